//! dpoffset and dvoffset (4.4.57, 4.4.60, 4.4.141, 4.4.142), backlash compensation.

mod common;

use common::*;
use motion_kernel::axes::AxisList;
use motion_kernel::machine::Machine;
use motion_kernel::registers::{Axst, ModeReg};

// shows: pcap.rddpoffset, pcap.rddpoffset.ret-0, pcap.wrdpoffset, pcap.wrdpoffset.ret-0, pcap.wrdpoffset.step
#[test]
fn an_offset_is_a_step_of_the_axis() {
    let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
    assert!(mcu.wrdpoffset(0, 0.2) && !mcu.wrdpoffset(1, f64::NAN));
    assert_eq!((mcu.rddpoffset(0), mcu.rddpoffset(1)), (0.2, 0.0));
    mcu.run(1);
    assert!(mcu.rdPosErr(0) > 0.15, "all of it at once: {}", mcu.rdPosErr(0));
    mcu.run(500);
    close(mcu.rdrp(0), 0.2, 2e-4);
    assert_eq!(mcu.rddp(0), 0.0, "no profile");
    assert!(mcu.axst(0).has(Axst::pe | Axst::ip) && !mcu.axst(0).has(Axst::mpe));
    mcu.wrdpoffset(0, -0.1);
    mcu.run(500);
    close(mcu.rdrp(0), -0.1, 2e-4);
    close(mcu.rdrp(1), 0.0, 2e-4);
}

// shows: pcap.wrdpoffset.rate, pcap.rddvoffset, pcap.rddvoffset.ret-0, pcap.wrdvoffset, pcap.wrdvoffset.ret-0
// shows: pcap.wrdvoffset.zero, pcap.wrdvoffset.default
#[test]
fn with_a_rate_the_offset_ramps() {
    let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
    assert_eq!(mcu.rddvoffset(0), 0.0, "at first 0: at once");
    assert!(mcu.wrdvoffset(0, 5.0) && !mcu.wrdvoffset(0, -1.0));
    assert_eq!(mcu.rddvoffset(0), 5.0);
    mcu.wrdpoffset(0, 1.0);
    mcu.run(100);
    close(mcu.rdrv(0), 5.0, 0.2);
    close(mcu.rdrp(0) + mcu.rdPosErr(0), 5.0 * 100.0 * TA, 1e-9);
    mcu.run(400);
    close(mcu.rdrp(0), 1.0, 2e-4);
    mcu.wrdvoffset(0, 0.0);
    mcu.wrdpoffset(0, 1.1);
    close(mcu.rdPosErr(0), 0.1, 2e-4);
}

#[test]
fn an_offset_adds_to_a_profile_and_closing_the_loop_takes_it_into_account() {
    let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
    mcu.wrdpoffset(0, 0.5);
    line(&mut mcu, &[10.0, 0.0, 0.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(1500);
    close(mcu.rddp(0), 10.0, 1e-9);
    close(mcu.rdrp(0), 10.5, 2e-4);
    mcu.ol(set(&[0]));
    mcu.run(50);
    let place = mcu.machine_position(0);
    mcu.cl(set(&[0]));
    mcu.run(300);
    close(mcu.machine_position(0), place, 2e-4);
}

/// Where the load ends at +5 from the left and from the right.
fn both_sides(compensation: f64, hysteresis: f64) -> (f64, f64) {
    let mut machine = Machine::builtin();
    machine.axes[0].plant.backlash = 0.05;
    machine.axes[0].equipment.backlash_compensation = compensation;
    machine.axes[0].equipment.backlash_hysteresis = hysteresis;
    let mut mcu = mcu_of(machine, ModeReg(0));
    let x = AxisList::new(&[0]);
    let ends = [5.0, 8.0, 5.0].map(|target| {
        mcu.ja(&x, &[target]);
        mcu.run(1500);
        close(mcu.rdrp(0), target, 2e-4);
        mcu.machine_position(0)
    });
    (ends[0], ends[2])
}

#[test]
fn backlash_compensation_brings_the_load_to_the_same_place() {
    let (from_left, from_right) = both_sides(0.0, 0.0);
    close(from_right - from_left, 0.05, 2e-3);
    let (from_left, from_right) = both_sides(0.05, 0.0);
    close(from_right, from_left, 2e-3);
    let (from_left, from_right) = both_sides(0.05, 4.0);
    close(from_right - from_left, 0.05, 2e-3); // 3 mm back are within the hysteresis
}

#[test]
fn backlash_compensation_can_be_changed_at_run_time() {
    let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
    assert!(mcu.wrbacklash(0, 0.02) && mcu.wrbacklash_hysteresis(0, 0.5) && !mcu.wrbacklash_hysteresis(0, -1.0));
    assert_eq!((mcu.rdbacklash(0), mcu.rdbacklash_hysteresis(0), mcu.rdactual_backlash(0)), (0.02, 0.5, 0.0));
    let x = AxisList::new(&[0]);
    for (target, actual) in [(1.0, 0.0), (0.6, 0.0), (0.0, -0.02), (0.4, -0.02), (1.0, 0.0)] {
        mcu.ja(&x, &[target]);
        mcu.run(1000);
        close(mcu.rdactual_backlash(0), actual, 1e-9);
        close(mcu.machine_position(0), target + actual, 2e-4);
    }
}

#[test]
fn another_gear_factor_keeps_offsets_where_they_are() {
    let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
    mcu.wrdpoffset(0, 0.5);
    mcu.wrbacklash(0, 0.02);
    mcu.run(500);
    mcu.wrgf(0, 2.0 * mcu.rdgf(0));
    assert_eq!((mcu.rddpoffset(0), mcu.rdbacklash(0)), (1.0, 0.04));
    close(mcu.rdrp(0), 1.0, 4e-4);
    mcu.run(500);
    close(mcu.rdrp(0), 1.0, 4e-4);
}
