//! `cnc_front._native.gcode.Stream`: a part program that is translated while it is executed.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use gcode::stream::{Counts, Segments};
use gcode::{Input, Options, SequenceColumns, Sequencer};
use motion_kernel::autocode::MoveKind;
use motion_kernel::machine;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use toolpaths::SequenceView;

use crate::machine::{Machine, Row};
use crate::program::{Pieces, Program, block_at, facts_dict, folder, levels, profile_of, rows};

/// The controller's part of a stream, that of the path it is measured against, and that of a recording.
const EXECUTES: usize = 0;
const MEASURES: usize = 1;
const RECORDS: usize = 2;

/// Findings and facts of a translation.
type Found<'py> = (Vec<Row>, Bound<'py, PyDict>);

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

/// `cnc_front.jobs.CompileOptions`, or what looks like it.
#[derive(FromPyObject)]
pub struct Asked {
    profile: Option<String>,
    optional_stop: bool,
    block_delete: Vec<u8>,
    start: Option<String>,
    stop: Option<String>,
    strict: bool,
    dry_feed: Option<f64>,
    mdi: bool,
}

impl Asked {
    fn options(self, path: &Path, check_only: bool) -> PyResult<Options> {
        let mut options = Options {
            profile: self.profile.as_deref().map(profile_of).transpose()?,
            optional_stop: self.optional_stop,
            block_delete: levels(&self.block_delete),
            from: self.start.as_deref().map(block_at).transpose()?,
            to: self.stop.as_deref().map(block_at).transpose()?,
            strict: self.strict,
            dry_feed: self.dry_feed,
            mdi: self.mdi,
            library: path.parent().map(|parent| folder(parent.to_path_buf())),
            check_only,
            ..Options::default()
        };
        // nothing of the text is kept: only the bound on commands holds
        options.limits.bytes = MOST_BYTES;
        Ok(options)
    }
}

/// Largest text that is read in windows.
pub const MOST_BYTES: usize = 1 << 30;

fn opened(path: &Path) -> std::io::Result<Input<'static>> {
    Ok(Box::new(File::open(path)?))
}
fn failed(error: &std::io::Error, path: &Path) -> PyErr {
    match error.raw_os_error() {
        Some(number) => PyOSError::new_err((number, error.to_string(), path.to_path_buf())),
        None => PyOSError::new_err(error.to_string()),
    }
}

/// Checks a part program that is read in windows: findings and facts as of `compile`, but for facts by line. Raises
/// OSError.
#[pyfunction]
pub fn check_once<'py>(
    py: Python<'py>,
    path: PathBuf,
    filename: &str,
    machine: &Machine,
    options: Asked,
) -> PyResult<Found<'py>> {
    let (options, target) = (options.options(&path, true)?, machine.inner.clone());
    let open = || opened(&path);
    let checked = py.detach(|| gcode::compile_once(&open, filename, &target, &options, None, gcode::WINDOW));
    let compiled = checked.map_err(|error| failed(&error, &path))?;
    Ok((rows(&compiled), facts_dict(py, &compiled, &target)?))
}

#[pymethods]
impl Stream {
    /// Begins to translate a file for its users: a controller (`Mcu.load`), a tracker (`Tracker.growing`), and a
    /// recording (`pieces`). The commands of the first may be iterated over, segment by segment. Raises OSError.
    #[new]
    fn new(path: PathBuf, filename: String, machine: &Machine, options: Asked, users: usize) -> PyResult<Stream> {
        let (options, target) = (options.options(&path, false)?, machine.inner.clone());
        let file = path.clone();
        let open = Box::new(move || opened(&file));
        let started = gcode::stream::Stream::start(open, filename, target.clone(), options, users);
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
        let text = if json { None } else { Some(opened(&path).map_err(|error| failed(&error, &path))?) };
        let sheet = gcode::Sheet::following(&this.machine, text);
        let state = Mutex::new((sheet, this.user(EXECUTES)?, None));
        Ok(StreamListing { machine: this.machine.clone(), state, _stream: this.into() })
    }
    /// The motion commands as columns in pieces of so many rows, for a recording.
    fn pieces(&self, rows: usize) -> PyResult<Pieces> {
        let mut segments = self.user(RECORDS)?;
        Ok(Pieces::new(self.machine.clone(), rows, move || segments.next()))
    }
    /// Waits for the end of the translation: findings and facts as of `check_once`, once. Raises OSError.
    fn finish<'py>(&self, py: Python<'py>) -> PyResult<Found<'py>> {
        let outcome = py.detach(|| locked(&self.stream).finish());
        let outcome = outcome.ok_or_else(|| PyValueError::new_err("the translation is over"))?;
        let compiled = outcome.map_err(|error| PyOSError::new_err(error.to_string()))?;
        Ok((rows(&compiled), facts_dict(py, &compiled, &self.machine)?))
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
