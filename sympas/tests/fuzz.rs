//! No text makes the compiler panic, hang, or take memory without bound; what it accepts the controller accepts too.

mod support;

use std::time::{Duration, Instant};

use motion_kernel::sap::verify::verify;
use proptest::prelude::*;

/// Pieces that programs are made of, good and bad.
const PIECES: &[&str] = &[
    "begin ",
    "end",
    "end.",
    ";",
    ":=",
    "=",
    "if ",
    "then ",
    "else ",
    "while ",
    "do ",
    "repeat ",
    "until ",
    "for ",
    "to ",
    "downto ",
    "goto ",
    "label ",
    "const ",
    "var ",
    "procedure ",
    "function ",
    "forward;",
    "program ",
    "i",
    "d",
    "P",
    "F",
    "L",
    "A1",
    "A1.",
    "VA.an",
    "dp",
    "digob.",
    "varint[",
    "SysVarInt[",
    "]",
    "(",
    ")",
    ",",
    ":",
    "integer",
    "double",
    "boolean",
    "timer",
    "single",
    "axis",
    "1",
    "2.5",
    "$FF",
    "99999999999",
    "'text'",
    "'",
    "{",
    "}",
    "{$I x}",
    "{$TASK 1}",
    "//",
    "\n",
    "+",
    "-",
    "*",
    "/",
    "mod ",
    "shl ",
    "and ",
    "or ",
    "not ",
    "<",
    "<>",
    ">=",
    "mla(",
    "ssf(",
    "PHI",
    "TRVL",
    "CI0",
    "CD1",
    "CI1000",
    "CLOCK",
    "wt(",
    "write(",
    "writeln;",
    "abort",
    "enev(EVEO)",
    "TRUE",
    "sin(",
    "power(",
    "rdcbi(",
    "integer(",
    ".",
    "..",
    "@",
    "ä",
    "\0",
    "\t",
    "L:",
    "azo(",
    "startcnct(",
];

fn check(source: &str) -> Result<(), TestCaseError> {
    let start = Instant::now();
    let result = support::compile(source);
    prop_assert!(start.elapsed() < Duration::from_secs(60));
    prop_assert_eq!(result.program.is_none(), result.errors().count() > 0);
    for finding in &result.diagnostics {
        prop_assert!(finding.line >= 1 && finding.column >= 1 && !finding.to_string().is_empty());
    }
    if let Some(program) = result.program {
        prop_assert!(verify(&program).is_ok(), "{:?}\n{source}", verify(&program));
        prop_assert_eq!(sympas::cnc::decode(&sympas::cnc::encode(&program)).expect("its own file"), program);
    }
    Ok(())
}

fn programs() -> Vec<String> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/programs");
    let names = ["expressions", "types", "statements", "routines", "lexical", "bad/names", "bad/types", "bad/lexical"];
    let text = |n: &&str| std::fs::read_to_string(format!("{folder}/{n}.src")).expect("a file of programs");
    names
        .iter()
        .flat_map(|n| text(n).split("// === ").skip(1).map(str::to_owned).collect::<Vec<_>>())
        .map(|s| format!("// {s}"))
        .collect()
}

fn config(cases: u32) -> ProptestConfig {
    let cases = support::fuzz_cases(cases);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config(3000))]

    #[test]
    fn soup_of_pieces(pieces in prop::collection::vec(prop::sample::select(PIECES), 0..80)) {
        check(&pieces.concat())?;
        check(&format!("var i : integer; d : double; VA : axis;\nbegin\n{}\nend.", pieces.concat()))?;
    }

    #[test]
    fn programs_with_changes(
        pick in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0usize..30, prop::sample::select(PIECES)), 1..5),
    ) {
        let list = programs();
        let mut text: Vec<char> = list[pick.index(list.len())].chars().collect();
        for (at, cut, piece) in changes {
            let at = at.index(text.len().max(1));
            let end = (at + cut).min(text.len());
            text.splice(at..end, piece.chars());
        }
        check(&text.into_iter().collect::<String>())?;
    }

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = sympas::compile("t.src", &bytes, &mut sympas::source::NoIncludes, &support::axes());
    }
}

#[test]
fn large_texts_end_in_good_time() {
    let many = |piece: &str, n: usize| format!("var i : integer;\nbegin\n{}\nend.", piece.repeat(n));
    let texts = [
        many("i := i + 1;\n", 100_000),
        many(";", 1_000_000),
        many("i := nosuch;\n", 100_000),
        many("x y z (;\n", 100_000),
        many("begin end ", 100_000),
        many("@", 1_000_000),
        many("'", 1_000_000),
        many("writeln(1, 2, 3);", 50_000),
        format!("var {} : integer; begin end.", (0..50_000).map(|n| format!("v{n}")).collect::<Vec<_>>().join(",")),
        format!("begin writeln({}); end.", vec!["1"; 300_000].join(",")),
        (0..20_000).map(|n| format!("procedure P{n}; begin end;\n")).collect::<String>() + "begin end.",
        (0..40_000).map(|n| format!("const c{n} = {n};\n")).collect::<String>() + "begin writeln(c39999); end.",
        many(&format!("i := {};\n", ["1"; 250].join(" + ")), 2_000),
        (0..100_000).map(|n| format!("x{n} := y{n};\n")).collect::<String>() + "begin end.",
        "begin ".to_owned() + &(0..100_000).map(|n| format!("x{n} := y{n};\n")).collect::<String>() + "end.",
        "var v: integr; begin ".to_owned()
            + &(0..100_000).map(|n| format!("x{n} := 1;\n")).collect::<String>()
            + "end.",
        "{".repeat(1_000_000),
        format!("begin mla({}); end.", vec!["A1 := 1"; 300_000].join(",")),
        format!(
            "var {0} : axis; begin ol({1}); ol({1}); end.",
            (0..8_000).map(|n| format!("V{n}")).collect::<Vec<_>>().join(","),
            (0..8_000).map(|n| format!("V{n}")).collect::<Vec<_>>().join(",")
        ),
        "begin ".to_owned() + &"A".repeat(3_000_000),
    ];
    for text in texts {
        let start = Instant::now();
        let result = support::compile(&text);
        assert!(result.diagnostics.len() < 700);
        assert!(start.elapsed() < Duration::from_secs(120), "{}", &text[..60]);
    }
    let result = support::compile(&many("i := 1;\n", 600_000));
    assert_eq!(support::ids(&result, false), ["SP108@1"]);
}
