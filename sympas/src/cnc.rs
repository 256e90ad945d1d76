//! Autocode files (`.cnc`): a compiled program as bytes.
//!
//! Eight bytes of magic, version, length and CRC-32 of what follows; then the program, numbers little-endian. A file is
//! accepted only if all of that is right and the program passes `motion_kernel::sap::verify`.

use motion_kernel::sap::program::{Operand, Program, Routine, Variable, VariableKind};
use motion_kernel::sap::tables::{Event, Type};
use motion_kernel::sap::verify::verify;

use crate::instructions::{self, Field};

/// The first bytes of every autocode file; a text transfer damages them.
pub const MAGIC: &[u8; 8] = b"\x89CNC\r\n\x1a\n";
pub const VERSION: u16 = 1;
/// No program is larger.
pub const MAX_BYTES: usize = 64 << 20;
const HEADER: usize = 18;

/// Why bytes are no program that a task may execute.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CncError {
    /// No autocode file at all.
    Magic,
    /// Written by another version (error 0004 hex of table 40).
    Version(u16),
    /// Cut off, longer than it says, or changed.
    Damaged,
    /// The bytes at this offset are no part of a program.
    Malformed(usize),
    /// The program could harm the controller.
    Refused(String),
}

impl std::fmt::Display for CncError {
    fn fmt(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            CncError::Magic => out.write_str("no autocode file"),
            CncError::Version(n) => write!(out, "autocode of version {n}, this controller reads version {VERSION}"),
            CncError::Damaged => out.write_str("the autocode file is damaged (length or checksum)"),
            CncError::Malformed(at) => write!(out, "malformed autocode at byte {at}"),
            CncError::Refused(reason) => write!(out, "autocode refused: {reason}"),
        }
    }
}

/// The file of a program.
pub fn encode(program: &Program) -> Vec<u8> {
    let mut body = Vec::new();
    put_program(program, &mut body);
    let mut out = MAGIC.to_vec();
    VERSION.put(&mut out);
    (body.len() as u32).put(&mut out);
    crc32(&body).put(&mut out);
    out.extend_from_slice(&body);
    out
}

/// The program of a file.
///
/// # Errors
/// When it is none, or not one that a task may execute. Memory stays within a small multiple of the file's size.
pub fn decode(bytes: &[u8]) -> Result<Program, CncError> {
    let Some((magic, rest)) = bytes.split_at_checked(MAGIC.len()) else { return Err(CncError::Magic) };
    if magic != MAGIC {
        return Err(CncError::Magic);
    }
    let mut header = Reader { bytes: rest, at: 0 };
    let version = u16::get(&mut header).ok_or(CncError::Damaged)?;
    if version != VERSION {
        return Err(CncError::Version(version));
    }
    let length = u32::get(&mut header).ok_or(CncError::Damaged)?;
    let sum = u32::get(&mut header).ok_or(CncError::Damaged)?;
    let body = &bytes[HEADER..];
    if body.len() != length as usize || body.len() > MAX_BYTES || crc32(body) != sum {
        return Err(CncError::Damaged);
    }
    let mut reader = Reader { bytes: body, at: 0 };
    let program = get_program(&mut reader).ok_or(CncError::Malformed(HEADER + reader.at))?;
    if reader.at != body.len() {
        return Err(CncError::Malformed(HEADER + reader.at));
    }
    verify(&program).map_err(|refusal| CncError::Refused(refusal.to_string()))?;
    if program.variables.iter().any(|v| usize::from(v.routine) >= program.routines.len()) {
        return Err(CncError::Refused("a variable of an unknown routine".to_owned()));
    }
    Ok(program)
}

/// CRC-32 as of zip and PNG.
fn crc32(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 256] = {
        let mut table = [0; 256];
        let mut n = 0;
        while n < 256 {
            let (mut value, mut bit) = (n as u32, 0);
            while bit < 8 {
                value = if value & 1 == 1 { 0xEDB8_8320 ^ value >> 1 } else { value >> 1 };
                bit += 1;
            }
            table[n] = value;
            n += 1;
        }
        table
    };
    !bytes.iter().fold(!0, |sum: u32, byte| TABLE[usize::from(sum as u8 ^ byte)] ^ sum >> 8)
}

/// Bytes that are read from front to back.
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    /// The next `N` bytes.
    pub(crate) fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let bytes = self.bytes.get(self.at..self.at + N)?.try_into().ok()?;
        self.at += N;
        Some(bytes)
    }
    /// A list; its length is believed only as far as bytes are there for it.
    fn list<T>(&mut self, least: usize, mut one: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = u32::get(self)? as usize;
        if count.checked_mul(least)? > self.bytes.len() - self.at {
            return None;
        }
        (0..count).map(|_| one(self)).collect()
    }
    fn text(&mut self) -> Option<String> {
        let bytes = self.list(1, u8::get)?;
        String::from_utf8(bytes).ok()
    }
}

fn put_text(text: &str, out: &mut Vec<u8>) {
    (text.len() as u32).put(out);
    out.extend_from_slice(text.as_bytes());
}

fn put_list<T>(list: &[T], out: &mut Vec<u8>, mut one: impl FnMut(&T, &mut Vec<u8>)) {
    (list.len() as u32).put(out);
    list.iter().for_each(|item| one(item, out));
}

/// An optional number, as one more than it.
fn put_option(value: Option<u16>, out: &mut Vec<u8>) {
    value.map_or(0, |n| u32::from(n) + 1).put(out);
}

fn get_option(from: &mut Reader) -> Option<Option<u16>> {
    let number = u32::get(from)?;
    if number == 0 { Some(None) } else { u16::try_from(number - 1).ok().map(Some) }
}

fn put_program(program: &Program, out: &mut Vec<u8>) {
    put_text(&program.name, out);
    put_option(program.task.map(u16::from), out);
    program.full_system.put(out);
    program.axes.put(out);
    put_list(&program.code, out, |instr, out| instructions::put(*instr, out));
    put_list(&program.lines, out, |(file, line), out| {
        file.put(out);
        line.put(out);
    });
    put_list(&program.files, out, |text, out| put_text(text, out));
    put_list(&program.globals, out, |bits, out| bits.put(out));
    put_list(&program.constants, out, |bits, out| bits.put(out));
    put_list(&program.routines, out, |routine, out| {
        put_text(&routine.name, out);
        routine.entry.put(out);
        routine.frame.put(out);
        routine.parameters.put(out);
        routine.function.put(out);
    });
    put_list(&program.lists, out, |list, out| {
        put_list(list, out, |operand, out| {
            operand.axis.put(out);
            operand.value.put(out);
        });
    });
    put_list(&program.texts, out, |text, out| put_text(text, out));
    program.events.iter().for_each(|handler| put_option(*handler, out));
    put_list(&program.variables, out, |variable, out| {
        put_text(&variable.name, out);
        variable.routine.put(out);
        variable.slot.put(out);
        match variable.kind {
            VariableKind::Axis => Type::ALL.len() as u8,
            VariableKind::Value(of) => of as u8,
        }
        .put(out);
    });
}

fn get_program(from: &mut Reader) -> Option<Program> {
    let name = from.text()?;
    let task = match get_option(from)? {
        Some(n) => Some(u8::try_from(n).ok()?),
        None => None,
    };
    Some(Program {
        name,
        task,
        full_system: bool::get(from)?,
        axes: u8::get(from)?,
        code: from.list(1, instructions::get)?,
        lines: from.list(6, |r| Some((u16::get(r)?, u32::get(r)?)))?,
        files: from.list(4, Reader::text)?,
        globals: from.list(8, u64::get)?,
        constants: from.list(8, u64::get)?,
        routines: from.list(13, get_routine)?,
        lists: from.list(4, |r| r.list(4, |r| Some(Operand { axis: Field::get(r)?, value: Field::get(r)? })))?,
        texts: from.list(4, Reader::text)?,
        events: get_events(from)?,
        variables: from.list(9, get_variable)?,
    })
}

fn get_routine(from: &mut Reader) -> Option<Routine> {
    Some(Routine {
        name: from.text()?,
        entry: u32::get(from)?,
        frame: u16::get(from)?,
        parameters: u16::get(from)?,
        function: bool::get(from)?,
    })
}

fn get_events(from: &mut Reader) -> Option<[Option<u16>; Event::ALL.len()]> {
    let mut events = [None; Event::ALL.len()];
    for handler in &mut events {
        *handler = get_option(from)?;
    }
    Some(events)
}

fn get_variable(from: &mut Reader) -> Option<Variable> {
    let (name, routine, slot) = (from.text()?, u16::get(from)?, Field::get(from)?);
    let number = usize::from(u8::get(from)?);
    let kind = match Type::ALL.get(number) {
        Some(of) => VariableKind::Value(*of),
        None if number == Type::ALL.len() => VariableKind::Axis,
        None => return None,
    };
    Some(Variable { name, routine, slot, kind })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_zip() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }
}
