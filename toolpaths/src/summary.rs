//! What a run measured, in figures.

use crate::deviation::DeviationSummary;
use crate::feed::{FeedSummary, OverrideSummary};
use crate::limits::Tally;
use crate::path::Merged;

/// Command minus encoder position of one axis, in axis units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FollowingError {
    pub max: f64,
    pub rms: f64,
}

/// The checks of a run (design 3.2).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    pub samples: u64,
    pub path_length_mm: f64,
    pub merged: Merged,
    pub setpoint: DeviationSummary,
    pub actual: DeviationSummary,
    /// Per axis of the machine.
    pub following_error: Vec<FollowingError>,
    pub feed: FeedSummary,
    pub override_: OverrideSummary,
    /// Largest distance along the path by which the load side lags the set point.
    pub lag_max_mm: f64,
    /// Path that the set point did not run, mm, and the source line at which it ended.
    pub missing_mm: f64,
    pub reached_line: u32,
    /// The set point reached the end of the path. A run stopped early is measured up to there.
    pub completed: bool,
    /// Samples per cause that limited the path velocity; they sum to `samples`.
    pub limits: Tally,
}
