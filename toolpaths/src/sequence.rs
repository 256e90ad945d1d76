//! The columns of a translated program (one row per motion command, in execution order) and their checks.

use std::fmt;

/// Columns of the sequence, borrowed from wherever they live (a compiled program, NumPy arrays).
/// `n` motion commands, `axes` axes of the machine, absolute machine coordinates in axis units (mm, degrees).
#[derive(Clone, Copy, Debug)]
pub struct SequenceView<'a> {
    pub axes: usize,
    /// Position before the first command, one per axis.
    pub start: &'a [f64],
    /// 0 line, 1 circle or helix, 2 circle in space.
    pub kind: &'a [u8],
    /// 1-based source line.
    pub line: &'a [u32],
    pub rapid: &'a [bool],
    /// (n, axes): position of all axes after the move.
    pub target: &'a [f64],
    /// First and second circle axis; unused for lines.
    pub c1: &'a [u8],
    pub c2: &'a [u8],
    /// (n, 2): centre in the circle axes.
    pub center: &'a [f64],
    /// Degrees, counter-clockwise positive from `c1` to `c2`.
    pub phi: &'a [f64],
    /// Programmed path velocity, mm/s.
    pub vl: &'a [f64],
    /// End points of the blocks that a merged line replaces, without the last: rows of `via_line`, `via_target`.
    pub via_first: &'a [u32],
    pub via_count: &'a [u32],
    pub via_line: &'a [u32],
    /// (m, axes)
    pub via_target: &'a [f64],
    /// (k, axes): effective radius of rotary axes, mm; NaN for axes that count in their own unit.
    pub effradius: &'a [f64],
    /// (n): row of `effradius` that holds for the move.
    pub effradius_of: &'a [u16],
    /// What only commands of rw_SymPas jobs have; empty columns where there are none.
    pub space: Space<'a>,
}

/// Circles in space (kind 2, in the axes `c1`, `c2`, `c3`), and moves that do not begin where the one before ended.
#[derive(Clone, Copy, Debug, Default)]
pub struct Space<'a> {
    /// (n, axes): position of all axes before the move, or empty: that after the move before.
    pub begin: &'a [f64],
    /// (n), (n, 3), (n, 3) or empty: third axis, centre in axis units, normal of the plane in the metric of the path.
    pub c3: &'a [u8],
    pub center: &'a [f64],
    pub normal: &'a [f64],
}

/// Why a sequence is no path. `line` is the source line, `command` counts motion commands from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum PathError {
    /// A column has the wrong length.
    Column { name: &'static str, expected: usize, found: usize },
    /// More axes than the controller has (18), or none.
    Axes { found: usize },
    /// A value is not finite or outside its range.
    Value { command: usize, line: u32, what: &'static str },
    /// Centre and angle do not lead from the start to the stated target.
    ArcEnd { command: usize, line: u32, off_mm: f64 },
}

impl fmt::Display for PathError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PathError::Column { name, expected, found } => {
                write!(f, "sequence column {name} has {found} values, expected {expected}")
            }
            PathError::Axes { found } => write!(f, "{found} axes: a path needs 1 to {MAX_AXES}"),
            PathError::Value { command, line, what } => write!(f, "line {line}, motion command {command}: {what}"),
            PathError::ArcEnd { command, line, off_mm } => write!(
                f,
                "line {line}, motion command {command}: centre and angle of the arc end {off_mm:.3e} mm off its target"
            ),
        }
    }
}

impl PathError {
    /// Counts motion commands behind those that were there before.
    pub(crate) fn behind(mut self, commands: usize) -> Self {
        if let PathError::Value { command, .. } | PathError::ArcEnd { command, .. } = &mut self {
            *command += commands;
        }
        self
    }
}

impl std::error::Error for PathError {}

/// Axes of the controller (design D12).
pub const MAX_AXES: usize = 18;

impl SequenceView<'_> {
    pub fn len(&self) -> usize {
        self.kind.len()
    }
    pub fn is_empty(&self) -> bool {
        self.kind.is_empty()
    }

    /// Checks shapes and values once, so that the geometry can index freely.
    pub fn check(&self) -> Result<(), PathError> {
        if self.axes == 0 || self.axes > MAX_AXES {
            return Err(PathError::Axes { found: self.axes });
        }
        self.check_shapes()?;
        for i in 0..self.len() {
            if let Some(what) = self.fault_of(i) {
                return Err(PathError::Value { command: i + 1, line: self.line[i], what });
            }
        }
        match self.start.iter().all(|x| x.is_finite()) {
            true => Ok(()),
            false => Err(PathError::Value { command: 0, line: 0, what: "start position is not finite" }),
        }
    }

    fn check_shapes(&self) -> Result<(), PathError> {
        let (n, a, m) = (self.len(), self.axes, self.via_line.len());
        let columns = [
            ("start", self.start.len(), a),
            ("line", self.line.len(), n),
            ("rapid", self.rapid.len(), n),
            ("target", self.target.len(), n * a),
            ("c1", self.c1.len(), n),
            ("c2", self.c2.len(), n),
            ("center", self.center.len(), n * 2),
            ("phi", self.phi.len(), n),
            ("vl", self.vl.len(), n),
            ("via_first", self.via_first.len(), n),
            ("via_count", self.via_count.len(), n),
            ("via_target", self.via_target.len(), m * a),
            ("effradius_of", self.effradius_of.len(), n),
            ("effradius", self.effradius.len(), self.effradius.len() / a * a),
            ("begin", self.space.begin.len(), if self.space.begin.is_empty() { 0 } else { n * a }),
            ("c3", self.space.c3.len(), if self.space.c3.is_empty() { 0 } else { n }),
            ("center3", self.space.center.len(), self.space.c3.len() * 3),
            ("normal", self.space.normal.len(), self.space.c3.len() * 3),
        ];
        match columns.into_iter().find(|&(_, found, expected)| found != expected) {
            Some((name, found, expected)) => Err(PathError::Column { name, expected, found }),
            None => Ok(()),
        }
    }

    fn fault_of(&self, i: usize) -> Option<&'static str> {
        let a = self.axes;
        let row = usize::from(self.effradius_of[i]);
        let vias = self.via_first[i] as usize..self.via_first[i] as usize + self.via_count[i] as usize;
        let finite = |values: &[f64]| values.iter().all(|x| x.is_finite());
        if !finite(&self.target[i * a..(i + 1) * a]) {
            return Some("target is not finite");
        }
        if !finite(self.space.begin.get(i * a..(i + 1) * a).unwrap_or(&[])) {
            return Some("begin is not finite");
        }
        if !(self.vl[i] > 0.0 && self.vl[i].is_finite()) {
            return Some("path velocity is not a positive number");
        }
        if vias.end > self.via_line.len() || !finite(&self.via_target[vias.start * a..vias.end * a]) {
            return Some("via points are missing or not finite");
        }
        if (row + 1) * a > self.effradius.len() {
            return Some("row of effective radii is missing");
        }
        if self.effradius[row * a..(row + 1) * a].iter().any(|r| r.is_infinite() || *r < 0.0) {
            return Some("effective radius is negative or not finite");
        }
        match self.kind[i] {
            0 => None,
            1 => self.arc_fault_of(i),
            2 => self.ring_fault_of(i),
            _ => Some("kind is neither line nor circle"),
        }
    }

    fn ring_fault_of(&self, i: usize) -> Option<&'static str> {
        let Some(&c3) = self.space.c3.get(i) else { return Some("columns of circles in space are missing") };
        let [a, b, c] = [self.c1[i], self.c2[i], c3].map(usize::from);
        if a.max(b).max(c) >= self.axes || a == b || b == c || a == c {
            return Some("circle axes are not three different axes of the machine");
        }
        if self.via_count[i] > 0 {
            return Some("an arc cannot have via points");
        }
        let numbers = [&self.space.center[3 * i..3 * i + 3], &self.space.normal[3 * i..3 * i + 3], &self.phi[i..=i]];
        (!numbers.concat().iter().all(|x| x.is_finite())).then_some("centre, normal or angle is not finite")
    }

    fn arc_fault_of(&self, i: usize) -> Option<&'static str> {
        let (c1, c2) = (usize::from(self.c1[i]), usize::from(self.c2[i]));
        if c1 >= self.axes || c2 >= self.axes || c1 == c2 {
            return Some("circle axes are not two different axes of the machine");
        }
        if self.via_count[i] > 0 {
            return Some("an arc cannot have via points");
        }
        let numbers = [self.center[2 * i], self.center[2 * i + 1], self.phi[i]];
        (!numbers.iter().all(|x| x.is_finite())).then_some("centre or angle is not finite")
    }
}
