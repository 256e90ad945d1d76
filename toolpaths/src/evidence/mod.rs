//! What a diagnosis needs to know of a run beside its deviations: sums in bounded memory, gathered sample by sample.
//!
//! Nothing is judged here. [`axes`] relates what an axis falls behind to its motion, [`blocks`] fits shifts and centres
//! to blocks that lie off the path, [`exchange`] tries whether axes were swapped, [`rounds`] collects full circles.

mod axes;
mod blocks;
mod exchange;
mod rounds;

pub use axes::{AxisFit, HISTOGRAM_BINS, MOTION, bin_edge};
pub use blocks::{AxisShare, BlockFit, CONIC, HARMONICS};
pub use exchange::{Exchange, ExchangeKind};
pub use rounds::{Round, RoundBin};

use blocks::Off;
use exchange::Watch;
use rounds::Rounds;

use crate::follower::{Follower, Place};
use crate::path::Path;

/// Deviations below this are not looked at: rounding for set points, the quiet run of a loop for the load side, mm.
pub const QUIET_SETPOINT_MM: f64 = 1e-6;
pub const QUIET_ACTUAL_MM: f64 = 1e-3;

/// One trace's sample on the path.
#[derive(Clone, Copy)]
pub struct At<'a, const N: usize> {
    pub place: Place,
    /// Position in the metric of the path (mm) and in axis units.
    pub x: &'a [f64; N],
    pub raw: &'a [f64],
    pub deviation: f64,
    /// Profile time since the last sample, s, and velocity of the foot, mm/s.
    pub time_s: f64,
    pub speed: f64,
}

/// Evidence of one trace: set points or load side.
#[derive(Clone, Debug)]
pub struct TraceEvidence {
    quiet_mm: f64,
    /// Runs on the chords of merged blocks, and so beside the path as programmed.
    on_chords: bool,
    off: Off,
    watch: Watch,
}

impl TraceEvidence {
    fn new(path: &Path, quiet_mm: f64, on_chords: bool) -> TraceEvidence {
        TraceEvidence { quiet_mm, on_chords, off: Off::new(path.axes()), watch: Watch::default() }
    }

    #[inline]
    pub fn add<const N: usize>(&mut self, path: &Path, at: &At<N>) {
        self.off.visit(path, at.place.segment);
        if at.deviation <= self.quiet_mm.max(if self.on_chords { path.merged_near(at.place.segment) } else { 0.0 }) {
            self.off.weigh(path, at);
            self.watch.quiet(at);
        } else {
            self.off.add(path, at);
            self.watch.add(path, at);
        }
    }

    fn finish(&mut self) {
        self.off.flush();
        self.watch.close();
    }

    /// Blocks that were off the path almost everywhere, the furthest first.
    pub fn blocks(&self) -> &[BlockFit] {
        &self.off.fits
    }
    /// Per axis, over all samples off the path.
    pub fn axes(&self) -> &[AxisShare] {
        &self.off.axes
    }
    pub fn exchanges(&self) -> &[Exchange] {
        &self.watch.found
    }
}

/// All evidence of a run.
#[derive(Clone, Debug)]
pub struct Evidence {
    pub setpoint: TraceEvidence,
    pub actual: TraceEvidence,
    /// Per axis of the machine.
    pub axes: Vec<AxisFit>,
    rounds: Rounds,
}

impl Evidence {
    pub fn new(path: &Path, sample_time_s: f64) -> Evidence {
        let fit = |&start: &f64| AxisFit::new(start, sample_time_s);
        Evidence {
            setpoint: TraceEvidence::new(path, QUIET_SETPOINT_MM, true),
            actual: TraceEvidence::new(path, QUIET_ACTUAL_MM, false),
            axes: path.start().iter().map(fit).collect(),
            rounds: Rounds::new(path),
        }
    }

    /// Set points and load-side positions of one sample, in axis units.
    #[inline]
    pub fn add_axes(&mut self, dp: &[f64], load: &[f64]) {
        for (axis, (dp, load)) in self.axes.iter_mut().zip(dp.iter().zip(load)) {
            axis.add(*dp, dp - load);
        }
    }

    /// The run begins elsewhere than its path.
    pub fn begin(&mut self, dp: &[f64]) {
        self.axes.iter_mut().zip(dp).for_each(|(axis, &dp)| axis.begin(dp));
    }

    #[inline]
    pub fn add_actual<const N: usize>(&mut self, path: &Path, at: &At<N>) {
        self.actual.add(path, at);
        self.rounds.add(at.place, at.x);
    }

    /// The path has grown; `whole`: to its end.
    pub(crate) fn grown(&mut self, path: &Path, whole: bool) {
        self.rounds.scan(path, whole);
    }
    /// First segment that is still looked at.
    pub(crate) fn first_segment(&self) -> usize {
        self.setpoint.watch.first_segment().min(self.actual.watch.first_segment())
    }
    pub(crate) fn forget(&mut self, segments: usize) {
        self.rounds.forget(segments);
        self.setpoint.watch.forget(segments);
        self.actual.watch.forget(segments);
    }
    /// Whether more of the path must be known before a sample counts: of a set point, or of the load side.
    #[inline]
    pub(crate) fn is_short(&self, path: &Path, at: &Follower, actual: bool) -> bool {
        let (watch, deviation) = (if actual { &self.actual.watch } else { &self.setpoint.watch }, at.d2.sqrt());
        actual && self.rounds.is_open(at.foot.segment) || watch.is_short(path, deviation)
    }

    pub fn finish(&mut self) {
        self.setpoint.finish();
        self.actual.finish();
    }

    /// Full circles of the path that were driven, in their order.
    pub fn rounds(&self) -> impl Iterator<Item = &Round> {
        self.rounds.driven()
    }
}
