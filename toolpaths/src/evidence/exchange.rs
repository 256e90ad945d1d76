//! Whether a trace that is far off the path follows it with two axes swapped, or one reversed.

use super::At;
use crate::follower::{Follower, Place, Sample};
use crate::path::{Numbered, Path};

/// A trace this far off the path is tried, mm; and how far it must get before anything is said.
const TRY_MM: f64 = 0.02;
const SAY_MM: f64 = 0.1;
/// How near the path the exchanged position must be: a share of the deviation, and a little.
const NEAR: f64 = 0.01;
const NEAR_MM: f64 = 2e-3;
const LEAST_SAMPLES: u32 = 5;
/// Episodes that are kept, and axes that are tried.
const KEPT: usize = 16;
const AXES: usize = 6;

/// How far an exchanged position is looked for ahead, mm.
fn ahead(deviation: f64) -> f64 {
    4.0 * deviation + 1.0
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExchangeKind {
    Swapped,
    Reversed,
}

/// An episode off the path that an exchange of axes explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    pub kind: ExchangeKind,
    /// The axes; equal for a reversed one.
    pub axes: (usize, usize),
    /// Block in which it began, samples explained, largest deviation among them.
    pub at: Numbered,
    pub samples: u32,
    pub max_mm: f64,
}

#[derive(Clone, Debug)]
struct Hypothesis {
    kind: ExchangeKind,
    axes: (usize, usize),
    /// Exchanged about this position; None: about zero.
    pivot: Option<[f64; 2]>,
    follower: Follower,
    samples: u32,
    max_mm: f64,
    alive: bool,
}

impl Hypothesis {
    fn apply(&self, raw: &[f64], into: &mut [f64]) {
        into.copy_from_slice(raw);
        let (a, b) = self.axes;
        let [pa, pb] = self.pivot.unwrap_or_default();
        match self.kind {
            ExchangeKind::Swapped => {
                into[a] = pa + raw[b] - pb;
                into[b] = pb + raw[a] - pa;
            }
            ExchangeKind::Reversed => into[a] = 2.0 * pa - raw[a],
        }
    }
}

/// Watches one trace.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    last_quiet: Place,
    hypotheses: Vec<Hypothesis>,
    begun: bool,
    at: Numbered,
    max_mm: f64,
    exchanged: Vec<f64>,
    pub found: Vec<Exchange>,
}

impl Watch {
    /// Whether a sample with that deviation may look at more of the path than is known.
    pub fn is_short(&self, path: &Path, deviation: f64) -> bool {
        if deviation <= TRY_MM || self.found.len() >= KEPT || !deviation.is_finite() {
            return false;
        }
        let alive = self.hypotheses.iter().filter(|h| h.alive).map(|h| h.follower.s(path));
        let from = if self.begun { 0.0 } else { path.s_of(self.last_quiet) };
        alive.fold(from, f64::max) + ahead(deviation) >= path.length_mm()
    }
    /// First segment that is still looked at.
    pub fn first_segment(&self) -> usize {
        let alive = self.hypotheses.iter().filter(|h| h.alive).map(|h| h.follower.foot.segment);
        alive.min().unwrap_or(usize::MAX)
    }
    pub fn forget(&mut self, segments: usize) {
        // a place that is gone is no longer near: the first that is left stands for it
        let quiet = self.last_quiet;
        self.last_quiet =
            quiet.segment.checked_sub(segments).map_or(Place::default(), |segment| Place { segment, ..quiet });
        for h in &mut self.hypotheses {
            h.follower.foot.segment = h.follower.foot.segment.saturating_sub(segments);
        }
    }
    #[inline]
    pub fn quiet<const N: usize>(&mut self, at: &At<N>) {
        self.last_quiet = at.place;
        if self.begun {
            self.close();
        }
    }

    #[inline]
    pub fn add<const N: usize>(&mut self, path: &Path, at: &At<N>) {
        if at.deviation > TRY_MM && self.found.len() < KEPT && at.deviation.is_finite() {
            if !self.begun {
                self.begin(path, at);
            }
            self.follow(path, at);
        }
    }

    #[inline(never)]
    fn begin<const N: usize>(&mut self, path: &Path, at: &At<N>) {
        self.begun = true;
        self.max_mm = 0.0;
        self.exchanged.resize(at.raw.len(), 0.0);
        let segment = &path.segments[at.place.segment];
        self.at = path.numbered(at.place.segment);
        let left = if path.numbered(self.last_quiet.segment) == self.at {
            path.position(self.last_quiet.segment, self.last_quiet.t)
        } else {
            path.position(at.place.segment, 0.0)
        };
        let scale = |a: usize| path.scales[usize::from(segment.scale) * path.width + a];
        let alike = |a: usize, b: usize| scale(a) == scale(b) && scale(a) > 0.0;
        let axes = at.raw.len().min(AXES);
        for (a, b) in (0..axes).flat_map(|a| (a..axes).map(move |b| (a, b))).filter(|&(a, b)| alike(a, b)) {
            let kind = if a == b { ExchangeKind::Reversed } else { ExchangeKind::Swapped };
            for pivot in [None, Some([left[a], left[b]])] {
                let mut follower = Follower::default();
                follower.put(self.last_quiet);
                let (samples, max_mm) = (0, 0.0);
                self.hypotheses.push(Hypothesis { kind, axes: (a, b), pivot, follower, samples, max_mm, alive: true });
            }
        }
        self.hypotheses.sort_by_key(|h| h.kind == ExchangeKind::Reversed);
    }

    #[inline(never)]
    fn follow<const N: usize>(&mut self, path: &Path, at: &At<N>) {
        self.max_mm = self.max_mm.max(at.deviation);
        let row = path.segments[at.place.segment].scale;
        for h in self.hypotheses.iter_mut().filter(|h| h.alive) {
            h.apply(at.raw, &mut self.exchanged);
            let mut x = Sample::<N>::new(path, &self.exchanged, row);
            let cap = h.follower.s(path) + ahead(at.deviation);
            h.follower.step(path, &mut x, at.time_s, cap);
            h.alive = h.follower.d2.sqrt() <= NEAR * at.deviation + NEAR_MM;
            if h.alive {
                h.samples += 1;
                h.max_mm = h.max_mm.max(at.deviation);
            }
        }
    }

    /// The episode is over.
    pub fn close(&mut self) {
        let explains =
            |h: &&Hypothesis| h.samples >= LEAST_SAMPLES && h.max_mm >= SAY_MM && h.max_mm >= 0.5 * self.max_mm;
        // the first of those that explain most: swapped before reversed
        let most = self.hypotheses.iter().filter(explains).map(|h| h.samples).max().unwrap_or(0);
        if let Some(h) = self.hypotheses.iter().filter(explains).find(|h| h.samples == most) {
            let (samples, max_mm) = (h.samples, h.max_mm);
            self.found.push(Exchange { kind: h.kind, axes: h.axes, at: self.at, samples, max_mm });
        }
        self.hypotheses.clear();
        self.begun = false;
    }
}
