//! `cnc_front._native.gcode`: part programs compiled to autocode.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use gcode::{At, Compiled, Library, Options, SequenceColumns};
use motion_kernel::autocode;
use motion_kernel::machine::{self, Profile};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::machine::{Machine, Row};
use crate::stream::Stream;

pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Program>()?;
    module.add_class::<Listing>()?;
    module.add_class::<Pieces>()?;
    module.add_class::<Stream>()?;
    module.add_class::<crate::stream::StreamListing>()?;
    module.add("MOST_CHANGES", gcode::MOST_CHANGES)?;
    module.add("MOST_BYTES", crate::stream::MOST_BYTES)?;
    module.add_function(wrap_pyfunction!(crate::stream::check_once, module)?)?;
    module.add_function(wrap_pyfunction!(catalogue, module)?)?;
    module.add_function(wrap_pyfunction!(compile, module)?)
}

/// Every id with its message (placeholders in braces) and hint.
#[pyfunction]
fn catalogue() -> Vec<(&'static str, &'static str, &'static str)> {
    gcode::CATALOGUE.iter().map(|(_, name, message, hint)| (*name, *message, *hint)).collect()
}

/// A compiled program and what is known about it.
#[pyclass(frozen, module = "cnc_front._native.gcode")]
pub struct Program {
    pub inner: Arc<autocode::Program>,
    pub machine: Arc<machine::Machine>,
}

/// Compiles a part program: (Program or None, diagnostics, facts). Diagnostics are rows of
/// (file, line, column, end_column, id, message, hint). Options: profile, optional_stop, block_delete (list of
/// levels), check_only, library (folder of subprograms), start and stop (a part: "N120" or a line), strict (linter),
/// dry_feed (mm/s, instead of F), mdi (no program end).
#[pyfunction]
#[pyo3(signature = (source, filename, machine, *, profile=None, optional_stop=false, block_delete=Vec::new(), check_only=false, library=None, start=None, stop=None, strict=false, dry_feed=None, mdi=false))]
#[allow(clippy::too_many_arguments)] // keyword options of one call
fn compile<'py>(
    py: Python<'py>,
    source: &[u8],
    filename: &str,
    machine: &Machine,
    profile: Option<&str>,
    optional_stop: bool,
    block_delete: Vec<u8>,
    check_only: bool,
    library: Option<PathBuf>,
    start: Option<&str>,
    stop: Option<&str>,
    strict: bool,
    dry_feed: Option<f64>,
    mdi: bool,
) -> PyResult<(Option<Program>, Vec<Row>, Bound<'py, PyDict>)> {
    let options = Options {
        profile: profile.map(profile_of).transpose()?,
        optional_stop,
        block_delete: levels(&block_delete),
        check_only,
        library: library.map(folder),
        from: start.map(block_at).transpose()?,
        to: stop.map(block_at).transpose()?,
        strict,
        dry_feed,
        mdi,
        ..Options::default()
    };
    let target = machine.inner.clone();
    let compiled = py.detach(|| gcode::compile(source, filename, &target, &options));
    let facts = facts_dict(py, &compiled, &target)?;
    let rows = rows(&compiled);
    let program = compiled.program.map(|inner| Program { inner: Arc::new(inner), machine: target });
    Ok((program, rows, facts))
}

/// Diagnostics as Python sees them.
pub fn rows(compiled: &Compiled) -> Vec<Row> {
    let row = |d: &gcode::Diagnostic| -> Row {
        (d.file.clone(), d.line, d.column, d.end_column, d.id.to_owned(), d.message.clone(), d.hint.to_owned())
    };
    compiled.diagnostics.iter().map(row).collect()
}

/// Levels of block delete as bits.
pub fn levels(levels: &[u8]) -> u16 {
    levels.iter().filter(|&&level| level < 10).fold(0, |bits, level| bits | 1 << level)
}

pub fn profile_of(name: &str) -> PyResult<Profile> {
    match name {
        "din" => Ok(Profile::Din),
        "fanuc" => Ok(Profile::Fanuc),
        "linuxcnc" => Ok(Profile::Linuxcnc),
        "lathe" => Ok(Profile::Lathe),
        _ => Err(PyValueError::new_err("profile is din, fanuc, linuxcnc or lathe")),
    }
}

/// `N120` is a block number, `120` a line.
pub fn block_at(text: &str) -> PyResult<At> {
    let digits = text.strip_prefix(['N', 'n']);
    let number = digits.unwrap_or(text).parse().map_err(|_| PyValueError::new_err(format!("'{text}' is no block")))?;
    Ok(if digits.is_some() { At::Block(number) } else { At::Line(number) })
}

/// Subprograms in the folder of the program; names never leave it (GC604).
pub fn folder(folder: PathBuf) -> Library {
    Arc::new(move |name: &str| {
        let plain = Path::new(name).file_name().is_some_and(|last| last == name);
        let file = folder.join(name);
        (plain && file.is_file()).then(|| std::fs::read(file).ok()).flatten()
    })
}

pub fn facts_dict<'py>(
    py: Python<'py>,
    compiled: &Compiled,
    machine: &machine::Machine,
) -> PyResult<Bound<'py, PyDict>> {
    let facts = &compiled.facts;
    let dict = PyDict::new(py);
    dict.set_item("lines", facts.lines)?;
    dict.set_item("blocks", facts.blocks)?;
    dict.set_item("motion_blocks", facts.motion_blocks)?;
    dict.set_item("tools", facts.tools.clone())?;
    let modal: Vec<(u32, &str)> = facts.modal.iter().map(|m| (m.0, facts.modal_texts[m.1 as usize].as_str())).collect();
    dict.set_item("modal", modal)?;
    dict.set_item("feeds", facts.feeds.clone())?;
    dict.set_item("looks_back", facts.looks_back)?;
    dict.set_item("more_warnings", compiled.more_warnings)?;
    let extents = PyDict::new(py);
    let group = machine.group();
    for (slot, axis) in group.iter().enumerate().take(facts.low.len()) {
        extents.set_item(&machine.axes[axis].name, (facts.low[slot], facts.high[slot]))?;
    }
    dict.set_item("extents", extents)?;
    dict.set_item("start", facts.start.as_ref().map(|start| start_dict(py, start, machine)).transpose()?)?;
    Ok(dict)
}

/// The listing of a program, piece by piece.
#[pyclass(frozen, module = "cnc_front._native.gcode")]
pub struct Listing {
    program: Arc<autocode::Program>,
    machine: Arc<machine::Machine>,
    source: Vec<u8>,
    sheet: Mutex<gcode::Sheet>,
}

#[pymethods]
impl Listing {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }
    fn __next__(&self, py: Python<'_>) -> Option<String> {
        let next = || self.sheet.lock().expect("no panic inside").piece(&self.program, &self.machine, &self.source);
        py.detach(next)
    }
}

/// State at the first block of a part; positions by axis name.
fn start_dict<'py>(py: Python<'py>, start: &gcode::Start, machine: &machine::Machine) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let by_axis = |values: &[f64]| -> PyResult<Bound<'py, PyDict>> {
        let named = PyDict::new(py);
        for (axis, value) in machine.group().iter().zip(values) {
            named.set_item(&machine.axes[axis].name, value)?;
        }
        Ok(named)
    };
    dict.set_item("line", start.line)?;
    dict.set_item("modal", &start.modal)?;
    dict.set_item("machine", by_axis(&start.machine)?)?;
    dict.set_item("program", by_axis(&start.program)?)?;
    dict.set_item("shift", by_axis(&start.shift)?)?;
    dict.set_item("in_spindle", start.in_spindle)?;
    dict.set_item("tool", start.tool)?;
    dict.set_item("tool_length", start.tool_length)?;
    dict.set_item("spindle", start.spindle)?;
    dict.set_item("speed", start.speed)?;
    dict.set_item("flood", start.coolant[0])?;
    dict.set_item("mist", start.coolant[1])?;
    dict.set_item("feed", start.feed)?;
    Ok(dict)
}

#[pymethods]
impl Program {
    /// Motion commands and spool functions per name, in the order of the manual.
    fn counts(&self) -> Vec<(&'static str, usize)> {
        let of = |kind: autocode::MoveKind| self.inner.moves.iter().filter(|m| m.kind == kind).count();
        let mut counts: Vec<_> = autocode::MoveKind::ALL.into_iter().map(|k| (k.name(), of(k))).collect();
        counts.push(("ssf", self.inner.ssfs.iter().map(|s| s.axes.len()).sum()));
        counts
    }
    /// A host event by its number from 0: (line, kind, text).
    fn event(&self, number: usize) -> Option<(u32, String, String)> {
        self.inner.events.get(number).map(|e| (e.line, e.kind.clone(), e.text.clone()))
    }
    /// Host events: (line, kind, text), numbered as the kernel's "host" events.
    fn events(&self) -> Vec<(u32, String, String)> {
        self.inner.events.iter().map(|e| (e.line, e.kind.clone(), e.text.clone())).collect()
    }
    /// JSON Lines of design 3.3, or the sheet to be read beside the source: pieces of whole lines.
    fn listing(&self, source: Vec<u8>, json: bool) -> Listing {
        let sheet = Mutex::new(gcode::Sheet::new(&self.inner, &self.machine, &source, json));
        Listing { program: self.inner.clone(), machine: self.machine.clone(), source, sheet }
    }
    /// The motion commands as columns (see gcode::SequenceColumns).
    fn sequence<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = py.detach(|| gcode::sequence(&self.inner, &self.machine));
        columns_dict(py, columns)
    }
    /// The same in pieces of so many rows, for a recording.
    fn pieces(&self, rows: usize) -> Pieces {
        let mut program = Some(self.inner.clone());
        Pieces::new(self.machine.clone(), rows, move || program.take())
    }
}

fn columns_dict(py: Python<'_>, columns: SequenceColumns) -> PyResult<Bound<'_, PyDict>> {
    let (n, a, m) = (columns.kind.len(), columns.axes, columns.via_line.len());
    let rows = columns.effradius.len() / a.max(1);
    let dict = PyDict::new(py);
    dict.set_item("start", columns.start.into_pyarray(py))?;
    dict.set_item("kind", columns.kind.into_pyarray(py))?;
    dict.set_item("line", columns.line.into_pyarray(py))?;
    dict.set_item("rapid", columns.rapid.into_pyarray(py))?;
    dict.set_item("target", columns.target.into_pyarray(py).reshape([n, a])?)?;
    dict.set_item("c1", columns.c1.into_pyarray(py))?;
    dict.set_item("c2", columns.c2.into_pyarray(py))?;
    dict.set_item("center", columns.center.into_pyarray(py).reshape([n, 2])?)?;
    dict.set_item("phi", columns.phi.into_pyarray(py))?;
    dict.set_item("vl", columns.vl.into_pyarray(py))?;
    dict.set_item("ac", columns.ac.into_pyarray(py))?;
    dict.set_item("tvl", columns.tvl.into_pyarray(py))?;
    dict.set_item("via_first", columns.via_first.into_pyarray(py))?;
    dict.set_item("via_count", columns.via_count.into_pyarray(py))?;
    dict.set_item("via_line", columns.via_line.into_pyarray(py))?;
    dict.set_item("via_target", columns.via_target.into_pyarray(py).reshape([m, a])?)?;
    dict.set_item("effradius", columns.effradius.into_pyarray(py).reshape([rows, a])?)?;
    dict.set_item("effradius_of", columns.effradius_of.into_pyarray(py))?;
    Ok(dict)
}

type NextSegment = Box<dyn FnMut() -> Option<Arc<autocode::Program>> + Send>;

/// Motion commands as columns, piece by piece.
#[pyclass(frozen, module = "cnc_front._native.gcode")]
pub struct Pieces {
    state: Mutex<(gcode::Pieces, NextSegment)>,
    machine: Arc<machine::Machine>,
}

impl Pieces {
    pub fn new(
        machine: Arc<machine::Machine>,
        rows: usize,
        next: impl FnMut() -> Option<Arc<autocode::Program>> + Send + 'static,
    ) -> Pieces {
        Pieces { state: Mutex::new((gcode::Pieces::new(&machine, rows.max(1)), Box::new(next))), machine }
    }
}

#[pymethods]
impl Pieces {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }
    /// The next piece; it waits for the translation. There is one at least.
    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let piece = py.detach(|| {
            let (pieces, next) = &mut *self.state.lock().unwrap_or_else(PoisonError::into_inner);
            pieces.next(&self.machine, next)
        });
        piece.map(|columns| columns_dict(py, columns)).transpose()
    }
}
