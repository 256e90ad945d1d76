//! The parts of the PIDF filter as they show in the motor command (chapter 2.1.2).

mod common;

use common::*;
use motion_kernel::machine::{Machine, PidfGains};
use motion_kernel::registers::ModeReg;

/// Motor command of X for following errors of 100 counts, after n samples, with an axis that cannot move.
fn output(gains: PidfGains, n: u64) -> i32 {
    let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
    mcu.uf(0, &gains);
    mcu.plant_mut(0).expect("a servo").block(true);
    mcu.wrdp(0, 0.01);
    mcu.run(n);
    mcu.rdmcp(0)
}

// shows: kernel.pidf.kp, kernel.pidf.zero-disables-p, kernel.pidf.zero-disables-i
#[test]
fn the_proportional_part() {
    let p = |kp| output(PidfGains { kp, ..PidfGains::default() }, 100);
    assert_eq!([p(0.0), p(1.0), p(5.0)], [0, 100, 500]);
    assert_eq!(output(PidfGains { kp: 1.0, ..PidfGains::default() }, 10_000), 100, "without KI nothing grows");
}

// shows: kernel.pidf.ki
#[test]
fn the_integral_part_grows_by_the_proportional_one_in_tn() {
    let (kp, tn) = (2.0, 0.128); // 100 samples
    let gains = PidfGains { kp, ki: kp / tn, ..PidfGains::default() };
    let grown = f64::from(output(gains, 300) - output(gains, 200));
    assert!((grown - 200.0).abs() <= 1.0, "{grown}");
}

// shows: kernel.pidf.kd, kernel.pidf.zero-disables-d
#[test]
fn the_derivative_part_answers_a_ramp_with_kp_tv_times_its_slope() {
    let ramp = |kd| {
        let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
        mcu.uf(0, &PidfGains { kd, ..PidfGains::default() });
        mcu.plant_mut(0).expect("a servo").block(true);
        for n in 1..=50 {
            mcu.wrdp(0, f64::from(n) * 1e-3); // 10 counts a sample
            mcu.run(1);
        }
        mcu.rdmcp(0)
    };
    let (kp, tv) = (2.0, 0.02);
    assert_eq!(ramp(kp * tv), (kp * tv * 10.0 / TA).round() as i32);
    assert_eq!(ramp(0.0), 0);
}

// shows: kernel.pidf.lag-default, kernel.pidf.kpl-formula
#[test]
fn the_lag_is_that_of_its_time_constant() {
    // a step through 1 / (1 + s T), bilinear at TA with T = (1 - KPL) TA / 2
    let first = |kpl: f64| output(PidfGains { kp: 100.0, kpl, ..PidfGains::default() }, 1);
    for kpl in [0.0, 0.5, 1.0] {
        let t = (1.0 - kpl) * TA / 2.0;
        let want = 10_000.0 / (1.0 + 2.0 * t / TA);
        assert_eq!(first(kpl), f64::round(want) as i32, "KPL {kpl}");
    }
}
