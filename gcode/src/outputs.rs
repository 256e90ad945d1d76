//! Digital outputs: what a block sets and resets, the spindle directions, M functions of the machine file.

use crate::mfunc::spool;
use crate::translate::Translator;

/// Outputs to be set and reset by one block: one entry each, reset first.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outputs {
    pub(crate) set: u32,
    pub(crate) reset: u32,
}

impl Outputs {
    pub(crate) fn put(&mut self, set: u32, reset: u32) {
        self.set = self.set & !reset | set;
        self.reset = self.reset & !set | reset;
    }
    /// One direction of the spindle instead of the other; a line that both have does not drop in between.
    pub(crate) fn turn(&mut self, on: u32, off: u32) {
        self.put(on, off & !on);
    }
}

impl Translator<'_> {
    pub(crate) fn put_out(&mut self, outputs: Outputs) {
        for (mask, command) in [(outputs.reset, spool::RESET_OUTPUTS), (outputs.set, spool::SET_OUTPUTS)] {
            if mask != 0 {
                self.sink.ssf(self.line, self.first(), command, f64::from(mask), false);
            }
        }
    }
    pub(crate) fn is_user_function(&self, m: u16) -> bool {
        self.machine.gcode.m_functions.iter().any(|f| f.number == u32::from(m))
    }
    /// An M function of the machine file: its outputs with those of the block; a common integer and a wait for
    /// inputs come after them.
    pub(crate) fn user_function(&mut self, m: u16, outputs: &mut Outputs) {
        let machine = self.machine;
        for function in machine.gcode.m_functions.iter().filter(|f| f.number == u32::from(m)) {
            outputs.put(function.set, function.reset);
            if let Some((ci, value)) = function.ci {
                self.sink.ssf(self.line, self.first(), ci as u16, f64::from(value), false);
            }
            if function.wait != 0 {
                self.put_out(std::mem::take(outputs));
                self.wait(spool::WAIT_INPUTS, f64::from(function.wait));
            }
        }
    }
    /// M10, M11: the output, and the input that shows it has happened.
    pub(crate) fn clamp(&mut self, (set, reset): (u32, u32), wait: u32, outputs: &mut Outputs) {
        outputs.put(set, reset);
        if wait != 0 {
            self.put_out(std::mem::take(outputs));
            self.wait(spool::WAIT_INPUTS, f64::from(wait));
        }
    }
}
