//! Motions of a block: targets, lines, arcs, limits (docs/dialect.md, sections 7, 10, 17).

use crate::aftermath::is_about_ends;
use crate::arc::{self, Arc, Ends};
use crate::block::{AXIS_LETTERS, Block, CENTRE_LETTERS, GWord, bit, mask};
use crate::codes::Group;
use crate::cylinder::ArcPlane;
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::dialect::ArcCentre;
use crate::feed::Lengths;
use crate::group::Point;
use crate::modal::{CycleWords, MotionMode};
use crate::sink::{Circle, Motion};
use crate::target::Target;
use crate::translate::Translator;

/// Shorter moves are no motion: far below a count, far above rounding.
pub(crate) const NOTHING: f64 = 1e-9;

impl Translator<'_> {
    /// GC413 for every axis outside its limits; the program is read on as if it had got there.
    #[inline]
    pub(crate) fn check_limits(&mut self, block: &Block, point: &Point) {
        let corrected = self.sink.is_displaced();
        for (slot, axis) in self.group.axes.iter().enumerate() {
            if corrected && self.sink.plane.contains(&slot) {
                continue;
            }
            let value = point[slot];
            self.facts.low[slot] = self.facts.low[slot].min(value);
            self.facts.high[slot] = self.facts.high[slot].max(value);
            if let Some((low, high)) = axis.limits
                && !(value >= low - NOTHING && value <= high + NOTHING)
                && self.state.unknown & 1 << slot == 0
                && (block.has(axis.letter) || value != self.state.machine[slot] || value == self.group.start[slot])
            {
                // an axis that only stays outside was reported before; a cycle may go outside with every peck
                let (letter, span) = (char::from(axis.letter), block.span_of(axis.letter));
                let fault = outside(letter, value, (low, high), "", span);
                if self.faults.iter().all(|f| (f.id, f.span) != (fault.id, span)) {
                    self.faults.push(fault);
                }
            }
        }
    }

    pub(crate) fn set_motion(&mut self, g: &GWord) {
        let mode = match g.code.tenths {
            0 => MotionMode::Rapid,
            10 => MotionMode::Line,
            20 => MotionMode::Clockwise,
            30 => MotionMode::CounterClockwise,
            800 if self.dialect.cycles_apart => self.state.modal.simple_motion,
            330 => MotionMode::Thread,
            800 => MotionMode::None,
            code => MotionMode::Cycle(code),
        };
        if !matches!(mode, MotionMode::Cycle(_) | MotionMode::None) {
            self.state.modal.simple_motion = mode;
        }
        if mode != self.state.modal.motion {
            self.end_thread();
            self.state.modal.lead = None;
            self.state.modal.motion = mode;
            // from cycle to cycle only the initial level stays
            let kept = self.state.cycle.filter(|_| matches!(mode, MotionMode::Cycle(_)));
            self.state.cycle = kept.map(|c| CycleWords { initial: c.initial, ..CycleWords::default() });
        }
    }

    /// Step 19: motion or cycle. `machine_block`: G53 with axis words.
    #[inline]
    pub(crate) fn motion_step(&mut self, block: &Block, machine_block: Option<&GWord>) -> Check<()> {
        if let Some(g) = block.code_of(Group::Motion) {
            self.set_motion(g);
        }
        if let Some(g53) = machine_block {
            return self.machine_coordinates(block, g53);
        }
        let axes = block.has_any(AXIS_LETTERS);
        match self.state.modal.motion {
            MotionMode::Rapid | MotionMode::Line if axes => self.straight(block),
            MotionMode::Clockwise | MotionMode::CounterClockwise
                if axes || block.has_any((CENTRE_LETTERS | bit(b'R')) & !self.used) =>
            {
                self.circular(block)
            }
            MotionMode::Thread if axes => self.thread(block),
            MotionMode::Cycle(code) if axes || block.has_group(Group::Motion) => self.cycle(block, code),
            MotionMode::Unknown => self.pass_over(block),
            MotionMode::None if axes => Err(Fault::new(Id::GC319, block.span)),
            MotionMode::Rapid => {
                if let Some(g) = block.g(0) {
                    self.faults.push(Fault::new(Id::GW933, g.span));
                }
                self.without_motion(block)
            }
            _ => self.without_motion(block),
        }
    }
    fn without_motion(&mut self, block: &Block) -> Check<()> {
        if let Some(g) = block.g(90) {
            self.faults.push(Fault::new(Id::GW915, g.span));
        }
        Ok(())
    }
    fn straight(&mut self, block: &Block) -> Check<()> {
        let target = self.target(block)?;
        self.check_limits(block, &target.machine);
        let rapid = self.state.modal.motion == MotionMode::Rapid;
        if self.state.modal.cutting_speed {
            if !rapid {
                return self.facing(block, &target);
            }
            // the speed is that of the place where the rapid ends
            let before = std::mem::replace(&mut self.state.program, target.program);
            self.drive(&target.program);
            self.state.program = before;
        }
        self.line_to(block, &target, rapid)
    }
    /// G53 with axis words: one block in machine coordinates.
    fn machine_coordinates(&mut self, block: &Block, g53: &GWord) -> Check<()> {
        if !matches!(self.state.modal.motion, MotionMode::Rapid | MotionMode::Line) {
            return Err(Fault::new(Id::GC314, g53.span));
        }
        if self.state.modal.incremental {
            return Err(Fault::new(Id::GC315, g53.span));
        }
        let mut target = self.target(block)?;
        let mut letters = block.mask & AXIS_LETTERS;
        target.machine = self.state.machine;
        while letters != 0 {
            let letter = b'A' + letters.trailing_zeros() as u8;
            letters &= letters - 1;
            let (slot, _) = self.slot_of(block, letter)?;
            target.machine[slot] = self.coordinate(block, letter, slot);
        }
        target.program = self.state.frame.to_program(&target.machine);
        self.check_limits(block, &target.machine);
        self.line_to(block, &target, self.state.modal.motion == MotionMode::Rapid)
    }

    /// A straight move to a resolved target.
    #[inline]
    pub(crate) fn line_to(&mut self, block: &Block, target: &Target, rapid: bool) -> Check<()> {
        self.lint_line(block, target, rapid);
        let lengths = Lengths::of(&self.group, &self.state.machine, &target.machine, None);
        let vl = if rapid || lengths.path < NOTHING { 0.0 } else { self.path_speed(block, &lengths)? };
        self.state.program = target.program;
        if lengths.path < NOTHING {
            if !rapid && self.state.modal.feed.is_none() {
                return Err(Fault::new(Id::GC501, block.span));
            }
            return Ok(());
        }
        let end_vl = if rapid { f64::INFINITY } else { self.end_speed(block, vl)? };
        let gcode = &self.machine.gcode;
        let (vl, ac) = if rapid {
            (self.group.rapid_speed(&self.state.machine, &target.machine, lengths.path), gcode.trac_rapid)
        } else {
            (vl, gcode.trac_feed)
        };
        self.facts.motion_blocks += 1;
        let motion = Motion {
            line: self.line,
            span: self.place(block),
            rapid,
            exact: self.state.modal.exact || block.groups & Group::Nothing.bit() != 0 && block.g(90).is_some(),
            target: target.machine,
            circle: None,
            length: lengths.path,
            vl,
            ac,
            end_vl,
            tolerance: self.state.modal.tolerance,
            slack: 0.0,
        };
        self.sink.motion(motion, block.span)?;
        self.state.machine = target.machine;
        Ok(())
    }

    fn circular(&mut self, block: &Block) -> Check<()> {
        let plane = self.arc_plane(block)?;
        let slots = plane.slots;
        if let Some((_, word)) = block.first_of(AXIS_LETTERS & mask("ABC") & !self.surface_letter()) {
            return Err(Fault::new(Id::GC418, word.span));
        }
        let known = self.state.unknown & (1 << slots[0] | 1 << slots[1]) == 0;
        let target = self.target(block)?;
        let arc = self.arc(block, &plane, &target);
        if !known && !self.state.modal.incremental {
            // it began where it should, or the next one will
            self.state.unknown &= !(1 << slots[0] | 1 << slots[1]);
        }
        match arc {
            Ok(arc) => self.arc_to(block, &plane, target, &arc),
            Err(fault) => {
                // the program is read on as if it had got there
                let by_ends = is_about_ends(fault.id);
                // a start in doubt is not where the program means it to be
                if known || !by_ends {
                    self.faults.push(fault);
                }
                if self.state.modal.feed.is_none() {
                    self.faults.push(Fault::new(Id::GC501, block.span));
                }
                self.sink.tracking = None;
                (self.state.program, self.state.machine) = (target.program, target.machine);
                if known && by_ends {
                    self.state.unknown |= target.named;
                }
                Ok(())
            }
        }
    }
    /// Geometry of the arc in program coordinates, mm.
    fn arc(&mut self, block: &Block, plane: &ArcPlane, target: &Target) -> Check<Arc> {
        self.used |= CENTRE_LETTERS | mask("RP");
        let turns = match block.word(b'P') {
            Some(p) if p.value < 1.0 || p.value.fract() != 0.0 || p.value > 1e6 => {
                return Err(Fault::new(Id::GC407, p.span));
            }
            Some(p) => p.value as u32,
            None => 1,
        };
        let start = plane.in_mm(&self.state.program);
        let end = plane.in_mm(&target.program);
        let counter_clockwise = self.state.modal.motion == MotionMode::CounterClockwise;
        let ends = Ends { start, end, counter_clockwise, turns, span: block.span };
        let (letters, third) = (plane.centres, plane.third);
        if let Some(word) = block.word(third) {
            if word.value != 0.0 {
                let args: [&dyn std::fmt::Display; 2] = [&char::from(third), &self.state.modal.plane.g()];
                return Err(Fault::with(Id::GC404, word.span, &args));
            }
            self.faults.push(Fault::with(Id::GW920, word.span, &[&char::from(third)]));
        }
        let has_centre = block.has(letters[0]) || block.has(letters[1]);
        if let Some(radius) = self.length(block, b'R') {
            if has_centre {
                let first = block.first_of(CENTRE_LETTERS).map_or('I', |w| char::from(w.0));
                return Err(Fault::with(Id::GC405, block.span_of(b'R'), &[&first]));
            }
            return arc::by_radius(&ends, radius, block.span_of(b'R'), &mut self.faults);
        }
        if !has_centre {
            return Err(Fault::new(Id::GC406, block.span));
        }
        let words = letters.map(|l| self.length(block, l));
        let relative = [0, 1].map(|i| start[i] + words[i].unwrap_or(0.0));
        let absolute = [0, 1].map(|i| words[i].unwrap_or(0.0));
        let (centre, other) = if self.centre_is_absolute() { (absolute, relative) } else { (relative, absolute) };
        arc::by_centre(&ends, centre, other, &mut self.faults)
    }
    fn centre_is_absolute(&self) -> bool {
        let by_dialect = match self.dialect.arc_centre {
            ArcCentre::Incremental => false,
            ArcCentre::Absolute => true,
            ArcCentre::LikeController => self.machine.gcode.modereg & 1 << 12 == 0 && !self.state.modal.incremental,
        };
        self.state.modal.centre_absolute.unwrap_or(by_dialect)
    }

    /// The motion command of an arc.
    fn arc_to(&mut self, block: &Block, plane: &ArcPlane, mut target: Target, arc: &Arc) -> Check<()> {
        let slots = plane.slots;
        let reverses = self.state.frame.reverses(slots).ok_or_else(|| Fault::new(Id::GC412, block.span))?;
        let mut centre = self.state.program;
        let closed = arc.end == plane.in_mm(&self.state.program);
        for i in 0..2 {
            centre[slots[i]] = arc.centre[i] / plane.metric[i];
            if closed {
                target.program[slots[i]] = self.state.program[slots[i]];
            }
        }
        if self.state.frame.is_plain() {
            for slot in slots {
                centre[slot] += self.state.frame.shift()[slot];
                if closed {
                    target.machine[slot] = self.state.machine[slot];
                }
            }
        } else {
            centre = self.state.frame.to_machine(&centre);
            target.machine = self.state.frame.to_machine(&target.program);
        }
        let (start, middle) = (plane.in_mm(&self.state.machine), plane.in_mm(&centre));
        let sweep = if reverses { -arc.sweep } else { arc.sweep };
        let radius = (start[0] - middle[0]).hypot(start[1] - middle[1]);
        let circle = Circle { slots, centre: slots.map(|s| centre[s]), sweep, radius };
        self.check_limits(block, &target.machine);
        let bounds = arc::bounds(start, middle, sweep, plane.in_mm(&target.machine));
        let bounds = [0, 1].map(|i| (bounds[i].0 / plane.metric[i], bounds[i].1 / plane.metric[i]));
        self.check_extremes(block, slots, bounds, slots.map(|s| target.machine[s]));
        self.circle_to(block, &target, circle)
    }
    fn circle_to(&mut self, block: &Block, target: &Target, circle: Circle) -> Check<()> {
        self.lint_arc(block, &circle);
        if self.state.modal.cutting_speed {
            self.drive(&target.program);
        }
        let lengths = Lengths::of(&self.group, &self.state.machine, &target.machine, Some(&circle));
        let vl = self.path_speed(block, &lengths)?;
        let mut motion = Motion {
            line: self.line,
            span: self.place(block),
            rapid: false,
            exact: self.state.modal.exact || block.g(90).is_some(),
            target: target.machine,
            circle: Some(circle),
            length: lengths.path,
            vl,
            ac: self.machine.gcode.trac_feed,
            end_vl: self.end_speed(block, vl)?,
            tolerance: self.state.modal.tolerance,
            slack: 0.0,
        };
        let sagitta = circle.radius * (1.0 - (0.5 * circle.sweep.to_radians()).cos());
        let short = lengths.path < 1.6 * self.machine.sample_time_s() * vl;
        if short && !self.sink.is_displaced() && circle.sweep.abs() < 180.0 && sagitta <= motion.tolerance {
            let chord = self.group.distance(&self.state.machine, &target.machine);
            motion = Motion { circle: None, length: chord, slack: sagitta, ..motion };
        }
        self.facts.motion_blocks += 1;
        if motion.length >= NOTHING {
            self.sink.motion(motion, block.span)?;
            self.state.machine = target.machine;
        }
        self.state.program = target.program;
        Ok(())
    }
    /// GC413 for the points of an arc that lie farthest out.
    fn check_extremes(&mut self, block: &Block, slots: [usize; 2], bounds: [(f64, f64); 2], end: [f64; 2]) {
        if self.sink.is_displaced() {
            return;
        }
        for (i, slot) in slots.into_iter().enumerate() {
            let (low, high) = bounds[i];
            self.facts.low[slot] = self.facts.low[slot].min(low);
            self.facts.high[slot] = self.facts.high[slot].max(high);
            let axis = &self.group.axes[slot];
            let Some((least, most)) = axis.limits else { continue };
            let inside = |v: f64| v >= least - NOTHING && v <= most + NOTHING;
            if self.state.unknown & (1 << slots[0] | 1 << slots[1]) != 0 || !inside(end[i]) {
                continue;
            }
            if let Some(worst) = [low, high].into_iter().find(|v| !inside(*v)) {
                let letter = char::from(axis.letter);
                self.faults.push(outside(letter, worst, (least, most), " (arc extreme)", block.span));
            }
        }
    }
}

pub(crate) fn outside(letter: char, value: f64, (low, high): (f64, f64), note: &str, span: Span) -> Fault {
    let value = format!("{value:.4}");
    let value = value.trim_end_matches('0').trim_end_matches('.');
    Fault::with(Id::GC413, span, &[&letter, &value, &low, &high, &note])
}
