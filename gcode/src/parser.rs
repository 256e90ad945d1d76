//! Text of one line -> [`Block`] (docs/dialect.md, sections 2 to 4). Knows no modal state.

use crate::block::{AXIS_LETTERS, Block, GWord, MWord, Statement, Word, letter_index};
use crate::codes::{self, Beside, Decision, Group, MGroup, m_group};
use crate::diagnostics::{Check, Fault, Id, Span, characters};
use crate::dialect::Dialect;
use crate::expression::{Environment, Reader};
use crate::number;
use crate::rules::RULES;
use crate::statements;
use crate::variables::{Assignment, Variable, check_assignment};

const MAX_M: usize = 8;

/// Reads a line into `block`. What can be passed over is added to `faults`; an `Err` ends the reading of the line.
pub fn parse(text: &[u8], env: &Environment, dialect: &Dialect, block: &mut Block, faults: &mut Vec<Fault>) {
    let mut parser = Parser { r: Reader::new(text, env), dialect, block, faults, headed: false, resumed: false };
    let result = parser.line();
    let Parser { r, block, faults, resumed, .. } = parser;
    block.assignments.extend(r.assigned);
    faults.extend(r.warnings);
    block.cut = resumed || result.is_err();
    faults.extend(result.err());
}

pub(crate) struct Parser<'a, 'e, 'b> {
    pub r: Reader<'a, 'e>,
    pub dialect: &'b Dialect,
    pub block: &'b mut Block,
    pub faults: &'b mut Vec<Fault>,
    /// The head of the block (`/`, N, O) is behind.
    headed: bool,
    /// A word that could not be read was passed over.
    resumed: bool,
}

impl Parser<'_, '_, '_> {
    fn line(&mut self) -> Check<()> {
        self.skip_mark()?;
        self.head()?;
        self.headed = true;
        loop {
            self.r.blanks();
            let at = self.r.pos;
            let byte = self.r.peek();
            match byte {
                0 if at >= self.r.text.len() => return Ok(()),
                b'A'..=b'Z' | b'a'..=b'z' | b'_' => self.letter(byte)?,
                b'(' => self.comment()?,
                b';' => {
                    self.block.comment = Some(Span::new(at + 1, self.r.text.len()));
                    return Ok(());
                }
                b'#' => self.hash_assignment()?,
                _ => {
                    let fault = self.stray(at);
                    self.resume(at, fault)?;
                }
            }
        }
    }

    /// Extends the block's span over the word that ends at the reader's position.
    #[inline]
    pub fn grow(&mut self, start: usize) -> Span {
        let span = Span::new(start, self.r.pos);
        if self.block.is_empty() {
            self.block.span = span;
        } else {
            self.block.span.end = span.end;
        }
        span
    }

    fn skip_mark(&mut self) -> Check<()> {
        self.r.blanks();
        if self.r.peek() != b'/' {
            return Ok(());
        }
        let at = self.r.pos;
        self.r.pos += 1;
        let mut level = 1;
        let digits = self.r.text[self.r.pos..].iter().take_while(|b| b.is_ascii_digit()).count();
        if digits > 0 {
            let digit = self.r.peek() - b'0';
            self.r.pos += digits;
            if digits > 1 || digit == 0 {
                return Err(Fault::new(Id::GC218, Span::new(at, self.r.pos)));
            }
            level = digit;
        }
        if self.r.peek() == b'/' {
            let span = Span::new(self.r.pos, self.r.pos + 1);
            return Err(Fault::with(Id::GC107, span, &[&'/', &"'//' is no comment here, use ';'"]));
        }
        self.block.skip = Some(level);
        self.grow(at);
        Ok(())
    }

    /// N, a later `/`, O or `:` at the start of the block.
    fn head(&mut self) -> Check<()> {
        self.r.blanks();
        if matches!(self.r.peek(), b'N' | b'n') && !self.r.at(self.r.pos + 1).is_ascii_alphabetic() {
            self.word(b'N')?;
            if self.block.skip.is_none() {
                self.skip_mark()?;
            }
            self.r.blanks();
        }
        match self.r.peek() {
            b'O' | b'o' => statements::program_or_o_word(self),
            b':' => {
                let at = self.r.pos;
                self.r.pos += 1;
                self.r.blanks();
                let word = self.value(at, b'O')?;
                self.block.program = Some(word);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// An address, a keyword, a common variable or a name.
    #[inline]
    fn letter(&mut self, byte: u8) -> Check<()> {
        let next = self.r.at(self.r.pos + 1);
        if next.is_ascii_alphabetic() || next == b'_' || byte == b'_' {
            return self.run();
        }
        self.word(byte.to_ascii_uppercase())
    }

    fn word(&mut self, letter: u8) -> Check<()> {
        let at = self.r.pos;
        self.r.pos += 1;
        self.r.blanks();
        if letter == b'L' && self.r.peek().is_ascii_alphabetic() && self.r.pos > at + 1 {
            return self.call_name(at);
        }
        let found = self.faults.len();
        let word = match self.value(at, letter) {
            Ok(word) => word,
            Err(fault) => return self.resume(at + 1, fault),
        };
        if self.faults.len() > found && self.faults[found..].iter().any(|f| !f.id.is_warning()) {
            return Ok(());
        }
        match letter {
            b'N' if self.headed => self.faults.push(Fault::new(Id::GC209, word.span)),
            b'G' => self.put_g(word),
            b'M' => self.put_m(word),
            _ => self.put(letter, word),
        }
        Ok(())
    }

    /// Behind a number that is wrong or missing the next word is clear, so that each mistake of a line is told at once.
    #[cold]
    fn resume(&mut self, from: usize, fault: Fault) -> Check<()> {
        let count = |from: usize, part: fn(&u8) -> bool| self.r.text[from..].iter().take_while(|b| part(b)).count();
        let mut end = from + count(from, |b| matches!(b, b' ' | b'\t'));
        end += count(end, |b| b.is_ascii_digit() || matches!(b, b'.' | b',' | b'+' | b'-'));
        let next = self.r.at(end);
        let clear = next == 0 || next.is_ascii_alphabetic() || matches!(next, b' ' | b'\t' | b'(' | b';');
        if !clear || !(Id::GC202..=Id::GC206).contains(&fault.id) {
            return Err(fault);
        }
        (self.r.pos, self.resumed) = (end, true);
        self.faults.push(fault);
        Ok(())
    }

    /// `L NAME`
    fn call_name(&mut self, at: usize) -> Check<()> {
        let is_part = |b: &&u8| b.is_ascii_alphanumeric() || **b == b'_';
        let length = self.r.text[self.r.pos..].iter().take_while(is_part).count();
        let name = String::from_utf8_lossy(&self.r.text[self.r.pos..self.r.pos + length]).into_owned();
        self.r.pos += length;
        let span = self.grow(at);
        self.block.call_name = Some((name, span));
        Ok(())
    }

    /// Reads the value behind an address and checks it against the table.
    #[inline]
    pub fn value(&mut self, at: usize, letter: u8) -> Check<Word> {
        let byte = self.r.peek();
        let rule = &RULES[letter_index(letter)];
        let mut integer_form = false;
        let signed = matches!(byte, b'+' | b'-') && matches!(self.r.at(self.r.pos + 1), b'#' | b'[');
        let value = if number::starts_number(byte) && !signed {
            let number = number::scan(self.r.text, self.r.pos, at)?;
            self.r.pos = number.end;
            if number.rounded {
                self.faults.push(Fault::new(Id::GW905, Span::new(at, number.end)));
            }
            integer_form = !number.point;
            if number.signed && !rule.signed {
                let span = self.grow(at);
                self.faults.push(Fault::with(Id::GC207, span, &[&char::from(letter)]));
                return Ok(Word { value: 0.0, span, integer_form });
            }
            number.value
        } else {
            self.unusual_value(at, letter)?
        };
        let span = self.grow(at);
        if self.r.peek() == b'=' {
            return Err(self.unexpected_equals(at, letter, value));
        }
        self.check_value(letter, value, span);
        Ok(Word { value, span, integer_form })
    }

    #[inline]
    fn check_value(&mut self, letter: u8, value: f64, span: Span) {
        let rule = &RULES[letter_index(letter)];
        if self.r.env.dry && value == 1.0 {
            return;
        }
        if rule.integer && value.fract() != 0.0 && !(letter == b'D' && self.dialect.d_is_radius) {
            self.faults.push(Fault::with(Id::GC210, span, &[&char::from(letter), &value]));
        } else if value < rule.low || value > rule.high {
            let range: [&dyn std::fmt::Display; 4] = [&value, &char::from(letter), &rule.low, &rule.high];
            self.faults.push(Fault::with(Id::GC216, span, &range));
        }
    }

    /// `#n`, `[..]`, `=..`, `CIn`, or no value at all.
    #[cold]
    fn unusual_value(&mut self, at: usize, letter: u8) -> Check<f64> {
        let negative = self.r.peek() == b'-';
        if matches!(self.r.peek(), b'+' | b'-') {
            self.r.pos += 1;
        }
        let start = self.r.pos;
        let value = match self.r.peek() {
            b'#' => {
                let variable = self.r.hash_variable()?;
                let span = Span::new(start, self.r.pos);
                self.r.read(&variable, span)?
            }
            b'[' => self.r.bracket()?,
            b'=' if matches!(letter, b'G' | b'M' | b'N' | b'O') => {
                let span = Span::new(start, start + 1);
                return Err(Fault::with(Id::GC220, span, &[&'=', &char::from(letter)]));
            }
            b'=' => {
                self.r.pos += 1;
                self.r.expression()?
            }
            b'(' => return Err(Fault::new(Id::GC208, Span::new(start, start + 1))),
            b'"' => return Err(Fault::new(Id::GC719, Span::new(start, start + 1))),
            b'C' | b'c' => match self.r.common()? {
                Some(variable) => {
                    let span = Span::new(start, self.r.pos);
                    self.r.read(&variable, span)?
                }
                None => return Err(no_value(at, letter)),
            },
            b',' | b'/' | b'%' | b':' | b')' | b']' => return Err(no_value(at, letter)),
            byte if byte > b' ' && !byte.is_ascii_alphanumeric() && byte != b';' => return Err(self.stray(start)),
            _ => return Err(no_value(at, letter)),
        };
        self.block.stored |= crate::block::bit(letter);
        Ok(if negative { -value } else { value })
    }

    fn unexpected_equals(&self, at: usize, letter: u8, value: f64) -> Fault {
        let equals = Span::new(self.r.pos, self.r.pos + 1);
        if letter == b'R' {
            return Fault::with(Id::GC215, Span::new(at, self.r.pos + 1), &[&value, &value]);
        }
        Fault::with(Id::GC220, equals, &[&'=', &format!("{}{value}", char::from(letter))])
    }

    #[inline]
    pub fn put(&mut self, letter: u8, word: Word) {
        if let Some(first) = self.block.word(letter) {
            let column = characters(self.r.text, first.span.start as usize) + 1;
            self.faults.push(Fault::with(Id::GC301, word.span, &[&char::from(letter), &column]));
            return;
        }
        self.block.put(letter, word);
    }

    #[inline]
    fn put_g(&mut self, word: Word) {
        let tenths = word.value * 10.0;
        let rounded = tenths.round();
        if (tenths - rounded).abs() > 1e-6 {
            self.faults.push(Fault::with(Id::GC217, word.span, &[&word.value]));
            return;
        }
        let code = self.dialect.code(rounded as u16);
        let alone = matches!(code.group, Group::Nothing | Group::OneShot) || !self.block.has_group(code.group);
        if code.decision == Decision::Yes && alone || self.accept_g(code, word.span) {
            self.block.groups |= code.group.bit();
            self.block.g.push(GWord { code, span: word.span });
        }
    }

    /// Repeated, clashing, ignored and refused codes; true if the code still counts.
    #[cold]
    fn accept_g(&mut self, code: codes::GCode, span: Span) -> bool {
        let text = codes::number(code.tenths);
        match code.decision {
            Decision::Refused(id) => {
                self.block.refused_motion |= code.group == Group::Motion;
                self.faults.push(Fault::with(id, span, &[&text]));
            }
            Decision::Ignored => self.faults.push(Fault::with(Id::GW914, span, &[&text])),
            Decision::Yes => {
                let first = *self.block.code_of(code.group).expect("only a present group clashes");
                let (one, two) = (format!("G{}", codes::number(first.code.tenths)), format!("G{text}"));
                match codes::beside(first.code.tenths, code.tenths) {
                    Beside::First => {}
                    Beside::Second => {
                        self.block.g.retain(|g| g.code.group != code.group);
                        return true;
                    }
                    Beside::Twice => self.faults.push(Fault::with(Id::GW913, span, &[&two])),
                    Beside::Clash => self.faults.push(Fault::with(Id::GC302, span, &[&one, &two, &code.group.name()])),
                }
            }
        }
        code.decision == Decision::Ignored
    }

    fn put_m(&mut self, word: Word) {
        let number = word.value as u16;
        if self.block.m.len() >= MAX_M {
            self.faults.push(Fault::new(Id::GC221, word.span));
            return;
        }
        let group = m_group(number);
        let clash = self.block.m.iter().find(|m| {
            m_group(m.number) == group
                && (group != MGroup::User || m.number == number)
                && !(group == MGroup::Coolant && m.number != number && m.number != 9 && number != 9)
        });
        if let Some(first) = clash {
            let (one, two) = (format!("M{}", first.number), format!("M{number}"));
            let fault = if first.number == number {
                Fault::with(Id::GW913, word.span, &[&two])
            } else {
                Fault::with(Id::GC302, word.span, &[&one, &two, &group.name()])
            };
            self.faults.push(fault);
            return;
        }
        self.block.m.push(MWord { number, span: word.span });
    }

    /// Two letters or more in a row.
    #[cold]
    fn run(&mut self) -> Check<()> {
        let at = self.r.pos;
        if let Some(variable) = self.r.common()? {
            return self.assignment(variable, at);
        }
        let word = self.r.letters(at, true);
        if statements::keyword(self, word)? {
            return Ok(());
        }
        let mut end = at + word.len();
        let digits = self.r.text[end..].iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
        let equals =
            end + digits + self.r.text[end + digits..].iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
        if self.r.at(equals) == b'=' && self.r.at(equals + 1) != b'=' {
            if word.eq_ignore_ascii_case(b"CR") && self.block.has_any(AXIS_LETTERS) {
                self.r.pos = at + 1; // CR= is Sinumerik's R
                return self.word(b'R');
            }
            let name = String::from_utf8_lossy(&self.r.text[at..end + digits]).into_owned();
            if digits > 0 {
                return Err(Fault::with(Id::GC219, Span::new(at, end + digits), &[&name]));
            }
            self.r.pos = end;
            return self.assignment(Variable::Name(crate::expression::short(&name)), at);
        }
        if word.len() == 3 && crate::expression::is_common(&self.r.text[at + 1..]) {
            return self.word(word[0].to_ascii_uppercase()); // XCI5
        }
        while matches!(self.r.at(end), b'0'..=b'9' | b'.' | b'-' | b'+' | b'_') || self.r.at(end).is_ascii_alphabetic()
        {
            end += 1;
        }
        let text = String::from_utf8_lossy(word).into_owned();
        let fault = Fault::with(Id::GC201, Span::new(at, at + word.len()), &[&text]);
        if word.len() > 2 && self.block.mask & !crate::block::bit(b'N') == 0 && self.block.g.is_empty() {
            return Err(fault); // a statement of another dialect: what follows belongs to it
        }
        self.faults.push(fault);
        self.r.pos = end;
        self.grow(at);
        Ok(())
    }

    fn hash_assignment(&mut self) -> Check<()> {
        let at = self.r.pos;
        let variable = self.r.hash_variable()?;
        self.assignment(variable, at)
    }

    /// `variable = expression`, with the position behind the variable.
    pub fn assignment(&mut self, variable: Variable, at: usize) -> Check<()> {
        let span = Span::new(at, self.r.pos);
        self.r.blanks();
        if self.r.peek() != b'=' {
            return Err(Fault::new(Id::GC718, span));
        }
        self.r.pos += 1;
        self.r.blanks();
        if matches!(self.r.peek(), 0 | b';' | b'(') {
            return Err(Fault::new(Id::GC718, span));
        }
        self.r.assigning = true;
        let value = self.r.expression()?;
        self.r.assigning = false;
        check_assignment(self.r.env.variables, &variable, value, span)?;
        self.grow(at);
        if self.r.assigned.iter().any(|a| a.variable == variable) {
            self.faults.push(Fault::with(Id::GW928, span, &[&variable]));
        }
        self.r.assigned.push(Assignment { variable, value, span });
        Ok(())
    }
}

fn no_value(at: usize, letter: u8) -> Fault {
    Fault::with(Id::GC202, Span::new(at, at + 1), &[&char::from(letter)])
}

/// Used by the statements: is this statement alone in its block?
pub(crate) fn set_statement(parser: &mut Parser, statement: Statement, at: usize) {
    parser.grow(at);
    parser.block.statement = Some(statement);
}
