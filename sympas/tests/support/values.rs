//! Values of the second opinion, with their types at run time.

use motion_kernel::sap::tables::Type;
use sympas::ast::{Binary, Unary};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    Boolean(bool),
    Integer(i32),
    Timer(u32),
    /// Double precision while it is in an expression.
    Single(f64),
    Double(f64),
}

use Value::{Boolean, Double, Integer, Single, Timer};

/// Runtime errors are their numbers of table 40.
pub type Checked = Result<Value, u32>;

const OPERAND: u32 = 0x8000;

impl Value {
    pub fn zero(of: Type) -> Value {
        match of {
            Type::Boolean => Boolean(false),
            Type::Integer => Integer(0),
            Type::Timer => Timer(0),
            Type::Single => Single(0.0),
            Type::Double => Double(0.0),
        }
    }
    pub fn real(self) -> f64 {
        match self {
            Boolean(b) => f64::from(u8::from(b)),
            Integer(i) => f64::from(i),
            Timer(t) => f64::from(t),
            Single(x) | Double(x) => x,
        }
    }
    /// Conversion, also the one of an assignment, which rounds what becomes Single.
    pub fn to(self, of: Type) -> Value {
        match of {
            Type::Boolean => Boolean(match self {
                Boolean(b) => b,
                other => other.real() != 0.0,
            }),
            Type::Integer => Integer(match self {
                Boolean(b) => i32::from(b),
                Integer(i) => i,
                Timer(t) => t as i32,
                Single(x) | Double(x) => x as i32,
            }),
            Type::Timer => Timer(match self {
                Timer(t) => t,
                Integer(i) => i as u32,
                other => other.real() as u32,
            }),
            Type::Single => Single(f64::from(self.real() as f32)),
            Type::Double => Double(self.real()),
        }
    }
}

pub fn unary(operator: Unary, value: Value) -> Value {
    match (operator, value) {
        (Unary::Plus, v) => v,
        (Unary::Minus, Integer(i)) => Integer(i.wrapping_neg()),
        (Unary::Minus, Single(x)) => Single(-x),
        (Unary::Minus, Double(x)) => Double(-x),
        (Unary::Not, Boolean(b)) => Boolean(!b),
        (Unary::Not, Integer(i)) => Integer(!i),
        (operator, value) => panic!("{} {value:?}", operator.text()),
    }
}

pub fn binary(operator: Binary, left: Value, right: Value) -> Checked {
    match (left, right) {
        (Boolean(a), Boolean(b)) => Ok(booleans(operator, a, b)),
        (Integer(a), Integer(b)) => integers(operator, a, b),
        (Timer(_), _) | (_, Timer(_)) => {
            let (Timer(a), Timer(b)) = (left.to(Type::Timer), right.to(Type::Timer)) else { unreachable!() };
            Ok(timers(operator, a, b))
        }
        _ => {
            let single = !matches!((left, right), (Double(_), _) | (_, Double(_)));
            reals(operator, left.real(), right.real()).map(|v| match v {
                Double(x) if single => Single(x),
                other => other,
            })
        }
    }
}

fn booleans(operator: Binary, a: bool, b: bool) -> Value {
    Boolean(match operator {
        Binary::And => a && b,
        Binary::Or => a || b,
        Binary::Xor => a != b,
        other => relation(other, i32::from(a).cmp(&i32::from(b))),
    })
}

fn relation(operator: Binary, order: std::cmp::Ordering) -> bool {
    match operator {
        Binary::Eq => order.is_eq(),
        Binary::Ne => order.is_ne(),
        Binary::Lt => order.is_lt(),
        Binary::Gt => order.is_gt(),
        Binary::Le => order.is_le(),
        Binary::Ge => order.is_ge(),
        other => panic!("{} is no relation", other.text()),
    }
}

fn integers(operator: Binary, a: i32, b: i32) -> Checked {
    Ok(Integer(match operator {
        Binary::Add => a.wrapping_add(b),
        Binary::Sub => a.wrapping_sub(b),
        Binary::Mul => a.wrapping_mul(b),
        Binary::Div | Binary::Mod if b == 0 => return Err(OPERAND),
        Binary::Div => a.wrapping_div(b),
        Binary::Mod => a.wrapping_rem(b),
        Binary::Shl => a << (b & 31),
        Binary::Shr => a >> (b & 31),
        Binary::And => a & b,
        Binary::Or => a | b,
        Binary::Xor => a ^ b,
        other => return Ok(Boolean(relation(other, a.cmp(&b)))),
    }))
}

/// Relations compare cyclically: the sign of the difference decides, half the range apart is neither before nor after.
fn timers(operator: Binary, a: u32, b: u32) -> Value {
    let after = |x: u32, y: u32| (1..=0x7FFF_FFFF).contains(&x.wrapping_sub(y));
    match operator {
        Binary::Add => Timer(a.wrapping_add(b)),
        Binary::Sub => Timer(a.wrapping_sub(b)),
        Binary::Eq => Boolean(a == b),
        Binary::Ne => Boolean(a != b),
        Binary::Gt => Boolean(after(a, b)),
        Binary::Lt => Boolean(after(b, a)),
        Binary::Le => Boolean(!after(a, b)),
        Binary::Ge => Boolean(!after(b, a)),
        other => panic!("{} of Timers", other.text()),
    }
}

fn reals(operator: Binary, a: f64, b: f64) -> Checked {
    Ok(Double(match operator {
        Binary::Add => a + b,
        Binary::Sub => a - b,
        Binary::Mul => a * b,
        Binary::Div if b == 0.0 => return Err(OPERAND),
        Binary::Div => a / b,
        Binary::Eq => return Ok(Boolean(a == b)),
        Binary::Ne => return Ok(Boolean(a != b)),
        Binary::Lt => return Ok(Boolean(a < b)),
        Binary::Gt => return Ok(Boolean(a > b)),
        Binary::Le => return Ok(Boolean(a <= b)),
        Binary::Ge => return Ok(Boolean(a >= b)),
        other => panic!("{} of reals", other.text()),
    }))
}

pub fn function(name: &str, x: f64) -> f64 {
    match name.to_ascii_lowercase().as_str() {
        "abs" => x.abs(),
        "acos" => x.acos(),
        "asin" => x.asin(),
        "atan" => x.atan(),
        "cos" => x.cos(),
        "cosh" => x.cosh(),
        "exp" => x.exp(),
        "ln" if x <= 0.0 => f64::NAN,
        "ln" => x.ln(),
        "sin" => x.sin(),
        "sinh" => x.sinh(),
        "sqr" => x * x,
        "sqrt" => x.sqrt(),
        "tan" => x.tan(),
        "tanh" => x.tanh(),
        other => panic!("no function {other}"),
    }
}
