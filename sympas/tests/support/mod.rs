//! Shared by the tests of this crate.
#![allow(dead_code)] // no test uses all of it

pub mod controller;
pub mod evaluator;
pub mod generator;
pub mod values;

use sympas::source::{Loader, NoIncludes, Sources};
use sympas::{Compilation, ast};

/// The axes of every test: A1, A2, A3.
pub fn axes() -> Vec<String> {
    ["A1", "A2", "A3"].map(str::to_owned).to_vec()
}

pub fn compile(source: &str) -> Compilation {
    compile_with(source, &mut NoIncludes)
}

pub fn compile_with(source: &str, loader: &mut dyn Loader) -> Compilation {
    sympas::compile("t.src", source.as_bytes(), loader, &axes())
}

/// Includes from a folder.
pub struct Folder(pub std::path::PathBuf);

impl Loader for Folder {
    fn load(&mut self, name: &str, _: &str) -> Result<(String, Vec<u8>), String> {
        let bytes = std::fs::read(self.0.join(name)).map_err(|e| e.to_string())?;
        Ok((name.to_owned(), bytes))
    }
}

/// The syntax tree of a text without errors.
pub fn syntax(source: &str) -> ast::Program {
    let (mut sources, mut reports) = (Sources::default(), sympas::diagnostics::Reports::default());
    let scanned = sympas::lexer::scan("t.src", source.as_bytes(), &mut NoIncludes, &mut sources, &mut reports);
    sympas::parser::parse(&scanned.tokens, &mut reports)
}

/// `id@line` of every error, or of every warning.
pub fn ids(compilation: &Compilation, warnings: bool) -> Vec<String> {
    let list = compilation.diagnostics.iter().filter(|d| d.is_warning() == warnings);
    list.map(|d| format!("{}@{}", d.id.name(), d.line)).collect()
}

/// The shortest text that reads back to the same number; a Single to the same Single.
pub fn real_text(value: f64, single: bool) -> String {
    if single { format!("{:?}", value as f32) } else { format!("{value:?}") }
}

/// Cases of a fuzz test; CNC_FRONT_FUZZ multiplies them: an hour of fuzzing is about 700.
pub fn fuzz_cases(cases: u32) -> u32 {
    cases * std::env::var("CNC_FRONT_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(1)
}
