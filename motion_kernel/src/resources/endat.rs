//! ENDAT encoders (chapter 6): a model of the encoder and its transfers. Nothing happens in a sample: a transfer is over
//! a sample after it was asked for, until then it is BUSY.

use super::table::{Device, Place, Range, done};
use super::{Code, Options, Type};
use crate::mcu::Mcu;

/// Values of ENDAT_BUSERR.
const CRC: i32 = 1;
const TIMEOUT: i32 = 2;

/// Environment variables MT for encoders of version 2.1 and 2.2.
const MT_21: u32 = 11;
const MT_22: u32 = 16;
/// Memory areas of the manufacturer, and words in them (ours, after the interface description of the encoders): clock
/// pulses of a position word and type of the encoder; steps, low and high word.
const AREA: u8 = 0xA1;
const BITS: usize = 13;
const KIND: usize = 14;
const ROTARY: u16 = 0x8000;
const STEP_AREA: u8 = 0xA3;
const STEPS: usize = 4;
const WORDS: usize = 256;

/// How an axis was set up from the data of its encoder (6.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EndatSetup {
    /// 21 or 22.
    pub version: u32,
    /// Bits of the position word.
    pub bits: u32,
    pub rotary: bool,
    /// Measuring steps per revolution; of a linear encoder the measuring step, nm.
    pub steps: u32,
}

/// The encoder of an axis and what the controller knows of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Endat {
    /// What the controller has read of it at boot or rs; without, it does not know the encoder.
    pub setup: Option<EndatSetup>,
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
    /// An encoder with that many position bits (1 to 32), and steps per revolution, or a measuring step in nm.
    pub fn new(bits: u32, rotary: bool, steps: u32) -> Option<Endat> {
        let area = |words: &[(usize, u16)]| {
            let mut area = vec![0; WORDS];
            words.iter().for_each(|&(address, word)| area[address] = word);
            area
        };
        let manufacturer = area(&[(BITS, bits as u16), (KIND, if rotary { ROTARY } else { 0 })]);
        let step = area(&[(STEPS, steps as u16), (STEPS + 1, (steps >> 16) as u16)]);
        (1..=32).contains(&bits).then(|| Endat {
            setup: None,
            alarm: false,
            crc_to_come: 0,
            timeouts_to_come: 0,
            memory: vec![(AREA, manufacturer), (STEP_AREA, step)],
            area: None,
            resets: 0,
            alarm_read: false,
            crc_errors: 0,
            timeout_errors: 0,
            bus_error: 0,
            transfer: None,
        })
    }
    /// The memory area chosen last.
    fn words(&mut self) -> Result<&mut [u16], Code> {
        let area = self.area.ok_or(Code::State)?;
        self.memory.iter_mut().find(|(code, _)| *code == area).map(|(_, words)| &mut words[..]).ok_or(Code::State)
    }
    fn choose(&mut self, area: u8) {
        if !self.memory.iter().any(|(code, _)| *code == area) {
            self.memory.push((area, vec![0; WORDS]));
        }
        self.area = Some(area);
    }
    fn word(&self, area: u8, address: usize) -> u16 {
        self.memory.iter().find(|(code, _)| *code == area).map_or(0, |(_, words)| words[address])
    }
    /// Boot or rs: the controller reads the encoder that its environment variable MT lets it expect.
    fn set_up(&mut self, mt: u32) {
        let version = match mt {
            MT_21 => 21,
            MT_22 => 22,
            _ => 0,
        };
        (self.area, self.transfer, self.alarm_read) = (None, None, false);
        (self.crc_errors, self.timeout_errors, self.bus_error) = (0, 0, 0);
        let bits = u32::from(self.word(AREA, BITS));
        let answers = version != 0 && !self.fails() && (1..=32).contains(&bits);
        self.setup = answers.then(|| EndatSetup {
            version,
            bits,
            rotary: self.word(AREA, KIND) & ROTARY != 0,
            steps: u32::from(self.word(STEP_AREA, STEPS)) | u32::from(self.word(STEP_AREA, STEPS + 1)) << 16,
        });
    }
    /// Whether this transfer fails, and how: that is counted.
    fn fails(&mut self) -> bool {
        if self.timeouts_to_come > 0 {
            self.timeouts_to_come -= 1;
            (self.timeout_errors, self.bus_error) = (self.timeout_errors + 1, TIMEOUT);
        } else if self.crc_to_come > 0 {
            self.crc_to_come -= 1;
            (self.crc_errors, self.bus_error) = (self.crc_errors + 1, CRC);
        } else {
            return false;
        }
        true
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
        let bits = encoder.setup.map_or(1, |setup| setup.bits);
        let word = counts as u64 & (u64::MAX >> (64 - bits));
        Ok(f64::from(word as u32 as i32))
    }),
    order(3001, "ENDAT_SMA", |m, p, v| {
        done((0.0..256.0).contains(&v))?;
        transferred(m, p, v as i32)?;
        encoder(m, p)?.choose(v as u8);
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

/// The axis was set up for its ENDAT encoder, or the resource is unknown.
fn encoder(mcu: &mut Mcu, place: Place) -> Result<&mut Endat, Code> {
    mcu.resources.axes[place.index].endat.as_mut().filter(|encoder| encoder.setup.is_some()).ok_or(Code::Unknown)
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
    if !encoder.fails() {
        return Ok(());
    }
    mcu.bus_error();
    Err(Code::State)
}

impl Mcu {
    /// Boot and rs: axes with an ENDAT encoder are set up from its data (6.2), if option ENDAT is there.
    pub(crate) fn set_up_endat(&mut self) {
        let has = self.resources.options.has(Options::ENDAT);
        let mut failed = false;
        for axis in &mut self.resources.axes {
            if let Some(encoder) = &mut axis.endat {
                encoder.set_up(if has { axis.mt } else { 0 });
                failed |= encoder.bus_error != 0;
            }
        }
        if failed {
            self.bus_error();
        }
    }
    /// Some encoder has a transmission error that nobody has cleared (event EVENDAT).
    pub(crate) fn has_endat_error(&self) -> bool {
        self.resources.axes.iter().any(|axis| axis.endat.as_ref().is_some_and(|encoder| encoder.bus_error != 0))
    }
}
