//! `cnc_front._native.recording`: recordings written from chunks and read back as columns.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use recording::{Attached, Columns, ColumnsView, Content, Error, Header, Item};

use crate::chunk::Chunk;

pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Writer>()?;
    module.add_class::<Reader>()
}

fn raise(error: Error, path: &Path) -> PyErr {
    match error {
        Error::Io(error) => match error.raw_os_error() {
            Some(number) => PyOSError::new_err((number, error.to_string(), path.to_path_buf())),
            None => PyOSError::new_err(error.to_string()),
        },
        other => PyValueError::new_err(other.to_string()),
    }
}

/// A recording being written, in a thread of its own: an error of the disk comes with a later call. `finish` closes it.
#[pyclass(module = "cnc_front._native.recording")]
pub struct Writer {
    inner: Option<recording::Writer>,
    path: PathBuf,
}

#[pymethods]
impl Writer {
    /// Attachments are (name, media type, bytes or the path of a file). `resolution`: axis units per count of the encoders. Raises OSError.
    #[new]
    #[pyo3(signature = (path, axes, sample_time_s, attachments, metadata, resolution=Vec::new(), scan=Vec::new()))]
    fn new(
        path: PathBuf,
        axes: Vec<String>,
        sample_time_s: f64,
        attachments: Vec<(String, String, Given)>,
        metadata: BTreeMap<String, String>,
        resolution: Vec<f64>,
        scan: Vec<String>,
    ) -> PyResult<Writer> {
        let attachments = attachments.into_iter().map(attached).collect();
        let header = Header { axes, sample_time_s, resolution, attachments, metadata, scan };
        let inner = recording::Writer::create(&path, &header).map_err(|e| raise(e, &path))?;
        Ok(Writer { inner: Some(inner), path })
    }

    /// Writes a chunk and the deviation of its load side (mm per sample).
    fn write(&mut self, py: Python<'_>, chunk: &Chunk, deviation_mm: PyReadonlyArray1<'_, f32>) -> PyResult<()> {
        let (dp, load, rp) =
            (chunk.dp.bind(py).readonly(), chunk.load.bind(py).readonly(), chunk.rp.bind(py).readonly());
        let (factor, v_plan) = (chunk.factor.bind(py).readonly(), chunk.v_plan.bind(py).readonly());
        let (line, entry, flags) =
            (chunk.line.bind(py).readonly(), chunk.entry.bind(py).readonly(), chunk.flags.bind(py).readonly());
        let axes = numpy::PyUntypedArrayMethods::shape(chunk.dp.bind(py))[1];
        let view = ColumnsView {
            first_sample: chunk.first_sample,
            axes,
            dp: dp.as_slice()?,
            load: load.as_slice()?,
            rp: rp.as_slice()?,
            factor: factor.as_slice()?,
            v_plan: v_plan.as_slice()?,
            line: line.as_slice()?,
            entry: entry.as_slice()?,
            flags: flags.as_slice()?,
            deviation_mm: deviation_mm.as_slice()?,
            standing: &chunk.standing,
        };
        let writer = self.inner.as_mut().ok_or_else(closed)?;
        let scan = chunk.scan.bind(py).readonly();
        let scan = scan.as_slice()?;
        py.detach(|| {
            writer.write_samples(&view)?;
            if scan.is_empty() { Ok(()) } else { writer.write_scan(view.first_sample, scan) }
        })
        .map_err(|e| raise(e, &self.path))
    }

    /// Writes samples that were gathered from several chunks: `first_sample` of the first and `standing` of the last,
    /// matrices dp, load, rp, columns factor and v_plan, columns line, entry and flags, the deviation.
    fn write_columns(
        &mut self,
        py: Python<'_>,
        place: (u64, Vec<u32>),
        matrices: [PyReadonlyArray2<'_, f64>; 3],
        numbers: [PyReadonlyArray1<'_, f64>; 2],
        words: [PyReadonlyArray1<'_, u32>; 3],
        deviation_mm: PyReadonlyArray1<'_, f32>,
    ) -> PyResult<()> {
        let (first_sample, standing) = place;
        let view = ColumnsView {
            first_sample,
            axes: numpy::PyUntypedArrayMethods::shape(&*matrices[0])[1],
            dp: matrices[0].as_slice()?,
            load: matrices[1].as_slice()?,
            rp: matrices[2].as_slice()?,
            factor: numbers[0].as_slice()?,
            v_plan: numbers[1].as_slice()?,
            line: words[0].as_slice()?,
            entry: words[1].as_slice()?,
            flags: words[2].as_slice()?,
            deviation_mm: deviation_mm.as_slice()?,
            standing: &standing,
        };
        let writer = self.inner.as_mut().ok_or_else(closed)?;
        py.detach(|| writer.write_samples(&view)).map_err(|e| raise(e, &self.path))
    }

    /// Writes an event, a JSON object, at an emulated time.
    fn write_event(&mut self, py: Python<'_>, t_s: f64, json: &str) -> PyResult<()> {
        let writer = self.inner.as_mut().ok_or_else(closed)?;
        py.detach(|| writer.write_event(t_s, json)).map_err(|e| raise(e, &self.path))
    }

    /// Attaches another file: (name, media type, bytes or the path of a file).
    fn attach(&mut self, py: Python<'_>, file: (String, String, Given)) -> PyResult<()> {
        let writer = self.inner.as_mut().ok_or_else(closed)?;
        py.detach(|| writer.attach(attached(file))).map_err(|e| raise(e, &self.path))
    }

    /// Adds the result object and closes the file.
    fn finish(&mut self, py: Python<'_>, result_json: &str) -> PyResult<()> {
        let writer = self.inner.take().ok_or_else(closed)?;
        py.detach(|| writer.finish(result_json)).map_err(|e| raise(e, &self.path))
    }
}

/// Bytes, or the path of a file.
#[derive(FromPyObject)]
enum Given {
    Bytes(Vec<u8>),
    File(PathBuf),
}

fn attached((name, media_type, given): (String, String, Given)) -> Attached<Content> {
    let data = match given {
        Given::Bytes(bytes) => Content::Bytes(bytes),
        Given::File(path) => Content::File(path),
    };
    Attached { name, media_type, data }
}

fn closed() -> PyErr {
    PyValueError::new_err("the recording is closed")
}

/// A recording being read from front to back.
#[pyclass(module = "cnc_front._native.recording")]
pub struct Reader {
    /// The reader is not Sync; Python may hand it to another thread.
    inner: Mutex<recording::Reader>,
    path: PathBuf,
}

#[pymethods]
impl Reader {
    /// With `only` nothing is told but the attachments whose names begin so.
    #[new]
    #[pyo3(signature = (path, only=None))]
    fn new(path: PathBuf, only: Option<&str>) -> PyResult<Reader> {
        let inner = match only {
            Some(prefix) => recording::Reader::attachments(&path, prefix),
            None => recording::Reader::open(&path),
        };
        let inner = inner.map_err(|e| raise(e, &path))?;
        Ok(Reader { inner: Mutex::new(inner), path })
    }
    /// Why reading ended before the end of the file, if it did.
    #[getter]
    fn damage(&self) -> Option<String> {
        self.inner.lock().ok()?.damage.clone()
    }
    /// ("attachment", name, bytes), ("metadata", name, dict), ("columns", "", dict of columns),
    /// ("event", "", JSON text), or None at the end. Raises ValueError if the file is no recording of ours.
    fn next_item<'py>(&mut self, py: Python<'py>) -> PyResult<Option<(&'static str, String, Bound<'py, PyAny>)>> {
        let reader = self.inner.get_mut().map_err(|_| closed())?;
        let Some(item) = py.detach(|| reader.next_item()).map_err(|e| raise(e, &self.path))? else { return Ok(None) };
        Ok(Some(match item {
            Item::Attachment(a) => ("attachment", a.name, PyBytes::new(py, &a.data).into_any()),
            Item::Metadata(name, map) => ("metadata", name, map.into_pyobject(py)?.into_any()),
            Item::Event(text) => ("event", String::new(), text.into_pyobject(py)?.into_any()),
            Item::Columns(columns) => ("columns", String::new(), columns_dict(py, columns)?.into_any()),
        }))
    }
}

fn columns_dict<'py>(py: Python<'py>, c: Columns) -> PyResult<Bound<'py, PyDict>> {
    let shape = [c.flags.len(), c.axes];
    let dict = PyDict::new(py);
    dict.set_item("first_sample", c.first_sample)?;
    dict.set_item("dp", c.dp.into_pyarray(py).reshape(shape)?)?;
    dict.set_item("load", c.load.into_pyarray(py).reshape(shape)?)?;
    dict.set_item("rp", c.rp.into_pyarray(py).reshape(shape)?)?;
    dict.set_item("factor", c.factor.into_pyarray(py))?;
    dict.set_item("v_plan", c.v_plan.into_pyarray(py))?;
    dict.set_item("line", c.line.into_pyarray(py))?;
    dict.set_item("entry", c.entry.into_pyarray(py))?;
    dict.set_item("flags", c.flags.into_pyarray(py))?;
    dict.set_item("deviation_mm", c.deviation_mm.into_pyarray(py))?;
    dict.set_item("standing", c.standing.into_pyarray(py))?;
    Ok(dict)
}
