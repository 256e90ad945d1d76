//! The resource interface: descriptors as tuples, the table, the board and the memory of the host.

use motion_kernel::registers::Options;
use motion_kernel::resources::{Code, DEVICES, Device, Endat, ObjectDescriptor, Range};
use pyo3::exceptions::{PyIndexError, PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::kernel::Mcu;

/// handle, bus, device, index, sub-index, data type, access
type Descriptor = (i32, i32, i32, i32, i32, i32, i32);
/// first and last number, name, data type, readable, writable, whether Index and SubIndex are axes, and the Index of a
/// function
type Row = (i32, i32, &'static str, i32, bool, bool, bool, bool, Option<i32>);

fn descriptor(d: Descriptor) -> ObjectDescriptor {
    let (handle, bus, device, index, sub_index, data_type, access) = d;
    ObjectDescriptor { handle, bus, device, index, sub_index, data_type, access }
}

/// (return code, handle, value)
fn answer<T: Default>(d: &ObjectDescriptor, read: Result<T, Code>) -> (i32, i32, T) {
    match read {
        Ok(value) => (Code::Ok as i32, d.handle, value),
        Err(code) => (code as i32, d.handle, T::default()),
    }
}

#[pymethods]
impl Mcu {
    fn rd_option_int(&mut self, d: Descriptor) -> (i32, i32, i32) {
        let mut d = descriptor(d);
        let read = self.kernel.rdOptionInt(&mut d);
        answer(&d, read)
    }
    fn rd_option_dbl(&mut self, d: Descriptor) -> (i32, i32, f64) {
        let mut d = descriptor(d);
        let read = self.kernel.rdOptionDbl(&mut d);
        answer(&d, read)
    }
    fn wr_option_int(&mut self, d: Descriptor, value: i32) -> (i32, i32) {
        let mut d = descriptor(d);
        (self.kernel.wrOptionInt(&mut d, value) as i32, d.handle)
    }
    fn wr_option_dbl(&mut self, d: Descriptor, value: f64) -> (i32, i32) {
        let mut d = descriptor(d);
        (self.kernel.wrOptionDbl(&mut d, value) as i32, d.handle)
    }
    /// Options of the operating system and the board.
    fn resource_options(&self) -> Vec<&'static str> {
        self.kernel.resources().options.names().collect()
    }
    fn set_resource_options(&mut self, names: Vec<String>) -> PyResult<()> {
        let mut options = Options(0);
        for name in &names {
            let option = Options::by_name(name);
            options.set(option.ok_or_else(|| PyValueError::new_err(format!("there is no option {name}")))?);
        }
        self.kernel.resources_mut().options = options;
        Ok(())
    }
    /// Physical address of new host memory.
    fn alloc_phys_mem(&mut self, size: u32) -> PyResult<u32> {
        let base = self.kernel.resources_mut().memory.alloc(size);
        base.ok_or_else(|| PyMemoryError::new_err(format!("{size} bytes of host memory are not to be had")))
    }
    fn free_phys_mem(&mut self, base: u32) -> bool {
        self.kernel.resources_mut().memory.free(base)
    }
    fn read_host<'py>(&mut self, py: Python<'py>, address: u64, size: usize) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.kernel.resources_mut().memory.at(address, size);
        bytes.map(|bytes| PyBytes::new(py, bytes)).ok_or_else(outside)
    }
    fn write_host(&mut self, address: u64, bytes: &[u8]) -> PyResult<()> {
        let place = self.kernel.resources_mut().memory.at(address, bytes.len());
        place.map(|place| place.copy_from_slice(bytes)).ok_or_else(outside)
    }
    /// An axis gets an ENDAT encoder by its environment variable MT (11: version 2.1, 16: 2.2; any other: none).
    fn fit_endat(&mut self, axis: usize, mt: u32, bits: u32) -> PyResult<()> {
        self.check(axis)?;
        let encoder = Endat::new(bits).ok_or_else(|| PyValueError::new_err("1 to 32 position bits"))?;
        self.kernel.resources_mut().axes[axis].endat = matches!(mt, 11 | 16).then_some(encoder);
        Ok(())
    }
    /// The encoder signals an alarm or not; so many of its next transfers fail.
    fn disturb_endat(&mut self, axis: usize, alarm: bool, crc_errors: u32, timeouts: u32) -> PyResult<()> {
        self.check(axis)?;
        let encoder = self.kernel.resources_mut().axes[axis].endat.as_mut();
        let encoder = encoder.ok_or_else(|| PyValueError::new_err("the axis has no ENDAT encoder"))?;
        encoder.alarm = alarm;
        (encoder.crc_to_come, encoder.timeouts_to_come) = (crc_errors, timeouts);
        Ok(())
    }
    /// Resets that the encoder has received.
    fn endat_resets(&self, axis: usize) -> PyResult<u32> {
        self.check(axis)?;
        Ok(self.kernel.resources().axes[axis].endat.as_ref().map_or(0, |encoder| encoder.resets))
    }
    /// Analog inputs of the board as the world outside has them.
    fn set_analog_input(&mut self, channel: usize, digits: i16) -> PyResult<()> {
        let input = self.kernel.resources_mut().ain.get_mut(channel);
        *input.ok_or_else(|| PyIndexError::new_err("analog inputs are 0 to 7"))? = digits;
        Ok(())
    }
    fn analog_outputs(&self) -> [i16; 4] {
        self.kernel.resources().aout
    }
    fn fast_outputs(&self) -> u16 {
        self.kernel.resources().fast
    }
}

fn outside() -> PyErr {
    PyIndexError::new_err("not inside allocated host memory")
}

/// All devices.
#[pyfunction]
pub fn resource_devices() -> Vec<Row> {
    let row = |d: &Device| {
        let axes = [d.index, d.sub_index].map(|range| range == Range::Axis);
        let function = if let Range::Only(function) = d.index { Some(function) } else { None };
        (d.first, d.last, d.name, d.kind as i32, d.read.is_some(), d.write.is_some(), axes[0], axes[1], function)
    };
    DEVICES.iter().flat_map(|table| table.iter()).map(row).collect()
}
