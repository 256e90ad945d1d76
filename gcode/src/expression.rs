//! Expressions (docs/dialect.md, section 15.2), evaluated while they are read.

use crate::arithmetic::{FUNCTIONS, OPERATORS, Op, apply, call, finite};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::number;
use crate::variables::{Assignment, Variable, Variables};

/// What an expression may look at.
pub struct Environment<'a> {
    pub variables: &'a Variables,
    /// Read-only system variables such as `#5041`.
    pub system: &'a dyn Fn(u32) -> Option<f64>,
    /// `#<name>` is allowed (oword dialect).
    pub angle_names: bool,
    /// Nothing is executed: values are unknown, so only the form is checked.
    pub dry: bool,
    /// Difference within which EQ and NE hold.
    pub equal: f64,
}

/// Reader of one line: position and what was found on the way.
pub struct Reader<'a, 'e> {
    pub text: &'a [u8],
    pub pos: usize,
    pub env: &'e Environment<'e>,
    /// Assignments read before in this block.
    pub assigned: Vec<Assignment>,
    /// True inside the right side of an assignment, which sees the earlier ones of the block.
    pub assigning: bool,
    pub warnings: Vec<Fault>,
    depth: usize,
}

const MAX_DEPTH: usize = 32;

impl<'a, 'e> Reader<'a, 'e> {
    pub fn new(text: &'a [u8], env: &'e Environment<'e>) -> Self {
        Reader { text, pos: 0, env, assigned: Vec::new(), assigning: false, warnings: Vec::new(), depth: 0 }
    }
    #[inline]
    pub fn at(&self, pos: usize) -> u8 {
        self.text.get(pos).copied().unwrap_or(0)
    }
    #[inline]
    pub fn peek(&self) -> u8 {
        self.at(self.pos)
    }
    #[inline]
    pub fn blanks(&mut self) {
        while matches!(self.peek(), b' ' | b'\t' | 0x0C | 0x7F) {
            self.pos += 1;
        }
    }
    /// The run of letters (and `_`, if asked for) at a position.
    pub fn letters(&self, pos: usize, underscore: bool) -> &'a [u8] {
        let is_part = |b: &&u8| b.is_ascii_alphabetic() || underscore && **b == b'_';
        &self.text[pos..pos + self.text[pos..].iter().take_while(is_part).count()]
    }
    /// A span of one character, whole even if it takes several bytes.
    pub fn character(&self, pos: usize) -> Span {
        let more = self.text.iter().skip(pos + 1).take_while(|&&b| b & 0xC0 == 0x80).count();
        Span::new(pos, pos + 1 + if self.at(pos) >= 0x80 { more } else { 0 })
    }
    fn nest(&mut self, at: usize) -> Check<()> {
        self.depth += 1;
        if self.depth > MAX_DEPTH { Err(Fault::new(Id::GC709, self.character(at))) } else { Ok(()) }
    }

    /// `[expression]`, with the position on the bracket.
    pub fn bracket(&mut self) -> Check<f64> {
        let open = self.pos;
        self.nest(open)?;
        self.pos += 1;
        let value = self.expression()?;
        self.close(open)?;
        self.depth -= 1;
        Ok(value)
    }
    fn close(&mut self, open: usize) -> Check<()> {
        self.blanks();
        if self.peek() != b']' {
            return Err(Fault::new(Id::GC713, Span::new(open, open + 1)));
        }
        self.pos += 1;
        Ok(())
    }
    /// An expression up to where no operator follows.
    pub fn expression(&mut self) -> Check<f64> {
        self.binary(1)
    }

    fn binary(&mut self, least: u8) -> Check<f64> {
        let mut left = self.unary()?;
        while let Some((op, precedence, at, length)) = self.operator()
            && precedence >= least
        {
            self.pos = at + length;
            let right = if op == Op::Power {
                self.nest(at)?;
                let right = self.binary(precedence)?;
                self.depth -= 1;
                right
            } else {
                self.binary(precedence + 1)?
            };
            left = if self.env.dry { 1.0 } else { apply(op, left, right, self.env.equal, Span::new(at, at + length))? };
        }
        Ok(left)
    }
    fn operator(&self) -> Option<(Op, u8, usize, usize)> {
        let skipped = self.text[self.pos..].iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
        let at = self.pos + skipped;
        let word = self.letters(at, false);
        let found = OPERATORS.iter().find(|(text, ..)| {
            if word.is_empty() {
                self.text[at..].starts_with(text.as_bytes())
            } else {
                word.eq_ignore_ascii_case(text.as_bytes())
            }
        });
        found.map(|&(text, op, precedence)| (op, precedence, at, text.len()))
    }
    fn unary(&mut self) -> Check<f64> {
        self.blanks();
        let at = self.pos;
        match self.peek() {
            b'+' | b'-' => {
                self.nest(at)?;
                self.pos += 1;
                let value = self.unary()?;
                self.depth -= 1;
                Ok(if self.at(at) == b'-' { -value } else { value })
            }
            b'[' => self.bracket(),
            b'#' => self.hash(),
            b'"' => Err(Fault::new(Id::GC719, Span::new(at, at + 1))),
            b'0'..=b'9' | b'.' => {
                let number = number::scan_operand(self.text, at).map_err(|f| operand(f, self.character(at)))?;
                self.pos = number.end;
                if number.rounded {
                    self.warnings.push(Fault::new(Id::GW905, Span::new(at, number.end)));
                }
                Ok(number.value)
            }
            b'A'..=b'Z' | b'a'..=b'z' | b'_' => self.word(),
            _ => Err(Fault::new(Id::GC714, self.character(at))),
        }
    }

    /// A function, a common variable or a name.
    fn word(&mut self) -> Check<f64> {
        let at = self.pos;
        if let Some(variable) = self.common()? {
            return self.read(&variable, Span::new(at, self.pos));
        }
        let word = self.letters(at, true);
        let span = Span::new(at, at + word.len());
        let text = String::from_utf8_lossy(word).into_owned();
        self.pos += word.len();
        self.foreign_name(at, &text)?;
        self.blanks();
        if self.peek() == b'[' {
            let upper = text.to_ascii_uppercase();
            let Some(&(name, least, most)) = FUNCTIONS.iter().find(|f| f.0 == upper) else {
                return Err(Fault::with(Id::GC715, span, &[&text]));
            };
            return self.function(name, (least, most), span);
        }
        if FUNCTIONS.iter().any(|f| f.0.eq_ignore_ascii_case(&text)) {
            return Err(Fault::with(Id::GC716, span, &[&text, &1]));
        }
        self.read(&Variable::Name(short(&text)), span)
    }
    /// Names that other dialects have here: `R1`, `VC1`, `IC(10)`; a single letter is an address.
    #[inline]
    fn foreign_name(&self, at: usize, text: &str) -> Check<()> {
        let digits = self.text[self.pos..].iter().take_while(|b| b.is_ascii_digit()).count();
        let shown = String::from_utf8_lossy(&self.text[at..self.pos + digits]).into_owned();
        let span = Span::new(at, self.pos + digits);
        if digits > 0 && text.eq_ignore_ascii_case("R") {
            let number = &shown[1..];
            return Err(Fault::with(Id::GC215, span, &[&number, &number]));
        }
        if text.len() < 2 {
            return Err(Fault::new(Id::GC714, span));
        }
        if digits > 0 {
            return Err(Fault::with(Id::GC219, span, &[&shown]));
        }
        let unset = || self.env.variables.get(&Variable::Name(short(text))).is_none();
        if self.peek() == b'(' && !FUNCTIONS.iter().any(|f| f.0.eq_ignore_ascii_case(text)) && unset() {
            return Err(Fault::with(Id::GC715, span, &[&shown]));
        }
        Ok(())
    }
    fn function(&mut self, name: &str, (least, most): (usize, usize), span: Span) -> Check<f64> {
        let mut arguments = vec![];
        let open = self.pos;
        self.nest(open)?;
        self.pos += 1;
        loop {
            arguments.push(self.expression()?);
            self.blanks();
            if self.peek() != b',' {
                break;
            }
            self.pos += 1;
        }
        self.close(open)?;
        self.depth -= 1;
        if arguments.len() < least || arguments.len() > most {
            return Err(Fault::with(Id::GC716, span, &[&name, &least]));
        }
        if name == "ATAN" {
            self.blanks();
            if self.peek() != b'/' || self.at(self.pos + 1) != b'[' {
                return Err(Fault::with(Id::GC716, span, &[&name, &2]));
            }
            self.pos += 1;
            arguments.push(self.bracket()?);
        }
        if self.env.dry { Ok(1.0) } else { finite(call(name, &arguments, span)?, span) }
    }

    /// `#n`, `##n`, `#[..]`, `#<name>`: the value.
    fn hash(&mut self) -> Check<f64> {
        let at = self.pos;
        let variable = self.hash_variable()?;
        self.read(&variable, Span::new(at, self.pos))
    }
    /// `#n` and its kin as a name; the position is on the `#`.
    pub fn hash_variable(&mut self) -> Check<Variable> {
        let at = self.pos;
        self.nest(at)?;
        self.pos += 1;
        let number = match self.peek() {
            b'<' => {
                self.depth -= 1;
                return self.angle_name(at);
            }
            b'[' => self.bracket()?,
            b'#' => self.hash()?,
            b'0'..=b'9' => {
                let start = self.pos;
                while self.peek().is_ascii_digit() {
                    self.pos += 1;
                }
                let text = std::str::from_utf8(&self.text[start..self.pos]).unwrap_or("");
                text.parse().unwrap_or(f64::INFINITY)
            }
            _ => return Err(Fault::new(Id::GC703, Span::new(at, at + 1))),
        };
        self.depth -= 1;
        let valid = number.fract() == 0.0 && (0.0..=9999.0).contains(&number);
        if !valid && !self.env.dry {
            return Err(Fault::new(Id::GC703, Span::new(at, self.pos)));
        }
        Ok(Variable::Hash(number as u32))
    }
    fn angle_name(&mut self, at: usize) -> Check<Variable> {
        let rest = &self.text[self.pos + 1..];
        let Some(length) = rest.iter().position(|&b| b == b'>').filter(|&n| n > 0) else {
            return Err(Fault::new(Id::GC703, Span::new(at, at + 2)));
        };
        let name: String = String::from_utf8_lossy(&rest[..length]).split_whitespace().collect();
        self.pos += length + 2;
        if !self.env.angle_names {
            return Err(Fault::new(Id::GC611, Span::new(at, self.pos)));
        }
        Ok(Variable::Name(name.to_ascii_lowercase()))
    }
    /// `CIn` or `CDn`, if one stands here.
    pub fn common(&mut self) -> Check<Option<Variable>> {
        let at = self.pos;
        if !is_common(&self.text[at..]) {
            return Ok(None);
        }
        let integer = self.at(at + 1).eq_ignore_ascii_case(&b'I');
        let digits = self.text[at + 2..].iter().take_while(|b| b.is_ascii_digit()).count();
        self.pos = at + 2 + digits;
        let text = std::str::from_utf8(&self.text[at + 2..self.pos]).unwrap_or("");
        match text.parse::<u16>() {
            Ok(n) if n <= 999 => Ok(Some(if integer { Variable::Ci(n) } else { Variable::Cd(n) })),
            _ => Err(Fault::with(Id::GC708, Span::new(at, self.pos), &[&text])),
        }
    }
    /// The value a variable has here, seen from inside the block.
    pub fn read(&mut self, variable: &Variable, span: Span) -> Check<f64> {
        if self.env.dry {
            return Ok(1.0);
        }
        if let Some(earlier) = self.assigned.iter().rev().find(|a| a.variable == *variable) {
            if self.assigning {
                return Ok(earlier.value);
            }
            return Err(Fault::with(Id::GC704, span, &[variable]));
        }
        if let Some(value) = self.env.variables.get(variable) {
            return Ok(value);
        }
        match variable {
            Variable::Hash(n) if *n == 0 || self.env.variables.is_free(*n) => {
                let empty = || Fault::with(Id::GC702, span, &[variable]);
                self.env.variables.vacant_zero.then_some(0.0).ok_or_else(empty)
            }
            Variable::Hash(n) => (self.env.system)(*n).ok_or_else(|| Fault::with(Id::GC701, span, &[n])),
            Variable::Ci(_) | Variable::Cd(_) => {
                self.warnings.push(Fault::with(Id::GW927, span, &[variable, &0]));
                Ok(0.0)
            }
            Variable::Name(name) => Err(Fault::with(Id::GC706, span, &[name])),
        }
    }
}

/// First 32 characters of a name are significant.
pub fn short(name: &str) -> String {
    name.chars().take(32).collect()
}

fn operand(fault: Fault, span: Span) -> Fault {
    if fault.id == Id::GC202 { Fault::new(Id::GC714, span) } else { fault }
}

/// `CI` or `CD` with an index stands here.
pub(crate) fn is_common(text: &[u8]) -> bool {
    matches!(text, [b'C' | b'c', b'I' | b'i' | b'D' | b'd', digit, ..] if digit.is_ascii_digit())
}
