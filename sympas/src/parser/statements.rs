//! Statements (5.3.5).

use super::declarations::DECLARATIONS;
use super::{Lost, Parse, Parser};
use crate::ast::{Name, Statement, StatementKind};
use crate::diagnostics::{Fault, Id, Phrase};
use crate::token::{Keyword, Symbol, TokenKind};

/// The keywords that begin a statement.
const STARTS: [Keyword; 6] =
    [Keyword::Begin, Keyword::If, Keyword::While, Keyword::Repeat, Keyword::For, Keyword::Goto];

impl Parser<'_> {
    /// Statements up to `end`, `until`, the end of the text, or a declaration that shows that an `end` is missing.
    pub(super) fn sequence(&mut self) -> Vec<Statement> {
        let mut list = Vec::new();
        let mut lost = false;
        loop {
            let from = self.at;
            match self.statement() {
                Ok(statement) => list.push(statement),
                Err(Lost) => {
                    lost = true;
                    self.skip_statement(from);
                }
            }
            if self.closes() {
                return list;
            }
            if self.is_keyword(Keyword::Else) {
                let span = self.span();
                if !lost {
                    self.report(Fault::new(Id::SP212, span));
                }
                self.advance();
            } else if !self.eat_symbol(Symbol::Semicolon) && !lost {
                self.expected("';'");
                if !self.starts_statement() {
                    self.skip_statement(self.at);
                    self.eat_symbol(Symbol::Semicolon);
                }
            }
            lost = lost && self.is_keyword(Keyword::Else);
        }
    }
    /// True where a sequence ends.
    fn closes(&self) -> bool {
        match self.keyword() {
            Some(Keyword::End | Keyword::Until) => true,
            Some(k) => DECLARATIONS.contains(&k),
            None => self.at_end() || self.is_final_point(),
        }
    }
    /// True behind `end.`: the program was meant to end here.
    fn is_final_point(&self) -> bool {
        let behind_end = self.at > 0 && self.tokens[self.at - 1].kind == TokenKind::Keyword(Keyword::End);
        behind_end && self.is_symbol(Symbol::Point)
    }
    fn starts_statement(&self) -> bool {
        matches!(self.kind(), TokenKind::Name(_)) || self.keyword().is_some_and(|k| STARTS.contains(&k))
    }
    /// Goes to where the next statement plainly begins, and at least one token on from where the lost one began.
    fn skip_statement(&mut self, from: usize) {
        if self.at == from && !self.closes() && !self.is_symbol(Symbol::Semicolon) {
            self.advance();
        }
        while !self.closes()
            && !self.is_symbol(Symbol::Semicolon)
            && !self.keyword().is_some_and(|k| STARTS.contains(&k) || k == Keyword::Else)
        {
            self.advance();
        }
    }
    pub(super) fn statement(&mut self) -> Parse<Statement> {
        self.deeper(|p| {
            let span = p.span();
            let mut labels = Vec::new();
            while matches!(p.kind(), TokenKind::Name(_)) && p.symbol_at(1, Symbol::Colon) {
                labels.push(p.expect_name(["a label", "ein Label"])?);
                p.advance();
            }
            let span = if labels.is_empty() { span } else { p.span() };
            let kind = p.unlabelled()?;
            Ok(Statement { labels, span, kind })
        })
    }
    fn unlabelled(&mut self) -> Parse<StatementKind> {
        match self.kind().clone() {
            TokenKind::Name(_) => self.assignment_or_call(),
            TokenKind::Keyword(Keyword::Begin) => self.compound(),
            TokenKind::Keyword(Keyword::If) => self.if_statement(),
            TokenKind::Keyword(Keyword::While) => self.while_statement(),
            TokenKind::Keyword(Keyword::Repeat) => self.repeat_statement(),
            TokenKind::Keyword(Keyword::For) => self.for_statement(),
            TokenKind::Keyword(Keyword::Goto) => {
                self.advance();
                Ok(StatementKind::Goto(self.expect_name(["a label", "ein Label"])?))
            }
            TokenKind::Symbol(Symbol::Semicolon) | TokenKind::Keyword(Keyword::Else) => Ok(StatementKind::Empty),
            _ if self.closes() => Ok(StatementKind::Empty),
            TokenKind::Keyword(k) if self.symbol_at(1, Symbol::Assign) => {
                let span = self.span();
                Err(self.report(Fault::new(Id::SP205, span).with(k.text())))
            }
            _ => {
                let (span, shown) = (self.span(), self.shown());
                Err(self.report(Fault::new(Id::SP202, span).with(shown)))
            }
        }
    }
    fn assignment_or_call(&mut self) -> Parse<StatementKind> {
        let next = |s| self.symbol_at(1, s);
        if !next(Symbol::Assign) && !next(Symbol::Point) && !next(Symbol::OpenBracket) {
            let call = self.call()?;
            if self.is_symbol(Symbol::Equal) && !call.parentheses {
                return Err(self.expected("':='"));
            }
            return Ok(StatementKind::Call(call));
        }
        let target = self.reference()?;
        self.expect_symbol(Symbol::Assign)?;
        Ok(StatementKind::Assign { target, value: self.expression()? })
    }
    fn compound(&mut self) -> Parse<StatementKind> {
        self.advance();
        let body = self.sequence();
        self.expect_keyword(Keyword::End)?;
        Ok(StatementKind::Compound(body))
    }
    fn if_statement(&mut self) -> Parse<StatementKind> {
        self.advance();
        let condition = self.expression()?;
        self.expect_keyword(Keyword::Then)?;
        let then = Box::new(self.statement()?);
        let stray = self.is_symbol(Symbol::Semicolon) && self.token(1).kind == TokenKind::Keyword(Keyword::Else);
        if stray {
            self.advance();
        }
        let otherwise = if self.eat_keyword(Keyword::Else) { Some(Box::new(self.statement()?)) } else { None };
        Ok(StatementKind::If { condition, then, otherwise })
    }
    fn while_statement(&mut self) -> Parse<StatementKind> {
        self.advance();
        let condition = self.expression()?;
        self.expect_keyword(Keyword::Do)?;
        Ok(StatementKind::While { condition, body: Box::new(self.statement()?) })
    }
    fn repeat_statement(&mut self) -> Parse<StatementKind> {
        self.advance();
        let body = self.sequence();
        let until = self.span();
        self.expect_keyword(Keyword::Until)?;
        Ok(StatementKind::Repeat { body, condition: self.expression()?, until })
    }
    fn for_statement(&mut self) -> Parse<StatementKind> {
        self.advance();
        if !matches!(self.kind(), TokenKind::Name(_)) {
            return Err(self.expect_name(["a variable", "eine Variable"]).err().unwrap_or(Lost));
        }
        let variable = self.reference()?;
        self.expect_symbol(Symbol::Assign)?;
        let from = self.expression()?;
        let down = self.is_keyword(Keyword::Downto);
        if !down && !self.is_keyword(Keyword::To) {
            return Err(self.expected(Phrase::new("'to' or 'downto'", "'to' oder 'downto'")));
        }
        self.advance();
        let to = self.expression()?;
        self.expect_keyword(Keyword::Do)?;
        Ok(StatementKind::For { variable, from, to, down, body: Box::new(self.statement()?) })
    }
    /// True for commands whose arguments are `name := value` (6.6): there `;` may separate them.
    pub(super) fn takes_values(&self, name: &Name) -> bool {
        use motion_kernel::sap::tables::{Form, command};
        command(&name.text).is_some_and(|(c, _)| {
            matches!(c.form(), Form::Values { .. } | Form::Circle | Form::Helix | Form::Circle3d | Form::SpoolFunction)
        })
    }
}
