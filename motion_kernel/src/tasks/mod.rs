//! The four CNC tasks (chapter 3.2.1): the virtual machine that executes autocode.

mod output;
mod vm;

pub use output::{Output, STRING};
pub use vm::{Task, TaskState, TaskStatus, runtime_error};

use crate::mcu::{Mcu, TASKS};
use crate::trace::EventKind;

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
            let mut task = std::mem::take(&mut self.tasks[number]);
            task.run(self);
            if let Some(error) = task.new_error() {
                self.told.task_error = true;
                self.event(EventKind::Task, number as i32, "error", true, error.line, i64::from(error.number));
            }
            self.tasks[number] = task;
        }
    }
}
