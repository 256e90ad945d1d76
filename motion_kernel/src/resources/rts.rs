//! DMA-RTS (chapter 7): every strobe of the first axis records the latched positions, many times a sample.
//!
//! Rows wait in the memory of the DMA channel until the scanner takes them at the end of a sample, as a data block of
//! fixed size. What finds no place there, or comes faster than the channel carries, is lost and told by the status.

use super::table::{Device, Place, Range, done};
use super::{Code, Options, Type};
use crate::machine::DriveKind;
use crate::mcu::Mcu;

/// Counters that a strobe latches, and analog channels.
const AXES: usize = 8;
/// Most rows of a block (7.4.2), and rows that wait for the scanner at most.
const MOST_ROWS: usize = 128;
const WAITING: usize = 1024;
/// Two strobes nearer than this are one: "about 30 kHz".
const LEAST_S: f64 = 30e-6;
/// Bytes of the head of a block: count, status and two reserved integers.
const HEAD: usize = 16;
/// Status of a block: rows were lost.
pub const OVERFLOW: i32 = 4;

#[derive(Clone, Copy, Debug, Default)]
struct Row {
    positions: [f64; AXES],
    analog: [i16; AXES],
}

/// State of the module.
#[derive(Clone, Debug, Default)]
pub struct Rts {
    running: bool,
    /// Something was recorded since RTS_Init.
    recorded: bool,
    /// Rows were lost since the last block.
    lost: bool,
    rows: Vec<Row>,
    /// When the last row was recorded, samples since boot.
    last: f64,
    /// Counts that the last strobe latched.
    latch: [i64; AXES],
}

/// What a block holds: the axes of its columns, rows, and whether analog values follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    pub columns: usize,
    pub rows: usize,
    pub analog: bool,
    axes: [u8; AXES],
    /// Columns that an axis was chosen for.
    used: usize,
}

impl Block {
    /// Bytes of every block, however many rows are valid.
    pub fn bytes(&self) -> usize {
        HEAD + self.rows * (self.columns * 8 + if self.analog { 2 * AXES } else { 0 })
    }
}

impl Rts {
    pub(crate) fn is_running(&self) -> bool {
        self.running
    }
    /// Appends the block of this sample to `out`; the rows stay, since several blocks may want them.
    pub(super) fn write_block(&self, block: &Block, out: &mut Vec<u8>) {
        let from = out.len();
        out.resize(from + block.bytes(), 0);
        let count = self.rows.len().min(block.rows);
        let lost = self.lost || count < self.rows.len();
        let bytes = &mut out[from..];
        bytes[..4].copy_from_slice(&(count as i32).to_le_bytes());
        bytes[4..8].copy_from_slice(&(if lost { OVERFLOW } else { 0 }).to_le_bytes());
        let (positions, analog) = bytes[HEAD..].split_at_mut(block.rows * block.columns * 8);
        for (row, to) in self.rows.iter().zip(positions.chunks_exact_mut(block.columns * 8)).take(count) {
            for (axis, to) in block.axes[..block.used].iter().zip(to.chunks_exact_mut(8)) {
                to.copy_from_slice(&row.positions[usize::from(*axis)].to_le_bytes());
            }
        }
        for (row, to) in self.rows.iter().zip(analog.chunks_exact_mut(2 * AXES)).take(count) {
            to.chunks_exact_mut(2).zip(row.analog).for_each(|(to, digits)| to.copy_from_slice(&digits.to_le_bytes()));
        }
    }
    /// All blocks of the sample are written.
    pub(super) fn taken(&mut self) {
        self.rows.clear();
        self.lost = false;
    }
}

impl Mcu {
    /// A strobe of the first axis at a fraction of the last sample.
    pub(crate) fn record_strobe(&mut self, fraction: f64) {
        let axes = self.axes.len().min(AXES);
        for a in 0..axes {
            self.resources.rts.latch[a] = self.counts_at(a, fraction);
        }
        let at = self.sample as f64 + fraction;
        let rts = &mut self.resources.rts;
        if !rts.running {
            return;
        }
        if (at - rts.last) * self.ta < LEAST_S || rts.rows.len() == WAITING {
            rts.lost = true;
            return;
        }
        let mut row = Row { analog: self.resources.ain, ..Row::default() };
        for a in 0..axes {
            row.positions[a] = rts.latch[a] as f64 * self.loops[a].unit_per_count;
        }
        (rts.last, rts.recorded) = (at, true);
        rts.rows.push(row);
    }

    /// The block that a descriptor means. [`Code::State`]: not so many columns or rows, or no axis of that number;
    /// [`Code::Hardware`]: the board, or the encoder of an axis, cannot do it.
    pub(super) fn data_block(&self, place: Place) -> Result<Block, Code> {
        let (columns, mask) = (place.index & 0xFFFF, place.index >> 16);
        let beyond = mask >> self.axes.len().min(AXES) != 0;
        done((1..=AXES).contains(&columns) && (1..=MOST_ROWS).contains(&place.sub) && mask != 0 && !beyond)?;
        let mut block = Block { columns, rows: place.sub, analog: place.device == 8014, axes: [0; AXES], used: 0 };
        for a in (0..AXES).filter(|a| mask >> a & 1 == 1).take(columns) {
            let absolute = self.resources.axes[a].endat.is_some();
            if self.hardware.get(a) != Some(&DriveKind::Servo) || absolute {
                return Err(Code::Hardware);
            }
            block.axes[block.used] = a as u8;
            block.used += 1;
        }
        fit(self)?;
        Ok(block)
    }
}

/// The board has the logic for it.
fn fit(mcu: &Mcu) -> Result<(), Code> {
    if mcu.resources.options.has(Options::EP1K50) { Ok(()) } else { Err(Code::Hardware) }
}
fn run(mcu: &mut Mcu, running: bool) -> Result<(), Code> {
    fit(mcu)?;
    let rts = &mut mcu.resources.rts;
    rts.running = running;
    if running {
        (rts.recorded, rts.lost, rts.last) = (false, false, f64::NEG_INFINITY);
        rts.rows.clear();
        rts.rows.reserve_exact(WAITING);
    }
    mcu.look_for_strobes();
    if running {
        mcu.remember_drives();
    }
    Ok(())
}
/// Whether something was recorded; BUSY before RTS_Init.
fn data_block(mcu: &mut Mcu, place: Place) -> Result<f64, Code> {
    if mcu.resources.options.has(Options::RTS_ANALOGIN) != (place.device == 8014) {
        return Err(Code::Unknown);
    }
    mcu.data_block(place)?;
    let rts = &mcu.resources.rts;
    if rts.running { Ok(f64::from(u8::from(rts.recorded))) } else { Err(Code::Busy) }
}

const fn device(number: i32, name: &'static str, kind: Type, index: Range, read: super::table::Read) -> Device {
    Device::read_only(number, name, kind, index, read).with(Options::DMARTS)
}
const fn order(number: i32, name: &'static str, write: super::table::Write) -> Device {
    device(number, name, Type::Integer, Range::Any, |_, _| Err(Code::Unknown)).writing(write).write_only()
}

pub(super) const DEVICES: &[Device] = &[
    order(8000, "RTS_Stop", |m, _, _| run(m, false)),
    order(8001, "RTS_Init", |m, _, _| run(m, true)),
    // rows that wait for the scanner
    device(8010, "RTS_DIAG", Type::Integer, Range::Any, |m, _| {
        let rts = &m.resources.rts;
        if rts.rows.is_empty() { Err(Code::Busy) } else { Ok(rts.rows.len() as f64) }
    }),
    device(8011, "LPR_RTS", Type::Short, Range::Below(AXES), |m, p| {
        done(p.index < m.axes.len())?;
        Ok(f64::from(m.resources.rts.latch[p.index] as i16))
    }),
    device(8012, "STROBE RTS", Type::Short, Range::Any, |m, _| {
        let strobes = m.signals.iter().map(|signals| signals.digi.has(crate::registers::Digi::strobe));
        Ok(strobes.enumerate().fold(0.0, |bits, (a, on)| bits + if on { f64::from(1_u32 << a) } else { 0.0 }))
    }),
    device(8013, "RTS_DATABLOCK", Type::DataBlock, Range::Any, data_block).with_sub(Range::Any),
    device(8014, "RTS_DATAANALOGBLOCK", Type::DataBlock, Range::Any, data_block).with_sub(Range::Any),
];
