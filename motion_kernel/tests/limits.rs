//! Software limits (chapter 2.4): TOM, SMA, SMD.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::machine::{LimitFunction, Machine};
use motion_kernel::registers::{Axst, ModeReg};
use motion_kernel::trace::Trace;

/// A servo axis X that runs at 50 mm/s to +20 with its right limit at +10, until `samples` have passed.
fn overrun(function: LimitFunction, referenced: bool, samples: u64) -> (Mcu, Trace) {
    let mut machine = Machine::builtin();
    machine.axes.truncate(1);
    let limits = machine.axes[0].limits.as_mut().expect("mill3 has limits");
    (limits.left, limits.right, limits.function) = (-10.0, 10.0, function);
    let mut mcu = mcu_of(machine, ModeReg(0));
    if referenced {
        mcu.set_referenced(mcu.all_axes());
    }
    line(&mut mcu, &[20.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    let mut trace = Trace::default();
    for _ in 0..samples {
        mcu.run(1);
        let axis = mcu.status().axes[0];
        trace.dp.push(axis.dp);
        trace.load.push(axis.load);
    }
    (mcu, trace)
}

// shows: limits.sma.hold, limits.sma.internal-continues, limits.software, limits.software-function, limits.status-axst
#[test]
fn sma_holds_the_axis_at_the_limit_while_the_profile_runs_on() {
    let (mcu, trace) = overrun(LimitFunction::Sma, true, 600);
    assert!(mcu.axst(0).has(Axst::lsrs | Axst::pe), "the profile ended as without the limit");
    assert!(trace.dp.iter().all(|dp| *dp <= 10.0));
    assert!((trace.load[599] - 10.0).abs() < 0.01);
}

// shows: limits.state-cleared-on-return
#[test]
fn the_limit_state_ends_on_return() {
    for (target, bit) in [(-20.0, Axst::lsls), (20.0, Axst::lsrs)] {
        let (mut mcu, _) = overrun(LimitFunction::Sma, true, 600);
        line(&mut mcu, &[target], 50.0, 1000.0, 0.0);
        line(&mut mcu, &[0.0], 50.0, 1000.0, 0.0);
        mcu.ssms(mcu.all_axes());
        mcu.run(3000);
        assert!(!mcu.axst(0).any(Axst::lsls | Axst::lsrs), "{bit:?}");
        assert!(mcu.status().axes[0].dp.abs() < 1e-3);
    }
}

// shows: limits.tom.motor-off, limits.tom.profile-continues
#[test]
fn tom_switches_the_motor_off_towards_the_limit() {
    let (mcu, trace) = overrun(LimitFunction::Tom, true, 600);
    assert!(mcu.axst(0).has(Axst::lsrs));
    assert!((trace.dp[599] - 20.0).abs() < 1e-9, "the set point runs on");
    assert!(trace.load[599] > 10.0 && trace.load[599] < 10.5, "the axis coasts: {}", trace.load[599]);
}

// shows: limits.tom.only-away
#[test]
fn from_a_tom_limit_the_axis_drives_away() {
    let (mut mcu, _) = overrun(LimitFunction::Tom, true, 600);
    line(&mut mcu, &[5.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(1500);
    assert!((mcu.status().axes[0].load - 5.0).abs() < 0.01);
}

// shows: limits.smd.decelerate, limits.smd.direct-mode, pcap.wrsdec.soft-limits
#[test]
fn smd_brakes_with_sdec_and_empties_the_spooler() {
    let (mcu, trace) = overrun(LimitFunction::Smd, true, 600);
    let sdec = mcu.parameters(0).sdec;
    let brake = 50.0 * 50.0 / (2.0 * sdec);
    let end = trace.dp[599];
    assert!(end > 10.0 && (end - 10.0 - brake).abs() <= 2.0 * 50.0 * TA, "stands at {end}");
    assert_eq!(mcu.status().axes[0].mcis, 0);
    assert!(mcu.axst(0).has(Axst::lsrs | Axst::pe));
}

// shows: limits.smd.no-further, limits.smd.leave
#[test]
fn from_an_smd_limit_the_axis_only_leaves() {
    let (mut mcu, _) = overrun(LimitFunction::Smd, true, 600);
    let before = mcu.status().axes[0].dp;
    line(&mut mcu, &[before + 5.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(600);
    assert!(mcu.status().axes[0].dp - before < 0.1);
    line(&mut mcu, &[0.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(1500);
    assert!(mcu.status().axes[0].dp.abs() < 1e-3);
}

// shows: axst.lsrs.conditions, axst.lsls.conditions, pcap.shp.soft-limits-off-before
#[test]
fn limits_are_watched_only_when_referenced_and_configured() {
    for (function, referenced) in [(LimitFunction::Sma, false), (LimitFunction::Off, true)] {
        let (mcu, trace) = overrun(function, referenced, 600);
        assert!((trace.dp[599] - 20.0).abs() < 1e-9);
        assert!(!mcu.axst(0).has(Axst::lsrs));
    }
}

// shows: limits.state-cleared-by-cl
#[test]
fn closing_the_loop_clears_the_state() {
    let (mut mcu, _) = overrun(LimitFunction::Sma, true, 600);
    let all = mcu.all_axes();
    mcu.cl(all);
    assert!(!mcu.axst(0).has(Axst::lsrs));
    mcu.run(10);
    assert!(!mcu.axst(0).has(Axst::lsrs), "the held position lies inside");
}
