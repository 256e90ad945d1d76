//! Radius correction against an independent measure: the distance of the tool centre from the programmed contour.

mod common;

use common::{Command, commands, ends, motions};
use gcode::{Compiled, Options, compile};
use motion_kernel::machine::Machine;
use proptest::prelude::*;

fn mill(radius: f64) -> Machine {
    let mut machine = common::mill3();
    machine.gcode.tools[0].radius = radius;
    machine
}
fn run(text: &str, radius: f64) -> Compiled {
    compile(text.as_bytes(), "t.nc", &mill(radius), &Options::default())
}
fn path(text: &str, radius: f64) -> Vec<Vec<f64>> {
    let compiled = run(text, radius);
    assert!(!compiled.has_errors(), "{:?}\n{text}", compiled.diagnostics);
    ends(&compiled.program.expect("no error"))
}
fn assert_path(found: &[Vec<f64>], want: &[[f64; 2]]) {
    let near = |f: &Vec<f64>, w: &[f64; 2]| (f[0] - w[0]).abs() < 1e-9 && (f[1] - w[1]).abs() < 1e-9;
    assert!(found.len() == want.len() && found.iter().zip(want).all(|(f, w)| near(f, w)), "{found:?}");
}

#[test]
fn inside_a_square_corners_are_cut_short() {
    // counter-clockwise, tool left = inside
    let text = "G0 X20 Y10\nG41 D1 G1 X20 Y0 F600\nX40\nY40\nX0\nY0\nX20\nG40 Y10\nM30\n";
    let want =
        [[20.0, 10.0], [20.0, 2.0], [38.0, 2.0], [38.0, 38.0], [2.0, 38.0], [2.0, 2.0], [20.0, 2.0], [20.0, 10.0]];
    assert_path(&path(text, 2.0), &want);
}

#[test]
fn outside_a_square_corners_are_rounded() {
    let text = "G0 X20 Y-20\nG42 D1 G1 X20 Y0 F600\nX40\nY40\nX20\nG40 Y60\nM30\n";
    let want = [
        [20.0, -20.0],
        [20.0, -2.0],
        [40.0, -2.0],
        [42.0, 0.0],
        [42.0, 40.0],
        [40.0, 42.0],
        [20.0, 42.0],
        [20.0, 60.0],
    ];
    assert_path(&path(text, 2.0), &want);
    let program = run(text, 2.0).program.unwrap();
    let arcs: Vec<f64> = program.moves.iter().filter(|m| !m.kind.is_linear()).map(|m| m.phi).collect();
    assert_eq!(arcs, [90.0, 90.0]);
}

#[test]
fn arcs_change_their_radius() {
    let text = "G0 X30\nG41 D1 G1 X20 F600\nG3 X0 Y20 I-20\nG3 X-20 Y0 J-20\nG40 G1 X-30\nM30\n";
    let program = run(text, 5.0).program.expect("no error");
    let found = motions(&program);
    let Command::Arc { center, phi, to, .. } = &found[2] else { panic!("{found:?}") };
    assert!((phi - 90.0).abs() < 1e-9 && center[0].abs() < 1e-9 && (to[1] - 15.0).abs() < 1e-9, "{found:?}");
    assert_eq!(run(text, 25.0).diagnostics[0].id, "GC420");
}

#[test]
fn the_mirrored_contour_has_the_tool_on_the_mirrored_side() {
    let text = "G0 X20 Y10\nG41 D1 G1 X20 Y0 F600\nX40\nY40\nG40 X0\nM30\n";
    let plain = path(text, 2.0);
    let mirrored = path(&format!("G51.1 X0\n{text}"), 2.0);
    assert!(plain.iter().zip(&mirrored).all(|(p, m)| (p[0] + m[0]).abs() < 1e-9 && (p[1] - m[1]).abs() < 1e-9));
}

#[test]
fn what_stands_between_blocks_stays_there() {
    let text = "G0 X20 Y10\nG41 D1 G1 X20 Y0 F600\nX40\nM8\nZ-2\nG4 P100\nY40\nG40 X0\nM30\n";
    let compiled = run(text, 2.0);
    let program = compiled.program.expect("no error");
    let kinds: Vec<String> = commands(&program)
        .iter()
        .map(|c| match c {
            Command::Line { to, .. } => format!("{:.0} {:.0} {:.0}", to[0], to[1], to[2]),
            Command::Ssf { command, .. } => format!("ssf {command}"),
            _ => String::new(),
        })
        .filter(|t| !t.is_empty())
        .collect();
    assert_eq!(kinds[..7], ["20 10 0", "20 2 0", "38 2 0", "ssf 1001", "38 2 -2", "ssf 1003", "38 40 -2"]);
    // the dwell stops the path
    assert_eq!(program.moves[3].tvl, 0.0);
}

#[test]
fn gouges_and_wrong_places_are_errors() {
    let id = |text: &str, radius: f64| {
        let compiled = run(text, radius);
        compiled.diagnostics.iter().find(|d| !d.is_warning()).map(|d| (d.id, d.line))
    };
    let lead = "G0 X20 Y10\nG41 D1 G1 X20 Y0 F600\n";
    // a slot of 6 mm, tool of 8 mm
    assert_eq!(id(&format!("{lead}X40\nY6\nX0\nG40 Y10\nM30\n"), 4.0), Some(("GC421", 5)));
    assert_eq!(id(&format!("{lead}X40\nX10\nG40 Y10\nM30\n"), 4.0), Some(("GC422", 4)));
    assert_eq!(id(&format!("{lead}G54\nM30\n"), 4.0), Some(("GC419", 3)));
    assert_eq!(id(&format!("{lead}G18\nM30\n"), 4.0), Some(("GC419", 3)));
    assert_eq!(id("G41 D1\nG2 X10 I5 F600\nM30\n", 4.0), Some(("GC419", 2)));
    assert_eq!(id("G0 X-598\nG41 D1 G1 Y10 F600\nY50\nM30\n", 4.0), Some(("GC413", 3)));
    assert_eq!(id("G41 D99 G1 X5 F600\nM30\n", 4.0), Some(("GC509", 1)));
}

/// Two spikes face each other with a gap of 6 mm: no element is too short, the tool still does not fit.
#[test]
fn a_bottleneck_between_elements_far_apart_is_found() {
    let neck = "G0 X5 Y20\nG41 D1 G1 X0 Y20 F600\nY0\nX18\nX20 Y17\nX22 Y0\nX40\nY40\nX22\nX20 Y23\nX18 Y40\nX0\nY20\n\
        G40 X5\nM30\n";
    assert!(!run(neck, 2.9).has_errors(), "{:?}", run(neck, 2.9).diagnostics);
    let found = run(neck, 3.05).diagnostics;
    assert_eq!((found[0].id, found[0].line), ("GC421", 10), "{found:?}");
}

/// A pocket with an arc onto and an arc off the wall: at the other end of the contour the tool passes over them.
#[test]
fn arcs_onto_and_off_the_contour_are_no_gouge() {
    let pocket =
        "G0 X20 Y4\nG41 D1 G1 X17 Y3 F600\nG3 X20 Y0 I3\nG1 X40\nY20\nX0\nY0\nX20\nG3 X23 Y3 J3\nG40 G1 X20 Y4\nM30\n";
    assert!(!run(pocket, 2.0).has_errors(), "{:?}", run(pocket, 2.0).diagnostics);
    // the same arc in the middle of a contour is one: the tool comes back too near to it
    let bay = "G0 X20 Y4\nG41 D1 G1 X10 Y0 F600\nX17\nG3 X20 Y3 J3\nG1 Y5\nX16\nY3\nG40 X0\nM30\n";
    assert_eq!(run(bay, 2.5).diagnostics[0].id, "GC421");
}

// --- random contours ---

type Point = [f64; 2];

#[derive(Clone, Copy, Debug)]
struct Edge {
    a: Point,
    b: Point,
    /// Centre and sweep in radians.
    arc: Option<(Point, f64)>,
}

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}
fn norm(a: Point) -> f64 {
    a[0].hypot(a[1])
}

impl Edge {
    fn at(&self, t: f64) -> Point {
        match self.arc {
            None => [self.a[0] + t * (self.b[0] - self.a[0]), self.a[1] + t * (self.b[1] - self.a[1])],
            Some((c, sweep)) => {
                let (v, (sin, cos)) = (sub(self.a, c), (t * sweep).sin_cos());
                [c[0] + v[0] * cos - v[1] * sin, c[1] + v[0] * sin + v[1] * cos]
            }
        }
    }
    fn distance(&self, p: Point) -> f64 {
        let ends = norm(sub(p, self.a)).min(norm(sub(p, self.b)));
        match self.arc {
            None => {
                let (d, v) = (sub(self.b, self.a), sub(p, self.a));
                let t = (d[0] * v[0] + d[1] * v[1]) / (d[0] * d[0] + d[1] * d[1]);
                if (0.0..=1.0).contains(&t) { norm(sub(p, self.at(t))) } else { ends }
            }
            Some((c, sweep)) => {
                let (u, v) = (sub(self.a, c), sub(p, c));
                let angle = (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]);
                let turned = if sweep > 0.0 {
                    angle.rem_euclid(std::f64::consts::TAU)
                } else {
                    (-angle).rem_euclid(std::f64::consts::TAU)
                };
                if turned <= sweep.abs() { (norm(v) - norm(u)).abs() } else { ends }
            }
        }
    }
    /// Unit normal to the left.
    fn left(&self, t: f64) -> Point {
        let d = match self.arc {
            None => sub(self.b, self.a),
            Some((c, sweep)) => {
                let v = sub(self.at(t), c);
                [-v[1] * sweep.signum(), v[0] * sweep.signum()]
            }
        };
        [-d[1] / norm(d), d[0] / norm(d)]
    }
    fn text(&self) -> String {
        match self.arc {
            None => format!("G1 X{:.9} Y{:.9}\n", self.b[0], self.b[1]),
            Some((c, sweep)) => {
                let (g, v) = (if sweep > 0.0 { 3 } else { 2 }, sub(c, self.a));
                format!("G{g} X{:.9} Y{:.9} I{:.9} J{:.9}\n", self.b[0], self.b[1], v[0], v[1])
            }
        }
    }
}

/// A closed contour about the origin: corners at rising angles, some edges bent to arcs.
fn contour(corners: &[(f64, f64, i8)], clockwise: bool) -> Vec<Edge> {
    let n = corners.len();
    let mut points: Vec<(Point, i8)> = corners
        .iter()
        .enumerate()
        .map(|(i, (shift, radius, bend))| {
            let angle = std::f64::consts::TAU * (i as f64 + shift) / n as f64;
            ([radius * angle.cos(), radius * angle.sin()], *bend)
        })
        .collect();
    if clockwise {
        points.reverse();
    }
    let edge = |i: usize| {
        let ((a, bend), (b, _)) = (points[i], points[(i + 1) % n]);
        let (chord, sign) = (sub(b, a), if bend > 0 { 1.0 } else { -1.0 });
        let arc = (bend != 0).then(|| {
            // sweeps of 20 to 80 degrees
            let sweep = f64::from(bend.abs()) * 20f64.to_radians();
            let height = 0.5 * norm(chord) / (0.5 * sweep).tan();
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let normal = [-chord[1] / norm(chord), chord[0] / norm(chord)];
            ([middle[0] + sign * height * normal[0], middle[1] + sign * height * normal[1]], sign * sweep)
        });
        Edge { a, b, arc }
    };
    (0..n).map(edge).collect()
}

/// Lead in and out on the middle of a straight first edge.
fn program(edges: &[Edge], left: bool, radius: f64) -> String {
    let start = edges[0].at(0.5);
    let n = edges[0].left(0.5);
    let side = if left { 2.0 * radius } else { -2.0 * radius };
    let beside = [start[0] + side * n[0], start[1] + side * n[1]];
    let go = |p: Point| format!("X{:.9} Y{:.9}", p[0], p[1]);
    let mut text = format!("G0 {}\n{} D1 G1 {} F3000\n", go(beside), if left { "G41" } else { "G42" }, go(start));
    text += &edges.iter().map(Edge::text).collect::<String>();
    text + &format!("G1 {}\nG40 {}\nM30\n", go(start), go(beside))
}

/// No corner folds back by more than 140 degrees: there, bent edges may cross each other.
fn is_decent(edges: &[Edge]) -> bool {
    (0..edges.len()).all(|i| {
        let (u, v) = (edges[i].left(1.0), edges[(i + 1) % edges.len()].left(0.0));
        u[0] * v[0] + u[1] * v[1] > 140f64.to_radians().cos()
    })
}

/// Is there really a place where the tool does not fit? `Some(true)`: surely, `Some(false)`: surely not.
fn gouges(edges: &[Edge], left: bool, radius: f64) -> Option<bool> {
    let n = edges.len();
    let mut doubtful = false;
    for (i, edge) in edges.iter().enumerate() {
        let mut reached = 0;
        for k in 0..=80 {
            let t = f64::from(k) / 80.0;
            let (p, normal) = (edge.at(t), edge.left(t));
            let side = if left { radius } else { -radius };
            let centre = [p[0] + side * normal[0], p[1] + side * normal[1]];
            let nearest = |adjacent: bool| {
                let others = edges.iter().enumerate().filter(|(j, _)| {
                    let near = *j == i || *j == (i + 1) % n || (*j + 1) % n == i;
                    near == adjacent
                });
                others.map(|(_, e)| e.distance(centre)).fold(f64::INFINITY, f64::min)
            };
            if nearest(false) < radius - 0.01 && nearest(true) > radius - 1e-6 {
                return Some(true);
            }
            doubtful |= nearest(false) < radius + 0.2;
            reached += usize::from(nearest(true) > radius - 1e-6);
        }
        if reached == 0 {
            return Some(true);
        }
        doubtful |= reached < 6;
    }
    if doubtful { None } else { Some(false) }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, max_global_rejects: 100_000, ..ProptestConfig::default() })]
    #[test]
    fn the_tool_keeps_its_distance(
        corners in prop::collection::vec((0.0..0.6f64, 25.0..80.0f64, -3..4i8), 4..10),
        clockwise: bool, left: bool, radius in 0.5..6.0f64,
    ) {
        let mut edges = contour(&corners, clockwise);
        edges[0].arc = None;
        prop_assume!(is_decent(&edges));
        let text = program(&edges, left, radius);
        let compiled = run(&text, radius);
        let errors: Vec<&str> = compiled.diagnostics.iter().filter(|d| !d.is_warning()).map(|d| d.id).collect();
        let real = gouges(&edges, left, radius);
        if !errors.is_empty() {
            prop_assert!(errors.iter().all(|id| ["GC420", "GC421", "GC422"].contains(id)), "{:?}", errors);
            prop_assert!(real != Some(false), "a gouge was invented: {:?}\n{}", errors, text);
            return Ok(());
        }
        prop_assert!(real != Some(true), "a gouge was missed\n{}", text);
        let program = compiled.program.unwrap();
        let all = ends(&program);
        // all but the approach (2 moves) and the departure
        for i in 2..program.moves.len() - 1 {
            let mv = &program.moves[i];
            let (a, b) = ([all[i - 1][0], all[i - 1][1]], [all[i][0], all[i][1]]);
            let arc = (!mv.kind.is_linear()).then(|| (mv.center, mv.phi.to_radians()));
            let piece = Edge { a, b, arc };
            for k in 0..=10 {
                let p = piece.at(f64::from(k) / 10.0);
                let d = edges.iter().map(|e| e.distance(p)).fold(f64::INFINITY, f64::min);
                prop_assert!((d - radius).abs() < 1e-6, "{} at {:?}, radius {}\n{}", d, p, radius, text);
            }
        }
    }
}
