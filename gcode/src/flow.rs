//! Subprograms and their files (docs/dialect.md, section 3): where the next line comes from.

use std::collections::{HashMap, HashSet};

use crate::block::Block;
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::dialect::Options;
use crate::files::Files;
use crate::index::{Index, build_index, subprogram_name};
use crate::loops::Loop;
use crate::source::{Lines, Mark};
use crate::translate::Call;
use crate::variables::Variables;

/// What a call or return does to the program.
pub(crate) enum Turn {
    Go,
    End(&'static str),
    EndByM99(Span),
}

struct CallFrame<'s> {
    back: Lines<'s>,
    back_file: usize,
    /// The block with the call.
    call: Mark,
    start: Mark,
    left: u32,
    own_variables: bool,
    loops: usize,
    /// Line of the call in the main program.
    main_line: u32,
}

pub(crate) struct Flows<'s> {
    pub lines: Lines<'s>,
    pub current: Mark,
    pub(crate) file: usize,
    sources: Vec<(&'s str, &'s [u8])>,
    files: &'s Files,
    indexes: HashMap<usize, Index>,
    calls: Vec<CallFrame<'s>>,
    pub(crate) loops: Vec<Loop>,
    /// The next `elseif` of this label is still open.
    pub(crate) pending_if: Option<String>,
    high_line: u32,
    max_calls: usize,
    library: Option<crate::dialect::Library>,
    main_line: u32,
    /// Names of the subprograms that were called.
    pub called: HashSet<String>,
    /// Statements executed and lines passed over by searches, they count toward GC602.
    pub scanned: u64,
}

impl<'s> Flows<'s> {
    pub fn new(source: &'s [u8], filename: &'s str, files: &'s Files, options: &Options) -> Self {
        Flows {
            lines: Lines::new(source),
            current: Mark::default(),
            file: 0,
            sources: vec![(filename, source)],
            files,
            indexes: HashMap::new(),
            calls: Vec::new(),
            loops: Vec::new(),
            pending_if: None,
            high_line: 0,
            max_calls: options.limits.calls,
            library: options.library.clone(),
            main_line: 0,
            called: HashSet::new(),
            scanned: 0,
        }
    }
    #[inline]
    pub fn next_line(&mut self) -> Option<(u32, &'s [u8])> {
        self.current = self.lines.mark();
        self.lines.next_line()
    }
    /// A line of the main file has been read elsewhere, in a window: the next one begins there.
    #[inline]
    pub fn goes_by(&mut self, next: Mark) {
        self.current = self.lines.mark();
        self.lines.go(next);
    }
    /// The main file, so far read in windows, is in memory from now on.
    pub fn hold(&mut self, text: Vec<u8>) {
        let (next, text) = (self.lines.mark(), self.files.main.get_or_init(|| text));
        self.sources[0].1 = text;
        self.lines = Lines::new(text);
        self.lines.go(next);
    }
    pub fn depth(&self) -> usize {
        self.calls.len()
    }
    pub fn file(&self) -> (u32, &'s str) {
        (self.file as u32, self.sources[self.file].0)
    }
    /// Commands carry the line of the main file: of the call, while another file is read.
    #[inline]
    pub fn source_line(&mut self, line: u32) -> u32 {
        if self.file == 0 {
            self.main_line = line;
        }
        self.main_line
    }
    /// True the first time a line of the main file is reached.
    pub fn is_first_pass(&mut self, line: u32) -> bool {
        let first = self.file == 0 && line > self.high_line;
        if first {
            self.high_line = line;
        }
        first
    }
    /// Place of the present line.
    pub fn here(&self) -> Mark {
        self.current
    }
    pub fn main_source(&self) -> &'s [u8] {
        self.sources[0].1
    }
    pub fn main_name(&self) -> &'s str {
        self.sources[0].0
    }
    pub fn in_loop(&self) -> bool {
        !self.loops.is_empty()
    }
    pub fn starts_subprogram(&self, name: &[u8]) -> bool {
        subprogram_name(name).is_some()
    }
    /// End of a subprogram file is its return; false at the end of the main file.
    pub fn at_end_of_file(&mut self, variables: &mut Variables) -> bool {
        if self.calls.is_empty() {
            return false;
        }
        self.leave(variables);
        true
    }
    /// Back to the main file, whatever was called.
    pub fn unwind(&mut self) {
        if !self.calls.is_empty() {
            let bottom = self.calls.remove(0);
            (self.lines, self.file) = (bottom.back, bottom.back_file);
            self.calls.clear();
        }
        self.loops.clear();
    }
    pub fn call(&mut self, call: Call, variables: &mut Variables) -> Check<Turn> {
        if call.name.is_empty() || !call.name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') {
            return Err(Fault::with(Id::GC604, call.span, &[&call.name]));
        }
        if self.calls.len() >= self.max_calls {
            return Err(Fault::with(Id::GC601, call.span, &[&self.max_calls]));
        }
        let (file, start) = self.find(&call)?;
        self.called.insert(call.name.clone());
        if call.count == 0 {
            return Ok(Turn::Go);
        }
        self.calls.push(CallFrame {
            back: self.lines.clone(),
            back_file: self.file,
            call: self.current,
            start,
            left: call.count - 1,
            own_variables: call.arguments.is_some(),
            loops: self.loops.len(),
            main_line: self.main_line,
        });
        if let Some(arguments) = &call.arguments {
            variables.enter(arguments);
        }
        if file != self.file {
            self.lines = Lines::new(self.sources[file].1);
            self.file = file;
        }
        self.lines.go(start);
        Ok(Turn::Go)
    }
    /// File and first line of a subprogram: this file, the main file, the library.
    fn find(&mut self, call: &Call) -> Check<(usize, Mark)> {
        for file in [self.file, 0] {
            if let Some(&(mark, _, double)) = self.index(file).subprograms.get(&call.name) {
                return match double {
                    Some(line) => Err(Fault::with(Id::GC613, call.span, &[&call.name, &line])),
                    None => Ok((file, mark)),
                };
            }
        }
        if let Some(file) = self.sources.iter().skip(1).position(|s| stem(s.0) == call.name) {
            return Ok((file + 1, Lines::new(self.sources[file + 1].1).mark()));
        }
        let missing = || Fault::with(Id::GC603, call.span, &[&call.name]);
        let library = self.library.as_ref().ok_or_else(missing)?;
        let names = ["nc", "sub", "spf", "ngc"].map(|ending| format!("{}.{ending}", call.name));
        let (name, bytes) = names.into_iter().find_map(|n| library(&n).map(|b| (n, b))).ok_or_else(missing)?;
        let cell = self.files.slots.get(self.sources.len() - 1).ok_or_else(missing)?;
        let (name, bytes) = cell.get_or_init(|| (name, bytes));
        self.sources.push((name, bytes));
        Ok((self.sources.len() - 1, Lines::new(bytes).mark()))
    }
    /// M17, M29, M99.
    pub fn ret(&mut self, target: Option<(u32, Span)>, block: &Block, variables: &mut Variables) -> Check<Turn> {
        if self.calls.is_empty() {
            return match block.m(99) {
                Some(m) => Ok(Turn::EndByM99(m.span)),
                None => Err(Fault::new(Id::GC614, block.m.last().map_or(block.span, |m| m.span))),
            };
        }
        if let (true, Some((n, span))) = (self.leave(variables), target) {
            self.goto(f64::from(n), span)?;
        }
        Ok(Turn::Go)
    }
    /// The end of a subprogram without M99: as M99. True behind the last repetition: back in the caller.
    pub fn leave(&mut self, variables: &mut Variables) -> bool {
        let Some(frame) = self.calls.last_mut() else { return false };
        self.loops.truncate(frame.loops);
        if frame.left > 0 {
            frame.left -= 1;
            self.lines.go(frame.start);
            return false;
        }
        let frame = self.calls.pop().expect("a call is open");
        (self.lines, self.file, self.main_line) = (frame.back, frame.back_file, frame.main_line);
        self.current = frame.call;
        if frame.own_variables {
            variables.leave();
        }
        true
    }

    /// Loops of the callers.
    pub(crate) fn base(&self) -> usize {
        self.calls.last().map_or(0, |frame| frame.loops)
    }
    /// What stands where in a file, made when first asked for.
    pub(crate) fn index(&mut self, file: usize) -> &Index {
        if !self.indexes.contains_key(&file) {
            let index = build_index(self.sources[file].1);
            self.indexes.insert(file, index);
        }
        &self.indexes[&file]
    }
}

fn stem(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}
