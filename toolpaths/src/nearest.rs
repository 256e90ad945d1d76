//! The nearest point of a drawing or of a surface: exact distances to line segments, arcs and triangles, found
//! through a tree of boxes.

/// A piece of a drawing or of a surface, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Segment([[f64; 3]; 2]),
    /// In the plane z = 0: centre, radius, first angle and sweep in radians (counter-clockwise positive).
    Arc {
        center: [f64; 2],
        radius: f64,
        start: f64,
        sweep: f64,
    },
    Triangle([[f64; 3]; 3]),
}

/// The nearest point of all shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    pub distance: f64,
    pub foot: [f64; 3],
    pub shape: usize,
    /// The foot is an end of the shape, and the point lies beyond it: no side can be told there.
    pub beyond: bool,
}

/// The last answer: the nearest shape at a place, and how far the next one was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Near {
    shape: usize,
    at: [f64; 3],
    second: f64,
}

/// Square of the distance, foot, shape, beyond an end, how far the shape faces the point.
type Measured = (f64, [f64; 3], usize, bool, f64);

/// A box of the tree: its children, or for a leaf (`count` above 0) its shapes in `order`.
#[derive(Clone, Copy, Debug)]
struct Node {
    low: [f64; 3],
    high: [f64; 3],
    first: u32,
    count: u32,
}

/// Shapes and the tree of boxes around them.
#[derive(Clone, Debug)]
pub struct Nearest {
    shapes: Vec<Shape>,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

const LEAF: usize = 4;
/// Squares of distances that differ by no more than rounding count as equal.
const TIE: f64 = 1e-12;

impl Nearest {
    /// None without shapes.
    pub fn new(shapes: Vec<Shape>) -> Option<Nearest> {
        if shapes.is_empty() {
            return None;
        }
        let boxes: Vec<_> = shapes.iter().map(bounds).collect();
        let order = (0..shapes.len() as u32).collect();
        let mut nearest = Nearest { shapes, order, nodes: Vec::new() };
        nearest.nodes.push(nearest.around(&boxes, 0, boxes.len()));
        let mut open = vec![(0_usize, 0_usize, boxes.len())];
        while let Some((node, from, to)) = open.pop() {
            if to - from <= LEAF {
                nearest.nodes[node].first = from as u32;
                nearest.nodes[node].count = (to - from) as u32;
                continue;
            }
            let axis = widest(&nearest.nodes[node]);
            let middle = (from + to) / 2;
            let centre = |i: &u32| boxes[*i as usize].0[axis] + boxes[*i as usize].1[axis];
            nearest.order[from..to].select_nth_unstable_by(middle - from, |a, b| centre(a).total_cmp(&centre(b)));
            let left = nearest.nodes.len();
            nearest.nodes[node].first = left as u32;
            for (a, b) in [(from, middle), (middle, to)] {
                nearest.nodes.push(nearest.around(&boxes, a, b));
            }
            open.extend([(left, from, middle), (left + 1, middle, to)]);
        }
        Some(nearest)
    }

    fn around(&self, boxes: &[([f64; 3], [f64; 3])], from: usize, to: usize) -> Node {
        let mut node = Node { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], first: 0, count: 0 };
        for i in &self.order[from..to] {
            let (low, high) = boxes[*i as usize];
            for k in 0..3 {
                node.low[k] = node.low[k].min(low[k]);
                node.high[k] = node.high[k].max(high[k]);
            }
        }
        node
    }

    /// The nearest point to `p`. `near` remembers the last answer: along a path most questions need no search.
    pub fn find(&self, p: [f64; 3], near: &mut Near) -> Found {
        let guess = self.measured(near.shape.min(self.shapes.len() - 1), p);
        let gone = minus(p, near.at);
        // no other shape can have come nearer than by the way gone since
        let best = if guess.0.sqrt() * (1.0 + 1e-9) < near.second - dot(gone, gone).sqrt() {
            guess
        } else {
            let (best, second) = self.search(p, guess);
            *near = Near { shape: best.2, at: p, second: second.sqrt() };
            best
        };
        Found { distance: best.0.sqrt(), foot: best.1, shape: best.2, beyond: best.3 }
    }

    /// The nearest shape, and the square of the distance of the one behind it.
    fn search(&self, p: [f64; 3], guess: Measured) -> (Measured, f64) {
        let (mut best, mut second) = (guess, f64::INFINITY);
        let mut stack = [0_u32; 128];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth] as usize];
            if outside(node, p) > second.max(best.0 * (1.0 + TIE)) {
                continue;
            }
            if node.count > 0 {
                let (from, to) = (node.first as usize, (node.first + node.count) as usize);
                for i in self.order[from..to].iter().filter(|i| **i as usize != guess.2) {
                    let other = self.measured(*i as usize, p);
                    if better(&other, &best) {
                        (second, best) = (best.0, other);
                    } else {
                        second = second.min(other.0);
                    }
                }
                continue;
            }
            // the nearer child is looked at first; a median tree of 2^32 shapes is 33 levels high
            let (left, right) = (node.first, node.first + 1);
            let swap = outside(&self.nodes[left as usize], p) < outside(&self.nodes[right as usize], p);
            stack[depth] = if swap { right } else { left };
            stack[depth + 1] = if swap { left } else { right };
            depth += 2;
        }
        (best, second)
    }

    /// Square of the distance, foot, shape, beyond an end, and how far the shape faces the point.
    fn measured(&self, shape: usize, p: [f64; 3]) -> Measured {
        let (foot, beyond) = foot(&self.shapes[shape], p);
        let off = minus(p, foot);
        (dot(off, off), foot, shape, beyond, facing(&self.shapes[shape], off))
    }

    /// Side of a closed surface on which `p` lies: + outside, by the winding of the triangle that was found.
    pub fn side(&self, found: &Found, p: [f64; 3]) -> f64 {
        match self.shapes[found.shape] {
            Shape::Triangle([a, b, c]) => dot(cross(minus(b, a), minus(c, a)), minus(p, found.foot)).signum(),
            _ => 1.0,
        }
    }
}

/// Nearer, or as near and facing the point better: at an edge only that triangle tells inside from outside.
fn better(a: &Measured, b: &Measured) -> bool {
    if (a.0 - b.0).abs() > TIE * (b.0 + b.0.sqrt()) {
        return a.0 < b.0;
    }
    if a.4 == b.4 { a.2 < b.2 } else { a.4 > b.4 }
}

fn facing(shape: &Shape, off: [f64; 3]) -> f64 {
    let Shape::Triangle([a, b, c]) = shape else { return 0.0 };
    let normal = cross(minus(*b, *a), minus(*c, *a));
    let length = dot(normal, normal).sqrt();
    if length > 0.0 { (dot(normal, off) / length).abs() } else { 0.0 }
}

fn widest(node: &Node) -> usize {
    let span = |k: usize| node.high[k] - node.low[k];
    (1..3).fold(0, |best, k| if span(k) > span(best) { k } else { best })
}

/// Square of the distance of a point from a box.
fn outside(node: &Node, p: [f64; 3]) -> f64 {
    (0..3).map(|k| (node.low[k] - p[k]).max(p[k] - node.high[k]).max(0.0).powi(2)).sum()
}

fn bounds(shape: &Shape) -> ([f64; 3], [f64; 3]) {
    let around = |points: &[[f64; 3]]| {
        let at = |k: usize, f: fn(f64, f64) -> f64| points.iter().map(|p| p[k]).reduce(f).unwrap_or(0.0);
        (std::array::from_fn(|k| at(k, f64::min)), std::array::from_fn(|k| at(k, f64::max)))
    };
    match shape {
        Shape::Segment(points) => around(points),
        Shape::Triangle(points) => around(points),
        Shape::Arc { center, radius, start, sweep } => around(&reached(*center, *radius, *start, *sweep)),
    }
}

/// Ends of an arc and the points between where it turns back in x or y.
fn reached(center: [f64; 2], radius: f64, start: f64, sweep: f64) -> Vec<[f64; 3]> {
    use std::f64::consts::FRAC_PI_2;
    let (from, to) = (start.min(start + sweep), start.max(start + sweep));
    let quarters = ((from / FRAC_PI_2).ceil() as i64..=(to / FRAC_PI_2).floor() as i64).take(5);
    let angles = [from, to].into_iter().chain(quarters.map(|k| k as f64 * FRAC_PI_2));
    angles.map(|a| [center[0] + radius * a.cos(), center[1] + radius * a.sin(), 0.0]).collect()
}

fn foot(shape: &Shape, p: [f64; 3]) -> ([f64; 3], bool) {
    match *shape {
        Shape::Segment([a, b]) => on_segment(a, b, p),
        Shape::Arc { center, radius, start, sweep } => on_arc(center, radius, start, sweep, p),
        Shape::Triangle([a, b, c]) => on_triangle(a, b, c, p),
    }
}

fn on_segment(a: [f64; 3], b: [f64; 3], p: [f64; 3]) -> ([f64; 3], bool) {
    let along = minus(b, a);
    let square = dot(along, along);
    let t = if square > 0.0 { dot(along, minus(p, a)) / square } else { 0.0 };
    let clamped = t.clamp(0.0, 1.0);
    (std::array::from_fn(|k| a[k] + clamped * along[k]), (t - clamped).abs() * square.sqrt() > 1e-9)
}

fn on_arc(center: [f64; 2], radius: f64, start: f64, sweep: f64, p: [f64; 3]) -> ([f64; 3], bool) {
    use std::f64::consts::TAU;
    let (dx, dy) = (p[0] - center[0], p[1] - center[1]);
    let at = |angle: f64| [center[0] + radius * angle.cos(), center[1] + radius * angle.sin(), 0.0];
    let length = dx.hypot(dy);
    let angle = if length > 0.0 { dy.atan2(dx) } else { start };
    // from the start in the direction of the sweep
    let turned = if sweep >= 0.0 { angle - start } else { start - angle }.rem_euclid(TAU);
    let whole = sweep.abs();
    if turned <= whole || length == 0.0 {
        let scale = if length > 0.0 { radius / length } else { 0.0 };
        let foot = if length > 0.0 { [center[0] + dx * scale, center[1] + dy * scale, 0.0] } else { at(start) };
        return (foot, false);
    }
    // the gap behind the end is shared between end and start
    let (excess, to_start) = (turned - whole, TAU - turned);
    let foot = if excess <= to_start { at(start + sweep) } else { at(start) };
    (foot, excess.min(to_start) * radius > 1e-9)
}

/// Nearest point of a triangle (C. Ericson, Real-Time Collision Detection, 5.1.5: by regions of its corners and edges).
fn on_triangle(a: [f64; 3], b: [f64; 3], c: [f64; 3], p: [f64; 3]) -> ([f64; 3], bool) {
    let (ab, ac, ap) = (minus(b, a), minus(c, a), minus(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    let (bp, cp) = (minus(p, b), minus(p, c));
    let (d3, d4, d5, d6) = (dot(ab, bp), dot(ac, bp), dot(ab, cp), dot(ac, cp));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let normal = cross(ab, ac);
    let inside = va > 0.0 && vb > 0.0 && vc > 0.0 && dot(normal, normal) > 0.0;
    if inside {
        let scale = 1.0 / (va + vb + vc);
        let (v, w) = (vb * scale, vc * scale);
        return (std::array::from_fn(|k| a[k] + v * ab[k] + w * ac[k]), false);
    }
    // on the border: the nearest point of the three edges
    let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| on_segment(from, to, p).0);
    let square = |q: &[f64; 3]| dot(minus(p, *q), minus(p, *q));
    let nearest = edges.iter().copied().reduce(|x, y| if square(&y) < square(&x) { y } else { x });
    (nearest.unwrap_or(a), true)
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
