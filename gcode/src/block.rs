//! One block as read: words with their places, codes, statement. Nothing is decided here.

use crate::codes::{GCode, Group};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::variables::{Assignment, Variable};

/// Index of an address letter, A = 0.
pub const fn letter_index(letter: u8) -> usize {
    (letter.to_ascii_uppercase() - b'A') as usize
}
pub const fn bit(letter: u8) -> u32 {
    1 << letter_index(letter)
}

/// Mask of several address letters.
pub const fn mask(letters: &str) -> u32 {
    let (bytes, mut all, mut i) = (letters.as_bytes(), 0, 0);
    while i < bytes.len() {
        all |= bit(bytes[i]);
        i += 1;
    }
    all
}

pub const AXIS_LETTERS: u32 = mask("XYZABCUVW");
pub const CENTRE_LETTERS: u32 = mask("IJK");

/// The value of an address.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Word {
    pub value: f64,
    pub span: Span,
    /// Written without a decimal point (integer increments).
    pub integer_form: bool,
}

#[derive(Clone, Copy, Debug)]
pub struct GWord {
    pub code: GCode,
    pub span: Span,
}

#[derive(Clone, Copy, Debug)]
pub struct MWord {
    pub number: u16,
    pub span: Span,
}

/// What `write` puts out.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    Text(String),
    /// An expression.
    Value(f64),
    /// `CIn` or `CDn` alone: read when the block runs.
    Common(Variable),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OWord {
    Sub,
    EndSub,
    Call,
    Return,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    Repeat,
    EndRepeat,
    Break,
    Continue,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Statement {
    /// `IF [..] GOTO n` and `GOTO n`.
    Goto {
        taken: bool,
        target: f64,
        span: Span,
    },
    While {
        condition: bool,
        level: u8,
        span: Span,
    },
    End {
        level: u8,
        span: Span,
    },
    Write {
        items: Vec<Item>,
        line: bool,
    },
    OWord {
        label: String,
        word: OWord,
        arguments: Vec<f64>,
        span: Span,
    },
    /// `IF [..] THEN` whose condition is false, or an assignment: nothing more to do.
    Done,
}

impl Statement {
    /// The next line follows, whatever stands elsewhere in the text.
    pub(crate) fn goes_on(&self) -> bool {
        matches!(self, Statement::Goto { taken: false, .. } | Statement::Write { .. } | Statement::Done)
    }
}

/// A block, reused from line to line.
#[derive(Clone, Debug, Default)]
pub struct Block {
    pub line: u32,
    words: [Word; 26],
    /// Letters present.
    pub mask: u32,
    /// Letters whose value came from a variable or an expression.
    pub stored: u32,
    pub g: Vec<GWord>,
    /// A motion function stands here that is refused.
    pub refused_motion: bool,
    /// The reading of the line ended before its end.
    pub cut: bool,
    /// Groups of the G codes present.
    pub groups: u32,
    pub m: Vec<MWord>,
    /// Level of block delete.
    pub skip: Option<u8>,
    /// First to last word.
    pub span: Span,
    /// The same in characters, for findings that come when the text is gone.
    pub columns: Span,
    /// `O100` or `:100` first in the block.
    pub program: Option<Word>,
    /// `L NAME`
    pub call_name: Option<(String, Span)>,
    pub message: Option<String>,
    /// Text of the last comment (the text of a `#3000` alarm).
    pub comment: Option<Span>,
    pub assignments: Vec<Assignment>,
    pub statement: Option<Statement>,
}

impl Block {
    pub fn clear(&mut self, line: u32) {
        self.line = line;
        self.mask = 0;
        self.stored = 0;
        self.groups = 0;
        (self.refused_motion, self.cut) = (false, false);
        self.g.clear();
        self.m.clear();
        self.span = Span::default();
        if self.skip.is_some() || self.program.is_some() || self.call_name.is_some() || self.message.is_some() {
            (self.skip, self.program, self.call_name, self.message) = (None, None, None, None);
        }
        self.comment = None;
        self.assignments.clear();
        self.statement = None;
    }
    /// Nothing but blanks and comments.
    pub fn is_empty(&self) -> bool {
        self.span == Span::default()
    }
    #[inline]
    pub fn has(&self, letter: u8) -> bool {
        self.mask & bit(letter) != 0
    }
    #[inline]
    pub fn has_any(&self, letters: u32) -> bool {
        self.mask & letters != 0
    }
    #[inline]
    pub fn word(&self, letter: u8) -> Option<&Word> {
        self.has(letter).then(|| &self.words[letter_index(letter)])
    }
    pub fn value(&self, letter: u8) -> Option<f64> {
        self.word(letter).map(|w| w.value)
    }
    /// Place of a word, or of the block.
    pub fn span_of(&self, letter: u8) -> Span {
        self.word(letter).map_or(self.span, |w| w.span)
    }
    /// The first word of a set of letters.
    pub fn first_of(&self, letters: u32) -> Option<(u8, &Word)> {
        let present = (0..26u8).filter(|i| self.mask & letters & 1 << i != 0);
        present.map(|i| (b'A' + i, &self.words[i as usize])).min_by_key(|(_, w)| w.span.start)
    }
    /// Those of the letters whose number stands without a point.
    pub fn integer_letters(&self, letters: u32) -> u32 {
        let present = (0..26u8).filter(|i| self.mask & letters & 1 << i != 0);
        present.filter(|i| self.words[*i as usize].integer_form).fold(0, |all, i| all | 1 << i)
    }
    #[inline]
    pub fn put(&mut self, letter: u8, word: Word) {
        self.words[letter_index(letter)] = word;
        self.mask |= bit(letter);
    }
    #[inline]
    pub fn has_group(&self, group: Group) -> bool {
        self.groups & group.bit() != 0
    }
    /// The code of a group in this block.
    pub fn code_of(&self, group: Group) -> Option<&GWord> {
        if self.has_group(group) { self.g.iter().find(|g| g.code.group == group) } else { None }
    }
    pub fn g(&self, tenths: u16) -> Option<&GWord> {
        self.g.iter().find(|g| g.code.tenths == tenths)
    }
    pub fn m(&self, number: u16) -> Option<&MWord> {
        self.m.iter().find(|m| m.number == number)
    }
    /// An unsigned integer word; the reader checked that it is one.
    pub fn integer(&self, letter: u8) -> Option<u32> {
        self.value(letter).map(|v| v as u32)
    }
    /// A word that must be a whole number only in this use (GC210).
    pub fn whole(&self, letter: u8) -> Check<Option<i64>> {
        match self.word(letter) {
            Some(w) if w.value.fract() != 0.0 => Err(Fault::with(Id::GC210, w.span, &[&char::from(letter), &w.value])),
            Some(w) => Ok(Some(w.value as i64)),
            None => Ok(None),
        }
    }
}
