//! The main spindle: S, G96 and G97, and what drives it (docs/dialect.md, sections 8 and 16).

use crate::block::{Block, GWord, bit};
use crate::codes::Group;
use crate::diagnostics::{Check, Fault, Id};
use crate::feed::Lengths;
use crate::group::Point;
use crate::mfunc::spool;
use crate::modal::FeedMode;
use crate::outputs::Outputs;
use crate::target::Target;
use crate::translate::Translator;

/// Smallest diameter that a cutting speed is referred to, mm.
const LEAST_DIAMETER: f64 = 0.1;
/// Change of the speed within a piece of a facing move.
const STEP: f64 = 1.05;
/// No piece takes fewer samples.
const LEAST_SAMPLES: f64 = 4.0;

impl Translator<'_> {
    /// Step 5: G96, G97, then S.
    pub(crate) fn spindle_speed(&mut self, block: &Block, owner: Option<&GWord>) -> Check<()> {
        if block.g(40).is_none() {
            self.used |= bit(b'S');
        }
        if let Some(g) = block.code_of(Group::SpindleMode) {
            let cutting = g.code.tenths == 960;
            if cutting && self.state.modal.speed_limit.is_none() {
                return Err(Fault::new(Id::GC503, g.span));
            }
            if cutting != self.state.modal.cutting_speed {
                self.state.modal.speed = None;
            }
            self.state.modal.cutting_speed = cutting;
        }
        let Some(word) = block.word(b'S') else { return Ok(()) };
        let most = self.machine.gcode.spindle.limit;
        if owner.is_some_and(|o| o.code.tenths == 920) || block.g(500).is_some() {
            self.state.modal.speed_limit = Some(if most > 0.0 { word.value.min(most) } else { word.value });
            return Ok(());
        }
        if block.m(19).is_some() || block.g(40).is_some() {
            return Ok(());
        }
        if !self.state.modal.cutting_speed && most > 0.0 && word.value > most {
            return Err(Fault::with(Id::GC515, word.span, &[&word.value, &most]));
        }
        if self.state.modal.speed != Some(word.value) {
            self.state.modal.speed = Some(word.value);
            let here = self.state.program;
            self.drive(&here);
        }
        Ok(())
    }

    /// Speed in 1/min at a mean of two program positions: S under G97, by the diameter under G96.
    pub(crate) fn speed_between(&self, from: &Point, to: &Point) -> Option<f64> {
        let modal = &self.state.modal;
        let speed = modal.speed.filter(|s| *s > 0.0)?;
        if !modal.cutting_speed {
            return Some(modal.speed_limit.map_or(speed, |limit| speed.min(limit)));
        }
        let slot = self.group.slot(b'X')?;
        let diameter = (from[slot] + to[slot]).abs().max(LEAST_DIAMETER);
        Some(modal.speed_limit?.min(self.cutting_metres(speed) * 1000.0 / (std::f64::consts::PI * diameter)))
    }
    /// Cutting speed in m/min; feet with inch units.
    fn cutting_metres(&self, speed: f64) -> f64 {
        if self.state.modal.inch { speed * 0.3048 } else { speed }
    }
    /// Speed in 1/min, for feed per revolution.
    pub(crate) fn revolutions(&self, block: &Block) -> Check<f64> {
        if self.state.modal.cutting_speed && self.state.modal.speed_limit.is_none() {
            return Err(Fault::new(Id::GC503, block.span));
        }
        let speed = self.speed_between(&self.state.program, &self.target_program);
        speed.ok_or_else(|| Fault::new(Id::GC505, block.span))
    }

    /// Sends the speed for the way from the present position to `to`.
    pub(crate) fn drive(&mut self, to: &Point) {
        let from = self.state.program;
        let Some(speed) = self.speed_between(&from, to).or(self.state.modal.speed) else { return };
        let (command, value) = match self.machine.gcode.spindle.command {
            Some((axis, full_speed)) => {
                let sense = [1.0, -1.0, 0.0][usize::from(self.state.modal.spindle.clamp(3, 5)) - 3];
                (spool::MOTOR_COMMAND + axis as u16, (sense * speed / full_speed).clamp(-1.0, 1.0) * 32767.0)
            }
            None => (spool::WRITE_CD + self.machine.gcode.speed_cd as u16, speed),
        };
        let value = if command >= spool::WRITE_CD { value } else { value.round() };
        if self.sent != Some(value) {
            self.sent = Some(value);
            self.sink.ssf(self.line, self.first(), command, value, false);
        }
    }
    /// M03, M04, M05 at the motor command port.
    pub(crate) fn direction_changed(&mut self) {
        if self.machine.gcode.spindle.command.is_some() {
            let here = self.state.program;
            self.drive(&here);
        }
    }
    /// The wait behind M03 and M04, where the machine file asks for one.
    pub(crate) fn run_up(&mut self) {
        let seconds = self.machine.gcode.spindle.dwell_s;
        if seconds > 0.0 {
            self.wait(spool::WAIT, (seconds / 64e-6 + 0.5).floor());
        }
    }
    /// G86 and threads: the spindle stands.
    pub(crate) fn spindle_stop(&mut self) {
        let (lines, turning) = (self.machine.gcode.outputs, self.state.modal.spindle);
        self.put_out(Outputs { set: 0, reset: lines.spindle_cw | lines.spindle_ccw });
        self.state.modal.spindle = 5;
        self.direction_changed();
        self.state.modal.spindle = turning;
    }
    pub(crate) fn spindle_again(&mut self) {
        let (lines, mut outputs) = (self.machine.gcode.outputs, Outputs::default());
        match self.state.modal.spindle {
            3 => outputs.turn(lines.spindle_cw, lines.spindle_ccw),
            4 => outputs.turn(lines.spindle_ccw, lines.spindle_cw),
            _ => return,
        }
        self.put_out(outputs);
        self.direction_changed();
        self.run_up();
    }

    /// A feed move under G96: in pieces, so that the speed changes by 5 % at most from one to the next.
    pub(crate) fn facing(&mut self, block: &Block, target: &Target) -> Check<()> {
        let (from, machine) = (self.state.program, self.state.machine);
        let pieces = self.pieces(block, target)?;
        let count = pieces.len() as u64;
        for part in pieces {
            let mut piece = *target;
            if part < 1.0 {
                for slot in 0..self.group.len() {
                    piece.program[slot] = from[slot] + part * (target.program[slot] - from[slot]);
                    piece.machine[slot] = machine[slot] + part * (target.machine[slot] - machine[slot]);
                }
            }
            self.target_program = piece.program;
            self.drive(&piece.program);
            self.line_to(block, &piece, false)?;
        }
        self.facts.motion_blocks = self.facts.motion_blocks.saturating_sub(count - 1);
        Ok(())
    }
    /// Ends of the pieces as parts of the way, the last one 1.
    fn pieces(&self, block: &Block, target: &Target) -> Check<Vec<f64>> {
        let whole = vec![1.0];
        let (modal, Some(slot)) = (&self.state.modal, self.group.slot(b'X')) else { return Ok(whole) };
        let (Some(speed), Some(limit)) = (modal.speed, modal.speed_limit) else { return Ok(whole) };
        if modal.feed_mode == FeedMode::InverseTime || speed <= 0.0 || limit <= 0.0 {
            return Ok(whole);
        }
        let (x0, x1) = (self.state.program[slot], target.program[slot]);
        // below this radius the limit holds
        let least =
            (self.cutting_metres(speed) * 1000.0 / (2.0 * std::f64::consts::PI * limit)).max(LEAST_DIAMETER / 2.0);
        let mut radii = vec![x1];
        for side in [1.0, -1.0] {
            let farthest = (x0 * side).max(x1 * side);
            let mut radius = least;
            while radius < farthest {
                radii.push(side * radius);
                radius *= STEP;
            }
        }
        let mut parts: Vec<f64> = radii.iter().map(|x| (x - x0) / (x1 - x0)).filter(|p| *p > 0.0 && *p < 1.0).collect();
        parts.sort_by(f64::total_cmp);
        parts.push(1.0);
        let lengths = Lengths::of(&self.group, &self.state.machine, &target.machine, None);
        let fastest = self.fastest(limit).ok_or_else(|| Fault::new(Id::GC501, block.span))?;
        let shortest = LEAST_SAMPLES * self.machine.sample_time_s() * fastest / lengths.feed.max(1e-9);
        let mut kept = Vec::new();
        let mut last = 0.0;
        for part in parts {
            if part - last >= shortest && (part == 1.0 || 1.0 - part >= shortest) {
                kept.push(part);
                last = part;
            }
        }
        if kept.last() != Some(&1.0) {
            kept.push(1.0);
        }
        Ok(kept)
    }
    /// Feed in mm/s at the highest speed there is.
    fn fastest(&self, limit: f64) -> Option<f64> {
        let modal = &self.state.modal;
        let feed = modal.feed?.mm / 60.0;
        let feed = if modal.feed_mode == FeedMode::PerRevolution { feed * limit } else { feed };
        Some(feed.min(self.machine.gcode.feed_limit))
    }
}
