//! Compiled programs as text: the disassembler.

use std::fmt::Write;

use motion_kernel::sap::code::Slot;
use motion_kernel::sap::program::{Operand, Program, VariableKind};
use motion_kernel::sap::tables::Event;

use crate::instructions;

/// One line per instruction, with the source line where it changes, below what belongs to the program as a whole.
pub fn listing(program: &Program) -> String {
    let mut out = String::new();
    head(program, &mut out);
    let mut place = (u16::MAX, 0);
    for (address, instr) in program.code.iter().enumerate() {
        let current = program.routines.iter().position(|r| r.entry as usize == address);
        if let Some(number) = current {
            let routine = &program.routines[number];
            let name = if number == 0 { "main program" } else { routine.name.as_str() };
            let kind = if routine.function { "function" } else { "procedure" };
            let kind = if number == 0 { "routine" } else { kind };
            let _ =
                writeln!(out, "\n{kind} {number} {name}: {} parameters, {} slots", routine.parameters, routine.frame);
        }
        let here = program.lines[address];
        let shown = if here == place { String::new() } else { place_text(program, here) };
        place = here;
        let routine = routine_of(program, address);
        let (name, operands) = instructions::shown(*instr, &|slot| slot_text(program, routine, slot));
        let operands = match instr {
            motion_kernel::sap::code::Instr::Do(_, list) | motion_kernel::sap::code::Instr::AwaitEnd(_, list) => {
                format!("{} ({})", operands[0], list_text(program, routine, *list))
            }
            motion_kernel::sap::code::Instr::Constant(_, number) => {
                let value =
                    program.constants.get(*number as usize).map_or_else(String::new, |bits| literal_text(*bits));
                format!("{}, {value}", operands[0])
            }
            motion_kernel::sap::code::Instr::WriteText(text) => {
                program.texts.get(*text as usize).map_or_else(String::new, |t| format!("'{}'", t.escape_debug()))
            }
            _ => operands.join(", "),
        };
        let _ = writeln!(out, "{}", format!("{address:6}  {shown:16} {name:12} {operands}").trim_end());
    }
    out
}

fn head(program: &Program, out: &mut String) {
    let name = if program.name.is_empty() { "(no name)" } else { &program.name };
    let task = program.task.map_or("any task".to_owned(), |n| format!("task {n}"));
    let full = if program.full_system { ", FULLSYSTEM" } else { "" };
    let _ = writeln!(out, "program {name}: {task}{full}, {} axes, {} globals", program.axes, program.globals.len());
    for variable in &program.variables {
        let kind = match variable.kind {
            VariableKind::Axis => "Axis",
            VariableKind::Value(of) => of.name(),
        };
        let slot = plain_slot(variable.slot);
        let owner = match variable.routine {
            0 => String::new(),
            n => format!(" of {}", program.routines[usize::from(n)].name),
        };
        let _ = writeln!(out, "  {slot:6} {}: {kind}{owner}", variable.name);
    }
    for (event, handler) in Event::ALL.iter().zip(&program.events) {
        if let Some(number) = handler {
            let _ = writeln!(out, "  {} is handled by routine {number}", event.name());
        }
    }
}

fn place_text(program: &Program, (file, line): (u16, u32)) -> String {
    match file {
        0 => format!("line {line}"),
        _ => format!("{}:{line}", program.files.get(usize::from(file)).map_or("?", String::as_str)),
    }
}

/// The routine that an address belongs to.
fn routine_of(program: &Program, address: usize) -> u16 {
    let starts = program.routines.iter().enumerate().filter(|(_, r)| r.entry as usize <= address);
    starts.max_by_key(|(_, r)| r.entry).map_or(0, |(n, _)| n as u16)
}

fn plain_slot(slot: Slot) -> String {
    format!("{}{}", if slot.is_global() { "g" } else { "l" }, slot.index())
}

/// A variable by its name, a literal by its value, a temporary by its number.
fn slot_text(program: &Program, routine: u16, slot: Slot) -> String {
    let owner = if slot.is_global() { 0 } else { routine };
    let named = program.variables.iter().find(|v| v.slot == slot && v.routine == owner);
    if let Some(variable) = named {
        return variable.name.clone();
    }
    match program.globals.get(slot.index()).filter(|_| slot.is_global()) {
        Some(bits) => literal_text(*bits),
        None => plain_slot(slot),
    }
}

/// Integers are small numbers, the bits of reals large ones.
fn literal_text(bits: u64) -> String {
    let whole = bits as i64;
    if (i64::from(i32::MIN)..=i64::from(u32::MAX)).contains(&whole) {
        whole.to_string()
    } else {
        format!("{:?}", f64::from_bits(bits))
    }
}

fn list_text(program: &Program, routine: u16, list: u32) -> String {
    let one = |o: &Operand| {
        let axis = slot_text(program, routine, o.axis);
        if o.axis == o.value { axis } else { format!("{axis} := {}", slot_text(program, routine, o.value)) }
    };
    let list = program.lists.get(list as usize).map_or(&[][..], Vec::as_slice);
    list.iter().map(one).collect::<Vec<_>>().join(", ")
}
