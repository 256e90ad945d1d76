//! Spooled lines: trapezoid profiles and the special cases of chapter 2.2.2.

mod common;

use common::*;
use motion_kernel::registers::ModeReg;

/// Closed form, independent of the kernel: position at time t of a trapezoid from standstill to standstill.
fn trapezoid(t: f64, length: f64, v: f64, a: f64) -> f64 {
    let v = v.min((a * length).sqrt());
    let (t1, t2) = (v / a, length / v);
    let end = t2 + t1;
    match t {
        t if t >= end => length,
        t if t < t1 => 0.5 * a * t * t,
        t if t < t2 => 0.5 * v * t1 + v * (t - t1),
        t => length - 0.5 * a * (end - t).powi(2),
    }
}

// shows: kernel.profile.trapezoid, kernel.profile.sample-synchronous, kernel.profile.accelerate-to-max
// shows: kernel.profile.brake-in-time, kernel.accel.brake-equals-accel-default, kernel.profile.move.symmetric-ramps
#[test]
fn a_line_follows_the_closed_form() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[30.0, 40.0], 20.0, 100.0, 0.0);
    let trace = run(&mut m);
    for (k, x) in dp(&trace, 0).iter().enumerate() {
        let s = trapezoid((k + 1) as f64 * TA, 50.0, 20.0, 100.0);
        close(*x, 0.6 * s, 1e-11);
        close(dp(&trace, 1)[k], 0.8 * s, 1e-11);
    }
    assert_eq!((dp(&trace, 0).last(), dp(&trace, 1).last()), (Some(&30.0), Some(&40.0)));
    assert_eq!(trace.len(), ((50.0 / 20.0 + 0.2) / TA).ceil() as usize);
}

// shows: kernel.profile.move.triangle
#[test]
fn a_short_line_is_a_triangle() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[1.0], 100.0, 100.0, 0.0);
    let trace = run(&mut m);
    for (k, x) in dp(&trace, 0).iter().enumerate() {
        close(*x, trapezoid((k + 1) as f64 * TA, 1.0, 100.0, 100.0), 1e-12);
    }
    assert_eq!(dp(&trace, 0).last(), Some(&1.0));
}

// shows: spool.no-gap
#[test]
fn a_chain_runs_without_ripple() {
    let mut m = mcu("X", EXACT);
    for n in 1..=10 {
        let (target, tvl) = if n < 10 { (f64::from(n) * 1.5, 20.0) } else { (17.0, 0.0) };
        line(&mut m, &[target], 20.0, 100.0, tvl);
    }
    let trace = run(&mut m);
    for (k, x) in dp(&trace, 0).iter().enumerate() {
        close(*x, trapezoid((k + 1) as f64 * TA, 17.0, 20.0, 100.0), 1e-11);
    }
}

#[test]
fn lookahead_splits_change_nothing() {
    let mut m = mcu("XY", LOOKAHEAD);
    for n in 1..=100 {
        line(&mut m, &[n as f64 * 0.3, n as f64 * 0.4], 20.0, 100.0, 20.0);
    }
    let trace = run(&mut m);
    for (k, x) in dp(&trace, 0).iter().enumerate() {
        close(*x, 0.6 * trapezoid((k + 1) as f64 * TA, 50.0, 20.0, 100.0), 1e-10);
    }
    assert!(m.errorreg().names().eq(["SpoolerDeepToLess"]), "the last target velocity was not 0");
}

#[test]
fn rounding_at_stops_without_exact_target() {
    let mut m = mcu("X", ModeReg(0));
    line(&mut m, &[1.00003], 20.0, 100.0, 0.0);
    assert_eq!(dp(&run(&mut m), 0).last(), Some(&1.0));
    // and where look-ahead makes the end of the spooler a stop
    let mut m = mcu("X", ModeReg::LookAhead);
    line(&mut m, &[1.00003], 20.0, 100.0, 20.0);
    assert_eq!(dp(&run(&mut m), 0).last(), Some(&1.0));
}
