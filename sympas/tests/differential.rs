//! Generated programs: the compiler with the controller against the second opinion.

mod support;

use std::collections::BTreeMap;

use motion_kernel::sap::code::Instr;
use motion_kernel::sap::program::Program;
use support::evaluator::{self, End};
use support::{controller, generator};

/// How many programs; CNC_FRONT_PROGRAMS asks for more.
fn count() -> u64 {
    std::env::var("CNC_FRONT_PROGRAMS").ok().and_then(|n| n.parse().ok()).unwrap_or(3000)
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
        let first = controller::run(&program, 10_000);
        assert_eq!(controller::shown(&first), controller::shown(&outcome), "seed {seed}\n{source}");
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

/// One instruction changed, as a mistake of the compiler would.
fn broken(program: &Program, at: usize) -> Option<Program> {
    use Instr::*;
    let changed = match program.code[at] {
        AddI(to, a, b) => SubI(to, a, b),
        SubI(to, a, b) => SubI(to, b, a),
        LtI(to, a, b) => LeI(to, a, b),
        DivI(to, a, b) => DivI(to, b, a),
        AddD(to, a, b) => SubD(to, a, b),
        SubD(to, a, b) => SubD(to, b, a),
        LtT(to, a, b) => LtT(to, b, a),
        RoundS(to, a) => Copy(to, a),
        ItoD(to, a) => Copy(to, a),
        ShrI(to, a, b) => ShlI(to, a, b),
        IfLtI(a, b) => IfLeI(a, b),
        NextUp(a, b) => NextDown(a, b),
        JumpIfNot(_, to) => Jump(to),
        WriteCi(from, n) => WriteCi(from, n ^ 1),
        _ => return None,
    };
    let mut program = program.clone();
    program.code[at] = changed;
    Some(program)
}

/// The comparison can fail: mistakes of every kind are noticed where the code is reached.
#[test]
fn a_broken_compiler_is_noticed() {
    let mut kinds: BTreeMap<String, (u32, u32)> = BTreeMap::new();
    for seed in 0..300 {
        let source = generator::program(seed);
        let program = support::compile(&source).program.expect("no errors");
        let second = controller::shown(&evaluator::run(&support::syntax(&source), 100_000));
        for at in 0..program.code.len() {
            let Some(mutant) = broken(&program, at) else { continue };
            let name = format!("{:?}", program.code[at]);
            let kind = kinds.entry(name.split('(').next().unwrap_or("").to_owned()).or_default();
            let first = controller::run(&mutant, 200);
            kind.0 += 1;
            kind.1 += u32::from(controller::shown(&first) != second);
        }
    }
    println!("{kinds:?}");
    for (kind, (tried, noticed)) in &kinds {
        assert!(*noticed > 0, "{kind}: none of {tried} noticed");
    }
    let (tried, noticed) = kinds.values().fold((0, 0), |sum, kind| (sum.0 + kind.0, sum.1 + kind.1));
    assert!(
        noticed * 8 > tried,
        "{noticed} of {tried} noticed: much generated code is never reached, but not that much"
    );
    assert!(kinds.len() >= 14, "{kinds:?}");
}
