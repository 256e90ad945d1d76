//! The bridge to Python: columns and plain values across the border, the GIL released for all real work.

use pyo3::prelude::*;

mod chunk;
mod debug;
mod evidence;
mod geometry;
mod kernel;
mod listing;
mod machine;
mod motion;
mod paths;
mod pcap;
mod program;
mod record;
mod resources;
mod stimulus;
mod stream;
mod sympas;
mod toml;

/// Adds a submodule and makes `from cnc_front._native.NAME import X` work.
fn submodule(parent: &Bound<'_, PyModule>, name: &str, fill: fn(&Bound<'_, PyModule>) -> PyResult<()>) -> PyResult<()> {
    let py = parent.py();
    let module = PyModule::new(py, name)?;
    fill(&module)?;
    parent.add_submodule(&module)?;
    py.import("sys")?.getattr("modules")?.set_item(format!("cnc_front._native.{name}"), &module)
}

/// A panic becomes an exception, and the outermost layer says so in one line; only developers want the rest.
fn quiet_panics() {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if std::env::var_os("CNC_FRONT_DEBUG").is_some() {
            before(info);
        }
    }));
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    quiet_panics();
    submodule(module, "motion_kernel", kernel::fill)?;
    submodule(module, "gcode", program::fill)?;
    submodule(module, "sympas", sympas::fill)?;
    submodule(module, "toolpaths", paths::fill)?;
    submodule(module, "recording", record::fill)?;
    submodule(module, "files", toml::fill)
}
