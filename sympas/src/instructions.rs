//! The instructions as bytes and as text: one table of numbers and operands, from which both are derived.
//!
//! Numbers never change their meaning: a new instruction takes a new one.

use motion_kernel::sap::code::{Instr, Slot};
use motion_kernel::sap::tables::{
    BitQualifier, Command, Event, Function, Indexed, Qualifier, SystemParameter, TaskCommand, Type,
};

use crate::cnc::Reader;

/// An operand of an instruction.
pub(crate) trait Field: Sized {
    fn put(self, out: &mut Vec<u8>);
    /// `None` if the bytes end or name nothing.
    fn get(from: &mut Reader) -> Option<Self>;
    fn shown(self, slot: &dyn Fn(Slot) -> String) -> String;
}

macro_rules! numbers {
    ($($kind:ident)*) => {$(
        impl Field for $kind {
            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn get(from: &mut Reader) -> Option<Self> {
                from.take().map($kind::from_le_bytes)
            }
            fn shown(self, _: &dyn Fn(Slot) -> String) -> String {
                self.to_string()
            }
        }
    )*};
}

numbers! { u8 u16 u32 u64 }

/// Members of the tables of predefined names, by their number there.
macro_rules! names {
    ($($kind:ident)*) => {$(
        impl Field for $kind {
            fn put(self, out: &mut Vec<u8>) {
                (self as u8).put(out);
            }
            fn get(from: &mut Reader) -> Option<Self> {
                u8::get(from).and_then($kind::by_number)
            }
            fn shown(self, _: &dyn Fn(Slot) -> String) -> String {
                self.name().to_owned()
            }
        }
    )*};
}

names! { SystemParameter Qualifier BitQualifier Function Command TaskCommand Event }

impl Field for Slot {
    fn put(self, out: &mut Vec<u8>) {
        self.0.put(out);
    }
    fn get(from: &mut Reader) -> Option<Self> {
        u16::get(from).map(Slot)
    }
    fn shown(self, slot: &dyn Fn(Slot) -> String) -> String {
        slot(self)
    }
}

impl Field for bool {
    fn put(self, out: &mut Vec<u8>) {
        u8::from(self).put(out);
    }
    fn get(from: &mut Reader) -> Option<Self> {
        u8::get(from).filter(|b| *b < 2).map(|b| b == 1)
    }
    fn shown(self, _: &dyn Fn(Slot) -> String) -> String {
        self.to_string()
    }
}

impl Field for Indexed {
    fn put(self, out: &mut Vec<u8>) {
        (self == Indexed::Double).put(out);
    }
    fn get(from: &mut Reader) -> Option<Self> {
        bool::get(from).map(|double| if double { Indexed::Double } else { Indexed::Integer })
    }
    fn shown(self, _: &dyn Fn(Slot) -> String) -> String {
        format!("{self:?}")
    }
}

impl Field for Type {
    fn put(self, out: &mut Vec<u8>) {
        (self as u8).put(out);
    }
    fn get(from: &mut Reader) -> Option<Self> {
        u8::get(from).and_then(|n| Type::ALL.get(usize::from(n)).copied())
    }
    fn shown(self, _: &dyn Fn(Slot) -> String) -> String {
        self.name().to_owned()
    }
}

macro_rules! instructions {
    ($($number:literal $name:ident $(($($operand:ident: $kind:ident),*))?;)*) => {
        pub(crate) fn put(instr: Instr, out: &mut Vec<u8>) {
            match instr {
                $(Instr::$name $(($($operand),*))? => {
                    out.push($number);
                    $($($operand.put(out);)*)?
                })*
            }
        }
        /// `None` if the bytes are no instruction.
        pub(crate) fn get(from: &mut Reader) -> Option<Instr> {
            match u8::get(from)? {
                $($number => Some(Instr::$name $(($(<$kind as Field>::get(from)?),*))?),)*
                _ => None,
            }
        }
        /// Name and operands.
        pub(crate) fn shown(instr: Instr, slot: &dyn Fn(Slot) -> String) -> (&'static str, Vec<String>) {
            match instr {
                $(Instr::$name $(($($operand),*))? => {
                    (stringify!($name), vec![$($($operand.shown(slot)),*)?])
                })*
            }
        }
    };
}

instructions! {
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
