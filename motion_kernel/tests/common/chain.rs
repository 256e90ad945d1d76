//! Random chains of lines, circles and helices in 2 to 6 axes, with 3-D circles in 3 of them, and an oracle for them: curves in n-dimensional space
//! (centre, two orthonormal vectors, drift) with foot points, in the metric of design D7. Shared with nobody.

use super::*;
use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::AxisList;
use motion_kernel::circle_3d::Circle3d;
use motion_kernel::trace::Trace;
use proptest::prelude::*;

pub type Vector = Vec<f64>;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
/// `a + k * b`
fn plus(a: &[f64], k: f64, b: &[f64]) -> Vector {
    a.iter().zip(b).map(|(x, y)| x + k * y).collect()
}
fn times(k: f64, a: &[f64]) -> Vector {
    a.iter().map(|x| k * x).collect()
}

/// A curve by the share travelled, 0..1: a line (`radius` 0), or a turn by `angle` radians about `center` in the plane
/// of `e1` (towards the start) and `e2`, together with `drift`.
#[derive(Clone, Debug)]
pub struct Curve {
    pub start: Vector,
    pub drift: Vector,
    pub center: Vector,
    pub e1: Vector,
    pub e2: Vector,
    pub radius: f64,
    pub angle: f64,
    pub length: f64,
}

impl Curve {
    fn line(start: &[f64], drift: Vector) -> Curve {
        let zero = vec![0.0; start.len()];
        let length = norm(&drift);
        Curve {
            start: start.to_vec(),
            drift,
            center: zero.clone(),
            e1: zero.clone(),
            e2: zero,
            radius: 0.0,
            angle: 0.0,
            length,
        }
    }
    /// A turn that begins at `start` and moves along the unit vector `along` at first, with the centre at `to_center`.
    fn turn(start: &[f64], to_center: &[f64], along: Vector, angle: f64, drift: Vector) -> Curve {
        let radius = norm(to_center);
        let length = (radius * angle).hypot(norm(&drift));
        let (e1, e2) = (times(-1.0 / radius, to_center), along);
        let center = plus(start, 1.0, to_center);
        Curve { start: start.to_vec(), drift, center, e1, e2, radius, angle, length }
    }
    pub fn at(&self, share: f64) -> Vector {
        if self.radius == 0.0 {
            return plus(&self.start, share, &self.drift);
        }
        let (sin, cos) = (self.angle * share).sin_cos();
        let around = plus(&times(self.radius * cos, &self.e1), self.radius * sin, &self.e2);
        plus(&plus(&self.center, 1.0, &around), share, &self.drift)
    }
    /// Unit tangent.
    pub fn tangent(&self, share: f64) -> Vector {
        let (sin, cos) = (self.angle * share).sin_cos();
        let around = plus(&times(-sin, &self.e1), cos, &self.e2);
        times(1.0 / self.length, &plus(&self.drift, self.radius * self.angle, &around))
    }
    /// Distance of a point from the curve, and the path length at its foot; of several the one nearest to `hint`.
    pub fn foot(&self, p: &[f64], hint: f64) -> (f64, f64) {
        let off = |share: f64| norm(&plus(p, -1.0, &self.at(share)));
        if self.radius == 0.0 {
            let share = (dot(&plus(p, -1.0, &self.start), &self.drift) / self.length / self.length).clamp(0.0, 1.0);
            return (off(share), share * self.length);
        }
        let from_center = plus(p, -1.0, &self.center);
        let angle = dot(&from_center, &self.e2).atan2(dot(&from_center, &self.e1));
        let turns = (self.angle.abs() / std::f64::consts::TAU).ceil() as i32 + 1;
        let all = (-turns..=turns)
            .map(|n| ((angle + f64::from(n) * std::f64::consts::TAU) / self.angle).clamp(0.0, 1.0))
            .map(|share| (off(share), share * self.length));
        let least = all.clone().map(|(d, _)| d).fold(f64::INFINITY, f64::min);
        let near = all.filter(|(d, _)| *d <= least + 1e-9);
        near.min_by(|a, b| (a.1 - hint).abs().total_cmp(&(b.1 - hint).abs())).expect("a curve has points")
    }
}

#[derive(Clone, Debug)]
pub enum Shape {
    /// Direction, in metric coordinates.
    Line { direction: Vector },
    /// Direction of the centre in the plane (radians), radius, degrees, travel of each further axis.
    Arc { towards: f64, radius: f64, phi: f64, further: Vector },
    /// A 3-D circle: normal, direction of the centre in its plane, radius, degrees, and how far beside the plane the
    /// centre is given.
    Space { normal: [f64; 3], towards: f64, radius: f64, phi: f64, beside: f64 },
}

/// One motion command, before it has a place.
#[derive(Clone, Debug)]
pub struct Element {
    /// Axes in command order; circles turn in the plane of the first two.
    pub order: Vec<usize>,
    pub shape: Shape,
    pub length: f64,
    /// Goes on in the direction of the element before, nearly.
    pub smooth: bool,
    pub vl: f64,
    pub ac: f64,
    pub goes_on: bool,
}

#[derive(Clone, Debug)]
pub struct Placed {
    pub curve: Curve,
    pub element: Element,
}

/// A chain of elements for a machine with `scale` path units per axis unit.
#[derive(Clone, Debug)]
pub struct Chain {
    pub scale: Vector,
    pub placed: Vec<Placed>,
}

fn shape(axes: usize) -> impl Strategy<Value = Shape> {
    let part = || prop_oneof![1 => Just(0.0), 4 => -1.0..1.0f64];
    let line = prop::collection::vec(part(), axes)
        .prop_filter("goes somewhere", |d| norm(d) > 0.1)
        .prop_map(|direction| Shape::Line { direction });
    let further = prop::collection::vec(prop_oneof![Just(0.0), -5.0..5.0f64], axes - 2);
    let phi = (prop_oneof![Just(-1.0), Just(1.0)], 5.0..500.0f64).prop_map(|(sign, phi)| sign * phi);
    let arc = (0.0..std::f64::consts::TAU, 0.2..10.0f64, phi, further)
        .prop_map(|(towards, radius, phi, further)| Shape::Arc { towards, radius, phi, further });
    prop_oneof![line, arc]
}

fn shape_in_space() -> impl Strategy<Value = Shape> {
    let normal = [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64].prop_filter("points somewhere", |n| norm(n) > 0.1);
    (normal, 0.0..std::f64::consts::TAU, 0.2..10.0f64, -500.0..500.0f64, -3.0..3.0f64).prop_map(
        |(normal, towards, radius, phi, beside)| Shape::Space {
            normal,
            towards,
            radius,
            phi: phi + phi.signum(),
            beside,
        },
    )
}

fn element(axes: usize, shape: impl Strategy<Value = Shape>) -> impl Strategy<Value = Element> {
    let order = Just((0..axes).collect::<Vec<_>>()).prop_shuffle();
    let length = prop_oneof![0.05..0.5f64, 0.5..20.0f64];
    let dynamics = (5.0..120.0f64, 100.0..2000.0f64);
    (order, shape, length, prop::bool::weighted(0.7), dynamics, prop::bool::weighted(0.9)).prop_map(
        |(order, shape, length, smooth, (vl, ac), goes_on)| Element { order, shape, length, smooth, vl, ac, goes_on },
    )
}

/// Chains of up to `most` elements in 2 to 6 axes; the last axis may be rotary with an effective radius.
pub fn chain(most: usize) -> impl Strategy<Value = Chain> {
    (2..=6usize, prop_oneof![Just(0.0), 5.0..200.0f64]).prop_flat_map(move |(axes, radius)| {
        let elements = prop::collection::vec(element(axes, shape(axes)), 1..most);
        elements.prop_map(move |elements| Chain::new(axes, radius, &elements))
    })
}

/// Chains in 3 axes that have 3-D circles, too. (Those are not under look-ahead.)
pub fn chain_in_space(most: usize) -> impl Strategy<Value = Chain> {
    let element = element(3, prop_oneof![shape(3), shape_in_space()]);
    (prop::collection::vec(element, 1..most), prop_oneof![Just(0.0), 5.0..200.0f64])
        .prop_map(|(elements, radius)| Chain::new(3, radius, &elements))
}

impl Chain {
    /// Places elements one after the other, from the origin. `radius` > 0: the last axis is rotary.
    pub fn new(axes: usize, radius: f64, elements: &[Element]) -> Chain {
        let mut scale = vec![1.0; axes];
        if radius > 0.0 {
            scale[axes - 1] = radius * std::f64::consts::PI / 180.0;
        }
        let (mut start, mut before) = (vec![0.0; axes], vec![0.0; axes]);
        let mut placed = Vec::new();
        for element in elements {
            let curve = element.from(&start, &before);
            (start, before) = (curve.at(1.0), curve.tangent(1.0));
            placed.push(Placed { curve, element: element.clone() });
        }
        Chain { scale, placed }
    }
    pub fn axes(&self) -> usize {
        self.scale.len()
    }
    pub fn machine(&self) -> Machine {
        let letters = "XYZUVW"[..self.axes() - 1].to_string();
        let rotary = self.scale[self.axes() - 1] != 1.0;
        let last = if rotary { "C" } else { &"XYZUVW"[self.axes() - 1..self.axes()] };
        let mut machine = machine(&(letters + last));
        for (axis, scale) in machine.axes.iter_mut().zip(&self.scale) {
            if *scale != 1.0 {
                axis.effradius = scale * 180.0 / std::f64::consts::PI;
                (axis.mdvel, axis.maxvel, axis.maxacc) = (axis.mdvel / scale, axis.maxvel / scale, axis.maxacc / scale);
            }
        }
        machine
    }
    pub fn machine_with(&self, jerkrel: f64) -> Machine {
        let mut machine = self.machine();
        machine.axes.iter_mut().for_each(|a| a.jerkrel = jerkrel);
        machine
    }
    /// A controller that has the whole chain in its spoolers.
    pub fn spooled(&self, mode: ModeReg) -> Mcu {
        self.spooled_on(self.machine(), mode)
    }
    pub fn spooled_on(&self, machine: Machine, mode: ModeReg) -> Mcu {
        let mut m = mcu_of(machine, mode);
        for n in 0..self.placed.len() {
            assert_eq!(self.enter(&mut m, n), Entered::Yes);
        }
        m
    }
    /// Spools one element.
    pub fn enter(&self, m: &mut Mcu, n: usize) -> Entered {
        let Placed { curve, element } = &self.placed[n];
        let order = &element.order;
        let machine = |p: &[f64]| -> Vector { order.iter().map(|&a| p[a] / self.scale[a]).collect() };
        let (targets, center) = (machine(&curve.at(1.0)), machine(&curve.center));
        let tvl = if element.goes_on && n + 1 < self.placed.len() { element.vl } else { 0.0 };
        let (kind, phi) = match &element.shape {
            Shape::Space { normal, phi, beside, .. } => {
                let scale = |i: usize| self.scale[order[i]];
                let center = std::array::from_fn(|i| center[i] + beside * normal[i] / scale(i));
                let &Element { vl, ac, .. } = element;
                let axes = &AxisList::new(order);
                let circle =
                    Circle3d { axes, relative: false, center, normal: *normal, phi: *phi, vl, ac, tvl, line: 1 };
                return m.spool_3d(&circle);
            }
            Shape::Line { .. } => (MoveKind::Smla, 0.0),
            Shape::Arc { phi, .. } => (MoveKind::Smha, *phi),
        };
        let v = [element.vl, element.ac, tvl];
        spool(m, kind, &AxisList::new(order), &targets, [center[0], center[1]], phi, v)
    }
    /// Largest extent of the whole chain, at least 1 mm.
    pub fn extent(&self) -> f64 {
        let reach = |c: &Curve| norm(&c.start).max(norm(&c.at(1.0))) + 2.0 * c.radius;
        self.placed.iter().map(|b| reach(&b.curve)).fold(1.0, f64::max)
    }
    /// Change of the unit tangent at the start of element `n` > 0.
    pub fn turn(&self, n: usize) -> Vector {
        plus(&self.placed[n].curve.tangent(0.0), -1.0, &self.placed[n - 1].curve.tangent(1.0))
    }
    /// Where the last element ends, in axis units.
    pub fn end(&self) -> Vector {
        let end = self.placed.last().expect("not empty").curve.at(1.0);
        end.iter().zip(&self.scale).map(|(p, k)| p / k).collect()
    }

    /// Checks every set point: it lies on the element that the trace names, within 1e-9 of the extent, and the path is
    /// travelled forwards. Returns the path length travelled at each sample, counted from the start of the chain;
    /// `travelled` is that of the sample before.
    pub fn follow(&self, trace: &Trace, travelled: f64) -> Vec<f64> {
        let tolerance = 1e-9 * self.extent();
        let mut starts = vec![0.0];
        for b in &self.placed {
            starts.push(starts[starts.len() - 1] + b.curve.length);
        }
        let mut last = travelled;
        let mut lengths = Vec::new();
        for (k, row) in trace.dp.chunks(trace.axes).enumerate() {
            let p: Vector = row.iter().zip(&self.scale).map(|(x, k)| x * k).collect();
            let n = if trace.entry[k] == 0 { self.placed.len() } else { trace.entry[k] as usize };
            let (off, s) = self.placed[n - 1].curve.foot(&p, last - starts[n - 1]);
            assert!(off <= tolerance, "sample {k}: {p:?} is {off:e} mm off element {n} {:?}", self.placed[n - 1]);
            let here = starts[n - 1] + s;
            assert!(here >= last - tolerance, "sample {k} runs back in element {n}: {here} after {last}");
            lengths.push(here);
            last = here;
        }
        lengths
    }
}

/// A turn about `normal` in three axes: the way to the centre, and the unit tangent at its start.
fn about(normal: &[f64; 3], towards: f64, radius: f64) -> ([f64; 3], [f64; 3]) {
    let cross =
        |a: &[f64], b: &[f64]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let unit = |a: &[f64]| -> [f64; 3] { std::array::from_fn(|i| a[i] / norm(a)) };
    let n = unit(normal);
    let least = (0..3).min_by(|i, j| n[*i].abs().total_cmp(&n[*j].abs())).expect("three");
    let u = unit(&cross(&n, &std::array::from_fn::<f64, 3, _>(|i| f64::from(u8::from(i == least)))));
    let v = cross(&n, &u);
    let to_center = std::array::from_fn(|i| radius * (towards.cos() * u[i] + towards.sin() * v[i]));
    (to_center, unit(&cross(&to_center, &n)))
}

impl Element {
    /// The curve from `start`; `before` is the unit tangent there (zeros at first).
    fn from(&self, start: &[f64], before: &[f64]) -> Curve {
        let axes = start.len();
        match &self.shape {
            Shape::Line { direction } => {
                let smooth = self.smooth && norm(before) > 0.5;
                let direction = if smooth { plus(before, 0.03, direction) } else { direction.clone() };
                Curve::line(start, times(self.length / norm(&direction), &direction))
            }
            Shape::Space { normal, towards, radius, phi, .. } => {
                let (way, tangent) = about(normal, *towards, *radius);
                let (mut to_center, mut along) = (vec![0.0; axes], vec![0.0; axes]);
                for (i, &a) in self.order.iter().enumerate() {
                    (to_center[a], along[a]) = (way[i], phi.signum() * tangent[i]);
                }
                Curve::turn(start, &to_center, along, phi.abs().to_radians(), vec![0.0; axes])
            }
            Shape::Arc { towards, radius, phi, further } => {
                let (x, y) = (self.order[0], self.order[1]);
                let flat = before[x].hypot(before[y]);
                let smooth = self.smooth && flat > 0.3;
                // the centre lies to the left of the direction of motion when turning counter-clockwise
                let towards = if smooth {
                    before[y].atan2(before[x]) + phi.signum() * std::f64::consts::FRAC_PI_2 + 0.01 * towards
                } else {
                    *towards
                };
                let (mut to_center, mut along, mut drift) = (vec![0.0; axes], vec![0.0; axes], vec![0.0; axes]);
                (to_center[x], to_center[y]) = (radius * towards.cos(), radius * towards.sin());
                (along[x], along[y]) = (phi.signum() * towards.sin(), -phi.signum() * towards.cos());
                let angle = phi.abs().to_radians();
                for (i, &a) in self.order.iter().enumerate().skip(2) {
                    drift[a] = if smooth { before[a] / flat * radius * angle } else { further[i - 2] };
                }
                Curve::turn(start, &to_center, along, angle, drift)
            }
        }
    }
}
