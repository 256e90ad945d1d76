//! Register code: the instructions of rw_SymPas programs.

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

/// One instruction, 8 bytes. Suffixes: I Integer, D real (Single and Double), T Timer, B Boolean. Where a value is
/// computed the first slot is written and the others are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Instr {
    /// A statement begins on this line.
    Statement(u32),
    Copy(Slot, Slot),
    /// Writes a constant of the pool: those that are used once need no global.
    Constant(Slot, u32),

    // wrap to 32 bits and count an overflow; a divisor 0 is error 8000 hex
    AddI(Slot, Slot, Slot),
    SubI(Slot, Slot, Slot),
    MulI(Slot, Slot, Slot),
    DivI(Slot, Slot, Slot),
    ModI(Slot, Slot, Slot),
    NegI(Slot, Slot),
    ShlI(Slot, Slot, Slot),
    ShrI(Slot, Slot, Slot),
    /// Bits of Integers and truth of Booleans alike.
    And(Slot, Slot, Slot),
    Or(Slot, Slot, Slot),
    Xor(Slot, Slot, Slot),
    NotI(Slot, Slot),
    NotB(Slot, Slot),

    AddD(Slot, Slot, Slot),
    SubD(Slot, Slot, Slot),
    MulD(Slot, Slot, Slot),
    /// A divisor 0 is error 8000 hex.
    DivD(Slot, Slot, Slot),
    NegD(Slot, Slot),

    // modulo 2^32; the operands may be Timers or Integers, whose 32 bits count
    AddT(Slot, Slot, Slot),
    SubT(Slot, Slot, Slot),

    // relations leave a Boolean
    EqI(Slot, Slot, Slot),
    NeI(Slot, Slot, Slot),
    LtI(Slot, Slot, Slot),
    LeI(Slot, Slot, Slot),
    EqD(Slot, Slot, Slot),
    NeD(Slot, Slot, Slot),
    LtD(Slot, Slot, Slot),
    LeD(Slot, Slot, Slot),
    EqT(Slot, Slot, Slot),
    NeT(Slot, Slot, Slot),
    /// b is later than a: (b - a) mod 2^32 lies in 1..2^31-1.
    LtT(Slot, Slot, Slot),
    /// Not b before a.
    LeT(Slot, Slot, Slot),

    // conversions
    /// Integer or Boolean to real.
    ItoD(Slot, Slot),
    /// Timer to real, unsigned.
    TtoD(Slot, Slot),
    /// Real to Integer: toward zero, limited; what is not a number gives 0.
    DtoI(Slot, Slot),
    /// The same 32 bits.
    TtoI(Slot, Slot),
    ItoT(Slot, Slot),
    /// Unequal 0.
    ItoB(Slot, Slot),
    DtoB(Slot, Slot),
    /// To single precision.
    RoundS(Slot, Slot),

    Jump(Address),
    /// Jumps when the Boolean is FALSE.
    JumpIfNot(Slot, Address),
    // these execute the jump behind them when the condition is false
    IfEqI(Slot, Slot),
    IfNeI(Slot, Slot),
    IfLtI(Slot, Slot),
    IfLeI(Slot, Slot),
    IfEqD(Slot, Slot),
    IfNeD(Slot, Slot),
    IfLtD(Slot, Slot),
    IfLeD(Slot, Slot),
    /// End of a `for ... to` body: where `var` < `last` adds 1 and executes the jump behind it (to the body),
    /// else skips it.
    NextUp(Slot, Slot),
    NextDown(Slot, Slot),
    /// Calls routine number `routine`; its frame begins at slot `base` of this frame.
    Call(u16, u16),
    /// Ends a routine; in the main program the task.
    Return,

    Math(Function, Slot, Slot),
    Power(Slot, Slot, Slot),

    /// (parameter, to)
    ReadSystem(SystemParameter, Slot),
    /// (parameter, from)
    WriteSystem(SystemParameter, Slot),
    /// CI and CD by number; above 999 it is error 0400 hex.
    ReadCi(Slot, u32),
    WriteCi(Slot, u32),
    ReadCd(Slot, u32),
    WriteCd(Slot, u32),
    /// SysVarInt[index], SysVarDbl[index]: (which, to, index)
    ReadSysVar(Indexed, Slot, Slot),
    /// (which, index, from)
    WriteSysVar(Indexed, Slot, Slot),
    /// (qualifier, to, axis). An axis number outside the machine is error 0100 hex, here and wherever a slot names an axis.
    ReadAxis(Qualifier, Slot, Slot),
    /// (qualifier, axis, from)
    WriteAxis(Qualifier, Slot, Slot),
    /// (qualifier, bit from 1, to, axis)
    ReadAxisBit(BitQualifier, u8, Slot, Slot),
    /// (qualifier, bit from 1, axis, from)
    WriteAxisBit(BitQualifier, u8, Slot, Slot),
    /// axis.varint[index], axis.vardbl[index]: (which, to, axis, index)
    ReadAxisVar(Indexed, Slot, Slot, Slot),
    /// (which, axis, index, from)
    WriteAxisVar(Indexed, Slot, Slot, Slot),

    /// A command for the axes of a list (6.6), whose values are reals. Path parameters come from the system parameters.
    Do(Command, u32),
    /// Waits for the profile end of the axes of a list, serving events (6.5). Behind `ssms`: for the whole spooler.
    AwaitEnd(bool, u32),
    Task(TaskCommand, u8),
    /// Zero offset set 0..4.
    Azo(u8),
    Enable(Event),
    Disable(Event),
    /// wt: ticks of 64 us.
    Wait(Slot),
    /// stop, abort of the own task.
    Stop,
    Abort,

    /// rdcbi, rdcbs, rdcbd: the type is Integer, Single or Double: (kind, to, offset).
    ReadBuffer(Type, Slot, Slot),
    /// (kind, offset, from)
    WriteBuffer(Type, Slot, Slot),

    /// Appends to the output string.
    WriteText(u32),
    WriteValue(Type, Slot),
    /// Closes the output string; with StopAtWriteln the task stops behind it.
    Writeln,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instruction_takes_eight_bytes() {
        assert_eq!(size_of::<Instr>(), 8);
    }
}
