//! Checks part programs, or times it: `cargo run --release --example check -- [--time] [--machine FILE] [--profile P] FILE...`

use std::time::Instant;

use gcode::{Options, compile, listing_text};
use motion_kernel::machine::{Machine, Profile};

fn main() {
    let mut options = Options::default();
    let (mut machine, mut time, mut list, mut files) = (Machine::builtin(), false, false, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--time" => time = true,
            "--list" => list = true,
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
            listing_text(program, &machine).for_each(|row| println!("{row}"));
        }
    }
}
