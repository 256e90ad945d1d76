//! Drive and mechanics of an axis (design D8): what the motor command does to the position.

use crate::controller::FULL_SCALE;
use crate::machine::Axis;

/// A velocity-controlled servo drive: first-order lag, exact over a sample; the encoder sits on the motor side
/// of the backlash and counts whole counts.
#[derive(Clone, Copy, Debug)]
pub struct ServoPlant {
    /// Axis units per second and digit.
    speed_per_digit: f64,
    ta_s: f64,
    lag_s: f64,
    /// exp(-TA / lag): what is left of a velocity difference after a sample.
    decay: f64,
    half_backlash: f64,
    counts_per_unit: f64,
    velocity: f64,
    motor: f64,
    load: f64,
}

impl ServoPlant {
    /// At rest at `start` (axis units), in the middle of the backlash.
    pub fn new(axis: &Axis, ta_s: f64, start: f64) -> Self {
        let plant = &axis.plant;
        ServoPlant {
            speed_per_digit: plant.full_speed / FULL_SCALE,
            ta_s,
            lag_s: plant.lag_s,
            decay: if plant.lag_s > 0.0 { (-ta_s / plant.lag_s).exp() } else { 0.0 },
            half_backlash: plant.backlash / 2.0,
            counts_per_unit: axis.counts_per_unit,
            velocity: 0.0,
            motor: start,
            load: start,
        }
    }

    /// One sample at a motor command in digits.
    #[inline]
    pub fn step(&mut self, digits: f64) {
        let wanted = digits * self.speed_per_digit;
        let behind = self.velocity - wanted;
        self.motor += wanted * self.ta_s + behind * self.lag_s * (1.0 - self.decay);
        self.velocity = wanted + behind * self.decay;
        self.load = self.load.clamp(self.motor - self.half_backlash, self.motor + self.half_backlash);
    }

    /// Position of the load, axis units.
    #[inline]
    pub fn load(&self) -> f64 {
        self.load
    }
    /// What the encoder says.
    #[inline]
    pub fn counts(&self) -> i64 {
        whole(self.motor * self.counts_per_unit)
    }
}

/// Nearest whole number.
#[inline]
pub(crate) fn whole(value: f64) -> i64 {
    (value + 0.5_f64.copysign(value)) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;

    const TA: f64 = 1.28e-3;

    #[test]
    fn a_step_of_the_command_is_a_first_order_step_of_the_speed() {
        let axis = &Machine::builtin().axes[0];
        let mut plant = ServoPlant::new(axis, TA, 1.0);
        let (v, lag) = (0.5 * axis.plant.full_speed, axis.plant.lag_s);
        for n in 1..200 {
            plant.step(0.5 * FULL_SCALE);
            let t = f64::from(n) * TA;
            let want = 1.0 + v * (t - lag * (1.0 - (-t / lag).exp()));
            assert!((plant.load() - want).abs() < 1e-9);
        }
    }

    #[test]
    fn backlash_stands_between_motor_and_load() {
        let mut axis = Machine::builtin().axes[0].clone();
        axis.plant.backlash = 0.01;
        axis.plant.lag_s = 0.0;
        let mut plant = ServoPlant::new(&axis, TA, 0.0);
        let digits = 0.02 / TA / axis.plant.full_speed * FULL_SCALE; // 0.02 mm a sample
        plant.step(digits);
        assert!((plant.load() - 0.015).abs() < 1e-12);
        plant.step(-digits);
        assert_eq!(plant.counts(), 0);
        assert!((plant.load() - 0.005).abs() < 1e-12);
    }

    #[test]
    fn counts_are_whole_and_nearest() {
        assert_eq!([whole(0.49), whole(0.5), whole(-0.5), whole(-1.49)], [0, 1, -1, -1]);
    }
}
