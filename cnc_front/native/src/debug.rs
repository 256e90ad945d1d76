//! Looking into CNC tasks that execute rw_SymPas programs.

use motion_kernel::sap::program::VariableKind;
use motion_kernel::tasks::Value;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat};

use crate::kernel::{Mcu, known_task};

#[pymethods]
impl Mcu {
    /// Places before which the task stops; False without a rw_SymPas program.
    fn break_at(&mut self, task: usize, places: Vec<u32>) -> PyResult<bool> {
        Ok(self.kernel.break_at(known_task(task)?, places))
    }
    /// What is added to the places of a task.
    fn number_lines(&mut self, task: usize, first: u32) -> PyResult<()> {
        self.kernel.number_lines(known_task(task)?, first);
        Ok(())
    }
    /// Files of the program, and what is added to their lines to make places of them; None without a rw_SymPas program.
    fn task_files(&self, task: usize) -> PyResult<Option<Vec<(String, u32)>>> {
        let program = self.kernel.sap_program(known_task(task)?);
        Ok(program.map(|p| p.files.iter().cloned().zip(p.offsets()).collect()))
    }
    /// Places of statements, rising.
    fn break_places(&self, task: usize) -> PyResult<Vec<u32>> {
        Ok(self.kernel.break_places(known_task(task)?))
    }
    /// Place that comes next, or at which the task failed: a line, counted over all files of the program.
    fn place(&self, task: usize) -> PyResult<u32> {
        Ok(self.kernel.place(known_task(task)?))
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
    /// Rows of (name, number of the call in `calls`, value), the main program first.
    fn task_variables(&self, py: Python<'_>, task: usize) -> PyResult<Vec<(String, usize, Py<PyAny>)>> {
        let rows = self.kernel.variables(known_task(task)?).into_iter().map(|(variable, call, value)| {
            let value = match value {
                Value::Boolean(on) => on.into_py_any(py),
                Value::Integer(number) | Value::Axis(number) => number.into_py_any(py),
                Value::Timer(ticks) => ticks.into_py_any(py),
                Value::Real(number) => number.into_py_any(py),
            };
            Ok((variable.name.clone(), call, value?))
        });
        rows.collect()
    }
    /// Names of axes and AXIS variables of the program.
    fn task_axes(&self, task: usize) -> PyResult<Vec<String>> {
        let variables = self.kernel.sap_program(known_task(task)?).map_or(&[][..], |p| &p.variables);
        Ok(variables.iter().filter(|v| v.kind == VariableKind::Axis).map(|v| v.name.clone()).collect())
    }
    /// Sets a variable that the routine being executed sees; ValueError where there is none, or for another type.
    fn set_task_variable(&mut self, task: usize, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = if value.is_instance_of::<PyBool>() {
            Value::Boolean(value.extract()?)
        } else if value.is_instance_of::<PyFloat>() {
            Value::Real(value.extract()?)
        } else {
            value.extract().map(Value::Integer).or_else(|_| value.extract().map(Value::Timer))?
        };
        self.kernel.set_variable(known_task(task)?, name, value).map_err(PyValueError::new_err)
    }
    fn has_overflowed(&self, task: usize) -> PyResult<bool> {
        Ok(self.kernel.has_overflowed(known_task(task)?))
    }
    /// Sets CLOCK.
    fn set_clock(&mut self, ticks: u32) {
        self.kernel.set_clock(ticks);
    }
}
