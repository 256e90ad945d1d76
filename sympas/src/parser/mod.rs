//! Tokens to syntax tree. Reports every error of a text once: a statement or declaration that is wrong is left behind
//! and parsing goes on where the next one plainly begins.

mod declarations;
mod expressions;
mod statements;

use crate::ast::{Name, Program};
use crate::diagnostics::{Fault, Id, Phrase, Reports};
use crate::source::Span;
use crate::token::{Keyword, Symbol, Token, TokenKind};

/// Statements within statements and operands within parentheses, together.
pub const MAX_NESTING: usize = 150;
/// Height of the tree of one expression.
pub const MAX_HEIGHT: u16 = 300;

/// The error was reported; the construct is lost.
pub(crate) struct Lost;

pub(crate) type Parse<T> = Result<T, Lost>;

/// Parses the tokens of a program. What comes back is whole only if no error was reported.
pub fn parse(tokens: &[Token], reports: &mut Reports) -> Program {
    Parser { tokens, at: 0, depth: 0, given_up: false, lost_names: false, reports }.program()
}

pub(crate) struct Parser<'a> {
    tokens: &'a [Token],
    at: usize,
    depth: usize,
    /// Too deep to go on: what follows would only be misread.
    given_up: bool,
    /// A declaration was left behind.
    lost_names: bool,
    reports: &'a mut Reports,
}

impl Parser<'_> {
    fn token(&self, ahead: usize) -> &Token {
        self.tokens.get(self.at + ahead).unwrap_or_else(|| &self.tokens[self.tokens.len() - 1])
    }
    fn kind(&self) -> &TokenKind {
        &self.token(0).kind
    }
    fn span(&self) -> Span {
        self.token(0).span
    }
    /// Place of the token that was read last.
    fn last_span(&self) -> Span {
        self.tokens[self.at.saturating_sub(1).min(self.tokens.len() - 1)].span
    }
    fn advance(&mut self) {
        self.at = (self.at + 1).min(self.tokens.len() - 1);
    }
    fn at_end(&self) -> bool {
        *self.kind() == TokenKind::End
    }
    fn keyword(&self) -> Option<Keyword> {
        match self.kind() {
            TokenKind::Keyword(k) => Some(*k),
            _ => None,
        }
    }
    fn is_keyword(&self, keyword: Keyword) -> bool {
        self.keyword() == Some(keyword)
    }
    fn is_symbol(&self, symbol: Symbol) -> bool {
        self.symbol_at(0, symbol)
    }
    fn symbol_at(&self, ahead: usize, symbol: Symbol) -> bool {
        self.token(ahead).kind == TokenKind::Symbol(symbol)
    }
    fn eat_keyword(&mut self, keyword: Keyword) -> bool {
        let found = self.is_keyword(keyword);
        if found {
            self.advance();
        }
        found
    }
    fn eat_symbol(&mut self, symbol: Symbol) -> bool {
        let found = self.is_symbol(symbol);
        if found {
            self.advance();
        }
        found
    }
    fn report(&mut self, fault: Fault) -> Lost {
        if !self.given_up {
            self.reports.add(fault);
        }
        Lost
    }
    /// `{what} expected, '{token}' found`. What is missing at the end of a line is reported there.
    fn expected(&mut self, what: impl Into<Phrase>) -> Lost {
        self.expected_but(what, None)
    }
    /// As `expected`, with what may be meant.
    fn expected_but(&mut self, what: impl Into<Phrase>, near: Option<&str>) -> Lost {
        let (last, here) = (self.last_span(), self.span());
        let elsewhere = self.at > 0 && last.file == here.file && last.line < here.line;
        let span = if elsewhere { Span { column: last.column + last.length, length: 1, ..last } } else { here };
        let shown = self.shown();
        self.report(Fault::new(Id::SP201, span).with(what).with(shown).suggest(near))
    }
    fn shown(&self) -> Phrase {
        if self.at_end() { Phrase::new("end of text", "Textende") } else { self.token(0).shown().into() }
    }
    fn expect_symbol(&mut self, symbol: Symbol) -> Parse<()> {
        if self.eat_symbol(symbol) { Ok(()) } else { Err(self.expected(format!("'{}'", symbol.text()))) }
    }
    fn expect_keyword(&mut self, keyword: Keyword) -> Parse<()> {
        if self.eat_keyword(keyword) { Ok(()) } else { Err(self.expected(format!("'{}'", keyword.text()))) }
    }
    /// A name; `what` says of what, in both languages.
    fn expect_name(&mut self, what: [&str; 2]) -> Parse<Name> {
        let span = self.span();
        match self.kind().clone() {
            TokenKind::Name(text) => {
                self.advance();
                Ok(Name { text, span })
            }
            TokenKind::Keyword(k) => Err(self.report(Fault::new(Id::SP205, span).with(k.text()))),
            _ => Err(self.expected(Phrase::new(what[0], what[1]))),
        }
    }
    /// Names separated by commas, at least one.
    fn expect_names(&mut self, what: [&str; 2]) -> Parse<Vec<Name>> {
        let mut names = vec![self.expect_name(what)?];
        while self.eat_symbol(Symbol::Comma) {
            names.push(self.expect_name(what)?);
        }
        Ok(names)
    }
    fn is_word(&self, word: &str) -> bool {
        matches!(self.kind(), TokenKind::Name(text) if text.eq_ignore_ascii_case(word))
    }
    /// Runs a parser one level deeper.
    fn deeper<T>(&mut self, inner: impl FnOnce(&mut Self) -> Parse<T>) -> Parse<T> {
        if self.depth >= MAX_NESTING {
            let span = self.span();
            let lost = self.report(Fault::new(Id::SP206, span).with(MAX_NESTING));
            self.given_up = true;
            self.at = self.tokens.len() - 1;
            return Err(lost);
        }
        self.depth += 1;
        let result = inner(self);
        self.depth -= 1;
        result
    }
}
