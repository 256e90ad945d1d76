//! Checks part programs, times it or runs it: `cargo run --release --example check -- [--time] [--run] [--machine FILE] [--profile P] FILE...`

use std::sync::Arc;
use std::time::Instant;

use gcode::{Options, Sheet, compile};
use motion_kernel::autocode::Program;
use motion_kernel::machine::{Machine, Profile};
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};

fn main() {
    let mut options = Options::default();
    let (mut machine, mut time, mut list, mut run) = (Machine::builtin(), false, false, false);
    let mut files = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--time" => time = true,
            "--list" => list = true,
            "--run" => run = true,
            "--check-only" => options.check_only = true,
            "--machine" => {
                let text = std::fs::read(arguments.next().expect("a machine file")).expect("readable");
                machine = Machine::parse(&text).expect("a valid machine file");
            }
            "--profile" => {
                options.profile = Some(match arguments.next().as_deref() {
                    Some("fanuc") => Profile::Fanuc,
                    Some("linuxcnc") => Profile::Linuxcnc,
                    Some("lathe") => Profile::Lathe,
                    _ => Profile::Din,
                });
            }
            _ => files.push(argument),
        }
    }
    for file in files {
        let source = std::fs::read(&file).expect("readable");
        let start = Instant::now();
        let compiled = compile(&source, &file, &machine, &options);
        let seconds = start.elapsed().as_secs_f64();
        if time {
            let rate = f64::from(compiled.facts.lines) / seconds / 1e6;
            println!("{file}: {} lines in {seconds:.4} s, {rate:.2} million lines/s", compiled.facts.lines);
            continue;
        }
        compiled.diagnostics.iter().for_each(|d| println!("{d}"));
        let errors = compiled.diagnostics.iter().filter(|d| !d.is_warning()).count();
        let merged = compiled.facts.merged;
        let motions = compiled.facts.motion_blocks;
        println!(
            "{file}: {errors} errors, {motions} motion blocks, {} merged ({:.5} mm)",
            merged.blocks, merged.max_mm
        );
        if let (Some(program), true) = (&compiled.program, list) {
            let mut sheet = Sheet::new(program, &machine, &source, false);
            while let Some(piece) = sheet.piece(program, &machine, &source) {
                print!("{piece}");
            }
        }
        if let (Some(program), true) = (compiled.program, run) {
            println!("{file}: {}", execute(program, &machine));
        }
    }
}

/// Runs a program on the emulated controller: how it ended, samples, bits in ErrorReg.
fn execute(program: Program, machine: &Machine) -> String {
    let mut mcu = Mcu::new(Arc::new(machine.clone()));
    mcu.prepare_gcode();
    mcu.load(0, Arc::new(program));
    mcu.startcnct(0);
    let mut trace = Trace::new(machine.axes.len(), 4096);
    for _ in 0..20_000 {
        trace.restart(mcu.samples());
        match mcu.advance(4096, &mut trace).stop {
            Stop::Budget => {}
            Stop::Acknowledge { .. } => mcu.acknowledge(),
            stop => {
                let bits: Vec<&str> = mcu.errorreg().names().collect();
                return format!("{stop:?} after {} samples, ErrorReg {bits:?}", mcu.samples());
            }
        }
    }
    "not at the end".to_owned()
}
