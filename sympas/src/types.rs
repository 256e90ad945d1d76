//! Types: what may be assigned to what, what operators yield (5.3.1.2.4, 5.3.1.3.1, tables 26 to 31).

use motion_kernel::sap::program::{boolean, integer, real};
use motion_kernel::sap::tables::Type;

use crate::ast::{Binary, Unary};
use crate::tree::{Expr, ExprKind};

pub const fn is_real(kind: Type) -> bool {
    matches!(kind, Type::Single | Type::Double)
}

/// True where `target := source` is allowed. A float literal is Double, yet fits into a Single (6.6.77).
pub fn assignable(target: Type, source: Type, literal: bool) -> bool {
    use Type::*;
    match (target, source) {
        (Boolean, Boolean) | (Integer, Boolean | Integer | Timer) | (Timer, Integer | Timer) | (Double, _) => true,
        (Single, Double) => literal,
        (Single, _) => true,
        _ => false,
    }
}

/// True where `target(source)` is allowed (5.3.3.2).
pub fn convertible(target: Type, source: Type) -> bool {
    target != Type::Timer || matches!(source, Type::Integer | Type::Timer)
}

/// Makes `source` a value of type `target`; the caller knows that it may.
pub fn convert(target: Type, source: Expr) -> Expr {
    match (target, &source) {
        _ if target == source.of && target != Type::Single => source,
        (Type::Single, Expr { of: Type::Single, kind: ExprKind::Load(_) }) => source,
        (Type::Single, Expr { kind: ExprKind::Literal(bits), of: Type::Double }) => {
            let single = f64::from(f64::from_bits(*bits) as f32);
            Expr { kind: ExprKind::Literal(real(single)), of: Type::Single }
        }
        (Type::Double, Expr { kind: ExprKind::Literal(bits), of: Type::Integer | Type::Boolean }) => {
            Expr { kind: ExprKind::Literal(real(f64::from(*bits as i64 as i32))), of: Type::Double }
        }
        _ => Expr { kind: ExprKind::Convert(Box::new(source)), of: target },
    }
}

/// The type in which a unary operator works, or `None`.
pub fn unary(operator: Unary, operand: Type) -> Option<Type> {
    let fits = match operator {
        Unary::Not => matches!(operand, Type::Boolean | Type::Integer),
        Unary::Plus | Unary::Minus => operand == Type::Integer || is_real(operand),
    };
    fits.then_some(operand)
}

/// The type of the operands and of the result of a binary operator, or `None` where it is not defined.
pub fn binary(operator: Binary, left: Type, right: Type) -> Option<(Type, Type)> {
    use Type::*;
    let common = match (left, right) {
        _ if left == right => left,
        (Timer, Integer) | (Integer, Timer) => Timer,
        (Integer, Single) | (Single, Integer) => Single,
        (Integer | Single | Double, Integer | Single | Double) => Double,
        _ => return None,
    };
    let number = common == Integer || is_real(common);
    let (fits, result) = match operator {
        Binary::Add | Binary::Sub => (number || common == Timer, common),
        Binary::Mul | Binary::Div => (number, common),
        Binary::Mod | Binary::Shl | Binary::Shr => (common == Integer, common),
        Binary::And | Binary::Or | Binary::Xor => (matches!(common, Integer | Boolean), common),
        _ => (true, Boolean),
    };
    fits.then_some((common, result))
}

/// A value known when compiling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    Boolean(bool),
    Integer(i32),
    Double(f64),
}

impl Value {
    pub const fn kind(self) -> Type {
        match self {
            Value::Boolean(_) => Type::Boolean,
            Value::Integer(_) => Type::Integer,
            Value::Double(_) => Type::Double,
        }
    }
    pub fn literal(self) -> Expr {
        let bits = match self {
            Value::Boolean(b) => boolean(b),
            Value::Integer(i) => integer(i),
            Value::Double(d) => real(d),
        };
        Expr { kind: ExprKind::Literal(bits), of: self.kind() }
    }
}
