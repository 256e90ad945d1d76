//! Variables, registers and qualified identifiers, read and written (5.2.3.5, 6.3).

use motion_kernel::sap::code::Slot;
use motion_kernel::sap::tables::{Access, BitQualifier, Indexed, Qualifier, SystemParameter, Type};

use super::Analyser;
use crate::ast::{self, ExprKind as Syntax, Name};
use crate::diagnostics::{Fault, Id, Phrase, closest};
use crate::scope::{Found, Predefined, Symbol, kind_of};
use crate::tree::{Expr, ExprKind, Place};
use crate::types::Value;

/// A place, the type of its value, and what a program may do with it.
type Located = (Place, Type, Access);

const READ_ONLY: [&str; 2] = ["read-only", "nur lesbar"];

impl Analyser<'_> {
    /// The target of an assignment.
    pub(super) fn target(&mut self, reference: &ast::Reference) -> Option<(Place, Type)> {
        let name = &reference.name;
        let plain = reference.index.is_none() && reference.qualifier.is_none();
        if let (true, Some(Found::User(Symbol::Routine(number)))) = (plain, self.scopes.find(&name.text)) {
            let result = self.headings[usize::from(number)].result;
            if let Some(of) = result.filter(|_| number == self.current) {
                self.labels.assigned_result = true;
                return Some((Place::Slot(Slot::local(0)), of));
            }
            let id = if result.is_some() { Id::SP304 } else { Id::SP303 };
            let fault = Fault::new(id, name.span).with(&name.text);
            self.report(fault.with(Phrase::new("it is a procedure", "es ist eine Prozedur")));
            return None;
        }
        let (place, of, access) = self.located(reference)?;
        if access == Access::Read {
            let shown = reference.qualifier.as_ref().map_or(name, |q| &q.name);
            let what = Phrase::new(READ_ONLY[0], READ_ONLY[1]);
            self.report(Fault::new(Id::SP303, shown.span).with(&shown.text).with(what));
            return None;
        }
        Some((place, of))
    }
    /// The value of a reference; a bare name may also call a function.
    pub(super) fn value(&mut self, reference: &ast::Reference) -> Option<Expr> {
        let name = &reference.name;
        let plain = reference.index.is_none() && reference.qualifier.is_none();
        match self.scopes.find(&name.text).filter(|_| plain) {
            Some(Found::User(Symbol::Constant(value))) => return Some(value.literal()),
            Some(Found::Predefined(Predefined::Boolean(b))) => return Some(Value::Boolean(b).literal()),
            Some(Found::User(Symbol::Routine(number))) => {
                let result = self.headings[usize::from(number)].result;
                if let Some(of) = result.filter(|_| number == self.current) {
                    return Some(Expr { kind: ExprKind::Load(Place::Slot(Slot::local(0))), of });
                }
                let call = ast::Call { name: name.clone(), parentheses: false, arguments: Vec::new() };
                return self.function_call(&call);
            }
            Some(Found::Predefined(Predefined::Function(_) | Predefined::Power | Predefined::ReadBuffer(_))) => {
                let call = ast::Call { name: name.clone(), parentheses: false, arguments: Vec::new() };
                return self.function_call(&call);
            }
            _ => {}
        }
        let (place, of, _) = self.located(reference)?;
        Some(Expr { kind: ExprKind::Load(place), of })
    }
    fn located(&mut self, reference: &ast::Reference) -> Option<Located> {
        let name = &reference.name;
        let Some(found) = self.scopes.find(&name.text) else {
            self.undeclared(name);
            return None;
        };
        if let Found::User(Symbol::Axis(slot)) = found {
            return self.qualified(name, slot, reference);
        }
        if reference.qualifier.is_some() {
            if !matches!(found, Found::User(Symbol::Unknown)) {
                let axis = Phrase::new("an axis", "eine Achse");
                let fault = Fault::new(Id::SP302, name.span).with(&name.text).with(kind_of(found));
                self.report(fault.with(axis));
            }
            return None;
        }
        if let Found::Predefined(p @ (Predefined::SysVarInt | Predefined::SysVarDbl)) = found {
            return self.system_variable(name, p, reference);
        }
        if reference.index.is_some() && !matches!(found, Found::User(Symbol::Unknown)) {
            self.report(Fault::new(Id::SP315, name.span).with(&name.text).with("index"));
            return None;
        }
        self.simple(name, found)
    }
    fn simple(&mut self, name: &Name, found: Found) -> Option<Located> {
        let writable = Access::ReadWrite;
        match found {
            Found::User(Symbol::Variable(slot, of)) => Some((Place::Slot(slot), of, writable)),
            Found::Predefined(Predefined::System(parameter)) => {
                if matches!(parameter, SystemParameter::CFLAG | SystemParameter::GFAUX) {
                    self.report(Fault::new(Id::SW905, name.span).with(&name.text));
                }
                Some((Place::System(parameter), parameter.kind(), parameter.access()))
            }
            Found::Predefined(Predefined::Ci(number)) => {
                self.check_common(name, number);
                Some((Place::Ci(number), Type::Integer, writable))
            }
            Found::Predefined(Predefined::Cd(number)) => {
                self.check_common(name, number);
                Some((Place::Cd(number), Type::Double, writable))
            }
            Found::User(Symbol::Unknown) => None,
            Found::User(Symbol::Constant(_)) | Found::Predefined(Predefined::Boolean(_)) => {
                self.report(Fault::new(Id::SP303, name.span).with(&name.text).with(kind_of(found)));
                None
            }
            other => {
                let value = Phrase::new("a value", "ein Wert");
                let fault = Fault::new(Id::SP302, name.span).with(&name.text).with(kind_of(other));
                self.report(fault.with(value));
                None
            }
        }
    }
    fn check_common(&mut self, name: &Name, number: u32) {
        if number > 999 {
            self.report(Fault::new(Id::SW906, name.span).with(&name.text));
        }
    }
    fn system_variable(&mut self, name: &Name, array: Predefined, reference: &ast::Reference) -> Option<Located> {
        let Some(index) = &reference.index else {
            let what = Phrase::new("an index in brackets", "einen Index in Klammern");
            self.report(Fault::new(Id::SP314, name.span).with(&name.text).with(what));
            return None;
        };
        let (which, of) = match array {
            Predefined::SysVarInt => (Indexed::Integer, Type::Integer),
            _ => (Indexed::Double, Type::Double),
        };
        let index = self.integer(index)?;
        Some((Place::SysVar(which, Box::new(index)), of, Access::ReadWrite))
    }
    /// An expression that must be an Integer.
    pub(super) fn integer(&mut self, expr: &ast::Expr) -> Option<Expr> {
        let value = self.expression(expr)?;
        self.assign(Type::Integer, value, expr.span)
    }
    /// `axis.qualifier`, `axis.qualifier[index]`, `axis.qualifier.bit`.
    fn qualified(&mut self, axis: &Name, slot: Slot, reference: &ast::Reference) -> Option<Located> {
        if reference.index.is_some() {
            self.report(Fault::new(Id::SP315, axis.span).with(&axis.text).with("index"));
            return None;
        }
        let Some(qualifier) = &reference.qualifier else {
            let what = Phrase::new("a qualifier, as in A1.dp", "einen Qualifizierer, z.B. A1.dp");
            self.report(Fault::new(Id::SP314, axis.span).with(&axis.text).with(what));
            return None;
        };
        let name = &qualifier.name;
        if let Some(bit) = BitQualifier::by_name(&name.text) {
            return self.bit(slot, bit, qualifier);
        }
        let indexed = match &*name.text {
            "varint" => Some((Indexed::Integer, Type::Integer)),
            "vardbl" => Some((Indexed::Double, Type::Double)),
            _ => None,
        };
        if qualifier.bit.is_some() {
            let what = Phrase::new("bit number", "Bitnummer");
            self.report(Fault::new(Id::SP315, name.span).with(&name.text).with(what));
            return None;
        }
        if let Some((which, of)) = indexed {
            let Some(index) = &qualifier.index else {
                let what = Phrase::new("an index in brackets", "einen Index in Klammern");
                self.report(Fault::new(Id::SP314, name.span).with(&name.text).with(what));
                return None;
            };
            let index = self.integer(index)?;
            return Some((Place::AxisVar(which, slot, Box::new(index)), of, Access::ReadWrite));
        }
        if qualifier.index.is_some() {
            self.report(Fault::new(Id::SP315, name.span).with(&name.text).with("index"));
            return None;
        }
        if &*name.text == "an" {
            return Some((Place::Slot(slot), Type::Integer, Access::ReadWrite));
        }
        match Qualifier::by_name(&name.text) {
            Some(register) => Some((Place::Axis(register, slot), register.kind(), register.access())),
            None => {
                self.unknown_qualifier(name);
                None
            }
        }
    }
    fn unknown_qualifier(&mut self, name: &Name) {
        let names = Qualifier::ALL.iter().map(|q| q.name()).chain(BitQualifier::ALL.iter().map(|q| q.name()));
        let near = closest(&name.text, names.chain(["an", "varint", "vardbl"]));
        self.report(Fault::new(Id::SP313, name.span).with(&name.text).suggest(near));
    }
    fn bit(&mut self, slot: Slot, register: BitQualifier, qualifier: &ast::Qualifier) -> Option<Located> {
        let name = &qualifier.name;
        if qualifier.index.is_some() {
            self.report(Fault::new(Id::SP315, name.span).with(&name.text).with("index"));
            return None;
        }
        let Some(bit) = &qualifier.bit else {
            let what = Phrase::new("a bit number, as in A1.digib.1", "eine Bitnummer, z.B. A1.digib.1");
            self.report(Fault::new(Id::SP314, name.span).with(&name.text).with(what));
            return None;
        };
        let number = match &bit.kind {
            Syntax::Integer(n) => *n,
            Syntax::Reference(r) => match self.named_constant(&r.name)? {
                Value::Integer(n) => n,
                other => {
                    self.report(Fault::new(Id::SP401, bit.span).with(other.kind().name()).with("Integer"));
                    return None;
                }
            },
            _ => return None,
        };
        if !(1..=32).contains(&number) {
            self.report(Fault::new(Id::SP316, bit.span).with(number));
            return None;
        }
        Some((Place::Bit(register, number as u8, slot), Type::Boolean, register.access()))
    }
}
