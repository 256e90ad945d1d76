//! What is added to the set point of the position loop: dpoffset with its rate dvoffset (4.4.141, 4.4.142), and the
//! compensation of play in the gear (resource devices 27, 30, 40).

use crate::axes::AxisSet;
use crate::machine;
use crate::mcu::Mcu;
use crate::plant::whole;

/// Backlash compensation of one axis. To the right nothing is added; to the left the motor is sent `value` further.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Backlash {
    value: f64,
    hysteresis: f64,
    leftward: bool,
    /// The set point farthest in the present direction.
    turning: f64,
}

impl Backlash {
    pub fn of(axis: &machine::Axis) -> Self {
        let equipment = &axis.equipment;
        Backlash {
            value: equipment.backlash_compensation,
            hysteresis: equipment.backlash_hysteresis,
            leftward: false,
            turning: axis.start,
        }
    }
    pub fn is_used(&self) -> bool {
        self.value != 0.0
    }
    pub(crate) fn shift(&mut self, by: f64) {
        self.turning += by;
    }
    /// A position of `x` units has `x * ratio` units from now on (gear.rs).
    pub(crate) fn convert(&mut self, ratio: f64) {
        [&mut self.value, &mut self.hysteresis, &mut self.turning].into_iter().for_each(|x| *x *= ratio);
    }
    /// True if the direction of travel changed.
    fn turns(&mut self, dp: f64) -> bool {
        let ahead = if self.leftward { self.turning - dp } else { dp - self.turning };
        if ahead > 0.0 {
            self.turning = dp;
        } else if -ahead > self.hysteresis {
            (self.leftward, self.turning) = (!self.leftward, dp);
            return true;
        }
        false
    }
}

impl Mcu {
    /// Offset of the set point of the position loop, axis units (4.4.57), as written: it may still be on its way.
    pub fn rddpoffset(&self, axis: usize) -> f64 {
        self.axes[axis].parameters.dpoffset
    }
    /// Sets it (4.4.141): a step of the axis, or with dvoffset a ramp. dp stays what the profile generator says.
    pub fn wrdpoffset(&mut self, axis: usize, offset: f64) -> bool {
        if !offset.is_finite() {
            return false;
        }
        self.axes[axis].parameters.dpoffset = offset;
        if self.axes[axis].parameters.dvoffset == 0.0 {
            self.set_effective_offset(axis, offset);
        }
        let moves = self.effective_offset(axis) != offset;
        let one = AxisSet::single(axis);
        self.attend_to(|attention| {
            let others = attention.offsets.without(one);
            attention.offsets = if moves { others.union(one) } else { others };
        });
        true
    }
    /// dpoffset as far as it is in effect: without what a gear adds.
    fn effective_offset(&self, axis: usize) -> f64 {
        let followed = self.resources.axes[axis].followed;
        if followed == 0.0 { self.loops[axis].offset } else { self.loops[axis].offset - followed }
    }
    fn set_effective_offset(&mut self, axis: usize, offset: f64) {
        self.loops[axis].offset = offset + self.resources.axes[axis].followed;
    }
    /// Rate at which dpoffset takes effect, axis units/s (4.4.60); 0 = at once.
    pub fn rddvoffset(&self, axis: usize) -> f64 {
        self.axes[axis].parameters.dvoffset
    }
    /// Sets it (4.4.142), not below 0.
    pub fn wrdvoffset(&mut self, axis: usize, rate: f64) -> bool {
        let ok = rate >= 0.0 && rate.is_finite();
        if ok {
            self.axes[axis].parameters.dvoffset = rate;
        }
        ok
    }
    /// One sample of the way to dpoffset.
    pub(crate) fn ramp_offset(&mut self, a: usize) {
        let (goal, rate) = (self.axes[a].parameters.dpoffset, self.axes[a].parameters.dvoffset);
        let left = goal - self.effective_offset(a);
        let step = if rate == 0.0 { f64::INFINITY } else { rate * self.ta };
        if left.abs() > step {
            self.loops[a].offset += step.copysign(left);
            return;
        }
        self.set_effective_offset(a, goal);
        self.attend_to(|attention| attention.offsets = attention.offsets.without(AxisSet::single(a)));
    }

    /// Backlash compensation of an axis, axis units (resource device 27).
    pub fn rdbacklash(&self, axis: usize) -> f64 {
        self.signals[axis].backlash.value
    }
    /// Sets it; what is in effect changes with it.
    pub fn wrbacklash(&mut self, axis: usize, value: f64) -> bool {
        if !value.is_finite() {
            return false;
        }
        let dp = self.axes[axis].dp;
        let backlash = &mut self.signals[axis].backlash;
        (backlash.value, backlash.turning) = (value, dp);
        self.apply_compensation(axis);
        let (used, one) = (self.signals[axis].backlash.is_used(), AxisSet::single(axis));
        self.attend_to(|attention| {
            let others = attention.backlash.without(one);
            attention.backlash = if used { others.union(one) } else { others };
        });
        true
    }
    /// Way back before a reversal counts, axis units (resource device 40).
    pub fn rdbacklash_hysteresis(&self, axis: usize) -> f64 {
        self.signals[axis].backlash.hysteresis
    }
    /// Sets it, not below 0.
    pub fn wrbacklash_hysteresis(&mut self, axis: usize, hysteresis: f64) -> bool {
        let ok = hysteresis >= 0.0 && hysteresis.is_finite();
        if ok {
            self.signals[axis].backlash.hysteresis = hysteresis;
        }
        ok
    }
    /// Compensation in effect, axis units (resource device 30): negative to the left.
    pub fn rdactual_backlash(&self, axis: usize) -> f64 {
        self.loops[axis].compensation() as f64 / self.axes[axis].parameters.counts_per_unit
    }
    pub(crate) fn compensate_backlash(&mut self, a: usize) {
        if self.loops[a].closed && self.signals[a].backlash.turns(self.axes[a].dp) {
            self.apply_compensation(a);
        }
    }
    fn apply_compensation(&mut self, a: usize) {
        let Backlash { value, leftward, .. } = self.signals[a].backlash;
        let counts = if leftward { -whole(value * self.axes[a].parameters.counts_per_unit) } else { 0 };
        self.loops[a].set_compensation(counts);
    }
}
