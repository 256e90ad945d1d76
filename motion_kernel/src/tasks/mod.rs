//! The four CNC tasks (chapter 3.2.1): the virtual machine that executes autocode.

mod debug;
mod output;
mod sap_task;
mod segments;
mod vm;

pub use debug::Value;
pub use output::{Output, STRING};
pub use segments::Segments;
pub use vm::{Task, TaskState, TaskStatus, runtime_error};

use crate::mcu::{Mcu, TASKS};
use crate::sap;
use crate::trace::EventKind;
use std::sync::Arc;

impl Mcu {
    /// Starts the program of a task from its beginning (startcnct); a running one is stopped before.
    /// Where no other task is at work, motion commands are numbered from 1 again.
    pub fn startcnct(&mut self, task: usize) {
        if !self.tasks.iter().enumerate().any(|(n, t)| n != task && t.is_alive()) {
            self.commands = 0;
        }
        self.tasks[task].start();
    }
    /// Stops a task where it is (stopcnct); [`Mcu::contcnct`] goes on.
    pub fn stopcnct(&mut self, task: usize) {
        self.tasks[task].stop();
    }
    /// Continues a stopped task, or one in single-step mode (contcnct).
    pub fn contcnct(&mut self, task: usize) {
        self.tasks[task].resume();
    }
    /// Executes one source line of a task, then waits (stepcnct). What the line spooled is started and runs dry.
    pub fn stepcnct(&mut self, task: usize) {
        self.tasks[task].step();
    }
    /// Brings a stopped task into single-step mode without executing a line (SAP stoptoss). What it spooled since its
    /// start begins to run.
    pub fn stoptoss(&mut self, task: usize) {
        if self.tasks[task].stop_to_step() {
            let spooled = self.tasks[task].sap.as_ref().map(|sap| sap.spooled);
            let program = self.tasks[task].program().map(|program| program.group);
            self.start_direct(spooled.or(program).unwrap_or_default());
        }
    }
    /// Loads a rw_SymPas program into a task (0..3); it runs after [`Mcu::startcnct`]. A running one is stopped.
    pub fn load_sap(&mut self, task: usize, program: Arc<sap::program::Program>) -> Result<(), sap::verify::Refusal> {
        sap::verify::verify(&program)?;
        if usize::from(program.axes) > self.axes.len() {
            return Err(sap::verify::Refusal { address: None, reason: "compiled for more axes than the machine has" });
        }
        (self.group, self.leader) = (self.all_axes(), 0);
        self.tasks[task].load_sap(program, task);
        Ok(())
    }
    /// State of a task (rdcncts).
    pub fn task_status(&self, task: usize) -> TaskStatus {
        self.tasks[task].status()
    }
    /// What the tasks wrote with write and writeln since the last call.
    pub fn take_output(&mut self, task: usize) -> String {
        self.tasks[task].output.take_all()
    }
    /// State of the output string of a task (gettskinfo, 4.4.13): bit 0 unfinished, bit 1 finished.
    pub fn gettskinfo(&self, task: usize) -> u32 {
        self.tasks[task].output.info()
    }
    /// The output string of a task (gettskstr, 4.4.14), at most 512 bytes. Reading it clears both bits of tskinfo.
    pub fn gettskstr(&mut self, task: usize) -> String {
        self.tasks[task].output.take_string()
    }

    /// All tasks, in equal shares (design D4).
    pub(crate) fn run_tasks(&mut self) {
        for number in 0..TASKS {
            if !self.tasks[number].is_active() {
                continue;
            }
            let stand_in = self.stand_in.take().unwrap_or_default();
            let mut task = std::mem::replace(&mut self.tasks[number], stand_in);
            task.run(self);
            if let Some(error) = task.new_error() {
                self.told.task_error = true;
                self.event(EventKind::Task, number as i32, "error", true, error.line, i64::from(error.number));
            }
            self.stand_in = Some(std::mem::replace(&mut self.tasks[number], task));
        }
    }
}
