//! The PIDF filter of chapter 2.1.2: position error in counts, motor command in digits (32767 = 10 V).

use crate::machine::PidfGains;

/// Largest motor command, about 10 V (errata 4.4.88).
pub const FULL_SCALE: f64 = 32_767.0;

/// What the integral part may do in a sample (ControllerFlags, 6.3.1.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integral {
    Free,
    /// Cleared.
    Zero,
    /// Held.
    Fix,
    /// Not above what it is, in magnitude.
    Limited,
}

/// (kp + ki/s + kd*s) / (1 + s*(1-KPL)*TA/2) as one bilinear filter at TA (design D26). Its pole lies at 0 for
/// KPL 0 and at -1 for KPL 1, hence "not above 0.95". The integrator is held while the command is clamped.
#[derive(Clone, Copy, Debug)]
pub struct Pidf {
    kp: f64,
    /// ki * TA / 2 and kd * 2 / TA.
    ki: f64,
    kd: f64,
    /// Share of the last output, and 1 / (1 + (1 - KPL)).
    feedback: f64,
    scale: f64,
    kfcv: f64,
    kfca: f64,
    error: f64,
    integral: f64,
    output: f64,
}

impl Pidf {
    /// A filter at rest; `ta_s` is the sample time.
    pub fn new(gains: &PidfGains, ta_s: f64) -> Self {
        let lag = 1.0 - gains.kpl;
        Pidf {
            kp: gains.kp,
            ki: gains.ki * ta_s / 2.0,
            kd: gains.kd * 2.0 / ta_s,
            feedback: 1.0 - lag,
            scale: 1.0 / (1.0 + lag),
            kfcv: gains.kfcv,
            kfca: gains.kfca,
            error: 0.0,
            integral: 0.0,
            output: 0.0,
        }
    }

    /// New coefficients, the past stays.
    pub fn tune(&mut self, gains: &PidfGains, ta_s: f64) {
        let Pidf { error, integral, output, .. } = *self;
        *self = Pidf { error, integral, output, ..Pidf::new(gains, ta_s) };
    }

    /// Forgets the past, as when the loop is closed.
    pub fn reset(&mut self) {
        (self.error, self.integral, self.output) = (0.0, 0.0, 0.0);
    }

    /// The motor command for a position error (counts), the velocity (counts/s) and the acceleration
    /// (counts/s²) of the set point.
    #[inline]
    pub fn step(&mut self, error: f64, velocity: f64, acceleration: f64) -> f64 {
        let ahead = self.kfcv * velocity + self.kfca * acceleration;
        let integral = self.integral + self.ki * (error + self.error);
        let mut output = self.filtered(error, integral);
        let mut command = output + ahead;
        if command.abs() > FULL_SCALE && self.ki != 0.0 {
            output = self.filtered(error, self.integral);
            command = output + ahead;
        } else {
            self.integral = integral;
        }
        (self.error, self.output) = (error, output);
        command.clamp(-FULL_SCALE, FULL_SCALE)
    }

    /// As [`Pidf::step`], with the motor command between `least` and `most` and a rule for the integral part.
    #[cold]
    pub fn step_within(&mut self, error: f64, ahead: f64, [least, most]: [f64; 2], rule: Integral) -> f64 {
        let grown = self.integral + self.ki * (error + self.error);
        let before = self.integral;
        let mut integral = match rule {
            Integral::Free => grown,
            Integral::Zero => 0.0,
            Integral::Fix => before,
            Integral::Limited if grown.abs() > before.abs() => before,
            Integral::Limited => grown,
        };
        if rule == Integral::Zero {
            self.integral = 0.0;
        }
        let mut output = self.filtered(error, integral);
        let clamped = output + ahead;
        if (clamped > most || clamped < least) && self.ki != 0.0 {
            integral = self.integral;
            output = self.filtered(error, integral);
        }
        (self.error, self.integral, self.output) = (error, integral, output);
        (output + ahead).clamp(least, most)
    }
    /// Feed-forward for velocity and acceleration of the set point.
    pub fn ahead(&self, velocity: f64, acceleration: f64) -> f64 {
        self.kfcv * velocity + self.kfca * acceleration
    }

    #[inline]
    fn filtered(&self, error: f64, integral: f64) -> f64 {
        let sum = self.kp * (error + self.error) + integral + self.integral + self.kd * (error - self.error);
        (sum - self.feedback * self.output) * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TA: f64 = 1.28e-3;

    /// The same filter as a rational function of z, by multiplying the two bilinear factors out.
    fn reference(g: &PidfGains, errors: &[f64]) -> Vec<f64> {
        let (t, l) = (TA, 1.0 - g.kpl);
        let b = [
            g.kp + g.ki * t / 2.0 + g.kd * 2.0 / t,
            g.ki * t - g.kd * 4.0 / t,
            -g.kp + g.ki * t / 2.0 + g.kd * 2.0 / t,
        ];
        let a = [1.0 + l, -2.0 * l, -1.0 + l];
        let mut out: Vec<f64> = Vec::new();
        for n in 0..errors.len() {
            let e = |k: usize| if n >= k { errors[n - k] } else { 0.0 };
            let y = |k: usize| if n >= k { out[n - k] } else { 0.0 };
            out.push((b[0] * e(0) + b[1] * e(1) + b[2] * e(2) - a[1] * y(1) - a[2] * y(2)) / a[0]);
        }
        out
    }

    // shows: kernel.pidf.structure
    #[test]
    fn equals_the_bilinear_transform() {
        let errors: Vec<f64> = (0..200).map(|n| f64::from(n * 37 % 23) - 11.0).collect();
        for kpl in [0.0, 0.3, 0.95] {
            let gains = PidfGains { kp: 0.7, ki: 3.0, kd: 0.002, kpl, ..PidfGains::default() };
            let mut filter = Pidf::new(&gains, TA);
            for (error, want) in errors.iter().zip(reference(&gains, &errors)) {
                assert!((filter.step(*error, 0.0, 0.0) - want).abs() < 1e-9 * want.abs().max(1.0));
            }
        }
    }

    #[test]
    fn the_integrator_is_held_while_the_command_is_clamped() {
        let gains = PidfGains { kp: 1.0, ki: 100.0, ..PidfGains::default() };
        let mut filter = Pidf::new(&gains, TA);
        for _ in 0..10_000 {
            assert!(filter.step(40_000.0, 0.0, 0.0) <= FULL_SCALE);
        }
        for _ in 0..3 {
            filter.step(0.0, 0.0, 0.0);
        }
        assert!(filter.step(0.0, 0.0, 0.0) < FULL_SCALE, "no wind-up");
    }
}
