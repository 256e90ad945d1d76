//! Short lines that become one (docs/dialect.md, section 9, design D6).

use crate::group::{ContourGroup, Point};
use crate::sink::Motion;

/// Bound on the work per block.
const MAX_PASSED: usize = 256;

/// A point that a merged line may pass over.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passed {
    pub line: u32,
    pub point: Point,
    pub slack: f64,
}

/// Short lines waiting to become one.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub start: Point,
    pub last: Motion,
    pub passed: Vec<Passed>,
    pub time: f64,
    pub same_speed: bool,
    pub deviation: f64,
}

/// What merging did, for the report (design 3.2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Merged {
    /// Blocks that were replaced.
    pub blocks: u64,
    pub max_mm: f64,
}

impl Run {
    pub fn speed(&self, length: f64) -> f64 {
        if self.same_speed { self.last.vl } else { length / self.time }
    }
    /// The largest distance of a passed point from the chord to the new end, if that is within tolerance.
    pub fn accepts(&self, motion: &Motion, group: &ContourGroup) -> Option<f64> {
        if motion.tolerance != self.last.tolerance || motion.ac != self.last.ac || self.passed.len() >= MAX_PASSED {
            return None;
        }
        let end = group.distance(&self.start, &motion.target);
        if end == 0.0 {
            return None;
        }
        let newest = Passed { line: self.last.line, point: self.last.target, slack: self.last.slack };
        let (mut deviation, mut before) = (motion.slack, 0.0);
        for passed in self.passed.iter().chain([&newest]) {
            let (mut along, mut square) = (0.0, 0.0);
            for (slot, axis) in group.axes.iter().enumerate() {
                let d = (passed.point[slot] - self.start[slot]) * axis.metric;
                along += d * (motion.target[slot] - self.start[slot]) * axis.metric;
                square += d * d;
            }
            along /= end;
            let distance = (square - along * along).max(0.0).sqrt() + passed.slack.max(motion.slack);
            if distance > motion.tolerance || along < before || along > end {
                return None;
            }
            before = along;
            deviation = distance.max(deviation);
        }
        Some(deviation)
    }
    pub fn extend(&mut self, motion: &Motion, time: f64, deviation: f64) {
        self.passed.push(Passed { line: self.last.line, point: self.last.target, slack: self.last.slack });
        self.same_speed &= motion.vl == self.last.vl;
        self.last = *motion;
        self.time += time;
        self.deviation = self.deviation.max(deviation);
    }
}
