//! Stops: `ms` for some axes of a group, S-shaped stops, commands while the system stops axes.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::machine::{LimitFunction, SoftwareLimits};
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use motion_kernel::trace::Trace;
use motion_kernel::trajectory::{Hmp3d, Lmp};

/// Cruising at 20 mm/s on a circle of 30 mm around (30, 0), Z going along; ac 100.
fn on_a_circle(modereg: ModeReg) -> Mcu {
    let mut m = mcu("XYZ", modereg);
    arc(&mut m, [30.0, 0.0], 360.0, &[5.0], 20.0, 100.0, 0.0);
    m.ssms(set(&[0, 1, 2]));
    m.run(1000);
    m
}

// shows: pcap.ms.on-circle, pcap.ms.direction-kept
#[test]
fn some_axes_of_a_group_brake_on_their_share_of_the_path() {
    let mut m = on_a_circle(EXACT);
    let whole = {
        let mut whole = on_a_circle(EXACT);
        whole.ms(set(&[0, 1, 2]));
        let mut trace = Trace::default();
        whole.pass(400, &mut trace);
        trace
    };
    m.ms(set(&[0, 1]));
    let mut trace = Trace::default();
    m.pass(400, &mut trace);
    assert_eq!((dp(&trace, 0), dp(&trace, 1)), (dp(&whole, 0), dp(&whole, 1)), "X and Y as if all had stopped");
    assert!(dp(&trace, 0).iter().zip(dp(&trace, 1)).all(|(x, y)| ((x - 30.0).hypot(y) - 30.0).abs() < 1e-9));
    let z = dp(&trace, 2);
    assert!(z[399] > z[398], "Z goes on");
    assert!((0..3).all(|a| m.axst(a).has(Axst::saf)), "and that is asynchronous");
    record(&mut m);
    assert_eq!(m.rddp(2), 5.0);
    // the next command starts where they stand
    assert_eq!(line(&mut m, &[0.0, 0.0, 0.0], 20.0, 100.0, 0.0), Entered::Yes);
    run(&mut m);
    assert_eq!([m.rddp(0), m.rddp(1), m.rddp(2)], [0.0; 3]);
}

#[test]
fn alone_an_axis_may_brake_beyond_the_end_of_its_move() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[6.0, 8.0], 20.0, 400.0, 20.0);
    line(&mut m, &[12.0, 16.0], 20.0, 400.0, 0.0);
    m.ssms(set(&[0, 1]));
    while m.rddp(0) < 5.9 {
        m.run(1);
    }
    let at = m.rddp(0);
    m.ms(set(&[0]));
    record(&mut m);
    close(m.rddp(0), at + 0.6 * 400.0 / 800.0, 1e-9); // 20²/(2·400) of path, 0.6 of it in X
    assert_eq!(m.rddp(1), 16.0);
}

/// Speeds of X from a stop on, and where it stands.
fn stop(modereg: ModeReg, jerkrel: f64, stop: impl Fn(&mut Mcu)) -> (Vec<f64>, f64) {
    let mut m = mcu("X", modereg);
    m.parameters_mut(0).jerkrel = jerkrel;
    m.parameters_mut(0).sdec = 100.0;
    line(&mut m, &[100.0], 20.0, 100.0, 0.0);
    m.ssms(set(&[0]));
    m.run(1000);
    let before = m.rddp(0);
    stop(&mut m);
    let mut trace = Trace::default();
    m.pass(200, &mut trace);
    assert!(m.stands());
    (speeds(&trace, 0, before), m.rddp(0) - before)
}

// shows: modereg.s-profile
#[test]
fn with_the_s_profile_stops_are_s_shaped_too() {
    for kind in 0..3 {
        let act = |m: &mut Mcu| match kind {
            0 => m.ms(set(&[0])),
            1 => m.js(set(&[0])),
            _ => m.hold(),
        };
        let (trapezoid, way) = stop(EXACT, 1.0, act);
        let (shaped, shaped_way) = stop(EXACT | ModeReg::SProfile, 1.0, act);
        close(way, 2.0, 1e-9);
        close(shaped_way, 2.0, 1e-9);
        let steepest = |v: &[f64]| v.windows(2).map(|w| (w[0] - w[1]) / TA).fold(0.0, f64::max);
        close(steepest(&trapezoid), 100.0, 0.1);
        close(steepest(&shaped), 200.0, 3.0); // a (1 + jerkrel)
        assert!((20.0 - shaped[5]) < (20.0 - trapezoid[5]) / 4.0, "it begins gently");
        let moving = |v: &[f64]| v.iter().filter(|v| v.abs() > 1e-9).count();
        assert_eq!(moving(&trapezoid), moving(&shaped), "in the same time");
        let (flat, _) = stop(EXACT | ModeReg::SProfile, 0.0, act);
        assert_eq!(flat, trapezoid, "jerkrel 0: a trapezoid");
    }
}

#[test]
fn an_endless_jog_has_s_shaped_ramps_too() {
    let steepest = |modereg: ModeReg| {
        let mut m = mcu("X", modereg);
        m.parameters_mut(0).jvl = -20.0;
        m.ja(&AxisList::new(&[0]), &[5.0]);
        let mut trace = Trace::default();
        m.pass(100, &mut trace);
        close(m.rddv(0), -20.0, 1e-9);
        speeds(&trace, 0, 0.0).windows(2).map(|w| (w[0] - w[1]) / TA).fold(0.0, f64::max)
    };
    close(steepest(EXACT), 500.0, 1e-6);
    close(steepest(EXACT | ModeReg::SProfile), 1000.0, 40.0);
}

fn at_a_limit() -> Mcu {
    let mut machine = machine("XYZ");
    machine.axes[0].limits = Some(SoftwareLimits { left: -1.0, right: 10.0, function: LimitFunction::Smd });
    machine.axes[0].stop_deceleration = 100.0;
    let mut m = mcu_of(machine, EXACT);
    m.set_referenced(set(&[0, 1, 2]));
    line(&mut m, &[50.0, 50.0], 20.0, 400.0, 0.0);
    m.ssms(set(&[0, 1]));
    while !m.axst(0).has(Axst::lsrs) {
        m.run(1);
    }
    m
}

// shows: errorreg.spooler-load
#[test]
fn while_the_system_brakes_an_axis_nothing_is_spooled_for_it() {
    let mut m = at_a_limit();
    m.run(5);
    assert!(m.rddv(0) > 0.0, "the limit brakes it");
    assert_eq!(line(&mut m, &[0.0, 0.0], 20.0, 400.0, 0.0), Entered::Discarded);
    assert_eq!(m.errorreg(), ErrorReg::SpoolerLoadError);
    let circle = Hmp3d { ac: 1.0, vl: 1.0, phi: 90.0, dtca1: 1.0, pn3: 1.0, ..Hmp3d::default() };
    assert_eq!(m.smca3d(&AxisList::new(&[0, 1, 2]), &circle), Entered::Discarded);
    m.clear_errorreg();
    let mut lmp = Lmp { ac: 100.0, vl: 10.0, ..Lmp::default() };
    lmp.dtm[2] = 1.0;
    assert_eq!(m.smla(&AxisList::new(&[2]), &lmp), Entered::Yes, "other axes are not concerned");
    m.run(500);
    assert_eq!(line(&mut m, &[0.0, 0.0], 20.0, 400.0, 0.0), Entered::Yes, "once it stands");
    assert_eq!(m.errorreg().0 & ErrorReg::SpoolerLoadError.0, 0);
    // a stop by command is none by the system
    let mut m = at_a_limit();
    m.js(set(&[0, 1]));
    m.run(2);
    assert_eq!(line(&mut m, &[0.0, 0.0], 20.0, 400.0, 0.0), Entered::Yes);
}

// shows: axst.saf.reset, pcap.ra.override, pcap.wrjovr.reset, pcap.ra.spooler
#[test]
fn ra_clears_saf_overrides_and_spoolers() {
    let broken = || {
        let mut m = mcu("XY", EXACT);
        for n in 1..=20 {
            line(&mut m, &[f64::from(n) * 2.0, f64::from(n)], 20.0, 200.0, if n < 20 { 20.0 } else { 0.0 });
        }
        m.ssms(set(&[0, 1]));
        m.wrtrovr(0.8);
        m.utrovr(set(&[0, 1]));
        m.run(200);
        m.wrjovr(0, 0.5);
        m.run(20);
        assert!(m.axst(0).has(Axst::saf) && m.axst(1).has(Axst::saf));
        m
    };
    let mut m = broken();
    m.ra(set(&[0]));
    assert!(!m.axst(0).has(Axst::saf) && m.axst(1).has(Axst::saf), "of the axes selected");
    assert_eq!((m.rdjovr(0), m.rdjovr(1)), (1.0, 0.8));
    assert_eq!(m.status().trovr, 0.8, "TROVR itself stays");
    assert_eq!((m.status().axes[0].mcis, m.status().axes[0].lsm), (0, m.status().axes[0].memory));
    assert!(m.status().axes[1].mcis > 0);
    // the effective trajectory override is 1 again
    m.ra(set(&[1]));
    m.cl(set(&[0, 1]));
    line(&mut m, &[20.0, 20.0], 10.0, 200.0, 0.0);
    m.ssms(set(&[0, 1]));
    m.run(200);
    close(m.status().path_v * m.status().factor, 10.0, 1e-9);
    for reset in 0..3 {
        let mut m = broken();
        match reset {
            0 => m.cl(set(&[0, 1])),
            1 => m.rs(),
            _ => m = Mcu::new(m.machine().clone()),
        }
        assert!(!m.axst(0).has(Axst::saf) && !m.axst(1).has(Axst::saf), "{reset}");
        let jovr = if reset == 0 { 0.5 } else { 1.0 };
        assert_eq!(m.rdjovr(0), jovr);
    }
}

#[test]
fn the_velocity_shown_as_programmed_is_that_of_the_command() {
    let mut m = mcu("XYZ", LOOKAHEAD);
    (0..2).for_each(|a| m.parameters_mut(a).maxacc = 10.0);
    arc(&mut m, [10.0, 0.0], 90.0, &[], 40.0, 1000.0, 0.0);
    m.ssms(set(&[0, 1]));
    m.run(500);
    let status = m.status();
    close(status.programmed_v, 40.0, 0.0);
    close(status.path_v, 10.0, 1e-9);
}
