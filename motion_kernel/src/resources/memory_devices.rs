//! Devices 300 to 321: host memory in several widths, for the board (sets of addresses) and for Isis axes.

use super::table::{Device, Place, Range, done};
use super::{Code, Options, Type};
use crate::mcu::Mcu;

/// First device of the Isis axes.
const ISIS: i32 = 310;

const fn memory(number: i32, name: &'static str, kind: Type) -> Device {
    let device = Device::read_only(number, name, kind, Range::Any, read).writing(write);
    for_owner(device, number)
}
/// The set of addresses, or the axis, is the SubIndex.
const fn for_owner(device: Device, number: i32) -> Device {
    if number < ISIS {
        device.with_sub(Range::Below(8)).with(Options::PCI)
    } else {
        device.with_sub(Range::Axis).with(Options::ISIS)
    }
}
const fn base(number: i32, name: &'static str) -> Device {
    let read = |m: &mut Mcu, p: Place| Ok(f64::from(slot(m, p).unwrap_or(0) as i32));
    let device = Device::read_only(number, name, Type::Integer, Range::Any, read);
    for_owner(
        device.writing(|m, p, v| {
            *slot(m, p) = Some(v as i32 as u32);
            Ok(())
        }),
        number,
    )
}

pub(super) const DEVICES: &[Device] = &[
    base(300, "HostMem PhysAdr"),
    memory(301, "HostMem Byte", Type::Byte),
    memory(302, "HostMem Word", Type::Word),
    memory(304, "HostMem Int", Type::Integer),
    memory(305, "HostMem Float", Type::Float),
    memory(308, "HostMem Double", Type::Double),
    base(310, "IsisAxis PhysAdr"),
    memory(311, "IsisHost MemByte", Type::Byte),
    memory(312, "IsisHost MemWord", Type::Word),
    memory(314, "IsisHost MemInt", Type::Integer),
    memory(315, "IsisHost MemFloat", Type::Float),
    memory(318, "IsisHost MemDouble", Type::Double),
    for_owner(
        Device::read_only(320, "IsisSensor Frequency Factor", Type::Integer, Range::Any, |m, p| {
            Ok(f64::from(m.resources.axes[p.sub].isis_frequency))
        })
        .writing(|m, p, v| done(v >= 1.0).map(|()| m.resources.axes[p.sub].isis_frequency = v as i32)),
        320,
    ),
    for_owner(
        Device::read_only(321, "IsisPos Norm Factor", Type::Double, Range::Any, |m, p| {
            Ok(m.resources.axes[p.sub].isis_norm)
        })
        .writing(|m, p, v| done(crate::named::put(&mut m.resources.axes[p.sub].isis_norm, v, |v| v != 0.0))),
        321,
    ),
];

fn slot(mcu: &mut Mcu, place: Place) -> &mut Option<u32> {
    if place.device < ISIS { &mut mcu.resources.bases[place.sub] } else { &mut mcu.resources.axes[place.sub].isis_base }
}

/// Address of an access.
fn address(mcu: &mut Mcu, place: Place) -> Result<u64, Code> {
    Ok(u64::from((*slot(mcu, place)).ok_or(Code::State)?) + place.index as u64)
}
/// The bytes at an address; one that no block of host memory holds is refused.
fn bytes<const N: usize>(mcu: &mut Mcu, place: Place) -> Result<[u8; N], Code> {
    let (address, mut bytes) = (address(mcu, place)?, [0; N]);
    done(mcu.resources.memory.read(address, &mut bytes)).map(|()| bytes)
}

fn read(mcu: &mut Mcu, place: Place) -> Result<f64, Code> {
    Ok(match place.device % 10 {
        1 => f64::from(bytes::<1>(mcu, place)?[0]),
        2 => f64::from(u16::from_le_bytes(bytes(mcu, place)?)),
        4 => f64::from(i32::from_le_bytes(bytes(mcu, place)?)),
        5 => f64::from(f32::from_le_bytes(bytes(mcu, place)?)),
        _ => f64::from_le_bytes(bytes(mcu, place)?),
    })
}

fn write(mcu: &mut Mcu, place: Place, value: f64) -> Result<(), Code> {
    let address = address(mcu, place)?;
    let memory = &mut mcu.resources.memory;
    done(match place.device % 10 {
        1 => memory.write(address, &[value as i32 as u8]),
        2 => memory.write(address, &(value as i32 as u16).to_le_bytes()),
        4 => memory.write(address, &(value as i32).to_le_bytes()),
        5 => memory.write(address, &(value as f32).to_le_bytes()),
        _ => memory.write(address, &value.to_le_bytes()),
    })
}
