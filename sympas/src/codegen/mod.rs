//! Typed tree to register code (contract: `motion_kernel::sap`).

mod expressions;
mod statements;

use std::collections::HashMap;

use motion_kernel::sap::code::{Address, Instr, MOST_FRAME, MOST_GLOBALS, Slot};
use motion_kernel::sap::program::{Operand, Program, Routine as Entry};

use crate::diagnostics::{Fault, Id, Phrase, Reports};
use crate::source::{Sources, Span};
use crate::tree::{Routine, Unit};

/// Literals that are globals: read as fast as variables.
const MOST_LITERALS: usize = 2048;

/// Generates the program of a unit that has no errors. Reports what does not fit into a task.
pub fn generate(unit: Unit, sources: &Sources, reports: &mut Reports) -> Program {
    let program = Program {
        name: unit.name,
        task: unit.task,
        full_system: unit.full_system,
        axes: unit.axes,
        files: sources.files.iter().map(|f| f.name.clone()).collect(),
        globals: unit.globals,
        events: unit.events,
        variables: unit.variables,
        ..Program::default()
    };
    let given = unit.routines.iter().map(|r| r.parameters + u16::from(r.function)).collect();
    let mut generator =
        Generator { program, given, literals: HashMap::new(), texts: HashMap::new(), frame: Frame::default() };
    for routine in &unit.routines {
        let frame = generator.routine(routine);
        if frame > MOST_FRAME {
            let what = Phrase::new("variables and values of a routine", "Variablen und Werte einer Routine");
            reports.add(Fault::new(Id::SP501, routine.end).with(what).with(MOST_FRAME));
        }
    }
    if generator.program.globals.len() > MOST_GLOBALS {
        let what = Phrase::new("global variables and constants", "globale Variablen und Konstanten");
        let end = unit.routines.first().map_or_else(Span::default, |r| r.end);
        reports.add(Fault::new(Id::SP501, end).with(what).with(MOST_GLOBALS));
    }
    generator.program
}

struct Generator {
    program: Program,
    /// Result and parameters of each routine.
    given: Vec<u16>,
    literals: HashMap<u64, Slot>,
    texts: HashMap<String, u32>,
    frame: Frame,
}

/// The routine being generated.
#[derive(Default)]
struct Frame {
    /// Slots in use: fixed ones and living temporaries.
    top: usize,
    most: usize,
    labels: Vec<Option<Address>>,
    /// Jumps to labels.
    jumps: Vec<(Address, u32)>,
    place: (u16, u32),
}

impl Generator {
    /// Returns the slots that the routine needs.
    fn routine(&mut self, routine: &Routine) -> usize {
        let entry = self.here();
        let fixed = usize::from(routine.slots);
        let labels = vec![None; routine.labels as usize];
        self.frame = Frame { top: fixed, most: fixed, labels, ..Frame::default() };
        self.statements(&routine.body);
        self.at(routine.end);
        self.emit(Instr::Return);
        for (from, label) in std::mem::take(&mut self.frame.jumps) {
            let to = self.frame.labels[label as usize].unwrap_or(entry);
            self.patch(from, to);
        }
        let frame = self.frame.most;
        self.program.routines.push(Entry {
            name: routine.name.clone(),
            entry,
            frame: frame.min(MOST_FRAME) as u16,
            parameters: routine.parameters,
            function: routine.function,
        });
        frame
    }
    fn here(&self) -> Address {
        self.program.code.len() as Address
    }
    /// What follows belongs to that line.
    fn at(&mut self, span: Span) {
        self.frame.place = (span.file, span.line);
    }
    fn emit(&mut self, instr: Instr) -> Address {
        self.program.code.push(instr);
        self.program.lines.push(self.frame.place);
        self.here() - 1
    }
    /// Sets the target of a jump that was emitted before its destination was known.
    fn patch(&mut self, at: Address, target: Address) {
        match &mut self.program.code[at as usize] {
            Instr::Jump(to) | Instr::JumpIfNot(_, to) => *to = target,
            other => unreachable!("no jump at {at}: {other:?}"),
        }
    }
    fn patch_here(&mut self, at: Address) {
        self.patch(at, self.here());
    }
    /// A temporary slot; it lives until `top` is set back.
    fn temporary(&mut self) -> Slot {
        self.reserve(1)
    }
    /// Consecutive temporaries; beyond what a slot can name they fall together, which is reported as too large a frame.
    fn reserve(&mut self, count: usize) -> Slot {
        let first = self.frame.top;
        self.frame.top += count;
        self.frame.most = self.frame.most.max(self.frame.top);
        Slot::local(first.min(0x7FFF - count) as u16)
    }
    /// A global that holds the literal; where there are many different ones, a temporary that it is loaded into.
    fn literal(&mut self, bits: u64) -> Slot {
        if let Some(slot) = self.literals.get(&bits) {
            return *slot;
        }
        if self.literals.len() >= MOST_LITERALS {
            let slot = self.temporary();
            let number = self.program.constants.len() as u32;
            self.program.constants.push(bits);
            self.emit(Instr::Constant(slot, number));
            return slot;
        }
        let index = self.program.globals.len();
        self.program.globals.push(bits);
        let slot = Slot::global(index.min(0x7FFF) as u16);
        self.literals.insert(bits, slot);
        slot
    }
    fn text(&mut self, text: &str) -> u32 {
        if let Some(number) = self.texts.get(text) {
            return *number;
        }
        let number = self.program.texts.len() as u32;
        self.program.texts.push(text.to_owned());
        self.texts.insert(text.to_owned(), number);
        number
    }
    fn list(&mut self, operands: Vec<Operand>) -> u32 {
        self.program.lists.push(operands);
        (self.program.lists.len() - 1) as u32
    }
}
