//! A stimulus for Python: the world outside of the controller, from its text to a run; and the graphic system analysis.

use std::collections::BTreeMap;
use std::sync::Arc;

use motion_kernel::analysis::{ANALYSIS_COLUMNS, LatchInfos};
use motion_kernel::stimulus;
use pyo3::prelude::*;

use crate::kernel::{Mcu, set};
use crate::machine::{Machine, error_of};

/// The rules of a stimulus for the axes of one machine.
#[pyclass(frozen, module = "cnc_front._native.motion_kernel")]
pub struct Stimulus {
    inner: Arc<stimulus::Stimulus>,
}

#[pymethods]
impl Stimulus {
    /// Reads the bytes of a stimulus file; raises MachineError with all findings.
    #[staticmethod]
    fn parse(bytes: &[u8], filename: &str, machine: &Machine) -> PyResult<Stimulus> {
        let parsed = stimulus::Stimulus::read(bytes, &machine.inner);
        parsed.map(|inner| Stimulus { inner: Arc::new(inner) }).map_err(|list| error_of(list, filename))
    }
    fn __len__(&self) -> usize {
        self.inner.rules.len()
    }
}

#[pymethods]
impl Mcu {
    /// From now on these rules act too; their times count from boot.
    fn add_stimulus(&mut self, stimulus: &Stimulus) {
        self.kernel.add_stimulus(&stimulus.inner);
    }
    /// Records axes in step: after `lst` s, for `let` s. False: no axis, or no times.
    fn lprs(&mut self, axes: Vec<usize>, lst: f64, r#let: f64) -> PyResult<bool> {
        Ok(self.kernel.lprs(set(&axes)?, &LatchInfos { san: 0, lst, let_: r#let }))
    }
    /// First sample, samples from value to value, and the columns of an axis.
    fn analysis(&self, axis: usize) -> (u64, u64, BTreeMap<&'static str, Vec<f64>>) {
        let analysis = self.kernel.analysis();
        let column = |name: &&'static str| (*name, analysis.column(axis, name).unwrap_or_default());
        (analysis.first_sample, analysis.every, ANALYSIS_COLUMNS.iter().map(column).collect())
    }
    /// What the application does at a fault: tasks stop and all axes with them.
    fn stop_job(&mut self) {
        self.kernel.stop_job();
    }
}
