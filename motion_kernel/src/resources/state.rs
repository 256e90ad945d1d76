//! What the resource interface itself keeps.

use super::{HostMemory, ObjectDescriptor};
use crate::machine::Machine;
pub use crate::registers::Options;

/// The standard board, without special hardware.
const STANDARD: Options = Options(Options::RESOURCE.0 | Options::PCI.0 | Options::GEAR.0);

/// Zero offsets that device 16 reaches: the five of `azo` and one more.
pub const OFFSETS: usize = 6;

/// Registers of one axis that exist as resources only.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisResources {
    pub ref_offset: [f64; OFFSETS],
    pub mirror: bool,
    pub position_factor: f64,
    /// Electronic gear: where the master was a sample ago, and what the slave has followed so far, axis units.
    pub led: f64,
    pub followed: f64,
    /// The axis as the slave of SyncMode.
    pub sync: super::Sync,
    /// Its ENDAT encoder, and its environment variable MT: 11 for version 2.1, 16 for 2.2.
    pub endat: Option<super::Endat>,
    pub mt: u32,
    /// Base address and factors of Isis and RayDex (310, 320, 321).
    pub isis_base: Option<u32>,
    pub isis_frequency: i32,
    pub isis_norm: f64,
}

/// State of the resource interface.
#[derive(Debug)]
pub struct Resources {
    pub options: Options,
    /// Resources in the order of their handles, the first has handle 1.
    defined: Vec<ObjectDescriptor>,
    pub axes: Vec<AxisResources>,
    /// Analog outputs and inputs of the base board, digits.
    pub aout: [i16; 4],
    pub ain: [i16; 8],
    /// Fast pulse outputs, a bit for each axis.
    pub fast: u16,
    /// Base addresses of host memory.
    pub bases: [Option<u32>; 8],
    pub memory: HostMemory,
    /// The DMA latch.
    pub rts: super::rts::Rts,
    pub(crate) scanner: super::scan::Scanner,
}

impl Resources {
    /// After a boot.
    pub fn of(machine: &Machine) -> Resources {
        let axes = machine.axes.iter().enumerate().map(|(a, axis)| {
            // one store for azo and for G54 to G59: the axis' own zero offsets where it has them
            let work = |set: usize| machine.gcode.offsets[set].get(a).copied().unwrap_or(0.0);
            let own = |set: usize| axis.zero_offsets.get(set).copied().filter(|offset| *offset != 0.0);
            let ref_offset = std::array::from_fn(|set| own(set).unwrap_or_else(|| work(set)));
            let factor = machine.gcode.position_factors.get(a).copied().unwrap_or(1.0);
            let mirror = factor != 1.0;
            let rotary = axis.kind == crate::machine::AxisKind::Rotary;
            AxisResources {
                ref_offset,
                mirror,
                position_factor: if mirror { factor } else { -1.0 },
                led: 0.0,
                followed: 0.0,
                sync: super::Sync::default(),
                endat: None,
                mt: 0,
                isis_base: None,
                isis_frequency: 1,
                isis_norm: if rotary { 4000.0 } else { 20_000.0 },
            }
        });
        Resources {
            options: STANDARD,
            defined: Vec::new(),
            axes: axes.collect(),
            aout: [0; 4],
            ain: [0; 8],
            fast: 0,
            bases: [None; 8],
            memory: HostMemory::default(),
            rts: super::rts::Rts::default(),
            scanner: super::scan::Scanner::default(),
        }
    }
    /// What a boot does not change: the board, its inputs, the memory of the host.
    pub(crate) fn keep_outside(&mut self, before: &mut Resources) {
        (self.options, self.ain) = (before.options, before.ain);
        self.memory = std::mem::take(&mut before.memory);
        for (axis, before) in self.axes.iter_mut().zip(&mut before.axes) {
            (axis.endat, axis.mt) = (before.endat.take(), before.mt);
        }
    }
    /// The descriptor is new, or its handle is that of the same resource.
    pub(super) fn knows(&self, descriptor: &ObjectDescriptor) -> bool {
        let slot = usize::try_from(i64::from(descriptor.handle) - 1);
        descriptor.handle == 0 || slot.ok().and_then(|slot| self.defined.get(slot)) == Some(&descriptor.definition())
    }
    /// Gives a descriptor its handle.
    pub(super) fn define(&mut self, descriptor: &mut ObjectDescriptor) {
        if descriptor.handle != 0 || descriptor.device == 0 {
            return;
        }
        let definition = descriptor.definition();
        let slot = self.defined.iter().position(|d| *d == definition).unwrap_or_else(|| {
            self.defined.push(definition);
            self.defined.len() - 1
        });
        descriptor.handle = slot as i32 + 1;
    }
    /// Deletes all defined resources (device 0).
    pub fn clear(&mut self) {
        self.defined.clear();
    }
    /// Resources that are defined.
    pub fn count(&self) -> usize {
        self.defined.len()
    }
}
