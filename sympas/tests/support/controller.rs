//! Programs in a CNC task of the controller, observed as the second opinion is.

use std::collections::BTreeMap;
use std::sync::Arc;

use motion_kernel::Mcu;
use motion_kernel::machine::Machine;
use motion_kernel::sap::program::Program;
use motion_kernel::tasks::TaskState;

use super::evaluator::{End, Outcome};

/// Common variables that programs of tests write.
const VARIABLES: usize = 20;

/// Runs a program in task 0 for at most so many samples.
pub fn run(program: &Program, most: u64) -> Outcome {
    let mut mcu = Mcu::new(Arc::new(machine()));
    run_in(&mut mcu, program, most)
}

/// The built-in machine, with tasks that get through a program of the language core in a few samples.
pub fn machine() -> Machine {
    let mut machine = Machine::builtin();
    machine.controller.statements_per_sample = 500;
    machine
}

pub fn run_in(mcu: &mut Mcu, program: &Program, most: u64) -> Outcome {
    mcu.load_sap(0, Arc::new(program.clone())).expect("a program for a task");
    mcu.startcnct(0);
    let mut output = String::new();
    let mut left = most;
    while mcu.task_status(0).running & 1 == 1 && left > 0 {
        mcu.run(1);
        output += &mcu.take_output(0);
        left -= 1;
    }
    output += &mcu.take_output(0);
    let status = mcu.task_status(0);
    let end = match status.state {
        _ if status.errnum != 0 => End::Error(status.errnum, status.errline),
        TaskState::Idle => End::Finished,
        TaskState::Failed => End::Aborted,
        other if left > 0 => End::Beyond(format!("{other:?}")),
        _ => End::Endless,
    };
    // what was never written is 0, and so it is for the second opinion
    let all = 0..VARIABLES;
    let ci: BTreeMap<u32, i32> = all.clone().map(|n| (n as u32, mcu.ci(n))).filter(|(_, v)| *v != 0).collect();
    let cd: BTreeMap<u32, f64> = all.map(|n| (n as u32, mcu.cd(n))).filter(|(_, v)| *v != 0.0).collect();
    Outcome { end, output, ci, cd }
}

/// The outcome as the controller shows it: only variables that are not 0, and a number that is none equals itself.
pub fn shown(outcome: &Outcome) -> String {
    let mut outcome = outcome.clone();
    outcome.ci.retain(|n, v| *v != 0 && (*n as usize) < VARIABLES);
    outcome.cd.retain(|n, v| *v != 0.0 && (*n as usize) < VARIABLES);
    format!("{outcome:?}")
}
