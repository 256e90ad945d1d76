//! A block and the modal state -> commands, in the order of docs/dialect.md, section 14.

use motion_kernel::machine::{Machine, Tool};

use crate::block::{AXIS_LETTERS, Block, CENTRE_LETTERS, GWord, bit, mask};
use crate::codes::{Decision, Group, number};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::dialect::{Dialect, Options};
use crate::facts::Facts;
use crate::frame::Frame;
use crate::group::{ContourGroup, Point, SLOTS};
use crate::lint::Lint;
use crate::modal::{Codes, FeedMode, Modal, MotionMode, Plane, State};
use crate::sink::Sink;

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
    pub faults: Vec<Fault>,
    /// Source line that commands are tagged with.
    pub line: u32,
    pub(crate) limited_feed: Option<f64>,
    /// A thread is being cut: the spindle stands under position control.
    pub(crate) threading: bool,
    /// Spindle speed that was sent last.
    pub(crate) sent: Option<f64>,
    /// The block stands in the main file.
    pub(crate) in_main: bool,
    /// Line of the last unit code to inch, and where it stands in it: bytes, if that is new.
    pub(crate) inch: (u32, Option<Span>),
    /// Characters of the output string so far (section 15.4).
    pub(crate) written: usize,
    pub(crate) target_program: Point,
    /// Letters of the present block that have found a use (GC326).
    pub(crate) used: u32,
    /// Tools that G10 has set.
    pub(crate) tools: std::collections::HashMap<u32, Tool>,
    modal_shown: Option<Codes>,
    pub(crate) lint: Lint,
}

const FAST_LETTERS: u32 = AXIS_LETTERS | CENTRE_LETTERS | mask("FNRP");

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
        let modal = Modal::reset(&dialect, machine);
        let mut factors = [1.0; SLOTS];
        for (factor, axis) in factors.iter_mut().zip(&group.axes) {
            *factor = machine.gcode.position_factors.get(axis.axis).copied().unwrap_or(1.0);
        }
        let state = State::new(&group, Frame::new(work, factors), modal);
        let keep = !options.check_only;
        let sink = Sink::new(&group, machine, &dialect, keep);
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
            threading: false,
            sent: None,
            in_main: true,
            inch: (1, None),
            written: 0,
            target_program: group.start,
            used: 0,
            tools: std::collections::HashMap::new(),
            modal_shown: None,
            lint: Lint::default(),
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
            self.used = bit(b'F') | bit(b'N');
            let result = self.feed_word(block).and_then(|()| self.motion_step(block, None));
            let result = result.and_then(|()| self.check_unused(block));
            if self.state.modal.motion != before.motion {
                self.show_modal();
            }
            if result.is_err() {
                self.state.modal = before;
            }
            return result.map(|()| Flow::Next);
        }
        self.execute_any(block)
    }
    fn execute_any(&mut self, block: &Block) -> Check<Flow> {
        let before = self.state.clone();
        let result = self.steps(block);
        if result.is_err() {
            self.state = before;
            self.restore_surface();
        }
        result
    }

    /// Section 14, top to bottom.
    fn steps(&mut self, block: &Block) -> Check<Flow> {
        self.used = bit(b'N');
        if block.g.iter().any(|g| g.code.decision == Decision::Ignored) {
            self.used |= mask("PQRL"); // G08 P1
        }
        if let Some(g) = block.g(650).or(block.code_of(Group::Call)) {
            return self.macro_call(block, g);
        }
        self.check_correction(block)?;
        self.check_cylinder(block)?;
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
            40 | 100 | 280 | 300 | 520 | 680 | 740 | 920 | 71 | 1070 | 511 => true,
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

    pub(crate) fn unit_and_feed(&mut self, block: &Block) -> Check<()> {
        if let Some(g) = block.code_of(Group::Unit) {
            if matches!(g.code.tenths, 700 | 710) && block.has_any(mask("PQUWDR")) {
                return Err(Fault::with(Id::GC317, g.span, &[&number(g.code.tenths)]));
            }
            let inch = matches!(g.code.tenths, 200 | 700);
            if inch != self.state.modal.inch
                && block.g(100).is_some()
                && let Some((letter, word)) = block.first_of(block.stored & !mask("LP"))
            {
                return Err(Fault::with(Id::GC329, word.span, &[&char::from(letter)]));
            }
            if inch && self.in_main {
                self.inch = (self.line, Some(g.span));
            }
            self.state.modal.inch = inch;
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
        if self.dialect.g07_g08 && (block.g(70).is_some() || block.g(80).is_some()) {
            self.state.modal.diameter = block.g(70).is_some();
        }
        self.dimensions(block);
        Ok(())
    }
    /// G90, G91, the centre mode, and where cycles return to.
    pub(crate) fn dimensions(&mut self, block: &Block) {
        if let Some(g) = block.code_of(Group::Distance) {
            self.state.modal.incremental = g.code.tenths == 910;
        }
        if let Some(g) = block.code_of(Group::ArcCentre) {
            self.state.modal.centre_absolute = Some(g.code.tenths == 901);
        }
        if let Some(g) = block.code_of(Group::CycleReturn) {
            self.state.modal.return_to_r = g.code.tenths == 990;
        }
    }
    pub(crate) fn set_plane(&mut self, g: &GWord) -> Check<()> {
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
    /// Facts that are known only at the end.
    pub fn settle_facts(&mut self) {
        self.facts.settle();
        self.facts.merged = self.sink.merged;
        for slot in 0..SLOTS {
            self.facts.low[slot] = self.facts.low[slot].min(self.sink.low[slot]);
            self.facts.high[slot] = self.facts.high[slot].max(self.sink.high[slot]);
        }
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
    #[inline]
    pub(crate) fn show_modal(&mut self) {
        let now = self.state.codes();
        if self.modal_shown != Some(now) {
            self.modal_shown = Some(now);
            self.facts.modal_changed(self.line, now);
        }
    }
}
