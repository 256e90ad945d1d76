//! A task that executes a rw_SymPas program: what the processor says becomes the state of the task.

use super::vm::{RuntimeError, Task, TaskState};
use crate::mcu::Mcu;
use crate::sap::processor::{Pause, Processor};
use crate::sap::program::Program;
use std::sync::Arc;

impl Task {
    /// Loads a verified program; a running one is stopped.
    pub(crate) fn load_sap(&mut self, program: Arc<Program>, number: usize) {
        *self = Task::default();
        (self.sap, self.output) = (Some(Box::new(Processor::new(program, number))), super::Output::reserved());
    }

    /// From the stopped to the single-step state, without executing a line (stoptoss). True where it was stopped.
    pub(super) fn stop_to_step(&mut self) -> bool {
        let stopped = self.state == TaskState::Stopped;
        if stopped {
            self.state = TaskState::Stepped;
        }
        stopped
    }

    /// enev lasts while the task runs.
    pub(super) fn disable_events(&mut self) {
        if let Some(sap) = &mut self.sap {
            sap.enabled = 0;
        }
    }

    /// The share of one sample.
    pub(super) fn run_sap(&mut self, mcu: &mut Mcu) {
        let share = mcu.machine.controller.statements_per_sample.max(1);
        let Some(sap) = &mut self.sap else { return };
        mcu.commanding = sap.number as u8;
        let pause = sap.run(mcu, &mut self.output, share);
        self.waiting = pause == Pause::Waiting;
        self.rests = pause == Pause::Writeln;
        self.state = match pause {
            Pause::Share | Pause::Waiting => TaskState::Running,
            Pause::End => TaskState::Idle,
            Pause::Stop => TaskState::Stopped,
            Pause::Abort | Pause::Error(_) => TaskState::Failed,
            Pause::Line => TaskState::Stepped,
            Pause::Writeln => TaskState::Stopped,
            Pause::Restart => {
                sap.restart();
                TaskState::Running
            }
        };
        if let Pause::Error(number) = pause {
            self.error = Some(RuntimeError { number, line: sap.executed_line() });
        }
        if !self.rests && matches!(self.state, TaskState::Idle | TaskState::Stopped | TaskState::Failed) {
            self.disable_events();
        }
    }
}
