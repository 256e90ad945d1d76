//! The electronic gear (chapter 5): slaves follow the set points (gcr 1) or the actual positions (gcr 2) of masters.
//!
//! The factor stands in the controller parameters of the slave, column 0, line = master. Following is added to the set
//! point of the slave's loop like dpoffset, so dp and profiles of the slave know nothing of it, and the following error
//! does not contain it (errata R14).

use super::Options;
use crate::axes::AxisSet;
use crate::mcu::Mcu;
use crate::port::Special;

/// Values of gcr.
const SET_POINT: i32 = 1;
const ACTUAL: i32 = 2;
const CLEAR: i32 = -1;
/// Columns of the controller parameters.
const COLUMNS: usize = 15;

impl Mcu {
    /// Gear configuration register of an axis (4.4.65).
    pub fn rdGCR(&self, axis: usize) -> i32 {
        self.card.axes[axis].gcr
    }
    /// Writes it. False, and nothing changes: 1 while the loop of the axis is open, -1 while any axis has a gcr that is
    /// not 0. -1 clears what all slaves have followed and reads as 0.
    pub fn wrGCR(&mut self, axis: usize, gcr: i32) -> bool {
        if !self.resources.options.has(Options::GEAR) {
            self.card.axes[axis].gcr = gcr;
            return true;
        }
        if gcr == CLEAR {
            return self.clear_following();
        }
        if gcr == SET_POINT && !self.loops[axis].closed {
            return false;
        }
        self.card.axes[axis].gcr = gcr;
        self.meet_master(axis);
        let follows = matches!(gcr, SET_POINT | ACTUAL);
        self.attend_to(|attention| {
            let others = attention.masters.without(AxisSet::single(axis));
            attention.masters = if follows { others.union(AxisSet::single(axis)) } else { others };
        });
        for slave in 0..self.axes.len() {
            let follows = self.attention.masters.iter().any(|m| self.gear_factor(slave, m) != 0.0);
            self.loops[slave].set_special(|special| (special.follows, special.led_v) = (follows, 0.0));
        }
        true
    }
    /// Following of the set point ends as the loop of the master is opened.
    pub(crate) fn release_gear(&mut self, axis: usize) {
        if self.card.axes[axis].gcr == SET_POINT {
            self.wrGCR(axis, 0);
        }
    }
    fn clear_following(&mut self) -> bool {
        let idle = self.card.axes.iter().all(|axis| axis.gcr == 0);
        if idle {
            for a in 0..self.axes.len() {
                self.loops[a].offset -= std::mem::take(&mut self.resources.axes[a].followed);
            }
        }
        idle
    }
    fn gear_factor(&self, slave: usize, master: usize) -> f64 {
        if slave == master || master >= COLUMNS { 0.0 } else { self.card.axes[slave].parameters[master * COLUMNS] }
    }
    fn leading_position(&self, master: usize) -> f64 {
        if self.card.axes[master].gcr == ACTUAL { self.loops[master].rp() } else { self.axes[master].set_point() }
    }
    /// In every sample with a gear, before the loops close it.
    #[cold]
    pub(crate) fn follow_masters(&mut self) {
        for a in 0..self.axes.len() {
            self.loops[a].special.led_v = 0.0;
        }
        for master in self.attention.masters.iter() {
            let now = self.leading_position(master);
            let travel = now - std::mem::replace(&mut self.resources.axes[master].led, now);
            for slave in 0..self.axes.len() {
                let way = travel * self.gear_factor(slave, master);
                if way != 0.0 {
                    self.resources.axes[slave].followed += way;
                    self.loops[slave].offset += way;
                    self.loops[slave].special.led_v += way / self.ta;
                }
            }
        }
    }
    /// From where the master stands now on.
    pub(crate) fn meet_master(&mut self, axis: usize) {
        self.resources.axes[axis].led = self.leading_position(axis);
    }
    /// A master gets other coordinates: nothing moves.
    pub(crate) fn shift_leading(&mut self, axis: usize, by: f64) {
        self.resources.axes[axis].led += by;
    }
}

impl Special {
    /// Velocity of the set point with what a gear adds.
    pub(crate) fn with_gear(&self, dv: f64) -> f64 {
        dv + self.led_v
    }
}
