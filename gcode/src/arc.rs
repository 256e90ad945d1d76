//! Circles in their plane (docs/dialect.md, section 7): pure geometry in mm, ordered axes (first, second).

use std::f64::consts::PI;

use crate::diagnostics::{Check, Fault, Id, Span};

type Vector = [f64; 2];

/// An arc from a known start: centre, signed sweep in degrees (counter-clockwise positive), end point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    pub centre: Vector,
    pub sweep: f64,
    pub radius: f64,
    pub end: Vector,
}

/// What the block says apart from centre or radius.
#[derive(Clone, Copy, Debug)]
pub struct Ends {
    pub start: Vector,
    pub end: Vector,
    pub counter_clockwise: bool,
    /// Whole turns, at least 1.
    pub turns: u32,
    pub span: Span,
}

const SAME: f64 = 0.0005;
const ACCEPTED: f64 = 0.005;
const SMALLEST: f64 = 1e-4;
const LARGEST: f64 = 1e7;

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}
fn length(v: Vector) -> f64 {
    v[0].hypot(v[1])
}

/// Radius difference that an arc may have before it is refused.
fn limit(radius: f64) -> f64 {
    (0.001 * radius).clamp(0.03, 0.5)
}

/// Signed sweep of less than a full turn, in degrees; a full turn where start and end fall together.
fn sweep(start: Vector, end: Vector, centre: Vector, counter_clockwise: bool) -> f64 {
    let (v0, v1) = (minus(start, centre), minus(end, centre));
    let angle = (v0[0] * v1[1] - v0[1] * v1[0]).atan2(v0[0] * v1[0] + v0[1] * v1[1]);
    let angle = match (counter_clockwise, angle > 0.0, angle < 0.0) {
        (true, false, _) => angle + 2.0 * PI,
        (false, _, false) => angle - 2.0 * PI,
        _ => angle,
    };
    angle.to_degrees()
}

fn with_turns(sweep: f64, turns: u32) -> f64 {
    sweep + 360.0 * f64::from(turns - 1).copysign(sweep)
}

fn check_radius(radius: f64, span: Span) -> Check<()> {
    if radius < SMALLEST {
        return Err(Fault::new(Id::GC402, span));
    }
    if radius > LARGEST { Err(Fault::with(Id::GC409, span, &[&radius])) } else { Ok(()) }
}

/// The arc with a programmed centre. `other` is the centre in the other centre mode, for the message.
pub fn by_centre(ends: &Ends, centre: Vector, other: Vector, warnings: &mut Vec<Fault>) -> Check<Arc> {
    let (r0, r1) = (length(minus(ends.start, centre)), length(minus(ends.end, centre)));
    check_radius(r0, ends.span)?;
    let gap = minus(ends.end, ends.start);
    if gap[0].abs() <= SAME && gap[1].abs() <= SAME {
        let full = if ends.counter_clockwise { 360.0 } else { -360.0 };
        return Ok(Arc { centre, sweep: with_turns(full, ends.turns), radius: r0, end: ends.start });
    }
    let (difference, radius) = ((r0 - r1).abs(), 0.5 * (r0 + r1));
    check_radius(radius, ends.span)?;
    if difference > limit(radius) {
        return Err(unequal(ends, (r0, r1), limit(radius), other));
    }
    if difference > ACCEPTED {
        warnings.push(Fault::with(Id::GW922, ends.span, &[&format!("{:.4}", difference / 2.0)]));
    }
    let centre = on_bisector(ends, centre);
    let once = sweep(ends.start, ends.end, centre, ends.counter_clockwise);
    if length(gap) <= ACCEPTED && radius > 1.0 && !(0.1..=350.0).contains(&once.abs()) {
        warnings.push(Fault::with(Id::GW921, ends.span, &[&format!("{once:.3}")]));
    }
    let radius = length(minus(ends.start, centre));
    Ok(Arc { centre, sweep: with_turns(once, ends.turns), radius, end: ends.end })
}

/// The nearest point to `centre` that has the same distance from start and end.
fn on_bisector(ends: &Ends, centre: Vector) -> Vector {
    let chord = minus(ends.end, ends.start);
    let middle = [0.5 * (ends.start[0] + ends.end[0]), 0.5 * (ends.start[1] + ends.end[1])];
    let offset = minus(centre, middle);
    let along = (offset[0] * chord[0] + offset[1] * chord[1]) / (chord[0] * chord[0] + chord[1] * chord[1]);
    [centre[0] - along * chord[0], centre[1] - along * chord[1]]
}

#[cold]
fn unequal(ends: &Ends, (r0, r1): (f64, f64), limit: f64, other: Vector) -> Fault {
    let (o0, o1) = (length(minus(ends.start, other)), length(minus(ends.end, other)));
    let fits = (o0 - o1).abs() <= self::limit(0.5 * (o0 + o1)) && o0 > SMALLEST;
    let hint = if fits { " (it would fit with the other arc centre mode, G90.1 / G91.1)" } else { "" };
    let text = |v: f64| format!("{v:.4}");
    let args: [&dyn std::fmt::Display; 5] = [&text(r0), &text(r1), &text((r0 - r1).abs()), &text(limit), &hint];
    Fault::with(Id::GC401, ends.span, &args)
}

/// The arc with a programmed radius; negative: more than a half circle. `word` is the place of R.
pub fn by_radius(ends: &Ends, radius: f64, word: Span, warnings: &mut Vec<Fault>) -> Check<Arc> {
    if radius == 0.0 {
        return Err(Fault::new(Id::GC411, word));
    }
    let chord = minus(ends.end, ends.start);
    if chord[0].abs() <= SAME && chord[1].abs() <= SAME {
        return Err(Fault::new(Id::GC408, ends.span));
    }
    let half = 0.5 * length(chord);
    let mut r = radius.abs();
    check_radius(r, ends.span)?;
    if r < half {
        if half - r > 0.005 + 0.0005 * half {
            let args: [&dyn std::fmt::Display; 2] = [&format!("{:.4}", 2.0 * half), &format!("{:.4}", 2.0 * r)];
            return Err(Fault::with(Id::GC410, ends.span, &args));
        }
        if half - r > 1e-9 {
            warnings.push(Fault::with(Id::GW923, word, &[&format!("{:.4}", half - r)]));
        }
        r = half;
    }
    let height = ((r - half) * (r + half)).max(0.0).sqrt();
    let left = ends.counter_clockwise == (radius > 0.0);
    let scale = if left { height } else { -height } / (2.0 * half);
    let middle = [0.5 * (ends.start[0] + ends.end[0]), 0.5 * (ends.start[1] + ends.end[1])];
    let centre = [middle[0] - chord[1] * scale, middle[1] + chord[0] * scale];
    let once = sweep(ends.start, ends.end, centre, ends.counter_clockwise);
    if [0.0, 180.0, 360.0].iter().any(|bad| (once.abs() - bad).abs() < 0.5) {
        warnings.push(Fault::new(Id::GW924, word));
    }
    Ok(Arc { centre, sweep: with_turns(once, ends.turns), radius: length(minus(ends.start, centre)), end: ends.end })
}

/// Smallest and largest value of each coordinate on an arc.
pub fn bounds(start: Vector, centre: Vector, sweep: f64, end: Vector) -> [(f64, f64); 2] {
    let v = minus(start, centre);
    let radius = length(v);
    let from = v[1].atan2(v[0]).to_degrees();
    let mut all = [0, 1].map(|i| (start[i].min(end[i]), start[i].max(end[i])));
    let (low, high) = if sweep < 0.0 { (from + sweep, from) } else { (from, from + sweep) };
    for quarter in 0..4i32 {
        let angle = f64::from(quarter) * 90.0;
        // the first turn of this direction at or behind `low`
        if angle + 360.0 * ((low - angle) / 360.0).ceil() <= high {
            let axis = (quarter % 2) as usize;
            let side = if quarter < 2 { radius } else { -radius };
            let extreme = centre[axis] + side;
            all[axis] = (all[axis].0.min(extreme), all[axis].1.max(extreme));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ends(start: Vector, end: Vector, counter_clockwise: bool) -> Ends {
        Ends { start, end, counter_clockwise, turns: 1, span: Span::default() }
    }
    fn turned(start: Vector, arc: &Arc) -> Vector {
        let (sin, cos) = arc.sweep.to_radians().sin_cos();
        let v = minus(start, arc.centre);
        [arc.centre[0] + v[0] * cos - v[1] * sin, arc.centre[1] + v[0] * sin + v[1] * cos]
    }

    proptest! {
        /// Section 17: the end point of the command is the programmed one within 1e-9 of the radius.
        #[test]
        fn both_forms_end_where_programmed(
            a in 0.0..360.0f64, sweep in 1.0..359.0f64, r in 0.1..1000.0f64, ccw: bool, noise in -0.002..0.002f64,
        ) {
            prop_assume!((sweep - 180.0).abs() > 1.0);
            let at = |angle: f64| [r * angle.to_radians().cos(), r * angle.to_radians().sin()];
            let (start, end) = (at(a), at(if ccw { a + sweep } else { a - sweep }));
            let e = ends(start, end, ccw);
            let warnings = &mut Vec::new();
            let one = by_centre(&e, [noise, 0.0], [0.0; 2], warnings).unwrap();
            let two = by_radius(&e, if sweep > 180.0 { -r } else { r }, Span::default(), warnings).unwrap();
            for arc in [one, two] {
                prop_assert!(length(minus(turned(start, &arc), end)) <= 1e-9 * arc.radius.max(1.0));
                prop_assert_eq!(arc.sweep > 0.0, ccw);
            }
            prop_assert!((two.sweep.abs() - sweep).abs() < 1e-6);
        }
        #[test]
        fn bounds_hold_every_point(a in -400.0..400.0f64, sweep in -800.0..800.0f64) {
            let start = [5.0 * a.to_radians().cos(), 5.0 * a.to_radians().sin()];
            let arc = Arc { centre: [0.0; 2], sweep, radius: 5.0, end: [0.0; 2] };
            let end = turned(start, &arc);
            let all = bounds(start, [0.0; 2], sweep, end);
            let mut seen = [(f64::INFINITY, f64::NEG_INFINITY); 2];
            for i in 0..=2000 {
                let p = turned(start, &Arc { sweep: sweep * f64::from(i) / 2000.0, ..arc });
                for axis in 0..2 {
                    prop_assert!(all[axis].0 - 1e-9 <= p[axis] && p[axis] <= all[axis].1 + 1e-9);
                    seen[axis] = (seen[axis].0.min(p[axis]), seen[axis].1.max(p[axis]));
                }
            }
            for axis in 0..2 {
                prop_assert!((seen[axis].0 - all[axis].0).abs() < 1e-3 && (seen[axis].1 - all[axis].1).abs() < 1e-3);
            }
        }
    }
}
