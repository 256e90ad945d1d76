//! Threads, tapping and the speed of the spindle (docs/dialect.md, sections 6, 8, 13, 16).

mod common;

use std::sync::Arc;

use common::{Command, commands, example, program_for};
use gcode::{Compiled, Options, compile, sequence};
use motion_kernel::machine::Machine;
use motion_kernel::registers::ErrorReg;
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};

/// X Y Z and the spindle axis S: 3000 1/min at most, 50,000 degrees/s2.
fn with_spindle() -> Machine {
    let mut machine = example("mill4c");
    let axis = &mut machine.axes[3];
    (axis.name, axis.letter) = ("S".to_owned(), None);
    (axis.rapid, axis.acceleration, axis.mdvel, axis.maxvel, axis.maxacc) = (18_000.0, 50_000.0, 0.0, 0.0, 0.0);
    (axis.plant.full_speed, axis.mpe) = (20_000.0, 1e6);
    machine.gcode.spindle.axis = Some(3);
    machine
}
/// The spindle hangs on the motor command port of axis 3.
fn with_command() -> Machine {
    let mut machine = with_spindle();
    machine.gcode.spindle.axis = None;
    machine.gcode.spindle.command = Some((3, 4000.0));
    machine
}
fn run_for(text: &str, machine: &Machine) -> Compiled {
    compile(text.as_bytes(), "t.nc", machine, &Options::default())
}
fn found(text: &str, machine: &Machine) -> Vec<(&'static str, u32, u32, u32)> {
    let compiled = run_for(text, machine);
    compiled.diagnostics.iter().map(|d| (d.id, d.line, d.column, d.end_column)).collect()
}
fn all(text: &str, machine: &Machine) -> Vec<Command> {
    commands(&program_for(text, machine, &Options::default()))
}
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs().max(1.0)
}
/// Set points (X Y Z S) of every sample.
fn set_points(text: &str, machine: &Machine) -> Vec<[f64; 4]> {
    let mut mcu = Mcu::new(Arc::new(machine.clone()));
    mcu.prepare_gcode();
    mcu.load(0, Arc::new(program_for(text, machine, &Options::default())));
    mcu.startcnct(0);
    let mut trace = Trace::new(4, 4096);
    let mut rows = Vec::new();
    loop {
        trace.restart(mcu.samples());
        let stop = mcu.advance(4096, &mut trace).stop;
        rows.extend(trace.dp.chunks(4).map(|row| [row[0], row[1], row[2], row[3]]));
        match stop {
            Stop::Finished => break,
            Stop::Acknowledge { .. } => mcu.acknowledge(),
            Stop::Budget | Stop::Events => {}
            other => panic!("{other:?}"),
        }
        assert!(rows.len() < 200_000);
    }
    assert_eq!(mcu.errorreg(), ErrorReg(0), "{:?}", mcu.errorreg().names().collect::<Vec<_>>());
    rows
}

#[test]
fn a_thread_is_one_interpolation_of_spindle_and_feed() {
    let machine = with_spindle();
    let text = "G0 X10 Z2\nM3 S600\nG33 Z-13 K1.5\nG0 X12\nM30\n";
    let program = program_for(text, &machine, &Options::default());
    let mv = &program.moves[1];
    // 15 mm / 1.5 mm are 10 turns, one second at 600 1/min
    assert_eq!(program.targets_of(mv), [10.0, 0.0, -13.0, 3600.0]);
    let path = 15f64.hypot(3600.0 * machine.axes[3].effradius.to_radians());
    assert!(close(mv.vl, path) && mv.tvl == 0.0 && !mv.rapid, "{mv:?}");
    // the spindle's acceleration binds, not that of the path
    assert!(close(mv.ac, 50_000.0 * path / 3600.0), "{mv:?}");
    let functions: Vec<(u16, f64)> = commands(&program)
        .into_iter()
        .filter_map(|c| match c {
            Command::Ssf { command, value, .. } if command >= 1000 => Some((command, value)),
            _ => None,
        })
        .collect();
    // S, M03, its outputs off before the thread and on again behind, everything off at the end
    let want = [(20200, 600.0), (1002, 2.0), (1001, 1.0), (1002, 3.0), (1002, 2.0), (1001, 1.0), (1002, 15.0)];
    assert_eq!(functions, want);
    // every other motion names the spindle with its present angle
    assert_eq!(program.targets_of(&program.moves[2]), [12.0, 0.0, -13.0, 3600.0]);
}

#[test]
fn spindle_and_feed_stay_in_step_in_every_sample() {
    let machine = with_spindle();
    for (start, sense) in [("M3", 1.0), ("M4", -1.0)] {
        let rows = set_points(&format!("G0 Z2\n{start} S1200\nG33 Z-18 K2\nG0 X5\nM30\n"), &machine);
        let worst = rows.iter().filter(|p| p[3] != 0.0).map(|p| (p[3] / 360.0 - sense * (2.0 - p[2]) / 2.0).abs());
        assert!(worst.fold(0.0, f64::max) < 1e-9);
        let fastest = rows.windows(2).map(|w| (w[1][3] - w[0][3]).abs() / 0.00128 / 6.0).fold(0.0, f64::max);
        assert!((fastest - 1200.0).abs() < 1e-6, "{fastest}");
    }
}

#[test]
fn chained_threads_do_not_stop_and_keep_their_lead() {
    let machine = with_spindle();
    let program = program_for("M3 S600\nG33 Z-10 K2\nX1 Z-20\nZ-30 K2\nM30\n", &machine, &Options::default());
    let [one, two, three] = &program.moves[..] else { panic!() };
    assert!(one.tvl > 0.0 && two.tvl > 0.0 && three.tvl == 0.0);
    let turns: Vec<f64> = program.moves.iter().map(|m| program.targets_of(m)[3] / 360.0).collect();
    assert_eq!(turns, [5.0, 10.0, 15.0]);
    let other = all("M3 S600\nG19 G33 X-10 I2\nM30\n", &machine);
    assert!(other.iter().any(|c| matches!(c, Command::Line { to, .. } if to == &[-10.0, 0.0, 0.0, 1800.0])));
    let inch = all("G20 M3 S600\nG33 Z-1 K0.1\nM30\n", &machine);
    assert!(inch.iter().any(|c| matches!(c, Command::Line { to, .. } if close(to[2], -25.4) && close(to[3], 3600.0))));
}

#[test]
fn tapping_turns_back_the_way_it_came() {
    let machine = with_spindle();
    for (text, lead) in [("G84 X10 Z-9 R1 F600", 1.0), ("G95 G84 X10 Z-9 R1 F1.25", 1.25)] {
        let program = program_for(&format!("G0 Z5\nM3 S600\n{text}\nX20\nG80\nM30\n"), &machine, &Options::default());
        let ends: Vec<&[f64]> = program.moves.iter().map(|m| program.targets_of(m)).collect();
        let turn = 360.0 * 10.0 / lead;
        let want = [
            [0.0, 0.0, 5.0, 0.0],
            [10.0, 0.0, 5.0, 0.0],
            [10.0, 0.0, 1.0, 0.0],
            [10.0, 0.0, -9.0, turn],
            [10.0, 0.0, 1.0, 0.0],
            [10.0, 0.0, 5.0, 0.0],
            [20.0, 0.0, 5.0, 0.0],
            [20.0, 0.0, 1.0, 0.0],
            [20.0, 0.0, -9.0, turn],
            [20.0, 0.0, 1.0, 0.0],
            [20.0, 0.0, 5.0, 0.0],
        ];
        assert!(
            ends.len() == want.len()
                && ends.iter().zip(&want).all(|(a, b)| a.iter().zip(b).all(|(a, b)| close(*a, *b))),
            "{ends:?}"
        );
        assert!(program.moves.iter().all(|m| m.tvl == 0.0));
    }
    // left-hand, with a dwell at the bottom
    let left = all("G0 Z5\nM4 S600\nG84 Z-9 R1 P500 F600\nM30\n", &machine);
    assert!(left.iter().any(|c| matches!(c, Command::Line { to, .. } if close(to[3], -3600.0))));
    assert_eq!(left.iter().filter(|c| matches!(c, Command::Ssf { command: 1003, .. })).count(), 1);
    let rows = set_points("G0 Z5\nM3 S600\nG84 X3 Z-9 R1 F600\nG80\nM30\n", &machine);
    let worst = rows.iter().filter(|p| p[3] != 0.0).map(|p| (p[3] / 360.0 - (1.0 - p[2])).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9 && rows.iter().any(|p| p[3] > 3599.0), "{worst}");
}

#[test]
fn what_a_thread_needs() {
    let (machine, mill) = (with_spindle(), common::mill3());
    assert_eq!(found("M3 S600\nG33 Z-20 K1.5\nM30\n", &mill), [("GC308", 2, 1, 3)]);
    assert_eq!(found("M3 S600\nG84 Z-20 R1 F600\nM30\n", &mill), [("GC308", 2, 1, 3)]);
    assert_eq!(
        found("G34 Z-5 K1\nG63 Z-5\nG74 Z0 R1\nM30\n", &machine).iter().map(|f| f.0).collect::<Vec<_>>(),
        ["GC308"; 3]
    );
    assert_eq!(found("G33 Z-20 K1.5\nM30\n", &machine), [("GC505", 1, 1, 13)], "the spindle stands");
    assert_eq!(found("M3\nG33 Z-20 K1.5\nM30\n", &machine), [("GC505", 2, 1, 13)], "no S");
    assert_eq!(found("M3 S600\nG33 Z-20\nM30\n", &machine), [("GC310", 2, 1, 3)]);
    assert_eq!(found("M3 S600\nG33 Z-20 I1.5\nM30\n", &machine), [("GC326", 2, 10, 13)], "X does not move");
    assert_eq!(found("M3 S600\nG33 X1 Z-20 I1 K1.5\nM30\n", &machine), [("GC326", 2, 16, 19)]);
    assert_eq!(found("M3 S600\nG33 Z-20 K0\nM30\n", &machine), [("GC216", 2, 10, 11)]);
    assert_eq!(found("M3 S4000\nG33 Z-20 K1\nM30\n", &machine), [("GC515", 2, 1, 11)]);
    assert_eq!(found("M3 S600\nG84 Z-20 R1 Q5 F600\nM30\n", &machine), [("GC326", 2, 13, 14)]);
    assert_eq!(found("M3 S1000\nG33 Z-50 K10\nM30\n", &machine), [("GW925", 2, 1, 12)], "100 mm/s at most");
}

#[test]
fn the_speed_limit_of_the_machine() {
    let mut machine = common::mill3();
    machine.gcode.spindle.limit = 2000.0;
    assert_eq!(found("M3 S2500\nM30\n", &machine), [("GC515", 1, 4, 8)]);
    assert_eq!(found("G96 S200\nM3\nM30\n", &machine), [], "it is the limit of G96 too");
    let first = |text: &str| match &all(text, &machine)[0] {
        Command::Ssf { command: 20200, value, .. } => *value,
        other => panic!("{other:?}"),
    };
    // 200 m/min at 0.1 mm is far above
    assert_eq!(first("G96 S200 M3\nM30\n"), 2000.0);
    assert_eq!(first("G92 S500\nG96 S200 M3\nM30\n"), 500.0);
    assert_eq!(first("G92 S9000\nG96 S200 M3\nM30\n"), 2000.0);
}

#[test]
fn threads_and_taps_without_a_spindle_axis_by_option() {
    let mut machine = common::mill3();
    machine.gcode.dialect.thread_as_feed = Some(true);
    machine.gcode.dialect.tapping_floating = Some(true);
    let text = "G0 Z2\nM3 S600\nG33 Z-13 K1.5\nM30\n";
    assert_eq!(found(text, &machine), [("GW916", 3, 1, 3)]);
    let line =
        all(text, &machine).into_iter().filter(|c| matches!(c, Command::Line { rapid: false, .. })).collect::<Vec<_>>();
    assert!(
        matches!(&line[..], [Command::Line { to, vl, .. }] if to == &[0.0, 0.0, -13.0] && close(*vl, 15.0)),
        "{line:?}"
    );
    let text = "G0 Z5\nM3 S600\nG84 Z-9 R1 F600\nG80\nM30\n";
    assert_eq!(found(text, &machine), [("GW919", 3, 1, 3)]);
    let kinds: Vec<String> = all(text, &machine)
        .iter()
        .filter_map(|c| match c {
            Command::Line { to, rapid, .. } => Some(format!("{} {}", if *rapid { "rapid" } else { "feed" }, to[2])),
            Command::Ssf { command: 1001, value, .. } => Some(format!("on {value}")),
            _ => None,
        })
        .collect();
    assert_eq!(kinds, ["rapid 5", "on 1", "rapid 1", "feed -9", "on 2", "feed 1", "on 1", "rapid 5"]);
}

#[test]
fn the_motor_command_takes_the_speed_with_its_sign() {
    let machine = with_command();
    let values: Vec<f64> = all("S1000\nM3\nS2000\nM4\nM5\nM3\nM30\n", &machine)
        .iter()
        .filter_map(|c| match c {
            Command::Ssf { command: 1203, value, .. } => Some(*value),
            _ => None,
        })
        .collect();
    assert_eq!(values, [0.0, 8192.0, 16384.0, -16384.0, 0.0, 16384.0, 0.0]);
    let mut mcu = Mcu::new(Arc::new(machine.clone()));
    mcu.prepare_gcode();
    mcu.load(0, Arc::new(program_for("S2000 M3\nG4 X2\nG1 X5 F600\nM30\n", &machine, &Options::default())));
    mcu.startcnct(0);
    mcu.advance(1200, &mut Trace::new(4, 1200));
    assert_eq!(mcu.rdmcp(3), 16384);
    assert!((mcu.rdrv(3) - 10_000.0).abs() < 20.0, "half of 20,000 degrees/s: {}", mcu.rdrv(3));
    let columns = sequence(&program_for("G1 X5 F600\nM30\n", &machine, &Options::default()), &machine);
    assert_eq!(columns.effradius[3], 0.0, "it is no part of the path");
}

#[test]
fn the_spindle_runs_up_before_the_program_goes_on() {
    let mut machine = common::mill3();
    machine.gcode.spindle.dwell_s = 0.5;
    let waits = all("M3 S100\nG1 X1 F100\nM5\nM4\nM30\n", &machine);
    let waits: Vec<u32> = waits
        .iter()
        .filter_map(
            |c| if let Command::Ssf { line, command: 1003, value: 7813.0, .. } = c { Some(*line) } else { None },
        )
        .collect();
    assert_eq!(waits, [1, 4]);
}

#[test]
fn a_facing_move_is_split_where_the_speed_changes() {
    let mut machine = common::mill3();
    machine.gcode.spindle.limit = 3000.0;
    let text = "G0 X100\nG96 S200 M3\nG95 G1 X5 F0.2\nM30\n";
    let mut speed = 0.0;
    let (mut pieces, mut from, mut time) = (Vec::new(), 100.0, 0.0);
    for command in all(text, &machine) {
        match command {
            Command::Ssf { command: 20200, value, .. } => speed = value,
            Command::Line { to, vl, rapid: false, line: 3, .. } => {
                let diameter: f64 = from + to[0]; // twice the mean radius
                let want = (200_000.0 / (std::f64::consts::PI * diameter)).min(3000.0);
                assert!(close(speed, want) && close(vl, 0.2 * want / 60.0), "{speed} {want} {vl}");
                pieces.push(speed);
                time += (from - to[0]) / vl;
                from = to[0];
            }
            _ => {}
        }
    }
    assert_eq!(from, 5.0);
    assert!(pieces.len() > 20 && pieces.windows(2).all(|w| w[1] >= w[0] && w[1] / w[0] < 1.06), "{pieces:?}");
    // in one piece it would be the speed of the middle: the whole takes the integral of dx / (f n)
    let least = 200_000.0 / (2.0 * std::f64::consts::PI * 3000.0);
    let exact = (100f64.powi(2) - least * least) * std::f64::consts::PI / 200_000.0 / 0.2 * 60.0
        + (least - 5.0) / (0.2 * 3000.0 / 60.0);
    assert!((time / exact - 1.0).abs() < 1e-3, "{time} {exact}");
    let compiled = run_for(text, &machine);
    assert_eq!((compiled.facts.motion_blocks, compiled.diagnostics.len()), (2, 0));
    // G93 is a time for the whole block: one piece
    let one = all("G0 X100\nG96 S200 M3\nG93 G1 X5 F2\nM30\n", &machine);
    assert_eq!(one.iter().filter(|c| matches!(c, Command::Line { line: 3, .. })).count(), 1);
}

#[test]
fn a_dwell_in_turns_of_the_spindle() {
    let waits = all("M3 S600\nG4 S5\nM30\n", &common::mill3());
    assert!(waits.contains(&Command::Ssf { line: 2, axes: vec![0, 1, 2], command: 1003, value: 7813.0 }));
    assert_eq!(found("G4 S5\nM30\n", &common::mill3()), [("GC505", 1, 1, 5)]);
    assert_eq!(found("M3 S100\nG4 S5 X1\nM30\n", &common::mill3()), [("GC508", 2, 4, 5)]);
}
