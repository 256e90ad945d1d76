//! Velocity profiles along a path (chapter 2.2): planned once in closed form, then asked at any time.
//!
//! Lengths in path units (mm), velocities and accelerations per second, times in seconds of the
//! profile clock. A plan is data; [`Profile::at`] is a pure function of time.

/// A stretch of constant mean acceleration. With `flank_t` > 0 its acceleration rises and falls
/// linearly over that time at both ends (4.4.76.1); time, length and end velocity stay the same.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ramp {
    /// Profile time at which the ramp begins, and its duration.
    pub begin_t: f64,
    pub duration_t: f64,
    /// Path coordinate and velocity at its begin.
    pub s0: f64,
    pub v0: f64,
    /// Mean acceleration.
    pub a: f64,
    pub flank_t: f64,
}

impl Ramp {
    /// Path coordinate and velocity `t` seconds after the begin of the ramp.
    #[inline]
    pub fn at(&self, t: f64) -> (f64, f64) {
        if self.flank_t > 0.0 {
            self.shaped_at(t)
        } else {
            (self.s0 + (self.v0 + 0.5 * self.a * t) * t, self.v0 + self.a * t)
        }
    }
    pub fn end_s(&self) -> f64 {
        self.s0 + (self.v0 + 0.5 * self.a * self.duration_t) * self.duration_t
    }
    pub fn end_v(&self) -> f64 {
        self.v0 + self.a * self.duration_t
    }
    /// Acceleration `t` seconds after the begin.
    pub fn acceleration(&self, t: f64) -> f64 {
        if self.flank_t <= 0.0 {
            return self.a;
        }
        let peak = self.a * self.duration_t / (self.duration_t - self.flank_t);
        peak * (t.min(self.duration_t - t) / self.flank_t).clamp(0.0, 1.0)
    }
    /// The S shape: the mean acceleration needs the peak a(1 + jerkrel), each flank j/(1 + j) of the time.
    fn shaped_at(&self, t: f64) -> (f64, f64) {
        let (flank, duration) = (self.flank_t, self.duration_t);
        let peak = self.a * duration / (duration - flank);
        let jerk = peak / flank;
        if t < flank {
            (self.s0 + (self.v0 + jerk * t * t / 6.0) * t, self.v0 + 0.5 * jerk * t * t)
        } else if t <= duration - flank {
            let (s, v) = (self.s0 + (self.v0 + jerk * flank * flank / 6.0) * flank, self.v0 + 0.5 * peak * flank);
            let u = t - flank;
            (s + (v + 0.5 * peak * u) * u, v + peak * u)
        } else {
            let left = duration - t;
            let v = self.end_v();
            (self.end_s() - (v - jerk * left * left / 6.0) * left, v - 0.5 * jerk * left * left)
        }
    }
}

/// What a profile is planned from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Path coordinates of start and target; `to >= from`.
    pub from: f64,
    pub to: f64,
    /// Momentary velocity at the start, >= 0.
    pub start_v: f64,
    /// Programmed path velocity and acceleration, > 0.
    pub max_v: f64,
    pub acc: f64,
    /// Target velocity; negative: overshoot, reverse, pass the target again (2.2.2).
    pub target_v: f64,
    /// Shape of the ramps 0..1, 0 for trapezoids.
    pub jerkrel: f64,
}

const RAMPS: usize = 3;

/// Up to three ramps, one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Profile {
    ramps: [Ramp; RAMPS],
    count: usize,
    /// Duration of the whole profile.
    pub end_t: f64,
    /// Path coordinate at its end.
    pub end_s: f64,
    /// Velocity after its end: the target velocity, even where it is reached by a jump.
    pub end_v: f64,
}

impl Profile {
    /// Path coordinate and velocity at profile time `t`; at the end exactly the target.
    #[inline]
    pub fn at(&self, t: f64) -> (f64, f64) {
        if t >= self.end_t {
            return (self.end_s, self.end_v);
        }
        let mut ramp = &self.ramps[0];
        for next in &self.ramps[1..self.count] {
            if t < next.begin_t {
                break;
            }
            ramp = next;
        }
        ramp.at(t - ramp.begin_t)
    }
    /// What it does at profile time `t`: 0 accelerate, 1 keep its velocity, 2 brake.
    #[inline]
    pub fn phase(&self, t: f64) -> usize {
        let mut a = self.ramps[0].a;
        for next in &self.ramps[1..] {
            // those that are not used begin at 0 and have acceleration 0
            a = if t >= next.begin_t && next.duration_t > 0.0 { next.a } else { a };
        }
        usize::from(a <= 0.0) + usize::from(a < 0.0)
    }
    pub fn ramps(&self) -> &[Ramp] {
        &self.ramps[..self.count]
    }
    /// Velocity directly after the start (the start velocity may have been set by a jump).
    pub fn start_v(&self) -> f64 {
        if self.count == 0 { self.end_v } else { self.ramps[0].v0 }
    }
    /// Highest velocity inside the profile.
    pub fn peak_v(&self) -> f64 {
        self.ramps().iter().map(|r| r.v0.max(r.end_v())).fold(0.0, f64::max)
    }

    /// A spooled MOVE profile with every special case of chapter 2.2.2.
    pub fn spooled(r: &Request) -> Profile {
        // A start above the maximum is set to it by a jump.
        let start_v = r.start_v.min(r.max_v);
        let profile = if r.target_v < 0.0 { Self::reversing(r, start_v) } else { Self::forward(r, start_v) };
        profile.checked(r.from)
    }

    fn forward(r: &Request, start_v: f64) -> Profile {
        let length = (r.to - r.from).max(0.0);
        let gain_v2 = 2.0 * r.acc * length;
        // Too short to accelerate: the target velocity is lowered. Above the maximum: a jump at the end.
        let wanted_v = r.target_v.min(r.max_v);
        let end_v = if wanted_v * wanted_v > start_v * start_v + gain_v2 {
            (start_v * start_v + gain_v2).sqrt()
        } else {
            wanted_v
        };
        // Too short to brake: the start velocity is lowered.
        let start_v =
            if start_v * start_v > end_v * end_v + gain_v2 { (end_v * end_v + gain_v2).sqrt() } else { start_v };
        let after_v = if end_v >= r.max_v { r.target_v } else { end_v };
        Self::three_ramps(r, start_v, end_v, after_v)
    }

    /// The target velocity points backwards: brake behind the target and come back to it.
    fn reversing(r: &Request, start_v: f64) -> Profile {
        let end_v = r.target_v.max(-r.max_v);
        let brake_s = (start_v * start_v - end_v * end_v) / (2.0 * r.acc);
        if brake_s <= r.to - r.from {
            return Self::three_ramps(r, start_v, end_v, r.target_v);
        }
        // Already too fast: brake at once, then run back to the target at the target velocity.
        let mut profile = Profile { end_s: r.to, end_v: r.target_v, ..Profile::default() };
        profile.push(r.from, start_v, end_v, -r.acc, r.jerkrel);
        let back_s = r.from + brake_s - r.to;
        profile.hold_speed(end_v, back_s / -end_v);
        profile
    }

    /// Accelerate, cruise, brake; a triangle where the maximum is not reached.
    fn three_ramps(r: &Request, start_v: f64, end_v: f64, after_v: f64) -> Profile {
        let length = (r.to - r.from).max(0.0);
        let top_v2 = r.acc * length + 0.5 * (start_v * start_v + end_v * end_v);
        let max_v2 = r.max_v * r.max_v;
        let peak_v = if top_v2 < max_v2 { top_v2.sqrt().max(start_v).max(end_v) } else { r.max_v };
        let cruise_s = length - (2.0 * peak_v * peak_v - start_v * start_v - end_v * end_v) / (2.0 * r.acc);
        let mut profile = Profile { end_s: r.to, end_v: after_v, ..Profile::default() };
        profile.push(r.from, start_v, peak_v, r.acc, r.jerkrel);
        if top_v2 > max_v2 && cruise_s > 0.0 {
            profile.hold_speed_from(r.from, peak_v, cruise_s / peak_v);
        }
        profile.push(r.from, peak_v, end_v, -r.acc, r.jerkrel);
        profile
    }

    /// A profile of direct mode, from the momentary velocity (negative: away from the target): jogs (2.2.1) and
    /// direct moves (2.2.2). A start above the maximum brakes by a ramp. Where the way is too short to brake, a
    /// jog jumps at its end, a move at its start.
    pub fn direct(r: &Request, brake_acc: f64, is_jog: bool) -> Profile {
        let (length, v0) = (r.to - r.from, r.start_v);
        let reach_v2 = v0 * v0 + 2.0 * r.acc * length;
        let wanted_v = r.target_v.clamp(-r.max_v, r.max_v);
        let end_v = if wanted_v > 0.0 { wanted_v.min(reach_v2.sqrt()) } else { wanted_v };
        let after_v = if end_v == wanted_v { r.target_v } else { end_v };
        let mut profile = Profile { end_s: r.to, end_v: after_v, ..Profile::default() };
        let brake_s = (v0 * v0 - end_v * end_v) / (2.0 * brake_acc);
        if v0 > 0.0 && brake_s > length {
            profile.too_fast(r, end_v, brake_s, brake_acc, is_jog);
            return profile.checked(r.from);
        }
        let shares = 1.0 / (2.0 * r.acc) + 1.0 / (2.0 * brake_acc);
        let top_v2 = (length + v0 * v0 / (2.0 * r.acc) + end_v * end_v / (2.0 * brake_acc)) / shares;
        let peak_v = if top_v2 < r.max_v * r.max_v { top_v2.sqrt() } else { r.max_v };
        let first_acc = if v0 > peak_v { -brake_acc } else { r.acc };
        profile.push(r.from, v0, peak_v, first_acc, r.jerkrel);
        let braking_s = (peak_v * peak_v - end_v * end_v) / (2.0 * brake_acc);
        let cruise_s = r.to - profile.next_s(r.from) - braking_s;
        if top_v2 >= r.max_v * r.max_v && cruise_s > 0.0 {
            profile.hold_speed_from(r.from, peak_v, cruise_s / peak_v);
        }
        profile.push(r.from, peak_v, end_v, -brake_acc, r.jerkrel);
        profile.checked(r.from)
    }

    /// The way is too short to brake to `end_v`.
    fn too_fast(&mut self, r: &Request, end_v: f64, brake_s: f64, brake_acc: f64, is_jog: bool) {
        let spent_v2 = 2.0 * brake_acc * (r.to - r.from);
        if end_v < 0.0 {
            self.push(r.from, r.start_v, end_v, -brake_acc, r.jerkrel);
            self.hold_speed(end_v, (r.from + brake_s - r.to) / -end_v);
        } else if is_jog {
            self.push(r.from, r.start_v, (r.start_v * r.start_v - spent_v2).sqrt(), -brake_acc, 0.0);
        } else {
            self.push(r.from, (end_v * end_v + spent_v2).sqrt(), end_v, -brake_acc, r.jerkrel);
        }
    }

    /// From `start_v` to `max_v` and on for ever.
    pub fn endless(start_v: f64, max_v: f64, acc: f64, brake_acc: f64, jerkrel: f64) -> Profile {
        let mut profile = Profile { end_s: f64::INFINITY, end_v: max_v, ..Profile::default() };
        profile.push(0.0, start_v, max_v, if start_v > max_v { -brake_acc } else { acc }, jerkrel);
        profile.hold_speed_from(0.0, max_v, f64::INFINITY);
        profile
    }

    /// Braking along a planned contour (design D17) with `brake_acc`, but harder where the plan asks for less
    /// than that leaves at `to` (`limit_v2`, squared). A plan is concave in v² over the path, so this is never
    /// faster than planned; a stop before `to` has the shape of `jerkrel`. Returns the profile, and whether it stands
    /// still before `to`.
    pub fn stopping(from: f64, to: f64, start_v: f64, brake_acc: f64, limit_v2: f64, jerkrel: f64) -> (Profile, bool) {
        let start_v2 = start_v * start_v;
        let stop_s = from + start_v2 / (2.0 * brake_acc);
        let mut profile = Profile::default();
        if stop_s < to {
            profile.end_s = stop_s;
            profile.push(from, start_v, 0.0, -brake_acc, jerkrel);
            return (profile.checked(from), true);
        }
        let acc = brake_acc.max((start_v2 - limit_v2) / (2.0 * (to - from)));
        (profile.end_s, profile.end_v) = (to, (start_v2 - 2.0 * acc * (to - from)).max(0.0).sqrt());
        profile.push(from, start_v, profile.end_v, -acc, 0.0);
        (profile.checked(from), false)
    }

    /// Braking while running backwards (the end of an overshoot): `v` < 0.
    pub fn turning_back(from: f64, v: f64, brake_acc: f64) -> Profile {
        let mut profile = Profile { end_s: from - v * v / (2.0 * brake_acc), ..Profile::default() };
        profile.push(from, v, 0.0, brake_acc, 0.0);
        profile.checked(from)
    }

    /// In debug builds: verified by integration (profile_check.rs).
    fn checked(self, from: f64) -> Profile {
        debug_assert!(self.is_integral(from), "not the integral of its acceleration: {self:?} from {from}");
        self
    }

    fn next_s(&self, from: f64) -> f64 {
        if self.count == 0 { from } else { self.ramps[self.count - 1].end_s() }
    }
    fn push(&mut self, from: f64, v0: f64, v1: f64, acc: f64, jerkrel: f64) {
        let duration_t = (v1 - v0) / acc;
        if duration_t > 0.0 {
            let flank_t = duration_t * jerkrel / (1.0 + jerkrel);
            self.add(Ramp { begin_t: self.end_t, duration_t, s0: self.next_s(from), v0, a: acc, flank_t });
        }
    }
    fn hold_speed_from(&mut self, from: f64, v: f64, duration_t: f64) {
        if duration_t > 0.0 {
            self.add(Ramp { begin_t: self.end_t, duration_t, s0: self.next_s(from), v0: v, a: 0.0, flank_t: 0.0 });
        }
    }
    fn hold_speed(&mut self, v: f64, duration_t: f64) {
        self.hold_speed_from(0.0, v, duration_t);
    }
    fn add(&mut self, ramp: Ramp) {
        self.ramps[self.count] = ramp;
        self.count += 1;
        self.end_t += ramp.duration_t;
    }
}
