//! Linear time of spooling and planning, up to a million entries: `cargo bench -p motion_kernel --bench planning`.
//! One line a size: entries, seconds to accept and to plan them, ns an entry; then the exponents of a power law.
//!
//! Planning is measured as the whole run of lines that take a little more than a sample each, less what as many samples
//! of one long line cost. Fewer entries would sit in the caches of the processor and look cheaper than they are.

use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::functions::Entered;
use motion_kernel::machine::{AxisKind, Machine};
use motion_kernel::motion::MotionCommand;
use motion_kernel::registers::ModeReg;
use motion_kernel::{Mcu, Stop};
use std::sync::Arc;
use std::time::Instant;

const SIZES: [u32; 3] = [250_000, 500_000, 1_000_000];
const VL: f64 = 50.0;
const LENGTH: f64 = 0.07;

/// Three axes with spool memory for `entries` lines, everything closed, look-ahead on.
fn controller(entries: u32) -> Mcu {
    let mut machine = Machine::builtin();
    machine.controller.spool_memory_bytes = 96 * entries;
    for axis in &mut machine.axes {
        (axis.kind, axis.limits) = (AxisKind::Linear, None);
    }
    let mut mcu = Mcu::new(Arc::new(machine));
    mcu.cl(AxisSet::first(3));
    mcu.set_modereg(ModeReg::LookAhead | ModeReg::ExactTargetPos);
    mcu
}

fn line(mcu: &mut Mcu, targets: &[f64; 3], tvl: f64) {
    let axes = &AxisList::new(&[0, 1, 2]);
    let entered = mcu.spool(&MotionCommand {
        kind: MoveKind::Smla,
        axes,
        targets,
        center: [0.0; 2],
        phi: 0.0,
        vl: VL,
        ac: 500.0,
        tvl,
        rapid: false,
        line: 1,
    });
    assert_eq!(entered, Entered::Yes);
}

/// Seconds until all motion has ended, and the samples it took.
fn finish(mcu: &mut Mcu) -> (f64, u64) {
    let begin = Instant::now();
    mcu.ssms(AxisSet::first(3));
    let mut trace = motion_kernel::trace::Trace::new(3, 1000);
    while mcu.advance(1000, &mut trace).stop != Stop::Finished {}
    (begin.elapsed().as_secs_f64(), mcu.samples())
}

/// Seconds to accept `entries` lines of a wide spiral, and to plan them.
fn measure(entries: u32) -> (f64, f64) {
    let mut mcu = controller(entries);
    let begin = Instant::now();
    for n in 1..=entries {
        let angle = f64::from(n) * 1e-4;
        let radius = LENGTH / 1e-4;
        line(&mut mcu, &[radius * angle.sin(), radius * (1.0 - angle.cos()), f64::from(n) * -1e-6], VL);
    }
    let accepted = begin.elapsed().as_secs_f64();
    let (seconds, samples) = finish(&mut mcu);
    assert!(mcu.planning_steps() >= u64::from(entries) - 1, "all of them are planned");
    let mut plain = controller(1000);
    line(&mut plain, &[f64::from(entries) * LENGTH, 0.0, 0.0], 0.0);
    let (idle, of_plain) = finish(&mut plain);
    (accepted, seconds - idle * samples as f64 / of_plain as f64)
}

fn main() {
    // the best of three, each for itself
    let rows = SIZES.map(|entries| {
        let runs = [measure(entries), measure(entries), measure(entries)];
        let best = |of: fn(&(f64, f64)) -> f64| runs.iter().map(of).fold(f64::INFINITY, f64::min);
        (best(|run| run.0), best(|run| run.1))
    });
    for (entries, (accepted, planned)) in SIZES.iter().zip(rows) {
        let per_entry = 1e9 / f64::from(*entries);
        println!(
            "{entries:8} entries  accepted in {accepted:6.3} s ({:5.0} ns each), planned in {planned:6.3} s ({:5.0} ns each)",
            accepted * per_entry,
            planned * per_entry
        );
    }
    let exponent = |from: f64, to: f64| (to / from).ln() / f64::from(SIZES[2] / SIZES[0]).ln();
    println!(
        "time ~ entries ^ {:.2} to accept, ^ {:.2} to plan",
        exponent(rows[0].0, rows[2].0),
        exponent(rows[0].1, rows[2].1)
    );
}
