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

/// The table of instructions: number in an autocode file, name, operands and their types. `$use` is a macro that makes
/// something of it: bytes and text in the compiler, the slots that the verifier looks at.
///
/// Numbers never change their meaning: a new instruction takes a new one.
#[macro_export]
macro_rules! sap_instructions {
    ($use:ident) => {
        $use! {
            0 Statement(line: u32);
            1 Copy(a: Slot, b: Slot);
            2 Constant(a: Slot, number: u32);
            10 AddI(a: Slot, b: Slot, c: Slot);
            11 SubI(a: Slot, b: Slot, c: Slot);
            12 MulI(a: Slot, b: Slot, c: Slot);
            13 DivI(a: Slot, b: Slot, c: Slot);
            14 ModI(a: Slot, b: Slot, c: Slot);
            15 NegI(a: Slot, b: Slot);
            16 ShlI(a: Slot, b: Slot, c: Slot);
            17 ShrI(a: Slot, b: Slot, c: Slot);
            18 And(a: Slot, b: Slot, c: Slot);
            19 Or(a: Slot, b: Slot, c: Slot);
            20 Xor(a: Slot, b: Slot, c: Slot);
            21 NotI(a: Slot, b: Slot);
            22 NotB(a: Slot, b: Slot);
            30 AddD(a: Slot, b: Slot, c: Slot);
            31 SubD(a: Slot, b: Slot, c: Slot);
            32 MulD(a: Slot, b: Slot, c: Slot);
            33 DivD(a: Slot, b: Slot, c: Slot);
            34 NegD(a: Slot, b: Slot);
            35 AddT(a: Slot, b: Slot, c: Slot);
            36 SubT(a: Slot, b: Slot, c: Slot);
            40 EqI(a: Slot, b: Slot, c: Slot);
            41 NeI(a: Slot, b: Slot, c: Slot);
            42 LtI(a: Slot, b: Slot, c: Slot);
            43 LeI(a: Slot, b: Slot, c: Slot);
            44 EqD(a: Slot, b: Slot, c: Slot);
            45 NeD(a: Slot, b: Slot, c: Slot);
            46 LtD(a: Slot, b: Slot, c: Slot);
            47 LeD(a: Slot, b: Slot, c: Slot);
            48 EqT(a: Slot, b: Slot, c: Slot);
            49 NeT(a: Slot, b: Slot, c: Slot);
            50 LtT(a: Slot, b: Slot, c: Slot);
            51 LeT(a: Slot, b: Slot, c: Slot);
            60 ItoD(a: Slot, b: Slot);
            61 TtoD(a: Slot, b: Slot);
            62 DtoI(a: Slot, b: Slot);
            63 TtoI(a: Slot, b: Slot);
            64 ItoT(a: Slot, b: Slot);
            65 ItoB(a: Slot, b: Slot);
            66 DtoB(a: Slot, b: Slot);
            67 RoundS(a: Slot, b: Slot);
            70 Jump(to: u32);
            71 JumpIfNot(a: Slot, to: u32);
            72 IfEqI(a: Slot, b: Slot);
            73 IfNeI(a: Slot, b: Slot);
            74 IfLtI(a: Slot, b: Slot);
            75 IfLeI(a: Slot, b: Slot);
            76 IfEqD(a: Slot, b: Slot);
            77 IfNeD(a: Slot, b: Slot);
            78 IfLtD(a: Slot, b: Slot);
            79 IfLeD(a: Slot, b: Slot);
            80 NextUp(a: Slot, b: Slot);
            81 NextDown(a: Slot, b: Slot);
            82 Call(routine: u16, base: u16);
            83 Return;
            90 Math(function: Function, a: Slot, b: Slot);
            91 Power(a: Slot, b: Slot, c: Slot);
            100 ReadSystem(parameter: SystemParameter, to: Slot);
            101 WriteSystem(parameter: SystemParameter, from: Slot);
            102 ReadCi(to: Slot, number: u32);
            103 WriteCi(from: Slot, number: u32);
            104 ReadCd(to: Slot, number: u32);
            105 WriteCd(from: Slot, number: u32);
            106 ReadSysVar(which: Indexed, to: Slot, index: Slot);
            107 WriteSysVar(which: Indexed, index: Slot, from: Slot);
            108 ReadAxis(qualifier: Qualifier, to: Slot, axis: Slot);
            109 WriteAxis(qualifier: Qualifier, axis: Slot, from: Slot);
            110 ReadAxisBit(qualifier: BitQualifier, bit: u8, to: Slot, axis: Slot);
            111 WriteAxisBit(qualifier: BitQualifier, bit: u8, axis: Slot, from: Slot);
            112 ReadAxisVar(which: Indexed, to: Slot, axis: Slot, index: Slot);
            113 WriteAxisVar(which: Indexed, axis: Slot, index: Slot, from: Slot);
            120 Do(command: Command, list: u32);
            121 AwaitEnd(spooler: bool, list: u32);
            122 Task(command: TaskCommand, task: u8);
            123 Azo(set: u8);
            124 Enable(event: Event);
            125 Disable(event: Event);
            126 Wait(ticks: Slot);
            127 Stop;
            128 Abort;
            130 ReadBuffer(kind: Type, to: Slot, offset: Slot);
            131 WriteBuffer(kind: Type, offset: Slot, from: Slot);
            140 WriteText(text: u32);
            141 WriteValue(kind: Type, from: Slot);
            142 Writeln;
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instruction_takes_eight_bytes() {
        assert_eq!(size_of::<Instr>(), 8);
    }
}
