//! Runs of which only parts follow a path: what rw_SymPas jobs spool, between direct moves, which have none.

use std::ops::Range;

use crate::path::Path;
use crate::tracker::{Chunk, PerSample, Tracker};

/// Motion commands that follow each other without a stop in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// First and last sample in which the set point is on them.
    pub begin: u64,
    pub end: u64,
    /// Its first motion command, counted from 0.
    pub command: usize,
    /// It is driven to its end: the load side is measured until the axes move again.
    pub settles: bool,
}

/// Feeds a tracker with those samples of a run that are on its path. The stretches rise and do not overlap.
#[derive(Clone, Debug)]
pub struct Stretches {
    list: Vec<Stretch>,
    next: usize,
    on: bool,
    last_dp: Vec<f64>,
}

impl Stretches {
    pub fn new(list: Vec<Stretch>) -> Stretches {
        Stretches { list, next: 0, on: false, last_dp: Vec::new() }
    }

    /// Measures those samples of a chunk that are on the path; the deviation of the others is 0. Only
    /// `out.actual_mm` is filled.
    pub fn feed(&mut self, tracker: &mut Tracker, chunk: &Chunk, out: &mut PerSample) {
        let (axes, mut from) = (tracker.path().axes(), 0);
        for k in 0..chunk.factor.len() {
            let (sample, was_on) = (chunk.first_sample + k as u64, self.on);
            let dp = &chunk.dp[k * axes..(k + 1) * axes];
            let begins = self.list.get(self.next).filter(|s| s.begin == sample).copied();
            if begins.is_some() || (was_on && !self.stays_on(tracker.path(), sample, dp)) {
                hand_on(tracker, chunk, axes, from..k, was_on, out);
                (from, self.on) = (k, false);
            }
            if let Some(stretch) = begins {
                // a load that still comes to rest at the end before stays measured there
                self.on = tracker.jump(stretch.command, was_on, dp);
                self.next += 1;
            }
            self.last_dp.clear();
            self.last_dp.extend_from_slice(dp);
        }
        hand_on(tracker, chunk, axes, from..chunk.factor.len(), self.on, out);
    }

    /// Behind its end a stretch is measured as long as its axes stand.
    fn stays_on(&self, path: &Path, sample: u64, dp: &[f64]) -> bool {
        let Some(stretch) = self.next.checked_sub(1).map(|i| self.list[i]) else { return false };
        let stands = || path.counted(stretch.command).zip(dp.iter().zip(&self.last_dp)).all(|(c, (a, b))| !c || a == b);
        sample <= stretch.end || (stretch.settles && stands())
    }
}

/// A part of a chunk, which is on the path or not.
fn hand_on(tracker: &mut Tracker, chunk: &Chunk, axes: usize, part: Range<usize>, on: bool, out: &mut PerSample) {
    if part.is_empty() {
        return;
    }
    let rows = part.start * axes..part.end * axes;
    let optional = |column: &[u32]| if column.is_empty() { 0..0 } else { part.clone() };
    let of_part = Chunk {
        first_sample: chunk.first_sample + part.start as u64,
        dp: &chunk.dp[rows.clone()],
        load: &chunk.load[rows.clone()],
        rp: &chunk.rp[rows],
        factor: &chunk.factor[part.clone()],
        v_plan: &chunk.v_plan[part.clone()],
        entry: &chunk.entry[optional(chunk.entry)],
        flags: &chunk.flags[optional(chunk.flags)],
    };
    if !on {
        return tracker.pass_by(&of_part);
    }
    let actual_mm = out.actual_mm.get_mut(part).unwrap_or(&mut []);
    tracker.feed(&of_part, &mut PerSample { actual_mm, ..Default::default() });
}

impl Path {
    /// The first segment of a motion command, counted from 0.
    fn segment_of(&self, command: usize) -> Option<usize> {
        let entry = |i: usize| self.block(self.segments[i].block).entry as usize;
        let (mut low, mut high) = (0, self.segments.len());
        while low < high {
            let middle = low.midpoint(high);
            if entry(middle) <= command { low = middle + 1 } else { high = middle }
        }
        (low < self.segments.len() && entry(low) == command + 1).then_some(low)
    }
    /// Which axes count for the length of a motion command.
    fn counted(&self, command: usize) -> impl Iterator<Item = bool> {
        let row = self.segment_of(command).map_or(0, |i| usize::from(self.segments[i].scale));
        self.scales[row * self.width..][..self.axes].iter().map(|scale| *scale > 0.0)
    }
}

impl Tracker {
    /// The set point begins a motion command, and the load side too unless it is still being measured at the end of the
    /// one before and that is where the command begins. False where the command has no path.
    fn jump(&mut self, command: usize, goes_on: bool, dp: &[f64]) -> bool {
        let Some(segment) = self.path().segment_of(command) else { return false };
        let continuous = goes_on && !self.path().is_apart(segment);
        self.put(segment, !continuous, dp);
        true
    }
}
