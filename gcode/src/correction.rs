//! Cutter radius correction G41, G42 (docs/dialect.md, section 22): pure geometry of the plane, one element ahead.
//!
//! The tool centre keeps the distance of the tool radius from the contour: lines and arcs are offset, outer
//! corners are rounded about the corner, inner corners end where the offset elements cross.

use std::collections::VecDeque;

use crate::diagnostics::{Check, Fault, Id, Span};

pub type Vector = [f64; 2];

/// A line or arc of the contour in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    pub start: Vector,
    pub end: Vector,
    /// Centre and sweep in degrees.
    pub arc: Option<(Vector, f64)>,
}

/// A part of the corrected path, from where the part before it ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    pub start: Vector,
    pub end: Vector,
    pub arc: Option<(Vector, f64)>,
}

/// How an element ends and the next one begins on the corrected path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// End of the corrected element.
    pub end: Vector,
    /// The arc about an outer corner.
    pub link: Option<Piece>,
    /// Start of the next corrected element.
    pub start: Vector,
}

/// Offset points nearer than this are one point: the joint was meant to be tangential.
const JOINT: f64 = 2e-4;
const TINY: f64 = 1e-9;
/// How much nearer than the radius the tool may come by rounding of the program text.
const TOUCH: f64 = 2e-3;
/// Blocks that are looked at for a bottleneck.
const WINDOW: usize = 24;

fn plus(a: Vector, b: Vector, factor: f64) -> Vector {
    [a[0] + factor * b[0], a[1] + factor * b[1]]
}
fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}
fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
fn length(a: Vector) -> f64 {
    a[0].hypot(a[1])
}
fn angle(centre: Vector, p: Vector) -> f64 {
    (p[1] - centre[1]).atan2(p[0] - centre[0]).to_degrees()
}
/// An angle difference as -180..180.
fn short_way(degrees: f64) -> f64 {
    degrees - 360.0 * (degrees / 360.0).round()
}

impl Element {
    pub fn is_nothing(&self) -> bool {
        self.arc.is_none() && length(minus(self.end, self.start)) < TINY
    }
    fn tangent(&self, at: Vector) -> Vector {
        match self.arc {
            Some((centre, sweep)) => {
                let v = minus(at, centre);
                let scale = sweep.signum() / length(v);
                [-v[1] * scale, v[0] * scale]
            }
            None => {
                let v = minus(self.end, self.start);
                let scale = 1.0 / length(v);
                [v[0] * scale, v[1] * scale]
            }
        }
    }
}

/// The side of the contour and the radius: `offset` > 0 is left of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset(pub f64);

impl Offset {
    /// The tool centre beside a point of an element.
    fn beside(self, element: &Element, at: Vector) -> Vector {
        let t = element.tangent(at);
        plus(at, [-t[1], t[0]], self.0)
    }
    pub fn beside_start(self, element: &Element) -> Vector {
        self.beside(element, element.start)
    }
    pub fn beside_end(self, element: &Element) -> Vector {
        self.beside(element, element.end)
    }
    /// Radius of the corrected arc; an inner arc must be larger than the tool.
    pub fn check(self, element: &Element, span: Span) -> Check<()> {
        let Some((centre, sweep)) = element.arc else { return Ok(()) };
        let radius = length(minus(element.start, centre));
        if radius - self.0 * sweep.signum() > JOINT {
            return Ok(());
        }
        Err(Fault::with(Id::GC420, span, &[&format!("{radius:.4}"), &format!("{:.4}", self.0.abs())]))
    }
    /// The corrected element between two points of its offset curve.
    pub fn piece(self, element: &Element, from: Vector, to: Vector, span: Span) -> Check<Piece> {
        let narrow = || Fault::new(Id::GC421, span);
        let Some((centre, sweep)) = element.arc else {
            if dot(minus(to, from), element.tangent(element.start)) < -TINY {
                return Err(narrow());
            }
            return Ok(Piece { start: from, end: to, arc: None });
        };
        let late = short_way(angle(centre, from) - angle(centre, element.start));
        let early = short_way(angle(centre, to) - angle(centre, element.end));
        let left = sweep + early - late;
        if left * sweep <= 0.0 {
            return Err(narrow());
        }
        Ok(Piece { start: from, end: to, arc: Some((self.centre(centre, from, to), left)) })
    }
    /// The nearest point to the centre with the same distance from both ends.
    fn centre(self, centre: Vector, from: Vector, to: Vector) -> Vector {
        let chord = minus(to, from);
        let square = dot(chord, chord);
        if square < 1e-12 {
            return centre;
        }
        let middle = plus(from, chord, 0.5);
        plus(centre, chord, -dot(minus(centre, middle), chord) / square)
    }

    /// The corner between two elements of the contour.
    pub fn corner(self, a: &Element, b: &Element, span: Span) -> Check<Corner> {
        let corner = a.end;
        let (ta, tb) = (a.tangent(a.end), b.tangent(b.start));
        let (pa, pb) = (self.beside_end(a), self.beside_start(b));
        let turn = cross(ta, tb).atan2(dot(ta, tb)).to_degrees();
        if length(minus(pa, pb)) <= JOINT {
            let joint = plus(pa, minus(pb, pa), 0.5);
            return Ok(Corner { end: joint, link: None, start: joint });
        }
        if turn.abs() > 179.9 {
            return Err(Fault::new(Id::GC422, span));
        }
        if turn * self.0 < 0.0 {
            let link = Piece { start: pa, end: pb, arc: Some((corner, turn)) };
            return Ok(Corner { end: pa, link: Some(link), start: pb });
        }
        let found = self.crossing(a, b, corner).ok_or_else(|| Fault::new(Id::GC421, span))?;
        Ok(Corner { end: found, link: None, start: found })
    }

    /// Where the offset curves of two elements cross next to their corner.
    fn crossing(self, a: &Element, b: &Element, corner: Vector) -> Option<Vector> {
        let found = match (a.arc, b.arc) {
            (None, None) => {
                let (p, u) = (self.beside_end(a), a.tangent(a.end));
                let (q, v) = (self.beside_start(b), b.tangent(b.start));
                let k = cross(u, v);
                (k.abs() > 1e-12).then(|| plus(p, u, cross(minus(q, p), v) / k)).into_iter().collect()
            }
            (None, Some(arc)) => line_circle(self.beside_end(a), a.tangent(a.end), arc.0, self.radius(b)),
            (Some(arc), None) => line_circle(self.beside_start(b), b.tangent(b.start), arc.0, self.radius(a)),
            (Some(one), Some(two)) => circle_circle(one.0, self.radius(a), two.0, self.radius(b)),
        };
        // of two crossings, one that lies on both elements; else the nearest, which shows that they are too short
        let rank = |p: &Vector| (!(on(a, *p) && on(b, *p)), length(minus(*p, corner)));
        found.into_iter().min_by(|p, q| rank(p).0.cmp(&rank(q).0).then(rank(p).1.total_cmp(&rank(q).1)))
    }
    fn radius(self, element: &Element) -> f64 {
        let (centre, sweep) = element.arc.expect("an arc");
        length(minus(element.start, centre)) - self.0 * sweep.signum()
    }
}

/// Does a point of the offset curve lie beside the element, not beyond its ends?
fn on(element: &Element, p: Vector) -> bool {
    match element.arc {
        Some((centre, sweep)) => {
            let turned = (angle(centre, p) - angle(centre, element.start)) * sweep.signum();
            turned.rem_euclid(360.0) <= sweep.abs()
        }
        None => {
            let (d, v) = (minus(element.end, element.start), minus(p, element.start));
            (0.0..=dot(d, d)).contains(&dot(v, d))
        }
    }
}

fn line_circle(p: Vector, u: Vector, centre: Vector, radius: f64) -> Vec<Vector> {
    let along = dot(minus(centre, p), u);
    let foot = plus(p, u, along);
    let square = radius * radius - dot(minus(foot, centre), minus(foot, centre));
    if square < -JOINT * radius {
        return Vec::new();
    }
    let half = square.max(0.0).sqrt();
    vec![plus(foot, u, half), plus(foot, u, -half)]
}

fn circle_circle(a: Vector, ra: f64, b: Vector, rb: f64) -> Vec<Vector> {
    let d = minus(b, a);
    let distance = length(d);
    if distance < TINY {
        return Vec::new();
    }
    let along = (distance * distance + ra * ra - rb * rb) / (2.0 * distance);
    let square = ra * ra - along * along;
    if square < -JOINT * ra {
        return Vec::new();
    }
    let (u, half) = ([d[0] / distance, d[1] / distance], square.max(0.0).sqrt());
    let foot = plus(a, u, along);
    vec![plus(foot, [-u[1], u[0]], half), plus(foot, [-u[1], u[0]], -half)]
}

/// Looks for places where the tool, beside one element, touches another one (bottleneck).
///
/// An arc right behind the approach, or right before the departure, leads onto or off the contour: it lies where the
/// tool passes at the other end of a closed contour, so only the tool path beside it is watched, not the arc itself.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    contour: VecDeque<Element>,
    centre_path: VecDeque<Piece>,
    /// An arc that may be the last element.
    late: Option<Element>,
    /// The next element is the first behind the approach.
    first: bool,
}

impl Watch {
    pub fn clear(&mut self) {
        *self = Watch::default();
    }
    /// The next element follows the approach.
    pub fn begin(&mut self) {
        *self = Watch { first: true, ..Watch::default() };
    }
    /// A new element of the contour must keep its distance from the tool path behind it.
    pub fn element(&mut self, element: &Element, radius: f64, span: Span) -> Check<()> {
        if let Some(late) = self.late.take() {
            self.add(&late, radius, span)?;
        }
        let first = std::mem::take(&mut self.first);
        match element.arc {
            Some(_) if first => Ok(()),
            Some(_) => {
                self.late = Some(*element);
                Ok(())
            }
            None => self.add(element, radius, span),
        }
    }
    fn add(&mut self, element: &Element, radius: f64, span: Span) -> Check<()> {
        if self.contour.len() == WINDOW {
            self.contour.pop_front();
        }
        self.contour.push_back(*element);
        let own = chords(element.start, element.arc, element.end);
        self.centre_path.iter().try_for_each(|piece| clear_of(&own, piece, radius, span))
    }
    /// A new piece of the tool path must keep its distance from the contour behind it.
    pub fn piece(&mut self, piece: &Piece, radius: f64, span: Span) -> Check<()> {
        // an element and the arc about its corner
        if self.centre_path.len() == 2 * WINDOW {
            self.centre_path.pop_front();
        }
        self.centre_path.push_back(*piece);
        let each = |e: &Element| clear_of(&chords(e.start, e.arc, e.end), piece, radius, span);
        self.contour.iter().try_for_each(each)
    }
}

fn clear_of(contour: &[Vector], piece: &Piece, radius: f64, span: Span) -> Check<()> {
    let path = chords(piece.start, piece.arc, piece.end);
    for a in contour.windows(2) {
        for b in path.windows(2) {
            if segments(a[0], a[1], b[0], b[1]) < radius - TOUCH {
                return Err(Fault::new(Id::GC421, span));
            }
        }
    }
    Ok(())
}

/// A polyline within a tenth of [`TOUCH`] of an element (at most 256 chords).
fn chords(start: Vector, arc: Option<(Vector, f64)>, end: Vector) -> Vec<Vector> {
    let Some((centre, sweep)) = arc else { return vec![start, end] };
    let radius = length(minus(start, centre));
    let step = (2.0 * (1.0 - (0.1 * TOUCH / radius).min(1.0)).acos()).to_degrees();
    let count = (sweep.abs() / step).ceil().clamp(1.0, 256.0) as usize;
    let from = angle(centre, start);
    let at = |i: usize| {
        let (sin, cos) = (from + sweep * i as f64 / count as f64).to_radians().sin_cos();
        [centre[0] + radius * cos, centre[1] + radius * sin]
    };
    let mut points: Vec<Vector> = (0..count).map(at).collect();
    points.push(end);
    points
}

/// Distance of two segments.
fn segments(a: Vector, b: Vector, c: Vector, d: Vector) -> f64 {
    let (u, v, w) = (minus(b, a), minus(d, c), minus(c, a));
    let k = cross(u, v);
    if k.abs() > 1e-15 {
        let (s, t) = (cross(w, v) / k, cross(w, u) / k);
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            return 0.0;
        }
    }
    let to = |p: Vector, a: Vector, u: Vector| {
        let square = dot(u, u);
        let t = if square > 0.0 { (dot(minus(p, a), u) / square).clamp(0.0, 1.0) } else { 0.0 };
        length(minus(p, plus(a, u, t)))
    };
    to(c, a, u).min(to(d, a, u)).min(to(a, c, v)).min(to(b, c, v))
}
