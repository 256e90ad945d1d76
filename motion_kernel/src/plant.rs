//! Drive and mechanics of an axis (design D8): what the motor command does to the position.

use crate::controller::FULL_SCALE;
use crate::machine::{Axis, DriveControl};

/// A servo drive with its mechanics; the encoder sits on the motor side of the backlash and counts whole counts.
/// The motor command holds for a sample, over which every step is solved in closed form.
#[derive(Clone, Copy, Debug)]
pub struct ServoPlant {
    kind: Kind,
    ta_s: f64,
    lag_s: f64,
    /// exp(-TA / lag): what is left of a difference after a sample.
    decay: f64,
    half_backlash: f64,
    counts_per_unit: f64,
    velocity: f64,
    motor: f64,
    load: f64,
    /// Time constant of running out without power.
    coast_s: f64,
    blocked: bool,
    unpowered: bool,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// The command is a speed: first-order lag, acceleration bounded.
    Velocity { speed_per_digit: f64, most_acc: f64 },
    /// The command is a torque, given as acceleration of the load inertia: friction, damping, highest speed.
    Torque { acc_per_digit: f64, torque: f64, friction: f64, damping: f64, top_speed: f64 },
}

impl ServoPlant {
    /// At rest at `start` (axis units), in the middle of the backlash.
    pub fn new(axis: &Axis, ta_s: f64, start: f64) -> Self {
        let plant = &axis.plant;
        let sign = if plant.reversed != axis.equipment.port.inverted { -1.0 } else { 1.0 };
        let most_acc =
            if plant.full_acceleration > 0.0 { plant.full_acceleration / plant.inertia } else { f64::INFINITY };
        let kind = match plant.control {
            DriveControl::Velocity => {
                Kind::Velocity { speed_per_digit: sign * plant.full_speed / FULL_SCALE, most_acc }
            }
            DriveControl::Torque => Kind::Torque {
                acc_per_digit: sign * most_acc / FULL_SCALE,
                torque: 0.0,
                friction: plant.friction / plant.inertia,
                damping: plant.damping / plant.inertia,
                top_speed: plant.full_speed,
            },
        };
        ServoPlant {
            kind,
            ta_s,
            lag_s: plant.lag_s,
            decay: if plant.lag_s > 0.0 { (-ta_s / plant.lag_s).exp() } else { 0.0 },
            half_backlash: plant.backlash / 2.0,
            counts_per_unit: axis.counts_per_unit,
            velocity: 0.0,
            motor: start,
            load: start,
            coast_s: plant.coast_s,
            blocked: false,
            unpowered: false,
        }
    }

    /// One sample at a motor command in digits.
    #[inline]
    pub fn step(&mut self, digits: f64) {
        if self.blocked || self.unpowered {
            return self.step_disturbed();
        }
        match self.kind {
            Kind::Velocity { speed_per_digit, most_acc } => self.step_velocity(digits * speed_per_digit, most_acc),
            Kind::Torque { .. } => self.step_torque(digits),
        }
        self.load = self.load.clamp(self.motor - self.half_backlash, self.motor + self.half_backlash);
    }

    /// Jammed mechanics do not move; without power a velocity drive runs out and a torque drive has no torque.
    #[cold]
    fn step_disturbed(&mut self) {
        if self.blocked {
            self.velocity = 0.0;
            return;
        }
        match &mut self.kind {
            Kind::Velocity { .. } => {
                let decay = (-self.ta_s / self.coast_s).exp();
                self.motor += self.velocity * self.coast_s * (1.0 - decay);
                self.velocity *= decay;
            }
            Kind::Torque { torque, .. } => {
                *torque = 0.0;
                self.step_torque(0.0);
            }
        }
        self.load = self.load.clamp(self.motor - self.half_backlash, self.motor + self.half_backlash);
    }

    #[inline]
    fn step_velocity(&mut self, wanted: f64, most_acc: f64) {
        let behind = self.velocity - wanted;
        if behind.abs() > most_acc * self.lag_s {
            return self.step_saturated(wanted, most_acc);
        }
        self.motor += wanted * self.ta_s + behind * self.lag_s * (1.0 - self.decay);
        self.velocity = wanted + behind * self.decay;
    }

    /// The drive accelerates as fast as it can until its lag asks for less.
    #[cold]
    fn step_saturated(&mut self, wanted: f64, most_acc: f64) {
        let behind = wanted - self.velocity;
        let acc = most_acc.copysign(behind);
        let bounded_t = ((behind.abs() / most_acc) - self.lag_s).min(self.ta_s);
        self.motor += (self.velocity + 0.5 * acc * bounded_t) * bounded_t;
        self.velocity += acc * bounded_t;
        let rest_t = self.ta_s - bounded_t;
        if rest_t > 0.0 {
            let left = self.velocity - wanted;
            let decay = if self.lag_s > 0.0 { (-rest_t / self.lag_s).exp() } else { 0.0 };
            self.motor += wanted * rest_t + left * self.lag_s * (1.0 - decay);
            self.velocity = wanted + left * decay;
        }
    }

    fn step_torque(&mut self, digits: f64) {
        let Kind::Torque { acc_per_digit, torque, friction, damping, top_speed } = &mut self.kind else { return };
        let wanted = digits * *acc_per_digit;
        let behind = *torque - wanted;
        let drive_acc = wanted + behind * self.lag_s / self.ta_s * (1.0 - self.decay); // mean over the sample
        *torque = wanted + behind * self.decay;
        let (friction, damping, top_speed) = (*friction, *damping, *top_speed);
        let mut left_t = self.ta_s;
        // a sample has at most three phases: to a stop, away from it, at the highest speed
        for _ in 0..3 {
            let standing = self.velocity == 0.0;
            if left_t <= 0.0 || standing && drive_acc.abs() <= friction {
                break;
            }
            let direction = if standing { drive_acc.signum() } else { self.velocity.signum() };
            let acc = drive_acc - friction * direction;
            let (v, s, t) = coast(self.velocity, acc, damping, left_t);
            (self.velocity, self.motor, left_t) = (v, self.motor + s, left_t - t);
        }
        self.velocity = self.velocity.clamp(-top_speed, top_speed);
    }

    /// Another number of counts per axis unit, `ratio` times as many units for a count (gear.rs).
    pub(crate) fn convert(&mut self, per_unit: f64, ratio: f64) {
        let ServoPlant { kind, half_backlash, counts_per_unit, velocity, motor, load, .. } = self;
        *counts_per_unit = per_unit;
        [half_backlash, velocity, motor, load].into_iter().for_each(|x| *x *= ratio);
        match kind {
            Kind::Velocity { speed_per_digit, most_acc } => {
                (*speed_per_digit, *most_acc) = (*speed_per_digit * ratio, *most_acc * ratio);
            }
            Kind::Torque { acc_per_digit, torque, friction, top_speed, .. } => {
                [acc_per_digit, torque, friction, top_speed].into_iter().for_each(|x| *x *= ratio);
            }
        }
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
    /// What the encoder says at a fraction of the sample that begins here, at a motor command in digits.
    pub(crate) fn counts_at(mut self, digits: f64, fraction: f64) -> i64 {
        if fraction > 0.0 {
            self.ta_s *= fraction;
            self.decay = if self.lag_s > 0.0 { (-self.ta_s / self.lag_s).exp() } else { 0.0 };
            self.step(digits);
        }
        self.counts()
    }
    /// Speed of the motor, axis units/s.
    pub fn velocity(&self) -> f64 {
        self.velocity
    }
    /// Position of the motor, axis units.
    pub fn motor(&self) -> f64 {
        self.motor
    }
    /// The mechanics jam (true) or come free.
    pub fn block(&mut self, blocked: bool) {
        self.blocked = blocked;
    }
    /// The drive has power (true) or lets the motor run out.
    pub fn power(&mut self, on: bool) {
        self.unpowered = !on;
    }
    /// Something from outside moves motor and load by a distance in axis units.
    pub fn push(&mut self, distance: f64) {
        (self.motor, self.load) = (self.motor + distance, self.load + distance);
    }
}

/// dv/dt = acc - damping * v from speed `v0` for `t`, or until the speed becomes 0: speed, distance, time used.
fn coast(v0: f64, acc: f64, damping: f64, t: f64) -> (f64, f64, f64) {
    let stop_t = if v0 == 0.0 || v0 * acc >= 0.0 {
        f64::INFINITY
    } else if damping > 0.0 {
        (1.0 - damping * v0 / acc).ln() / damping
    } else {
        -v0 / acc
    };
    let used_t = stop_t.min(t);
    let (v, s) = if damping > 0.0 {
        let (end_v, decay) = (acc / damping, (-damping * used_t).exp());
        (end_v + (v0 - end_v) * decay, end_v * used_t + (v0 - end_v) * (1.0 - decay) / damping)
    } else {
        (v0 + acc * used_t, (v0 + 0.5 * acc * used_t) * used_t)
    };
    (if stop_t <= t { 0.0 } else { v }, s, used_t)
}

/// A stepper with its pulse generator: the step output toggles every |mcp| + 1 clock ticks, so that
/// f = CLOCK / 2 / (|mcp| + 1) (errata 4.4.88); the sign of mcp is the direction, 0 = no pulses.
#[derive(Clone, Copy, Debug)]
pub struct Stepper {
    ticks_per_sample: f64,
    /// Clock ticks since the last step.
    phase: f64,
    pub mcp: i32,
    /// Steps that were output.
    pub counts: i64,
    /// Steps that the motor did not make.
    lost: i64,
    pub(crate) blocked: bool,
    pub(crate) unpowered: bool,
}

/// Largest delay that can be written and that is ever reported (errata 4.4.162).
pub const MOST_DELAY_WRITTEN: i32 = 1_048_574;
pub const MOST_DELAY: i32 = 1_048_575;

impl Stepper {
    pub fn new(clock_hz: f64, ta_s: f64, counts: i64) -> Self {
        Stepper {
            ticks_per_sample: clock_hz * ta_s,
            phase: 0.0,
            mcp: 0,
            counts,
            lost: 0,
            blocked: false,
            unpowered: false,
        }
    }
    /// One sample of pulses at the delay `mcp`.
    pub fn run(&mut self) {
        if self.mcp == 0 {
            self.phase = 0.0;
            return;
        }
        let period = 2.0 * (f64::from(self.mcp.abs()) + 1.0);
        self.phase += self.ticks_per_sample;
        let steps = (self.phase / period).floor();
        self.phase -= steps * period;
        self.output(steps as i64 * i64::from(self.mcp.signum()));
    }
    #[inline]
    fn output(&mut self, steps: i64) {
        self.counts = self.counts.saturating_add(steps);
        if self.blocked || self.unpowered {
            self.lost = self.lost.saturating_add(steps);
        }
    }
    /// Where the motor stands, steps.
    #[inline]
    pub fn motor(&self) -> i64 {
        self.counts.saturating_sub(self.lost)
    }
    /// Something from outside turns the motor.
    pub fn push(&mut self, steps: i64) {
        self.lost = self.lost.saturating_sub(steps);
    }
    /// As many pulses as lead to `target` within the sample; mcp is the delay between them.
    #[inline]
    pub fn follow(&mut self, target: i64) {
        let steps = target.saturating_sub(self.counts);
        self.output(steps);
        self.mcp = if steps == 0 { 0 } else { self.delay_of(steps) };
    }
    fn delay_of(&self, steps: i64) -> i32 {
        let delay = (self.ticks_per_sample / (2.0 * steps.unsigned_abs() as f64) - 1.0).round();
        delay.clamp(1.0, f64::from(MOST_DELAY)) as i32 * steps.signum() as i32
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
    use crate::machine::{self, Machine};

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

    /// Many small steps of the same drive, as an oracle for the closed forms.
    fn integrated(axis: &machine::Axis, digits: &[f64]) -> f64 {
        let p = &axis.plant;
        let n = 20_000;
        let (dt, mut x, mut v, mut torque) = (TA / f64::from(n), 0.0, 0.0_f64, 0.0);
        for d in digits {
            let command = d / FULL_SCALE * p.full_acceleration / p.inertia;
            let before = torque;
            torque = command + (before - command) * (-TA / p.lag_s).exp();
            let mean = command + (before - command) * p.lag_s / TA * (1.0 - (-TA / p.lag_s).exp());
            for _ in 0..n {
                let slip = if v == 0.0 { mean.signum() } else { v.signum() };
                if v == 0.0 && mean.abs() <= p.friction / p.inertia {
                    continue;
                }
                let next = v + (mean - slip * p.friction / p.inertia - p.damping / p.inertia * v) * dt;
                v = if v != 0.0 && next * v < 0.0 { 0.0 } else { next };
                x += v * dt;
            }
        }
        x
    }

    #[test]
    fn a_torque_drive_with_friction_equals_its_integration() {
        let mut axis = Machine::builtin().axes[0].clone();
        axis.plant = machine::Plant {
            control: DriveControl::Torque,
            lag_s: 0.0005,
            full_acceleration: 4000.0,
            inertia: 1.5,
            friction: 300.0,
            damping: 8.0,
            ..axis.plant
        };
        let digits: Vec<f64> = (0..60).map(|n| [30_000.0, -25_000.0, 2_000.0, 0.0][n / 15]).collect();
        let mut plant = ServoPlant::new(&axis, TA, 0.0);
        digits.iter().for_each(|d| plant.step(*d));
        let want = integrated(&axis, &digits);
        assert!((plant.load() - want).abs() < 2e-5, "{} against {want}", plant.load());
    }

    #[test]
    fn friction_holds_a_small_torque() {
        let mut axis = Machine::builtin().axes[0].clone();
        axis.plant.control = DriveControl::Torque;
        (axis.plant.full_acceleration, axis.plant.friction) = (1000.0, 100.0);
        let mut plant = ServoPlant::new(&axis, TA, 0.0);
        (0..100).for_each(|_| plant.step(0.09 * FULL_SCALE));
        assert_eq!((plant.load(), plant.velocity()), (0.0, 0.0));
        (0..100).for_each(|_| plant.step(0.2 * FULL_SCALE));
        assert!(plant.load() > 0.1);
    }

    #[test]
    fn a_velocity_drive_saturates_at_its_torque() {
        let mut axis = Machine::builtin().axes[0].clone();
        (axis.plant.full_acceleration, axis.plant.inertia) = (2000.0, 2.0);
        let mut plant = ServoPlant::new(&axis, TA, 0.0);
        for n in 1..=50 {
            plant.step(FULL_SCALE);
            let t = f64::from(n) * TA;
            assert!((plant.velocity() - 1000.0 * t).abs() < 1e-9 && (plant.load() - 500.0 * t * t).abs() < 1e-9);
        }
        (0..1000).for_each(|_| plant.step(FULL_SCALE));
        assert!((plant.velocity() - axis.plant.full_speed).abs() < 1e-9);
    }

    #[test]
    fn a_blocked_axis_does_not_move() {
        let axis = &Machine::builtin().axes[0];
        let mut plant = ServoPlant::new(axis, TA, 3.0);
        plant.block(true);
        (0..10).for_each(|_| plant.step(10_000.0));
        assert_eq!((plant.load(), plant.velocity()), (3.0, 0.0));
    }

    // shows: pcap.wrmcp.stepper-formula, pcap.wrmcp.stepper-sign, pcap.wrmcp.stepper-zero, pcap.rdmcp.stepper-delay
    #[test]
    fn a_stepper_counts_the_pulses_of_its_clock() {
        for (clock_hz, mcp, want_hz) in [(70e6, 999, 35_000.0), (66.66666e6, 999, 33_333.33), (70e6, -12_499, -2_800.0)]
        {
            let mut stepper = Stepper::new(clock_hz, TA, 0);
            stepper.mcp = mcp;
            let samples = 100_000;
            (0..samples).for_each(|_| stepper.run());
            let seconds = f64::from(samples) * TA;
            assert!((stepper.counts as f64 - want_hz * seconds).abs() <= 1.0, "{} at {mcp}", stepper.counts);
        }
        let mut stepper = Stepper::new(70e6, TA, 5);
        stepper.run();
        assert_eq!(stepper.counts, 5);
    }

    // shows: pcap.rdmcp.stepper-range, pcap.rdmcp.stepper-zero
    #[test]
    fn the_delay_reported_is_that_of_the_pulses() {
        let mut stepper = Stepper::new(66.66666e6, TA, 0);
        stepper.follow(-40);
        let frequency = 66.66666e6 / 2.0 / (f64::from(stepper.mcp.abs()) + 1.0);
        assert!(stepper.mcp < 0 && (frequency * TA - 40.0).abs() < 0.1, "{}", stepper.mcp);
        stepper.follow(-40);
        assert_eq!(stepper.mcp, 0);
        stepper.follow(1_000_000_000);
        assert!(stepper.mcp > 0 && stepper.mcp <= MOST_DELAY);
    }
}
