//! Direct mode (2.2.8.1): jogs of single axes and direct moves. They take effect some samples after the call
//! (design D2), replace what runs then, go on from its position and velocity, and discard the spoolers.

use crate::autocode::MoveKind;
use crate::axes::{AxisList, AxisSet, MAX_AXES};
use crate::axis::{Axis, Doing};
use crate::cause::{Cause, Limit};
use crate::circle_3d::Space;
use crate::functions::Entered;
use crate::homing::Search;
use crate::mcu::Mcu;
use crate::motion::MotionCommand;
use crate::path::{Component, Geometry};
use crate::profile::{Profile, Request};
use crate::registers::{Axst, ModeReg};
use crate::spooler::{Move, NONE};
use crate::units::TrajectoryUnits;

/// Direct commands that can wait for their effect at once.
pub(crate) const MOST_PENDING: usize = 64;

/// A direct command that has been called.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pending {
    /// Sample in which it takes effect.
    due: u64,
    command: Direct,
}

#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant)] // few, in a list of their own; a box would allocate inside a sample
enum Direct {
    Jog { axis: usize, way: f64, relative: bool },
    Search { axis: usize, way: f64, search: Search },
    Move(DirectMove),
}

/// A motion command with its own copy of what it refers to.
#[derive(Clone, Copy, Debug)]
struct DirectMove {
    kind: MoveKind,
    axes: AxisList,
    targets: [f64; MAX_AXES],
    center: [f64; 2],
    space: Option<Space>,
    phi: f64,
    vl: f64,
    ac: f64,
    tvl: f64,
    line: u32,
    units: TrajectoryUnits,
}

impl Mcu {
    /// Jogs each axis, on its own, to its absolute target in axis units (ja) with jvl, jac and jtvl.
    pub fn ja(&mut self, axes: &AxisList, targets: &[f64]) -> Entered {
        self.jog(axes, targets, false)
    }
    /// As [`Mcu::ja`], by a distance from the set point when the profile starts (jr).
    pub fn jr(&mut self, axes: &AxisList, distances: &[f64]) -> Entered {
        self.jog(axes, distances, true)
    }

    fn jog(&mut self, axes: &AxisList, ways: &[f64], relative: bool) -> Entered {
        self.call_each(axes, ways, |axis, way| Direct::Jog { axis, way, relative })
    }
    /// A home search of each axis (homing.rs).
    pub(crate) fn search(&mut self, axes: &AxisList, ways: &[f64], search: Search) -> Entered {
        self.call_each(axes, ways, |axis, way| Direct::Search { axis, way, search })
    }

    fn call_each(&mut self, axes: &AxisList, ways: &[f64], command: impl Fn(usize, f64) -> Direct) -> Entered {
        if let Err(outcome) = self.check_axes(axes, axes.is_empty()) {
            return outcome;
        }
        if ways.len() != axes.len() || !ways.iter().all(|w| w.is_finite()) {
            self.refuse(axes.set());
            return Entered::Discarded;
        }
        if self.pending.len() + axes.len() > MOST_PENDING {
            return Entered::Full;
        }
        for (axis, &way) in axes.iter().zip(ways) {
            self.call(command(axis, way), AxisSet::single(axis));
        }
        Entered::Yes
    }

    /// A direct move: mla, mlr, mca, mcr, mha or mhr, by the kind of the command (its spooled name).
    pub fn direct(&mut self, command: &MotionCommand) -> Entered {
        self.direct_as(command, None)
    }

    pub(crate) fn direct_as(&mut self, command: &MotionCommand, space: Option<Space>) -> Entered {
        if let Err(outcome) = self.check_parameters(command) {
            return outcome;
        }
        if self.pending.len() == MOST_PENDING {
            return Entered::Full;
        }
        let MotionCommand { kind, center, phi, vl, ac, tvl, line, .. } = self.in_path_units(command);
        let mut targets = [0.0; MAX_AXES];
        targets[..command.axes.len()].copy_from_slice(&command.targets[..command.axes.len()]);
        let units = self.registers.units;
        let direct = DirectMove { kind, axes: *command.axes, targets, center, space, phi, vl, ac, tvl, line, units };
        self.call(Direct::Move(direct), command.axes.set());
        Entered::Yes
    }

    /// From the call on pe is 0 (axst.pe.at-call); saf is cleared.
    fn call(&mut self, command: Direct, axes: AxisSet) {
        let due = self.sample + u64::from(self.machine.controller.direct_latency);
        self.pending.push(Pending { due, command });
        for a in axes.iter() {
            self.axes[a].pending += 1;
            self.axes[a].status.clear(Axst::pe | Axst::ip);
            self.set_status(a, Axst::saf, false);
        }
    }

    /// Carries out the commands whose time has come, in the order of their calls.
    pub(crate) fn begin_direct(&mut self) {
        while let Some(first) = self.pending.first().copied().filter(|p| p.due <= self.sample) {
            self.pending.remove(0);
            match first.command {
                Direct::Jog { axis, way, relative } => {
                    self.axes[axis].pending -= 1;
                    self.begin_jog(axis, way, relative);
                }
                Direct::Search { axis, way, search } => {
                    self.axes[axis].pending -= 1;
                    self.begin_search(axis, way, search);
                }
                Direct::Move(direct) => {
                    direct.axes.iter().for_each(|a| self.axes[a].pending -= 1);
                    self.begin_move(&direct);
                }
            }
        }
    }

    /// Commands of these axes that are not in effect yet are dropped, with the axes they belong to.
    pub(crate) fn drop_pending(&mut self, axes: AxisSet) {
        let mut index = 0;
        while index < self.pending.len() {
            let concerned = match &self.pending[index].command {
                Direct::Jog { axis, .. } | Direct::Search { axis, .. } => AxisSet::single(*axis),
                Direct::Move(direct) => direct.axes.set(),
            };
            if concerned.intersects(axes) {
                self.pending.remove(index);
                concerned.iter().for_each(|a| self.axes[a].pending -= 1);
            } else {
                index += 1;
            }
        }
    }

    fn begin_jog(&mut self, a: usize, way: f64, relative: bool) {
        if !self.loops[a].closed {
            return;
        }
        let shaped = self.registers.modereg.has(ModeReg::SProfile);
        let shortest = self.registers.modereg.has(ModeReg::ShortestRotatoricDistance);
        let rounds = !self.registers.modereg.has(ModeReg::ExactTargetPos);
        let v = self.axes[a].velocity();
        self.enter_direct_mode(a);
        let axis = &mut self.axes[a];
        let mut target = if relative { axis.dp + way } else { way - if shortest { axis.turns(way) } else { 0.0 } };
        if rounds && axis.parameters.jtvl == 0.0 {
            target = axis.rounded(target);
        }
        let distance = target - axis.dp;
        let parameters = axis.parameters;
        let jerkrel = if shaped { parameters.jerkrel } else { 0.0 };
        // without distance a moving axis comes back to where it is
        let toward = if distance != 0.0 { distance.signum() } else { -v.signum() };
        let direction = if parameters.jvl < 0.0 { -toward } else { toward };
        let start_v = v * direction / axis.jog_override();
        axis.alone = if parameters.jvl > 0.0 {
            let request = Request {
                from: 0.0,
                to: distance.abs(),
                start_v,
                max_v: parameters.jvl,
                acc: parameters.jac,
                target_v: parameters.jtvl,
                jerkrel,
            };
            Profile::direct(&request, parameters.jog_brake, true)
        } else {
            Profile::endless(start_v, -parameters.jvl, parameters.jac, parameters.jog_brake, jerkrel)
        };
        axis.component = Component { base: axis.dp, p: direction, target, ..Component::default() };
        (axis.doing, axis.t, axis.jogging, axis.queue_end) = (Doing::Alone, 0.0, true, target);
    }

    /// The magnitude of the present velocity is laid into the new direction (2.2.2).
    fn begin_move(&mut self, direct: &DirectMove) {
        let list = direct.axes;
        let axes = list.set();
        if axes.iter().any(|a| !self.loops[a].closed) {
            return;
        }
        let squares = axes.iter().map(|a| (self.axes[a].velocity() * self.axes[a].parameters.scale).powi(2));
        let start_v = squares.sum::<f64>().sqrt() / self.axes[list.at(0)].trajectory.factor;
        axes.iter().for_each(|a| self.enter_direct_mode(a));
        let &DirectMove { kind, center, phi, vl, ac, tvl, line, .. } = direct;
        let targets = &direct.targets[..list.len()];
        let command = MotionCommand { kind, axes: &list, targets, center, phi, vl, ac, tvl, rapid: false, line };
        let mut components = std::mem::take(&mut self.components);
        let units = std::mem::replace(&mut self.registers.units, direct.units); // those of the call
        let course = self.course(&command, direct.space.as_ref(), &mut components);
        self.registers.units = units;
        match course {
            Ok(geometry) => self.travel(&command, &geometry, &components, start_v),
            Err(nothing) => _ = self.discard(nothing),
        }
        self.components = components;
    }

    fn travel(&mut self, command: &MotionCommand, geometry: &Geometry, components: &[Component], start_v: f64) {
        let axes = command.axes.set();
        let shaped = self.registers.modereg.has(ModeReg::SProfile);
        let &MotionCommand { vl, ac, tvl, line, .. } = command;
        let length = geometry.length;
        let jerkrel = if shaped { self.jerkrel_of(axes) } else { 0.0 };
        let request = Request { from: 0.0, to: length, start_v, max_v: vl, acc: ac, target_v: tvl, jerkrel };
        let slot = self.moves.add(Move {
            axes,
            line,
            direct: true,
            programmed_v: vl,
            length,
            to: length,
            curvature: geometry.curvature,
            vl,
            ac,
            tvl,
            jerkrel,
            users: command.axes.len() as u32,
            ..Move::default()
        });
        // a chain of its own, planned at once
        self.lookahead.append(&mut self.moves, slot, None);
        self.lookahead.plan(&mut self.moves, slot, 0);
        (self.moves[slot].planned, self.moves[slot].profile) = (true, Profile::direct(&request, ac, false));
        let end = self.moves[slot].target_limit();
        self.moves[slot].explain(Limit::of(Cause::Stop), end, vl);
        for (&component, a) in components.iter().zip(command.axes.iter()) {
            let axis = &mut self.axes[a];
            (axis.doing, axis.component, axis.t) = (Doing::Move(slot), component, 0.0);
            (axis.queue_end, axis.queue_tvl, axis.queue_last) = (component.target, tvl, NONE);
        }
    }

    /// The jog acceleration (wrjac): positive for both ramps, negative for the braking ramp alone. 0 is refused.
    pub fn wrjac(&mut self, axis: usize, value: f64) -> bool {
        let ok = value != 0.0 && value.is_finite();
        let parameters = &mut self.axes[axis].parameters;
        if ok {
            parameters.jog_brake = value.abs();
            parameters.jac_written = value;
            if value > 0.0 {
                parameters.jac = value;
            }
        }
        ok
    }
    /// The value last written (rdjac).
    pub fn rdjac(&self, axis: usize) -> f64 {
        self.axes[axis].parameters.jac_written
    }
}

impl Axis {
    /// Whole turns, in degrees, by which a rotary axis comes to the same place as at `target` on a longer way. Half a
    /// turn keeps its direction.
    fn turns(&self, target: f64) -> f64 {
        let way = target - self.dp;
        let turns = (way.abs() / 360.0 - 0.5).ceil().max(0.0);
        if self.parameters.rotary { (360.0 * turns).copysign(way) } else { 0.0 }
    }
}
