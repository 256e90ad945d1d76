//! Looking into a task that executes a rw_SymPas program: breakpoints, steps over calls, variables by name. The board
//! has nothing of this; it changes nothing of what a program does.

use crate::mcu::Mcu;
use crate::sap::program::{Variable, VariableKind};
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

impl Mcu {
    /// The task stops before statements on these source lines, in single-step mode (`stepcnct`, `contcnct` go on).
    /// Without a rw_SymPas program there is nothing to stop: false.
    pub fn break_at(&mut self, task: usize, lines: Vec<u32>) -> bool {
        let Some(sap) = &mut self.tasks[task].sap else { return false };
        sap.stepping.breaks = lines;
        true
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
    /// Variables of the main program, then those of the routine being executed, with their values.
    pub fn variables(&self, task: usize) -> Vec<(&Variable, Value)> {
        let Some(sap) = &self.tasks[task].sap else { return Vec::new() };
        let seen = |v: &&Variable| v.slot.is_global() || v.routine == sap.routine();
        let value = |v: &Variable| {
            let slot = sap.get(v.slot);
            match v.kind {
                VariableKind::Axis => Value::Axis(slot as i32),
                VariableKind::Value(Type::Boolean) => Value::Boolean(slot != 0),
                VariableKind::Value(Type::Integer) => Value::Integer(slot as i32),
                VariableKind::Value(Type::Timer) => Value::Timer(slot as u32),
                VariableKind::Value(Type::Single | Type::Double) => Value::Real(f64::from_bits(slot)),
            }
        };
        sap.program.variables.iter().filter(seen).map(|v| (v, value(v))).collect()
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
