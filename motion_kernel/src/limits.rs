//! Limits and the inputs with a function (chapters 2.4, 4.4.45). Software limits are watched once the axis is
//! referenced (shp) and stand against the set point that the profile generator computes; hardware limits follow their
//! inputs.

use crate::axes::AxisSet;
use crate::axis::{Axis, Doing};
use crate::machine::{InputFunction, LimitFunction, Machine, Side, SoftwareLimits};
use crate::mcu::Mcu;
use crate::registers::Axst;

/// Status bits that are put here.
const WATCHED: Axst = Axst(
    Axst::lsls.0 | Axst::lsrs.0 | Axst::lslh.0 | Axst::lsrh.0 | Axst::eo.0 | Axst::dnr.0 | Axst::ui.0 | Axst::refh.0,
);
/// States of the limit switches, cleared as the loop is closed.
pub(crate) const LIMIT_STATES: Axst = Axst(Axst::lsls.0 | Axst::lsrs.0 | Axst::lslh.0 | Axst::lsrh.0);

/// What limits do to an axis in this sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limiting {
    /// SMA: how far to the left and to the right the set point goes, while the profile runs on internally.
    pub left: Option<f64>,
    pub right: Option<f64>,
    /// TOM: the motor is off towards the left (-1) or the right (+1) limit; 0 = on.
    pub motor_off: f64,
}

/// A limit that has tripped: -1 left, +1 right; where a software limit lies.
struct Trip {
    side: f64,
    function: LimitFunction,
    at: Option<f64>,
}

/// Inputs with a function for one axis, bit n-1 = input n.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AxisInputs {
    /// Left and right limit switches with TOM, SMA, SMD.
    left: [u32; 3],
    right: [u32; 3],
    emergency_out: u32,
    pub(crate) drive_ready: u32,
    user: u32,
    pub(crate) reference: u32,
    pub(crate) latch: u32,
}

const FUNCTIONS: [LimitFunction; 3] = [LimitFunction::Tom, LimitFunction::Sma, LimitFunction::Smd];

impl AxisInputs {
    /// Per axis; empty where no input has a function.
    pub(crate) fn of(machine: &Machine) -> Vec<AxisInputs> {
        let mut axes = vec![AxisInputs::default(); machine.axes.len()];
        for input in &machine.inputs {
            let Some((axis, function)) = input.function else { continue };
            let inputs = &mut axes[axis];
            let mask = match function {
                InputFunction::Limit(side, function) => {
                    let switches = if side == Side::Left { &mut inputs.left } else { &mut inputs.right };
                    let Some(index) = FUNCTIONS.iter().position(|f| *f == function) else { continue };
                    &mut switches[index]
                }
                InputFunction::EmergencyOut => &mut inputs.emergency_out,
                InputFunction::DriveReady => &mut inputs.drive_ready,
                InputFunction::User => &mut inputs.user,
                InputFunction::Reference => &mut inputs.reference,
                InputFunction::Latch => &mut inputs.latch,
            };
            *mask |= 1 << (input.number - 1);
        }
        if axes.iter().all(|a| *a == AxisInputs::default()) { Vec::new() } else { axes }
    }
    fn status(&self, digi: u32) -> Axst {
        let mut status = Axst(0);
        let any = |masks: &[u32]| masks.iter().any(|mask| digi & mask != 0);
        status.put(Axst::lslh, any(&self.left));
        status.put(Axst::lsrh, any(&self.right));
        status.put(Axst::eo, any(&[self.emergency_out]));
        status.put(Axst::dnr, digi & self.drive_ready != self.drive_ready);
        status.put(Axst::ui, any(&[self.user]));
        status.put(Axst::refh, any(&[self.reference]));
        status
    }
    fn trips(&self, digi: u32) -> impl Iterator<Item = Trip> {
        let sides = [(-1.0, self.left), (1.0, self.right)];
        sides.into_iter().flat_map(move |(side, masks)| {
            let active = FUNCTIONS.into_iter().zip(masks).filter(move |(_, mask)| digi & mask != 0);
            active.map(move |(function, _)| Trip { side, function, at: None })
        })
    }
}

/// The software limit that a set point has passed.
pub fn passed(limits: &SoftwareLimits, set_point: f64) -> Axst {
    if set_point < limits.left {
        Axst::lsls
    } else if set_point > limits.right {
        Axst::lsrs
    } else {
        Axst(0)
    }
}

impl Axis {
    /// The set point that the position loop sees.
    #[inline]
    pub fn set_point(&self) -> f64 {
        let left_of = self.limiting.right.map_or(self.dp, |right| self.dp.min(right));
        self.limiting.left.map_or(left_of, |left| left_of.max(left))
    }
    /// Its velocity where the position loop sees `set_point`: 0 where a limit holds it.
    #[inline]
    pub(crate) fn set_velocity(&self, set_point: f64) -> f64 {
        if set_point == self.dp { self.dv } else { 0.0 }
    }
}

impl Mcu {
    /// Status bits and reactions of all limits and inputs with a function.
    pub(crate) fn watch_limits(&mut self) {
        for a in 0..self.axes.len() {
            let axis = &self.axes[a];
            let mut now = match axis.parameters.limits {
                Some(limits) if limits.function != LimitFunction::Off && axis.watches_limits() => {
                    passed(&limits, axis.dp)
                }
                _ => Axst(0),
            };
            if let Some(inputs) = self.axis_inputs.get(a) {
                now.set(inputs.status(self.digi));
            }
            let before = Axst(axis.status.0 & WATCHED.0);
            if now.0 | before.0 != 0 {
                self.at_limit(a, now, before);
            }
        }
    }

    #[cold]
    fn at_limit(&mut self, a: usize, now: Axst, before: Axst) {
        self.set_status(a, Axst(before.0 & !now.0), false);
        self.set_status(a, Axst(now.0 & !before.0), true);
        let axis = &self.axes[a];
        let here = axis.set_point();
        let brakes_already = axis.doing == Doing::Alone && !axis.jogging;
        let mut limiting = Limiting::default();
        let mut brakes = false;
        let inputs = self.axis_inputs.get(a).copied().unwrap_or_default();
        for Trip { side, function, at } in self.software_trip(a, now).into_iter().chain(inputs.trips(self.digi)) {
            let at = at.unwrap_or(here);
            match function {
                LimitFunction::Off => {}
                LimitFunction::Tom => limiting.motor_off = side,
                LimitFunction::Sma if side < 0.0 => limiting.left = axis.limiting.left.or(Some(at)),
                LimitFunction::Sma => limiting.right = axis.limiting.right.or(Some(at)),
                LimitFunction::Smd => brakes |= axis.dv * side > 0.0 && !brakes_already,
            }
        }
        self.axes[a].limiting = limiting;
        if brakes {
            self.tell_fault(a);
            self.stop_by_system(AxisSet::single(a));
        }
    }

    fn software_trip(&self, a: usize, now: Axst) -> Option<Trip> {
        let limits = self.axes[a].parameters.limits?;
        let (side, at) = if now.has(Axst::lsls) { (-1.0, limits.left) } else { (1.0, limits.right) };
        now.any(Axst::lsls | Axst::lsrs).then_some(Trip { side, function: limits.function, at: Some(at) })
    }
}
