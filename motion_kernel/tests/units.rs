//! Trajectory units PU and TU, and rotary axes in interpolations (chapters 2.3.4, 4.4.2, 4.4.11).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::machine::Machine;
use motion_kernel::registers::{ErrorReg, ModeReg};
use std::f64::consts::PI;

const ROTATORIC: ModeReg = ModeReg(1 << 8 | 1 << 10);
const TRANSLATORY: ModeReg = ModeReg(1 << 8);

/// A stepper machine with X and C; C has effradius 100 mm and 20000 counts a degree, X 5000 counts a revolution.
fn xc(modereg: ModeReg) -> Mcu {
    let mut machine: Machine = machine("XC");
    (machine.axes[1].effradius, machine.axes[1].counts_per_unit) = (100.0, 20_000.0);
    machine.axes[0].slsp = 50_000.0; // 5 mm a revolution
    mcu_of(machine, modereg)
}
/// One line of the axis and what it did: end position, highest speed and acceleration of the axis.
fn moved(mcu: &mut Mcu, axis: usize, target: f64, v: [f64; 3]) -> (f64, f64, f64) {
    let entered = spool(mcu, MoveKind::Smla, &AxisList::new(&[axis]), &[target], [0.0; 2], 0.0, v);
    assert_eq!(entered, Entered::Yes);
    let trace = run(mcu);
    let speeds = speeds(&trace, axis, 0.0);
    let most = speeds.iter().copied().fold(0.0, f64::max);
    let changes = speeds.windows(2).map(|w| (w[1] - w[0]).abs() / TA);
    (mcu.rddp(axis), most, changes.fold(0.0, f64::max))
}

// shows: pcap.ctru, pcap.ctru.pu-0, pcap.ctru.pu-1, pcap.ctru.pu-2, pcap.ctru.pu-3, pcap.ctru.pu-6, pcap.ctru.pu-7
// shows: pcap.general.conversion, pcap.general.move-units, kernel.accel.trajectory-unit, kernel.tvl.unit
#[test]
fn position_units_of_a_linear_axis() {
    for (pu, mm) in [(0, 1.0), (1, 25.4), (2, 1000.0), (3, 5.0), (6, 1e-4), (7, 1e-4)] {
        let mut mcu = xc(ROTATORIC);
        assert!(mcu.ctru(pu, 0));
        let (end, speed, acc) = moved(&mut mcu, 0, 40.0 / mm, [50.0 / mm, 500.0 / mm, 0.0]);
        close(end, 40.0, 1e-9);
        close(speed, 50.0, 1e-6);
        close(acc, 500.0, 1e-3);
    }
}

// shows: pcap.ctru.pu-4, pcap.ctru.pu-5
#[test]
fn position_units_of_a_rotary_axis() {
    for (pu, degrees) in [(3, 360.0), (4, 1.0), (5, 180.0 / PI), (6, 1.0 / 20_000.0)] {
        for modereg in [ROTATORIC, TRANSLATORY] {
            let mut mcu = xc(modereg);
            assert!(mcu.ctru(pu, 0));
            let (end, speed, acc) = moved(&mut mcu, 1, 90.0 / degrees, [50.0 / degrees, 500.0 / degrees, 0.0]);
            close(end, 90.0, 1e-9);
            close(speed, 50.0, 1e-6);
            close(acc, 500.0, 1e-3);
        }
    }
}

// shows: pcap.ctru.tu-0, pcap.ctru.tu-1, pcap.ctru.tu-2
#[test]
fn time_units() {
    for (tu, seconds) in [(0, 1.0), (1, 60.0), (2, TA)] {
        let mut mcu = xc(ROTATORIC);
        assert!(mcu.ctru(0, tu));
        let (end, speed, acc) = moved(&mut mcu, 0, 40.0, [50.0 * seconds, 500.0 * seconds * seconds, 0.0]);
        close(end, 40.0, 1e-9);
        close(speed, 50.0, 1e-6);
        close(acc, 500.0, 1e-3);
    }
}

// shows: pcap.ctru.default
#[test]
fn after_boot_units_are_mm_and_seconds() {
    let (end, speed, acc) = moved(&mut xc(ROTATORIC), 0, 40.0, [50.0, 500.0, 0.0]);
    close(end, 40.0, 1e-9);
    close(speed, 50.0, 1e-6);
    close(acc, 500.0, 1e-3);
}

// shows: errorreg.unit
#[test]
fn an_invalid_unit_is_refused() {
    let mut mcu = xc(ROTATORIC);
    mcu.ctru(1, 0);
    for (pu, tu) in [(8, 0), (-1, 0), (0, 3), (0, i32::MIN)] {
        assert!(!mcu.ctru(pu, tu));
        assert!(mcu.errorreg().has(ErrorReg::errUnit));
    }
    close(moved(&mut mcu, 0, 1.0, [5.0, 50.0, 0.0]).0, 25.4, 1e-9);
}

// shows: pcap.ctru.moves-only, pcap.general.jog-units, kernel.maxvel.units, kernel.accel.axis-unit
#[test]
fn jogs_keep_the_units_of_the_axis() {
    let mut mcu = xc(ROTATORIC);
    mcu.ctru(2, 1);
    mcu.ja(&AxisList::new(&[0]), &[12.0]);
    let trace = record(&mut mcu);
    close(mcu.rddp(0), 12.0, 1e-9);
    let speeds = speeds(&trace, 0, 0.0);
    let jog = &mcu.machine().axes[0];
    close(speeds.iter().copied().fold(0.0, f64::max), jog.jog_velocity, 1e-6);
    close(speeds.windows(2).map(|w| (w[1] - w[0]) / TA).fold(0.0, f64::max), jog.jog_acceleration, 1e-3);
}

// shows: pcap.mla.units, pcap.mca.units
#[test]
fn direct_moves_take_the_units_of_their_call() {
    let mut mcu = mcu("XY", ROTATORIC);
    let command = |kind, targets: &'static [f64], axes: &'static AxisList| motion_kernel::motion::MotionCommand {
        kind,
        axes,
        targets,
        center: [1.0, 0.0],
        phi: 180.0,
        vl: 2.0,
        ac: 20.0,
        tvl: 0.0,
        rapid: false,
        line: 0,
    };
    let axes: &'static AxisList = Box::leak(Box::new(xy()));
    mcu.ctru(1, 0);
    mcu.direct(&command(MoveKind::Smla, &[2.0, 1.0], axes));
    mcu.ctru(0, 0); // before the command takes effect
    let trace = record(&mut mcu);
    close(mcu.rddp(0), 50.8, 1e-9);
    close(mcu.rddp(1), 25.4, 1e-9);
    let along = speeds(&trace, 0, 0.0).into_iter().fold(0.0, f64::max) * 5.0_f64.sqrt() / 2.0;
    close(along, 50.8, 1e-6);
    mcu.ctru(1, 0);
    mcu.direct(&command(MoveKind::Smca, &[0.0, 0.0], axes));
    record(&mut mcu);
    close(mcu.rddp(0), 0.0, 1e-9);
    close(mcu.rddp(1), -25.4, 1e-9);
}

/// A line of X and C and its duration in s.
fn xc_line(modereg: ModeReg, kind: MoveKind, targets: &[f64], vl: f64) -> (Mcu, f64) {
    let mut mcu = xc(modereg);
    spool(&mut mcu, kind, &AxisList::new(&[0, 1]), targets, [0.0; 2], 0.0, [vl, 1e6, 0.0]);
    let trace = run(&mut mcu);
    let moving = trace.flags.iter().filter(|f| *f & 1 == 1).count();
    (mcu, moving as f64 * TA)
}

// shows: interp.effradius.example, interp.effradius.translatory-default, interp.effradius.conversion
// shows: interp.effradius.unit
#[test]
fn a_rotary_axis_counts_with_its_circumference() {
    let (mcu, seconds) = xc_line(TRANSLATORY, MoveKind::Smlr, &[25.0, 60.0], 50.0);
    close(mcu.rddp(0), 25.0, 1e-9);
    close(mcu.rddp(1), (60.0_f64 / 100.0).to_degrees(), 1e-9);
    close(seconds, 25.0_f64.hypot(60.0) / 50.0, 2.0 * TA);
}

// shows: interp.effradius.rotatoric-unit, interp.effradius.rotatoric-unit-global
#[test]
fn with_rotatoric_unit_it_moves_by_degrees() {
    let (mcu, seconds) = xc_line(ROTATORIC, MoveKind::Smlr, &[25.0, 60.0], 50.0);
    close(mcu.rddp(1), 60.0, 1e-9);
    close(seconds, 25.0_f64.hypot(60.0_f64.to_radians() * 100.0) / 50.0, 2.0 * TA);
    // one switch for all axes; here 1 degree is 2 mm of circumference
    for (modereg, want) in [(ROTATORIC, 30.0), (TRANSLATORY, 15.0)] {
        let mut machine = machine("XBC");
        machine.axes.iter_mut().for_each(|a| a.effradius = 360.0 / PI);
        let mut mcu = mcu_of(machine, modereg);
        let targets = [1.0, 30.0, 30.0];
        spool(&mut mcu, MoveKind::Smla, &AxisList::new(&[0, 1, 2]), &targets, [0.0; 2], 0.0, [50.0, 1e6, 0.0]);
        run(&mut mcu);
        close(mcu.rddp(1), want, 1e-9);
        close(mcu.rddp(2), want, 1e-9);
    }
}

// shows: interp.effradius.all-kinds
#[test]
fn the_conversion_works_for_circles_and_helices() {
    // C runs along with a circle of X and Y: the path of the helix is as long as circle and circumference
    let mut machine = machine("XYC");
    machine.axes[2].effradius = 100.0;
    let helix = |machine: &Machine, c: f64| {
        let mut mcu = mcu_of(machine.clone(), TRANSLATORY);
        arc(&mut mcu, [10.0, 0.0], 360.0, &[c], 20.0, 1e6, 0.0);
        let trace = run(&mut mcu);
        (mcu.rddp(2), trace.flags.iter().filter(|f| *f & 1 == 1).count() as f64 * TA)
    };
    let (end, seconds) = helix(&machine, 50.0);
    close(end, 0.5_f64.to_degrees(), 1e-9);
    close(seconds, (20.0 * PI).hypot(50.0) / 20.0, 2.0 * TA);
    // a circle on the unrolled surface: X and C in one plane
    let mut mcu = xc(TRANSLATORY);
    let axes = AxisList::new(&[0, 1]);
    spool(&mut mcu, MoveKind::Smca, &axes, &[0.0, 0.0], [10.0, 0.0], 90.0, [20.0, 1e6, 0.0]);
    let trace = run(&mut mcu);
    close(mcu.rddp(0), 10.0, 1e-9);
    close(mcu.rddp(1), (-10.0_f64 / 100.0).to_degrees(), 1e-9);
    close(trace.len() as f64 * TA, 5.0 * PI / 20.0, 3.0 * TA);
}

// shows: interp.mixed-types
#[test]
fn an_interpolation_of_rotary_axes_alone_is_in_degrees() {
    let mut mcu = mcu("BC", ROTATORIC);
    mcu.ctru(4, 0);
    line(&mut mcu, &[30.0, 40.0], 25.0, 1e6, 0.0);
    let trace = run(&mut mcu);
    close(trace.len() as f64 * TA, 2.0, 2.0 * TA);
}

// shows: pcap.rdslsp, pcap.rdslsp.ret-1, pcap.rdslsp.default
#[test]
fn counts_per_revolution_come_from_the_machine_file() {
    let mcu = xc(ROTATORIC);
    assert_eq!((mcu.rdslsp(0), mcu.rdslsp(1)), ((1, 50_000.0), (1, 10_000.0)));
}
