//! Set points from the spooler (4.4.117 to 4.4.119), sstvl (4.4.122), PcapIndex (4.4.94).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use motion_kernel::trace::Trace;
use motion_kernel::trajectory::{Lmp, PerAxis};

fn sine(n: usize, size: f64) -> Vec<f64> {
    (1..=n).map(|k| size * (1.0 - (k as f64 / n as f64 * std::f64::consts::TAU).cos())).collect()
}
fn pass(m: &mut Mcu, samples: u64) -> Trace {
    let mut trace = Trace::default();
    m.pass(samples, &mut trace);
    trace
}
fn lmp(targets: &[f64], vl: f64, tvl: f64) -> Lmp {
    let mut dtm: PerAxis = [0.0; 18];
    dtm[..targets.len()].copy_from_slice(targets);
    Lmp { ac: 500.0, vl, tvl, dtm }
}
fn start(m: &mut Mcu) {
    let all = m.all_axes();
    m.ssms(all);
}

// shows: pcap.spd, pcap.spd.multi-axis, pcap.spda, pcap.spda.multi-axis
#[test]
fn each_point_is_the_set_point_of_one_sample() {
    for indexed in [false, true] {
        let mut m = mcu("XY", EXACT);
        let (x, y) = (sine(200, 3.0), sine(200, -1.0));
        for (a, values) in [&x, &y].into_iter().enumerate() {
            let entered = if indexed { m.spda(a, values, 0) } else { m.spd(a, values) };
            assert_eq!(entered, Entered::Yes);
        }
        assert_eq!(dp(&pass(&mut m, 5), 0), [0.0; 5], "nothing moves before ssms");
        start(&mut m);
        let trace = pass(&mut m, 200);
        assert_eq!((dp(&trace, 0), dp(&trace, 1)), (x, y));
        assert!(!m.axst(0).has(Axst::pe), "pe is 0 up to the last point");
        let trace = pass(&mut m, 3);
        assert_eq!(dp(&trace, 0), [0.0; 3], "and stands after it");
        assert!(m.axst(0).has(Axst::pe));
        assert!(!m.axst(0).has(Axst::saf));
    }
}

// shows: pcap.spd.size, pcap.spda.size
#[test]
fn a_block_has_1_to_1000_points() {
    let mut m = mcu("X", EXACT);
    let refused = |entered: Entered, m: &mut Mcu| {
        assert_eq!(entered, Entered::Discarded);
        assert_eq!(m.errorreg(), ErrorReg::CheckMonitorScreen);
        assert_eq!(m.status().axes[0].mcis, 0);
        m.clear_errorreg();
    };
    for values in [&[][..], &vec![0.0; 1001], &[0.0, f64::NAN]] {
        let entered = m.spd(0, values);
        refused(entered, &mut m);
        let entered = m.spda(0, values, 1);
        refused(entered, &mut m);
    }
    let before = m.status().axes[0].lsm;
    assert_eq!(m.spd(0, &vec![0.0; 1000]), Entered::Yes);
    assert_eq!(m.spda(0, &[0.0], 1), Entered::Yes);
    assert_eq!(before - m.status().axes[0].lsm, 32 + 8000 + 32 + 8);
    assert_eq!(m.status().axes[0].mcis, 2);
    assert_eq!(m.spd(1, &[0.0]), Entered::Discarded);
    assert!(m.errorreg().has(ErrorReg::errAxDef));
}

#[test]
fn points_fill_the_spooler_and_free_it() {
    let mut m = mcu("X", EXACT);
    let memory = m.status().axes[0].lsm;
    let block = vec![0.5; 1000];
    let mut blocks = 0;
    while m.spd(0, &block) == Entered::Yes {
        blocks += 1;
    }
    assert_eq!(blocks, memory / 8032);
    assert_eq!(m.errorreg(), ErrorReg::errSpoolerOverrun);
    start(&mut m);
    m.run(1);
    assert_eq!(m.status().axes[0].lsm, memory % 8032 + 8032, "free as soon as the block is executed");
    m.sdels(set(&[0]));
    assert_eq!(m.status().axes[0].lsm, memory);
    assert_eq!(m.spd(0, &[7.0, 8.0]), Entered::Yes);
    let trace = pass(&mut m, 1001);
    assert_eq!(dp(&trace, 0)[998..], [0.5, 7.0, 8.0], "the block being executed is completed, then what came after");
}

// shows: pcap.spdr
#[test]
fn distances_count_from_where_the_block_begins() {
    let mut m = mcu("X", EXACT);
    assert_eq!(m.smla(&AxisList::new(&[0]), &lmp(&[10.0], 50.0, 0.0)), Entered::Yes);
    assert_eq!(m.spdr(0, &[0.01, 0.02, 0.01], 0), Entered::Yes);
    assert_eq!(m.spdr(0, &[0.01, 0.02], 0), Entered::Yes);
    assert_eq!(m.smlr(&AxisList::new(&[0]), &lmp(&[1.0], 50.0, 0.0)), Entered::Yes);
    let x = dp(&run(&mut m), 0);
    let first = x.iter().position(|p| *p == 10.01).expect("all refer to the begin of the block");
    let want = [10.01, 10.02, 10.01, 10.02, 10.03];
    x[first..first + 5].iter().zip(want).for_each(|(is, want)| close(*is, want, 1e-12));
    close(*x.last().expect("recorded"), 11.03, 1e-12);
}

// shows: pcap.spd.no-index, pcap.spda.index
#[test]
fn the_index_counts_on_with_each_point() {
    let mut m = mcu("X", EXACT);
    assert_eq!(m.spda(0, &[0.1, 0.2, 0.3], 100), Entered::Yes);
    assert_eq!(m.spd(0, &[0.4, 0.5]), Entered::Yes);
    assert_eq!(m.spdr(0, &[0.1], -5), Entered::Yes);
    assert_eq!(m.rdPcapIndex(0), 0);
    start(&mut m);
    let shown: Vec<i32> = (0..7).map(|_| (m.run(1), m.rdPcapIndex(0)).1).collect();
    assert_eq!(shown, [100, 101, 102, 102, 102, -5, -5], "spd passes no index");
}

// shows: pcap.smlai, pcap.smlri, pcap.ssfi, pcap.ssfni
#[test]
fn commands_show_their_index_while_they_are_executed() {
    let mut m = mcu("XY", EXACT);
    let list = xy();
    assert_eq!(m.smlai(&list, &lmp(&[1.0, 1.0], 50.0, 0.0), 11), Entered::Yes);
    assert_eq!(m.ssfi(0, 5, 99.0, 12), Entered::Yes);
    assert_eq!(m.ssfi(0, 1003, 2000.0, 13), Entered::Yes);
    assert_eq!(m.ssfi(1, 1003, 2000.0, 14), Entered::Yes);
    assert_eq!(m.smla(&list, &lmp(&[2.0, 2.0], 50.0, 0.0)), Entered::Yes);
    assert_eq!(m.smlri(&list, &lmp(&[1.0, 0.0], 50.0, 0.0), 15), Entered::Yes);
    assert_eq!(m.rdPcapIndex(0), 0, "not before they are executed");
    start(&mut m);
    let mut seen = [vec![], vec![]];
    for _ in 0..2000 {
        m.run(1);
        for (a, seen) in seen.iter_mut().enumerate() {
            let index = m.rdPcapIndex(a);
            if seen.last() != Some(&index) {
                seen.push(index);
            }
        }
    }
    assert_eq!(seen, [vec![11, 13, 15], vec![11, 14, 15]], "12 takes no time");
    assert_eq!(m.ci(5), 99);
    let x: Vec<f64> = (0..2).map(|a| m.rddp(a)).collect();
    assert_eq!(x, [3.0, 2.0]);
}

/// A line of 10 mm, then points that go on at 20 mm/s: speeds between samples.
fn into_points(modereg: ModeReg, change: impl Fn(&mut Mcu)) -> (Vec<f64>, usize) {
    let mut m = mcu("X", modereg);
    assert_eq!(m.smla(&AxisList::new(&[0]), &lmp(&[5.0], 20.0, 20.0)), Entered::Yes);
    assert_eq!(m.smla(&AxisList::new(&[0]), &lmp(&[10.0], 20.0, 20.0)), Entered::Yes);
    change(&mut m);
    let points: Vec<f64> = (1..=100).map(|k| 10.0 + 20.0 * TA * f64::from(k)).collect();
    assert_eq!(m.spd(0, &points), Entered::Yes);
    start(&mut m);
    let trace = pass(&mut m, 700);
    let passage = dp(&trace, 0).iter().position(|x| *x > 10.0).expect("takes the points over");
    (speeds(&trace, 0, 0.0), passage)
}

// shows: pcap.sstvl, pcap.sstvl.lookahead-end, pcap.spd.sstvl, pcap.spda.sstvl, modereg.lookahead
#[test]
fn sstvl_passes_into_points_without_a_stop() {
    let (v, passage) = into_points(LOOKAHEAD, |_| {});
    assert!(v[passage - 10..passage].iter().all(|v| *v < 7.0), "look-ahead brakes the contour to 0");
    let (v, passage) = into_points(LOOKAHEAD, |m| m.sstvl(set(&[0]), 20.0));
    assert!(v[passage - 200..passage + 90].iter().all(|v| *v > 20.0 - 1e-6), "no drop at {passage}");
    // without look-ahead the target velocity is the programmed one anyway
    let (v, passage) = into_points(EXACT, |_| {});
    assert!(v[passage - 200..passage + 90].iter().all(|v| *v > 20.0 - 1e-6));
}

// shows: pcap.sstvl.limited
#[test]
fn sstvl_is_reduced_to_what_limits_allow_and_can_be_reached() {
    let end_v = |modereg: ModeReg, length: f64, change: &dyn Fn(&mut Mcu), tvl: f64| {
        let mut m = mcu("X", modereg);
        change(&mut m);
        assert_eq!(m.smla(&AxisList::new(&[0]), &lmp(&[length], 30.0, 30.0)), Entered::Yes);
        m.sstvl(set(&[0]), tvl);
        start(&mut m);
        m.run(2000);
        m.status().axes[0].dv
    };
    close(end_v(LOOKAHEAD, 20.0, &|_| {}, 12.0), 12.0, 1e-9);
    close(end_v(LOOKAHEAD, 20.0, &|_| {}, 99.0), 30.0, 1e-9);
    close(end_v(LOOKAHEAD, 0.1, &|_| {}, 20.0), 10.0, 1e-9); // sqrt(2 * 500 * 0.1)
    let check = LOOKAHEAD | ModeReg::ChkMaxVel;
    close(end_v(check, 20.0, &|m| m.parameters_mut(0).maxvel = 8.0, 20.0), 8.0, 1e-9);
    close(end_v(check, 0.1, &|m| m.parameters_mut(0).maxacc = 125.0, 20.0), 5.0, 1e-9);
    // MdVel: after a reversal with at most 0.5 mm/s of change the rest is too short for more
    let after_corner = {
        let mut m = mcu("X", LOOKAHEAD);
        m.smla(&AxisList::new(&[0]), &lmp(&[20.0], 30.0, 30.0));
        m.smlr(&AxisList::new(&[0]), &lmp(&[-0.1], 30.0, 30.0));
        m.sstvl(set(&[0]), 20.0);
        start(&mut m);
        m.run(2000);
        m.status().axes[0].dv
    };
    close(after_corner, -(0.25f64.powi(2) + 100.0).sqrt(), 1e-9);
}

// shows: pcap.sstvl.direction
#[test]
fn sstvl_keeps_the_direction_of_the_last_command() {
    let mut m = mcu("XY", LOOKAHEAD);
    assert_eq!(m.smla(&xy(), &lmp(&[-6.0, 8.0], 10.0, 10.0)), Entered::Yes);
    m.sstvl(set(&[0, 1]), 10.0);
    start(&mut m);
    m.run(2000);
    let v: Vec<f64> = (0..2).map(|a| m.status().axes[a].dv).collect();
    [(v[0], -6.0), (v[1], 8.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-9));
}

#[test]
fn sstvl_reaches_a_move_that_runs_already() {
    let mut m = mcu("XY", LOOKAHEAD);
    assert_eq!(m.smla(&xy(), &lmp(&[6.0, 8.0], 10.0, 10.0)), Entered::Yes);
    start(&mut m);
    m.run(300);
    let before: Vec<f64> = (0..2).map(|a| m.rddp(a)).collect();
    m.sstvl(set(&[0, 1]), 10.0);
    m.run(1);
    close(m.rddp(0) - before[0], 6.0 * TA, 1e-9);
    m.run(1000);
    close(m.status().axes[1].dv, 8.0, 1e-9);
    assert!(!m.axst(0).has(Axst::saf));
    // 2001 takes it back, as long as the axis has not arrived
    let mut m = mcu("XY", LOOKAHEAD);
    m.smla(&xy(), &lmp(&[6.0, 8.0], 10.0, 10.0));
    m.sstvl(set(&[0, 1]), 10.0);
    m.ssf(0, 2001, 0.0, 0);
    m.ssf(1, 2001, 0.0, 0);
    start(&mut m);
    m.run(2000);
    assert_eq!([m.rddp(0), m.rddp(1)], [6.0, 8.0]);
}

#[test]
fn behind_sstvl_an_interpolation_joins_as_always() {
    let entry_speeds = |with: bool| {
        let mut m = mcu("X", LOOKAHEAD);
        m.smla(&AxisList::new(&[0]), &lmp(&[10.0], 20.0, 20.0));
        if with {
            m.sstvl(set(&[0]), 20.0);
        }
        m.smla(&AxisList::new(&[0]), &lmp(&[20.0], 20.0, 20.0));
        run(&mut m).v_plan
    };
    assert_eq!(entry_speeds(true), entry_speeds(false));
}

#[test]
fn a_move_behind_points_starts_with_their_velocity() {
    let mut m = mcu("XY", EXACT);
    for (a, share) in [(0, 0.6), (1, 0.8)] {
        let points: Vec<f64> = (1..=50).map(|k| share * 0.02 * f64::from(k)).collect();
        assert_eq!(m.spd(a, &points), Entered::Yes);
    }
    let v = 0.02 / TA;
    let lmp = Lmp { vl: v, ac: 1e3, ..lmp(&[6.0, 8.0], v, 0.0) };
    assert_eq!(m.smla(&xy(), &lmp), Entered::Yes);
    let trace = run(&mut m);
    speeds(&trace, 0, 0.0)[..200].iter().for_each(|x| close(*x, 0.6 * v, 1e-6));
    assert_eq!([m.rddp(0), m.rddp(1)], [6.0, 8.0]);
}

#[test]
fn stops_break_points_off() {
    for stop in 0..3 {
        let mut m = mcu("X", EXACT);
        let points: Vec<f64> = (1..=900).map(|k| 0.02 * f64::from(k)).collect();
        assert_eq!(m.spd(0, &points), Entered::Yes);
        assert_eq!(m.spd(0, &points), Entered::Yes);
        start(&mut m);
        m.run(100);
        match stop {
            0 => m.ms(set(&[0])),
            1 => m.js(set(&[0])),
            _ => m.hold(),
        }
        m.run(500);
        let v = 0.02 / TA;
        close(m.rddp(0), 2.0 + v * v / (2.0 * 2000.0), 1e-9); // sdec 2000
        let status = m.status();
        assert_eq!((status.axes[0].mcis, status.axes[0].lsm), (0, status.axes[0].memory));
        m.resume();
        assert_eq!(m.spd(0, &[9.0]), Entered::Yes);
        start(&mut m);
        m.run(2);
        assert_eq!(m.rddp(0), 9.0, "none of the old points is left");
    }
}

#[test]
fn a_hold_at_a_block_end_lets_a_block_of_points_end_and_steps_through_the_next() {
    let mut m = mcu("X", EXACT);
    let points: Vec<f64> = (1..=100).map(|k| 0.01 * f64::from(k)).collect();
    assert_eq!(m.spd(0, &points), Entered::Yes);
    assert_eq!(m.spd(0, &[1.01]), Entered::Yes);
    start(&mut m);
    m.run(20);
    m.hold_at_block_end();
    m.run(200);
    assert_eq!((m.rddp(0), m.is_holding()), (1.0, true));
    assert!(m.step_block());
    m.run(10);
    assert_eq!(m.rddp(0), 1.01);
    assert!(!m.step_block(), "nothing is left");
}

#[test]
fn points_need_a_closed_loop() {
    let mut m = Mcu::new(std::sync::Arc::new(machine("X")));
    assert_eq!(m.spd(0, &[1.0]), Entered::Refused);
    assert!(m.axst(0).has(Axst::dhef));
}
