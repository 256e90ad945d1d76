//! Looking into CNC tasks that execute rw_SymPas programs.

use motion_kernel::tasks::Value;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;

use crate::kernel::{Mcu, known_task};

#[pymethods]
impl Mcu {
    /// Source lines before which the task stops; False without a rw_SymPas program.
    fn break_at(&mut self, task: usize, lines: Vec<u32>) -> PyResult<bool> {
        Ok(self.kernel.break_at(known_task(task)?, lines))
    }
    /// One source line, called routines included.
    fn step_over(&mut self, task: usize) -> PyResult<()> {
        self.kernel.step_over(known_task(task)?);
        Ok(())
    }
    /// To the end of the routine being executed.
    fn step_out(&mut self, task: usize) -> PyResult<()> {
        self.kernel.step_out(known_task(task)?);
        Ok(())
    }
    /// Names of the events that the task has enabled.
    fn enabled_events(&self, task: usize) -> PyResult<Vec<&'static str>> {
        Ok(self.kernel.enabled_events(known_task(task)?))
    }
    /// Names of the routines being executed, the main program first.
    fn calls(&self, task: usize) -> PyResult<Vec<String>> {
        Ok(self.kernel.calls(known_task(task)?).into_iter().map(str::to_owned).collect())
    }
    /// Rows of (name, belongs to the main program, value).
    fn task_variables(&self, py: Python<'_>, task: usize) -> PyResult<Vec<(String, bool, Py<PyAny>)>> {
        let rows = self.kernel.variables(known_task(task)?).into_iter().map(|(variable, value)| {
            let value = match value {
                Value::Boolean(on) => on.into_py_any(py),
                Value::Integer(number) | Value::Axis(number) => number.into_py_any(py),
                Value::Timer(ticks) => ticks.into_py_any(py),
                Value::Real(number) => number.into_py_any(py),
            };
            Ok((variable.name.clone(), variable.slot.is_global(), value?))
        });
        rows.collect()
    }
    fn has_overflowed(&self, task: usize) -> PyResult<bool> {
        Ok(self.kernel.has_overflowed(known_task(task)?))
    }
    /// Sets CLOCK.
    fn set_clock(&mut self, ticks: u32) {
        self.kernel.set_clock(ticks);
    }
}
