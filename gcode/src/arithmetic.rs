//! Operators and functions of expressions (docs/dialect.md, section 15.2): what they are called and what they give.

use crate::diagnostics::{Check, Fault, Id, Span};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Op {
    Add,
    Sub,
    Mul,
    Div,
    Mod,
    Power,
    Eq,
    Ne,
    Gt,
    Ge,
    Lt,
    Le,
    And,
    Or,
    Xor,
    BitAnd,
    BitOr,
    BitXor,
}

/// Operators: text, meaning, precedence. Longer signs first.
pub(crate) const OPERATORS: &[(&str, Op, u8)] = &[
    ("**", Op::Power, 5),
    ("*", Op::Mul, 4),
    ("/", Op::Div, 4),
    ("MOD", Op::Mod, 4),
    ("+", Op::Add, 3),
    ("-", Op::Sub, 3),
    ("==", Op::Eq, 2),
    ("<>", Op::Ne, 2),
    (">=", Op::Ge, 2),
    ("<=", Op::Le, 2),
    (">", Op::Gt, 2),
    ("<", Op::Lt, 2),
    ("EQ", Op::Eq, 2),
    ("NE", Op::Ne, 2),
    ("GT", Op::Gt, 2),
    ("GE", Op::Ge, 2),
    ("LT", Op::Lt, 2),
    ("LE", Op::Le, 2),
    ("AND", Op::And, 1),
    ("OR", Op::Or, 1),
    ("XOR", Op::Xor, 1),
    ("BAND", Op::BitAnd, 1),
    ("BOR", Op::BitOr, 1),
    ("BXOR", Op::BitXor, 1),
];

/// Functions and how many arguments they take.
pub(crate) const FUNCTIONS: &[(&str, usize, usize)] = &[
    ("SIN", 1, 1),
    ("COS", 1, 1),
    ("TAN", 1, 1),
    ("ASIN", 1, 1),
    ("ACOS", 1, 1),
    ("ATAN", 1, 1),
    ("SQRT", 1, 1),
    ("ABS", 1, 1),
    ("ROUND", 1, 1),
    ("FIX", 1, 1),
    ("FUP", 1, 1),
    ("TRUNC", 1, 1),
    ("INT", 1, 1),
    ("LN", 1, 1),
    ("EXP", 1, 1),
    ("POW", 2, 2),
    ("MIN", 1, 99),
    ("MAX", 1, 99),
];

const LARGEST: f64 = 1e300;

/// `a op b`; EQ and NE hold within `equal`.
pub(crate) fn apply(op: Op, a: f64, b: f64, equal: f64, span: Span) -> Check<f64> {
    let truth = |t: bool| f64::from(u8::from(t));
    let bits = |f: fn(i64, i64) -> i64| f(a as i64, b as i64) as f64;
    let value = match op {
        Op::Add => a + b,
        Op::Sub => a - b,
        Op::Mul => a * b,
        Op::Div | Op::Mod if b == 0.0 => return Err(Fault::new(Id::GC710, span)),
        Op::Div => a / b,
        Op::Mod => a - b * (a / b).floor(),
        Op::Power if a == 0.0 && b < 0.0 || a < 0.0 && b.fract() != 0.0 => {
            return Err(Fault::with(Id::GC711, span, &[&b, &"**"]));
        }
        Op::Power => a.powf(b),
        Op::Eq => truth((a - b).abs() <= equal),
        Op::Ne => truth((a - b).abs() > equal),
        Op::Gt => truth(a > b),
        Op::Ge => truth(a >= b),
        Op::Lt => truth(a < b),
        Op::Le => truth(a <= b),
        Op::And => truth(a != 0.0 && b != 0.0),
        Op::Or => truth(a != 0.0 || b != 0.0),
        Op::Xor => truth((a != 0.0) != (b != 0.0)),
        Op::BitAnd => bits(|a, b| a & b),
        Op::BitOr => bits(|a, b| a | b),
        Op::BitXor => bits(|a, b| a ^ b),
    };
    finite(value, span)
}

pub(crate) fn finite(value: f64, span: Span) -> Check<f64> {
    if value.abs() <= LARGEST { Ok(value) } else { Err(Fault::new(Id::GC712, span)) }
}

pub(crate) fn call(name: &str, arguments: &[f64], span: Span) -> Check<f64> {
    let a = arguments[0];
    let b = arguments.get(1).copied().unwrap_or(0.0);
    let outside = |bad: bool| if bad { Err(Fault::with(Id::GC711, span, &[&a, &name])) } else { Ok(()) };
    Ok(match name {
        "SIN" => degrees(a).0,
        "COS" => degrees(a).1,
        "TAN" => {
            let (sin, cos) = degrees(a);
            outside(cos == 0.0)?;
            sin / cos
        }
        "ASIN" | "ACOS" => {
            outside(a.abs() > 1.0)?;
            if name == "ASIN" { a.asin().to_degrees() } else { a.acos().to_degrees() }
        }
        "ATAN" => a.atan2(b).to_degrees(),
        "SQRT" => {
            outside(a < 0.0)?;
            a.sqrt()
        }
        "ABS" => a.abs(),
        "ROUND" => a.round(),
        "FIX" => a.floor(),
        "FUP" => a.ceil(),
        "TRUNC" | "INT" => a.trunc(),
        "LN" => {
            outside(a <= 0.0)?;
            a.ln()
        }
        "EXP" => a.exp(),
        "POW" => {
            outside(a == 0.0 && b < 0.0 || a < 0.0 && b.fract() != 0.0)?;
            a.powf(b)
        }
        "MIN" => arguments.iter().copied().fold(f64::INFINITY, f64::min),
        _ => arguments.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    })
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90.
pub fn degrees(angle: f64) -> (f64, f64) {
    let turn = angle.rem_euclid(360.0);
    match turn {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => turn.to_radians().sin_cos(),
    }
}
