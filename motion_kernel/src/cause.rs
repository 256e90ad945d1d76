//! What limits the path velocity, recorded where it is decided: a move knows what bounds its start, its velocity and its
//! end, its plan names one cause for each phase, and every sample says the cause of the phase it is in.
//!
//! | phase | cause |
//! |---|---|
//! | the velocity of the move | what set that: F, the rapid, maxvel of an axis, maxacc on an arc |
//! | a ramp from or to a junction | what bounds the speed at that junction, also where it lies many moves ahead or behind |
//! | a ramp from or to standstill in a move that never reaches its velocity | the ramp: the move is too short |
//!
//! Below an override of 1 that is the cause of all motion, since more of it would be faster everywhere.

use crate::axis::{Axis, Doing, Wait};
use crate::mcu::Mcu;
use crate::spooler::{Move, SpoolState};

/// Declares the causes: `Variant, "name in JSON and Python", "English", "German";`, numbered from 1.
macro_rules! causes {
    ($($variant:ident, $name:literal, $english:literal, $german:literal;)*) => {
        /// What limits the path velocity.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Cause { Unknown = 0, $(#[doc = $english] $variant,)* }

        impl Cause {
            /// Those by which nothing is lost: the program gets what it asks for.
            pub const AT_SPEED: [Cause; 3] = [Cause::Feed, Cause::Rapid, Cause::Dwell];
            /// Every cause with its name and its words in English and German.
            pub const ALL: &'static [(Cause, &'static str, &'static str, &'static str)] =
                &[$((Cause::$variant, $name, $english, $german),)*];
        }
    };
}

causes! {
    Feed, "feed", "programmed feed", "programmierter Vorschub";
    Rapid, "rapid", "rapid at its limit", "Eilgang an seiner Grenze";
    MaxVel, "maxvel", "maxvel of an axis", "maxvel einer Achse";
    ArcAcc, "arc_maxacc", "maxacc on an arc", "maxacc auf einem Bogen";
    MdVel, "mdvel", "mdvel at a junction", "mdvel an einem Satzübergang";
    TargetVelocity, "target_velocity", "programmed target velocity", "programmierte Zielgeschwindigkeit";
    Ramp, "ramp", "ramp: move too short", "Rampe: Satz zu kurz";
    MaxAcc, "maxacc", "ramp lowered by maxacc of an axis", "Rampe durch maxacc einer Achse verringert";
    ShortBlock, "short_block", "block shorter than a sample", "Satz kürzer als eine Abtastung";
    Stop, "stop", "stop in the program", "Halt im Programm";
    EndOfSpool, "end_of_spool", "end of what is spooled", "Ende der Sätze im Spooler";
    Starved, "starved", "spooler starved", "Spooler leergelaufen";
    Depth, "lookahead_depth", "end of the look-ahead window", "Ende des Look-ahead-Fensters";
    Override, "override", "override below 100 %", "Vorschubkorrektur unter 100 %";
    Hold, "hold", "hold", "Vorschub-Halt";
    Dwell, "dwell", "dwell", "Verweilzeit";
    Wait, "wait", "wait for inputs, axes or the application", "Warten auf Eingänge, Achsen oder Anwendung";
    Idle, "idle", "no motion commanded", "keine Bewegung befohlen";
    Direct, "direct", "jog, search or stop of an axis", "Tippen, Suche oder Halt einer Achse";
    Points, "points", "set points of the application", "Sollwerte der Anwendung";
}

/// A cause and, where it is that of one axis, the axis: 16 bits, cause in the low byte, axis index + 1 in the high one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Limit(pub u16);

impl Limit {
    pub const fn of(cause: Cause) -> Limit {
        Limit(cause as u16)
    }
    pub const fn by(cause: Cause, axis: usize) -> Limit {
        Limit(cause as u16 | (axis as u16 + 1) << 8)
    }
    pub fn cause(self) -> Cause {
        Cause::ALL.get(usize::from(self.0 & 0xff).wrapping_sub(1)).map_or(Cause::Unknown, |row| row.0)
    }
    pub fn axis(self) -> Option<usize> {
        usize::from(self.0 >> 8).checked_sub(1)
    }
    /// Standstill that the program asks for.
    fn is_stop(self) -> bool {
        self == Limit::of(Cause::Stop) || self == Limit::of(Cause::EndOfSpool)
    }
}

/// The causes of one move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Of its velocity, of its ramps where it does not reach that, and of the speed at its start.
    pub velocity: Limit,
    pub ramp: Limit,
    pub junction: Limit,
    /// Of its plan: accelerating, constant, braking; and of the speed at its end.
    pub phases: [Limit; 3],
    pub end: Limit,
}

impl Default for Limits {
    fn default() -> Self {
        let (feed, ramp, stop) = (Limit::of(Cause::Feed), Limit::of(Cause::Ramp), Limit::of(Cause::Stop));
        Limits { velocity: feed, ramp, junction: stop, phases: [stop, feed, stop], end: stop }
    }
}

/// A peak this much below the velocity has not reached it.
const NOT_REACHED: f64 = 1.0 - 1e-9;

impl Move {
    /// Names the phases of its plan. `max_v` is the velocity that it was planned with, NoTriangle may have lowered it.
    pub(crate) fn explain(&mut self, start: Limit, end: Limit, max_v: f64) {
        let limits = &mut self.limits;
        let constant = if max_v < self.vl * NOT_REACHED { limits.ramp } else { limits.velocity };
        (limits.phases, limits.end) = ([start, constant, end], end);
        if (start.is_stop() || end.is_stop()) && self.profile.peak_v() < max_v * NOT_REACHED {
            for phase in limits.phases.iter_mut().filter(|phase| phase.is_stop()) {
                *phase = limits.ramp;
            }
        }
    }
    /// Its plan was replaced by one that brakes for `cause`.
    pub(crate) fn explain_stop(&mut self, cause: Cause) {
        (self.limits.phases[2], self.limits.end) = (Limit::of(cause), Limit::of(cause));
    }
    /// What limits a velocity at which the one of `last` and its own meet: the smaller one.
    pub(crate) fn target_limit(&self) -> Limit {
        match self.tvl {
            tvl if tvl <= 0.0 => Limit::of(Cause::Stop),
            tvl if tvl < self.vl => Limit::of(Cause::TargetVelocity),
            _ => self.limits.velocity,
        }
    }
}

impl Axis {
    /// What limits the path velocity in the move that the axis executes.
    #[inline]
    pub(crate) fn limit_in(&self, mv: &Move) -> Limit {
        if self.trajectory.factor < 1.0 && !mv.stopping {
            return Limit::of(Cause::Override);
        }
        mv.limits.phases[mv.profile.phase(self.t)]
    }
}

impl Mcu {
    /// The leading axis executes no move: that of another one counts, else what this one does.
    pub(crate) fn limit_without_leader(&self) -> Limit {
        let moving = |a: usize| if let Doing::Move(slot) = self.axes[a].doing { Some((a, slot)) } else { None };
        if let Some((a, slot)) = (0..self.axes.len()).find_map(moving) {
            return self.axes[a].limit_in(&self.moves[slot]);
        }
        let busy = |a: &usize| self.axes[*a].doing != Doing::Nothing;
        let axis =
            &self.axes[Some(self.leader).filter(busy).or((0..self.axes.len()).find(busy)).unwrap_or(self.leader)];
        Limit::of(match axis.doing {
            Doing::Alone => Cause::Direct,
            Doing::Points(_) => Cause::Points,
            _ if self.holding => Cause::Hold,
            Doing::Wait(Wait::Samples(_)) => Cause::Dwell,
            Doing::Wait(_) => Cause::Wait,
            Doing::Move(_) | Doing::Nothing => match axis.spooler.state {
                SpoolState::Held => Cause::Hold,
                SpoolState::Halted | SpoolState::Stopped => Cause::Wait,
                _ if axis.run_on_v != 0.0 => Cause::TargetVelocity,
                _ if axis.limit == Limit::of(Cause::Starved) => Cause::Starved,
                _ if self.tasks.iter().any(|task| task.is_alive()) => Cause::Idle,
                _ => Cause::EndOfSpool,
            },
        })
    }
}
