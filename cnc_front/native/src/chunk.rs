//! Samples as NumPy columns: the vectors of the trace move into the arrays, nothing is copied.

use motion_kernel::Stop;
use motion_kernel::trace::Trace;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

/// Columns of some samples (see motion_kernel::trace): n samples, a axes.
#[pyclass(frozen, get_all, module = "cnc_front._native.motion_kernel")]
pub struct Chunk {
    pub first_sample: u64,
    /// Why the advance ended: "budget", "finished", "acknowledge", "held", "task_error", "fault", "events".
    pub stop: &'static str,
    /// Command of an acknowledge, axis of a fault, task of an error; else 0.
    pub stop_value: u32,
    pub dp: Py<PyArray2<f64>>,
    pub load: Py<PyArray2<f64>>,
    pub rp: Py<PyArray2<f64>>,
    pub line: Py<PyArray1<u32>>,
    pub entry: Py<PyArray1<u32>>,
    pub v_plan: Py<PyArray1<f64>>,
    pub factor: Py<PyArray1<f64>>,
    pub flags: Py<PyArray1<u32>>,
}

impl Chunk {
    pub fn new(py: Python<'_>, trace: Trace, stop: Stop) -> PyResult<Chunk> {
        let (samples, axes) = (trace.len(), trace.axes);
        let matrix = |column: Vec<f64>| column.into_pyarray(py).reshape([samples, axes]).map(Bound::unbind);
        let (stop, stop_value) = match stop {
            Stop::Budget => ("budget", 0),
            Stop::Finished => ("finished", 0),
            Stop::Acknowledge { command } => ("acknowledge", u32::from(command)),
            Stop::Held => ("held", 0),
            Stop::TaskError { task } => ("task_error", task as u32),
            Stop::Fault { axis } => ("fault", axis as u32),
            Stop::Events => ("events", 0),
        };
        Ok(Chunk {
            first_sample: trace.first_sample,
            stop,
            stop_value,
            dp: matrix(trace.dp)?,
            load: matrix(trace.load)?,
            rp: matrix(trace.rp)?,
            line: trace.line.into_pyarray(py).unbind(),
            entry: trace.entry.into_pyarray(py).unbind(),
            v_plan: trace.v_plan.into_pyarray(py).unbind(),
            factor: trace.factor.into_pyarray(py).unbind(),
            flags: trace.flags.into_pyarray(py).unbind(),
        })
    }
}

#[pymethods]
impl Chunk {
    fn __len__(&self, py: Python<'_>) -> usize {
        self.flags.bind(py).len().unwrap_or(0)
    }
}
