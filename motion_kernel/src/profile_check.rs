//! The second opinion on profiles (chapter 2.2): the acceleration, integrated twice over time, must give the velocity
//! and the way of the closed form. Asked in debug builds for every profile that is planned.

use crate::profile::{Profile, Ramp};

/// Simpson intervals of each of the three parts of a ramp; its acceleration is linear in each of them.
const INTERVALS: u32 = 4;
/// Rounding: relative to the greatest velocity and way involved.
const CLOSE: f64 = 1e-9;

impl Profile {
    /// Whether velocity and way of the profile are what its acceleration gives, from the path coordinate `from` to
    /// its end. A profile without end is not judged.
    pub(crate) fn is_integral(&self, from: f64) -> bool {
        if !(self.end_s.is_finite() && self.end_t.is_finite()) {
            return true;
        }
        let reach = self.ramps().iter().fold(from.abs().max(self.end_s.abs()), |reach, ramp| {
            reach + ramp.s0.abs() + ramp.v0.abs().max(ramp.end_v().abs()) * ramp.duration_t
        });
        let mut s = Some(from);
        for ramp in self.ramps() {
            s = s.filter(|s| (ramp.s0 - s).abs() <= CLOSE * reach).and_then(|s| integrated(ramp, s, reach));
        }
        s.is_some_and(|s| (self.end_s - s).abs() <= CLOSE * reach)
    }
}

/// The path coordinate at the end of a ramp that begins at `s`, by integrating its acceleration; None where the closed
/// form says something else on the way.
fn integrated(ramp: &Ramp, mut s: f64, reach: f64) -> Option<f64> {
    let most_v = ramp.v0.abs().max(ramp.end_v().abs());
    let mut v = ramp.v0;
    let breaks = [0.0, ramp.flank_t, ramp.duration_t - ramp.flank_t, ramp.duration_t];
    for part in breaks.windows(2) {
        let h = (part[1] - part[0]) / f64::from(INTERVALS);
        for n in 0..INTERVALS {
            let t = part[0] + f64::from(n) * h;
            let [a0, a1, a2] = [0.0, 0.5, 1.0].map(|share| ramp.acceleration((t + share * h).min(ramp.duration_t)));
            let middle_v = v + h * (5.0 * a0 + 8.0 * a1 - a2) / 24.0;
            let end_v = v + h * (a0 + 4.0 * a1 + a2) / 6.0;
            s += h * (v + 4.0 * middle_v + end_v) / 6.0;
            v = end_v;
            let (closed_s, closed_v) = ramp.at((t + h).min(ramp.duration_t));
            if (closed_s - s).abs() > CLOSE * reach || (closed_v - v).abs() > CLOSE * most_v {
                return None;
            }
        }
    }
    Some(s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::Request;

    #[test]
    fn a_profile_that_is_not_its_integral_is_noticed() {
        for jerkrel in [0.0, 0.4, 1.0] {
            let request = Request { from: 2.0, to: 9.0, start_v: 3.0, max_v: 20.0, acc: 100.0, target_v: 5.0, jerkrel };
            let good = Profile::spooled(&request);
            assert!(good.is_integral(2.0));
            assert!(!good.is_integral(2.001));
            let breaks: [fn(&mut Profile); 2] = [|p| p.end_s += 1e-6, |p| p.end_s -= 1e-6];
            for change in breaks {
                let mut bad = good;
                change(&mut bad);
                assert!(!bad.is_integral(2.0));
            }
        }
    }
}
