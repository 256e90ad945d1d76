//! Home searches (4.4.20 to 4.4.22) and the home position (shp, 4.4.116). A search is a jog with hvl and hac that is
//! braked with hac as its signal comes.
#![allow(non_snake_case)] // the manual's own names

use crate::axes::{AxisList, AxisSet, MAX_AXES};
use crate::axis::{Axis, Doing};
use crate::functions::Entered;
use crate::mcu::Mcu;
use crate::path::Component;
use crate::profile::{Profile, Request};
use crate::registers::Axst;
use crate::spooler::Entry;

/// What a home search looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// The index of the encoder.
    Index,
    /// An input with function REF.
    Reference,
}

impl Mcu {
    /// Searches the encoder index over at most these distances (jhi); their signs are the directions.
    pub fn jhi(&mut self, axes: &AxisList, distances: &[f64]) -> Entered {
        self.search(axes, distances, Search::Index)
    }
    /// Searches the reference switch to the left, endlessly (jhl).
    pub fn jhl(&mut self, axes: &AxisList) -> Entered {
        self.search(axes, &[-1.0; MAX_AXES][..axes.len()], Search::Reference)
    }
    /// Searches the reference switch to the right, endlessly (jhr).
    pub fn jhr(&mut self, axes: &AxisList) -> Entered {
        self.search(axes, &[1.0; MAX_AXES][..axes.len()], Search::Reference)
    }

    /// The search takes effect: a trapezoidal profile with hvl and hac from the present velocity.
    pub(crate) fn begin_search(&mut self, a: usize, way: f64, search: Search) {
        if !self.loops[a].closed {
            return;
        }
        let v = self.axes[a].velocity();
        self.enter_direct_mode(a);
        let axis = &mut self.axes[a];
        let direction = if way < 0.0 { -1.0 } else { 1.0 };
        let start_v = v * direction / axis.jog_override();
        let (max_v, acc) = (axis.parameters.hvl, axis.parameters.hac);
        axis.alone = match search {
            Search::Reference => Profile::endless(start_v, max_v, acc, acc, 0.0),
            Search::Index => {
                let to = way.abs();
                Profile::direct(&Request { from: 0.0, to, start_v, max_v, acc, target_v: 0.0, jerkrel: 0.0 }, acc, true)
            }
        };
        axis.component = Component { base: axis.dp, p: direction, target: axis.dp + way, ..Component::default() };
        (axis.doing, axis.t, axis.jogging, axis.queue_end) = (Doing::Alone, 0.0, true, axis.dp + way);
        self.signals[a].search = Some(search);
        self.signals[a].index_edge = false;
        self.attend_to(|attention| attention.homing = attention.homing.with(a));
    }

    /// Brakes with hac as the signal comes; whatever else ended the search, it is over.
    pub(crate) fn watch_search(&mut self, a: usize) {
        let axis = &self.axes[a];
        let runs = axis.doing == Doing::Alone && axis.jogging;
        let found = match self.signals[a].search {
            Some(Search::Index) => self.signals[a].index_edge,
            Some(Search::Reference) => self.axis_inputs.get(a).is_some_and(|inputs| self.digi & inputs.reference != 0),
            None => true,
        };
        if runs && !found {
            return;
        }
        if runs {
            self.brake_alone(a, self.axes[a].parameters.hac, 0.0);
        }
        self.signals[a].search = None;
        self.attend_to(|attention| attention.homing = attention.homing.without(AxisSet::single(a)));
    }

    /// An axis leaves what it executes and brakes on its own.
    pub(crate) fn brake_alone(&mut self, a: usize, brake_acc: f64, jerkrel: f64) {
        let v = self.axes[a].velocity();
        self.enter_direct_mode(a);
        let axis = &mut self.axes[a];
        if v == 0.0 {
            return;
        }
        (axis.alone, _) = Profile::stopping(0.0, f64::INFINITY, v.abs(), brake_acc, 0.0, jerkrel);
        (axis.component.base, axis.component.p) = (axis.dp, v.signum());
        (axis.doing, axis.t, axis.jogging, axis.dv) = (Doing::Alone, 0.0, false, v);
    }

    /// The actual position gets the coordinate `tp` (axis units): home position, the axis is referenced and its software
    /// limits are watched. In open and closed loop; set point, offsets and compensation shift with it, nothing moves.
    pub fn shp(&mut self, axis: usize, tp: f64) -> bool {
        if !tp.is_finite() {
            return false;
        }
        self.shift_coordinates(axis, self.loops[axis].counts_to(tp));
        if !self.loops[axis].closed {
            self.axes[axis].dp = self.loops[axis].rp();
            self.axes[axis].forget_queue();
        }
        self.axes[axis].evlss = None;
        self.set_status(axis, Axst::referenced, true);
        true
    }

    /// Every position of an axis gets a coordinate `counts` whole counts higher: encoder, set point, what it executes
    /// and what is queued. Software limits keep their numbers.
    pub(crate) fn shift_coordinates(&mut self, a: usize, counts: i64) {
        self.loops[a].shift_counts(counts);
        let by = counts as f64 / self.axes[a].parameters.counts_per_unit;
        self.axes[a].shift_positions(by);
        self.signals[a].backlash.shift(by);
        self.shift_leading(a, by);
    }

    /// Home acceleration hac (4.4.68), of all home commands.
    pub fn rdhac(&self, axis: usize) -> f64 {
        self.axes[axis].parameters.hac
    }
    /// Sets it (4.4.147), above 0.
    pub fn wrhac(&mut self, axis: usize, hac: f64) -> bool {
        let ok = hac > 0.0 && hac.is_finite();
        if ok {
            self.axes[axis].parameters.hac = hac;
        }
        ok
    }
    /// Home velocity hvl (4.4.69), of all home commands.
    pub fn rdhvl(&self, axis: usize) -> f64 {
        self.axes[axis].parameters.hvl
    }
    /// Sets it (4.4.148), above 0.
    pub fn wrhvl(&mut self, axis: usize, hvl: f64) -> bool {
        let ok = hvl > 0.0 && hvl.is_finite();
        if ok {
            self.axes[axis].parameters.hvl = hvl;
        }
        ok
    }
}

impl Axis {
    fn shift_positions(&mut self, by: f64) {
        let component = &mut self.component;
        for position in [&mut self.dp, &mut self.queue_end, &mut component.base, &mut component.target] {
            *position += by;
        }
        for index in 0..self.spooler.len() {
            if let Some(Entry::Move { component, .. }) = self.spooler.entry_mut(index) {
                component.base += by;
                component.target += by;
            }
        }
        for bound in [&mut self.limiting.left, &mut self.limiting.right].into_iter().flatten() {
            *bound += by;
        }
    }
}
