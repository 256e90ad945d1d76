//! The position loop of one axis: plant, encoder, PIDF filter, motor command port (chapters 2.1, 4.2).
//!
//! Counts of the machine start at its position at boot; coordinates may be shifted against them (shp, wrrp, zero
//! offsets, backlash compensation). Whatever is not the plain loop sets `special` and goes its own way (port.rs).

use crate::controller::{FULL_SCALE, Pidf};
use crate::machine::{self, DriveKind, PidfGains};
use crate::plant::{MOST_DELAY_WRITTEN, ServoPlant, Stepper, whole};
use crate::port::Special;

/// Loop and plant of an axis.
#[derive(Debug)]
pub struct PositionLoop {
    pub closed: bool,
    pub(crate) counts_per_unit: f64,
    pub(crate) unit_per_count: f64,
    ta_s: f64,
    gains: PidfGains,
    pub(crate) drive: Drive,
    /// Encoder position in whole counts, now and a sample ago.
    pub(crate) counts: i64,
    pub(crate) counts_before: i64,
    /// Counts of the machine where the coordinate is 0, without and with backlash compensation.
    pub(crate) origin: i64,
    pub(crate) encoder_origin: i64,
    /// dpoffset in effect, axis units.
    pub(crate) offset: f64,
    pub(crate) is_special: bool,
    pub(crate) special: Special,
    pub(crate) command_use: CommandUse,
}

/// How much of the motor command of a servo axis was used: largest magnitude, samples at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CommandUse {
    pub peak_digits: f64,
    pub saturated: u64,
}

impl CommandUse {
    #[inline]
    pub(crate) fn note(&mut self, digits: f64) {
        let used = digits.abs();
        if used > self.peak_digits {
            self.peak_digits = used;
        }
        self.saturated += u64::from(used >= FULL_SCALE);
    }
}

#[derive(Debug)]
pub(crate) enum Drive {
    Servo {
        filter: Pidf,
        plant: ServoPlant,
        per_sample: f64,
        velocity: f64,
        digits: f64,
    },
    /// In closed loop whole steps follow the set point of the sample before, else pulses run at the rate of mcp.
    Stepper {
        target: i64,
        stepper: Stepper,
    },
}

impl PositionLoop {
    pub fn new(axis: &machine::Axis, ta: f64, clock_hz: f64) -> Self {
        let counts = whole(axis.start * axis.counts_per_unit);
        let drive = match axis.drive {
            DriveKind::Servo => Drive::Servo {
                filter: Pidf::new(&axis.pidf, ta),
                plant: ServoPlant::new(axis, ta, axis.start),
                per_sample: 1.0 / ta,
                velocity: 0.0,
                digits: 0.0,
            },
            DriveKind::Stepper => Drive::Stepper { target: counts, stepper: Stepper::new(clock_hz, ta, counts) },
        };
        let special = Special::new(axis);
        PositionLoop {
            closed: false,
            counts_per_unit: axis.counts_per_unit,
            unit_per_count: 1.0 / axis.counts_per_unit,
            ta_s: ta,
            gains: axis.pidf,
            drive,
            counts,
            counts_before: counts,
            origin: 0,
            encoder_origin: 0,
            offset: 0.0,
            is_special: special.is_needed(),
            special,
            command_use: CommandUse::default(),
        }
    }
    /// How much of the motor command was used since boot.
    pub fn command_use(&self) -> CommandUse {
        self.command_use
    }
    /// Encoder position, axis units.
    #[inline]
    pub fn rp(&self) -> f64 {
        self.counts as f64 * self.unit_per_count
    }
    /// Actual velocity: what the encoder counted in the last sample, axis units/s.
    pub fn rv(&self) -> f64 {
        self.counts.saturating_sub(self.counts_before) as f64 * self.unit_per_count / self.ta_s
    }
    /// Position of the load side, axis units (design D21).
    #[inline]
    pub fn load(&self) -> f64 {
        if self.is_special && self.special.simulated {
            return self.rp();
        }
        match &self.drive {
            Drive::Servo { plant, .. } => plant.load() - self.origin as f64 * self.unit_per_count,
            Drive::Stepper { stepper, .. } => {
                (stepper.motor().saturating_sub(self.origin)) as f64 * self.unit_per_count
            }
        }
    }
    /// Following error of a set point (axis units).
    #[inline]
    pub fn error(&self, set_point: f64) -> f64 {
        set_point + self.offset - self.rp()
    }
    /// The drive follows the last motor command for one sample.
    #[inline]
    pub fn step_plant(&mut self) {
        self.counts_before = self.counts;
        if self.is_special {
            return self.step_special();
        }
        match &mut self.drive {
            Drive::Servo { plant, digits, .. } => {
                plant.step(*digits);
                self.counts = plant.counts().saturating_sub(self.encoder_origin);
            }
            Drive::Stepper { target, stepper } => {
                if self.closed {
                    stepper.follow(*target);
                } else {
                    stepper.run();
                }
                self.counts = stepper.counts.saturating_sub(self.encoder_origin);
            }
        }
    }
    /// The filter computes the next motor command for set point `dp` moving at `dv` (axis units). Towards the
    /// side `motor_off` (-1, +1; 0 = none) the motor gets no command (limit function TOM). In open loop the
    /// motor command stays what it is. `travels`: the axis executes a profile.
    #[inline]
    pub fn control(&mut self, dp: f64, dv: f64, motor_off: f64, travels: bool) {
        if !self.closed {
            return;
        }
        if self.is_special {
            return self.control_special(dp, dv, motor_off, travels);
        }
        match &mut self.drive {
            Drive::Servo { filter, per_sample, velocity, digits, .. } => {
                let v = dv * self.counts_per_unit;
                let a = (v - *velocity) * *per_sample;
                *velocity = v;
                *digits = filter.step((dp + self.offset) * self.counts_per_unit - self.counts as f64, v, a);
                if *digits * motor_off > 0.0 {
                    *digits = 0.0;
                }
                self.command_use.note(*digits);
            }
            Drive::Stepper { target, .. } => {
                let wanted = whole((dp + self.offset) * self.counts_per_unit).saturating_add(self.encoder_origin);
                if wanted.saturating_sub(*target) as f64 * motor_off <= 0.0 {
                    *target = wanted;
                }
            }
        }
    }
    /// Closes the loop at the present position; `dv` is the velocity the set point starts with.
    pub fn close(&mut self, dv: f64) {
        self.closed = true;
        match &mut self.drive {
            Drive::Servo { filter, velocity, .. } => {
                filter.reset();
                *velocity = dv * self.counts_per_unit;
            }
            Drive::Stepper { target, stepper } => *target = stepper.counts,
        }
        self.special.simulated_counts = self.counts;
    }
    /// Opening the loop puts 0 on the motor command port (2.1.1).
    pub fn open(&mut self) {
        self.closed = false;
        self.set_mcp(0);
    }

    /// Value of the motor command port (4.4.88): digits of a servo axis, delay of a stepper axis.
    pub fn mcp(&self) -> i32 {
        match &self.drive {
            Drive::Servo { digits, .. } => whole(*digits) as i32,
            Drive::Stepper { stepper, .. } => stepper.mcp,
        }
    }
    /// Writes the motor command port (4.4.162), within its range. A closed loop overwrites it in the next sample.
    pub fn set_mcp(&mut self, mcp: i32) {
        let port = &self.special.port;
        match &mut self.drive {
            // 0 is always possible: it is what opens the loop
            Drive::Servo { digits, .. } if mcp == 0 => *digits = 0.0,
            Drive::Servo { digits, .. } => {
                *digits = f64::from(mcp).clamp(-FULL_SCALE, FULL_SCALE).clamp(port.min, port.max);
            }
            Drive::Stepper { stepper, .. } => stepper.mcp = mcp.clamp(-MOST_DELAY_WRITTEN, MOST_DELAY_WRITTEN),
        }
    }
    pub fn gains(&self) -> &PidfGains {
        &self.gains
    }
    /// New filter coefficients; the state of the filter goes on (uf, 4.4.131).
    pub fn set_gains(&mut self, gains: &PidfGains) {
        self.gains = *gains;
        if let Drive::Servo { filter, .. } = &mut self.drive {
            filter.tune(gains, self.ta_s);
        }
    }
    /// Another number of counts per axis unit, `ratio` times as many units for a count (gear.rs). The motor notices
    /// nothing.
    pub(crate) fn convert(&mut self, counts_per_unit: f64, ratio: f64) {
        (self.counts_per_unit, self.unit_per_count) = (counts_per_unit, 1.0 / counts_per_unit);
        self.offset *= ratio;
        if let Some(encoder) = &mut self.special.encoder {
            encoder.counts_per_unit /= ratio;
        }
        if let Drive::Servo { plant, .. } = &mut self.drive {
            plant.convert(counts_per_unit, ratio);
        }
    }
    /// The mechanics of a servo axis, to play faults.
    pub fn plant_mut(&mut self) -> Option<&mut ServoPlant> {
        match &mut self.drive {
            Drive::Servo { plant, .. } => Some(plant),
            Drive::Stepper { .. } => None,
        }
    }
}
