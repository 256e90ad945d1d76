//! `cnc_front._native.sympas`: rw_SymPas jobs compiled to autocode, and autocode files.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::sympas::cnc::CncError;
use ::sympas::diagnostics::{Diagnostic, Language};
use ::sympas::lexer::MAX_SOURCE_MIB;
use ::sympas::source::Loader;
use ::sympas::{cnc, listing};
use motion_kernel::sap;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::machine::Machine;

pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Program>()?;
    module.add("MAGIC", PyBytes::new(module.py(), cnc::MAGIC))?;
    module.add_function(wrap_pyfunction!(decode, module)?)?;
    module.add_function(wrap_pyfunction!(compile, module)?)
}

/// A compiled job.
#[pyclass(frozen, module = "cnc_front._native.sympas")]
pub struct Program {
    pub inner: Arc<sap::program::Program>,
}

#[pymethods]
impl Program {
    /// Name of the program heading; empty without one.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }
    /// Number of `{$TASK n}`, or None.
    #[getter]
    fn task(&self) -> Option<u8> {
        self.inner.task
    }
    #[getter]
    fn full_system(&self) -> bool {
        self.inner.full_system
    }
    /// Files of the program, the job first, and what is added to their lines to make places of them.
    #[getter]
    fn files(&self) -> Vec<(String, u32)> {
        self.inner.files.iter().cloned().zip(self.inner.offsets()).collect()
    }
    /// Number of places: lines of all files.
    #[getter]
    fn places(&self) -> u32 {
        self.inner.offsets().last().copied().unwrap_or(0)
    }
    /// Lines of the disassembly.
    fn listing(&self) -> Vec<String> {
        listing::listing(&self.inner).lines().map(str::to_owned).collect()
    }
    /// The autocode file.
    fn encode<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &cnc::encode(&self.inner))
    }
}

#[pymethods]
impl crate::kernel::Mcu {
    /// txbf2 of an autocode file: loads it into the task that it names (else 0), which stops. Return code of 4.4.129.
    fn load_autocode(&mut self, py: Python<'_>, data: &[u8]) -> i32 {
        match py.detach(|| cnc::decode(data)) {
            Ok(program) => {
                let task = usize::from(program.task.unwrap_or(0));
                let known = task < motion_kernel::mcu::TASKS;
                if known && self.kernel.load_sap(task, Arc::new(program)).is_ok() { 0 } else { 24 }
            }
            Err(CncError::Magic | CncError::Version(_)) => 22,
            Err(CncError::Damaged | CncError::Malformed(_) | CncError::Refused(_)) => 24,
        }
    }
}

/// The program of an autocode file. Raises ValueError for anything that a task may not execute.
#[pyfunction]
fn decode(py: Python<'_>, data: &[u8]) -> PyResult<Program> {
    let program = py.detach(|| cnc::decode(data)).map_err(|e| PyValueError::new_err(e.to_string()))?;
    Ok(Program { inner: Arc::new(program) })
}

/// Diagnostic of Python: file, line, column, end_column, id, message, hint, source line with a caret.
type Row = (String, u32, u32, u32, String, String, String, String);

fn row(found: &Diagnostic, language: Language) -> Row {
    let (message, hint) = (found.message(language), found.hint(language));
    let id = found.id.name().to_owned();
    (found.file.clone(), found.line, found.column, found.end_column, id, message, hint, found.excerpt())
}

/// Compiles a job for the axes of a machine: (Program or None, diagnostics). `path` is where its includes are looked
/// for: relative to the file that includes them. `language` of messages is en or de.
#[pyfunction]
#[pyo3(signature = (source, filename, machine, *, path=None, language="en"))]
fn compile(
    py: Python<'_>,
    source: &[u8],
    filename: &str,
    machine: &Machine,
    path: Option<PathBuf>,
    language: &str,
) -> (Option<Program>, Vec<Row>) {
    let axes: Vec<String> = machine.inner.axes.iter().map(|a| a.name.clone()).collect();
    let mut includes = Includes { files: vec![(filename.to_owned(), path)] };
    let language = if language == "de" { Language::German } else { Language::English };
    let result = py.detach(|| ::sympas::compile(filename, source, &mut includes, &axes));
    let rows = result.diagnostics.iter().map(|d| row(d, language)).collect();
    (result.program.map(|inner| Program { inner: Arc::new(inner) }), rows)
}

/// Included files lie beside the file that includes them. Names may be written the DOS way: any case, backslashes.
struct Includes {
    /// Names as shown, and where they are.
    files: Vec<(String, Option<PathBuf>)>,
}

impl Loader for Includes {
    fn load(&mut self, name: &str, from: &str) -> Result<(String, Vec<u8>), String> {
        let from = self.files.iter().find(|(shown, _)| shown == from).and_then(|(_, path)| path.as_deref());
        let Some(from) = from else { return Err("the text has no folder to look in".to_owned()) };
        let folder = from.parent().unwrap_or(Path::new(""));
        let wanted = name.replace('\\', "/");
        let file = find(folder, &wanted).ok_or("there is no such file")?;
        let bytes = read(&file)?;
        let shown = file.to_string_lossy().into_owned();
        self.files.push((shown.clone(), Some(file)));
        Ok((shown, bytes))
    }
}

/// The file of that name, else the first of its folder that differs in case only.
fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let exact = folder.join(name);
    if exact.is_file() {
        return Some(exact);
    }
    let beside = exact.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let last = exact.file_name()?.to_str()?;
    let mut names: Vec<PathBuf> = std::fs::read_dir(beside).ok()?.filter_map(|e| e.ok().map(|e| e.path())).collect();
    names.sort();
    let same = |p: &PathBuf| p.file_name().and_then(|n| n.to_str()).is_some_and(|n| n.eq_ignore_ascii_case(last));
    names.into_iter().find(|p| same(p) && p.is_file())
}

fn read(file: &Path) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let most = (MAX_SOURCE_MIB << 20) as u64 + 1;
    let open = File::open(file).map_err(|e| e.to_string())?;
    open.take(most).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes)
}
