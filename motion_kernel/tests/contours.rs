//! Properties of whole contours: the path is the programmed one at any override and through any hold.

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

    // shows: kernel.override.during-profile, kernel.override.trajectory-synchronous, spool.override-synchronous
    // shows: pcap.wrtrovr.during-path, pcap.utrovr
    #[test]
    fn set_points_lie_on_the_path_at_any_override(
        blocks in contour(25),
        mode in 0..MODES.len(),
        schedule in prop::collection::vec((1u64..300, 0.05..1.5f64, 0.0..0.4f64), 1..8),
    ) {
        let (mut m, placed) = start(&blocks, MODES[mode]);
        let all = m.all_axes();
        for &(samples, factor, seconds) in schedule.iter().cycle().take(2000) {
            m.wrtrovrst(seconds);
            m.wrtrovr(factor);
            m.utrovr(all);
            let mut trace = Trace::default();
            let advanced = m.advance(samples, &mut trace);
            check_on_path(&trace, &placed);
            if advanced.stop == Stop::Finished {
                ends(&m, &placed);
                return Ok(());
            }
        }
        let trace = record(&mut m);
        check_on_path(&trace, &placed);
        ends(&m, &placed);
    }

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

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    /// Limits are kept at any constant factor up to 1 (design D18): no axis is faster than maxvel; its speed changes
    /// by no more than mdvel at a junction, and in between by no more than its ramp and its share of the curvature.
    #[test]
    fn limits_are_kept(blocks in contour(25), factor in prop_oneof![Just(1.0), 0.2..1.0f64]) {
        let (mut m, placed) = start(&blocks, LOOKAHEAD | ModeReg::ChkMaxVel);
        for a in 0..3 {
            m.parameters_mut(a).maxvel = 200.0;
        }
        m.wrtrovr(factor);
        m.utrovr(set(&[0, 1, 2]));
        let trace = record(&mut m);
        let ramp: f64 = placed.iter().map(|b| b.block.ac).fold(0.0, f64::max);
        for axis in 0..3 {
            let v = speeds(&trace, axis, 0.0);
            prop_assert!(v.iter().all(|v| v.abs() <= 200.0 * factor + 1e-6));
            for k in 1..v.len() {
                let junctions = f64::from(trace.entry[k].abs_diff(trace.entry[k.saturating_sub(2)])).min(5.0);
                let junctions = if trace.entry[k] == 0 { 5.0 } else { junctions };
                // curvature: v²/r <= maxacc 1000 by the limit of arcs
                let allowed = (ramp + 1000.0) * factor * factor * TA + junctions * 0.5 * factor + 1e-6;
                prop_assert!((v[k] - v[k - 1]).abs() <= allowed, "axis {axis}, sample {k}: {} to {}", v[k - 1], v[k]);
            }
        }
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
