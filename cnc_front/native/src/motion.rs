//! Motion commands beside lines, circles and helices: home searches, 3-D circles, set points from the spooler, latches.

use motion_kernel::axes::{AxisList, MAX_AXES};
use motion_kernel::trajectory::Hmp3d;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::kernel::{Mcu, axis_list, outcome, set};

#[pymethods]
impl Mcu {
    /// jhi with distances, jhl ("left") and jhr ("right"): outcome as for `motion`.
    fn search(&mut self, kind: &str, axes: Vec<usize>, distances: Vec<f64>) -> PyResult<&'static str> {
        let list = axis_list(&axes, &distances)?;
        match kind {
            "index" => Ok(outcome(self.kernel.jhi(&list, &distances))),
            "left" => Ok(outcome(self.kernel.jhl(&list))),
            "right" => Ok(outcome(self.kernel.jhr(&list))),
            _ => Err(PyValueError::new_err("a search is for index, left or right")),
        }
    }
    fn shp(&mut self, axis: usize, position: f64) -> PyResult<bool> {
        self.check(axis)?;
        Ok(self.kernel.shp(axis, position))
    }
    fn lps(&mut self, axis: usize, mst: u32) -> PyResult<()> {
        self.check(axis)?;
        self.kernel.lps(axis, mst);
        Ok(())
    }
    /// Reads the latched position, which clears lpsf.
    fn rdlp(&mut self, axis: usize) -> PyResult<f64> {
        self.check(axis)?;
        Ok(self.kernel.rdlp(axis))
    }
    /// mca3d, mcr3d, smca3d, smcr3d.
    #[allow(clippy::too_many_arguments)] // the command has these parameters
    fn circle_3d(
        &mut self,
        kind: &str,
        axes: [usize; 3],
        center: [f64; 3],
        normal: [f64; 3],
        phi: f64,
        vl: f64,
        ac: f64,
        tvl: f64,
    ) -> PyResult<&'static str> {
        set(&axes)?;
        let list = AxisList::new(&axes);
        let ([dtca1, dtca2, dtca3], [pn1, pn2, pn3], dtm) = (center, normal, [0.0; MAX_AXES]);
        let parameters = Hmp3d { ac, vl, tvl, phi, dtca1, dtca2, dtca3, pn1, pn2, pn3, dtm };
        Ok(outcome(match kind {
            "mca3d" => self.kernel.mca3d(&list, &parameters),
            "mcr3d" => self.kernel.mcr3d(&list, &parameters),
            "smca3d" => self.kernel.smca3d(&list, &parameters),
            "smcr3d" => self.kernel.smcr3d(&list, &parameters),
            _ => return Err(PyValueError::new_err("unknown motion command")),
        }))
    }
    /// spd (without index), spda, spdr.
    fn points(&mut self, kind: &str, axis: usize, points: Vec<f64>, pcap_index: i32) -> PyResult<&'static str> {
        self.check(axis)?;
        Ok(outcome(match kind {
            "spd" => self.kernel.spd(axis, &points),
            "spda" => self.kernel.spda(axis, &points, pcap_index),
            "spdr" => self.kernel.spdr(axis, &points, pcap_index),
            _ => return Err(PyValueError::new_err("unknown motion command")),
        }))
    }
    fn sstvl(&mut self, axes: Vec<usize>, tvl: f64) -> PyResult<()> {
        self.kernel.sstvl(set(&axes)?, tvl);
        Ok(())
    }
}
