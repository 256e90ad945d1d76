//! ControllerFlags (4.4.51, 4.4.137, 6.3.1.4): what the integral part does while the axis travels and stands.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::card::DEAD_BAND;
use motion_kernel::machine::{Machine, PidfGains};
use motion_kernel::registers::{ControllerFlags as Flags, ModeReg};

/// mill3 with KI only on a jammed axis X, so that mcp is the integral part: a standing error of 100 counts first.
fn stuck(flags: Flags) -> Mcu {
    let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
    mcu.uf(0, &PidfGains { ki: 10.0, ..PidfGains::default() });
    mcu.block(0, true);
    mcu.wrdp(0, 0.01);
    mcu.run(100);
    mcu.wrControllerFlags(0, flags);
    mcu
}
/// Integral part before and after 50 samples, standing or travelling.
fn integral(flags: u32, travels: bool, dead_band: f64) -> (i32, i32) {
    let mut mcu = stuck(Flags(0));
    mcu.set_controller_parameter(0, DEAD_BAND, dead_band);
    if travels {
        line(&mut mcu, &[50.0, 0.0, 0.0], 1.0, 1000.0, 0.0);
        mcu.ssms(mcu.all_axes());
        mcu.run(1);
    }
    let before = mcu.rdmcp(0);
    mcu.wrControllerFlags(0, Flags(flags));
    mcu.run(50);
    (before, mcu.rdmcp(0))
}

// shows: pcap.rdcontrollerflags, pcap.rdcontrollerflags.roundtrip, pcap.wrcontrollerflags, cflags.axis-specific
#[test]
fn each_axis_has_its_own_register() {
    let mut mcu = stuck(Flags(0));
    mcu.wrControllerFlags(0, Flags(0x0909));
    mcu.wrControllerFlags(1, Flags(0xffff_f2f0));
    assert_eq!([0, 1, 2].map(|a| mcu.rdControllerFlags(a).0), [0x0909, 0xffff_f2f0, 0]);
}

// shows: pcap.wrcontrollerflags.effect, cflags.bit-01-movezero, cflags.bit-03-movefix, cflags.bit-09-stopzero
// shows: cflags.bit-11-stopfix
#[test]
fn zero_clears_and_fix_holds_the_integral_part() {
    for (zero, fix, travels) in [(Flags::MoveZero, Flags::MoveFix, true), (Flags::StopZero, Flags::StopFix, false)] {
        let enable = if travels { Flags::MoveControl } else { Flags::StopControl };
        let (before, free) = integral(0, travels, 0.0);
        assert!(before > 20 && free > before + 20, "{before} {free}");
        assert_eq!(integral((enable | zero).0, travels, 0.0).1, 0);
        let held = integral((enable | fix).0, travels, 0.0).1;
        assert!((held - before).abs() <= 1, "{held} is not {before}");
    }
}

// shows: cflags.bit-02-movedeadband, cflags.bit-10-stopdeadband
#[test]
fn outside_the_dead_band_the_integral_part_does_not_grow() {
    for (band, enable, travels) in
        [(Flags::MoveDeadBand, Flags::MoveControl, true), (Flags::StopDeadBand, Flags::StopControl, false)]
    {
        let flags = (enable | band).0;
        let (before, outside) = integral(flags, travels, 50.0);
        assert!((outside - before).abs() <= 1, "100 counts are outside of 50: {outside} is not {before}");
        let (before, inside) = integral(flags, travels, 1e6);
        assert!(inside > before + 20);
    }
}

// shows: cflags.bit-00-movecontrol, cflags.bit-08-stopcontrol, cflags.both-controls-off
#[test]
fn without_its_enable_a_flag_does_nothing() {
    let all = 0xe0e;
    for travels in [true, false] {
        let free = integral(0, travels, 0.0);
        assert_eq!(integral(all, travels, 0.0), free, "both off");
        let other = if travels { Flags::StopControl } else { Flags::MoveControl };
        assert_eq!(integral(all | other.0, travels, 0.0), free, "the other one");
        let own = if travels { Flags::MoveControl } else { Flags::StopControl };
        assert_ne!(integral(all | own.0, travels, 0.0), free);
    }
}

// shows: cflags.bit-04-unused, cflags.bit-05-unused, cflags.bit-06-unused, cflags.bit-07-unused
// shows: cflags.bit-12-31-unused
#[test]
fn unused_bits_do_nothing() {
    for travels in [true, false] {
        for bit in (4..8).chain(12..32) {
            let enabled = (Flags::MoveControl | Flags::StopControl).0;
            assert_eq!(integral(enabled | 1 << bit, travels, 0.0), integral(enabled, travels, 0.0), "bit {bit}");
        }
    }
}

// shows: cflags.servo-only
#[test]
fn a_stepper_knows_no_integral_part() {
    let course = |flags: u32| {
        let mut mcu = mcu("XY", EXACT);
        mcu.wrControllerFlags(0, Flags(flags));
        line(&mut mcu, &[5.0, 3.0], 20.0, 500.0, 0.0);
        run(&mut mcu).rp
    };
    assert_eq!(course(0xf0f), course(0));
}

#[test]
fn the_loop_with_enables_alone_is_the_plain_one() {
    let course = |flags: u32| {
        let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
        mcu.uf(0, &PidfGains { kp: 0.8, ki: 4.0, kd: 0.001, kpl: 0.5, kfcv: 0.01, kfca: 1e-5 });
        mcu.wrControllerFlags(0, Flags(flags));
        line(&mut mcu, &[5.0, 3.0, 1.0], 20.0, 500.0, 0.0);
        run(&mut mcu).rp
    };
    assert_eq!(course(0x101), course(0), "to the last count");
}
