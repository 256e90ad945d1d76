//! Random contours, and whether set points lie on them: geometry of its own, shared with nobody.

use motion_kernel::Mcu;
use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::motion::MotionCommand;
use motion_kernel::trace::Trace;
use proptest::prelude::*;

pub type Point = [f64; 3];

#[derive(Clone, Debug)]
pub enum Shape {
    /// Relative target.
    Line(Point),
    /// Centre relative to the start, degrees, relative travel of the third axis.
    Arc([f64; 2], f64, f64),
}

#[derive(Clone, Debug)]
pub struct Block {
    pub shape: Shape,
    pub vl: f64,
    pub ac: f64,
    pub goes_on: bool,
}

/// A block with its start, in machine coordinates.
#[derive(Clone, Debug)]
pub struct Placed {
    pub start: Point,
    pub end: Point,
    pub block: Block,
}

pub fn shape() -> impl Strategy<Value = Shape> {
    let length = prop_oneof![0.05..0.5f64, 0.5..20.0f64];
    let sign = prop_oneof![Just(-1.0), Just(1.0)];
    prop_oneof![
        (length.clone(), 0.0..std::f64::consts::TAU, -1.0..1.0f64).prop_map(|(l, w, z)| Shape::Line([
            l * w.cos(),
            l * w.sin(),
            l * z
        ])),
        (0.2..10.0f64, 0.0..std::f64::consts::TAU, sign, 5.0..500.0f64, prop_oneof![Just(0.0), -5.0..5.0f64])
            .prop_map(|(r, w, s, phi, z)| Shape::Arc([r * w.cos(), r * w.sin()], s * phi, z)),
    ]
}

pub fn block() -> impl Strategy<Value = Block> {
    (shape(), 2.0..120.0f64, 100.0..2000.0f64, prop::bool::weighted(0.85)).prop_map(|(shape, vl, ac, goes_on)| Block {
        shape,
        vl,
        ac,
        goes_on,
    })
}

/// Blocks one after the other; neighbours may also run on tangentially.
pub fn contour(most: usize) -> impl Strategy<Value = Vec<Block>> {
    prop::collection::vec(block(), 1..most)
}

pub fn place(blocks: &[Block]) -> Vec<Placed> {
    let mut start = [0.0; 3];
    let mut placed = Vec::new();
    for block in blocks {
        let end = point(&start, &block.shape, 1.0);
        placed.push(Placed { start, end, block: block.clone() });
        start = end;
    }
    placed
}

/// The point after a share of a block.
fn point(start: &Point, shape: &Shape, share: f64) -> Point {
    match shape {
        Shape::Line(d) => std::array::from_fn(|i| start[i] + d[i] * share),
        Shape::Arc(c, phi, dz) => {
            let (sin, cos) = (phi * share).to_radians().sin_cos();
            let (x, y) = (-c[0], -c[1]);
            [start[0] + c[0] + x * cos - y * sin, start[1] + c[1] + x * sin + y * cos, start[2] + dz * share]
        }
    }
}

/// Spools block `n`, two of them to a source line; false when there is no room.
pub fn enter(mcu: &mut Mcu, placed: &[Placed], n: usize) -> bool {
    let entered = try_enter(mcu, placed, n);
    assert!(matches!(entered, Entered::Yes | Entered::Full), "{entered:?}");
    entered == Entered::Yes
}
pub fn try_enter(mcu: &mut Mcu, placed: &[Placed], n: usize) -> Entered {
    let Placed { start, end, block } = &placed[n];
    let tvl = if block.goes_on && n + 1 < placed.len() { block.vl } else { 0.0 };
    let (kind, center, phi) = match block.shape {
        Shape::Line(_) => (MoveKind::Smla, [0.0; 2], 0.0),
        Shape::Arc(c, phi, _) => (MoveKind::Smha, [start[0] + c[0], start[1] + c[1]], phi),
    };
    let (axes, line) = (AxisList::new(&[0, 1, 2]), n as u32 / 2 + 1);
    let &Block { vl, ac, .. } = block;
    let command = MotionCommand { kind, axes: &axes, targets: end, center, phi, vl, ac, tvl, rapid: false, line };
    mcu.spool(&command)
}

pub fn distance(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

/// Distance of a point from a block, and the length from the start of the block to the point nearest to it.
pub fn off(p: &Point, placed: &Placed) -> (f64, f64) {
    let start = &placed.start;
    match &placed.block.shape {
        Shape::Line(d) => {
            let length2: f64 = d.iter().map(|x| x * x).sum();
            let along: f64 = (0..3).map(|i| (p[i] - start[i]) * d[i]).sum::<f64>() / length2;
            let share = along.clamp(0.0, 1.0);
            (distance(p, &point(start, &placed.block.shape, share)), share * length2.sqrt())
        }
        Shape::Arc(c, phi, dz) => {
            let (x, y) = (-c[0], -c[1]);
            let (px, py) = (p[0] - start[0] - c[0], p[1] - start[1] - c[1]);
            let angle = (x * py - y * px).atan2(x * px + y * py).to_degrees();
            let length = (c[0].hypot(c[1]) * phi.to_radians()).hypot(*dz);
            let candidates = (-3..=3).map(|k| ((angle + 360.0 * f64::from(k)) / phi).clamp(0.0, 1.0));
            let best = candidates.map(|share| (distance(p, &point(start, &placed.block.shape, share)), share * length));
            best.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are candidates")
        }
    }
}

pub fn length(placed: &Placed) -> f64 {
    match &placed.block.shape {
        Shape::Line(_) => distance(&placed.start, &placed.end),
        Shape::Arc(c, phi, dz) => (c[0].hypot(c[1]) * phi.to_radians()).hypot(*dz),
    }
}

/// Every sample lies on the block that the trace names, and the path is travelled forwards.
pub fn check_on_path(trace: &Trace, placed: &[Placed]) {
    let (mut last_entry, mut last_s) = (0, 0.0);
    for k in 0..trace.len() {
        let p: Point = std::array::from_fn(|i| trace.dp[k * trace.axes + i]);
        let entry = trace.entry[k] as usize;
        if entry == 0 {
            let (near, _) = placed
                .iter()
                .map(|b| (distance(&p, &b.end), 0))
                .chain([(distance(&p, &placed[0].start), 0)])
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .expect("not empty");
            assert!(near <= 1e-9, "sample {k} stands {near:e} mm off any block end: {p:?}");
            continue;
        }
        let (d, s) = off(&p, &placed[entry - 1]);
        assert!(d <= 1e-9, "sample {k} is {d:e} mm off block {entry}: {p:?} {:?}", placed[entry - 1]);
        assert!(entry >= last_entry, "sample {k}: block {entry} after {last_entry}");
        if entry == last_entry && matches!(placed[entry - 1].block.shape, Shape::Line(_)) {
            assert!(s >= last_s - 1e-9, "sample {k} runs backwards in block {entry}");
        }
        (last_entry, last_s) = (entry, s);
    }
}
