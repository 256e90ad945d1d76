//! Geometry of lines, circles and helices: pure functions of the path coordinate (chapter 2.3).
//!
//! Path length and unit tangent are measured in translatory units (design D7): a linear axis counts
//! its mm, a rotary axis radius times angle. Each axis keeps its own component, in axis units, so that
//! it can be evaluated on the clock of that axis.

use crate::axes::{AxisList, AxisSet};

/// Below this length (mm) a path or a radius counts as nothing (ErrorReg bits 15 and 16).
pub const NOTHING: f64 = 1e-9;

/// What a course belongs to. As wide as the numbers beside it: entries of spoolers are copied all the time, and bytes of
/// padding in them cost more than these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u64)]
pub enum Form {
    #[default]
    Line,
    Circle,
}

/// The course of one axis along a move: `base + p * x + q * y`, where (x, y) is (s, 0) on lines and
/// (cos, sin) of the travelled angle for the two circle axes. Axis units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Component {
    pub form: Form,
    pub base: f64,
    pub p: f64,
    pub q: f64,
    /// Position at the end of the whole move.
    pub target: f64,
}

/// A point on a move, as its components need it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    pub s: f64,
    pub cos: f64,
    pub sin: f64,
}

impl Component {
    fn line(start: f64, target: f64, length: f64) -> Self {
        Component { form: Form::Line, base: start, p: (target - start) / length, q: 0.0, target }
    }
    #[inline]
    pub const fn is_circle(&self) -> bool {
        matches!(self.form, Form::Circle)
    }
    #[inline]
    pub fn position(&self, at: &Point) -> f64 {
        if self.is_circle() { self.base + self.p * at.cos + self.q * at.sin } else { self.base + self.p * at.s }
    }
    /// Change per path length; `curvature` is radians per path length.
    #[inline]
    pub fn slope(&self, at: &Point, curvature: f64) -> f64 {
        if self.is_circle() { curvature * (self.q * at.cos - self.p * at.sin) } else { self.p }
    }
}

/// A move in space: its length and curvature. The courses of its axes are written to a buffer of the caller, one
/// per axis of the command, in command order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    pub length: f64,
    /// Radians travelled per path length, signed; 0 for lines.
    pub curvature: f64,
    /// Radius in the circle plane; 0 for lines.
    pub radius: f64,
}

/// Why a command describes no path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPath {
    /// Nothing to travel (ErrorReg bit 15).
    Zero,
    /// Radius almost 0 (bit 16), or exactly 0 (bits 16 and 3).
    Radius { exactly: bool },
    /// A centre or angle that is no number (bit 3).
    Center,
}

/// Start, target, and scale (path units per axis unit) of each axis of a command, in its order.
#[derive(Clone, Copy, Debug)]
pub struct Ends<'a> {
    pub list: &'a AxisList,
    pub start: &'a [f64],
    pub target: &'a [f64],
    pub scale: &'a [f64],
    /// Axes that do not count for the path length (NFRAX).
    pub nfrax: AxisSet,
}

impl Ends<'_> {
    /// Length over the axes from position `first` on, without the NFRAX axes unless nothing else moves.
    fn length(&self, first: usize) -> f64 {
        let sum = |all: bool| -> f64 {
            let counts = |&i: &usize| all || !self.nfrax.contains(self.list.at(i));
            (first..self.list.len())
                .filter(counts)
                .map(|i| ((self.target[i] - self.start[i]) * self.scale[i]).powi(2))
                .sum()
        };
        let feed = sum(false);
        if feed > NOTHING * NOTHING { feed.sqrt() } else { sum(true).sqrt() }
    }
}

/// The point at path coordinate `s`.
#[inline]
pub fn point(s: f64, curvature: f64) -> Point {
    if curvature == 0.0 {
        return Point { s, cos: 1.0, sin: 0.0 };
    }
    let (sin, cos) = (curvature * s).sin_cos();
    Point { s, cos, sin }
}

/// A straight line in any number of axes (2.3.1); an axis without travel takes part formally.
pub fn line(ends: &Ends, components: &mut Vec<Component>) -> Result<Geometry, NoPath> {
    let length = ends.length(0);
    if !length.is_finite() {
        return Err(NoPath::Center);
    }
    if length <= NOTHING {
        return Err(NoPath::Zero);
    }
    components.clear();
    components.extend((0..ends.list.len()).map(|i| Component::line(ends.start[i], ends.target[i], length)));
    Ok(Geometry { length, curvature: 0.0, radius: 0.0 })
}

/// A circle of the first two axes around `center`, `phi` degrees; further axes run linearly (2.3.2, 2.3.3).
/// The end of the circle axes follows from centre and angle, not from `target`.
pub fn circle(ends: &Ends, center: [f64; 2], phi: f64, components: &mut Vec<Component>) -> Result<Geometry, NoPath> {
    let (sx, sy) = (ends.scale[0], ends.scale[1]);
    let (rx, ry) = ((ends.start[0] - center[0]) * sx, (ends.start[1] - center[1]) * sy);
    let radius = rx.hypot(ry);
    if !(radius.is_finite() && phi.is_finite()) {
        return Err(NoPath::Center);
    }
    if radius <= NOTHING {
        return Err(NoPath::Radius { exactly: radius == 0.0 });
    }
    let angle = phi.to_radians();
    let length = (radius * angle).hypot(if ends.list.len() > 2 { ends.length(2) } else { 0.0 });
    if !length.is_finite() {
        return Err(NoPath::Center);
    }
    if length <= NOTHING {
        return Err(NoPath::Zero);
    }
    let (sin, cos) = angle.sin_cos();
    let plane =
        |base: f64, p: f64, q: f64| Component { form: Form::Circle, base, p, q, target: base + p * cos + q * sin };
    components.clear();
    components.push(plane(center[0], rx / sx, -ry / sx));
    components.push(plane(center[1], ry / sy, rx / sy));
    components.extend((2..ends.list.len()).map(|i| Component::line(ends.start[i], ends.target[i], length)));
    Ok(Geometry { length, curvature: angle / length, radius })
}

/// A circle of three axes in the plane through the start with that normal (4.4.30). `center` is projected onto the
/// plane along the normal; `phi` degrees, counter-clockwise positive seen from the tip of the normal.
pub fn circle_3d(
    ends: &Ends,
    center: [f64; 3],
    normal: [f64; 3],
    phi: f64,
    components: &mut Vec<Component>,
) -> Result<Geometry, NoPath> {
    let size = normal[0].hypot(normal[1]).hypot(normal[2]);
    let n = normal.map(|x| x / size);
    let out: [f64; 3] = std::array::from_fn(|i| (ends.start[i] - center[i]) * ends.scale[i]);
    let along = out[0] * n[0] + out[1] * n[1] + out[2] * n[2];
    let r: [f64; 3] = std::array::from_fn(|i| out[i] - along * n[i]);
    let radius = r[0].hypot(r[1]).hypot(r[2]);
    let angle = phi.to_radians();
    let length = radius * angle.abs();
    if !(size > 0.0 && size.is_finite() && radius.is_finite() && length.is_finite()) {
        return Err(NoPath::Center);
    }
    if radius <= NOTHING {
        return Err(NoPath::Radius { exactly: radius == 0.0 });
    }
    if length <= NOTHING {
        return Err(NoPath::Zero);
    }
    let (sin, cos) = angle.sin_cos();
    let turned = [n[1] * r[2] - n[2] * r[1], n[2] * r[0] - n[0] * r[2], n[0] * r[1] - n[1] * r[0]];
    components.clear();
    components.extend((0..3).map(|i| {
        let (p, q) = (r[i] / ends.scale[i], turned[i] / ends.scale[i]);
        let base = ends.start[i] - p;
        Component { form: Form::Circle, base, p, q, target: base + p * cos + q * sin }
    }));
    Ok(Geometry { length, curvature: angle / length, radius })
}

/// The angle in degrees from start to target around a centre, counter-clockwise unless `clockwise`;
/// target = start gives a full circle (4.4.35 with |phi| <= 1e-100).
pub fn sweep_to_target(start: [f64; 2], center: [f64; 2], target: [f64; 2], clockwise: bool) -> f64 {
    let angle = |p: [f64; 2]| (p[1] - center[1]).atan2(p[0] - center[0]);
    let sweep = (angle(target) - angle(start)).to_degrees();
    let turned = if clockwise { -sweep } else { sweep }.rem_euclid(360.0);
    let turned = if turned <= 1e-12 || turned >= 360.0 - 1e-12 { 360.0 } else { turned };
    if clockwise { -turned } else { turned }
}
