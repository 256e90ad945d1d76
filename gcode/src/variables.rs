//! Variables of a program (docs/dialect.md, section 15.1): `#n`, `CIn`, `CDn`, names.

use std::collections::HashMap;

use crate::diagnostics::{Check, Fault, Id, Span};

/// What an assignment names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Variable {
    Hash(u32),
    Ci(u16),
    Cd(u16),
    /// Letters and `_` (in the oword dialect also digits); global when it starts with `_`.
    Name(String),
}

impl std::fmt::Display for Variable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Variable::Hash(n) => write!(f, "#{n}"),
            Variable::Ci(n) => write!(f, "CI{n}"),
            Variable::Cd(n) => write!(f, "CD{n}"),
            Variable::Name(name) => f.write_str(name),
        }
    }
}

/// An assignment of the block that is being read.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    pub variable: Variable,
    pub value: f64,
    pub span: Span,
}

const LOCALS: usize = 33;
const COMMONS: usize = 3000;

/// One level of local variables; NaN is "empty".
#[derive(Clone, Debug)]
struct Level {
    hash: [f64; LOCALS + 1],
    names: HashMap<String, f64>,
}

impl Level {
    fn new() -> Self {
        Level { hash: [f64::NAN; LOCALS + 1], names: HashMap::new() }
    }
}

#[derive(Clone, Debug)]
pub struct Variables {
    levels: Vec<Level>,
    common: Vec<f64>,
    names: HashMap<String, f64>,
    ci: HashMap<u16, i32>,
    cd: HashMap<u16, f64>,
    /// Reading an empty `#n` gives 0.
    pub vacant_zero: bool,
    /// Names are local to a call unless they start with `_`.
    pub local_names: bool,
}

impl Variables {
    pub fn new(vacant_zero: bool, local_names: bool) -> Self {
        Variables {
            levels: vec![Level::new()],
            common: vec![f64::NAN; COMMONS],
            names: HashMap::new(),
            ci: HashMap::new(),
            cd: HashMap::new(),
            vacant_zero,
            local_names,
        }
    }
    fn level(&self) -> &Level {
        self.levels.last().expect("the main program has a level")
    }
    /// A variable that programs may set at all: LinuxCNC knows no gaps up to 2999.
    pub fn is_free(&self, n: u32) -> bool {
        matches!(n, 1..=33 | 100..=199 | 500..=999) || self.local_names && (n as usize) < COMMONS && n > 0
    }
    /// A new set of locals for a macro call, with its arguments.
    pub fn enter(&mut self, arguments: &[(usize, f64)]) {
        let mut level = Level::new();
        for &(n, value) in arguments {
            level.hash[n] = value;
        }
        self.levels.push(level);
    }
    pub fn leave(&mut self) {
        if self.levels.len() > 1 {
            self.levels.pop();
        }
    }
    /// The stored value; `None` if it was never assigned.
    pub fn get(&self, variable: &Variable) -> Option<f64> {
        match variable {
            Variable::Hash(n @ 1..=33) => Some(self.level().hash[*n as usize]).filter(|v| !v.is_nan()),
            Variable::Hash(n) => self.common.get(*n as usize).copied().filter(|v| !v.is_nan()),
            Variable::Ci(n) => self.ci.get(n).map(|&v| f64::from(v)),
            Variable::Cd(n) => self.cd.get(n).copied(),
            Variable::Name(name) if self.is_local(name) => self.level().names.get(name).copied(),
            Variable::Name(name) => self.names.get(name).copied(),
        }
    }
    fn is_local(&self, name: &str) -> bool {
        self.local_names && !name.starts_with('_')
    }
    /// Stores a value that [`check_assignment`] accepted.
    pub fn set(&mut self, variable: &Variable, value: f64) {
        match variable {
            Variable::Hash(n @ 1..=33) => self.levels.last_mut().expect("a level").hash[*n as usize] = value,
            Variable::Hash(n) => {
                if let Some(slot) = self.common.get_mut(*n as usize) {
                    *slot = value;
                }
            }
            Variable::Ci(n) => {
                self.ci.insert(*n, value.round() as i32);
            }
            Variable::Cd(n) => {
                self.cd.insert(*n, value);
            }
            Variable::Name(name) if self.is_local(name) => {
                self.levels.last_mut().expect("a level").names.insert(name.clone(), value);
            }
            Variable::Name(name) => {
                self.names.insert(name.clone(), value);
            }
        }
    }
}

/// May the program assign this value to this variable?
pub fn check_assignment(variables: &Variables, variable: &Variable, value: f64, span: Span) -> Check<()> {
    match variable {
        Variable::Hash(n) if variables.is_free(*n) => Ok(()),
        Variable::Hash(3000 | 3006) | Variable::Name(_) => Ok(()),
        Variable::Hash(n) => Err(Fault::with(Id::GC701, span, &[n])),
        Variable::Ci(99) => Err(Fault::new(Id::GC707, span)),
        Variable::Ci(_) if !(-2_147_483_648.5..2_147_483_647.5).contains(&value) => {
            Err(Fault::with(Id::GC705, span, &[&value]))
        }
        Variable::Ci(_) | Variable::Cd(_) => Ok(()),
    }
}
