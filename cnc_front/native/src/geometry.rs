//! `cnc_front._native.toolpaths`, second part: chords of a driven path, height maps that tools cut, nearest points.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use toolpaths::{Met, Move, Profile, Shape, Watch};

pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Chords>()?;
    module.add_class::<HeightMap>()?;
    module.add_class::<Nearest>()
}

type Columns2<'py> = Bound<'py, PyArray2<f64>>;
/// Chords (n, 6), tags, first samples.
type ChordColumns<'py> = (Columns2<'py>, Bound<'py, PyArray1<u64>>, Bound<'py, PyArray1<u64>>);

/// Rows of `width` finite numbers.
fn rows<'a>(array: &'a PyReadonlyArray2<'_, f64>, width: usize, what: &str) -> PyResult<&'a [f64]> {
    let values = array.as_slice()?;
    if array.shape()[1] != width || values.iter().any(|x| !x.is_finite()) {
        return Err(PyValueError::new_err(format!("{what}: rows of {width} finite numbers expected")));
    }
    Ok(values)
}

fn point(row: &[f64]) -> [f64; 3] {
    [row[0], row[1], row[2]]
}

/// A driven path as few straight pieces, from samples in chunks of any size.
#[pyclass(module = "cnc_front._native.toolpaths")]
pub struct Chords {
    inner: toolpaths::Chords,
}

#[pymethods]
impl Chords {
    #[new]
    fn new(tolerance_mm: f64) -> Chords {
        Chords { inner: toolpaths::Chords::new(tolerance_mm) }
    }
    /// Points (n, 3), the tag of the piece that leads to each, the number of the first sample. Finished chords as
    /// rows (from, to), their tags and first samples.
    fn feed<'py>(
        &mut self,
        py: Python<'py>,
        points: PyReadonlyArray2<'_, f64>,
        tags: PyReadonlyArray1<'_, u64>,
        first_sample: u64,
    ) -> PyResult<ChordColumns<'py>> {
        let (points, tags) = (rows(&points, 3, "points")?, tags.as_slice()?);
        if points.len() != 3 * tags.len() {
            return Err(PyValueError::new_err("as many tags as points expected"));
        }
        let mut out = Vec::new();
        py.detach(|| {
            for ((row, tag), sample) in points.chunks_exact(3).zip(tags).zip(first_sample..) {
                self.inner.push(point(row), *tag, sample, &mut out);
            }
        });
        chords(py, &out)
    }
    /// The chord that is still open.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<ChordColumns<'py>> {
        let mut out = Vec::new();
        self.inner.finish(&mut out);
        chords(py, &out)
    }
}

fn chords<'py>(py: Python<'py>, list: &[toolpaths::Chord]) -> PyResult<ChordColumns<'py>> {
    let moves: Vec<f64> = list.iter().flat_map(|c| c.from.into_iter().chain(c.to)).collect();
    let tags: Vec<u64> = list.iter().map(|c| c.tag).collect();
    let samples: Vec<u64> = list.iter().map(|c| c.sample).collect();
    Ok((moves.into_pyarray(py).reshape([list.len(), 6])?, tags.into_pyarray(py), samples.into_pyarray(py)))
}

/// Heights at the middles of square cells, cut by rotating tools.
#[pyclass(module = "cnc_front._native.toolpaths")]
pub struct HeightMap {
    inner: toolpaths::HeightMap,
}

#[pymethods]
impl HeightMap {
    /// `z` is (ny, nx), its first node at (x0 + step / 2, y0 + step / 2); -infinity where nothing is.
    #[new]
    fn new(x0: f64, y0: f64, step: f64, z: PyReadonlyArray2<'_, f64>) -> PyResult<HeightMap> {
        let sound = z.as_slice()?.iter().all(|h| !h.is_nan() && *h < f64::INFINITY);
        if !(sound && step > 0.0 && step.is_finite() && x0.is_finite() && y0.is_finite()) {
            return Err(PyValueError::new_err("heights, place and step of a height map must be numbers"));
        }
        Ok(HeightMap { inner: toolpaths::HeightMap::new(x0, y0, step, z.shape()[1], z.as_slice()?.to_vec()) })
    }
    /// Underside of the body: nothing is cut below.
    #[getter]
    fn get_floor(&self) -> f64 {
        self.inner.floor
    }
    #[setter]
    fn set_floor(&mut self, z: f64) {
        self.inner.floor = z;
    }
    /// A copy of the heights.
    fn z<'py>(&self, py: Python<'py>) -> PyResult<Columns2<'py>> {
        self.inner.z.clone().into_pyarray(py).reshape([self.inner.ny, self.inner.nx])
    }
    /// Source line of the move that lowered each node last, 0 where none did.
    fn line<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        self.inner.line.clone().into_pyarray(py).reshape([self.inner.ny, self.inner.nx])
    }
    /// Lowers the map to what a tool leaves on moves (n, 6) of its tip. `margin` is that of rapids, None for feed moves;
    /// `bodies` are radius and height above the tip. Rows: most height removed, x, y, volume; the same of what a rapid
    /// met, and of what a body met; number of that body.
    #[allow(clippy::too_many_arguments)]
    fn cut<'py>(
        &mut self,
        py: Python<'py>,
        moves: PyReadonlyArray2<'_, f64>,
        lines: PyReadonlyArray1<'_, u32>,
        radius: f64,
        corner: f64,
        margin: Option<f64>,
        bodies: Vec<(f64, f64)>,
    ) -> PyResult<Columns2<'py>> {
        let (values, lines) = (rows(&moves, 6, "moves")?, lines.as_slice()?);
        if values.len() != 6 * lines.len() {
            return Err(PyValueError::new_err("as many lines as moves expected"));
        }
        for (radius, _) in &bodies {
            profile(*radius, 0.0)?;
        }
        let (tool, watch) = (profile(radius, corner)?, Watch { margin, bodies });
        let inner = &mut self.inner;
        let passed: Vec<f64> = py.detach(|| {
            let one = |(row, line): (&[f64], &u32)| {
                let p = inner.pass(tool, one_move(row), *line, &watch);
                let columns = [p.cut, p.rapid, p.body].into_iter().flat_map(columns);
                columns.chain([p.which as f64]).collect::<Vec<_>>()
            };
            values.chunks_exact(6).zip(lines).flat_map(one).collect()
        });
        passed.into_pyarray(py).reshape([lines.len(), 13])
    }
    /// What a body meets on moves; nothing is removed. Rows: most height, x, y, volume.
    fn probe<'py>(
        &self,
        py: Python<'py>,
        moves: PyReadonlyArray2<'_, f64>,
        radius: f64,
        corner: f64,
    ) -> PyResult<Columns2<'py>> {
        let values = rows(&moves, 6, "moves")?;
        let (body, inner) = (profile(radius, corner)?, &self.inner);
        let met: Vec<Met> = py.detach(|| values.chunks_exact(6).map(|row| inner.probe(body, one_move(row))).collect());
        table(py, &met)
    }
    /// Raises the map to triangles (n, 9); with `grow` also the nodes that far beside them.
    fn raise_mesh(&mut self, py: Python<'_>, triangles: PyReadonlyArray2<'_, f64>, grow: f64) -> PyResult<()> {
        let values = rows(&triangles, 9, "triangles")?;
        let inner = &mut self.inner;
        py.detach(|| {
            for row in values.chunks_exact(9) {
                inner.raise([point(row), point(&row[3..]), point(&row[6..])], grow);
            }
            inner.settle();
        });
        Ok(())
    }
}

fn profile(radius: f64, corner: f64) -> PyResult<Profile> {
    let sound = radius > 0.0 && radius.is_finite() && (0.0..=radius).contains(&corner);
    sound.then_some(Profile { radius, corner }).ok_or_else(|| PyValueError::new_err("0 <= corner <= radius expected"))
}

fn one_move(row: &[f64]) -> Move {
    Move { from: point(row), to: point(&row[3..]) }
}

fn columns(m: Met) -> [f64; 4] {
    [m.depth, m.at[0], m.at[1], m.volume]
}

fn table<'py>(py: Python<'py>, met: &[Met]) -> PyResult<Columns2<'py>> {
    let values: Vec<f64> = met.iter().copied().flat_map(columns).collect();
    values.into_pyarray(py).reshape([met.len(), 4])
}

/// Nearest points of a drawing or surface.
#[pyclass(frozen, module = "cnc_front._native.toolpaths")]
pub struct Nearest {
    inner: toolpaths::Nearest,
}

#[pymethods]
impl Nearest {
    /// Per shape its kind and nine numbers: 0 segment (from, to), 1 arc (centre x, y, radius, first angle, sweep in
    /// radians), 2 triangle (corners, counter-clockwise from outside).
    #[new]
    fn new(kinds: PyReadonlyArray1<'_, u8>, data: PyReadonlyArray2<'_, f64>) -> PyResult<Nearest> {
        let (kinds, values) = (kinds.as_slice()?, rows(&data, 9, "shapes")?);
        if values.len() != 9 * kinds.len() {
            return Err(PyValueError::new_err("as many kinds as shapes expected"));
        }
        let shape = |(kind, v): (&u8, &[f64])| match kind {
            0 => Shape::Segment([point(v), point(&v[3..])]),
            1 => Shape::Arc { center: [v[0], v[1]], radius: v[2], start: v[3], sweep: v[4] },
            _ => Shape::Triangle([point(v), point(&v[3..]), point(&v[6..])]),
        };
        let shapes = kinds.iter().zip(values.chunks_exact(9)).map(shape).collect();
        let inner = toolpaths::Nearest::new(shapes).ok_or_else(|| PyValueError::new_err("no shapes"))?;
        Ok(Nearest { inner })
    }
    /// For points (n, 3): distance, foot (n, 3), number of the shape, whether the point lies beyond an end of it, and
    /// the side of a closed surface (+1 outside).
    fn find<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'_, f64>) -> PyResult<Bound<'py, PyAny>> {
        let values = rows(&points, 3, "points")?;
        let inner = &self.inner;
        let mut near = toolpaths::Near::default();
        let found: Vec<(toolpaths::Found, f64)> = py.detach(|| {
            let one = |row: &[f64]| {
                let found = inner.find(point(row), &mut near);
                (found, inner.side(&found, point(row)))
            };
            values.chunks_exact(3).map(one).collect()
        });
        let feet: Vec<f64> = found.iter().flat_map(|f| f.0.foot).collect();
        let columns = (
            found.iter().map(|f| f.0.distance).collect::<Vec<_>>().into_pyarray(py),
            feet.into_pyarray(py).reshape([found.len(), 3])?,
            found.iter().map(|f| f.0.shape as u32).collect::<Vec<_>>().into_pyarray(py),
            found.iter().map(|f| f.0.beyond).collect::<Vec<_>>().into_pyarray(py),
            found.iter().map(|f| f.1).collect::<Vec<_>>().into_pyarray(py),
        );
        Ok(columns.into_pyobject(py)?.into_any())
    }
}
