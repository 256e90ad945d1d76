//! Parts of a program and the linter: what a part keeps, what it sends again, what the linter leaves alone.

mod common;

use common::{Command, commands, ends, mill3};
use gcode::{At, Compiled, Options, compile};

fn run(text: &str, from: Option<At>, to: Option<At>) -> Compiled {
    compile(text.as_bytes(), "t.nc", &mill3(), &Options { from, to, ..Options::default() })
}
fn path(compiled: Compiled) -> Vec<Vec<f64>> {
    assert!(!compiled.has_errors(), "{:?}", compiled.diagnostics);
    ends(&compiled.program.expect("no error"))
}

const PART: &str = "N10 G21 G90 G54 T3 M6\nN20 S2000 M3 M8\nN30 G0 X10 Y5 Z20\nN40 G91 G1 Z-25 F300\n#1=7\n(a note)\n\
    N50 X10\nN60 Y#1\nN70 G90 G0 Z20\nN80 M9\nN90 X0\nM30\n";

#[test]
fn the_commands_of_a_part_are_those_of_the_whole() {
    let whole = path(run(PART, None, None));
    let part = path(run(PART, Some(At::Block(60)), None));
    assert_eq!(part[part.len() - 3..], whole[whole.len() - 3..], "from N60 on the same targets");
    // lift (Z stands at 0, the contour at -5: nothing to lift), across, down
    assert_eq!(part[..2], [[20.0, 5.0, 0.0], [20.0, 5.0, -5.0]]);
    assert_eq!(part.len(), 5);
    let upto = path(run(PART, None, Some(At::Line(7))));
    assert_eq!(upto[..], whole[..3]);
    assert_eq!(path(run(PART, Some(At::Line(6)), Some(At::Block(50)))).len(), 3, "a comment means the next block");
}

#[test]
fn tool_speed_and_outputs_are_sent_again() {
    let compiled = run(PART, Some(At::Block(60)), None);
    let start = compiled.facts.start.clone().expect("a start");
    assert_eq!((start.line, start.in_spindle, start.spindle, start.coolant), (8, 3, 3, [true, false]));
    assert_eq!((start.speed, start.feed), (Some(2000.0), Some(300.0)));
    assert_eq!(start.machine[..3], [20.0, 5.0, -5.0]);
    assert_eq!(start.modal, "G1 G17 G91 G21 G94 G40 G49 G64 G54");
    let program = compiled.program.unwrap();
    let sent: Vec<Command> =
        commands(&program).into_iter().take_while(|c| !matches!(c, Command::Line { .. })).collect();
    assert!(matches!(&sent[0], Command::Event { kind, text, .. } if kind == "M06" && text == "3"), "{sent:?}");
    let value = |number: u16| {
        sent.iter().find_map(|c| match c {
            Command::Ssf { command, value, .. } if *command == number => Some(*value),
            _ => None,
        })
    };
    assert_eq!(value(20_200), Some(2000.0));
    assert_eq!(value(1001), Some(5.0), "spindle on and coolant: outputs 1 and 3");
    // the way down is feeding, the way across is not
    assert!(program.moves[0].rapid);
    assert_eq!((program.moves[1].rapid, program.moves[1].vl), (false, 5.0));
}

#[test]
fn a_part_in_the_middle_of_merged_blocks_begins_at_its_own_block() {
    let text = "G1 X10 F3000\nX10.01\nX10.02\nX10.03\nX10.04\nM30\n";
    let part = path(run(text, Some(At::Line(3)), None));
    assert_eq!(part, [[10.01, 0.0, 0.0], [10.04, 0.0, 0.0]]);
}

#[test]
fn where_nothing_can_be_rebuilt_it_is_refused() {
    let id = |text: &str, line: u32| {
        let mut machine = mill3();
        machine.gcode.tools[0].radius = 2.0;
        let options = Options { from: Some(At::Line(line)), ..Options::default() };
        let compiled = compile(text.as_bytes(), "t.nc", &machine, &options);
        compiled.diagnostics.into_iter().find(|d| !d.is_warning()).map(|d| (d.id, d.line, d.message))
    };
    let reason = |text: &str, line: u32| id(text, line).filter(|f| f.0 == "GC618").map(|f| f.2).unwrap_or_default();
    let corrected = "G0 X20 Y10\nG41 D1 G1 X20 Y0 F600\nX40\nY40\nG40 X0\nY9\nM30\n";
    assert!(reason(corrected, 4).contains("radius correction"));
    assert!(reason(corrected, 5).contains("radius correction"));
    assert_eq!(id(corrected, 6), None);
    assert!(reason("#1=0\nWHILE [#1 LT 3] DO1\n#1=[#1+1]\nG0 X#1\nEND1\nM30\n", 4).contains("loop"));
    assert!(
        reason("N1 #1=[#1+1]\nG0 X5\nIF [#1 LT 3] GOTO 1\nM30\n".replace("N1", "#1=0\nN1").as_str(), 3)
            .contains("once")
    );
    // an error anywhere in the text is still an error
    assert_eq!(id("G0 X9999\nX1\nM30\n", 2).map(|f| f.0), Some("GC413"));
}

#[test]
fn the_linter_leaves_good_programs_alone() {
    let text = "O1\nG0 Z20\nX5 Y5\nZ2\nG1 Z-1 F100\nX20 F900\nG3 X10 Y0 I-10\nG3 I-5\nG0 Z20\nX0\nG1 Z2 F3000\nM98 P2\nM30\nO2\nM99\n";
    let options = Options { strict: true, ..Options::default() };
    let compiled = compile(text.as_bytes(), "t.nc", &mill3(), &options);
    let smells: Vec<&str> = compiled.diagnostics.iter().map(|d| d.id).filter(|id| *id > "GW940").collect();
    assert_eq!(smells, [""; 0], "{:?}", compiled.diagnostics);
}

/// The way to the start is no block of the program: GW926 has nothing to name there, whichever way the text is read.
#[test]
fn the_way_to_the_start_is_no_slowed_block() {
    let text = b"G21 G90 G17 F6000\nG1 X1 Z-0.0001\nX50\nM30\n";
    let options = Options { from: Some(At::Line(3)), ..Options::default() };
    let found = compile(text, "t.nc", &mill3(), &options).diagnostics;
    let slowed: Vec<u32> = found.iter().filter(|d| d.id == "GW926").map(|d| d.line).collect();
    assert!(slowed.is_empty(), "{found:?}");
    common::same_once(text, &mill3(), &options, 43, 5);
}
