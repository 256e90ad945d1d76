//! What a position loop does beside the plain case: limits and zero compensation of its motor command, ControllerFlags,
//! SimulationMode, a cut encoder, encoder verification of steppers, and coordinates shifted against the machine.

use crate::controller::Integral;
use crate::machine::{self, Encoder, Port};
use crate::plant::whole;
use crate::position_loop::{Drive, PositionLoop};
use crate::registers::ControllerFlags;

/// Settings of a loop that is not plain.
#[derive(Debug)]
pub(crate) struct Special {
    pub port: Port,
    /// Added to the motor command, digits (resource MCP OFFSET).
    pub mcp_offset: f64,
    pub flags: ControllerFlags,
    /// Dead band of the control deviation, counts (ControllerParams[8][0]).
    pub dead_band: f64,
    /// A gear acts on the axis, and how fast it moves the set point, axis units/s.
    pub follows: bool,
    pub led_v: f64,
    /// SimulationMode (MODEREG bit 24), and the position that is simulated.
    pub simulated: bool,
    pub simulated_counts: i64,
    /// The encoder has no connection.
    pub cut: bool,
    pub encoder: Option<Encoder>,
    /// Steps per count of that encoder.
    pub gfaux: f64,
}

impl Special {
    pub fn new(axis: &machine::Axis) -> Self {
        Special {
            port: axis.equipment.port,
            mcp_offset: 0.0,
            follows: false,
            led_v: 0.0,
            flags: ControllerFlags(0),
            dead_band: 0.0,
            simulated: false,
            simulated_counts: 0,
            cut: false,
            encoder: axis.equipment.encoder,
            gfaux: 1.0,
        }
    }
    pub fn is_needed(&self) -> bool {
        let plain = Port { inverted: self.port.inverted, ..Port::default() };
        self.port != plain
            || self.mcp_offset != 0.0
            || self.follows
            || self.flags.any(ControllerFlags::MoveControl | ControllerFlags::StopControl)
            || self.simulated
            || self.cut
            || self.encoder.is_some_and(|e| e.feedback)
    }
    /// What the integral part may do for a control deviation in counts.
    fn rule(&self, error: f64, travels: bool) -> Integral {
        type F = ControllerFlags;
        let (enable, zero, fix, band) = if travels {
            (F::MoveControl, F::MoveZero, F::MoveFix, F::MoveDeadBand)
        } else {
            (F::StopControl, F::StopZero, F::StopFix, F::StopDeadBand)
        };
        match self.flags {
            flags if !flags.has(enable) => Integral::Free,
            flags if flags.has(zero) => Integral::Zero,
            flags if flags.has(fix) => Integral::Fix,
            flags if flags.has(band) && error.abs() > self.dead_band => Integral::Limited,
            _ => Integral::Free,
        }
    }
    /// Zero compensation and limits of a motor command.
    fn compensated(&self, digits: f64) -> f64 {
        let added = if digits > 0.0 {
            self.port.positive
        } else if digits < 0.0 {
            -self.port.negative
        } else {
            0.0
        };
        (digits + added + self.mcp_offset).clamp(self.port.min, self.port.max)
    }
}

impl PositionLoop {
    /// Changes a setting.
    pub(crate) fn set_special(&mut self, change: impl FnOnce(&mut Special)) {
        change(&mut self.special);
        self.is_special = self.special.is_needed();
    }

    /// SimulationMode: the drive gets no command, the actual position is the set point of the sample before.
    pub(crate) fn simulate(&mut self, on: bool) {
        if on != self.special.simulated {
            let counts = self.counts;
            self.set_special(|special| (special.simulated, special.simulated_counts) = (on, counts));
        }
    }

    #[cold]
    pub(crate) fn step_special(&mut self) {
        let special = &self.special;
        let simulated = special.simulated && self.closed;
        match &mut self.drive {
            Drive::Servo { plant, digits, .. } => {
                plant.step(if special.simulated { 0.0 } else { *digits });
                if !special.cut && !special.simulated {
                    self.counts = plant.counts().saturating_sub(self.encoder_origin);
                }
            }
            Drive::Stepper { target, stepper } => {
                if special.simulated {
                    stepper.mcp = 0;
                } else if self.closed {
                    stepper.follow(*target);
                } else {
                    stepper.run();
                }
                self.counts = stepper.counts.saturating_sub(self.encoder_origin);
            }
        }
        if simulated {
            self.counts = special.simulated_counts;
        } else if special.encoder.is_some_and(|e| e.feedback) && !special.cut {
            self.counts = whole(self.aux() as f64 * special.gfaux).saturating_sub(self.encoder_origin);
        }
    }

    #[cold]
    pub(crate) fn control_special(&mut self, dp: f64, dv: f64, motor_off: f64, travels: bool) {
        let wanted = (dp + self.offset) * self.counts_per_unit;
        let error = wanted - self.counts as f64;
        let special = &mut self.special;
        if special.simulated {
            special.simulated_counts = whole(wanted);
            return;
        }
        match &mut self.drive {
            Drive::Servo { filter, per_sample, velocity, digits, .. } => {
                let v = special.with_gear(dv) * self.counts_per_unit;
                let ahead = filter.ahead(v, (v - *velocity) * *per_sample);
                *velocity = v;
                let range = [special.port.min, special.port.max];
                let output = filter.step_within(error, ahead, range, special.rule(error, travels));
                *digits = special.compensated(output);
                if *digits * motor_off > 0.0 {
                    *digits = 0.0;
                }
                self.command_use.note(*digits);
            }
            Drive::Stepper { target, .. } => {
                let wanted = whole(wanted).saturating_add(self.encoder_origin);
                if wanted.saturating_sub(*target) as f64 * motor_off <= 0.0 {
                    *target = wanted;
                }
            }
        }
    }

    /// Counts of the encoder on the auxiliary channel (register aux of a stepper axis); 0 without one.
    pub fn aux(&self) -> i64 {
        match (&self.drive, self.special.encoder) {
            (Drive::Stepper { stepper, .. }, Some(encoder)) => {
                whole(stepper.motor() as f64 * self.unit_per_count * encoder.counts_per_unit)
            }
            _ => 0,
        }
    }
    /// Following error of a set point against the encoder on the auxiliary channel, axis units; 0 without one.
    pub fn error_aux(&self, set_point: f64) -> f64 {
        if self.special.encoder.is_none() {
            return 0.0;
        }
        let counts = whole(self.aux() as f64 * self.special.gfaux).saturating_sub(self.encoder_origin);
        set_point + self.offset - counts as f64 * self.unit_per_count
    }
    /// Counts of the encoder on the scale of the machine.
    pub(crate) fn machine_counts(&self) -> i64 {
        match &self.drive {
            Drive::Servo { plant, .. } => plant.counts(),
            Drive::Stepper { stepper, .. } => stepper.motor(),
        }
    }
    /// Where the load stands on the scale of the machine, axis units.
    pub(crate) fn machine_position(&self) -> f64 {
        match &self.drive {
            Drive::Servo { plant, .. } => plant.load(),
            Drive::Stepper { stepper, .. } => stepper.motor() as f64 * self.unit_per_count,
        }
    }

    /// Gives the present position another coordinate (wrrp, 4.4.167); nothing moves.
    pub fn set_rp(&mut self, rp: f64) {
        self.shift_counts(self.counts_to(rp));
    }
    /// Gives every position another coordinate, `counts` higher; nothing moves.
    pub(crate) fn shift_counts(&mut self, counts: i64) {
        self.counts = self.counts.saturating_add(counts);
        self.counts_before = self.counts_before.saturating_add(counts);
        self.origin = self.origin.saturating_sub(counts);
        self.encoder_origin = self.encoder_origin.saturating_sub(counts);
        self.special.simulated_counts = self.special.simulated_counts.saturating_add(counts);
    }
    /// Counts at a fraction of the last sample, between those at its begin and end.
    pub(crate) fn counts_between(&self, fraction: f64) -> i64 {
        let way = (self.counts.saturating_sub(self.counts_before)) as f64;
        self.counts_before.saturating_add(whole(way * fraction))
    }
    /// Coordinate of a place on the scale of the machine.
    pub(crate) fn coordinate_of(&self, machine_counts: i64) -> f64 {
        machine_counts.saturating_sub(self.encoder_origin) as f64 * self.unit_per_count
    }
    /// Counts from the present position to a coordinate (axis units).
    pub(crate) fn counts_to(&self, coordinate: f64) -> i64 {
        whole(coordinate * self.counts_per_unit).saturating_sub(self.counts)
    }
    /// Backlash compensation in effect, counts: the motor is sent that much further.
    pub(crate) fn compensation(&self) -> i64 {
        self.encoder_origin.saturating_sub(self.origin)
    }
    pub(crate) fn set_compensation(&mut self, counts: i64) {
        let more = counts.saturating_sub(self.compensation());
        self.encoder_origin = self.encoder_origin.saturating_add(more);
        self.counts = self.counts.saturating_sub(more);
    }

    /// The cable of the encoder breaks, or is mended: the counts between are lost.
    pub(crate) fn cut_encoder(&mut self, cut: bool) {
        if self.special.cut && !cut {
            self.encoder_origin = self.machine_counts().saturating_sub(self.counts);
        }
        self.set_special(|special| special.cut = cut);
    }
    /// The mechanics jam or come free; a stepper loses its steps meanwhile.
    pub(crate) fn block(&mut self, blocked: bool) {
        match &mut self.drive {
            Drive::Servo { plant, .. } => plant.block(blocked),
            Drive::Stepper { stepper, .. } => stepper.blocked = blocked,
        }
    }
    /// The drive has power or not.
    pub(crate) fn power(&mut self, on: bool) {
        match &mut self.drive {
            Drive::Servo { plant, .. } => plant.power(on),
            Drive::Stepper { stepper, .. } => stepper.unpowered = !on,
        }
    }
    /// Something from outside moves the load by a distance in axis units.
    pub(crate) fn push(&mut self, distance: f64) {
        match &mut self.drive {
            Drive::Servo { plant, .. } => plant.push(distance),
            Drive::Stepper { stepper, .. } => stepper.push(whole(distance * self.counts_per_unit)),
        }
    }
}
