//! Modal state of a program (docs/dialect.md, section 5). A block is resolved against a copy; only a good block is kept.

use motion_kernel::machine::Machine;

use crate::dialect::Dialect;
use crate::frame::{Frame, Zero};
use crate::group::{ContourGroup, Point};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionMode {
    Rapid,
    Line,
    Clockwise,
    CounterClockwise,
    /// G33
    Thread,
    /// A canned cycle, its G code in tenths.
    Cycle(u16),
    /// G80
    None,
    /// One that was refused (`aftermath.rs`).
    Unknown,
}

impl MotionMode {
    /// Its G code in tenths.
    pub const fn tenths(self) -> u16 {
        match self {
            MotionMode::Rapid => 0,
            MotionMode::Line => 10,
            MotionMode::Clockwise => 20,
            MotionMode::CounterClockwise => 30,
            MotionMode::Thread => 330,
            MotionMode::Cycle(code) => code,
            MotionMode::None | MotionMode::Unknown => 800,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    Xy,
    Zx,
    Yz,
}

impl Plane {
    /// Ordered axis pair and normal (section 7.1).
    pub const fn letters(self) -> ([u8; 2], u8) {
        match self {
            Plane::Xy => ([b'X', b'Y'], b'Z'),
            Plane::Zx => ([b'Z', b'X'], b'Y'),
            Plane::Yz => ([b'Y', b'Z'], b'X'),
        }
    }
    /// Centre letters of the pair, and the third.
    pub const fn centres(self) -> ([u8; 2], u8) {
        match self {
            Plane::Xy => ([b'I', b'J'], b'K'),
            Plane::Zx => ([b'K', b'I'], b'J'),
            Plane::Yz => ([b'J', b'K'], b'I'),
        }
    }
    pub const fn g(self) -> u16 {
        match self {
            Plane::Xy => 17,
            Plane::Zx => 18,
            Plane::Yz => 19,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedMode {
    /// G93
    InverseTime,
    /// G94
    PerMinute,
    /// G95
    PerRevolution,
}

impl FeedMode {
    /// Its G code in tenths.
    pub const fn tenths(self) -> u16 {
        match self {
            FeedMode::InverseTime => 930,
            FeedMode::PerMinute => 940,
            FeedMode::PerRevolution => 950,
        }
    }
}

/// F as programmed, and in mm with the unit active when it was programmed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feed {
    pub raw: f64,
    pub mm: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modal {
    pub motion: MotionMode,
    /// The last motion that was no cycle.
    pub simple_motion: MotionMode,
    pub plane: Plane,
    pub incremental: bool,
    /// G90.1 / G91.1 as programmed.
    pub centre_absolute: Option<bool>,
    pub feed_mode: FeedMode,
    pub inch: bool,
    /// 40, 41, 42
    pub correction: u16,
    /// 43, 44, 49
    pub length_code: u16,
    /// G60, G61
    pub exact: bool,
    /// Tolerance for merging, mm.
    pub tolerance: f64,
    /// G99: cycles return to R.
    pub return_to_r: bool,
    pub feed: Option<Feed>,
    /// G96
    pub cutting_speed: bool,
    pub speed: Option<f64>,
    pub speed_limit: Option<f64>,
    /// 3, 4 or 5
    pub spindle: u16,
    /// Flood (M08) and mist (M07).
    pub coolant: [bool; 2],
    pub override_on: bool,
    /// Preselected tool, and the one in the spindle.
    pub tool: u32,
    pub in_spindle: u32,
    /// Correction number of the lathe's T word, for G41 to G44 without D or H.
    pub tool_offset: Option<u32>,
    /// The last D word; where it is no modal word, only until the next tool.
    pub d: Option<u32>,
    /// A T word since the last M06.
    pub tool_named: bool,
    /// X words are diameters.
    pub diameter: bool,
    /// Slot and lead of G33, mm.
    pub lead: Option<(usize, f64)>,
    /// G07.1: slot of the rotary axis and radius of the surface, mm.
    pub cylinder: Option<(usize, f64)>,
}

impl Modal {
    pub fn reset(dialect: &Dialect, machine: &Machine) -> Self {
        Modal {
            motion: MotionMode::Rapid,
            simple_motion: MotionMode::Rapid,
            plane: if dialect.lathe { Plane::Zx } else { Plane::Xy },
            incremental: false,
            centre_absolute: None,
            feed_mode: if dialect.feed_per_revolution { FeedMode::PerRevolution } else { FeedMode::PerMinute },
            inch: false,
            correction: 40,
            length_code: 49,
            exact: false,
            tolerance: machine.gcode.merge_tolerance,
            return_to_r: false,
            feed: None,
            cutting_speed: false,
            speed: None,
            speed_limit: Some(machine.gcode.spindle.limit).filter(|limit| *limit > 0.0),
            spindle: 5,
            coolant: [false; 2],
            override_on: true,
            tool: 0,
            in_spindle: 0,
            tool_offset: None,
            d: None,
            tool_named: false,
            diameter: dialect.diameter,
            lead: None,
            cylinder: None,
        }
    }
    /// mm per programmed length unit.
    #[inline]
    pub fn unit(&self) -> f64 {
        if self.inch { 25.4 } else { 1.0 }
    }
}

/// Sticky words of a canned cycle, in program coordinates (mm).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CycleWords {
    pub bottom: Option<f64>,
    pub retract: Option<f64>,
    pub peck: Option<f64>,
    pub dwell_s: f64,
    /// Level from which the cycle was called first (G98).
    pub initial: f64,
}

/// What a block is resolved against.
#[derive(Clone, Debug)]
pub struct State {
    pub modal: Modal,
    pub frame: Frame,
    pub cycle: Option<CycleWords>,
    /// Present end of the path, in program and machine coordinates.
    pub program: Point,
    pub machine: Point,
    /// Slots whose position is unknown because a block with an error should have moved them.
    pub unknown: u32,
}

impl State {
    pub fn new(group: &ContourGroup, frame: Frame, modal: Modal) -> Self {
        let program = frame.to_program(&group.start);
        State { modal, frame, cycle: None, program, machine: group.start, unknown: 0 }
    }
    /// After any change of the frame: the machine stays, its program position is recomputed.
    pub fn reframe(&mut self) {
        self.frame.refresh();
        self.program = self.frame.to_program(&self.machine);
    }
    /// The active code of a modal group (`#4001`..), in the numbering of section 5; 0 for a cylinder that is off.
    pub fn group_code(&self, group: u32) -> Option<f64> {
        let (m, frame) = (&self.modal, &self.frame);
        let choose = |on: bool, yes: u16, no: u16| if on { yes } else { no };
        let tenths = match group {
            1 => m.motion.tenths(),
            2 => m.plane.g() * 10,
            3 => choose(m.incremental, 910, 900),
            4 => choose(m.centre_absolute == Some(true), 901, 911),
            5 => m.feed_mode.tenths(),
            6 => choose(m.inch, 200, 210),
            7 => m.correction * 10,
            8 => m.length_code * 10,
            9 => choose(m.exact, 610, 640),
            10 => choose(m.return_to_r, 990, 980),
            11 => self.zero_code().0,
            12 => choose(m.cutting_speed, 960, 970),
            13 => choose(frame.scale.is_some(), 510, 500),
            14 => choose(frame.mirror.iter().any(Option::is_some), 511, 501),
            15 => choose(frame.rotation.is_some(), 680, 690),
            16 => choose(m.cylinder.is_some(), 71, 0),
            _ => return None,
        };
        Some(f64::from(tenths) / 10.0)
    }
    /// The zero offset in force, and the number of G54.1.
    fn zero_code(&self) -> (u16, u16) {
        match self.frame.zero {
            Zero::Machine => (530, 0),
            Zero::Work(set) => (540 + 10 * set as u16, 0),
            Zero::Extra(n) => (541, n as u16),
        }
    }
    /// The active G codes in tenths, in the order in which operators read them.
    #[inline]
    pub fn codes(&self) -> Codes {
        let m = &self.modal;
        let (zero, extra) = self.zero_code();
        let choose = |on: bool, yes: u16, no: u16| if on { yes } else { no };
        Codes([
            m.motion.tenths(),
            m.plane.g() * 10,
            choose(m.incremental, 910, 900),
            choose(m.inch, 200, 210),
            m.feed_mode.tenths(),
            m.correction * 10,
            m.length_code * 10,
            choose(m.exact, 610, 640),
            zero,
            extra,
            choose(m.cylinder.is_some(), 71, 0),
        ])
    }
}

/// Active G codes, to be compared cheaply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Codes([u16; 11]);

impl std::fmt::Display for Codes {
    /// "G1 G17 G90 G21 G94 G40 G49 G64 G54"
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, tenths) in self.0[..9].iter().enumerate() {
            write!(f, "{}G{}", if i == 0 { "" } else { " " }, crate::codes::number(*tenths))?;
        }
        if self.0[9] != 0 {
            write!(f, " P{}", self.0[9])?;
        }
        if self.0[10] == 0 { Ok(()) } else { write!(f, " G{}", crate::codes::number(self.0[10])) }
    }
}
