//! Lines, circles and helices in the metric of design D7, parametrised by arc length; foot points on pieces of them.

use std::f64::consts::{FRAC_PI_2, TAU};

/// Marks a segment without circle.
pub const LINE: u32 = u32::MAX;

/// What line, circle and helix have in common. Coordinates lie in the path's own columns.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Path length at its start, mm.
    pub s0: f64,
    pub length: f64,
    /// Programmed velocity, mm/s, and its inverse.
    pub speed: f64,
    pub slowness: f64,
    /// 1 over the length of the tangent in the X-Y plane; infinite where it has no direction there.
    pub plane_scale: f64,
    /// Number in the path's circles, or [`LINE`].
    pub circle: u32,
    pub block: u32,
    /// Row of axis scales (effective radii).
    pub scale: u16,
    /// The path turns back at its end, by more than a right angle.
    pub sharp_end: bool,
}

/// The circular part of a circle or helix.
#[derive(Clone, Copy, Debug)]
pub struct Circle {
    pub c1: usize,
    pub c2: usize,
    pub center: [f64; 2],
    pub radius: f64,
    /// Angle of the start point, rad.
    pub theta0: f64,
    /// Radians per mm of path, counter-clockwise positive.
    pub rate: f64,
    /// Other axes move too.
    pub helical: bool,
}

/// The nearest point of a piece of a segment: arc length from the segment's start, squared distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    pub t: f64,
    pub d2: f64,
}

/// Geometry of one segment, with the columns it needs at hand.
#[derive(Clone, Copy)]
pub struct Shape<'a, const N: usize> {
    pub start: &'a [f64; N],
    /// Change of each coordinate per mm of path; 0 in the circle axes.
    pub slope: &'a [f64; N],
    pub circle: Option<&'a Circle>,
}

impl<const N: usize> Shape<'_, N> {
    pub fn point(&self, t: f64) -> [f64; N] {
        let mut p: [f64; N] = std::array::from_fn(|a| self.start[a] + t * self.slope[a]);
        if let Some(c) = self.circle {
            let (sin, cos) = (c.theta0 + t * c.rate).sin_cos();
            p[c.c1] = c.center[0] + c.radius * cos;
            p[c.c2] = c.center[1] + c.radius * sin;
        }
        p
    }

    /// Longest piece on which the distance has one minimum only, as far as is needed: a quarter turn.
    pub fn piece(&self) -> f64 {
        self.circle.map_or(f64::INFINITY, |c| FRAC_PI_2 / c.rate.abs())
    }

    /// Nearest point on the piece from `a` to `b` (mm from the start), which must not be longer than [`Shape::piece`].
    pub fn nearest(&self, x: &[f64; N], a: f64, b: f64) -> Nearest {
        match self.circle {
            None => self.nearest_on_line(x, a, b),
            Some(c) if c.helical => self.nearest_on_helix(c, x, a, b),
            Some(c) => self.nearest_on_circle(c, x, a, b),
        }
    }

    fn nearest_on_line(&self, x: &[f64; N], a: f64, b: f64) -> Nearest {
        let along: f64 = (0..N).map(|i| (x[i] - self.start[i]) * self.slope[i]).sum();
        let t = along.max(a).min(b);
        let d2 = (0..N).map(|i| (x[i] - self.start[i] - t * self.slope[i]).powi(2)).sum();
        Nearest { t, d2 }
    }

    fn nearest_on_circle(&self, c: &Circle, x: &[f64; N], a: f64, b: f64) -> Nearest {
        let (dx, dy) = (x[c.c1] - c.center[0], x[c.c2] - c.center[1]);
        let middle = c.theta0 + 0.5 * (a + b) * c.rate;
        let turned = dy.atan2(dx) - middle;
        let t = 0.5 * (a + b) + (turned - TAU * (turned / TAU).round()) / c.rate;
        if !(t >= a && t <= b) {
            let t = t.max(a).min(b);
            return Nearest { t, d2: squared_distance(x, &self.point(t)) };
        }
        let off = (dx * dx + dy * dy).sqrt() - c.radius;
        let others = (0..N).filter(|&i| i != c.c1 && i != c.c2).map(|i| (x[i] - self.start[i]).powi(2));
        Nearest { t, d2: off * off + others.sum::<f64>() }
    }

    /// Half the derivative of the squared distance by path length, and half its second derivative.
    fn helix_slope(&self, c: &Circle, x: &[f64; N], t: f64) -> (f64, f64) {
        let (sin, cos) = (c.theta0 + t * c.rate).sin_cos();
        let (dx, dy) = (x[c.c1] - c.center[0], x[c.c2] - c.center[1]);
        let turn = c.radius * c.rate;
        let mut first = turn * (dx * sin - dy * cos);
        let mut second = turn * c.rate * (dx * cos + dy * sin);
        // circle axes have slope 0, so their coordinates drop out
        for ((x, start), slope) in x.iter().zip(self.start).zip(self.slope) {
            first -= slope * (x - start - t * slope);
            second += slope * slope;
        }
        (first, second)
    }

    /// Newton's method, kept inside the piece by bisection; the ends compete where the distance is not convex.
    fn nearest_on_helix(&self, c: &Circle, x: &[f64; N], a: f64, b: f64) -> Nearest {
        let at = |t: f64| Nearest { t, d2: squared_distance(x, &self.point(t)) };
        let (mut low, mut high) = (a, b);
        let rises_at_a = self.helix_slope(c, x, a).0 >= 0.0;
        let falls_at_b = self.helix_slope(c, x, b).0 <= 0.0;
        if rises_at_a || falls_at_b {
            let (at_a, at_b) = (at(a), at(b));
            return if rises_at_a && (!falls_at_b || at_a.d2 <= at_b.d2) { at_a } else { at_b };
        }
        let mut t = 0.5 * (a + b);
        for _ in 0..60 {
            let (first, second) = self.helix_slope(c, x, t);
            if first > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - first / second;
            let next = if second > 0.0 && newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let done = (next - t).abs() <= 1e-14 * (1.0 + t.abs());
            t = next;
            if done {
                break;
            }
        }
        at(t)
    }

    /// Signed distance of `x` from the foot at `t` in the plane, positive to the left of the direction of motion:
    /// the circle's plane for circles, the first two axes for lines; NaN where the path has no direction there.
    pub fn left_of(&self, plane_scale: f64, x: &[f64; N], t: f64) -> f64 {
        let Some(c) = self.circle else {
            if !plane_scale.is_finite() {
                return f64::NAN;
            }
            let off = |i: usize| x[i] - self.start[i] - t * self.slope[i];
            return (self.slope[0] * off(1) - self.slope[1] * off(0)) * plane_scale;
        };
        let (sin, cos) = (c.theta0 + t * c.rate).sin_cos();
        let (dx, dy) = (x[c.c1] - c.center[0], x[c.c2] - c.center[1]);
        (c.radius - dx * cos - dy * sin) * c.rate.signum()
    }
}

pub fn squared_distance<const N: usize>(x: &[f64; N], y: &[f64; N]) -> f64 {
    (0..N).map(|i| (x[i] - y[i]).powi(2)).sum()
}
