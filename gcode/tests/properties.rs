//! Symmetric properties over generated programs, and robustness against any text.

mod common;

use common::{ends, mill3, points, program, program_for};
use gcode::{Limits, Options, compile};
use motion_kernel::machine::Profile;
use proptest::prelude::*;

fn near(a: &[Vec<f64>], b: &[Vec<f64>], tolerance: f64) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance))
}

/// Points on a grid of 0.01 mm.
fn path() -> impl Strategy<Value = Vec<(i32, i32, i32)>> {
    prop::collection::vec((-9000..9000i32, -9000..9000i32, -5000..5000i32), 1..20)
}
fn grid(v: i32) -> f64 {
    f64::from(v) / 100.0
}
fn lines(path: &[(i32, i32, i32)]) -> String {
    path.iter().map(|p| format!("G1 X{:.2} Y{:.2} Z{:.2} F500\n", grid(p.0), grid(p.1), grid(p.2))).collect()
}

proptest! {
    #[test]
    fn incremental_is_absolute(path in path()) {
        let mut before = (0, 0, 0);
        let steps: String = path.iter().map(|p| {
            let (x, y, z) = (grid(p.0 - before.0), grid(p.1 - before.1), grid(p.2 - before.2));
            before = *p;
            format!("G1 X{x:.2} Y{y:.2} Z{z:.2} F500\n")
        }).collect();
        let (a, b) = (program(&format!("{}M30\n", lines(&path))), program(&format!("G91\n{steps}M30\n")));
        prop_assert!(near(&points(&a), &points(&b), 1e-9));
    }

    #[test]
    fn inch_is_mm(path in path()) {
        let inch: String = path.iter().map(|p| {
            format!("G1 X{:.15} Y{:.15} Z{:.15} F{:.15}\n", grid(p.0) / 25.4, grid(p.1) / 25.4, grid(p.2) / 25.4, 500.0 / 25.4)
        }).collect();
        let (a, b) = (program(&format!("{}M30\n", lines(&path))), program(&format!("G20\n{inch}M30\n")));
        prop_assert!(near(&ends(&a), &ends(&b), 1e-9));
        prop_assert!(a.moves.iter().zip(&b.moves).all(|(a, b)| (a.vl - b.vl).abs() < 1e-9));
    }

    #[test]
    fn mirrored_twice_turned_by_360_and_scaled_back(path in path()) {
        let plain = program(&format!("{}M30\n", lines(&path)));
        for code in ["G51.1 X3\nG50.1 X0", "G68 X1 Y2 R360", "G51 X0 Y0 Z0 P1", "G52 X4 Y5\nG52 X0 Y0"] {
            let other = program(&format!("{code}\n{}M30\n", lines(&path)));
            prop_assert!(near(&ends(&plain), &ends(&other), 1e-9), "{}", code);
        }
        let mirrored = |text: &str| ends(&program(&format!("G51.1 X0 Y0\n{text}M30\n")));
        let negative: Vec<_> = path.iter().map(|p| (-p.0, -p.1, p.2)).collect();
        prop_assert!(near(&mirrored(&lines(&negative)), &ends(&plain), 1e-9));
    }

    /// R against I J K, G91.1 against G90.1: the same circle.
    #[test]
    fn the_forms_of_an_arc_agree(
        a in 0..3600i32, sweep in 10..3590i32, radius in 100..8000i32, plane in 0..3usize, clockwise: bool,
    ) {
        prop_assume!((sweep - 1800).abs() > 10);
        let (r, from) = (grid(radius), f64::from(a) / 10.0);
        let to = from + f64::from(if clockwise { -sweep } else { sweep }) / 10.0;
        let at = |angle: f64| (r * angle.to_radians().cos(), r * angle.to_radians().sin());
        let (s, e) = (at(from), at(to));
        let (first, second, i, j, g) = [("X", "Y", "I", "J", 17), ("Z", "X", "K", "I", 18), ("Y", "Z", "J", "K", 19)][plane];
        let start = format!("G{g} G0 {first}{:.9} {second}{:.9}\n", s.0, s.1);
        let arc = format!("{} {first}{:.9} {second}{:.9} F900", if clockwise { "G2" } else { "G3" }, e.0, e.1);
        let relative = program(&format!("{start}{arc} {i}{:.9} {j}{:.9}\nM30\n", -s.0, -s.1));
        let absolute = program(&format!("G90.1\n{start}{arc} {i}0 {j}0\nM30\n"));
        let by_radius = program(&format!("{start}{arc} R{}\nM30\n", if sweep > 1800 { -r } else { r }));
        let last = |p: &motion_kernel::autocode::Program| *p.moves.last().unwrap();
        for other in [&absolute, &by_radius] {
            let (one, two) = (last(&relative), last(other));
            prop_assert!((one.phi - two.phi).abs() < 1e-4, "{} {}", one.phi, two.phi);
            prop_assert!((0..2).all(|k| (one.center[k] - two.center[k]).abs() < 1e-4));
            prop_assert!(near(&ends(&relative), &ends(other), 1e-7));
        }
        prop_assert!((last(&relative).phi.abs() - f64::from(sweep) / 10.0).abs() < 1e-4);
    }

    /// Design D6: merging keeps every point, stays in tolerance, and no entry is shorter than 1.6 samples.
    #[test]
    fn merging_keeps_the_path(steps in prop::collection::vec((-20..60i32, -9..9i32, -9..9i32), 5..120), tolerance in 1..50u32) {
        let (mut x, mut y, mut z) = (0, 0, 0);
        let mut text = format!("G64 P{:.4}\nG1 F3000\n", f64::from(tolerance) / 1e4);
        let mut wanted = Vec::new();
        for (dx, dy, dz) in steps {
            let before = (x, y, z);
            (x, y, z) = (x + dx, y + dy, z + dz);
            text += &format!("X{:.3} Y{:.4} Z{:.4}\n", f64::from(x) / 1e3, f64::from(y) / 1e4, f64::from(z) / 1e4);
            if before != (x, y, z) {
                wanted.push(vec![f64::from(x) / 1e3, f64::from(y) / 1e4, f64::from(z) / 1e4]);
            }
        }
        let compiled = common::run(&(text + "M30\n"));
        let program = compiled.program.expect("no error");
        prop_assert!(near(&points(&program), &wanted, 1e-9));
        prop_assert!(compiled.facts.merged.max_mm <= f64::from(tolerance) / 1e4);
        let mut from = vec![0.0; 3];
        for (mv, to) in program.moves.iter().zip(ends(&program)) {
            let length = from.iter().zip(&to).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            prop_assert!(length / mv.vl >= 1.6 * 0.00128 * (1.0 - 1e-12));
            for via in program.vias_of(mv) {
                let p = program.via_targets(mv, via);
                let along: f64 = (0..3).map(|k| (p[k] - from[k]) * (to[k] - from[k])).sum::<f64>() / length;
                let square: f64 = (0..3).map(|k| (p[k] - from[k]).powi(2)).sum();
                prop_assert!((square - along * along).max(0.0).sqrt() <= f64::from(tolerance) / 1e4 + 1e-7);
            }
            from = to;
        }
    }

    /// Section 9: never negative, never above TRVL or the next TRVL, 0 at the end and beside rapids.
    #[test]
    fn target_velocities(words in prop::collection::vec(("G0|G1|G9 G1|G61 G1|G64 G1", -500..500i32, 1..60u32), 1..30)) {
        let text: String = words.iter().map(|(g, x, f)| format!("{g} X{} F{}\n", grid(*x), f * 100)).collect();
        let program = program(&(text + "M30\n"));
        for (i, mv) in program.moves.iter().enumerate() {
            let next = program.moves.get(i + 1);
            let limit = next.filter(|n| !n.rapid && !mv.rapid).map_or(0.0, |n| n.vl.min(mv.vl));
            prop_assert!(mv.tvl >= 0.0 && mv.tvl <= limit);
        }
    }
}

/// Small limits, so that a loop that a fuzzer finds does not take minutes.
fn careful(profile: Profile) -> Options {
    let limits = Limits { blocks: 2000, commands: 20_000, ..Limits::default() };
    Options { profile: Some(profile), limits, ..Options::default() }
}

fn survives(source: &[u8]) -> Result<(), TestCaseError> {
    for profile in [Profile::Din, Profile::Fanuc, Profile::Linuxcnc, Profile::Lathe] {
        let mut machine = mill3();
        machine.gcode.tools[0].radius = 1.5;
        let compiled = compile(source, "f.nc", &machine, &careful(profile));
        prop_assert!(compiled.diagnostics.len() <= 601);
        prop_assert_eq!(compiled.program.is_none(), compiled.has_errors());
        for d in &compiled.diagnostics {
            prop_assert!(d.line >= 1 && d.column >= 1 && d.end_column >= d.column, "{}", d);
        }
        if let Some(program) = &compiled.program {
            for mv in &program.moves {
                prop_assert!(program.targets_of(mv).iter().all(|v| v.is_finite()));
                prop_assert!(mv.vl > 0.0 && mv.vl.is_finite() && mv.ac > 0.0 && mv.phi.is_finite());
            }
        }
    }
    Ok(())
}

const WORDS: &[&str] = &[
    "G0",
    "G1",
    "G2",
    "G3",
    "G4",
    "G10",
    "G17",
    "G18",
    "G19",
    "G20",
    "G21",
    "G28",
    "G41",
    "G43",
    "G51",
    "G51.1",
    "G50.1",
    "G52",
    "G53",
    "G54.1",
    "G61",
    "G64",
    "G68",
    "G69",
    "G73",
    "G80",
    "G81",
    "G83",
    "G90",
    "G91",
    "G90.1",
    "G92",
    "G92.2",
    "G93",
    "G95",
    "G96",
    "X1",
    "X-2.5",
    "Y3",
    "Z-1",
    "I1",
    "J-2",
    "K0",
    "R5",
    "R-3",
    "P1",
    "P2000",
    "Q1",
    "L2",
    "L1",
    "H1",
    "D1",
    "F100",
    "F0.1",
    "S500",
    "T1",
    "M0",
    "M1",
    "M3",
    "M6",
    "M8",
    "M98",
    "M99",
    "M30",
    "O5",
    "N10",
    "/",
    "%",
    "%L5",
    "#1=5",
    "X#1",
    "X[1+2]",
    "Y=2*3",
    "CI5=1",
    "CD7=2.5",
    "IF [1 EQ 1] GOTO 10",
    "WHILE [#1 LT 3] DO1",
    "END1",
    "GOTO 10",
    "(a)",
    "(MSG, b)",
    ";c",
    "write \"x\", CI5",
    "o1 sub",
    "o1 endsub",
    "o1 call",
    "o2 if [1]",
    "o2 endif",
    "o3 repeat [2]",
    "o3 endrepeat",
    "abc=1",
    "\n",
    "\n",
    "\n",
    "\n",
    "\r\n",
    "[",
    "]",
    "\"",
    "(",
    ")",
    "=",
    "99999999999",
    "\u{e4}",
    "\t",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]
    #[test]
    fn any_bytes_are_survived(source in prop::collection::vec(any::<u8>(), 0..600)) {
        survives(&source)?;
    }
    #[test]
    fn any_text_is_survived(source in "[ -~\n\t\u{80}-\u{2100}]{0,300}") {
        survives(source.as_bytes())?;
    }
    #[test]
    fn programs_of_known_words_are_survived(words in prop::collection::vec(prop::sample::select(WORDS), 0..80)) {
        survives(words.join(" ").as_bytes())?;
    }
}

/// Linear in time: a line of a megabyte, a file of brackets, a file of one letter.
#[test]
fn extreme_files_take_no_time() {
    let start = std::time::Instant::now();
    for text in ["[".repeat(1 << 20), "(".repeat(1 << 20), "X\n".repeat(1 << 19), "G1X1Y1\nX0Y0\n".repeat(1 << 15)] {
        let _ = compile(text.as_bytes(), "f.nc", &mill3(), &Options::default());
    }
    let _ = program_for("G0 X1\nM30\n", &mill3(), &Options::default());
    assert!(start.elapsed().as_secs() < 20);
}
