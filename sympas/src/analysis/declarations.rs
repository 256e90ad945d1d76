//! Blocks and what they declare (5.3.2, 5.3.6).

use motion_kernel::sap::code::Slot;
use motion_kernel::sap::program::{Variable, VariableKind};
use motion_kernel::sap::tables::{Event, Type};

use super::{Analyser, Heading};
use crate::ast::{self, Item, Name, TypeName};
use crate::diagnostics::{Fault, Id, Phrase};
use crate::scope::{Found, Symbol, kind_of};
use crate::tree::Routine;
use crate::types::Value;

impl Analyser<'_> {
    pub(super) fn main(&mut self, program: &ast::Program) {
        self.items(&program.block);
        for number in 1..self.headings.len() {
            let heading = &self.headings[number];
            if !heading.has_block {
                let fault = Fault::new(Id::SP309, heading.span).with(&heading.name);
                self.report(fault);
            }
        }
        self.handlers();
        self.body(&program.block);
    }
    /// The declarations of a block in their order.
    fn items(&mut self, block: &ast::Block) {
        for item in &block.items {
            match item {
                Item::Labels(names) => names.iter().for_each(|n| self.label_declaration(n)),
                Item::Constant(constant) => self.constant(constant),
                Item::Variables { names, kind } => names.iter().for_each(|n| self.variable(n, *kind)),
                Item::Unknown(names) => names.iter().for_each(|n| self.scopes.poison(&n.text)),
                Item::Routine(routine) => self.routine(routine),
            }
        }
    }
    /// The statements of a block, whose labels are its own.
    fn body(&mut self, block: &ast::Block) {
        let body = self.statements(&block.body);
        self.finish_labels();
        let routine = &mut self.unit.routines[usize::from(self.current)];
        routine.body = body;
        routine.end = block.end;
    }
    fn label_declaration(&mut self, name: &Name) {
        let number = self.labels.next();
        if self.declare(name, Symbol::Label(number)) {
            self.labels.add(name);
        }
        self.unit.routines[usize::from(self.current)].labels = self.labels.next();
    }
    fn constant(&mut self, constant: &ast::Constant) {
        let value = self.constant_value(&constant.value);
        let symbol = value.map_or(Symbol::Unknown, Symbol::Constant);
        let declared = self.declare(&constant.name, symbol);
        if let (true, 0, Some(value)) = (declared, self.current, value) {
            self.constants.push((constant.at, constant.name.text.clone(), value));
        }
    }
    fn constant_value(&mut self, expr: &ast::Expr) -> Option<Value> {
        use ast::ExprKind;
        match &expr.kind {
            ExprKind::Integer(n) => Some(Value::Integer(*n)),
            ExprKind::Double(x) => Some(Value::Double(*x)),
            ExprKind::Unary(sign, inner) => {
                let value = self.constant_value(inner)?;
                match (sign, value) {
                    (ast::Unary::Plus, Value::Integer(_) | Value::Double(_)) => Some(value),
                    (ast::Unary::Minus, Value::Integer(n)) => Some(Value::Integer(n.wrapping_neg())),
                    (ast::Unary::Minus, Value::Double(x)) => Some(Value::Double(-x)),
                    _ => {
                        let kind = value.kind().name();
                        self.report(Fault::new(Id::SP403, expr.span).with(sign.text()).with(kind));
                        None
                    }
                }
            }
            ExprKind::Reference(r) if r.index.is_none() && r.qualifier.is_none() => self.named_constant(&r.name),
            _ => {
                self.report(Fault::new(Id::SP209, expr.span));
                None
            }
        }
    }
    /// The value of a constant by name; anything else is reported.
    pub(super) fn named_constant(&mut self, name: &Name) -> Option<Value> {
        use crate::scope::Predefined;
        match self.scopes.find(&name.text) {
            Some(Found::User(Symbol::Constant(value))) => return Some(value),
            Some(Found::Predefined(Predefined::Boolean(b))) => return Some(Value::Boolean(b)),
            Some(Found::User(Symbol::Unknown)) => {}
            Some(found) => {
                let constant = Phrase::new("a constant", "eine Konstante");
                let fault = Fault::new(Id::SP302, name.span).with(&name.text).with(kind_of(found));
                self.report(fault.with(constant));
            }
            None => self.undeclared(name),
        }
        None
    }
    fn variable(&mut self, name: &Name, kind: TypeName) {
        let Some(of) = kind.kind else {
            if self.current != 0 {
                return self.report(Fault::new(Id::SP311, kind.span));
            }
            let slot = self.new_slot();
            self.declare(name, Symbol::Axis(slot));
            return self.show(name, slot, VariableKind::Axis);
        };
        let slot = self.new_slot();
        self.declare(name, Symbol::Variable(slot, of));
        self.show(name, slot, VariableKind::Value(of));
    }
    /// Makes a variable known to the debugger.
    fn show(&mut self, name: &Name, slot: Slot, kind: VariableKind) {
        let variable = Variable { name: name.text.to_string(), routine: self.current, slot, kind };
        self.unit.variables.push(variable);
    }
    fn routine(&mut self, routine: &ast::Routine) {
        let Some(number) = self.heading(routine) else { return };
        if let Some(block) = &routine.block {
            self.routine_block(number, routine, block);
        }
    }
    /// Declares a routine, or finds its forward heading. `None` if it cannot be told what is meant.
    fn heading(&mut self, routine: &ast::Routine) -> Option<u16> {
        let name = &routine.name;
        let parameters: Vec<Type> = routine.parameters.iter().filter_map(|(_, t)| t.kind).collect();
        let result = routine.result.and_then(|t| t.kind);
        let known = self.scopes.global(&name.text);
        if let Some((Symbol::Routine(number), first)) = known {
            let (place, heading) = (self.place(first), &mut self.headings[usize::from(number)]);
            if heading.has_block {
                self.report(Fault::new(Id::SP301, name.span).with(&name.text).with(place));
                return None;
            }
            if routine.block.is_none() {
                self.report(Fault::new(Id::SP308, name.span).with(&name.text));
                return None;
            }
            heading.has_block = true;
            if heading.parameters != parameters || heading.result != result {
                self.report(Fault::new(Id::SP310, name.span).with(&name.text).with(place));
            }
            return Some(number);
        }
        if self.headings.len() > usize::from(i16::MAX as u16) {
            self.report(Fault::new(Id::SP501, name.span).with("routines").with(i16::MAX));
            return None;
        }
        let number = self.headings.len() as u16;
        if Event::ALL.iter().any(|e| e.name() == &*name.text) && (!parameters.is_empty() || result.is_some()) {
            self.report(Fault::new(Id::SP312, name.span).with(&name.text));
        }
        self.declare(name, Symbol::Routine(number));
        self.unit.routines.push(Routine {
            name: name.text.to_string(),
            parameters: parameters.len() as u16,
            function: result.is_some(),
            end: name.span,
            ..Routine::default()
        });
        let has_block = routine.block.is_some();
        self.headings.push(Heading { name: name.text.clone(), span: name.span, parameters, result, has_block });
        Some(number)
    }
    fn routine_block(&mut self, number: u16, routine: &ast::Routine, block: &ast::Block) {
        let outer = std::mem::take(&mut self.labels);
        self.current = number;
        self.scopes.enter();
        if let Some(of) = routine.result.and_then(|t| t.kind) {
            let slot = self.new_local();
            self.show(&routine.name, slot, VariableKind::Value(of));
        }
        for (name, kind) in &routine.parameters {
            self.variable(name, *kind);
        }
        self.items(block);
        self.body(block);
        if routine.result.is_some() && !self.labels.assigned_result {
            self.report(Fault::new(Id::SW908, routine.name.span).with(&routine.name.text));
        }
        self.scopes.leave();
        self.current = 0;
        self.labels = outer;
    }
    /// Parameterless procedures with the name of an event handle it (6.4).
    fn handlers(&mut self) {
        for (n, event) in Event::ALL.iter().enumerate() {
            if let Some((Symbol::Routine(number), _)) = self.scopes.global(event.name()) {
                let heading = &self.headings[usize::from(number)];
                let fits = heading.parameters.is_empty() && heading.result.is_none();
                self.unit.events[n] = fits.then_some(number);
            }
        }
    }
    /// Labels that are used: each marks a statement. Those that other blocks own are told from unknown ones.
    fn finish_labels(&mut self) {
        for fault in self.labels.check() {
            self.report(fault);
        }
    }
    pub(super) fn label_number(&mut self, name: &Name) -> Option<u32> {
        match self.scopes.innermost(&name.text) {
            Some(Symbol::Label(number)) => return Some(number),
            Some(Symbol::Unknown) => return None,
            _ => {}
        }
        match self.scopes.find(&name.text) {
            Some(Found::User(Symbol::Label(_))) => self.report(Fault::new(Id::SP307, name.span).with(&name.text)),
            Some(Found::User(Symbol::Unknown)) => {}
            Some(found) if self.scopes.innermost(&name.text).is_some() => {
                let (is, other) = (kind_of(found), Phrase::new("a label", "ein Label"));
                self.report(Fault::new(Id::SP302, name.span).with(&name.text).with(is).with(other));
            }
            _ => self.undeclared(name),
        }
        None
    }
}
