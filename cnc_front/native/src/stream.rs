//! `cnc_front._native.gcode.Stream`: a part program that is translated while it is executed.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use gcode::stream::{Counts, Segments};
use gcode::{Options, SequenceColumns, Sequencer};
use motion_kernel::autocode::MoveKind;
use motion_kernel::machine;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use toolpaths::SequenceView;

use crate::machine::{Machine, Row};
use crate::program::{Program, facts_dict, levels, profile_of, rows};

/// The controller's part of a stream, and that of the path it is measured against.
const EXECUTES: usize = 0;
const MEASURES: usize = 1;

/// Findings and facts of a translation; None: the program jumps, loops or calls and must be compiled whole.
type Found<'py> = Option<(Vec<Row>, Bound<'py, PyDict>)>;

/// A part program on its way from a file: a thread translates it, those who need its commands take them as they come.
#[pyclass(frozen, module = "cnc_front._native.gcode")]
pub struct Stream {
    stream: Mutex<gcode::stream::Stream>,
    users: Mutex<Vec<Option<Segments>>>,
    machine: Arc<machine::Machine>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn options(profile: Option<&str>, optional_stop: bool, block_delete: &[u8], check_only: bool) -> PyResult<Options> {
    let profile = profile.map(profile_of).transpose()?;
    let mut options =
        Options { profile, optional_stop, block_delete: levels(block_delete), check_only, ..Options::default() };
    // nothing of the text is kept: only the bound on commands holds
    options.limits.bytes = MOST_BYTES;
    Ok(options)
}

/// Largest text that is read once.
pub const MOST_BYTES: usize = 1 << 30;

fn opened(path: &Path) -> PyResult<File> {
    File::open(path).map_err(|error| failed(&error, path))
}
fn failed(error: &std::io::Error, path: &Path) -> PyErr {
    PyOSError::new_err((error.raw_os_error().unwrap_or(0), error.to_string(), path.to_path_buf()))
}

/// Checks a part program that is read once: findings and facts as of `compile`, but for facts by line.
#[pyfunction]
#[pyo3(signature = (path, filename, machine, *, profile=None, optional_stop=false, block_delete=Vec::new()))]
pub fn check_once<'py>(
    py: Python<'py>,
    path: PathBuf,
    filename: &str,
    machine: &Machine,
    profile: Option<&str>,
    optional_stop: bool,
    block_delete: Vec<u8>,
) -> PyResult<Found<'py>> {
    let options = options(profile, optional_stop, &block_delete, true)?;
    let (target, input) = (machine.inner.clone(), opened(&path)?);
    let checked = py.detach(|| gcode::compile_once(input, filename, &target, &options, None, gcode::WINDOW));
    match checked.map_err(|error| failed(&error, &path))? {
        Some(compiled) => Ok(Some((rows(&compiled), facts_dict(py, &compiled, &target)?))),
        None => Ok(None),
    }
}

#[pymethods]
impl Stream {
    /// Begins to translate a file. Two `users`: its commands go to a controller (`Mcu.load`) and to a tracker
    /// (`Tracker.growing`). One: they are iterated over, segment by segment.
    #[new]
    #[pyo3(signature = (path, filename, machine, *, users=2, profile=None, optional_stop=false, block_delete=Vec::new()))]
    fn new(
        path: PathBuf,
        filename: String,
        machine: &Machine,
        users: usize,
        profile: Option<&str>,
        optional_stop: bool,
        block_delete: Vec<u8>,
    ) -> PyResult<Stream> {
        let options = options(profile, optional_stop, &block_delete, false)?;
        let (file, target) = (Box::new(opened(&path)?), machine.inner.clone());
        let started = gcode::stream::Stream::start(file, filename, target.clone(), options, users);
        let (stream, users) = started.map_err(|error| failed(&error, &path))?;
        let users = Mutex::new(users.into_iter().map(Some).collect());
        Ok(Stream { stream: Mutex::new(stream), users, machine: target })
    }
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }
    /// The next segment as a program of its own.
    fn __next__(&self, py: Python<'_>) -> Option<Program> {
        let next = || locked(&self.users).first_mut()?.as_mut()?.next();
        py.detach(next).map(|inner| Program { inner, machine: self.machine.clone() })
    }
    /// Commands translated so far, as Program.counts.
    fn counts(&self) -> Vec<(&'static str, usize)> {
        let Counts { moves, functions } = locked(&self.stream).counts();
        let mut counts: Vec<_> = MoveKind::ALL.into_iter().map(|kind| (kind.name(), moves[kind as usize])).collect();
        counts.push(("ssf", functions));
        counts
    }
    /// A host event by its number: (line, kind, text). Those before it are forgotten.
    fn event(&self, number: usize) -> Option<(u32, String, String)> {
        locked(&self.stream).event(number).map(|event| (event.line, event.kind, event.text))
    }
    /// The controller (0) or the tracker (1) needs no more commands.
    fn send_away(&self, user: usize) -> PyResult<()> {
        if user >= locked(&self.users).len() {
            return Err(PyValueError::new_err("there is no such user"));
        }
        locked(&self.stream).send_away(user);
        Ok(())
    }
    /// JSON Lines of design 3.3, or the sheet to be read beside the source (`path`, read again): pieces of whole lines.
    fn listing(this: PyRef<'_, Self>, path: PathBuf, json: bool) -> PyResult<StreamListing> {
        let text = if json { None } else { Some(Box::new(opened(&path)?) as Box<dyn std::io::Read + Send>) };
        let sheet = gcode::Sheet::following(&this.machine, text);
        let state = Mutex::new((sheet, this.user(EXECUTES)?, None));
        Ok(StreamListing { machine: this.machine.clone(), state, _stream: this.into() })
    }
    /// Waits for the end of the translation: findings and facts as of `check_once`, once. Raises OSError.
    fn finish<'py>(&self, py: Python<'py>) -> PyResult<Found<'py>> {
        let outcome = py.detach(|| locked(&self.stream).finish());
        let outcome = outcome.ok_or_else(|| PyValueError::new_err("the translation is over"))?;
        match outcome.map_err(|error| PyOSError::new_err(error.to_string()))? {
            Some(compiled) => Ok(Some((rows(&compiled), facts_dict(py, &compiled, &self.machine)?))),
            None => Ok(None),
        }
    }
}

impl Stream {
    fn user(&self, user: usize) -> PyResult<Segments> {
        let taken = locked(&self.users).get_mut(user).and_then(Option::take);
        taken.ok_or_else(|| PyValueError::new_err("the commands of this stream go elsewhere"))
    }
    /// Its segments, for the controller.
    pub fn segments(&self) -> PyResult<motion_kernel::tasks::Segments> {
        let mut segments = self.user(EXECUTES)?;
        Ok(motion_kernel::tasks::Segments::new(move || segments.next()))
    }
    /// A tracker whose path grows with the translation.
    pub fn tracker(&self, options: toolpaths::TrackerOptions) -> PyResult<toolpaths::Tracker> {
        let mut segments = self.user(MEASURES)?;
        let mut sequencer = Sequencer::new(&self.machine);
        let start: Vec<f64> = self.machine.axes.iter().map(|axis| axis.start).collect();
        let path = toolpaths::Path::begin(&start).map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(toolpaths::Tracker::growing(path, options, move |path| match segments.next() {
            Some(segment) => path.append(&view(&sequencer.next(&segment))).map(|()| true),
            None => Ok(false),
        }))
    }
}

type ListingState = (gcode::Sheet, Segments, Option<Arc<motion_kernel::autocode::Program>>);

/// The listing of a stream, piece by piece.
#[pyclass(frozen, module = "cnc_front._native.gcode")]
pub struct StreamListing {
    machine: Arc<machine::Machine>,
    state: Mutex<ListingState>,
    /// The translation goes on as long as somebody holds it.
    _stream: Py<Stream>,
}

#[pymethods]
impl StreamListing {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }
    fn __next__(&self, py: Python<'_>) -> Option<String> {
        py.detach(|| {
            let (sheet, segments, program) = &mut *locked(&self.state);
            loop {
                if let Some(piece) = program.as_ref().and_then(|program| sheet.piece(program, &self.machine, b"")) {
                    return Some(piece);
                }
                *program = Some(segments.next()?);
                sheet.next_segment();
            }
        })
    }
}

fn view(c: &SequenceColumns) -> SequenceView<'_> {
    SequenceView {
        axes: c.axes,
        start: &c.start,
        kind: &c.kind,
        line: &c.line,
        rapid: &c.rapid,
        target: &c.target,
        c1: &c.c1,
        c2: &c.c2,
        center: &c.center,
        phi: &c.phi,
        vl: &c.vl,
        via_first: &c.via_first,
        via_count: &c.via_count,
        via_line: &c.via_line,
        via_target: &c.via_target,
        effradius: &c.effradius,
        effradius_of: &c.effradius_of,
        space: toolpaths::Space::default(),
    }
}
