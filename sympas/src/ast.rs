//! The program as it is written (grammar of chapters 5.3 and 6.6): names unresolved, types unchecked.

use std::rc::Rc;

use motion_kernel::sap::tables::Type;

use crate::source::Span;

#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    pub text: Rc<str>,
    pub span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    pub heading: Option<Name>,
    pub block: Block,
    /// A declaration was not understood: names may be missing.
    pub lost_names: bool,
}

/// Declarations and statements of the main program or of a routine.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    pub items: Vec<Item>,
    pub body: Vec<Statement>,
    /// Place of its `end`.
    pub end: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    Labels(Vec<Name>),
    Constant(Constant),
    Variables {
        names: Vec<Name>,
        kind: TypeName,
    },
    /// Variables whose type was misspelt, which was reported.
    Unknown(Vec<Name>),
    Routine(Routine),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    pub name: Name,
    /// Literal, or another constant with a sign; `at` counts the tokens before it.
    pub value: Expr,
    pub at: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TypeName {
    /// `None` is AXIS.
    pub kind: Option<Type>,
    pub span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Routine {
    pub name: Name,
    pub parameters: Vec<(Name, TypeName)>,
    /// `None`: a procedure.
    pub result: Option<TypeName>,
    /// `None`: announced with forward.
    pub block: Option<Block>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    pub labels: Vec<Name>,
    pub span: Span,
    pub kind: StatementKind,
}

#[derive(Clone, Debug, PartialEq)]
pub enum StatementKind {
    Empty,
    Assign { target: Reference, value: Expr },
    Call(Call),
    Goto(Name),
    Compound(Vec<Statement>),
    If { condition: Expr, then: Box<Statement>, otherwise: Option<Box<Statement>> },
    While { condition: Expr, body: Box<Statement> },
    Repeat { body: Vec<Statement>, condition: Expr, until: Span },
    For { variable: Reference, from: Expr, to: Expr, down: bool, body: Box<Statement> },
}

/// A call of a routine, command or function, with or without parentheses.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    pub name: Name,
    pub parentheses: bool,
    pub arguments: Vec<Argument>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    /// `axis :=` or `PHI :=` in front of the value.
    pub name: Option<Name>,
    pub value: Expr,
}

/// `name`, `name[index]`, `axis.qualifier`, `axis.qualifier[index]`, `axis.qualifier.bit`.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    pub name: Name,
    pub index: Option<Box<Expr>>,
    pub qualifier: Option<Qualifier>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Qualifier {
    pub name: Name,
    pub index: Option<Box<Expr>>,
    /// A literal, or the name of a constant.
    pub bit: Option<Box<Expr>>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    pub kind: ExprKind,
    pub span: Span,
    /// Height of the tree: bounded, so that every walk over it is.
    pub height: u16,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    Integer(i32),
    Double(f64),
    Text(Rc<str>),
    /// A variable, constant, register or a call without parentheses.
    Reference(Reference),
    Call(Call),
    Convert(Type, Box<Expr>),
    Unary(Unary, Box<Expr>),
    Binary(Binary, Box<Expr>, Box<Expr>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    Plus,
    Minus,
    Not,
}

impl Unary {
    pub const fn text(self) -> &'static str {
        match self {
            Unary::Plus => "+",
            Unary::Minus => "-",
            Unary::Not => "not",
        }
    }
}

macro_rules! operators {
    ($($variant:ident $text:literal $rank:literal;)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Binary { $($variant,)* }

        impl Binary {
            pub const ALL: &[Binary] = &[$(Binary::$variant,)*];
            pub const fn text(self) -> &'static str {
                match self { $(Binary::$variant => $text,)* }
            }
            /// Table 26; 1 is reserved for unary operators.
            pub const fn rank(self) -> u8 {
                match self { $(Binary::$variant => $rank,)* }
            }
            pub const fn is_relation(self) -> bool {
                self.rank() == 4
            }
        }
    };
}

operators! {
    Mul "*" 2; Div "/" 2; Mod "mod" 2; Shl "shl" 2; Shr "shr" 2; And "and" 2;
    Add "+" 3; Sub "-" 3; Or "or" 3; Xor "xor" 3;
    Eq "=" 4; Ne "<>" 4; Lt "<" 4; Gt ">" 4; Le "<=" 4; Ge ">=" 4;
}
