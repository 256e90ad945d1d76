//! What the tests of this crate share.
#![allow(dead_code)] // each test binary uses a part of it

use std::cell::RefCell;
use std::rc::Rc;

use gcode::{Compiled, Deliver, Options, Sequencer, Sheet, compile, compile_once};
use motion_kernel::autocode::{Instr, MoveKind, Program};
use motion_kernel::machine::Machine;

pub fn mill3() -> Machine {
    static MILL: std::sync::OnceLock<Machine> = std::sync::OnceLock::new();
    MILL.get_or_init(Machine::builtin).clone()
}

pub fn example(name: &str) -> Machine {
    let path = format!("{}/../examples/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Machine::parse(&std::fs::read(path).expect("the example machine")).expect("a valid machine file")
}

pub fn run(text: &str) -> Compiled {
    compile(text.as_bytes(), "t.nc", &mill3(), &Options::default())
}

/// Compiles and insists on no error.
pub fn program(text: &str) -> Program {
    program_for(text, &mill3(), &Options::default())
}
pub fn program_for(text: &str, machine: &Machine, options: &Options) -> Program {
    let compiled = compile(text.as_bytes(), "t.nc", machine, options);
    let errors: Vec<String> =
        compiled.diagnostics.iter().filter(|d| !d.is_warning()).map(ToString::to_string).collect();
    assert!(errors.is_empty(), "{text}\n{errors:#?}");
    compiled.program.expect("no error, so there is a program")
}

/// A command of a program, flat: easy to write down as expectation.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    Line { line: u32, to: Vec<f64>, vl: f64, tvl: f64, rapid: bool },
    Arc { line: u32, axes: Vec<usize>, to: Vec<f64>, center: [f64; 2], phi: f64, vl: f64, tvl: f64 },
    Ssf { line: u32, axes: Vec<usize>, command: u16, value: f64 },
    Event { line: u32, kind: String, text: String },
    Drain(u32),
    Text(String),
    Other(Instr),
}

pub fn commands(program: &Program) -> Vec<Command> {
    let each = |(instr, line): (&Instr, &u32)| match *instr {
        Instr::Spool(n) => {
            let mv = &program.moves[n as usize];
            let (line, to) = (*line, program.targets_of(mv).to_vec());
            if mv.kind == MoveKind::Smla {
                Command::Line { line, to, vl: mv.vl, tvl: mv.tvl, rapid: mv.rapid }
            } else {
                let axes = program.axes_of(mv).iter().collect();
                Command::Arc { line, axes, to, center: mv.center, phi: mv.phi, vl: mv.vl, tvl: mv.tvl }
            }
        }
        Instr::Ssf(n) => {
            let ssf = &program.ssfs[n as usize];
            if ssf.command == 198 {
                let event = &program.events[ssf.value as usize - 1];
                return Command::Event { line: event.line, kind: event.kind.clone(), text: event.text.clone() };
            }
            Command::Ssf { line: *line, axes: ssf.axes.iter().collect(), command: ssf.command, value: ssf.value }
        }
        Instr::Drain(_) => Command::Drain(*line),
        Instr::WriteText(n) => Command::Text(program.texts[n as usize].clone()),
        other => Command::Other(other),
    };
    program.code.iter().zip(&program.lines).map(each).collect()
}

/// Only the motion commands.
pub fn motions(program: &Program) -> Vec<Command> {
    let all = commands(program).into_iter();
    all.filter(|c| matches!(c, Command::Line { .. } | Command::Arc { .. })).collect()
}

/// End points of all motion commands, in the order of the machine's axes.
pub fn ends(program: &Program) -> Vec<Vec<f64>> {
    let end = |mv: &motion_kernel::autocode::Move| {
        let mut pairs: Vec<(usize, f64)> = program.axes_of(mv).iter().zip(program.targets_of(mv).to_vec()).collect();
        pairs.sort_by_key(|p| p.0);
        pairs.into_iter().map(|p| p.1).collect()
    };
    program.moves.iter().map(end).collect()
}

/// Every point of the path as programmed: passed-over points and end points.
pub fn points(program: &Program) -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    for (mv, end) in program.moves.iter().zip(ends(program)) {
        all.extend(program.vias_of(mv).iter().map(|v| program.via_targets(mv, v).to_vec()));
        all.push(end);
    }
    all
}

/// Everything that a program in segments says, operand by operand; a whole program is one segment.
pub fn flat(segments: &[Program], machine: &Machine) -> Vec<String> {
    let (mut said, mut moved) = (Vec::new(), Vec::new());
    let mut sequencer = Sequencer::new(machine);
    for p in segments {
        for (line, instr) in p.lines.iter().zip(&p.code) {
            let what = match *instr {
                Instr::Spool(n) => {
                    let mv = &p.moves[n as usize];
                    let vias: Vec<_> = p.vias_of(mv).iter().map(|v| (v.line, p.via_targets(mv, v))).collect();
                    let bare = motion_kernel::autocode::Move { axes: 0, target: 0, vias: (0, 0), ..*mv };
                    format!("{bare:?} {:?} {:?} {vias:?}", p.axes_of(mv), p.targets_of(mv))
                }
                Instr::Ssf(n) if p.ssfs[n as usize].command == 198 => {
                    format!("{:?} {:?}", p.ssfs[n as usize], p.event(p.ssfs[n as usize].value))
                }
                Instr::Ssf(n) => format!("{:?}", p.ssfs[n as usize]),
                Instr::Number(n) => format!("number {}", p.numbers[n as usize]),
                Instr::WriteText(n) => format!("text {}", p.texts[n as usize]),
                other => format!("{other:?}"),
            };
            said.push(format!("{line} {what}"));
        }
        let c = sequencer.next(p);
        let rows = c.target.chunks(c.axes).zip(c.center.chunks(2)).zip(&c.effradius_of);
        let radii = |row: &u16| &c.effradius[usize::from(*row) * c.axes..][..c.axes];
        moved.extend(rows.map(|((to, centre), row)| format!("{to:?} {centre:?} {:?}", radii(row))));
    }
    said.extend(moved);
    said
}

/// As [`compile`], read in windows of that size and put together from segments of about `every` instructions.
pub fn once(text: &[u8], machine: &Machine, options: &Options, window: usize, every: u32) -> (Vec<Program>, Compiled) {
    let segments = Rc::new(RefCell::new(Vec::new()));
    let taken = segments.clone();
    let deliver = Deliver { every, to: Box::new(move |segment| taken.borrow_mut().push(segment)) };
    let open = || -> std::io::Result<gcode::Input<'static>> { Ok(Box::new(std::io::Cursor::new(text.to_vec()))) };
    let compiled = compile_once(&open, "t.nc", machine, options, Some(deliver), window).expect("it can be read");
    let mut segments = segments.take();
    segments.extend(compiled.program.clone());
    (segments, compiled)
}

/// Insists on equal findings, facts and commands of both ways. True for a program of which no text was kept.
pub fn same_once(text: &[u8], machine: &Machine, options: &Options, window: usize, every: u32) -> bool {
    let (segments, found) = once(text, machine, options, window, every);
    let whole = compile(text, "t.nc", machine, options);
    let shown = || {
        format!("windows of {window}, segments of {every}\n{}", String::from_utf8_lossy(&text[..text.len().min(3000)]))
    };
    assert_eq!(found.diagnostics, whole.diagnostics, "{}", shown());
    assert_eq!(found.more_warnings, whole.more_warnings, "{}", shown());
    let facts =
        |c: &Compiled| (c.facts.low, c.facts.high, c.facts.tools.clone(), c.facts.motion_blocks, c.facts.merged);
    assert_eq!(
        (&found.facts.start, found.facts.looks_back),
        (&whole.facts.start, whole.facts.looks_back),
        "{}",
        shown()
    );
    assert_eq!(facts(&found), facts(&whole), "{}", shown());
    assert_eq!((found.facts.blocks, found.facts.lines), (whole.facts.blocks, whole.facts.lines), "{}", shown());
    match whole.program {
        Some(program) => {
            let (one, all) = (flat(&segments, machine), flat(std::slice::from_ref(&program), machine));
            // the sheet beside a program that jumps is that of the whole one
            for json in [false, true].into_iter().filter(|json| *json || !found.facts.looks_back) {
                let one = listed(text, &segments, machine, json);
                assert_eq!(one, listed(text, std::slice::from_ref(&program), machine, json), "{}", shown());
            }
            assert!(one == all, "{}\n{:?}", shown(), one.iter().zip(&all).find(|(a, b)| a != b));
        }
        None => assert!(found.program.is_none(), "{}", shown()),
    }
    !found.facts.looks_back
}

/// The listing of a program in segments, or of a whole one.
fn listed(text: &[u8], segments: &[Program], machine: &Machine, json: bool) -> String {
    let mut sheet = match segments {
        [program] => Sheet::new(program, machine, text, json),
        _ => Sheet::following(machine, (!json).then(|| Box::new(std::io::Cursor::new(text.to_vec())) as _)),
    };
    let mut all = String::new();
    for program in segments {
        sheet.next_segment();
        while let Some(piece) = sheet.piece(program, machine, text) {
            all += &piece;
        }
    }
    all
}
