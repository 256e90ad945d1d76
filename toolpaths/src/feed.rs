//! Feed and override checks of design 3.2, from the foot of the set point and the override alone.

/// What one sample interval says about the feed.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    pub time_s: f64,
    /// Effective override.
    pub factor: f64,
    /// Path run, mm, and the time that the programmed velocity needs for it.
    pub length: f64,
    pub programmed_s: f64,
    /// Length that was run for certain: at a reversal two feet are equally near, and the chord decides.
    pub certain: f64,
    pub rapid: bool,
    /// The length is exact enough to compare speeds.
    pub unambiguous: bool,
    /// Begins and ends on one motion command.
    pub same_command: bool,
}

impl Interval {
    /// Weighs the length by foot points against the set point's own `travel`, where they may differ: beside the path
    /// (`off`) or across segments. Beside the path, on one motion command (the chord of merged blocks), the set
    /// point moves straight and its feet leap from block to block; at a corner feet run further than the set
    /// point; at a reversal they are ambiguous.
    pub fn judge(&mut self, travel: f64, off: bool, same_command: bool, slowness: f64) {
        if off && same_command {
            self.length = travel;
            self.programmed_s = travel * slowness;
        }
        self.same_command = same_command;
        self.certain = self.length.min(travel);
        self.unambiguous = (same_command || !off) && self.length - self.certain <= 1e-3 * self.length;
    }
}

/// Share of F times override that counts as reached.
const REACHED: f64 = 0.99;

/// `feed` of design 3.2; None where no feed motion was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FeedSummary {
    /// Share of feed motion time at 99 % or more of F times override, %.
    pub programmed_reached_pct: Option<f64>,
    /// Most by which path speed exceeded F times override, %; 0 if it never did.
    pub max_over_pct: Option<f64>,
    /// Feed motion, rapid motion and standstill, s.
    pub feed_s: f64,
    pub rapid_s: f64,
    pub standstill_s: f64,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct FeedCheck {
    intervals: u64,
    reached: u64,
    rapid: u64,
    still: u64,
    over: f64,
}

impl FeedCheck {
    #[inline]
    pub fn add(&mut self, interval: &Interval) {
        let allowed = interval.time_s * interval.factor;
        if interval.length <= 0.0 || allowed <= 0.0 {
            self.still += 1;
        } else if interval.rapid {
            self.rapid += 1;
        } else {
            self.intervals += 1;
            self.reached += u64::from(interval.programmed_s >= REACHED * allowed);
            // divisions only for what may be a new maximum
            if interval.programmed_s > (1.0 + self.over) * allowed {
                let certain_s = interval.programmed_s * (interval.certain / interval.length).min(1.0);
                self.over = self.over.max(certain_s / allowed - 1.0);
            }
        }
    }

    pub fn summary(&self, sample_time_s: f64) -> FeedSummary {
        let measured = self.intervals > 0;
        FeedSummary {
            programmed_reached_pct: measured.then(|| 100.0 * self.reached as f64 / self.intervals as f64),
            max_over_pct: measured.then_some(100.0 * self.over),
            feed_s: self.intervals as f64 * sample_time_s,
            rapid_s: self.rapid as f64 * sample_time_s,
            standstill_s: self.still as f64 * sample_time_s,
        }
    }
}

/// `override` of design 3.2 without the schedule itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OverrideSummary {
    /// Largest set-point deviation less `merged.max_mm` while the factor was not 1.
    pub path_change_mm: f64,
    /// Path speed against factor times planned speed, where both are steady; None where they never were.
    pub velocity_ratio_error_pct: Option<f64>,
    /// The effective factor reached each scheduled one within TROVRST times the change, and stayed.
    pub settling_ok: bool,
    /// Longest time from a scheduled change to its factor, s, and what TROVRST allows for that change; None without one.
    pub settling_s: Option<(f64, f64)>,
}

/// Samples that a change may take beyond TROVRST times its size: command latency (design D2) and rounding.
const LATENCY_SAMPLES: f64 = 4.0;
const SAME_FACTOR: f64 = 1e-9;

/// Checks the effective override against its schedule.
#[derive(Clone, Debug)]
pub struct OverrideCheck {
    /// Machine seconds, factor; in order of time.
    schedule: Vec<(f64, f64)>,
    trovrst_s: f64,
    sample_time_s: f64,
    step: usize,
    settled_by_s: f64,
    violated: bool,
    changed_max: f64,
    /// Planned speeds of the last three samples, the latest first, and how many had the same factor.
    planned: [f64; 3],
    factor: f64,
    same_factor: u32,
    /// Length of the last interval, if it is unambiguous, and whether it stayed on one command.
    length: f64,
    same_command: bool,
    ratio_error: Option<f64>,
    /// A change on its way: when it began and what it may take; and the one that took most of that.
    change: Option<(f64, f64)>,
    slowest: Option<(f64, f64)>,
}

impl OverrideCheck {
    pub fn new(schedule: &[(f64, f64)], trovrst_s: f64, sample_time_s: f64) -> Self {
        let schedule = if schedule.is_empty() { vec![(0.0, 1.0)] } else { schedule.to_vec() };
        OverrideCheck {
            schedule,
            trovrst_s,
            sample_time_s,
            step: 0,
            settled_by_s: 0.0,
            violated: false,
            changed_max: 0.0,
            planned: [0.0; 3],
            factor: f64::NAN,
            same_factor: 0,
            length: 0.0,
            same_command: false,
            ratio_error: None,
            change: None,
            slowest: None,
        }
    }

    #[inline]
    pub fn add(&mut self, time_s: f64, interval: &Interval, planned: f64, setpoint_deviation: f64) {
        while let Some(&(at, factor)) = self.schedule.get(self.step + 1).filter(|&&(at, _)| at <= time_s) {
            let change = (factor - self.schedule[self.step].1).abs();
            // changes that follow faster than the ramp add up
            let from = self.settled_by_s.max(at);
            self.settled_by_s = from + change * self.trovrst_s + LATENCY_SAMPLES * self.sample_time_s;
            self.step += 1;
            self.change = Some((at, self.settled_by_s - at));
        }
        self.time_change(time_s, interval.factor);
        // before the first motion the factor may still be on its way
        if interval.length > 0.0 && time_s > self.settled_by_s {
            // a rapid runs at no more than the rapid override, and the feed override returns after it (design D30)
            let wanted = self.schedule[self.step].1;
            let fits = interval.factor >= wanted.min(1.0) - SAME_FACTOR && interval.factor <= wanted + SAME_FACTOR;
            self.violated |= !fits;
        }
        if interval.factor != 1.0 {
            self.changed_max = self.changed_max.max(setpoint_deviation);
        }
        self.same_factor = if interval.factor == self.factor { self.same_factor + 1 } else { 1 };
        self.factor = interval.factor;
        self.compare_speeds(planned);
        self.planned = [planned, self.planned[0], self.planned[1]];
        self.length = if interval.unambiguous { interval.length } else { 0.0 };
        self.same_command = interval.same_command;
    }

    /// How long a change takes until its factor is there.
    #[inline]
    fn time_change(&mut self, time_s: f64, factor: f64) {
        let Some((at, allowed)) = self.change else { return };
        if (factor - self.schedule[self.step].1).abs() <= SAME_FACTOR {
            let taken = time_s - at;
            if self.slowest.is_none_or(|(slow, room)| taken * room > slow * allowed) {
                self.slowest = Some((taken, allowed));
            }
            self.change = None;
        }
    }

    /// Judges the last interval when planned speed changes evenly before, in and after it: then its mean is known.
    #[inline]
    fn compare_speeds(&mut self, after: f64) {
        let [end, start, before] = self.planned;
        let mean = 0.5 * (start + end);
        let bend = (before - 2.0 * start + end).abs() + (start - 2.0 * end + after).abs();
        let standing = before <= 0.0 || after <= 0.0 || self.length <= 0.0 || self.factor <= 0.0;
        if bend <= 1e-7 * mean && self.same_factor >= 4 && !standing {
            let excess = self.length / (self.factor * self.sample_time_s * mean) - 1.0;
            // between commands planned speed may dip and recover within the interval
            let error = if self.same_command { excess.abs() } else { excess.max(0.0) };
            if self.ratio_error.is_none_or(|worst| error > worst) {
                self.ratio_error = Some(error);
            }
        }
    }

    pub fn summary(&self, merged_max_mm: f64) -> OverrideSummary {
        OverrideSummary {
            path_change_mm: (self.changed_max - merged_max_mm).max(0.0),
            velocity_ratio_error_pct: self.ratio_error.map(|e| 100.0 * e),
            settling_ok: !self.violated,
            settling_s: self.slowest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TA: f64 = 1e-3;

    /// Runs a check over samples of (time, factor, planned speed) with the path speed that belongs to them.
    fn check(schedule: &[(f64, f64)], trovrst_s: f64, sample: impl Fn(f64) -> (f64, f64, f64)) -> OverrideSummary {
        let mut check = OverrideCheck::new(schedule, trovrst_s, TA);
        for k in 0..3000u32 {
            let time_s = f64::from(k + 1) * TA;
            let (factor, planned, speed) = sample(time_s);
            let length = speed * TA;
            let interval = Interval {
                time_s: TA,
                factor,
                length,
                programmed_s: length / planned,
                certain: length,
                rapid: false,
                unambiguous: true,
                same_command: true,
            };
            check.add(time_s, &interval, planned, 0.0);
        }
        check.summary(0.0)
    }

    /// From 1 to 0.5 at 1 s, over `ramp_s`.
    fn ramp(time_s: f64, ramp_s: f64) -> f64 {
        1.0 - 0.5 * ((time_s - 1.0) / ramp_s).clamp(0.0, 1.0)
    }

    #[test]
    fn a_ramp_with_trovrst_is_settled_and_a_slower_one_is_not() {
        let schedule = [(0.0, 1.0), (1.0, 0.5)];
        let run = |ramp_s: f64| check(&schedule, 0.5, move |t| (ramp(t, ramp_s), 10.0, 10.0 * ramp(t, ramp_s)));
        assert!(run(0.25).settling_ok);
        let (taken, allowed) = run(0.25).settling_s.unwrap();
        assert!((taken - 0.25).abs() < 2.0 * TA && (allowed - 0.25).abs() < 5.0 * TA, "{taken} {allowed}");
        assert!(!run(0.26).settling_ok);
        assert!(run(0.25).velocity_ratio_error_pct.unwrap() < 1e-9);
        assert!(!check(&schedule, 0.5, |_| (1.0, 10.0, 10.0)).settling_ok, "a change that never came");
    }

    #[test]
    fn speed_that_does_not_follow_the_factor_is_found_with_its_size() {
        let schedule = [(0.0, 1.0), (1.0, 0.5)];
        let slow = check(&schedule, 0.5, |t| (ramp(t, 0.25), 10.0, 9.8 * ramp(t, 0.25)));
        assert!((slow.velocity_ratio_error_pct.unwrap() - 2.0).abs() < 1e-6, "{slow:?}");
        // even acceleration is judged by the mean of its ends
        let speeding = check(&[], 0.0, |t| (1.0, 5.0 + t, 5.0 + t - 0.5 * TA));
        assert!(speeding.velocity_ratio_error_pct.unwrap() < 1e-6, "{speeding:?}");
    }
}
