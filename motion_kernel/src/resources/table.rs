//! Table 2: what the device numbers mean.

use super::{Code, Options, Type};
use crate::axis::Axis;
use crate::mcu::{COMMONS, Mcu, TASKS};
use crate::registers::Digi;

/// What a descriptor refers to, in range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    pub device: i32,
    pub index: usize,
    pub sub: usize,
}

/// What Index or SubIndex may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Has no meaning, or one that the device judges itself.
    Any,
    Axis,
    /// 0 to the number before this.
    Below(usize),
    /// One function of several of the same device number.
    Only(i32),
}

impl Range {
    pub fn holds(self, value: i32, axes: usize) -> bool {
        let below = |most: usize| usize::try_from(value).is_ok_and(|value| value < most);
        match self {
            Range::Any => true,
            Range::Axis => below(axes),
            Range::Below(most) => below(most),
            Range::Only(function) => value == function,
        }
    }
}

pub type Read = fn(&mut Mcu, Place) -> Result<f64, Code>;
pub type Write = fn(&mut Mcu, Place, f64) -> Result<(), Code>;

/// A device number, or several in a row that are alike.
pub struct Device {
    pub first: i32,
    pub last: i32,
    pub name: &'static str,
    pub kind: Type,
    pub index: Range,
    pub sub_index: Range,
    pub read: Option<Read>,
    pub write: Option<Write>,
    pub needs: Options,
}

impl Device {
    pub(super) const fn read_only(number: i32, name: &'static str, kind: Type, index: Range, read: Read) -> Device {
        let (read, write, needs) = (Some(read), None, Options::RESOURCE);
        Device { first: number, last: number, name, kind, index, sub_index: Range::Below(1), read, write, needs }
    }
    pub(super) const fn writing(self, write: Write) -> Device {
        Device { write: Some(write), ..self }
    }
    pub(super) const fn write_only(self) -> Device {
        Device { read: None, ..self }
    }
    pub(super) const fn with_sub(self, sub_index: Range) -> Device {
        Device { sub_index, ..self }
    }
    pub(super) const fn up_to(self, last: i32) -> Device {
        Device { last, ..self }
    }
    pub(super) const fn with(self, option: Options) -> Device {
        Device { needs: Options(self.needs.0 | option.0), ..self }
    }
}

/// A value that was not allowed changes nothing.
pub(super) fn done(ok: bool) -> Result<(), Code> {
    if ok { Ok(()) } else { Err(Code::State) }
}

/// A register of 32 bits as the integer that the interface hands over.
fn word(bits: u32) -> Result<f64, Code> {
    Ok(f64::from(bits as i32))
}

const fn double(number: i32, name: &'static str, read: Read) -> Device {
    Device::read_only(number, name, Type::Double, Range::Axis, read)
}
const fn integer(number: i32, name: &'static str, index: Range, read: Read) -> Device {
    Device::read_only(number, name, Type::Integer, index, read)
}
/// A write-only integer.
const fn order(number: i32, name: &'static str, index: Range, write: Write) -> Device {
    integer(number, name, index, |_, _| Err(Code::Unknown)).writing(write).write_only()
}

/// The tables of all rooms.
pub static DEVICES: &[&[Device]] = &[
    MOTION,
    AXIS,
    CARD,
    super::memory_devices::DEVICES,
    super::sync::DEVICES,
    super::endat::DEVICES,
    super::rts::DEVICES,
];

/// Devices that go to the memory of the host.
pub(super) fn is_host_memory(number: i32) -> bool {
    super::memory_devices::DEVICES.iter().any(|d| d.first == number && d.index == Range::Any)
}

/// The device, or of several functions the one that Index chooses.
pub(super) fn device(number: i32, index: i32) -> Option<&'static Device> {
    let is_it = |d: &&Device| {
        let other = matches!(d.index, Range::Only(function) if function != index);
        (d.first..=d.last).contains(&number) && !other
    };
    DEVICES.iter().flat_map(|table| table.iter()).find(is_it)
}

/// Motion: positions, velocities, the command being executed.
const MOTION: &[Device] = &[
    double(1, "dp", |m, p| Ok(m.rddp(p.index))),
    double(2, "rp", |m, p| Ok(m.rdrp(p.index))),
    integer(3, "axst", Range::Axis, |m, p| word(m.rdaxst(p.index).0)),
    integer(5, "scntr", Range::Below(1), |m, _| word(m.samples() as u32)),
    double(7, "poserr", |m, p| Ok(m.rdPosErr(p.index))),
    double(8, "trvl", |m, p| {
        let axis = &m.axes[p.index];
        Ok(axis.plan_v * axis.trajectory.factor / m.velocity_unit(p.index))
    }),
    double(9, "dv", |m, p| Ok(m.rddv(p.index))),
    double(10, "rv", |m, p| Ok(m.rdrv(p.index))),
    double(11, "aux", |m, p| Ok(m.rdaux(p.index))),
    double(14, "lp", |m, p| Ok(m.latched(p.index))),
    double(15, "lpndx", |m, p| Ok(m.rdlpndx(p.index))),
    Device::read_only(20, "DTV[0]", Type::Double, Range::Any, |m, _| Ok(m.trajectory_velocities()[0])),
    Device::read_only(21, "DTV[1]", Type::Double, Range::Any, |m, _| Ok(m.trajectory_velocities()[1])),
    // its contents are nowhere described
    integer(22, "PIR", Range::Any, |_, _| Ok(0.0)),
    double(23, "PTP", |m, p| Ok(m.rdtp(p.index))),
    double(31, "PosErrAux", |m, p| Ok(m.loops[p.index].error_aux(m.rddp(p.index)))),
    integer(32, "PcapIndex", Range::Axis, |m, p| word(m.rdPcapIndex(p.index) as u32)),
    double(33, "PosKorrRotAxis", |m, p| {
        let rotary = m.axes[p.index].parameters.rotary;
        Ok(if rotary { (m.rdrp(p.index) / 360.0).floor() } else { 0.0 })
    }),
    double(36, "ZP Offset", |m, p| Ok(m.zero_offset(p.index))),
    double(37, "DpOffset", |m, p| Ok(m.rddpoffset(p.index))),
    // the board has no compensation tables (ELCAM)
    double(73, "Compensation Position", |_, _| Ok(0.0)),
];

/// Settings of an axis.
const AXIS: &[Device] = &[
    double(16, "RefOffset", |m, p| Ok(m.resources.axes[p.index].ref_offset[p.sub]))
        .writing(|m, p, v| done(put(&mut m.resources.axes[p.index].ref_offset[p.sub], v)))
        .with_sub(Range::Below(super::state::OFFSETS)),
    integer(17, "Mirror", Range::Axis, |m, p| Ok(f64::from(u8::from(m.resources.axes[p.index].mirror))))
        .writing(|m, p, v| switch(&mut m.resources.axes[p.index].mirror, v)),
    double(18, "Position Factor", |m, p| Ok(m.resources.axes[p.index].position_factor))
        .writing(|m, p, v| done(v != 0.0 && put(&mut m.resources.axes[p.index].position_factor, v))),
    integer(26, "mcp", Range::Axis, |m, p| Ok(f64::from(m.rdmcp(p.index)))),
    double(27, "Backlash", |m, p| Ok(m.rdbacklash(p.index))).writing(|m, p, v| done(m.wrbacklash(p.index, v))),
    digits(28, "MCP_MAX", |m, p| Ok(shown(m.port(p.index).max))).writing(|m, p, v| limit(m, p, taken(v), true)),
    digits(29, "MCP_MIN", |m, p| Ok(shown(m.port(p.index).min))).writing(|m, p, v| limit(m, p, taken(v), false)),
    double(30, "Actual Backlash Value", |m, p| Ok(m.rdactual_backlash(p.index))),
    double(38, "mcpmax", |m, p| Ok(volts(m.port(p.index).max))).writing(|m, p, v| limit(m, p, of_volts(v), true)),
    double(39, "mcpmin", |m, p| Ok(volts(m.port(p.index).min))).writing(|m, p, v| limit(m, p, of_volts(v), false)),
    double(40, "backlash", |m, p| Ok(m.rdbacklash_hysteresis(p.index)))
        .writing(|m, p, v| done(m.wrbacklash_hysteresis(p.index, v))),
    double(41, "mcpcp", |m, p| Ok(volts(m.port(p.index).positive))).writing(|m, p, v| {
        let port = crate::machine::Port { positive: of_volts(v), ..m.port(p.index) };
        done(m.set_port(p.index, &port))
    }),
    double(42, "mcpcn", |m, p| Ok(volts(m.port(p.index).negative))).writing(|m, p, v| {
        let port = crate::machine::Port { negative: of_volts(v), ..m.port(p.index) };
        done(m.set_port(p.index, &port))
    }),
    integer(105, "EVLSS", Range::Axis, |m, p| Ok(f64::from(u8::from(m.axes[p.index].watches_limits())))).writing(
        |m, p, v| {
            let Axis { evlss, .. } = &mut m.axes[p.index];
            let mut on = false;
            switch(&mut on, v).map(|()| *evlss = Some(on))
        },
    ),
    double(200, "cp", |m, p| Ok(m.card.axes[p.index].parameters[cell(p)]))
        .writing(|m, p, v| {
            let ok = v.is_finite();
            if ok {
                m.set_controller_parameter(p.index, cell(p), v);
            }
            done(ok)
        })
        .with_sub(Range::Below(15))
        .up_to(214),
    double(406, "MCP OFFSET", |m, p| Ok(m.loops[p.index].special.mcp_offset)).writing(|m, p, v| {
        let ok = v.is_finite() && v.abs() <= crate::controller::FULL_SCALE;
        done(ok).map(|()| m.loops[p.index].set_special(|special| special.mcp_offset = v))
    }),
];

/// The card: inputs and outputs, common variables, tasks.
const CARD: &[Device] = &[
    order(0, "clear", Range::Any, |m, _, v| done(v == 1.0 && !m.attention.scanning).map(|()| m.resources.clear())),
    integer(4, "digi", Range::Axis, |m, p| word(m.rddigi(p.index))),
    integer(6, "digo", Range::Axis, |m, _| word(m.rddigo())),
    integer(12, "CI", Range::Below(COMMONS), |m, p| Ok(f64::from(m.ci(p.index)))).writing(|m, p, v| {
        m.set_ci(p.index, v as i32);
        Ok(())
    }),
    Device::read_only(13, "CD", Type::Double, Range::Below(COMMONS), |m, p| Ok(m.cd(p.index))).writing(|m, p, v| {
        m.set_cd(p.index, v);
        Ok(())
    }),
    integer(19, "LookAheadDepth", Range::Any, |m, _| word(m.registers.lookahead_depth))
        .writing(|m, _, v| done(v >= 0.0).map(|()| m.registers.lookahead_depth = v as u32)),
    integer(24, "TaskLineNr", Range::Below(TASKS), |m, p| word(m.task_status(p.index).csrcline)),
    integer(62, "EpmRev SdiCh0", Range::Any, |_, _| Ok(1.0)),
    // no option board
    integer(63, "EpmRev SdiCh1", Range::Any, |_, _| Ok(0.0)),
    Device::read_only(64, "FAST PULSE OUT", Type::Word, Range::Any, |m, _| Ok(f64::from(m.resources.fast)))
        .writing(|m, _, v| {
            m.resources.fast = (v as i32) as u16;
            Ok(())
        })
        .with(Options::FAST_PULSE),
    integer(70, "TASK STATUS", Range::Below(TASKS), |m, p| word(m.gettskinfo(p.index))),
    integer(79, "INV_DIGI", Range::Axis, |m, _| word(m.io.inverted())),
    order(83, "AOUT03", Range::Below(1), |m, _, v| analog(&mut m.resources.aout[3], v)),
    order(87, "AOUT", Range::Below(4), |m, p, v| analog(&mut m.resources.aout[p.index], v)),
    integer(100, "ain_CH", Range::Below(8), |m, p| Ok(f64::from(m.resources.ain[p.index]))),
    integer(101, "WTLSTRB", Range::Below(8), |m, p| {
        let signals = m.signals.get_mut(p.index).ok_or(Code::State)?;
        if !signals.digi.has(Digi::strobe) {
            return Err(Code::Busy);
        }
        signals.digi.clear(Digi::strobe);
        Ok(1.0)
    }),
];

const fn digits(number: i32, name: &'static str, read: Read) -> Device {
    Device::read_only(number, name, Type::Float, Range::Axis, read)
}
/// The field of `scp` stands row by row; a device is a column of it.
fn cell(place: Place) -> usize {
    place.sub * 15 + (place.device - 200) as usize
}
fn put(slot: &mut f64, value: f64) -> bool {
    crate::named::put(slot, value, |_| true)
}
fn switch(slot: &mut bool, value: f64) -> Result<(), Code> {
    done(value == 0.0 || value == 1.0).map(|()| *slot = value == 1.0)
}
fn analog(slot: &mut i16, value: f64) -> Result<(), Code> {
    let ok = (f64::from(i16::MIN)..=f64::from(i16::MAX)).contains(&value);
    done(ok).map(|()| *slot = value as i16)
}

/// 10 V are 32768 digits; the converter ends one before.
const TEN_VOLTS: f64 = 32_768.0;
fn shown(digits: f64) -> f64 {
    if digits.abs() == crate::controller::FULL_SCALE { TEN_VOLTS.copysign(digits) } else { digits }
}
fn taken(digits: f64) -> f64 {
    let most = crate::controller::FULL_SCALE;
    if digits.abs() <= TEN_VOLTS { digits.clamp(-most, most) } else { digits }
}
fn volts(digits: f64) -> f64 {
    shown(digits) * 10.0 / TEN_VOLTS
}
fn of_volts(volts: f64) -> f64 {
    taken(volts * TEN_VOLTS / 10.0)
}
fn limit(mcu: &mut Mcu, place: Place, digits: f64, upper: bool) -> Result<(), Code> {
    let mut port = mcu.port(place.index);
    *(if upper { &mut port.max } else { &mut port.min }) = digits;
    done(mcu.set_port(place.index, &port))
}

impl Mcu {
    /// Path velocity of the command that is executed first, in PU and TU: as programmed, and as the axes allow it.
    fn trajectory_velocities(&self) -> [f64; 2] {
        let executes = (0..self.axes.len()).find_map(|a| self.current_move(a).map(|mv| (a, mv)));
        executes.map_or([0.0; 2], |(a, mv)| {
            let unit = self.velocity_unit(a);
            [mv.programmed_v / unit, mv.vl.min(mv.programmed_v) / unit]
        })
    }
}
