//! What was spooled, while it runs: the listing of jobs whose motion is known only then (rw_SymPas).
//!
//! Rows hold positions in axis units, resolved (absolute, with the start) but not rounded to counts: what was asked for,
//! not what was made of it. Nothing is recorded before [`Mcu::list_commands`].

use crate::axes::MAX_AXES;
use crate::circle_3d::Space;
use crate::mcu::Mcu;
use crate::motion::MotionCommand;
use crate::path::{Component, Geometry};
use crate::registers::ModeReg;

/// A spooled motion command.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// As in [`crate::trace::Trace::entry`].
    pub number: u32,
    pub name: &'static str,
    /// CNC task that gave it, and its source line.
    pub task: u8,
    pub line: u32,
    /// 0 line, 1 circle or helix, 2 circle in space.
    pub kind: u8,
    /// Set of its axes, and those of the circle.
    pub axes: u32,
    pub circle: [u8; 3],
    /// Position of all axes before and after it.
    pub start: [f64; MAX_AXES],
    pub target: [f64; MAX_AXES],
    pub center: [f64; 3],
    /// Of circles in space, in the metric of the path.
    pub normal: [f64; 3],
    pub phi: f64,
    /// mm and s.
    pub vl: f64,
    pub ac: f64,
    pub tvl: f64,
    /// Effective radius, mm; NaN for linear axes, 0 where the axis does not count for the path (NFRAX, or not its own).
    pub radius: [f64; MAX_AXES],
    /// How far its end may be off, mm, because it stops and its axes are rounded to counts; else 0.
    pub rounding: f64,
}

/// What a command has come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Came {
    /// The sample is the first in which its first axis is on it.
    Begun,
    /// The sample is the last in which its last axis was on it.
    Done,
    /// An axis left it before its end, or it was cut short: the last sample on it.
    Cut,
}

/// Rows and what became of them, in order, since they were last taken.
#[derive(Debug)]
pub struct Listing {
    pub rows: Vec<Row>,
    /// Number of the command, sample.
    pub passed: Vec<(u32, u64, Came)>,
    /// Spool functions (ssf) entered, one for each axis.
    pub functions: u64,
    /// Rows and passages that found no room.
    pub lost: u64,
}

impl Listing {
    const CAPACITY: usize = 8192;

    fn new() -> Listing {
        let (rows, passed) = (Vec::with_capacity(Self::CAPACITY), Vec::with_capacity(2 * Self::CAPACITY));
        Listing { rows, passed, functions: 0, lost: 0 }
    }
    /// The application had better take it.
    pub(crate) fn is_nearly_full(&self) -> bool {
        self.rows.len() > Self::CAPACITY / 2 || self.passed.len() > Self::CAPACITY
    }
    fn pass(&mut self, number: u32, sample: u64, came: Came) {
        if self.passed.len() < self.passed.capacity() {
            self.passed.push((number, sample, came));
        } else {
            self.lost += 1;
        }
    }
}

impl Mcu {
    /// From now on spooled commands are listed; [`Mcu::advance`] comes back with [`crate::Stop::Events`] when the list
    /// had better be taken.
    pub fn list_commands(&mut self) {
        self.listing.get_or_insert_with(|| Box::new(Listing::new()));
    }
    /// What was listed since the last call; empty without [`Mcu::list_commands`].
    pub fn take_listing(&mut self) -> Listing {
        match &mut self.listing {
            Some(listing) => *std::mem::replace(listing, Box::new(Listing::new())),
            None => Listing { rows: Vec::new(), passed: Vec::new(), functions: 0, lost: 0 },
        }
    }

    /// Lists a command that is about to enter the spoolers of its axes; its number is that of the command before + 1.
    #[cold]
    pub(crate) fn list(
        &mut self,
        command: &MotionCommand,
        space: Option<&Space>,
        geometry: &Geometry,
        components: &[Component],
    ) {
        let row = self.row_of(command, space, geometry, components);
        let Some(listing) = &mut self.listing else { return };
        if listing.rows.len() < listing.rows.capacity() {
            listing.rows.push(row);
        } else {
            listing.lost += 1;
        }
    }

    fn row_of(
        &self,
        command: &MotionCommand,
        space: Option<&Space>,
        geometry: &Geometry,
        components: &[Component],
    ) -> Row {
        let list = command.axes;
        let (relative, linear) = (command.kind.is_relative(), command.kind.is_linear());
        let mut row = self.blank_row(command, space);
        let [x, y] = command.center;
        let given = space.map_or([x, y, 0.0], |space| space.center);
        let turned = crate::path::point(geometry.length, geometry.curvature);
        for (i, (a, component)) in list.iter().zip(components).enumerate() {
            let (unit, start) = (self.command_unit(a), self.axes[a].queue_end);
            let from = if relative { start } else { 0.0 };
            row.start[a] = start;
            row.target[a] = if component.is_circle() {
                component.base + component.p * turned.cos + component.q * turned.sin
            } else {
                from + command.targets[i] * unit
            };
            if i < 3 {
                row.circle[i] = a as u8;
                row.center[i] = from + given[i] * unit;
            }
        }
        if !linear && command.phi.abs() <= 1e-100 {
            row.phi = (geometry.curvature * geometry.length).to_degrees();
        }
        row
    }

    /// What does not depend on the course; axes that take no part are where they are.
    fn blank_row(&self, command: &MotionCommand, space: Option<&Space>) -> Row {
        let axes = command.axes.set();
        let feeds = axes.iter().any(|a| !self.registers.nfrax.contains(a));
        let at = |a: usize| self.axes.get(a).map_or(0.0, |axis| axis.dp);
        let here: [f64; MAX_AXES] = std::array::from_fn(at);
        let radius = |a: usize| match self.axes.get(a) {
            Some(axis) if axes.contains(a) && !(feeds && self.registers.nfrax.contains(a)) => {
                if axis.parameters.rotary { axis.parameters.scale.to_degrees() } else { f64::NAN }
            }
            _ => 0.0,
        };
        let rounds = command.tvl == 0.0 && !self.registers.modereg.has(ModeReg::ExactTargetPos);
        let half_count = |a: usize| {
            let parameters = &self.axes[a].parameters;
            0.5 / parameters.counts_per_unit * parameters.scale
        };
        Row {
            number: self.commands,
            name: match (space, command.kind.is_relative()) {
                (None, _) => command.kind.name(),
                (Some(_), false) => "smca3d",
                (Some(_), true) => "smcr3d",
            },
            task: self.commanding,
            line: command.line,
            kind: if space.is_some() { 2 } else { u8::from(!command.kind.is_linear()) },
            axes: axes.0,
            circle: [0; 3],
            start: here,
            target: here,
            center: [0.0; 3],
            normal: space.map_or([0.0; 3], |space| space.normal),
            phi: command.phi,
            vl: command.vl,
            ac: command.ac,
            tvl: command.tvl,
            radius: std::array::from_fn(radius),
            rounding: if rounds { axes.iter().map(half_count).fold(0.0, f64::hypot) } else { 0.0 },
        }
    }

    /// A spooled move has begun, or is over in this sample.
    #[inline]
    pub(crate) fn tell_passage(&mut self, slot: u32, came: Came) {
        if let Some(listing) = &mut self.listing
            && !self.moves[slot].direct
        {
            listing.pass(self.moves[slot].number, self.sample, came);
        }
    }
    /// An axis leaves a move between samples, or before it was evaluated in this one.
    pub(crate) fn tell_cut(&mut self, slot: u32) {
        if let Some(listing) = &mut self.listing
            && self.moves[slot].planned
            && !self.moves[slot].direct
        {
            listing.pass(self.moves[slot].number, self.sample.saturating_sub(1), Came::Cut);
        }
    }
    pub(crate) fn tell_function(&mut self) {
        if let Some(listing) = &mut self.listing {
            listing.functions += 1;
        }
    }
}
