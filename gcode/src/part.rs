//! A part of a program (docs/dialect.md, section 23): block search to its first block, and where it ends.
//!
//! Everything before the first block is translated as ever, so that modal state, position, variables and offsets are
//! those of the whole program; only its commands are thrown away. What they left behind (tool, outputs, common
//! variables) is sent again, then the axes go to where that block begins.

use std::io;

use motion_kernel::autocode::{HOST_EVENT_CI, Instr, Program};
use motion_kernel::axes::AxisSet;

use crate::block::Block;
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::group::Point;
use crate::mfunc::spool;
use crate::modal::{FeedMode, MotionMode};
use crate::once::{Input, Reader};
use crate::outputs::Outputs;
use crate::program::Run;
use crate::statements::{block_number, head_length};
use crate::target::Target;
use crate::translate::Translator;

/// A block of the main file: by its line, or by its N.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum At {
    Line(u32),
    Block(u32),
}

impl At {
    fn number(self) -> u32 {
        match self {
            At::Line(n) | At::Block(n) => n,
        }
    }
}

impl std::fmt::Display for At {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            At::Line(n) => write!(f, "line {n}"),
            At::Block(n) => write!(f, "N{n}"),
        }
    }
}

/// What the operator must know before the program starts in the middle; positions in mm or degrees, per slot.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    pub line: u32,
    /// Active G codes.
    pub modal: String,
    pub machine: Point,
    pub program: Point,
    /// From program to machine coordinates: zero offset, G52, G92, tool length.
    pub shift: Point,
    /// Tool in the spindle, and the one preselected.
    pub in_spindle: u32,
    pub tool: u32,
    pub tool_length: f64,
    /// 3, 4 or 5, and S as programmed.
    pub spindle: u16,
    pub speed: Option<f64>,
    /// M08 and M07.
    pub coolant: [bool; 2],
    /// F in mm/min.
    pub feed: Option<f64>,
}

/// How far the reader is with the part that was asked for.
#[derive(Debug, Default)]
pub(crate) struct Part {
    from: Option<u32>,
    to: Option<u32>,
    begun: bool,
    /// Depth of calls at the last block, once it is executed.
    ending: Option<usize>,
}

impl Run<'_, '_, '_> {
    /// Finds the blocks that the options name; the fault stands on line 1.
    pub(crate) fn find_part(&mut self) -> io::Result<Check<()>> {
        let mut wanted = [self.t.options.from, self.t.options.to].map(|at| at.map(Search::new));
        if self.t.options.from.is_some() {
            self.t.sink.left = Some(Left::default());
        }
        if wanted.iter().any(Option::is_some) {
            let source: Input<'_> = match self.open {
                Some(open) => open()?,
                None => Box::new(self.flows.main_source()),
            };
            let mut reader = Reader::every_line(source);
            while let Some((behind, text)) = reader.next_line()?
                && wanted.iter_mut().flatten().any(|search| search.goes_on())
            {
                wanted.iter_mut().flatten().for_each(|search| search.pass(behind.line - 1, text));
            }
        }
        let [from, to] = wanted.map(|search| search.map(Search::line).transpose());
        Ok(from.and_then(|from| to.map(|to| self.part = Part { from, to, ..Part::default() })))
    }
    /// Before a block is executed; false if the part is over.
    pub(crate) fn within_part(&mut self, line: u32) -> bool {
        if self.part.from.is_none() && self.part.to.is_none() || !self.t.in_main {
            return true;
        }
        if self.part.ending.is_some_and(|depth| self.flows.depth() <= depth) {
            self.program_end(Some("M30"));
            return false;
        }
        if self.part.from == Some(line)
            && let Err(reason) = self.begin_part(line)
        {
            self.t.faults.push(Fault::with(Id::GC618, Span::new(0, 1), &[&line, &reason]));
        }
        if self.part.to == Some(line) {
            self.part.ending = Some(self.flows.depth());
        }
        true
    }
    fn begin_part(&mut self, line: u32) -> Result<(), &'static str> {
        if std::mem::replace(&mut self.part.begun, true) {
            return Err("it is executed more than once");
        }
        if self.flows.depth() > 0 {
            return Err("it belongs to a subprogram");
        }
        if self.flows.in_loop() {
            return Err("it lies in a loop");
        }
        self.t.start_here(line)
    }
    /// GC617 where the program never came to its first block.
    pub(crate) fn check_part(&mut self) {
        if let Some(at) = self.t.options.from.filter(|_| self.part.from.is_some() && !self.part.begun) {
            self.report(1, b" ", &Fault::with(Id::GC617, Span::new(0, 1), &[&at]));
            self.t.sink.drop_program();
        }
    }
}

/// Looks for the line of a block; for a line without words it is the next one that has some.
struct Search {
    at: At,
    found: Option<u32>,
    ambiguous: bool,
}

impl Search {
    fn new(at: At) -> Self {
        Search { at, found: None, ambiguous: false }
    }
    /// A number may stand once more in every line that follows.
    fn goes_on(&self) -> bool {
        match self.at {
            At::Line(_) => self.found.is_none(),
            At::Block(_) => !self.ambiguous,
        }
    }
    fn pass(&mut self, line: u32, text: &[u8]) {
        match self.at {
            At::Line(n) if self.found.is_none() && line >= n && has_words(text) => self.found = Some(line),
            At::Block(n) if block_number(text) == Some(n) => self.ambiguous |= self.found.replace(line).is_some(),
            _ => {}
        }
    }
    fn line(self) -> Check<u32> {
        if self.ambiguous {
            return Err(Fault::with(Id::GC605, Span::new(0, 1), &[&self.at.number(), &"ambiguous"]));
        }
        self.found.ok_or_else(|| Fault::with(Id::GC617, Span::new(0, 1), &[&self.at]))
    }
}
/// More than blanks, comments and a block number.
fn has_words(text: &[u8]) -> bool {
    let rest = text[head_length(text).min(text.len())..].trim_ascii();
    !matches!(rest.first(), None | Some(b'(' | b';' | b'%'))
}

impl Translator<'_> {
    /// The commands so far are thrown away; what they left behind is sent again, and the axes go to the present place.
    fn start_here(&mut self, line: u32) -> Result<(), &'static str> {
        if self.sink.is_displaced() {
            return Err("radius correction is active");
        }
        if self.state.modal.cylinder.is_some() {
            return Err("the cylinder surface is active");
        }
        self.sink.flush();
        self.facts.start = Some(self.start(line));
        let before = self.sink.begin_again(self.machine.gcode.start_fill);
        let mut left = self.sink.left.take().unwrap_or_default(); // from here on commands count
        left.pass(&before);
        (self.facts.motion_blocks, self.facts.low, self.facts.high) = (0, self.group.start, self.group.start);
        self.line = line;
        self.call_tools();
        for (axes, command, value) in left.writes {
            self.sink.ssf(line, axes, command, value, false);
        }
        self.put_out(Outputs { set: left.set, reset: 0 });
        // the way there is ours, not the program's: neither lint nor GW926
        let (lint, slowed) = (std::mem::take(&mut self.lint), self.sink.slowed.len());
        let approached = self.approach().map_err(|_| "its start cannot be approached");
        self.lint = lint;
        self.sink.slowed.truncate(slowed);
        approached
    }
    fn start(&self, line: u32) -> Start {
        let (state, modal) = (&self.state, &self.state.modal);
        Start {
            line,
            modal: state.codes().to_string(),
            machine: state.machine,
            program: state.program,
            shift: *state.frame.shift(),
            in_spindle: modal.in_spindle,
            tool: modal.tool,
            tool_length: state.frame.length.map_or(0.0, |l| l.1),
            spindle: modal.spindle,
            speed: modal.speed,
            coolant: modal.coolant,
            feed: modal.feed.map(|f| f.mm),
        }
    }
    fn call_tools(&mut self) {
        let (in_spindle, next) = (self.state.modal.in_spindle, self.state.modal.tool);
        if in_spindle != 0 {
            self.host_wait("M06", &in_spindle.to_string());
        }
        if next != in_spindle && next != 0 {
            self.sink.event(self.line, "T", &next.to_string());
        }
    }
    /// Lift along the normal of the plane, across at rapid, then down: at F where the program is feeding.
    fn approach(&mut self) -> Check<()> {
        let (goal, program) = (self.state.machine, self.state.program);
        let motion = self.state.modal.motion;
        self.state.machine = self.group.start;
        let normal = self.group.slot(self.state.modal.plane.letters().1);
        let mut stations = vec![self.group.start, goal, goal];
        if let Some(slot) = normal {
            stations[0][slot] = goal[slot].max(self.group.start[slot]);
            stations[1][slot] = stations[0][slot];
        }
        let feeding = matches!(motion, MotionMode::Line | MotionMode::Clockwise | MotionMode::CounterClockwise)
            && self.state.modal.feed_mode == FeedMode::PerMinute
            && self.state.modal.feed.is_some();
        let block = Block::default();
        for (i, machine) in stations.into_iter().enumerate() {
            let target = Target { program: self.state.frame.to_program(&machine), machine, named: 0 };
            self.line_to(&block, &target, i < 2 || !feeding)?;
        }
        (self.state.machine, self.state.program) = (goal, program);
        self.sink.stop();
        Ok(())
    }
}

/// What commands leave behind that are thrown away.
#[derive(Default)]
pub(crate) struct Left {
    set: u32,
    /// The last value of each variable or motor command, in the order in which they were first written.
    writes: Vec<(AxisSet, u16, f64)>,
}

impl Left {
    /// The commands that come next.
    pub(crate) fn pass(&mut self, program: &Program) {
        for instr in &program.code {
            let Instr::Ssf(number) = instr else { continue };
            let ssf = &program.ssfs[*number as usize];
            match ssf.command {
                spool::SET_OUTPUTS => self.set |= ssf.value as u32,
                spool::RESET_OUTPUTS => self.set &= !(ssf.value as u32),
                HOST_EVENT_CI | spool::HALT | spool::WAIT | spool::WAIT_INPUTS | spool::WAIT_HOST => {}
                command => match self.writes.iter_mut().find(|w| w.0 == ssf.axes && w.1 == command) {
                    Some(known) => known.2 = ssf.value,
                    None => self.writes.push((ssf.axes, command, ssf.value)),
                },
            }
        }
    }
}
