//! Properties of whole contours: the path is the programmed one through any hold.

mod common;

use common::contour::*;
use common::*;
use motion_kernel::registers::{Axst, ModeReg};
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};
use proptest::prelude::*;

const MODES: [ModeReg; 4] = [LOOKAHEAD, EXACT, ModeReg(LOOKAHEAD.0 | 1 << 1), ModeReg(LOOKAHEAD.0 | 1 << 7)];

fn start(blocks: &[Block], mode: ModeReg) -> (Mcu, Vec<Placed>) {
    let mut m = mcu("XYZ", mode);
    let placed = place(blocks);
    for n in 0..placed.len() {
        assert!(enter(&mut m, &placed, n));
    }
    let all = m.all_axes();
    m.ssms(all);
    (m, placed)
}

/// Everything is done: the axes stand at the end of the contour.
fn ends(m: &Mcu, placed: &[Placed]) {
    let end = placed.last().expect("not empty").end;
    for (axis, end) in m.status().axes.iter().zip(end) {
        close(axis.dp, end, 1e-9);
        assert!(axis.axst.has(Axst::pe) && !axis.axst.has(Axst::saf));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    // shows: pcap.ms.direction-kept, pcap.ms.on-circle
    #[test]
    fn a_resumed_path_is_the_same_path(
        blocks in contour(25),
        mode in 0..MODES.len(),
        holds in prop::collection::vec(1u64..200, 1..12),
        factor in 0.2..1.3f64,
    ) {
        let (mut m, placed) = start(&blocks, MODES[mode]);
        let all = m.all_axes();
        m.wrtrovr(factor);
        m.utrovr(all);
        for &samples in &holds {
            let mut trace = Trace::default();
            if m.advance(samples, &mut trace).stop == Stop::Finished {
                check_on_path(&trace, &placed);
                return Ok(());
            }
            check_on_path(&trace, &placed);
            let before = m.status();
            m.hold();
            let advanced = m.advance(20_000, &mut trace);
            prop_assert_eq!(advanced.stop, Stop::Held);
            check_braking(&trace, &placed, before.path_v, factor);
            m.advance(7, &mut trace);
            prop_assert!(trace.v_plan.iter().all(|v| *v == 0.0), "held");
            m.resume();
        }
        let trace = record(&mut m);
        check_on_path(&trace, &placed);
        ends(&m, &placed);
    }
}

/// While braking for a hold every sample lies on a block, and the speed never rises.
fn check_braking(trace: &Trace, placed: &[Placed], start_v: f64, factor: f64) {
    let mut last_v = start_v / factor;
    for k in 0..trace.len() {
        let p: Point = std::array::from_fn(|i| trace.dp[k * 3 + i]);
        let near = placed.iter().map(|b| off(&p, b).0).fold(f64::INFINITY, f64::min);
        assert!(near <= 1e-9, "held {near:e} off");
        let v = trace.v_plan[k];
        assert!(v <= last_v + 1e-9, "faster while braking: {v} after {last_v}");
        last_v = v;
    }
}
