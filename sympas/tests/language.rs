//! The language tests: programs under `programs/`, what they must do beside their lines.
//!
//! A file holds sections that begin with `// === id, id` or `// === title`. In a section
//! - `// expect: text` is the next line of output,
//! - `// stops: 8000` is the runtime error (hexadecimal) in which the program ends on this line,
//! - `// error 3, SP401` are the errors of this line, all of them; such a program is not run,
//! - `// warning SW902` is a warning of the section.

mod support;

use std::path::PathBuf;

use support::evaluator::{self, End};
use support::ids;

struct Section {
    title: String,
    /// With empty lines in front, so that lines count as in the file.
    source: String,
    errors: Vec<String>,
    warnings: Vec<String>,
    output: String,
    stops: Option<(u32, u32)>,
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/programs")
}

fn sections(file: &str) -> Vec<Section> {
    let text = std::fs::read_to_string(folder().join(file)).expect("a file of programs");
    let mut list: Vec<Section> = Vec::new();
    for (n, line) in text.lines().enumerate() {
        if let Some(title) = line.strip_prefix("// === ") {
            let source = "\n".repeat(n);
            let (title, output) = (title.to_owned(), String::new());
            list.push(Section { title, source, errors: vec![], warnings: vec![], output, stops: None });
        } else if let Some(section) = list.last_mut() {
            read_line(section, line, n as u32 + 1);
        }
        if let Some(section) = list.last_mut() {
            section.source += line;
            section.source.push('\n');
        }
    }
    list
}

fn read_line(section: &mut Section, line: &str, number: u32) {
    for (mark, words) in ["expect:", "stops:", "error", "warning"].iter().filter_map(|mark| {
        let (_, rest) = line.split_once(&format!("// {mark} "))?;
        Some((*mark, rest))
    }) {
        let list = words.split(',').map(|w| w.trim().to_owned());
        match mark {
            "expect:" => section.output += &format!("{words}\n"),
            "stops:" => section.stops = Some((u32::from_str_radix(words.trim(), 16).expect("a number"), number)),
            "error" => section.errors.extend(list.map(|id| format!("{id}@{number}"))),
            _ => section.warnings.extend(list),
        }
    }
}

/// Compiles, and runs what compiles.
fn check(file: &str, section: &Section) {
    let name = format!("{file}: {}", section.title);
    let result = support::compile(&section.source);
    let (mut errors, mut wanted) = (ids(&result, false), section.errors.clone());
    errors.sort();
    wanted.sort();
    let all: Vec<String> = result.diagnostics.iter().map(ToString::to_string).collect();
    assert_eq!(errors, wanted, "{name}\n{}", all.join("\n"));
    let list = result.diagnostics.iter().filter(|d| d.is_warning());
    let mut warnings: Vec<&str> = list.map(|d| d.id.name()).collect();
    let mut wanted: Vec<&str> = section.warnings.iter().map(String::as_str).collect();
    warnings.sort_unstable();
    wanted.sort_unstable();
    assert_eq!(warnings, wanted, "{name}");
    assert_eq!(result.program.is_some(), section.errors.is_empty(), "{name}");
    let Some(program) = result.program else { return };
    motion_kernel::sap::verify::verify(&program).unwrap_or_else(|e| panic!("{name}: {e}"));
    let second = evaluator::run(&support::syntax(&section.source), 1_000_000);
    if !matches!(second.end, End::Beyond(_)) {
        assert_eq!(second.output, section.output, "{name}");
        let end = section.stops.map_or(End::Finished, |(number, line)| End::Error(number, line));
        assert!(second.end == end || second.end == End::Aborted, "{name}: {:?}", second.end);
        assert_eq!(support::machine::run(&program, 10_000_000), second, "{name}");
    }
}

fn check_file(file: &str) {
    let list = sections(file);
    assert!(!list.is_empty());
    list.iter().for_each(|section| check(file, section));
}

#[test]
fn expressions() {
    check_file("expressions.src");
}

#[test]
fn types() {
    check_file("types.src");
    check_file("bad/types.src");
}

#[test]
fn statements() {
    check_file("statements.src");
}

#[test]
fn routines() {
    check_file("routines.src");
    check_file("bad/names.src");
}

#[test]
fn lexical() {
    check_file("lexical.src");
    check_file("bad/lexical.src");
}

#[test]
fn commands() {
    check_file("names.src");
    check_file("bad/commands.src");
}
