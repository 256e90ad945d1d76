//! The labels of one block: where each is placed and from where it is reached (5.3.2.1.1.1, 5.3.5.3).

use crate::ast::Name;
use crate::diagnostics::{Fault, Id};
use crate::source::Span;

/// The structured statements around a place, outermost first.
type Path = Vec<u32>;

#[derive(Debug, Default)]
pub(crate) struct Labels {
    names: Vec<Name>,
    placed: Vec<Option<(Span, Path)>>,
    jumps: Vec<(u32, Span, Path)>,
    path: Path,
    structures: u32,
    /// The function of this block assigned its result somewhere.
    pub assigned_result: bool,
}

impl Labels {
    /// The number of the next label.
    pub fn next(&self) -> u32 {
        self.names.len() as u32
    }
    pub fn add(&mut self, name: &Name) {
        self.names.push(name.clone());
        self.placed.push(None);
    }
    /// Notes where a label stands, or says where it already does.
    pub fn place(&mut self, number: u32, span: Span) -> Result<(), Span> {
        let slot = &mut self.placed[number as usize];
        match slot {
            Some((first, _)) => Err(*first),
            None => {
                *slot = Some((span, self.path.clone()));
                Ok(())
            }
        }
    }
    pub fn jump(&mut self, number: u32, span: Span) {
        self.jumps.push((number, span, self.path.clone()));
    }
    /// Enters an if, while, repeat or for statement.
    pub fn enter(&mut self) {
        self.structures += 1;
        self.path.push(self.structures);
    }
    pub fn leave(&mut self) {
        self.path.pop();
    }
    /// Jumps without a target, and those into a structure.
    pub fn check(&self) -> Vec<Fault> {
        let fault = |(number, span, path): &(u32, Span, Path)| match &self.placed[*number as usize] {
            None => Some(Fault::new(Id::SP306, *span).with(&self.names[*number as usize].text)),
            Some((_, target)) if !path.starts_with(target) => Some(Fault::new(Id::SW909, *span)),
            Some(_) => None,
        };
        self.jumps.iter().filter_map(fault).collect()
    }
}
