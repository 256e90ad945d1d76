//! The compiled program of a CNC task: its code and what the code refers to. Immutable.

use super::code::{Address, Instr, Slot};
use super::tables::{Event, Type};

/// An axis of a command's list and its value (a slot of a real); where the command has none the value is the axis slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Operand {
    pub axis: Slot,
    pub value: Slot,
}

/// A procedure, a function, or the main program (number 0).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Routine {
    pub name: String,
    pub entry: Address,
    /// Slots of its frame: result, parameters, locals and temporaries.
    pub frame: u16,
    pub parameters: u16,
    /// A function has its result in slot 0 and its parameters behind it; a procedure has parameters from slot 0 on.
    pub function: bool,
}

impl Routine {
    /// Slots that lie in the caller's frame too: the result and the parameters.
    pub const fn given(&self) -> u16 {
        self.parameters + self.function as u16
    }
}

/// A variable as the debugger shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    pub name: String,
    /// Routine it belongs to; 0 and a global slot: the main program.
    pub routine: u16,
    pub slot: Slot,
    pub kind: VariableKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableKind {
    Value(Type),
    Axis,
}

/// A compiled rw_SymPas program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    pub name: String,
    /// `{$TASK n}`.
    pub task: Option<u8>,
    /// `{$FULLSYSTEM}`.
    pub full_system: bool,
    /// Axes that the program was compiled for: it does not run where there are fewer.
    pub axes: u8,
    pub code: Vec<Instr>,
    /// Source of each instruction, parallel to `code`: file (of `files`) and 1-based line.
    pub lines: Vec<(u16, u32)>,
    pub files: Vec<String>,
    /// Global slots with their values at the start of the task.
    pub globals: Vec<u64>,
    pub constants: Vec<u64>,
    pub routines: Vec<Routine>,
    pub lists: Vec<Vec<Operand>>,
    pub texts: Vec<String>,
    /// Routine that handles the event, in the order of [`Event::ALL`].
    pub events: [Option<u16>; Event::ALL.len()],
    pub variables: Vec<Variable>,
}

impl Program {
    /// What is added to the lines of each file so that one number, a *place*, names a line of all of them: the text of
    /// the job first, its includes behind it; at the end the number of all lines. Lines behind the last instruction of
    /// a file have no place.
    pub fn offsets(&self) -> Vec<u32> {
        let mut most = vec![1; self.files.len()];
        for &(file, line) in &self.lines {
            if let Some(most) = most.get_mut(usize::from(file)) {
                *most = line.max(*most);
            }
        }
        let sums = most.iter().scan(0_u32, |sum, lines| {
            *sum = sum.saturating_add(*lines);
            Some(*sum)
        });
        std::iter::once(0).chain(sums).collect()
    }
}

/// Slot values.
pub const fn integer(value: i32) -> u64 {
    value as i64 as u64
}
pub const fn timer(value: u32) -> u64 {
    value as u64
}
pub const fn boolean(value: bool) -> u64 {
    value as u64
}
pub const fn real(value: f64) -> u64 {
    value.to_bits()
}
