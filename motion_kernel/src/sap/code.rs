//! The compiled program of a CNC task: register code with its pools. Immutable once verified.

use super::tables::{BitQualifier, Command, Event, Function, Indexed, Qualifier, SystemParameter, TaskCommand, Type};

/// A slot of 64 bits. Bit 15 set: a global; else one of the running routine's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Slot(pub u16);

/// Slots that globals (literals, axes and variables) and one frame may take.
pub const MOST_GLOBALS: usize = 8192;
pub const MOST_FRAME: usize = 1024;

impl Slot {
    pub const fn global(index: u16) -> Slot {
        Slot(index | 0x8000)
    }
    pub const fn local(index: u16) -> Slot {
        Slot(index)
    }
    pub const fn is_global(self) -> bool {
        self.0 & 0x8000 != 0
    }
    pub const fn index(self) -> usize {
        (self.0 & 0x7FFF) as usize
    }
}

/// Address of an instruction.
pub type Address = u32;

/// One instruction, 8 bytes. `to` is written, all other slots are read; suffixes: I Integer, D real (Single and
/// Double), T Timer, B Boolean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Instr {
    /// A statement begins on this line.
    Statement {
        line: u32,
    },
    Copy {
        to: Slot,
        from: Slot,
    },
    /// Writes 0: FALSE, 0, 0.0.
    Clear {
        to: Slot,
    },

    // wrap to 32 bits and count an overflow; a divisor 0 is error 8000 hex
    AddI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    SubI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    MulI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    DivI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    ModI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    NegI {
        to: Slot,
        a: Slot,
    },
    ShlI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    ShrI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    /// Bits of Integers and truth of Booleans alike.
    And {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    Or {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    Xor {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    NotI {
        to: Slot,
        a: Slot,
    },
    NotB {
        to: Slot,
        a: Slot,
    },

    AddD {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    SubD {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    MulD {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    /// A divisor 0 is error 8000 hex.
    DivD {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    NegD {
        to: Slot,
        a: Slot,
    },

    // modulo 2^32; the operands may be Timers or Integers, whose 32 bits count
    AddT {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    SubT {
        to: Slot,
        a: Slot,
        b: Slot,
    },

    // relations leave a Boolean
    EqI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    NeI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    LtI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    LeI {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    EqD {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    NeD {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    LtD {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    LeD {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    EqT {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    NeT {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    /// b is later than a: (b - a) mod 2^32 lies in 1..2^31-1.
    LtT {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    /// Not b before a.
    LeT {
        to: Slot,
        a: Slot,
        b: Slot,
    },

    // conversions
    /// Integer or Boolean to real.
    ItoD {
        to: Slot,
        a: Slot,
    },
    /// Timer to real, unsigned.
    TtoD {
        to: Slot,
        a: Slot,
    },
    /// Real to Integer: toward zero, limited; what is not a number gives 0.
    DtoI {
        to: Slot,
        a: Slot,
    },
    /// The same 32 bits.
    TtoI {
        to: Slot,
        a: Slot,
    },
    ItoT {
        to: Slot,
        a: Slot,
    },
    /// Unequal 0.
    ItoB {
        to: Slot,
        a: Slot,
    },
    DtoB {
        to: Slot,
        a: Slot,
    },
    /// To single precision.
    RoundS {
        to: Slot,
        a: Slot,
    },

    Jump {
        to: Address,
    },
    /// Jumps when the Boolean is FALSE.
    JumpIfNot {
        a: Slot,
        to: Address,
    },
    // these execute the jump behind them when the condition is false
    IfEqI {
        a: Slot,
        b: Slot,
    },
    IfNeI {
        a: Slot,
        b: Slot,
    },
    IfLtI {
        a: Slot,
        b: Slot,
    },
    IfLeI {
        a: Slot,
        b: Slot,
    },
    IfEqD {
        a: Slot,
        b: Slot,
    },
    IfNeD {
        a: Slot,
        b: Slot,
    },
    IfLtD {
        a: Slot,
        b: Slot,
    },
    IfLeD {
        a: Slot,
        b: Slot,
    },
    /// End of a `for ... to` body: where `var` < `last` adds 1 and executes the jump behind it (to the body),
    /// else skips it.
    NextUp {
        var: Slot,
        last: Slot,
    },
    NextDown {
        var: Slot,
        last: Slot,
    },
    /// Calls routine number `routine`; its frame begins at slot `base` of this frame.
    Call {
        routine: u16,
        base: u16,
    },
    /// Ends a routine; in the main program the task.
    Return,

    Math {
        function: Function,
        to: Slot,
        a: Slot,
    },
    Power {
        to: Slot,
        a: Slot,
        b: Slot,
    },

    ReadSystem {
        parameter: SystemParameter,
        to: Slot,
    },
    WriteSystem {
        parameter: SystemParameter,
        from: Slot,
    },
    /// CI and CD by number; above 999 it is error 0400 hex.
    ReadCi {
        to: Slot,
        number: u32,
    },
    WriteCi {
        from: Slot,
        number: u32,
    },
    ReadCd {
        to: Slot,
        number: u32,
    },
    WriteCd {
        from: Slot,
        number: u32,
    },
    /// SysVarInt[index], SysVarDbl[index].
    ReadSysVar {
        which: Indexed,
        to: Slot,
        index: Slot,
    },
    WriteSysVar {
        which: Indexed,
        index: Slot,
        from: Slot,
    },
    /// An axis number outside the machine is error 0100 hex, here and wherever a slot names an axis.
    ReadAxis {
        qualifier: Qualifier,
        to: Slot,
        axis: Slot,
    },
    WriteAxis {
        qualifier: Qualifier,
        axis: Slot,
        from: Slot,
    },
    ReadAxisBit {
        qualifier: BitQualifier,
        bit: u8,
        to: Slot,
        axis: Slot,
    },
    WriteAxisBit {
        qualifier: BitQualifier,
        bit: u8,
        axis: Slot,
        from: Slot,
    },
    /// axis.varint[index], axis.vardbl[index].
    ReadAxisVar {
        which: Indexed,
        to: Slot,
        axis: Slot,
        index: Slot,
    },
    WriteAxisVar {
        which: Indexed,
        axis: Slot,
        index: Slot,
        from: Slot,
    },

    /// A command for the axes of a list (6.6). Path parameters come from the system parameters.
    Do {
        command: Command,
        list: u32,
    },
    /// Waits for the profile end of the axes of a list, serving events (6.5). Behind `ssms`: for the whole spooler.
    AwaitEnd {
        spooler: bool,
        list: u32,
    },
    Task {
        command: TaskCommand,
        number: u8,
    },
    /// Zero offset set 0..4.
    Azo {
        set: u8,
    },
    Enable {
        event: Event,
    },
    Disable {
        event: Event,
    },
    /// wt: ticks of 64 us.
    Wait {
        a: Slot,
    },
    /// stop, abort of the own task.
    Stop,
    Abort,

    /// rdcbi, rdcbs, rdcbd: the type is Integer, Single or Double.
    ReadBuffer {
        kind: Type,
        to: Slot,
        offset: Slot,
    },
    WriteBuffer {
        kind: Type,
        offset: Slot,
        from: Slot,
    },

    /// Appends to the output string.
    WriteText {
        text: u32,
    },
    WriteValue {
        kind: Type,
        from: Slot,
    },
    /// Closes the output string; with StopAtWriteln the task stops behind it.
    Writeln,
}

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
    /// Slots of its frame: parameters, result, locals and temporaries.
    pub frame: u16,
    /// Parameters stand in its slots 0, 1, ...
    pub parameters: u16,
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
    pub routines: Vec<Routine>,
    pub lists: Vec<Vec<Operand>>,
    pub texts: Vec<String>,
    /// Routine that handles the event, in the order of [`Event::ALL`].
    pub events: [Option<u16>; Event::ALL.len()],
    pub variables: Vec<Variable>,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instruction_takes_eight_bytes() {
        assert_eq!(size_of::<Instr>(), 8);
    }
}
