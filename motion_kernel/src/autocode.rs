//! Autocode: the one instruction set that both languages compile to and that a CNC task executes.
//!
//! A program is a list of 8-byte instructions beside pools for what does not fit into one: motion
//! commands, numbers, texts. Motion leaves a task only as spooled or direct commands.
//! Numbers in motion commands are in PU/TU (mm, s) and in axis units (degrees) for rotary axes.

use crate::axes::{AxisList, AxisSet};

/// A block is slowed down to last so many samples at least (design D6).
pub const LEAST_SAMPLES: f64 = 1.6;

/// Kinds of spooled and direct motion commands; names are the manual's own (chapters 4.4, 6.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MoveKind {
    /// Linear, absolute target per axis.
    Smla,
    /// Linear, distance per axis.
    Smlr,
    /// Circle with two axes, absolute centre, signed angle.
    Smca,
    /// Circle with two axes, centre relative to the start.
    Smcr,
    /// Helix: circle with the first two axes, absolute linear targets for the others.
    Smha,
    /// Helix, centre and linear distances relative to the start.
    Smhr,
}

impl MoveKind {
    pub const ALL: [MoveKind; 6] =
        [MoveKind::Smla, MoveKind::Smlr, MoveKind::Smca, MoveKind::Smcr, MoveKind::Smha, MoveKind::Smhr];

    /// The command name as in the manual and in `translate --json`.
    pub const fn name(self) -> &'static str {
        match self {
            MoveKind::Smla => "smla",
            MoveKind::Smlr => "smlr",
            MoveKind::Smca => "smca",
            MoveKind::Smcr => "smcr",
            MoveKind::Smha => "smha",
            MoveKind::Smhr => "smhr",
        }
    }
    pub const fn is_relative(self) -> bool {
        matches!(self, MoveKind::Smlr | MoveKind::Smcr | MoveKind::Smhr)
    }
    pub const fn is_linear(self) -> bool {
        matches!(self, MoveKind::Smla | MoveKind::Smlr)
    }
}

/// One motion command (LMP, CMP, HMP of chapter 4.3.2) in the pool of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    pub kind: MoveKind,
    /// Rapid traverse (G00 and its kin): not feed time, no programmed F.
    pub rapid: bool,
    /// Index into [`Program::axis_lists`].
    pub axes: u16,
    /// First of the targets (or distances) in [`Program::numbers`], one per axis of the list in its order.
    /// Circles keep the end point of the two circle axes there too: the path as programmed needs it.
    pub target: u32,
    /// Path velocity, acceleration and target velocity, PU/TU and PU/TU².
    pub vl: f64,
    pub ac: f64,
    pub tvl: f64,
    /// Signed sweep in degrees, counter-clockwise positive; 0 for lines.
    pub phi: f64,
    /// Centre of the circle in the two circle axes; 0 for lines.
    pub center: [f64; 2],
    /// Blocks that a merged line replaces: range of [`Program::vias`].
    pub vias: (u32, u32),
}

/// The end point of a block that was merged into a longer line (design D6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Via {
    pub line: u32,
    /// First of the targets in [`Program::numbers`], as for the move that carries it.
    pub target: u32,
}

/// One instruction of a CNC task. Operands that do not fit are indices into the program's pools.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Instr {
    /// Spool the motion command of that number, for all its axes at once.
    Spool(u32),
    /// Spool one `ssf` for each axis of the set of [`Program::ssfs`].
    Ssf(u32),
    /// Start the spoolers of the set that stand in direct mode (design D23).
    Ssms(AxisSet),
    /// Start them, then wait until they are empty, back in direct mode and at profile end (G75).
    Drain(AxisSet),
    /// Wait until these axes are in position (axst ip).
    InPosition(AxisSet),
    /// Wait a number of samples without spooling anything (SAP `wt`).
    Wait(u32),
    /// Push a number of the pool.
    Number(u32),
    /// Push a common variable.
    LoadCi(u16),
    LoadCd(u16),
    /// Pop into a common variable at once (G-code assigns through `Ssf`, in step with motion).
    StoreCi(u16),
    StoreCd(u16),
    /// Pop into effradius of an axis (4.4.143), mm. Positions in degrees stay; so do the limits of the axis in degrees.
    EffRadius(u16),
    /// Local slots of the task.
    LoadLocal(u16),
    StoreLocal(u16),
    /// Arithmetic and comparison on the two topmost values; a comparison pushes 1 or 0.
    Binary(BinaryOp),
    Negate,
    Not,
    Jump(u32),
    JumpIfZero(u32),
    Call(u32),
    Return,
    /// Append a text of the pool, or the popped value, to the task's output string.
    WriteText(u32),
    WriteValue,
    /// Close the output string.
    Writeln,
    /// End of the program.
    Halt,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinaryOp {
    Add,
    Sub,
    Mul,
    Div,
    Mod,
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
    And,
    Or,
    Xor,
}

impl Instr {
    /// Statements count against the share of a task per sample (design D4); plain stack work does not.
    pub const fn is_statement(self) -> bool {
        !matches!(
            self,
            Instr::Number(_)
                | Instr::LoadCi(_)
                | Instr::LoadCd(_)
                | Instr::LoadLocal(_)
                | Instr::Binary(_)
                | Instr::Negate
                | Instr::Not
        )
    }
}

/// A spool special function (4.4.123) for every axis of a set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ssf {
    pub axes: AxisSet,
    pub command: u16,
    pub value: f64,
}

/// What the application does when a block becomes active: the number is written into the common
/// integer [`HOST_EVENT_CI`] by a spooled function, so it happens in step with motion.
#[derive(Clone, Debug, PartialEq)]
pub struct HostEvent {
    pub line: u32,
    /// "MSG", "M00", "M01", "M06", "T", "M30" ...
    pub kind: String,
    /// Text for the operator, tool number and the like.
    pub text: String,
}

/// `ssf(axis, 198, n + 1)` announces host event n of the program.
pub const HOST_EVENT_CI: u16 = 198;

/// A compiled program, or a segment of one that is executed as it comes (see `Mcu::load_segments`). Immutable once built.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    pub code: Vec<Instr>,
    /// 1-based source line of each instruction, parallel to `code`.
    pub lines: Vec<u32>,
    pub moves: Vec<Move>,
    pub ssfs: Vec<Ssf>,
    pub numbers: Vec<f64>,
    pub axis_lists: Vec<AxisList>,
    pub vias: Vec<Via>,
    pub texts: Vec<String>,
    pub events: Vec<HostEvent>,
    /// Events of the segments before this one: `events[0]` is announced as `first_event + 1`.
    pub first_event: u32,
    /// Axes of the contour group; spooling starts by itself when `start_fill` commands wait (din66025.md 17).
    pub group: AxisSet,
    /// 0: only `Ssms` and a full spooler (AutoSpool) start it.
    pub start_fill: u32,
}

impl Program {
    /// The axes of a move in the order of its command.
    pub fn axes_of(&self, mv: &Move) -> &AxisList {
        &self.axis_lists[mv.axes as usize]
    }
    /// Targets of a move, one per axis of [`Program::axes_of`].
    pub fn targets_of(&self, mv: &Move) -> &[f64] {
        let first = mv.target as usize;
        &self.numbers[first..first + self.axes_of(mv).len()]
    }
    /// End points of the blocks a merged line replaces, without the last.
    pub fn vias_of(&self, mv: &Move) -> &[Via] {
        &self.vias[mv.vias.0 as usize..mv.vias.1 as usize]
    }
    /// The event that `ssf(axis, 198, number)` announces.
    pub fn event(&self, number: f64) -> Option<&HostEvent> {
        (number as usize).checked_sub(self.first_event as usize + 1).and_then(|n| self.events.get(n))
    }
    pub fn via_targets(&self, mv: &Move, via: &Via) -> &[f64] {
        let first = via.target as usize;
        &self.numbers[first..first + self.axes_of(mv).len()]
    }
}

/// Writes a program: the narrow waist that both compilers emit through.
#[derive(Debug, Default)]
pub struct Builder {
    program: Program,
}

impl Builder {
    pub fn new(group: AxisSet, start_fill: u32) -> Self {
        Builder { program: Program { group, start_fill, ..Program::default() } }
    }
    /// Appends an instruction and returns its address.
    pub fn emit(&mut self, line: u32, instr: Instr) -> u32 {
        self.program.code.push(instr);
        self.program.lines.push(line);
        (self.program.code.len() - 1) as u32
    }
    pub fn axis_list(&mut self, list: AxisList) -> u16 {
        let known = self.program.axis_lists.iter().position(|l| *l == list);
        known.unwrap_or_else(|| {
            self.program.axis_lists.push(list);
            self.program.axis_lists.len() - 1
        }) as u16
    }
    /// Stores numbers and returns the index of the first.
    pub fn numbers(&mut self, values: &[f64]) -> u32 {
        self.program.numbers.extend_from_slice(values);
        (self.program.numbers.len() - values.len()) as u32
    }
    pub fn via(&mut self, via: Via) -> u32 {
        self.program.vias.push(via);
        (self.program.vias.len() - 1) as u32
    }
    pub fn via_count(&self) -> u32 {
        self.program.vias.len() as u32
    }
    pub fn spool(&mut self, line: u32, mv: Move) -> u32 {
        self.program.moves.push(mv);
        self.emit(line, Instr::Spool((self.program.moves.len() - 1) as u32))
    }
    pub fn ssf(&mut self, line: u32, ssf: Ssf) -> u32 {
        self.program.ssfs.push(ssf);
        self.emit(line, Instr::Ssf((self.program.ssfs.len() - 1) as u32))
    }
    /// Announces a host event in step with motion, on the spooler of one axis.
    pub fn event(&mut self, axis: usize, event: HostEvent) -> u32 {
        let line = event.line;
        self.program.events.push(event);
        let number = f64::from(self.program.first_event + self.program.events.len() as u32);
        self.ssf(line, Ssf { axes: AxisSet::single(axis), command: HOST_EVENT_CI, value: number })
    }
    pub fn text(&mut self, text: &str) -> u32 {
        self.program.texts.push(text.to_owned());
        (self.program.texts.len() - 1) as u32
    }
    /// Changes the last move, e.g. to lower its target velocity once the next block is known.
    pub fn last_move_mut(&mut self) -> Option<&mut Move> {
        self.program.moves.last_mut()
    }
    pub fn here(&self) -> u32 {
        self.program.code.len() as u32
    }
    /// Sets the target of a jump emitted before its destination was known.
    pub fn patch(&mut self, at: u32, target: u32) {
        match &mut self.program.code[at as usize] {
            Instr::Jump(t) | Instr::JumpIfZero(t) | Instr::Call(t) => *t = target,
            other => unreachable!("no jump at {at}: {other:?}"),
        }
    }
    pub fn finish(self) -> Program {
        self.program
    }
    /// What is written so far as a segment of its own; the next one numbers its events on.
    pub fn cut(&mut self) -> Program {
        let Program { group, start_fill, first_event, .. } = self.program;
        let first_event = first_event + self.program.events.len() as u32;
        std::mem::replace(&mut self.program, Program { group, start_fill, first_event, ..Program::default() })
    }
}
