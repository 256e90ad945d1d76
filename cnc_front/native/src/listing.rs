//! Commands as they are spooled, as columns for Python.

use motion_kernel::axes::MAX_AXES;
use motion_kernel::listing::{Came, Row};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::kernel::Mcu;

#[pymethods]
impl Mcu {
    /// From now on spooled commands are listed; `advance` comes back early when `take_listing` is due.
    fn list_commands(&mut self) {
        self.kernel.list_commands();
    }

    /// Commands spooled since the last call, one row each (positions in axis units, velocities in mm and s), what the
    /// commands came to (`passed`: number, sample, 0 begun, 1 done or 2 cut), and how many spool functions were entered.
    fn take_listing<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let listing = self.kernel.take_listing();
        let (rows, axes) = (&listing.rows, self.kernel.machine().axes.len());
        let dict = PyDict::new(py);
        dict.set_item("name", rows.iter().map(|r| r.name).collect::<Vec<_>>())?;
        dict.set_item("number", column(py, rows, |r| r.number))?;
        dict.set_item("task", column(py, rows, |r| r.task))?;
        dict.set_item("line", column(py, rows, |r| r.line))?;
        dict.set_item("kind", column(py, rows, |r| r.kind))?;
        dict.set_item("axes", column(py, rows, |r| r.axes))?;
        for (name, of) in [
            ("phi", (|r: &Row| r.phi) as fn(&Row) -> f64),
            ("vl", |r| r.vl),
            ("ac", |r| r.ac),
            ("tvl", |r| r.tvl),
            ("rounding", |r| r.rounding),
        ] {
            dict.set_item(name, column(py, rows, of))?;
        }
        for (name, of) in [
            ("start", (|r: &Row| &r.start) as fn(&Row) -> &[f64; MAX_AXES]),
            ("target", |r| &r.target),
            ("radius", |r| &r.radius),
        ] {
            let values: Vec<f64> = rows.iter().flat_map(|r| of(r)[..axes].iter().copied()).collect();
            dict.set_item(name, values.into_pyarray(py).reshape([rows.len(), axes])?)?;
        }
        for (name, of) in [("center", (|r: &Row| &r.center) as fn(&Row) -> &[f64; 3]), ("normal", |r| &r.normal)] {
            let values: Vec<f64> = rows.iter().flat_map(|r| *of(r)).collect();
            dict.set_item(name, values.into_pyarray(py).reshape([rows.len(), 3])?)?;
        }
        let circle: Vec<u8> = rows.iter().flat_map(|r| r.circle).collect();
        dict.set_item("circle", circle.into_pyarray(py).reshape([rows.len(), 3])?)?;
        let came = |c: Came| match c {
            Came::Begun => 0_u8,
            Came::Done => 1,
            Came::Cut => 2,
        };
        let passed: Vec<(u32, u64, u8)> = listing.passed.iter().map(|&(n, sample, c)| (n, sample, came(c))).collect();
        dict.set_item("passed", passed)?;
        dict.set_item("functions", listing.functions)?;
        dict.set_item("lost", listing.lost)?;
        Ok(dict)
    }
}

fn column<'py, T: numpy::Element>(
    py: Python<'py>,
    rows: &[Row],
    of: impl Fn(&Row) -> T,
) -> Bound<'py, numpy::PyArray1<T>> {
    rows.iter().map(of).collect::<Vec<_>>().into_pyarray(py)
}
