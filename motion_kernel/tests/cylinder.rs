//! A contour mapped through effradius (2.3.4): lines, arcs and helices of X and C lie on the cylinder in space, where and
//! as fast as they are programmed, in both settings of MODEREG RotatoricUnit.

mod common;

use common::*;
use motion_kernel::autocode::MoveKind::{Smca, Smha, Smla};
use motion_kernel::axes::AxisList;
use motion_kernel::registers::ModeReg;
use motion_kernel::trace::Trace;
use std::f64::consts::PI;

const TRANSLATORY: ModeReg = ModeReg(1 << 8);
const ROTATORIC: ModeReg = ModeReg(1 << 8 | 1 << 10);
const RADIUS: f64 = 17.5;
const VL: f64 = 25.0;
const AC: f64 = 400.0;

/// A curve on the unrolled surface: (along the cylinder, around it) in mm, over the path length.
struct Unrolled {
    start: [f64; 2],
    /// Centre and signed angle in radians; None: a line to `end`.
    turn: Option<([f64; 2], f64)>,
    end: [f64; 2],
    /// Travel of a further linear axis.
    deep: f64,
}

impl Unrolled {
    fn length(&self) -> f64 {
        let flat = match self.turn {
            Some((c, angle)) => (self.start[0] - c[0]).hypot(self.start[1] - c[1]) * angle.abs(),
            None => (self.end[0] - self.start[0]).hypot(self.end[1] - self.start[1]),
        };
        flat.hypot(self.deep)
    }
    fn at(&self, s: f64) -> [f64; 2] {
        let share = s / self.length();
        let Some((c, angle)) = self.turn else {
            return std::array::from_fn(|i| self.start[i] + share * (self.end[i] - self.start[i]));
        };
        let (x, y) = (self.start[0] - c[0], self.start[1] - c[1]);
        let (r, from) = (x.hypot(y), y.atan2(x));
        [c[0] + r * (from + share * angle).cos(), c[1] + r * (from + share * angle).sin()]
    }
}

/// Rolled up: a point of the cylinder around the x axis, with the surface at `RADIUS + deep`.
fn in_space(x: f64, around_rad: f64, deep: f64) -> [f64; 3] {
    [x, (RADIUS + deep) * around_rad.sin(), (RADIUS + deep) * around_rad.cos()]
}
fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Path length of a trapezoid from standstill to standstill, in closed form.
fn travelled(t: f64, length: f64) -> f64 {
    let v = VL.min((AC * length).sqrt());
    let (ramp, end) = (v / AC, length / v + v / AC);
    let t = t.min(end);
    let cruise = v * (t - ramp) + 0.5 * v * ramp;
    if t < ramp {
        0.5 * AC * t * t
    } else if t < end - ramp {
        cruise
    } else {
        length - 0.5 * AC * (end - t).powi(2)
    }
}

/// The contour in the units of `mode`: each curve from standstill to standstill.
fn driven(mode: ModeReg, curves: &[Unrolled]) -> Trace {
    let mut machine = machine("XCU");
    machine.axes[1].effradius = RADIUS;
    let mut m = mcu_of(machine, mode);
    let around = |mm: f64| if mode == ROTATORIC { mm / RADIUS * 180.0 / PI } else { mm };
    for curve in curves {
        let axes = AxisList::new(if curve.deep == 0.0 { &[0, 1] } else { &[0, 1, 2] });
        let targets = [curve.end[0], around(curve.end[1]), curve.deep];
        let (center, phi) = curve.turn.map_or(([0.0; 2], 0.0), |(c, angle)| ([c[0], around(c[1])], angle.to_degrees()));
        let kind = match curve.turn {
            None => Smla,
            Some(_) if curve.deep == 0.0 => Smca,
            Some(_) => Smha,
        };
        spool(&mut m, kind, &axes, &targets[..axes.len()], center, phi, [VL, AC, 0.0]);
    }
    run(&mut m)
}

/// Every set point against the programmed curve in space, and the speed between samples on the surface.
fn check(mode: ModeReg, curves: &[Unrolled]) {
    let trace = driven(mode, curves);
    let durations: Vec<f64> = curves
        .iter()
        .map(|c| {
            let v = VL.min((AC * c.length()).sqrt());
            c.length() / v + v / AC
        })
        .collect();
    let mut cruising = 0;
    let mut before: Option<(usize, f64, [f64; 3])> = None;
    for (k, row) in trace.dp.chunks(3).enumerate() {
        let mut t = (k + 1) as f64 * TA;
        let mut n = 0;
        while n + 1 < curves.len() && t > durations[n] {
            t -= durations[n];
            n += 1;
        }
        let curve = &curves[n];
        let s = travelled(t, curve.length());
        let [x, around] = curve.at(s);
        let deep = curve.deep * s / curve.length();
        let (want, have) = (in_space(x, around / RADIUS, deep), in_space(row[0], row[1].to_radians(), row[2]));
        assert!(apart(want, have) <= 1e-9, "sample {k} is {:e} mm off the curve in space", apart(want, have));
        close(have[1].hypot(have[2]), RADIUS + deep, 1e-9);
        // on the surface a sample of cruising is VL * TA long: the chord, on an arc that is curved twice
        if let Some((same, from, last)) = before
            && same == n
            && curve.deep == 0.0
            && travelled(t + TA, curve.length()) - from >= (2.0 - 1e-9) * VL * TA
        {
            let bend = 1.0 / RADIUS
                + curve.turn.map_or(0.0, |(c, _)| 1.0 / (curve.start[0] - c[0]).hypot(curve.start[1] - c[1]));
            let (chord, arc) = (apart(last, have), VL * TA);
            assert!(
                chord <= arc + 1e-12 && chord >= arc * (1.0 - (bend * arc).powi(2) / 24.0) - 1e-12,
                "sample {k}: {chord}"
            );
            cruising += 1;
        }
        before = Some((n, s, have));
    }
    assert!(cruising > trace.len() / 4, "most of the way is at the programmed velocity: {cruising} of {}", trace.len());
}

/// A contour as G2 and G3 make it: line, quarter turns both ways, most of a circle, once around the cylinder.
fn contour() -> Vec<Unrolled> {
    let quarter = 0.5 * PI;
    let line = |start, end| Unrolled { start, turn: None, end, deep: 0.0 };
    let arc = |start: [f64; 2], center: [f64; 2], angle: f64| {
        let (x, y) = (start[0] - center[0], start[1] - center[1]);
        let (sin, cos) = angle.sin_cos();
        let end = [center[0] + x * cos - y * sin, center[1] + x * sin + y * cos];
        Unrolled { start, turn: Some((center, angle)), end, deep: 0.0 }
    };
    let mut contour = vec![line([0.0, 0.0], [20.0, 8.0])];
    for (to_center, angle) in [([0.0, 6.0], quarter), ([9.0, 0.0], -quarter), ([4.0, 3.0], 5.0), ([-3.0, 12.0], -7.0)] {
        let start = contour[contour.len() - 1].end;
        contour.push(arc(start, [start[0] + to_center[0], start[1] + to_center[1]], angle));
    }
    let start = contour[contour.len() - 1].end;
    contour.push(line(start, [start[0] - 3.0, start[1] + 2.0 * PI * RADIUS]));
    contour
}

// shows: interp.effradius.all-kinds, interp.effradius.conversion
#[test]
fn a_contour_lies_on_the_cylinder_at_the_programmed_speed() {
    for mode in [TRANSLATORY, ROTATORIC] {
        check(mode, &contour());
    }
}

#[test]
fn both_settings_of_rotatoric_unit_drive_the_same() {
    let (mm, degrees) = (driven(TRANSLATORY, &contour()), driven(ROTATORIC, &contour()));
    assert_eq!(mm.len(), degrees.len());
    for (a, b) in mm.dp.iter().zip(&degrees.dp) {
        close(*a, *b, 1e-9);
    }
}

/// A helix of X and C with a linear axis that goes deeper: its feed is that of all three (design D15).
#[test]
fn a_helix_on_the_cylinder_goes_deeper_evenly() {
    let helix = |deep| Unrolled { start: [0.0, 0.0], turn: Some(([6.0, 2.0], 9.0)), end: [0.0, 0.0], deep };
    for mode in [TRANSLATORY, ROTATORIC] {
        let trace = driven(mode, &[helix(-4.0)]);
        let length = helix(-4.0).length();
        close(length, (6.0f64.hypot(2.0) * 9.0).hypot(4.0), 1e-9);
        for (k, row) in trace.dp.chunks(3).enumerate() {
            let s = travelled((k + 1) as f64 * TA, length);
            let [x, around] = helix(-4.0).at(s);
            let want = in_space(x, around / RADIUS, -4.0 * s / length);
            assert!(apart(want, in_space(row[0], row[1].to_radians(), row[2])) <= 1e-9, "sample {k}");
        }
    }
}
