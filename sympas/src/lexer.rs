//! The scanner (chapter 5.2): text with its includes becomes one list of tokens.
//!
//! Strings and comments are found in one pass, so neither hides the other. Directives are comments that begin with
//! `{$`; an include is scanned in place, a task directive is kept with the number of tokens before it.

use std::rc::Rc;

use crate::diagnostics::{Fault, Id, Reports};
use crate::source::{Loader, Sources, Span, decode};
use crate::token::{Keyword, Symbol, Token, TokenKind};

/// Text of one compilation, includes counted as often as they are included.
pub const MAX_SOURCE_MIB: usize = 4;
/// `{$I}` levels below the job itself (6.7.1).
pub const MAX_INCLUDE_LEVELS: usize = 15;
const MAX_INCLUDES: usize = 1000;
/// Characters of a name that count (5.2.3.2.1).
const SIGNIFICANT: usize = 32;

/// `{$TASK n}`: the number, or the name of a constant that is declared above.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskDirective {
    pub span: Span,
    pub number: TokenKind,
    /// Tokens in front of the directive.
    pub at: usize,
}

/// A scanned text.
#[derive(Debug, Default)]
pub struct Scanned {
    /// Ends with [`TokenKind::End`].
    pub tokens: Vec<Token>,
    pub tasks: Vec<TaskDirective>,
    pub full_system: bool,
}

/// Scans `text` and everything that it includes.
pub fn scan(
    name: &str,
    bytes: &[u8],
    loader: &mut dyn Loader,
    sources: &mut Sources,
    reports: &mut Reports,
) -> Scanned {
    let mut lexer = Lexer { loader, sources, reports, out: Scanned::default(), files: Vec::new(), total: 0 };
    lexer.open(name.to_owned(), bytes, Span { line: 1, column: 1, ..Span::default() });
    while !lexer.files.is_empty() {
        lexer.step();
        if lexer.reports.stopped() {
            break;
        }
    }
    let last = lexer.sources.files.first().map_or(1, |f| f.text.lines().count().max(1));
    let column = lexer.sources.line(0, last as u32).chars().count() + 1;
    let span = Span { file: 0, line: last as u32, column: column as u32, length: 1 };
    lexer.out.tokens.push(Token { kind: TokenKind::End, span });
    lexer.out
}

/// A place inside one text.
struct Cursor {
    text: Rc<str>,
    file: u16,
    at: usize,
    line: u32,
    column: u32,
}

impl Cursor {
    fn peek(&self, ahead: usize) -> u8 {
        self.text.as_bytes().get(self.at + ahead).copied().unwrap_or(0)
    }
    fn is_done(&self) -> bool {
        self.at >= self.text.len()
    }
    fn bump(&mut self) {
        let byte = self.peek(0);
        self.at += 1;
        if byte == b'\n' {
            (self.line, self.column) = (self.line + 1, 1);
        } else if self.peek(0) & 0xC0 != 0x80 {
            self.column += 1;
        }
    }
    fn skip(&mut self, bytes: usize) {
        (0..bytes).for_each(|_| self.bump());
    }
    fn skip_while(&mut self, test: impl Fn(u8) -> bool) {
        while !self.is_done() && test(self.peek(0)) {
            self.bump();
        }
    }
    fn span(&self) -> Span {
        Span { file: self.file, line: self.line, column: self.column, length: 1 }
    }
    fn since(&self, start: Span) -> Span {
        let length = if self.line == start.line { self.column - start.column } else { 1 };
        Span { length: length.max(1), ..start }
    }
}

const fn is_letter(byte: u8) -> bool {
    byte.is_ascii_alphabetic() || byte == b'_'
}
const fn is_word(byte: u8) -> bool {
    is_letter(byte) || byte.is_ascii_digit()
}
fn is_digit(byte: u8) -> bool {
    byte.is_ascii_digit()
}

struct Lexer<'a> {
    loader: &'a mut dyn Loader,
    sources: &'a mut Sources,
    reports: &'a mut Reports,
    out: Scanned,
    files: Vec<Cursor>,
    total: usize,
}

impl Lexer<'_> {
    fn fault(&mut self, fault: Fault) {
        self.reports.add(fault);
    }
    /// Starts a text: the job, or an include at `place`.
    fn open(&mut self, name: String, bytes: &[u8], place: Span) {
        self.total += bytes.len();
        let controls = bytes.iter().take(4096).filter(|&&b| b < 8).count();
        let problem = if self.total > MAX_SOURCE_MIB << 20 {
            Some(Fault::new(Id::SP108, place).with(MAX_SOURCE_MIB))
        } else if controls > 0 {
            Some(Fault::new(Id::SP101, place).with(controls))
        } else {
            None
        };
        let text: Rc<str> = if problem.is_some() { "".into() } else { decode(bytes).into() };
        let file = self.sources.add(name, text.to_string());
        match problem {
            Some(fault) => self.fault(fault),
            None => self.files.push(Cursor { text, file, at: 0, line: 1, column: 1 }),
        }
    }
    fn cursor(&mut self) -> &mut Cursor {
        self.files.last_mut().expect("a text is open")
    }
    fn push(&mut self, kind: TokenKind, start: Span) {
        let span = self.cursor().since(start);
        self.out.tokens.push(Token { kind, span });
    }
    fn previous(&self) -> Option<&TokenKind> {
        self.out.tokens.last().map(|t| &t.kind)
    }
    /// One token, comment or blank of the innermost text, or its end.
    fn step(&mut self) {
        let cursor = self.cursor();
        if cursor.is_done() {
            self.files.pop();
            return;
        }
        let (here, next) = (cursor.peek(0), cursor.peek(1));
        match here {
            b' ' | b'\t' | b'\n' | b'\r' | 0x0C | 0x1A => cursor.bump(),
            b'{' if next == b'$' => self.directive(),
            b'{' => {
                self.comment();
            }
            b'/' if next == b'/' => cursor.skip_while(|b| b != b'\n'),
            b'\'' => self.string(),
            b'$' => self.hexadecimal(),
            b'.' if is_digit(next) && !self.selects() => self.number(),
            _ if is_digit(here) => self.number(),
            _ if is_letter(here) => self.word(),
            _ => self.symbol(),
        }
    }
    /// True behind a name or `]`, where a point is always the selector.
    fn selects(&self) -> bool {
        matches!(self.previous(), Some(TokenKind::Name(_) | TokenKind::Symbol(Symbol::CloseBracket)))
    }
    /// Skips `{...}` and returns its inside, or `None` if it is not closed.
    fn comment(&mut self) -> Option<String> {
        let cursor = self.cursor();
        let (start, from) = (cursor.span(), cursor.at + 1);
        cursor.skip_while(|b| b != b'}');
        let text = cursor.text[from..cursor.at].to_owned();
        if cursor.is_done() {
            self.fault(Fault::new(Id::SP103, start));
            return None;
        }
        cursor.bump();
        Some(text)
    }
    fn string(&mut self) {
        let cursor = self.cursor();
        let (start, from) = (cursor.span(), cursor.at + 1);
        cursor.bump();
        cursor.skip_while(|b| b != b'\'' && b != b'\n');
        let text: Rc<str> = cursor.text[from..cursor.at].trim_end_matches('\r').into();
        if cursor.peek(0) == b'\'' && !cursor.is_done() {
            cursor.bump();
        } else {
            let span = cursor.since(start);
            self.fault(Fault::new(Id::SP104, span));
        }
        self.push(TokenKind::Text(text), start);
    }
    fn hexadecimal(&mut self) {
        let cursor = self.cursor();
        let start = cursor.span();
        cursor.bump();
        let from = cursor.at;
        cursor.skip_while(is_word);
        let text = &cursor.text[from..cursor.at];
        let digits = text.trim_start_matches('0');
        let bits = if digits.len() > 16 {
            Ok(u64::MAX)
        } else {
            u64::from_str_radix(if digits.is_empty() { "0" } else { digits }, 16)
        };
        let problem = match bits {
            _ if text.is_empty() => Some(Fault::new(Id::SP106, cursor.since(start))),
            _ if !text.bytes().all(|b| b.is_ascii_hexdigit()) => {
                Some(Fault::new(Id::SP107, cursor.since(start)).with(format!("${text}")))
            }
            _ => None,
        };
        if let Some(fault) = problem {
            self.fault(fault);
        }
        self.push(TokenKind::Hexadecimal(bits.unwrap_or(0)), start);
    }
    fn number(&mut self) {
        let whole_only = matches!(self.previous(), Some(TokenKind::Symbol(Symbol::Point)));
        let cursor = self.cursor();
        let (start, from) = (cursor.span(), cursor.at);
        cursor.skip_while(is_digit);
        let mut float = false;
        if !whole_only {
            if cursor.peek(0) == b'.' {
                float = true;
                cursor.bump();
                cursor.skip_while(is_digit);
            }
            let sign = usize::from(matches!(cursor.peek(1), b'+' | b'-'));
            if cursor.peek(0).eq_ignore_ascii_case(&b'e') && is_digit(cursor.peek(1 + sign)) {
                float = true;
                cursor.skip(1 + sign);
                cursor.skip_while(is_digit);
            }
        }
        let text = cursor.text[from..cursor.at].to_owned();
        self.check_tail(start, from);
        if !float {
            return self.push(TokenKind::Decimal(text.parse().unwrap_or(u64::MAX)), start);
        }
        let value: f64 = text.parse().unwrap_or(0.0);
        if value.is_infinite() {
            let span = self.cursor().since(start);
            self.fault(Fault::new(Id::SP116, span).with(text));
        }
        self.push(TokenKind::Float(if value.is_finite() { value } else { 0.0 }), start);
    }
    /// Letters directly behind a number are a mistake unless they are a keyword (`1to`).
    fn check_tail(&mut self, start: Span, from: usize) {
        let cursor = self.cursor();
        let tail = &cursor.text[cursor.at..];
        let word = &tail[..tail.bytes().take_while(|&b| is_word(b)).count()];
        if word.is_empty() || Keyword::of(word).is_some() {
            return;
        }
        let length = word.len();
        cursor.skip(length);
        let text: String = cursor.text[from..cursor.at].chars().take(40).collect();
        let fault = Fault::new(Id::SP107, cursor.since(start)).with(text);
        self.fault(fault);
    }
    fn word(&mut self) {
        let cursor = self.cursor();
        let (start, from) = (cursor.span(), cursor.at);
        cursor.skip_while(is_word);
        let text = &cursor.text[from..cursor.at];
        let kind = match Keyword::of(text) {
            Some(keyword) => TokenKind::Keyword(keyword),
            None => TokenKind::Name(text[..text.len().min(SIGNIFICANT)].into()),
        };
        self.push(kind, start);
    }
    fn symbol(&mut self) {
        let cursor = self.cursor();
        let start = cursor.span();
        let rest = &cursor.text.as_bytes()[cursor.at..];
        if let Some(symbol) = Symbol::ALL.iter().find(|s| rest.starts_with(s.text().as_bytes())) {
            cursor.skip(symbol.text().len());
            return self.push(TokenKind::Symbol(*symbol), start);
        }
        let c = cursor.text[cursor.at..].chars().next().unwrap_or('?');
        cursor.skip(c.len_utf8());
        let fault = match c {
            '}' => Fault::new(Id::SP105, start),
            _ => Fault::new(Id::SP102, start).with(c.escape_debug()).with(format!("{:04X}", u32::from(c))),
        };
        self.fault(fault);
    }
    /// `{$name ...}` (6.7).
    fn directive(&mut self) {
        let start = self.cursor().span();
        let Some(text) = self.comment() else { return };
        let span = self.cursor().since(start);
        let body = text[1..].trim_end();
        let name = &body[..body.bytes().take_while(|&b| is_word(b)).count()];
        let argument = body[name.len()..].trim();
        let spaced = body[name.len()..].starts_with([' ', '\t']);
        let wrong = |what: [&str; 2]| {
            Fault::new(Id::SP112, span)
                .with(name.to_uppercase())
                .with(crate::diagnostics::Phrase::new(what[0], what[1]))
        };
        match name.to_ascii_uppercase().as_str() {
            "I" if spaced && !argument.is_empty() && !argument.contains('\n') => self.include(argument, span),
            "I" => self.fault(wrong(["a file name", "Dateiname"])),
            "TASK" => match task_number(argument) {
                Some(number) if spaced => {
                    let at = self.out.tokens.len();
                    self.out.tasks.push(TaskDirective { span, number, at });
                }
                _ => self.fault(wrong(["a number or a constant", "Zahl oder Konstante"])),
            },
            "FULLSYSTEM" if argument.is_empty() => self.out.full_system = true,
            "FULLSYSTEM" => self.fault(wrong(["no parameter", "kein Parameter"])),
            _ => {
                let shown: String = if name.is_empty() { body.chars().take(20).collect() } else { name.to_owned() };
                self.fault(Fault::new(Id::SP111, span).with(shown));
            }
        }
    }
    fn include(&mut self, name: &str, span: Span) {
        if self.files.len() > MAX_INCLUDE_LEVELS {
            return self.fault(Fault::new(Id::SP110, span).with(MAX_INCLUDE_LEVELS));
        }
        if self.sources.files.len() > MAX_INCLUDES {
            return self.fault(Fault::new(Id::SP115, span).with(MAX_INCLUDES));
        }
        let from = self.sources.name(span.file).to_owned();
        match self.loader.load(name, &from) {
            Ok((shown, bytes)) => self.open(shown, &bytes, span),
            Err(text) => self.fault(Fault::new(Id::SP109, span).with(name).with(text)),
        }
    }
}

fn task_number(text: &str) -> Option<TokenKind> {
    let word = !text.is_empty() && text.bytes().all(is_word);
    match word {
        true if text.bytes().all(is_digit) => Some(TokenKind::Decimal(text.parse().unwrap_or(u64::MAX))),
        true if !is_digit(text.as_bytes()[0]) => Some(TokenKind::Name(text[..text.len().min(SIGNIFICANT)].into())),
        _ => None,
    }
}
