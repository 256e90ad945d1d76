//! Compiled programs on the emulated controller: they run to the end, without a bit in ErrorReg, and end where programmed.

mod common;

use std::sync::Arc;

use common::{ends, example, mill3, program_for};
use gcode::Options;
use motion_kernel::machine::Machine;
use motion_kernel::registers::ErrorReg;
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};
use proptest::prelude::*;

/// Runs a program; set points of every sample, one row per axis order of the machine.
fn run(text: &str, machine: Machine) -> (Vec<Vec<f64>>, Mcu) {
    let program = Arc::new(program_for(text, &machine, &Options::default()));
    let mut mcu = Mcu::new(Arc::new(machine));
    mcu.prepare_gcode();
    mcu.load(0, program.clone());
    mcu.startcnct(0);
    let mut trace = Trace::new(mcu.machine().axes.len(), 4096);
    let mut rows = Vec::new();
    for _ in 0..500 {
        trace.restart(mcu.samples());
        let advanced = mcu.advance(4096, &mut trace);
        rows.extend(trace.dp.chunks(trace.axes).map(<[f64]>::to_vec));
        match advanced.stop {
            Stop::Finished => return (rows, mcu),
            Stop::Acknowledge { .. } => mcu.acknowledge(),
            Stop::Budget => {}
            other => panic!("{other:?} in\n{text}"),
        }
    }
    panic!("not at the end after two million samples:\n{text}");
}

fn assert_runs(text: &str, machine: Machine) {
    let last = ends(&program_for(text, &machine, &Options::default())).pop();
    let (rows, mcu) = run(text, machine);
    assert_eq!(mcu.errorreg(), ErrorReg(0), "{:?}\n{text}", mcu.errorreg().names().collect::<Vec<_>>());
    if let (Some(last), Some(row)) = (last, rows.last()) {
        assert!(last.iter().zip(row).all(|(a, b)| (a - b).abs() < 1e-6), "{last:?} {row:?}\n{text}");
    }
}

// shows: gcode.runs-in-cnc-task
#[test]
fn a_part_program_runs_to_its_end() {
    let text = "G17 G90 G54\nT1 M6\nG43 H1 G0 Z20\nM3 S3000 M8\nG0 X-20 Y0\nG1 Z-2 F300\nG41 D0 X0 F600\nG2 X10 Y10 I10\n\
        G3 X10 Y10 I5\nG3 X20 Y0 Z-4 I0 J-10 P2\nG4 P20\nG61 G1 X30\nG64 X40 Y5\nM0\nG81 X50 Y5 Z-8 R2 F200\nX60\nG80\nG0 Z30\nM5 M9\nM30\n";
    assert_runs(text, mill3());
}

#[test]
fn a_corrected_contour_runs() {
    let mut machine = mill3();
    machine.gcode.tools[0].radius = 3.0;
    let text = "T1 M6\nG0 X20 Y15 Z5\nG1 Z-2 F600\nG41 D1 X20 Y0\nX30\nG3 X40 Y10 J10\nG1 Y40\nX0\nG3 X-10 Y30 J-10\nG1 Y0\nX20\n\
        G40 Y15\nM30\n";
    assert_runs(text, machine);
}

#[test]
fn short_blocks_run_without_a_small_profile() {
    let steps: String = (1..=400)
        .map(|i| {
            let a = f64::from(i) * 0.02;
            format!("X{:.4} Y{:.4}\n", 3.0 * a.cos() - 3.0, 3.0 * a.sin())
        })
        .collect();
    assert_runs(&format!("G64 P0.002\nG1 F3000\n{steps}M30\n"), mill3());
}

#[test]
fn rotary_and_linear_axes_run_together() {
    assert_runs("G1 X10 A90 F600\nG0 A-30 Z5\nG93 G1 X0 A0 F20\nG94 A10 F1000\nM30\n", example("mill4a"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    /// Any mixture of lines, arcs, rapids and waits.
    #[test]
    fn generated_programs_run(blocks in prop::collection::vec((0..6u8, -300..300i32, -300..300i32, 1..60i32), 1..40)) {
        let mut text = String::from("G0 Z10\nF1500\n");
        for (kind, a, b, c) in blocks {
            let (x, y) = (f64::from(a) / 10.0, f64::from(b) / 10.0);
            text += &match kind {
                0 => format!("G0 X{x} Y{y}\n"),
                1 => format!("G1 X{x} Y{y} F{}\n", c * 100),
                2 => format!("G2 I{} J{} F{}\n", x / 10.0 + 0.05, y / 10.0, c * 50),
                3 => format!("G91 G1 X{} Y{} F3000\nG90\n", f64::from(a) / 5000.0, f64::from(b) / 5000.0),
                4 => format!("G3 X{x} Y{y} R200 F{}\n", c * 100),
                _ => format!("G4 P{c}\nM8\n"),
            };
        }
        text += "M30\n";
        if !common::run(&text).has_errors() {
            assert_runs(&text, mill3());
        }
    }
}
