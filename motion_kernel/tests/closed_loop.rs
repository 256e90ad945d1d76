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
