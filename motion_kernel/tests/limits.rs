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

/// mill3 with one input of a function for X at input 3, closed, on its way to X+30 at 50 mm/s.
fn switched(function: &str, inverted: bool) -> Mcu {
    let text = format!(
        "{}\n[[input]]\nnumber = 3\naxis = \"X\"\nfunction = \"{function}\"\ninverted = {inverted}\n",
        motion_kernel::machine::BUILTIN
    );
    let mut mcu = mcu_of(Machine::parse(text.as_bytes()).expect("valid"), ModeReg(0));
    mcu.set_inputs(if inverted { 0xffff } else { 0 });
    line(&mut mcu, &[30.0, 0.0, 0.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu
}
const INPUT_3: u32 = 1 << 2;

// shows: limits.hardware-inputs, axst.lslh, axst.lsrh, axst.eo, axst.dnr, axst.ui, pcap.rddigi, pcap.rddigi.invert
// shows: pcap.rddigib, pcap.rddigib.one-based
#[test]
fn status_bits_follow_their_inputs() {
    for (function, bit, when) in [
        ("LSL_TOM", Axst::lslh, true),
        ("LSL_SMA", Axst::lslh, true),
        ("LSL_SMD", Axst::lslh, true),
        ("LSR_TOM", Axst::lsrh, true),
        ("LSR_SMA", Axst::lsrh, true),
        ("LSR_SMD", Axst::lsrh, true),
        ("EO", Axst::eo, true),
        ("DR", Axst::dnr, false),
        ("UI", Axst::ui, true),
        ("REF", Axst::refh, true),
    ] {
        for inverted in [false, true] {
            let mut mcu = switched(function, inverted);
            for active in [false, true, false] {
                mcu.set_inputs(if active != inverted { INPUT_3 } else { 0 });
                mcu.run(1);
                assert_eq!(mcu.rddigi(0) & INPUT_3 != 0, active);
                assert_eq!((mcu.rddigib(0, 3), mcu.rddigib(0, 2)), (i32::from(active), 0));
                assert_eq!(mcu.axst(0).has(bit), active == when, "{function} {active}");
                assert!(!mcu.axst(1).has(bit), "only for its axis");
            }
        }
    }
}

// shows: limits.hardware-function, pcap.wrsdec.hard-limits
#[test]
fn an_smd_switch_brakes_with_sdec() {
    let mut mcu = switched("LSR_SMD", false);
    mcu.run(200);
    let from = mcu.rddp(0);
    mcu.set_inputs(INPUT_3);
    mcu.run(400);
    let brake = 50.0 * 50.0 / (2.0 * mcu.parameters(0).sdec);
    assert!((mcu.rddp(0) - from - brake).abs() <= 2.0 * 50.0 * TA, "{} from {from}", mcu.rddp(0));
    assert_eq!(mcu.status().axes[0].mcis, 0);
}

#[test]
fn a_second_stop_while_an_axis_brakes_changes_nothing() {
    let course = |stops: usize| {
        let mut mcu = switched("LSR_SMD", false);
        mcu.run(200);
        (0..stops).for_each(|_| mcu.js(set(&[0])));
        let mut course = Vec::new();
        for _ in 0..100 {
            mcu.run(1);
            course.push(mcu.rddp(0));
        }
        course
    };
    let (once, twice) = (course(1), course(2));
    assert!(once.iter().zip(&twice).all(|(a, b)| (a - b).abs() < 1e-12) && once[99] > once[0] + 0.5);
}

#[test]
fn a_jog_into_an_smd_switch_is_braked() {
    let mut mcu = switched("LSR_SMD", false);
    mcu.run(2000);
    mcu.ja(&motion_kernel::axes::AxisList::new(&[0]), &[200.0]);
    mcu.run(500);
    let from = mcu.rddp(0);
    assert!(from > 40.0);
    mcu.set_inputs(INPUT_3);
    mcu.run(500);
    assert!(mcu.stands() && mcu.rddp(0) - from < 5.0, "{} from {from}", mcu.rddp(0));
}

#[test]
fn an_sma_switch_holds_until_the_profile_comes_back() {
    let mut mcu = switched("LSR_SMA", false);
    mcu.run(200);
    let at = mcu.rddp(0);
    mcu.set_inputs(INPUT_3);
    mcu.run(600);
    assert!((mcu.rddp(0) - at).abs() <= 50.0 * TA + 1e-9 && (mcu.rdrp(0) - mcu.rddp(0)).abs() < 1e-3);
    line(&mut mcu, &[0.0, 0.0, 0.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(1000);
    assert!(mcu.axst(0).has(Axst::lsrh) && mcu.rdrp(0).abs() < 1e-3, "away from the switch it may go");
}

#[test]
fn a_tom_switch_cuts_the_motor_towards_it_only() {
    let mut mcu = switched("LSR_TOM", false);
    mcu.run(200);
    let at = mcu.rdrp(0);
    mcu.set_inputs(INPUT_3);
    mcu.run(600);
    assert!(mcu.rdrp(0) - at < 0.5 && (mcu.rddp(0) - 30.0).abs() < 1e-9);
    line(&mut mcu, &[0.0, 0.0, 0.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(1000);
    assert!(mcu.rdrp(0).abs() < 0.05, "{}: it may go away, but not be pulled back", mcu.rdrp(0));
    mcu.set_inputs(0);
    mcu.run(1);
    assert!(!mcu.axst(0).has(Axst::lsrh));
}
