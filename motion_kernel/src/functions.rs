//! Spool special functions (4.4.123): commands other than motion, executed in step with it.

use crate::autocode::HOST_EVENT_CI;
use crate::axes::AxisSet;
use crate::axis::{Doing, Wait};
use crate::mcu::{Mcu, WAIT_CI};
use crate::registers::ErrorReg;
use crate::spooler::{BYTES_FUNCTION, Entry, Function, NONE, SpoolState};
use crate::trace::EventKind;

/// Commands with a meaning of their own.
pub mod command {
    pub const HALT: u16 = 1000;
    pub const SET_OUTPUTS: u16 = 1001;
    pub const RESET_OUTPUTS: u16 = 1002;
    pub const PC_INTERRUPT: u16 = 1101;
    pub const WAIT_TIME: u16 = 1003;
    pub const WAIT_INPUTS: u16 = 1004;
    pub const WAIT_CI99: u16 = 1005;
    pub const WAIT_AXES: u16 = 1006;
    pub const ADD_WAIT_CI99: u16 = 1015;
    pub const WAIT_CI99_BIT: u16 = 1025;
    pub const STOP_LAST: u16 = 2001;
    pub const WAITS: [u16; 7] = [HALT, WAIT_TIME, WAIT_INPUTS, WAIT_CI99, WAIT_AXES, ADD_WAIT_CI99, WAIT_CI99_BIT];
}

/// What became of a command given to the spooler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entered {
    Yes,
    /// Discarded; the reason stands in ErrorReg.
    Discarded,
    /// An axis is in open loop (design D11): no motion, axst dhef.
    Refused,
    /// The spooler is full (ErrorReg bit 4).
    Full,
}

/// Integer targets: truncated towards zero to 32 bits; NaN counts as 0 (errata, 4.4.123).
pub fn to_int(value: f64) -> i32 {
    value as i64 as i32
}
/// Bit masks are unsigned 32 bits.
pub fn to_mask(value: f64) -> u32 {
    value as i64 as u32
}

impl Mcu {
    /// Enters a function into the spooler of one axis.
    ///
    /// A wait behind a motion that does not end with target velocity 0 is refused (ErrorReg bit 10).
    pub fn ssf(&mut self, axis: usize, number: u16, value: f64, line: u32) -> Entered {
        self.ssf_as(axis, Function { command: number, value, line, pcap_index: None })
    }
    /// As [`Mcu::ssf`]; the axis shows `pcap_index` from its execution on ([`Mcu::rdPcapIndex`]). ssfni is the same.
    pub fn ssfi(&mut self, axis: usize, number: u16, value: f64, pcap_index: i32) -> Entered {
        self.ssf_as(axis, Function { command: number, value, line: 0, pcap_index: Some(pcap_index) })
    }

    fn ssf_as(&mut self, axis: usize, function: Function) -> Entered {
        let number = function.command;
        if axis >= self.axes.len() {
            self.raise(ErrorReg::errAxDef);
            return Entered::Discarded;
        }
        if !self.loops[axis].closed {
            self.refuse(AxisSet::single(axis));
            return Entered::Refused;
        }
        if number == command::STOP_LAST {
            self.stop_last(axis);
            return Entered::Yes;
        }
        if command::WAITS.contains(&number) && self.queued_velocity(axis) != 0.0 {
            self.raise(ErrorReg::SsfWaitRefused);
            return Entered::Discarded;
        }
        if !is_known(number) {
            self.monitor_message();
            return Entered::Discarded;
        }
        if self.axes[axis].spooler.left() < BYTES_FUNCTION {
            self.raise(ErrorReg::errSpoolerOverrun);
            return Entered::Full;
        }
        self.axes[axis].spooler.push(Entry::Function(function));
        self.tell_function();
        Entered::Yes
    }

    /// Target velocity of the motion before a new entry.
    fn queued_velocity(&self, axis: usize) -> f64 {
        let axis = &self.axes[axis];
        if axis.is_drained() { axis.run_on_v } else { axis.queue_tvl }
    }

    /// 2001: target velocity 0 for the last spooled motion.
    fn stop_last(&mut self, axis: usize) {
        let slot = self.axes[axis].queue_last;
        self.axes[axis].queue_tvl = 0.0;
        if slot == NONE || !self.axes[axis].holds(slot) {
            return;
        }
        (self.moves[slot].tvl, self.moves[slot].passes) = (0.0, false);
        if self.moves[slot].planned {
            self.brake_to_end(slot);
        } else {
            self.lookahead.refresh(&self.moves, slot);
        }
    }

    /// Executes a function of the spooler.
    pub(crate) fn execute(&mut self, a: usize, function: Function) {
        let value = function.value;
        match function.command {
            n @ 0..=999 => self.write_ci(a, n, to_int(value), function.line),
            n @ 10000..=10999 => {
                let bits = self.ci[usize::from(n) - 10000] as u32 | to_mask(value);
                self.write_ci(a, n - 10000, bits as i32, function.line);
            }
            n @ 11000..=11999 => {
                let bits = self.ci[usize::from(n) - 11000] as u32 & !to_mask(value);
                self.write_ci(a, n - 11000, bits as i32, function.line);
            }
            n @ 1200..=1207 => {
                if let Some(position_loop) = self.loops.get_mut(usize::from(n) - 1200) {
                    position_loop.set_mcp(to_int(value));
                }
            }
            n @ 20000..=20999 => self.cd[usize::from(n) - 20000] = value,
            command::PC_INTERRUPT => self.card.set_irqpc(true),
            command::SET_OUTPUTS => {
                self.write_outputs(a as i32, self.io.digo | to_mask(value), function.line);
            }
            command::RESET_OUTPUTS => {
                self.write_outputs(a as i32, self.io.digo & !to_mask(value), function.line);
            }
            _ => self.begin_wait(a, function),
        }
    }

    fn begin_wait(&mut self, a: usize, function: Function) {
        let wait = match function.command {
            command::HALT => {
                self.axes[a].spooler.state = SpoolState::Halted;
                None
            }
            command::WAIT_TIME => Some(Wait::Samples(self.samples_of(function.value))),
            command::WAIT_INPUTS => Some(Wait::Inputs(to_mask(function.value))),
            command::WAIT_AXES => Some(Wait::Axes(to_mask(function.value))),
            command::WAIT_CI99 => {
                self.ci[WAIT_CI] = to_int(function.value);
                Some(Wait::Ci99)
            }
            command::ADD_WAIT_CI99 => {
                self.ci[WAIT_CI] = self.ci[WAIT_CI].wrapping_add(to_int(function.value));
                Some(Wait::Ci99)
            }
            _ => {
                self.ci[WAIT_CI] |= 1 << a;
                Some(Wait::Ci99Bit)
            }
        };
        let axis = &mut self.axes[a];
        axis.function = Some(function);
        axis.short_moves = 0;
        (axis.run_on_v, axis.path_v) = (0.0, 0.0);
        if let Some(wait) = wait {
            axis.doing = Doing::Wait(wait);
        }
        self.waiting = true;
        if self.leader == a {
            self.event(EventKind::Wait, a as i32, "wait", true, function.line, i64::from(function.command));
        }
    }

    /// Units of 64 us, rounded down to whole samples.
    fn samples_of(&self, ticks: f64) -> u64 {
        (ticks.max(0.0) as u64) / u64::from(self.machine.controller.sample_ticks)
    }

    fn write_ci(&mut self, a: usize, number: u16, value: i32, line: u32) {
        self.ci[usize::from(number)] = value;
        if number == HOST_EVENT_CI && value > 0 {
            self.event(EventKind::Host, a as i32, "host", true, line, i64::from(value) - 1);
        }
    }
}

fn is_known(number: u16) -> bool {
    let range = matches!(number, 0..=1002 | 1101 | 1200..=1207 | 10000..=11999 | 20000..=20999);
    range || command::WAITS.contains(&number)
}
