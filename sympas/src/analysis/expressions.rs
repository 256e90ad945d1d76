//! Expressions and calls of functions (5.3.4, 5.3.6.2).

use motion_kernel::sap::program::real;
use motion_kernel::sap::tables::Type;

use super::Analyser;
use crate::ast::{self, Binary, ExprKind as Syntax, Unary};
use crate::diagnostics::{Fault, Id, Phrase};
use crate::scope::{Found, Predefined, Symbol, kind_of};
use crate::source::Span;
use crate::tree::{Expr, ExprKind};
use crate::types::{self, Value};

impl Analyser<'_> {
    /// `None` where something was wrong and reported.
    pub(super) fn expression(&mut self, expr: &ast::Expr) -> Option<Expr> {
        match &expr.kind {
            Syntax::Integer(n) => Some(Value::Integer(*n).literal()),
            Syntax::Double(x) => Some(Value::Double(*x).literal()),
            Syntax::Text(_) => {
                self.report(Fault::new(Id::SP407, expr.span));
                None
            }
            Syntax::Reference(reference) => self.value(reference),
            Syntax::Call(call) => self.function_call(call),
            Syntax::Convert(target, inner) => self.conversion(*target, inner, expr.span),
            Syntax::Unary(operator, inner) => self.unary(*operator, inner, expr.span),
            Syntax::Binary(operator, left, right) => self.binary(*operator, left, right, expr.span),
        }
    }
    fn conversion(&mut self, target: Type, inner: &ast::Expr, span: Span) -> Option<Expr> {
        let value = self.expression(inner)?;
        if !types::convertible(target, value.of) {
            self.report(Fault::new(Id::SP406, span).with(value.of.name()).with(target.name()));
            return None;
        }
        let converted = types::convert(target, value);
        // a literal made Double is none any more: only a literal fits into a Single
        let double = target == Type::Double && matches!(converted.kind, ExprKind::Literal(_));
        Some(if double {
            Expr { kind: ExprKind::Unary(Unary::Plus, Box::new(converted)), of: target }
        } else {
            converted
        })
    }
    fn unary(&mut self, operator: Unary, inner: &ast::Expr, span: Span) -> Option<Expr> {
        let value = self.expression(inner)?;
        let Some(of) = types::unary(operator, value.of) else {
            self.report(Fault::new(Id::SP403, span).with(operator.text()).with(value.of.name()));
            return None;
        };
        Some(match (operator, &value.kind) {
            (Unary::Plus, _) => value,
            (Unary::Minus, ExprKind::Literal(bits)) if of == Type::Double => {
                Expr { kind: ExprKind::Literal(real(-f64::from_bits(*bits))), of }
            }
            _ => Expr { kind: ExprKind::Unary(operator, Box::new(value)), of },
        })
    }
    fn binary(&mut self, operator: Binary, left: &ast::Expr, right: &ast::Expr, span: Span) -> Option<Expr> {
        let (a, b) = (self.expression(left), self.expression(right));
        let (a, b) = (a?, b?);
        let Some((common, of)) = types::binary(operator, a.of, b.of) else {
            let fault = Fault::new(Id::SP402, span).with(operator.text()).with(a.of.name()).with(b.of.name());
            self.report(fault);
            return None;
        };
        let zero = match b.kind {
            ExprKind::Literal(bits) if b.of == Type::Double => f64::from_bits(bits) == 0.0,
            ExprKind::Literal(bits) => bits == 0,
            _ => false,
        };
        if zero && matches!(operator, Binary::Div | Binary::Mod) {
            self.report(Fault::new(Id::SW912, right.span));
        }
        // real operators work in double precision, so Single operands stay as they are
        let working = if common == Type::Single { Type::Double } else { common };
        let (a, b) = (types::convert(working, a), types::convert(working, b));
        Some(Expr { kind: ExprKind::Binary(operator, working, Box::new(a), Box::new(b)), of })
    }
    pub(super) fn function_call(&mut self, call: &ast::Call) -> Option<Expr> {
        let name = &call.name;
        let Some(found) = self.scopes.find(&name.text) else {
            self.undeclared(name);
            return None;
        };
        match found {
            Found::User(Symbol::Routine(number)) => {
                let Some(of) = self.headings[usize::from(number)].result else {
                    self.report(Fault::new(Id::SP408, name.span).with(&name.text));
                    return None;
                };
                let arguments = self.arguments(number, call)?;
                Some(Expr { kind: ExprKind::Call(number, arguments), of })
            }
            Found::Predefined(Predefined::Function(function)) => {
                let [value] = self.doubles(call)?;
                Some(Expr { kind: ExprKind::Math(function, Box::new(value)), of: Type::Double })
            }
            Found::Predefined(Predefined::Power) => {
                let [base, exponent] = self.doubles(call)?;
                let kind = ExprKind::Power(Box::new(base), Box::new(exponent));
                Some(Expr { kind, of: Type::Double })
            }
            Found::Predefined(Predefined::ReadBuffer(of)) => {
                let offset = self.offset(of, call, 1)?;
                Some(Expr { kind: ExprKind::ReadBuffer(of, Box::new(offset)), of })
            }
            Found::Predefined(Predefined::Command) => {
                self.report(Fault::new(Id::SP408, name.span).with(&name.text));
                None
            }
            Found::User(Symbol::Unknown) => None,
            other => {
                let function = Phrase::new("a function", "eine Funktion");
                let fault = Fault::new(Id::SP302, name.span).with(&name.text).with(kind_of(other));
                self.report(fault.with(function));
                None
            }
        }
    }
    /// The arguments of a user routine, converted to its parameters.
    pub(super) fn arguments(&mut self, number: u16, call: &ast::Call) -> Option<Vec<Expr>> {
        let parameters = self.headings[usize::from(number)].parameters.clone();
        if !self.check_count(call, parameters.len()) {
            return None;
        }
        let mut list = Vec::with_capacity(parameters.len());
        for (argument, of) in call.arguments.iter().zip(&parameters) {
            let value = self.expression(&argument.value);
            list.push(value.and_then(|v| self.assign(*of, v, argument.value.span)));
        }
        list.into_iter().collect()
    }
    /// The right number of arguments, none of them `name := value`.
    pub(super) fn check_count(&mut self, call: &ast::Call, count: usize) -> bool {
        let given = call.arguments.len();
        if given != count {
            let fault = Fault::new(Id::SP409, call.name.span).with(&call.name.text).with(count).with(given);
            self.report(fault);
            return false;
        }
        let named = call.arguments.iter().find_map(|a| a.name.clone());
        if let Some(name) = &named {
            self.report(Fault::new(Id::SP411, name.span).with(&name.text).with(&call.name.text));
        }
        named.is_none()
    }
    fn doubles<const N: usize>(&mut self, call: &ast::Call) -> Option<[Expr; N]> {
        if !self.check_count(call, N) {
            return None;
        }
        let list: Vec<Option<Expr>> = call.arguments.iter().map(|a| self.double(&a.value)).collect();
        let list: Option<Vec<Expr>> = list.into_iter().collect();
        list?.try_into().ok()
    }
    pub(super) fn double(&mut self, expr: &ast::Expr) -> Option<Expr> {
        let value = self.expression(expr)?;
        self.assign(Type::Double, value, expr.span)
    }
    /// The offset of an access to the common buffer, the first of `count` arguments. A constant one is checked.
    pub(super) fn offset(&mut self, of: Type, call: &ast::Call, count: usize) -> Option<Expr> {
        if !self.check_count(call, count) {
            return None;
        }
        let span = call.arguments[0].value.span;
        let offset = self.integer(&call.arguments[0].value)?;
        if let ExprKind::Literal(bits) = offset.kind {
            let (n, size) = (bits as i64, if of == Type::Double { 8 } else { 4 });
            let inside = (0..=1000 - size).contains(&n);
            if !inside || n % size != 0 {
                let error = if inside && of == Type::Double { "0800" } else { "0100" };
                self.report(Fault::new(Id::SW911, span).with(n).with(error));
            }
        }
        Some(offset)
    }
}
