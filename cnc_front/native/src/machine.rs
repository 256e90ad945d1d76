//! The machine file, for Python.

use std::sync::Arc;

use motion_kernel::machine::{self, AxisKind};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

pyo3::create_exception!(
    motion_kernel,
    MachineError,
    PyValueError,
    "A machine file with findings: args[0] is a list of (file, line, column, end_column, id, message, hint)."
);

/// A validated machine file.
#[pyclass(frozen, module = "cnc_front._native.motion_kernel")]
pub struct Machine {
    pub inner: Arc<machine::Machine>,
}

pub type Row = (String, u32, u32, u32, String, String, String);

/// Findings as the error that carries their rows.
pub fn error_of(list: Vec<machine::MachineDiagnostic>, filename: &str) -> PyErr {
    let row = |d: machine::MachineDiagnostic| -> Row {
        (filename.to_owned(), d.line, d.column, d.end_column, d.id.to_owned(), d.message, d.hint)
    };
    MachineError::new_err((list.into_iter().map(row).collect::<Vec<Row>>(),))
}

#[pymethods]
impl Machine {
    /// Reads the bytes of a machine file; raises MachineError with all findings.
    #[staticmethod]
    fn parse(bytes: &[u8], filename: &str) -> PyResult<Machine> {
        let parsed = machine::Machine::parse(bytes);
        parsed.map(|inner| Machine { inner: Arc::new(inner) }).map_err(|list| error_of(list, filename))
    }
    /// The built-in 3-axis mill.
    #[staticmethod]
    fn builtin() -> Machine {
        Machine { inner: Arc::new(machine::Machine::builtin()) }
    }
    /// Text of the built-in machine file.
    #[staticmethod]
    fn builtin_text() -> &'static str {
        machine::BUILTIN
    }
    /// The resolved machine file with all defaults.
    fn show(&self) -> String {
        self.inner.show()
    }
    /// The same machine standing elsewhere at the start of a run, and with another work offset G54, both in machine
    /// coordinates per axis.
    fn placed(&self, start: Vec<f64>, g54: Vec<f64>) -> PyResult<Machine> {
        let mut inner = machine::Machine::clone(&self.inner);
        let is_place = |values: &[f64]| values.len() == inner.axes.len() && values.iter().all(|x| x.is_finite());
        if !is_place(&start) || !is_place(&g54) {
            return Err(PyValueError::new_err("a finite number for each axis"));
        }
        inner.axes.iter_mut().zip(start).for_each(|(axis, at)| axis.start = at);
        inner.gcode.offsets[0] = g54;
        Ok(Machine { inner: Arc::new(inner) })
    }
    /// Work offset G54 per axis.
    #[getter]
    fn g54(&self) -> Vec<f64> {
        self.inner.gcode.offsets[0].clone()
    }
    /// Highest path feed, mm/s.
    #[getter]
    fn feed_limit(&self) -> f64 {
        self.inner.gcode.feed_limit
    }
    /// Dry-run feed, mm/s.
    #[getter]
    fn dry_feed(&self) -> f64 {
        self.inner.gcode.dry_feed
    }
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }
    #[getter]
    fn tolerance_mm(&self) -> f64 {
        self.inner.tolerance_mm
    }
    #[getter]
    fn sample_time_us(&self) -> f64 {
        f64::from(self.inner.controller.sample_ticks) * 64.0
    }
    /// Memory of the spooler of an axis, bytes.
    #[getter]
    fn spool_memory_bytes(&self) -> u32 {
        self.inner.controller.spool_memory_bytes
    }
    #[getter]
    fn trovrst_s(&self) -> f64 {
        self.inner.gcode.trovrst_s
    }
    #[getter]
    fn axis_names(&self) -> Vec<String> {
        self.inner.axes.iter().map(|a| a.name.clone()).collect()
    }
    /// Address letter per axis, empty where part programs may not use it.
    #[getter]
    fn letters(&self) -> Vec<String> {
        self.inner.axes.iter().map(|a| a.letter.map(String::from).unwrap_or_default()).collect()
    }
    /// "linear" or "rotary" per axis.
    #[getter]
    fn kinds(&self) -> Vec<&'static str> {
        let word = |a: &machine::Axis| if a.kind == AxisKind::Linear { "linear" } else { "rotary" };
        self.inner.axes.iter().map(word).collect()
    }
    /// "mm" or "deg" per axis.
    #[getter]
    fn units(&self) -> Vec<&'static str> {
        self.inner.axes.iter().map(|a| if a.kind == AxisKind::Linear { "mm" } else { "deg" }).collect()
    }
    /// Axis units per count of the encoder.
    #[getter]
    fn resolution(&self) -> Vec<f64> {
        self.inner.axes.iter().map(|a| 1.0 / a.counts_per_unit).collect()
    }
    /// Following error limit per axis.
    #[getter]
    fn mpe(&self) -> Vec<f64> {
        self.inner.axes.iter().map(|a| a.mpe).collect()
    }
    /// Software limits per axis, None where there are none.
    #[getter]
    fn limits(&self) -> Vec<Option<(f64, f64)>> {
        self.inner.axes.iter().map(|a| a.limits.map(|l| (l.left, l.right))).collect()
    }
    /// Start position of a G-code run per axis.
    #[getter]
    fn start(&self) -> Vec<f64> {
        self.inner.axes.iter().map(|a| a.start).collect()
    }
    #[getter]
    fn effradius(&self) -> Vec<f64> {
        self.inner.axes.iter().map(|a| a.effradius).collect()
    }
    /// mdvel, maxvel, maxacc, rapid, acceleration per axis.
    fn dynamics(&self) -> Vec<(f64, f64, f64, f64, f64)> {
        self.inner.axes.iter().map(|a| (a.mdvel, a.maxvel, a.maxacc, a.rapid, a.acceleration)).collect()
    }
}
