//! The bridge to Python: columns and plain values across the border, the GIL released for all real work.

use pyo3::prelude::*;

mod chunk;
mod kernel;
mod machine;
mod paths;
mod program;
mod record;

/// Adds a submodule and makes `from cnc_front._native.NAME import X` work.
fn submodule(parent: &Bound<'_, PyModule>, name: &str, fill: fn(&Bound<'_, PyModule>) -> PyResult<()>) -> PyResult<()> {
    let py = parent.py();
    let module = PyModule::new(py, name)?;
    fill(&module)?;
    parent.add_submodule(&module)?;
    py.import("sys")?.getattr("modules")?.set_item(format!("cnc_front._native.{name}"), &module)
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    submodule(module, "motion_kernel", kernel::fill)?;
    submodule(module, "gcode", program::fill)?;
    submodule(module, "toolpaths", paths::fill)?;
    submodule(module, "recording", record::fill)
}
