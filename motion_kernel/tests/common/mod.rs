//! Machines and helpers for the tests of the kernel.
#![allow(dead_code)] // every test binary uses its own part

pub mod chain;
pub mod contour;

use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::functions::Entered;
use motion_kernel::machine::*;
use motion_kernel::motion::MotionCommand;
use motion_kernel::registers::ModeReg;
use motion_kernel::trace::Trace;
use motion_kernel::units::PositionUnit;
use motion_kernel::{Mcu, Stop};
use std::sync::Arc;

pub const TA: f64 = 1.28e-3;

fn axis(name: char, kind: AxisKind) -> Axis {
    Axis {
        name: name.to_string(),
        letter: Some(name),
        drive: DriveKind::Stepper,
        kind,
        counts_per_unit: 10_000.0,
        slsp: 10_000.0,
        rapid: 200.0,
        acceleration: 1000.0,
        jog_velocity: 50.0,
        jog_acceleration: 500.0,
        jog_target_velocity: 0.0,
        stop_deceleration: 2000.0,
        mdvel: 0.5,
        maxvel: 200.0,
        maxacc: 1000.0,
        jerkrel: 1.0,
        mpe: 0.0,
        ipw: 0.01,
        limits: None,
        pidf: PidfGains::default(),
        plant: Plant { lag_s: 0.0, ..Plant::for_rapid(240.0) },
        effradius: 57.29577951308232,
        display: PositionUnit::Mm,
        zero_offsets: [0.0; 5],
        modulo: false,
        start: 0.0,
        reference: 0.0,
        equipment: Equipment::default(),
    }
}

/// A machine of stepper axes without limits; letters A, B, C are rotary.
pub fn machine(letters: &str) -> Machine {
    let kind = |c: char| if "ABC".contains(c) { AxisKind::Rotary } else { AxisKind::Linear };
    let axes: Vec<Axis> = letters.chars().map(|c| axis(c, kind(c))).collect();
    Machine {
        name: "test".into(),
        axes,
        controller: Controller {
            sample_ticks: 20,
            spool_memory_bytes: 148_480,
            direct_latency: 2,
            statements_per_sample: 20,
            lookahead_depth: 0,
            clock_hz: 70e6,
            ..Controller::default()
        },
        gcode: GcodeDefaults {
            trac_feed: 500.0,
            trac_rapid: 500.0,
            start_fill: 100,
            tools: vec![],
            ..GcodeDefaults::for_axes(letters.len())
        },
        inputs: vec![],
        outputs: vec![],
        stimulus: None,
        tolerance_mm: 0.05,
    }
}

/// A controller with closed loops and that MODEREG, everything else as after boot.
pub fn mcu_of(machine: Machine, modereg: ModeReg) -> Mcu {
    let mut mcu = Mcu::new(Arc::new(machine));
    let all = mcu.all_axes();
    mcu.cl(all);
    mcu.set_modereg(modereg);
    mcu
}
pub fn mcu(letters: &str, modereg: ModeReg) -> Mcu {
    mcu_of(machine(letters), modereg)
}
pub const EXACT: ModeReg = ModeReg(1 << 8 | 1 << 10);
pub const LOOKAHEAD: ModeReg = ModeReg(EXACT.0 | 1);

pub fn xy() -> AxisList {
    AxisList::new(&[0, 1])
}

/// A line of the axes 0.. to `targets`.
pub fn line(mcu: &mut Mcu, targets: &[f64], vl: f64, ac: f64, tvl: f64) -> Entered {
    let list = AxisList::new(&(0..targets.len()).collect::<Vec<_>>());
    spool(mcu, MoveKind::Smla, &list, targets, [0.0; 2], 0.0, [vl, ac, tvl])
}
/// A circle of the axes 0 and 1 with further axes going to `further`.
pub fn arc(mcu: &mut Mcu, center: [f64; 2], phi: f64, further: &[f64], vl: f64, ac: f64, tvl: f64) -> Entered {
    let targets: Vec<f64> = [0.0, 0.0].iter().chain(further).copied().collect();
    let list = AxisList::new(&(0..targets.len()).collect::<Vec<_>>());
    let kind = if further.is_empty() { MoveKind::Smca } else { MoveKind::Smha };
    spool(mcu, kind, &list, &targets, center, phi, [vl, ac, tvl])
}
pub fn spool(
    mcu: &mut Mcu,
    kind: MoveKind,
    axes: &AxisList,
    targets: &[f64],
    center: [f64; 2],
    phi: f64,
    v: [f64; 3],
) -> Entered {
    let [vl, ac, tvl] = v;
    mcu.spool(&MotionCommand { kind, axes, targets, center, phi, vl, ac, tvl, rapid: false, line: 1 })
}

/// Starts all spoolers and records until everything is done.
pub fn run(mcu: &mut Mcu) -> Trace {
    let all = mcu.all_axes();
    mcu.ssms(all);
    record(mcu)
}
/// Records until everything is done (at most 200 000 samples).
pub fn record(mcu: &mut Mcu) -> Trace {
    let mut trace = Trace::default();
    let advanced = mcu.advance(200_000, &mut trace);
    assert_eq!(advanced.stop, Stop::Finished, "after {} samples", advanced.samples);
    trace
}
pub fn set(axes: &[usize]) -> AxisSet {
    axes.iter().copied().collect()
}
/// Set points of one axis.
pub fn dp(trace: &Trace, axis: usize) -> Vec<f64> {
    trace.dp.iter().skip(axis).step_by(trace.axes).copied().collect()
}
/// Speeds between samples of one axis, from its start position on.
pub fn speeds(trace: &Trace, axis: usize, start: f64) -> Vec<f64> {
    let positions = dp(trace, axis);
    let before = std::iter::once(start).chain(positions.iter().copied());
    before.zip(&positions).map(|(a, b)| (b - a) / TA).collect()
}
#[track_caller]
pub fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b}");
}
