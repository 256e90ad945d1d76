//! What the program means: resolves names, checks types, makes conversions explicit. Every error is reported once; what
//! hangs on something wrong is left out silently.

mod commands;
mod declarations;
mod expressions;
mod labels;
mod references;
mod statements;

use std::rc::Rc;

use motion_kernel::sap::code::{MOST_FRAME, MOST_GLOBALS, Slot};
use motion_kernel::sap::program::{Variable, VariableKind};
use motion_kernel::sap::tables::Type;

use crate::ast;
use crate::diagnostics::{Fault, Id, Phrase, Reports};
use crate::lexer::{Scanned, TaskDirective};
use crate::scope::{Scopes, Symbol};
use crate::source::{Sources, Span};
use crate::token::TokenKind;
use crate::tree::{Expr, Routine, Unit};
use crate::types::Value;
use labels::Labels;

/// Analyses a program for a machine with these axes.
pub fn analyse(
    program: &ast::Program,
    scanned: &Scanned,
    axes: &[String],
    sources: &Sources,
    reports: &mut Reports,
) -> Unit {
    let mut unit = Unit {
        name: program.heading.as_ref().map_or_else(String::new, |n| n.text.to_string()),
        full_system: scanned.full_system,
        axes: axes.len() as u8,
        globals: (0..axes.len() as u64).collect(),
        ..Unit::default()
    };
    for (n, name) in axes.iter().enumerate() {
        let slot = Slot::global(n as u16);
        unit.variables.push(Variable { name: name.clone(), routine: 0, slot, kind: VariableKind::Axis });
    }
    unit.routines.push(Routine { end: program.block.end, ..Routine::default() });
    let scopes = Scopes::new(axes);
    let mut analyser = Analyser {
        unit,
        headings: vec![Heading::default()],
        scopes,
        labels: Labels::default(),
        constants: Vec::new(),
        current: 0,
        whole: !reports.has_errors(),
        lost_names: program.lost_names,
        sources,
        reports,
    };
    analyser.main(program);
    analyser.task_directives(&scanned.tasks);
    analyser.check_sizes(program.block.end);
    analyser.unit
}

/// A routine as its callers see it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Heading {
    name: Rc<str>,
    span: Span,
    parameters: Vec<Type>,
    result: Option<Type>,
    /// Its block was seen.
    has_block: bool,
}

pub(crate) struct Analyser<'a> {
    unit: Unit,
    /// Parallel to the routines of the unit.
    headings: Vec<Heading>,
    scopes: Scopes,
    labels: Labels,
    /// Global constants with the tokens before them, for `{$TASK name}`.
    constants: Vec<(usize, Rc<str>, Value)>,
    /// Routine whose block is being analysed; 0: the main program.
    current: u16,
    /// The parser understood everything.
    whole: bool,
    lost_names: bool,
    sources: &'a Sources,
    reports: &'a mut Reports,
}

impl Analyser<'_> {
    /// What may follow from a syntax error alone is not reported.
    fn report(&mut self, fault: Fault) {
        let follows = match fault.id {
            Id::E3 => self.lost_names,
            Id::SP306 | Id::SP309 | Id::SW908 | Id::SW913 => !self.whole,
            _ => false,
        };
        if !follows {
            self.reports.add(fault);
        }
    }
    /// The place of a declaration, as text.
    fn place(&self, span: Span) -> String {
        format!("{}:{}", self.sources.name(span.file), span.line)
    }
    /// Error 3, once per name and block.
    fn undeclared(&mut self, name: &ast::Name) {
        if !self.lost_names && !self.reports.stopped() {
            let suggestion = self.scopes.suggest(&name.text).map(str::to_owned);
            let fault = Fault::new(Id::E3, name.span).with(&name.text).suggest(suggestion.as_deref());
            self.report(fault);
        }
        self.scopes.poison(&name.text);
    }
    fn declare(&mut self, name: &ast::Name, symbol: Symbol) -> bool {
        let result = self.scopes.declare(&name.text, symbol, name.span);
        if let Err(first) = result {
            let place = self.place(first);
            self.report(Fault::new(Id::SP301, name.span).with(&name.text).with(place));
        }
        result.is_ok()
    }
    /// A new slot: global in the main program, else in the frame of the routine.
    fn new_slot(&mut self) -> Slot {
        if self.current == 0 {
            self.unit.globals.push(0);
            return Slot::global((self.unit.globals.len() - 1).min(usize::from(i16::MAX as u16)) as u16);
        }
        self.new_local()
    }
    /// A new slot of the frame.
    fn new_local(&mut self) -> Slot {
        let slots = &mut self.unit.routines[usize::from(self.current)].slots;
        *slots = slots.saturating_add(1);
        Slot::local((*slots - 1).min(i16::MAX as u16))
    }
    fn check_sizes(&mut self, span: Span) {
        if self.unit.globals.len() > MOST_GLOBALS {
            let what = Phrase::new("global variables", "globale Variablen");
            self.report(Fault::new(Id::SP501, span).with(what).with(MOST_GLOBALS));
        }
        let large = self.unit.routines.iter().find(|r| usize::from(r.slots) > MOST_FRAME);
        if let Some(end) = large.map(|r| r.end) {
            let what = Phrase::new("variables of a routine", "Variablen einer Routine");
            self.report(Fault::new(Id::SP501, end).with(what).with(MOST_FRAME));
        }
    }
    fn task_directives(&mut self, directives: &[TaskDirective]) {
        for directive in directives {
            let value = match &directive.number {
                TokenKind::Name(name) => {
                    let above = self.constants.iter().rev().find(|(at, n, _)| *at < directive.at && n == name);
                    let Some((_, _, value)) = above else {
                        let suggestion = self.scopes.suggest(name).map(str::to_owned);
                        let fault = Fault::new(Id::E3, directive.span).with(name).suggest(suggestion.as_deref());
                        self.report(fault);
                        continue;
                    };
                    *value
                }
                TokenKind::Decimal(n) => Value::Integer(i32::try_from(*n).unwrap_or(i32::MAX)),
                _ => continue,
            };
            match value {
                Value::Integer(n @ 0..=3) => self.unit.task = Some(n as u8),
                Value::Integer(n) => self.report(Fault::new(Id::SP113, directive.span).with(n)),
                other => {
                    let shown = other.kind().name();
                    self.report(Fault::new(Id::SP113, directive.span).with(shown));
                }
            }
        }
    }
    /// `source` as a value that `target` accepts, or a report.
    fn assign(&mut self, target: Type, source: Expr, span: Span) -> Option<Expr> {
        let literal = matches!(source.kind, crate::tree::ExprKind::Literal(_));
        if !crate::types::assignable(target, source.of, literal) {
            self.report(Fault::new(Id::SP401, span).with(source.of.name()).with(target.name()));
            return None;
        }
        Some(crate::types::convert(target, source))
    }
}
