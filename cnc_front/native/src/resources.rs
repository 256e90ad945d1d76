//! The resource interface: descriptors as tuples, the table, the board and the memory of the host.

use motion_kernel::registers::Options;
use motion_kernel::resources::{CallerMemory, Code, DEVICES, Device, Endat, EndatSetup, ObjectDescriptor, Range};
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIndexError, PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::kernel::Mcu;
use crate::machine::Machine;
use std::sync::Arc;

/// handle, bus, device, index, sub-index, data type, access
type Descriptor = (i32, i32, i32, i32, i32, i32, i32);
/// first and last number, name, data type, readable, writable, what Index and SubIndex are ("axis", "0 to 5", "3", "-"
/// for no meaning), the Index of a function, and the options that are needed
type Row = (i32, i32, &'static str, i32, bool, bool, String, String, Option<i32>, Vec<&'static str>);

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
        let mut bytes = vec![0; size.min(1 << 28)];
        let found = self.kernel.resources().memory.read(address, &mut bytes) && bytes.len() == size;
        if found { Ok(PyBytes::new(py, &bytes)) } else { Err(outside()) }
    }
    fn write_host(&mut self, address: u64, bytes: &[u8]) -> PyResult<()> {
        if self.kernel.resources_mut().memory.write(address, bytes) { Ok(()) } else { Err(outside()) }
    }
    /// Physical address of memory of the caller, which is kept alive until it is freed.
    fn lend_phys_mem(&mut self, memory: &Bound<'_, PyArray1<u8>>) -> PyResult<u32> {
        if memory.try_readwrite().is_err() || !memory.is_contiguous() {
            return Err(PyValueError::new_err("the memory is read-only or in use elsewhere"));
        }
        let size = memory.len();
        let lent = Box::new(Lent { array: memory.clone().unbind(), size });
        let base = self.kernel.resources_mut().memory.lend(lent);
        base.ok_or_else(|| PyMemoryError::new_err(format!("{size} bytes cannot be lent as host memory")))
    }
    /// An axis gets an ENDAT encoder with position bits, and steps per revolution or a measuring step in nm; 0 bits: none.
    fn fit_endat(&mut self, axis: usize, bits: u32, rotary: bool, steps: u32) -> PyResult<()> {
        self.check(axis)?;
        let encoder = Endat::new(bits, rotary, steps);
        if encoder.is_none() && bits != 0 {
            return Err(PyValueError::new_err(format!("{bits} position bits: an encoder has 1 to 32")));
        }
        self.kernel.resources_mut().axes[axis].endat = encoder;
        Ok(())
    }
    /// Environment variables MT of the axes, for the next boot or rs.
    fn set_endat_environment(&mut self, mt: Vec<u32>) {
        for (axis, mt) in self.kernel.resources_mut().axes.iter_mut().zip(mt) {
            axis.mt = mt;
        }
    }
    /// Version (21, 22), position bits, rotary, steps: how boot or rs set the axis up; None without.
    fn endat_setup(&self, axis: usize) -> PyResult<Option<(u32, u32, bool, u32)>> {
        self.check(axis)?;
        let setup = self.kernel.resources().axes[axis].endat.as_ref().and_then(|encoder| encoder.setup);
        Ok(setup.map(|EndatSetup { version, bits, rotary, steps }| (version, bits, rotary, steps)))
    }
    /// Scans these resources, by name, from the next sample on. What cannot be scanned comes back as its position and
    /// return code.
    fn scan(&mut self, resources: Vec<(String, Descriptor)>) -> Option<(usize, i32)> {
        let resources: Vec<_> = resources.into_iter().map(|(name, d)| (name, descriptor(d))).collect();
        self.kernel.scan(&resources).err().map(|(n, code)| (n, code as i32))
    }
    /// The machine as part programs find it now (resources 16 to 18).
    fn gcode_machine(&self) -> Machine {
        Machine { inner: Arc::new(self.kernel.gcode_machine()) }
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

/// Memory of Python, held by a reference. Every access asks NumPy, so nothing else writes meanwhile.
#[derive(Debug)]
struct Lent {
    array: Py<PyArray1<u8>>,
    size: usize,
}

impl CallerMemory for Lent {
    fn size(&self) -> usize {
        self.size
    }
    fn read(&self, from: usize, bytes: &mut [u8]) -> bool {
        Python::attach(|py| {
            let Ok(array) = self.array.bind(py).try_readonly() else { return false };
            let place = array.as_slice().ok().and_then(|all| all.get(from..from + bytes.len()));
            place.map(|place| bytes.copy_from_slice(place)).is_some()
        })
    }
    fn write(&mut self, from: usize, bytes: &[u8]) -> bool {
        Python::attach(|py| {
            let Ok(mut array) = self.array.bind(py).try_readwrite() else { return false };
            let place = array.as_slice_mut().ok().and_then(|all| all.get_mut(from..from + bytes.len()));
            place.map(|place| place.copy_from_slice(bytes)).is_some()
        })
    }
}

fn outside() -> PyErr {
    PyIndexError::new_err("not inside allocated host memory")
}

/// All devices.
#[pyfunction]
pub fn resource_devices() -> Vec<Row> {
    let row = |d: &Device| {
        let [index, sub_index] = [d.index, d.sub_index].map(|range| match range {
            Range::Any => "-".to_owned(),
            Range::Axis => "axis".to_owned(),
            Range::Below(1) => "0".to_owned(),
            Range::Below(most) => format!("0 to {}", most - 1),
            Range::Only(function) => function.to_string(),
        });
        let function = if let Range::Only(function) = d.index { Some(function) } else { None };
        let needs = d.needs.names().collect();
        (d.first, d.last, d.name, d.kind as i32, d.read.is_some(), d.write.is_some(), index, sub_index, function, needs)
    };
    DEVICES.iter().flat_map(|table| table.iter()).map(row).collect()
}
