//! CNC tasks: the way from autocode to motion, single step, runtime errors, determinism.

mod common;

use common::*;
use motion_kernel::autocode::{BinaryOp, Builder, HostEvent, Instr, Move, MoveKind, Program, Ssf};
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::machine::Machine;
use motion_kernel::tasks::{TaskState, runtime_error};
use motion_kernel::trace::{EventKind, Trace};
use motion_kernel::{Mcu, Stop};
use std::sync::Arc;

struct Writer {
    builder: Builder,
    axes: u16,
    n: usize,
    line: u32,
}

impl Writer {
    fn new(axes: usize, start_fill: u32) -> Self {
        let list: Vec<usize> = (0..axes).collect();
        let mut builder = Builder::new(AxisSet::first(axes), start_fill);
        let axes = builder.axis_list(AxisList::new(&list));
        Writer { builder, axes, n: list.len(), line: 0 }
    }
    fn line(&mut self, targets: &[f64], vl: f64, tvl: f64) -> &mut Self {
        assert_eq!(targets.len(), self.n);
        self.line += 1;
        let target = self.builder.numbers(targets);
        let (axes, center) = (self.axes, [0.0; 2]);
        let mv = Move {
            kind: MoveKind::Smla,
            rapid: false,
            axes,
            target,
            vl,
            ac: 500.0,
            tvl,
            phi: 0.0,
            center,
            vias: (0, 0),
        };
        self.builder.spool(self.line, mv);
        self
    }
    fn ssf(&mut self, command: u16, value: f64) -> &mut Self {
        self.line += 1;
        self.builder.ssf(self.line, Ssf { axes: AxisSet::first(self.n), command, value });
        self
    }
    fn emit(&mut self, instr: Instr) -> &mut Self {
        self.builder.emit(self.line.max(1), instr);
        self
    }
    fn number(&mut self, value: f64) -> &mut Self {
        let n = self.builder.numbers(&[value]);
        self.emit(Instr::Number(n))
    }
    fn finish(mut self) -> Arc<Program> {
        self.builder.emit(self.line + 1, Instr::Halt);
        Arc::new(self.builder.finish())
    }
}

fn start(machine: Machine, program: Arc<Program>) -> Mcu {
    let mut m = Mcu::new(Arc::new(machine));
    m.prepare_gcode();
    m.load(0, program);
    m.startcnct(0);
    m
}

/// Short blocks on a wavy line, with functions and a wait between them.
fn wave(blocks: usize) -> Arc<Program> {
    let mut w = Writer::new(3, 50);
    for n in 1..=blocks {
        let x = n as f64 * 0.05;
        let last = n == blocks || n % 500 == 0;
        w.line(&[x, (x * 0.7).sin(), 0.1 * (x * 0.3).cos()], 30.0, if last { 0.0 } else { 30.0 });
        if n % 500 == 0 {
            w.ssf(1003, 200.0);
        }
        if n % 70 == 0 {
            w.ssf(20, n as f64);
        }
    }
    w.finish()
}

/// Runs to the end in chunks of the given sizes, with an override and a hold on the way, and joins the chunks.
fn whole_run(chunks: &[u64], program: &Arc<Program>) -> (Trace, Vec<motion_kernel::trace::Event>) {
    let mut m = start(Machine::builtin(), Arc::clone(program));
    let all = m.all_axes();
    let (mut joined, mut trace) = (Trace::new(3, 100_000), Trace::default());
    let mut events = Vec::new();
    let mut chunk = chunks.iter().cycle();
    loop {
        // commands come at fixed samples, whatever the chunks are
        match m.samples() {
            800 => {
                m.wrtrovr(0.6);
                m.utrovr(all);
            }
            2000 => m.hold(),
            2600 => m.resume(),
            _ => {}
        }
        let next = [800, 2000, 2600].into_iter().find(|s| *s > m.samples()).unwrap_or(u64::MAX);
        let advanced = m.advance((next - m.samples()).min(*chunk.next().expect("cycles")), &mut trace);
        joined.axes = 3;
        joined.dp.extend(&trace.dp);
        joined.load.extend(&trace.load);
        joined.rp.extend(&trace.rp);
        joined.v_plan.extend(&trace.v_plan);
        joined.factor.extend(&trace.factor);
        joined.line.extend(&trace.line);
        joined.entry.extend(&trace.entry);
        joined.flags.extend(&trace.flags);
        events.extend(m.events());
        match advanced.stop {
            Stop::Budget | Stop::Held | Stop::Events => {}
            Stop::Finished => return (joined, events),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn the_same_run_twice_is_bit_equal_whatever_the_chunks() {
    let program = wave(3000);
    let first = whole_run(&[1000], &program);
    for chunks in [&[1000][..], &[1, 7, 333], &[50_000]] {
        let (trace, events) = whole_run(chunks, &program);
        assert!(trace == first.0, "chunks of {chunks:?} differ");
        assert_eq!(events, first.1);
    }
    assert!(first.0.len() > 5000);
    assert_eq!(first.0.entry.iter().max(), Some(&3000));
}

// shows: sap.mode.standalone
#[test]
fn a_task_spools_runs_and_ends() {
    let mut m = start(Machine::builtin(), wave(3000));
    let mut trace = Trace::default();
    let advanced = m.advance(1_000_000, &mut trace);
    assert_eq!(advanced.stop, Stop::Finished);
    assert_eq!(m.task_status(0).state, TaskState::Idle);
    let status = m.status();
    close(status.axes[0].dp, 150.0, 1e-9);
    assert!(status.axes.iter().all(|a| (a.rp - a.dp).abs() < 0.01), "settled in position");
    assert_eq!(m.ci(20), 2940);
    assert_eq!(m.errorreg().0, 0);
}

#[test]
fn a_full_spooler_starts_by_itself_and_the_task_waits() {
    let mut machine = Machine::builtin();
    machine.controller.spool_memory_bytes = 20 * 96;
    let mut w = Writer::new(3, 0);
    for n in 1..=100 {
        w.line(&[f64::from(n), 0.0, 0.0], 50.0, if n < 100 { 50.0 } else { 0.0 });
    }
    let mut m = start(machine, w.finish());
    m.run(2);
    assert_eq!((m.status().axes[0].mcis, m.task_status(0).running), (20 - 1, 0b1001));
    record(&mut m);
    close(m.status().axes[0].dp, 100.0, 0.0);
    assert_eq!(m.errorreg().0 & 1 << 4, 0, "no overrun");
}

#[test]
fn start_fill_starts_the_group() {
    let mut w = Writer::new(3, 5);
    for n in 1..=10 {
        w.line(&[f64::from(n), 0.0, 0.0], 50.0, 50.0);
    }
    w.emit(Instr::Wait(100));
    let mut m = start(Machine::builtin(), w.finish());
    m.run(1);
    assert!(m.status().axes[0].dp > 0.0, "10 commands wait, 5 are enough");
    let mut w = Writer::new(3, 50);
    w.line(&[1.0, 0.0, 0.0], 50.0, 0.0).emit(Instr::Wait(100));
    let mut m = start(Machine::builtin(), w.finish());
    m.run(99);
    assert_eq!(m.status().axes[0].dp, 0.0);
    m.run(3);
    assert!(m.status().axes[0].dp > 0.0, "the end of the program starts the rest");
}

#[test]
fn twenty_statements_a_sample() {
    let mut w = Writer::new(3, 0);
    for n in 1..=100 {
        w.line(&[f64::from(n), 0.0, 0.0], 50.0, 0.0);
    }
    let mut m = start(Machine::builtin(), w.finish());
    for sample in 1..=5 {
        m.run(1);
        assert_eq!(m.status().axes[0].mcis, 20 * sample);
    }
}

#[test]
fn drain_waits_for_the_end_of_motion() {
    let mut w = Writer::new(3, 0);
    w.line(&[1.0, 0.0, 0.0], 50.0, 0.0).emit(Instr::Drain(AxisSet::first(3)));
    w.number(7.0).emit(Instr::StoreCi(3));
    let mut m = start(Machine::builtin(), w.finish());
    m.run(50);
    assert_eq!(m.ci(3), 0);
    record(&mut m);
    assert_eq!(m.ci(3), 7);
}

#[test]
fn arithmetic_locals_jumps_and_output() {
    // sum := 0; i := 3; while i > 0 do begin sum := sum + i; i := i - 1 end; write sum
    let mut w = Writer::new(1, 0);
    w.line = 5;
    w.number(3.0).emit(Instr::StoreLocal(1));
    let top = w.builder.here();
    w.emit(Instr::LoadLocal(0)).emit(Instr::LoadLocal(1)).emit(Instr::Binary(BinaryOp::Add)).emit(Instr::StoreLocal(0));
    w.emit(Instr::LoadLocal(1)).number(1.0).emit(Instr::Binary(BinaryOp::Sub)).emit(Instr::StoreLocal(1));
    w.emit(Instr::LoadLocal(1));
    let exit = w.builder.emit(5, Instr::JumpIfZero(0));
    w.emit(Instr::Jump(top));
    let after = w.builder.here();
    w.builder.patch(exit, after);
    let text = w.builder.text("sum = ");
    w.emit(Instr::WriteText(text)).emit(Instr::LoadLocal(0)).emit(Instr::WriteValue).emit(Instr::Writeln);
    w.number(6.0).emit(Instr::StoreCd(9));
    let mut m = start(machine("X"), w.finish());
    m.run(5);
    assert_eq!((m.take_output(0).as_str(), m.cd(9)), ("sum = 6\n", 6.0));
    assert_eq!(m.task_status(0).state, TaskState::Idle);
}

fn failure(write: impl Fn(&mut Writer)) -> (u32, u32) {
    let mut w = Writer::new(1, 0);
    w.line = 41;
    write(&mut w);
    let mut m = start(machine("X"), w.finish());
    let mut trace = Trace::default();
    let advanced = m.advance(10_000, &mut trace);
    assert_eq!(advanced.stop, Stop::TaskError { task: 0 });
    assert!(m.events().iter().any(|e| e.kind == EventKind::Task && e.line == 41));
    assert_eq!(m.task_status(0).state, TaskState::Failed);
    (m.task_status(0).errnum, m.task_status(0).errline)
}

// shows: struct.cncts.errnum, struct.cncts.errline
#[test]
fn runtime_errors_stop_the_task_with_number_and_line() {
    let zero = |w: &mut Writer| {
        w.number(1.0).number(0.0).emit(Instr::Binary(BinaryOp::Mod));
    };
    assert_eq!(failure(zero), (runtime_error::BAD_PARAMETER, 41));
    let one = |instr: Instr| failure(move |w| _ = w.emit(instr));
    assert_eq!(one(Instr::StoreLocal(0)), (runtime_error::STACK_UNDERFLOW, 41));
    assert_eq!(one(Instr::Return), (runtime_error::STACK_UNDERFLOW, 41));
    assert_eq!(one(Instr::LoadCi(1000)), (runtime_error::COMMON_RANGE, 41));
    assert_eq!(one(Instr::Jump(9999)), (runtime_error::BAD_ADDRESS, 41));
    let endless = |w: &mut Writer| {
        let here = w.builder.here();
        w.emit(Instr::Call(here));
    };
    assert_eq!(failure(endless), (runtime_error::STACK_OVERFLOW, 41));
    let grow = |w: &mut Writer| {
        let here = w.builder.here();
        w.number(1.0).emit(Instr::Jump(here));
    };
    assert_eq!(failure(grow), (runtime_error::STACK_OVERFLOW, 41));
}

#[test]
fn motion_in_open_loop_is_a_runtime_error() {
    let mut w = Writer::new(1, 0);
    w.line(&[1.0], 10.0, 0.0);
    let mut m = Mcu::new(Arc::new(machine("X")));
    m.load(0, w.finish());
    m.startcnct(0);
    m.run(1);
    assert_eq!((m.task_status(0).errnum, m.task_status(0).errline), (runtime_error::OPEN_LOOP, 1));
}

#[test]
fn an_empty_loop_does_not_hang() {
    let mut w = Writer::new(1, 0);
    w.emit(Instr::Jump(0));
    let mut m = start(machine("X"), w.finish());
    m.run(1000);
    assert_eq!(m.samples(), 1000);
    // shows that the task is still running, at its line
    assert_eq!((m.task_status(0).running, m.task_status(0).csrcline), (1, 1));
}

// shows: pcap.stepcnct, pcap.stepcnct.done, struct.cncts.running-bit1, struct.cncts.csrcline
#[test]
fn single_step_runs_one_line_and_stops_at_its_end() {
    let mut w = Writer::new(3, 50);
    for n in 1..=4 {
        w.line(&[f64::from(n), 0.0, 0.0], 50.0, 50.0);
    }
    let mut m = Mcu::new(Arc::new(Machine::builtin()));
    m.prepare_gcode();
    m.load(0, w.finish());
    for n in 1..=3 {
        m.stepcnct(0);
        m.run(1000);
        close(m.status().axes[0].dp, f64::from(n), 0.0);
        assert_eq!((m.task_status(0).running, m.task_status(0).csrcline), (2, n as u32 + 1));
    }
    m.contcnct(0);
    record(&mut m);
    close(m.status().axes[0].dp, 4.0, 0.0);
}

#[test]
fn a_step_waits_for_the_motion_of_the_step_before() {
    let mut w = Writer::new(3, 50);
    for n in 1..=4 {
        w.line(&[f64::from(n), 0.0, 0.0], 50.0, 50.0);
    }
    let mut m = Mcu::new(Arc::new(Machine::builtin()));
    m.prepare_gcode();
    m.load(0, w.finish());
    m.stepcnct(0);
    m.run(10);
    m.stepcnct(0);
    m.run(2);
    assert_eq!((m.status().entry, m.status().axes[0].mcis, m.task_status(0).running), (1, 0, 0b1001));
    m.run(1000);
    close(m.status().axes[0].dp, 2.0, 0.0);
    assert_eq!(m.task_status(0).running, 2);
}

#[test]
fn a_new_start_numbers_commands_from_1() {
    let mut w = Writer::new(3, 0);
    w.line(&[1.0, 0.0, 0.0], 50.0, 0.0).line(&[0.0, 0.0, 0.0], 50.0, 0.0);
    let mut m = start(Machine::builtin(), w.finish());
    for _ in 0..2 {
        let trace = record(&mut m);
        assert_eq!((trace.entry[1], trace.entry.iter().max()), (1, Some(&2)));
        m.startcnct(0);
    }
}

// shows: pcap.startcnct, pcap.stopcnct, pcap.stopcnct.continue, pcap.contcnct, struct.cncts.running-bit0
// shows: pcap.startcnct.stops-running
#[test]
fn tasks_start_stop_and_continue() {
    let count = || {
        let mut w = Writer::new(1, 0);
        for _ in 0..1000 {
            w.emit(Instr::LoadCi(1)).number(1.0).emit(Instr::Binary(BinaryOp::Add)).emit(Instr::StoreCi(1));
        }
        w.finish()
    };
    let mut m = Mcu::new(Arc::new(machine("X")));
    m.load(2, count());
    m.run(5);
    assert_eq!((m.ci(1), m.task_status(2).running), (0, 0));
    m.startcnct(2);
    m.run(5);
    assert_eq!((m.ci(1), m.task_status(2).running), (100, 1));
    m.stopcnct(2);
    m.run(5);
    assert_eq!((m.ci(1), m.task_status(2).running), (100, 0));
    m.contcnct(2);
    m.run(5);
    assert_eq!(m.ci(1), 200);
    m.startcnct(2);
    m.run(51);
    assert_eq!((m.ci(1), m.task_status(2).running), (1200, 0), "from the beginning, to the end");
}

// shows: sap.tasks.four, sap.tasks.equal-priority, sap.common.ci, sap.common.cd
#[test]
fn four_tasks_share_the_sample_equally() {
    let mut m = Mcu::new(Arc::new(machine("X")));
    for task in 0..4 {
        let mut w = Writer::new(1, 0);
        w.emit(Instr::LoadCi(task)).number(1.0).emit(Instr::Binary(BinaryOp::Add)).emit(Instr::StoreCi(task));
        w.emit(Instr::Jump(0));
        m.load(usize::from(task), w.finish());
        m.startcnct(usize::from(task));
    }
    m.run(10);
    assert_eq!((0..4).map(|n| m.ci(n)).collect::<Vec<_>>(), [100; 4]);
    m.set_ci(0, -5);
    m.set_cd(999, 1.5);
    assert_eq!((m.ci(0), m.cd(999)), (-5, 1.5));
}

#[test]
fn host_events_come_in_step_with_motion() {
    let mut w = Writer::new(3, 0);
    w.line(&[1.0, 0.0, 0.0], 50.0, 0.0);
    w.builder.event(0, HostEvent { line: 2, kind: "T".into(), text: "5".into() });
    w.line(&[2.0, 0.0, 0.0], 50.0, 0.0);
    let mut m = start(Machine::builtin(), w.finish());
    let trace = record(&mut m);
    let events = m.events();
    let event = events.iter().find(|e| e.kind == EventKind::Host).expect("the event");
    assert_eq!((event.value, event.line), (0, 2));
    let second = trace.entry.iter().position(|e| *e == 2).expect("second block");
    assert_eq!(event.sample as usize, second);
}
