//! The position loop of one axis: plant, encoder, PIDF filter, motor command (chapters 2.1, 4.2).

use crate::controller::Pidf;
use crate::machine::{self, DriveKind};
use crate::plant::{ServoPlant, whole};

/// Loop and plant of an axis.
#[derive(Debug)]
pub struct PositionLoop {
    pub closed: bool,
    counts_per_unit: f64,
    unit_per_count: f64,
    drive: Drive,
    /// Encoder position in whole counts.
    counts: i64,
}

#[derive(Debug)]
enum Drive {
    Servo {
        filter: Pidf,
        plant: ServoPlant,
        per_sample: f64,
        velocity: f64,
        digits: f64,
    },
    /// Whole steps follow the set point of the sample before.
    Stepper {
        target: i64,
    },
}

impl PositionLoop {
    pub fn new(axis: &machine::Axis, ta: f64) -> Self {
        let counts = whole(axis.start * axis.counts_per_unit);
        let drive = match axis.drive {
            DriveKind::Servo => Drive::Servo {
                filter: Pidf::new(&axis.pidf, ta),
                plant: ServoPlant::new(axis, ta, axis.start),
                per_sample: 1.0 / ta,
                velocity: 0.0,
                digits: 0.0,
            },
            DriveKind::Stepper => Drive::Stepper { target: counts },
        };
        PositionLoop {
            closed: false,
            counts_per_unit: axis.counts_per_unit,
            unit_per_count: 1.0 / axis.counts_per_unit,
            drive,
            counts,
        }
    }
    /// Encoder position, axis units.
    #[inline]
    pub fn rp(&self) -> f64 {
        self.counts as f64 * self.unit_per_count
    }
    /// Position of the load side, axis units (design D21).
    #[inline]
    pub fn load(&self) -> f64 {
        match &self.drive {
            Drive::Servo { plant, .. } => plant.load(),
            Drive::Stepper { .. } => self.rp(),
        }
    }
    /// The drive follows the last motor command for one sample.
    #[inline]
    pub fn step_plant(&mut self) {
        match &mut self.drive {
            Drive::Servo { plant, digits, .. } => {
                plant.step(*digits);
                self.counts = plant.counts();
            }
            Drive::Stepper { target } => self.counts = *target,
        }
    }
    /// The filter computes the next motor command for set point `dp` moving at `dv` (axis units). Towards the
    /// side `motor_off` (-1, +1; 0 = none) the motor gets no command (limit function TOM).
    #[inline]
    pub fn control(&mut self, dp: f64, dv: f64, motor_off: f64) {
        match &mut self.drive {
            Drive::Servo { filter, per_sample, velocity, digits, .. } => {
                if !self.closed {
                    return; // open loop: the motor command stays what it is
                }
                let v = dv * self.counts_per_unit;
                let a = (v - *velocity) * *per_sample;
                *velocity = v;
                *digits = filter.step(dp * self.counts_per_unit - self.counts as f64, v, a);
                if *digits * motor_off > 0.0 {
                    *digits = 0.0;
                }
            }
            Drive::Stepper { target } => {
                let wanted = whole(dp * self.counts_per_unit);
                if (wanted - *target) as f64 * motor_off <= 0.0 {
                    *target = wanted;
                }
            }
        }
    }
    pub fn close(&mut self) {
        self.closed = true;
        if let Drive::Servo { filter, velocity, .. } = &mut self.drive {
            filter.reset();
            *velocity = 0.0;
        }
    }
    /// Opening the loop puts 0 on the motor command port (2.1.1).
    pub fn open(&mut self) {
        self.closed = false;
        if let Drive::Servo { digits, .. } = &mut self.drive {
            *digits = 0.0;
        }
    }
}
