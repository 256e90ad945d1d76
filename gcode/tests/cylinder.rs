//! Cylinder surface G07.1 (docs/dialect.md, section 11).

mod common;

use std::f64::consts::PI;
use std::sync::Arc;

use common::{example, program_for};
use gcode::{Options, compile, listing_json, sequence};
use motion_kernel::Mcu;
use motion_kernel::autocode::{Instr, MoveKind, Program};
use motion_kernel::machine::Machine;
use motion_kernel::registers::{ErrorReg, ModeReg};
use motion_kernel::trace::Trace;
use proptest::prelude::*;

fn mill4c() -> Machine {
    example("mill4c")
}
fn program(text: &str) -> Program {
    program_for(text, &mill4c(), &Options::default())
}
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs().max(1.0)
}

/// Set points (X Y Z C) of every sample.
fn run(text: &str, machine: &Machine) -> Vec<[f64; 4]> {
    let program = Arc::new(program_for(text, machine, &Options::default()));
    let mut mcu = Mcu::new(Arc::new(machine.clone()));
    mcu.prepare_gcode();
    mcu.load(0, program);
    mcu.startcnct(0);
    let mut trace = Trace::new(4, 1 << 16);
    mcu.advance(1 << 16, &mut trace);
    assert_eq!(mcu.errorreg(), ErrorReg(0), "{:?}", mcu.errorreg().names().collect::<Vec<_>>());
    trace.dp.chunks(4).map(|row| [row[0], row[1], row[2], row[3]]).collect()
}

#[test]
fn lines_and_arcs_on_the_surface() {
    // 20 mm: a degree is 0.349 mm; the arc about (0, 10) goes from (0, 0) to (10, 10) on the surface
    let quarter = 10.0_f64.to_degrees() / 20.0;
    let text = format!(
        "G07.1 C20\nG1 C90 Z0 F600\nC0\nG3 C{quarter:.12} Z10 R10\nG2 C{quarter:.12} K5 J0\nG7.1 C0\nG1 C9 F600\nM30\n"
    );
    let program = program(&text);
    let radii: Vec<f64> = program
        .code
        .windows(2)
        .filter_map(|w| match (w[0], w[1]) {
            (Instr::Number(n), Instr::EffRadius(3)) => Some(program.numbers[n as usize]),
            _ => None,
        })
        .collect();
    assert_eq!(radii, [20.0, 180.0 / PI]);
    let [line, _, arc, full, ..] = &program.moves[..] else { panic!("{:?}", program.moves) };
    assert!(close(line.vl, 10.0) && program.targets_of(line) == [0.0, 0.0, 0.0, 90.0]);
    assert_eq!((arc.kind, program.axes_of(arc).iter().collect::<Vec<_>>()), (MoveKind::Smha, vec![3, 2, 0, 1]));
    assert!(
        close(arc.center[0], 0.0) && close(arc.center[1], 10.0) && close(arc.phi, 90.0) && close(arc.vl, 10.0),
        "{arc:?}"
    );
    assert!(close(full.center[0], quarter) && close(full.center[1], 15.0) && full.phi == -360.0, "{full:?}");
    // off: rotary only, degrees a minute
    assert!(close(program.moves[4].vl, 10.0));
    // each change waits until the motion before it is done
    let drained = |i: usize| matches!(program.code[i - 2], Instr::Drain(_));
    assert!((0..program.code.len()).filter(|&i| matches!(program.code[i], Instr::EffRadius(_))).all(drained));
}

#[test]
fn the_sequence_and_the_listing_name_the_radius_of_each_move() {
    let text = "G1 C10 F600\nG07.1 C20\nC20\nG07.1 C30\nC30\nG07.1 C0\nC40\nM30\n";
    for rotatoric in [true, false] {
        let mut machine = mill4c();
        if !rotatoric {
            machine.gcode.modereg &= !ModeReg::RotatoricUnit.0;
        }
        let program = program_for(text, &machine, &Options::default());
        let columns = sequence(&program, &machine);
        let radius = |i: usize| columns.effradius[usize::from(columns.effradius_of[i]) * 4 + 3];
        let shown: Vec<f64> = (0..4).map(radius).collect();
        let own = machine.axes[3].effradius;
        assert_eq!(shown, [own, 20.0, 30.0, own]);
        let ends: Vec<f64> = columns.target.chunks(4).map(|row| row[3]).collect();
        assert!(ends.iter().zip([10.0, 20.0, 30.0, 40.0]).all(|(a, b)| close(*a, b)), "{ends:?}");
        let lines: Vec<String> = listing_json(&program, &machine).filter(|l| l.contains("smla")).collect();
        assert!(lines[1].contains(r#""effradius":{"C":20.0}"#), "{}", lines[1]);
    }
}

#[test]
fn both_settings_of_rotatoric_unit_give_the_same_motion() {
    let text = "G0 Z5 C-30\nG07.1 C25\nG1 C90 Z-20 F1800\nG3 C120 Z-10 R40 X3\nG2 C60 Z-40 R70\nG1 C-10\nG07.1 C0\nG0 C0\nM30\n";
    let machine = mill4c();
    let mut other = mill4c();
    other.gcode.modereg &= !ModeReg::RotatoricUnit.0;
    let (one, two) = (run(text, &machine), run(text, &other));
    assert_eq!(one.len(), two.len());
    let worst = one.iter().flatten().zip(two.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst}");
    let far = one.iter().map(|p| p[3]).fold(0.0, f64::max);
    assert!(far > 100.0, "the axis turned: {far}");
}

#[test]
fn the_set_point_stays_on_the_unrolled_curve() {
    // centre: u = 0, z = 30
    let rows = run("G07.1 C25\nG3 C0 Z60 R30 F1800\nM30\n", &mill4c());
    let radius = |p: &[f64; 4]| (p[3].to_radians() * 25.0).hypot(p[2] - 30.0);
    let worst = rows.iter().map(|p| (radius(p) - 30.0).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst}");
    assert!(rows.iter().any(|p| p[3] > 60.0));
    // the surface speed is F
    let step = |w: &[[f64; 4]]| ((w[1][3] - w[0][3]).to_radians() * 25.0).hypot(w[1][2] - w[0][2]) / 0.00128;
    let fastest = rows.windows(2).map(step).fold(0.0, f64::max);
    assert!((fastest - 30.0).abs() < 1e-3, "{fastest}");
}

#[test]
fn a_smaller_radius_keeps_the_limits_of_the_axis_in_degrees() {
    // F asks for 286 degrees a second, the axis can do 120
    let rows = run("G07.1 C10\nG1 C360 F3000\nM30\n", &mill4c());
    let fastest = rows.windows(2).map(|w| (w[1][3] - w[0][3]) / 0.00128).fold(0.0, f64::max);
    assert!((fastest - 120.0).abs() < 1e-3, "{fastest}");
}

#[test]
fn what_has_no_meaning_on_the_surface() {
    let mut machine = mill4c();
    machine.gcode.tools[0].radius = 4.0;
    let found = |text: &str| {
        let compiled = compile(text.as_bytes(), "t.nc", &machine, &Options::default());
        let errors = compiled.diagnostics.into_iter().filter(|d| !d.is_warning());
        errors.map(|d| (d.id, d.line, d.column, d.end_column)).collect::<Vec<_>>()
    };
    for code in ["G41 D1", "G42 D1", "G28", "G30 P2", "G53", "G68 X0 Y0 R5", "G81 Z-5 R1 F100", "G18"] {
        let end = code.find(' ').unwrap_or(code.len()) as u32;
        assert_eq!(found(&format!("G07.1 C20\n{code}\nM30\n")), [("GC321", 2, 1, end)], "{code}");
    }
    assert_eq!(found("G68 X0 Y0 R5\nG07.1 C20\nM30\n"), [("GC321", 2, 1, 5)]);
    assert_eq!(found("G07.1 C-5\nM30\n"), [("GC414", 1, 7, 9)]);
    assert_eq!(found("G07.1\nM30\n"), [("GC327", 1, 1, 5)]);
    assert_eq!(found("G07.1 X5\nM30\n"), [("GC326", 1, 7, 8)]);
    assert_eq!(found("G107 C5 Z1\nM30\n"), [("GC326", 1, 9, 10)]);
    // a block with an error switches nothing
    assert_eq!(found("G107 C5 Q1\nG1 C10 F100\nG2 C20 R5\nM30\n"), [("GC326", 1, 9, 10), ("GC418", 3, 4, 6)]);
}

#[test]
fn the_extreme_of_an_arc_is_checked_in_degrees() {
    let mut machine = mill4c();
    machine.axes[3].limits =
        machine.axes[0].limits.map(|l| motion_kernel::machine::SoftwareLimits { left: -45.0, right: 45.0, ..l });
    let compiled = compile(b"G07.1 C20\nG3 C0 Z40 R20 F600\nM30\n", "t.nc", &machine, &Options::default());
    assert_eq!((compiled.diagnostics[0].id, compiled.diagnostics[0].line), ("GC413", 2));
    assert!(compiled.diagnostics[0].message.contains("57.2958"), "{}", compiled.diagnostics[0].message);
}

proptest! {
    /// An arc on the surface is the arc of the plane with u = radius * angle, in the R and in the centre form.
    #[test]
    fn the_surface_is_the_plane_unrolled(
        radius in 5.0..200.0f64, r in 2.0..80.0f64, from in 0.0..360.0f64, sweep in 1.0..359.0f64, clockwise: bool,
    ) {
        prop_assume!((sweep - 180.0).abs() > 1.0);
        let to = from + if clockwise { -sweep } else { sweep };
        let at = |angle: f64| (r * angle.to_radians().cos(), r * angle.to_radians().sin());
        let (s, e) = (at(from), at(to));
        let degrees = |u: f64| u / radius.to_radians();
        let g = if clockwise { "G2" } else { "G3" };
        let signed = if sweep > 180.0 { -r } else { r };
        let start = format!("G0 C{:.12} Z{:.12}\nG07.1 C{radius:.12}\n", degrees(s.0), s.1);
        let end = format!("{g} C{:.12} Z{:.12} F600", degrees(e.0), e.1);
        let by_radius = program(&format!("{start}{end} R{signed:.12}\nM30\n"));
        let by_centre = program(&format!("{start}{end} J{:.12} K{:.12}\nM30\n", -s.0, -s.1));
        let absolute = program(&format!("{start}G90.1\n{end} J0 K0\nM30\n"));
        let plane = program(&format!("G0 X{:.12} Y{:.12}\n{g} X{:.12} Y{:.12} R{signed:.12} F600\nM30\n", s.0, s.1, e.0, e.1));
        let want = plane.moves.last().expect("an arc");
        for found in [&by_radius, &by_centre, &absolute] {
            let arc = found.moves.last().expect("an arc");
            prop_assert!((arc.phi - want.phi).abs() < 1e-6, "{} {}", arc.phi, want.phi);
            prop_assert!((arc.center[0] * radius.to_radians() - want.center[0]).abs() < 1e-6);
            prop_assert!((arc.center[1] - want.center[1]).abs() < 1e-6 && (arc.vl - want.vl).abs() < 1e-9);
        }
    }
}

#[test]
fn tangents_are_those_of_the_surface() {
    let mut machine = mill4c();
    machine.gcode.dialect.corner_angle = Some(1.0);
    let tvl = |text: &str| -> Vec<f64> {
        program_for(text, &machine, &Options::default()).moves.iter().map(|m| m.tvl).collect()
    };
    // along the circumference, a quarter of radius 10 turns into the axis, on along the axis
    let (one, two) = (10f64.to_degrees() / 25.0, 20f64.to_degrees() / 25.0);
    let smooth = format!("G07.1 C25\nG1 C{one:.12} F600\nG3 C{two:.12} Z10 R10\nG1 Z20\nM30\n");
    assert_eq!(tvl(&smooth), [10.0, 10.0, 0.0]);
    // the same arc clockwise meets the line at a right angle
    let sharp = format!("G07.1 C25\nG1 C{one:.12} F600\nG2 C{two:.12} Z10 R10\nG1 Z20\nM30\n");
    assert_eq!(tvl(&sharp), [0.0, 0.0, 0.0]);
}

#[test]
fn merged_points_on_the_surface_are_degrees_in_both_settings() {
    let steps: String = (1..=40).map(|i| format!("C{:.3}\n", 0.05 * f64::from(i))).collect();
    let text = format!("G07.1 C25\nG1 F3000\n{steps}M30\n");
    for clear in [0, ModeReg::RotatoricUnit.0] {
        let mut machine = mill4c();
        machine.gcode.modereg &= !clear;
        let program = program_for(&text, &machine, &Options::default());
        let columns = sequence(&program, &machine);
        let mut points: Vec<f64> =
            columns.target.iter().chain(&columns.via_target).skip(3).step_by(4).copied().collect();
        points.sort_by(f64::total_cmp);
        assert!(program.moves.len() < 20 && points.len() == 40);
        assert!(points.iter().zip(1..).all(|(p, i)| close(*p, 0.05 * f64::from(i))), "{points:?}");
    }
}

#[test]
fn each_rotary_axis_has_its_plane_and_letters() {
    // centre 10 mm along the linear axis, 5 mm along the surface
    for (name, rotary, linear, along, across) in
        [("mill4a", 'A', 'X', 'I', 'J'), ("mill4b", 'B', 'Y', 'J', 'I'), ("mill4c", 'C', 'Z', 'K', 'J')]
    {
        let text = format!("G07.1 {rotary}20\nG3 {rotary}0 {linear}0 {along}10 {across}5 F600\nM30\n");
        let machine = example(name);
        let program = program_for(&text, &machine, &Options::default());
        let arc = &program.moves[0];
        let names: Vec<&str> = program.axes_of(arc).iter().map(|a| machine.axes[a].name.as_str()).collect();
        assert_eq!(names[..2], [rotary.to_string(), linear.to_string()], "{name}");
        assert!(close(arc.center[0], 5f64.to_degrees() / 20.0) && close(arc.center[1], 10.0), "{name} {arc:?}");
        assert_eq!(arc.phi, 360.0);
    }
}
