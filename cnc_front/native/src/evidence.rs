//! What `Tracker.evidence` hands to the diagnosis in Python: the sums of toolpaths::Evidence as plain dicts and arrays.

use std::collections::BTreeMap;

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use toolpaths::{
    AxisFit, AxisShare, BlockFit, CONIC, Evidence, Exchange, ExchangeKind, HARMONICS, MOTION, Round, TraceEvidence,
};

/// {"setpoint": trace, "actual": trace, "axes": [...], "circles": [...], "lines": {block: line}}; see toolpaths/diagnosis.py.
pub fn dict<'py>(py: Python<'py>, evidence: &Evidence, axes: usize) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("setpoint", trace(py, &evidence.setpoint, axes)?)?;
    dict.set_item("actual", trace(py, &evidence.actual, axes)?)?;
    dict.set_item("axes", list(py, evidence.axes.iter().map(|fit| axis(py, fit)))?)?;
    dict.set_item("circles", list(py, evidence.rounds().map(|round| circle(py, round)))?)?;
    dict.set_item("lines", lines(evidence))?;
    let edges: Vec<f64> = (0..toolpaths::HISTOGRAM_BINS).map(toolpaths::bin_edge).collect();
    dict.set_item("bin_edges", edges.into_pyarray(py))?;
    Ok(dict)
}

/// Source lines of all blocks that are named.
fn lines(evidence: &Evidence) -> BTreeMap<u32, u32> {
    let mut named = Vec::new();
    for trace in [&evidence.setpoint, &evidence.actual] {
        named.extend(trace.blocks().iter().map(|fit| fit.at));
        named.extend(trace.axes().iter().map(|share| share.at));
        named.extend(trace.exchanges().iter().map(|found| found.at));
    }
    named.extend(evidence.rounds().flat_map(|round| [round.blocks.0, round.blocks.1]));
    named.iter().map(|at| (at.block, at.line)).collect()
}

fn list<'py>(
    py: Python<'py>,
    items: impl Iterator<Item = PyResult<Bound<'py, PyDict>>>,
) -> PyResult<Bound<'py, PyList>> {
    PyList::new(py, items.collect::<PyResult<Vec<_>>>()?)
}

/// A full symmetric matrix from its upper triangle.
fn symmetric<'py>(py: Python<'py>, n: usize, upper: &[f64]) -> PyResult<Bound<'py, PyAny>> {
    let mut full = vec![0.0; n * n];
    let pairs = (0..n).flat_map(|i| (i..n).map(move |j| (i, j)));
    for ((i, j), value) in pairs.zip(upper) {
        full[i * n + j] = *value;
        full[j * n + i] = *value;
    }
    Ok(full.into_pyarray(py).reshape([n, n])?.into_any())
}

fn trace<'py>(py: Python<'py>, evidence: &TraceEvidence, axes: usize) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("blocks", list(py, evidence.blocks().iter().map(|fit| block(py, fit, axes)))?)?;
    dict.set_item("axes", list(py, evidence.axes().iter().map(|share| share_of(py, share)))?)?;
    dict.set_item("exchanges", list(py, evidence.exchanges().iter().map(|found| exchange(py, found)))?)?;
    Ok(dict)
}

fn block<'py>(py: Python<'py>, fit: &BlockFit, axes: usize) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let weight = fit.weight.max(f64::MIN_POSITIVE);
    dict.set_item("block", fit.at.block)?;
    dict.set_item("samples", fit.samples)?;
    dict.set_item("summed", fit.summed)?;
    dict.set_item("weight", fit.weight)?;
    dict.set_item("mean_mm", fit.offset[..axes].iter().map(|e| e / weight).collect::<Vec<_>>().into_pyarray(py))?;
    dict.set_item("mean_square", fit.squares / weight)?;
    dict.set_item("max_mm", fit.max)?;
    dict.set_item("circle", fit.circle)?;
    dict.set_item("normal", symmetric(py, HARMONICS, &fit.normal)?)?;
    dict.set_item("right", fit.right.to_vec().into_pyarray(py))?;
    dict.set_item("radial_squares", fit.radial_squares)?;
    dict.set_item("conic_normal", symmetric(py, CONIC, &fit.conic_normal)?)?;
    dict.set_item("conic_right", fit.conic_right.to_vec().into_pyarray(py))?;
    dict.set_item("conic_squares", fit.conic_squares)?;
    dict.set_item("mm_per_unit", fit.scales[..axes].to_vec())?;
    Ok(dict)
}

fn share_of<'py>(py: Python<'py>, share: &AxisShare) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let sums = [
        ("w", share.w),
        ("wx", share.wx),
        ("wxx", share.wxx),
        ("e", share.e),
        ("ex", share.ex),
        ("wvv", share.wvv),
        ("ev", share.ev),
        ("squares", share.squares),
        ("most_mm", share.most),
        ("mm_per_unit", share.scale),
    ];
    for (name, value) in sums {
        dict.set_item(name, value)?;
    }
    dict.set_item("block", share.at.block)?;
    Ok(dict)
}

fn exchange<'py>(py: Python<'py>, found: &Exchange) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("kind", if found.kind == ExchangeKind::Swapped { "swapped" } else { "reversed" })?;
    dict.set_item("axes", found.axes)?;
    dict.set_item("block", found.at.block)?;
    dict.set_item("samples", found.samples)?;
    dict.set_item("max_mm", found.max_mm)?;
    Ok(dict)
}

fn axis<'py>(py: Python<'py>, fit: &AxisFit) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("samples", fit.samples)?;
    dict.set_item("normal", symmetric(py, MOTION, &fit.normal)?)?;
    dict.set_item("right", fit.right.to_vec().into_pyarray(py))?;
    dict.set_item("squares", fit.squares)?;
    dict.set_item("reversals", fit.reversals)?;
    dict.set_item("range", fit.range)?;
    dict.set_item("velocity", fit.velocity)?;
    dict.set_item("acceleration", fit.acceleration)?;
    dict.set_item("jerk", fit.jerk)?;
    dict.set_item("acceleration_bins", fit.acceleration_bins.to_vec().into_pyarray(py))?;
    dict.set_item("jerk_bins", fit.jerk_bins.to_vec().into_pyarray(py))?;
    Ok(dict)
}

fn circle<'py>(py: Python<'py>, round: &Round) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("blocks", (round.blocks.0.block, round.blocks.1.block))?;
    dict.set_item("axes", round.axes)?;
    dict.set_item("center", round.center)?;
    dict.set_item("radius_mm", round.radius)?;
    dict.set_item("ccw", round.ccw)?;
    dict.set_item("vl", round.vl)?;
    let column = |f: fn(&toolpaths::RoundBin) -> f64| round.bins.iter().map(f).collect::<Vec<_>>().into_pyarray(py);
    dict.set_item("samples", round.bins.iter().map(|b| b.samples).collect::<Vec<_>>().into_pyarray(py))?;
    dict.set_item("mean_mm", column(|b| b.sum / f64::from(b.samples)))?;
    dict.set_item("min_mm", column(|b| b.min))?;
    dict.set_item("min_angle", column(|b| b.min_angle))?;
    dict.set_item("max_mm", column(|b| b.max))?;
    dict.set_item("max_angle", column(|b| b.max_angle))?;
    Ok(dict)
}
