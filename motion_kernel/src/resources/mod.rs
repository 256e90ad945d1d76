//! The resource interface: internal quantities by device number (manual "Ressourcen-Interface").
//!
//! An [`ObjectDescriptor`] names a quantity and a direction; the first access defines the resource and gives the
//! descriptor its handle. What a device number means stands in tables once (`table.rs` and the rooms of the functions);
//! nothing of it costs a sample anything.
#![allow(non_snake_case)] // the manual's own names

mod endat;
mod gear;
mod memory;
mod memory_devices;
mod rts;
mod scan;
mod state;
mod sync;
mod table;

pub use endat::{Endat, EndatSetup};
pub use memory::{CallerMemory, HostMemory};
pub use rts::{Block, OVERFLOW};
pub use scan::{Layout, Scan};
pub use state::{AxisResources, Options, Resources};
pub use sync::Sync;
pub use table::{DEVICES, Device, Place, Range};

use crate::machine::Machine;
use crate::mcu::Mcu;

/// BusNumber of every resource.
pub const BUS: i32 = 1000;

/// Return codes (6.4, 7.4.3, errata Q28).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// No such resource for this operating system, data type and direction, or a handle that is none.
    Unknown = 1,
    /// Not yet: to be repeated.
    Busy = 2,
    Ok = 4,
    /// This hardware cannot do it.
    Hardware = 8,
    /// STATE_ERR: not in this state, or an index or value out of range. Nothing has changed.
    State = 0x80,
}

/// Data types of descriptors. Only the number of ATDataBlock is in the manual, the others are ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    Byte = 1,
    Word = 2,
    Integer = 3,
    Float = 4,
    Double = 5,
    DataBlock = 6,
    Short = 7,
}

impl Type {
    pub const ALL: [Type; 7] =
        [Type::Byte, Type::Word, Type::Integer, Type::Float, Type::Double, Type::DataBlock, Type::Short];
}

/// Directions of descriptors (ATAccessInput, ATAccessOutput; 3 = both is wrong for resources).
pub const READ: i32 = 1;
pub const WRITE: i32 = 2;

/// The object descriptor of the universal object interface (2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectDescriptor {
    /// 0 before the first access and after a boot or clear; then kept by the system.
    pub handle: i32,
    pub bus: i32,
    pub device: i32,
    pub index: i32,
    pub sub_index: i32,
    /// Number of a [`Type`].
    pub data_type: i32,
    /// [`READ`] or [`WRITE`].
    pub access: i32,
}

impl ObjectDescriptor {
    /// A descriptor that was not used yet.
    pub fn new(device: i32, index: i32, sub_index: i32, data_type: Type, access: i32) -> Self {
        ObjectDescriptor { handle: 0, bus: BUS, device, index, sub_index, data_type: data_type as i32, access }
    }
    /// The same without its handle: what the system keeps of a resource.
    fn definition(&self) -> ObjectDescriptor {
        ObjectDescriptor { handle: 0, ..*self }
    }
}

impl Mcu {
    /// Reads an integer, a float (the 32 bits of an IEEE single) or the state of a data block.
    pub fn rdOptionInt(&mut self, descriptor: &mut ObjectDescriptor) -> Result<i32, Code> {
        let value = self.read_option(descriptor, false)?;
        let float = descriptor.data_type == Type::Float as i32;
        Ok(if float { (value as f32).to_bits() as i32 } else { value as i32 })
    }
    /// Reads a double.
    pub fn rdOptionDbl(&mut self, descriptor: &mut ObjectDescriptor) -> Result<f64, Code> {
        self.read_option(descriptor, true)
    }
    /// Writes an integer or the 32 bits of a float; [`Code::Ok`] or what is wrong.
    pub fn wrOptionInt(&mut self, descriptor: &mut ObjectDescriptor, value: i32) -> Code {
        let float = descriptor.data_type == Type::Float as i32;
        let value = if float { f64::from(f32::from_bits(value as u32)) } else { f64::from(value) };
        self.write_option(descriptor, false, value)
    }
    /// Writes a double.
    pub fn wrOptionDbl(&mut self, descriptor: &mut ObjectDescriptor, value: f64) -> Code {
        self.write_option(descriptor, true, value)
    }

    fn read_option(&mut self, descriptor: &mut ObjectDescriptor, double: bool) -> Result<f64, Code> {
        let (device, place) = self.resolve(descriptor, READ, double)?;
        let read = device.read.ok_or(Code::Unknown)?;
        let answer = read(self, place);
        if matches!(answer, Ok(_) | Err(Code::Busy)) {
            self.resources.define(descriptor);
        }
        answer
    }
    fn write_option(&mut self, descriptor: &mut ObjectDescriptor, double: bool, value: f64) -> Code {
        let (device, place) = match self.resolve(descriptor, WRITE, double) {
            Ok(found) => found,
            Err(code) => return code,
        };
        let Some(write) = device.write else { return Code::Unknown };
        let code = write(self, place, value).err().unwrap_or(Code::Ok);
        if matches!(code, Code::Ok | Code::Busy) {
            self.resources.define(descriptor);
        }
        code
    }

    /// The device that a descriptor means, if it may be used so.
    fn resolve(&self, d: &ObjectDescriptor, access: i32, double: bool) -> Result<(&'static Device, Place), Code> {
        let resources = &self.resources;
        let known = |device: &&Device| resources.options.has(device.needs);
        let device = table::device(d.device, d.index).filter(known).ok_or(Code::Unknown)?;
        let kind = device.kind;
        let fits = d.data_type == kind as i32 && double == (kind == Type::Double);
        if d.bus != BUS || d.access != access || !fits || !resources.knows(d) {
            return Err(Code::Unknown);
        }
        if (access == READ && device.read.is_none()) || (access == WRITE && device.write.is_none()) {
            return Err(Code::Unknown);
        }
        let axes = self.axes.len();
        if !device.index.holds(d.index, axes) || !device.sub_index.holds(d.sub_index, axes) {
            return Err(Code::State);
        }
        let place = Place { device: d.device, index: d.index as u32 as usize, sub: d.sub_index as u32 as usize };
        Ok((device, place))
    }

    /// The machine as part programs find it now: G54 to G59 are RefOffset 0 to 5, mirrored axes go by PositionFactor
    /// (resources 16 to 18).
    pub fn gcode_machine(&self) -> Machine {
        let mut machine = (*self.machine).clone();
        let axes = &self.resources.axes;
        machine.gcode.offsets = std::array::from_fn(|set| axes.iter().map(|axis| axis.ref_offset[set]).collect());
        machine.gcode.position_factors =
            axes.iter().map(|axis| if axis.mirror { axis.position_factor } else { 1.0 }).collect();
        machine
    }

    /// The state of the resource interface.
    pub fn resources(&self) -> &Resources {
        &self.resources
    }
    /// The same, to fit options and to play the world outside.
    pub fn resources_mut(&mut self) -> &mut Resources {
        &mut self.resources
    }
}
