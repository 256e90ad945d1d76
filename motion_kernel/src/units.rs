//! Trajectory units PU and TU and encoder counts: every conversion there is (2.3.4, 4.3.2.3, 4.4.11).
//!
//! Inside, positions of linear axes are mm, of rotary axes degrees, path lengths mm, times s. Interpolation commands of
//! the application come in PU and TU; jog commands and axis values in the units of the axis.

use crate::axes::MAX_AXES;
use crate::axis::Axis;
use crate::mcu::Mcu;
use crate::motion::MotionCommand;
use crate::registers::{ErrorReg, ModeReg};

/// Unit of positions (TRU.pu).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PositionUnit {
    #[default]
    Mm,
    Inch,
    M,
    Rev,
    Deg,
    Rad,
    Counts,
    Steps,
}

/// Unit of times (TRU.tu).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TimeUnit {
    #[default]
    Sec,
    Min,
    Tsample,
}

/// Position units in the order of TRU.pu, with their names.
pub const POSITION_UNITS: [(&str, PositionUnit); 8] = [
    ("mm", PositionUnit::Mm),
    ("inch", PositionUnit::Inch),
    ("m", PositionUnit::M),
    ("rev", PositionUnit::Rev),
    ("deg", PositionUnit::Deg),
    ("rad", PositionUnit::Rad),
    ("counts", PositionUnit::Counts),
    ("steps", PositionUnit::Steps),
];

/// Time units in the order of TRU.tu.
pub const TIME_UNITS: [(&str, TimeUnit); 3] =
    [("sec", TimeUnit::Sec), ("min", TimeUnit::Min), ("tsample", TimeUnit::Tsample)];

/// The units of interpolation commands (ctru).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TrajectoryUnits {
    pub pu: PositionUnit,
    pub tu: TimeUnit,
}

impl TimeUnit {
    /// Seconds per unit.
    pub fn seconds(self, ta_s: f64) -> f64 {
        match self {
            TimeUnit::Sec => 1.0,
            TimeUnit::Min => 60.0,
            TimeUnit::Tsample => ta_s,
        }
    }
}

impl PositionUnit {
    /// mm per unit of a translatory unit.
    pub(crate) fn mm(self) -> Option<f64> {
        match self {
            PositionUnit::Mm => Some(1.0),
            PositionUnit::Inch => Some(25.4),
            PositionUnit::M => Some(1000.0),
            _ => None,
        }
    }
    /// Revolutions per unit of a rotary unit.
    fn revolutions(self) -> Option<f64> {
        match self {
            PositionUnit::Rev => Some(1.0),
            PositionUnit::Deg => Some(1.0 / 360.0),
            PositionUnit::Rad => Some(1.0 / std::f64::consts::TAU),
            _ => None,
        }
    }
}

impl Axis {
    /// Axis units (mm, degrees) per unit. Revolutions of a linear axis are those of its motor. A rotary axis takes
    /// translatory units as circumference at its effective radius, or with MODEREG RotatoricUnit as degrees (2.3.4).
    pub fn per_unit(&self, unit: PositionUnit, rotatoric_unit: bool) -> f64 {
        let parameters = &self.parameters;
        if let Some(mm) = unit.mm() {
            return match (parameters.rotary, rotatoric_unit) {
                (false, _) => mm,
                (true, false) => mm / parameters.scale,
                (true, true) => 1.0,
            };
        }
        let Some(revolutions) = unit.revolutions() else { return 1.0 / parameters.counts_per_unit };
        let revolution = if parameters.rotary { 360.0 } else { parameters.slsp / parameters.counts_per_unit };
        revolutions * revolution
    }
}

impl Mcu {
    /// Selects the units of positions, velocities and accelerations of all interpolation commands (4.4.11), by their
    /// numbers in TRU. An unknown number changes nothing and sets ErrorReg errUnit.
    pub fn ctru(&mut self, pu: i32, tu: i32) -> bool {
        let index = |number: i32| usize::try_from(number).ok();
        let position = index(pu).and_then(|n| POSITION_UNITS.get(n));
        let time = index(tu).and_then(|n| TIME_UNITS.get(n));
        let (Some(&(_, pu)), Some(&(_, tu))) = (position, time) else {
            self.raise(ErrorReg::errUnit);
            return false;
        };
        self.registers.units = TrajectoryUnits { pu, tu };
        true
    }

    /// Effective radius of a rotary axis in mm (4.4.143); what was spooled before keeps its course. The limits mdvel,
    /// maxvel and maxacc go along: they are in PU and TU, and the axis can still do as many degrees a second.
    pub fn change_radius(&mut self, axis: usize, radius: f64) -> bool {
        let Some(parameters) = self.axes.get_mut(axis).map(|a| &mut a.parameters) else { return false };
        if !parameters.rotary || !radius.is_finite() || radius <= 0.0 {
            return false;
        }
        let change = radius.to_radians() / parameters.scale;
        parameters.scale = radius.to_radians();
        for limit in [&mut parameters.mdvel, &mut parameters.maxvel, &mut parameters.maxacc] {
            *limit *= change;
        }
        true
    }

    /// Axis units per unit of a command's position.
    pub(crate) fn command_unit(&self, a: usize) -> f64 {
        self.axes[a].per_unit(self.registers.units.pu, self.registers.modereg.has(ModeReg::RotatoricUnit))
    }

    /// mm of path per unit of a command's path length. Rotary units and counts suppose that all axes are of the type
    /// of the first one (2.3.4).
    fn path_unit(&self, first: usize) -> f64 {
        let pu = self.registers.units.pu;
        pu.mm().unwrap_or_else(|| self.axes[first].per_unit(pu, true) * self.axes[first].parameters.scale)
    }

    /// mm/s per unit of velocity of an axis in PU and TU, and mm/s² per unit of acceleration.
    pub(crate) fn velocity_unit(&self, axis: usize) -> f64 {
        self.path_unit(axis) / self.registers.units.tu.seconds(self.ta)
    }
    pub(crate) fn acceleration_unit(&self, axis: usize) -> f64 {
        self.velocity_unit(axis) / self.registers.units.tu.seconds(self.ta)
    }

    /// Path velocities and acceleration of a command in mm and s; positions stay in PU.
    pub(crate) fn in_path_units<'c>(&self, command: &MotionCommand<'c>) -> MotionCommand<'c> {
        let TrajectoryUnits { tu, .. } = self.registers.units;
        let first = command.axes.iter().next().filter(|&a| a < self.axes.len().min(MAX_AXES));
        let (length, time) = (first.map_or(1.0, |a| self.path_unit(a)), tu.seconds(self.ta));
        let velocity = length / time;
        MotionCommand {
            vl: command.vl * velocity,
            tvl: command.tvl * velocity,
            ac: command.ac * velocity / time,
            ..*command
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // shows: struct.tru.pu, struct.tru.tu
    #[test]
    fn the_tables_are_those_of_the_manual() {
        let names: Vec<&str> = POSITION_UNITS.iter().map(|row| row.0).collect();
        assert_eq!(names, ["mm", "inch", "m", "rev", "deg", "rad", "counts", "steps"]);
        assert_eq!(TIME_UNITS.map(|row| row.0), ["sec", "min", "tsample"]);
        for (n, (_, unit)) in POSITION_UNITS.iter().enumerate() {
            assert_eq!(*unit as usize, n);
        }
        assert_eq!(TIME_UNITS.map(|row| row.1.seconds(1.28e-3)), [1.0, 60.0, 1.28e-3]);
    }
}
