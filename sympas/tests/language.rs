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
use support::{controller, ids};

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
        assert_eq!(controller::shown(&controller::run(&program, 10_000)), controller::shown(&second), "{name}");
    }
}

fn check_file(file: &str) {
    let list = sections(file);
    assert!(!list.is_empty());
    list.iter().for_each(|section| check(file, section));
}

// shows: sympas.expr.binary-unary, sympas.expr.higher-rank-binds, sympas.expr.left-associative
// shows: sympas.expr.parentheses-first, sympas.lex.parentheses, sympas.expr.rank.1-unary
// shows: sympas.expr.rank.2-multiplicative, sympas.expr.rank.3-additive, sympas.expr.rank.4-relational
// shows: sympas.expr.precedence.and-over-or, sympas.expr.precedence.not-over-and, sympas.expr.factor.variable
// shows: sympas.expr.factor.constant, sympas.expr.factor.parenthesised, sympas.expr.factor.not
// shows: sympas.expr.factor.conversion, sympas.expr.factor.function-call, sympas.expr.add.integer
// shows: sympas.expr.add.real, sympas.expr.sub.integer, sympas.expr.sub.real, sympas.expr.mul.integer
// shows: sympas.expr.mul.real, sympas.expr.div.integer, sympas.expr.div.real, sympas.expr.div.zero
// shows: runtime-error.0x8000, runtime-error.number-and-line, sympas.expr.mod, sympas.expr.mod.negative
// shows: sympas.expr.unary.plus, sympas.expr.unary.minus, sympas.expr.not.integer, sympas.expr.and.integer
// shows: sympas.expr.or.integer, sympas.expr.xor.integer, sympas.expr.shl, sympas.expr.shr
// shows: sympas.expr.shift.negative, sympas.expr.not.boolean, sympas.expr.and.boolean, sympas.expr.or.boolean
// shows: sympas.expr.xor.boolean, sympas.expr.no-short-circuit, sympas.expr.rel.eq, sympas.expr.rel.ne
// shows: sympas.expr.rel.lt, sympas.expr.rel.gt, sympas.expr.rel.le, sympas.expr.rel.ge, sympas.expr.rel.boolean
// shows: sympas.expr.rel.mixed
#[test]
fn expressions() {
    check_file("expressions.src");
}

// shows: sympas.type.boolean.values, sympas.type.boolean.order, sympas.type.boolean.ordinal, sympas.type.integer
// shows: sympas.type.timer, sympas.type.table.timer, sympas.type.single, sympas.type.double
// shows: sympas.type.assign.same-type, sympas.type.assign.double-from-integer, sympas.type.assign.double-from-single
// shows: sympas.type.assign.single-from-integer, sympas.type.auto.integer-to-single
// shows: sympas.type.assign.single-from-literal, sympas.type.assign.integer-from-boolean
// shows: sympas.type.assign.double-from-boolean, sympas.type.assign.real-from-timer
// shows: sympas.type.auto.mixed-to-double, sympas.type.convert.boolean-from-integer
// shows: sympas.type.convert.boolean-from-double, sympas.type.convert.integer-from-double
// shows: sympas.type.convert.single, sympas.type.convert.double, sympas.type.convert.type-names
// shows: sympas.type.table.boolean, sympas.type.table.integer, sympas.type.table.single, sympas.type.table.double
// shows: sympas.timer.wraparound-compare, sympas.timer.other-relations, sympas.timer.modulo-add-sub
// shows: sympas.timer.integer-expression-mixed, sympas.timer.one-second, sympas.timer.max-delay
// shows: sympas.timer.clock.to-integer, sympas.timer.clock.to-timer, sympas.type.declared-before-use
// shows: sympas.lex.const.two-classes, sympas.lex.const.float, sympas.lex.const.float.fraction-forms
// shows: sympas.lex.const.float.exponent, sympas.lex.const.float.exponent-sign, sympas.lex.const.digit-sequence
// shows: sympas.lex.const.integer, sympas.lex.const.sign, sympas.lex.const.decimal, sympas.lex.const.hexadecimal
// shows: sympas.lex.const.hex-digit-case, sympas.lex.const.integer-range, sympas.lex.const.integer-clamp-high
// shows: sympas.lex.const.integer-clamp-low, sympas.lex.const.hex-twos-complement, sympas.lex.const.hex-clamp
// shows: sympas.lex.const.float.omit-one-part, sympas.lex.const.float-is-double, sympas.lex.const.float-range
// shows: sympas.lex.const.declaration, sympas.lex.const.declaration-float, sympas.lex.const.declaration-signed
// shows: sympas.lex.const.assign-sign-lenient, sympas.type.assign.integer-from-double-rejected
// shows: sympas.type.assign.integer-from-single-rejected, sympas.type.assign.single-from-double-rejected
// shows: sympas.type.assign.boolean-from-integer-rejected, sympas.stmt.assignment.incompatible
// shows: sympas.expr.rel.no-chain, sympas.expr.operand-types, sympas.expr.mod.integer-only
// shows: sympas.expr.logical.integer-only, sympas.stmt.if.boolean-condition, sympas.stmt.for.integer-variable
// shows: sympas.stmt.for.integer-bounds, sympas.proc.no-value, sympas.func.parameter-mismatch
// shows: sympas.func.result-must-be-used
#[test]
fn types() {
    check_file("types.src");
    check_file("bad/types.src");
}

// shows: sympas.stmt.label-prefix, sympas.stmt.goto, sympas.stmt.assignment, sympas.stmt.procedure-call
// shows: sympas.stmt.procedure-call.parameters, sympas.stmt.function-call, sympas.stmt.goto.backward-forward
// shows: sympas.stmt.goto.out-of-loop, sympas.stmt.compound.order, sympas.stmt.compound.single
// shows: sympas.stmt.compound.last-semicolon, sympas.stmt.structured.nesting, sympas.stmt.if.true
// shows: sympas.stmt.if.false, sympas.stmt.if.no-parentheses, sympas.stmt.if.dangling-else
// shows: sympas.stmt.if.semicolon-before-else, sympas.stmt.if.compound-branches, sympas.stmt.while
// shows: sympas.stmt.while.no-parentheses, sympas.stmt.while.compound, sympas.stmt.repeat
// shows: sympas.stmt.repeat.no-parentheses, sympas.stmt.repeat.sequence, sympas.stmt.repeat.compound
// shows: sympas.stmt.for.to, sympas.stmt.for.downto, sympas.stmt.for.skipped, sympas.stmt.for.equal-bounds
// shows: sympas.stmt.for.variable-scope, sympas.stmt.for.bounds-once, sympas.stmt.for.compound
// shows: sympas.lex.empty-statement, sympas.lex.semicolon
#[test]
fn statements() {
    check_file("statements.src");
}

// shows: sympas.proc.declaration, sympas.proc.parameters, sympas.proc.parameters.by-value
// shows: sympas.proc.global-exchange, sympas.proc.local-declarations, sympas.proc.recursion
// shows: sympas.proc.recursion.no-forward, sympas.var.local, sympas.proc.forward, sympas.proc.forward.parameters
// shows: sympas.proc.forward.mutual, sympas.func.declaration, sympas.func.parameters, sympas.func.operand-anywhere
// shows: sympas.func.result-as-local, sympas.func.recursion-parentheses, sympas.func.recursion-empty-parentheses
// shows: sympas.lex.empty-parentheses, sympas.func.forward, sympas.func.local-declarations, sympas.func.result-types
// shows: sympas.block.structure, sympas.block.sections-any-order, sympas.block.label-section
// shows: sympas.block.const-section, sympas.block.var-section, sympas.block.scope-to-end, sympas.block.shadowing
// shows: sympas.block.standard-scope, sympas.var.identifier-list, sympas.var.global, sympas.var.initial-values
// shows: sympas.prog.structure, sympas.prog.heading, sympas.prog.heading-optional, sympas.prog.main-block-last
// shows: sympas.prog.main-block-form, sympas.prog.implementation-part, runtime-error.0x0400
// shows: sap.functions.integer-argument, sap.abs, sympas.block.undeclared-is-error-3, sympas.block.label-undeclared
// shows: sympas.block.label-defined-once, sympas.block.label-not-placed, sympas.block.once-per-level
// shows: sympas.block.local-names, sympas.stmt.goto.same-block, sympas.stmt.goto.into-structure
// shows: sympas.proc.call-before-declaration, sympas.proc.no-nested-declaration, sympas.proc.forward.without-block
// shows: sympas.func.assign-outside, sympas.type.axis.main-program-only, sympas.prog.missing-period
#[test]
fn routines() {
    check_file("routines.src");
    check_file("bad/names.src");
}

// shows: sympas.lex.comment.brace, sympas.lex.comment.no-nesting, sympas.lex.comment.double-slash
// shows: sympas.lex.comment.as-separator, sympas.lex.keyword.any-case, sympas.lex.identifier.characters
// shows: sympas.lex.identifier-32-significant, sympas.lex.identifier.case-sensitive
// shows: sympas.lex.identifier.name-spaces, sympas.lex.label.form, sympas.lex.punctuators, sympas.lex.comma
// shows: sympas.lex.equals-sign, sympas.lex.string.apostrophes, sympas.lex.identifier.first-character
// shows: sympas.lex.label.only-goto, sympas.lex.const.no-expression, sympas.lex.const.not-assignable
// shows: sympas.expr.factor.string
#[test]
fn lexical() {
    check_file("lexical.src");
    check_file("bad/lexical.src");
}

// shows: sap.acos, sap.acos.domain, sap.asin, sap.asin.domain, sap.atan, sap.cos, sap.cosh, sap.exp, sap.ln
// shows: sap.ln.domain, sap.power, sap.sin, sap.sinh, sap.sqr, sap.sqrt, sap.sqrt.domain, sap.tan, sap.tanh
// shows: sap.rdcbd, sap.wrcbd, sap.rdcbd.alignment, sap.wrcbd.alignment, runtime-error.0x0800, sap.rdcbd.buffer-size
// shows: sap.rdcbi, sap.wrcbi, sap.rdcbi.alignment, sap.wrcbi.alignment, sap.rdcbs, sap.wrcbs, sap.rdcbs.alignment
// shows: sap.wrcbs.alignment, runtime-error.0x0100
#[test]
fn functions() {
    check_file("functions.src");
}

#[test]
fn fragments_of_the_manual() {
    check_file("fragments.src");
}

// shows: sympas.stdid.abort, sympas.stdid.cl, sympas.stdid.contcnct, sympas.stdid.disev, sympas.stdid.enev
// shows: sympas.stdid.ja, sympas.stdid.jaw, sympas.stdid.jhi, sympas.stdid.jhiw, sympas.stdid.jhl, sympas.stdid.jhlw
// shows: sympas.stdid.jhr, sympas.stdid.jhrw, sympas.stdid.jr, sympas.stdid.jrw, sympas.stdid.js, sympas.stdid.jsw
// shows: sympas.stdid.mca, sympas.stdid.mcaw, sympas.stdid.mcr, sympas.stdid.mcrw, sympas.stdid.mha
// shows: sympas.stdid.mhaw, sympas.stdid.mhr, sympas.stdid.mhrw, sympas.stdid.mla, sympas.stdid.mlaw
// shows: sympas.stdid.mlr, sympas.stdid.mlrw, sympas.stdid.ms, sympas.stdid.msw, sympas.stdid.ol, sympas.stdid.ra
// shows: sympas.stdid.rs, sympas.stdid.shp, sympas.stdid.smca, sympas.stdid.smcr, sympas.stdid.smha
// shows: sympas.stdid.smhr, sympas.stdid.smla, sympas.stdid.smlr, sympas.stdid.ssms, sympas.stdid.ssmsw
// shows: sympas.stdid.startcnct, sympas.stdid.stop, sympas.stdid.stepcnct, sympas.stdid.stopcnct, sympas.stdid.uf
// shows: sympas.stdid.wt, sympas.stdid.utrovr, abbr.Spec, abbr.Pos, sympas.lex.axis-specifier.case-sensitive
// shows: abbr.Event, abbr.Qual, sap.azo.range, sap.contcnct.range, sap.startcnct.range, sap.stepcnct.range
// shows: sap.stopcnct.range, sap.stoptoss.range, sap.lpr.one-axis, sysparam.case-sensitive, sysparam.NOA.read-only
// shows: qual.rv.read-only, qual.case-sensitive, qualb.case-sensitive, qual.unknown, qualb.constant-index
// shows: sap.mca3d.equals-sign-lenient, sap.ssf.equals-sign-lenient, sap.ssmsw.semicolon-lenient, sysparam.CFLAG
// shows: sysparam.GFAUX, directive.unknown, directive.task.range
#[test]
fn commands() {
    check_file("names.src");
    check_file("bad/commands.src");
}

/// What `// shows:` claims above a test, a section of one of its files carries in its title.
#[test]
fn claims_have_their_sections() {
    let (mut claimed, mut count) = (Vec::new(), 0);
    for line in include_str!("language.rs").lines() {
        if let Some(ids) = line.strip_prefix("// shows: ") {
            claimed.extend(ids.split(", "));
        } else if let Some((_, file)) = line.split_once("    check_file(\"") {
            let titles: Vec<String> = sections(file.trim_end_matches("\");")).into_iter().map(|s| s.title).collect();
            claimed.retain(|id| !titles.iter().any(|t| t.split(", ").any(|part| part == *id)));
            count += titles.len();
        } else if line == "}" {
            assert!(claimed.is_empty(), "no section shows {claimed:?}");
        }
    }
    assert!(count >= 250, "{count} programs");
}
