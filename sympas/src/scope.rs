//! Names and what they stand for (5.3.2.2): those of the routine hide those of the program, which hide predefined ones.

use std::collections::HashMap;
use std::rc::Rc;

use motion_kernel::sap::code::Slot;
use motion_kernel::sap::tables::{Event, Function, SystemParameter, TaskCommand, Type, command};

use crate::diagnostics::{Phrase, closest};
use crate::source::Span;
use crate::types::Value;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Symbol {
    Constant(Value),
    Variable(Slot, Type),
    Axis(Slot),
    Routine(u16),
    /// Number within its block.
    Label(u32),
    /// Used without a declaration: reported once.
    Unknown,
}

/// What a name stands for that the program does not declare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Predefined {
    Boolean(bool),
    System(SystemParameter),
    Ci(u32),
    Cd(u32),
    SysVarInt,
    SysVarDbl,
    Event(Event),
    Function(Function),
    Power,
    /// rdcbd, rdcbi, rdcbs.
    ReadBuffer(Type),
    /// Anything that stands as a statement.
    Command,
}

#[derive(Clone, Copy, Debug)]
pub enum Found {
    User(Symbol),
    Predefined(Predefined),
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    symbol: Symbol,
    span: Span,
}

#[derive(Debug, Default)]
pub struct Scopes {
    axes: HashMap<Rc<str>, Slot>,
    global: HashMap<Rc<str>, Entry>,
    local: Option<HashMap<Rc<str>, Entry>>,
}

impl Scopes {
    pub fn new(axes: &[String]) -> Self {
        let slots = axes.iter().enumerate().map(|(n, name)| (name.as_str().into(), Slot::global(n as u16)));
        Scopes { axes: slots.collect(), ..Scopes::default() }
    }
    pub fn enter(&mut self) {
        self.local = Some(HashMap::new());
    }
    pub fn leave(&mut self) {
        self.local = None;
    }
    /// Declares a name in the innermost block, or says where it already is.
    pub fn declare(&mut self, name: &Rc<str>, symbol: Symbol, span: Span) -> Result<(), Span> {
        let scope = self.local.as_mut().unwrap_or(&mut self.global);
        if let Some(known) = scope.get(name).filter(|known| known.symbol != Symbol::Unknown) {
            return Err(known.span);
        }
        scope.insert(name.clone(), Entry { symbol, span });
        Ok(())
    }
    /// Remembers that an undeclared name was reported.
    pub fn poison(&mut self, name: &Rc<str>) {
        let scope = self.local.as_mut().unwrap_or(&mut self.global);
        scope.entry(name.clone()).or_insert(Entry { symbol: Symbol::Unknown, span: Span::default() });
    }
    /// What the innermost block itself declares.
    pub fn innermost(&self, name: &str) -> Option<Symbol> {
        self.local.as_ref().unwrap_or(&self.global).get(name).map(|e| e.symbol)
    }
    pub fn global(&self, name: &str) -> Option<(Symbol, Span)> {
        self.global.get(name).map(|e| (e.symbol, e.span))
    }
    pub fn find(&self, name: &str) -> Option<Found> {
        let user = self.local.as_ref().and_then(|scope| scope.get(name)).or_else(|| self.global.get(name));
        if let Some(entry) = user {
            return Some(Found::User(entry.symbol));
        }
        if let Some(slot) = self.axes.get(name) {
            return Some(Found::User(Symbol::Axis(*slot)));
        }
        predefined(name).map(Found::Predefined)
    }
    /// A visible name that `name` may be a slip of.
    pub fn suggest(&self, name: &str) -> Option<&str> {
        let local = self.local.iter().flatten().chain(&self.global);
        let users = local.filter(|(_, e)| e.symbol != Symbol::Unknown).map(|(n, _)| n.as_ref());
        let axes = self.axes.keys().map(AsRef::as_ref);
        let mut all: Vec<&str> = users.chain(axes).collect();
        all.sort_unstable(); // a map has no order of its own, messages must have one
        closest(name, all.into_iter()).or_else(|| closest(name, predefined_names()))
    }
}

fn predefined_names() -> impl Iterator<Item = &'static str> {
    use motion_kernel::sap::tables::{Command, SPECIAL};
    let system = SystemParameter::ALL.iter().map(|p| p.name());
    let functions = Function::ALL.iter().map(|f| f.name());
    let commands = Command::ALL.iter().map(|c| c.name()).chain(TaskCommand::ALL.iter().map(|c| c.name()));
    system
        .chain(Event::ALL.iter().map(|e| e.name()))
        .chain(functions)
        .chain(commands)
        .chain(SPECIAL)
        .chain(["SysVarInt", "SysVarDbl"])
}

/// CI or CD with nothing but digits behind it.
fn common(name: &str) -> Option<Predefined> {
    let digits = name.get(2..).filter(|d| !d.is_empty() && d.bytes().all(|b| b.is_ascii_digit()))?;
    let number = digits.parse().unwrap_or(u32::MAX);
    match &name[..2] {
        "CI" => Some(Predefined::Ci(number)),
        "CD" => Some(Predefined::Cd(number)),
        _ => None,
    }
}

/// System parameters and events in their own case, commands and functions in any (6.3.1, E7).
pub fn predefined(name: &str) -> Option<Predefined> {
    if let Some(parameter) = SystemParameter::by_name(name) {
        return Some(Predefined::System(parameter));
    }
    if let Some(event) = Event::ALL.iter().find(|e| e.name() == name) {
        return Some(Predefined::Event(*event));
    }
    if let Some(variable) = common(name) {
        return Some(variable);
    }
    if let Some(function) = Function::by_name(name) {
        return Some(Predefined::Function(function));
    }
    match name.to_ascii_lowercase().as_str() {
        "true" => Some(Predefined::Boolean(true)),
        "false" => Some(Predefined::Boolean(false)),
        "power" => Some(Predefined::Power),
        "rdcbd" => Some(Predefined::ReadBuffer(Type::Double)),
        "rdcbi" => Some(Predefined::ReadBuffer(Type::Integer)),
        "rdcbs" => Some(Predefined::ReadBuffer(Type::Single)),
        _ if name == "SysVarInt" => Some(Predefined::SysVarInt),
        _ if name == "SysVarDbl" => Some(Predefined::SysVarDbl),
        lower => {
            let special = motion_kernel::sap::tables::SPECIAL.contains(&lower);
            let known = special || command(lower).is_some() || TaskCommand::by_name(lower).is_some();
            known.then_some(Predefined::Command)
        }
    }
}

/// What kind of thing a name stands for, as messages say it.
pub fn kind_of(found: Found) -> Phrase {
    let (english, german) = match found {
        Found::User(Symbol::Constant(_)) | Found::Predefined(Predefined::Boolean(_)) => {
            ("a constant", "eine Konstante")
        }
        Found::User(Symbol::Variable(..)) => ("a variable", "eine Variable"),
        Found::User(Symbol::Axis(_)) => ("an axis", "eine Achse"),
        Found::User(Symbol::Routine(_)) => ("a routine", "eine Routine"),
        Found::User(Symbol::Label(_)) => ("a label", "ein Label"),
        Found::User(Symbol::Unknown) => ("unknown", "unbekannt"),
        Found::Predefined(Predefined::Event(_)) => ("an event", "ein Ereignis"),
        Found::Predefined(Predefined::Function(_) | Predefined::Power | Predefined::ReadBuffer(_)) => {
            ("a function", "eine Funktion")
        }
        Found::Predefined(Predefined::Command) => ("a command", "ein Befehl"),
        Found::Predefined(Predefined::SysVarInt | Predefined::SysVarDbl) => {
            ("an array of system variables", "ein Feld von Systemvariablen")
        }
        Found::Predefined(Predefined::System(_) | Predefined::Ci(_) | Predefined::Cd(_)) => {
            ("a system parameter", "ein Systemparameter")
        }
    };
    Phrase::new(english, german)
}
