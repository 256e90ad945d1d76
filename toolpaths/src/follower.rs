//! The foot point of a moving sample on the path: it moves forward only and never jumps to a neighbouring pass.
//!
//! Searched is a window ahead of the present foot, as long as the programmed velocities allow an advance in one
//! sample, twice over, plus a little. Four rules, in this order:
//! 1. the nearest point of the window; where several are equally near, the earliest;
//! 2. a sample that is off the path by d may round a corner: the window grows by a few d;
//! 3. a foot at the end of its window goes on while the distance falls (a lag being made up);
//! 4. a foot that stands although the sample moves away is stuck before a reversal or after a fault: the window
//!    opens up to the cap, and the first point ahead that is nearer is taken.
//!
//! The cap is where the foot can be at most. For set points it is the time that the foot has been stuck, at
//! programmed velocity; for the actual path, which lags, it is the set point's foot.

use crate::path::Path;
use crate::segment::{Nearest, Radial};

/// Distance by which windows exceed what velocities allow: corners of merged blocks, rounding.
pub const SLACK_MM: f64 = 0.02;
/// Advance allowed per sample, in multiples of what the programmed velocity gives.
pub const ADVANCE: f64 = 2.0;
/// Window growth in multiples of the distance from the path: less than a full turn of a circle even at its centre.
const CORNER_REACH: f64 = 4.0;
/// Distances closer than this are ties; rounding of coordinates of some metres stays well below.
const TIE_MM: f64 = 1e-10;
/// A sample closer than that is on the path.
const ON_PATH_D2: f64 = TIE_MM * TIE_MM;
/// A foot this close to the end of its window is at the end.
const ARRIVED_MM: f64 = 1e-9;

/// A place on the path: segment and arc length from its start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    pub segment: usize,
    pub t: f64,
}

/// A sample in the metric of the segment at hand; effective radii may change along the path.
#[derive(Clone, Copy, Debug)]
pub struct Sample<const N: usize> {
    raw: [f64; N],
    scaled: [f64; N],
    row: u16,
}

impl<const N: usize> Sample<N> {
    /// `row` of a trace in axis units, padded with zeros.
    #[inline]
    pub fn new(path: &Path, row: &[f64], scale_row: u16) -> Self {
        let raw: [f64; N] = match row.first_chunk::<N>() {
            Some(full) => *full,
            None => std::array::from_fn(|a| row.get(a).copied().unwrap_or(0.0)),
        };
        let mut sample = Sample { raw, scaled: raw, row: scale_row };
        sample.rescale(path, scale_row);
        sample
    }
    #[inline]
    fn rescale(&mut self, path: &Path, row: u16) {
        let scale = &path.scales[usize::from(row) * N..usize::from(row) * N + N];
        self.scaled = std::array::from_fn(|a| self.raw[a] * scale[a]);
        self.row = row;
    }
    #[inline]
    pub fn in_row(&mut self, path: &Path, row: u16) -> &[f64; N] {
        if row != self.row {
            self.rescale(path, row);
        }
        &self.scaled
    }
}

/// The nearest place found so far.
#[derive(Clone, Copy, Debug)]
struct Found {
    place: Place,
    d2: f64,
    radial: Radial,
}

/// Follows one trace along the path.
#[derive(Clone, Copy, Debug, Default)]
pub struct Follower {
    pub foot: Place,
    /// Squared distance of the last sample from the path.
    pub d2: f64,
    radial: Radial,
    /// Time for which the foot has been stuck, s (profile time).
    stuck_s: f64,
}

impl Follower {
    /// Path length at the foot.
    #[inline]
    pub fn s(&self, path: &Path) -> f64 {
        path.s_of(self.foot)
    }

    /// Moves the foot to the next sample. `time_s`: profile time since the last one. `cap_s`: path length that the
    /// foot cannot exceed, infinite if only time bounds it.
    #[inline]
    pub fn step<const N: usize>(&mut self, path: &Path, x: &mut Sample<N>, time_s: f64, cap_s: f64) {
        let reach = (path.reach(self.foot, ADVANCE * time_s) + SLACK_MM).min(cap_s);
        let before = self.foot;
        let last_d2 = self.d2;
        let found = nearest_until(path, x, before, reach, self.radial);
        self.take(found);
        if self.d2 > ON_PATH_D2 {
            self.look_further(path, x, before, last_d2, reach, time_s, cap_s);
        } else {
            self.stuck_s = 0.0;
        }
    }

    #[inline]
    fn take(&mut self, found: Found) {
        (self.foot, self.d2, self.radial) = (found.place, found.d2, found.radial);
    }

    /// Goes on from a place, whatever was before.
    pub fn begin(&mut self, foot: Place) {
        *self = Follower { foot, ..Follower::default() };
    }

    /// Sets the foot back to a place.
    pub fn put(&mut self, foot: Place) {
        (self.foot, self.radial) = (foot, None);
    }

    /// Signed distance of the sample from its foot in the plane; see [`Shape::left_of`](crate::segment::Shape).
    #[inline]
    pub fn left_of<const N: usize>(&self, path: &Path, x: &mut Sample<N>) -> f64 {
        let segment = &path.segments[self.foot.segment];
        let shape = path.shape::<N>(self.foot.segment);
        shape.left_of(segment.plane_scale, x.in_row(path, segment.scale), self.foot.t, self.radial)
    }

    /// Rules 2 to 4, for samples off the path.
    #[inline(never)]
    #[allow(clippy::too_many_arguments)]
    fn look_further<const N: usize>(
        &mut self,
        path: &Path,
        x: &mut Sample<N>,
        before: Place,
        last_d2: f64,
        reach: f64,
        time_s: f64,
        cap_s: f64,
    ) {
        let cap = cap_s.min(path.reach(before, ADVANCE * time_s + self.stuck_s) + SLACK_MM);
        let cap = if cap_s.is_finite() { cap_s } else { cap };
        let near = &path.segments[self.foot.segment];
        let corner = (path.s_of(self.foot) + CORNER_REACH * self.d2.sqrt()).max(reach).min(cap);
        // within a piece of one segment, what lies behind a foot before the window's end is further away
        let there = path.s_of(self.foot);
        let piece_end = there + path.shape::<N>(self.foot.segment).piece();
        let same_piece = corner <= (near.s0 + near.length).min(piece_end) && there < reach;
        if corner > reach && !same_piece {
            let from = path.place_near(self.foot, reach);
            let found = nearest_until(path, x, from, corner, None);
            if nearer(found.d2, self.d2) {
                self.take(found);
            }
        }
        if path.s_of(self.foot) >= corner - ARRIVED_MM && corner < cap {
            self.descend(path, x, cap);
        }
        let stands = self.foot == before;
        let leaves = nearer(last_d2, self.d2);
        if stands && (leaves || self.stuck_s > 0.0) {
            self.stuck_s += time_s;
            self.hop(path, x, cap);
        } else if path.s_of(self.foot) >= cap - ARRIVED_MM && !cap_s.is_finite() {
            self.stuck_s += time_s;
        } else {
            self.stuck_s = 0.0;
        }
    }

    /// Goes on from the foot while the distance falls.
    fn descend<const N: usize>(&mut self, path: &Path, x: &mut Sample<N>, cap: f64) {
        let mut from = self.foot;
        while let Some(piece) = path.piece_at::<N>(from, cap) {
            let near = path.nearest_in(x, piece, None);
            if near.t > piece.a && !nearer(near.d2, self.d2) {
                break;
            }
            if near.d2 <= self.d2 {
                self.take(near.on(piece));
            }
            if near.t < piece.b {
                break;
            }
            from = Place { segment: piece.segment, t: piece.b };
        }
    }

    /// Takes the first place ahead that is nearer than the present foot.
    fn hop<const N: usize>(&mut self, path: &Path, x: &mut Sample<N>, cap: f64) {
        let mut from = self.foot;
        let stuck_d2 = self.d2;
        while let Some(piece) = path.piece_at::<N>(from, cap) {
            let near = path.nearest_in(x, piece, None);
            if nearer(near.d2, stuck_d2) {
                self.take(near.on(piece));
                self.stuck_s = 0.0;
                return self.descend(path, x, cap);
            }
            from = Place { segment: piece.segment, t: piece.b };
        }
    }
}

/// Whether a squared distance is less than another by more than a tie.
#[inline]
fn nearer(d2: f64, than_d2: f64) -> bool {
    d2 < than_d2 && d2.sqrt() < than_d2.sqrt() - TIE_MM
}

/// Part of a segment on which the distance has one minimum.
#[derive(Clone, Copy)]
pub(crate) struct Piece {
    segment: usize,
    a: f64,
    b: f64,
}

impl Nearest {
    #[inline]
    fn on(self, piece: Piece) -> Found {
        Found { place: Place { segment: piece.segment, t: self.t }, d2: self.d2, radial: self.radial }
    }
}

/// The nearest place from `from` to path length `to`, ties earliest. `radial`: direction at `from`, if it is known.
#[inline]
fn nearest_until<const N: usize>(path: &Path, x: &mut Sample<N>, from: Place, to: f64, radial: Radial) -> Found {
    let here = Piece { segment: from.segment, a: from.t, b: from.t };
    let Some(first) = path.piece_at::<N>(from, to) else { return path.nearest_in(x, here, radial).on(here) };
    let radial = if first.segment == from.segment { radial } else { None };
    let mut best = path.nearest_in(x, first, radial).on(first);
    let mut last = first;
    while best.d2 > ON_PATH_D2 {
        let Some(piece) = path.piece_at::<N>(Place { segment: last.segment, t: last.b }, to) else { break };
        let near = path.nearest_in(x, piece, None);
        if nearer(near.d2, best.d2) {
            best = near.on(piece);
        }
        last = piece;
    }
    best
}

impl Path {
    #[inline]
    pub(crate) fn s_of(&self, place: Place) -> f64 {
        self.segments.get(place.segment).map_or(0.0, |s| s.s0 + place.t)
    }

    /// Path length that programmed velocity reaches from a place in a time.
    #[inline]
    pub(crate) fn reach(&self, from: Place, time_s: f64) -> f64 {
        let (mut left, mut t) = (time_s, from.t);
        for (i, segment) in self.segments.iter().enumerate().skip(from.segment) {
            let rest = (segment.length - t) * segment.slowness;
            if rest >= left {
                return segment.s0 + t + left * segment.speed;
            }
            if self.is_apart(i + 1) {
                return segment.s0 + segment.length;
            }
            left -= rest;
            t = 0.0;
        }
        self.end_seen.set();
        self.length_mm()
    }

    /// The place at path length `s`, which lies at or after `from`.
    fn place_near(&self, from: Place, s: f64) -> Place {
        let mut segment = from.segment;
        let ends_before = |i: usize| self.segments[i].s0 + self.segments[i].length < s;
        while segment + 1 < self.segments.len() && ends_before(segment) && !self.is_apart(segment + 1) {
            segment += 1;
        }
        if self.segments[segment].s0 + self.segments[segment].length < s {
            self.end_seen.set();
        }
        let t = (s - self.segments[segment].s0).clamp(0.0, self.segments[segment].length);
        if segment == from.segment { Place { segment, t: t.max(from.t) } } else { Place { segment, t } }
    }

    /// The next piece from a place on, not beyond path length `to`; None when there is nothing left.
    #[inline]
    fn piece_at<const N: usize>(&self, from: Place, to: f64) -> Option<Piece> {
        let mut at = from;
        if at.t >= self.segments[at.segment].length {
            at = Place { segment: at.segment + 1, t: 0.0 };
            if self.is_apart(at.segment) {
                return None;
            }
        }
        let Some(segment) = self.segments.get(at.segment) else {
            self.end_seen.set();
            return None;
        };
        let end = (to - segment.s0).min(segment.length);
        if end <= at.t {
            return None;
        }
        let b = end.min(at.t + self.shape::<N>(at.segment).piece());
        Some(Piece { segment: at.segment, a: at.t, b })
    }

    #[inline]
    fn nearest_in<const N: usize>(&self, x: &mut Sample<N>, piece: Piece, radial: Radial) -> Nearest {
        let row = self.segments[piece.segment].scale;
        self.shape::<N>(piece.segment).nearest(x.in_row(self, row), piece.a, piece.b, radial)
    }
}
