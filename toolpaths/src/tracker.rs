//! Walks set points and load-side positions along the programmed path, chunk by chunk, in bounded memory.

use std::sync::Arc;

use crate::blocks::BlockStats;
use crate::deviation::Deviations;
use crate::evidence::{At, Evidence};
use crate::feed::{FeedCheck, Interval, OverrideCheck};
use crate::follower::{ADVANCE, Follower, Place, SLACK_MM, Sample};
use crate::growth::Growth;
use crate::limits::{BlockLimit, Limits, Tally, limit_of};
use crate::passages::Passages;
use crate::path::{Path, WIDTHS};
use crate::segment::squared_distance;
use crate::series::{LengthSeries, TimeSeries};
use crate::summary::{FollowingError, Summary};
use crate::watched::Watched;

#[derive(Clone, Debug)]
pub struct TrackerOptions {
    pub sample_time_s: f64,
    /// Override schedule: machine seconds, factor. Empty: factor 1 throughout.
    pub schedule: Vec<(f64, f64)>,
    /// Time of an override change of 1.0, s (TROVRST).
    pub trovrst_s: f64,
    /// Buckets of the reduced curves over path length, and most of those over time.
    pub buckets: usize,
    /// Causes (the low bytes of their numbers) that mean full speed, one bit each.
    pub at_speed: u64,
    /// Also collects what a bound on the time of each motion command is computed from.
    pub passages: bool,
}

impl Default for TrackerOptions {
    fn default() -> Self {
        TrackerOptions {
            sample_time_s: 1.28e-3,
            schedule: Vec::new(),
            trovrst_s: 0.0,
            buckets: 4096,
            at_speed: 0,
            passages: false,
        }
    }
}

/// `n` samples of a run, `axes` values a row, in axis units. Samples follow each other without gap.
#[derive(Clone, Copy, Debug, Default)]
pub struct Chunk<'a> {
    pub first_sample: u64,
    /// (n, axes): set points, load-side positions, encoder positions.
    pub dp: &'a [f64],
    pub load: &'a [f64],
    pub rp: &'a [f64],
    /// (n): effective override, nominal path velocity at factor 1.
    pub factor: &'a [f64],
    pub v_plan: &'a [f64],
    /// (n): number of the motion command (from 1; 0 none), flags of the controller with the cause that limits the path
    /// velocity from bit 8 on;
    /// empty where there are none.
    pub entry: &'a [u32],
    pub flags: &'a [u32],
}

/// Results per sample, as far as the caller gives room for them: n values each, or empty.
#[derive(Debug, Default)]
pub struct PerSample<'a> {
    /// Deviation of the load side and of the set point, mm.
    pub actual_mm: &'a mut [f32],
    pub setpoint_mm: &'a mut [f32],
    /// Signed deviation of the load side in the plane, + = left, NaN without direction in the plane.
    pub signed_mm: &'a mut [f32],
    /// Path length at the foot of the load side and of the set point, mm.
    pub s_actual_mm: &'a mut [f64],
    pub s_setpoint_mm: &'a mut [f64],
    /// Number in [`Path::blocks`] of the block that the foot of the load side is on.
    pub block: &'a mut [u32],
}

/// How far the end of the path may be missed: rounding of stops to counts.
const END_MM: f64 = 1e-3;

/// A set point further from the path than rounding runs beside it, as on the chord of merged blocks.
const ON_PATH_MM: f64 = 1e-9;

/// Measures a run against a path. Feed chunks in order, then [`Tracker::finish`].
#[derive(Debug)]
pub struct Tracker {
    pub(crate) path: Arc<Path>,
    /// Where the rest of the path comes from.
    pub(crate) growth: Option<Growth>,
    options: TrackerOptions,
    samples: u64,
    pub(crate) setpoint: Trace,
    pub(crate) actual: Trace,
    last_dp: Vec<f64>,
    last_deviation: f64,
    samples_per_s: f64,
    feed: FeedCheck,
    overrides: OverrideCheck,
    following: Vec<(f64, f64)>,
    lag_max: f64,
    /// One per block; none where blocks are forgotten when they are behind.
    pub(crate) blocks: Vec<BlockStats>,
    pub(crate) over_length: LengthSeries,
    pub(crate) over_time: TimeSeries,
    /// Samples on no path, beside `samples`.
    passed: u64,
    watched: Watched,
    limits: Limits,
    passages: Passages,
    pub(crate) evidence: Evidence,
}

#[derive(Clone, Debug)]
pub(crate) struct Trace {
    pub follower: Follower,
    deviations: Deviations,
}

/// What the set point did in one interval.
struct Step {
    interval: Interval,
    speed: f64,
    programmed: f64,
    deviation: f64,
}

/// Where the load side is: its foot may be ahead of the set point's by an overshoot.
struct Measured {
    foot: Place,
    deviation: f64,
    signed: f64,
}

impl Tracker {
    pub fn new(path: Arc<Path>, options: TrackerOptions) -> Tracker {
        let trace = Trace { follower: Follower::default(), deviations: Deviations::new() };
        let blocks = path.segments.last().map_or(0, |s| s.block as usize + 1).max(path.blocks().len());
        Tracker {
            growth: None,
            samples: 0,
            setpoint: trace.clone(),
            actual: trace,
            last_dp: path.start().to_vec(),
            last_deviation: 0.0,
            samples_per_s: 1.0 / options.sample_time_s,
            feed: FeedCheck::default(),
            overrides: OverrideCheck::new(&options.schedule, options.trovrst_s, options.sample_time_s),
            following: vec![(0.0, 0.0); path.axes],
            lag_max: 0.0,
            blocks: vec![BlockStats::default(); blocks],
            over_length: LengthSeries::new(path.length_mm(), options.buckets),
            over_time: TimeSeries::new(path.axes, options.buckets),
            passed: 0,
            watched: Watched::default(),
            limits: Limits::new(options.buckets, options.at_speed),
            passages: Passages::new(path.axes),
            evidence: Evidence::new(&path, options.sample_time_s),
            path,
            options,
        }
    }

    /// Also collects the largest deviation per piece of a polyline, given by the path length at its vertices.
    pub fn watch(&mut self, s_mm: &[f64]) {
        self.limits.watch(s_mm);
        self.watched = Watched::new(s_mm);
    }

    /// Largest deviation of the load side on the piece that ends at each vertex of the watched polyline,
    /// NaN where it was not yet driven; and the vertex being approached.
    pub fn watched(&self) -> (&[f32], usize) {
        (&self.watched.max_mm, self.watched.at)
    }

    /// Signed deviation in the plane, + = left, where the values of [`Tracker::watched`] were found; NaN where the
    /// path has no direction in the plane.
    pub fn watched_signed(&self) -> &[f32] {
        &self.watched.signed_mm
    }

    /// Puts the foot of the set point, and with `both` that of the load side, to the start of a segment: the run is
    /// elsewhere now, and what was between is not measured.
    pub(crate) fn put(&mut self, segment: usize, both: bool, dp: &[f64]) {
        let place = Place { segment, t: 0.0 };
        self.setpoint.follower.begin(place);
        if both {
            self.actual.follower.begin(place);
        }
        self.last_deviation = 0.0;
        self.last_dp.copy_from_slice(dp);
    }

    /// Measures a chunk. The columns must have matching lengths (rows of `axes` values).
    pub fn feed(&mut self, chunk: &Chunk, out: &mut PerSample) {
        let n = chunk.factor.len();
        let rows = n * self.path.axes;
        assert!(chunk.dp.len() == rows && chunk.load.len() == rows && chunk.rp.len() == rows, "rows of the chunk");
        assert!(chunk.v_plan.len() == n, "columns of the chunk");
        match self.path.width {
            3 => self.feed_width::<{ WIDTHS[0] }>(chunk, out),
            4 => self.feed_width::<{ WIDTHS[1] }>(chunk, out),
            6 => self.feed_width::<{ WIDTHS[2] }>(chunk, out),
            _ => self.feed_width::<{ WIDTHS[3] }>(chunk, out),
        }
    }

    fn feed_width<const N: usize>(&mut self, chunk: &Chunk, out: &mut PerSample) {
        let mut path = Arc::clone(&self.path);
        let axes = path.axes;
        for k in 0..chunk.factor.len() {
            let row = k * axes..(k + 1) * axes;
            let (dp, load, rp) = (&chunk.dp[row.clone()], &chunk.load[row.clone()], &chunk.rp[row]);
            let sample = chunk.first_sample + k as u64;
            let step = loop {
                match self.advance_setpoint::<N>(&path, sample, dp, chunk.factor[k]) {
                    Some(step) => break step,
                    None => path = self.grow(path),
                }
            };
            let actual = loop {
                match self.advance_actual::<N>(&path, sample, load, chunk.factor[k]) {
                    Some(actual) => break actual,
                    None => path = self.grow(path),
                }
            };

            let time_s = (sample + 1) as f64 * self.options.sample_time_s;
            self.feed.add(&step.interval);
            self.overrides.add(time_s, &step.interval, chunk.v_plan[k], step.deviation);
            self.add_following(dp, rp);
            self.evidence.add_axes(dp, load);

            let (set_mm, actual_mm) = (step.deviation as f32, actual.deviation as f32);
            let (foot, signed) = (actual.foot, actual.signed);
            let (s_set, s_actual) = (self.setpoint.follower.s(&path), path.s_of(foot));
            self.lag_max = self.lag_max.max(s_set - s_actual);
            self.over_length.add(s_set, set_mm, s_actual, actual_mm, signed as f32);
            let curves = [step.speed, step.programmed, chunk.factor[k], actual.deviation];
            self.over_time.add(curves, dp, rp);
            self.watched.add(s_actual, actual_mm, signed as f32);
            let at = path.segments[self.setpoint.follower.foot.segment].block;
            let at = if self.growth.is_none() { at } else { 0 };
            self.limits.add(limit_of(chunk.flags.get(k).copied().unwrap_or(0)), at, s_set);
            if self.options.passages {
                let speed = (chunk.v_plan[k] * chunk.factor[k], chunk.factor[k]);
                self.passages.add(
                    sample,
                    chunk.entry.get(k).copied().unwrap_or(0),
                    s_set,
                    speed,
                    self.samples_per_s,
                    dp,
                );
            }

            put(out.actual_mm, k, actual_mm);
            put(out.setpoint_mm, k, set_mm);
            put(out.signed_mm, k, signed as f32);
            put(out.s_actual_mm, k, s_actual);
            put(out.s_setpoint_mm, k, s_set);
            put(out.block, k, path.segments[foot.segment].block);
        }
        self.samples += chunk.factor.len() as u64;
    }

    /// `None`: more of the path has to be known first.
    fn advance_setpoint<const N: usize>(&mut self, path: &Path, sample: u64, dp: &[f64], factor: f64) -> Option<Step> {
        let time_s = self.options.sample_time_s;
        let follower = self.setpoint.follower;
        let before = follower.foot;
        let row = path.segments.get(before.segment)?.scale;
        let mut x = Sample::<N>::new(path, dp, row);
        self.setpoint.follower.step(path, &mut x, time_s * factor, f64::INFINITY);
        if self.is_short(path, &self.setpoint.follower, false) {
            self.setpoint.follower = follower;
            return None;
        }
        let foot = self.setpoint.follower.foot;
        let segment = &path.segments[foot.segment];
        let deviation = distance(self.setpoint.follower.d2);
        let signed = self.setpoint.follower.left_of(path, &mut x);
        self.setpoint.deviations.add(deviation, signed, sample, || path.block(segment.block).line, dp);
        if let Some(stats) = self.blocks.get_mut(segment.block as usize) {
            stats.setpoint.add(deviation);
        }

        let length = path.s_of(foot) - path.s_of(before);
        let same_segment = foot.segment == before.segment;
        let programmed_s = match same_segment {
            true => length * segment.slowness,
            false => self.share_interval(path, before, foot, length),
        };
        let mut interval = Interval {
            time_s,
            factor,
            length,
            programmed_s,
            certain: length,
            rapid: path.block(segment.block).rapid,
            unambiguous: true,
            same_command: true,
        };
        let off = deviation.max(self.last_deviation) > ON_PATH_MM;
        if off || !same_segment {
            let last = *Sample::<N>::new(path, &self.last_dp, segment.scale).in_row(path, segment.scale);
            let travel = squared_distance(&last, x.in_row(path, segment.scale)).sqrt();
            let before_entry = path.block(path.segments[before.segment].block).entry;
            interval.judge(travel, off, before_entry == path.block(segment.block).entry, segment.slowness);
        }
        let speed = interval.length * self.samples_per_s;
        if same_segment {
            self.pass(segment.block, time_s, length, speed);
        }
        let x = x.in_row(path, segment.scale);
        let at = At { place: foot, x, raw: dp, deviation, time_s: time_s * factor, speed };
        self.evidence.setpoint.add(path, &at);
        self.last_deviation = deviation;
        self.last_dp.copy_from_slice(dp);
        Some(Step { interval, speed, programmed: segment.speed * factor, deviation })
    }

    /// Shares an interval out to the blocks that it crosses; returns the time their programmed velocities need.
    fn share_interval(&mut self, path: &Path, from: Place, to: Place, length: f64) -> f64 {
        let time_s = self.options.sample_time_s;
        let mut programmed_s = 0.0;
        if length <= 0.0 {
            self.pass(path.segments[to.segment].block, time_s, 0.0, 0.0);
            return programmed_s;
        }
        for i in from.segment..=to.segment {
            let segment = &path.segments[i];
            let a = if i == from.segment { from.t } else { 0.0 };
            let b = if i == to.segment { to.t } else { segment.length };
            programmed_s += (b - a) * segment.slowness;
            let share = (b - a) / length;
            self.pass(segment.block, time_s * share, b - a, length * self.samples_per_s);
        }
        programmed_s
    }
    #[inline]
    fn pass(&mut self, block: u32, time_s: f64, length: f64, speed: f64) {
        if let Some(stats) = self.blocks.get_mut(block as usize) {
            stats.pass(time_s, length, speed);
        }
    }

    /// `None`: more of the path has to be known first.
    fn advance_actual<const N: usize>(
        &mut self,
        path: &Path,
        sample: u64,
        load: &[f64],
        factor: f64,
    ) -> Option<Measured> {
        let time_s = self.options.sample_time_s;
        let set_foot = self.setpoint.follower.foot;
        let cap = path.reach(set_foot, ADVANCE * time_s * factor) + SLACK_MM;
        let mut follower = self.actual.follower;
        let row = path.segments[follower.foot.segment].scale;
        let mut x = Sample::<N>::new(path, load, row);
        let s_before = follower.s(path);
        follower.step(path, &mut x, time_s * factor, cap);
        if self.is_short(path, &follower, true) {
            return None;
        }
        let foot = follower.foot;
        let deviation = distance(follower.d2);
        let signed = follower.left_of(path, &mut x);
        if path.s_of(foot) > path.s_of(set_foot) {
            // an overshoot at a stop is given back
            follower.put(set_foot);
        }
        self.actual.follower = follower;
        let (block, row) = (path.segments[foot.segment].block, path.segments[foot.segment].scale);
        let speed = (path.s_of(foot) - s_before) * self.samples_per_s;
        let x = x.in_row(path, row);
        let at = At { place: foot, x, raw: load, deviation, time_s: time_s * factor, speed };
        self.evidence.add_actual(path, &at);
        self.actual.deviations.add(deviation, signed, sample, || path.block(block).line, load);
        if let Some(stats) = self.blocks.get_mut(block as usize) {
            stats.actual.add(deviation);
            stats.add_signed(signed);
        }
        Some(Measured { foot, deviation, signed })
    }

    #[inline]
    fn add_following(&mut self, dp: &[f64], rp: &[f64]) {
        for ((max, squares), (d, r)) in self.following.iter_mut().zip(dp.iter().zip(rp)) {
            let error = d - r;
            *max = if error.abs() > *max { error.abs() } else { *max };
            *squares += error * error;
        }
    }

    /// Samples that are on no path: what is told of axes, and over time, holds for them too.
    pub(crate) fn pass_by(&mut self, chunk: &Chunk) {
        let axes = self.path.axes;
        if self.samples + self.passed == 0 {
            self.evidence.begin(&chunk.dp[..axes]);
        }
        for (k, factor) in chunk.factor.iter().enumerate() {
            let row = k * axes..(k + 1) * axes;
            let (dp, load, rp) = (&chunk.dp[row.clone()], &chunk.load[row.clone()], &chunk.rp[row]);
            self.add_following(dp, rp);
            self.evidence.add_axes(dp, load);
            self.over_time.add([0.0, 0.0, *factor, 0.0], dp, rp);
            self.limits.add_beside(limit_of(chunk.flags.get(k).copied().unwrap_or(0)));
        }
        self.passed += chunk.factor.len() as u64;
    }

    /// The path that the run is measured against.
    pub fn path(&self) -> &Arc<Path> {
        &self.path
    }

    /// What was measured so far; call it after the last chunk.
    pub fn finish(&mut self) -> Summary {
        self.grow_to_end();
        self.over_time.finish();
        self.over_length.finish();
        self.limits.finish();
        self.evidence.finish();
        let path = &self.path;
        let foot = self.setpoint.follower.foot;
        let missing_mm = (path.length_mm() - path.s_of(foot)).max(0.0);
        let n = (self.samples + self.passed).max(1) as f64;
        Summary {
            samples: self.samples,
            path_length_mm: path.length_mm(),
            merged: path.merged(),
            setpoint: self.setpoint.deviations.summary(self.options.sample_time_s),
            actual: self.actual.deviations.summary(self.options.sample_time_s),
            following_error: self
                .following
                .iter()
                .map(|&(max, sq)| FollowingError { max, rms: (sq / n).sqrt() })
                .collect(),
            feed: self.feed.summary(self.options.sample_time_s),
            override_: self.overrides.summary(path.merged().max_mm),
            lag_max_mm: self.lag_max,
            missing_mm,
            reached_line: path.block(path.segments[foot.segment].block).line,
            completed: missing_mm <= END_MM,
            limits: self.limits.total.clone(),
        }
    }

    /// What a diagnosis needs; complete after [`Tracker::finish`].
    pub fn evidence(&self) -> &Evidence {
        &self.evidence
    }

    /// One row per block of [`Path::blocks`].
    pub fn blocks(&self) -> &[BlockStats] {
        &self.blocks[..self.path.blocks().len().min(self.blocks.len())]
    }
    /// What limited each block of [`Path::blocks`]; complete after [`Tracker::finish`].
    pub fn block_limits(&self) -> Vec<BlockLimit> {
        let mut blocks = self.limits.blocks.clone();
        blocks.resize(self.path.blocks().len(), BlockLimit::default());
        blocks
    }
    /// The cause of most of the piece that ends at each vertex of the watched polyline, 0 where it was not driven.
    pub fn watched_limits(&self) -> &[u16] {
        &self.limits.pieces
    }
    /// Causes over time, in buckets of so many samples; complete after [`Tracker::finish`].
    pub fn limits_over_time(&self) -> (u64, &[Tally]) {
        (self.limits.samples_per_bucket, &self.limits.buckets)
    }
    /// One passage per motion command, if they are collected.
    pub fn passages(&self) -> &Passages {
        &self.passages
    }
    pub fn over_length(&self) -> &LengthSeries {
        &self.over_length
    }
    /// Complete after [`Tracker::finish`].
    pub fn over_time(&self) -> &TimeSeries {
        &self.over_time
    }
}

/// A sample that is no number is as far from the path as can be, never unnoticed.
#[inline]
fn distance(d2: f64) -> f64 {
    if d2.is_nan() { f64::INFINITY } else { d2.sqrt() }
}

#[inline]
fn put<T>(column: &mut [T], k: usize, value: T) {
    if let Some(place) = column.get_mut(k) {
        *place = value;
    }
}
