//! How far an axis is behind its set point, as a linear function of its motion; histograms of its dynamics.

/// Regressors of the difference set point minus load: velocity, acceleration, direction of the last motion (-1, 1), 1.
pub const MOTION: usize = 4;
/// Classes of the histograms: quarters of an octave from 2^-8 on.
pub const HISTOGRAM_BINS: usize = 160;
const LEAST_EXPONENT: u64 = 1023 - 8;

/// A way back shorter than that is no reversal, axis units.
const RETREAT: f64 = 1e-5;
/// Way after a reversal on which play is taken up and nothing is counted, axis units.
const PLAY: f64 = 0.1;
/// Slower is rest, axis units/s.
const MOVING: f64 = 1e-2;
/// One sample of so many enters the normal equations: as good, and cheaper.
const EVERY: u8 = 4;

/// One axis over a whole run, in axis units and seconds.
#[derive(Clone, Debug)]
pub struct AxisFit {
    /// Samples counted, their normal equations (upper triangle, row by row), right-hand sides and sum of squares.
    pub samples: u64,
    pub normal: [f64; MOTION * (MOTION + 1) / 2],
    pub right: [f64; MOTION],
    pub squares: f64,
    pub reversals: u64,
    /// Least and greatest set point.
    pub range: (f64, f64),
    /// Largest magnitudes.
    pub velocity: f64,
    pub acceleration: f64,
    pub jerk: f64,
    /// Samples by magnitude of acceleration and jerk; see [`bin_edge`]. Without those at rest.
    pub acceleration_bins: [u64; HISTOGRAM_BINS],
    pub jerk_bins: [u64; HISTOGRAM_BINS],
    last: [f64; 3],
    per_s: f64,
    /// Direction of motion, 0 before the first; furthest position in it; where it began.
    direction: f64,
    extreme: f64,
    begun: f64,
    settled: bool,
    counted: u8,
}

impl AxisFit {
    pub fn new(start: f64, sample_time_s: f64) -> AxisFit {
        AxisFit {
            samples: 0,
            normal: [0.0; MOTION * (MOTION + 1) / 2],
            right: [0.0; MOTION],
            squares: 0.0,
            reversals: 0,
            range: (start, start),
            velocity: 0.0,
            acceleration: 0.0,
            jerk: 0.0,
            acceleration_bins: [0; HISTOGRAM_BINS],
            jerk_bins: [0; HISTOGRAM_BINS],
            last: [start, 0.0, 0.0],
            per_s: 1.0 / sample_time_s,
            direction: 0.0,
            extreme: start,
            begun: start,
            settled: false,
            counted: 0,
        }
    }

    /// The run begins elsewhere than its path.
    pub fn begin(&mut self, dp: f64) {
        *self = AxisFit::new(dp, 1.0 / self.per_s);
    }

    /// A set point, and how far the load is behind it.
    #[inline]
    pub fn add(&mut self, dp: f64, behind: f64) {
        let v = (dp - self.last[0]) * self.per_s;
        let a = (v - self.last[1]) * self.per_s;
        let j = (a - self.last[2]) * self.per_s;
        self.last = [dp, v, a];
        self.range = (self.range.0.min(dp), self.range.1.max(dp));
        // rounding of positions is no motion
        if j.abs() > 1e-2 || a.abs() > 1e-3 {
            self.velocity = self.velocity.max(v.abs());
            self.acceleration = self.acceleration.max(a.abs());
            self.jerk = self.jerk.max(j.abs());
            self.acceleration_bins[bin(a)] += 1;
            self.jerk_bins[bin(j)] += 1;
        }
        self.turn(dp);
        self.counted = self.counted.wrapping_add(1);
        // at rest the load lies where the last overshoot left it
        if self.settled && v.abs() > MOVING && self.counted.is_multiple_of(EVERY) {
            self.relate([v, a, self.direction, 1.0], behind);
        }
    }

    fn relate(&mut self, x: [f64; MOTION], behind: f64) {
        self.samples += 1;
        let mut k = 0;
        for i in 0..MOTION {
            for j in i..MOTION {
                self.normal[k] += x[i] * x[j];
                k += 1;
            }
            self.right[i] += x[i] * behind;
        }
        self.squares += behind * behind;
    }

    #[inline]
    fn turn(&mut self, dp: f64) {
        let ahead = (dp - self.extreme) * self.direction;
        if ahead > 0.0 {
            self.extreme = dp;
            self.settled |= (dp - self.begun).abs() > PLAY;
        } else if ahead < -RETREAT || (self.direction == 0.0 && (dp - self.begun).abs() > RETREAT) {
            self.reversals += u64::from(self.direction != 0.0);
            self.begun = self.extreme;
            self.direction = (dp - self.extreme).signum();
            self.extreme = dp;
            self.settled = (dp - self.begun).abs() > PLAY;
        }
    }
}

#[inline]
fn bin(value: f64) -> usize {
    let quarter = value.abs().to_bits() >> 50;
    quarter.saturating_sub(LEAST_EXPONENT << 2).min(HISTOGRAM_BINS as u64 - 1) as usize
}

/// Upper edge of a class of the histograms.
pub fn bin_edge(bin: usize) -> f64 {
    f64::from_bits((bin as u64 + 1 + (LEAST_EXPONENT << 2)) << 50)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_hold_what_they_say() {
        for k in 0..200 {
            let value = 0.01 * 1.1f64.powi(k);
            let at = bin(-value);
            assert!(value < bin_edge(at) && (at == 0 || value >= bin_edge(at - 1)), "{value}");
        }
        assert_eq!(bin(0.0), 0);
        assert_eq!(bin(f64::INFINITY), HISTOGRAM_BINS - 1);
    }

    #[test]
    fn a_reversal_counts_when_its_play_is_taken_up() {
        let mut fit = AxisFit::new(0.0, 1e-3);
        let mut x = 0.0;
        for k in 0..4000 {
            x += if k < 2000 { 1e-3 } else { -1e-3 };
            fit.add(x, 0.0);
        }
        assert_eq!(fit.reversals, 1);
        // 100 samples behind each beginning are left out, and three of four behind them
        assert!((949..=951).contains(&fit.samples), "{}", fit.samples);
        let directions = fit.normal[8];
        assert!(directions.abs() <= 1.0, "as many forward as back: {directions}");
    }
}
