//! Threads G33 and tapping G84 (docs/dialect.md, sections 6 and 13): spindle and feed axes in one interpolation.
//!
//! The spindle axis takes part in the straight move, so it turns in step with the feed at every speed and override.
//! It stands under position control meanwhile: what M03 and M04 switch on is off before and on again behind.

use crate::block::{Block, CENTRE_LETTERS, bit};
use crate::codes::Group;
use crate::cycles::Hole;
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::feed::Lengths;
use crate::modal::{FeedMode, Modal};
use crate::motion::NOTHING;
use crate::sink::Motion;
use crate::target::Target;
use crate::translate::Translator;

/// A straight move with the spindle: `turns` in all, signed, in `time` seconds.
#[derive(Clone, Copy, Debug)]
struct Turning {
    spindle: usize,
    turns: f64,
    time: f64,
}

impl Translator<'_> {
    /// Revolutions per minute of a spindle that turns, and its sense: M03 positive.
    fn turning(&self, block: &Block) -> Check<(f64, f64)> {
        let sense = match self.state.modal.spindle {
            3 => 1.0,
            4 => -1.0,
            _ => return Err(Fault::new(Id::GC505, block.span)),
        };
        Ok((self.revolutions(block)?, sense))
    }
    /// The spindle axis must be able to turn at that speed.
    fn check_speed(&self, block: &Block, slot: usize, speed: f64) -> Check<()> {
        let most = self.group.axes[slot].rapid / 6.0;
        if speed > most {
            return Err(Fault::with(Id::GC515, block.span_of(b'S'), &[&speed, &most]));
        }
        Ok(())
    }

    /// G33: a straight move with the lead under I, J or K, in the axis it belongs to.
    pub(crate) fn thread(&mut self, block: &Block) -> Check<()> {
        let target = self.target(block)?;
        self.check_limits(block, &target.machine);
        if self.state.modal.cylinder.is_some() {
            let span = block.code_of(Group::Motion).map_or(block.span, |g| g.span);
            return Err(Fault::with(Id::GC321, span, &[&"G33"]));
        }
        let (slot, lead) = self.lead(block, &target)?;
        let way = (target.program[slot] - self.state.program[slot]).abs();
        let (speed, sense) = self.turning(block)?;
        let turns = way / lead;
        let time = turns / speed * 60.0;
        let Some(spindle) = self.group.spindle else {
            let span = block.code_of(Group::Motion).map_or(block.span, |g| g.span);
            self.faults.push(Fault::new(Id::GW916, span));
            return self.timed_line(block, &target, time, self.machine.gcode.trac_feed);
        };
        self.check_speed(block, spindle, speed)?;
        self.begin_thread();
        self.turn_to(block, target, Turning { spindle, turns: sense * turns, time })
    }
    /// The axis of the lead, and the lead in mm. It stays until another motion function comes.
    fn lead(&mut self, block: &Block, target: &Target) -> Check<(usize, f64)> {
        self.used |= CENTRE_LETTERS;
        let missing = || {
            let span = block.code_of(Group::Motion).map_or(block.span, |g| g.span);
            Fault::with(Id::GC310, span, &[&"G33", &"I, J or K"])
        };
        let Some((letter, word)) = block.first_of(CENTRE_LETTERS) else {
            let (slot, lead) = self.state.modal.lead.ok_or_else(missing)?;
            return if self.moves(slot, target) { Ok((slot, lead)) } else { Err(missing()) };
        };
        if let Some((second, other)) = block.first_of(CENTRE_LETTERS & !bit(letter)) {
            return Err(Fault::with(Id::GC326, other.span, &[&char::from(second)]));
        }
        let slot = self.group.slot(letter - b'I' + b'X').filter(|s| self.moves(*s, target));
        let slot = slot.ok_or_else(|| Fault::with(Id::GC326, word.span, &[&char::from(letter)]))?;
        let lead = self.length(block, letter).unwrap_or(0.0);
        if lead <= 0.0 {
            let range: [&dyn std::fmt::Display; 4] = [&word.value, &char::from(letter), &0, &1e7];
            return Err(Fault::with(Id::GC216, word.span, &range));
        }
        self.state.modal.lead = Some((slot, lead));
        Ok((slot, lead))
    }
    fn moves(&self, slot: usize, target: &Target) -> bool {
        (target.program[slot] - self.state.program[slot]).abs() > NOTHING
    }

    /// The drive of the spindle is off while it stands under position control.
    fn begin_thread(&mut self) {
        if !std::mem::replace(&mut self.threading, true) {
            self.sink.stop();
            self.spindle_stop();
        }
    }
    /// Behind a thread: the path stands, the spindle turns again.
    pub(crate) fn end_thread(&mut self) {
        if std::mem::take(&mut self.threading) {
            self.sink.stop();
            self.spindle_again();
        }
    }

    /// The straight move with its turns of the spindle.
    fn turn_to(&mut self, block: &Block, mut target: Target, turning: Turning) -> Check<()> {
        let Turning { spindle, turns, mut time } = turning;
        let feed = Lengths::of(&self.group, &self.state.machine, &target.machine, None).path;
        let (limit, wanted) = (self.machine.gcode.feed_limit, feed / time);
        if wanted > limit {
            self.limited(block, wanted * 60.0, wanted, limit);
            time = feed / limit;
        }
        target.machine[spindle] = self.state.machine[spindle] + 360.0 * turns;
        target.program[spindle] = self.state.program[spindle] + 360.0 * turns;
        let path = self.group.distance(&self.state.machine, &target.machine);
        let axis = &self.machine.axes[self.group.axes[spindle].axis];
        let by_spindle = axis.acceleration * path / (360.0 * turns).abs();
        let ac = by_spindle.min(self.machine.gcode.trac_feed * path / feed);
        self.timed_line(block, &target, time, ac)
    }
    /// A straight move that takes a given time.
    fn timed_line(&mut self, block: &Block, target: &Target, time: f64, ac: f64) -> Check<()> {
        let length = self.group.distance(&self.state.machine, &target.machine);
        self.state.program = target.program;
        if length < NOTHING {
            return Ok(());
        }
        self.facts.motion_blocks += 1;
        let motion = Motion {
            line: self.line,
            span: self.place(block),
            rapid: false,
            exact: self.state.modal.exact || block.g(90).is_some(),
            target: target.machine,
            circle: None,
            length,
            vl: length / time,
            ac,
            end_vl: f64::INFINITY,
            tolerance: self.state.modal.tolerance,
            slack: 0.0,
        };
        self.sink.motion(motion, block.span)?;
        self.state.machine = target.machine;
        Ok(())
    }

    /// The way down and up of G84. The lead is F under G95, else F / S.
    pub(crate) fn tap(&mut self, block: &Block, hole: &Hole) -> Check<()> {
        let (speed, sense) = self.turning(block)?;
        let feed = self.state.modal.feed.ok_or_else(|| Fault::new(Id::GC501, block.span))?;
        let lead = if self.state.modal.feed_mode == FeedMode::PerRevolution { feed.mm } else { feed.mm / speed };
        let span = Span { ..block.span };
        let Some(spindle) = self.group.spindle else { return self.floating_tap(block, hole, span) };
        self.check_speed(block, spindle, speed)?;
        let turns = sense * (hole.retract - hole.bottom) / lead;
        let time = turns.abs() / speed * 60.0;
        self.begin_thread();
        for (level, turns) in [(hole.bottom, turns), (hole.retract, -turns)] {
            let target = self.level(block, hole, level);
            self.turn_to(block, target, Turning { spindle, turns, time })?;
            self.sink.stop();
            if level == hole.bottom && hole.words.dwell_s > 0.0 {
                self.wait_seconds(hole.words.dwell_s, span)?;
            }
        }
        self.end_thread();
        Ok(())
    }
    /// Without a spindle axis: feed down, the spindle reversed, feed up, the spindle as before.
    fn floating_tap(&mut self, block: &Block, hole: &Hole, span: Span) -> Check<()> {
        let code = block.code_of(Group::Motion).map_or(block.span, |g| g.span);
        self.faults.push(Fault::new(Id::GW919, code));
        let before = self.state.modal.spindle;
        let reversed = 7 - before; // 3 and 4
        self.depth(block, hole, hole.bottom, false)?;
        self.reverse(reversed);
        if hole.words.dwell_s > 0.0 {
            self.wait_seconds(hole.words.dwell_s, span)?;
        }
        self.depth(block, hole, hole.retract, false)?;
        self.reverse(before);
        Ok(())
    }
    fn reverse(&mut self, direction: u16) {
        self.sink.stop();
        let modal = Modal { spindle: direction, ..self.state.modal };
        self.state.modal = modal;
        self.spindle_again();
    }
    /// Refused before anything moves: a peck depth.
    pub(crate) fn check_tapping(&self, block: &Block) -> Check<()> {
        match block.word(b'Q') {
            Some(word) => Err(Fault::with(Id::GC326, word.span, &[&'Q'])),
            None => Ok(()),
        }
    }
}
