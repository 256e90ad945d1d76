//! What a program must fulfil before a task may execute it: nothing it names lies outside of it.
//!
//! Slots carry no type that could be checked, and none is needed: a slot is 64 bits, and what an instruction makes of them
//! is defined for every pattern (Integer: the low 32, Boolean: not 0, Double: the IEEE number, NaN included, axis and
//! index: compared with the range at each use, else runtime error 0100 hex). A program whose types do not fit computes
//! nonsense, as it would on the board, and nothing else.

use super::code::{Instr, MOST_FRAME, MOST_GLOBALS, Slot};
use super::program::{Program, Routine};
use super::tables::{BitQualifier, Command, Event, Function, Indexed, Qualifier, SystemParameter, TaskCommand, Type};

/// Lines of a text with its includes.
const MOST_LINES: u32 = 1 << 23;

/// Why a program is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Address of the instruction; none where the program as a whole is wrong.
    pub address: Option<u32>,
    pub reason: &'static str,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.address {
            Some(address) => write!(out, "instruction {address}: {}", self.reason),
            None => out.write_str(self.reason),
        }
    }
}

/// Checks a program: slots, jumps, calls, pools. Each routine's code must be one piece that cannot be left at its end.
pub fn verify(program: &Program) -> Result<(), Refusal> {
    whole(program).map_err(|reason| Refusal { address: None, reason })?;
    let mut order: Vec<&Routine> = program.routines.iter().collect();
    order.sort_by_key(|r| r.entry);
    for (n, routine) in order.iter().enumerate() {
        let end = order.get(n + 1).map_or(program.code.len() as u32, |next| next.entry);
        let piece = Piece { program, routine, end };
        for address in routine.entry..end {
            piece.instruction(address).map_err(|reason| Refusal { address: Some(address), reason })?;
        }
        let last = program.code.get(end as usize - 1);
        if !matches!(last, Some(Instr::Return | Instr::Jump(_) | Instr::Abort)) {
            return Err(Refusal { address: Some(end - 1), reason: "a routine has no end" });
        }
    }
    Ok(())
}

fn whole(program: &Program) -> Result<(), &'static str> {
    let Program { code, lines, routines, globals, events, .. } = program;
    let entries = |r: &Routine| (r.entry as usize) < code.len();
    let mut sorted: Vec<u32> = routines.iter().map(|r| r.entry).collect();
    sorted.sort_unstable();
    let handlers = events.iter().flatten();
    let files = lines.iter().all(|(file, _)| usize::from(*file) < program.files.len());
    let rules = [
        (!routines.is_empty(), "there is no main program"),
        (routines.iter().all(entries), "a routine begins outside the code"),
        (sorted.first() == Some(&0), "code before the first routine"),
        (sorted.windows(2).all(|pair| pair[0] < pair[1]), "two routines begin at one address"),
        (lines.len() == code.len(), "the line table does not fit the code"),
        (files, "a line of an unknown file"),
        (files && program.offsets().last().is_none_or(|&most| most <= MOST_LINES), "a line that no text has"),
        (globals.len() <= MOST_GLOBALS, "too many globals"),
        (program.task.is_none_or(|t| t < 4), "the task number is not 0 to 3"),
        (routines.iter().all(|r| usize::from(r.frame) <= MOST_FRAME), "a routine needs too large a frame"),
        (routines.iter().all(|r| r.given() <= r.frame), "a frame is smaller than its parameters"),
        (
            handlers.clone().all(|&n| routines.get(usize::from(n)).is_some_and(|r| r.given() == 0)),
            "an event handler is no procedure without parameters",
        ),
    ];
    rules.iter().find(|(ok, _)| !ok).map_or(Ok(()), |(_, reason)| Err(*reason))
}

/// The code of one routine.
struct Piece<'p> {
    program: &'p Program,
    routine: &'p Routine,
    end: u32,
}

impl Piece<'_> {
    fn instruction(&self, address: u32) -> Result<(), &'static str> {
        let instr = self.program.code[address as usize];
        if !all_slots(instr, |slot| self.holds(slot)) {
            return Err("a slot outside globals and frame");
        }
        match instr {
            Instr::Jump(to) | Instr::JumpIfNot(_, to) => self.jump(to),
            Instr::IfEqI(..)
            | Instr::IfNeI(..)
            | Instr::IfLtI(..)
            | Instr::IfLeI(..)
            | Instr::IfEqD(..)
            | Instr::IfNeD(..)
            | Instr::IfLtD(..)
            | Instr::IfLeD(..)
            | Instr::NextUp(..)
            | Instr::NextDown(..) => self.before_jump(address),
            Instr::Call(number, base) => self.call(number, base),
            Instr::Do(_, list) | Instr::AwaitEnd(_, list) => self.list(list),
            Instr::Constant(_, number) if number as usize >= self.program.constants.len() => Err("an unknown constant"),
            Instr::WriteText(text) if text as usize >= self.program.texts.len() => Err("an unknown text"),
            Instr::Task(_, number) if number > 3 => Err("the task number is not 0 to 3"),
            Instr::Azo(set) if set > 4 => Err("the set of zero offsets is not 0 to 4"),
            Instr::ReadAxisBit(_, bit, ..) | Instr::WriteAxisBit(_, bit, ..) if !(1..=32).contains(&bit) => {
                Err("the bit number is not 1 to 32")
            }
            Instr::ReadBuffer(Type::Boolean | Type::Timer, ..)
            | Instr::WriteBuffer(Type::Boolean | Type::Timer, ..) => {
                Err("the common buffer holds Integer, Single and Double")
            }
            _ => Ok(()),
        }
    }

    fn holds(&self, slot: Slot) -> bool {
        let room = if slot.is_global() { self.program.globals.len() } else { usize::from(self.routine.frame) };
        slot.index() < room
    }
    fn jump(&self, to: u32) -> Result<(), &'static str> {
        if (self.routine.entry..self.end).contains(&to) { Ok(()) } else { Err("a jump leaves its routine") }
    }
    fn before_jump(&self, address: u32) -> Result<(), &'static str> {
        let next = (address + 1 < self.end).then(|| self.program.code[address as usize + 1]);
        if matches!(next, Some(Instr::Jump(_))) { Ok(()) } else { Err("a condition without its jump") }
    }
    fn call(&self, number: u16, base: u16) -> Result<(), &'static str> {
        let Some(callee) = self.program.routines.get(usize::from(number)) else { return Err("an unknown routine") };
        // the caller writes the parameters and reads the result in its own frame
        let reach = usize::from(base) + usize::from(callee.given());
        if number == 0 {
            return Err("the main program cannot be called");
        }
        if reach <= usize::from(self.routine.frame) { Ok(()) } else { Err("the parameters lie outside the frame") }
    }
    fn list(&self, list: u32) -> Result<(), &'static str> {
        let Some(list) = self.program.lists.get(list as usize) else { return Err("an unknown list of axes") };
        let ok = list.iter().all(|o| self.holds(o.axis) && self.holds(o.value));
        if ok { Ok(()) } else { Err("a slot outside globals and frame") }
    }
}

/// An operand of an instruction, which may be a slot.
trait Operand {
    fn slot(self) -> Option<Slot>;
}
impl Operand for Slot {
    fn slot(self) -> Option<Slot> {
        Some(self)
    }
}
macro_rules! no_slots {
    ($($kind:ident)*) => {$(
        impl Operand for $kind {
            fn slot(self) -> Option<Slot> {
                None
            }
        }
    )*};
}
no_slots! { u8 u16 u32 bool Type Indexed SystemParameter Qualifier BitQualifier Function Command TaskCommand Event }

macro_rules! slots_of {
    ($($number:literal $name:ident $(($($operand:ident: $kind:ident),*))?;)*) => {
        /// Whether a condition holds for all slots that an instruction names itself.
        fn all_slots(instr: Instr, holds: impl Fn(Slot) -> bool) -> bool {
            match instr {
                $(Instr::$name $(($($operand),*))? => {
                    true $($(&& $operand.slot().is_none_or(&holds))*)?
                })*
            }
        }
    };
}
crate::sap_instructions!(slots_of);
