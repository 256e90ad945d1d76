//! A block and the modal state -> commands, in the order of docs/dialect.md, section 14.

use motion_kernel::machine::Machine;

use crate::arc::{self, Arc, Ends};
use crate::block::{AXIS_LETTERS, Block, CENTRE_LETTERS, GWord, bit, mask};
use crate::codes::{Group, number};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::dialect::{ArcCentre, Dialect, Options};
use crate::facts::Facts;
use crate::feed::Lengths;
use crate::frame::{Frame, Zero};
use crate::group::{ContourGroup, Point, SLOTS};
use crate::modal::{FeedMode, Modal, MotionMode, Plane, State};
use crate::sink::{Circle, Motion, Sink};

/// What the block asks of the program flow, after its motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Flow {
    Next,
    /// M02, M30
    End,
    /// M17, M29, M99, with the block number of `M99 P`.
    Return(Option<(u32, Span)>),
    Call(Call),
}

/// A subprogram call.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    pub name: String,
    pub count: u32,
    /// G65: its arguments as #n; `None` shares the variables with the caller.
    pub arguments: Option<Vec<(usize, f64)>>,
    pub span: Span,
}

pub struct Translator<'a> {
    pub machine: &'a Machine,
    pub options: &'a Options,
    pub dialect: Dialect,
    pub group: ContourGroup,
    pub state: State,
    pub sink: Sink,
    pub facts: Facts,
    /// Findings of the present block.
    pub faults: Vec<Box<Fault>>,
    /// Source line that commands are tagged with.
    pub line: u32,
    pub(crate) limited_feed: Option<f64>,
    pub(crate) target_program: Point,
    /// Letters of the present block that have found a use (GC326).
    pub(crate) used: u32,
    /// Tool lengths that G10 has set.
    pub(crate) tool_lengths: std::collections::HashMap<u32, f64>,
    modal_shown: Option<(Modal, Zero)>,
}

/// A resolved target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub program: Point,
    pub machine: Point,
    /// Slots that the block names.
    pub named: u32,
}

const FAST_LETTERS: u32 = AXIS_LETTERS | CENTRE_LETTERS | mask("FNRP");
/// Shorter moves are no motion: far below a count, far above rounding.
const NOTHING: f64 = 1e-9;

impl<'a> Translator<'a> {
    pub fn new(machine: &'a Machine, options: &'a Options) -> Self {
        let dialect = Dialect::new(machine, options);
        let group = ContourGroup::new(machine);
        let mut work = [[0.0; SLOTS]; 6];
        for (set, offsets) in work.iter_mut().zip(&machine.gcode.offsets) {
            for (slot, axis) in group.axes.iter().enumerate() {
                set[slot] = offsets.get(axis.axis).copied().unwrap_or(0.0);
            }
        }
        let modal = Modal::reset(dialect.lathe, machine.gcode.merge_tolerance);
        let state = State::new(&group, Frame::new(work), modal);
        let keep = !options.check_only;
        let sample = machine.sample_time_s();
        let sink = Sink::new(&group, machine.gcode.start_fill, sample, dialect.look_ahead, keep);
        let facts = Facts::new(&group.start);
        Translator {
            machine,
            options,
            dialect,
            state,
            sink,
            facts,
            faults: Vec::new(),
            line: 0,
            limited_feed: None,
            target_program: group.start,
            used: 0,
            tool_lengths: std::collections::HashMap::new(),
            modal_shown: None,
            group,
        }
    }

    /// Read, check, commit: after an `Err` the modal state is that of before.
    #[inline]
    pub fn execute(&mut self, block: &Block) -> Check<Flow> {
        self.facts.blocks += 1;
        let plain = block.groups & !Group::Motion.bit() == 0 && block.mask & !FAST_LETTERS == 0;
        let cycle = matches!(self.state.modal.motion, MotionMode::Cycle(_));
        let special = !block.m.is_empty() || block.message.is_some() || !block.assignments.is_empty();
        if plain && !special && !cycle && block.call_name.is_none() && block.statement.is_none() {
            let before = self.state.modal;
            let found = self.faults.len();
            self.used = bit(b'F') | bit(b'N');
            let result = self.feed_word(block).and_then(|()| self.motion_step(block, None));
            let result = result.and_then(|()| self.check_unused(block));
            if result.is_err() || self.has_errors(found) {
                self.state.modal = before;
            }
            return result.map(|()| Flow::Next);
        }
        self.execute_any(block)
    }
    /// Errors among the findings since `from`.
    fn has_errors(&self, from: usize) -> bool {
        self.faults[from..].iter().any(|f| !f.id.is_warning())
    }
    fn execute_any(&mut self, block: &Block) -> Check<Flow> {
        let before = self.state.clone();
        let found = self.faults.len();
        let result = self.steps(block);
        if result.is_err() || self.has_errors(found) {
            let (program, machine) = (self.state.program, self.state.machine);
            self.state = before;
            if result.is_ok() {
                // only a limit was passed: the program goes on from where it meant to be
                (self.state.machine, self.state.program) = (machine, program);
                self.state.program = self.state.frame.to_program(&machine);
            }
        }
        result
    }

    /// Section 14, top to bottom.
    fn steps(&mut self, block: &Block) -> Check<Flow> {
        self.used = bit(b'N');
        let owner = self.axis_owner(block)?;
        self.sink.flush();
        self.message(block);
        self.unit_and_feed(block)?;
        self.spindle_speed(block, owner.as_ref())?;
        self.tool_and_outputs_before(block)?;
        self.dwell(block)?;
        self.modes(block, owner.as_ref())?;
        self.offsets_step(block, owner.as_ref())?;
        let moves = owner.is_none_or(|o| o.code.tenths == 530);
        if moves {
            self.motion_step(block, owner.as_ref())?;
        } else if let Some(code) = block.code_of(Group::Motion) {
            self.set_motion(code);
        }
        self.outputs_after(block)?;
        let flow = self.flow_step(block)?;
        self.check_unused(block)?;
        self.show_modal();
        Ok(flow)
    }

    /// Which code takes the axis words of the block; `None`: the motion.
    fn axis_owner(&mut self, block: &Block) -> Check<Option<GWord>> {
        let has_axes = block.has_any(AXIS_LETTERS);
        let takes = |g: &&GWord| match g.code.tenths {
            40 | 100 | 280 | 300 | 520 | 650 | 680 | 740 | 920 | 71 | 1070 | 511 => true,
            500 | 501 | 510 | 530 => has_axes,
            _ => false,
        };
        let mut takers = block.g.iter().filter(takes);
        let Some(first) = takers.next().copied() else { return Ok(None) };
        let name = |g: &GWord| format!("G{}", number(g.code.tenths));
        if first.code.tenths == 40 || block.g(40).is_some() {
            return self.check_dwell_block(block).map(|()| Some(first));
        }
        if let Some(second) = takers.next() {
            return Err(Fault::with(Id::GC303, second.span, &[&name(&first), &name(second)]));
        }
        let motion = block.code_of(Group::Motion).filter(|g| g.code.tenths != 800 && g.code.tenths != 0);
        if let Some(motion) = motion.filter(|_| first.code.tenths != 530 && has_axes) {
            let (one, two) = if motion.span.start < first.span.start { (*motion, first) } else { (first, *motion) };
            return Err(Fault::with(Id::GC303, two.span, &[&name(&one), &name(&two)]));
        }
        Ok(Some(first))
    }

    fn unit_and_feed(&mut self, block: &Block) -> Check<()> {
        if let Some(g) = block.code_of(Group::Unit) {
            if matches!(g.code.tenths, 700 | 710) && block.has_any(mask("PQUWDR")) {
                return Err(Fault::with(Id::GC317, g.span, &[&number(g.code.tenths)]));
            }
            self.state.modal.inch = matches!(g.code.tenths, 200 | 700);
        }
        if let Some(g) = block.code_of(Group::FeedMode) {
            let mode = match g.code.tenths {
                930 => FeedMode::InverseTime,
                940 => FeedMode::PerMinute,
                _ => FeedMode::PerRevolution,
            };
            if mode != self.state.modal.feed_mode {
                self.state.modal.feed_mode = mode;
                self.state.modal.feed = None;
            }
        }
        if block.g(40).is_none() {
            self.used |= bit(b'F');
            self.feed_word(block)?;
        }
        Ok(())
    }

    /// Plane, corrections, zero offset, path mode, dimensions.
    fn modes(&mut self, block: &Block, owner: Option<&GWord>) -> Check<()> {
        if let Some(g) = block.code_of(Group::Plane) {
            self.set_plane(g)?;
        }
        self.radius_correction(block)?;
        self.length_correction(block)?;
        self.zero_offset(block, owner)?;
        self.path_mode(block)?;
        if let Some(g) = block.code_of(Group::Distance) {
            self.state.modal.incremental = g.code.tenths == 910;
        }
        if let Some(g) = block.code_of(Group::ArcCentre) {
            self.state.modal.centre_absolute = Some(g.code.tenths == 901);
        }
        if let Some(g) = block.code_of(Group::CycleReturn) {
            self.state.modal.return_to_r = g.code.tenths == 990;
        }
        Ok(())
    }
    fn set_plane(&mut self, g: &GWord) -> Check<()> {
        let plane = match g.code.tenths {
            170 => Plane::Xy,
            180 => Plane::Zx,
            _ => Plane::Yz,
        };
        if plane != self.state.modal.plane {
            let mode = match (self.state.frame.rotation, self.state.modal.motion) {
                (Some(_), _) => "G68 is active",
                (None, MotionMode::Cycle(_)) => "a cycle is active",
                _ => "",
            };
            if !mode.is_empty() {
                return Err(Fault::with(Id::GC328, g.span, &[&mode]));
            }
        }
        self.state.modal.plane = plane;
        Ok(())
    }
    fn radius_correction(&mut self, block: &Block) -> Check<()> {
        let Some(g) = block.code_of(Group::RadiusCorrection) else { return Ok(()) };
        if g.code.tenths == 400 {
            self.state.modal.correction = 40;
            return Ok(());
        }
        self.used |= bit(b'D');
        let number_ = block.integer(b'D').unwrap_or(self.state.modal.in_spindle);
        let radius = self.machine.gcode.tools.iter().find(|t| t.number == number_).map(|t| t.radius);
        match radius {
            _ if number_ == 0 => {}
            None => return Err(Fault::with(Id::GC509, block.word(b'D').map_or(g.span, |w| w.span), &[&number_])),
            Some(0.0) => {}
            Some(_) => return Err(Fault::with(Id::GC312, g.span, &[&number(g.code.tenths)])),
        }
        self.state.modal.correction = g.code.tenths / 10;
        self.faults.push(Fault::new(Id::GW917, g.span));
        Ok(())
    }
    fn length_correction(&mut self, block: &Block) -> Check<()> {
        let Some(g) = block.code_of(Group::LengthCorrection) else { return Ok(()) };
        let mut length = 0.0;
        if g.code.tenths != 490 {
            self.used |= bit(b'H');
            let number = block.integer(b'H').unwrap_or(self.state.modal.in_spindle);
            let tool = self.machine.gcode.tools.iter().find(|t| t.number == number);
            let missing = || Fault::with(Id::GC509, block.word(b'H').map_or(g.span, |w| w.span), &[&number]);
            length = if number == 0 {
                0.0
            } else {
                self.tool_length(number).or(tool.map(|t| t.length)).ok_or_else(missing)?
            };
        }
        let normal = self.state.modal.plane.letters().1;
        let signed = if g.code.tenths == 440 { -length } else { length };
        self.state.frame.length = match self.group.slot(normal) {
            _ if g.code.tenths == 490 => None,
            Some(slot) => Some((slot, signed)),
            None if signed == 0.0 => None,
            None => return Err(Fault::with(Id::GC801, g.span, &[&char::from(normal)])),
        };
        self.state.reframe();
        Ok(())
    }
    fn path_mode(&mut self, block: &Block) -> Check<()> {
        let Some(g) = block.code_of(Group::PathMode) else { return Ok(()) };
        self.state.modal.exact = g.code.tenths != 640;
        if g.code.tenths == 640 {
            self.used |= mask("PQ");
            let word = block.value(b'P').map(|p| p * self.state.modal.unit());
            if word.is_some_and(|p| p < 0.0) {
                let args: [&dyn std::fmt::Display; 4] = [&block.value(b'P').unwrap_or(0.0), &'P', &0, &1e7];
                return Err(Fault::with(Id::GC216, block.span_of(b'P'), &args));
            }
            self.state.modal.tolerance = word.unwrap_or(self.machine.gcode.merge_tolerance);
            if let Some(q) = block.word(b'Q') {
                self.faults.push(Fault::new(Id::GW918, q.span));
            }
        }
        Ok(())
    }

    /// A length word in mm.
    pub(crate) fn length(&self, block: &Block, letter: u8) -> Option<f64> {
        block.word(letter).map(|w| self.increments(w.value, w.integer_form) * self.state.modal.unit())
    }
    /// Numbers without point are least increments, if the dialect says so.
    #[inline]
    pub(crate) fn increments(&self, value: f64, integer_form: bool) -> f64 {
        if integer_form && self.dialect.integer_increment > 0.0 {
            value * self.dialect.integer_increment
        } else {
            value
        }
    }
    /// An axis word as a program coordinate: mm or degrees.
    #[inline]
    pub(crate) fn coordinate(&self, block: &Block, letter: u8, slot: usize) -> f64 {
        let Some(word) = block.word(letter) else { return 0.0 };
        let value = self.increments(word.value, word.integer_form);
        if self.group.axes[slot].rotary {
            return value;
        }
        let value = value * self.state.modal.unit();
        if self.dialect.diameter && matches!(letter, b'X' | b'U') { value * 0.5 } else { value }
    }
    /// The slot of an axis word, and whether it is an incremental U V W.
    #[inline]
    pub(crate) fn slot_of(&self, block: &Block, letter: u8) -> Check<(usize, bool)> {
        if let Some(slot) = self.group.slot(letter) {
            return Ok((slot, false));
        }
        let main = letter.wrapping_sub(b'U').wrapping_add(b'X');
        if self.dialect.uvw_incremental && matches!(letter, b'U' | b'V' | b'W') {
            if let Some(slot) = self.group.slot(main) {
                return Ok((slot, true));
            }
        }
        Err(Fault::with(Id::GC801, block.span_of(letter), &[&char::from(letter)]))
    }

    /// The target that the axis words name.
    #[inline]
    pub(crate) fn target(&mut self, block: &Block) -> Check<Target> {
        let mut target = Target { program: self.state.program, machine: self.state.machine, named: 0 };
        let plain = self.state.frame.is_plain();
        let mut letters = block.mask & AXIS_LETTERS;
        while letters != 0 {
            let letter = b'A' + letters.trailing_zeros() as u8;
            letters &= letters - 1;
            let (slot, relative) = self.slot_of(block, letter)?;
            let value = self.coordinate(block, letter, slot);
            if self.state.modal.incremental || relative {
                target.program[slot] += value;
                target.machine[slot] += value;
            } else {
                target.program[slot] = value;
                target.machine[slot] = value + self.state.frame.shift()[slot];
                self.state.unknown &= !(1 << slot);
            }
            target.named |= 1 << slot;
        }
        if !plain {
            target.machine = self.state.frame.to_machine(&target.program);
        }
        self.used |= AXIS_LETTERS;
        self.target_program = target.program;
        Ok(target)
    }

    /// GC413 for every axis outside its limits; the program is read on as if it had got there.
    #[inline]
    pub(crate) fn check_limits(&mut self, block: &Block, point: &Point) {
        for (slot, axis) in self.group.axes.iter().enumerate() {
            let value = point[slot];
            self.facts.low[slot] = self.facts.low[slot].min(value);
            self.facts.high[slot] = self.facts.high[slot].max(value);
            if let Some((low, high)) = axis.limits
                && !(value >= low - NOTHING && value <= high + NOTHING)
                && self.state.unknown & 1 << slot == 0
            {
                let (letter, span) = (char::from(axis.letter), block.span_of(axis.letter));
                self.faults.push(outside(letter, value, (low, high), "", span));
            }
        }
    }

    fn set_motion(&mut self, g: &GWord) {
        let mode = match g.code.tenths {
            0 => MotionMode::Rapid,
            10 => MotionMode::Line,
            20 => MotionMode::Clockwise,
            30 => MotionMode::CounterClockwise,
            800 => MotionMode::None,
            code => MotionMode::Cycle(code),
        };
        if mode != self.state.modal.motion {
            self.state.modal.motion = mode;
            self.state.cycle = None;
        }
    }

    /// Step 19: motion or cycle. `machine_block`: G53 with axis words.
    #[inline]
    fn motion_step(&mut self, block: &Block, machine_block: Option<&GWord>) -> Check<()> {
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
                if axes || block.has_any(CENTRE_LETTERS | bit(b'R')) =>
            {
                self.circular(block)
            }
            MotionMode::Cycle(code) if axes || block.has_group(Group::Motion) => self.cycle(block, code),
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
        self.line_to(block, &target, self.state.modal.motion == MotionMode::Rapid)
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
        let lengths = Lengths::of(&self.group, &self.state.machine, &target.machine, None);
        let vl = if rapid || lengths.path < NOTHING { 0.0 } else { self.path_speed(block, &lengths)? };
        self.state.program = target.program;
        if lengths.path < NOTHING {
            if !rapid && self.state.modal.feed.is_none() {
                return Err(Fault::new(Id::GC501, block.span));
            }
            return Ok(());
        }
        let gcode = &self.machine.gcode;
        let (vl, ac) = if rapid {
            (self.rapid_speed(&target.machine, lengths.path), gcode.trac_rapid)
        } else {
            (vl, gcode.trac_feed)
        };
        self.facts.motion_blocks += 1;
        self.sink.motion(Motion {
            line: self.line,
            rapid,
            exact: self.state.modal.exact || block.groups & Group::Nothing.bit() != 0 && block.g(90).is_some(),
            target: target.machine,
            circle: None,
            length: lengths.path,
            vl,
            ac,
            tolerance: self.state.modal.tolerance,
            slack: 0.0,
        });
        self.state.machine = target.machine;
        Ok(())
    }

    fn circular(&mut self, block: &Block) -> Check<()> {
        let (letters, _) = self.state.modal.plane.letters();
        let mut slots = [0; 2];
        for (slot, letter) in slots.iter_mut().zip(letters) {
            let g = block.code_of(Group::Motion).map_or(block.span, |g| g.span);
            *slot = self.group.slot(letter).ok_or_else(|| Fault::with(Id::GC417, g, &[&char::from(letter)]))?;
        }
        if let Some((_, word)) = block.first_of(AXIS_LETTERS & mask("ABC")) {
            return Err(Fault::new(Id::GC418, word.span));
        }
        let target = self.target(block)?;
        let known = self.state.unknown & (1 << slots[0] | 1 << slots[1]) == 0;
        match self.arc(block, slots, &target) {
            Ok(arc) => self.arc_to(block, slots, target, &arc),
            // the start is not where the program means it to be: nothing can be said about this arc
            Err(fault) if !known && fault.id >= Id::GC401 && fault.id <= Id::GC410 => {
                (self.state.program, self.state.machine) = (target.program, target.machine);
                Ok(())
            }
            Err(fault) => Err(fault),
        }
    }
    /// Geometry of the arc in program coordinates.
    fn arc(&mut self, block: &Block, slots: [usize; 2], target: &Target) -> Check<Arc> {
        self.used |= CENTRE_LETTERS | mask("RP");
        let turns = match block.word(b'P') {
            Some(p) if p.value < 1.0 || p.value.fract() != 0.0 || p.value > 1e6 => {
                return Err(Fault::new(Id::GC407, p.span));
            }
            Some(p) => p.value as u32,
            None => 1,
        };
        let start = slots.map(|s| self.state.program[s]);
        let end = slots.map(|s| target.program[s]);
        let counter_clockwise = self.state.modal.motion == MotionMode::CounterClockwise;
        let ends = Ends { start, end, counter_clockwise, turns, span: block.span };
        let (letters, third) = self.state.modal.plane.centres();
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
    fn arc_to(&mut self, block: &Block, slots: [usize; 2], mut target: Target, arc: &Arc) -> Check<()> {
        let reverses = self.state.frame.reverses(slots).ok_or_else(|| Fault::new(Id::GC412, block.span))?;
        let mut centre = self.state.program;
        for i in 0..2 {
            centre[slots[i]] = arc.centre[i];
            target.program[slots[i]] = arc.end[i];
        }
        let closed = slots.iter().all(|&s| target.program[s] == self.state.program[s]);
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
        let start = slots.map(|s| self.state.machine[s]);
        let centre = slots.map(|s| centre[s]);
        let sweep = if reverses { -arc.sweep } else { arc.sweep };
        let radius = (start[0] - centre[0]).hypot(start[1] - centre[1]);
        let circle = Circle { slots, centre, sweep, radius };
        self.check_limits(block, &target.machine);
        self.check_extremes(block, &circle, start, slots.map(|s| target.machine[s]));
        self.circle_to(block, &target, circle)
    }
    fn circle_to(&mut self, block: &Block, target: &Target, circle: Circle) -> Check<()> {
        let lengths = Lengths::of(&self.group, &self.state.machine, &target.machine, Some(&circle));
        let vl = self.path_speed(block, &lengths)?;
        let mut motion = Motion {
            line: self.line,
            rapid: false,
            exact: self.state.modal.exact || block.g(90).is_some(),
            target: target.machine,
            circle: Some(circle),
            length: lengths.path,
            vl,
            ac: self.machine.gcode.trac_feed,
            tolerance: self.state.modal.tolerance,
            slack: 0.0,
        };
        let sagitta = circle.radius * (1.0 - (0.5 * circle.sweep.to_radians()).cos());
        let short = lengths.path < 1.6 * self.machine.sample_time_s() * vl;
        if short && circle.sweep.abs() < 180.0 && sagitta <= motion.tolerance {
            let chord = self.group.distance(&self.state.machine, &target.machine);
            motion = Motion { circle: None, length: chord, slack: sagitta, ..motion };
        }
        self.facts.motion_blocks += 1;
        if motion.length >= NOTHING {
            self.sink.motion(motion);
            self.state.machine = target.machine;
        }
        self.state.program = target.program;
        Ok(())
    }
    /// GC413 for the points of an arc that lie farthest out.
    fn check_extremes(&mut self, block: &Block, circle: &Circle, start: [f64; 2], end: [f64; 2]) {
        let bounds = arc::bounds(start, circle.centre, circle.sweep, end);
        for (i, slot) in circle.slots.into_iter().enumerate() {
            let (low, high) = bounds[i];
            self.facts.low[slot] = self.facts.low[slot].min(low);
            self.facts.high[slot] = self.facts.high[slot].max(high);
            let axis = &self.group.axes[slot];
            let Some((least, most)) = axis.limits else { continue };
            let inside = |v: f64| v >= least - NOTHING && v <= most + NOTHING;
            if self.state.unknown != 0 || !inside(end[i]) {
                continue;
            }
            if let Some(worst) = [low, high].into_iter().find(|v| !inside(*v)) {
                let letter = char::from(axis.letter);
                self.faults.push(outside(letter, worst, (least, most), " (arc extreme)", block.span));
            }
        }
    }

    /// Words that no function of the block has asked for.
    #[inline]
    pub(crate) fn check_unused(&mut self, block: &Block) -> Check<()> {
        let left = block.mask & !self.used;
        if left == 0 {
            return Ok(());
        }
        let (letter, word) = block.first_of(left).expect("a letter is left");
        let id = if letter == b'E' {
            Id::GC214
        } else if letter == b'O' {
            Id::GC212
        } else {
            Id::GC326
        };
        Err(Fault::with(id, word.span, &[&char::from(letter)]))
    }
    /// Notes the modal codes where they changed.
    fn show_modal(&mut self) {
        let now = (Modal { feed: None, speed: None, ..self.state.modal }, self.state.frame.zero);
        if self.modal_shown != Some(now) {
            self.modal_shown = Some(now);
            let text = self.state.text();
            if self.facts.modal.last().is_none_or(|last| last.1 != text) {
                self.facts.modal.push((self.line, text));
            }
        }
    }
    /// After an error in a block that may have moved: nobody knows where the axes should be.
    pub fn lose_position(&mut self) {
        self.state.unknown = (1 << SLOTS) - 1;
    }
}

fn outside(letter: char, value: f64, (low, high): (f64, f64), note: &str, span: Span) -> Box<Fault> {
    let value = format!("{value:.4}");
    let value = value.trim_end_matches('0').trim_end_matches('.');
    Fault::with(Id::GC413, span, &[&letter, &value, &low, &high, &note])
}
