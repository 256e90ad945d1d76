//! ENDAT encoders (chapter 6): a model of the encoder and its transfers. Nothing happens in a sample: a transfer is over
//! a sample after it was asked for, until then it is BUSY.

use super::table::{Device, Place, Range, done};
use super::{Code, Options, Type};
use crate::mcu::Mcu;

/// Values of ENDAT_BUSERR.
const CRC: i32 = 1;
const TIMEOUT: i32 = 2;

/// The encoder of an axis and what the controller knows of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Endat {
    /// Bits of the position word.
    pub bits: u32,
    /// The encoder signals an alarm.
    pub alarm: bool,
    /// Transfers to come that fail, by CRC error and by silence.
    pub crc_to_come: u32,
    pub timeouts_to_come: u32,
    /// 256 words of each memory area (MRS code) that was selected.
    memory: Vec<(u8, Vec<u16>)>,
    area: Option<u8>,
    /// Resets received.
    pub resets: u32,
    alarm_read: bool,
    crc_errors: i32,
    timeout_errors: i32,
    bus_error: i32,
    /// What is being transferred, and the sample in which it is over.
    transfer: Option<(Place, i32, u64)>,
}

impl Endat {
    /// An encoder with that many position bits (1 to 32).
    pub fn new(bits: u32) -> Option<Endat> {
        (1..=32).contains(&bits).then(|| Endat {
            bits,
            alarm: false,
            crc_to_come: 0,
            timeouts_to_come: 0,
            memory: Vec::new(),
            area: None,
            resets: 0,
            alarm_read: false,
            crc_errors: 0,
            timeout_errors: 0,
            bus_error: 0,
            transfer: None,
        })
    }
    fn words(&mut self) -> Result<&mut [u16], Code> {
        let area = self.area.ok_or(Code::State)?;
        let known = self.memory.iter().position(|(code, _)| *code == area);
        let place = known.unwrap_or_else(|| {
            self.memory.push((area, vec![0; 256]));
            self.memory.len() - 1
        });
        Ok(&mut self.memory[place].1)
    }
}

const fn function(number: i32, name: &'static str, read: super::table::Read) -> Device {
    Device::read_only(number, name, Type::Integer, Range::Axis, read).with(Options::ENDAT)
}
const fn order(number: i32, name: &'static str, write: super::table::Write) -> Device {
    function(number, name, |_, _| Err(Code::Unknown)).writing(write).write_only()
}
/// A counter or register that writing 0 clears.
const fn errors(number: i32, name: &'static str, read: super::table::Read, write: super::table::Write) -> Device {
    function(number, name, read).writing(write)
}

pub(super) const DEVICES: &[Device] = &[
    function(3000, "ENDAT_TPV", |m, p| {
        transferred(m, p, 0)?;
        let counts = m.loops[p.index].machine_counts();
        let encoder = encoder(m, p)?;
        encoder.alarm_read = encoder.alarm;
        let word = counts as u64 & (u64::MAX >> (64 - encoder.bits));
        Ok(f64::from(word as u32 as i32))
    }),
    order(3001, "ENDAT_SMA", |m, p, v| {
        done((0.0..256.0).contains(&v))?;
        transferred(m, p, v as i32)?;
        encoder(m, p)?.area = Some(v as u8);
        Ok(())
    }),
    function(3002, "ENDAT_TP", |m, p| {
        encoder(m, p)?.words()?;
        transferred(m, p, 0)?;
        Ok(f64::from(encoder(m, p)?.words()?[p.sub]))
    })
    .with_sub(Range::Below(256)),
    order(3003, "ENDAT_RP", |m, p, v| {
        done((0.0..65536.0).contains(&v))?;
        encoder(m, p)?.words()?;
        transferred(m, p, v as i32)?;
        encoder(m, p)?.words()?[p.sub] = v as u16;
        Ok(())
    })
    .with_sub(Range::Below(256)),
    order(3004, "ENDAT_RR", |m, p, v| {
        done(!m.loops[p.index].closed)?;
        transferred(m, p, v as i32)?;
        let encoder = encoder(m, p)?;
        encoder.resets += 1;
        (encoder.alarm, encoder.area) = (false, None);
        Ok(())
    }),
    function(3010, "ENDAT_RA", |m, p| Ok(f64::from(u8::from(encoder(m, p)?.alarm_read)))),
    errors(
        3011,
        "ENDAT_CRCERRS",
        |m, p| Ok(f64::from(encoder(m, p)?.crc_errors)),
        |m, p, v| cleared(&mut encoder(m, p)?.crc_errors, v),
    ),
    errors(
        3012,
        "ENDAT_TOERRS",
        |m, p| Ok(f64::from(encoder(m, p)?.timeout_errors)),
        |m, p, v| cleared(&mut encoder(m, p)?.timeout_errors, v),
    ),
    errors(
        3013,
        "ENDAT_BUSERR",
        |m, p| Ok(f64::from(encoder(m, p)?.bus_error)),
        |m, p, v| cleared(&mut encoder(m, p)?.bus_error, v),
    ),
];

/// The axis has an ENDAT encoder, or the resource is unknown.
fn encoder(mcu: &mut Mcu, place: Place) -> Result<&mut Endat, Code> {
    mcu.resources.axes[place.index].endat.as_mut().ok_or(Code::Unknown)
}
fn cleared(register: &mut i32, value: f64) -> Result<(), Code> {
    done(value == 0.0).map(|()| *register = 0)
}

/// Begins a transfer, or ends one that is over: BUSY until then, STATE_ERR if it failed.
fn transferred(mcu: &mut Mcu, place: Place, value: i32) -> Result<(), Code> {
    let now = mcu.sample;
    let encoder = encoder(mcu, place)?;
    match encoder.transfer {
        Some((asked, with, over)) if now >= over => {
            encoder.transfer = None;
            if (asked, with) != (place, value) {
                encoder.transfer = Some((place, value, now + 1)); // nobody asked for the answer of the one before
                return Err(Code::Busy);
            }
        }
        Some(_) => return Err(Code::Busy),
        None => {
            encoder.transfer = Some((place, value, now + 1));
            return Err(Code::Busy);
        }
    }
    if encoder.timeouts_to_come > 0 {
        encoder.timeouts_to_come -= 1;
        (encoder.timeout_errors, encoder.bus_error) = (encoder.timeout_errors + 1, TIMEOUT);
    } else if encoder.crc_to_come > 0 {
        encoder.crc_to_come -= 1;
        (encoder.crc_errors, encoder.bus_error) = (encoder.crc_errors + 1, CRC);
    } else {
        return Ok(());
    }
    mcu.bus_error();
    Err(Code::State)
}
