//! A second opinion of the language core: walks the syntax tree, knows types at run time only and shares no code with
//! analysis, code generation or the controller. Programs are those that the compiler accepts.

use std::collections::{BTreeMap, HashMap};

use motion_kernel::sap::tables::Type;
use sympas::ast::{Argument, Block, Call, Expr, ExprKind, Item, Program, Reference, Routine, Statement, StatementKind};

use super::values::{Value, binary, function, unary};

/// How a program ended.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    Finished,
    /// Number and line.
    Error(u32, u32),
    /// abort
    Aborted,
    /// More statements than allowed.
    Endless,
    /// Not part of the core: axes, tasks, time.
    Beyond(String),
}

/// What can be observed of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    pub end: End,
    pub output: String,
    pub ci: BTreeMap<u32, i32>,
    pub cd: BTreeMap<u32, f64>,
}

enum Flow {
    Next,
    Goto(String),
}

enum Halt {
    Error(u32),
    Aborted,
    Endless,
    Beyond(String),
}

type Run<T> = Result<T, Halt>;

#[derive(Clone, Copy)]
struct Cell {
    of: Type,
    value: Value,
}

#[derive(Default)]
struct Frame<'p> {
    variables: HashMap<&'p str, Cell>,
    constants: HashMap<&'p str, Value>,
    function: Option<&'p str>,
}

struct Machine<'p> {
    frames: Vec<Frame<'p>>,
    routines: HashMap<&'p str, &'p Routine>,
    output: String,
    ci: BTreeMap<u32, i32>,
    cd: BTreeMap<u32, f64>,
    buffer: Vec<u8>,
    line: u32,
    left: u64,
}

/// Runs a program for at most so many statements.
pub fn run(program: &Program, most: u64) -> Outcome {
    let mut machine = Machine {
        frames: vec![Frame::default()],
        routines: HashMap::new(),
        output: String::new(),
        ci: BTreeMap::new(),
        cd: BTreeMap::new(),
        buffer: vec![0; 1000],
        line: 0,
        left: most,
    };
    let halt = machine.block(&program.block).err();
    let end = match halt {
        None => End::Finished,
        Some(Halt::Error(number)) => End::Error(number, machine.line),
        Some(Halt::Aborted) => End::Aborted,
        Some(Halt::Endless) => End::Endless,
        Some(Halt::Beyond(what)) => End::Beyond(what),
    };
    Outcome { end, output: machine.output, ci: machine.ci, cd: machine.cd }
}

/// Text form of a value (6.6.79).
pub fn shown(value: Value) -> String {
    match value {
        Value::Boolean(b) => if b { "TRUE" } else { "FALSE" }.to_owned(),
        Value::Integer(i) => i.to_string(),
        Value::Timer(t) => t.to_string(),
        Value::Single(x) => super::real_text(f64::from(x as f32), true),
        Value::Double(x) => super::real_text(x, false),
    }
}

impl<'p> Machine<'p> {
    fn block(&mut self, block: &'p Block) -> Run<()> {
        for item in &block.items {
            match item {
                Item::Labels(_) | Item::Unknown(_) => {}
                Item::Constant(c) => {
                    let value = self.value(&c.value)?;
                    self.frame().constants.insert(&c.name.text, value);
                }
                Item::Variables { names, kind } => {
                    let Some(of) = kind.kind else { return Err(Halt::Beyond("axis".to_owned())) };
                    for name in names {
                        self.frame().variables.insert(&name.text, Cell { of, value: Value::zero(of) });
                    }
                }
                Item::Routine(routine) if routine.block.is_some() => {
                    self.routines.insert(&routine.name.text, routine);
                }
                Item::Routine(_) => {}
            }
        }
        self.sequence(&block.body).map(|_| ())
    }
    fn frame(&mut self) -> &mut Frame<'p> {
        self.frames.last_mut().expect("the main program has a frame")
    }
    fn tick(&mut self) -> Run<()> {
        self.left = self.left.checked_sub(1).ok_or(Halt::Endless)?;
        Ok(())
    }
    /// A goto looks for its label in the sequences around it, from the inside.
    fn sequence(&mut self, list: &'p [Statement]) -> Run<Flow> {
        let mut at = 0;
        while at < list.len() {
            match self.statement(&list[at])? {
                Flow::Next => at += 1,
                Flow::Goto(label) => {
                    self.tick()?;
                    let target = list.iter().position(|s| s.labels.iter().any(|l| *l.text == *label));
                    match target {
                        Some(target) => at = target,
                        None => return Ok(Flow::Goto(label)),
                    }
                }
            }
        }
        Ok(Flow::Next)
    }
    fn statement(&mut self, statement: &'p Statement) -> Run<Flow> {
        self.tick()?;
        self.line = statement.span.line;
        match &statement.kind {
            StatementKind::Empty => {}
            StatementKind::Compound(list) => return self.sequence(list),
            StatementKind::Goto(label) => return Ok(Flow::Goto(label.text.to_string())),
            StatementKind::Assign { target, value } => self.assign(target, value)?,
            StatementKind::Call(call) => self.call_statement(call)?,
            StatementKind::If { condition, then, otherwise } => {
                if self.truth(condition)? {
                    return self.statement(then);
                } else if let Some(other) = otherwise {
                    return self.statement(other);
                }
            }
            StatementKind::While { condition, body } => {
                while self.truth(condition)? {
                    if let Flow::Goto(label) = self.statement(body)? {
                        return Ok(Flow::Goto(label));
                    }
                    self.tick()?;
                    self.line = statement.span.line;
                }
            }
            StatementKind::Repeat { body, condition, until } => loop {
                if let Flow::Goto(label) = self.sequence(body)? {
                    return Ok(Flow::Goto(label));
                }
                self.tick()?;
                self.line = until.line;
                if self.truth(condition)? {
                    break;
                }
            },
            StatementKind::For { variable, from, to, down, body } => {
                return self.for_statement(variable, [from, to], *down, body);
            }
        }
        Ok(Flow::Next)
    }
    fn for_statement(
        &mut self,
        variable: &Reference,
        [from, to]: [&'p Expr; 2],
        down: bool,
        body: &'p Statement,
    ) -> Run<Flow> {
        let Value::Integer(first) = self.value(from)? else { panic!("a bound is Integer") };
        let Value::Integer(last) = self.value(to)? else { panic!("a bound is Integer") };
        let name = variable.name.text.to_string();
        self.cell(&name).expect("a loop variable").value = Value::Integer(first);
        let within = |i: i32| if down { i >= last } else { i <= last };
        if !within(first) {
            return Ok(Flow::Next);
        }
        loop {
            if let Flow::Goto(label) = self.statement(body)? {
                return Ok(Flow::Goto(label));
            }
            let cell = self.cell(&name).expect("a loop variable");
            let Value::Integer(i) = cell.value else { panic!("a loop variable is Integer") };
            if if down { i <= last } else { i >= last } {
                return Ok(Flow::Next);
            }
            cell.value = Value::Integer(if down { i - 1 } else { i + 1 });
        }
    }
    fn truth(&mut self, condition: &'p Expr) -> Run<bool> {
        match self.value(condition)? {
            Value::Boolean(b) => Ok(b),
            other => panic!("condition {other:?}"),
        }
    }
    /// A variable: of the running routine, else global.
    fn cell(&mut self, name: &str) -> Option<&mut Cell> {
        let last = self.frames.len() - 1;
        let hidden = self.frames[last].constants.contains_key(name);
        if self.frames[last].variables.contains_key(name) || hidden {
            return self.frames[last].variables.get_mut(name);
        }
        self.frames[0].variables.get_mut(name)
    }
    fn assign(&mut self, target: &'p Reference, source: &'p Expr) -> Run<()> {
        if target.index.is_some() || target.qualifier.is_some() {
            return Err(Halt::Beyond(target.name.text.to_string()));
        }
        let value = self.value(source)?;
        let name: &str = &target.name.text;
        if let Some(cell) = self.cell(name) {
            cell.value = value.to(cell.of);
            return Ok(());
        }
        match common(name) {
            Some((_, n)) if n > 999 => return Err(Halt::Error(0x0400)),
            Some((true, n)) => {
                let Value::Integer(i) = value.to(Type::Integer) else { unreachable!() };
                self.ci.insert(n, i);
            }
            Some((false, n)) => {
                self.cd.insert(n, value.real());
            }
            None => return Err(Halt::Beyond(name.to_owned())),
        }
        Ok(())
    }
    fn value(&mut self, expr: &'p Expr) -> Run<Value> {
        Ok(match &expr.kind {
            ExprKind::Integer(i) => Value::Integer(*i),
            ExprKind::Double(x) => Value::Double(*x),
            ExprKind::Text(_) => panic!("a string is no value"),
            ExprKind::Reference(reference) => return self.reference(reference),
            ExprKind::Call(call) => return self.function(&call.name.text, &call.arguments),
            ExprKind::Convert(of, inner) => self.value(inner)?.to(*of),
            ExprKind::Unary(operator, inner) => unary(*operator, self.value(inner)?),
            ExprKind::Binary(operator, left, right) => {
                let (a, b) = (self.value(left)?, self.value(right)?);
                binary(*operator, a, b).map_err(Halt::Error)?
            }
        })
    }
    fn reference(&mut self, reference: &'p Reference) -> Run<Value> {
        let name: &'p str = &reference.name.text;
        if reference.index.is_some() || reference.qualifier.is_some() {
            return Err(Halt::Beyond(name.to_owned()));
        }
        let last = self.frames.len() - 1;
        if let Some(value) = self.frames[last].constants.get(name) {
            return Ok(*value);
        }
        if let Some(cell) = self.cell(name) {
            return Ok(cell.value);
        }
        if let Some(value) = self.frames[0].constants.get(name) {
            return Ok(*value);
        }
        match common(name) {
            Some((_, n)) if n > 999 => return Err(Halt::Error(0x0400)),
            Some((true, n)) => return Ok(Value::Integer(self.ci.get(&n).copied().unwrap_or(0))),
            Some((false, n)) => return Ok(Value::Double(self.cd.get(&n).copied().unwrap_or(0.0))),
            None => {}
        }
        match name.to_ascii_lowercase().as_str() {
            "true" if !self.routines.contains_key(name) => Ok(Value::Boolean(true)),
            "false" if !self.routines.contains_key(name) => Ok(Value::Boolean(false)),
            _ => self.function(name, &[]),
        }
    }
    fn function(&mut self, name: &'p str, arguments: &'p [Argument]) -> Run<Value> {
        if let Some(routine) = self.routines.get(name).copied() {
            return self.routine(routine, arguments).map(|v| v.expect("a function has a result"));
        }
        let mut values = Vec::new();
        for argument in arguments {
            values.push(self.value(&argument.value)?);
        }
        match (name.to_ascii_lowercase().as_str(), values.as_slice()) {
            ("power", [a, b]) => Ok(Value::Double(a.real().powf(b.real()))),
            ("rdcbi", [offset]) => {
                self.buffer(offset, 4).map(|b| Value::Integer(i32::from_le_bytes(b[..4].try_into().unwrap())))
            }
            ("rdcbs", [offset]) => {
                self.buffer(offset, 4).map(|b| Value::Single(f64::from(f32::from_le_bytes(b[..4].try_into().unwrap()))))
            }
            ("rdcbd", [offset]) => {
                self.buffer(offset, 8).map(|b| Value::Double(f64::from_le_bytes(b[..8].try_into().unwrap())))
            }
            (known, [x]) if known != "wt" => Ok(Value::Double(function(known, x.real()))),
            (other, _) => Err(Halt::Beyond(other.to_owned())),
        }
    }
    /// The bytes of the common buffer from an offset on.
    fn buffer(&mut self, offset: &Value, size: i32) -> Run<&mut [u8]> {
        let Value::Integer(at) = offset.to(Type::Integer) else { unreachable!() };
        if !(0..=1000 - size).contains(&at) {
            return Err(Halt::Error(0x0100));
        }
        if at % size != 0 {
            return Err(Halt::Error(if size == 8 { 0x0800 } else { 0x0100 }));
        }
        Ok(&mut self.buffer[at as usize..])
    }
    fn routine(&mut self, routine: &'p Routine, arguments: &'p [Argument]) -> Run<Option<Value>> {
        let mut frame = Frame::default();
        for ((name, kind), argument) in routine.parameters.iter().zip(arguments) {
            let of = kind.kind.expect("a parameter has a value");
            let value = self.value(&argument.value)?.to(of);
            frame.variables.insert(&name.text, Cell { of, value });
        }
        let result = routine.result.and_then(|t| t.kind);
        if let Some(of) = result {
            frame.variables.insert(&routine.name.text, Cell { of, value: Value::zero(of) });
            frame.function = Some(&routine.name.text);
        }
        let line = self.line;
        self.frames.push(frame);
        if self.frames.len() > 60 {
            return Err(Halt::Beyond("recursion".to_owned()));
        }
        self.block(routine.block.as_ref().expect("a routine has a block"))?;
        let frame = self.frames.pop().expect("its own frame");
        self.line = line;
        Ok(result.map(|_| frame.variables[&*routine.name.text].value))
    }
    fn call_statement(&mut self, call: &'p Call) -> Run<()> {
        let name: &'p str = &call.name.text;
        if let Some(routine) = self.routines.get(name).copied() {
            return self.routine(routine, &call.arguments).map(|_| ());
        }
        match name.to_ascii_lowercase().as_str() {
            "write" => self.write(&call.arguments),
            "writeln" => {
                self.write(&call.arguments)?;
                self.output.push('\n');
                Ok(())
            }
            "abort" => Err(Halt::Aborted),
            size @ ("wrcbi" | "wrcbs" | "wrcbd") => {
                let offset = self.value(&call.arguments[0].value)?;
                let value = self.value(&call.arguments[1].value)?;
                let bytes = match size {
                    "wrcbi" => match value.to(Type::Integer) {
                        Value::Integer(i) => i.to_le_bytes().to_vec(),
                        _ => unreachable!(),
                    },
                    "wrcbs" => (value.real() as f32).to_le_bytes().to_vec(),
                    _ => value.real().to_le_bytes().to_vec(),
                };
                self.buffer(&offset, bytes.len() as i32)?[..bytes.len()].copy_from_slice(&bytes);
                Ok(())
            }
            other => Err(Halt::Beyond(other.to_owned())),
        }
    }
    fn write(&mut self, arguments: &'p [Argument]) -> Run<()> {
        for argument in arguments {
            match &argument.value.kind {
                ExprKind::Text(text) => self.output.push_str(text),
                _ => {
                    let value = self.value(&argument.value)?;
                    self.output.push_str(&shown(value));
                }
            }
        }
        Ok(())
    }
}

/// `CI12` is (true, 12), `CD3` (false, 3).
fn common(name: &str) -> Option<(bool, u32)> {
    let (kind, digits) = name.split_at_checked(2)?;
    let number = digits.parse().ok().filter(|_| digits.bytes().all(|b| b.is_ascii_digit()))?;
    match kind {
        "CI" => Some((true, number)),
        "CD" => Some((false, number)),
        _ => None,
    }
}
