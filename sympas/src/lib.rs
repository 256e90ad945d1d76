//! rw_SymPas: the language of stand-alone jobs (chapters 5 and 6 of the programming manual) and its compiler.
//!
//! Text becomes tokens ([`lexer`]), a syntax tree ([`parser`], [`ast`]), a typed tree ([`analysis`], [`tree`]) and
//! register code ([`codegen`]) that a CNC task executes. Every error of a text is reported, each once ([`diagnostics`]).
//! What is predefined stands in `motion_kernel::sap::tables`, nowhere here.

pub mod analysis;
pub mod ast;
pub mod catalogue;
pub mod cnc;
pub mod codegen;
pub mod diagnostics;
mod instructions;
pub mod lexer;
pub mod listing;
pub mod parser;
pub mod reference;
pub mod scope;
pub mod source;
pub mod token;
pub mod tree;
pub mod types;

use motion_kernel::sap::program::Program;

use diagnostics::{Diagnostic, Reports};
use source::{Loader, Sources};

/// What the compiler made of a text.
#[derive(Debug)]
pub struct Compilation {
    /// `None` if there is any error.
    pub program: Option<Program>,
    /// Errors and warnings by place.
    pub diagnostics: Vec<Diagnostic>,
}

impl Compilation {
    pub fn errors(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|d| !d.is_warning())
    }
}

/// Compiles the text of a job for a machine whose axes have these names, in the order of their numbers.
///
/// `name` is what messages call the text; `loader` finds what it includes. Never panics, whatever the text is.
pub fn compile(name: &str, text: &[u8], loader: &mut dyn Loader, axes: &[String]) -> Compilation {
    let mut sources = Sources::default();
    let mut reports = Reports::default();
    let scanned = lexer::scan(name, text, loader, &mut sources, &mut reports);
    if scanned.tokens.len() == 1 && reports.has_errors() {
        return Compilation { program: None, diagnostics: reports.finish(&sources) }; // nothing of it was read
    }
    let syntax = parser::parse(&scanned.tokens, &mut reports);
    let unit = analysis::analyse(&syntax, &scanned, axes, &sources, &mut reports);
    let mut program = None;
    if !reports.has_errors() {
        program = Some(codegen::generate(unit, &sources, &mut reports)).filter(|_| !reports.has_errors());
    }
    Compilation { program, diagnostics: reports.finish(&sources) }
}
