//! One golden translation for every G and M function, compared as numbers and read against docs/dialect.md.
//!
//! Expected commands are words and numbers: `line X10 v10 e5` is a feed move of the axes that change, at 10 mm/s with
//! target velocity 5; `arc XY X10 cX5 cY0 p-180` a circle about (5, 0); `ssf * 1003 1000` a spool function of all group
//! axes. What every program end adds (outputs off, M30, drain) is left out.

mod common;

use std::collections::BTreeSet;

use gcode::codes::{Decision, G_CODES, number};
use gcode::{Options, compile};
use motion_kernel::autocode::{Instr, MoveKind, Program};
use motion_kernel::machine::{MFunction, Machine, has_fixed_meaning};

/// X Y Z C and a spindle axis S; tool 1 is 50 mm long with radius 5; work offsets X 0, 10 .. 50; P2 at X100.
fn machine() -> Machine {
    let mut machine = common::example("mill4c");
    let mut spindle = machine.axes[3].clone();
    (spindle.name, spindle.letter, spindle.rapid, spindle.acceleration) = ("S".to_owned(), None, 18_000.0, 50_000.0);
    machine.axes.push(spindle);
    let gcode = &mut machine.gcode;
    gcode.spindle.axis = Some(4);
    (gcode.tools[0].length, gcode.tools[0].radius) = (50.0, 5.0);
    gcode.position_factors = vec![1.0; 5];
    for (set, offsets) in gcode.offsets.iter_mut().enumerate() {
        *offsets = vec![10.0 * set as f64, 0.0, 0.0, 0.0, 0.0];
    }
    gcode.references[0] = Some(vec![100.0, 0.0, 0.0, 0.0, 0.0]);
    gcode.m_functions.push(MFunction { number: 110, set: 32, reset: 64, wait: 0, ci: Some((7, -2)) });
    machine
}

/// (functions shown, program without its end, expected commands)
type Golden = (&'static str, &'static str, &'static [&'static str]);

const MOTION: &[Golden] = &[
    ("G0", "G0 X30 Y40", &["rapid X30 Y40 v250"]), // Y at its 200 mm/s
    ("G1", "G1 X10 F600", &["line X10 v10 e0"]),
    ("G1", "G1 X3 Y4 F600\nX6 Y8", &["line X3 Y4 v10 e10", "line X6 Y8 v10 e0"]),
    ("G1", "G1 C90 F600", &["line C90 v10 e0"]),
    // F holds for the tool point: L_c is sqrt(10*10 + 10*10)
    ("G1", "G1 X10 C10 F600", &["line X10 C10 v14.142135623730951 e0"]),
    ("G2 G17", "G17 G2 X10 Y10 I10 F600", &["arc XY X10 Y10 cX10 cY0 p-90 v10 e0"]),
    ("G3", "G3 X10 Y10 J10 F600", &["arc XY X10 Y10 cX0 cY10 p90 v10 e0"]),
    ("G3", "G3 X0 Y0 I5 P3 F600", &["arc XY cX5 cY0 p1080 v10 e0"]),
    ("G2", "G2 X10 R-10 F600", &["arc XY X10 cX5 cY8.660254037844387 p-300 v10 e0"]),
    ("G18", "G18 G2 Z10 X10 K10 F600", &["arc ZX X10 Z10 cZ10 cX0 p-90 v10 e0"]),
    ("G19", "G19 G2 Y10 Z10 J10 F600", &["arc YZ Y10 Z10 cY10 cZ0 p-90 v10 e0"]),
    (
        "G90.1 G91.1",
        "G90.1 G2 X10 Y0 I5 J0 F600\nG91.1 X20 I5",
        &["arc XY X10 cX5 cY0 p-180 v10 e10", "arc XY X20 cX15 cY0 p-180 v10 e0"],
    ),
    ("G9", "G1 X10 F600\nG9 X20\nX30", &["line X10 v10 e10", "line X20 v10 e0", "line X30 v10 e0"]),
    (
        "G60 G64",
        "G60 G1 X10 F600\nX20\nG64 X30\nX40",
        &["line X10 v10 e0", "line X20 v10 e0", "line X30 v10 e10", "line X40 v10 e0"],
    ),
    (
        "G61 G61.1",
        "G61 G1 X10 F600\nX20\nG64\nG61.1 X30\nX40",
        &["line X10 v10 e0", "line X20 v10 e0", "line X30 v10 e0", "line X40 v10 e0"],
    ),
    ("G93", "G93 G1 X10 F6", &["line X10 v1 e0"]), // a sixth of a minute
    ("G94 G95", "S600\nG95 G1 X10 F0.5\nG94 X20 F600", &["ssf X 20200 600", "line X10 v5 e5", "line X20 v10 e0"]),
    ("G90 G91", "G91 G0 X5\nX5\nG90 X5", &["rapid X5 v200", "rapid X10 v200", "rapid X5 v200"]),
    ("G20 G21", "G20 G1 X1 F60\nG21 X10 F60", &["line X25.4 v25.4 e1", "line X10 v1 e0"]),
    ("G70 G71", "G70 G1 X1 F60\nG71 X10 F60", &["line X25.4 v25.4 e1", "line X10 v1 e0"]),
    (
        "G7.1",
        "G7.1 C20\nG1 C90 F600\nG3 C90 K10 J0\nG7.1 C0",
        &[
            "drain",
            "effradius C20",
            "line C90 v10 e10",
            "arc CZ cC90 cZ10 p360 v10 e0",
            "drain",
            "effradius C57.29577951308232",
        ],
    ),
    (
        "G107",
        "G107 C10\nG1 C90 Z5 F600\nG107 C0",
        &["drain", "effradius C10", "line Z5 C90 v10 e0", "drain", "effradius C57.29577951308232"],
    ),
    // 2 turns at 10 a second: (3 mm, 720 degrees) in 0.2 s
    (
        "G33",
        "M3 S600\nG33 Z-3 K1.5\nG0 X1",
        &[
            "ssf X 20200 600",
            "ssf X 1002 2",
            "ssf X 1001 1",
            "ssf X 1002 3",
            "line Z-3 S720 v3600.0312498643 e0",
            "ssf X 1002 2",
            "ssf X 1001 1",
            "rapid X1 v200",
        ],
    ),
    ("G8 G15 G23 G62 G11", "G8\nG15\nG23\nG62\nG11\nG0 X1", &["rapid X1 v200"]),
];

const SHIFTS: &[Golden] = &[
    ("G10", "G10 L2 P1 X5\nG0 X1\nG91 G10 L2 P1 X5\nG90 X1", &["rapid X6 v200", "rapid X11 v200"]),
    (
        "G10",
        "G0 X10\nG10 L20 P1 X0\nX1\nG10 L1 P3 Z7\nG43 H3 Z0",
        &["rapid X10 v200", "rapid X11 v200", "rapid Z7 v200"],
    ),
    ("G28", "G0 X10 Y5\nG28 X20", &["rapid X10 Y5 v223.60679774997897", "rapid X20 v200", "rapid X0 v200"]),
    ("G28", "G0 X10 Z5\nG28", &["rapid X10 Z5 v223.60679774997897", "rapid X0 Z0 v223.60679774997897"]),
    ("G30", "G30 X5", &["rapid X5 v200", "rapid X100 v200"]),
    ("G40 G41", "G41 D1 G1 X10 F600\nX40\nG40 Y20", &["line X10 Y5 v10 e10", "line X40 v10 e10", "line Y20 v10 e0"]),
    ("G40 G42", "G42 D1 G1 X10 F600\nX40\nG40 Y20", &["line X10 Y-5 v10 e10", "line X40 v10 e10", "line Y20 v10 e0"]),
    ("G43 G49", "G43 H1 G0 Z0\nG49 Z0", &["rapid Z50 v200", "rapid Z0 v200"]),
    ("G44", "G44 H1 G0 Z0", &["rapid Z-50 v200"]),
    ("G50 G51", "G51 X0 Y0 Z0 P2\nG0 X10\nG50\nX10", &["rapid X20 v200", "rapid X10 v200"]),
    ("G51", "G51 X4 I3\nG0 X10", &["rapid X22 v200"]),
    (
        "G50.1 G51.1",
        "G51.1 X5\nG0 X0\nG2 X10 Y10 I10 F600\nG50.1\nG0 X0",
        &["rapid X10 v200", "arc XY X0 Y10 cX0 cY0 p90 v10 e0"],
    ),
    ("G52", "G52 X5\nG0 X1\nG52 X0\nX1", &["rapid X6 v200", "rapid X1 v200"]),
    (
        "G53 G55",
        "G55 G0 X1\nG53 X2\nX3\nG53\nX4",
        &["rapid X11 v200", "rapid X2 v200", "rapid X13 v200", "rapid X4 v200"],
    ),
    ("G54 G56", "G56 G0 X1\nG54 X1", &["rapid X21 v200", "rapid X1 v200"]),
    ("G57 G58 G59", "G57 G0 X1\nG58\nX1\nG59\nX1", &["rapid X31 v200", "rapid X41 v200", "rapid X51 v200"]),
    ("G54.1", "G55\nG54.1 P3\nG0 X1", &["rapid X1 v200"]),
    ("G68 G69", "G68 X0 Y0 R90\nG0 X10\nG69\nX10", &["rapid Y10 v200", "rapid X10 v200"]),
    ("G68", "G0 X10\nG68 R90\nX20", &["rapid X10 v200", "rapid Y10 v200"]),
    ("G92 G92.1", "G0 X10\nG92 X0\nX5\nG92.1\nX5", &["rapid X10 v200", "rapid X15 v200", "rapid X5 v200"]),
    ("G92.2 G92.3", "G0 X10\nG92 X0\nG92.2\nX5\nG92.3\nX5", &["rapid X10 v200", "rapid X5 v200", "rapid X15 v200"]),
];

const CYCLES: &[Golden] = &[
    (
        "G73",
        "G0 Z5\nG73 Z-5 R1 Q3 F600",
        &["rapid Z5 v200", "rapid Z1 v200", "line Z-2 v10 e0", "rapid Z-1 v200", "line Z-5 v10 e0", "rapid Z5 v200"],
    ),
    (
        "G81 G80",
        "G0 Z5\nG81 X10 Z-5 R1 F600\nX20\nG80 G0 X0",
        &[
            "rapid Z5 v200",
            "rapid X10 v200",
            "rapid Z1 v200",
            "line Z-5 v10 e0",
            "rapid Z5 v200",
            "rapid X20 v200",
            "rapid Z1 v200",
            "line Z-5 v10 e0",
            "rapid Z5 v200",
            "rapid X0 v200",
        ],
    ),
    (
        "G82",
        "G0 Z5\nG82 Z-5 R1 P64 F600",
        &["rapid Z5 v200", "rapid Z1 v200", "line Z-5 v10 e0", "ssf * 1003 1000", "rapid Z5 v200"],
    ),
    (
        "G83",
        "G0 Z5\nG83 Z-5 R1 Q3 F600",
        &[
            "rapid Z5 v200",
            "rapid Z1 v200",
            "line Z-2 v10 e0",
            "rapid Z1 v200",
            "rapid Z-1 v200",
            "line Z-5 v10 e0",
            "rapid Z5 v200",
        ],
    ),
    // 6 mm at 1 mm a turn and 10 turns a second: (6 mm, 2160 degrees) in 0.6 s
    (
        "G84",
        "G0 Z5\nM4 S600\nG84 Z-5 R1 F600",
        &[
            "rapid Z5 v200",
            "ssf X 20200 600",
            "ssf X 1002 1",
            "ssf X 1001 2",
            "rapid Z1 v200",
            "ssf X 1002 3",
            "line Z-5 S-2160 v3600.013888862099 e0",
            "line Z1 S0 v3600.013888862099 e0",
            "ssf X 1002 1",
            "ssf X 1001 2",
            "rapid Z5 v200",
        ],
    ),
    (
        "G85",
        "G0 Z5\nG85 Z-5 R1 F600",
        &["rapid Z5 v200", "rapid Z1 v200", "line Z-5 v10 e10", "line Z1 v10 e0", "rapid Z5 v200"],
    ),
    (
        "G86",
        "G0 Z5\nM3\nG86 Z-5 R1 P64 F600",
        &[
            "rapid Z5 v200",
            "ssf X 1002 2",
            "ssf X 1001 1",
            "rapid Z1 v200",
            "line Z-5 v10 e0",
            "ssf * 1003 1000",
            "ssf X 1002 3",
            "rapid Z5 v200",
            "ssf X 1002 2",
            "ssf X 1001 1",
        ],
    ),
    (
        "G89",
        "G0 Z5\nG89 Z-5 R1 P64 F600",
        &["rapid Z5 v200", "rapid Z1 v200", "line Z-5 v10 e0", "ssf * 1003 1000", "line Z1 v10 e0", "rapid Z5 v200"],
    ),
    (
        "G98 G99",
        "G0 Z5\nG99 G81 Z-5 R1 F600\nG98 X10",
        &[
            "rapid Z5 v200",
            "rapid Z1 v200",
            "line Z-5 v10 e0",
            "rapid Z1 v200",
            "rapid X10 v200",
            "line Z-5 v10 e0",
            "rapid Z5 v200",
        ],
    ),
    // incremental: R from the level, Z from R, the hole twice
    (
        "G81",
        "G91 G81 X10 Z-5 R-1 L2 F600",
        &[
            "rapid X10 v200",
            "rapid Z-1 v200",
            "line Z-6 v10 e0",
            "rapid Z0 v200",
            "rapid X20 v200",
            "rapid Z-1 v200",
            "line Z-6 v10 e0",
            "rapid Z0 v200",
        ],
    ),
];

const SWITCHING: &[Golden] = &[
    (
        "G4",
        "G4 X0.064\nG4 P64\nG4 F0.064\nG4 U0.064",
        &["ssf * 1003 1000", "ssf * 1003 1000", "ssf * 1003 1000", "ssf * 1003 1000"],
    ),
    ("G74", "G74 X0 Z0", &["event G74 XZ", "ssf * 1025 1"]),
    ("G75", "G1 X10 F600\nG75\nX20", &["line X10 v10 e0", "drain", "line X20 v10 e0"]),
    // at X0 the limit holds
    ("G96 G97", "G92 S1000\nG96 S100\nG97 S500", &["ssf X 20200 1000", "ssf X 20200 500"]),
    ("G65", "G65 P9 X5 Z-1\nM30\nO9\nG0 X#24 Z#26\nM99", &["rapid X5 Z-1 v203.9607805437114"]),
    ("M0", "G1 X5 F600\nM0\nX9", &["line X5 v10 e0", "event M00", "ssf * 1000 0", "line X9 v10 e0"]),
    ("M1", "M1", &[]),
    ("M2", "G0 X1\nM2", &["rapid X1 v200"]),
    ("M30", "G0 X1\nM30", &["rapid X1 v200"]),
    ("M3", "M3 S500 G1 X1 F600", &["ssf X 20200 500", "ssf X 1002 2", "ssf X 1001 1", "line X1 v10 e0"]),
    ("M4", "M4", &["ssf X 1002 1", "ssf X 1001 2"]),
    ("M5", "M5 G1 X1 F600", &["line X1 v10 e0", "ssf X 1002 3"]),
    ("M6", "T2 M6", &["event T 2", "event M06 2", "ssf * 1025 1"]),
    ("M7", "M7", &["ssf X 1001 8"]),
    ("M8", "M8 G1 X1 F600", &["ssf X 1001 4", "line X1 v10 e0"]),
    ("M7 M8", "M7 M8", &["ssf X 1001 12"]),
    ("M9", "M9 G1 X1 F600", &["line X1 v10 e0", "ssf X 1002 12"]),
    ("M10 M11", "M10\nM11", &["ssf X 1001 16", "ssf X 1002 16"]),
    ("M13", "M13", &["ssf X 1002 2", "ssf X 1001 5"]),
    ("M14", "M14", &["ssf X 1002 1", "ssf X 1001 6"]),
    ("M17", "L5 O2\nM30\n%L5\nG91 G0 X1\nM17", &["rapid X1 v200", "rapid X2 v200"]),
    ("M29", "L NAME\nM30\n%L NAME\nG0 X1\nM29", &["rapid X1 v200"]),
    ("M98 M99", "M98 P5 L2\nM30\nO5\nG91 G0 X1\nM99", &["rapid X1 v200", "rapid X2 v200"]),
    ("M19", "M19 S90", &["event M19 90", "ssf * 1025 1"]),
    ("M36 M37 M38 M39", "M36\nM37\nM38\nM39", &["event M36", "event M37", "event M38", "event M39"]),
    (
        "M40 M41 M42",
        "M40\nM41\nM42",
        &["event M40", "ssf * 1025 1", "event M41", "ssf * 1025 1", "event M42", "ssf * 1025 1"],
    ),
    (
        "M43 M44 M45",
        "M43\nM44\nM45",
        &["event M43", "ssf * 1025 1", "event M44", "ssf * 1025 1", "event M45", "ssf * 1025 1"],
    ),
    ("M46 M47", "M46\nM47", &["event M46", "event M47"]),
    ("M48 M49", "M49\nM48", &["event M49", "event M48"]),
    ("M60", "M60", &["event M60", "ssf * 1000 0"]),
    ("M62 M63", "M62 P3\nM63 P31", &["ssf X 1001 8", "ssf X 1002 2147483648"]),
    ("M64 M65", "M64 P3\nM65 P3", &["ssf X 1001 8", "ssf X 1002 8"]),
    ("M66", "G1 X1 F600\nM66 P3 L3\nM66 P3 L0", &["line X1 v10 e0", "ssf * 1004 8"]),
    ("M50", "M50", &["event M50"]),
    ("M110", "M110", &["ssf X 7 -2", "ssf X 1002 64", "ssf X 1001 32"]),
    ("S T H", "S100\nT7\nH5", &["ssf X 20200 100", "event T 7", "ssf X 200 5"]),
    ("CI CD MSG", "CI5 = 7\nCD6 = 1.5\n(MSG, look)", &["ssf X 5 7", "ssf X 20006 1.5", "event MSG look"]),
];

/// Commands of a program as words and numbers.
fn rendered(program: &Program, machine: &Machine) -> Vec<String> {
    let names: Vec<&str> = machine.axes.iter().map(|a| a.name.as_str()).collect();
    let mut at = vec![0.0; names.len()];
    let (mut pushed, mut out) = (0.0, Vec::new());
    for instr in &program.code {
        match *instr {
            Instr::Spool(n) => {
                let mv = &program.moves[n as usize];
                let axes: Vec<usize> = program.axes_of(mv).iter().collect();
                let mut to = at.clone();
                axes.iter().zip(program.targets_of(mv)).for_each(|(a, v)| to[*a] = *v);
                let moved = |a: &usize| (to[*a] - at[*a]).abs() > 1e-9;
                let target: String = (0..to.len()).filter(moved).map(|a| format!(" {}{}", names[a], to[a])).collect();
                out.push(match (mv.kind, mv.rapid) {
                    (MoveKind::Smla, true) => format!("rapid{target} v{}", mv.vl),
                    (MoveKind::Smla, false) => format!("line{target} v{} e{}", mv.vl, mv.tvl),
                    _ => {
                        let (a, b) = (names[axes[0]], names[axes[1]]);
                        let centre = format!("c{a}{} c{b}{}", mv.center[0], mv.center[1]);
                        format!("arc {a}{b}{target} {centre} p{} v{} e{}", mv.phi, mv.vl, mv.tvl)
                    }
                });
                at = to;
            }
            Instr::Ssf(n) => {
                let ssf = &program.ssfs[n as usize];
                let who = if ssf.axes.len() == names.len() {
                    "*".to_owned()
                } else {
                    ssf.axes.iter().map(|a| names[a]).collect()
                };
                out.push(if ssf.command == 198 {
                    let event = &program.events[ssf.value as usize - 1];
                    format!("event {} {}", event.kind, event.text).trim().to_owned()
                } else {
                    format!("ssf {who} {} {}", ssf.command, ssf.value)
                });
            }
            Instr::Number(n) => pushed = program.numbers[n as usize],
            Instr::EffRadius(a) => out.push(format!("effradius {}{pushed}", names[usize::from(a)])),
            Instr::Drain(_) => out.push("drain".to_owned()),
            Instr::Ssms(_) | Instr::Halt => {}
            other => out.push(format!("{other:?}")),
        }
    }
    out
}

/// A word is letters and perhaps a number behind them.
fn same(found: &str, want: &str) -> bool {
    let split = |word: &str| {
        let letters = word.find(|c: char| c.is_ascii_digit() || c == '-' || c == '.').unwrap_or(word.len());
        (word[..letters].to_owned(), word[letters..].parse::<f64>().ok())
    };
    let (found, want): (Vec<&str>, Vec<&str>) = (found.split(' ').collect(), want.split(' ').collect());
    found.len() == want.len()
        && found.iter().zip(want).all(|(f, w)| {
            let ((f, x), (w, y)) = (split(f), split(w));
            f == w && x.is_some() == y.is_some() && (x.unwrap_or(0.0) - y.unwrap_or(0.0)).abs() <= 1e-9
        })
}

fn all() -> impl Iterator<Item = &'static Golden> {
    [MOTION, SHIFTS, CYCLES, SWITCHING].into_iter().flatten()
}

#[test]
fn every_translation_is_as_read_against_the_specification() {
    let machine = machine();
    let mut wrong = Vec::new();
    for (shows, text, want) in all() {
        let ended = text.contains("M30") || text.contains("M2");
        let source = if ended { format!("{text}\n") } else { format!("{text}\nM30\n") };
        let compiled = compile(source.as_bytes(), "t.nc", &machine, &Options::default());
        let Some(program) = compiled.program else {
            wrong.push(format!(
                "{shows}: {:?}",
                compiled.diagnostics.iter().map(ToString::to_string).collect::<Vec<_>>()
            ));
            continue;
        };
        let mut found = rendered(&program, &machine);
        let end = if text.ends_with("\nM2") { "event M02" } else { "event M30" };
        let tail: Vec<String> = found.split_off(found.len().saturating_sub(3));
        if tail != ["ssf X 1002 15", end, "drain"]
            || found.len() != want.len()
            || !found.iter().zip(*want).all(|(f, w)| same(f, w))
        {
            wrong.push(format!("{shows}: {text:?}\n  found {found:#?} {tail:?}\n  want  {want:#?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_comparison_sees_a_difference() {
    assert!(same("line X10 v10 e0", "line X10.0000000001 v10 e0"));
    for other in ["line X10.00001 v10 e0", "line Y10 v10 e0", "line X10 v10", "line X10 v10 e1", "rapid X10 v10 e0"] {
        assert!(!same("line X10 v10 e0", other), "{other}");
    }
}

/// No G function of the table and no M function with a meaning is without a golden translation.
#[test]
fn every_function_has_one() {
    let shown: BTreeSet<String> = all().flat_map(|row| row.0.split(' ')).map(str::to_owned).collect();
    let codes = G_CODES.iter().filter(|row| !matches!(row.2, Decision::Refused(_)));
    let missing: Vec<String> = codes.map(|row| format!("G{}", number(row.0))).filter(|g| !shown.contains(g)).collect();
    assert!(missing.is_empty(), "{missing:?}");
    let functions = (0..=999u32).filter(|m| has_fixed_meaning(*m)).map(|m| format!("M{m}"));
    let missing: Vec<String> = functions.filter(|m| !shown.contains(m)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
