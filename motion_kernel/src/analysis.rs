//! The graphic system analysis (lpr, lprs; 4.4.25, 4.4.26): 1000 values of one or several axes, in step.

use crate::axes::AxisSet;
use crate::mcu::Mcu;

/// Values of a recording, of each column of each axis (6.3.1, LET).
pub const ANALYSIS_VALUES: usize = 1000;
/// What is recorded of an axis, in axis units, s and digits.
pub const ANALYSIS_COLUMNS: [&str; 5] = ["dp", "rp", "dv", "rv", "mcp"];

/// LATCH_INFOS: the axis (lpr only), when the recording begins after the call, and how long it is, s: rounded up to a
/// whole multiple of 1000 samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatchInfos {
    pub san: usize,
    pub lst: f64,
    pub let_: f64,
}

/// A recording, running or done.
#[derive(Debug, Default)]
pub struct Analysis {
    axes: AxisSet,
    /// First sample of the recording, and samples from one value to the next.
    pub first_sample: u64,
    pub every: u64,
    /// Values still to come.
    left: usize,
    /// Row-major: for each instant the columns of each axis.
    values: Vec<f64>,
}

impl Analysis {
    pub(crate) fn for_axes(axes: usize) -> Self {
        let most = axes * ANALYSIS_COLUMNS.len() * ANALYSIS_VALUES;
        Analysis { values: Vec::with_capacity(most), ..Analysis::default() }
    }
    pub fn axes(&self) -> AxisSet {
        self.axes
    }
    pub fn is_running(&self) -> bool {
        self.left > 0
    }
    /// One column of an axis, by its name in [`ANALYSIS_COLUMNS`].
    pub fn column(&self, axis: usize, name: &str) -> Option<Vec<f64>> {
        let position = self.axes.iter().position(|a| a == axis)?;
        let column = ANALYSIS_COLUMNS.iter().position(|c| *c == name)?;
        let (first, row) = (position * ANALYSIS_COLUMNS.len() + column, self.axes.len() * ANALYSIS_COLUMNS.len());
        Some(self.values.iter().skip(first).step_by(row).copied().collect())
    }
}

impl Mcu {
    /// Records one axis (lpr). False: no such axis, or times that are no times.
    pub fn lpr(&mut self, infos: &LatchInfos) -> bool {
        infos.san < self.axes.len() && self.lprs(AxisSet::single(infos.san), infos)
    }
    /// Records several axes in step (lprs), whatever `infos.san` says. A recording before is lost.
    pub fn lprs(&mut self, axes: AxisSet, infos: &LatchInfos) -> bool {
        let time = |s: f64| (0.0..=1e9).contains(&s);
        let axes = self.known(axes);
        if axes.is_empty() || !time(infos.lst) || !time(infos.let_) {
            return false;
        }
        let samples = (infos.let_ / self.ta).round().max(1.0) as u64;
        let every = samples.div_ceil(ANALYSIS_VALUES as u64);
        let analysis = &mut self.analysis;
        (analysis.axes, analysis.every) = (axes, every);
        analysis.first_sample = self.sample + (infos.lst / self.ta).round() as u64;
        analysis.left = ANALYSIS_VALUES;
        analysis.values.clear();
        self.attend_to(|attention| attention.recording = true);
        true
    }
    /// The recording of lpr or lprs so far.
    pub fn analysis(&self) -> &Analysis {
        &self.analysis
    }
    /// Behind a sample.
    #[cold]
    pub(crate) fn record_analysis(&mut self) {
        let analysis = &mut self.analysis;
        let sample = self.sample - 1; // the one that has just ended
        let due = sample.checked_sub(analysis.first_sample).is_some_and(|since| since % analysis.every == 0);
        if !due {
            return;
        }
        for a in analysis.axes.iter() {
            let (axis, position_loop) = (&self.axes[a], &self.loops[a]);
            let (dp, dv) = (axis.set_point(), axis.dv);
            let row = [dp, position_loop.rp(), dv, position_loop.rv(), f64::from(position_loop.mcp())];
            analysis.values.extend_from_slice(&row);
        }
        analysis.left -= 1;
        if analysis.left == 0 {
            self.attend_to(|attention| attention.recording = false);
        }
    }
}
