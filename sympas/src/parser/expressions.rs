//! Expressions, references, calls (5.3.4), by rank (table 26).

use super::declarations::simple_type;
use super::{MAX_HEIGHT, Parse, Parser};
use crate::ast::{Argument, Binary, Call, Expr, ExprKind, Name, Qualifier, Reference, Unary};
use crate::diagnostics::{Fault, Id, Phrase};
use crate::source::Span;
use crate::token::{Keyword, Symbol, TokenKind};

/// Lowest rank of a sum, which excludes relations.
const SUM: u8 = 3;

impl Parser<'_> {
    pub(super) fn expression(&mut self) -> Parse<Expr> {
        let left = self.ranked(SUM)?;
        let Some(operator) = self.binary_operator().filter(|o| o.is_relation()) else { return Ok(left) };
        self.advance();
        let right = self.ranked(SUM)?;
        let relation = self.binary(operator, left, right)?;
        if self.binary_operator().is_some_and(Binary::is_relation) {
            let span = self.span();
            return Err(self.report(Fault::new(Id::SP204, span)));
        }
        Ok(relation)
    }
    /// Operators of that rank or a higher one (a smaller number), left to right.
    fn ranked(&mut self, rank: u8) -> Parse<Expr> {
        let mut left = if rank > 2 { self.ranked(rank - 1)? } else { self.factor()? };
        while let Some(operator) = self.binary_operator().or(self.div()).filter(|o| o.rank() == rank) {
            if operator == Binary::Div && !self.is_symbol(Symbol::Slash) {
                let span = self.span();
                self.report(Fault::new(Id::SP213, span));
            }
            self.advance();
            let right = if rank > 2 { self.ranked(rank - 1)? } else { self.factor()? };
            left = self.binary(operator, left, right)?;
        }
        Ok(left)
    }
    pub(super) fn binary_operator(&self) -> Option<Binary> {
        let text = match self.kind() {
            TokenKind::Keyword(k) => k.text(),
            TokenKind::Symbol(s) => s.text(),
            _ => return None,
        };
        Binary::ALL.iter().copied().find(|o| o.text() == text)
    }
    /// Pascal's `div`, a plain name here: an operator to whoever writes it between operands of one line.
    fn div(&self) -> Option<Binary> {
        let (last, here) = (self.last_span(), self.span());
        (self.is_word("div") && (last.file, last.line) == (here.file, here.line)).then_some(Binary::Div)
    }
    fn binary(&mut self, operator: Binary, left: Expr, right: Expr) -> Parse<Expr> {
        let (span, height) = (left.span.to(right.span), left.height.max(right.height) + 1);
        self.node(ExprKind::Binary(operator, Box::new(left), Box::new(right)), span, height)
    }
    fn node(&mut self, kind: ExprKind, span: Span, height: u16) -> Parse<Expr> {
        if height > MAX_HEIGHT {
            return Err(self.report(Fault::new(Id::SP206, span).with(MAX_HEIGHT)));
        }
        Ok(Expr { kind, span, height })
    }
    fn factor(&mut self) -> Parse<Expr> {
        self.deeper(Self::plain_factor)
    }
    fn plain_factor(&mut self) -> Parse<Expr> {
        let span = self.span();
        match self.kind().clone() {
            TokenKind::Symbol(Symbol::Minus) => {
                self.advance();
                if let TokenKind::Decimal(n) = *self.kind() {
                    self.advance();
                    return self.decimal(n, true, span.to(self.last_span()));
                }
                self.unary(Unary::Minus, span)
            }
            TokenKind::Symbol(Symbol::Plus) => {
                self.advance();
                self.unary(Unary::Plus, span)
            }
            TokenKind::Keyword(Keyword::Not) => {
                self.advance();
                self.unary(Unary::Not, span)
            }
            TokenKind::Symbol(Symbol::Open) => {
                self.advance();
                let inner = self.expression()?;
                self.expect_symbol(Symbol::Close)?;
                Ok(Expr { span: span.to(self.last_span()), ..inner })
            }
            TokenKind::Keyword(k) if simple_type(k).is_some() && self.symbol_at(1, Symbol::Open) => {
                self.skip_two();
                let inner = self.expression()?;
                self.expect_symbol(Symbol::Close)?;
                let (height, kind) =
                    (inner.height + 1, simple_type(k).unwrap_or(motion_kernel::sap::tables::Type::Integer));
                self.node(ExprKind::Convert(kind, Box::new(inner)), span.to(self.last_span()), height)
            }
            TokenKind::Name(_) if self.symbol_at(1, Symbol::Open) => {
                let call = self.call()?;
                let height = call.arguments.iter().map(|a| a.value.height).max().unwrap_or(0) + 1;
                self.node(ExprKind::Call(call), span.to(self.last_span()), height)
            }
            TokenKind::Name(_) => {
                let reference = self.reference()?;
                let inner = reference.index.iter().chain(reference.qualifier.iter().flat_map(|q| &q.index));
                let height = inner.map(|e| e.height).max().unwrap_or(0) + 1;
                self.node(ExprKind::Reference(reference), span.to(self.last_span()), height)
            }
            _ => self.literal(),
        }
    }
    fn skip_two(&mut self) {
        self.advance();
        self.advance();
    }
    fn unary(&mut self, operator: Unary, span: Span) -> Parse<Expr> {
        let inner = self.factor()?;
        let height = inner.height + 1;
        self.node(ExprKind::Unary(operator, Box::new(inner)), span.to(self.last_span()), height)
    }
    fn literal(&mut self) -> Parse<Expr> {
        let span = self.span();
        let kind = match self.kind().clone() {
            TokenKind::Decimal(n) => {
                self.advance();
                return self.decimal(n, false, span);
            }
            TokenKind::Hexadecimal(bits) => {
                let shown = self.token(0).shown();
                if bits > u64::from(u32::MAX) {
                    self.report(Fault::new(Id::SW904, span).with(shown).with("$7FFFFFFF"));
                }
                ExprKind::Integer(u32::try_from(bits).map_or(i32::MAX, |b| b as i32))
            }
            TokenKind::Float(x) => ExprKind::Double(x),
            TokenKind::Text(text) => ExprKind::Text(text),
            TokenKind::Keyword(k) if self.symbol_at(1, Symbol::Close) => {
                return Err(self.report(Fault::new(Id::SP205, span).with(k.text())));
            }
            _ => {
                let shown = self.shown();
                return Err(self.report(Fault::new(Id::SP203, span).with(shown)));
            }
        };
        self.advance();
        self.node(kind, span, 1)
    }
    /// A decimal constant with its sign, limited to 32 bits (5.2.3.7.1.1).
    fn decimal(&mut self, magnitude: u64, negative: bool, span: Span) -> Parse<Expr> {
        let wide = i64::try_from(magnitude).unwrap_or(i64::MAX);
        let value = if negative { -wide } else { wide };
        let limited = value.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
        if i64::from(limited) != value {
            self.report(Fault::new(Id::SW904, span).with(value).with(limited));
        }
        self.node(ExprKind::Integer(limited), span, 1)
    }
    /// The right side of a constant declaration: a literal or a name with a sign, nothing computed.
    pub(super) fn constant_value(&mut self) -> Parse<Expr> {
        let signed = self.is_symbol(Symbol::Minus) || self.is_symbol(Symbol::Plus);
        let value = &self.token(usize::from(signed)).kind;
        match value {
            TokenKind::Decimal(_) | TokenKind::Hexadecimal(_) | TokenKind::Float(_) | TokenKind::Name(_) => {
                let name = matches!(value, TokenKind::Name(_));
                let next = usize::from(signed) + 1;
                if name && (self.symbol_at(next, Symbol::Open) || self.symbol_at(next, Symbol::Point)) {
                    let span = self.span();
                    return Err(self.report(Fault::new(Id::SP209, span)));
                }
                self.plain_factor()
            }
            _ => {
                let span = self.span();
                Err(self.report(Fault::new(Id::SP209, span)))
            }
        }
    }
    /// A call in a statement, or in an expression where `(` follows the name.
    pub(super) fn call(&mut self) -> Parse<Call> {
        let name = self.expect_name(["a name", "ein Name"])?;
        if !self.eat_symbol(Symbol::Open) {
            return Ok(Call { name, parentheses: false, arguments: Vec::new() });
        }
        let values = self.takes_values(&name);
        let mut arguments = Vec::new();
        if self.eat_symbol(Symbol::Close) {
            return Ok(Call { name, parentheses: true, arguments });
        }
        loop {
            arguments.push(self.argument(values)?);
            let span = self.span();
            if self.eat_symbol(Symbol::Comma) {
                continue;
            }
            if values && self.eat_symbol(Symbol::Semicolon) {
                self.report(Fault::new(Id::SW903, span));
                continue;
            }
            if self.is_symbol(Symbol::Semicolon) && self.looks_like_arguments() {
                self.report(Fault::new(Id::SP211, span));
                self.advance();
                continue;
            }
            self.expect_symbol(Symbol::Close)?;
            return Ok(Call { name, parentheses: true, arguments });
        }
    }
    /// Behind a `;`: true if `)` comes before anything that only a statement has.
    fn looks_like_arguments(&self) -> bool {
        for ahead in 1..40 {
            match &self.token(ahead).kind {
                TokenKind::Symbol(Symbol::Close) => return true,
                TokenKind::Symbol(Symbol::Assign | Symbol::Semicolon | Symbol::Open) | TokenKind::End => return false,
                TokenKind::Keyword(Keyword::End | Keyword::If | Keyword::For | Keyword::While) => return false,
                _ => {}
            }
        }
        false
    }
    /// In a list of values `name = value` means `name := value` (6.6.33).
    fn argument(&mut self, values: bool) -> Parse<Argument> {
        let named = matches!(self.kind(), TokenKind::Name(_));
        let equal = values && self.symbol_at(1, Symbol::Equal);
        if !named || !equal && !self.symbol_at(1, Symbol::Assign) {
            return Ok(Argument { name: None, value: self.expression()? });
        }
        let name = self.expect_name(["a name", "ein Name"])?;
        let span = self.span();
        if equal {
            self.report(Fault::new(Id::SW902, span));
        }
        self.advance();
        Ok(Argument { name: Some(name), value: self.expression()? })
    }
    pub(super) fn reference(&mut self) -> Parse<Reference> {
        let name = self.expect_name(["a name", "ein Name"])?;
        let index = self.index()?;
        let qualifier = if self.eat_symbol(Symbol::Point) { Some(self.qualifier()?) } else { None };
        Ok(Reference { name, index, qualifier })
    }
    fn index(&mut self) -> Parse<Option<Box<Expr>>> {
        if !self.eat_symbol(Symbol::OpenBracket) {
            return Ok(None);
        }
        let index = self.deeper(Self::expression)?;
        self.expect_symbol(Symbol::CloseBracket)?;
        Ok(Some(Box::new(index)))
    }
    fn qualifier(&mut self) -> Parse<Qualifier> {
        let name: Name = self.expect_name(["a qualifier", "ein Qualifizierer"])?;
        let index = self.index()?;
        let mut bit = None;
        if self.eat_symbol(Symbol::Point) {
            let span = self.span();
            let kind = match self.kind().clone() {
                TokenKind::Decimal(n) => ExprKind::Integer(i32::try_from(n).unwrap_or(i32::MAX)),
                TokenKind::Name(text) => {
                    ExprKind::Reference(Reference { name: Name { text, span }, index: None, qualifier: None })
                }
                _ => return Err(self.expected(Phrase::new("a bit number", "eine Bitnummer"))),
            };
            self.advance();
            bit = Some(Box::new(Expr { kind, span, height: 1 }));
        }
        Ok(Qualifier { name, index, bit })
    }
}
