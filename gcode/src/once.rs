//! A program read once, from its beginning to its end, in windows: memory does not grow with it.
//!
//! Findings, facts and commands are those of [`crate::compile`]. A program that jumps, loops or calls would have to
//! look back; it is left to [`crate::compile`].

use std::io::Read;

use motion_kernel::machine::Machine;

use crate::block::Block;
use crate::diagnostics::{Place, Reports};
use crate::dialect::Options;
use crate::flow::Files;
use crate::program::{Compiled, Run, check_machine};
use crate::segments::Deliver;
use crate::source::{Lines, Mark, check_text, leader, trailer};
use crate::tape::LEADER_LINES;
use crate::translate::Translator;

/// Bytes that are read at a time.
pub const WINDOW: usize = 1 << 18;
/// What the checks of the file level look at, behind the leader.
const HEAD: usize = 4096;
/// A text whose lines do not end for so long is none that can be read in windows.
const MOST_HELD: usize = 1 << 20;

/// Where the text is with its reader: some of its lines, whole ones but for the last.
struct Window<'r> {
    input: Box<dyn Read + Send + 'r>,
    step: usize,
    text: Vec<u8>,
    /// Bytes read in all.
    total: usize,
    ended: bool,
}

impl<'r> Window<'r> {
    fn new(input: Box<dyn Read + Send + 'r>, step: usize) -> Self {
        Window { input, step, text: Vec::new(), total: 0, ended: false }
    }
    /// Reads on, behind what is there.
    fn more(&mut self) -> std::io::Result<()> {
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
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.text.truncate(end);
        self.total += end - held;
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
    fn begin(&mut self) -> std::io::Result<bool> {
        loop {
            self.more()?;
            let ends = self.text.iter().filter(|b| matches!(b, b'\n' | b'\r')).count();
            if self.ended || self.text.len() >= leader(&self.text) + HEAD && ends > 2 * LEADER_LINES {
                return Ok(true);
            }
            if self.text.len() > MOST_HELD {
                return Ok(false);
            }
        }
    }
}

/// Compiles a program that is read once. `None`: it must be compiled whole. With `deliver` the program is handed over
/// in segments, `Compiled::program` is the last of them. `window`: [`WINDOW`]; tests take less.
pub fn compile_once(
    input: impl Read + Send,
    filename: &str,
    machine: &Machine,
    options: &Options,
    deliver: Option<Deliver>,
    window: usize,
) -> std::io::Result<Option<Compiled>> {
    let mut window = Window::new(Box::new(input), window);
    if options.from.is_some() || options.to.is_some() || options.strict || !window.begin()? {
        return Ok(None);
    }
    let mut reports = Reports::new(options.limits.errors);
    let files = Files::default();
    let mut translator = Translator::new(machine, options);
    translator.facts.by_line = false;
    translator.sink.deliver = deliver;
    match check_text(&window.text, options.limits.bytes).and_then(|()| check_machine(&translator)) {
        Err(fault) => reports.add(Place { file_index: 0, file: filename, line: 1, text: b" " }, &fault),
        Ok(()) => {
            let mut run = Run::new(&mut translator, &mut reports, b"", filename, &files);
            if !run.through(&mut window)? {
                return Ok(None);
            }
        }
    }
    Ok(Some(Compiled::new(translator, reports)))
}

impl Run<'_, '_, '_> {
    /// All lines of the text; false if it must be compiled whole.
    fn through(&mut self, window: &mut Window<'_>) -> std::io::Result<bool> {
        self.once = true;
        let mut block = Block::default();
        let first = self.leader(Lines::new(&window.text), &mut block);
        self.main_loop.0 = self.t.dialect.main_loop;
        let mut next = 1;
        let mut begin = leader(&window.text);
        loop {
            let end = window.lines_end().max(begin);
            let mut lines = Lines::piece(&window.text[begin..end], next);
            while !self.reports.stopped()
                && let Some((line, text)) = lines.next_line()
            {
                if line >= first {
                    self.flows.current = Mark { offset: 0, line };
                    self.line(line, text, &mut block);
                }
                if self.needs_whole {
                    return Ok(false);
                }
            }
            next = lines.mark().line;
            if window.ended || self.reports.stopped() {
                break;
            }
            window.text.drain(..end);
            begin = 0;
            window.more()?;
            if window.total > self.t.options.limits.bytes || window.text.len() > MOST_HELD + window.step {
                return Ok(false);
            }
        }
        self.finish(next - 1);
        Ok(true)
    }
}

/// Lines of a text that are asked for in their order.
pub(crate) struct LineReader {
    window: Window<'static>,
    begin: usize,
    next: u32,
}

impl LineReader {
    pub fn new(input: Box<dyn Read + Send>) -> Self {
        LineReader { window: Window::new(input, WINDOW), begin: 0, next: 0 }
    }
    /// A line at or behind the one that was asked for last; none where the text cannot be read on.
    pub fn line(&mut self, number: u32) -> Option<&[u8]> {
        if self.next == 0 {
            self.window.more().ok()?;
            (self.begin, self.next) = (leader(&self.window.text), 1);
        }
        loop {
            let end = self.window.lines_end().max(self.begin);
            let mut lines = Lines::piece(&self.window.text[self.begin..end], self.next);
            while lines.mark().line < number && lines.next_line().is_some() {}
            self.next = lines.mark().line;
            let begin = self.begin + lines.mark().offset;
            if self.next == number && begin < end {
                self.begin = begin;
                return Lines::piece(&self.window.text[begin..end], number).next_line().map(|line| line.1);
            }
            if self.window.ended || self.next > number {
                return None;
            }
            self.window.text.drain(..end);
            self.begin = 0;
            self.window.more().ok()?;
        }
    }
}
