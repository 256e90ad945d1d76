//! Samples as NumPy columns: the vectors of the trace move into the arrays, nothing is copied.

use motion_kernel::Stop;
use motion_kernel::mcu::TASKS;
use motion_kernel::resources::Scan;
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
    /// Rows of the scanner: a column for each of `scan_names` in order, and of each data block its bytes; empty without.
    pub scan: Py<PyArray2<f64>>,
    pub scan_names: Vec<String>,
    pub scan_blocks: Py<PyArray2<u8>>,
    /// Name, columns, rows and whether analog values follow, of each data block.
    pub scan_layout: Vec<(String, usize, usize, bool)>,
    /// What stands in the controller behind the last sample, for recordings (`recording::ColumnsView::standing`).
    pub standing: Vec<u32>,
}

impl Chunk {
    pub fn new(py: Python<'_>, trace: Trace, stop: Stop, standing: Vec<u32>) -> PyResult<Chunk> {
        let (samples, axes) = (trace.len(), trace.axes);
        let matrix = |column: Vec<f64>| column.into_pyarray(py).reshape([samples, axes]).map(Bound::unbind);
        let Scan { layout, values, blocks } = trace.scan;
        let bytes = layout.blocks.iter().map(|(_, block)| block.bytes()).sum();
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
            scan: values.into_pyarray(py).reshape([samples, layout.names.len()])?.unbind(),
            scan_names: layout.names.clone(),
            scan_blocks: blocks.into_pyarray(py).reshape::<_>([samples, bytes])?.unbind(),
            scan_layout: layout.blocks.iter().map(|(name, b)| (name.clone(), b.columns, b.rows, b.analog)).collect(),
            standing,
        })
    }
}

/// The words of `recording::ColumnsView::standing`.
pub fn standing(kernel: &motion_kernel::Mcu) -> Vec<u32> {
    let spoolers = kernel.status().axes.into_iter().flat_map(|axis| [axis.memory - axis.lsm, axis.mcis]);
    let lines = (0..TASKS).map(|task| kernel.task_status(task).csrcline);
    let speed = kernel.cd(kernel.machine().gcode.speed_cd as usize).to_bits();
    spoolers.chain(lines).chain([speed as u32, (speed >> 32) as u32]).collect()
}

#[pymethods]
impl Chunk {
    fn __len__(&self, py: Python<'_>) -> usize {
        self.flags.bind(py).len().unwrap_or(0)
    }
}
