//! Braking along the contour: `ms`, and the operator's feed hold and resume (design D5, D17).
//!
//! Where the axes will stand is known in closed form when the command comes: the moves up to there get a
//! braking profile, the move in which they stop is cut in two on the same geometry. `ms` discards what lies
//! behind; a hold puts a mark there and keeps it, so resuming is going on behind the mark. Spool functions
//! passed while braking are not executed: a hold keeps them behind the mark, before the rest of the cut move.

use crate::axes::AxisSet;
use crate::axis::{Axis, Doing};
use crate::cause::{Cause, Limit};
use crate::mcu::Mcu;
use crate::profile::Profile;
use crate::registers::ModeReg;
use crate::spooler::{Entry, NONE, SpoolState};

/// What happens to the contour behind the stop.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Behind {
    Kept,
    Discarded,
}

/// A remainder shorter than this (mm) is no cut: the axes stop at the end of the move.
const CUT_END: f64 = 1e-9;

impl Mcu {
    /// Feed hold: all axes brake along their contours, tasks stand; [`Mcu::resume`] goes on. Idempotent.
    pub fn hold(&mut self) {
        if self.holding && !self.block_hold {
            return;
        }
        self.remove_marks();
        (self.holding, self.block_hold, self.told.held) = (true, false, false);
        let axes = self.all_axes();
        self.stop_contours(axes, Behind::Kept);
    }

    /// Goes on after a hold where it stopped; also while the axes are still braking.
    pub fn resume(&mut self) {
        if !self.holding {
            return;
        }
        (self.holding, self.block_hold) = (false, false);
        for axis in &mut self.axes {
            if axis.spooler.state == SpoolState::Held {
                axis.spooler.state = SpoolState::Running;
            }
        }
        self.remove_marks();
    }

    fn remove_marks(&mut self) {
        for axis in &mut self.axes {
            while let Some(mark) = axis.spooler.entries().iter().position(|e| *e == Entry::HoldPoint) {
                axis.spooler.remove(mark);
            }
        }
    }

    /// True from [`Mcu::hold`] to [`Mcu::resume`].
    pub fn is_holding(&self) -> bool {
        self.holding
    }

    /// Motion stop (ms, 4.4.39): brakes along the contour with the acceleration of the current command
    /// (MS_DECEL: TRAC), never faster than planned; the rest is discarded.
    pub fn ms(&mut self, axes: AxisSet) {
        self.stop_contours(axes, Behind::Discarded);
    }

    /// Ends the job: tasks stop, axes brake along their contours, everything spooled is discarded.
    pub fn abort(&mut self) {
        for task in 0..self.tasks.len() {
            self.tasks[task].abort();
        }
        let axes = self.all_axes();
        self.ms(axes);
        (self.holding, self.block_hold) = (false, false);
        self.told = crate::mcu::Told::default();
    }

    fn stop_contours(&mut self, axes: AxisSet, behind: Behind) {
        self.drop_pending(axes);
        let mut done = AxisSet::EMPTY;
        for a in self.known(axes).iter() {
            match self.axes[a].doing {
                Doing::Move(slot) if self.moves[slot].stopping => {
                    if behind == Behind::Discarded && !done.contains(a) {
                        self.discard_behind_mark(a);
                    }
                }
                Doing::Move(slot) => {
                    let group = self.moves[slot].axes;
                    if axes.contains_all(group) && self.can_stop_together(a, slot, behind) {
                        self.stop_group(slot, self.axes[a].t, behind);
                        done = done.union(group);
                    } else if behind == Behind::Discarded {
                        self.stop_apart(a, slot);
                    } else {
                        self.js(AxisSet::single(a));
                    }
                }
                Doing::Points(_) => self.js(AxisSet::single(a)),
                Doing::Alone if self.axes[a].jogging => self.js(AxisSet::single(a)),
                Doing::Alone => {}
                Doing::Wait(_) => self.break_wait(a, behind),
                Doing::Nothing if self.axes[a].run_on_v != 0.0 => self.js(AxisSet::single(a)),
                Doing::Nothing => self.stop_idle(a, behind),
            }
        }
    }

    /// All axes of the move are on one clock, and a hold does not meet an overshoot (negative target velocity).
    fn can_stop_together(&self, a: usize, slot: u32, behind: Behind) -> bool {
        let (mv, t) = (&self.moves[slot], self.axes[a].t);
        let together = |b: usize| self.axes[b].doing == Doing::Move(slot) && self.axes[b].t == t;
        mv.axes.iter().all(together) && (behind == Behind::Discarded || mv.profile.end_v >= 0.0)
    }

    /// A wait is broken off; a hold lets it begin anew, in full.
    fn break_wait(&mut self, a: usize, behind: Behind) {
        let axis = &mut self.axes[a];
        axis.doing = Doing::Nothing;
        if let Some(function) = axis.function.take().filter(|_| behind == Behind::Kept) {
            axis.spooler.push_front(Entry::Function(function));
        }
        self.stop_idle(a, behind);
    }

    fn stop_idle(&mut self, a: usize, behind: Behind) {
        match behind {
            Behind::Discarded => self.enter_direct_mode(a),
            Behind::Kept if self.axes[a].spooler.state == SpoolState::Running => {
                self.axes[a].spooler.state = SpoolState::Held;
            }
            Behind::Kept => {}
        }
    }

    /// Stops the axes of a move, which are at profile time `t` in it.
    fn stop_group(&mut self, slot: u32, t: f64, behind: Behind) {
        let brake_acc = self.brake_acc(slot);
        let axes = self.moves[slot].axes;
        let cut = self.brake_along(slot, t, brake_acc);
        for a in axes.iter() {
            self.axes[a].t = 0.0;
        }
        let (to, stop_s) = (self.moves[cut].to, self.moves[cut].profile.end_s);
        let inside = (to - stop_s).abs() > CUT_END;
        let rest = if inside && behind == Behind::Kept { self.cut_off(cut) } else { NONE };
        if inside {
            self.moves[cut].to = stop_s;
        } else {
            self.moves[cut].profile.end_s = to;
        }
        for a in axes.iter() {
            match behind {
                Behind::Kept => self.mark(a, cut, rest),
                Behind::Discarded => self.discard_behind(a, cut),
            }
        }
    }

    /// An axis leaves its group and brakes on, or on beyond, its share of the path, in the direction it has (4.4.39).
    fn stop_apart(&mut self, a: usize, slot: u32) {
        let brake_acc = self.brake_acc(slot);
        let jerkrel = self.shape_of(slot);
        let mut apart = self.moves[slot];
        let (s, v) = apart.profile.at(self.axes[a].t);
        let (profile, _) = Profile::stopping(s, f64::INFINITY, v.max(0.0), brake_acc, 0.0, jerkrel);
        apart.profile = if v < 0.0 { Profile::turning_back(s, v, brake_acc) } else { profile };
        (apart.axes, apart.users, apart.to) = (AxisSet::single(a), 1, apart.profile.end_s);
        (apart.planned, apart.stopping) = (true, true);
        apart.explain_stop(Cause::Stop);
        let component = self.axes[a].component;
        self.enter_direct_mode(a);
        let own = self.moves.add(apart);
        self.lookahead.append(&mut self.moves, own, None);
        self.lookahead.plan(&mut self.moves, own, 0);
        let end = crate::path::point(apart.to, apart.curvature);
        let axis = &mut self.axes[a];
        (axis.doing, axis.component, axis.t) = (Doing::Move(own), component, 0.0);
        axis.queue_end = component.position(&end);
    }

    /// Acceleration of a stop along a move: its own, or TRAC, which is in PU and TU.
    fn brake_acc(&self, slot: u32) -> f64 {
        let mv = &self.moves[slot];
        let trac = self.registers.modereg.has(ModeReg::MS_DECEL) && self.registers.trac > 0.0;
        let first = mv.axes.iter().next().unwrap_or(0);
        if trac { self.registers.trac * self.acceleration_unit(first) } else { mv.ac }
    }
    /// jerkrel of a move if ramps are S-shaped, else 0.
    fn shape_of(&self, slot: u32) -> f64 {
        if self.registers.modereg.has(ModeReg::SProfile) { self.moves[slot].jerkrel } else { 0.0 }
    }

    /// Gives the moves from `slot` on braking profiles and returns the one in which the axes stop.
    fn brake_along(&mut self, slot: u32, t: f64, brake_acc: f64) -> u32 {
        let jerkrel = self.shape_of(slot);
        let mv = &mut self.moves[slot];
        let (s, v) = mv.profile.at(t);
        let limit_v2 = mv.profile.end_v.max(0.0).powi(2);
        let (mut profile, mut stands) = Profile::stopping(s, mv.to, v.max(0.0), brake_acc, limit_v2, jerkrel);
        if v < 0.0 {
            (profile, stands) = (Profile::turning_back(s, v, brake_acc), true);
        }
        (mv.profile, mv.stopping) = (profile, true);
        let cause = if self.holding { Cause::Hold } else { Cause::Stop };
        mv.explain_stop(cause);
        let mut current = slot;
        while !stands && profile.end_v > 0.0 {
            let next = self.lookahead.first_unplanned(&self.moves, current);
            if next == NONE {
                self.brake_to_end(current);
                break;
            }
            let looks_ahead = self.registers.modereg.has(ModeReg::LookAhead) && !self.moves[next].plain;
            let bound = self.lookahead.plan(&mut self.moves, next, self.registers.lookahead_depth);
            let mv = &mut self.moves[next];
            let limit_v2 = if looks_ahead { bound.v2 } else { mv.tvl.max(0.0).powi(2) };
            // without look-ahead the plan itself may start lower, by a jump (2.2.2)
            let highest_v2 = limit_v2 + 2.0 * mv.ac.max(brake_acc) * (mv.to - mv.from);
            let start_v = profile.end_v.min(mv.vl).min(highest_v2.sqrt());
            (profile, stands) = Profile::stopping(mv.from, mv.to, start_v, brake_acc, limit_v2, 0.0);
            (mv.profile, mv.planned, mv.stopping) = (profile, true, true);
            mv.explain_stop(cause);
            current = next;
        }
        current
    }

    /// A planned move that would end with a velocity, and nothing joins it: it brakes to 0 within its length,
    /// from where its axes are.
    pub(crate) fn brake_to_end(&mut self, slot: u32) {
        let mv = &self.moves[slot];
        let executing = mv.axes.iter().find(|&a| self.axes[a].doing == Doing::Move(slot));
        let t = executing.map_or(0.0, |a| self.axes[a].t);
        let (s, v) = mv.profile.at(t);
        let needed = v * v / (2.0 * (mv.to - s).max(1e-12));
        let request = crate::profile::Request {
            from: s,
            to: mv.to,
            start_v: v.max(0.0),
            max_v: mv.vl.max(v),
            acc: mv.ac.max(needed),
            target_v: 0.0,
            jerkrel: 0.0,
        };
        self.moves[slot].profile = Profile::spooled(&request);
        self.moves[slot].explain_stop(if self.holding { Cause::Hold } else { Cause::Stop });
        for a in 0..self.axes.len() {
            if self.axes[a].doing == Doing::Move(slot) {
                self.axes[a].t = 0.0;
            }
        }
    }

    /// The rest of a cut move as a move of its own, on the same geometry and with the same number.
    fn cut_off(&mut self, cut: u32) -> u32 {
        let mut rest = self.moves[cut];
        rest.from = rest.profile.end_s;
        (rest.planned, rest.stopping, rest.profile) = (false, false, Profile::default());
        rest.limits.junction = Limit::of(Cause::Hold);
        rest.users = rest.axes.len() as u32;
        let slot = self.moves.add(rest);
        self.lookahead.insert_first(&mut self.moves, slot, cut);
        slot
    }

    /// Orders the spooler of an axis: moves up to the cut, the mark, functions passed, the rest, what follows.
    fn mark(&mut self, a: usize, cut: u32, rest: u32) {
        let axis = &mut self.axes[a];
        let component = axis.component_of(cut);
        let mut behind = axis.after(cut);
        let (mut index, mut passed) = (0, 0);
        while index + 1 < behind {
            if matches!(axis.spooler.entries()[index], Entry::Function(_)) {
                let function = axis.spooler.remove(index).expect("index is inside");
                behind -= 1;
                axis.spooler.insert(behind + passed, function);
                passed += 1;
            } else {
                index += 1;
            }
        }
        if rest != NONE {
            axis.spooler.insert(behind + passed, Entry::Move { slot: rest, component });
            if axis.queue_last == cut {
                axis.queue_last = rest;
            }
        }
        axis.spooler.insert(behind, Entry::HoldPoint);
        axis.spooler.state = SpoolState::Running; // also behind a direct move
    }

    /// `ms` or the end of a job during a hold: what was kept goes too.
    fn discard_behind_mark(&mut self, a: usize) {
        let mark = self.axes[a].spooler.entries().iter().position(|e| *e == Entry::HoldPoint);
        while mark.is_some_and(|mark| self.axes[a].spooler.len() > mark) {
            if let Some(Entry::Move { slot, .. }) = self.axes[a].spooler.pop_back() {
                self.let_go(slot);
            }
        }
        (self.axes[a].queue_tvl, self.axes[a].queue_last) = (0.0, NONE);
    }

    /// Everything behind the cut goes, and functions before it.
    fn discard_behind(&mut self, a: usize, cut: u32) {
        let keep = self.axes[a].after(cut);
        while self.axes[a].spooler.len() > keep {
            if let Some(Entry::Move { slot, .. }) = self.axes[a].spooler.pop_back() {
                self.let_go(slot);
            }
        }
        let axis = &mut self.axes[a];
        let mut index = 0;
        while index < axis.spooler.len() {
            if matches!(axis.spooler.entries()[index], Entry::Function(_)) {
                axis.spooler.remove(index);
            } else {
                index += 1;
            }
        }
        let component = axis.component_of(cut);
        let mv = &self.moves[cut];
        let end = crate::path::point(mv.to, mv.curvature);
        axis.queue_end = if mv.to == mv.length { component.target } else { component.position(&end) };
        (axis.queue_tvl, axis.queue_last) = (0.0, NONE);
    }
}

impl Axis {
    /// Index of the first entry behind the move `slot`; 0 if the axis is executing it.
    pub(crate) fn after(&self, slot: u32) -> usize {
        let at = self.spooler.entries().iter().position(|e| matches!(e, Entry::Move { slot: s, .. } if *s == slot));
        at.map_or(0, |index| index + 1)
    }
    fn component_of(&self, slot: u32) -> crate::path::Component {
        let entry = self.spooler.entries().iter().find_map(|e| match e {
            Entry::Move { slot: s, component } if *s == slot => Some(*component),
            _ => None,
        });
        entry.unwrap_or(self.component)
    }
}
