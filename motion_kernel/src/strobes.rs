//! Hardware latch strobes: the counters keep the position of the instant at which a strobe input becomes active, also
//! many times a sample. A stimulus lets an input pulse (`input 14 pulsing 10 kHz`).
//!
//! Where a servo motor was inside a sample is computed as its drive moves, from the state at the begin of the sample;
//! other counters are interpolated between two samples.

use crate::latch::{FIRST_STROBE, STROBES};
use crate::mcu::Mcu;
use crate::plant::ServoPlant;
use crate::position_loop::{Drive, PositionLoop};

/// Pulses on the strobe inputs, and the drives as they were a sample ago.
#[derive(Debug, Default)]
pub(crate) struct Strobes {
    trains: [Option<Train>; STROBES],
    /// One for each axis; empty where they are not known.
    before: Vec<Option<ServoPlant>>,
}

/// Pulses at equal distances; times in samples since boot.
#[derive(Clone, Copy, Debug)]
struct Train {
    start: f64,
    period: f64,
    /// Pulses so far.
    count: u64,
}

impl Strobes {
    pub fn for_axes(axes: usize) -> Self {
        Strobes { before: Vec::with_capacity(axes), ..Strobes::default() }
    }
}

impl Mcu {
    /// The strobe input of this number (14 to 16) pulses from an instant of the last sample on; 0 Hz ends it.
    pub(crate) fn pulse(&mut self, number: u32, hz: f64, fraction: f64) {
        let Some(train) = (number as usize - 1).checked_sub(FIRST_STROBE).filter(|a| *a < STROBES) else { return };
        let (start, period) = (self.sample as f64 + fraction, 1.0 / (hz * self.ta));
        self.strobes.trains[train] = (hz > 0.0).then_some(Train { start, period, count: 0 });
        self.look_for_strobes();
    }
    /// Strobes are played as long as there are any, or somebody waits for one.
    pub(crate) fn look_for_strobes(&mut self) {
        let wanted = self.strobes.trains.iter().any(Option::is_some) || self.resources.rts.is_running();
        self.attend_to(|attention| attention.strobes = wanted);
        if !wanted {
            self.strobes.before.clear();
        }
    }
    /// Between two samples: the drives are as they will be at the begin of the next.
    pub(crate) fn remember_drives(&mut self) {
        self.strobes.before.clear();
        self.strobes.before.extend(self.loops.iter().map(PositionLoop::servo));
    }
    /// At the end of what happened outside in a sample.
    pub(crate) fn play_strobes(&mut self) {
        let end = (self.sample + 1) as f64;
        for n in 0..STROBES {
            while let Some(train) = &mut self.strobes.trains[n] {
                let at = train.start + train.count as f64 * train.period;
                if at >= end {
                    break;
                }
                train.count += 1;
                self.strobe(n, (at - self.sample as f64).clamp(0.0, 1.0));
            }
        }
        self.remember_drives();
    }
    /// Counts of an axis, in its coordinates, at a fraction of the last sample.
    pub(crate) fn counts_at(&self, axis: usize, fraction: f64) -> i64 {
        let position_loop = &self.loops[axis];
        match (self.strobes.before.get(axis), &position_loop.drive) {
            (Some(Some(plant)), Drive::Servo { digits, .. }) if position_loop.counts_motor() => {
                plant.counts_at(*digits, fraction).saturating_sub(position_loop.encoder_origin)
            }
            _ => position_loop.counts_between(fraction),
        }
    }
}

impl PositionLoop {
    fn servo(&self) -> Option<ServoPlant> {
        if let Drive::Servo { plant, .. } = &self.drive { Some(*plant) } else { None }
    }
    /// The counter shows where the motor is.
    fn counts_motor(&self) -> bool {
        !(self.is_special && (self.special.simulated || self.special.cut))
    }
}
