//! Motion commands on their way into the spoolers (4.3.2.4 to 4.3.2.6): checked, given a path and limits.

use crate::autocode::{LEAST_SAMPLES, MoveKind};
use crate::axes::{AxisList, AxisSet, MAX_AXES};
use crate::cause::{Cause, Limit, Limits};
use crate::circle_3d::Space;
use crate::functions::Entered;
use crate::mcu::Mcu;
use crate::path::{self, Component, Ends, Geometry, NoPath};
use crate::registers::{Axst, ErrorReg, ModeReg};
use crate::spooler::{BYTES_CIRCLE, BYTES_LINEAR, Entry, Move, NONE};

/// A motion command: LMP, CMP or HMP of chapter 4.3.2, in PU and TU (units.rs).
#[derive(Clone, Copy, Debug)]
pub struct MotionCommand<'a> {
    pub kind: MoveKind,
    /// Circles turn in the plane of the first two axes.
    pub axes: &'a AxisList,
    /// One target (or distance) per axis in the order of `axes`; for circles given by angle those of the
    /// circle axes are not used.
    pub targets: &'a [f64],
    pub center: [f64; 2],
    /// Degrees, counter-clockwise positive. |phi| <= 1e-100 in smha and smhr: to the target point.
    pub phi: f64,
    pub vl: f64,
    pub ac: f64,
    pub tvl: f64,
    pub rapid: bool,
    pub line: u32,
}

/// Velocity and acceleration of a move, and what limits them.
struct Dynamics {
    vl: f64,
    ac: f64,
    limits: Limits,
}

impl Mcu {
    /// Spools a motion command for all its axes (smla, smlr, smca, smcr, smha, smhr).
    pub fn spool(&mut self, command: &MotionCommand) -> Entered {
        self.spool_as(command, None, None)
    }
    /// As [`Mcu::spool`]; the axes show `pcap_index` while they execute it (smlai, smlri; [`Mcu::rdPcapIndex`]).
    pub fn spool_indexed(&mut self, command: &MotionCommand, pcap_index: i32) -> Entered {
        self.spool_as(command, None, Some(pcap_index))
    }

    pub(crate) fn spool_as(
        &mut self,
        command: &MotionCommand,
        space: Option<&Space>,
        pcap_index: Option<i32>,
    ) -> Entered {
        self.commands += 1;
        let command = &self.in_path_units(command);
        if let Err(outcome) = self.check(command, space) {
            return outcome;
        }
        self.begin_spooling(command.axes.set());
        let mut components = std::mem::take(&mut self.components);
        let outcome = match self.course(command, space, &mut components) {
            Ok(geometry) => {
                if self.listing.is_some() {
                    self.list(command, space, &geometry, &components);
                }
                let slot = self.enter(command, &geometry, &components, space.is_some());
                self.moves[slot].pcap_index = pcap_index;
                Entered::Yes
            }
            Err(nothing) => self.discard(nothing),
        };
        self.components = components;
        outcome
    }

    /// Axes without anything to do: what is spooled begins where they stand.
    pub(crate) fn begin_spooling(&mut self, axes: AxisSet) {
        for a in axes.iter() {
            if self.axes[a].is_drained() {
                self.axes[a].forget_queue();
            }
        }
    }

    /// Bytes that the command takes in the spooler of the axis at `position` of its list.
    pub fn bytes_of(kind: MoveKind, position: usize) -> u32 {
        if !kind.is_linear() && position < 2 { BYTES_CIRCLE } else { BYTES_LINEAR }
    }
    /// Room for the command in every spooler concerned.
    pub fn has_room(&self, kind: MoveKind, axes: &AxisList) -> bool {
        let fits =
            |(i, a): (usize, usize)| self.axes.get(a).is_none_or(|axis| axis.spooler.left() >= Self::bytes_of(kind, i));
        axes.iter().enumerate().all(fits)
    }

    fn check(&mut self, command: &MotionCommand, space: Option<&Space>) -> Result<(), Entered> {
        self.check_parameters(command)?;
        if command.axes.iter().any(|a| self.axes[a].braked_by_system) {
            self.raise(ErrorReg::SpoolerLoadError);
            return Err(Entered::Discarded);
        }
        let room = |a: usize| self.axes[a].spooler.left() >= BYTES_CIRCLE;
        if !self.has_room(command.kind, command.axes) || (space.is_some() && !command.axes.iter().all(room)) {
            self.raise(ErrorReg::errSpoolerOverrun);
            return Err(Entered::Full);
        }
        Ok(())
    }

    /// What spooled and direct commands refuse alike: axes, open loops, velocity and acceleration.
    pub(crate) fn check_parameters(&mut self, command: &MotionCommand) -> Result<(), Entered> {
        let too_few = command.axes.is_empty() || (!command.kind.is_linear() && command.axes.len() < 2);
        self.check_axes(command.axes, too_few)?;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let has_velocity = positive(command.vl) && command.tvl.is_finite();
        for (ok, bit) in [(has_velocity, ErrorReg::VelocityZero), (positive(command.ac), ErrorReg::AccelZero)] {
            if !ok {
                self.raise(bit);
                self.profile_refused();
                return Err(Entered::Discarded);
            }
        }
        Ok(())
    }

    /// Axes named twice or not there (ErrorReg bit 0), and axes in open loop (design D11).
    pub(crate) fn check_axes(&mut self, list: &AxisList, too_few: bool) -> Result<(), Entered> {
        let axes = list.set();
        if list.has_duplicates() || !self.all_axes().contains_all(axes) || too_few {
            self.raise(ErrorReg::errAxDef);
            return Err(Entered::Discarded);
        }
        let open: AxisSet = axes.iter().filter(|&a| !self.loops[a].closed).collect();
        if !open.is_empty() {
            self.refuse(open);
            return Err(Entered::Refused);
        }
        Ok(())
    }

    /// The message on discarding a profile without distance, velocity or acceleration (MODEREG bit 29).
    fn profile_refused(&mut self) {
        if !self.registers.modereg.has(ModeReg::InhibitProfileRefuse) {
            self.monitor_message();
        }
    }

    pub(crate) fn discard(&mut self, nothing: NoPath) -> Entered {
        if nothing == NoPath::Zero {
            self.profile_refused();
        }
        self.raise(match nothing {
            NoPath::Zero => ErrorReg::ZeroProfile,
            NoPath::Radius { exactly: true } => ErrorReg::RadiusError | ErrorReg::errCenterPoint,
            NoPath::Radius { exactly: false } => ErrorReg::RadiusError,
            NoPath::Center => ErrorReg::errCenterPoint,
        });
        Entered::Discarded
    }

    /// The path of a command from the end of what is spooled.
    pub(crate) fn course(
        &self,
        command: &MotionCommand,
        space: Option<&Space>,
        components: &mut Vec<Component>,
    ) -> Result<Geometry, NoPath> {
        let n = command.axes.len();
        let (mut start, mut target, mut scale) = ([0.0; MAX_AXES], [0.0; MAX_AXES], [1.0; MAX_AXES]);
        let [x, y] = command.center;
        let mut center = space.map_or([x, y, 0.0], |space| space.center);
        let relative = command.kind.is_relative();
        let rounds = command.tvl == 0.0 && !self.registers.modereg.has(ModeReg::ExactTargetPos);
        for (i, a) in command.axes.iter().enumerate() {
            let axis = &self.axes[a];
            let unit = self.command_unit(a);
            (start[i], scale[i]) = (axis.queue_end, axis.parameters.scale);
            let given = command.targets[i] * unit;
            target[i] = if relative { start[i] + given } else { given };
            if rounds {
                target[i] = axis.rounded(target[i]);
            }
            if i < 3 {
                center[i] = if relative { start[i] + center[i] * unit } else { center[i] * unit };
            }
        }
        let (list, nfrax) = (command.axes, self.registers.nfrax);
        let ends = Ends { list, start: &start[..n], target: &target[..n], scale: &scale[..n], nfrax };
        if command.kind.is_linear() {
            return path::line(&ends, components);
        }
        let geometry = match space {
            Some(space) => path::circle_3d(&ends, center, space.normal, command.phi, components)?,
            None => {
                let center = [center[0], center[1]];
                path::circle(&ends, center, self.sweep(command, &ends, center), components)?
            }
        };
        for (component, a) in components.iter_mut().zip(list.iter()).filter(|(c, _)| rounds && c.is_circle()) {
            component.target = self.axes[a].rounded(component.target);
        }
        Ok(geometry)
    }

    fn sweep(&self, command: &MotionCommand, ends: &Ends, center: [f64; 2]) -> f64 {
        let to_target = matches!(command.kind, MoveKind::Smha | MoveKind::Smhr) && command.phi.abs() <= 1e-100;
        if !to_target {
            return command.phi;
        }
        let metric = |p: [f64; 2]| [p[0] * ends.scale[0], p[1] * ends.scale[1]];
        let (start, target) = ([ends.start[0], ends.start[1]], [ends.target[0], ends.target[1]]);
        path::sweep_to_target(
            metric(start),
            metric(center),
            metric(target),
            command.phi.is_sign_negative() && command.phi != 0.0,
        )
    }

    /// Path velocity and acceleration within the limits of the axes (ChkMaxVel on lines, arcs under LookAhead).
    fn limits(&self, command: &MotionCommand, geometry: &Geometry, components: &[Component]) -> Dynamics {
        let Dynamics { mut vl, mut ac, mut limits } = self.programmed(command, geometry);
        if command.kind.is_linear() && self.registers.modereg.has(ModeReg::ChkMaxVel) {
            for (component, a) in components.iter().zip(command.axes.iter()) {
                let parameters = &self.axes[a].parameters;
                let share = (component.p * parameters.scale).abs();
                if parameters.maxvel > 0.0 && share * vl > parameters.maxvel {
                    (vl, limits.velocity) = (parameters.maxvel / share, Limit::by(Cause::MaxVel, a));
                }
                if parameters.maxacc > 0.0 && share * ac > parameters.maxacc {
                    (ac, limits.ramp) = (parameters.maxacc / share, Limit::by(Cause::MaxAcc, a));
                }
            }
        }
        if !command.kind.is_linear() && self.registers.modereg.has(ModeReg::LookAhead) {
            for a in [command.axes.at(0), command.axes.at(1)] {
                let most = self.axes[a].parameters.maxacc;
                if most > 0.0 && geometry.radius * most < vl * vl {
                    (vl, limits.velocity) = ((geometry.radius * most).sqrt(), Limit::by(Cause::ArcAcc, a));
                }
            }
        }
        Dynamics { vl, ac, limits }
    }

    /// Velocity and acceleration of the command itself.
    fn programmed(&self, command: &MotionCommand, geometry: &Geometry) -> Dynamics {
        let &MotionCommand { vl, ac, .. } = command;
        let velocity = match geometry.length <= LEAST_SAMPLES * self.ta * vl * (1.0 + 1e-9) {
            true => Cause::ShortBlock,
            false if command.rapid => Cause::Rapid,
            false => Cause::Feed,
        };
        Dynamics { vl, ac, limits: Limits { velocity: Limit::of(velocity), ..Limits::default() } }
    }

    /// Puts the move into the spoolers of its axes and into its look-ahead chain.
    fn enter(&mut self, command: &MotionCommand, geometry: &Geometry, components: &[Component], plain: bool) -> u32 {
        let axes = command.axes.set();
        let Dynamics { vl, ac, mut limits } = match plain {
            true => self.programmed(command, geometry),
            false => self.limits(command, geometry, components),
        };
        let capped = command.kind.is_linear() && self.registers.modereg.has(ModeReg::ChkMaxVel);
        let tvl = if capped { command.tvl.min(vl) } else { command.tvl };
        let before = self.chain_end(axes);
        let (mut junction_v, junction) = match before {
            Some(previous) if plain => (self.passing_v(previous), self.moves[previous].target_limit()),
            Some(previous) => self.turn_v(previous, command.axes, geometry, components),
            None => (0.0, Limit::of(Cause::Stop)),
        };
        limits.junction = if junction_v < vl { junction } else { limits.velocity };
        junction_v = junction_v.min(vl);
        let jerkrel = self.jerkrel_of(axes);
        let slot = self.moves.add(Move {
            axes,
            number: self.commands,
            line: command.line,
            rapid: command.rapid,
            plain,
            programmed_v: command.vl,
            length: geometry.length,
            to: geometry.length,
            curvature: geometry.curvature,
            vl,
            ac,
            tvl,
            jerkrel,
            users: command.axes.len() as u32,
            junction_v2: junction_v * junction_v,
            ..Move::default()
        });
        // not with the rest: a wide copy directly behind narrow stores waits for them
        self.moves[slot].limits = limits;
        let tangent = self.lookahead.append(&mut self.moves, slot, before);
        let end = path::point(geometry.length, geometry.curvature);
        for (&component, a) in components.iter().zip(command.axes.iter()) {
            let axis = &mut self.axes[a];
            tangent[a] = component.slope(&end, geometry.curvature) * axis.parameters.scale;
            axis.spooler.push(Entry::Move { slot, component });
            (axis.queue_end, axis.queue_tvl, axis.queue_last) = (component.target, tvl, slot);
        }
        slot
    }

    /// Velocity with which what is no part of the look-ahead follows a move: 0 unless `sstvl` set it.
    fn passing_v(&self, previous: u32) -> f64 {
        let last = &self.moves[previous];
        if last.passes { last.tvl.max(0.0) } else { 0.0 }
    }

    /// Interpolating axes use the smallest jerkrel of the group (design D14).
    pub(crate) fn jerkrel_of(&self, axes: AxisSet) -> f64 {
        axes.iter().map(|a| self.axes[a].parameters.jerkrel).fold(1.0, f64::min)
    }

    /// Highest speed at the junction with the move before: no axis may change its speed by more than its mdvel
    /// (0 = not watched), and neither velocity nor target velocity of that move are exceeded.
    fn turn_v(&self, previous: u32, list: &AxisList, geometry: &Geometry, components: &[Component]) -> (f64, Limit) {
        let last = &self.moves[previous];
        let Some(before) = self.lookahead.end_tangent(&self.moves, previous) else {
            return (0.0, Limit::of(Cause::Stop));
        };
        let start = path::point(0.0, geometry.curvature);
        let (mut v, mut limit) = (last.tvl.max(0.0).min(last.vl), last.target_limit());
        for (component, a) in components.iter().zip(list.iter()) {
            let parameters = &self.axes[a].parameters;
            let change = (component.slope(&start, geometry.curvature) * parameters.scale - before[a]).abs();
            if parameters.mdvel > 0.0 && change > 1e-12 {
                let most = parameters.mdvel / change;
                // which axis decides changes from junction to junction: no branch
                limit = if most < v { Limit::by(Cause::MdVel, a) } else { limit };
                v = v.min(most);
            }
        }
        (v, limit)
    }

    /// The newest move of all these axes, if it has just these axes and still lives.
    fn chain_end(&self, axes: AxisSet) -> Option<u32> {
        let first = axes.iter().next()?;
        let slot = self.axes[first].queue_last;
        let joins = slot != NONE
            && self.moves[slot].axes == axes
            && axes.iter().all(|a| self.axes[a].queue_last == slot && self.axes[a].holds(slot))
            && self.lookahead.end_tangent(&self.moves, slot).is_some();
        joins.then_some(slot)
    }

    /// A message on the monitor screen (ErrorReg bit 9).
    pub(crate) fn monitor_message(&mut self) {
        self.raise(ErrorReg::CheckMonitorScreen);
    }
    /// A motion command for an axis in open loop (design D11).
    pub(crate) fn refuse(&mut self, axes: AxisSet) {
        for a in axes.iter() {
            self.set_status(a, Axst::dhef, true);
        }
        self.monitor_message();
    }
}
