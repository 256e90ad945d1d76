//! Motor command port, SimulationMode, drives without power, blocked axes, cut encoders, steppers with encoder
//! verification (2.1, 4.4.67, 4.4.88, 4.4.162, 6.3.1.5).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::machine::{DriveControl, Encoder, Machine, Port};
use motion_kernel::registers::{Axst, Digi, ErrorReg, ModeReg};
use std::sync::Arc;

fn booted(change: impl Fn(&mut Machine)) -> Mcu {
    let mut machine = Machine::builtin();
    change(&mut machine);
    Mcu::new(Arc::new(machine))
}
fn closed(change: impl Fn(&mut Machine)) -> Mcu {
    let mut mcu = booted(change);
    mcu.cl(mcu.all_axes());
    mcu
}
fn start(mcu: &mut Mcu, x: f64) {
    line(mcu, &[x, 0.0, 0.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
}

// shows: pcap.wrmcp.servo-invert
#[test]
fn an_inverted_output_turns_the_motor_round() {
    let mut mcu = booted(|m| m.axes[0].equipment.port.inverted = true);
    mcu.wrmcp(0, 3_277);
    mcu.run(500);
    assert_eq!(mcu.rdmcp(0), 3_277, "as written");
    assert!(mcu.rdrp(0) < -1.0 && mcu.rdrv(0) < 0.0);
    // wired the other way round, the loop needs the inversion
    let end = |inverted, reversed| {
        let mut mcu = closed(|m| {
            m.axes[0].equipment.port.inverted = inverted;
            m.axes[0].plant.reversed = reversed;
        });
        start(&mut mcu, 5.0);
        mcu.run(1000);
        (mcu.rdrp(0) - 5.0).abs() < 1e-3
    };
    assert_eq!([end(false, false), end(true, true), end(true, false), end(false, true)], [true, true, false, false]);
}

#[test]
fn the_motor_command_keeps_its_limits() {
    let mut mcu = closed(|m| (m.axes[0].equipment.port.max, m.axes[0].equipment.port.min) = (5_000.0, -2_000.0));
    mcu.ol(set(&[0]));
    assert_eq!(mcu.rdmcp(0), 0);
    for (written, read) in [(4_000, 4_000), (9_000, 5_000), (-9_000, -2_000)] {
        mcu.wrmcp(0, written);
        assert_eq!(mcu.rdmcp(0), read);
    }
    mcu.wrmcp(0, 0);
    mcu.cl(set(&[0]));
    let extremes = |mcu: &mut Mcu, x: f64| {
        mcu.wrdp(0, x);
        let range = (0..200).map(|_| {
            mcu.run(1);
            mcu.rdmcp(0)
        });
        let commands: Vec<i32> = range.collect();
        (commands.iter().copied().min(), commands.iter().copied().max())
    };
    assert_eq!(extremes(&mut mcu, 20.0).1, Some(5_000));
    assert_eq!(extremes(&mut mcu, -20.0).0, Some(-2_000));
}

#[test]
fn zero_compensation_is_added_to_either_side() {
    let command = |positive: f64, negative: f64, x: f64| {
        let mut mcu = closed(|m| {
            let port = &mut m.axes[0].equipment.port;
            (port.positive, port.negative) = (positive, negative);
            (m.axes[0].pidf.kfcv, m.axes[0].pidf.kfca) = (0.0, 0.0);
        });
        mcu.block(0, true);
        mcu.wrdp(0, x);
        mcu.run(100);
        mcu.rdmcp(0)
    };
    let (plus, minus) = (command(0.0, 0.0, 0.1), command(0.0, 0.0, -0.1));
    assert_eq!(command(300.0, 70.0, 0.1), plus + 300);
    assert_eq!(command(300.0, 70.0, -0.1), minus - 70);
    assert_eq!(command(300.0, 70.0, 0.0), 0);
}

// shows: errorreg.limit-def, sysparam.ERRORREG.bit-14-LimitDefError
#[test]
fn invalid_limits_of_the_motor_command_set_an_error() {
    let good = Port { max: 20_000.0, min: -10_000.0, positive: 100.0, negative: 50.0, inverted: false };
    let mut mcu = booted(|_| ());
    assert!(mcu.set_port(0, &good));
    assert_eq!((mcu.port(0), mcu.errorreg()), (good, ErrorReg(0)));
    let bad = [
        Port { max: f64::NAN, ..good },
        Port { max: 40_000.0, ..good },
        Port { min: f64::NEG_INFINITY, ..good },
        Port { min: 30_000.0, ..good },
        Port { positive: -1.0, ..good },
        Port { negative: f64::NAN, ..good },
    ];
    for port in bad {
        mcu.clear_errorreg();
        assert!(!mcu.set_port(0, &port), "{port:?}");
        assert_eq!(mcu.errorreg(), ErrorReg::LimitDefError);
        assert_eq!(mcu.port(0), good, "the one before stays");
    }
}

#[test]
fn in_simulation_mode_the_axis_stands_and_its_position_follows() {
    let mut mcu = closed(|_| ());
    mcu.set_modereg(ModeReg::SimulationMode);
    start(&mut mcu, 30.0);
    for _ in 0..1000 {
        let before = mcu.rddp(0);
        mcu.run(1);
        close(mcu.rdrp(0), before, 0.6e-4);
        assert_eq!(mcu.rdmcp(0), 0);
        assert_eq!(mcu.machine_position(0), 0.0);
    }
    assert!(mcu.axst(0).has(Axst::pe | Axst::ip) && !mcu.axst(0).has(Axst::mpe));
    close(mcu.rdrp(0), 30.0, 1e-9);
    mcu.set_modereg(ModeReg(0));
    mcu.run(1);
    close(mcu.rdrp(0), 0.0, 0.0);
}

#[test]
fn a_stepper_is_simulated_without_pulses() {
    let mut mcu = mcu("X", ModeReg::SimulationMode | ModeReg::ExactTargetPos);
    line(&mut mcu, &[3.0], 20.0, 500.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(500);
    assert_eq!((mcu.rdrp(0), mcu.rdmcp(0), mcu.machine_position(0)), (3.0, 0, 0.0));
}

#[test]
fn a_drive_without_power_runs_out() {
    let mut mcu = closed(|m| m.axes[0].plant.coast_s = 0.2);
    start(&mut mcu, 200.0);
    mcu.run(500);
    let (place, speed) = (mcu.machine_position(0), mcu.rdrv(0));
    close(speed, 50.0, 0.2);
    mcu.drop_drive(0, true);
    mcu.run(2000);
    close(mcu.machine_position(0), place + 50.0 * 0.2, 0.1);
    assert!(mcu.axst(0).has(Axst::mpe), "seen as following error");
    let mut mcu = closed(|m| {
        m.axes[0].plant.control = DriveControl::Torque;
        (m.axes[0].plant.full_acceleration, m.axes[0].plant.friction) = (8000.0, 250.0);
        m.axes[0].mpe = 1e6;
    });
    mcu.ol(set(&[0]));
    mcu.wrmcp(0, 8_000);
    mcu.run(20);
    // rv is the mean of the last sample
    let acceleration = 8000.0 * 8000.0 / 32_767.0 - 250.0;
    let (place, speed) = (mcu.machine_position(0), mcu.rdrv(0) + acceleration * TA / 2.0);
    mcu.drop_drive(0, true);
    mcu.run(2000);
    close(mcu.machine_position(0), place + speed * speed / 500.0, 0.01);
}

// shows: digi.bit17, digi.bit20, digi.bit21, digi.bit22, digi.bit23, pcap.rddigib.18, pcap.rddigib.21
// shows: pcap.rddigib.22, pcap.rddigib.23, pcap.rddigib.24
#[test]
fn a_cut_encoder_raises_its_alarms() {
    let mut mcu = closed(|_| ());
    start(&mut mcu, 50.0);
    mcu.run(200);
    let rp = mcu.rdrp(0);
    mcu.cut_encoder(0, true);
    mcu.run(50);
    assert_eq!(mcu.rdrp(0), rp, "no counts any more");
    assert!(mcu.machine_position(0) > rp + 1.0, "the axis goes on");
    let alarms = Digi::error | Digi::AEA | Digi::AEB | Digi::AEN | Digi::AES;
    assert_eq!(mcu.rddigi(0) & !0xffff, alarms.0);
    assert_eq!([18, 21, 22, 23, 24].map(|bitnr| mcu.rddigib(0, bitnr)), [1; 5]);
    assert_eq!([18, 21, 22, 23, 24].map(|bitnr| mcu.rddigib(1, bitnr)), [0; 5]);
    mcu.cut_encoder(0, false);
    mcu.run(1);
    assert_eq!(mcu.rddigi(0) & !0xffff, Digi::error.0, "the error stays until rdigi");
    assert!((mcu.rdrp(0) - rp).abs() < 1.0, "what passed meanwhile is lost: {}", mcu.rdrp(0));
}

#[test]
fn a_blocked_stepper_loses_its_steps() {
    let mut machine = machine("X");
    machine.axes[0].equipment.encoder = Some(Encoder { counts_per_unit: 20_000.0, feedback: false });
    let mut mcu = mcu_of(machine, ModeReg(0));
    mcu.wrgfaux(0, 0.5); // 10000 steps, 20000 counts
    line(&mut mcu, &[10.0], 20.0, 500.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(200);
    close(mcu.encoder_counts(0) as f64 * mcu.rdgfaux(0), mcu.rdrp(0) * 10_000.0, 1.0);
    mcu.block(0, true);
    mcu.run(100);
    mcu.block(0, false);
    mcu.run(500);
    close(mcu.rdrp(0), 10.0, 1e-9);
    let lost = mcu.rdrp(0) - mcu.machine_position(0);
    close(lost, 20.0 * 100.0 * TA, 0.05);
    close(mcu.encoder_counts(0) as f64 * 0.5, (10.0 - lost) * 10_000.0, 1.0);
    assert!(!mcu.axst(0).has(Axst::mpe), "without feedback from the encoder nobody notices");
}

#[test]
fn encoder_feedback_shows_lost_steps_as_following_error() {
    let mut machine = machine("X");
    machine.axes[0].equipment.encoder = Some(Encoder { counts_per_unit: 20_000.0, feedback: true });
    machine.axes[0].mpe = 0.5;
    let mut mcu = mcu_of(machine, ModeReg(0));
    mcu.wrgfaux(0, 0.5);
    line(&mut mcu, &[10.0], 20.0, 500.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(200);
    assert!(!mcu.axst(0).has(Axst::mpe) && mcu.rdPosErr(0).abs() < 0.05);
    mcu.block(0, true);
    mcu.run(100);
    assert!(mcu.axst(0).has(Axst::mpe) && mcu.rdPosErr(0) > 0.5);
    mcu.block(0, false);
    // overlaid control by the application (table 37, dpoffset): the lost steps are made up
    mcu.run(500);
    mcu.wrdpoffset(0, mcu.rdPosErr(0));
    mcu.run(10);
    close(mcu.machine_position(0), 10.0, 2e-4);
}

// shows: pcap.rptodp.following-error
#[test]
fn a_blocked_axis_is_recovered_by_rptodp() {
    let mut mcu = closed(|_| ());
    mcu.block(0, true);
    start(&mut mcu, 5.0);
    mcu.run(500);
    assert!(mcu.axst(0).has(Axst::mpe) && (mcu.rdPosErr(0) - 5.0).abs() < 1e-3);
    mcu.RPtoDP(set(&[0]));
    mcu.block(0, false);
    mcu.run(100);
    assert!(mcu.machine_position(0).abs() < 1e-3 && mcu.rdPosErr(0).abs() < 1e-3, "no jump");
    start(&mut mcu, 2.0);
    mcu.run(500);
    close(mcu.rdrp(0), 2.0, 1e-3);
}
