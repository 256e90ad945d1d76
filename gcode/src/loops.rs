//! Jumps and loops (docs/dialect.md, section 15.3): `GOTO`, `WHILE .. DO`, O-words.

use crate::block::{Block, OWord, Statement};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::flow::Flows;
use crate::source::Mark;
use crate::statements::{O_WORDS, head_length, loop_word, o_word};
use crate::translate::Call;
use crate::variables::Variables;

#[derive(Clone, Debug)]
pub(crate) struct Loop {
    /// `WHILE .. DOm`: m; O-words: label.
    name: String,
    /// Line that opens the loop.
    at: Mark,
    /// Line behind it.
    behind: Mark,
    word: OWord,
    left: u32,
}

impl Loop {
    /// GC607: it has no end.
    fn unended(&self, span: Span) -> Fault {
        let end = match self.word {
            OWord::Do => OWord::While,
            OWord::Repeat => OWord::EndRepeat,
            _ => OWord::EndWhile,
        };
        match self.name.strip_prefix('o') {
            Some(label) => Fault::with(Id::GC607, span, &[&said(label, self.word), &said(label, end)]),
            None => unended(&self.name, span),
        }
    }
}

/// GC607 of `WHILE .. DOm`.
fn unended(level: &str, span: Span) -> Fault {
    Fault::with(Id::GC607, span, &[&format!("DO{level}"), &format!("END{level}")])
}
/// GC606 of `ENDm`.
fn crossed(level: u8, span: Span) -> Fault {
    Fault::with(Id::GC606, span, &[&format!("END{level}"), &format!("DO{level}")])
}
/// GC606 of an O-word that needs another one before it.
fn o_crossed(label: &str, word: OWord, needed: OWord, span: Span) -> Fault {
    Fault::with(Id::GC606, span, &[&said(label, word), &said(label, needed)])
}
/// What an O-word ends, or a loop that it can leave.
fn begin_of(word: OWord) -> OWord {
    if word == OWord::EndRepeat { OWord::Repeat } else { OWord::While }
}
/// An O-word as programs have it: `o1 while`, `o<name> endif`.
fn said(label: &str, word: OWord) -> String {
    let word = O_WORDS.iter().find(|row| row.1 == word).map_or("", |row| row.0);
    format!("{} {word}", named(label))
}
fn named(label: &str) -> String {
    if label.bytes().all(|b| b.is_ascii_digit()) { format!("o{label}") } else { format!("o<{label}>") }
}

impl<'s> Flows<'s> {
    /// A loop that is open where the program ends.
    pub fn open_loop(&mut self) -> Option<(u32, &'s [u8], Fault)> {
        let open = self.loops.pop()?;
        let mut lines = self.lines.clone();
        lines.go(open.at);
        let (line, text) = lines.next_line()?;
        Some((line, text, open.unended(Span::new(0, text.len()))))
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
    pub(crate) fn goto(&mut self, target: f64, span: Span) -> Check<()> {
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
            return Err(crossed(level, span));
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
                Some((false, m)) => return Err(crossed(m, span)),
                None => {}
            }
        }
        self.lines.go(back);
        Err(unended(&level.to_string(), span))
    }
    fn end_loop(&mut self, level: u8, span: Span) -> Check<()> {
        let base = self.base();
        match self.loops[base..].last() {
            Some(open) if open.name == level.to_string() => {
                self.lines.go(open.at);
                Ok(())
            }
            _ => Err(crossed(level, span)),
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
            OWord::EndWhile | OWord::EndRepeat => self.o_end(label, word, span),
            OWord::Break => self.o_break(label, span),
            OWord::Continue => self.o_continue(label, span),
        }
    }
    fn open(&mut self, label: &str, word: OWord, left: u32) {
        let (at, behind) = (self.current, self.lines.mark());
        self.loops.push(Loop { name: format!("o{label}"), at, behind, word, left });
    }
    /// The innermost open loop of that label in this call.
    fn innermost(&self, label: &str, word: OWord, span: Span) -> Check<Loop> {
        let name = format!("o{label}");
        let found = self.loops[self.base()..].last().filter(|l| l.name == name).cloned();
        found.ok_or_else(|| o_crossed(label, word, begin_of(word), span))
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
        let wanted: Vec<String> = words.iter().map(|word| said(label, *word)).collect();
        Err(Fault::with(Id::GC607, span, &[&named(label), &wanted.join("/")]))
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
            // a loop of that label that began elsewhere
            Some(open) if open.at != self.current => Err(o_crossed(label, OWord::While, OWord::Do, span)),
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
    fn o_end(&mut self, label: &str, word: OWord, span: Span) -> Check<()> {
        let open = self.innermost(label, word, span)?;
        if open.word != begin_of(word) {
            return Err(o_crossed(label, word, begin_of(word), span));
        }
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
        self.innermost(label, OWord::Break, span)?;
        self.loops.pop();
        self.skip_to(label, &[OWord::EndWhile, OWord::EndRepeat, OWord::While], span, true).map(|_| ())
    }
    fn o_continue(&mut self, label: &str, span: Span) -> Check<()> {
        let open = self.innermost(label, OWord::Continue, span)?;
        match open.word {
            OWord::While => self.lines.go(open.at),
            _ => {
                self.skip_to(label, &[OWord::EndRepeat, OWord::While], span, false)?;
            }
        }
        Ok(())
    }
}
