//! The registers of a task that executes a rw_SymPas program, and its instructions on values and control flow.

use super::code::{Instr, Slot};
use super::commands::Arguments;
use super::program::{Program, integer};
use super::tables::Event;
use crate::mcu::Mcu;
use crate::tasks::runtime_error as error;
use std::sync::Arc;

/// Slots of a task's memory: its globals, then the frames of its calls (errata Q26: the stack is fixed).
pub(super) const SLOTS: usize = 16 * 1024;
/// Calls that may be open at once.
const MOST_CALLS: usize = 1024;

/// Why the processor came back within a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pause {
    /// The share of this sample is used up.
    Share,
    /// Waits (wt, end of profile, room in the spooler): the task goes on at a later sample.
    Waiting,
    /// The main program has ended.
    End,
    /// stop, or rs.
    Stop,
    Abort,
    /// A line is done in single-step mode, or a breakpoint is reached.
    Line,
    /// Stopped behind writeln (MODEREG bit 26).
    Writeln,
    /// startcnct of the own task.
    Restart,
    Error(u32),
}

/// Where a routine goes on when the one it called returns.
#[derive(Clone, Copy, Debug)]
struct Frame {
    pc: usize,
    base: usize,
    routine: u16,
    /// The called routine is an event handler.
    handler: bool,
}

/// Single-step mode (stepcnct) and breakpoints.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stepping {
    pub on: bool,
    /// Place whose statements are being executed.
    place: Option<u32>,
    /// Step over: do not stop where more calls are open than this.
    pub over: Option<usize>,
    /// Places of the breakpoints.
    pub breaks: Vec<u32>,
    /// Address of the breakpoint that the task stands at and will pass.
    passing: Option<usize>,
}

/// Registers of a task.
#[derive(Debug)]
pub(crate) struct Processor {
    pub program: Arc<Program>,
    /// See [`Program::offsets`]; what is added to all of them besides.
    offsets: Box<[u32]>,
    pub first_line: u32,
    pub(super) memory: Box<[u64; SLOTS]>,
    pub pc: usize,
    pub(super) base: usize,
    routine: u16,
    frames: Vec<Frame>,
    /// Bits of [`Event::ALL`]: enabled by enev; active in this sample; served and active ever since.
    pub enabled: u8,
    active: u8,
    served: u8,
    /// Something may have to be done before the next statement.
    pub(super) attention: bool,
    pub stepping: Stepping,
    /// Arguments of the command that waits; of the one that an event handler has interrupted.
    pub(super) given: Option<Arguments>,
    interrupted: Option<Arguments>,
    /// Samples left of wt.
    wait: Option<u64>,
    /// An Integer operation has wrapped (errata Q3).
    pub overflow: bool,
    /// Axes for which the task has spooled since its start (stoptoss).
    pub spooled: crate::axes::AxisSet,
    /// Number of the task.
    pub number: usize,
}

impl Processor {
    pub fn new(program: Arc<Program>, number: usize) -> Processor {
        let mut processor = Processor {
            memory: vec![0; SLOTS].into_boxed_slice().try_into().expect("SLOTS slots"),
            pc: 0,
            base: 0,
            routine: 0,
            frames: Vec::with_capacity(MOST_CALLS),
            enabled: 0,
            active: 0,
            served: 0,
            attention: false,
            stepping: Stepping::default(),
            given: None,
            interrupted: None,
            wait: None,
            overflow: false,
            spooled: crate::axes::AxisSet::EMPTY,
            number,
            offsets: program.offsets().into(),
            first_line: 0,
            program,
        };
        processor.restart();
        processor
    }

    /// Back to the beginning; breakpoints stay.
    pub fn restart(&mut self) {
        let globals = &self.program.globals;
        self.memory[..globals.len()].copy_from_slice(globals);
        self.base = globals.len();
        let frame = usize::from(self.program.routines[0].frame);
        self.memory[self.base..self.base + frame].fill(0);
        (self.pc, self.routine) = (self.program.routines[0].entry as usize, 0);
        self.frames.clear();
        (self.enabled, self.served, self.wait, self.overflow) = (0, 0, None, false);
        self.stepping = Stepping { breaks: std::mem::take(&mut self.stepping.breaks), ..Stepping::default() };
        (self.given, self.interrupted) = (None, None);
        self.spooled = crate::axes::AxisSet::EMPTY;
    }

    #[inline(always)]
    fn at(&self, slot: Slot) -> usize {
        let base = if slot.is_global() { 0 } else { self.base };
        (base + slot.index()) & (SLOTS - 1) // verified code stays inside; the mask spares the check
    }
    #[inline(always)]
    pub fn get(&self, slot: Slot) -> u64 {
        self.memory[self.at(slot)]
    }
    #[inline(always)]
    pub fn put(&mut self, slot: Slot, value: u64) {
        let at = self.at(slot);
        self.memory[at] = value;
    }
    #[inline(always)]
    pub fn int(&self, slot: Slot) -> i32 {
        self.get(slot) as i32
    }
    #[inline(always)]
    pub fn real(&self, slot: Slot) -> f64 {
        f64::from_bits(self.get(slot))
    }
    #[inline(always)]
    pub(super) fn put_int(&mut self, slot: Slot, (value, overflow): (i32, bool)) {
        self.overflow |= overflow;
        self.put(slot, integer(value));
    }

    /// Bytes of the stack that are free (stackfree).
    pub fn stack_free(&self) -> u32 {
        let frame = usize::from(self.program.routines[usize::from(self.routine)].frame);
        ((SLOTS - self.base - frame) * 8) as u32
    }
    /// Address of the instruction that comes next; during wt that of the wait.
    fn next(&self) -> usize {
        self.pc - usize::from(self.wait.is_some())
    }
    /// Line in its file, of the instruction that comes next.
    pub fn line(&self) -> u32 {
        self.line_at(self.next())
    }
    /// Place of the instruction that comes next: its line among those of all files.
    pub fn place(&self) -> u32 {
        self.place_at(self.next())
    }
    /// Line in its file, and place, of the instruction being executed, or that failed.
    pub fn executed_line(&self) -> u32 {
        self.line_at(self.pc.saturating_sub(1))
    }
    pub fn executed_place(&self) -> u32 {
        self.place_at(self.pc.saturating_sub(1))
    }
    fn line_at(&self, at: usize) -> u32 {
        self.program.lines.get(at).map_or(0, |(_, line)| *line)
    }
    fn place_at(&self, at: usize) -> u32 {
        let place = |(file, line): &(u16, u32)| self.first_line + self.offsets[usize::from(*file)] + line;
        self.program.lines.get(at).map_or(0, place)
    }
    /// The routine being executed.
    pub fn routine(&self) -> u16 {
        self.routine
    }
    /// Number and frame of the routines being executed, the main program first.
    pub fn frames(&self) -> impl Iterator<Item = (u16, usize)> {
        self.frames.iter().map(|f| (f.routine, f.base)).chain([(self.routine, self.base)])
    }
    /// Their names.
    pub fn calls(&self) -> Vec<&str> {
        self.frames().map(|(n, _)| self.program.routines[usize::from(n)].name.as_str()).collect()
    }
    /// A slot of a routine whose frame begins at `base`.
    pub fn get_in(&self, slot: Slot, base: usize) -> u64 {
        let at = if slot.is_global() { slot.index() } else { base + slot.index() };
        self.memory[at & (SLOTS - 1)]
    }
    /// Places of statements, rising.
    pub fn break_places(&self) -> Vec<u32> {
        let code = self.program.code.iter().enumerate();
        let mut places: Vec<u32> =
            code.filter(|(_, i)| matches!(i, Instr::Statement(_))).map(|(at, _)| self.place_at(at)).collect();
        places.sort_unstable();
        places.dedup();
        places
    }
    /// The share of one sample, at most `share` statements.
    pub fn run(&mut self, mcu: &mut Mcu, output: &mut crate::tasks::Output, share: u32) -> Pause {
        self.watch_events(mcu);
        if let Some(pause) = self.still_waiting() {
            return pause;
        }
        let program = self.program.clone();
        let mut left = share;
        loop {
            let instr = match self.compute(&program.code, &mut left) {
                Ok(instr) => instr,
                Err(pause) => return pause,
            };
            if let Err(pause) = self.execute(instr, &program, mcu, output) {
                return pause;
            }
        }
    }

    fn still_waiting(&mut self) -> Option<Pause> {
        let left = self.wait?;
        self.wait = (left > 1).then(|| left - 1);
        self.wait.map(|_| Pause::Waiting)
    }

    pub(super) fn call(&mut self, program: &Program, number: u16, base: usize, handler: bool) -> Result<(), Pause> {
        let callee = &program.routines[usize::from(number)];
        let (given, frame) = (usize::from(callee.parameters), usize::from(callee.frame));
        if base + frame > SLOTS || self.frames.len() == MOST_CALLS {
            return Err(Pause::Error(error::STACK_OVERFLOW));
        }
        let result = usize::from(callee.function);
        self.memory[base..base + result].fill(0);
        self.memory[base + result + given..base + frame].fill(0);
        self.frames.push(Frame { pc: self.pc, base: self.base, routine: self.routine, handler });
        (self.pc, self.base, self.routine) = (callee.entry as usize, base, number);
        Ok(())
    }

    pub(super) fn leave(&mut self) -> Result<(), Pause> {
        let Some(frame) = self.frames.pop() else {
            self.pc -= 1;
            return Err(Pause::End);
        };
        (self.pc, self.base, self.routine) = (frame.pc, frame.base, frame.routine);
        if frame.handler {
            self.given = self.interrupted.take();
            self.attention = true; // another event may be waiting
        }
        Ok(())
    }

    /// wt: whole samples, rounded up, at least one (errata Q19).
    pub(super) fn wait_for(&mut self, ticks: i32, mcu: &Mcu) -> Pause {
        let per_sample = i64::from(mcu.machine.controller.sample_ticks);
        self.wait = Some((i64::from(ticks).max(1) as u64).div_ceil(per_sample as u64));
        Pause::Waiting
    }

    pub(super) fn enable(&mut self, event: Event, on: bool) {
        let bit = 1 << event as u8;
        self.enabled = if on { self.enabled | bit } else { self.enabled & !bit };
        if on {
            self.served &= !bit; // one that is active already is served at the next check (errata Q29)
            self.attention = true;
        }
    }

    /// Looks once per sample which events are active.
    fn watch_events(&mut self, mcu: &Mcu) {
        self.attention = self.stepping.on || !self.stepping.breaks.is_empty();
        if self.enabled != 0 {
            self.active = super::events::active(mcu);
            self.served &= self.active;
            self.attention = true;
        }
    }

    /// The handler of the most urgent event that waits for one.
    fn due_handler(&mut self) -> Option<u16> {
        if self.stepping.on || self.frames.iter().any(|f| f.handler) {
            return None;
        }
        let due = self.enabled & self.active & !self.served;
        let event = (due != 0).then(|| due.trailing_zeros() as usize)?;
        self.served |= 1 << event;
        self.program.events[event]
    }

    /// Events, single steps and breakpoints at the beginning of a statement.
    pub(super) fn before_statement(&mut self) -> Result<(), Pause> {
        if self.stops_here() {
            self.pc -= 1;
            return Err(Pause::Line);
        }
        self.serve_events()?;
        self.attention = self.stepping.on || !self.stepping.breaks.is_empty() || self.more_due();
        Ok(())
    }
    fn more_due(&self) -> bool {
        self.enabled & self.active & !self.served != 0
    }

    /// Enters the handler of an event that is due; the interrupted statement begins behind it.
    fn serve_events(&mut self) -> Result<(), Pause> {
        if self.enabled & self.active & !self.served == 0 {
            return Ok(());
        }
        if let Some(handler) = self.due_handler() {
            self.pc -= 1; // back to the statement, or to the waiting command
            let frame = usize::from(self.program.routines[usize::from(self.routine)].frame);
            let program = self.program.clone();
            self.call(&program, handler, self.base + frame, true)?;
            self.interrupted = self.given.take(); // handlers do not interrupt each other
        }
        Ok(())
    }

    /// A waiting command is not at its end: serves events, and comes back to it in the next sample.
    pub fn wait_here(&mut self) -> Result<(), Pause> {
        let at = self.pc;
        self.serve_events()?;
        if self.pc != at {
            return Ok(());
        }
        self.pc -= 1;
        Err(Pause::Waiting)
    }

    fn stops_here(&mut self) -> bool {
        let (here, place) = (self.pc - 1, self.executed_place());
        if self.stepping.on {
            let deep = self.stepping.over.is_some_and(|most| self.frames.len() > most);
            return !deep && *self.stepping.place.get_or_insert(place) != place;
        }
        let passing = self.stepping.passing.take() == Some(here);
        let stops = !passing && self.stepping.breaks.contains(&place);
        self.stepping.passing = stops.then_some(here);
        stops
    }

    /// Single-step mode for the next line; `over`: lines of called routines do not count.
    pub fn step(&mut self, over: bool) {
        self.stepping.on = true;
        self.stepping.place = None;
        self.stepping.over = over.then_some(self.frames.len());
    }
    /// Single-step mode behind the end of the routine being executed.
    pub fn step_out(&mut self) {
        self.step(true);
        self.stepping.over = Some(self.frames.len().saturating_sub(1));
        self.stepping.place = Some(u32::MAX); // the first statement of the caller is another line
    }
    pub fn run_on(&mut self) {
        self.stepping.on = false;
    }
}
