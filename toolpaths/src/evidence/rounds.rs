//! Full circles of the path and how the load side drove them: extremes and means of the radius by angle.

use std::f64::consts::TAU;

use crate::follower::Place;
use crate::path::{Numbered, Path};
use crate::segment::Circle;

/// Classes of the angle on a circle.
const BINS: usize = 720;
/// Circles that are kept; a program with more is measured on its first ones.
const KEPT: usize = 64;
/// Centres and radii closer than that are the same, mm; and angles, rad.
const SAME_MM: f64 = 1e-6;
const SAME_RAD: f64 = 1e-9;

/// Radius minus nominal radius in one class of the angle, mm; angles of the extremes, rad from the first circle axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundBin {
    pub samples: u32,
    pub sum: f64,
    pub min: f64,
    pub min_angle: f64,
    pub max: f64,
    pub max_angle: f64,
}

const EMPTY: RoundBin =
    RoundBin { samples: 0, sum: 0.0, min: f64::INFINITY, min_angle: 0.0, max: f64::NEG_INFINITY, max_angle: 0.0 };

/// A full circle: one block, or consecutive arcs about one centre.
#[derive(Clone, Debug)]
pub struct Round {
    /// Blocks, first and last.
    pub blocks: (Numbered, Numbered),
    pub axes: (usize, usize),
    /// In the metric of the path, mm.
    pub center: [f64; 2],
    pub radius: f64,
    /// Counter-clockwise, seen with the first axis to the right and the second upwards.
    pub ccw: bool,
    /// Programmed velocity, mm/s.
    pub vl: f64,
    pub bins: Vec<RoundBin>,
    segments: (usize, usize),
}

#[derive(Clone, Debug, Default)]
pub struct Rounds {
    rounds: Vec<Round>,
    at: usize,
    /// Segments that were looked at, and those that were forgotten; both count from the beginning of the path.
    scanned: usize,
    gone: usize,
}

impl Rounds {
    pub fn new(path: &Path) -> Rounds {
        let mut rounds = Rounds::default();
        rounds.scan(path, true);
        rounds
    }

    /// Looks for circles in what is new of a path; unless it is `whole`, arcs at its end may go on.
    pub fn scan(&mut self, path: &Path, whole: bool) {
        while self.scanned < self.gone + path.segments.len() && self.rounds.len() < KEPT {
            let first = self.scanned - self.gone;
            let Some(circle) = path.circles.get(path.segments[first].circle as usize) else {
                self.scanned += 1;
                continue;
            };
            let mut last = first;
            let mut turned = turn(path, first);
            while last + 1 < path.segments.len() && same(circle, path, last + 1) {
                last += 1;
                turned += turn(path, last);
            }
            if last + 1 == path.segments.len() && !whole {
                return;
            }
            if turned >= TAU - SAME_RAD && !circle.helical && circle.is_plane() {
                let round = round(path, circle, first, last);
                let segments = (first + self.gone, last + self.gone);
                self.rounds.push(Round { segments, ..round });
            }
            self.scanned = self.gone + last + 1;
        }
    }
    /// Whether it is not yet known if the segment belongs to a circle.
    #[inline]
    pub fn is_open(&self, segment: usize) -> bool {
        segment + self.gone >= self.scanned && self.rounds.len() < KEPT
    }
    pub fn forget(&mut self, segments: usize) {
        self.gone += segments;
    }

    /// A load-side sample with its foot.
    #[inline]
    pub fn add<const N: usize>(&mut self, place: Place, x: &[f64; N]) {
        let Some(round) = self.rounds.get_mut(self.at) else { return };
        let segment = place.segment + self.gone;
        if segment < round.segments.0 {
            return;
        }
        if segment > round.segments.1 {
            self.at += 1;
            return self.add(place, x);
        }
        // at the very ends the machine comes from elsewhere
        if segment == round.segments.0 && place.t <= 0.0 {
            return;
        }
        if round.bins.is_empty() {
            round.bins = vec![EMPTY; BINS];
        }
        let (dx, dy) = (x[round.axes.0] - round.center[0], x[round.axes.1] - round.center[1]);
        let (angle, off) = (dy.atan2(dx).rem_euclid(TAU), dx.hypot(dy) - round.radius);
        let bin = &mut round.bins[((angle * (BINS as f64 / TAU)) as usize).min(BINS - 1)];
        bin.samples += 1;
        bin.sum += off;
        if off < bin.min {
            (bin.min, bin.min_angle) = (off, angle);
        }
        if off > bin.max {
            (bin.max, bin.max_angle) = (off, angle);
        }
    }

    pub fn driven(&self) -> impl Iterator<Item = &Round> {
        self.rounds.iter().filter(|round| !round.bins.is_empty())
    }
}

fn turn(path: &Path, segment: usize) -> f64 {
    let circle = path.circles.get(path.segments[segment].circle as usize);
    circle.map_or(0.0, |c| path.segments[segment].length * c.rate.abs())
}

fn same(circle: &Circle, path: &Path, segment: usize) -> bool {
    path.circles.get(path.segments[segment].circle as usize).is_some_and(|c| {
        let off = (c.center[0] - circle.center[0]).hypot(c.center[1] - circle.center[1]);
        (c.c1, c.c2, c.helical, c.ring) == (circle.c1, circle.c2, circle.helical, circle.ring)
            && c.rate.signum() == circle.rate.signum()
            && off.max((c.radius - circle.radius).abs()) <= SAME_MM
    })
}

fn round(path: &Path, c: &Circle, first: usize, last: usize) -> Round {
    let begin = &path.segments[first];
    Round {
        blocks: (path.numbered(first), path.numbered(last)),
        axes: (c.c1, c.c2),
        center: c.center,
        radius: c.radius,
        ccw: c.rate > 0.0,
        vl: begin.speed,
        bins: Vec::new(),
        segments: (first, last),
    }
}
