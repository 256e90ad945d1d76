//! What is recorded per sample: columns, allocated once, filled without allocation.

use crate::resources::Scan;

/// Bits of [`Trace::flags`].
pub mod flag {
    pub const MOVING: u32 = 1;
    pub const RAPID: u32 = 1 << 1;
    /// A wait of the spooler (ssf 1000..1025).
    pub const WAITING: u32 = 1 << 2;
    /// Feed hold, braking or standing.
    pub const HELD: u32 = 1 << 3;
    pub const DIRECT: u32 = 1 << 4;
    /// From here on: what limits the path velocity, as [`crate::cause::Limit`].
    pub const LIMIT_SHIFT: u32 = 8;
}

/// A chunk of samples. Matrices are row-major, one row of `axes` values per sample. Row k is the state at the
/// end of sample interval `first_sample + k`, i.e. at time (first_sample + k + 1) * sample time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    pub first_sample: u64,
    pub axes: usize,
    /// Set points, axis units (mm, degrees).
    pub dp: Vec<f64>,
    /// Load-side actual position (design D21).
    pub load: Vec<f64>,
    /// Encoder position: whole counts per counts_per_unit.
    pub rp: Vec<f64>,
    /// Source line and number (1-based, in order of execution) of the motion command that the first group
    /// axis executes; 0 = none.
    pub line: Vec<u32>,
    pub entry: Vec<u32>,
    /// Nominal path velocity at factor 1, and the effective override.
    pub v_plan: Vec<f64>,
    pub factor: Vec<f64>,
    /// Bits of [`flag`], and the cause that limits the path velocity.
    pub flags: Vec<u32>,
    /// Rows of the scanner; empty without one.
    pub scan: Scan,
}

impl Trace {
    /// Room for `samples` rows of `axes` axes.
    pub fn new(axes: usize, samples: usize) -> Self {
        Trace {
            first_sample: 0,
            axes,
            dp: Vec::with_capacity(axes * samples),
            load: Vec::with_capacity(axes * samples),
            rp: Vec::with_capacity(axes * samples),
            line: Vec::with_capacity(samples),
            entry: Vec::with_capacity(samples),
            v_plan: Vec::with_capacity(samples),
            factor: Vec::with_capacity(samples),
            flags: Vec::with_capacity(samples),
            scan: Scan::default(),
        }
    }
    /// Samples recorded.
    pub fn len(&self) -> usize {
        self.flags.len()
    }
    pub fn is_empty(&self) -> bool {
        self.flags.is_empty()
    }
    /// Empties the chunk; the next row is that of sample `first_sample`.
    pub fn restart(&mut self, first_sample: u64) {
        self.first_sample = first_sample;
        for column in [&mut self.dp, &mut self.load, &mut self.rp, &mut self.v_plan, &mut self.factor] {
            column.clear();
        }
        for column in [&mut self.line, &mut self.entry, &mut self.flags] {
            column.clear();
        }
    }
    /// Makes room for `samples` rows in all, so that recording them allocates nothing.
    pub fn reserve(&mut self, samples: usize) {
        for column in [&mut self.dp, &mut self.load, &mut self.rp] {
            column.reserve((samples * self.axes).saturating_sub(column.len()));
        }
        for column in [&mut self.v_plan, &mut self.factor] {
            column.reserve(samples.saturating_sub(column.len()));
        }
        for column in [&mut self.line, &mut self.entry, &mut self.flags] {
            column.reserve(samples.saturating_sub(column.len()));
        }
        self.scan.reserve(samples);
    }
}

/// What kind of thing happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// An axst bit of an axis: see `name`.
    Axst,
    /// An ErrorReg bit was set.
    ErrorReg,
    /// A host event of the program: `value` is its index in `Program::events`.
    Host,
    /// ssf 1001/1002 changed outputs: `value` holds the outputs of the axis after it.
    Outputs,
    /// The spooler began or ended a wait for the application (ssf 1000, 1005, 1015, 1025): `value` = command.
    Wait,
    /// The world outside: an input or a fault that a stimulus plays (`name`); `value` = number of the input.
    Stimulus,
    /// A task stopped with a runtime error: `value` = error number, `axis` = task.
    Task,
}

impl EventKind {
    pub const fn name(self) -> &'static str {
        match self {
            EventKind::Axst => "axst",
            EventKind::ErrorReg => "errorreg",
            EventKind::Host => "host",
            EventKind::Outputs => "outputs",
            EventKind::Wait => "wait",
            EventKind::Stimulus => "stimulus",
            EventKind::Task => "task",
        }
    }
}

/// Something that the application wants to know, with the sample in which it happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    pub sample: u64,
    pub kind: EventKind,
    /// Axis (or task) index; -1 for the controller as a whole.
    pub axis: i32,
    pub name: &'static str,
    pub on: bool,
    pub line: u32,
    pub value: i64,
}

/// A bounded list of events; when it is full, later ones are counted and dropped.
#[derive(Debug)]
pub struct Events {
    list: Vec<Event>,
    pub lost: u64,
}

impl Default for Events {
    fn default() -> Self {
        Events { list: Vec::with_capacity(Self::CAPACITY), lost: 0 }
    }
}

impl Events {
    pub const CAPACITY: usize = 8192;

    pub fn push(&mut self, event: Event) {
        if self.list.len() < Self::CAPACITY {
            self.list.push(event);
        } else {
            self.lost += 1;
        }
    }
    /// True when the application had better drain the list.
    pub fn is_nearly_full(&self) -> bool {
        self.list.len() > Self::CAPACITY / 2
    }
    pub fn drain(&mut self) -> Vec<Event> {
        self.list.drain(..).collect()
    }
}
