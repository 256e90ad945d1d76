//! No allocation inside a sample (design 6): counted by an allocator of its own.
#![allow(unsafe_code)] // a global allocator cannot be written without

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::analysis::LatchInfos;
use motion_kernel::autocode::{Builder, Instr, Move, MoveKind, Program, Ssf};
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::functions::Entered;
use motion_kernel::machine::{Index, Machine};
use motion_kernel::registers::{ControllerFlags, ModeReg, Options};
use motion_kernel::resources::{Code, ObjectDescriptor, READ, Type, WRITE};
use motion_kernel::stimulus::Stimulus;
use motion_kernel::trace::Trace;
use motion_kernel::trajectory::Hmp3d;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

struct Counting;
thread_local! {
    /// Of this thread: the test harness allocates in others.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}
fn count() {
    ALLOCATIONS.set(ALLOCATIONS.get() + 1);
}

// SAFETY: every call goes to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        unsafe { System.dealloc(ptr, layout) }
    }
    unsafe fn realloc(&self, ptr: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(ptr, layout, new_size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Axes of the group and the shape of block n.
struct Job {
    axes: usize,
    blocks: u32,
    shape: fn(u32, &mut Move) -> Vec<f64>,
    /// Every how many blocks the group stops, switches outputs and waits.
    stops: u32,
}

fn program(job: &Job) -> Program {
    let group = AxisSet::first(job.axes);
    let mut builder = Builder::new(group, 100);
    let axes = builder.axis_list(AxisList::new(&(0..job.axes).collect::<Vec<_>>()));
    for n in 1..=job.blocks {
        let stop = n.is_multiple_of(job.stops);
        let (vl, ac, tvl) = (40.0, 500.0, if stop { 0.0 } else { 40.0 });
        let mut mv = Move {
            kind: MoveKind::Smla,
            rapid: false,
            axes,
            target: 0,
            vl,
            ac,
            tvl,
            phi: 0.0,
            center: [0.0; 2],
            vias: (0, 0),
        };
        let end = (job.shape)(n, &mut mv);
        mv.target = builder.numbers(&end);
        builder.spool(n, mv);
        if stop {
            builder.ssf(n, Ssf { axes: group, command: 1003, value: 100.0 });
            builder.ssf(n, Ssf { axes: AxisSet::single(0), command: 1001, value: 1.0 });
        }
    }
    builder.emit(job.blocks + 1, Instr::Halt);
    builder.finish()
}

/// Runs the job on servo axes and counts what `samples` of it allocate.
fn check(job: &Job, samples: u64, modereg: ModeReg) {
    let mut machine = Machine::builtin();
    machine.axes = (0..job.axes).map(|a| machine.axes[a % 3].clone()).collect();
    machine.gcode.offsets = std::array::from_fn(|_| vec![0.0; job.axes]);
    let mut m = Mcu::new(Arc::new(machine));
    m.prepare_gcode();
    m.set_modereg(m.modereg() | modereg);
    m.load(0, Arc::new(program(job)));
    m.startcnct(0);
    let mut trace = Trace::new(job.axes, samples as usize);
    m.advance(10, &mut trace);
    let before = ALLOCATIONS.get();
    let advanced = m.advance(samples, &mut trace);
    let after = ALLOCATIONS.get();
    assert_eq!((advanced.samples, after - before), (samples, 0), "{:?}", advanced.stop);
    assert!(trace.entry[samples as usize - 1] > 1000, "only {} commands", trace.entry[samples as usize - 1]);
    close(trace.factor[0], 1.0, 0.0);
}

/// Lines, arcs, functions and waits, spooled by a task while they run, through a full spooler.
#[test]
fn lines_arcs_and_waits_allocate_nothing() {
    let shape = |n: u32, mv: &mut Move| {
        let x = f64::from(n) * 0.05;
        if n.is_multiple_of(10) {
            (mv.kind, mv.phi, mv.center) = (MoveKind::Smha, 180.0, [x - 0.025, 0.0]);
        }
        vec![x, 0.0, 0.1]
    };
    check(&Job { axes: 3, blocks: 20_000, shape, stops: 300 }, 10_000, ModeReg(0));
}

/// A block a sample, which is the most that the spooler hands over, with S profiles too.
#[test]
fn blocks_of_a_sample_allocate_nothing() {
    let shape = |n: u32, _: &mut Move| {
        let angle = f64::from(n) * 0.001;
        vec![50.0 * angle.cos() - 50.0, 50.0 * angle.sin(), f64::from(n) * -1e-5]
    };
    check(&Job { axes: 3, blocks: 40_000, shape, stops: 5000 }, 20_000, ModeReg(0));
    check(&Job { axes: 3, blocks: 40_000, shape, stops: 5000 }, 20_000, ModeReg::SProfile | ModeReg::NoTriangle);
}

/// All axes that the controller can have.
#[test]
fn eighteen_axes_allocate_nothing() {
    let shape = |n: u32, mv: &mut Move| {
        let at = |k: u32, a: u32| f64::from(k) * 0.002 * f64::from(1 + a % 3);
        if n.is_multiple_of(10) {
            (mv.kind, mv.phi, mv.center) = (MoveKind::Smha, 5.0, [at(n - 1, 0) + 0.5, at(n - 1, 1)]);
        }
        (0..18).map(|a| at(n, a)).collect()
    };
    check(&Job { axes: 18, blocks: 20_000, shape, stops: 500 }, 10_000, ModeReg(0));
}

/// Circles in space, spooled before.
#[test]
fn circles_in_space_allocate_nothing() {
    let mut m = mcu("XYZ", ModeReg::LookAhead);
    let list = AxisList::new(&[0, 1, 2]);
    let circle =
        Hmp3d { vl: 20.0, ac: 500.0, tvl: 20.0, phi: 10.0, dtca1: 5.0, pn2: 1.0, pn3: 1.0, ..Hmp3d::default() };
    (0..500).for_each(|_| assert_eq!(m.smcr3d(&list, &circle), Entered::Yes));
    let mut trace = Trace::new(3, 10_000);
    m.ssms(list.set());
    let before = ALLOCATIONS.get();
    m.pass(10_000, &mut trace);
    assert_eq!(ALLOCATIONS.get() - before, 0);
    assert!(trace.entry[9_999] > 10, "only {} circles", trace.entry[9_999]);
}

/// Everything that a sample may have to look after besides motion.
#[test]
fn searches_latches_faults_and_offsets_allocate_nothing() {
    let mut machine = Machine::builtin();
    for axis in &mut machine.axes {
        axis.equipment.index = Some(Index { position: 0.0, period: 1.0, width: 0.01, inverted: false });
        axis.equipment.backlash_compensation = 0.01;
    }
    let mut m = mcu_of(machine, ModeReg(0));
    let rules = "while X > 1: input 14 on bouncing 9 ms, Y blocked\nwhenever X < 2 after 5 ms: Z pushed 0.1\n\
                 when X > 3: X encoder cut\nat 2 s: X encoder mended, Y drive off";
    m.add_stimulus(&Stimulus::parse(rules, &["X", "Y", "Z"]).expect("valid"));
    m.wrControllerFlags(0, ControllerFlags(0xf0f));
    m.wrdvoffset(0, 0.01);
    m.wrdpoffset(0, 3.0);
    m.lps(1, 3);
    m.lprs(m.all_axes(), &LatchInfos { san: 0, lst: 0.1, let_: 2.0 });
    m.run(10);
    let mut trace = Trace::new(3, 3000);
    m.pass(10, &mut trace);
    let before = ALLOCATIONS.get();
    m.jhi(&AxisList::new(&[0, 1]), &[9.0, -7.0]);
    m.jhl(&AxisList::new(&[2]));
    m.pass(2900, &mut trace);
    assert_eq!(ALLOCATIONS.get() - before, 0);
    assert!(m.rdPosErr(0).abs() > 0.0 && m.machine_position(2) < -10.0);
}

/// The scanner, DMA-RTS at 30 kHz, a gear and a flying saw.
#[test]
fn resources_allocate_nothing() {
    let mut m = mcu_of(Machine::builtin(), LOOKAHEAD);
    m.resources_mut().options =
        Options::RESOURCE | Options::GEAR | Options::DMARTS | Options::EP1K50 | Options::RTS_ANALOGIN;
    let rules = "at 10 ms: input 14 pulsing 30 kHz\nat 10 ms: input 15 pulsing 5 kHz";
    m.add_stimulus(&Stimulus::parse(rules, &["X", "Y", "Z"]).expect("valid"));
    let write = |m: &mut Mcu, device, index, sub, kind, value: f64| {
        let mut d = ObjectDescriptor::new(device, index, sub, kind, WRITE);
        let code =
            if kind == Type::Double { m.wrOptionDbl(&mut d, value) } else { m.wrOptionInt(&mut d, value as i32) };
        assert_eq!(code, Code::Ok, "{d:?}");
    };
    write(&mut m, 200, 1, 0, Type::Double, 0.5);
    assert!(m.wrGCR(0, 1));
    write(&mut m, 7000, 6, 2, Type::Double, 40.0);
    write(&mut m, 7000, 4, 2, Type::Double, 1.0);
    write(&mut m, 7000, 1, 2, Type::Integer, 1.0);
    write(&mut m, 8001, 0, 0, Type::Integer, 1.0);
    let mut scan = Vec::new();
    for (device, index, sub, kind) in [
        (1, 0, 0, Type::Double),
        (200, 1, 0, Type::Double),
        (3, 2, 0, Type::Integer),
        (8014, 3 | 7 << 16, 48, Type::DataBlock),
    ] {
        let mut d = ObjectDescriptor::new(device, index, sub, kind, READ);
        let _ = if kind == Type::Double { m.rdOptionDbl(&mut d).is_ok() } else { m.rdOptionInt(&mut d).is_ok() };
        scan.push((device.to_string(), d));
    }
    m.scan(&scan).expect("all can be scanned");
    m.ja(&AxisList::new(&[2]), &[-50.0]);
    m.ja(&AxisList::new(&[0]), &[80.0]);
    let mut trace = Trace::new(3, 2000);
    m.pass(5, &mut trace);
    m.begin_trace(&mut trace);
    trace.reserve(2000);
    let before = ALLOCATIONS.get();
    m.pass(2000, &mut trace);
    assert_eq!(ALLOCATIONS.get() - before, 0);
    let last = trace.scan.values.len() - 3;
    close(trace.scan.values[last], 80.0, 0.01);
    assert!(trace.scan.blocks.chunks(trace.scan.blocks.len() / 2000).all(|block| block[4] == 0 && block[0] < 40));
    assert!(trace.dp[2 * 3 + 2].abs() < 0.01 && trace.dp[1999 * 3 + 2] < -10.0, "the saw follows");
    close(trace.rp[1999 * 3 + 1], 40.0, 0.01);
}
