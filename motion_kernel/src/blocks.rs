//! Single block for what is spooled already: the axes stop at the end of a source line, and go on line by line.
//!
//! As in hold.rs a mark in the spoolers says where they rest. The junction behind the line gets speed 0, so the
//! look-ahead plans the stop like any other; where the line is too short for it, the stop is at the end of a later one.

use crate::axes::AxisSet;
use crate::axis::Doing;
use crate::cause::{Cause, Limit};
use crate::functions::command;
use crate::mcu::Mcu;
use crate::profile::{Profile, Request};
use crate::registers::ModeReg;
use crate::spooler::{Entry, NONE, SpoolState};

impl Mcu {
    /// A hold at the end of the source line being executed, or of the next that leaves room to brake. Tasks stand;
    /// [`Mcu::resume`] goes on, [`Mcu::step_block`] executes one more line, [`Mcu::hold`] stops at once.
    pub fn hold_at_block_end(&mut self) {
        if self.holding {
            return;
        }
        (self.holding, self.block_hold, self.told.held) = (true, true, false);
        let mut done = AxisSet::EMPTY;
        for a in 0..self.axes.len() {
            match self.axes[a].doing {
                Doing::Move(slot) if !done.contains(a) => {
                    done = done.union(self.moves[slot].axes);
                    self.stop_at_line_end(a, slot);
                }
                Doing::Wait(_) | Doing::Points(_) => self.axes[a].spooler.insert(0, Entry::HoldPoint),
                Doing::Nothing if self.axes[a].spooler.state == SpoolState::Running => {
                    self.axes[a].spooler.state = SpoolState::Held;
                }
                _ => {}
            }
        }
    }

    /// While held: executes the next source line of what is spooled and holds again. False if nothing is spooled:
    /// then [`Mcu::resume`] and [`Mcu::stepcnct`] let the task give the next line.
    pub fn step_block(&mut self) -> bool {
        let held = |a: &usize| self.axes[*a].spooler.state == SpoolState::Held;
        let axes: AxisSet = (0..self.axes.len()).filter(held).collect();
        let Some(line) = self.holding.then(|| self.next_line(axes)).flatten() else { return false };
        (self.block_hold, self.told.held) = (true, false);
        let only_functions =
            axes.iter().any(|a| matches!(self.axes[a].spooler.entries().front(), Some(Entry::Function(_))));
        for a in axes.iter() {
            let behind = self.entries_of_line(a, line, only_functions);
            let last = behind.checked_sub(1).map(|index| self.axes[a].spooler.entries()[index]);
            if let Some(Entry::Move { slot, .. }) = last {
                self.rest_behind(slot);
            }
            self.axes[a].spooler.insert(behind, Entry::HoldPoint);
            self.axes[a].spooler.state = SpoolState::Running;
        }
        true
    }

    /// The source line of what comes next: functions first, for they may stand before it on one axis only.
    fn next_line(&self, axes: AxisSet) -> Option<u32> {
        let first = |a: usize| self.axes[a].spooler.entries().front().copied();
        let function = axes.iter().find_map(|a| match first(a) {
            Some(Entry::Function(function)) => Some(function.line),
            _ => None,
        });
        function.or_else(|| axes.iter().find_map(|a| first(a).and_then(|entry| self.line_of(&entry))))
    }

    fn line_of(&self, entry: &Entry) -> Option<u32> {
        match entry {
            Entry::Move { slot, .. } => Some(self.moves[*slot].line),
            Entry::Function(function) => Some(function.line),
            Entry::Points(_) => Some(0), // commands of the application have no line
            Entry::HoldPoint => None,
        }
    }

    /// Entries at the front of a spooler that belong to a line.
    fn entries_of_line(&self, a: usize, line: u32, only_functions: bool) -> usize {
        let belongs =
            |e: &&Entry| self.line_of(e) == Some(line) && (!only_functions || matches!(e, Entry::Function(_)));
        self.axes[a].spooler.entries().iter().take_while(belongs).count()
    }

    /// Speed 0 at the junction behind a move that is not planned yet.
    fn rest_behind(&mut self, slot: u32) {
        let next = self.moves[slot].next;
        if next != NONE {
            self.moves[next].junction_v2 = 0.0;
            self.moves[next].limits.junction = Limit::of(Cause::Hold);
        }
        self.moves[slot].tvl = 0.0;
        self.lookahead.refresh(&self.moves, slot);
    }

    /// Plans the axes of a move to rest at the end of its line, or of the next line that leaves room for it.
    fn stop_at_line_end(&mut self, a: usize, slot: u32) {
        let mv = &self.moves[slot];
        let (axes, line, end_v2) = (mv.axes, mv.line, mv.profile.end_v * mv.profile.end_v);
        let (s, v) = mv.profile.at(self.axes[a].t);
        let first = self.lookahead.first_unplanned(&self.moves, slot);
        let own_line = first == NONE || self.moves[first].line != line;
        let last = if own_line && v >= 0.0 && v * v <= 2.0 * mv.ac * (mv.to - s) {
            self.replan(slot, s, v, 0.0);
            slot
        } else {
            self.last_to_rest(slot, first, end_v2)
        };
        for b in axes.iter() {
            let axis = &self.axes[b];
            let behind = axis.after(last);
            let of_line = |e: &&Entry| matches!(e, Entry::Function(f) if f.line == self.moves[last].line && !command::WAITS.contains(&f.command));
            let functions = axis.spooler.entries().iter().skip(behind).take_while(of_line).count();
            self.axes[b].spooler.insert(behind + functions, Entry::HoldPoint);
        }
    }

    /// The last move of the first line behind the move `slot` that can end with standstill, when the next move
    /// starts with the squared speed planned now; that stop is planned.
    fn last_to_rest(&mut self, slot: u32, first: u32, start_v2: f64) -> u32 {
        let (mut last, mut next, mut room_v2) = (slot, first, 0.0);
        while next != NONE {
            let mv = &self.moves[next];
            // without look-ahead nothing plans back over several moves
            let before = if self.registers.modereg.has(ModeReg::LookAhead) { room_v2 } else { 0.0 };
            room_v2 = before + 2.0 * mv.ac * (mv.to - mv.from);
            (last, next) = (next, mv.next);
            if (next == NONE || self.moves[next].line != self.moves[last].line) && start_v2 <= room_v2 {
                break;
            }
        }
        if last == slot {
            self.brake_to_end(slot);
        } else {
            self.rest_behind(last);
        }
        last
    }

    /// A new plan for the rest of the move that its axes execute, from path coordinate `s` at velocity `v`.
    fn replan(&mut self, slot: u32, s: f64, v: f64, target_v: f64) {
        let mv = &mut self.moves[slot];
        let shaped = self.registers.modereg.has(ModeReg::SProfile);
        let jerkrel = if shaped { mv.jerkrel } else { 0.0 };
        let request = Request { from: s, to: mv.to, start_v: v, max_v: mv.vl.max(v), acc: mv.ac, target_v, jerkrel };
        mv.profile = Profile::spooled(&request);
        mv.explain_stop(Cause::Hold);
        for axis in &mut self.axes {
            if axis.doing == Doing::Move(slot) {
                axis.t = 0.0;
            }
        }
    }
}
