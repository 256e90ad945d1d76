//! The closed loop against theory (chapter 2.1).

mod common;

use common::*;
use motion_kernel::machine::{Machine, PidfGains};
use motion_kernel::registers::{Axst, ModeReg};
use motion_kernel::trace::Trace;

/// Moves X by 200 mm at 50 mm/s and returns the following error dp - rp per sample in counts.
fn following(change: impl Fn(&mut PidfGains)) -> Vec<f64> {
    let mut machine = Machine::builtin();
    machine.axes.iter_mut().for_each(|a| change(&mut a.pidf));
    let counts_per_unit = machine.axes[0].counts_per_unit;
    let mut mcu = mcu_of(machine, ModeReg(0));
    line(&mut mcu, &[200.0, 0.0, 0.0], 50.0, 500.0, 0.0);
    mcu.ssms(mcu.all_axes());
    let mut trace = Trace::new(3, 4000);
    mcu.advance(4000, &mut trace);
    (0..trace.len()).map(|k| (trace.dp[3 * k] - trace.rp[3 * k]) * counts_per_unit).collect()
}

#[test]
fn a_proportional_loop_follows_at_v_over_kv() {
    let error = following(|g| *g = PidfGains { kp: g.kp, ..PidfGains::default() });
    let machine = Machine::builtin();
    let axis = &machine.axes[0];
    let kv = axis.pidf.kp * axis.counts_per_unit * axis.plant.full_speed / 32_767.0;
    let want = 50.0 / kv * axis.counts_per_unit;
    assert!((error[1500] / want - 1.0).abs() < 0.01, "{} counts, theory {want}", error[1500]);
}

#[test]
fn with_full_feed_forward_it_follows_within_two_counts() {
    let error = following(|_| ());
    assert!(error[1000..2000].iter().all(|e| e.abs() < 2.0), "{:?}", &error[1000..1010]);
}

#[test]
fn an_overtuned_loop_diverges_and_mpe_sees_it() {
    let overrun = |gain: f64| {
        let mut machine = Machine::builtin();
        machine.axes[0].pidf.kp *= gain;
        machine.axes[0].mpe = 0.1; // the swing is bounded by the 10 V of the drive
        let mut mcu = mcu_of(machine, ModeReg(0));
        line(&mut mcu, &[1.0, 0.0, 0.0], 50.0, 500.0, 0.0);
        mcu.ssms(mcu.all_axes());
        mcu.run(4000);
        mcu.axst(0).has(Axst::mpe)
    };
    assert!(overrun(30.0));
    assert!(!overrun(1.0));
}

/// mill3 with the settings of a G-code run; the load side of X and Y at every sample of what `spool` enters.
fn load_path(spool: impl Fn(&mut motion_kernel::Mcu)) -> Vec<[f64; 2]> {
    let mut mcu = motion_kernel::Mcu::new(std::sync::Arc::new(Machine::builtin()));
    mcu.prepare_gcode();
    spool(&mut mcu);
    let trace = run(&mut mcu);
    (0..trace.len()).map(|k| [trace.load[3 * k], trace.load[3 * k + 1]]).collect()
}

#[test]
fn mill3_stays_on_a_circle_at_its_feed_limit() {
    let path = load_path(|mcu| {
        let entered = arc(mcu, [10.0, 0.0], 720.0, &[0.0], 100.0, 1000.0, 0.0);
        assert_eq!(entered, motion_kernel::functions::Entered::Yes);
    });
    let worst = path.iter().map(|[x, y]| ((x - 10.0).hypot(*y) - 10.0).abs()).fold(0.0, f64::max);
    assert!(worst < 3e-3, "{worst} mm off the circle");
}

#[test]
fn mill3_keeps_its_tolerance_at_corners() {
    let path = load_path(|mcu| {
        line(mcu, &[30.0, 0.0, 0.0], 100.0, 1000.0, 100.0);
        line(mcu, &[30.0, 30.0, 0.0], 100.0, 1000.0, 100.0);
        line(mcu, &[0.0, 30.0, 0.0], 100.0, 1000.0, 0.0);
    });
    let off = |[x, y]: &[f64; 2]| {
        let to = |x0: f64, x1: f64, y0: f64, y1: f64| (x - x.clamp(x0, x1)).hypot(y - y.clamp(y0, y1));
        to(0.0, 30.0, 0.0, 0.0).min(to(30.0, 30.0, 0.0, 30.0)).min(to(0.0, 30.0, 30.0, 30.0))
    };
    let worst = path.iter().map(off).fold(0.0, f64::max);
    let tolerance = Machine::builtin().tolerance_mm;
    assert!(worst < tolerance / 2.0, "{worst} mm off at the corners");
    let end = path.last().expect("samples");
    assert!(end[0].hypot(end[1] - 30.0) < Machine::builtin().axes[0].ipw, "ends at {end:?}");
}

/// The closed loop of one axis as two difference equations, written from the transfer functions: the filter by the
/// bilinear transform, drive and integrator by step invariance. Returns motor positions.
fn difference_equations(
    g: &PidfGains,
    set_points: &[f64],
    lag_s: f64,
    full_speed: f64,
    counts_per_unit: f64,
) -> Vec<f64> {
    let (t, lag) = (TA, 1.0 - g.kpl);
    let num =
        [g.kp + g.ki * t / 2.0 + 2.0 * g.kd / t, g.ki * t - 4.0 * g.kd / t, g.ki * t / 2.0 - g.kp + 2.0 * g.kd / t];
    let den = [1.0 + lag, -2.0 * lag, lag - 1.0];
    let (p, k) = ((-t / lag_s).exp(), full_speed / 32_767.0);
    let plant = [k * (t - lag_s * (1.0 - p)), k * (lag_s * (1.0 - p) - p * t)];
    let (mut e, mut u, mut y) = ([0.0; 2], [0.0; 2], [0.0; 2]); // values one and two samples ago
    let mut positions = Vec::new();
    for &set_point in set_points {
        let position = (1.0 + p) * y[0] - p * y[1] + plant[0] * u[0] + plant[1] * u[1];
        let error = set_point * counts_per_unit - (position * counts_per_unit).round();
        let command = (num[0] * error + num[1] * e[0] + num[2] * e[1] - den[1] * u[0] - den[2] * u[1]) / den[0];
        (e, u, y) = ([error, e[0]], [command, u[0]], [position, y[0]]);
        positions.push(position);
    }
    positions
}

fn response(gains: PidfGains, set_points: &[f64]) -> Vec<f64> {
    let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
    assert!(mcu.uf(0, &gains));
    let step = |&set_point: &f64| {
        mcu.wrdp(0, set_point);
        mcu.run(1);
        mcu.status().axes[0].load
    };
    set_points.iter().map(step).collect()
}

#[test]
fn step_and_ramp_equal_their_difference_equations() {
    let axis = &Machine::builtin().axes[0];
    let step = vec![0.2; 600]; // small enough for 10 V
    let ramp: Vec<f64> = (0..600).map(|n| f64::from(n) * 0.05).collect();
    for set_points in [&step, &ramp] {
        for (kp, ki, kd, kpl) in
            [(0.6, 0.0, 0.0, 0.0), (0.8, 4.0, 0.0, 0.5), (1.2, 2.0, 0.001, 0.0), (2.5, 10.0, 0.002, 0.9)]
        {
            let gains = PidfGains { kp, ki, kd, kpl, ..PidfGains::default() };
            let want =
                difference_equations(&gains, set_points, axis.plant.lag_s, axis.plant.full_speed, axis.counts_per_unit);
            let got = response(gains, set_points);
            let worst = got.iter().zip(&want).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-9, "{gains:?}: {worst} mm");
        }
    }
}

#[test]
fn a_poor_tuning_overshoots_as_much_as_theory_says() {
    // second order: KV = 1 / (4 D^2 lag); the samples take some damping away
    let axis = &Machine::builtin().axes[0];
    let overshoot = |damping: f64| {
        let kv = 1.0 / (4.0 * damping * damping * axis.plant.lag_s);
        let kp = kv * 32_767.0 / axis.plant.full_speed / axis.counts_per_unit;
        let path = response(PidfGains { kp, ..PidfGains::default() }, &vec![0.1; 400]);
        path.iter().copied().fold(0.0, f64::max) / 0.1 - 1.0
    };
    let theory = |damping: f64| (-std::f64::consts::PI * damping / (1.0 - damping * damping).sqrt()).exp();
    assert!(overshoot(1.5) < 0.01);
    let (d, seen) = (0.5, overshoot(0.5));
    assert!(seen > theory(d) && seen < 5.0 * theory(d), "{seen} against {} without dead time", theory(d));
}

// shows: kernel.accel.unreachable
#[test]
fn a_drive_too_weak_for_the_acceleration_lags_behind_meanwhile() {
    let worst = |full_acceleration: f64| {
        let mut machine = Machine::builtin();
        machine.axes[0].plant.full_acceleration = full_acceleration;
        let mut mcu = mcu_of(machine, ModeReg(0));
        line(&mut mcu, &[100.0, 0.0, 0.0], 100.0, 1000.0, 0.0);
        mcu.ssms(mcu.all_axes());
        let errors = (0..300).map(|_| {
            mcu.run(1);
            mcu.rdPosErr(0).abs()
        });
        let errors: Vec<f64> = errors.collect();
        (errors[..100].iter().copied().fold(0.0, f64::max), errors[299])
    };
    let ((strong, _), (weak, later)) = (worst(0.0), worst(700.0));
    assert!(weak > 1.0 && weak > 50.0 * strong, "{weak} mm against {strong} mm");
    assert!(later < weak / 10.0, "{later} mm once the speed is reached");
}

/// mill3 with a torque-controlled drive of X, tuned with a derivative part.
fn torque_axis(friction: f64, ki: f64) -> Machine {
    let mut machine = Machine::builtin();
    let axis = &mut machine.axes[0];
    axis.plant = motion_kernel::machine::Plant {
        control: motion_kernel::machine::DriveControl::Torque,
        lag_s: 0.0,
        full_acceleration: 8000.0,
        friction,
        ..axis.plant
    };
    // double integrator: poles at w = 100 1/s with damping 1
    let gain = 32_767.0 / (8000.0 * axis.counts_per_unit);
    axis.pidf = PidfGains { kp: 1e4 * gain, kd: 200.0 * gain, ki, kpl: 0.9, kfca: gain, ..PidfGains::default() };
    machine
}

#[test]
fn a_torque_drive_is_held_by_its_derivative_part() {
    let end = |machine: Machine| {
        let mut mcu = mcu_of(machine, ModeReg(0));
        line(&mut mcu, &[20.0, 0.0, 0.0], 50.0, 500.0, 0.0);
        mcu.ssms(mcu.all_axes());
        mcu.run(2500);
        mcu.rdPosErr(0).abs()
    };
    assert!(end(torque_axis(0.0, 0.0)) < 1e-3);
    let undamped = end({
        let mut machine = torque_axis(0.0, 0.0);
        machine.axes[0].pidf.kd = 0.0;
        machine
    });
    assert!(undamped > 0.1, "without KD it swings: {undamped}");
    let stuck = end(torque_axis(400.0, 0.0));
    assert!(stuck > 5e-3 && stuck < 0.05, "friction leaves up to friction / w^2 = 0.04 mm: {stuck}");
    let gain = 32_767.0 / (8000.0 * 1e4);
    assert!(end(torque_axis(400.0, 2e5 * gain)) < stuck / 4.0, "the integral part overcomes it");
}
