//! Gear factor and resolution at run time (4.4.66, 4.4.145, 4.4.171): gf in axis units per motor revolution.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::axes::AxisList;
use motion_kernel::machine::DriveKind;
use motion_kernel::registers::Axst;
use motion_kernel::trace::Trace;

/// X: 10000 counts/mm, 10000 counts/revolution.
fn geared(drive: DriveKind) -> Mcu {
    let mut machine = machine("XY");
    for axis in &mut machine.axes {
        axis.drive = drive;
        axis.pidf.kp = 20.0;
        axis.pidf.kfcv = 32_767.0 / 240.0 / 10_000.0;
        axis.slsp = 20_000.0;
    }
    mcu_of(machine, EXACT)
}
fn jog(m: &mut Mcu, target: f64) {
    m.ja(&AxisList::new(&[0]), &[target]);
    m.run(3000);
    assert!(m.axst(0).has(Axst::pe));
}
fn counts(m: &Mcu) -> f64 {
    m.rdrp(0) * m.parameters(0).counts_per_unit
}

// shows: pcap.rdgf, pcap.rdgf.default, pcap.wrgf, pcap.wrgf.readback, pcap.wrslsp, pcap.wrslsp.positive
// shows: struct.tsrp.gf, pcap.rdslsp.default, qual.gf, qual.slsp
#[test]
fn gear_factor_and_resolution_convert_units_to_counts() {
    let mut m = geared(DriveKind::Stepper);
    assert_eq!((m.rdgf(0), m.rdslsp(0)), (2.0, (1, 20_000.0)), "2 mm a revolution, from the system data");
    jog(&mut m, 5.0);
    close(counts(&m), 50_000.0, 0.5);
    assert!(m.wrgf(0, 4.0));
    assert_eq!(m.rdgf(0), 4.0);
    close(m.rdrp(0), 10.0, 1e-9);
    close(m.rddp(0), 10.0, 1e-9);
    jog(&mut m, 14.0);
    close(counts(&m), 70_000.0, 0.5);
    assert!(m.wrslsp(0, 40_000.0));
    assert_eq!((m.rdgf(0), m.rdslsp(0)), (4.0, (1, 40_000.0)));
    close(m.rdrp(0), 7.0, 1e-9);
    jog(&mut m, 8.0);
    close(counts(&m), 80_000.0, 0.5);
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(!m.wrgf(0, wrong) && !m.wrslsp(0, wrong));
    }
    assert!(!m.wrgf(0, 1e-320) && !m.wrslsp(0, 1e-320), "no number of counts at all");
    assert_eq!((m.rdgf(0), m.rdslsp(0).1), (4.0, 40_000.0));
    assert_eq!(m.rdgf(1), 2.0, "the other axis keeps its own");
}

// shows: pcap.wrgf.params-not-adapted
#[test]
fn velocities_keep_their_numbers_and_so_the_motor_turns_at_another_speed() {
    let mut m = geared(DriveKind::Stepper);
    let motor_speed = |m: &mut Mcu| {
        let start = m.rdrp(0);
        m.ja(&AxisList::new(&[0]), &[start + 50.0]);
        m.run(400);
        let before = counts(m);
        m.run(100);
        let speed = (counts(m) - before) / (100.0 * TA);
        m.js(set(&[0]));
        m.run(500);
        speed
    };
    close(motor_speed(&mut m), 500_000.0, 500.0); // 50 mm/s
    let jvl = m.parameters(0).jvl;
    assert!(m.wrgf(0, 8.0));
    assert_eq!(m.parameters(0).jvl, jvl);
    close(motor_speed(&mut m), 125_000.0, 500.0);
}

#[test]
fn the_motor_of_a_standing_or_moving_axis_notices_nothing() {
    for drive in [DriveKind::Stepper, DriveKind::Servo] {
        let motion = |change: bool| {
            let mut m = geared(drive);
            for n in 1..=4 {
                line(&mut m, &[5.0 * f64::from(n), 1.0], 20.0, 200.0, 0.0);
            }
            arc(&mut m, [20.0, 6.0], 180.0, &[], 20.0, 200.0, 0.0);
            m.spd(0, &[20.1, 20.2]);
            m.spdr(0, &[0.1, 0.2], 0);
            m.ssms(set(&[0, 1]));
            let mut counted = vec![];
            for k in 0..3000 {
                if change && [0, 100, 1500, 2500].contains(&k) {
                    let gf = m.rdgf(0);
                    assert!(m.wrgf(0, if gf == 2.0 { 0.5 } else { 2.0 }));
                }
                m.run(1);
                counted.push(counts(&m));
            }
            counted
        };
        let (with, without) = (motion(true), motion(false));
        assert!(without.last().expect("ran") > &200_000.0);
        // a count more or less, where rounding decides
        for (k, (a, b)) in with.iter().zip(&without).enumerate() {
            assert!((a - b).abs() <= 1.5, "{drive:?} sample {k}: {a} against {b}");
        }
    }
}

#[test]
fn a_jog_goes_on_to_the_same_place() {
    let mut m = geared(DriveKind::Stepper);
    m.ja(&AxisList::new(&[0]), &[20.0]);
    m.run(200);
    assert!(m.wrgf(0, 1.0));
    let mut trace = Trace::default();
    m.pass(2000, &mut trace);
    close(counts(&m), 200_000.0, 0.5);
    close(m.rddp(0), 10.0, 1e-9);
    assert!(speeds(&trace, 0, trace.dp[0]).windows(2).skip(1).all(|w| (w[1] - w[0]).abs() <= 250.0 * TA + 1e-6));
}
