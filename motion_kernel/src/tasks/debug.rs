//! Looking into a task that executes a rw_SymPas program: breakpoints, steps over calls, variables by name. The board
//! has nothing of this; it changes nothing of what a program does.

use super::vm::Task;
use crate::mcu::Mcu;
use crate::sap::program::{self, Variable, VariableKind};
use crate::sap::tables::{Event, Type};

/// Value of a variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    Boolean(bool),
    Integer(i32),
    Timer(u32),
    /// Single and Double.
    Real(f64),
    /// Number of the axis that an axis name or AXIS variable stands for.
    Axis(i32),
}

impl Task {
    /// Where the task is, or where it failed, as `Processor::place` counts lines.
    pub(super) fn place(&self) -> u32 {
        match (&self.sap, self.error) {
            (Some(sap), Some(_)) => sap.executed_place(),
            (Some(sap), None) => sap.place(),
            (None, Some(error)) => error.line,
            (None, None) => self.line(),
        }
    }
}

impl Mcu {
    /// The task stops before statements at these places (lines, counted over all files of the program), in single-step
    /// mode (`stepcnct`, `contcnct` go on). Without a rw_SymPas program there is nothing to stop: false.
    pub fn break_at(&mut self, task: usize, places: Vec<u32>) -> bool {
        let Some(sap) = &mut self.tasks[task].sap else { return false };
        sap.stepping.breaks = places;
        true
    }
    /// Places before which a task can stop: those of statements, rising.
    pub fn break_places(&self, task: usize) -> Vec<u32> {
        self.tasks[task].sap.as_ref().map_or(Vec::new(), |sap| sap.break_places())
    }
    /// What is added to the places of a task, so that one number names a line of the programs of all tasks. It lasts until
    /// another program is loaded.
    pub fn number_lines(&mut self, task: usize, first: u32) {
        if let Some(sap) = &mut self.tasks[task].sap {
            sap.first_line = first.min(u32::MAX / 2);
        }
    }
    /// The rw_SymPas program of a task.
    pub fn sap_program(&self, task: usize) -> Option<&program::Program> {
        self.tasks[task].sap.as_ref().map(|sap| &*sap.program)
    }
    /// Place that comes next, or at which the task failed; 0 without a program.
    pub fn place(&self, task: usize) -> u32 {
        self.tasks[task].place()
    }
    /// As `stepcnct`, but the lines of routines that the line calls are passed.
    pub fn step_over(&mut self, task: usize) {
        self.stepcnct(task);
        if let Some(sap) = &mut self.tasks[task].sap {
            sap.step(true);
        }
    }
    /// Runs on to the end of the routine being executed, and stops in the one that called it; the main program runs on.
    pub fn step_out(&mut self, task: usize) {
        if self.calls(task).len() < 2 {
            return self.contcnct(task);
        }
        self.stepcnct(task);
        if let Some(sap) = &mut self.tasks[task].sap {
            sap.step_out();
        }
    }
    /// Names of the events that the task has enabled (enev).
    pub fn enabled_events(&self, task: usize) -> Vec<&'static str> {
        let enabled = self.tasks[task].sap.as_ref().map_or(0, |sap| sap.enabled);
        Event::ALL.iter().filter(|&&e| enabled >> e as u8 & 1 == 1).map(|e| e.name()).collect()
    }
    /// Names of the routines that are being executed, the main program first.
    pub fn calls(&self, task: usize) -> Vec<&str> {
        self.tasks[task].sap.as_ref().map_or(Vec::new(), |sap| sap.calls())
    }
    /// Variables of all routines being executed with their values and the number of the call in `calls`: those of the
    /// main program (0) first.
    pub fn variables(&self, task: usize) -> Vec<(&Variable, usize, Value)> {
        let Some(sap) = &self.tasks[task].sap else { return Vec::new() };
        let of_call = |(call, (routine, base)): (usize, (u16, usize))| {
            let own = move |v: &&Variable| if call == 0 { v.slot.is_global() } else { belongs(v, routine) };
            let row = move |v| (v, call, value_of(v, sap.get_in(v.slot, base)));
            sap.program.variables.iter().filter(own).map(row)
        };
        sap.frames().enumerate().flat_map(of_call).collect()
    }
    /// Sets the variable of that name that the routine being executed sees. What the value is not fit for is an error
    /// in words.
    pub fn set_variable(&mut self, task: usize, name: &str, value: Value) -> Result<(), String> {
        let sap = self.tasks[task].sap.as_mut().ok_or("the task has no rw_SymPas program")?;
        let routine = sap.routine();
        let named = |own: bool| {
            let mut all = sap.program.variables.iter();
            all.find(|v| v.name == name && if own { belongs(v, routine) } else { v.slot.is_global() })
        };
        let variable = named(true).or_else(|| named(false)).ok_or_else(|| format!("no variable '{name}' here"))?;
        let slot = variable.slot;
        let taken = slot_of(variable.kind, value).ok_or_else(|| format!("'{name}' does not take that value"))?;
        sap.put(slot, taken);
        Ok(())
    }
    /// An Integer operation of the task has wrapped to 32 bits since its start (errata Q3).
    pub fn has_overflowed(&self, task: usize) -> bool {
        self.tasks[task].sap.as_ref().is_some_and(|sap| sap.overflow)
    }
    /// Sets CLOCK, the ticks of 64 us that programs read.
    pub fn set_clock(&mut self, ticks: u32) {
        let start = &mut self.registers.sap.clock_start;
        *start = 0;
        let now = self.clock();
        self.registers.sap.clock_start = ticks.wrapping_sub(now);
    }
}

/// A variable of a routine's own.
fn belongs(variable: &Variable, routine: u16) -> bool {
    !variable.slot.is_global() && variable.routine == routine
}

fn value_of(variable: &Variable, slot: u64) -> Value {
    match variable.kind {
        VariableKind::Axis => Value::Axis(slot as i32),
        VariableKind::Value(Type::Boolean) => Value::Boolean(slot != 0),
        VariableKind::Value(Type::Integer) => Value::Integer(slot as i32),
        VariableKind::Value(Type::Timer) => Value::Timer(slot as u32),
        VariableKind::Value(Type::Single | Type::Double) => Value::Real(f64::from_bits(slot)),
    }
}

/// A value in the slot of a variable, as an assignment would convert it.
fn slot_of(kind: VariableKind, value: Value) -> Option<u64> {
    use VariableKind::{Axis, Value as Of};
    Some(match (kind, value) {
        (Of(Type::Boolean), Value::Boolean(on)) => program::boolean(on),
        (Of(Type::Integer) | Axis, Value::Integer(number)) => program::integer(number),
        (Of(Type::Timer), Value::Integer(number)) => program::timer(number as u32),
        (Of(Type::Timer), Value::Timer(ticks)) => program::timer(ticks),
        (Of(Type::Double), Value::Real(number)) => program::real(number),
        (Of(Type::Double), Value::Integer(number)) => program::real(f64::from(number)),
        (Of(Type::Single), Value::Real(number)) => program::real(f64::from(number as f32)),
        (Of(Type::Single), Value::Integer(number)) => program::real(f64::from(number as f32)),
        _ => return None,
    })
}
