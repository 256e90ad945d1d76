//! Samples a second of the kernel with the loop closed and the trace kept: `cargo bench -p motion_kernel [-- CASE..]`.
//! One line a case: name, samples, then of the median slice samples/s, ns a sample, and a sample as a number of dependent
//! additions in the same process, a figure that a busy machine changes little.

use motion_kernel::autocode::{Builder, Instr, Move, MoveKind, Program};
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::machine::Machine;
use motion_kernel::registers::Options;
use motion_kernel::resources::{Code, ObjectDescriptor, READ, Type, WRITE};
use motion_kernel::stimulus::Stimulus;
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};
use std::sync::Arc;
use std::time::Instant;

/// Samples and additions of a slice.
const SLICE: u64 = 1000;
const ADDITIONS: u32 = 50_000;

/// A program of `blocks` moves of the first `N` axes; `write` fills in targets and shape of block n.
fn program<const N: usize>(blocks: u32, write: impl Fn(u32, &mut Move) -> [f64; N]) -> Arc<Program> {
    let mut builder = Builder::new(AxisSet::first(N), 100);
    let axes = builder.axis_list(AxisList::new(&std::array::from_fn::<_, N, _>(|a| a)));
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
/// Lines of all axes that the controller can have.
fn eighteen_axes() -> Arc<Program> {
    program::<18>(200, |n, _| if n % 2 == 1 { std::array::from_fn(|a| 10.0 * a as f64) } else { [0.0; 18] })
}
/// Lines of all axes, of about 5 samples each.
fn eighteen_axes_short() -> Arc<Program> {
    program::<18>(20_000, |n, _| {
        let angle = f64::from(n) * 0.002;
        std::array::from_fn(|a| if a % 2 == 0 { 50.0 * angle.cos() - 50.0 } else { 50.0 * angle.sin() })
    })
}

/// A machine of servo axes in closed loop.
fn machine(axes: usize) -> Machine {
    let mut machine = Machine::builtin();
    machine.axes = (0..axes).map(|a| machine.axes[a % 3].clone()).collect();
    machine.gcode.offsets = std::array::from_fn(|_| vec![0.0; axes]);
    machine
}

/// Uses of the resource interface that are over: a scan, a gear, a flying saw, the DMA latch.
fn used_resources(mcu: &mut Mcu) {
    mcu.resources_mut().options = Options::RESOURCE | Options::GEAR | Options::DMARTS | Options::EP1K50;
    scan_dp(mcu);
    mcu.scan(&[]).expect("the end of a scan");
    mcu.wrGCR(0, 1);
    mcu.wrGCR(0, 0);
    for (device, index, sub, kind, value) in [
        (7000, 6, 2, Type::Double, 50.0),
        (7000, 1, 2, Type::Integer, 1.0),
        (7000, 1, 2, Type::Integer, 0.0),
        (8001, 0, 0, Type::Integer, 1.0),
        (8000, 0, 0, Type::Integer, 1.0),
    ] {
        let mut d = ObjectDescriptor::new(device, index, sub, kind, WRITE);
        let done =
            if kind == Type::Double { mcu.wrOptionDbl(&mut d, value) } else { mcu.wrOptionInt(&mut d, value as i32) };
        assert_eq!(done, Code::Ok, "{d:?}");
    }
}
/// Three resources a sample.
fn scan_dp(mcu: &mut Mcu) {
    let chosen = (0..3).map(|axis| {
        let mut d = ObjectDescriptor::new(1, axis, 0, Type::Double, READ);
        mcu.rdOptionDbl(&mut d).expect("dp can be read");
        (axis.to_string(), d)
    });
    let chosen: Vec<_> = chosen.collect();
    mcu.scan(&chosen).expect("dp can be scanned");
}
/// The DMA latch at 10 kHz, scanned.
fn latch_fast(mcu: &mut Mcu) {
    mcu.resources_mut().options = Options::RESOURCE | Options::DMARTS | Options::EP1K50;
    let rules = Stimulus::parse("at 0 s: input 14 pulsing 10 kHz", &["X", "Y", "Z"]).expect("a rule");
    mcu.add_stimulus(&rules);
    let mut block = ObjectDescriptor::new(8013, 3 | 7 << 16, 16, Type::DataBlock, READ);
    assert_eq!(mcu.rdOptionInt(&mut block), Err(Code::Busy));
    mcu.scan(&[("block".to_owned(), block)]).expect("a block can be scanned");
    assert_eq!(mcu.wrOptionInt(&mut ObjectDescriptor::new(8001, 0, 0, Type::Integer, WRITE), 1), Code::Ok);
}

/// Seconds of [`ADDITIONS`] additions of which each waits for the one before: the measure of this machine just now.
fn additions_s() -> f64 {
    let step = std::hint::black_box(1e-9);
    let begin = Instant::now();
    std::hint::black_box((0..ADDITIONS).fold(0.0, |sum, _| sum + step));
    begin.elapsed().as_secs_f64()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Runs a case in short slices with a slice of additions after each; only the cases that the command line asks for, if
/// it does.
fn measure(name: &str, axes: usize, program: fn() -> Arc<Program>) {
    measure_with(name, axes, program, |_| {});
}

fn measure_with(name: &str, axes: usize, program: fn() -> Arc<Program>, prepare: impl Fn(&mut Mcu)) {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    if !wanted.is_empty() && !wanted.iter().any(|w| name.contains(w.as_str())) {
        return;
    }
    let program = program();
    let mut mcu = Mcu::new(Arc::new(machine(axes)));
    mcu.prepare_gcode();
    mcu.load(0, program);
    mcu.startcnct(0);
    prepare(&mut mcu);
    let mut trace = Trace::new(axes, SLICE as usize);
    let (mut samples_s, mut addition_s) = (Vec::new(), Vec::new());
    loop {
        let begin = Instant::now();
        let stop = mcu.advance(SLICE, &mut trace).stop;
        samples_s.push(begin.elapsed().as_secs_f64() / SLICE as f64);
        addition_s.push(additions_s() / f64::from(ADDITIONS));
        if stop != Stop::Budget {
            break;
        }
    }
    let (samples, sample_s, addition_s) = (mcu.samples(), median(samples_s), median(addition_s));
    println!(
        "{name:16}{samples:9} samples {:7.2} M/s {:8.1} ns {:6.0} additions",
        1e-6 / sample_s,
        1e9 * sample_s,
        sample_s / addition_s
    );
}

fn main() {
    measure("long lines", 3, long_lines);
    measure_with("long, used", 3, long_lines, used_resources);
    measure_with("long, scan of 3", 3, long_lines, scan_dp);
    measure_with("long, 10 kHz", 3, long_lines, latch_fast);
    measure("short blocks", 3, short_blocks);
    measure("arcs", 3, arcs);
    measure("18 axes", 18, eighteen_axes);
    measure("18 axes, short", 18, eighteen_axes_short);
}
