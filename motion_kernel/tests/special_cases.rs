//! The special cases of MOVE profiles (2.2.2), in the profile itself and in spooled motion.

mod common;

use common::*;
use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::profile::{Profile, Request};
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use proptest::prelude::*;

fn request(length: f64, start_v: f64, max_v: f64, acc: f64, target_v: f64) -> Request {
    Request { from: 0.0, to: length, start_v, max_v, acc, target_v, jerkrel: 0.0 }
}

/// The ramps join without gaps, never exceed the maximum, and end at the target: independent of the planning.
fn check(profile: &Profile, r: &Request) {
    let (mut s, mut t, mut v) = (r.from, 0.0, profile.start_v());
    for ramp in profile.ramps() {
        close(ramp.s0, s, 1e-9 * (1.0 + s.abs()));
        close(ramp.v0, v, 1e-9 * (1.0 + v.abs()));
        close(ramp.begin_t, t, 1e-12 * (1.0 + t));
        assert!(ramp.v0.abs() <= r.max_v + 1e-9 && ramp.a.abs() <= r.acc + 1e-9);
        (s, v, t) = (ramp.end_s(), ramp.end_v(), t + ramp.duration_t);
    }
    close(s, r.to, 1e-9 * (1.0 + r.to));
    close(profile.end_t, t, 1e-12 * (1.0 + t));
    if profile.end_v <= r.max_v && profile.end_v >= -r.max_v {
        close(v, profile.end_v, 1e-7 * (1.0 + v.abs()));
    }
}

proptest! {
    // shows: kernel.profile.move.positive-max-and-accel, kernel.tvl.sign-allowed
    #[test]
    fn every_profile_reaches_its_target(
        length in 1e-3..100.0f64, start_v in 0.0..60.0f64, max_v in 1.0..50.0f64, acc in 10.0..2000.0f64,
        target_v in -60.0..60.0f64, jerkrel in prop_oneof![Just(0.0), 0.0..1.0f64, Just(1.0)],
    ) {
        let r = Request { jerkrel, ..request(length, start_v, max_v, acc, target_v) };
        let profile = Profile::spooled(&r);
        check(&profile, &r);
        let feasible = start_v <= max_v && target_v.abs() <= max_v && (start_v * start_v - target_v * target_v).abs() <= 2.0 * acc * length;
        if feasible {
            prop_assert!((profile.start_v() - start_v).abs() <= 1e-9, "no jump at the start");
            prop_assert!((profile.end_v - target_v).abs() <= 1e-9, "no jump at the end");
        }
    }

    // shows: jerkrel.mean-accel, jerkrel.amax, jerkrel.zero, jerkrel.one, jerkrel.between
    #[test]
    fn s_ramps_keep_time_and_length(v0 in 0.0..50.0f64, v1 in 0.0..50.0f64, acc in 10.0..1000.0f64, jerkrel in 0.0..1.0f64) {
        prop_assume!((v1 - v0).abs() > 0.1);
        let length = (v1 * v1 - v0 * v0).abs() / (2.0 * acc);
        let shaped = Profile::spooled(&Request { jerkrel, ..request(length, v0, v0.max(v1), acc, v1) });
        let plain = Profile::spooled(&request(length, v0, v0.max(v1), acc, v1));
        prop_assert!((shaped.end_t - plain.end_t).abs() < 1e-12);
        let ramp = shaped.ramps()[0];
        // numerical integration of the acceleration, and its peak
        let n = 200_000;
        let dt = ramp.duration_t / f64::from(n);
        let (mut v, mut s, mut peak) = (v0, 0.0, 0.0f64);
        for k in 0..n {
            let a = ramp.acceleration((f64::from(k) + 0.5) * dt);
            s += v * dt + 0.5 * a * dt * dt;
            v += a * dt;
            peak = peak.max(a.abs());
            if k % 10_000 == 9_999 {
                let (s_at, v_at) = ramp.at(f64::from(k + 1) * dt);
                prop_assert!((s_at - s).abs() < 1e-6 * (1.0 + s) && (v_at - v).abs() < 1e-6 * (1.0 + v));
            }
        }
        prop_assert!((s - length).abs() < 1e-6 * (1.0 + length) && (v - v1).abs() < 1e-6 * (1.0 + v1));
        prop_assert!((peak - acc * (1.0 + jerkrel)).abs() < 1e-3 * acc);
    }
}

// shows: kernel.profile.move.start-equals-max
#[test]
fn a_move_may_start_at_its_maximum() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[10.0], 20.0, 100.0, 20.0);
    line(&mut m, &[20.0], 20.0, 100.0, 0.0);
    let trace = run(&mut m);
    let second = trace.entry.iter().position(|e| *e == 2).expect("second block");
    // 10 mm at 20 mm/s, the last 2 of them braking
    let cruising = (8.0 / 20.0 / TA) as usize - 1;
    assert!(trace.v_plan[second..second + cruising].iter().all(|v| *v == 20.0), "no ramp");
}

// shows: kernel.profile.move.end-equals-max
#[test]
fn a_move_may_end_at_its_maximum() {
    let profile = Profile::spooled(&request(10.0, 20.0, 20.0, 100.0, 20.0));
    assert_eq!(profile.ramps().len(), 1);
    close(profile.end_t, 0.5, 1e-12);
    let profile = Profile::spooled(&request(10.0, 0.0, 20.0, 100.0, 20.0));
    let ramps: Vec<f64> = profile.ramps().iter().map(|r| r.a).collect();
    assert_eq!(ramps, [100.0, 0.0], "no braking ramp");
    close(profile.end_v, 20.0, 0.0);
}

// shows: kernel.profile.move.start-above-max-spooled, kernel.maxvel.below-start
#[test]
fn a_start_above_the_maximum_jumps_down() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[10.0], 20.0, 1000.0, 20.0);
    line(&mut m, &[20.0], 5.0, 1000.0, 0.0);
    let trace = run(&mut m);
    let fast = trace.v_plan.iter().position(|v| *v > 19.9).expect("reaches 20");
    let after = trace.v_plan[fast..].iter().find(|v| **v < 19.9).expect("comes down");
    close(*after, 5.0, 1e-9);
}

// shows: kernel.profile.move.too-short-to-accelerate
#[test]
fn too_short_to_accelerate_lowers_the_end() {
    let profile = Profile::spooled(&request(1.0, 0.0, 50.0, 50.0, 50.0));
    close(profile.end_v, 10.0, 1e-12);
    close(profile.ramps()[0].end_v(), 10.0, 1e-12);
}

// shows: kernel.profile.move.too-short-to-brake
#[test]
fn too_short_to_brake_lowers_the_start() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[10.0], 40.0, 200.0, 40.0);
    line(&mut m, &[11.0], 40.0, 50.0, 0.0);
    let trace = run(&mut m);
    let first = trace.entry.iter().position(|e| *e == 2).expect("second block");
    assert!(trace.v_plan[first] < 10.0 && trace.v_plan[first] > 9.8, "{}", trace.v_plan[first]);
    assert_eq!(dp(&trace, 0).last(), Some(&11.0));
}

// shows: kernel.profile.move.tvl-above-max, kernel.tvl.above-max-jump
#[test]
fn a_target_velocity_above_the_maximum_is_a_jump_at_the_end() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[10.0], 10.0, 200.0, 30.0);
    line(&mut m, &[20.0], 30.0, 200.0, 0.0);
    let trace = run(&mut m);
    let second = trace.entry.iter().position(|e| *e == 2).expect("second block");
    assert!(trace.v_plan[..second].iter().all(|v| *v <= 10.0 + 1e-9));
    close(trace.v_plan[second], 30.0, 1e-9);
}

// shows: kernel.profile.move.reverse-end, interp.linear.reversal-by-negative-tvl, kernel.tvl.relative-to-direction
#[test]
fn a_negative_target_velocity_overshoots_and_comes_back() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[10.0, 0.0], 20.0, 100.0, -20.0);
    line(&mut m, &[0.0, 0.0], 20.0, 100.0, 0.0);
    let trace = run(&mut m);
    let x = dp(&trace, 0);
    let top = x.iter().copied().fold(0.0, f64::max);
    close(top, 12.0, 1e-3); // 20²/(2·100) behind the target
    let v = speeds(&trace, 0, 0.0);
    assert!(v.windows(2).all(|w| (w[1] - w[0]).abs() <= 100.0 * TA + 1e-6), "no jump on the way back");
    assert_eq!(x.last(), Some(&0.0));
}

// shows: kernel.tvl.runs-on, axst.pe
#[test]
fn with_a_target_velocity_and_no_command_the_axis_runs_on() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[-5.0], 10.0, 100.0, 10.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(200);
    assert!(!m.axst(0).has(Axst::pe));
    m.run(800);
    let before = m.status().axes[0].dp;
    m.run(100);
    assert!(before < -5.0 && m.axst(0).has(Axst::pe));
    close(m.status().axes[0].dp - before, -10.0 * 100.0 * TA, 1e-9);
    // ms brakes it with sdec
    m.ms(all);
    m.run(100);
    close(m.status().axes[0].dv, 0.0, 0.0);
}

// shows: kernel.profile.move.direction-change, interp.linear.direction-mismatch
#[test]
fn the_magnitude_of_the_velocity_is_laid_into_the_new_direction() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[10.0, 0.0], 20.0, 100.0, 20.0);
    line(&mut m, &[10.0, 10.0], 20.0, 100.0, 0.0);
    let trace = run(&mut m);
    let second = trace.entry.iter().position(|e| *e == 2).expect("second block");
    close(speeds(&trace, 1, 0.0)[second + 1], 20.0, 1e-6);
    close(speeds(&trace, 0, 0.0)[second + 1], 0.0, 1e-9);
}

// shows: kernel.profile.move.chained-ramps, kernel.profile.start-values-momentary
#[test]
fn chained_moves_give_different_slopes() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[2.0], 20.0, 100.0, 20.0);
    line(&mut m, &[2.5], 20.0, 400.0, 0.0);
    let trace = run(&mut m);
    let v = speeds(&trace, 0, 0.0);
    assert!(v.windows(2).any(|w| (w[1] - w[0] - 100.0 * TA).abs() < 1e-6));
    assert!(v.windows(2).any(|w| (w[1] - w[0] + 400.0 * TA).abs() < 1e-6));
}

// shows: kernel.profile.move.circle-same-scheme, pcap.mca.phi-unlimited
#[test]
fn circles_have_the_same_profile_as_lines() {
    let mut circle = mcu("XY", EXACT);
    let r = 50.0 / std::f64::consts::TAU / 2.0;
    arc(&mut circle, [r, 0.0], 720.0, &[], 20.0, 100.0, 0.0);
    let mut straight = mcu("XY", EXACT);
    line(&mut straight, &[50.0, 0.0], 20.0, 100.0, 0.0);
    let (a, b) = (run(&mut circle), run(&mut straight));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.v_plan.iter().zip(&b.v_plan) {
        close(*a, *b, 1e-9);
    }
    close(*dp(&a, 0).last().expect("samples"), 0.0, 1e-12);
}

fn refused(vl: f64, ac: f64) -> ErrorReg {
    let mut m = mcu("X", EXACT);
    assert_eq!(line(&mut m, &[1.0], vl, ac, 0.0), Entered::Discarded);
    let trace = run(&mut m);
    assert!(trace.dp.iter().all(|x| *x == 0.0));
    m.errorreg()
}

// shows: kernel.profile.move.negative-accel-refused, kernel.accel.move-negative-refused, errorreg.accel-zero
#[test]
fn without_acceleration_the_move_is_discarded() {
    assert!(refused(1.0, -5.0).has(ErrorReg::AccelZero));
    assert!(refused(1.0, 0.0).has(ErrorReg::AccelZero | ErrorReg::CheckMonitorScreen));
    assert!(refused(1.0, f64::NAN).has(ErrorReg::AccelZero));
}

// shows: kernel.profile.move.negative-velocity-refused, kernel.maxvel.move-not-positive-refused, errorreg.velocity-zero
#[test]
fn without_velocity_the_move_is_discarded() {
    assert!(refused(-1.0, 5.0).has(ErrorReg::VelocityZero));
    assert!(refused(0.0, 5.0).has(ErrorReg::VelocityZero | ErrorReg::CheckMonitorScreen));
}

// shows: errorreg.velocity-zero.refuse, errorreg.accel-zero.refuse
#[test]
fn inhibit_profile_refuse_only_silences_the_message() {
    for (vl, ac) in [(0.0, 1.0), (1.0, 0.0)] {
        let mut m = mcu("X", EXACT | ModeReg::InhibitProfileRefuse);
        assert_eq!(line(&mut m, &[1.0], vl, ac, 0.0), Entered::Discarded);
        assert!(!m.errorreg().has(ErrorReg::CheckMonitorScreen));
        assert!(m.errorreg().any(ErrorReg::VelocityZero | ErrorReg::AccelZero));
    }
}

// shows: errorreg.zero-profile, errorreg.zero-profile.no-motion
#[test]
fn nothing_to_travel_is_discarded() {
    let mut m = mcu("XY", EXACT);
    assert_eq!(line(&mut m, &[0.0, 0.0], 10.0, 100.0, 0.0), Entered::Discarded);
    assert_eq!(line(&mut m, &[1e-12, 0.0], 10.0, 100.0, 0.0), Entered::Discarded);
    assert_eq!(arc(&mut m, [1.0, 0.0], 0.0, &[], 10.0, 100.0, 0.0), Entered::Discarded);
    assert!(m.errorreg().names().eq(["CheckMonitorScreen", "ZeroProfile"]));
    line(&mut m, &[1.0, 0.0], 10.0, 100.0, 0.0);
    assert_eq!(dp(&run(&mut m), 0).last(), Some(&1.0));
}

// shows: errorreg.radius, errorreg.radius.no-motion, errorreg.center-point
#[test]
fn a_circle_without_radius_is_discarded() {
    let mut m = mcu("XY", EXACT);
    assert_eq!(arc(&mut m, [1e-12, 0.0], 90.0, &[], 10.0, 100.0, 0.0), Entered::Discarded);
    assert!(m.errorreg().names().eq(["RadiusError"]));
    assert_eq!(arc(&mut m, [0.0, 0.0], 90.0, &[], 10.0, 100.0, 0.0), Entered::Discarded);
    assert!(m.errorreg().names().eq(["errCenterPoint", "RadiusError"]));
    let mut m = mcu("XY", EXACT);
    assert_eq!(arc(&mut m, [f64::NAN, 0.0], 90.0, &[], 10.0, 100.0, 0.0), Entered::Discarded);
    assert!(m.errorreg().names().eq(["errCenterPoint"]));
    assert!(run(&mut m).is_empty());
}

// shows: errorreg.axis-multiple
#[test]
fn an_axis_named_twice_is_an_error() {
    let mut m = mcu("XY", EXACT);
    let twice = AxisList::new(&[0, 0]);
    assert_eq!(spool(&mut m, MoveKind::Smla, &twice, &[1.0, 2.0], [0.0; 2], 0.0, [1.0, 1.0, 0.0]), Entered::Discarded);
    assert!(m.errorreg().has(ErrorReg::errAxDef));
}

// shows: spool.precondition.closed-loop, axst.dhef, errorreg.check-monitor
#[test]
fn an_axis_in_open_loop_refuses_motion() {
    let mut m = mcu("XY", EXACT);
    m.ol(set(&[1]));
    assert_eq!(line(&mut m, &[1.0, 1.0], 10.0, 100.0, 0.0), Entered::Refused);
    assert!(m.axst(1).has(Axst::dhef) && !m.axst(0).has(Axst::dhef));
    assert!(m.errorreg().names().eq(["CheckMonitorScreen"]));
    assert!(run(&mut m).is_empty());
}

// shows: interp.formal, interp.formal.automatic, interp.formal.not-zero-profile, interp.formal.spooled
#[test]
fn an_axis_without_travel_takes_part_formally() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[5.0, 0.0], 10.0, 100.0, 0.0);
    line(&mut m, &[5.0, 5.0], 10.0, 100.0, 0.0);
    let trace = run(&mut m);
    let second = trace.entry.iter().position(|e| *e == 2).expect("second block");
    assert!(dp(&trace, 1)[..second].iter().all(|y| *y == 0.0));
    assert!(dp(&trace, 0)[second..].iter().all(|x| *x == 5.0));
    assert_eq!(m.errorreg().0, 0);
}
