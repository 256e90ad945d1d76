//! Lines, circles and helices as programmed (2.3, 4.4.28 to 4.4.38), rotary axes, several groups at once.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::autocode::MoveKind::{Smca, Smcr, Smha, Smhr, Smla, Smlr};
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::functions::Entered;
use motion_kernel::motion::MotionCommand;
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use motion_kernel::trace::Trace;

const V: [f64; 3] = [20.0, 200.0, 0.0];

/// Rows of the trace as points.
fn points(trace: &Trace) -> Vec<Vec<f64>> {
    trace.dp.chunks(trace.axes).map(<[f64]>::to_vec).collect()
}
fn end(trace: &Trace) -> Vec<f64> {
    trace.dp[trace.dp.len() - trace.axes..].to_vec()
}
#[track_caller]
fn at(point: &[f64], want: &[f64]) {
    assert_eq!(point.len(), want.len());
    for (a, b) in point.iter().zip(want) {
        close(*a, *b, 1e-12);
    }
}

// shows: interp.linear.straight, interp.linear.parameters, interp.sample-synchronous, pcap.smla, pcap.smla.abs-target
// shows: kernel.target.absolute, kernel.target.reference, pcap.general.absolute
#[test]
fn a_line_in_five_axes_is_straight_and_absolute() {
    let mut m = mcu("XYZUV", EXACT);
    line(&mut m, &[1.0; 5], 20.0, 200.0, 0.0);
    let target = [10.0, -5.0, 3.0, 0.5, 7.0];
    line(&mut m, &target, 20.0, 200.0, 0.0);
    let trace = run(&mut m);
    let first = trace.entry.iter().position(|e| *e == 2).expect("second line");
    for p in &points(&trace)[first..] {
        let share = (p[0] - 1.0) / 9.0;
        for (x, target) in p.iter().zip(target) {
            close(*x, 1.0 + share * (target - 1.0), 1e-12);
        }
    }
    assert_eq!(end(&trace), target);
}

// shows: pcap.smlr, kernel.target.relative, pcap.general.relative, interp.linear.absolute-or-relative
#[test]
fn relative_lines_start_at_the_end_of_the_one_before() {
    let mut m = mcu("XY", EXACT);
    for _ in 0..3 {
        spool(&mut m, Smlr, &xy(), &[1.0, -2.0], [0.0; 2], 0.0, V);
    }
    at(&end(&run(&mut m)), &[3.0, -6.0]);
}

// shows: pcap.smca, interp.circle.two-axes, interp.circle.parameters, interp.kinds
#[test]
fn a_circle_keeps_its_radius_and_turns_counter_clockwise() {
    for (phi, target) in [(90.0, [5.0, -5.0]), (-90.0, [5.0, 5.0]), (450.0, [5.0, -5.0])] {
        let mut m = mcu("XY", EXACT);
        spool(&mut m, Smca, &xy(), &[0.0; 2], [5.0, 0.0], phi, V);
        let trace = run(&mut m);
        for p in points(&trace) {
            close((p[0] - 5.0).hypot(p[1]), 5.0, 1e-12);
        }
        at(&end(&trace), &target);
        let duration = 5.0 * f64::abs(phi).to_radians() / 20.0 + 0.1;
        assert_eq!(trace.len(), (duration / TA).ceil() as usize);
    }
}

// shows: pcap.smcr, interp.circle.center-abs-rel
#[test]
fn a_relative_centre_counts_from_the_start() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[10.0, 10.0], 20.0, 200.0, 0.0);
    spool(&mut m, Smcr, &xy(), &[0.0; 2], [5.0, 0.0], 180.0, V);
    at(&end(&run(&mut m)), &[20.0, 10.0]);
    spool(&mut m, Smca, &xy(), &[0.0; 2], [5.0, 10.0], 180.0, V);
    at(&end(&run(&mut m)), &[-10.0, 10.0]);
}

/// Any two axes in any order: the first named one is the x axis of the circle.
#[test]
fn the_order_of_the_axes_is_that_of_the_command() {
    let mut m = mcu("XYZ", EXACT);
    let zx = AxisList::new(&[2, 0]);
    spool(&mut m, Smca, &zx, &[0.0; 2], [5.0, 0.0], 90.0, V);
    at(&end(&run(&mut m)), &[-5.0, 0.0, 5.0]);
}

// shows: pcap.smha, interp.helix
#[test]
fn a_helix_takes_any_further_axes_along_linearly() {
    let mut m = mcu("XYZU", EXACT);
    arc(&mut m, [5.0, 0.0], 720.0, &[12.0, -3.0], 20.0, 200.0, 0.0);
    let trace = run(&mut m);
    let length = (5.0 * std::f64::consts::TAU * 2.0f64).hypot(12.0f64.hypot(3.0));
    // the path length and the feed include the linear axes (design D15)
    assert_eq!(trace.len(), ((length / 20.0 + 0.1) / TA).ceil() as usize);
    for p in points(&trace) {
        let angle = (p[2] / 12.0 * 720.0).to_radians();
        at(&p[..2], &[5.0 - 5.0 * angle.cos(), -5.0 * angle.sin()]);
        close(p[3], -p[2] / 4.0, 1e-12);
    }
    at(&end(&trace), &[0.0, 0.0, 12.0, -3.0]);
}

// shows: pcap.smhr
#[test]
fn a_relative_helix_counts_everything_from_the_start() {
    let mut m = mcu("XYZ", EXACT);
    line(&mut m, &[1.0, 2.0, 3.0], 20.0, 200.0, 0.0);
    let xyz = AxisList::new(&[0, 1, 2]);
    spool(&mut m, Smhr, &xyz, &[0.0, 0.0, 2.0], [5.0, 0.0], 180.0, V);
    at(&end(&run(&mut m)), &[11.0, 2.0, 5.0]);
}

// shows: pcap.mha.target-mode, pcap.mha.target-mode-sign, pcap.mha.target-mode-full-circle, pcap.mha.target-corrected
// shows: pcap.mhr.target-mode
#[test]
fn phi_0_of_a_helix_means_to_the_target_point() {
    for direct in [false, true] {
        let go = |m: &mut Mcu, kind, target: [f64; 2], phi: f64| {
            let [vl, ac, tvl] = V;
            let axes = xy();
            let center = [5.0, 0.0];
            let command =
                MotionCommand { kind, axes: &axes, targets: &target, center, phi, vl, ac, tvl, rapid: false, line: 1 };
            let entered = if direct { m.direct(&command) } else { m.spool(&command) };
            assert_eq!(entered, Entered::Yes);
            run(m)
        };
        let to = |target: [f64; 2], phi: f64| {
            let mut m = mcu("XY", EXACT);
            let trace = go(&mut m, Smha, target, phi);
            (trace.len(), end(&trace), points(&trace)[20][1])
        };
        // counter-clockwise from (0, 0) around (5, 0) begins downwards
        let (quarter, p, y) = to([5.0, -5.0], 0.0);
        at(&p, &[5.0, -5.0]);
        assert!(y < 0.0);
        let (three_quarters, p, y) = to([5.0, -5.0], -1e-120);
        at(&p, &[5.0, -5.0]);
        assert!(y > 0.0 && three_quarters > 2 * quarter);
        // the target is the start: a full circle; off the circle: corrected onto it
        let (full, p, _) = to([0.0, 0.0], 0.0);
        at(&p, &[0.0, 0.0]);
        assert!(full > three_quarters);
        at(&to([5.0, -9.0], 0.0).1, &[5.0, -5.0]);
        // relative form: target and centre from the start
        let mut m = mcu("XY", EXACT);
        line(&mut m, &[1.0, 1.0], 20.0, 200.0, 0.0);
        run(&mut m);
        at(&end(&go(&mut m, Smhr, [5.0, -5.0], 0.0)), &[6.0, -4.0]);
    }
}

// shows: interp.circle.direction-mismatch
#[test]
fn into_a_circle_the_velocity_is_turned_at_once() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[10.0, 0.0], 20.0, 200.0, 20.0);
    spool(&mut m, Smca, &xy(), &[0.0; 2], [15.0, 0.0], 90.0, V);
    let trace = run(&mut m);
    let second = trace.entry.iter().position(|e| *e == 2).expect("the circle") + 1;
    close(speeds(&trace, 0, 0.0)[second], 0.0, 0.5);
    close(speeds(&trace, 1, 0.0)[second], -20.0, 0.1);
}

// shows: interp.circle.reversal-by-negative-tvl
#[test]
fn a_circle_reverses_by_a_negative_target_velocity() {
    let mut m = mcu("XY", EXACT);
    spool(&mut m, Smca, &xy(), &[0.0; 2], [5.0, 0.0], 180.0, [20.0, 200.0, -20.0]);
    spool(&mut m, Smca, &xy(), &[0.0; 2], [5.0, 0.0], -180.0, V);
    let trace = run(&mut m);
    for p in points(&trace) {
        close((p[0] - 5.0).hypot(p[1]), 5.0, 1e-12);
    }
    let v: Vec<f64> = trace.v_plan.clone();
    let jump = |w: &[f64]| (w[1] - w[0]).abs();
    let crossing = trace.entry.iter().position(|e| *e == 2).expect("second circle");
    assert!(v.windows(2).enumerate().all(|(k, w)| k + 1 == crossing || jump(w) <= 200.0 * TA + 1e-9));
    assert!(points(&trace).iter().any(|p| p[1] > 0.5), "it overshoots");
    at(&end(&trace), &[0.0, 0.0]);
}

// shows: interp.concurrent, interp.parallel.independent, spool.per-axis, spool.interpolation-synchronous
#[test]
fn two_circles_run_at_the_same_time() {
    let mut m = mcu("XYZU", EXACT);
    let zu = AxisList::new(&[2, 3]);
    spool(&mut m, Smca, &xy(), &[0.0; 2], [5.0, 0.0], 360.0, V);
    spool(&mut m, Smca, &zu, &[0.0; 2], [0.0, 2.0], -720.0, [35.0, 500.0, 0.0]);
    let trace = run(&mut m);
    for p in points(&trace) {
        close((p[0] - 5.0).hypot(p[1]), 5.0, 1e-12);
        close(p[2].hypot(p[3] - 2.0), 2.0, 1e-12);
    }
    at(&end(&trace), &[0.0; 4]);
    assert!((0..4).all(|a| !m.axst(a).has(Axst::saf)));
}

// shows: spool.queue
#[test]
fn entries_are_not_executed_when_entered() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[10.0, 0.0], 20.0, 200.0, 0.0);
    spool(&mut m, Smla, &xy(), &[10.0, 10.0], [0.0; 2], 0.0, V);
    m.ssf(0, 7, 1.0, 0);
    m.run(1000);
    assert_eq!((m.status().axes[0].dp, m.ci(7)), (0.0, 0));
}

/// A rotary axis counts with radius times angle (design D7); RotatoricUnit decides the unit of targets.
#[test]
fn rotary_targets_are_degrees_or_circumference() {
    let turned = |mode: ModeReg, target: f64| {
        let mut machine = machine("XC");
        machine.axes[1].effradius = 100.0;
        let mut m = mcu_of(machine, mode);
        line(&mut m, &[0.0, target], 20.0, 200.0, 0.0);
        let trace = run(&mut m);
        (end(&trace)[1], trace.len())
    };
    let arc_mm = 100.0 * 60.0f64.to_radians();
    let (degrees, samples) = turned(EXACT, 60.0);
    close(degrees, 60.0, 1e-12);
    assert_eq!(samples, ((arc_mm / 20.0 + 0.1) / TA).ceil() as usize, "the feed is that of the circumference");
    let (degrees, samples_mm) = turned(ModeReg::ExactTargetPos, arc_mm);
    close(degrees, 60.0, 1e-12);
    assert_eq!(samples, samples_mm);
}

/// Alone they do count.
// shows: pcap.wrnfrax.effect
#[test]
fn nfrax_axes_do_not_count_for_the_feed() {
    let samples = |nfrax: AxisSet, target: [f64; 2]| {
        let mut m = mcu("XY", EXACT);
        m.registers_mut().nfrax = nfrax;
        line(&mut m, &target, 20.0, 200.0, 0.0);
        let trace = run(&mut m);
        at(&end(&trace), &target);
        trace.len()
    };
    let line_of = |length: f64| ((length / 20.0 + 0.1) / TA).ceil() as usize;
    assert_eq!(samples(AxisSet::EMPTY, [33.0, 44.0]), line_of(55.0));
    assert_eq!(samples(set(&[1]), [33.0, 44.0]), line_of(33.0));
    assert_eq!(samples(set(&[1]), [0.0, 44.0]), line_of(44.0));
}

// shows: jerkrel.s-profile-only, jerkrel.source
#[test]
fn s_profiles_need_the_bit_and_use_the_smallest_jerkrel_of_the_group() {
    let run_with = |mode: ModeReg, jerkrel: [f64; 2]| {
        let mut m = mcu("XY", mode);
        m.parameters_mut(0).jerkrel = jerkrel[0];
        m.parameters_mut(1).jerkrel = jerkrel[1];
        line(&mut m, &[30.0, 0.0], 20.0, 100.0, 0.0);
        let v = run(&mut m).v_plan;
        (v.len(), v.windows(2).map(|w| (w[1] - w[0]) / TA).fold(0.0, f64::max))
    };
    let s_profile = EXACT | ModeReg::SProfile;
    let (samples, plain) = run_with(EXACT, [1.0, 1.0]);
    close(plain, 100.0, 1e-6);
    for (jerkrel, peak) in [([1.0, 1.0], 200.0), ([1.0, 0.2], 120.0), ([0.0, 1.0], 100.0)] {
        let (same, a) = run_with(s_profile, jerkrel);
        assert_eq!(same, samples, "time and length stay");
        close(a, peak, 0.02 * peak);
    }
}

/// Nonsense from an application: never a panic, never motion.
#[test]
fn numbers_that_are_none_are_refused() {
    let mut m = mcu("XY", EXACT);
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(line(&mut m, &[bad, 0.0], 20.0, 200.0, 0.0), Entered::Discarded);
        assert_eq!(arc(&mut m, [5.0, 0.0], bad, &[], 20.0, 200.0, 0.0), Entered::Discarded);
        assert_eq!(line(&mut m, &[1.0, 0.0], 20.0, 200.0, bad), Entered::Discarded);
    }
    assert!(m.errorreg().0 != 0 && run(&mut m).is_empty());
    assert!(!m.errorreg().has(ErrorReg::errSpoolerOverrun));
}
