//! Software limits (chapter 2.4). They are watched once the axis is referenced (shp) and stand against the set
//! point that the profile generator computes.

use crate::axes::AxisSet;
use crate::axis::{Axis, Doing};
use crate::machine::{LimitFunction, SoftwareLimits};
use crate::mcu::Mcu;
use crate::registers::Axst;

/// What limits do to an axis in this sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limiting {
    /// SMA: the set point at which the axis is held while the profile goes on internally.
    pub frozen: Option<f64>,
    /// TOM: the motor is off towards the left (-1) or the right (+1) limit; 0 = on.
    pub motor_off: f64,
}

/// The limit that a set point has passed.
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
        self.limiting.frozen.unwrap_or(self.dp)
    }
}

impl Mcu {
    /// Status bits and reactions of all software limits.
    pub(crate) fn watch_limits(&mut self) {
        for a in 0..self.axes.len() {
            let Some(limits) = self.axes[a].parameters.limits else { continue };
            let axis = &self.axes[a];
            let watched = limits.function != LimitFunction::Off && axis.status.has(Axst::referenced);
            let now = if watched { passed(&limits, axis.dp) } else { Axst(0) };
            let before = Axst(axis.status.0 & (Axst::lsls | Axst::lsrs).0);
            if now.0 | before.0 != 0 {
                self.at_limit(a, &limits, now, before);
            }
        }
    }

    #[cold]
    fn at_limit(&mut self, a: usize, limits: &SoftwareLimits, now: Axst, before: Axst) {
        self.set_status(a, Axst(before.0 & !now.0), false);
        self.set_status(a, Axst(now.0 & !before.0), true);
        let side = if now == Axst::lsls { -1.0 } else { 1.0 };
        let axis = &mut self.axes[a];
        if now.0 == 0 {
            axis.limiting = Limiting::default();
            return;
        }
        match limits.function {
            LimitFunction::Off => {}
            LimitFunction::Tom => axis.limiting.motor_off = side,
            LimitFunction::Sma => {
                let limit = if side < 0.0 { limits.left } else { limits.right };
                axis.limiting.frozen.get_or_insert(limit);
            }
            LimitFunction::Smd if axis.dv * side > 0.0 && axis.doing != Doing::Alone => {
                self.told.fault = true;
                self.js(AxisSet::single(a));
            }
            LimitFunction::Smd => {}
        }
    }
}
