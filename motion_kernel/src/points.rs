//! Set points from the spooler, one for each sample interval (spd, spda, spdr: 4.4.117 to 4.4.119), and the passage
//! from a trajectory into them (sstvl, 4.4.122).
//!
//! Positions are in axis units. The first one is taken over in the sample in which what stood before ends; an override
//! does not act on them. A command that follows starts with the velocity of the last step; without one the axis stands.

use crate::axes::AxisSet;
use crate::axis::{Axis, Doing};
use crate::cause::Cause;
use crate::functions::Entered;
use crate::mcu::Mcu;
use crate::profile::{Profile, Request};
use crate::registers::{ErrorReg, ModeReg};
use crate::spooler::{BYTES_POINT, BYTES_POINTS, Entry, NONE, Points, SpoolState};

/// Points that a block may have.
const MOST_POINTS: usize = 1000;

impl Mcu {
    /// Spools set points of an axis, 1 to 1000, one for each sample.
    pub fn spd(&mut self, axis: usize, positions: &[f64]) -> Entered {
        self.spool_points(axis, positions, false, None)
    }
    /// As [`Mcu::spd`]; `pcap_index` is shown at the first point and counts on with each (4.4.118).
    pub fn spda(&mut self, axis: usize, positions: &[f64], pcap_index: i32) -> Entered {
        self.spool_points(axis, positions, false, Some(pcap_index))
    }
    /// As [`Mcu::spda`], by distances from where the axis stands as the block begins (4.4.119).
    pub fn spdr(&mut self, axis: usize, distances: &[f64], pcap_index: i32) -> Entered {
        self.spool_points(axis, distances, true, Some(pcap_index))
    }
    /// Index of the command that the axis executes, or executed last, of those that had one (4.4.94).
    #[allow(non_snake_case)] // the manual's own name
    pub fn rdPcapIndex(&self, axis: usize) -> i32 {
        self.axes[axis].pcap_index
    }

    fn spool_points(&mut self, a: usize, values: &[f64], relative: bool, pcap_index: Option<i32>) -> Entered {
        if a >= self.axes.len() {
            self.raise(ErrorReg::errAxDef);
            return Entered::Discarded;
        }
        if !self.loops[a].closed {
            self.refuse(AxisSet::single(a));
            return Entered::Refused;
        }
        let size = 1..=MOST_POINTS;
        let Some(&last) =
            values.last().filter(|_| size.contains(&values.len()) && values.iter().all(|v| v.is_finite()))
        else {
            self.monitor_message();
            return Entered::Discarded;
        };
        let points = Points { count: values.len() as u32, relative, pcap_index };
        if self.axes[a].spooler.left() < BYTES_POINTS + points.count * BYTES_POINT {
            self.raise(ErrorReg::errSpoolerOverrun);
            return Entered::Full;
        }
        self.begin_spooling(AxisSet::single(a));
        let axis = &mut self.axes[a];
        let end = if relative { axis.queue_end + last } else { last };
        (axis.queue_end, axis.queue_tvl, axis.queue_last) = (end, 0.0, NONE);
        axis.spooler.push_points(points, values);
        Entered::Yes
    }

    /// Sets the target velocity, in PU and TU, of the last trajectory of these axes, in its direction: what follows goes
    /// on with it (4.4.122). It is no higher than the limits of that move and what it can reach.
    pub fn sstvl(&mut self, axes: AxisSet, tvl: f64) {
        if !tvl.is_finite() || tvl < 0.0 {
            return self.monitor_message();
        }
        let mut done = NONE;
        for a in self.known(axes).iter() {
            let slot = self.last_trajectory(a);
            if slot == NONE {
                continue;
            }
            let wanted_v = (tvl * self.velocity_unit(a)).min(self.moves[slot].vl);
            if self.axes[a].queue_last == slot {
                self.axes[a].queue_tvl = wanted_v;
            }
            if slot != done {
                self.pass_on(slot, wanted_v);
            }
            done = slot;
        }
    }

    /// The newest interpolation of an axis, in its spooler or being executed.
    fn last_trajectory(&self, a: usize) -> u32 {
        let axis = &self.axes[a];
        let spooled = axis.spooler.entries().iter().rev().find_map(|e| match e {
            Entry::Move { slot, .. } => Some(*slot),
            _ => None,
        });
        let executed = if let Doing::Move(slot) = axis.doing { slot } else { NONE };
        spooled.unwrap_or(executed)
    }

    /// A move ends with `v`, by a new plan where it is being executed.
    fn pass_on(&mut self, slot: u32, v: f64) {
        (self.moves[slot].tvl, self.moves[slot].passes) = (v, true);
        let executing = (0..self.axes.len()).find(|&a| self.axes[a].doing == Doing::Move(slot));
        let Some(a) = executing else { return };
        let mv = &self.moves[slot];
        let (s, now_v) = mv.profile.at(self.axes[a].t);
        if mv.stopping || now_v < 0.0 {
            return;
        }
        let jerkrel = if self.registers.modereg.has(ModeReg::SProfile) { mv.jerkrel } else { 0.0 };
        let max_v = mv.vl.max(now_v);
        let request = Request { from: s, to: mv.to, start_v: now_v, max_v, acc: mv.ac, target_v: v, jerkrel };
        let profile = Profile::spooled(&request);
        self.moves[slot].profile = profile;
        self.moves[slot].explain_stop(Cause::TargetVelocity);
        for axis in &mut self.axes {
            if axis.doing == Doing::Move(slot) {
                axis.t = 0.0;
            }
        }
    }
}

impl Axis {
    pub(crate) fn begin_points(&mut self, points: Points) {
        self.doing = Doing::Points(points.count);
        self.points_base = if points.relative { self.dp } else { 0.0 };
        self.points_count = points.pcap_index.is_some();
        // the first point counts it up to the index given
        self.pcap_index = points.pcap_index.map_or(self.pcap_index, |index| index.wrapping_sub(1));
        (self.path_v, self.last_axes, self.plan_v) = (0.0, AxisSet::EMPTY, 0.0);
    }

    /// The next point becomes the set point; false if none is left. `rest` is what the command before has left of
    /// this sample.
    pub(crate) fn step_points(&mut self, rest: f64, ta: f64) -> bool {
        let Doing::Points(left) = self.doing else { return false };
        if left == 0 {
            self.doing = Doing::Nothing;
            return false;
        }
        if rest <= 0.0 {
            return true;
        }
        let before = self.dp;
        let value = self.spooler.take_point().unwrap_or(before - self.points_base);
        self.dp = self.points_base + value;
        self.dv = (self.dp - before) / ta;
        self.doing = Doing::Points(left - 1);
        self.pcap_index = self.pcap_index.wrapping_add(i32::from(self.points_count));
        let goes_on = self.spooler.state == SpoolState::Running
            && matches!(self.spooler.entries().front(), Some(Entry::Move { .. }));
        self.run_on_v = if left == 1 && goes_on { self.dv / self.trajectory.factor } else { 0.0 };
        true
    }
}
