//! Lines, circles and helices in the metric of design D7, parametrised by arc length; foot points on pieces of them.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::ring::Ring;

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
    /// 1 over the length of the tangent in the X-Y plane; NaN where it has no direction there.
    pub plane_scale: f64,
    /// Number in the path's circles, or [`LINE`].
    pub circle: u32,
    pub block: u32,
    /// Row of axis scales (effective radii).
    pub scale: u16,
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
    /// Radians per mm of path, counter-clockwise positive, and its inverse.
    pub rate: f64,
    pub mm_per_radian: f64,
    /// Other axes move too.
    pub helical: bool,
    /// Number of its place in space, or [`LINE`]: a circle of the axes `c1` and `c2`.
    pub ring: u32,
}

impl Circle {
    /// It lies in the plane of two axes.
    pub fn is_plane(&self) -> bool {
        self.ring == LINE
    }
}

/// The nearest point of a piece of a segment: arc length from the segment's start, squared distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    pub t: f64,
    pub d2: f64,
    /// On a circle: direction from its centre to the foot, where it is known.
    pub radial: Radial,
}

/// Unit vector from a circle's centre in its plane; kept from sample to sample, because sines are dear.
pub type Radial = Option<[f64; 2]>;

/// Geometry of one segment, with the columns it needs at hand.
#[derive(Clone, Copy)]
pub struct Shape<'a, const N: usize> {
    pub start: &'a [f64; N],
    /// Change of each coordinate per mm of path; 0 in the circle axes.
    pub slope: &'a [f64; N],
    pub circle: Option<&'a Circle>,
    /// Where that circle lies in space, unless it is one of two axes.
    pub ring: Option<&'a Ring>,
}

impl<const N: usize> Shape<'_, N> {
    /// Longest piece on which the distance has one minimum only, as far as is needed: a quarter turn.
    pub fn piece(&self) -> f64 {
        self.circle.map_or(f64::INFINITY, |c| FRAC_PI_2 * c.mm_per_radian.abs())
    }

    /// Nearest point on the piece from `a` to `b` (mm from the start), which must not be longer than [`Shape::piece`].
    /// `radial`: direction at `a`, if it is known.
    #[inline]
    pub fn nearest(&self, x: &[f64; N], a: f64, b: f64, radial: Radial) -> Nearest {
        match self.circle {
            None => self.nearest_on_line(x, a, b),
            Some(c) if let Some(ring) = self.ring => self.nearest_on_ring(ring, c, x, a, b),
            Some(c) if c.helical => {
                self.near_helix(c, x, a, b, radial).unwrap_or_else(|| self.nearest_on_helix(c, x, a, b))
            }
            Some(c) => self.nearest_on_circle(c, x, a, b, radial),
        }
    }

    #[inline]
    fn nearest_on_line(&self, x: &[f64; N], a: f64, b: f64) -> Nearest {
        let off: [f64; N] = std::array::from_fn(|i| x[i] - self.start[i]);
        let mut along = 0.0;
        for (off, slope) in off.iter().zip(self.slope) {
            along += off * slope;
        }
        let t = along.max(a).min(b);
        let mut d2 = 0.0;
        for (off, slope) in off.iter().zip(self.slope) {
            let d = off - t * slope;
            d2 += d * d;
        }
        Nearest { t, d2, radial: None }
    }

    fn nearest_on_circle(&self, c: &Circle, x: &[f64; N], a: f64, b: f64, radial: Radial) -> Nearest {
        let (dx, dy) = (x[c.c1] - c.center[0], x[c.c2] - c.center[1]);
        let at_a = radial.unwrap_or_else(|| self.radial(c, a));
        let turned = angle(at_a[0] * dy - at_a[1] * dx, at_a[0] * dx + at_a[1] * dy);
        let t = a + turned * c.mm_per_radian;
        if t >= a && t <= b {
            let rho = (dx * dx + dy * dy).sqrt();
            let off = rho - c.radius;
            // the other axes stand still on a circle
            let mut d2 = off * off;
            for (i, (x, start)) in x.iter().zip(self.start).enumerate() {
                if i != c.c1 && i != c.c2 {
                    d2 += (x - start) * (x - start);
                }
            }
            // in the very centre every direction is as good
            return Nearest { t, d2, radial: (rho > 0.0).then(|| [dx / rho, dy / rho]) };
        }
        // behind `a`, unless the other way round to `b` is shorter
        let nearer_a = t < a && (a - t) <= PI * c.mm_per_radian.abs() - 0.5 * (b - a);
        let (t, radial) = if nearer_a { (a, at_a) } else { (b, self.radial(c, b)) };
        Nearest { t, d2: squared_distance(x, &self.at_direction(c, t, radial)), radial: Some(radial) }
    }

    fn radial(&self, c: &Circle, t: f64) -> [f64; 2] {
        if t == 0.0 {
            let (dx, dy) = (self.start[c.c1] - c.center[0], self.start[c.c2] - c.center[1]);
            return [dx / c.radius, dy / c.radius];
        }
        let (sin, cos) = (c.theta0 + t * c.rate).sin_cos();
        [cos, sin]
    }

    /// Half the derivative of the squared distance by path length, and half its second derivative, at `t`, where
    /// `out` is the direction from the centre.
    #[inline]
    fn helix_slope(&self, c: &Circle, x: &[f64; N], t: f64, out: [f64; 2]) -> (f64, f64) {
        let (dx, dy) = (x[c.c1] - c.center[0], x[c.c2] - c.center[1]);
        let turn = c.radius * c.rate;
        let mut first = turn * (dx * out[1] - dy * out[0]);
        let mut second = turn * c.rate * (dx * out[0] + dy * out[1]);
        // circle axes have slope 0, so their coordinates drop out
        for ((x, start), slope) in x.iter().zip(self.start).zip(self.slope) {
            first -= slope * (x - start - t * slope);
            second += slope * slope;
        }
        (first, second)
    }

    /// The usual case: the sample is close to the helix and its foot inside the piece. Newton's method from where
    /// the angles agree; None where that does not settle.
    fn near_helix(&self, c: &Circle, x: &[f64; N], a: f64, b: f64, radial: Radial) -> Option<Nearest> {
        let at_a = radial.unwrap_or_else(|| self.radial(c, a));
        let (dx, dy) = (x[c.c1] - c.center[0], x[c.c2] - c.center[1]);
        let mut t = a + angle(at_a[0] * dy - at_a[1] * dx, at_a[0] * dx + at_a[1] * dy) * c.mm_per_radian;
        for _ in 0..5 {
            if !(t >= a && t <= b) {
                return None;
            }
            let (sin, cos) = (c.theta0 + t * c.rate).sin_cos();
            let (first, second) = self.helix_slope(c, x, t, [cos, sin]);
            let step = -first / second;
            t += step;
            if step.abs() * c.rate.abs() < 1e-9 && second > 0.0 {
                // so small a turn is its own sine
                let turn = step * c.rate;
                let out = [cos - turn * sin, sin + turn * cos];
                let d2 = squared_distance(x, &self.at_direction(c, t, out));
                return (t >= a && t <= b && d2 < 0.25 * c.radius * c.radius).then_some(Nearest {
                    t,
                    d2,
                    radial: Some(out),
                });
            }
        }
        None
    }

    /// Point and unit tangent at `t`.
    pub fn at(&self, t: f64) -> ([f64; N], [f64; N]) {
        let Some(c) = self.circle else {
            return (std::array::from_fn(|a| self.start[a] + t * self.slope[a]), *self.slope);
        };
        if let Some(ring) = self.ring {
            return (self.on_ring(ring, c, t), self.tangent_of_ring(ring, c, t));
        }
        let out = self.radial(c, t);
        let mut tangent = *self.slope;
        tangent[c.c1] = -c.radius * c.rate * out[1];
        tangent[c.c2] = c.radius * c.rate * out[0];
        (self.at_direction(c, t, out), tangent)
    }

    /// The point at `t` with the direction from the centre known.
    #[inline]
    fn at_direction(&self, c: &Circle, t: f64, out: [f64; 2]) -> [f64; N] {
        let mut p: [f64; N] = std::array::from_fn(|a| self.start[a] + t * self.slope[a]);
        p[c.c1] = c.center[0] + c.radius * out[0];
        p[c.c2] = c.center[1] + c.radius * out[1];
        p
    }

    /// Newton's method, kept inside the piece by bisection; the ends compete where the distance is not convex.
    fn nearest_on_helix(&self, c: &Circle, x: &[f64; N], a: f64, b: f64) -> Nearest {
        let at = |t: f64| {
            let out = self.radial(c, t);
            Nearest { t, d2: squared_distance(x, &self.at_direction(c, t, out)), radial: Some(out) }
        };
        let slope_at = |t: f64| self.helix_slope(c, x, t, self.radial(c, t));
        let (mut low, mut high) = (a, b);
        let rises_at_a = slope_at(a).0 >= 0.0;
        let falls_at_b = slope_at(b).0 <= 0.0;
        if rises_at_a || falls_at_b {
            let (at_a, at_b) = (at(a), at(b));
            return if rises_at_a && (!falls_at_b || at_a.d2 <= at_b.d2) { at_a } else { at_b };
        }
        let mut t = 0.5 * (a + b);
        for _ in 0..60 {
            let (first, second) = slope_at(t);
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
    #[inline]
    pub fn left_of(&self, plane_scale: f64, x: &[f64; N], t: f64, radial: Radial) -> f64 {
        let Some(c) = self.circle else {
            let off = |i: usize| x[i] - self.start[i] - t * self.slope[i];
            return (self.slope[0] * off(1) - self.slope[1] * off(0)) * plane_scale;
        };
        if let Some(ring) = self.ring {
            return self.left_of_ring(ring, c, x, t);
        }
        let out = radial.unwrap_or_else(|| self.radial(c, t));
        let (dx, dy) = (x[c.c1] - c.center[0], x[c.c2] - c.center[1]);
        (c.radius - dx * out[0] - dy * out[1]) * c.rate.signum()
    }
}

/// Angle of a vector, of which most are small here.
#[inline]
fn angle(sin: f64, cos: f64) -> f64 {
    let x = sin / cos;
    if cos <= 0.0 || x.abs() > 0.05 {
        return sin.atan2(cos);
    }
    let q = x * x;
    // the next term is below 1e-16 relative
    let series = 1.0 / 11.0 - q * (1.0 / 13.0);
    let series = 1.0 / 7.0 - q * (1.0 / 9.0 - q * series);
    x * (1.0 - q * (1.0 / 3.0 - q * (1.0 / 5.0 - q * series)))
}

pub fn squared_distance<const N: usize>(x: &[f64; N], y: &[f64; N]) -> f64 {
    (0..N).map(|i| (x[i] - y[i]).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_angles_are_exact() {
        for i in -2000..=2000 {
            let a = f64::from(i) * 1e-4;
            let found = angle(3.0 * a.sin(), 3.0 * a.cos());
            assert!((found - a).abs() <= 4e-16 * a.abs(), "{a}: {found}");
        }
        assert!((angle(0.0, -1.0) - PI).abs() < 1e-15);
    }

    /// The nearest of many points on a piece.
    fn densely(shape: &Shape<3>, c: &Circle, x: &[f64; 3], a: f64, b: f64) -> f64 {
        let at = |i: u32| a + (b - a) * f64::from(i) / 20_000.0;
        (0..=20_000)
            .map(|i| squared_distance(x, &shape.at_direction(c, at(i), shape.radial(c, at(i)))))
            .fold(f64::INFINITY, f64::min)
            .sqrt()
    }

    #[test]
    fn nearest_points_of_circles_and_helices_are_nearest_wherever_the_sample_is() {
        let mut k = 0.0f64;
        let mut next = |low: f64, high: f64| {
            k += 1.0;
            low + (high - low) * (k * 0.754_877_666).fract()
        };
        for round in 0..300 {
            let (radius, theta0) = (next(0.5, 8.0), next(-3.0, 3.0));
            let rise = if round % 2 == 0 { 0.0 } else { next(-0.4, 0.4) };
            let turn = (1.0f64 - rise * rise).sqrt() * if round % 3 == 0 { -1.0 } else { 1.0 };
            let rate = turn / radius;
            let center = [next(-5.0, 5.0), next(-5.0, 5.0)];
            let circle = Circle {
                c1: 0,
                c2: 1,
                center,
                radius,
                theta0,
                rate,
                mm_per_radian: 1.0 / rate,
                helical: rise != 0.0,
                ring: LINE,
            };
            let start = [center[0] + radius * theta0.cos(), center[1] + radius * theta0.sin(), 1.0];
            let slope = [0.0, 0.0, rise];
            let shape = Shape { start: &start, slope: &slope, circle: Some(&circle), ring: None };
            let a = next(0.0, 3.0) * radius;
            let b = a + next(0.05, 1.0) * shape.piece();
            let x = [center[0] + next(-10.0, 10.0), center[1] + next(-10.0, 10.0), 1.0 + next(-3.0, 3.0)];
            let found = shape.nearest(&x, a, b, None);
            let expected = densely(&shape, &circle, &x, a, b);
            assert!(found.t >= a && found.t <= b);
            assert!(found.d2.sqrt() <= expected + 1e-9, "round {round}: {} for {expected}", found.d2.sqrt());
            assert!(found.d2.sqrt() >= expected - 1e-6, "round {round}: {} for {expected}", found.d2.sqrt());
        }
    }
}
