//! The program as it is meant: names resolved to slots and registers, types checked, conversions explicit.

use motion_kernel::sap::code::Slot;
use motion_kernel::sap::program::Variable;
use motion_kernel::sap::tables::{
    BitQualifier, Command, Event, Function, Indexed, Qualifier, SystemParameter, TaskCommand, Type,
};

use crate::ast::{Binary, Unary};
use crate::source::Span;

#[derive(Debug, Default)]
pub struct Unit {
    pub name: String,
    pub task: Option<u8>,
    pub full_system: bool,
    pub axes: u8,
    /// Initial values of axes and variables; literals follow when code is generated.
    pub globals: Vec<u64>,
    /// Number 0 is the main program.
    pub routines: Vec<Routine>,
    pub events: [Option<u16>; Event::ALL.len()],
    pub variables: Vec<Variable>,
}

#[derive(Debug, Default)]
pub struct Routine {
    pub name: String,
    pub parameters: u16,
    pub function: bool,
    /// Result, parameters, variables and loop bounds.
    pub slots: u16,
    pub labels: u32,
    pub body: Vec<Statement>,
    /// Place of its `end`.
    pub end: Span,
}

#[derive(Debug)]
pub struct Statement {
    pub labels: Vec<u32>,
    pub span: Span,
    pub kind: StatementKind,
}

#[derive(Debug)]
pub enum StatementKind {
    Empty,
    Assign(Place, Expr),
    Call(u16, Vec<Expr>),
    Act(Action),
    Goto(u32),
    Compound(Vec<Statement>),
    If { condition: Expr, then: Box<Statement>, otherwise: Option<Box<Statement>> },
    While { condition: Expr, body: Box<Statement> },
    Repeat { body: Vec<Statement>, condition: Expr, until: Span },
    For { variable: Slot, bound: Slot, from: Expr, to: Expr, down: bool, body: Box<Statement> },
}

/// What a command does.
#[derive(Debug)]
pub enum Action {
    Do { command: Command, wait: bool, arguments: Vec<Argument> },
    Task(TaskCommand, u8),
    Azo(u8),
    Enable(Event),
    Disable(Event),
    Wait(Expr),
    Stop,
    Abort,
    WriteBuffer(Type, Expr, Expr),
    Write { outputs: Vec<Output>, line: bool },
}

#[derive(Debug)]
pub enum Argument {
    Axis(Slot),
    /// Double.
    Value(Slot, Expr),
    Parameter(SystemParameter, Expr),
}

#[derive(Debug)]
pub enum Output {
    Text(String),
    Value(Expr),
}

/// Where a value is read and written.
#[derive(Debug)]
pub enum Place {
    Slot(Slot),
    System(SystemParameter),
    Ci(u32),
    Cd(u32),
    SysVar(Indexed, Box<Expr>),
    Axis(Qualifier, Slot),
    Bit(BitQualifier, u8, Slot),
    AxisVar(Indexed, Slot, Box<Expr>),
}

#[derive(Debug)]
pub struct Expr {
    pub kind: ExprKind,
    pub of: Type,
}

/// Operands have the types that their operator works on.
#[derive(Debug)]
pub enum ExprKind {
    /// The bits of a slot.
    Literal(u64),
    Load(Place),
    Unary(Unary, Box<Expr>),
    /// Type of the operands beside them: relations are Boolean whatever they compare.
    Binary(Binary, Type, Box<Expr>, Box<Expr>),
    Convert(Box<Expr>),
    Call(u16, Vec<Expr>),
    Math(Function, Box<Expr>),
    Power(Box<Expr>, Box<Expr>),
    /// Its own type: that of the expression widens where it is used.
    ReadBuffer(Type, Box<Expr>),
}
