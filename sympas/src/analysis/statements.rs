//! Statements (5.3.5).

use motion_kernel::sap::code::Slot;
use motion_kernel::sap::tables::Type;

use super::Analyser;
use crate::ast::{self, StatementKind as Syntax};
use crate::diagnostics::{Fault, Id, Phrase};
use crate::scope::{Found, Predefined, Symbol, kind_of};
use crate::tree::{Expr, Statement, StatementKind};

impl Analyser<'_> {
    pub(super) fn statements(&mut self, list: &[ast::Statement]) -> Vec<Statement> {
        list.iter().map(|s| self.statement(s)).collect()
    }
    fn boxed(&mut self, statement: &ast::Statement) -> Box<Statement> {
        self.labels.enter();
        let inner = self.statement(statement);
        self.labels.leave();
        Box::new(inner)
    }
    fn statement(&mut self, statement: &ast::Statement) -> Statement {
        let labels = statement.labels.iter().filter_map(|name| self.placed_label(name)).collect();
        let kind = self.kind(&statement.kind).unwrap_or(StatementKind::Empty);
        Statement { labels, span: statement.span, kind }
    }
    fn placed_label(&mut self, name: &ast::Name) -> Option<u32> {
        let number = self.label_number(name)?;
        if let Err(first) = self.labels.place(number, name.span) {
            let place = self.place(first);
            self.report(Fault::new(Id::SP305, name.span).with(&name.text).with(place));
            return None;
        }
        Some(number)
    }
    /// `None` where something was wrong and reported.
    fn kind(&mut self, statement: &Syntax) -> Option<StatementKind> {
        match statement {
            Syntax::Empty => Some(StatementKind::Empty),
            Syntax::Assign { target, value } => self.assignment(target, value),
            Syntax::Call(call) => self.call_statement(call),
            Syntax::Goto(name) => {
                let number = self.label_number(name)?;
                self.labels.jump(number, name.span);
                Some(StatementKind::Goto(number))
            }
            Syntax::Compound(list) => Some(StatementKind::Compound(self.statements(list))),
            Syntax::If { condition, then, otherwise } => {
                let condition = self.condition(condition);
                let then = self.boxed(then);
                let otherwise = otherwise.as_ref().map(|s| self.boxed(s));
                Some(StatementKind::If { condition: condition?, then, otherwise })
            }
            Syntax::While { condition, body } => {
                let condition = self.condition(condition);
                let body = self.boxed(body);
                Some(StatementKind::While { condition: condition?, body })
            }
            Syntax::Repeat { body, condition, until } => {
                self.labels.enter();
                let body = self.statements(body);
                self.labels.leave();
                let condition = self.condition(condition)?;
                Some(StatementKind::Repeat { body, condition, until: *until })
            }
            Syntax::For { variable, from, to, down, body } => {
                let slot = self.loop_variable(variable);
                let (from, to) = (self.bound(from), self.bound(to));
                let bound = self.new_local();
                let body = self.boxed(body);
                let (variable, from, to) = (slot?, from?, to?);
                Some(StatementKind::For { variable, bound, from, to, down: *down, body })
            }
        }
    }
    fn condition(&mut self, expr: &ast::Expr) -> Option<Expr> {
        let value = self.expression(expr)?;
        if value.of != Type::Boolean {
            self.report(Fault::new(Id::SP404, expr.span).with(value.of.name()));
            return None;
        }
        Some(value)
    }
    /// A bound of a for loop is Integer, nothing that converts to it.
    fn bound(&mut self, expr: &ast::Expr) -> Option<Expr> {
        let value = self.expression(expr)?;
        if value.of != Type::Integer {
            self.report(Fault::new(Id::SP401, expr.span).with(value.of.name()).with(Type::Integer.name()));
            return None;
        }
        Some(value)
    }
    /// An Integer variable, or the number of an axis.
    fn loop_variable(&mut self, reference: &ast::Reference) -> Option<Slot> {
        match self.scopes.find(&reference.name.text) {
            None => {
                self.undeclared(&reference.name);
                return None;
            }
            Some(Found::User(Symbol::Unknown)) => return None,
            Some(Found::User(Symbol::Variable(slot, Type::Integer)))
                if reference.index.is_none() && reference.qualifier.is_none() =>
            {
                return Some(slot);
            }
            Some(Found::User(Symbol::Axis(slot))) => {
                let plain = |q: &ast::Qualifier| &*q.name.text == "an" && q.index.is_none() && q.bit.is_none();
                if reference.qualifier.as_ref().is_some_and(plain) {
                    return Some(slot);
                }
            }
            Some(_) => {}
        }
        self.report(Fault::new(Id::SP405, reference.name.span));
        None
    }
    fn assignment(&mut self, target: &ast::Reference, value: &ast::Expr) -> Option<StatementKind> {
        let place = self.target(target);
        let source = self.expression(value);
        let (place, of) = place?;
        let value = self.assign(of, source?, value.span)?;
        Some(StatementKind::Assign(place, value))
    }
    fn call_statement(&mut self, call: &ast::Call) -> Option<StatementKind> {
        let Some(found) = self.scopes.find(&call.name.text) else {
            self.undeclared(&call.name);
            self.check_arguments(call);
            return None;
        };
        match found {
            Found::User(Symbol::Routine(number)) => {
                if self.headings[usize::from(number)].result.is_some() {
                    let fault = Fault::new(Id::E91, call.name.span).with(&call.name.text);
                    self.report(fault);
                }
                let arguments = self.arguments(number, call)?;
                Some(StatementKind::Call(number, arguments))
            }
            Found::Predefined(Predefined::Command) => self.command(call).map(StatementKind::Act),
            Found::Predefined(Predefined::Function(_) | Predefined::Power | Predefined::ReadBuffer(_)) => {
                self.report(Fault::new(Id::E91, call.name.span).with(&call.name.text));
                None
            }
            Found::User(Symbol::Unknown) => None,
            other => {
                let statement = Phrase::new("a statement", "eine Anweisung");
                let fault = Fault::new(Id::SP302, call.name.span).with(&call.name.text).with(kind_of(other));
                self.report(fault.with(statement));
                None
            }
        }
    }
    /// Reports what is wrong inside the arguments of something unknown.
    fn check_arguments(&mut self, call: &ast::Call) {
        for argument in &call.arguments {
            if !matches!(argument.value.kind, ast::ExprKind::Text(_))
                && argument.name.is_none()
                && !self.is_axis(argument)
            {
                self.expression(&argument.value);
            }
        }
    }
}
