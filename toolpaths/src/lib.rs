//! The second opinion on a run: the path as programmed, built from the translated sequence by this crate's own
//! geometry, and how far set points and load-side positions stay from it, sample by sample.
//!
//! Shares no code with `motion_kernel`. Everything is measured in the metric of design D7: linear axes in mm,
//! a rotary axis as effradius times angle. [`Path`] is the programmed geometry before merging (design D20),
//! [`Tracker`] walks both traces along it with a foot point that moves forward only.

mod blocks;
mod chords;
mod deviation;
mod evidence;
mod feed;
mod follower;
mod growth;
mod limits;
mod nearest;
mod passages;
mod path;
mod removal;
mod ring;
mod segment;
mod sequence;
mod series;
mod stretches;
mod summary;
mod tracker;
mod watched;

pub use blocks::BlockStats;
pub use chords::{Chord, Chords};
pub use deviation::{DeviationSummary, Worst};
pub use evidence::{
    AxisFit, AxisShare, BlockFit, CONIC, Evidence, Exchange, ExchangeKind, HARMONICS, HISTOGRAM_BINS, MOTION, Round,
    RoundBin, TraceEvidence, bin_edge,
};
pub use feed::{FeedSummary, OverrideSummary};
pub use limits::{BlockLimit, Tally};
pub use nearest::{Found, Near, Nearest, Shape};
pub use passages::{Passage, Passages};
pub use path::{Block, Merged, Numbered, Path, Polyline};
pub use removal::{HeightMap, Met, Move, Passed, Profile, Watch};
pub use sequence::{PathError, SequenceView, Space};
pub use series::{LengthSeries, MinMax, TimeSeries};
pub use stretches::{Stretch, Stretches};
pub use summary::{FollowingError, Summary};
pub use tracker::{Chunk, PerSample, Tracker, TrackerOptions};
