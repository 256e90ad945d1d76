//! The instructions as bytes and as text, both derived from the table of instructions (`motion_kernel::sap::code`).

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

motion_kernel::sap_instructions!(instructions);
