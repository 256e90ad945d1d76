//! A whole program: lines in, blocks through the translator, tape marks, program end, all findings.

use motion_kernel::autocode::Program;
use motion_kernel::machine::Machine;

use crate::aftermath::Doubts;
use crate::block::Block;
use crate::diagnostics::{Diagnostic, Fault, Id, Place, Reports, Span, columns};
use crate::dialect::Options;
use crate::expression::Environment;
use crate::facts::Facts;
use crate::files::Files;
use crate::flow::{Flows, Turn};
use crate::lint::Definition;
use crate::once::Open;
use crate::parser;
use crate::part::Part;
use crate::seen::Numbers;
use crate::source::{Lines, Mark, check_length, check_text};
use crate::statements::head_length;
use crate::tape::is_numbered_mark;
use crate::translate::{Flow, Translator};
use crate::variables::Variables;

/// The result of a compilation. `program` is there exactly if no error was found (and it was not only a check).
#[derive(Debug)]
pub struct Compiled {
    pub program: Option<Program>,
    pub diagnostics: Vec<Diagnostic>,
    /// Warnings beyond the kept ones.
    pub more_warnings: usize,
    pub facts: Facts,
}

impl Compiled {
    pub(crate) fn new(mut translator: Translator, reports: Reports) -> Self {
        let keep = !reports.has_errors() && !translator.options.check_only;
        let (diagnostics, more_warnings) = reports.finish();
        translator.settle_facts();
        let Translator { sink, facts, .. } = translator;
        Compiled { program: keep.then(|| sink.finish()), diagnostics, more_warnings, facts }
    }
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|d| !d.is_warning())
    }
}

/// Compiles a part program for a machine. Never panics, whatever the bytes.
pub fn compile(source: &[u8], filename: &str, machine: &Machine, options: &Options) -> Compiled {
    let mut reports = Reports::new(options.limits.errors);
    let files = Files::default();
    let mut translator = Translator::new(machine, options);
    compile_text(source, filename, &mut translator, &mut reports, &files);
    Compiled::new(translator, reports)
}

/// Translates a text that is in memory.
pub(crate) fn compile_text(
    source: &[u8],
    filename: &str,
    translator: &mut Translator,
    reports: &mut Reports,
    files: &Files,
) {
    let limits = translator.options.limits;
    if is_sound(source, limits.bytes.min(limits.held), filename, translator, reports) {
        Run::new(translator, reports, source, filename, files).run();
    }
}

/// What stands before all else: it is a text, and the machine can move. The finding, if not.
pub(crate) fn is_sound(
    source: &[u8],
    most: usize,
    filename: &str,
    translator: &Translator,
    reports: &mut Reports,
) -> bool {
    let found = check_text(source, most).and_then(|()| check_machine(translator));
    if let Err(fault) = &found {
        reports.add(Place { file_index: 0, file: filename, line: 1, text: b" " }, fault);
    }
    found.is_ok()
}

/// A group without axes, speed or acceleration cannot move.
fn check_machine(translator: &Translator) -> crate::diagnostics::Check<()> {
    let gcode = &translator.machine.gcode;
    let axes = &translator.group.axes;
    let dead = |v: f64| v.is_nan() || v <= 0.0;
    if axes.is_empty() || dead(gcode.trac_feed) || dead(gcode.trac_rapid) || axes.iter().any(|a| dead(a.rapid)) {
        return Err(Fault::new(Id::GC807, Span::new(0, 1)));
    }
    match axes.iter().find(|a| a.rotary && dead(a.effradius)) {
        Some(axis) => Err(Fault::with(Id::GC808, Span::new(0, 1), &[&char::from(axis.letter)])),
        None => Ok(()),
    }
}

/// Where the reader is in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Blocks are executed.
    Run,
    /// Program end is behind, or a subprogram is being defined: blocks are only read.
    Read,
    /// End of tape: the rest is not read.
    Ignore,
}

pub(crate) struct Run<'t, 'm, 's> {
    pub t: &'t mut Translator<'m>,
    pub reports: &'t mut Reports,
    pub variables: Variables,
    pub flows: Flows<'s>,
    pub mode: Mode,
    numbers: Numbers,
    /// The program has begun: a block was executed.
    pub begun: bool,
    /// Commands so far, and the block count when the last came.
    commanded: (u64, u64),
    pub ended: bool,
    pub any_block: bool,
    pub told: Told,
    /// Lines already executed, to be read again.
    pub behind: Option<Lines<'s>>,
    /// Times that M99 still starts the main program again, from there.
    pub main_loop: (u32, Mark),
    /// The last block that was executed: line, bytes, text.
    pub last: (u32, Span, Vec<u8>),
    /// Columns of the last unit code to inch.
    pub inch: Span,
    pub faults: Vec<Fault>,
    /// The text comes in windows, and can be read whole; `None`: it is in memory.
    pub open: Option<&'s Open<'s>>,
    pub failed: Option<std::io::Error>,
    pub part: Part,
    /// Subprograms so far, for the linter.
    pub definitions: Vec<Definition>,
    pub doubts: Doubts,
    /// Line of the O number of the main program.
    pub program_line: u32,
}

/// Warnings that are given once.
#[derive(Default)]
pub(crate) struct Told {
    after_tape: bool,
    pub oword: bool,
    pub star: bool,
    pub increments: bool,
}

impl<'t, 'm, 's> Run<'t, 'm, 's> {
    pub(crate) fn new(
        t: &'t mut Translator<'m>,
        reports: &'t mut Reports,
        source: &'s [u8],
        filename: &'s str,
        files: &'s Files,
    ) -> Self {
        let variables = Variables::new(t.dialect.vacant_zero, t.dialect.oword);
        let main_loop = (t.dialect.main_loop, Mark::default());
        Run {
            flows: Flows::new(source, filename, files, t.options),
            t,
            reports,
            variables,
            mode: Mode::Run,
            numbers: Numbers::default(),
            begun: false,
            commanded: (0, 0),
            ended: false,
            any_block: false,
            told: Told::default(),
            behind: None,
            main_loop,
            last: (1, Span::default(), b" ".to_vec()),
            inch: Span::new(0, 1),
            faults: Vec::new(),
            open: None,
            failed: None,
            definitions: Vec::new(),
            part: Part::default(),
            doubts: Doubts::default(),
            program_line: 0,
        }
    }

    /// A text in memory, from its beginning.
    fn run(&mut self) {
        let mut block = Block::default();
        match self.find_part() {
            Ok(Ok(())) => {}
            Ok(Err(fault)) => return self.report(1, b" ", &fault),
            Err(_) => return, // memory can be read
        }
        let first = self.leader(self.flows.lines.clone(), &mut block);
        self.through_memory(first, &mut block);
        self.finish(self.flows.lines.mark().line - 1);
    }
    /// The lines that follow, of a text in memory; those before `first` do not count.
    pub(crate) fn through_memory(&mut self, first: u32, block: &mut Block) {
        while self.flows.lines.mark().line < first && self.flows.lines.next_line().is_some() {}
        while !self.reports.stopped() {
            let Some((line, text)) = self.flows.next_line() else {
                if self.flows.at_end_of_file(&mut self.variables) {
                    continue;
                }
                break;
            };
            self.line(line, text, block);
        }
    }

    #[inline]
    pub(crate) fn line(&mut self, line: u32, text: &[u8], block: &mut Block) {
        let first = text.iter().copied().find(|b| !matches!(b, b' ' | b'\t')).unwrap_or(0);
        if first == 0 && text.iter().all(|b| matches!(b, b' ' | b'\t')) {
            return;
        }
        if self.mode == Mode::Ignore && first != b'%' {
            if !std::mem::replace(&mut self.told.after_tape, true) {
                self.report(line, text, &Fault::new(Id::GW902, Span::new(0, text.len())));
            }
            return;
        }
        if let Err(fault) = check_length(text) {
            self.report(line, text, &fault);
            self.any_block = true;
            return;
        }
        if first == b'%' || first | 0x20 == b'n' && is_numbered_mark(text) {
            return self.tape_mark(line, text);
        }
        self.read(line, text, block);
        self.one_block(line, text, block);
    }

    /// Parses a line; in `Read` mode and in skipped blocks only its form counts.
    pub(crate) fn read(&mut self, line: u32, text: &[u8], block: &mut Block) {
        block.clear(line);
        let system = |n: u32| crate::system::variable(self.t, n);
        let env = Environment {
            variables: &self.variables,
            system: &system,
            angle_names: self.t.dialect.oword,
            dry: self.mode != Mode::Run || self.is_deleted(text),
            equal: self.t.dialect.equal_tolerance,
        };
        parser::parse(text, &env, &self.t.dialect, block, &mut self.faults);
        block.columns = columns(text, block.span);
    }

    #[inline]
    fn one_block(&mut self, line: u32, text: &[u8], block: &mut Block) {
        if block.is_empty() && self.faults.is_empty() && block.message.is_none() {
            return;
        }
        self.any_block |= !block.is_empty();
        let bad = !self.faults.is_empty() && self.report_all(line, text, block);
        if bad || self.mode != Mode::Run || self.is_skipped(block) {
            return;
        }
        self.execute(line, text, block);
    }
    /// Block delete is on for this line: its form is checked, its values are not.
    fn is_deleted(&self, text: &[u8]) -> bool {
        let head = &text[..head_length(text)];
        let Some(at) = head.iter().position(|b| *b == b'/') else { return false };
        let level = head.get(at + 1).filter(|b| b.is_ascii_digit()).map_or(1, |b| b - b'0');
        self.t.options.block_delete & 1 << level != 0
    }
    pub(crate) fn is_skipped(&self, block: &Block) -> bool {
        block.skip.is_some_and(|level| self.t.options.block_delete & 1 << level != 0)
    }

    #[inline]
    fn execute(&mut self, line: u32, text: &[u8], block: &mut Block) {
        self.t.line = self.flows.source_line(line);
        self.t.in_main = self.flows.file().0 == 0;
        if self.main_loop.1 == Mark::default() {
            self.main_loop.1 = self.flows.here();
        }
        if self.t.dialect.integer_increment > 0.0 {
            self.note_increments(line, text, block);
        }
        if !self.within_part(line) {
            return;
        }
        (self.last.0, self.last.1) = (line, block.span);
        self.last.2.clear();
        self.last.2.extend_from_slice(text);
        if let Some(n) = block.word(b'N')
            && self.flows.is_first_pass(line)
            && self.numbers.seen_before(n.value as u32)
        {
            self.t.faults.push(Fault::with(Id::GW908, n.span, &[&n.value]));
        }
        let result = if block.program.is_none() && block.statement.is_none() && block.assignments.is_empty() {
            self.t.execute(block)
        } else {
            self.execute_special(block, text)
        };
        self.begun = true;
        self.note_inch(text);
        match result {
            Ok(Flow::Next) => {}
            Ok(flow) => self.turn(flow, block),
            Err(fault) => {
                self.salvage(block, text, std::slice::from_ref(&fault));
                if !self.follows(&fault) {
                    self.t.faults.push(fault);
                }
            }
        }
        if !self.t.faults.is_empty() || !self.t.sink.slowed.is_empty() {
            self.settle(line, text);
        }
        if let Some((limit, what)) = self.exceeded() {
            self.report(line, text, &Fault::with(Id::GC602, block.span, &[&limit, &what]));
            self.give_up();
        }
    }
    /// Where the unit became inch, for GW934.
    #[inline]
    pub(crate) fn note_inch(&mut self, text: &[u8]) {
        if let Some(span) = self.t.inch.1.take() {
            self.inch = columns(text, span);
        }
    }
    /// An error after which nothing more of the program is worth reading.
    pub(crate) fn give_up(&mut self) {
        self.t.sink.drop_program();
        (self.mode, self.told.after_tape, self.ended) = (Mode::Ignore, true, true);
        self.flows.unwind();
    }
    /// The limit of GC602 that the program has passed.
    fn exceeded(&mut self) -> Option<(u64, &'static str)> {
        let (limits, blocks) = (self.t.options.limits, self.t.facts.blocks + self.flows.scanned);
        if self.t.sink.commands != self.commanded.0 {
            self.commanded = (self.t.sink.commands, blocks);
        }
        if self.t.sink.commands > limits.commands {
            return Some((limits.commands, "commands spooled"));
        }
        let most = [(blocks, limits.blocks), (blocks - self.commanded.1, limits.idle_blocks)];
        most.iter().find(|(count, limit)| count > limit).map(|(_, limit)| (*limit, "blocks executed"))
    }
    /// Program numbers, assignments and statements.
    fn execute_special(&mut self, block: &mut Block, text: &[u8]) -> crate::diagnostics::Check<Flow> {
        if block.program.is_some() {
            if self.begun && self.flows.here() != self.main_loop.1 {
                self.next_program();
                return Ok(Flow::Next);
            }
            self.program_line = block.line;
            if block.mask == 0 && block.g.is_empty() && block.m.is_empty() {
                return Ok(Flow::Next);
            }
        }
        if !block.assignments.is_empty() {
            self.t.sink.flush();
            self.t.assign(block, &mut self.variables);
            let note = block.comment.map_or(&b""[..], |c| &text[c.start as usize..c.end as usize]);
            self.t.alarm(block, crate::source::decode(note).trim());
        }
        self.flows.scanned += u64::from(block.statement.is_some());
        match block.statement.take() {
            Some(crate::block::Statement::Done) => Ok(Flow::Next),
            Some(statement @ crate::block::Statement::Write { .. }) => {
                self.t.write(&statement, block.span);
                Ok(Flow::Next)
            }
            Some(statement) => {
                if !statement.goes_on() {
                    self.look_back(block.span)?;
                }
                self.flows.statement(&statement, block, &mut self.variables)?;
                Ok(Flow::Next)
            }
            None => self.t.execute(block),
        }
    }
    /// Another program begins where this one did not end: as if it had ended.
    pub(crate) fn next_program(&mut self) {
        if self.flows.depth() > 0 {
            self.flows.leave(&mut self.variables);
        } else {
            self.warn_missing_end();
            self.program_end(Some("M02"));
        }
    }
    /// Calls, returns and the end of the program.
    fn turn(&mut self, flow: Flow, block: &Block) {
        let again = self.main_loop.0 > 0 && matches!(flow, Flow::Return(_));
        if (again || matches!(flow, Flow::Call(_)))
            && let Err(fault) = self.look_back(block.span)
        {
            return self.t.faults.push(fault);
        }
        let turn = match flow {
            Flow::Next => Ok(Turn::Go),
            Flow::End if self.t.dialect.strict_end && self.flows.depth() > 0 => {
                let m = block.m(2).or(block.m(30));
                Err(Fault::new(Id::GC615, m.map_or(block.span, |m| m.span)))
            }
            Flow::End => {
                let kind = if block.m(2).is_some() { "M02" } else { "M30" };
                Ok(Turn::End(kind))
            }
            Flow::Return(target) => self.flows.ret(target, block, &mut self.variables),
            Flow::Call(call) => self.flows.call(call, &mut self.variables),
        };
        match turn {
            Ok(Turn::Go) => {}
            Ok(Turn::End(kind)) => self.program_end(Some(kind)),
            Ok(Turn::EndByM99(_)) if self.main_loop.0 > 0 => {
                self.main_loop.0 -= 1;
                self.t.operator_stop(99);
                self.flows.lines.go(self.main_loop.1);
            }
            Ok(Turn::EndByM99(span)) => {
                self.t.faults.push(Fault::new(Id::GW912, span));
                self.program_end(Some("M30"));
            }
            Err(fault) => self.t.faults.push(fault),
        }
    }

    pub(crate) fn program_end(&mut self, kind: Option<&str>) {
        if let Some(kind) = kind
            && !self.ended
        {
            self.t.end(kind);
        }
        self.ended = true;
        self.flows.unwind();
        self.mode = Mode::Read;
    }

    /// Behind the last of `lines` lines.
    pub(crate) fn finish(&mut self, lines: u32) {
        self.t.facts.lines = lines;
        self.check_part();
        self.lint_subprograms();
        if !self.any_block {
            self.report(1, b" ", &Fault::new(Id::GC113, Span::new(0, 1)));
        } else if !self.ended {
            if let Some(fault) = self.flows.open_loop() {
                let (line, text, fault) = fault;
                self.report(line, text, &fault);
            }
            self.warn_missing_end();
            self.t.end("M02");
        }
        self.t.sink.flush();
        let (line, _, text) = std::mem::take(&mut self.last);
        self.settle(line, &text);
        if self.t.dialect.integer_increment == 0.0 {
            self.hint_inch();
        }
    }
}
