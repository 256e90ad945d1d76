//! Blocks that lie off the path almost everywhere: sums from which a shift, a centre or a radius follow.

use super::At;
use crate::path::{Numbered, Path};
use crate::sequence::MAX_AXES;

/// Regressors of the radial deviation on a circle at angle a: cos a, sin a, 1.
pub const HARMONICS: usize = 3;
/// Regressors of v² on a conic about a circle, in its radii from its centre: u², u, v, 1.
pub const CONIC: usize = 4;
/// Fits that are kept, the furthest off.
const KEPT: usize = 64;
/// A block is off the path when this share of its samples is, and there are at least so many.
const MOST: f64 = 0.9;
const LEAST_SAMPLES: u32 = 3;
/// A foot that is held (at an end, or because it does not go back) is not below its sample: the way to it has more
/// than this share along the path.
const ASLANT: f64 = 1e-3;
/// One sample on the path of so many is weighed for all.
const EVERY: u32 = 8;

/// One block that was off the path. Offsets are position minus foot, mm, in the axes of the path.
#[derive(Clone, Copy, Debug)]
pub struct BlockFit {
    pub at: Numbered,
    /// Samples on it, off it, and those that were summed.
    pub samples: u32,
    pub off: u32,
    pub summed: u32,
    /// Sum of weights: the middle of a block counts most, since at its ends the machine swings in and out.
    pub weight: f64,
    pub offset: [f64; MAX_AXES],
    pub squares: f64,
    pub max: f64,
    /// Axes and radius of a circle; its radial deviation (outwards positive) as normal equations.
    pub circle: Option<(usize, usize, f64)>,
    pub normal: [f64; HARMONICS * (HARMONICS + 1) / 2],
    pub right: [f64; HARMONICS],
    pub radial_squares: f64,
    /// The same points as a conic (an ellipse along the axes), which tells scales of the two axes apart.
    pub conic_normal: [f64; CONIC * (CONIC + 1) / 2],
    pub conic_right: [f64; CONIC],
    pub conic_squares: f64,
    /// mm per axis unit on this block.
    pub scales: [f64; MAX_AXES],
}

impl Default for BlockFit {
    fn default() -> Self {
        BlockFit {
            at: Numbered { block: u32::MAX, line: 0 },
            samples: 0,
            off: 0,
            summed: 0,
            weight: 0.0,
            offset: [0.0; MAX_AXES],
            squares: 0.0,
            max: 0.0,
            circle: None,
            normal: [0.0; HARMONICS * (HARMONICS + 1) / 2],
            right: [0.0; HARMONICS],
            radial_squares: 0.0,
            conic_normal: [0.0; CONIC * (CONIC + 1) / 2],
            conic_right: [0.0; CONIC],
            conic_squares: 0.0,
            scales: [0.0; MAX_AXES],
        }
    }
}

impl BlockFit {
    /// A point at `u`, `v` radii from the centre of a circle.
    fn add_round(&mut self, weight: f64, radius: f64, [u, v]: [f64; 2]) {
        let rho = u.hypot(v);
        let radial = (rho - 1.0) * radius;
        add(&mut self.normal, &mut self.right, weight, [u / rho, v / rho, 1.0], radial);
        self.radial_squares += weight * radial * radial;
        add(&mut self.conic_normal, &mut self.conic_right, weight, [u * u, u, v, 1.0], v * v);
        self.conic_squares += weight * v.powi(4);
    }
    fn mean_square(&self) -> f64 {
        if self.weight > 0.0 { self.squares / self.weight } else { 0.0 }
    }
}

/// Adds one observation to normal equations (upper triangle, row by row).
fn add<const N: usize>(normal: &mut [f64], right: &mut [f64; N], weight: f64, x: [f64; N], value: f64) {
    let mut k = 0;
    for i in 0..N {
        for j in i..N {
            normal[k] += weight * x[i] * x[j];
            k += 1;
        }
        right[i] += weight * x[i] * value;
    }
}

/// Deviation against single causes of an axis. With offset e (normal to the path), position x and velocity v of the
/// axis, and w = 1 - (share of the axis in the tangent)²: sums that make the least squares of e = c + k * x and of
/// e = -lag * v. Samples on the path have no offset and count by their weights, one in [`EVERY`] of them for all.
#[derive(Clone, Copy, Debug, Default)]
pub struct AxisShare {
    pub w: f64,
    pub wx: f64,
    pub wxx: f64,
    pub e: f64,
    pub ex: f64,
    pub wvv: f64,
    pub ev: f64,
    /// Squares of all offsets, whatever their axis.
    pub squares: f64,
    /// Largest offset in this axis, its block, and mm per axis unit there.
    pub most: f64,
    pub at: Numbered,
    pub scale: f64,
}

impl AxisShare {
    #[inline]
    fn weigh(&mut self, samples: f64, x: f64, tangent: f64, speed: f64) {
        let w = samples * (1.0 - tangent * tangent);
        let v = tangent * speed;
        self.w += w;
        self.wx += w * x;
        self.wxx += w * x * x;
        self.wvv += w * v * v;
    }
}

#[derive(Clone, Debug)]
pub struct Off {
    current: BlockFit,
    pub fits: Vec<BlockFit>,
    pub axes: Vec<AxisShare>,
    visited: u32,
}

impl Off {
    pub fn new(axes: usize) -> Off {
        let axes = vec![AxisShare::default(); axes];
        Off { current: BlockFit::default(), fits: Vec::with_capacity(2 * KEPT), axes, visited: 0 }
    }

    #[inline]
    pub fn visit(&mut self, path: &Path, segment: usize) {
        let at = path.numbered(segment);
        if at.block != self.current.at.block {
            self.flush();
            self.current.at = at;
        }
        self.current.samples += 1;
    }

    pub fn flush(&mut self) {
        let done = self.current;
        if done.samples > 0 {
            self.current = BlockFit::default();
        }
        let most = f64::from(done.off) >= MOST * f64::from(done.samples);
        if most && done.summed >= LEAST_SAMPLES {
            self.fits.push(done);
            if self.fits.len() == 2 * KEPT {
                self.keep();
            }
        }
    }

    fn keep(&mut self) {
        self.fits.sort_by(|a, b| b.mean_square().total_cmp(&a.mean_square()).then(a.at.block.cmp(&b.at.block)));
        self.fits.truncate(KEPT);
    }

    /// Weighs a sample on the path.
    #[inline]
    pub fn weigh<const N: usize>(&mut self, path: &Path, at: &At<N>) {
        self.visited = self.visited.wrapping_add(1);
        if self.visited.is_multiple_of(EVERY) {
            self.add_weights(path, at);
        }
    }

    #[inline(never)]
    fn add_weights<const N: usize>(&mut self, path: &Path, at: &At<N>) {
        let (foot, tangent) = path.shape::<N>(at.place.segment).at(at.place.t);
        for (a, share) in self.axes.iter_mut().enumerate() {
            share.weigh(f64::from(EVERY), foot[a], tangent[a], at.speed);
        }
    }

    /// A sample off the path, on the block visited last.
    #[inline(never)]
    pub fn add<const N: usize>(&mut self, path: &Path, at: &At<N>) {
        let fit = &mut self.current;
        fit.off += 1;
        fit.max = fit.max.max(at.deviation);
        let segment = &path.segments[at.place.segment];
        let shape = path.shape::<N>(at.place.segment);
        let (foot, tangent) = shape.at(at.place.t);
        let along: f64 = (0..N).map(|a| (at.x[a] - foot[a]) * tangent[a]).sum();
        if !at.deviation.is_finite() || along.abs() > ASLANT * at.deviation {
            return;
        }
        let scales = &path.scales[usize::from(segment.scale) * N..usize::from(segment.scale) * N + N];
        if fit.summed == 0 {
            fit.scales[..N].copy_from_slice(scales);
        }
        fit.summed += 1;
        let share = at.place.t / segment.length;
        let weight = (4.0 * share * (1.0 - share)).powi(2);
        fit.weight += weight;
        fit.squares += weight * at.deviation * at.deviation;
        for (a, share) in self.axes.iter_mut().enumerate() {
            let (e, x) = (at.x[a] - foot[a], foot[a]);
            fit.offset[a] += weight * e;
            share.weigh(1.0, x, tangent[a], at.speed);
            share.e += e;
            share.ex += e * x;
            share.ev += e * tangent[a] * at.speed;
            share.squares += at.deviation * at.deviation;
            if e.abs() > share.most {
                (share.most, share.at, share.scale) = (e.abs(), path.numbered(at.place.segment), scales[a]);
            }
        }
        if let Some(c) = shape.circle.filter(|c| c.is_plane()) {
            let off = [at.x[c.c1] - c.center[0], at.x[c.c2] - c.center[1]];
            fit.circle = Some((c.c1, c.c2, c.radius));
            fit.add_round(weight, c.radius, off.map(|d| d / c.radius));
        }
    }
}
