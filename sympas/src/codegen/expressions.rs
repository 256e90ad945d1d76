//! Expressions: every value ends up in a slot.

use motion_kernel::sap::code::{Address, Instr, Slot};
use motion_kernel::sap::tables::Type;

use super::Generator;
use crate::ast::{Binary, Unary};
use crate::tree::{Expr, ExprKind, Place};
use crate::types::is_real;

/// True where evaluating calls a routine of the program, which may change globals.
pub(super) fn calls(expr: &Expr) -> bool {
    match &expr.kind {
        ExprKind::Call(..) => true,
        ExprKind::Literal(_) => false,
        ExprKind::Load(place) => match place {
            Place::SysVar(_, index) | Place::AxisVar(_, _, index) => calls(index),
            _ => false,
        },
        ExprKind::Unary(_, a) | ExprKind::Convert(a) | ExprKind::Math(_, a) | ExprKind::ReadBuffer(_, a) => calls(a),
        ExprKind::Binary(_, _, a, b) | ExprKind::Power(a, b) => calls(a) || calls(b),
    }
}

/// Conversions that leave the slot as it is: a Single in an expression has double precision until it is stored.
fn is_free(to: Type, from: Type) -> bool {
    matches!((to, from), (Type::Integer, Type::Boolean) | (Type::Double, Type::Single))
}

impl Generator {
    /// The slot that holds the value: its own where it has one, else a temporary.
    pub(super) fn operand(&mut self, expr: &Expr) -> Slot {
        match &expr.kind {
            ExprKind::Literal(bits) => self.literal(*bits),
            ExprKind::Load(Place::Slot(slot)) => *slot,
            ExprKind::Unary(Unary::Plus, inner) => self.operand(inner),
            ExprKind::Convert(inner) if is_free(expr.of, inner.of) => self.operand(inner),
            ExprKind::Call(number, arguments) => self.call(*number, arguments),
            _ => {
                let target = self.temporary();
                self.into(expr, target);
                target
            }
        }
    }
    /// As [`Self::operand`], but safe from what `later` may change.
    pub(super) fn stable(&mut self, expr: &Expr, later: bool) -> Slot {
        let slot = self.operand(expr);
        if !later || !slot.is_global() || matches!(expr.kind, ExprKind::Literal(_)) {
            return slot;
        }
        let copy = self.temporary();
        self.emit(Instr::Copy(copy, slot));
        copy
    }
    /// Evaluates into a slot.
    pub(super) fn into(&mut self, expr: &Expr, target: Slot) {
        let mark = self.frame.top;
        match &expr.kind {
            ExprKind::Load(place) if !matches!(place, Place::Slot(_)) => self.load(place, target),
            ExprKind::Unary(operator, inner) if *operator != Unary::Plus => {
                let a = self.operand(inner);
                self.emit(match (operator, inner.of) {
                    (Unary::Not, Type::Boolean) => Instr::NotB(target, a),
                    (Unary::Not, _) => Instr::NotI(target, a),
                    (_, Type::Integer) => Instr::NegI(target, a),
                    _ => Instr::NegD(target, a),
                });
            }
            ExprKind::Unary(_, inner) => self.into(inner, target),
            ExprKind::Binary(operator, working, left, right) => {
                let a = self.stable(left, calls(right));
                let b = self.operand(right);
                self.emit(operation(*operator, *working, target, a, b));
            }
            ExprKind::Convert(inner) if is_free(expr.of, inner.of) => self.into(inner, target),
            ExprKind::Convert(inner) => self.convert(inner, expr.of, target),
            ExprKind::Math(function, inner) => {
                let a = self.operand(inner);
                self.emit(Instr::Math(*function, target, a));
            }
            ExprKind::Power(base, exponent) => {
                let a = self.stable(base, calls(exponent));
                let b = self.operand(exponent);
                self.emit(Instr::Power(target, a, b));
            }
            ExprKind::ReadBuffer(kind, offset) => {
                let a = self.operand(offset);
                self.emit(Instr::ReadBuffer(*kind, target, a));
            }
            ExprKind::Literal(_) | ExprKind::Load(_) | ExprKind::Call(..) => {
                let source = self.operand(expr);
                self.emit(Instr::Copy(target, source));
            }
        }
        self.frame.top = mark;
    }
    fn load(&mut self, place: &Place, target: Slot) {
        let instr = match place {
            Place::Slot(slot) => Instr::Copy(target, *slot),
            Place::System(parameter) => Instr::ReadSystem(*parameter, target),
            Place::Ci(number) => Instr::ReadCi(target, *number),
            Place::Cd(number) => Instr::ReadCd(target, *number),
            Place::SysVar(which, index) => {
                let index = self.operand(index);
                Instr::ReadSysVar(*which, target, index)
            }
            Place::Axis(qualifier, axis) => Instr::ReadAxis(*qualifier, target, *axis),
            Place::Bit(qualifier, bit, axis) => Instr::ReadAxisBit(*qualifier, *bit, target, *axis),
            Place::AxisVar(which, axis, index) => {
                let index = self.operand(index);
                Instr::ReadAxisVar(*which, target, *axis, index)
            }
        };
        self.emit(instr);
    }
    fn convert(&mut self, inner: &Expr, to: Type, target: Slot) {
        let a = self.operand(inner);
        let real = is_real(inner.of);
        let instr = match (to, inner.of) {
            (Type::Boolean, _) if real => Instr::DtoB(target, a),
            (Type::Boolean, _) => Instr::ItoB(target, a),
            (Type::Integer, Type::Timer) => Instr::TtoI(target, a),
            (Type::Integer, _) if real => Instr::DtoI(target, a),
            (Type::Timer, _) => Instr::ItoT(target, a),
            (Type::Single, _) if real => Instr::RoundS(target, a),
            (Type::Single | Type::Double, Type::Timer) => Instr::TtoD(target, a),
            (Type::Single | Type::Double, _) if !real => Instr::ItoD(target, a),
            _ => Instr::Copy(target, a),
        };
        self.emit(instr);
        if to == Type::Single && !real {
            self.emit(Instr::RoundS(target, target));
        }
    }
    /// Calls a routine; a function leaves its result in the slot that comes back.
    pub(super) fn call(&mut self, number: u16, arguments: &[Expr]) -> Slot {
        let given = usize::from(self.given[usize::from(number)]);
        let base = self.reserve(given);
        let first = base.0 + (given - arguments.len()) as u16;
        for (n, argument) in arguments.iter().enumerate() {
            self.into(argument, Slot::local(first + n as u16));
        }
        self.emit(Instr::Call(number, base.0));
        self.frame.top = self.frame.top - given + usize::from(given > arguments.len());
        base
    }
    /// Emits a jump that is taken when the condition is FALSE; its target is to be patched.
    pub(super) fn unless(&mut self, condition: &Expr) -> Address {
        let mark = self.frame.top;
        let jump = self.conditional(condition);
        self.frame.top = mark;
        jump
    }
    fn conditional(&mut self, condition: &Expr) -> Address {
        if let ExprKind::Binary(operator, working, left, right) = &condition.kind
            && operator.is_relation()
            && *working != Type::Timer
        {
            let a = self.stable(left, calls(right));
            let b = self.operand(right);
            let test = match (operator, is_real(*working)) {
                (Binary::Eq, false) => Instr::IfEqI(a, b),
                (Binary::Ne, false) => Instr::IfNeI(a, b),
                (Binary::Lt, false) => Instr::IfLtI(a, b),
                (Binary::Gt, false) => Instr::IfLtI(b, a),
                (Binary::Le, false) => Instr::IfLeI(a, b),
                (_, false) => Instr::IfLeI(b, a),
                (Binary::Eq, true) => Instr::IfEqD(a, b),
                (Binary::Ne, true) => Instr::IfNeD(a, b),
                (Binary::Lt, true) => Instr::IfLtD(a, b),
                (Binary::Gt, true) => Instr::IfLtD(b, a),
                (Binary::Le, true) => Instr::IfLeD(a, b),
                (_, true) => Instr::IfLeD(b, a),
            };
            self.emit(test);
            return self.emit(Instr::Jump(0));
        }
        let slot = self.operand(condition);
        self.emit(Instr::JumpIfNot(slot, 0))
    }
}

/// The instruction of an operator on operands of that type.
fn operation(operator: Binary, working: Type, to: Slot, a: Slot, b: Slot) -> Instr {
    match working {
        Type::Single | Type::Double => real_operation(operator, to, a, b),
        Type::Timer => timer_operation(operator, to, a, b),
        Type::Integer | Type::Boolean => integer_operation(operator, to, a, b),
    }
}

fn integer_operation(operator: Binary, to: Slot, a: Slot, b: Slot) -> Instr {
    match operator {
        Binary::Mul => Instr::MulI(to, a, b),
        Binary::Div => Instr::DivI(to, a, b),
        Binary::Mod => Instr::ModI(to, a, b),
        Binary::Shl => Instr::ShlI(to, a, b),
        Binary::Shr => Instr::ShrI(to, a, b),
        Binary::And => Instr::And(to, a, b),
        Binary::Add => Instr::AddI(to, a, b),
        Binary::Sub => Instr::SubI(to, a, b),
        Binary::Or => Instr::Or(to, a, b),
        Binary::Xor => Instr::Xor(to, a, b),
        Binary::Eq => Instr::EqI(to, a, b),
        Binary::Ne => Instr::NeI(to, a, b),
        Binary::Lt => Instr::LtI(to, a, b),
        Binary::Gt => Instr::LtI(to, b, a),
        Binary::Le => Instr::LeI(to, a, b),
        Binary::Ge => Instr::LeI(to, b, a),
    }
}

fn real_operation(operator: Binary, to: Slot, a: Slot, b: Slot) -> Instr {
    match operator {
        Binary::Mul => Instr::MulD(to, a, b),
        Binary::Div => Instr::DivD(to, a, b),
        Binary::Add => Instr::AddD(to, a, b),
        Binary::Sub => Instr::SubD(to, a, b),
        Binary::Eq => Instr::EqD(to, a, b),
        Binary::Ne => Instr::NeD(to, a, b),
        Binary::Lt => Instr::LtD(to, a, b),
        Binary::Gt => Instr::LtD(to, b, a),
        Binary::Le => Instr::LeD(to, a, b),
        Binary::Ge => Instr::LeD(to, b, a),
        other => unreachable!("{} has no real operands", other.text()),
    }
}

fn timer_operation(operator: Binary, to: Slot, a: Slot, b: Slot) -> Instr {
    match operator {
        Binary::Add => Instr::AddT(to, a, b),
        Binary::Sub => Instr::SubT(to, a, b),
        Binary::Eq => Instr::EqT(to, a, b),
        Binary::Ne => Instr::NeT(to, a, b),
        Binary::Lt => Instr::LtT(to, a, b),
        Binary::Gt => Instr::LtT(to, b, a),
        Binary::Le => Instr::LeT(to, a, b),
        Binary::Ge => Instr::LeT(to, b, a),
        other => unreachable!("{} has no Timer operands", other.text()),
    }
}
