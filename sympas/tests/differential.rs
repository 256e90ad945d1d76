//! Generated programs: the compiler with the controller against the second opinion.

mod support;

use std::collections::BTreeMap;

use support::evaluator::{self, End};
use support::generator;

/// How many programs; CNC_FRONT_PROGRAMS asks for more.
fn count() -> u64 {
    std::env::var("CNC_FRONT_PROGRAMS").ok().and_then(|n| n.parse().ok()).unwrap_or(3000)
}

/// Equal, where a number that is none equals itself.
fn same(a: &evaluator::Outcome, b: &evaluator::Outcome) -> bool {
    format!("{a:?}") == format!("{b:?}")
}

#[test]
fn generated_programs_compile_and_end() {
    let mut ends: BTreeMap<String, u64> = BTreeMap::new();
    for seed in 0..count() {
        let source = generator::program(seed);
        let result = support::compile(&source);
        let errors: Vec<String> = result.errors().map(ToString::to_string).collect();
        assert!(errors.is_empty(), "seed {seed}\n{source}\n{}", errors.join("\n"));
        let outcome = evaluator::run(&support::syntax(&source), 100_000);
        let program = result.program.expect("no errors");
        let first = support::machine::run(&program, 10_000_000);
        assert!(same(&first, &outcome), "seed {seed}\n{source}\n{first:?}\n{outcome:?}");
        let end = match outcome.end {
            End::Error(number, _) => format!("error {number:04X}"),
            other => format!("{other:?}"),
        };
        *ends.entry(end).or_default() += 1;
    }
    println!("{ends:?}");
    assert!(ends["Finished"] * 10 > count() * 4, "most programs get to their end: {ends:?}");
    for error in ["error 8000", "error 0400", "error 0100"] {
        assert!(ends.contains_key(error), "no program ends in {error}: {ends:?}");
    }
}
