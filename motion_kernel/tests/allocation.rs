//! No allocation inside a sample (design 6): counted by an allocator of its own.
#![allow(unsafe_code)] // a global allocator cannot be written without

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::autocode::{Builder, Instr, Move, MoveKind, Ssf};
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::machine::Machine;
use motion_kernel::trace::Trace;
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

/// Lines, arcs, functions and waits, spooled by a task while they run, through a full spooler.
#[test]
fn ten_thousand_samples_allocate_nothing() {
    let mut builder = Builder::new(AxisSet::first(3), 100);
    let axes = builder.axis_list(AxisList::new(&[0, 1, 2]));
    for n in 1..=20_000u32 {
        let x = f64::from(n) * 0.05;
        let end = [x, 0.0, 0.1];
        let stop = n % 300 == 0;
        let target = builder.numbers(&end);
        let tvl = if stop { 0.0 } else { 40.0 };
        let mut mv = Move {
            kind: MoveKind::Smla,
            rapid: false,
            axes,
            target,
            vl: 40.0,
            ac: 500.0,
            tvl,
            phi: 0.0,
            center: [0.0; 2],
            vias: (0, 0),
        };
        if n % 10 == 0 {
            (mv.kind, mv.phi, mv.center) = (MoveKind::Smha, 180.0, [x - 0.025, 0.0]);
        }
        builder.spool(n, mv);
        if stop {
            builder.ssf(n, Ssf { axes: AxisSet::first(3), command: 1003, value: 100.0 });
            builder.ssf(n, Ssf { axes: AxisSet::single(0), command: 1001, value: 1.0 });
        }
    }
    builder.emit(20_001, Instr::Halt);
    let mut m = Mcu::new(Arc::new(Machine::builtin()));
    m.prepare_gcode();
    m.load(0, Arc::new(builder.finish()));
    m.startcnct(0);
    let mut trace = Trace::new(3, 10_000);
    m.advance(10, &mut trace);
    let before = ALLOCATIONS.get();
    let advanced = m.advance(10_000, &mut trace);
    let after = ALLOCATIONS.get();
    assert_eq!((advanced.samples, after - before), (10_000, 0));
    assert!(trace.entry[9_999] > 1000);
    close(trace.factor[0], 1.0, 0.0);
}
