//! A program that comes in segments is executed as if it were whole.

mod common;

use std::sync::Arc;

use common::mcu;
use motion_kernel::autocode::{Builder, HostEvent, Instr, Move, MoveKind, Program, Ssf};
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::registers::ModeReg;
use motion_kernel::tasks::{Segments, TaskState, runtime_error};
use motion_kernel::trace::{EventKind, Trace};
use motion_kernel::{Mcu, Stop};

/// A program of lines, functions, numbers and host events, whole and cut into segments of so many instructions.
fn cut(every: u32) -> (Program, Vec<Program>) {
    let fill = |builder: &mut Builder, parts: &mut Vec<Program>, cut: bool| {
        for n in 0..200u32 {
            if cut && builder.here() >= every {
                parts.push(builder.cut());
            }
            let axes = builder.axis_list(AxisList::new(&[0, 1]));
            let target = builder.numbers(&[f64::from(n % 7), f64::from(n % 5)]);
            let (kind, center) = (MoveKind::Smla, [0.0; 2]);
            let tvl = if n % 3 == 0 { 0.0 } else { 8.0 };
            let mv =
                Move { kind, rapid: false, axes, target, vl: 10.0, ac: 500.0, tvl, phi: 0.0, center, vias: (0, 0) };
            builder.spool(n + 1, mv);
            match n % 4 {
                0 => drop(builder.ssf(n + 1, Ssf { axes: AxisSet::single(1), command: 5, value: f64::from(n) })),
                1 => drop(builder.event(0, HostEvent { line: n + 1, kind: "MSG".into(), text: n.to_string() })),
                _ => {
                    let number = builder.numbers(&[f64::from(n)]);
                    builder.emit(n + 1, Instr::Number(number));
                    builder.emit(n + 1, Instr::StoreCi(7));
                }
            }
        }
        builder.emit(201, Instr::Halt);
    };
    let (mut whole, mut parts) = (Builder::new(AxisSet::first(2), 50), Vec::new());
    fill(&mut whole, &mut Vec::new(), false);
    let mut segments = Builder::new(AxisSet::first(2), 50);
    fill(&mut segments, &mut parts, true);
    parts.push(segments.finish());
    (whole.finish(), parts)
}

fn load_cut(mcu: &mut Mcu, parts: Vec<Program>) {
    let mut parts = parts.into_iter().map(Arc::new);
    let parts = std::sync::Mutex::new(move || parts.next());
    mcu.load_segments(0, Segments::new(move || (parts.lock().unwrap())()));
}

#[test]
fn segments_are_executed_as_if_they_were_one_program() {
    for every in [1, 2, 7, 100, 10_000] {
        let (whole, parts) = cut(every);
        assert_eq!(parts.len() > 1, every < 500);
        let run = |load: &dyn Fn(&mut Mcu)| {
            let mut mcu = mcu("XY", ModeReg::LookAhead);
            load(&mut mcu);
            mcu.startcnct(0);
            let mut trace = Trace::default();
            let mut lines = Vec::new();
            loop {
                let mut part = Trace::default();
                let advanced = mcu.advance(37, &mut part);
                lines.push((mcu.task_status(0).csrcline, mcu.task_status(0).running, mcu.ci(7)));
                trace.line.extend(part.line);
                trace.entry.extend(part.entry);
                trace.dp.extend(part.dp);
                if matches!(advanced.stop, Stop::Finished | Stop::TaskError { .. }) {
                    break;
                }
            }
            (trace, lines, mcu.events(), mcu.samples())
        };
        let (one, many) = (run(&|m| m.load(0, Arc::new(whole.clone()))), run(&|m| load_cut(m, parts.clone())));
        assert!(one.1.len() > 50 && one.2.iter().any(|e| e.kind == EventKind::Host && e.value > 40));
        assert_eq!((one.0.dp, one.0.line, one.0.entry), (many.0.dp, many.0.line, many.0.entry), "{every}");
        assert_eq!((one.1, one.2, one.3), (many.1, many.2, many.3), "{every}");
    }
}

#[test]
fn a_program_in_segments_starts_again_only_while_its_first_segment_is_there() {
    let mut mcu = mcu("XY", ModeReg::LookAhead);
    load_cut(&mut mcu, cut(50).1);
    mcu.startcnct(0);
    mcu.startcnct(0);
    assert_eq!(mcu.task_status(0).state, TaskState::Running);
    mcu.advance(100, &mut Trace::default());
    mcu.startcnct(0);
    assert_eq!((mcu.task_status(0).state, mcu.task_status(0).errnum), (TaskState::Failed, runtime_error::BAD_ADDRESS));
    // segments that end without a Halt run into nothing
    load_cut(&mut mcu, cut(50).1[..2].to_vec());
    mcu.startcnct(0);
    while mcu.task_status(0).state == TaskState::Running {
        mcu.advance(100, &mut Trace::default());
    }
    assert_eq!(mcu.task_status(0).errnum, runtime_error::BAD_ADDRESS);
}
