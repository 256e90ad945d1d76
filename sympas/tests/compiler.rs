//! What the compiler as a whole promises: one program whatever its layout, predefined names, directives, axes.

mod support;

use motion_kernel::sap::code::Instr;
use motion_kernel::sap::program::Program;
use motion_kernel::sap::tables::{Command, Form, Function, SystemParameter, TaskCommand, Type, command};
use sympas::source::NoIncludes;
use sympas::token::Keyword;

fn program(source: &str) -> Program {
    let result = support::compile(source);
    let errors: Vec<String> = result.errors().map(ToString::to_string).collect();
    result.program.unwrap_or_else(|| panic!("{source}\n{}", errors.join("\n")))
}

/// Code without its lines.
fn code(source: &str) -> (Vec<Instr>, Vec<u64>) {
    let program = program(source);
    let plain = |i: &Instr| if matches!(i, Instr::Statement(_)) { Instr::Statement(0) } else { *i };
    (program.code.iter().map(plain).collect(), program.globals)
}

const LAYOUTS: [&str; 2] = [
    "program P;const k=2;var i,j:integer;procedure Q(n:integer);begin i:=i+n end;\
     begin i:=1;for j:=1to k do begin Q(j);A1.digob.2:=not A1.digib.1 end;if i>2then goto1(i)else mla(A1:=1.5,A2:=-k)end.",
    "{a} program {b} P ; // c
     const
       k {=3} = 2 ;
     var i ,
         j : integer ;
     procedure Q ( n : integer ) ;
     begin
       i := i + n
     end ;
     begin
       i\t:=\t1 ;
       for j := 1 to k do begin
         Q ( j ) ;
         A1 . digob . 2 := not A1 . digib . 1
       end ;
       if i > 2 then
         goto1 ( i )
       else
         mla ( A1 := 1.5 , { x } A2 := - k )
     end .",
];

// shows: sympas.lex.whitespace, sympas.lex.comment.as-separator
#[test]
fn layout_changes_nothing_but_lines() {
    let own = |text: &str| text.replace("goto1", "Q");
    assert_eq!(code(&own(LAYOUTS[0])), code(&own(LAYOUTS[1])));
    assert_eq!(code("label L1; begin goto{x}L1; L1: end."), code("label L1; begin goto L1; L1: end."));
}

// shows: sympas.lex.identifier.any-length
#[test]
fn names_of_any_length() {
    let name = "Long_Name_".repeat(20);
    assert_eq!(name.len(), 200);
    program(&format!("var {name} : integer; begin {name} := {name} + 1; end."));
}

// shows: sympas.lex.keyword.reserved, sympas.kw.and, sympas.kw.begin, sympas.kw.boolean, sympas.kw.const, sympas.kw.do
// shows: sympas.kw.double, sympas.kw.downto, sympas.kw.else, sympas.kw.end, sympas.kw.for, sympas.kw.forward
// shows: sympas.kw.function, sympas.kw.goto, sympas.kw.if, sympas.kw.integer, sympas.kw.label, sympas.kw.mod
// shows: sympas.kw.module, sympas.kw.not, sympas.kw.or, sympas.kw.procedure, sympas.kw.repeat, sympas.kw.shl
// shows: sympas.kw.shr, sympas.kw.single, sympas.kw.then, sympas.kw.timer, sympas.kw.to, sympas.kw.until, sympas.kw.var
// shows: sympas.kw.while, sympas.kw.xor
#[test]
fn keywords_are_reserved_and_used() {
    let programs = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/programs/expressions.src"));
    let mut uses = programs.expect("a file of programs");
    for file in ["types", "statements", "routines"] {
        let path = format!("{}/tests/programs/{file}.src", env!("CARGO_MANIFEST_DIR"));
        uses += &std::fs::read_to_string(path).expect("a file of programs");
    }
    for keyword in Keyword::ALL.iter().map(|k| k.text()) {
        for text in [
            format!("var {keyword} : integer; begin end."),
            format!("const {keyword} = 1; begin end."),
            format!("label {keyword}; begin end."),
            format!("procedure {keyword}; begin end; begin end."),
            format!("function {keyword} : integer; begin end; begin end."),
        ] {
            assert!(support::ids(&support::compile(&text), false).contains(&"SP205@1".to_owned()), "{text}");
        }
        let shown = keyword == "module" || uses.contains(&format!("sympas.kw.{keyword}"));
        assert!(shown, "no program uses {keyword}");
    }
    assert_eq!(Keyword::ALL.len(), 32);
}

/// A correct call of a command.
fn call(command: Command, name: &str) -> String {
    let arguments = match command.form() {
        Form::Nothing => "",
        Form::Axes | Form::OneAxis => "(A2)",
        Form::Values { .. } | Form::SpoolFunction => "(A2 := 1.5)",
        Form::Circle | Form::Helix => "(A2 := 1.5, A1 := 2.5)",
        Form::Circle3d => "(A2 := 1.5, A1 := 2.5, A3 := 3.5)",
    };
    format!("begin {name}{arguments}; end.")
}

// shows: sympas.stdid.predeclared, sympas.stdid.any-case, sap.simultaneous
#[test]
fn every_predefined_name_is_known_in_its_cases() {
    for item in Command::ALL {
        for name in [item.name().to_owned(), item.name().to_uppercase(), format!("{}w", item.name())] {
            let Some((found, wait)) = command(&name) else { continue };
            let program = program(&call(found, &name));
            assert!(program.code.iter().any(|i| matches!(i, Instr::Do(c, _) if c == item)), "{name}");
            let waits =
                program.code.iter().any(|i| matches!(i, Instr::AwaitEnd(s, _) if *s == (*item == Command::Ssms)));
            assert_eq!(waits, wait, "{name}");
        }
        if item.form() == Form::Axes {
            let all = program(&format!("begin {}(A3, A1, A2); end.", item.name()));
            assert_eq!(all.lists[0].iter().map(|o| o.axis.index()).collect::<Vec<_>>(), [2, 0, 1]);
        }
    }
    for item in Function::ALL {
        for name in [item.name().to_owned(), item.name().to_uppercase()] {
            let program = program(&format!("begin CD0 := {name}(1.5); end."));
            assert!(program.code.iter().any(|i| matches!(i, Instr::Math(f, ..) if f == item)), "{name}");
        }
    }
    for item in TaskCommand::ALL {
        for name in [item.name().to_owned(), item.name().to_uppercase()] {
            let program = program(&format!("const two = 2; begin {name}(3); {name}(two); end."));
            let found: Vec<&Instr> = program.code.iter().filter(|i| matches!(i, Instr::Task(..))).collect();
            assert_eq!(found, [&Instr::Task(*item, 3), &Instr::Task(*item, 2)], "{name}");
        }
    }
    for text in
        ["Stop", "ABORT", "Azo(1)", "DisEv(EVEO)", "WT(5)", "WrCBI(0, 1)", "wrcbS(0, 1)", "WRCBD(0, 1)", "WRITE(1)"]
    {
        program(&format!(
            "begin {text}; {}; {}; end.",
            text.to_uppercase(),
            text.to_lowercase().replace("eveo", "EVEO")
        ));
    }
}

#[test]
fn system_parameters_are_read_and_written() {
    for item in SystemParameter::ALL {
        let kind = item.kind();
        let program = program(&format!("var v : {}; begin v := {}; end.", kind.name(), item.name()));
        assert!(program.code.iter().any(|i| matches!(i, Instr::ReadSystem(p, _) if p == item)), "{}", item.name());
        let text = match kind {
            Type::Boolean => "TRUE",
            Type::Integer => "1",
            _ => "0.5",
        };
        let written = support::compile(&format!("begin {} := {text}; end.", item.name()));
        let read_only = item.access() == motion_kernel::sap::tables::Access::Read;
        assert_eq!(written.program.is_none(), read_only, "{}", item.name());
    }
}

fn with_axes(source: &str, names: &[&str]) -> sympas::Compilation {
    let axes: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
    sympas::compile("t.src", source.as_bytes(), &mut NoIncludes, &axes)
}

// shows: sympas.lex.axis-specifier.predeclared, sympas.lex.axis-specifier.8-characters
// shows: sympas.lex.axis-specifier.user-names, abbr.A1, abbr.A2, qual.all-axes
#[test]
fn axes_are_named_by_the_configuration() {
    let names = ["X", "Z", "C", "Spindle1"];
    let result = with_axes("begin ol(X, Z, C); Spindle1.jvl := 5.0; mlr(X := 25, C := 60); end.", &names);
    let program = result.program.expect("the names of the configuration");
    assert_eq!(program.lists[1].iter().map(|o| o.axis.index()).collect::<Vec<_>>(), [0, 2]);
    assert!(with_axes("begin ol(A1); end.", &names).program.is_none());
    assert!(with_axes("begin ol(A1, A2); end.", &["A1", "A2"]).program.is_some());
    for qualifier in motion_kernel::sap::tables::Qualifier::ALL {
        for axis in names {
            let name = qualifier.name();
            let source = format!("var v : {}; begin v := {axis}.{name}; end.", qualifier.kind().name());
            assert!(with_axes(&source, &names).program.is_some(), "{axis}.{name}");
        }
    }
}

// shows: directive.syntax, directive.anywhere, directive.task.constant, directive.fullsystem
#[test]
fn directives_stand_where_comments_may() {
    let task = |source: &str| (program(source).task, program(source).full_system);
    assert_eq!(task("begin end."), (None, false));
    assert_eq!(task("{$TASK 1} begin end."), (Some(1), false));
    assert_eq!(task("{ $TASK 1} begin end."), (None, false));
    assert_eq!(task("{$fullsystem}{$task 3};begin end."), (Some(3), true));
    assert_eq!(task("program P; const Task1 = 1; {$TASK Task1}; begin end."), (Some(1), false));
    assert_eq!(task("var i {$TASK 2} : {$FULLSYSTEM} integer; begin i := {$TASK 0} 1; end."), (Some(0), true));
    let where_it_stands = code("begin CI0 := 1 {$TASK 1} + 2; end.");
    assert_eq!(where_it_stands, code("begin CI0 := 1 + 2; end."));
}

// shows: sympas.stmt.if.deep-nesting
#[test]
fn fifty_nested_ifs() {
    for open in ["if i < 9 then ", "if i < 9 then begin i := i; "] {
        let close = if open.contains("begin") { " end" } else { "" };
        let source =
            format!("var i : integer; begin {}i := i + 1{}; writeln(i); end.", open.repeat(60), close.repeat(60));
        let outcome = support::controller::run(&program(&source), 10_000);
        assert_eq!(outcome.output, "1\n");
    }
}

// shows: directive.include
#[test]
fn the_twelve_programs_of_the_grammar_compile() {
    let folder = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/programs/manual");
    let mut names: Vec<_> = std::fs::read_dir(&folder).expect("a folder").map(|e| e.expect("a file").path()).collect();
    names.retain(|p| p.extension().is_some_and(|e| e == "src"));
    assert_eq!(names.len(), 12);
    for name in names {
        let text = std::fs::read_to_string(&name).expect("a program");
        let result = support::compile_with(&text, &mut support::Folder(folder.clone()));
        let all: Vec<String> = result.diagnostics.iter().map(ToString::to_string).collect();
        let clamped = name.to_string_lossy().contains("P02"); // 3000000000 is meant
        assert_eq!(all.len(), usize::from(clamped), "{name:?}\n{}", all.join("\n"));
        motion_kernel::sap::verify::verify(&result.program.expect("no errors")).expect("a program for a task");
    }
}

#[test]
fn a_program_may_have_any_number_of_constants() {
    let lines: String = (0..20_000).map(|n| format!("  d := d + {n}.5; wrcbd(0, {n}.25);\n")).collect();
    let source = format!("var d : double; i : integer;\nbegin\n{lines}  writeln(d, ' ', rdcbd(0));\nend.\n");
    let program = program(&source);
    assert!(program.constants.len() > 30_000 && program.globals.len() < 4096);
    assert_eq!(sympas::cnc::decode(&sympas::cnc::encode(&program)).expect("its file"), program);
    let outcome = support::controller::run(&program, 10_000);
    assert_eq!(outcome.output, "200000000.0 19999.25\n");
}

/// Ids of a text as (id, line); of many texts only the last findings matter.
fn found(source: &str) -> Vec<String> {
    support::ids(&support::compile(source), false)
}

#[test]
fn limits_are_said() {
    assert_eq!(found("begin\n\u{1}\u{2}\nend."), ["SP101@1"]);
    let many = found(&format!("begin\n{}end.", "  5;\n".repeat(200)));
    assert_eq!((many.len(), many[100].as_str()), (101, "SP114@102"));
    let locals: Vec<String> = (0..1100).map(|n| format!("v{n}")).collect();
    let routine = format!("procedure P;\nvar {} : integer;\nbegin\nend;\nbegin end.", locals.join(", "));
    assert_eq!(found(&routine), ["SP501@4"]);
    let globals: Vec<String> = (0..9000).map(|n| format!("v{n}")).collect();
    assert_eq!(found(&format!("var {} : integer;\nbegin\nend.", globals.join(", "))), ["SP501@3"]);
    let axes: Vec<String> = (0..19).map(|n| format!("V{n}")).collect();
    let list = axes.join(", ");
    assert_eq!(found(&format!("var {list} : axis;\nbegin\n  ol({list});\nend.")), ["SP501@3"]);
    let nested = format!("begin CI0 := {}CI1{}; end.", "abs(".repeat(140), ")".repeat(140));
    assert_eq!(found(&nested), ["SP401@1"], "deep, but not too deep");
}

/// Every message has a scene in these tests.
#[test]
fn every_id_of_the_catalogue_is_provoked() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    let mut files: Vec<std::path::PathBuf> = Vec::new();
    for part in ["", "programs", "programs/bad"] {
        let list = std::fs::read_dir(format!("{folder}/{part}")).expect("a folder");
        files.extend(list.map(|e| e.expect("a file").path()).filter(|p| p.is_file()));
    }
    let mut words = std::collections::HashSet::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a text");
        let marked = |line: &&str| line.contains("// error") || line.contains("// warning") || line.contains('"');
        for line in text.lines().filter(marked) {
            words.extend(line.split(|c: char| !c.is_ascii_alphanumeric()).map(str::to_owned));
        }
    }
    let missing: Vec<&str> =
        sympas::catalogue::CATALOGUE.iter().map(|row| row.1).filter(|id| !words.contains(*id)).collect();
    assert_eq!(missing, Vec::<&str>::new());
}
