//! Direct mode: jogs and direct moves (2.2.1, 2.2.8.1, 4.4.19, 4.4.23, 4.4.24, 4.4.28 to 4.4.38).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::autocode::MoveKind::{self, *};
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::motion::MotionCommand;
use motion_kernel::profile::{Profile, Request};
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use motion_kernel::trace::{Trace, flag};
use proptest::prelude::*;

const LATENCY: u64 = 2;

fn jogger() -> Mcu {
    let mut m = mcu("XY", EXACT);
    for a in 0..2 {
        let p = m.parameters_mut(a);
        (p.jvl, p.jac, p.jog_brake, p.jtvl) = (20.0, 100.0, 100.0, 0.0);
    }
    m
}
fn ja(m: &mut Mcu, axis: usize, target: f64) {
    assert_eq!(m.ja(&AxisList::new(&[axis]), &[target]), Entered::Yes);
}
fn direct(m: &mut Mcu, kind: MoveKind, axes: &[usize], targets: &[f64], v: [f64; 3]) -> Entered {
    let list = AxisList::new(axes);
    let [vl, ac, tvl] = v;
    m.direct(&MotionCommand {
        kind,
        axes: &list,
        targets,
        center: [5.0, 0.0],
        phi: 90.0,
        vl,
        ac,
        tvl,
        rapid: false,
        line: 1,
    })
}
fn x(m: &Mcu) -> f64 {
    m.status().axes[0].dp
}
/// Velocity of X over the next sample.
fn v(m: &mut Mcu) -> f64 {
    let before = x(m);
    m.run(1);
    (x(m) - before) / TA
}
/// Velocities of X until everything is done.
fn velocities(m: &mut Mcu) -> Vec<f64> {
    let start = x(m);
    let trace = record(m);
    speeds(&trace, 0, start)
}
fn smooth(v: &[f64], acc: f64) -> bool {
    v.windows(2).all(|w| (w[1] - w[0]).abs() <= acc * TA + 1e-6)
}

proptest! {
    // shows: kernel.profile.jog.positive-max-and-accel
    #[test]
    fn every_consistent_direct_profile_reaches_its_target_without_a_jump(
        length in 0.01..100.0f64, start_v in -40.0..60.0f64, max_v in 1.0..50.0f64, acc in 10.0..500.0f64,
        brake_acc in 10.0..500.0f64, target_v in -50.0..50.0f64,
    ) {
        let target_v = target_v.clamp(-max_v, max_v);
        let reach = |v0: f64, v1: f64, a: f64| v0 * v0 - v1 * v1 <= 2.0 * a * length;
        prop_assume!((start_v < 0.0 || reach(start_v, target_v, brake_acc)) && reach(target_v, start_v, acc));
        let r = Request { from: 0.0, to: length, start_v, max_v, acc, target_v, jerkrel: 0.0 };
        let profile = Profile::direct(&r, brake_acc, true);
        let (mut s, mut v) = (0.0, start_v);
        for ramp in profile.ramps() {
            close(ramp.s0, s, 1e-9 * (1.0 + s.abs()));
            close(ramp.v0, v, 1e-9 * (1.0 + v.abs()));
            assert!(ramp.a <= acc + 1e-9 && ramp.a >= -brake_acc - 1e-9);
            assert!(ramp.end_v() <= max_v.max(v) + 1e-9);
            (s, v) = (ramp.end_s(), ramp.end_v());
        }
        close(s, length, 1e-8 * (1.0 + length));
        close(v, target_v, 1e-6 * (1.0 + v.abs()));
        close(profile.end_v, target_v, 1e-9);
    }
}

// shows: pcap.ja, pcap.ja.parameters, direct.latency, axst.pe.at-call, kernel.mode.by-command, direct.activation
#[test]
fn a_jog_starts_two_samples_after_the_call() {
    let mut m = jogger();
    ja(&mut m, 0, -10.0);
    assert!(!m.axst(0).has(Axst::pe), "from the call on");
    m.run(LATENCY);
    assert_eq!(x(&m), 0.0);
    assert!(!m.axst(0).has(Axst::pe));
    m.run(1);
    close(x(&m), -0.5 * 100.0 * TA * TA, 1e-12);
    let trace = record(&mut m);
    assert_eq!(x(&m), -10.0);
    assert_eq!(trace.len() as u64 + 1, ((10.0 / 20.0 + 0.2) / TA).ceil() as u64);
    assert!(trace.flags.iter().rev().skip(1).all(|f| f & flag::DIRECT != 0) && m.axst(0).has(Axst::pe));
}

// shows: pcap.jr, pcap.jr.direction
#[test]
fn a_relative_jog_counts_from_the_set_point_when_it_starts() {
    let mut m = jogger();
    for (way, end) in [(3.0, 3.0), (-5.0, -2.0)] {
        m.jr(&AxisList::new(&[0]), &[way]);
        record(&mut m);
        close(x(&m), end, 1e-12);
    }
}

// shows: pcap.ja.independent, interp.jog-vs-move
#[test]
fn axes_of_one_jog_run_independently() {
    let mut m = jogger();
    m.parameters_mut(1).jvl = 5.0;
    m.ja(&AxisList::new(&[1, 0]), &[10.0, 10.0]);
    m.run(800);
    assert!(m.axst(0).has(Axst::pe) && !m.axst(1).has(Axst::pe));
    record(&mut m);
    close(m.status().axes[1].dp, 10.0, 0.0);
}

// shows: direct.replaces-running-profile, direct.seamless, direct.retarget, kernel.profile.jog.reverse-start
// shows: direct.sequence-needs-wait
#[test]
fn a_new_target_replaces_the_running_profile() {
    let mut m = jogger();
    ja(&mut m, 0, 100.0);
    m.run(400);
    ja(&mut m, 0, -5.0);
    let v = velocities(&mut m);
    assert!(smooth(&v, 100.0) && v[0] > 19.0, "on from the momentary velocity");
    assert!(v.iter().any(|v| *v < -19.0));
    assert_eq!(x(&m), -5.0);
}

// shows: direct.raise-velocity, direct.change-accel-in-ramp, kernel.profile.jog.start-above-max
#[test]
fn velocity_and_acceleration_change_on_the_way() {
    let mut m = jogger();
    ja(&mut m, 0, 100.0);
    m.run(50);
    m.parameters_mut(0).jvl = 30.0;
    m.wrjac(0, 300.0);
    ja(&mut m, 0, 100.0);
    m.run(LATENCY);
    let (a, b) = (v(&mut m), v(&mut m));
    close((b - a) / TA, 300.0, 1e-3);
    m.run(400);
    close(v(&mut m), 30.0, 1e-9);
    m.parameters_mut(0).jvl = 10.0;
    ja(&mut m, 0, 100.0);
    let v = velocities(&mut m);
    assert!(smooth(&v, 300.0), "brakes by a ramp");
    close(v[400], 10.0, 1e-9);
}

// shows: kernel.profile.jog.negative-accel-brake-ramp, kernel.profile.jog.asymmetric-ramps, pcap.wrjac.negative
// shows: kernel.accel.jog-negative-brake, direct.change-brake-ramp, pcap.wrjac
#[test]
fn a_negative_acceleration_is_the_braking_ramp() {
    let mut m = jogger();
    m.wrjac(0, 200.0);
    m.wrjac(0, -50.0);
    assert_eq!(m.rdjac(0), -50.0);
    ja(&mut m, 0, 50.0);
    m.run(400);
    let v = velocities(&mut m);
    let steepest = v.windows(2).map(|w| (w[1] - w[0]) / TA).fold(0.0, f64::min);
    close(steepest, -50.0, 0.1);
    m.wrjac(0, 300.0);
    ja(&mut m, 0, 0.0);
    let v = velocities(&mut m);
    close(v.windows(2).map(|w| (w[1] - w[0]) / TA).fold(0.0, f64::min), -300.0, 0.1);
    assert!(!m.wrjac(0, 0.0));
}

// shows: kernel.profile.jog.triangle
#[test]
fn a_short_jog_is_a_triangle() {
    let mut m = jogger();
    ja(&mut m, 0, 1.0);
    let v = velocities(&mut m);
    assert!(smooth(&v, 100.0));
    close(v.iter().copied().fold(0.0, f64::max), 10.0, 100.0 * TA);
    assert_eq!(x(&m), 1.0);
}

/// X runs on at 20 mm/s, the maximum, behind a jog to 10.
fn running_on() -> Mcu {
    let mut m = jogger();
    m.parameters_mut(0).jtvl = 20.0;
    ja(&mut m, 0, 10.0);
    m.run(1000);
    m
}

// shows: kernel.profile.jog.end-equals-max, pcap.wrjtvl
#[test]
fn a_jog_may_end_at_its_maximum() {
    let mut m = jogger();
    m.parameters_mut(0).jtvl = 20.0;
    ja(&mut m, 0, 10.0);
    let mut trace = Trace::default();
    m.pass(700, &mut trace);
    let speeds = speeds(&trace, 0, 0.0);
    let top = speeds.iter().position(|v| *v > 20.0 - 1e-9).expect("reaches the maximum");
    assert!(smooth(&speeds, 100.0) && speeds[top..].iter().all(|v| (v - 20.0).abs() < 1e-9), "no braking ramp");
    assert!(x(&m) > 10.0 && m.axst(0).has(Axst::pe));
}

// shows: kernel.profile.jog.start-equals-max
#[test]
fn a_jog_may_start_at_its_maximum() {
    let mut m = running_on();
    m.parameters_mut(0).jtvl = 0.0;
    ja(&mut m, 0, 50.0);
    let speeds = velocities(&mut m);
    assert!(smooth(&speeds, 100.0) && speeds[..100].iter().all(|v| (v - 20.0).abs() < 1e-9));
    assert_eq!(x(&m), 50.0);
}

// shows: kernel.profile.jog.reverse-end
#[test]
fn a_negative_target_velocity_of_a_jog_passes_the_target_twice() {
    let mut m = running_on();
    m.parameters_mut(0).jtvl = -20.0;
    ja(&mut m, 0, 60.0);
    let mut trace = Trace::default();
    let start = x(&m);
    m.pass(1900, &mut trace);
    let top = dp(&trace, 0).into_iter().fold(0.0, f64::max);
    close(top, 62.0, 1e-2); // 20²/(2·100) behind the target
    assert!(x(&m) < 60.0 && smooth(&speeds(&trace, 0, start), 100.0));
    close(v(&mut m), -20.0, 1e-9);
}

// shows: kernel.profile.jog.tvl-above-max, kernel.profile.jog.tvl-not-above-max
#[test]
fn a_target_velocity_above_the_maximum_is_a_jump() {
    let mut m = jogger();
    m.parameters_mut(0).jtvl = 40.0;
    ja(&mut m, 0, 10.0);
    m.run(1000);
    close(v(&mut m), 40.0, 1e-9);
}

// shows: kernel.profile.jog.too-short-to-brake
#[test]
fn too_short_to_brake_ends_a_jog_with_a_jump() {
    let mut m = jogger();
    ja(&mut m, 0, 100.0);
    m.run(400);
    let target = x(&m) + 1.0;
    ja(&mut m, 0, target);
    let v = velocities(&mut m);
    assert_eq!(x(&m), target);
    let last = v.iter().rposition(|v| v.abs() > 1.0).expect("it moved");
    assert!(v[last - 1] > 14.0 && !smooth(&v, 100.0));
}

// shows: kernel.maxvel.jog-not-positive-endless
#[test]
fn a_velocity_that_is_not_positive_runs_away_or_stands() {
    let mut m = jogger();
    m.parameters_mut(0).jvl = -10.0;
    ja(&mut m, 0, 5.0);
    m.run(2000);
    close(v(&mut m), -10.0, 1e-9);
    assert!(!m.axst(0).has(Axst::pe));
    let mut m = jogger();
    m.parameters_mut(0).jvl = 0.0;
    ja(&mut m, 0, 5.0);
    m.run(2000);
    assert!(x(&m) == 0.0 && !m.axst(0).has(Axst::pe));
    m.js(set(&[0]));
    m.run(1);
    assert!(m.axst(0).has(Axst::pe));
}

// shows: pcap.js, pcap.js.pe, pcap.js.sdec-zero, pcap.js.independent
#[test]
fn js_brakes_each_axis_with_its_sdec() {
    let mut m = jogger();
    m.ja(&AxisList::new(&[0, 1]), &[100.0, -100.0]);
    m.run(400);
    m.parameters_mut(0).sdec = 50.0;
    m.parameters_mut(1).sdec = 0.0;
    let (x0, y0) = (x(&m), m.status().axes[1].dp);
    m.js(set(&[0, 1]));
    m.run(2);
    assert!(!m.axst(0).has(Axst::pe) && m.axst(1).has(Axst::pe | Axst::cl));
    record(&mut m);
    close(x(&m) - x0, 20.0 * 20.0 / 100.0, 1e-9);
    close(m.status().axes[1].dp, y0, 1e-9);
}

// shows: kernel.override.jog-per-axis, pcap.wrjovr, pcap.wrjovr.below-one, pcap.wrjovr.above-one, pcap.wrjovr.accel
#[test]
fn the_jog_override_scales_the_clock_of_one_axis() {
    for factor in [0.5, 1.5] {
        let mut m = jogger();
        m.wrjovr(0, factor);
        m.ja(&AxisList::new(&[0, 1]), &[60.0, 60.0]);
        m.run(LATENCY);
        let (a, b) = (v(&mut m), v(&mut m));
        close((b - a) / TA, 100.0 * factor * factor, 1e-3);
        m.run(600);
        close(v(&mut m), 20.0 * factor, 1e-9);
        close(m.status().axes[1].dv, 20.0, 1e-9);
        record(&mut m);
        assert_eq!(x(&m), 60.0);
    }
}

// shows: direct.discards-spooler, spool.saf.clear-by-direct-command, pcap.sstps.ms-js-discard
#[test]
fn a_direct_command_discards_the_spooler_and_clears_saf() {
    let mut m = jogger();
    line(&mut m, &[10.0, 10.0], 20.0, 100.0, 0.0);
    line(&mut m, &[20.0, 20.0], 20.0, 100.0, 0.0);
    m.ssms(set(&[0]));
    m.run(10);
    assert!(m.axst(0).has(Axst::saf));
    ja(&mut m, 0, 1.0);
    ja(&mut m, 1, 1.0);
    assert!(!m.axst(0).has(Axst::saf));
    record(&mut m);
    assert!(m.status().axes.iter().all(|a| a.mcis == 0 && a.dp == 1.0 && a.lsm == a.memory));
    line(&mut m, &[2.0, 2.0], 20.0, 100.0, 0.0);
    line(&mut m, &[3.0, 3.0], 20.0, 100.0, 0.0);
    m.ssms(set(&[0, 1]));
    m.run(10);
    m.js(set(&[0, 1]));
    assert!(m.status().axes.iter().all(|a| a.mcis == 0));
}

// shows: pcap.mla, pcap.mla.abs-target, pcap.mla.parameters, pcap.mlr, pcap.mla.any-axes
#[test]
fn direct_lines_interpolate_at_once() {
    let mut m = mcu("XYZ", EXACT);
    assert_eq!(direct(&mut m, Smla, &[0, 1, 2], &[6.0, 8.0, 0.0], [20.0, 100.0, 0.0]), Entered::Yes);
    let trace = record(&mut m);
    assert!(trace.dp.chunks(3).all(|p| (p[1] * 0.75 - p[0]).abs() < 1e-12));
    assert_eq!(trace.len() as u64, LATENCY + ((10.0 / 20.0 + 0.2) / TA).ceil() as u64);
    direct(&mut m, Smlr, &[2, 0], &[5.0, -6.0], [20.0, 100.0, 0.0]);
    record(&mut m);
    let at = m.status().axes;
    assert_eq!([at[0].dp, at[1].dp, at[2].dp], [0.0, 8.0, 5.0]);
}

// shows: pcap.mca, pcap.mca.any-axes, pcap.mca.center-absolute, pcap.mca.phi-degrees, pcap.mca.phi-sign, pcap.mcr
// shows: pcap.mha, pcap.mha.linear-targets, pcap.mha.simultaneous-end, pcap.mhr, pcap.mca.trapezoid
#[test]
fn direct_circles_and_helices() {
    let v = [20.0, 100.0, 0.0];
    for (kind, axes, targets, end) in [
        (Smca, &[0, 2][..], &[0.0; 2][..], [5.0, 0.0, -5.0]),
        (Smcr, &[0, 2], &[0.0; 2], [5.0, 0.0, -5.0]),
        (Smha, &[0, 1, 2], &[0.0, 0.0, 3.0], [5.0, -5.0, 3.0]),
        (Smhr, &[0, 1, 2], &[0.0, 0.0, 3.0], [5.0, -5.0, 3.0]),
    ] {
        let mut m = mcu("XYZ", EXACT);
        direct(&mut m, kind, axes, targets, v);
        let trace = record(&mut m);
        for p in trace.dp.chunks(3) {
            close((p[0] - 5.0).hypot(p[axes[1]]), 5.0, 1e-12);
        }
        for (axis, end) in m.status().axes.iter().zip(end) {
            close(axis.dp, end, 1e-12);
        }
        assert!(trace.v_plan.iter().copied().fold(0.0, f64::max) <= 20.0 + 1e-9);
    }
}

// shows: kernel.profile.move.start-above-max-direct
#[test]
fn a_direct_move_brakes_to_its_maximum_by_a_ramp() {
    let mut m = mcu("X", EXACT);
    direct(&mut m, Smla, &[0], &[100.0], [40.0, 100.0, 0.0]);
    m.run(400);
    direct(&mut m, Smla, &[0], &[100.0], [10.0, 100.0, 0.0]);
    let v = velocities(&mut m);
    assert!(smooth(&v, 100.0) && v[0] > 39.0);
    close(v[400], 10.0, 1e-9);
}

#[test]
fn a_direct_move_in_another_direction_keeps_the_magnitude() {
    let mut m = mcu("XY", EXACT);
    direct(&mut m, Smla, &[0, 1], &[100.0, 0.0], [20.0, 100.0, 0.0]);
    m.run(400);
    let here = x(&m);
    direct(&mut m, Smlr, &[0, 1], &[0.0, 30.0], [20.0, 100.0, 0.0]);
    m.run(LATENCY + 2);
    close(m.status().axes[1].dv, 20.0, 1e-9);
    record(&mut m);
    assert!(x(&m) > here && (m.status().axes[1].dp - 30.0).abs() < 1e-12);
}

// shows: interp.parallel.free-axis
#[test]
fn another_axis_jogs_beside_an_interpolation() {
    let mut m = mcu("XYZ", EXACT);
    line(&mut m, &[10.0, 10.0], 20.0, 100.0, 0.0);
    m.ssms(set(&[0, 1]));
    m.run(50);
    ja(&mut m, 2, -5.0);
    let trace = record(&mut m);
    assert!(trace.dp.chunks(3).all(|p| p[0] == p[1]));
    assert_eq!((x(&m), m.status().axes[2].dp), (10.0, -5.0));
    assert!(!m.axst(0).has(Axst::saf));
}

#[test]
fn direct_commands_are_refused_like_spooled_ones() {
    let mut m = mcu("XY", EXACT);
    m.ol(set(&[1]));
    assert_eq!(m.ja(&AxisList::new(&[0, 1]), &[1.0, 1.0]), Entered::Refused);
    assert!(m.axst(1).has(Axst::dhef) && m.errorreg().has(ErrorReg::CheckMonitorScreen));
    assert_eq!(m.ja(&AxisList::new(&[0, 0]), &[1.0, 1.0]), Entered::Discarded);
    assert_eq!(m.ja(&AxisList::new(&[0]), &[f64::NAN]), Entered::Discarded);
    assert_eq!(direct(&mut m, Smla, &[0], &[1.0], [0.0, 1.0, 0.0]), Entered::Discarded);
    assert!(run(&mut m).is_empty());
    // what is valid at the call and has no path when it starts
    assert_eq!(direct(&mut m, Smla, &[0], &[0.0], [1.0, 1.0, 0.0]), Entered::Yes);
    record(&mut m);
    assert!(m.errorreg().has(ErrorReg::ZeroProfile) && m.axst(0).has(Axst::pe));
}

#[test]
fn a_stop_before_the_effect_drops_the_command() {
    let mut m = jogger();
    ja(&mut m, 0, 10.0);
    m.js(set(&[0]));
    m.run(100);
    assert!(x(&m) == 0.0 && m.axst(0).has(Axst::pe));
}

#[test]
fn a_direct_move_is_held_and_resumed_on_its_path() {
    let mut m = mcu("XY", EXACT | ModeReg::LookAhead);
    direct(&mut m, Smca, &[0, 1], &[0.0; 2], [20.0, 100.0, 0.0]);
    m.run(200);
    m.hold();
    m.run(500);
    assert!(m.status().stands);
    m.resume();
    let mut trace = Trace::default();
    m.advance(20_000, &mut trace);
    assert!(trace.dp.chunks(2).all(|p| ((p[0] - 5.0).hypot(p[1]) - 5.0).abs() < 1e-12));
    close(m.status().axes[1].dp, -5.0, 1e-12);
}

// shows: pcap.wrmaxvel.spooled-only, pcap.wrmaxacc.spooled-only
#[test]
fn the_limits_of_chk_max_vel_are_for_spooled_commands() {
    let mut m = mcu("X", EXACT | ModeReg::ChkMaxVel);
    (m.parameters_mut(0).maxvel, m.parameters_mut(0).maxacc) = (5.0, 20.0);
    direct(&mut m, Smla, &[0], &[10.0], [20.0, 100.0, 0.0]);
    let v = velocities(&mut m);
    close(v.iter().copied().fold(0.0, f64::max), 20.0, 1e-6);
    close(v.windows(2).map(|w| (w[1] - w[0]) / TA).fold(0.0, f64::max), 100.0, 1e-3);
    line(&mut m, &[0.0], 20.0, 100.0, 0.0);
    let spooled = run(&mut m);
    close(spooled.v_plan.iter().copied().fold(0.0, f64::max), 5.0, 1e-9);
}
