//! Commands of chapter 4.4 that are plain values: registers by name, the card, filters and zero points.

use motion_kernel::card::{CONTROLLER_PARAMETERS, Led};
use motion_kernel::machine::PidfGains;
use motion_kernel::named::{axis_register, system_register};
use motion_kernel::registers::ControllerFlags;
use motion_kernel::{Stop, units};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::chunk::Chunk;
use crate::kernel::{Mcu, known_task, set};
use crate::machine::Machine;

#[pymethods]
impl Mcu {
    /// Forgets what was recorded; `pass_on` goes on from here.
    fn begin_recording(&mut self) {
        self.kernel.begin_trace(&mut self.recording);
    }
    /// Lets sample intervals pass, whatever happens in them; comes back earlier behind one that raised the interrupt of
    /// the PC. Returns how many passed.
    fn pass_on(&mut self, py: Python<'_>, samples: u64) -> u64 {
        let (kernel, recording) = (&mut self.kernel, &mut self.recording);
        py.detach(|| kernel.pass_to_interrupt(samples, recording))
    }
    fn take_recording(&mut self, py: Python<'_>) -> PyResult<Chunk> {
        Chunk::new(py, std::mem::take(&mut self.recording), Stop::Budget, Vec::new())
    }
    /// txbf2 of a system file.
    fn initialise(&mut self, machine: &Machine) {
        self.kernel.initialise(machine.inner.clone());
    }

    /// A register of an axis by name.
    fn read_axis_register(&self, axis: usize, name: &str) -> PyResult<f64> {
        self.check(axis)?;
        let register = axis_register(name).ok_or_else(|| unknown(name))?;
        Ok((register.read)(&self.kernel, axis))
    }
    /// Writes it; false if the value is not allowed.
    fn write_axis_register(&mut self, axis: usize, name: &str, value: f64) -> PyResult<bool> {
        self.check(axis)?;
        let write = axis_register(name).and_then(|r| r.write).ok_or_else(|| unknown(name))?;
        Ok(write(&mut self.kernel, axis, value))
    }
    fn read_register(&self, name: &str) -> PyResult<f64> {
        Ok((system_register(name).ok_or_else(|| unknown(name))?.read)(&self.kernel))
    }
    fn write_register(&mut self, name: &str, value: f64) -> PyResult<bool> {
        Ok((system_register(name).ok_or_else(|| unknown(name))?.write)(&mut self.kernel, value))
    }
    /// The operating system starts again.
    fn reboot(&mut self) {
        self.kernel.reboot();
    }
    /// Digi word of an axis.
    fn rddigi(&self, axis: usize) -> PyResult<u32> {
        self.check(axis)?;
        Ok(self.kernel.rddigi(axis))
    }
    fn rdigi(&mut self, axis: usize) -> PyResult<()> {
        self.check(axis)?;
        self.kernel.rdigi(axis);
        Ok(())
    }
    fn rddigo(&self) -> u32 {
        self.kernel.rddigo()
    }
    fn wrdigo(&mut self, axis: usize, digo: u32) -> PyResult<()> {
        self.check(axis)?;
        self.kernel.wrdigo(axis, digo);
        Ok(())
    }
    fn wrdigob(&mut self, axis: usize, bitnr: u32, on: bool) -> PyResult<()> {
        self.check(axis)?;
        self.kernel.wrdigob(axis, bitnr, on);
        Ok(())
    }
    /// A fault from outside: of an axis (cut_encoder, drop_drive, block), or of the card (undervoltage, bus_error).
    fn play(&mut self, fault: &str, axis: usize, on: bool) -> PyResult<()> {
        self.check(axis)?;
        match fault {
            "cut_encoder" => self.kernel.cut_encoder(axis, on),
            "drop_drive" => self.kernel.drop_drive(axis, on),
            "block" => self.kernel.block(axis, on),
            "undervoltage" => self.kernel.undervoltage(on),
            "bus_error" => self.kernel.bus_error(),
            _ => return Err(PyValueError::new_err("unknown fault")),
        }
        Ok(())
    }
    fn rdifs(&self) -> u32 {
        self.kernel.rdifs().0
    }
    fn rifs(&mut self) {
        self.kernel.rifs();
    }
    fn rdcontrollerflags(&self, axis: usize) -> PyResult<u32> {
        self.check(axis)?;
        Ok(self.kernel.rdControllerFlags(axis).0)
    }
    fn wrcontrollerflags(&mut self, axis: usize, flags: u32) -> PyResult<()> {
        self.check(axis)?;
        self.kernel.wrControllerFlags(axis, ControllerFlags(flags));
        Ok(())
    }

    /// kp, ki, kd, kpl, kfcv, kfca.
    fn rdf(&self, axis: usize) -> PyResult<[f64; 6]> {
        self.check(axis)?;
        let PidfGains { kp, ki, kd, kpl, kfcv, kfca } = self.kernel.rdf(axis);
        Ok([kp, ki, kd, kpl, kfcv, kfca])
    }
    fn uf(&mut self, axis: usize, gains: [f64; 6]) -> PyResult<bool> {
        self.check(axis)?;
        let [kp, ki, kd, kpl, kfcv, kfca] = gains;
        Ok(self.kernel.uf(axis, &PidfGains { kp, ki, kd, kpl, kfcv, kfca }))
    }
    fn wrmcp(&mut self, axis: usize, mcp: i32) -> PyResult<()> {
        self.check(axis)?;
        self.kernel.wrmcp(axis, mcp);
        Ok(())
    }
    fn clv(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.clv(set(&axes)?);
        Ok(())
    }
    fn ra(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.ra(set(&axes)?);
        Ok(())
    }
    fn rptodp(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.RPtoDP(set(&axes)?);
        Ok(())
    }
    fn ctru(&mut self, pu: i32, tu: i32) -> bool {
        self.kernel.ctru(pu, tu)
    }
    fn azo(&mut self, number: i32) {
        self.kernel.azo(number);
    }
    /// szpa, or szpr with `relative`.
    fn set_zero(&mut self, axis: usize, position: f64, relative: bool) -> PyResult<bool> {
        self.check(axis)?;
        Ok(if relative { self.kernel.szpr(axis, position) } else { self.kernel.szpa(axis, position) })
    }
    fn rdsampletime(&self) -> i32 {
        self.kernel.rdSampleTime().1
    }
    fn rdslsp(&self, axis: usize) -> PyResult<f64> {
        self.check(axis)?;
        Ok(self.kernel.rdslsp(axis).1)
    }

    /// tskinfo of a task: bit 0 an open string, bit 1 a closed one.
    fn gettskinfo(&self, task: usize) -> PyResult<u32> {
        Ok(self.kernel.gettskinfo(known_task(task)?))
    }
    fn gettskstr(&mut self, task: usize) -> PyResult<String> {
        Ok(self.kernel.gettskstr(known_task(task)?))
    }

    fn led(&self, colour: &str) -> PyResult<bool> {
        Ok(self.kernel.card().led(led_of(colour)?))
    }
    fn set_led(&mut self, colour: &str, on: bool) -> PyResult<()> {
        self.kernel.card_mut().set_led(led_of(colour)?, on);
        Ok(())
    }
    fn irqpc(&self) -> bool {
        self.kernel.card().irqpc()
    }
    fn interrupts(&self) -> u64 {
        self.kernel.card().interrupts()
    }
    fn set_irqpc(&mut self, on: bool) {
        self.kernel.card_mut().set_irqpc(on);
    }
    /// Someone saves system data in the EEPROM.
    fn program_eeprom(&mut self) {
        self.kernel.card_mut().epc += 1;
    }
    fn epc(&self) -> i32 {
        self.kernel.card().epc
    }
    fn gcr(&self, axis: usize) -> PyResult<i32> {
        self.check(axis)?;
        Ok(self.kernel.card().axes[axis].gcr)
    }
    fn set_gcr(&mut self, axis: usize, value: i32) -> PyResult<bool> {
        self.check(axis)?;
        Ok(self.kernel.wrGCR(axis, value))
    }
    /// The field of `scp`, row by row.
    fn controller_parameters(&self, axis: usize) -> PyResult<Vec<f64>> {
        self.check(axis)?;
        Ok(self.kernel.card().axes[axis].parameters.clone())
    }
    fn set_controller_parameters(&mut self, axis: usize, values: Vec<f64>) -> PyResult<()> {
        self.check(axis)?;
        if values.len() != CONTROLLER_PARAMETERS {
            return Err(PyValueError::new_err("15 x 15 controller parameters"));
        }
        for (cell, value) in values.into_iter().enumerate() {
            self.kernel.set_controller_parameter(axis, cell, value);
        }
        Ok(())
    }

    /// An application variable of the system, or of an axis.
    fn variable_int(&self, axis: Option<usize>, index: usize) -> PyResult<i32> {
        self.variables(axis)?.int.get(index).copied().ok_or_else(no_variable)
    }
    fn variable_dbl(&self, axis: Option<usize>, index: usize) -> PyResult<f64> {
        self.variables(axis)?.dbl.get(index).copied().ok_or_else(no_variable)
    }
    fn set_variable_int(&mut self, axis: Option<usize>, index: usize, value: i32) -> PyResult<()> {
        *self.variables_mut(axis)?.int.get_mut(index).ok_or_else(no_variable)? = value;
        Ok(())
    }
    fn set_variable_dbl(&mut self, axis: Option<usize>, index: usize, value: f64) -> PyResult<()> {
        *self.variables_mut(axis)?.dbl.get_mut(index).ok_or_else(no_variable)? = value;
        Ok(())
    }

    /// (error code, the first bytes of the common buffer of a task).
    fn common_buffer<'py>(&self, py: Python<'py>, task: usize, size: usize) -> (i32, Bound<'py, PyBytes>) {
        self.kernel
            .card()
            .common_buffer(task, size)
            .map_or_else(|code| (code, PyBytes::new(py, &[])), |b| (0, PyBytes::new(py, b)))
    }
    fn set_common_buffer(&mut self, task: usize, bytes: &[u8]) -> i32 {
        self.kernel.card_mut().set_common_buffer(task, bytes).err().unwrap_or(0)
    }
}

impl Mcu {
    fn variables(&self, axis: Option<usize>) -> PyResult<&motion_kernel::card::Variables> {
        let card = self.kernel.card();
        match axis {
            None => Ok(&card.variables),
            Some(axis) => self.check(axis).map(|()| &card.axes[axis].variables),
        }
    }
    fn variables_mut(&mut self, axis: Option<usize>) -> PyResult<&mut motion_kernel::card::Variables> {
        if let Some(axis) = axis {
            self.check(axis)?;
        }
        let card = self.kernel.card_mut();
        Ok(axis.map_or(&mut card.variables, |axis| &mut card.axes[axis].variables))
    }
}

fn unknown(name: &str) -> PyErr {
    PyValueError::new_err(format!("no register {name}"))
}
fn no_variable() -> PyErr {
    PyIndexError::new_err("application variables are 0 to 99")
}
fn led_of(colour: &str) -> PyResult<Led> {
    match colour {
        "green" => Ok(Led::Green),
        "red" => Ok(Led::Red),
        "yellow" => Ok(Led::Yellow),
        _ => Err(PyValueError::new_err("LEDs are green, red and yellow")),
    }
}

/// Names of the units of `ctru`: positions, times; a number is a place in the list.
#[pyfunction]
pub fn trajectory_units() -> (Vec<&'static str>, Vec<&'static str>) {
    let positions = units::POSITION_UNITS.iter().map(|row| row.0);
    (positions.collect(), units::TIME_UNITS.iter().map(|row| row.0).collect())
}
