//! Samples a second of the kernel with the loop closed: `cargo bench -p motion_kernel`.
//! One line a case: name, samples, samples/s, ns a sample, times real time.

use motion_kernel::autocode::{Builder, Instr, Move, MoveKind, Program};
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::machine::Machine;
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};
use std::sync::Arc;
use std::time::Instant;

/// A program of `blocks` moves of X Y Z; `write` fills in targets and shape of block n.
fn program(blocks: u32, write: impl Fn(u32, &mut Move) -> [f64; 3]) -> Arc<Program> {
    let mut builder = Builder::new(AxisSet::first(3), 100);
    let axes = builder.axis_list(AxisList::new(&[0, 1, 2]));
    for n in 1..=blocks {
        let tvl = if n < blocks { 50.0 } else { 0.0 };
        let mut mv = Move {
            kind: MoveKind::Smla,
            rapid: false,
            axes,
            target: 0,
            vl: 50.0,
            ac: 1000.0,
            tvl,
            phi: 0.0,
            center: [0.0; 2],
            vias: (0, 0),
        };
        let end = write(n, &mut mv);
        mv.target = builder.numbers(&end);
        builder.spool(n, mv);
    }
    builder.emit(blocks + 1, Instr::Halt);
    Arc::new(builder.finish())
}

/// Long lines there and back.
fn long_lines() -> Arc<Program> {
    program(400, |n, _| if n % 2 == 1 { [300.0, 200.0, -100.0] } else { [0.0; 3] })
}
/// Lines of about 0.1 mm along a spiral.
fn short_blocks() -> Arc<Program> {
    program(200_000, |n, _| {
        let angle = f64::from(n) * 0.002;
        [50.0 * angle.cos() - 50.0, 50.0 * angle.sin(), f64::from(n) * -1e-5]
    })
}
/// Half circles.
fn arcs() -> Arc<Program> {
    program(2000, |n, mv| {
        let start = if n % 2 == 1 { 0.0 } else { 40.0 };
        (mv.kind, mv.phi, mv.center) = (MoveKind::Smha, 180.0, [20.0, 0.0]);
        [40.0 - start, 0.0, -f64::from(n) * 0.01]
    })
}

/// Measures a case unless the command line asks for others.
fn measure(name: &str, program: fn() -> Arc<Program>) {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    if !wanted.is_empty() && !wanted.iter().any(|w| name.contains(w.as_str())) {
        return;
    }
    let program = program();
    let mut mcu = Mcu::new(Arc::new(Machine::builtin()));
    mcu.prepare_gcode();
    mcu.load(0, program);
    mcu.startcnct(0);
    let mut trace = Trace::new(3, 1000);
    let begin = Instant::now();
    while mcu.advance(1000, &mut trace).stop == Stop::Budget {}
    let seconds = begin.elapsed().as_secs_f64();
    let samples = mcu.samples() as f64;
    let real_time = samples * mcu.sample_time_s() / seconds;
    println!(
        "{name:14} {samples:10.0} samples  {:6.2} M/s  {:6.1} ns  {real_time:8.0} x real time",
        samples / seconds / 1e6,
        seconds / samples * 1e9
    );
}

fn main() {
    measure("long lines", long_lines);
    measure("short blocks", short_blocks);
    measure("arcs", arcs);
}
