//! A program read from its beginning to its end in windows: memory does not grow with it.
//!
//! Findings, facts and commands are those of [`crate::compile`]. Where the program jumps, loops or calls, its text is
//! read whole and the reader goes on in it; commands still leave in segments.

use std::io::{self, ErrorKind, Read};

use motion_kernel::machine::Machine;

use crate::block::Block;
use crate::diagnostics::{Check, Fault, Id, Place, Reports, Span};
use crate::dialect::Options;
use crate::files::Files;
use crate::program::{Compiled, Run, compile_text, is_sound};
use crate::segments::Deliver;
use crate::source::{Lines, Mark, leader, trailer};
use crate::tape::LEADER_LINES;
use crate::translate::Translator;

/// Bytes that are read at a time.
pub const WINDOW: usize = 1 << 18;
/// What the checks of the file level look at, behind the leader.
const HEAD: usize = 4096;
/// A text whose lines do not end for so long is none that can be read in windows.
const MOST_HELD: usize = 1 << 20;

/// Changes by line of a program that is read in windows (`Facts::most_changes`).
pub const MOST_CHANGES: usize = 50_000;

/// A text from its beginning.
pub type Input<'r> = Box<dyn Read + Send + 'r>;
/// Opens a text, as often as it is called.
pub type Open<'o> = dyn Fn() -> io::Result<Input<'static>> + Send + Sync + 'o;

/// Lines of a text that is read in windows, in their order.
pub(crate) struct Reader<'r> {
    input: Input<'r>,
    step: usize,
    /// What was read and not given yet: whole lines from `begin` to `end`, then a part of one.
    text: Vec<u8>,
    begin: usize,
    end: usize,
    /// Bytes without a whole line at most.
    most: usize,
    /// The line that comes next.
    next: Mark,
    /// Bytes read in all.
    total: usize,
    ended: bool,
}

impl<'r> Reader<'r> {
    fn new(input: Input<'r>, step: usize, most: usize) -> Self {
        let next = Mark { offset: 0, line: 0 };
        Reader { input, step, text: Vec::new(), begin: 0, end: 0, most, next, total: 0, ended: false }
    }
    /// Every line, however long.
    pub fn every_line(input: Input<'r>) -> Self {
        Reader::new(input, WINDOW, usize::MAX)
    }
    /// Reads on, behind what is there.
    fn more(&mut self) -> io::Result<()> {
        let held = self.text.len();
        self.text.resize(held + self.step, 0);
        let mut end = held;
        while end < self.text.len() {
            match self.input.read(&mut self.text[end..]) {
                Ok(0) => {
                    self.ended = true;
                    break;
                }
                Ok(n) => end += n,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.text.truncate(end);
        self.total += end - held;
        self.end = self.lines_end();
        Ok(())
    }
    /// Length of the lines that are whole, whatever follows: the blanks and marks at the very end of a text are no
    /// lines, and two characters may end one.
    fn lines_end(&self) -> usize {
        let end = trailer(&self.text);
        if self.ended {
            return end;
        }
        let last = self.text[..end].iter().rposition(|b| matches!(b, b'\n' | b'\r'));
        last.map_or(0, |last| last + 1)
    }
    /// Reads the beginning: enough for what is decided there. False for a text that does not begin like one.
    fn start(&mut self) -> io::Result<bool> {
        loop {
            self.more()?;
            let ends = self.text.iter().filter(|b| matches!(b, b'\n' | b'\r')).count();
            let known = self.ended || self.text.len() >= leader(&self.text) + HEAD && ends > 2 * LEADER_LINES;
            if known || self.text.len() > self.most {
                self.begin = leader(&self.text);
                self.end = self.end.max(self.begin);
                self.next = Mark { offset: self.begin, line: 1 };
                return Ok(known);
            }
        }
    }
    /// Reads on until there is a whole line. False at the end, and where none ends.
    #[cold]
    fn fill(&mut self) -> io::Result<bool> {
        self.text.drain(..self.begin);
        (self.begin, self.end) = (0, 0);
        while !self.ended && self.text.len() <= self.most {
            self.more()?;
            if self.end > 0 {
                return Ok(true);
            }
        }
        Ok(false)
    }
    /// The next line, and where the one behind it begins.
    #[inline]
    pub fn next_line(&mut self) -> io::Result<Option<(Mark, &[u8])>> {
        if self.next.line == 0 {
            self.start()?;
        }
        if self.begin >= self.end && !self.fill()? {
            return Ok(None);
        }
        let begin = self.begin;
        let mut lines = Lines::piece(&self.text[begin..self.end], self.next.line);
        let Some(length) = lines.next_line().map(|line| line.1.len()) else { return Ok(None) };
        let Mark { offset, line } = lines.mark();
        self.begin += offset;
        self.next = Mark { offset: self.next.offset + offset, line };
        Ok(Some((self.next, &self.text[begin..begin + length])))
    }
    /// A line at or behind the one that comes next; none where the text cannot be read on.
    pub fn line(&mut self, number: u32) -> Option<&[u8]> {
        if self.next.line == 0 {
            self.start().ok()?;
        }
        while self.next.line < number {
            self.next_line().ok()??;
        }
        if self.next.line > number {
            return None;
        }
        self.next_line().ok()?.map(|line| line.1)
    }
}

/// Compiles a program that is read in windows. With `deliver` it is handed over in segments, `Compiled::program` is the
/// last of them. `window`: [`WINDOW`]; tests take less.
pub fn compile_once(
    open: &Open<'_>,
    filename: &str,
    machine: &Machine,
    options: &Options,
    deliver: Option<Deliver>,
    window: usize,
) -> io::Result<Compiled> {
    let mut reader = Reader::new(open()?, window, MOST_HELD);
    let begins = reader.start()?;
    let mut reports = Reports::new(options.limits.errors);
    let files = Files::default();
    let mut translator = Translator::new(machine, options);
    translator.facts.most_changes = MOST_CHANGES;
    translator.sink.deliver = deliver;
    if !begins {
        let text = whole(open, options.limits.held)?;
        compile_text(&text, filename, &mut translator, &mut reports, &files);
    } else if is_sound(&reader.text, options.limits.bytes, filename, &translator, &mut reports) {
        let mut run = Run::new(&mut translator, &mut reports, b"", filename, &files);
        run.open = Some(open);
        if !run.through(&mut reader)? {
            reports = Reports::new(options.limits.errors);
            let fault = Fault::with(Id::GC106, Span::new(0, 1), &[&(options.limits.bytes >> 20)]);
            reports.add(Place { file_index: 0, file: filename, line: 1, text: b" " }, &fault);
        }
    }
    Ok(Compiled::new(translator, reports))
}

/// A text as a whole, and not much more than `most` bytes of it.
fn whole(open: &Open<'_>, most: usize) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    open()?.take(most as u64 + 1).read_to_end(&mut text)?;
    Ok(text)
}

impl Run<'_, '_, '_> {
    /// All lines of a text that comes in windows; false if it is too large.
    fn through(&mut self, reader: &mut Reader<'_>) -> io::Result<bool> {
        if let Err(fault) = self.find_part()? {
            self.report(1, b" ", &fault);
            return Ok(true);
        }
        let mut block = Block::default();
        let first = self.leader(Lines::new(&reader.text), &mut block);
        self.flows.lines.go(reader.next);
        while self.open.is_some() && !self.reports.stopped() {
            let Some((behind, text)) = reader.next_line()? else { break };
            let line = behind.line - 1;
            self.flows.goes_by(behind);
            self.note_definition(line, text);
            if line >= first {
                self.line(line, text, &mut block);
            }
            if reader.total > self.t.options.limits.bytes {
                return Ok(false);
            }
        }
        if self.open.is_some() && !reader.ended && !self.reports.stopped() {
            let _ = self.look_back(Span::new(0, 1)); // a line without an end
        }
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        if self.open.is_none() {
            self.through_memory(first, &mut block);
        }
        self.finish(self.flows.lines.mark().line - 1);
        Ok(true)
    }
    /// What follows needs lines that are behind or far ahead: the text is read whole, and the reader goes on in it.
    /// The fault, for the block that needs them: it is too large for that. Where it cannot be read, `failed` says why.
    pub(crate) fn look_back(&mut self, span: Span) -> Check<()> {
        self.t.facts.looks_back = true;
        let Some(open) = self.open else { return Ok(()) };
        let most = self.t.options.limits.held;
        match whole(open, most) {
            Ok(text) if text.len() > most => {}
            Ok(text) if text.len() < self.flows.lines.mark().offset => {
                self.failed = Some(io::Error::other("the file became shorter while it was read"));
            }
            Ok(text) => {
                self.flows.hold(text);
                self.open = None;
                return Ok(());
            }
            Err(error) => self.failed = Some(error),
        }
        self.give_up();
        Err(Fault::with(Id::GC106, span, &[&(most >> 20)]))
    }
}
