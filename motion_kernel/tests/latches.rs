//! Latched positions (4.4.25 to 4.4.27, 4.4.82, 4.4.83, 4.4.158, 4.4.159).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::analysis::LatchInfos;
use motion_kernel::machine::{Encoder, Machine};
use motion_kernel::registers::{Axst, Digi, ModeReg};
use motion_kernel::stimulus::Stimulus;

const LP: u32 = 1 << 5;
const STROBE_1: u32 = 1 << 13;

/// mill3 with an LP input for X at input 6, on its way to X+100 at 50 mm/s.
fn travelling(rules: &str) -> Mcu {
    let text = format!("{}\n[[input]]\nnumber = 6\naxis = \"X\"\nfunction = \"LP\"\n", motion_kernel::machine::BUILTIN);
    let mut mcu = mcu_of(Machine::parse(text.as_bytes()).expect("valid"), ModeReg(0));
    mcu.add_stimulus(&Stimulus::parse(rules, &["X", "Y", "Z"]).expect("valid"));
    line(&mut mcu, &[100.0, 50.0, -20.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(200);
    mcu
}

// shows: pcap.lps, pcap.lps.flag, pcap.lps.read, pcap.lps.read-clears, pcap.lps.typical, axst.lpsf, axst.lpsf.reset
// shows: pcap.rdlp, pcap.rdlp.lps
#[test]
fn lps_latches_every_mst_samples() {
    for mst in [1, 10, 100] {
        let mut mcu = travelling("");
        mcu.lps(0, mst);
        for n in 1..=3 * u64::from(mst) {
            mcu.run(1);
            let latched = n % u64::from(mst) == 0;
            assert_eq!(mcu.axst(0).has(Axst::lpsf), latched, "sample {n} of {mst}");
            if latched {
                let rp = mcu.rdrp(0);
                assert_eq!(mcu.rdlp(0), rp);
                assert!(!mcu.axst(0).has(Axst::lpsf) && !mcu.axst(1).has(Axst::lpsf));
            }
        }
        mcu.lps(0, 0);
        mcu.run(200);
        assert!(!mcu.axst(0).has(Axst::lpsf), "0 ends it");
    }
}

// shows: pcap.rdlp.lp-input, pcap.rdlp.lp-input-rearm, axst.lpsf.input, pcap.rdlp.source
#[test]
fn an_lp_input_latches_once_until_it_is_inactive() {
    let mut mcu = travelling("");
    let at = mcu.rdrp(0);
    mcu.set_inputs(LP);
    mcu.run(2);
    assert!(mcu.axst(0).has(Axst::lpsf));
    let latched = mcu.rdlp(0);
    assert!((at..=at + 2.0 * 50.0 * TA).contains(&latched), "within two samples");
    mcu.run(50);
    assert_eq!((mcu.rdlp(0), mcu.axst(0).has(Axst::lpsf)), (latched, false), "still active: no new latch");
    mcu.set_inputs(0);
    mcu.run(1);
    mcu.set_inputs(LP);
    mcu.run(2);
    assert!(mcu.axst(0).has(Axst::lpsf) && mcu.rdlp(0) > latched);
}

// shows: pcap.rdlp.realtime, digi.bit19, pcap.rddigib.20, pcap.rdlp.realtime-rearm
#[test]
fn a_strobe_latches_inside_the_sample() {
    for place in [20.0, 20.013, 20.0371] {
        let mut mcu = travelling(&format!("when X > {place}: input 14 on\nwhen X > 30: input 14 off"));
        assert_eq!(mcu.rddigib(0, 20), 0);
        mcu.run(800);
        let latched = mcu.rdlp(0);
        assert!((latched - place).abs() < 1e-3, "{latched} is not {place}: a sample is 57 um");
        assert!(mcu.rddigi(0) & Digi::strobe.0 != 0 && mcu.rddigib(0, 20) == 1);
        mcu.set_inputs(STROBE_1);
        mcu.run(1);
        assert!(mcu.rdlp(0) > latched, "inactive and active again: a new latch");
        let latched = mcu.rdlp(0);
        mcu.set_inputs(STROBE_1 | 1);
        mcu.run(10);
        assert_eq!(mcu.rdlp(0), latched);
    }
}

// shows: digi.bit13.strobe, digi.bit14.strobe, digi.bit15.strobe, digi.bit13, digi.bit14, digi.bit15
#[test]
fn inputs_14_to_16_are_the_strobes_of_the_first_three_axes() {
    for a in 0..3 {
        let mut mcu = travelling("");
        mcu.set_inputs(STROBE_1 << a);
        assert_eq!(mcu.rddigi(a) >> 13 & 7, 1 << a);
        for b in 0..3 {
            let latched = if b == a { mcu.rdrp(b) } else { 0.0 };
            assert_eq!(mcu.rdlp(b), latched, "axis {b} at strobe {a}");
            assert_eq!(mcu.rddigi(b) & Digi::strobe.0 != 0, a == b);
        }
    }
}

// shows: pcap.rdlp.priority
#[test]
fn of_one_sample_the_strobe_counts_before_lps_before_the_input() {
    // all in the sample in which X passes 20; lps is due in every sample
    let latched = |rules: &str, lps: bool| {
        let mut mcu = travelling(rules);
        if lps {
            mcu.lps(0, 1);
        }
        let mut before = mcu.rdrp(0);
        while mcu.rdrp(0) <= 20.0 {
            before = mcu.rdrp(0);
            mcu.run(1);
        }
        (mcu.rdlp(0), before, mcu.rdrp(0))
    };
    let strobe = "when X > 20: input 14 on\n";
    let input = "when X > 20: input 6 on\n";
    let (lp, before, after) = latched(&format!("{strobe}{input}"), true);
    assert!(lp > before && lp < after, "the strobe lies inside the sample: {lp} in {before} .. {after}");
    let (lp, _, after) = latched(input, true);
    assert_eq!(lp, after);
    let (lp, before, after) = latched(&format!("{input}{strobe}"), false);
    assert!(lp > before && lp < after, "whatever comes first");
}

// shows: pcap.wrlp
#[test]
fn latched_positions_can_be_written() {
    let mut mcu = travelling("");
    assert!(mcu.wrlp(0, 12.5) && !mcu.wrlp(0, f64::NAN));
    assert_eq!((mcu.rdlp(0), mcu.rdlp(1)), (12.5, 0.0));
}

// shows: pcap.rdlp.aux
#[test]
fn with_encoder_feedback_the_auxiliary_channel_is_latched() {
    let mut machine = machine("X");
    machine.axes[0].equipment.encoder = Some(Encoder { counts_per_unit: 4_000.0, feedback: true });
    let mut mcu = mcu_of(machine, ModeReg(0));
    mcu.wrgfaux(0, 2.5); // 10000 steps, 4000 counts
    line(&mut mcu, &[10.0], 20.0, 500.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(200);
    mcu.block(0, true);
    mcu.run(50);
    mcu.set_inputs(STROBE_1);
    let from_encoder = (mcu.encoder_counts(0) as f64 * 2.5).round() / 10_000.0;
    close(mcu.rdlp(0), from_encoder, 1e-9);
    assert!(mcu.rddp(0) - mcu.rdlp(0) > 0.5, "the steps went on, the encoder did not");
}

// shows: pcap.lpr, pcap.lprs, pcap.lprs.san-ignored
#[test]
fn the_system_analysis_records_a_thousand_values() {
    let mut mcu = travelling("");
    let infos = LatchInfos { san: 1, lst: 0.0, let_: 100.0 * TA }; // becomes 1000 samples
    assert!(mcu.lpr(&infos));
    let mut rp = Vec::new();
    for _ in 0..1000 {
        assert!(mcu.analysis().is_running());
        mcu.run(1);
        rp.push(mcu.rdrp(1));
    }
    mcu.run(100);
    assert!(!mcu.analysis().is_running());
    assert_eq!(mcu.analysis().column(1, "rp"), Some(rp), "every sample of its axis");
    assert_eq!(mcu.analysis().column(0, "rp"), None);

    assert!(mcu.lprs(set(&[0, 2]), &LatchInfos { san: 17, lst: 10.0 * TA, let_: 2500.0 * TA }));
    let first = mcu.samples() + 10;
    let (mut x, mut z) = (Vec::new(), Vec::new());
    for _ in 0..3000 {
        mcu.run(1);
        let sample = mcu.samples() - 1;
        if sample >= first && (sample - first).is_multiple_of(3) && x.len() < 1000 {
            x.push(mcu.rddp(0));
            z.push(f64::from(mcu.rdmcp(2)));
        }
    }
    assert_eq!((mcu.analysis().first_sample, mcu.analysis().every), (first, 3), "1000 values");
    assert_eq!((mcu.analysis().column(0, "dp"), mcu.analysis().column(2, "mcp")), (Some(x), Some(z)));
    assert_eq!(mcu.analysis().axes(), set(&[0, 2]), "san has no meaning");
    for bad in [f64::NAN, -1.0] {
        assert!(!mcu.lprs(set(&[0]), &LatchInfos { let_: bad, ..infos }));
    }
    assert!(!mcu.lpr(&LatchInfos { san: 3, ..infos }));
}
