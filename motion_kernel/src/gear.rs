//! Gear factor and resolution at run time (4.4.66, 4.4.145, 4.4.102, 4.4.171).
//!
//! gf is the distance in axis units that the axis travels in a motor revolution, slsp the counts (steps) of one: both
//! together convert axis units to counts. The motor stays where it is, so every position of the axis gets another
//! number of units, also those that a running or spooled command still has to reach: that motion is the same one in
//! counts. Velocities, accelerations and limits keep their numbers, so the application has to adapt them.
#![allow(non_snake_case)] // the manual's own names

use crate::axis::Axis;
use crate::mcu::Mcu;
use crate::path::Component;

impl Mcu {
    /// Gear factor: axis units per motor revolution.
    pub fn rdgf(&self, axis: usize) -> f64 {
        let parameters = &self.axes[axis].parameters;
        parameters.slsp / parameters.counts_per_unit
    }
    /// Sets it; only values above 0.
    pub fn wrgf(&mut self, axis: usize, gf: f64) -> bool {
        let slsp = self.axes[axis].parameters.slsp;
        is_positive(gf) && self.set_counts_per_unit(axis, slsp / gf)
    }
    /// Sets the counts or steps per motor revolution; only values above 0. The gear factor stays.
    pub fn wrslsp(&mut self, axis: usize, slsp: f64) -> bool {
        let done = is_positive(slsp) && self.set_counts_per_unit(axis, slsp / self.rdgf(axis));
        if done {
            self.axes[axis].parameters.slsp = slsp;
        }
        done
    }

    fn set_counts_per_unit(&mut self, a: usize, counts_per_unit: f64) -> bool {
        let ratio = self.axes[a].parameters.counts_per_unit / counts_per_unit;
        let ok = is_positive(ratio) && is_positive(counts_per_unit);
        if ok {
            self.loops[a].convert(counts_per_unit, ratio);
            self.axes[a].convert(counts_per_unit, ratio);
            self.signals[a].backlash.convert(ratio);
            let resources = &mut self.resources.axes[a];
            (resources.led, resources.followed) = (resources.led * ratio, resources.followed * ratio);
        }
        ok
    }
}

fn is_positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

impl Axis {
    /// A position of `x` units has `x * ratio` units from now on.
    fn convert(&mut self, counts_per_unit: f64, ratio: f64) {
        self.parameters.counts_per_unit = counts_per_unit;
        let lengths = [
            &mut self.dp,
            &mut self.dv,
            &mut self.run_on_v,
            &mut self.queue_end,
            &mut self.points_base,
            &mut self.zero,
            &mut self.parameters.dpoffset,
        ];
        lengths.into_iter().for_each(|x| *x *= ratio);
        self.limiting.left = self.limiting.left.map(|x| x * ratio);
        self.limiting.right = self.limiting.right.map(|x| x * ratio);
        self.component.convert(ratio);
        self.spooler.convert(ratio);
    }
}

impl Component {
    pub(crate) fn convert(&mut self, ratio: f64) {
        [&mut self.base, &mut self.p, &mut self.q, &mut self.target].into_iter().for_each(|x| *x *= ratio);
    }
}
