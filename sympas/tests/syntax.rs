//! Scanner and parser: what is read as what, and which errors are reported where.

use std::collections::HashMap;

use sympas::diagnostics::{Language, Reports};
use sympas::source::{Loader, NoIncludes, Sources};
use sympas::token::{Token, TokenKind};
use sympas::{lexer, parser};

/// Ids with line and column of everything that scanner and parser report.
fn faults(source: &str) -> Vec<String> {
    let (mut sources, mut reports) = (Sources::default(), Reports::default());
    let scanned = lexer::scan("t.src", source.as_bytes(), &mut NoIncludes, &mut sources, &mut reports);
    parser::parse(&scanned.tokens, &mut reports);
    let list = reports.finish(&sources);
    list.iter().map(|d| format!("{}@{}:{}", d.id.name(), d.line, d.column)).collect()
}

fn tokens(source: &str) -> Vec<Token> {
    let (mut sources, mut reports) = (Sources::default(), Reports::default());
    let scanned = lexer::scan("t.src", source.as_bytes(), &mut NoIncludes, &mut sources, &mut reports);
    assert!(!reports.has_errors(), "{source}");
    scanned.tokens
}

fn shown(source: &str) -> String {
    let list: Vec<String> = tokens(source).iter().map(Token::shown).collect();
    list.join(" ")
}

#[test]
fn a_point_behind_a_name_selects() {
    assert_eq!(shown("A1.digob.7 x[1].5 .5 5. 5.e1 end."), "A1 . digob . 7 x [ 1 ] . 5 0.5 5.0 50.0 end . end of text");
}

#[test]
fn the_longest_token_wins() {
    assert_eq!(shown("a:=b<>c<=d>=e<f"), "a := b <> c <= d >= e < f end of text");
    assert_eq!(shown("1to 2.0mod 3"), "1 to 2.0 mod 3 end of text");
}

#[test]
fn names_count_32_characters() {
    let long = "n".repeat(200);
    let list = tokens(&format!("{long} {}x", "n".repeat(32)));
    assert_eq!(list[0].kind, list[1].kind);
    assert_eq!(list[0].kind, TokenKind::Name("n".repeat(32).as_str().into()));
    assert_eq!(list[0].span.length, 200);
}

#[test]
fn all_errors_of_a_text_and_no_cascades() {
    let source = "
var i : integr;
    k : integer;
begin
  i := ;
  if k > 1 thn k := 2;
  for k = 1 to 3 do k := k;
  k := 3 k := 4;
  while do begin k := 1; end;
  foo(1, 2;
  k := 1;
  else;
  k := 1 < 2 < 3;
end.
";
    let want = [
        "SP201@2:9",
        "SP203@5:8",
        "SP201@6:12",
        "SP201@7:9",
        "SP201@8:10",
        "SP203@9:9",
        "SP201@10:11",
        "SP212@12:3",
        "SP204@13:14",
    ];
    assert_eq!(faults(source), want);
}

#[test]
fn ends_too_many_and_too_few() {
    assert_eq!(faults("begin\n if a then b := 1;\n end;\n c := 2;\nend.\n"), ["SP207@3:2"]);
    assert_eq!(faults("begin\n begin\n a := 1;\nend.\n"), ["SP201@4:4"]);
    assert_eq!(
        faults("procedure P;\nbegin\n if a then begin\n b := 1;\nend;\nprocedure Q;\nbegin\nend;\nbegin\nend.\n"),
        ["SP201@5:5"]
    );
    assert_eq!(faults("begin\n a := 1\nend\n"), ["SP207@3:1"]);
    assert_eq!(faults("begin\n a := 7 div 2 + b DIV c;\n a := 7 / 2 mod 3;\nend.\n"), ["SP213@2:9", "SP213@2:19"]);
    assert_eq!(faults("begin\n a := 7\n div := 2;\nend.\n"), ["SP201@2:8"]); // 'div' may be a variable
    assert_eq!(faults(""), ["SP201@1:1"]);
}

#[test]
fn lexical_errors_have_their_place() {
    assert_eq!(faults("begin a := 1A; b := $; c := 'x\nend."), ["SP107@1:12", "SP106@1:21", "SP104@1:29"]);
    assert_eq!(faults("begin ?B := 1; } end."), ["SP102@1:7", "SP105@1:16"]);
    assert_eq!(faults("begin { open end."), ["SP103@1:7", "SP201@1:18"]);
    assert_eq!(faults("begin ä end."), ["SP102@1:7"]);
    assert_eq!(faults("{$nosuch} {$I} {$TASK x y} begin end."), ["SP111@1:1", "SP112@1:11", "SP112@1:16"]);
}

#[test]
fn deep_nesting_is_refused_not_survived_by_luck() {
    for (open, close) in [("(", ")"), ("not ", ""), ("- ", ""), ("SysVarInt[", "]"), ("f(", ")"), ("integer(", ")")] {
        let source = format!("begin x := {}1{}; end.", open.repeat(100_000), close.repeat(100_000));
        assert_eq!(faults(&source).len(), 1, "{open}");
        assert!(faults(&source)[0].starts_with("SP206"), "{open}");
    }
    let open = ["if a then ", "begin ", "while a do ", "repeat ", "for i := 1 to 2 do ", "if a then b else "];
    for text in open {
        assert!(faults(&format!("begin {}", text.repeat(50_000)))[0].starts_with("SP206"), "{text}");
    }
    let sum = format!("begin x := {}1; end.", "1 + ".repeat(100_000));
    assert!(faults(&sum)[0].starts_with("SP206"));
}

#[test]
fn a_caret_points_at_it() {
    let (mut sources, mut reports) = (Sources::default(), Reports::default());
    let scanned = lexer::scan("t.src", b"begin\n\tx := 12AB;\nend.", &mut NoIncludes, &mut sources, &mut reports);
    parser::parse(&scanned.tokens, &mut reports);
    let list = reports.finish(&sources);
    assert_eq!(
        list[0].render(Language::English).lines().collect::<Vec<_>>(),
        [
            "t.src:2:7: SP107: malformed number or name '12AB'",
            "   x := 12AB;",
            "        ^^^^",
            "  hint: names start with a letter; an exponent needs digits",
        ]
    );
    assert!(list[0].render(Language::German).starts_with("t.src:2:7: SP107: ungültige Zahl"));
}

/// Files of a test.
struct Files(HashMap<String, String>);

impl Loader for Files {
    fn load(&mut self, name: &str, _: &str) -> Result<(String, Vec<u8>), String> {
        let text = self.0.get(name).ok_or("no such file")?;
        Ok((name.to_owned(), text.clone().into_bytes()))
    }
}

fn with_files(source: &str, files: &[(&str, String)]) -> Vec<String> {
    let mut loader = Files(files.iter().map(|(n, t)| ((*n).to_owned(), t.clone())).collect());
    let (mut sources, mut reports) = (Sources::default(), Reports::default());
    let scanned = lexer::scan("t.src", source.as_bytes(), &mut loader, &mut sources, &mut reports);
    parser::parse(&scanned.tokens, &mut reports);
    let list = reports.finish(&sources);
    list.iter().map(|d| format!("{}:{}@{}:{}", d.file, d.id.name(), d.line, d.column)).collect()
}

/// `n` files, each including the next.
fn chain(n: usize) -> Vec<(String, String)> {
    let text = |i: usize| if i < n { format!("{{$I f{}}}", i + 1) } else { "CI0 := 1;".to_owned() };
    (1..=n).map(|i| (format!("f{i}"), text(i))).collect()
}

// shows: directive.include, directive.include.depth-15, directive.include.depth-16, directive.include.nested
#[test]
fn includes_nest_fifteen_levels() {
    let run = |n: usize| {
        let files = chain(n);
        let files: Vec<(&str, String)> = files.iter().map(|(a, b)| (a.as_str(), b.clone())).collect();
        with_files("begin {$I f1} end.", &files)
    };
    assert!(run(15).is_empty());
    assert_eq!(run(16), ["f15:SP110@1:1"]);
    assert_eq!(with_files("{$I t}\nbegin end.", &[("t", "{$I t}".into())]), ["t:SP110@1:1"]);
    assert_eq!(with_files("begin\n {$i nosuch.inc } end.", &[]), ["t.src:SP109@2:2"]);
    let wide: String = "{$I a}".repeat(40);
    let bomb = with_files("begin {$I a} end.", &[("a", wide)]);
    assert!(bomb.iter().all(|d| d.contains("SP110") || d.contains("SP115") || d.contains("SP114")), "{bomb:?}");
    assert!(bomb.len() < 110, "an include bomb ends");
    let many: String = "{$I a}".repeat(1001);
    let wide = with_files(&format!("begin {many} end."), &[("a", ";".into())]);
    assert_eq!(wide.last().map(String::as_str), Some("t.src:SP115@1:6007"));
}
