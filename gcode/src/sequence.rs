//! The motion commands as columns, for path checks and plots: one row per command, in execution order.

use motion_kernel::autocode::{Instr, Move, Program};
use motion_kernel::machine::{Axis, AxisKind, Machine};
use motion_kernel::registers::ModeReg;

/// `a` axes of the machine, `n` motion commands, `m` passed-over points; two-dimensional columns are row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SequenceColumns {
    pub axes: usize,
    /// (a) position before the first command; machine coordinates, mm or degrees.
    pub start: Vec<f64>,
    /// (n) 0 line, 1 circle or helix.
    pub kind: Vec<u8>,
    /// (n) 1-based source line.
    pub line: Vec<u32>,
    pub rapid: Vec<bool>,
    /// (n, a) absolute positions of all axes after the command.
    pub target: Vec<f64>,
    /// (n) circle axes, first and second of the plane.
    pub c1: Vec<u8>,
    pub c2: Vec<u8>,
    /// (n, 2)
    pub center: Vec<f64>,
    /// (n) degrees, counter-clockwise positive.
    pub phi: Vec<f64>,
    /// (n) path velocity, acceleration, target velocity: mm/s, mm/s².
    pub vl: Vec<f64>,
    pub ac: Vec<f64>,
    pub tvl: Vec<f64>,
    /// (n) range of `via_line` and `via_target` for the blocks a merged line replaces, without the last.
    pub via_first: Vec<u32>,
    pub via_count: Vec<u32>,
    /// (m)
    pub via_line: Vec<u32>,
    /// (m, a)
    pub via_target: Vec<f64>,
    /// (k, a) effective radii, mm; NaN for linear axes, 0 where the axis is no part of the path.
    pub effradius: Vec<f64>,
    /// (n) row of `effradius`.
    pub effradius_of: Vec<u16>,
}

/// The motion commands of a program.
pub fn sequence(program: &Program, machine: &Machine) -> SequenceColumns {
    Sequencer::new(machine).next(program)
}

/// Turns a program into columns, segment by segment.
pub struct Sequencer {
    position: Vec<f64>,
    radii: Radii,
}

impl Sequencer {
    pub fn new(machine: &Machine) -> Self {
        Sequencer { position: machine.axes.iter().map(|axis| axis.start).collect(), radii: Radii::new(machine) }
    }
    /// The columns of the next segment; `start` is where the one before it ends.
    pub fn next(&mut self, program: &Program) -> SequenceColumns {
        let a = self.position.len();
        let mut columns = SequenceColumns { axes: a, start: self.position.clone(), ..SequenceColumns::default() };
        columns.effradius.extend(&self.radii.now);
        for (&line, instr) in program.lines.iter().zip(&program.code) {
            if self.radii.follow(instr, program) {
                columns.effradius.extend(&self.radii.now);
            }
            if let Instr::Spool(number) = instr {
                self.push(&mut columns, program, line, &program.moves[*number as usize]);
            }
        }
        columns
    }
    fn push(&mut self, columns: &mut SequenceColumns, program: &Program, line: u32, mv: &Move) {
        let (axes, vias) = (program.axes_of(mv), program.vias_of(mv));
        columns.via_first.push(columns.via_line.len() as u32);
        columns.via_count.push(vias.len() as u32);
        let radii = &self.radii;
        for via in vias {
            columns.via_line.push(via.line);
            let first = columns.via_target.len();
            columns.via_target.extend_from_slice(&self.position);
            let row = &mut columns.via_target[first..];
            axes.iter().zip(program.via_targets(mv, via)).for_each(|(axis, v)| row[axis] = radii.axis_unit(axis, *v));
        }
        for (axis, v) in axes.iter().zip(program.targets_of(mv)) {
            self.position[axis] = radii.axis_unit(axis, *v);
        }
        let linear = mv.kind.is_linear();
        columns.kind.push(u8::from(!linear));
        columns.line.push(line);
        columns.rapid.push(mv.rapid);
        columns.target.extend_from_slice(&self.position);
        columns.c1.push(if linear { 0 } else { axes.at(0) as u8 });
        columns.c2.push(if linear { 0 } else { axes.at(1) as u8 });
        let center = |i: usize| if linear { 0.0 } else { radii.axis_unit(axes.at(i), mv.center[i]) };
        columns.center.extend([center(0), center(1)]);
        columns.phi.push(mv.phi);
        columns.vl.push(mv.vl);
        columns.ac.push(mv.ac);
        columns.tvl.push(mv.tvl);
        columns.effradius_of.push((columns.effradius.len() / columns.axes - 1) as u16);
    }
}

/// The effective radii while a program is read from its first instruction to its last.
pub(crate) struct Radii {
    /// Per axis, mm; NaN for linear axes, 0 for those that are no part of the path.
    pub now: Vec<f64>,
    /// mm per degree of the machine file, for axes that do not count.
    own: Vec<f64>,
    in_degrees: bool,
    pushed: f64,
}

impl Radii {
    pub fn new(machine: &Machine) -> Self {
        let gcode = &machine.gcode;
        let radius = |(index, axis): (usize, &Axis)| match axis.kind {
            // no part of the path: NFRAX axes, and a spindle that turns by its motor command
            _ if gcode.nfrax.contains(&index) || gcode.spindle.command.is_some_and(|c| c.0 == index) => 0.0,
            AxisKind::Rotary => axis.effradius,
            AxisKind::Linear => f64::NAN,
        };
        let in_degrees = ModeReg(gcode.modereg).has(ModeReg::RotatoricUnit);
        let own = machine.axes.iter().map(|a| a.effradius.to_radians()).collect();
        Radii { now: machine.axes.iter().enumerate().map(radius).collect(), own, in_degrees, pushed: 0.0 }
    }
    /// True if the instruction changes a radius.
    pub fn follow(&mut self, instr: &Instr, program: &Program) -> bool {
        match *instr {
            Instr::Number(n) => self.pushed = program.numbers[n as usize],
            Instr::EffRadius(axis) => {
                self.now[usize::from(axis)] = self.pushed;
                return true;
            }
            _ => {}
        }
        false
    }
    /// A position of a command in degrees, where rotary positions are spooled as mm of circumference.
    pub fn axis_unit(&self, axis: usize, value: f64) -> f64 {
        match self.now[axis] {
            _ if self.in_degrees => value,
            radius if radius.is_nan() => value,
            0.0 => value / self.own[axis],
            radius => value / radius.to_radians(),
        }
    }
}
