//! Circles of three axes in any plane (smca3d, smcr3d): their geometry, and the foot point on pieces of them.

use std::f64::consts::{PI, TAU};

use crate::path::Path;
use crate::segment::{Circle, LINE, Nearest, Shape, squared_distance};
use crate::sequence::{PathError, SequenceView};

/// Where a circle lies in space: point = centre + radius * (out * cos + left * sin).
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    pub axes: [usize; 3],
    pub center: [f64; 3],
    /// Unit vectors towards the start, and at right angles to it counter-clockwise about the normal.
    pub out: [f64; 3],
    pub left: [f64; 3],
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Ring {
    /// The circle through `start` about the line through `center` along `normal`, and its radius; None where these
    /// describe no circle.
    fn through(axes: [usize; 3], start: [f64; 3], center: [f64; 3], normal: [f64; 3]) -> Option<(Ring, f64)> {
        let size = dot(normal, normal).sqrt();
        let n = normal.map(|x| x / size);
        let arm: [f64; 3] = std::array::from_fn(|i| start[i] - center[i]);
        let height = dot(arm, n);
        let center: [f64; 3] = std::array::from_fn(|i| center[i] + height * n[i]);
        let arm: [f64; 3] = std::array::from_fn(|i| start[i] - center[i]);
        let radius = dot(arm, arm).sqrt();
        let out = arm.map(|x| x / radius);
        let left = cross(n, out);
        let sound = size > 0.0 && radius > 0.0 && [size, radius].iter().chain(&left).all(|x| x.is_finite());
        sound.then_some((Ring { axes, center, out, left }, radius))
    }
    /// Coordinates about the centre: towards the start, at right angles to it, along the normal.
    fn local<const N: usize>(&self, x: &[f64; N]) -> [f64; 3] {
        let arm: [f64; 3] = std::array::from_fn(|i| x[self.axes[i]] - self.center[i]);
        [dot(arm, self.out), dot(arm, self.left), dot(arm, cross(self.out, self.left))]
    }
    /// The coordinates of the three axes at an angle from the start.
    pub fn at(&self, radius: f64, angle: f64) -> [f64; 3] {
        let (sin, cos) = angle.sin_cos();
        std::array::from_fn(|i| self.center[i] + radius * (self.out[i] * cos + self.left[i] * sin))
    }
    /// Per axis: how far the circle reaches from its centre, and at which angle.
    fn reach(&self, radius: f64) -> [(f64, f64); 3] {
        std::array::from_fn(|i| (radius * self.out[i].hypot(self.left[i]), self.left[i].atan2(self.out[i])))
    }
    /// Least and greatest coordinate per axis between the start and an angle, beside those of the two ends.
    pub fn extremes(&self, radius: f64, angle: f64) -> impl Iterator<Item = (usize, f64)> {
        let (low, high) = (angle.min(0.0), angle.max(0.0));
        let passes = move |at: f64| low + (at - low).rem_euclid(TAU) <= high;
        let (axes, center, reach) = (self.axes, self.center, self.reach(radius));
        (0..3).flat_map(move |i| {
            let (most, at) = reach[i];
            let ends = [(at, most), (at + PI, -most)];
            ends.into_iter().filter(move |end| passes(end.0)).map(move |end| (axes[i], center[i] + end.1))
        })
    }
}

impl<const N: usize> Shape<'_, N> {
    /// Point at path length `t`.
    pub(crate) fn on_ring(&self, ring: &Ring, c: &Circle, t: f64) -> [f64; N] {
        let mut p = *self.start;
        for (axis, x) in ring.axes.into_iter().zip(ring.at(c.radius, t * c.rate)) {
            p[axis] = x;
        }
        p
    }
    pub(crate) fn tangent_of_ring(&self, ring: &Ring, c: &Circle, t: f64) -> [f64; N] {
        let (sin, cos) = (t * c.rate).sin_cos();
        let mut tangent = [0.0; N];
        for i in 0..3 {
            tangent[ring.axes[i]] = c.radius * c.rate * (ring.left[i] * cos - ring.out[i] * sin);
        }
        tangent
    }

    /// Nearest point on the piece from `a` to `b`, at most a quarter turn.
    pub(crate) fn nearest_on_ring(&self, ring: &Ring, c: &Circle, x: &[f64; N], a: f64, b: f64) -> Nearest {
        let [u, v, height] = ring.local(x);
        let (sin, cos) = (a * c.rate).sin_cos();
        let turned = (cos * v - sin * u).atan2(cos * u + sin * v);
        let t = a + turned * c.mm_per_radian;
        if t >= a && t <= b {
            let off = u.hypot(v) - c.radius;
            let aside = (0..N).filter(|i| !ring.axes.contains(i)).map(|i| (x[i] - self.start[i]).powi(2));
            return Nearest { t, d2: off * off + height * height + aside.sum::<f64>(), radial: None };
        }
        let nearer_a = t < a && (a - t) <= PI * c.mm_per_radian.abs() - 0.5 * (b - a);
        let t = if nearer_a { a } else { b };
        Nearest { t, d2: squared_distance(x, &self.on_ring(ring, c, t)), radial: None }
    }

    /// Signed distance in the plane of the circle, positive to the left seen from the tip of the normal.
    pub(crate) fn left_of_ring(&self, ring: &Ring, c: &Circle, x: &[f64; N], t: f64) -> f64 {
        let [u, v, _] = ring.local(x);
        let (sin, cos) = (t * c.rate).sin_cos();
        (c.radius - u * cos - v * sin) * c.rate.signum()
    }
}

impl Path {
    /// The circle of a command of kind 2 from a scaled start: its length, and its number among the circles.
    pub(crate) fn ring(
        &mut self,
        sequence: &SequenceView,
        i: usize,
        scale: &[f64],
        here: &[f64],
        end: &[f64],
    ) -> Result<(f64, u32), PathError> {
        let fault = |what| PathError::Value { command: i + 1, line: sequence.line[i], what };
        let axes = [sequence.c1[i], sequence.c2[i], sequence.space.c3[i]].map(usize::from);
        let center: [f64; 3] = std::array::from_fn(|k| sequence.space.center[3 * i + k] * scale[axes[k]]);
        let normal: [f64; 3] = std::array::from_fn(|k| sequence.space.normal[3 * i + k]);
        let found = Ring::through(axes, axes.map(|a| here[a]), center, normal);
        let (ring, radius) = found.ok_or_else(|| fault("centre and normal describe no circle"))?;
        let phi = sequence.phi[i].to_radians();
        let length = radius * phi.abs();
        let off_mm = ring.at(radius, phi).iter().zip(axes).map(|(x, a)| (x - end[a]).powi(2)).sum::<f64>().sqrt();
        self.arc_end_error_mm = self.arc_end_error_mm.max(off_mm);
        let size = radius + ring.center.iter().map(|x| x.abs()).sum::<f64>();
        if off_mm > 1e-6 + 1e-9 * size {
            return Err(PathError::ArcEnd { command: i + 1, line: sequence.line[i], off_mm });
        }
        if length == 0.0 {
            return Ok((0.0, LINE));
        }
        let number = self.circles.len() as u32;
        let rate = phi.signum() / radius;
        self.circles.push(Circle {
            c1: axes[0],
            c2: axes[1],
            center: [ring.center[0], ring.center[1]],
            radius,
            theta0: 0.0,
            rate,
            mm_per_radian: 1.0 / rate,
            helical: false,
            ring: self.rings.len() as u32,
        });
        self.rings.push(ring);
        Ok((length, number))
    }
}
