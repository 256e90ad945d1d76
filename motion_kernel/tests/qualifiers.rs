//! Values of one axis, its filter and its motor command port (chapters 2.1, 4.4).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::functions::Entered;
use motion_kernel::machine::{DriveKind, LimitFunction, Machine, PidfGains};
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use std::sync::Arc;

fn booted(change: impl Fn(&mut Machine)) -> Mcu {
    let mut machine = Machine::builtin();
    change(&mut machine);
    Mcu::new(Arc::new(machine))
}
/// mill3 after boot and cl.
fn closed() -> Mcu {
    mcu_of(Machine::builtin(), ModeReg(0))
}
fn start_line(mcu: &mut Mcu, x: f64, v: f64) {
    line(mcu, &[x, 0.0, 0.0], v, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
}

// shows: kernel.controller.power-up-open, kernel.controller.power-up-mcp-zero, axst.cl
#[test]
fn after_boot_loops_are_open_and_outputs_zero() {
    let mut mcu = booted(|_| ());
    for a in 0..3 {
        assert!(!mcu.axst(a).has(Axst::cl));
        assert_eq!(mcu.rdmcp(a), 0);
    }
    mcu.cl(set(&[1]));
    assert_eq!([0, 1, 2].map(|a| mcu.axst(a).has(Axst::cl)), [false, true, false]);
}

// shows: kernel.controller.open-loop-output, kernel.controller.loop-chain, pcap.wrmcp, pcap.rdrv.open-loop, pcap.rdrv
#[test]
fn a_motor_command_moves_the_open_axis() {
    let mut mcu = booted(|_| ());
    mcu.wrmcp(0, 3_277); // about 1 V
    mcu.run(1000);
    let speed = 0.1 * Machine::builtin().axes[0].plant.full_speed;
    assert!((mcu.rdrp(0) / (speed * 1000.0 * TA) - 1.0).abs() < 0.01, "{}", mcu.rdrp(0));
    assert!((mcu.rdrv(0) / speed - 1.0).abs() < 0.01, "{}", mcu.rdrv(0));
    assert_eq!(mcu.rdrp(1), 0.0);
    mcu.wrmcp(0, -3_277);
    mcu.run(100);
    assert!(mcu.rdrv(0) < 0.0);
}

// shows: pcap.wrmcp.servo-range, pcap.rdmcp.servo-range, pcap.rdmcp
#[test]
fn the_motor_command_of_a_servo_is_clamped() {
    let mut mcu = booted(|_| ());
    for (written, read) in [(32_767, 32_767), (40_000, 32_767), (i32::MIN, -32_767), (-5, -5)] {
        mcu.wrmcp(0, written);
        assert_eq!(mcu.rdmcp(0), read);
    }
}

// shows: pcap.wrmcp.closed-loop
#[test]
fn a_closed_loop_overwrites_the_motor_command() {
    let mut mcu = closed();
    mcu.wrmcp(0, 20_000);
    assert_eq!(mcu.rdmcp(0), 20_000);
    mcu.run(1);
    assert!(mcu.rdmcp(0).abs() < 10_000, "the loop brings the axis back: {}", mcu.rdmcp(0));
    mcu.run(300);
    assert!(mcu.rdrp(0).abs() < 1e-3);
}

// shows: pcap.wrmcp.clock, pcap.wrmcp.stepper-range
#[test]
fn a_stepper_in_open_loop_steps_at_the_rate_of_its_clock() {
    let mut mcu = booted(|m| m.axes[0].drive = DriveKind::Stepper);
    mcu.wrmcp(0, 2_000_000);
    assert_eq!(mcu.rdmcp(0), 1_048_574);
    mcu.wrmcp(0, -2_000_000);
    assert_eq!(mcu.rdmcp(0), -1_048_574);
    mcu.wrmcp(0, 999);
    mcu.run(10_000);
    let steps = mcu.rdrp(0) * Machine::builtin().axes[0].counts_per_unit;
    assert!((steps - 33_333.33 * 10_000.0 * TA).abs() <= 1.0, "{steps} at 66.66666 MHz");
}

// shows: kernel.controller.close-takes-actual, pcap.cl, pcap.cl.takes-actual
#[test]
fn closing_takes_the_actual_position_over_and_moves_nothing() {
    let mut mcu = booted(|_| ());
    mcu.wrmcp(0, 5_000);
    mcu.run(500);
    mcu.wrmcp(0, 0);
    mcu.run(100); // comes to rest
    let rp = mcu.rdrp(0);
    assert!(rp > 1.0);
    mcu.cl(set(&[0]));
    assert_eq!(mcu.rddp(0), rp);
    mcu.run(500);
    assert!((mcu.rdrp(0) - rp).abs() <= 1.5e-4, "within a count");
}

// shows: pcap.clv, pcap.clv.keeps-moving
#[test]
fn clv_goes_on_with_the_actual_velocity() {
    let mut mcu = booted(|_| ());
    mcu.wrmcp(0, 3_277);
    mcu.run(500);
    let (rp, rv) = (mcu.rdrp(0), mcu.rdrv(0));
    mcu.clv(set(&[0]));
    assert_eq!(mcu.rddp(0), rp);
    assert!((mcu.rddv(0) - rv).abs() < 1e-9);
    mcu.run(1);
    assert!((mcu.rdmcp(0) - 3_277).abs() < 400, "no jerk: {}", mcu.rdmcp(0));
    mcu.run(499);
    assert!((mcu.rdrp(0) - rp - rv * 500.0 * TA).abs() < 0.01, "{} mm after {rp}", mcu.rdrp(0));
    mcu.js(set(&[0]));
    mcu.run(500);
    assert!(mcu.stands() && mcu.rdrv(0).abs() < 0.2 && mcu.rdPosErr(0).abs() < 1e-3);
}

// shows: kernel.controller.profile-needs-closed-loop
// shows: kernel.controller.stepper-needs-closed-loop
#[test]
fn profiles_need_a_closed_loop() {
    for drive in [DriveKind::Servo, DriveKind::Stepper] {
        let mut mcu = booted(|m| m.axes.iter_mut().for_each(|a| a.drive = drive));
        start_line(&mut mcu, 10.0, 20.0);
        mcu.run(1000);
        assert_eq!(mcu.rdrp(0), 0.0);
        assert!(mcu.axst(0).has(Axst::dhef));
        mcu.cl(mcu.all_axes());
        start_line(&mut mcu, 10.0, 20.0);
        mcu.run(1000);
        assert!((mcu.rdrp(0) - 10.0).abs() < 1e-3);
    }
}

// shows: kernel.controller.position-hold, pcap.cl.pidf
#[test]
fn a_push_from_outside_is_corrected() {
    let mut mcu = closed();
    mcu.plant_mut(0).expect("a servo").push(0.05);
    mcu.run(1);
    assert!((mcu.rdPosErr(0) + 0.05).abs() < 0.01);
    mcu.run(300);
    assert!(mcu.rdPosErr(0).abs() <= 1.5e-4, "{}", mcu.rdPosErr(0));
}

// shows: pcap.ol, pcap.ol.output
#[test]
fn opening_the_loop_puts_out_zero() {
    let mut mcu = closed();
    start_line(&mut mcu, 100.0, 50.0);
    mcu.run(200);
    assert!(mcu.rdmcp(0) > 1000);
    mcu.ol(set(&[0]));
    assert_eq!((mcu.rdmcp(0), mcu.axst(0).has(Axst::cl)), (0, false));
    assert!(mcu.axst(1).has(Axst::cl));
    mcu.run(100);
    assert!(mcu.rdrv(0).abs() < 0.2);
}

// shows: pcap.rdf, pcap.rdf.defaults, pcap.uf, pcap.uf.together
#[test]
fn filter_coefficients_are_read_and_written_together() {
    let mut mcu = closed();
    assert_eq!(mcu.rdf(0), Machine::builtin().axes[0].pidf);
    let gains = PidfGains { kp: 0.1, ki: 0.2, kd: 0.003, kpl: 0.4, kfcv: 0.005, kfca: 0.00006 };
    assert!(mcu.uf(0, &gains));
    assert_eq!(mcu.rdf(0), gains);
    assert_eq!(mcu.rdf(1), Machine::builtin().axes[1].pidf);
}

// shows: kernel.pidf.kpl-range
#[test]
fn kpl_goes_from_0_to_1() {
    let mut mcu = closed();
    for (kpl, ok) in [(0.0, true), (1.0, true), (0.97, true), (-0.1, false), (1.1, false), (f64::NAN, false)] {
        assert_eq!(mcu.uf(0, &PidfGains { kp: 0.1, kpl, ..PidfGains::default() }), ok, "{kpl}");
    }
    assert_eq!(mcu.rdf(0).kpl, 0.97);
}

// shows: pcap.uf.any-time
#[test]
fn new_coefficients_count_during_a_profile() {
    let mut mcu = closed();
    start_line(&mut mcu, 100.0, 50.0);
    mcu.run(400);
    assert!(mcu.rdPosErr(0).abs() < 1e-3);
    let gains = PidfGains { kfcv: 0.0, kfca: 0.0, ..mcu.rdf(0) };
    mcu.uf(0, &gains);
    mcu.run(300);
    assert!((mcu.rdPosErr(0) - 1.0).abs() < 0.05, "50 mm/s / 50 per s without feed-forward: {}", mcu.rdPosErr(0));
}

// shows: kernel.controller.sample-time, pcap.rdsampletime, pcap.rdsampletime.ret-1
#[test]
fn the_sample_time_is_1280_microseconds() {
    assert_eq!(closed().rdSampleTime(), (1, 1280));
    assert_eq!(booted(|m| m.controller.sample_ticks = 10).rdSampleTime(), (1, 640));
}

// shows: kernel.controller.sample-cycle, pcap.rdrp, pcap.rdrp.any-time, pcap.rdrp.update
#[test]
fn each_sample_brings_a_new_position_and_output() {
    let mut mcu = closed();
    start_line(&mut mcu, 10.0, 50.0);
    mcu.run(20); // it accelerates for 39 samples
    for _ in 0..10 {
        let before = (mcu.rdrp(0), mcu.rdmcp(0));
        mcu.run(1);
        assert!(mcu.rdrp(0) > before.0 && mcu.rdmcp(0) != before.1);
    }
}

// shows: pcap.rddv, pcap.rdposerr, pcap.rddp.matches-rp, pcap.rddp, pcap.rddp.following-error
#[test]
fn set_point_velocity_and_following_error() {
    let mut mcu = closed();
    start_line(&mut mcu, 100.0, 50.0);
    mcu.run(400);
    assert!((mcu.rddv(0) - 50.0).abs() < 1e-9);
    assert!((mcu.rddp(0) - mcu.rdrp(0)).abs() < 1e-3);
    assert_eq!(mcu.rdPosErr(0), mcu.rddp(0) - mcu.rdrp(0));
}

// shows: pcap.rdaxst, pcap.rdaxstb, pcap.rdaxstb.one-based, pcap.rdaxstb.zero
#[test]
fn status_bits_are_counted_from_1() {
    let mut mcu = closed();
    for bitnr in 1..=32 {
        assert_eq!(mcu.rdaxstb(0, bitnr), (mcu.rdaxst(0).0 >> (bitnr - 1) & 1) as i32);
    }
    assert_eq!(mcu.rdaxstb(0, 13), 1, "pe");
    start_line(&mut mcu, 10.0, 20.0);
    mcu.run(10);
    assert_eq!([mcu.rdaxstb(0, 13), mcu.rdaxstb(0, 0), mcu.rdaxstb(0, 33)], [0; 3]);
}

// shows: axst.mpe, axst.mpe.runtime, pcap.rdmpe, pcap.wrmpe
#[test]
fn the_following_error_limit_changes_at_run_time() {
    let mut mcu = closed();
    mcu.uf(0, &PidfGains { kp: 0.6553, ..PidfGains::default() }); // 1 mm behind at 50 mm/s
    assert!(mcu.wrmpe(0, 1.5) && !mcu.wrmpe(0, -1.0));
    start_line(&mut mcu, 100.0, 50.0);
    mcu.run(500);
    assert!(!mcu.axst(0).has(Axst::mpe));
    mcu.wrmpe(0, 0.9);
    assert_eq!(mcu.rdmpe(0), 0.9);
    mcu.run(1);
    assert!(mcu.axst(0).has(Axst::mpe));
}

// shows: axst.ip, pcap.rdipw, pcap.wripw
#[test]
fn in_position_needs_profile_end_and_window() {
    let mut mcu = closed();
    mcu.uf(0, &PidfGains { kp: 0.6553, ..PidfGains::default() });
    assert!(mcu.wripw(0, 0.002));
    assert_eq!(mcu.rdipw(0), 0.002);
    start_line(&mut mcu, 10.0, 50.0);
    let mut seen = (false, false);
    for _ in 0..1000 {
        mcu.run(1);
        let near = mcu.rdPosErr(0).abs() < 0.002;
        let status = mcu.axst(0);
        assert_eq!(status.has(Axst::ip), status.has(Axst::pe) && near);
        seen = (seen.0 || status.has(Axst::pe) && !near, seen.1 || status.has(Axst::ip));
    }
    assert_eq!(seen, (true, true));
}

// shows: pcap.rptodp, pcap.rptodp.no-delay, pcap.rptodp.following-error
#[test]
fn rptodp_forgets_the_following_error_of_a_blocked_axis() {
    let mut mcu = closed();
    mcu.plant_mut(0).expect("a servo").block(true);
    start_line(&mut mcu, 5.0, 50.0);
    mcu.run(500);
    assert!(mcu.rdPosErr(0) > 4.9 && mcu.axst(0).has(Axst::mpe));
    mcu.RPtoDP(set(&[0]));
    assert_eq!(mcu.rdPosErr(0), 0.0);
    mcu.run(2); // the filter sees it
    mcu.plant_mut(0).expect("a servo").block(false);
    mcu.run(1);
    let speed = mcu.rdrv(0).abs();
    mcu.run(500);
    assert!(speed < 1.0 && mcu.rdrp(0).abs() < 1e-3, "{speed} mm/s, at {}", mcu.rdrp(0));
}

// shows: pcap.rptodp.not-in-profile
#[test]
fn rptodp_does_not_last_in_a_profile() {
    let mut mcu = closed();
    mcu.uf(0, &PidfGains { kp: 0.6553, ..PidfGains::default() });
    start_line(&mut mcu, 100.0, 50.0);
    mcu.run(500);
    let dp = mcu.rddp(0);
    mcu.RPtoDP(set(&[0]));
    mcu.run(1);
    assert!((mcu.rddp(0) - dp - 50.0 * TA).abs() < 1e-9);
}

// shows: pcap.rptodp.end-velocity
#[test]
fn rptodp_corrects_an_axis_that_runs_on() {
    let mut mcu = closed();
    mcu.uf(0, &PidfGains { kp: 0.6553, ..PidfGains::default() });
    line(&mut mcu, &[10.0, 0.0, 0.0], 50.0, 1000.0, 50.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(500);
    let (dp, rp) = (mcu.rddp(0), mcu.rdrp(0));
    assert!(dp - rp > 0.9);
    mcu.RPtoDP(set(&[0]));
    mcu.run(1);
    assert!((mcu.rddp(0) - rp - 50.0 * TA).abs() < 1e-9);
}

// shows: pcap.wrdp, pcap.wrdp.closed-loop-only, pcap.wrdp.step
#[test]
fn a_written_set_point_is_a_step_without_profile() {
    let mut mcu = booted(|_| ());
    assert!(!mcu.wrdp(0, 1.0));
    mcu.run(100);
    assert_eq!(mcu.rdrp(0), 0.0);
    mcu.cl(set(&[0]));
    assert!(mcu.wrdp(0, 10.0));
    mcu.run(1);
    assert_eq!(mcu.rdmcp(0), (0.6553_f64 * 100_000.0 / 2.0).round() as i32, "half at once, the lag of the filter");
    mcu.run(1);
    assert_eq!(mcu.rdmcp(0), 32_767, "all the drive can");
    mcu.run(1000);
    assert!((mcu.rdrp(0) - 10.0).abs() < 1e-3);
}

// shows: pcap.wrrp, pcap.wrrp.open-loop-only, pcap.wrrp.shifts-zero
#[test]
fn a_written_actual_position_shifts_the_zero_point() {
    let mut mcu = closed();
    mcu.set_referenced(set(&[0]));
    assert!(!mcu.wrrp(0, 7.0));
    assert_eq!(mcu.rdrp(0), 0.0);
    mcu.ol(set(&[0]));
    assert!(mcu.wrrp(0, 7.0));
    assert_eq!((mcu.rdrp(0), mcu.axst(0).has(Axst::referenced)), (7.0, false));
    mcu.cl(mcu.all_axes());
    start_line(&mut mcu, 8.0, 20.0);
    mcu.run(1000);
    assert!((mcu.rdrp(0) - 8.0).abs() < 1e-3, "one mm further");
    assert!((mcu.status().axes[0].load - 8.0).abs() < 1e-3);
}

// shows: pcap.rdsll, pcap.rdslr, pcap.wrsll, pcap.wrslr, pcap.wrsll.home-needed, pcap.shp.soft-limits-on-after
// shows: axst.lsls, axst.lsrs
#[test]
fn software_limits_change_at_run_time() {
    let mut mcu = closed();
    assert_eq!((mcu.rdsll(0), mcu.rdslr(0)), (Some(-600.0), Some(600.0)));
    assert!(mcu.wrsll(0, -5.0) && mcu.wrslr(0, 6.0));
    assert_eq!((mcu.rdsll(0), mcu.rdslr(0)), (Some(-5.0), Some(6.0)));
    start_line(&mut mcu, 7.0, 50.0);
    mcu.run(500);
    assert!(!mcu.axst(0).has(Axst::lsrs), "not referenced yet");
    mcu.set_referenced(set(&[0]));
    mcu.run(1);
    assert!(mcu.axst(0).has(Axst::lsrs));
    start_line(&mut mcu, -6.0, 50.0);
    mcu.run(1000);
    assert!(mcu.axst(0).has(Axst::lsls) && !mcu.axst(0).has(Axst::lsrs));
    assert!((mcu.rdrp(0) + 5.0).abs() < 0.01);
}

/// An axis that runs at 50 mm/s when its right limit at +10 has acted; speed of the load at every sample.
fn speeds_at_limit(function: LimitFunction) -> Vec<f64> {
    let mut machine = Machine::builtin();
    let limits = machine.axes[0].limits.as_mut().expect("limits");
    (limits.right, limits.function) = (10.0, function);
    let mut mcu = mcu_of(machine, ModeReg(0));
    mcu.set_referenced(mcu.all_axes());
    start_line(&mut mcu, 30.0, 50.0);
    mcu.run(800);
    start_line(&mut mcu, 0.0, 50.0);
    let mut before = mcu.status().axes[0].load;
    let step = |_| {
        mcu.run(1);
        let load = mcu.status().axes[0].load;
        let speed = (load - before) / TA;
        before = load;
        speed
    };
    (0..1000).map(step).collect()
}

// shows: limits.tom.leave-jump, limits.sma.jump
#[test]
fn leaving_a_limit_can_make_the_velocity_jump() {
    let most = |speeds: &[f64]| speeds.windows(2).map(|w| (w[1] - w[0]).abs() / TA).fold(0.0, f64::max);
    let without = most(&speeds_at_limit(LimitFunction::Off));
    assert!(without < 1300.0, "{without} mm/s2, programmed were 1000");
    for function in [LimitFunction::Tom, LimitFunction::Sma] {
        let acceleration = most(&speeds_at_limit(function));
        assert!(acceleration > 1.5 * without, "{function:?}: {acceleration} mm/s2, without limit {without}");
    }
}

// shows: pcap.ra, pcap.ra.open-loop, pcap.ra.positions-zero, pcap.ra.soft-limits, pcap.ra.keeps-system-data
#[test]
fn ra_resets_the_selected_axes() {
    let mut mcu = closed();
    mcu.set_referenced(mcu.all_axes());
    let (gains, parameters) = (mcu.rdf(0), *mcu.parameters(0));
    mcu.wrslr(0, 4.0);
    start_line(&mut mcu, 3.0, 50.0);
    mcu.run(30);
    mcu.ra(set(&[0]));
    let status = mcu.axst(0);
    assert!(!status.any(Axst::cl | Axst::referenced) && mcu.axst(1).has(Axst::cl | Axst::referenced));
    assert_eq!((mcu.rdmcp(0), mcu.rdrp(0), mcu.rddp(0)), (0, 0.0, 0.0));
    assert_eq!((mcu.rdf(0), mcu.parameters(0).maxacc, mcu.rdslr(0)), (gains, parameters.maxacc, Some(4.0)));
    mcu.cl(set(&[0]));
    start_line(&mut mcu, 6.0, 50.0);
    mcu.run(500);
    assert!(!mcu.axst(0).has(Axst::lsrs) && mcu.rdrp(0) > 5.9, "limits are not watched before shp");
}

// shows: pcap.rs, pcap.rs.command-output, pcap.rs.open-loop, pcap.rs.soft-limits, pcap.rs.keeps-system-data
// shows: errorreg.sticky
#[test]
fn rs_resets_the_system() {
    let mut mcu = closed();
    mcu.set_referenced(mcu.all_axes());
    line(&mut mcu, &[1.0, 0.0, 0.0], 0.0, 1000.0, 0.0);
    assert!(mcu.errorreg().has(ErrorReg::VelocityZero));
    mcu.wrmpe(0, 0.7);
    let gains = mcu.rdf(0);
    start_line(&mut mcu, 50.0, 50.0);
    mcu.run(100);
    mcu.ra(set(&[1]));
    mcu.rs();
    for a in 0..3 {
        assert_eq!((mcu.rdmcp(a), mcu.axst(a).any(Axst::cl | Axst::referenced)), (0, false));
    }
    assert_eq!((mcu.rdmpe(0), mcu.rdf(0)), (0.7, gains));
    assert!(mcu.errorreg().has(ErrorReg::VelocityZero), "only writing 0 clears it");
    mcu.clear_errorreg();
    assert_eq!(mcu.errorreg(), ErrorReg(0));
}

#[test]
fn positions_beyond_all_counts_do_not_panic() {
    for drive in [DriveKind::Servo, DriveKind::Stepper] {
        let mut mcu = booted(|m| m.axes.iter_mut().for_each(|a| a.drive = drive));
        mcu.wrrp(0, -1e300);
        mcu.wrmcp(0, 1);
        mcu.run(2);
        mcu.cl(mcu.all_axes());
        mcu.wrdp(0, 1e300);
        mcu.run(3);
        mcu.wrdp(0, -1e300);
        mcu.run(3);
        mcu.ra(mcu.all_axes());
        mcu.run(2);
        assert_eq!(mcu.rddp(0), 0.0);
    }
}

// shows: ssf.1200-1207
#[test]
fn a_spooled_function_writes_the_motor_command_of_an_open_axis() {
    let mut mcu = booted(|_| ());
    mcu.cl(set(&[0]));
    line(&mut mcu, &[5.0], 50.0, 1000.0, 0.0);
    assert_eq!(mcu.ssf(0, 1202, -1234.9, 1), Entered::Yes);
    assert_eq!(mcu.ssf(0, 1207, 500.0, 1), Entered::Yes, "an axis that this machine lacks");
    assert_eq!(mcu.ssf(0, 1208, 500.0, 1), Entered::Discarded);
    mcu.ssms(set(&[0]));
    mcu.run(20);
    assert_eq!(mcu.rdmcp(2), 0, "in step with motion");
    mcu.run(500);
    assert_eq!((mcu.rdmcp(1), mcu.rdmcp(2)), (0, -1234));
    assert!(mcu.rdrp(2) < -1.0);
}
