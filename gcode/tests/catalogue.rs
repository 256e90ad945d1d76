//! Every id of the catalogue has a small bad program with the expected place.
//! Ids that this crate cannot reach are listed with the reason, visibly.

mod common;

use std::collections::BTreeSet;

use common::{example, mill3};
use gcode::{At, CATALOGUE, Compiled, Limits, Options, compile};
use motion_kernel::machine::{Machine, Profile};

/// (id, line, column, end column, program)
type Row = (&'static str, u32, u32, u32, &'static str);

const ON_MILL3: &[Row] = &[
    ("GC103", 1, 6, 6, "G1 X1\x07 F100\nM30\n"),
    ("GC104", 1, 5, 5, "G1 X\u{2013}5\nM30\n"),
    ("GC104", 1, 3, 3, "G0\u{a0}X5\nM30\n"),
    ("GC107", 2, 1, 1, "G0 X1\n$X$=5\nM30\n"),
    ("GC107", 1, 4, 4, "N1 @371 R52 K2 K0\nM30\n"),
    ("GC107", 1, 2, 2, "//G0 X1\nM30\n"),
    ("GC108", 1, 4, 4, "G90(abc\nM30\n"),
    ("GC109", 1, 6, 6, "G0 X1) Y2\nM30\n"),
    ("GC110", 1, 7, 7, "write \"abc\nM30\n"),
    ("GC113", 1, 1, 1, "(only a comment)\n\n"),
    ("GC201", 1, 1, 5, "XYZZY\nM30\n"),
    ("GC201", 1, 7, 9, "G0 X10FOO\nM30\n"),
    ("GC202", 1, 4, 4, "G0 X Y5\nM30\n"),
    ("GC202", 1, 4, 5, "G0 X-\nM30\n"),
    ("GC202", 1, 4, 5, "G0 X.\nM30\n"),
    ("GC203", 1, 4, 5, "G0 10\nM30\n"),
    ("GC203", 1, 7, 7, "G0 X1 0\nM30\n"),
    ("GC204", 1, 5, 9, "G0 X1.2.3\nM30\n"),
    ("GC204", 1, 5, 7, "G0 X--1\nM30\n"),
    ("GC204", 1, 5, 7, "G0 X1-2\nM30\n"),
    ("GC205", 1, 6, 6, "G0 X1,5\nM30\n"),
    ("GC206", 1, 5, 46, "G0 X0.0000000000000000000000000000000000000001\nM30\n"),
    ("GC207", 1, 1, 4, "N-10 G0 X1\nM30\n"),
    ("GC207", 1, 1, 3, "T-1\nM30\n"),
    ("GC207", 1, 1, 5, "S-500\nM30\n"),
    ("GC208", 1, 5, 5, "G0 X(a)10\nM30\n"),
    ("GC209", 1, 4, 6, "G0 N10 X5\nM30\n"),
    ("GC210", 1, 1, 5, "N10.5 G0 X1\nM30\n"),
    ("GC210", 1, 1, 4, "T1.5\nM30\n"),
    ("GC211", 1, 7, 7, "G0 X1 /Y2\nM30\n"),
    ("GC212", 1, 7, 8, "G0 X1 O5\nM30\n"),
    ("GC213", 1, 8, 9, "G0 X10 ,R2\nM30\n"),
    ("GC214", 1, 12, 15, "G1 X1 F100 E100\nM30\n"),
    ("GC215", 1, 1, 3, "R1=5\nM30\n"),
    ("GC216", 1, 4, 15, "G0 X99999999999\nM30\n"),
    ("GC216", 1, 1, 5, "G1000\nM30\n"),
    ("GC217", 1, 1, 6, "G91.15\nM30\n"),
    ("GC218", 1, 1, 2, "/0 G0 X1\nM30\n"),
    ("GC219", 1, 1, 3, "AB1 = 5\nM30\n"),
    ("GC220", 1, 2, 2, "G=1\nM30\n"),
    ("GC220", 1, 5, 5, "N10 = 5\nM30\n"),
    ("GC221", 1, 33, 35, "M36 M50 M51 M52 M53 M54 M55 M56 M57\nM30\n"),
    ("GC301", 1, 7, 8, "G0 X1 X2\nM30\n"),
    ("GC302", 1, 4, 5, "G0 G1 X1\nM30\n"),
    ("GC302", 1, 5, 7, "G17 G18\nM30\n"),
    ("GC302", 1, 4, 5, "M3 M5\nM30\n"),
    ("GC302", 1, 5, 7, "G90 G91\nM30\n"),
    ("GC303", 1, 4, 6, "G1 G92 X5\nM30\n"),
    ("GC303", 1, 5, 6, "G28 G1 X1\nM30\n"),
    ("GC304", 1, 8, 9, "G04 X1 Y2\nM30\n"),
    ("GC304", 1, 4, 5, "G1 G4 X5\nM30\n"),
    ("GC305", 1, 1, 3, "G05\nM30\n"),
    ("GC305", 1, 1, 4, "G999\nM30\n"),
    ("GC306", 1, 1, 3, "G06\nM30\n"),
    ("GC307", 1, 1, 3, "G31 Z-5\nM30\n"),
    ("GC307", 1, 1, 5, "G38.2 Z-5\nM30\n"),
    ("GC308", 1, 1, 3, "G33 Z-20 K1.5\nM30\n"),
    ("GC308", 1, 1, 3, "G84 Z-20 R1\nM30\n"),
    ("GC309", 1, 5, 6, "G10 L3 P1 X0\nM30\n"),
    ("GC310", 1, 1, 3, "G10 P1 X0\nM30\n"),
    ("GC310", 1, 1, 5, "G54.1\nM30\n"),
    ("GC310", 1, 1, 3, "G68 X0\nM30\n"),
    ("GC310", 1, 1, 3, "M62\nM30\n"),
    ("GC310", 1, 1, 3, "M66 L3\nM30\n"),
    ("GC311", 1, 5, 6, "G30 P7\nM30\n"),
    ("GC313", 1, 1, 3, "G50 X1\nM30\n"),
    ("GC314", 1, 4, 6, "G2 G53 X1\nM30\n"),
    ("GC315", 1, 5, 7, "G91 G53 G0 X1\nM30\n"),
    ("GC316", 1, 1, 3, "G58 X10\nM30\n"),
    ("GC317", 1, 1, 3, "G71 U1 R1\nM30\n"),
    ("GC317", 1, 1, 3, "G76 P1\nM30\n"),
    ("GC318", 1, 5, 6, "G74 X5\nM30\n"),
    ("GC319", 2, 1, 2, "G80\nX5\nM30\n"),
    ("GC320", 1, 1, 3, "G87 Z-1 R1\nM30\n"),
    ("GC323", 2, 1, 3, "G93\nG81 X1 Z-1 R1 F10\nM30\n"),
    ("GC325", 1, 1, 15, "G81 X5 Z-5 F100\nM30\n"),
    ("GC326", 1, 7, 8, "G0 X1 Q5\nM30\n"),
    ("GC326", 1, 1, 2, "P3\nM30\n"),
    ("GC326", 1, 5, 6, "G17 I5\nM30\n"),
    ("GC327", 1, 1, 3, "G52\nM30\n"),
    ("GC327", 1, 1, 3, "G92\nM30\n"),
    ("GC327", 1, 1, 5, "G51.1\nM30\n"),
    ("GC328", 2, 1, 3, "G68 X0 Y0 R10\nG18\nM30\n"),
    ("GC329", 2, 15, 17, "#1=5\nG20 G10 L2 P1 X#1\nM30\n"),
    ("GC401", 1, 1, 21, "G2 X10 Y0 I4 J0 F1000\nM30\n"),
    ("GC402", 1, 1, 15, "G2 X1 I0 J0 F10\nM30\n"),
    ("GC403", 1, 5, 6, "G51 P0\nM30\n"),
    ("GC404", 1, 18, 19, "G17 G2 X1 Y1 I.5 K2 F100\nM30\n"),
    ("GC405", 1, 7, 8, "G2 X1 R5 I2 F100\nM30\n"),
    ("GC406", 1, 1, 15, "G2 X10 Y10 F100\nM30\n"),
    ("GC407", 1, 7, 8, "G3 I5 P0 F100\nM30\n"),
    ("GC408", 1, 1, 10, "G2 R5 F100\nM30\n"),
    ("GC409", 1, 1, 27, "G3 X1 I9999999 J9999999 F10\nM30\n"),
    ("GC410", 1, 1, 16, "G2 X100 R20 F100\nM30\n"),
    ("GC411", 1, 7, 8, "G2 X1 R0 F100\nM30\n"),
    ("GC412", 2, 1, 14, "G51 I2 J1\nG2 X10 I5 F100\nM30\n"),
    ("GC413", 1, 4, 7, "G0 X700\nM30\n"),
    ("GC413", 2, 1, 12, "G0 X590\nG2 I20 F1000\nM30\n"),
    ("GC415", 1, 8, 9, "G81 Z5 R2 F100\nM30\n"),
    ("GC416", 1, 1, 3, "G83 Z-9 R1 F100\nM30\n"),
    ("GC501", 1, 1, 6, "G1 X10\nM30\n"),
    ("GC502", 2, 1, 5, "G93 G1 X1 F10\nX5 Y1\nM30\n"),
    ("GC503", 1, 1, 3, "G96 S200\nM30\n"),
    ("GC504", 1, 7, 8, "G1 X1 F0\nM30\n"),
    ("GC504", 1, 7, 11, "G1 X1 F-100\nM30\n"),
    ("GC505", 1, 1, 15, "G95 G1 X1 F0.10\nM30\n"),
    ("GC506", 1, 5, 7, "G04 P-1\nM30\n"),
    ("GC507", 1, 1, 3, "G04\nM30\n"),
    ("GC508", 1, 8, 11, "G04 X1 P500\nM30\n"),
    ("GC509", 1, 5, 7, "G43 H99\nM30\n"),
    ("GC510", 1, 1, 3, "M15\nM30\n"),
    ("GC511", 1, 8, 9, "M66 P0 L1\nM30\n"),
    ("GC511", 1, 11, 12, "M66 P0 L3 Q1\nM30\n"),
    ("GC512", 1, 4, 10, "G4 X100000\nM30\n"),
    ("GC514", 1, 5, 7, "M62 P40\nM30\n"),
    ("GC601", 2, 1, 3, "O1\nM98 P1\nM99\n"),
    ("GC603", 1, 1, 3, "M98 P9999\nM30\n"),
    ("GC605", 1, 6, 7, "GOTO 77\nM30\n"),
    ("GC605", 3, 6, 6, "N5 G0 X1\nN5 G0 X2\nGOTO 5\nM30\n"),
    ("GC606", 1, 1, 3, "END1\nM30\n"),
    ("GC607", 1, 1, 5, "WHILE [0 EQ 1] DO1\nM30\n"),
    ("GC607", 1, 1, 18, "WHILE [1 EQ 1] DO1\nG0 X1\n"),
    ("GC608", 1, 6, 7, "GOTO 10\nWHILE [0 EQ 1] DO1\nN10 G0 X1\nEND1\nM30\n"),
    ("GC609", 1, 7, 10, "G0 X1 GOTO 5\nM30\n"),
    ("GC610", 1, 4, 4, "IF #1 EQ 2 GOTO 5\nM30\n"),
    ("GC611", 1, 1, 8, "o100 sub\nM30\n"),
    ("GC612", 1, 1, 3, "M98\nM30\n"),
    ("GC613", 1, 1, 3, "M98 P5\nM30\nO5\nM99\nO5\nM99\n"),
    ("GC614", 1, 1, 3, "M17\nM30\n"),
    ("GC616", 1, 1, 4, "L100 O10000\nM30\n"),
    ("GC701", 1, 1, 5, "#2000=1\nM30\n"),
    ("GC702", 1, 5, 6, "G0 X#5\nM30\n"),
    ("GC703", 1, 5, 10, "G0 X#[1.5]\nM30\n"),
    ("GC703", 1, 1, 1, "#-1=5\nM30\n"),
    ("GC704", 1, 7, 8, "#1=5 X#1\nM30\n"),
    ("GC705", 1, 1, 3, "CI1 = 3000000000\nM30\n"),
    ("GC706", 1, 6, 8, "G0 X=abc\nM30\n"),
    ("GC707", 1, 1, 4, "CI99=1\nM30\n"),
    ("GC708", 1, 1, 6, "CI1000=1\nM30\n"),
    ("GC709", 1, 37, 37, "G0 X[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]\nM30\n"),
    ("GC710", 1, 7, 7, "G0 X[1/0]\nM30\n"),
    ("GC710", 1, 5, 7, "X[1 MOD 0]\nM30\n"),
    ("GC711", 1, 6, 9, "G0 X[SQRT[-1]]\nM30\n"),
    ("GC712", 1, 10, 11, "#1=[10000**400]\nM30\n"),
    ("GC713", 1, 5, 5, "G0 X[1+2\nM30\n"),
    ("GC713", 1, 6, 6, "G0 X1]\nM30\n"),
    ("GC714", 1, 8, 8, "G0 X[1+]\nM30\n"),
    ("GC714", 1, 6, 6, "G0 X[]\nM30\n"),
    ("GC715", 1, 6, 9, "G0 X[SINH[1]]\nM30\n"),
    ("GC716", 1, 6, 9, "G0 X[ATAN[1]]\nM30\n"),
    ("GC718", 1, 1, 2, "#1\nM30\n"),
    ("GC718", 1, 1, 3, "CI5\nM30\n"),
    ("GC719", 1, 5, 5, "G0 X\"a\"\nM30\n"),
    ("GC801", 1, 7, 8, "G0 X1 V5\nM30\n"),
    ("GW901", 1, 1, 10, "PART ABOUT\n%\nG0 X1\nM30\n"),
    ("GW902", 4, 1, 4, "%\nM30\n%\nmore\n"),
    ("GW903", 1, 1, 7, "%MPF 90\nG0 X1\nM30\n"),
    ("GW905", 1, 4, 22, "G0 X1.2345678901234567\nM30\n"),
    ("GW906", 1, 1, 6, "(a (b) c\nM30\n"),
    ("GW907", 1, 1, 9, "(DEBUG,a)\nM30\n"),
    ("GW908", 2, 1, 3, "N10 G0 X1\nN10 G0 X2\nM30\n"),
    ("GW909", 1, 1, 5, "G0 X1\n"),
    ("GW910", 1, 1, 2, "L5 O0\nM30\n%L5\nM17\n"),
    ("GW911", 1, 7, 8, "G0 X1 L5\nM30\n%L5\nM17\n"),
    ("GW912", 2, 1, 3, "G0 X1\nM99\n"),
    ("GW913", 1, 5, 7, "G90 G90\nM30\n"),
    ("GW914", 1, 1, 3, "G08\nM30\n"),
    ("GW915", 1, 1, 3, "G09\nM30\n"),
    ("GW917", 1, 1, 3, "G41 D1\nM30\n"),
    ("GW918", 1, 9, 12, "G64 P.1 Q.01\nM30\n"),
    ("GW920", 1, 7, 12, "G2 I5 K0.000 F100\nM30\n"),
    ("GW921", 2, 1, 20, "G0 X10\nG3 X10 Y.003 I-5 F99\nM30\n"),
    ("GW922", 1, 1, 20, "G2 X10.02 Y0 I5 F100\nM30\n"),
    ("GW923", 1, 11, 16, "G2 X10 Y0 R4.996 F100\nM30\n"),
    ("GW924", 1, 11, 12, "G2 X10 Y0 R5 F100\nM30\n"),
    ("GW925", 1, 7, 12, "G1 X1 F90000\nM30\n"),
    ("GW926", 1, 1, 13, "G1 X.01 F6000\nM30\n"),
    ("GW927", 1, 8, 10, "G0 X=1+CI5\nM30\n"),
    ("GW928", 1, 6, 7, "#1=5 #1=6\nM30\n"),
    ("GW930", 1, 1, 3, "M88\nM30\n"),
    ("GW931", 1, 1, 3, "M64 P1\nM30\n"),
    ("GW932", 1, 4, 5, "G4 P1\nM30\n"),
    ("GW933", 1, 1, 2, "G0\nM30\n"),
    ("GW935", 1, 5, 6, "T99 M6\nM30\n"),
];

/// Ids that the application finds, not the compiler: each has a scene in tests/app/test_catalogue.py.
const APPLICATION: &[&str] = &["GC112", "GC114", "GC803", "GC805", "GC806", "GC809", "GC810"];

fn find<'c>(compiled: &'c Compiled, id: &str, line: u32) -> Option<&'c gcode::Diagnostic> {
    compiled.diagnostics.iter().find(|d| d.id == id && d.line == line)
}

fn check(row: &Row, machine: &Machine, options: &Options) -> Option<String> {
    let &(id, line, column, end, text) = row;
    let compiled = compile(text.as_bytes(), "t.nc", machine, options);
    let all: Vec<String> = compiled.diagnostics.iter().map(ToString::to_string).collect();
    let Some(d) = find(&compiled, id, line) else { return Some(format!("{id} missing for {text:?}: {all:?}")) };
    if (d.column, d.end_column) != (column, end) {
        return Some(format!("{id} at {}..{} for {text:?}, expected {column}..{end}", d.column, d.end_column));
    }
    let others: Vec<&String> = all.iter().filter(|t| t.contains(": GC") && !t.contains(id)).collect();
    if id.starts_with("GC") && id != "GC111" && !others.is_empty() {
        return Some(format!("{id} with others for {text:?}: {others:?}"));
    }
    assert_eq!(compiled.program.is_none(), compiled.has_errors(), "{text:?}");
    None
}

// shows: gcode.identifier-no-digits
#[test]
fn each_id_is_found_where_it_is() {
    let wrong: Vec<String> = ON_MILL3.iter().filter_map(|row| check(row, &mill3(), &Options::default())).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A row with the machine and the options it needs.
struct Scene {
    row: Row,
    machine: Machine,
    options: Options,
}

fn on(machine: Machine, row: Row) -> Scene {
    Scene { row, machine, options: Options::default() }
}
fn with(row: Row, change: impl FnOnce(&mut Machine)) -> Scene {
    let mut machine = mill3();
    change(&mut machine);
    on(machine, row)
}
fn limited(limits: Limits, row: Row) -> Scene {
    Scene { row, machine: mill3(), options: Options { limits, ..Options::default() } }
}

fn part(from: At, row: Row) -> Scene {
    Scene { row, machine: mill3(), options: Options { from: Some(from), ..Options::default() } }
}
fn strict(row: Row) -> Scene {
    Scene { row, machine: mill3(), options: Options { strict: true, ..Options::default() } }
}

fn scenes() -> Vec<Scene> {
    let rotary = |row: Row| on(example("mill4a"), row);
    let cylinder = |row: Row| on(example("mill4c"), row);
    let corrected = |row: Row| with(row, |m| m.gcode.tools[0].radius = 4.0);
    let linuxcnc = Options { profile: Some(Profile::Linuxcnc), ..Options::default() };
    let o_words = |row: Row| Scene { row, machine: mill3(), options: linuxcnc.clone() };
    let default = Limits::default;
    vec![
        rotary(("GC324", 1, 5, 7, "G81 A90 Z-1 R1 F10\nM30\n")),
        rotary(("GC418", 1, 11, 13, "G2 X10 I5 A90 F10\nM30\n")),
        cylinder(("GC321", 2, 1, 3, "G07.1 C20\nG28\nM30\n")),
        on(two_tables(), ("GC322", 2, 7, 8, "G07.1 C20\nG07.1 A5\nM30\n")),
        cylinder(("GC414", 1, 7, 9, "G07.1 C-5\nM30\n")),
        on(example("xy-stepper"), ("GC417", 1, 5, 6, "G18 G2 X10 R5 F10\nM30\n")),
        with(("GC312", 1, 1, 3, "G41 D1\nM30\n"), |m| m.gcode.dialect.radius_correction = Some(false)),
        corrected(("GC419", 2, 1, 3, "G41 D1 G1 X5 F100\nG54\nM30\n")),
        corrected(("GC420", 2, 1, 9, "G41 D1 G1 X5 F100\nG3 X1 I-2\nM30\n")),
        corrected(("GC421", 4, 1, 2, "G41 D1 G1 X5 F100\nX40\nY6\nX0\nM30\n")),
        corrected(("GC422", 3, 1, 3, "G41 D1 G1 X5 F100\nX40\nX10\nM30\n")),
        o_words(("GC606", 2, 1, 11, "o1 do\no1 endwhile\nM30\n")),
        o_words(("GC606", 2, 1, 12, "o1 while [1]\no1 endrepeat\nM30\n")),
        o_words(("GC606", 2, 1, 8, "o1 repeat [2]\no1 while [1]\no1 endwhile\no1 endrepeat\nM30\n")),
        with(("GC513", 1, 1, 3, "M88\nM30\n"), |m| m.gcode.dialect.strict_m = Some(true)),
        with(("GC515", 1, 4, 8, "M3 S9000\nM30\n"), |m| m.gcode.spindle.limit = 8000.0),
        with(("GC516", 2, 1, 2, "T1 M6\nM6\nM30\n"), |m| m.gcode.dialect.m6_needs_t = Some(true)),
        with(("GC615", 4, 4, 6, "L5\nM30\n%L5\nX1 M30\nM17\n"), |m| m.gcode.dialect.strict_end = Some(true)),
        limited(Limits { bytes: 4, ..default() }, ("GC106", 1, 1, 1, "G0 X1\nM30\n")),
        limited(Limits { errors: 1, ..default() }, ("GC111", 2, 4, 7, "G0 X700\nG0 X700\nM30\n")),
        limited(
            Limits { blocks: 1000, ..default() },
            ("GC602", 2, 1, 18, "N1 #1=1\nWHILE [1 EQ 1] DO1\nG4 P2\nEND1\nM30\n"),
        ),
        limited(Limits { idle_blocks: 1000, ..default() }, ("GC602", 1, 1, 9, "N1 GOTO 1\nM30\n")),
        limited(Limits { calls: 3, ..default() }, ("GC601", 2, 1, 3, "O1\nM98 P1\nM99\n")),
        on(excluded(), ("GC802", 1, 4, 5, "G0 A1\nM30\n")),
        Scene { machine: nfrax(), ..rotary(("GC804", 1, 1, 12, "G1 A90 F1000\nM30\n")) },
        with(("GC807", 1, 1, 1, "G0 X1\nM30\n"), |m| m.gcode.trac_feed = 0.0),
        on(flat(), ("GC808", 1, 1, 1, "G0 X1\nM30\n")),
        Scene { row: ("GC604", 1, 1, 11, "o<a/b> call\nM30\n"), machine: mill3(), options: linuxcnc },
        with(("GW904", 2, 4, 8, "G0 X1. Y2.\nG0 X1000 Y5.\nM30\n"), |m| {
            m.gcode.dialect.integer_increment = Some(0.001)
        }),
        with(("GW916", 2, 1, 3, "M3 S600\nG33 Z-2 K1\nM30\n"), |m| m.gcode.dialect.thread_as_feed = Some(true)),
        with(("GW919", 2, 1, 3, "M3 S600\nG84 Z-2 R1 F600\nM30\n"), |m| m.gcode.dialect.tapping_floating = Some(true)),
        part(At::Block(77), ("GC617", 1, 1, 1, "N10 G0 X1\nM30\n")),
        part(At::Line(2), ("GC617", 1, 1, 1, "GOTO 5\nG0 X1\nN5 M30\n")),
        part(At::Line(4), ("GC618", 4, 1, 1, "L5\nM30\n%L5\nG0 X1\nM17\n")),
        part(At::Block(5), ("GC605", 1, 1, 1, "N5 G0 X1\nN5 X2\nM30\n")),
        strict(("GW941", 3, 5, 9, "G1 X5 F100\nY5 F300\nX10 F2000\nM30\n")),
        strict(("GW942", 2, 1, 37, "G0 X10\nG3 X9.99996192 Y0.0872653550 I-10 F99\nM30\n")),
        strict(("GW943", 4, 4, 6, "G0 Z5\nX5\nG1 Z-1 F100\nG0 X10\nM30\n")),
        strict(("GW944", 3, 1, 3, "L6\nM30\n%L5\nM17\n%L6\nM17\n")),
        on(wide(), ("GW934", 2, 4, 6, "G0 X1\nG0 G20 X100\nX5\nM30\n")),
    ]
}

/// A machine with two rotary axes.
fn two_tables() -> Machine {
    let mut machine = example("mill4c");
    machine.axes.push(machine.axes[3].clone());
    (machine.axes[4].name, machine.axes[4].letter) = ("A".to_owned(), Some('A'));
    machine
}
/// A machine without software limits.
fn wide() -> Machine {
    let mut machine = mill3();
    machine.axes.iter_mut().for_each(|a| a.limits = None);
    machine
}
/// Its A axis is not for programs.
fn excluded() -> Machine {
    let mut machine = example("mill4a");
    machine.axes[3].letter = None;
    machine
}
/// Its A axis does not count for the path.
fn nfrax() -> Machine {
    let mut machine = example("mill4a");
    machine.gcode.nfrax = vec![3];
    machine
}
fn flat() -> Machine {
    let mut machine = example("mill4a");
    machine.axes[3].effradius = 0.0;
    machine
}

#[test]
fn ids_that_need_another_machine_or_option() {
    let wrong: Vec<String> = scenes().iter().filter_map(|s| check(&s.row, &s.machine, &s.options)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let idle = limited(Limits { idle_blocks: 1000, ..Limits::default() }, ON_MILL3[0]);
    let busy = "#1=0\nWHILE [#1 LT 400] DO1\n#1=[#1+1]\nG4 P2\nEND1\nM30\n";
    assert!(
        compile(busy.as_bytes(), "t.nc", &mill3(), &idle.options).program.is_some(),
        "1600 blocks, but they command"
    );
}

/// Loops are named as the program has them, and a limit is that which was passed.
#[test]
fn loops_and_limits_are_named() {
    let few = Limits { commands: 10, ..Limits::default() };
    let said = |text: &str, limits: Limits| {
        let options = Options { profile: Some(Profile::Linuxcnc), limits, ..Options::default() };
        compile(text.as_bytes(), "t.nc", &mill3(), &options).diagnostics[0].message.clone()
    };
    let texts = [
        ("o1 do\no1 endwhile\nM30\n", "o1 endwhile without o1 while or crossed loops"),
        ("o<name> break\nM30\n", "o<name> break without o<name> while or crossed loops"),
        ("o1 if [0]\nM30\n", "o1 without o1 elseif/o1 else/o1 endif"),
        ("o1 repeat [2]\n", "o1 repeat without o1 endrepeat"),
        ("END2\nM30\n", "END2 without DO2 or crossed loops"),
        ("WHILE [0 EQ 1] DO1\nM30\n", "DO1 without END1"),
    ];
    for (text, message) in texts {
        assert_eq!(said(text, Limits::default()), message);
    }
    let endless = "WHILE [1 EQ 1] DO1\nG91 X1\nX-1\nEND1\nM30\n";
    assert_eq!(said(endless, few), "more than 10 commands spooled (endless loop?)");
    let blocks = Limits { blocks: 1000, ..Limits::default() };
    assert_eq!(said(endless, blocks), "more than 1000 blocks executed (endless loop?)");
}

/// Files that a Rust string cannot hold, and long ones: (id, line, column, end column, bytes).
fn files() -> Vec<(&'static str, u32, u32, u32, Vec<u8>)> {
    let long = |n: usize| format!("write \"{}\"\nM30\n", "x".repeat(n)).into_bytes();
    let two = format!("write \"{0}\"\nwrite \"{0}\"\nwriteln\nwrite \"{0}\"\nM30\n", "x".repeat(300));
    let megabyte = vec![b'X'; 1 << 20];
    vec![
        ("GC101", 1, 1, 1, b"\x7fELF\x02\x01\x01\x00\x00\x00".to_vec()),
        ("GC102", 1, 1, 1, b"\xFF\xFEG\x000\x00".to_vec()),
        ("GC105", 2, 1025, 1 << 20, [&b"G0 X1\n"[..], &megabyte, b"\nM30\n"].concat()),
        ("GC113", 1, 1, 1, Vec::new()),
        ("GC717", 1, 7, 521, long(513)),
        ("GW929", 2, 1, 308, two.into_bytes()),
    ]
}

#[test]
fn files_that_are_no_text_or_too_long() {
    for (id, line, column, end, source) in files() {
        let compiled = compile(&source, "t.nc", &mill3(), &Options::default());
        let found: Vec<_> = compiled.diagnostics.iter().map(|d| (d.id, d.line, d.column, d.end_column)).collect();
        assert_eq!(found, [(id, line, column, end)]);
    }
}

#[test]
fn more_than_a_hundred_errors_stop() {
    let compiled = common::run(&"G0 X700\n".repeat(300));
    assert_eq!(compiled.diagnostics.iter().filter(|d| d.id == "GC413").count(), 100);
    assert_eq!(compiled.diagnostics.last().map(|d| (d.id, d.line)), Some(("GC111", 101)));
}

/// No id is unreachable: each has a row, a scene or a file above, or a scene of the application.
#[test]
fn every_id_is_shown() {
    let rows = ON_MILL3.iter().map(|row| row.0);
    let shown: BTreeSet<&str> =
        rows.chain(scenes().iter().map(|s| s.row.0)).chain(files().iter().map(|f| f.0)).collect();
    let application: BTreeSet<&str> = APPLICATION.iter().copied().collect();
    assert_eq!(shown.intersection(&application).count(), 0);
    let all: BTreeSet<&str> = CATALOGUE.iter().map(|row| row.1).collect();
    assert_eq!(shown.union(&application).copied().collect::<BTreeSet<_>>(), all);
}

/// Warnings about a line that is behind know their column.
#[test]
fn late_warnings_have_their_place() {
    let place = |text: &str, id: &str| {
        let compiled = common::run(text);
        compiled.diagnostics.iter().filter(|d| d.id == id).map(|d| (d.line, d.column, d.end_column)).collect::<Vec<_>>()
    };
    assert_eq!(place("(\u{e4}) G1 X.01 F6000 (end)\nM30\n", "GW926"), [(1, 5, 17)]);
    assert_eq!(place("F6000\n  G1 X.01\nG4 P5\n  G1 X.02\nM30\n", "GW926"), [(2, 3, 9), (4, 3, 9)]);
}
