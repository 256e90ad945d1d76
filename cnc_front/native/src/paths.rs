//! `cnc_front._native.toolpaths`: the programmed path and the tracker that measures a run against it.

use std::collections::BTreeMap;
use std::sync::Arc;

use motion_kernel::cause::Cause;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use toolpaths::{
    BlockLimit, BlockStats, DeviationSummary, MinMax, Passage, SequenceView, Space, Stretch, Stretches, Summary,
    TrackerOptions,
};

use crate::chunk::Chunk;
use crate::stream::Stream;

pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Path>()?;
    module.add_class::<Tracker>()?;
    crate::geometry::fill(module)
}

/// The path as programmed, before merging.
#[pyclass(frozen, module = "cnc_front._native.toolpaths")]
pub struct Path {
    inner: Arc<toolpaths::Path>,
}

fn column<'py, T: numpy::Element>(sequence: &Bound<'py, PyDict>, name: &str) -> PyResult<PyReadonlyArray1<'py, T>> {
    let value = sequence.get_item(name)?.ok_or_else(|| PyValueError::new_err(format!("no column {name}")))?;
    value.call_method0("ravel")?.extract::<PyReadonlyArray1<'py, T>>()
}

/// A column that only rw_SymPas jobs have.
fn optional<'py, T: numpy::Element>(
    sequence: &Bound<'py, PyDict>,
    name: &str,
) -> PyResult<Option<PyReadonlyArray1<'py, T>>> {
    if sequence.contains(name)? { column(sequence, name).map(Some) } else { Ok(None) }
}
fn slice<'a, T: numpy::Element>(column: &'a Option<PyReadonlyArray1<'_, T>>) -> PyResult<&'a [T]> {
    Ok(match column {
        Some(column) => column.as_slice()?,
        None => &[],
    })
}

#[pymethods]
impl Path {
    /// From the columns of gcode.Program.sequence().
    #[new]
    fn new(py: Python<'_>, sequence: &Bound<'_, PyDict>) -> PyResult<Path> {
        let start = column::<f64>(sequence, "start")?;
        let (kind, line, rapid) =
            (column::<u8>(sequence, "kind")?, column::<u32>(sequence, "line")?, column::<bool>(sequence, "rapid")?);
        let (target, center) = (column::<f64>(sequence, "target")?, column::<f64>(sequence, "center")?);
        let (c1, c2) = (column::<u8>(sequence, "c1")?, column::<u8>(sequence, "c2")?);
        let (phi, vl) = (column::<f64>(sequence, "phi")?, column::<f64>(sequence, "vl")?);
        let (via_first, via_count) = (column::<u32>(sequence, "via_first")?, column::<u32>(sequence, "via_count")?);
        let (via_line, via_target) = (column::<u32>(sequence, "via_line")?, column::<f64>(sequence, "via_target")?);
        let (effradius, effradius_of) =
            (column::<f64>(sequence, "effradius")?, column::<u16>(sequence, "effradius_of")?);
        let (begin, c3) = (optional::<f64>(sequence, "begin")?, optional::<u8>(sequence, "c3")?);
        let (center3, normal) = (optional::<f64>(sequence, "center3")?, optional::<f64>(sequence, "normal")?);
        let view = SequenceView {
            axes: start.len(),
            start: start.as_slice()?,
            kind: kind.as_slice()?,
            line: line.as_slice()?,
            rapid: rapid.as_slice()?,
            target: target.as_slice()?,
            c1: c1.as_slice()?,
            c2: c2.as_slice()?,
            center: center.as_slice()?,
            phi: phi.as_slice()?,
            vl: vl.as_slice()?,
            via_first: via_first.as_slice()?,
            via_count: via_count.as_slice()?,
            via_line: via_line.as_slice()?,
            via_target: via_target.as_slice()?,
            effradius: effradius.as_slice()?,
            effradius_of: effradius_of.as_slice()?,
            space: Space { begin: slice(&begin)?, c3: slice(&c3)?, center: slice(&center3)?, normal: slice(&normal)? },
        };
        let path = py.detach(|| toolpaths::Path::new(view)).map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok(Path { inner: Arc::new(path) })
    }
    #[getter]
    fn length_mm(&self) -> f64 {
        self.inner.length_mm()
    }
    /// Blocks that were merged away, and the largest distance of one of their end points from the chord.
    #[getter]
    fn merged(&self) -> (u64, f64) {
        let merged = self.inner.merged();
        (merged.blocks, merged.max_mm)
    }
    /// mm of the path's metric per axis unit, by the effective radius an axis has at first; 0 where it does not count.
    #[getter]
    fn mm_per_unit(&self) -> Vec<f64> {
        self.inner.mm_per_unit()
    }
    /// (min, max) per axis in axis units.
    #[getter]
    fn extents(&self) -> Vec<(f64, f64)> {
        self.inner.extents()
    }
    /// Points (n, axes), source line, rapid and path length per vertex; chords within `chord_mm`.
    fn polyline<'py>(&self, py: Python<'py>, chord_mm: f64, max_points: usize) -> PyResult<Bound<'py, PyDict>> {
        let line = py.detach(|| self.inner.polyline(chord_mm, max_points));
        let dict = PyDict::new(py);
        let n = line.lines.len();
        dict.set_item("points", line.points.into_pyarray(py).reshape([n, self.inner.axes()])?)?;
        dict.set_item("lines", line.lines.into_pyarray(py))?;
        dict.set_item("rapid", line.rapid.into_pyarray(py))?;
        dict.set_item("s_mm", line.s_mm.into_pyarray(py))?;
        Ok(dict)
    }
    /// Programmed blocks as columns: line, entry, s0_mm, length_mm, vl, rapid.
    fn blocks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let blocks = self.inner.blocks();
        let dict = PyDict::new(py);
        let numbers = |f: fn(&toolpaths::Block) -> f64| blocks.iter().map(f).collect::<Vec<_>>().into_pyarray(py);
        dict.set_item("line", blocks.iter().map(|b| b.line).collect::<Vec<_>>().into_pyarray(py))?;
        dict.set_item("entry", blocks.iter().map(|b| b.entry).collect::<Vec<_>>().into_pyarray(py))?;
        dict.set_item("s0_mm", numbers(|b| b.s0))?;
        dict.set_item("length_mm", numbers(|b| b.length))?;
        dict.set_item("vl", numbers(|b| b.vl))?;
        dict.set_item("rapid", blocks.iter().map(|b| b.rapid).collect::<Vec<_>>().into_pyarray(py))?;
        Ok(dict)
    }
}

/// Measures a run against its path, chunk by chunk.
#[pyclass(module = "cnc_front._native.toolpaths")]
pub struct Tracker {
    inner: toolpaths::Tracker,
    axes: usize,
    /// The parts of the run that are on the path, unless it is the whole.
    stretches: Option<Stretches>,
}

/// The causes by which nothing is lost, as bits.
fn at_speed() -> u64 {
    Cause::AT_SPEED.iter().fold(0, |bits, &cause| bits | 1 << cause as u64)
}

#[pymethods]
impl Tracker {
    #[new]
    #[pyo3(signature = (path, *, sample_time_s, schedule=Vec::new(), trovrst_s=0.0, buckets=4096, passages=false))]
    fn new(
        path: &Path,
        sample_time_s: f64,
        schedule: Vec<(f64, f64)>,
        trovrst_s: f64,
        buckets: usize,
        passages: bool,
    ) -> Tracker {
        let at_speed = at_speed();
        let options = TrackerOptions { sample_time_s, schedule, trovrst_s, buckets, at_speed, passages };
        Tracker {
            inner: toolpaths::Tracker::new(path.inner.clone(), options),
            axes: path.inner.axes(),
            stretches: None,
        }
    }

    /// Only these parts of the run are on the path: first and last sample, first motion command (from 0), and whether the
    /// load side is measured until the axes move again. Before the first chunk.
    fn set_stretches(&mut self, rows: Vec<(u64, u64, usize, bool)>) {
        let stretch = |(begin, end, command, settles)| Stretch { begin, end, command, settles };
        self.stretches = Some(Stretches::new(rows.into_iter().map(stretch).collect()));
    }

    /// A tracker whose path comes from a stream as it is needed: nothing per block, over length or per command.
    #[staticmethod]
    #[pyo3(signature = (stream, *, sample_time_s, schedule=Vec::new(), trovrst_s=0.0))]
    fn growing(stream: &Stream, sample_time_s: f64, schedule: Vec<(f64, f64)>, trovrst_s: f64) -> PyResult<Tracker> {
        let at_speed = at_speed();
        let options = TrackerOptions { sample_time_s, schedule, trovrst_s, at_speed, ..TrackerOptions::default() };
        let inner = stream.tracker(options)?;
        let axes = inner.path().axes();
        Ok(Tracker { inner, axes, stretches: None })
    }
    /// As Path.mm_per_unit; complete after `finish`.
    #[getter]
    fn mm_per_unit(&self) -> Vec<f64> {
        self.inner.path().mm_per_unit()
    }

    /// Collects the largest deviation per piece of a polyline, given by the path length at its vertices.
    fn watch(&mut self, s_mm: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        self.inner.watch(s_mm.as_slice()?);
        Ok(())
    }
    /// Deviation per watched vertex (NaN where not yet driven), and the vertex being approached.
    fn watched<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f32>>, usize) {
        let (values, at) = self.inner.watched();
        (PyArray1::from_slice(py, values), at)
    }

    /// Signed deviation in the plane, + = left, where the values of `watched` were found; NaN without direction there.
    fn watched_signed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, self.inner.watched_signed())
    }

    /// What limited most of the piece that ends at each watched vertex (cause, axis + 1 in the high byte; 0: not driven).
    fn watched_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u16>> {
        PyArray1::from_slice(py, self.inner.watched_limits())
    }
    /// Causes over time: samples per bucket, and per bucket {limit: samples}.
    fn limits_over_time(&self) -> (u64, Vec<BTreeMap<u16, u64>>) {
        let (samples, buckets) = self.inner.limits_over_time();
        (samples, buckets.iter().map(|bucket| bucket.rows().iter().copied().collect()).collect())
    }
    /// Per motion command, if asked for: first, last, samples, s_mm (n, 2), v (n, 2), v_max, a_max, factor_max, factor_min, and the
    /// set points `begin` and `end` (n, axes) at its first and last sample. `samples` is 0 for what was never executed.
    fn passages<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let passages = self.inner.passages();
        let (list, n) = (passages.list(), passages.list().len());
        let dict = PyDict::new(py);
        let numbers = |f: fn(&Passage) -> f64| list.iter().map(f).collect::<Vec<_>>().into_pyarray(py);
        let counts = |f: fn(&Passage) -> u64| list.iter().map(f).collect::<Vec<_>>().into_pyarray(py);
        let pairs = |f: fn(&Passage) -> [f64; 2]| list.iter().flat_map(f).collect::<Vec<_>>().into_pyarray(py);
        dict.set_item("first", counts(|p| p.first))?;
        dict.set_item("last", counts(|p| p.last))?;
        dict.set_item("samples", counts(|p| p.samples))?;
        dict.set_item("s_mm", pairs(|p| p.s_mm).reshape([n, 2])?)?;
        dict.set_item("v", pairs(|p| p.v).reshape([n, 2])?)?;
        dict.set_item("v_max", numbers(|p| p.v_max))?;
        dict.set_item("a_max", numbers(|p| p.a_max))?;
        dict.set_item("factor_max", numbers(|p| p.factor_max))?;
        dict.set_item("factor_min", numbers(|p| p.factor_min))?;
        let (begin, end) = passages.ends();
        dict.set_item("begin", PyArray1::from_slice(py, begin).reshape([n, self.axes])?)?;
        dict.set_item("end", PyArray1::from_slice(py, end).reshape([n, self.axes])?)?;
        Ok(dict)
    }

    /// Measures a chunk of the controller; returns the deviation of the load side per sample (f32, mm).
    fn feed<'py>(&mut self, py: Python<'py>, chunk: &Chunk) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let (dp, load, rp) =
            (chunk.dp.bind(py).readonly(), chunk.load.bind(py).readonly(), chunk.rp.bind(py).readonly());
        let (factor, v_plan) = (chunk.factor.bind(py).readonly(), chunk.v_plan.bind(py).readonly());
        let (entry, flags) = (chunk.entry.bind(py).readonly(), chunk.flags.bind(py).readonly());
        self.measure(py, chunk.first_sample, (dp, load, rp), (factor, v_plan), (entry, flags))
    }

    /// As `feed`, from columns of a recording.
    #[allow(clippy::too_many_arguments)] // one per column
    fn feed_columns<'py>(
        &mut self,
        py: Python<'py>,
        first_sample: u64,
        dp: PyReadonlyArray2<'py, f64>,
        load: PyReadonlyArray2<'py, f64>,
        rp: PyReadonlyArray2<'py, f64>,
        factor: PyReadonlyArray1<'py, f64>,
        v_plan: PyReadonlyArray1<'py, f64>,
        entry: PyReadonlyArray1<'py, u32>,
        flags: PyReadonlyArray1<'py, u32>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        self.measure(py, first_sample, (dp, load, rp), (factor, v_plan), (entry, flags))
    }

    /// What was measured so far; call it once, after the last chunk.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let summary = py.detach(|| self.inner.finish());
        self.check_path()?;
        summary_dict(py, &summary)
    }

    /// Running figures for a screen: (deviation now is in `feed`) largest deviation of the load side, mm, and its line.
    fn blocks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let blocks = self.inner.blocks();
        let dict = PyDict::new(py);
        let numbers = |f: fn(&BlockStats) -> f64| blocks.iter().map(f).collect::<Vec<_>>().into_pyarray(py);
        dict.set_item("time_s", numbers(|b| b.time_s))?;
        dict.set_item("moving_s", numbers(|b| b.moving_s))?;
        dict.set_item("speed_min", numbers(|b| f64::from(b.speed_min)))?;
        dict.set_item("speed_max", numbers(|b| f64::from(b.speed_max)))?;
        dict.set_item("setpoint_max_mm", numbers(|b| f64::from(b.setpoint.max_mm)))?;
        dict.set_item("setpoint_rms_mm", numbers(|b| b.setpoint.rms_mm()))?;
        dict.set_item("actual_max_mm", numbers(|b| f64::from(b.actual.max_mm)))?;
        dict.set_item("actual_rms_mm", numbers(|b| b.actual.rms_mm()))?;
        dict.set_item("signed_min_mm", numbers(|b| f64::from(b.signed_min_mm)))?;
        dict.set_item("signed_max_mm", numbers(|b| f64::from(b.signed_max_mm)))?;
        let limits = self.inner.block_limits();
        let share = |(l, b): (&BlockLimit, &BlockStats)| f64::from(l.samples) / f64::from(b.setpoint.samples);
        dict.set_item("limit", limits.iter().map(|l| l.limit).collect::<Vec<_>>().into_pyarray(py))?;
        dict.set_item("limit_share", limits.iter().zip(blocks).map(share).collect::<Vec<_>>().into_pyarray(py))?;
        dict.set_item("slow_limit", limits.iter().map(|l| l.slow).collect::<Vec<_>>().into_pyarray(py))?;
        Ok(dict)
    }

    /// What a diagnosis needs (toolpaths/diagnosis.py, circularity.py); complete after `finish`.
    fn evidence<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        crate::evidence::dict(py, self.inner.evidence(), self.axes)
    }

    /// Reduced curves: {"over_length": {"bucket_mm", "setpoint_mm": (min, max), ...}, "over_time": {...}}.
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let length = self.inner.over_length();
        let over_length = PyDict::new(py);
        over_length.set_item("bucket_mm", length.bucket_mm)?;
        over_length.set_item("setpoint_mm", pair(py, &length.setpoint_mm))?;
        over_length.set_item("actual_mm", pair(py, &length.actual_mm))?;
        over_length.set_item("signed_mm", pair(py, &length.signed_mm))?;
        let time = self.inner.over_time();
        let over_time = PyDict::new(py);
        over_time.set_item("samples_per_bucket", time.samples_per_bucket)?;
        over_time.set_item("speed", pair(py, &time.speed))?;
        over_time.set_item("programmed", pair(py, &time.programmed))?;
        over_time.set_item("factor", pair(py, &time.factor))?;
        over_time.set_item("deviation_actual_mm", pair(py, &time.deviation_actual_mm))?;
        over_time.set_item("following", PyList::new(py, time.following.iter().map(|m| pair(py, m)))?)?;
        let dict = PyDict::new(py);
        dict.set_item("over_length", over_length)?;
        dict.set_item("over_time", over_time)?;
        Ok(dict)
    }
}

type Matrices<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>);

impl Tracker {
    fn check_path(&self) -> PyResult<()> {
        self.inner.path_error().map_or(Ok(()), |error| Err(PyValueError::new_err(error.to_string())))
    }
    fn measure<'py>(
        &mut self,
        py: Python<'py>,
        first_sample: u64,
        (dp, load, rp): Matrices<'py>,
        (factor, v_plan): (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>),
        (entry, flags): (PyReadonlyArray1<'py, u32>, PyReadonlyArray1<'py, u32>),
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let n = factor.len();
        let shaped = [&dp, &load, &rp].iter().all(|m| m.shape() == [n, self.axes]) && v_plan.len() == n;
        if !shaped || entry.len() != n || flags.len() != n {
            return Err(PyValueError::new_err("columns of different length"));
        }
        let chunk = toolpaths::Chunk {
            first_sample,
            dp: dp.as_slice()?,
            load: load.as_slice()?,
            rp: rp.as_slice()?,
            factor: factor.as_slice()?,
            v_plan: v_plan.as_slice()?,
            entry: entry.as_slice()?,
            flags: flags.as_slice()?,
        };
        let mut actual = vec![0.0_f32; n];
        let (tracker, stretches) = (&mut self.inner, &mut self.stretches);
        py.detach(|| {
            let mut out = toolpaths::PerSample { actual_mm: &mut actual, ..Default::default() };
            match stretches {
                Some(stretches) => stretches.feed(tracker, &chunk, &mut out),
                None => tracker.feed(&chunk, &mut out),
            }
        });
        self.check_path()?;
        Ok(actual.into_pyarray(py))
    }
}

type Pair<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>);

fn pair<'py>(py: Python<'py>, range: &MinMax) -> Pair<'py> {
    (PyArray1::from_slice(py, &range.min), PyArray1::from_slice(py, &range.max))
}

fn deviation_dict<'py>(py: Python<'py>, d: &DeviationSummary) -> PyResult<Bound<'py, PyDict>> {
    let worst = PyDict::new(py);
    worst.set_item("line", d.worst.line)?;
    worst.set_item("t_s", d.worst.t_s)?;
    worst.set_item("position", d.worst.position.clone())?;
    let dict = PyDict::new(py);
    dict.set_item("max_mm", d.max_mm)?;
    dict.set_item("rms_mm", d.rms_mm)?;
    dict.set_item("mean_mm", d.mean_mm)?;
    dict.set_item("p95_mm", d.p95_mm)?;
    dict.set_item("p99_mm", d.p99_mm)?;
    dict.set_item("p997_mm", d.p997_mm)?;
    dict.set_item("left_mm", d.left_mm)?;
    dict.set_item("right_mm", d.right_mm)?;
    dict.set_item("worst", worst)?;
    Ok(dict)
}

fn summary_dict<'py>(py: Python<'py>, s: &Summary) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("samples", s.samples)?;
    dict.set_item("path_length_mm", s.path_length_mm)?;
    dict.set_item("merged", (s.merged.blocks, s.merged.max_mm))?;
    dict.set_item("setpoint", deviation_dict(py, &s.setpoint)?)?;
    dict.set_item("actual", deviation_dict(py, &s.actual)?)?;
    dict.set_item("following_error", s.following_error.iter().map(|f| (f.max, f.rms)).collect::<Vec<_>>())?;
    dict.set_item("programmed_reached_pct", s.feed.programmed_reached_pct)?;
    dict.set_item("max_over_pct", s.feed.max_over_pct)?;
    dict.set_item("feed_s", s.feed.feed_s)?;
    dict.set_item("rapid_s", s.feed.rapid_s)?;
    dict.set_item("standstill_s", s.feed.standstill_s)?;
    dict.set_item("path_change_mm", s.override_.path_change_mm)?;
    dict.set_item("velocity_ratio_error_pct", s.override_.velocity_ratio_error_pct)?;
    dict.set_item("settling_ok", s.override_.settling_ok)?;
    dict.set_item("settling_s", s.override_.settling_s.map(|(taken, _)| taken))?;
    dict.set_item("settling_allowed_s", s.override_.settling_s.map(|(_, allowed)| allowed))?;
    dict.set_item("lag_max_mm", s.lag_max_mm)?;
    dict.set_item("missing_mm", s.missing_mm)?;
    dict.set_item("reached_line", s.reached_line)?;
    dict.set_item("completed", s.completed)?;
    dict.set_item("limits", s.limits.rows().to_vec())?;
    Ok(dict)
}
