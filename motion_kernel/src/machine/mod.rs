//! The machine file: it stands for system.dat (design 3.5). Read once, validated once, then immutable.

use crate::axes::AxisSet;

mod file;
mod section;
mod show;

pub use file::{AXIS_LETTERS, BUILTIN};
pub use section::{MC_IDS, MachineDiagnostic, nearest};

/// A machine as the kernel and the compilers see it. Lengths in mm, rotary positions in degrees,
/// times in s, velocities and accelerations per second.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    pub name: String,
    pub axes: Vec<Axis>,
    pub controller: Controller,
    pub gcode: GcodeDefaults,
    /// Verdict limit of the contour deviation, mm.
    pub tolerance_mm: f64,
}

/// Settings of the control card as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    /// Sample time in units of 64 us (20 = 1.28 ms).
    pub sample_ticks: u32,
    pub spool_memory_bytes: u32,
    /// Samples from a direct command to its effect (design D2).
    pub direct_latency: u32,
    /// Statements of a CNC task per sample (design D4).
    pub statements_per_sample: u32,
    /// Look-ahead depth in entries; 0 = the whole spooler.
    pub lookahead_depth: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveKind {
    Servo,
    Stepper,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisKind {
    /// mm
    Linear,
    /// degrees
    Rotary,
}

/// Function of a limit (chapter 2.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitFunction {
    Off,
    /// Turn off motor, stop motor abruptly, stop motor with deceleration.
    Tom,
    Sma,
    Smd,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name of up to 8 characters; its first character need not be the letter of part programs.
    pub name: String,
    /// Address letter in part programs, if they may use the axis.
    pub letter: Option<char>,
    pub drive: DriveKind,
    pub kind: AxisKind,
    /// Encoder counts (stepper: steps) per mm or degree.
    pub counts_per_unit: f64,
    pub rapid: f64,
    /// What the drive can accelerate.
    pub acceleration: f64,
    /// Jog velocity, acceleration and stop deceleration (jvl, jac, sdec).
    pub jog_velocity: f64,
    pub jog_acceleration: f64,
    pub stop_deceleration: f64,
    /// Look-ahead and checks (4.4.160..163); 0 = not watched.
    pub mdvel: f64,
    pub maxvel: f64,
    pub maxacc: f64,
    /// Shape of S ramps 0..1.
    pub jerkrel: f64,
    /// Following error limit and in-position window.
    pub mpe: f64,
    pub ipw: f64,
    /// Software limits; None = not configured.
    pub limits: Option<SoftwareLimits>,
    pub pidf: PidfGains,
    pub plant: Plant,
    /// Effective radius of a rotary axis, mm.
    pub effradius: f64,
    /// Start position of a G-code run and reference position (G28).
    pub start: f64,
    pub reference: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftwareLimits {
    pub left: f64,
    pub right: f64,
    pub function: LimitFunction,
}

/// PIDF filter of chapter 2.1.2: error in counts, output in digits (32767 = 10 V); design D26.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PidfGains {
    pub kp: f64,
    pub ki: f64,
    pub kd: f64,
    pub kpl: f64,
    /// Feed-forward of velocity (digits per count/s) and acceleration (digits per count/s²).
    pub kfcv: f64,
    pub kfca: f64,
}

/// Drive and mechanics of an axis (design D8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// First-order lag of the velocity loop, s.
    pub lag_s: f64,
    /// Axis velocity at 10 V.
    pub full_speed: f64,
    pub backlash: f64,
}

/// Defaults of a G-code run (design D19, din66025.md).
#[derive(Clone, Debug, PartialEq)]
pub struct GcodeDefaults {
    pub modereg: u32,
    pub trovrst_s: f64,
    /// Highest path feed, mm/s.
    pub feed_limit: f64,
    /// Path acceleration of feed and rapid moves, mm/s².
    pub trac_feed: f64,
    pub trac_rapid: f64,
    pub start_fill: u32,
    pub merge_tolerance: f64,
    pub tools: Vec<Tool>,
    /// Work offsets G54..G59 per axis, in the order of the axes.
    pub offsets: [Vec<f64>; 6],
    pub dwell_p_unit: DwellUnit,
    /// Commanded at once where no dialect is chosen per program.
    pub profile: Profile,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    pub number: u32,
    pub length: f64,
    pub radius: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DwellUnit {
    Milliseconds,
    Seconds,
}

/// Dialect profiles of din66025.md section 20.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    Din,
    Fanuc,
    Linuxcnc,
    Lathe,
}

impl Machine {
    /// Axes that part programs may use, in the order of the contour group.
    pub fn group(&self) -> AxisSet {
        (0..self.axes.len()).filter(|&a| self.axes[a].letter.is_some()).collect()
    }
    pub fn axis_by_letter(&self, letter: char) -> Option<usize> {
        self.axes.iter().position(|a| a.letter == Some(letter))
    }
    pub fn sample_time_s(&self) -> f64 {
        f64::from(self.controller.sample_ticks) * 64e-6
    }
}
