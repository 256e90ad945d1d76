//! Subprograms, jumps and loops (docs/dialect.md, sections 3 and 15.3): where the next line comes from.

use std::collections::{HashMap, HashSet};

use crate::block::{Block, OWord, Statement};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::dialect::Options;
use crate::files::Files;
use crate::index::{Index, build_index, subprogram_name};
use crate::source::{Lines, Mark};
use crate::statements::{head_length, loop_word, o_word};
use crate::translate::Call;
use crate::variables::Variables;

/// What a call or return does to the program.
pub(crate) enum Turn {
    Go,
    End(&'static str),
    EndByM99(Span),
}

#[derive(Clone, Debug)]
struct Loop {
    /// `WHILE .. DOm`: m; O-words: label.
    name: String,
    /// Line that opens the loop.
    at: Mark,
    /// Line behind it.
    behind: Mark,
    word: OWord,
    left: u32,
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
    file: usize,
    sources: Vec<(&'s str, &'s [u8])>,
    files: &'s Files,
    indexes: HashMap<usize, Index>,
    calls: Vec<CallFrame<'s>>,
    loops: Vec<Loop>,
    /// The next `elseif` of this label is still open.
    pending_if: Option<String>,
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
    /// A loop that is open where the program ends.
    pub fn open_loop(&mut self) -> Option<(u32, &'s [u8], Fault)> {
        let open = self.loops.pop()?;
        let mut lines = self.lines.clone();
        lines.go(open.at);
        let (line, text) = lines.next_line()?;
        Some((line, text, Fault::with(Id::GC607, Span::new(0, text.len()), &[&open.name, &open.name])))
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

    /// True if the statement ends the program.
    pub fn statement(&mut self, statement: &Statement, block: &Block, variables: &mut Variables) -> Check<()> {
        match statement {
            Statement::Goto { taken: true, target, span } => self.goto(*target, *span),
            Statement::While { condition, level, span } => self.while_loop(*condition, *level, *span),
            Statement::End { level, span } => self.end_loop(*level, *span),
            Statement::OWord { label, word, arguments, span } => {
                self.o_word(label, *word, arguments, *span, block, variables)
            }
            _ => Ok(()),
        }
    }
    fn base(&self) -> usize {
        self.calls.last().map_or(0, |frame| frame.loops)
    }
    fn goto(&mut self, target: f64, span: Span) -> Check<()> {
        let fault = |what: &str| Fault::with(Id::GC605, span, &[&target, &what]);
        if target.fract() != 0.0 || !(0.0..=99_999_999.0).contains(&target) {
            return Err(fault("missing"));
        }
        let (offset, base) = (self.current.offset, self.base());
        let index = self.index(self.file);
        let region = index.regions.partition_point(|start| *start <= offset);
        let label = index.labels.get(&(region, target as u32)).cloned().ok_or_else(|| fault("missing"))?;
        if label.ambiguous {
            return Err(fault("ambiguous"));
        }
        let open = &self.loops[base..];
        let loops = label.loops();
        let same = open.iter().zip(&loops).take_while(|(l, offset)| l.at.offset == **offset).count();
        if same < loops.len() {
            return Err(Fault::new(Id::GC608, span));
        }
        self.loops.truncate(base + same);
        self.lines.go(label.mark);
        Ok(())
    }
    fn while_loop(&mut self, condition: bool, level: u8, span: Span) -> Check<()> {
        let base = self.base();
        let again = self.loops[base..].last().is_some_and(|l| l.at == self.current);
        let name = level.to_string();
        if !again && self.loops[base..].iter().any(|l| l.name == name) {
            return Err(Fault::with(Id::GC606, span, &[&level, &level]));
        }
        if condition {
            if !again {
                let (at, behind) = (self.current, self.lines.mark());
                self.loops.push(Loop { name, at, behind, word: OWord::While, left: 0 });
            }
            return Ok(());
        }
        if again {
            self.loops.pop();
        }
        self.skip_loop(level, span)
    }
    /// To the line behind END.
    fn skip_loop(&mut self, level: u8, span: Span) -> Check<()> {
        let mut open = vec![level];
        let back = self.lines.mark();
        while let Some((_, text)) = self.lines.next_line() {
            self.scanned += 1;
            match loop_word(text) {
                Some((true, m)) => open.push(m),
                Some((false, m)) if open.last() == Some(&m) => {
                    open.pop();
                    if open.is_empty() {
                        return Ok(());
                    }
                }
                Some((false, m)) => return Err(Fault::with(Id::GC606, span, &[&m, &m])),
                None => {}
            }
        }
        self.lines.go(back);
        Err(Fault::with(Id::GC607, span, &[&level, &level]))
    }
    fn end_loop(&mut self, level: u8, span: Span) -> Check<()> {
        let base = self.base();
        match self.loops[base..].last() {
            Some(open) if open.name == level.to_string() => {
                self.lines.go(open.at);
                Ok(())
            }
            _ => Err(Fault::with(Id::GC606, span, &[&level, &level])),
        }
    }

    // --- O-words ---

    fn o_word(
        &mut self,
        label: &str,
        word: OWord,
        arguments: &[f64],
        span: Span,
        block: &Block,
        variables: &mut Variables,
    ) -> Check<()> {
        let condition = arguments.first().copied().unwrap_or(0.0) != 0.0;
        match word {
            OWord::Sub => self.skip_to(label, &[OWord::EndSub], span, true).map(|_| ()),
            OWord::EndSub | OWord::Return => self.ret(None, block, variables).map(|_| ()),
            OWord::Call => {
                let arguments = arguments.iter().enumerate().take(30).map(|(i, v)| (i + 1, *v)).collect();
                let call = Call { name: label.to_owned(), count: 1, arguments: Some(arguments), span };
                self.call(call, variables).map(|_| ())
            }
            OWord::If if condition => Ok(()),
            OWord::If => self.next_branch(label, span),
            OWord::ElseIf | OWord::Else => self.branch(label, word, condition, span),
            OWord::EndIf => {
                self.pending_if = None;
                Ok(())
            }
            OWord::Do => {
                self.open(label, OWord::Do, 0);
                Ok(())
            }
            OWord::While => self.o_while(label, condition, span),
            OWord::Repeat => self.o_repeat(label, arguments.first().copied().unwrap_or(0.0), span),
            OWord::EndWhile | OWord::EndRepeat => self.o_end(label, span),
            OWord::Break => self.o_break(label, span),
            OWord::Continue => self.o_continue(label, span),
        }
    }
    fn open(&mut self, label: &str, word: OWord, left: u32) {
        let (at, behind) = (self.current, self.lines.mark());
        self.loops.push(Loop { name: format!("o{label}"), at, behind, word, left });
    }
    /// The innermost open loop of that label in this call.
    fn innermost(&self, label: &str, span: Span) -> Check<Loop> {
        let name = format!("o{label}");
        let found = self.loops[self.base()..].last().filter(|l| l.name == name).cloned();
        found.ok_or_else(|| Fault::with(Id::GC606, span, &[&label, &label]))
    }
    /// Goes to the next line that holds one of the O-words of a label (or behind it).
    fn skip_to(&mut self, label: &str, words: &[OWord], span: Span, behind: bool) -> Check<OWord> {
        let back = self.lines.mark();
        loop {
            let at = self.lines.mark();
            let Some((_, text)) = self.lines.next_line() else { break };
            self.scanned += 1;
            if let Some((name, word, _)) = o_word(text, head_length(text))
                && name == label
                && words.contains(&word)
            {
                if !behind {
                    self.lines.go(at);
                }
                return Ok(word);
            }
        }
        self.lines.go(back);
        Err(Fault::with(Id::GC607, span, &[&label, &label]))
    }
    fn next_branch(&mut self, label: &str, span: Span) -> Check<()> {
        self.pending_if = Some(label.to_owned());
        self.skip_to(label, &[OWord::ElseIf, OWord::Else, OWord::EndIf], span, false).map(|_| ())
    }
    fn branch(&mut self, label: &str, word: OWord, condition: bool, span: Span) -> Check<()> {
        if self.pending_if.as_deref() != Some(label) {
            return self.skip_to(label, &[OWord::EndIf], span, true).map(|_| ());
        }
        self.pending_if = None;
        if word == OWord::Else || condition { Ok(()) } else { self.next_branch(label, span) }
    }
    fn o_while(&mut self, label: &str, condition: bool, span: Span) -> Check<()> {
        let base = self.base();
        let name = format!("o{label}");
        let innermost = self.loops[base..].last().filter(|l| l.name == name).cloned();
        match innermost {
            Some(open) if open.word == OWord::Do => {
                if condition {
                    self.lines.go(open.behind);
                } else {
                    self.loops.pop();
                }
                Ok(())
            }
            Some(_) if condition => Ok(()),
            Some(_) => {
                self.loops.pop();
                self.skip_to(label, &[OWord::EndWhile], span, true).map(|_| ())
            }
            None if condition => {
                self.open(label, OWord::While, 0);
                Ok(())
            }
            None => self.skip_to(label, &[OWord::EndWhile], span, true).map(|_| ()),
        }
    }
    fn o_repeat(&mut self, label: &str, count: f64, span: Span) -> Check<()> {
        if count < 1.0 {
            return self.skip_to(label, &[OWord::EndRepeat], span, true).map(|_| ());
        }
        self.open(label, OWord::Repeat, count.min(1e9) as u32 - 1);
        Ok(())
    }
    fn o_end(&mut self, label: &str, span: Span) -> Check<()> {
        let open = self.innermost(label, span)?;
        if open.word == OWord::Repeat {
            if open.left == 0 {
                self.loops.pop();
                return Ok(());
            }
            self.loops.last_mut().expect("a loop is open").left -= 1;
            self.lines.go(open.behind);
        } else {
            self.lines.go(open.at);
        }
        Ok(())
    }
    fn o_break(&mut self, label: &str, span: Span) -> Check<()> {
        self.innermost(label, span)?;
        self.loops.pop();
        self.skip_to(label, &[OWord::EndWhile, OWord::EndRepeat, OWord::While], span, true).map(|_| ())
    }
    fn o_continue(&mut self, label: &str, span: Span) -> Check<()> {
        let open = self.innermost(label, span)?;
        match open.word {
            OWord::While => self.lines.go(open.at),
            _ => {
                self.skip_to(label, &[OWord::EndRepeat, OWord::While], span, false)?;
            }
        }
        Ok(())
    }

    // --- index ---

    fn index(&mut self, file: usize) -> &Index {
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
