//! One sample interval, top to bottom (design 4.2).

use crate::axes::AxisSet;
use crate::axis::{Axis, Doing, Wait};
use crate::cause::{Cause, Limit};
use crate::listing::Came;
use crate::mcu::{Mcu, PointCache, WAIT_CI};
use crate::path::point;
use crate::position_loop::PositionLoop;
use crate::profile::{Profile, Request};
use crate::registers::{Axst, ErrorReg, ModeReg};
use crate::spooler::{Entry, NONE, SpoolState};
use crate::trace::{EventKind, Trace, flag};

/// Share of the speed that a triangle reaches below which NoTriangle takes a junction for standstill.
const STANDSTILL: f64 = 1e-3;

impl Mcu {
    /// One sample: measure, tasks, spooler and profiles, position loop, status, trace.
    pub(crate) fn step(&mut self, trace: &mut Trace) {
        for position_loop in &mut self.loops {
            position_loop.step_plant();
        }
        if self.attending {
            self.attend();
        }
        if !self.holding {
            self.run_tasks();
        }
        if !self.pending.is_empty() {
            self.begin_direct();
        }
        if self.waiting {
            self.end_waits();
        }
        for a in 0..self.axes.len() {
            if self.attention.slaves.contains(a) {
                self.synchronise(a);
            }
            self.step_axis(a);
        }
        self.check_synchronism();
        self.watch_limits();
        if !self.attention.masters.is_empty() {
            self.follow_masters();
        }
        self.close_sample();
        self.record(trace);
        self.sample += 1;
        if self.attending {
            self.look_back(trace);
        }
    }

    /// The profile clock of an axis runs on by one sample; what is left of it flows into the next entry.
    fn step_axis(&mut self, a: usize) {
        let axis = &mut self.axes[a];
        axis.trajectory.advance();
        let mut rest = axis.trajectory.factor * self.ta;
        loop {
            let axis = &mut self.axes[a];
            match axis.doing {
                Doing::Move(slot) => {
                    let t = axis.t + rest;
                    let end_t = self.moves[slot].profile.end_t;
                    if t < end_t {
                        axis.t = t;
                        return self.evaluate(a, slot);
                    }
                    rest = t - end_t;
                    self.finish_move(a, slot);
                }
                Doing::Wait(_) => {
                    axis.dv = 0.0;
                    return;
                }
                Doing::Points(_) => {
                    if axis.step_points(rest, self.ta) {
                        return;
                    }
                }
                Doing::Alone => {
                    axis.step_alone(self.ta);
                    if axis.doing == Doing::Nothing && axis.jogging {
                        self.forbid_target_velocity(a);
                    }
                    return;
                }
                Doing::Nothing => {
                    if axis.spooler.state != SpoolState::Running {
                        return axis.run_on(rest);
                    }
                    self.next_entry(a);
                }
            }
        }
    }

    /// Set point of an axis inside a move. Axes on the same clock share the point on the path.
    #[inline]
    fn evaluate(&mut self, a: usize, slot: u32) {
        let axis = &mut self.axes[a];
        let mv = &self.moves[slot];
        if self.cache.slot != slot || self.cache.t != axis.t {
            let (s, v) = mv.profile.at(axis.t);
            self.cache = PointCache { slot, t: axis.t, v, point: point(s, mv.curvature) };
        }
        axis.plan_v = self.cache.v;
        axis.dp = axis.component.position(&self.cache.point);
        axis.dv = axis.component.slope(&self.cache.point, mv.curvature) * self.cache.v * axis.trajectory.factor;
    }

    /// The end of a move: exactly its target, rounded to counts at a stop without ExactTargetPos.
    fn finish_move(&mut self, a: usize, slot: u32) {
        let mv = &self.moves[slot];
        let exact = self.registers.modereg.has(ModeReg::ExactTargetPos);
        let end = point(mv.to, mv.curvature);
        let end_v = mv.profile.end_v;
        let whole = mv.to == mv.length;
        let axis = &mut self.axes[a];
        axis.dp = if whole { axis.component.target } else { axis.component.position(&end) };
        if whole && end_v == 0.0 && !exact {
            axis.dp = axis.rounded(axis.dp);
        }
        axis.run_on_v = axis.component.slope(&end, mv.curvature) * end_v;
        (axis.path_v, axis.last_axes, axis.plan_v) = (end_v, mv.axes, 0.0);
        axis.limit = mv.limits.end;
        axis.doing = Doing::Nothing;
        let direct = mv.direct;
        if self.moves[slot].users == 1 {
            self.tell_passage(slot, if whole { Came::Done } else { Came::Cut });
        }
        self.let_go(slot);
        if direct {
            self.forbid_target_velocity(a);
        }
    }

    /// ForbidTargetVel: motion profiles that end with a velocity, and nothing follows, reset the system.
    fn forbid_target_velocity(&mut self, a: usize) {
        if self.axes[a].run_on_v != 0.0 && self.registers.modereg.has(ModeReg::ForbidTargetVel) {
            self.raise(ErrorReg::errTargetVel);
            self.rs();
        }
    }

    /// One axis no longer holds an entry of a move.
    pub(crate) fn let_go(&mut self, slot: u32) {
        if self.moves[slot].users == 1 {
            self.lookahead.remove(&mut self.moves, slot);
        }
        if self.moves.release(slot) && self.cache.slot == slot {
            self.cache.slot = NONE;
        }
    }

    /// The running spooler of an axis hands over its next entry.
    fn next_entry(&mut self, a: usize) {
        match self.axes[a].spooler.pop() {
            None => self.drained(a),
            Some(Entry::Move { slot, component }) => {
                let axis = &mut self.axes[a];
                (axis.doing, axis.component, axis.t) = (Doing::Move(slot), component, 0.0);
                if !self.moves[slot].planned {
                    self.plan(a, slot);
                }
                self.watch_duration(a, slot);
                let axis = &mut self.axes[a];
                axis.run_on_v = 0.0;
                axis.pcap_index = self.moves[slot].pcap_index.unwrap_or(axis.pcap_index);
            }
            Some(Entry::Function(function)) => {
                let axis = &mut self.axes[a];
                axis.pcap_index = function.pcap_index.unwrap_or(axis.pcap_index);
                self.execute(a, function);
            }
            Some(Entry::Points(points)) => self.axes[a].begin_points(points),
            Some(Entry::HoldPoint) => self.axes[a].spooler.state = SpoolState::Held,
        }
    }

    /// The spooler is empty: back to direct mode (2.2.8.2).
    fn drained(&mut self, a: usize) {
        let axis = &mut self.axes[a];
        axis.spooler.state = SpoolState::Direct;
        axis.short_moves = 0;
        if axis.run_on_v == 0.0 {
            axis.path_v = 0.0;
        }
        self.forbid_target_velocity(a);
    }

    /// Plans a move as its first axis starts it; its plan is frozen from here on.
    fn plan(&mut self, a: usize, slot: u32) {
        let start_v = self.start_velocity(a, slot);
        let joins = self.axes[a].last_axes == self.moves[slot].axes;
        let start = if joins { self.axes[a].limit } else { Limit::of(Cause::Stop) };
        let looks_ahead = self.registers.modereg.has(ModeReg::LookAhead) && !self.moves[slot].plain;
        let bound = self.lookahead.plan(&mut self.moves, slot, self.registers.lookahead_depth);
        let mv = &self.moves[slot];
        let mut end = mv.target_limit();
        let mut request = Request {
            from: mv.from,
            to: mv.to,
            start_v,
            max_v: mv.vl,
            acc: mv.ac,
            target_v: mv.tvl,
            jerkrel: if self.registers.modereg.has(ModeReg::SProfile) { mv.jerkrel } else { 0.0 },
        };
        if looks_ahead {
            let reach_v2 = start_v.min(mv.vl).powi(2) + 2.0 * mv.ac * (mv.to - mv.from);
            request.target_v = bound.v2.min(reach_v2).sqrt();
            // what it cannot reach is limited by where it comes from
            end = if bound.v2 < reach_v2 { bound.limit } else { start };
            if bound.starved && bound.v2 < reach_v2 {
                self.raise(ErrorReg::SpoolerDeepToLess);
            }
            if self.registers.modereg.has(ModeReg::NoTriangle) {
                Self::without_triangle(&mut request);
            }
        }
        let mv = &mut self.moves[slot];
        mv.profile = Profile::spooled(&request);
        mv.planned = true;
        mv.explain(start, end, request.max_v);
        self.tell_passage(slot, Came::Begun);
    }

    /// NoTriangle (design D16): a move that cannot reach its velocity keeps the higher of its junction speeds. Less
    /// than a thousandth of what the triangle reaches is standstill, else a tiny last move would make the one before
    /// it crawl.
    fn without_triangle(request: &mut Request) {
        let (v0, v1) = (request.start_v, request.target_v);
        let top_v2 = request.acc * (request.to - request.from) + 0.5 * (v0 * v0 + v1 * v1);
        let kept_v = v0.max(v1);
        if top_v2 < request.max_v * request.max_v && kept_v > STANDSTILL * top_v2.sqrt() {
            request.max_v = kept_v;
        }
    }

    /// Path velocity at the start: that of the preceding move of the same axes, else the magnitude of the
    /// present velocities (2.2.2).
    fn start_velocity(&self, a: usize, slot: u32) -> f64 {
        let axes = self.moves[slot].axes;
        if self.axes[a].last_axes == axes {
            return self.axes[a].path_v.abs();
        }
        let squares = axes.iter().map(|b| (self.axes[b].run_on_v * self.axes[b].parameters.scale).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// Two spooled moves in a row that take less than a sample (ErrorReg bit 5).
    fn watch_duration(&mut self, a: usize, slot: u32) {
        let axis = &mut self.axes[a];
        if self.moves[slot].profile.end_t >= self.ta * axis.trajectory.factor {
            axis.short_moves = 0;
            return;
        }
        axis.short_moves += 1;
        if axis.short_moves == 2 {
            self.raise(ErrorReg::ProfileToSmall);
        }
    }

    /// Ends the waits whose condition is met, all in the same sample.
    fn end_waits(&mut self) {
        let mut over = 0u32;
        for (a, axis) in self.axes.iter().enumerate() {
            if let Doing::Wait(wait) = axis.doing
                && self.is_over(a, wait)
            {
                over |= 1 << a;
            }
        }
        self.waiting = false;
        for (a, axis) in self.axes.iter_mut().enumerate() {
            if over >> a & 1 == 1 {
                axis.doing = Doing::Nothing;
                axis.function = None;
            } else if let Doing::Wait(Wait::Samples(left)) = &mut axis.doing {
                *left -= 1;
            }
            self.waiting |= matches!(axis.doing, Doing::Wait(_)) || axis.spooler.state == SpoolState::Halted;
        }
        self.waiting |= self.tasks.iter().any(|t| t.rests());
        if !self.waiting {
            self.told.acknowledge = false;
        }
    }

    fn is_over(&self, a: usize, wait: Wait) -> bool {
        match wait {
            Wait::Samples(left) => left == 0,
            Wait::Inputs(mask) => self.digi & mask == mask,
            Wait::Ci99 => self.ci[WAIT_CI] == 0,
            Wait::Ci99Bit => self.ci[WAIT_CI] as u32 >> a & 1 == 0,
            Wait::Axes(mask) => {
                let known = mask & self.all_axes().0;
                (0..self.axes.len()).all(|b| known >> b & 1 == 0 || self.axes[b].doing == Doing::Wait(Wait::Axes(mask)))
            }
        }
    }

    /// The axes of an interpolation execute it on the same clock, else they are asynchronous (2.2.8.3).
    fn check_synchronism(&mut self) {
        let mut seen = (NONE, 0.0, true);
        for a in 0..self.axes.len() {
            let axis = &self.axes[a];
            let Doing::Move(slot) = axis.doing else { continue };
            if seen.0 != slot || seen.1 != axis.t {
                let is_here = |b: usize| matches!(self.axes[b].doing, Doing::Move(s) if s == slot);
                let together = self.moves[slot].axes.iter().all(|b| is_here(b) && self.axes[b].t == axis.t);
                seen = (slot, axis.t, together);
            }
            if !seen.2 && !axis.status.has(Axst::saf) {
                self.lose_synchronism(self.moves[slot].axes.0);
            }
        }
    }

    #[cold]
    fn lose_synchronism(&mut self, axes: u32) {
        for a in 0..self.axes.len() {
            if axes >> a & 1 == 1 {
                self.set_status(a, Axst::saf, true);
            }
        }
        if self.registers.modereg.has(ModeReg::JSatSAF) {
            let closed = (0..self.axes.len()).filter(|&a| self.loops[a].closed).collect();
            self.stop_by_system(closed);
            self.raise(ErrorReg::JSatSAFdone);
            self.tell_fault(axes.trailing_zeros() as usize);
        }
    }

    /// Motor commands and status at the end of the interval.
    fn close_sample(&mut self) {
        let (mut settled, mut idle) = (true, true);
        let mut astray = 0;
        for (a, (axis, position_loop)) in self.axes.iter_mut().zip(&mut self.loops).enumerate() {
            let set_point = axis.set_point();
            let travels = axis.doing.travels() || axis.pending > 0;
            position_loop.control(set_point, axis.set_velocity(set_point), axis.limiting.motor_off, travels);
            axis.status.put(Axst::pe, !travels);
            let off = position_loop.error(set_point).abs();
            let in_position = !travels && (axis.parameters.ipw <= 0.0 || off < axis.parameters.ipw);
            axis.status.put(Axst::ip, in_position && axis.parameters.ipw > 0.0);
            settled &= in_position;
            idle &= !travels;
            if position_loop.closed
                && axis.parameters.mpe > 0.0
                && off > axis.parameters.mpe
                && !axis.status.has(Axst::mpe)
            {
                astray |= 1 << a;
            }
        }
        for a in AxisSet(astray).iter() {
            self.set_status(a, Axst::mpe, true);
        }
        self.settled = if settled { self.settled + 1 } else { 0 };
        self.ended = if idle { self.ended + 1 } else { 0 };
    }

    /// Sets or clears status bits of an axis, with an event for each that changes.
    pub(crate) fn set_status(&mut self, a: usize, bits: Axst, on: bool) {
        let before = self.axes[a].status;
        self.axes[a].status.put(bits, on);
        let changed = before.0 ^ self.axes[a].status.0;
        if on && changed & self.stop_at.0 != 0 {
            self.tell_fault(a);
        }
        let line = self.current_move(a).or_else(|| self.current_move(self.leader)).map_or(0, |mv| mv.line);
        for &(number, name, _) in Axst::ALL {
            if changed >> number & 1 == 1 {
                self.event(EventKind::Axst, a as i32, name, on, line, i64::from(number));
            }
        }
    }

    /// Motion has left its contour, or is to end: [`crate::Stop::Fault`].
    pub(crate) fn tell_fault(&mut self, a: usize) {
        self.told.fault.get_or_insert(a);
    }

    fn record(&self, trace: &mut Trace) {
        let mut flags = 0;
        trace.dp.extend(self.axes.iter().map(Axis::set_point));
        trace.load.extend(self.loops.iter().map(PositionLoop::load));
        trace.rp.extend(self.loops.iter().map(PositionLoop::rp));
        for axis in &self.axes {
            flags |= match axis.doing {
                Doing::Move(_) | Doing::Points(_) => flag::MOVING,
                Doing::Alone => flag::MOVING | flag::DIRECT,
                Doing::Wait(_) => flag::WAITING,
                Doing::Nothing if axis.spooler.state == SpoolState::Halted => flag::WAITING,
                Doing::Nothing if axis.run_on_v != 0.0 => flag::MOVING,
                Doing::Nothing => 0,
            };
        }
        let leader = &self.axes[self.leader];
        let (mut line, mut number) = (leader.function.map_or(0, |f| f.line), 0);
        let limit = if let Doing::Move(slot) = leader.doing {
            let mv = &self.moves[slot];
            (line, number) = (mv.line, mv.number);
            flags |= if mv.rapid { flag::RAPID } else { 0 } | if mv.direct { flag::DIRECT } else { 0 };
            leader.limit_in(mv)
        } else {
            self.limit_without_leader()
        };
        flags |= if self.holding { flag::HELD } else { 0 } | u32::from(limit.0) << flag::LIMIT_SHIFT;
        trace.line.push(line);
        trace.entry.push(number);
        trace.v_plan.push(leader.plan_v);
        trace.factor.push(leader.trajectory.factor);
        trace.flags.push(flags);
    }
}

impl Axis {
    /// After a target velocity without a following command the axis goes on moving (2.2.5).
    fn run_on(&mut self, rest: f64) {
        self.dp += self.run_on_v * rest;
        self.dv = self.run_on_v * self.trajectory.factor;
    }
    /// A jog or a stop of the axis alone.
    fn step_alone(&mut self, ta: f64) {
        let factor = if self.jogging { self.jog_override() } else { 1.0 };
        self.t += factor * ta;
        let rest = self.t - self.alone.end_t;
        if rest < 0.0 {
            let (s, v) = self.alone.at(self.t);
            (self.dp, self.dv) = (self.component.base + self.component.p * s, self.component.p * v * factor);
            return;
        }
        let (end_s, end_v) = (self.alone.end_s, self.alone.end_v);
        self.dp = if self.jogging { self.component.target } else { self.component.base + self.component.p * end_s };
        (self.doing, self.run_on_v) = (Doing::Nothing, self.component.p * end_v);
        (self.dp, self.dv) = (self.dp + self.run_on_v * rest, self.run_on_v * factor);
        self.braked_by_system = false;
        self.forget_queue();
    }
}
