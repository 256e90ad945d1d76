//! Generated programs on a machine that has everything (rotary axes, spindle, options, factors): translation never
//! panics, its numbers are sound, and what it lets through runs to the end without a bit in ErrorReg.

mod common;

use std::sync::Arc;

use gcode::{Limits, Options, compile, listing_json, sequence};
use motion_kernel::autocode::Program;
use motion_kernel::machine::{DialectOptions, Machine, Profile};
use motion_kernel::registers::{ErrorReg, ModeReg};
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};
use proptest::prelude::*;

const BLOCKS: &[&str] = &[
    "G0 X1 Y2",
    "G0 Z5",
    "G1 X10 F600",
    "G1 X3 Y-4 C20 F900",
    "X5 Y5",
    "C90",
    "C-30 Z-2",
    "G2 X5 Y5 R20 F500",
    "G3 I5 J0 F800",
    "G3 X4 Z-4 I2 J2 P2 F800",
    "G2 C10 Z5 R40 F700",
    "G3 C20 K4 J1 F700",
    "G7.1 C20",
    "G7.1 C35.5",
    "G7.1 C0",
    "M3 S600",
    "M4 S300",
    "M5",
    "G33 Z-8 K1.5",
    "G33 X2 I2",
    "Z-12",
    "G84 X2 Z-5 R1 F600",
    "G81 X3 Z-4 R2 F300",
    "G73 Z-6 R1 Q2",
    "G80",
    "G96 S100",
    "G97 S400",
    "G92 S900",
    "G95 F0.2",
    "G94 F500",
    "G93 G1 X2 F30",
    "G1 Z-1 F400 E100",
    "G41 D1",
    "G40",
    "G43 H1",
    "G49",
    "G51 X0 Y0 Z0 P2",
    "G50",
    "G51.1 X2",
    "G50.1",
    "G68 X0 Y0 R30",
    "G69",
    "G90",
    "G91",
    "G53 G0 X1",
    "G55",
    "G54",
    "G92 X3",
    "G92.1",
    "G10 L2 P1 X1",
    "G61",
    "G64 P0.01",
    "G4 P10",
    "G4 S2",
    "G9 X7",
    "G120 X3",
    "G28 Z4",
    "M10",
    "M66 P1 L0",
    "CI5 = 3",
    "T1 M6",
    "M0",
    "writeln \"a\", CI5",
    "G20",
    "G21",
];

/// X Y Z C, the spindle axis S, and a spindle drive D on its motor command.
fn loaded(flags: u32) -> Machine {
    let on = |bit: u32| flags >> bit & 1 == 1;
    let mut machine = common::example("mill4c");
    let mut spindle = machine.axes[3].clone();
    (spindle.name, spindle.letter, spindle.rapid, spindle.acceleration) = ("S".to_owned(), None, 18_000.0, 50_000.0);
    (spindle.maxvel, spindle.maxacc, spindle.mdvel, spindle.mpe) = (0.0, 0.0, 0.0, 1e6);
    // the same loop gain at another drive
    let slower = spindle.plant.full_speed / 20_000.0;
    spindle.plant.full_speed = 20_000.0;
    let pidf = &mut spindle.pidf;
    (pidf.kp, pidf.kfcv, pidf.kfca) = (pidf.kp * slower, pidf.kfcv * slower, pidf.kfca * slower);
    let drive = motion_kernel::machine::Axis { name: "D".to_owned(), ..spindle.clone() };
    machine.axes.extend([spindle, drive]);
    machine.axes.iter_mut().for_each(|a| a.limits = None);
    machine.axes[3].modulo = on(0);
    let gcode = &mut machine.gcode;
    gcode.spindle.axis = on(1).then_some(4);
    gcode.spindle.command = on(2).then_some((5, 4000.0));
    gcode.spindle.limit = 2000.0;
    gcode.position_factors = vec![if on(3) { -1.0 } else { 1.0 }; 6];
    gcode.nfrax = if on(4) { vec![3] } else { Vec::new() };
    gcode.tools[0] = motion_kernel::machine::Tool { number: 1, length: 5.0, radius: 1.0 };
    gcode.g_functions = vec![(1200, "5".to_owned())];
    if on(5) {
        gcode.modereg &= !ModeReg::RotatoricUnit.0;
    }
    gcode.dialect = DialectOptions {
        rapid_blend: Some(on(6)),
        exact_in_position: Some(on(7)),
        end_feed: Some(true),
        corner_angle: on(8).then_some(20.0),
        thread_as_feed: Some(true),
        tapping_floating: Some(true),
        ..DialectOptions::default()
    };
    machine
}

fn check(program: &Program, machine: &Machine) -> Result<(), TestCaseError> {
    for mv in &program.moves {
        let targets = program.targets_of(mv);
        let sound = targets.iter().chain(&mv.center).all(|v| v.is_finite()) && mv.phi.is_finite();
        prop_assert!(sound && mv.vl > 0.0 && mv.vl.is_finite() && mv.ac > 0.0 && mv.ac.is_finite(), "{mv:?}");
        prop_assert!(mv.tvl >= 0.0 && mv.tvl <= mv.vl * (1.0 + 1e-12), "{mv:?}");
    }
    let columns = sequence(program, machine);
    prop_assert!(columns.target.iter().chain(&columns.center).all(|v| v.is_finite()));
    prop_assert_eq!(listing_json(program, machine).filter(|l| l.contains("\"vl\"")).count(), program.moves.len());
    Ok(())
}

fn run(program: Program, machine: Machine) -> Result<(), TestCaseError> {
    let mut mcu = Mcu::new(Arc::new(machine));
    mcu.prepare_gcode();
    mcu.load(0, Arc::new(program));
    mcu.startcnct(0);
    let mut trace = Trace::new(6, 1 << 14);
    for _ in 0..60 {
        trace.restart(mcu.samples());
        match mcu.advance(1 << 14, &mut trace).stop {
            Stop::Finished => {
                let names: Vec<&str> = mcu.errorreg().names().collect();
                prop_assert!(mcu.errorreg() == ErrorReg(0), "{names:?}");
                return Ok(());
            }
            Stop::Acknowledge { .. } => mcu.acknowledge(),
            Stop::Budget | Stop::Events => {
                mcu.events();
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }
    prop_assert!(false, "not at its end after a million samples");
    Ok(())
}

fn program_text() -> impl Strategy<Value = String> {
    let blocks = prop::collection::vec(prop::sample::select(BLOCKS), 1..14);
    blocks.prop_map(|blocks| format!("{}\nM30\n%L5\nG0 X#24\nM17\n", blocks.join("\n")))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, max_global_rejects: 60_000, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn translation_is_sound(text in program_text(), flags: u32, profile in 0..4usize) {
        let machine = loaded(flags);
        let profile = [Profile::Din, Profile::Fanuc, Profile::Linuxcnc, Profile::Lathe][profile];
        let limits = Limits { commands: 50_000, ..Limits::default() };
        let options = Options { profile: Some(profile), limits, ..Options::default() };
        let compiled = compile(text.as_bytes(), "t.nc", &machine, &options);
        for d in &compiled.diagnostics {
            prop_assert!(d.line >= 1 && d.column >= 1 && d.end_column >= d.column, "{}", d);
        }
        prop_assert_eq!(compiled.program.is_none(), compiled.has_errors());
        if let Some(program) = &compiled.program {
            check(program, &machine)?;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, max_global_rejects: 60_000, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn what_compiles_runs(text in program_text(), flags: u32) {
        let machine = loaded(flags);
        let compiled = compile(text.as_bytes(), "t.nc", &machine, &Options::default());
        prop_assume!(compiled.program.is_some());
        run(compiled.program.expect("assumed"), machine)?;
    }
}
