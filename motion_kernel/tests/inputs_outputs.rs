//! Digital inputs and outputs, amplifier enable, interface status, configuration check (4.4.8, 4.4.41, 4.4.42, 4.4.52
//! to 4.4.55, 4.4.70, 4.4.71, 4.4.111, 4.4.113, 4.4.138, 4.4.139).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::machine::Machine;
use motion_kernel::registers::{Axst, ErrorReg, Ifs, ModeReg};
use std::sync::Arc;

/// mill3: output 1 on after a reset, output 2 and 3 PAE of X and Y, inputs as given.
fn booted(further: &str) -> Mcu {
    let text = format!(
        "{}\n[[output]]\nnumber = 1\non = true\n[[output]]\nnumber = 2\naxis = \"X\"\nfunction = \"PAE\"\n\
         [[output]]\nnumber = 3\naxis = \"Y\"\nfunction = \"PAE\"\n{further}",
        motion_kernel::machine::BUILTIN
    );
    Mcu::new(Arc::new(Machine::parse(text.as_bytes()).expect("valid")))
}

// shows: digi.bit0, digi.bit1, digi.bit2, digi.bit3, digi.bit5, digi.bit6, digi.bit7, digi.bit8, digi.bit9, digi.bit10
// shows: digi.bit11, digi.bit12, pcap.rddigib.inputs, pcap.rddigi.no-axis-mapping, struct.tsrp.digi
#[test]
fn each_input_is_a_bit_of_every_axis() {
    let mut mcu = booted("");
    for n in 0..16 {
        mcu.set_inputs(1 << n);
        for a in 0..3 {
            assert_eq!(mcu.rddigi(a) & 0xffff, 1 << n);
            for bitnr in 1..=16 {
                assert_eq!(mcu.rddigib(a, bitnr), i32::from(bitnr == n + 1));
            }
        }
    }
}

// shows: digi.bits24-31, pcap.rddigib.undefined
#[test]
fn unassigned_bits_read_0() {
    let mut mcu = booted("");
    mcu.set_inputs(u32::MAX);
    mcu.cut_encoder(0, true);
    assert_eq!(mcu.rddigi(0) >> 24, 0);
    for bitnr in [0, 25, 28, 32, 33, u32::MAX] {
        assert_eq!(mcu.rddigib(0, bitnr), 0);
    }
    assert_eq!([21, 22, 23, 24].map(|bitnr| mcu.rddigib(1, bitnr)), [0; 4]);
}

// shows: pcap.wrdigo, pcap.wrdigo.not-axis-specific, digo.bit0, digo.bit1, digo.bit2, digo.bit3, digo.bit4, digo.bit5
// shows: digo.bit6, digo.bit7, digo.bits8-31, struct.tsrp.digo
#[test]
fn outputs_are_the_same_for_all_axes_and_eight() {
    let mut mcu = booted("");
    for n in 0..32 {
        mcu.wrdigo(n as usize % 3, 1 << n);
        let want = if n < 8 { 1 << n } else { 0 };
        assert_eq!(mcu.rddigo(), want, "output {}", n + 1);
        assert!(mcu.status().axes.iter().all(|axis| axis.digo == want));
    }
    mcu.wrdigo(0, 0b1010_0101);
    assert_eq!(mcu.rddigo(), 0b1010_0101);
    mcu.wrdigo(1, 0);
    assert_eq!(mcu.rddigo(), 0);
}

// shows: pcap.wrdigob, pcap.wrdigob.reset, pcap.wrdigob.bitnr, pcap.wrdigob.unassigned, pcap.rddigob
#[test]
fn single_outputs_count_from_1() {
    let mut mcu = booted("");
    mcu.wrdigo(0, 0);
    for bitnr in 1..=8 {
        mcu.wrdigob(0, bitnr, true);
        assert_eq!((mcu.rddigo(), mcu.rddigob(bitnr)), (1 << (bitnr - 1), 1));
        mcu.wrdigob(2, bitnr, false);
        assert_eq!((mcu.rddigo(), mcu.rddigob(bitnr)), (0, 0));
    }
    for bitnr in [0, 9, 32, u32::MAX] {
        mcu.wrdigob(0, bitnr, true);
        assert_eq!((mcu.rddigo(), mcu.rddigob(bitnr)), (0, 0));
    }
}

// shows: ssf.example-set, ssf.example-reset, ssf.1001, ssf.1002
#[test]
fn spooled_functions_switch_the_same_outputs() {
    let mut mcu = booted("");
    mcu.cl(mcu.all_axes());
    mcu.wrdigo(0, 0b0110);
    mcu.ssf(0, 1001, 1.0, 0);
    mcu.ssf(0, 1002, 4.0, 0);
    mcu.run(10);
    assert_eq!(mcu.rddigo(), 0b0110, "not before the spooler runs");
    mcu.ssms(mcu.all_axes());
    mcu.run(2);
    assert_eq!(mcu.rddigo(), 0b0011, "O1 set, O3 reset");
}

// shows: ssf.1004.group
#[test]
fn a_spooled_wait_takes_any_of_the_sixteen_inputs() {
    for n in 0..16 {
        let mut mcu = booted("");
        mcu.cl(mcu.all_axes());
        mcu.ssf(2, 1004, f64::from(1 << n), 0);
        mcu.ssf(2, 10, 1.0, 0);
        mcu.ssms(mcu.all_axes());
        mcu.set_inputs(!(1 << n));
        mcu.run(20);
        assert_eq!(mcu.ci(10), 0);
        mcu.set_inputs(1 << n);
        mcu.run(2);
        assert_eq!(mcu.ci(10), 1);
    }
}

// shows: pcap.cl.pae, pcap.clv.pae, pcap.ol.pae
#[test]
fn closing_loops_enables_the_amplifiers() {
    let mut mcu = booted("");
    assert_eq!(mcu.rddigo(), 0b001, "after boot as configured");
    for close in [Mcu::cl, Mcu::clv] {
        close(&mut mcu, set(&[0]));
        assert_eq!(mcu.rddigo(), 0b111, "all PAE outputs");
        mcu.ol(set(&[1]));
        assert_eq!(mcu.rddigo(), 0b011, "that of the axis");
        mcu.ol(set(&[0, 2]));
        assert_eq!(mcu.rddigo(), 0b001);
    }
}

// shows: pcap.ra.outputs, pcap.ra.pae-group, pcap.rs.outputs
#[test]
fn resets_bring_the_outputs_back() {
    for reset in [(|mcu: &mut Mcu| mcu.ra(set(&[2]))) as fn(&mut Mcu), |mcu| mcu.rs()] {
        let mut mcu = booted("");
        mcu.cl(mcu.all_axes());
        mcu.wrdigo(0, 0xfe);
        reset(&mut mcu);
        assert_eq!(mcu.rddigo(), 0b001, "defaults, also for PAE of other axes");
    }
}

#[test]
fn without_its_enable_a_drive_does_not_move() {
    let mut mcu = booted("");
    mcu.wrmcp(0, 3_000);
    mcu.run(200);
    assert_eq!(mcu.rdrp(0), 0.0);
    mcu.wrdigob(0, 2, true);
    mcu.run(200);
    assert!(mcu.rdrp(0) > 1.0);
    let mut mcu = booted("");
    mcu.cl(mcu.all_axes());
    line(&mut mcu, &[50.0, 0.0, 0.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(300);
    mcu.ra(set(&[2])); // resets the enable of X too
    mcu.run(300);
    assert!(mcu.axst(0).has(Axst::mpe | Axst::cl));
}

#[test]
fn the_world_outside_rests_at_boot() {
    let inputs = "[[input]]\nnumber = 1\naxis = \"X\"\nfunction = \"DR\"\n[[input]]\nnumber = 2\naxis = \"Y\"\n\
                  function = \"DR\"\ninverted = true\n[[input]]\nnumber = 3\naxis = \"X\"\nfunction = \"LSL_SMD\"\n\
                  inverted = true\n";
    let mut mcu = booted(inputs);
    mcu.run(1);
    assert_eq!(mcu.rddigi(0) & 7, 0b011, "drives are ready, no switch is actuated");
    assert!(!mcu.axst(0).any(Axst::dnr | Axst::lslh) && !mcu.axst(1).has(Axst::dnr));
    mcu.drop_drive(1, true);
    mcu.run(1);
    assert_eq!([0, 1].map(|a| mcu.axst(a).has(Axst::dnr)), [false, true]);
    mcu.drop_drive(1, false);
    mcu.run(1);
    assert!(!mcu.axst(1).has(Axst::dnr));
}

// shows: pcap.rdifs, pcap.rdifs.ret-0, ifs.edv, ifs.cncrdy, ifs.bits2-15, ifs.pfe, ifs.scpfe, ifs.rifs-clears, pcap.rifs
// shows: pcap.rdifsb, pcap.rdifsb.one-based, pcap.rs.keeps-ifs, struct.tsrp.ifs
#[test]
fn the_interface_status_after_power_up() {
    let mut mcu = booted("");
    let power_up = Ifs::edv | Ifs::cncrdy | Ifs::pfe | Ifs::scpfe;
    assert_eq!(mcu.rdifs(), power_up);
    for bitnr in 0..=33 {
        assert_eq!(mcu.rdifsb(bitnr), i32::from([1, 2, 17, 21].contains(&bitnr)), "bitnr {bitnr}");
    }
    mcu.rs();
    assert_eq!(mcu.rdifs(), power_up);
    mcu.rifs();
    assert_eq!(mcu.rdifs(), Ifs::edv | Ifs::cncrdy);
}

// shows: ifs.boot-copy, ifs.bus-error
#[test]
fn a_boot_takes_the_flags_of_the_logic_over_once() {
    let mut mcu = booted("");
    mcu.boot_interface();
    assert_eq!(mcu.rdifs(), Ifs::edv | Ifs::cncrdy, "of power-up nothing is left");
    mcu.undervoltage(false);
    mcu.bus_error();
    assert_eq!(mcu.rdifs(), Ifs::edv | Ifs::cncrdy | Ifs::scpfe | Ifs::bus_error);
    mcu.rifs();
    assert_eq!(mcu.rdifs(), Ifs::edv | Ifs::cncrdy | Ifs::bus_error, "bit 21 needs a boot");
    mcu.boot_interface();
    assert_eq!(mcu.rdifs(), Ifs::edv | Ifs::cncrdy | Ifs::scpfe, "copied");
    mcu.boot_interface();
    assert_eq!(mcu.rdifs(), Ifs::edv | Ifs::cncrdy, "and gone");
}

// shows: pcap.general.pe-flag, pcap.wripw.monitor, pcap.wrmpe.monitor
#[test]
fn windows_of_0_are_not_watched() {
    let mut mcu = booted("");
    mcu.cl(mcu.all_axes());
    mcu.run(10);
    assert!(mcu.axst(0).has(Axst::pe | Axst::ip));
    mcu.wripw(0, 0.0);
    mcu.run(1);
    assert!(mcu.axst(0).has(Axst::pe) && !mcu.axst(0).has(Axst::ip));
    mcu.wripw(0, 0.01);
    mcu.wrmpe(0, 0.0);
    mcu.block(0, true);
    for spooled in [true, false] {
        if spooled {
            line(&mut mcu, &[20.0, 0.0, 0.0], 50.0, 1000.0, 0.0);
            mcu.ssms(mcu.all_axes());
        } else {
            mcu.ja(&motion_kernel::axes::AxisList::new(&[0]), &[40.0]);
        }
        mcu.run(5);
        assert!(!mcu.axst(0).has(Axst::pe), "a profile runs");
        mcu.run(1000);
        assert!(mcu.axst(0).has(Axst::pe), "profile end, spooled and direct");
        assert!(!mcu.axst(0).any(Axst::ip | Axst::mpe));
    }
    mcu.wrmpe(0, 1.0);
    mcu.run(1);
    assert!(mcu.axst(0).has(Axst::mpe));
    mcu.ol(set(&[0]));
    mcu.cl(set(&[0]));
    mcu.ol(set(&[0]));
    mcu.push(0, 100.0);
    mcu.run(10);
    assert!(!mcu.axst(0).has(Axst::mpe), "only in closed loop");
}

// shows: errorreg.bit20
#[test]
fn bit_20_of_the_error_register_belongs_to_an_option() {
    assert!(ErrorReg::ALL.iter().all(|(number, _, _)| *number != 20));
    let mut mcu = mcu("XY", ModeReg(0));
    line(&mut mcu, &[0.0, 0.0], 1.0, 1.0, 0.0);
    line(&mut mcu, &[1.0, 0.0], 0.0, 0.0, 0.0);
    line(&mut mcu, &[1.0, 0.0], 1.0, 0.0, 0.0);
    mcu.ctru(99, 99);
    assert!(mcu.errorreg().0.count_ones() >= 3 && mcu.errorreg().0 >> 20 == 0);
}

// shows: axst.cef, axst.cef.after-reset, axst.cef.after-txbf2
#[test]
fn system_data_of_another_drive_are_a_configuration_error() {
    let mill = Machine::builtin();
    let mut other = mill.clone();
    other.axes[1].drive = motion_kernel::machine::DriveKind::Stepper;
    let mut mcu = Mcu::new(Arc::new(mill.clone()));
    let errors = |mcu: &Mcu| [0, 1, 2].map(|a| mcu.axst(a).has(Axst::cef));
    mcu.rs();
    assert_eq!(errors(&mcu), [false; 3]);
    mcu.initialise(Arc::new(other));
    assert_eq!(errors(&mcu), [false, true, false], "after the transfer");
    mcu.rs();
    assert_eq!(errors(&mcu), [false, true, false], "and after a reset");
    mcu.initialise(Arc::new(mill));
    assert_eq!(errors(&mcu), [false; 3]);
}
