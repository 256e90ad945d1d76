//! One axis: its registers, its spooler and the command it is executing.

use crate::axes::AxisSet;
use crate::cause::{Cause, Limit};
use crate::limits::Limiting;
use crate::machine;
use crate::path::Component;
use crate::profile::Profile;
use crate::registers::Axst;
use crate::spooler::{Entry, Function, NONE, Spooler};

/// A wait of the spooler (ssf 1003..1025), begun and ended on a sample (design D23).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wait {
    /// 1003: samples left.
    Samples(u64),
    /// 1004: until these inputs are active.
    Inputs(u32),
    /// 1005, 1015: until CI99 is 0.
    Ci99,
    /// 1025: until the bit of the axis in CI99 is clear.
    Ci99Bit,
    /// 1006: until all axes of the mask wait with the same mask.
    Axes(u32),
}

/// What an axis does in this sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Doing {
    /// Stands still, or runs on with the target velocity of the last profile.
    #[default]
    Nothing,
    /// A spooled move; the profile clock is [`Axis::t`].
    Move(u32),
    Wait(Wait),
    /// A set point each sample (spd, 4.4.117); so many are left.
    Points(u32),
    /// A profile of its own in axis units: a jog (4.4.19, 4.4.23), or a stop with sdec (js, 4.4.24).
    Alone,
}

impl Doing {
    /// A profile or set points are being executed: pe is 0.
    pub fn travels(self) -> bool {
        matches!(self, Doing::Move(_) | Doing::Points(_) | Doing::Alone)
    }
}

/// The override of an axis: the factor of its profile clock (design D1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Override {
    pub factor: f64,
    goal: f64,
    step: f64,
}

impl Default for Override {
    fn default() -> Self {
        Override { factor: 1.0, goal: 1.0, step: 0.0 }
    }
}

impl Override {
    /// Ramps to `goal` with `step` per sample; 0 takes it over at once.
    pub fn take(&mut self, goal: f64, step: f64) {
        *self = if step > 0.0 { Override { goal, step, ..*self } } else { Override { factor: goal, goal, step: 0.0 } };
    }
    #[inline]
    pub fn advance(&mut self) {
        if self.factor != self.goal {
            let left = self.goal - self.factor;
            self.factor = if left.abs() <= self.step { self.goal } else { self.factor + self.step.copysign(left) };
        }
    }
}

/// Axis qualifiers that programs may change at run time (chapters 4.4, 6.3.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Path units per axis unit: 1, or the effective radius per degree (design D7).
    pub scale: f64,
    pub counts_per_unit: f64,
    /// Counts or steps per motor revolution.
    pub slsp: f64,
    /// Limits of look-ahead and ChkMaxVel in PU and TU: mm/s and mm/s² on the path, also for rotary axes.
    pub mdvel: f64,
    pub maxvel: f64,
    pub maxacc: f64,
    pub jerkrel: f64,
    pub sdec: f64,
    /// Jog velocity, acceleration, slope of its braking ramp, target velocity.
    pub jvl: f64,
    pub jac: f64,
    pub jog_brake: f64,
    pub jac_written: f64,
    pub jtvl: f64,
    pub mpe: f64,
    pub ipw: f64,
    pub rotary: bool,
    pub jovr: f64,
    /// Home velocity and acceleration.
    pub hvl: f64,
    pub hac: f64,
    /// Offset of the set point of the loop, and the rate at which it takes effect (0 = at once).
    pub dpoffset: f64,
    pub dvoffset: f64,
    /// Software limits sll and slr.
    pub limits: Option<machine::SoftwareLimits>,
}

impl Parameters {
    fn new(axis: &machine::Axis) -> Self {
        let rotary = axis.kind == machine::AxisKind::Rotary;
        let scale = if rotary && axis.effradius > 0.0 { axis.effradius.to_radians() } else { 1.0 };
        Parameters {
            scale,
            counts_per_unit: axis.counts_per_unit,
            slsp: axis.slsp,
            // machine files speak of degrees, the registers of PU and TU (4.4.160, 4.4.161, 4.4.163)
            mdvel: axis.mdvel * scale,
            maxvel: axis.maxvel * scale,
            maxacc: axis.maxacc * scale,
            jerkrel: axis.jerkrel.clamp(0.0, 1.0),
            sdec: axis.stop_deceleration,
            jvl: axis.jog_velocity,
            jac: axis.jog_acceleration,
            jog_brake: axis.jog_acceleration,
            jac_written: axis.jog_acceleration,
            jtvl: axis.jog_target_velocity,
            mpe: axis.mpe,
            ipw: axis.ipw,
            rotary,
            jovr: 1.0,
            hvl: axis.equipment.home.velocity.unwrap_or(axis.jog_velocity / 4.0),
            hac: axis.equipment.home.acceleration.unwrap_or(axis.jog_acceleration),
            dpoffset: 0.0,
            dvoffset: 0.0,
            limits: axis.limits,
        }
    }
}

/// State of one axis.
#[derive(Debug)]
pub struct Axis {
    pub doing: Doing,
    /// Profile clock inside the move or profile being executed.
    pub t: f64,
    pub component: Component,
    /// Profile of [`Doing::Alone`].
    pub alone: Profile,
    /// It is a jog: on the clock of the jog override, to the target of the component.
    pub jogging: bool,
    /// Direct commands called and not in effect yet (design D2).
    pub pending: u32,
    /// Set point and its velocity, axis units.
    pub dp: f64,
    pub dv: f64,
    /// Nominal path velocity of the move being executed, at factor 1.
    pub plan_v: f64,
    pub trajectory: Override,
    /// jovr shows the trajectory override since the last utrovr.
    pub jovr_follows: bool,
    /// Velocity kept after a profile that ended with a target velocity, axis units/s at factor 1.
    pub run_on_v: f64,
    /// Path velocity at the end of the last move, and the axes of that move.
    pub path_v: f64,
    pub last_axes: AxisSet,
    /// What limited the speed at the end of that move.
    pub limit: Limit,
    /// [`Doing::Alone`] is a stop that the system made (a limit, JSatSAF), not a command.
    pub braked_by_system: bool,
    /// Where a block of distances began (spdr), and 0 for one of positions.
    pub points_base: f64,
    /// PcapIndex of what is executed, the last one that had any (4.4.94), and whether the points of a block count it on.
    pub pcap_index: i32,
    pub points_count: bool,
    /// Too short moves in a row (ErrorReg bit 5).
    pub short_moves: u32,

    pub spooler: Spooler,
    /// End point and programmed target velocity of the newest entry, and its move while it lives.
    pub queue_end: f64,
    pub queue_tvl: f64,
    pub queue_last: u32,
    /// The function behind [`Doing::Wait`] or a halt, to put it back at a feed hold.
    pub function: Option<Function>,

    /// Virtual zero point, a position of the machine (zero.rs).
    pub zero: f64,
    pub limiting: Limiting,
    /// Software limits are watched or not, whatever shp did (resource EVLSS).
    pub evlss: Option<bool>,
    pub status: Axst,
    pub parameters: Parameters,
}

impl Axis {
    pub fn new(axis: &machine::Axis, spool_memory: u32) -> Self {
        Axis {
            doing: Doing::Nothing,
            t: 0.0,
            component: Component { target: axis.start, ..Component::default() },
            alone: Profile::default(),
            jogging: false,
            pending: 0,
            dp: axis.start,
            dv: 0.0,
            plan_v: 0.0,
            trajectory: Override::default(),
            jovr_follows: false,
            run_on_v: 0.0,
            path_v: 0.0,
            last_axes: AxisSet::EMPTY,
            limit: Limit::of(Cause::Stop),
            braked_by_system: false,
            points_base: 0.0,
            pcap_index: 0,
            points_count: false,
            short_moves: 0,
            spooler: Spooler::new(spool_memory),
            queue_end: axis.start,
            queue_tvl: 0.0,
            queue_last: NONE,
            function: None,
            zero: 0.0,
            limiting: Limiting::default(),
            evlss: None,
            status: Axst::pe,
            parameters: Parameters::new(axis),
        }
    }
    /// The nearest whole count to a position.
    pub fn rounded(&self, position: f64) -> f64 {
        (position * self.parameters.counts_per_unit).round() / self.parameters.counts_per_unit
    }
    /// No profile and nothing spooled.
    pub fn is_drained(&self) -> bool {
        self.doing == Doing::Nothing && self.spooler.is_empty() && self.pending == 0
    }
    /// The jog override; without OvrMode it is the effective trajectory override, also while that ramps (4.4.175).
    pub fn jog_override(&self) -> f64 {
        if self.jovr_follows { self.trajectory.factor } else { self.parameters.jovr }
    }
    /// Software limits are watched: since shp, or as EVLSS says.
    pub fn watches_limits(&self) -> bool {
        self.evlss.unwrap_or(self.status.has(Axst::referenced))
    }
    /// Executes a motion command with a target.
    pub fn travels(&self) -> bool {
        matches!(self.doing, Doing::Move(_)) || (self.doing == Doing::Alone && self.jogging)
    }
    /// Velocity of the set point now, axis units.
    pub fn velocity(&self) -> f64 {
        if self.doing == Doing::Nothing { self.run_on_v * self.trajectory.factor } else { self.dv }
    }
    /// True while the axis executes this move or has it in its spooler as the newest motion.
    pub fn holds(&self, slot: u32) -> bool {
        let is_newest = matches!(self.spooler.entries().back(), Some(Entry::Move { slot: s, .. }) if *s == slot);
        is_newest
            || self.doing == Doing::Move(slot)
            || self.spooler.entries().iter().rev().any(|e| matches!(e, Entry::Move { slot: s, .. } if *s == slot))
    }
    /// The queue continues from where the axis stands.
    pub fn forget_queue(&mut self) {
        (self.queue_end, self.queue_tvl, self.queue_last) = (self.dp, 0.0, NONE);
    }
}
