//! The machine file: it stands for system.dat (design 3.5). Read once, validated once, then immutable.

use crate::axes::AxisSet;
use crate::registers::Axst;
use crate::stimulus::Stimulus;

mod equipment;
mod file;
mod gcode;
mod reference;

mod section;
mod show;

pub use equipment::{Encoder, Equipment, Home, Index, Output, Port};
pub use file::{AXIS_LETTERS, BUILTIN};
pub use gcode::has_fixed_meaning;
pub use reference::machine_reference;
pub use section::{MC_IDS, MachineDiagnostic, nearest};

/// A machine as the kernel and the compilers see it. Lengths in mm, rotary positions in degrees,
/// times in s, velocities and accelerations per second.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    pub name: String,
    pub axes: Vec<Axis>,
    pub controller: Controller,
    /// Digital inputs that are inverted or have a function.
    pub inputs: Vec<Input>,
    /// Digital outputs that are on after a reset or have a function.
    pub outputs: Vec<Output>,
    /// What the world outside does in every run.
    pub stimulus: Option<Stimulus>,
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
    /// Clock of the pulse generators of stepper axes (4.4.162).
    pub clock_hz: f64,
    /// Status bits at which the application ends a job.
    pub stop_at: Axst,
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
    /// Counts (steps) per motor revolution (4.4.102).
    pub slsp: f64,
    pub rapid: f64,
    /// What the drive can accelerate.
    pub acceleration: f64,
    /// Jog velocity, acceleration and stop deceleration (jvl, jac, sdec).
    pub jog_velocity: f64,
    pub jog_acceleration: f64,
    /// Target velocity of jogs (jtvl), of either sign.
    pub jog_target_velocity: f64,
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
    /// Unit in which positions are shown (rddpd, rdrpd, rdtpd).
    pub display: crate::units::PositionUnit,
    /// Sets of zero offsets that `azo` chooses from.
    pub zero_offsets: [f64; crate::zero::ZERO_OFFSET_SETS],
    /// G00 under G90 takes the short way, a whole turn or more is left out.
    pub modulo: bool,
    /// Start position of a G-code run and reference position (G28).
    pub start: f64,
    pub reference: f64,
    pub equipment: Equipment,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftwareLimits {
    pub left: f64,
    pub right: f64,
    pub function: LimitFunction,
}

/// A digital input of the base board (2.4, 4.4.52).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    /// 1 to 16.
    pub number: u32,
    pub inverted: bool,
    /// Index of the axis, and what the input means to it.
    pub function: Option<(usize, InputFunction)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputFunction {
    Limit(Side, LimitFunction),
    EmergencyOut,
    DriveReady,
    User,
    Reference,
    /// LP: latches the position.
    Latch,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
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
    pub control: DriveControl,
    /// First-order lag of the velocity loop or of the torque, s.
    pub lag_s: f64,
    /// Axis velocity at 10 V; torque control: highest velocity.
    pub full_speed: f64,
    pub backlash: f64,
    /// Acceleration of inertia 1: at 10 V under torque control, else the most the drive gives; 0 = no bound.
    pub full_acceleration: f64,
    /// Inertia of drive and load; 1 = that which `full_acceleration`, `friction` and `damping` refer to.
    pub inertia: f64,
    /// Deceleration of inertia 1 by dry friction, and per velocity by viscous friction (torque control only).
    pub friction: f64,
    pub damping: f64,
    /// Time constant in which a velocity-controlled axis runs out without power, s.
    pub coast_s: f64,
    /// A positive motor command drives the axis to the left.
    pub reversed: bool,
}

/// What the motor command means to the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveControl {
    Velocity,
    Torque,
}

/// Defaults of a G-code run (design D19, din66025.md).
#[derive(Clone, Debug, PartialEq)]
pub struct GcodeDefaults {
    pub modereg: u32,
    pub trovrst_s: f64,
    /// Highest path feed, mm/s.
    pub feed_limit: f64,
    /// Dry-run feed of the operator's terminal, mm/s; at most the feed limit.
    pub dry_feed: f64,
    /// Path acceleration of feed and rapid moves, mm/s².
    pub trac_feed: f64,
    pub trac_rapid: f64,
    pub start_fill: u32,
    pub merge_tolerance: f64,
    pub tools: Vec<Tool>,
    /// Work offsets G54..G59 per axis, in the order of the axes.
    pub offsets: [Vec<f64>; 6],
    /// Positions 2, 3, 4 of G30 per axis; those not configured are unknown to programs (GC311).
    pub references: [Option<Vec<f64>>; 3],
    /// The dialect where none is chosen per program, and what differs from it on this machine.
    pub profile: Profile,
    pub dialect: DialectOptions,
    pub outputs: OutputMasks,
    pub spindle: Spindle,
    /// Axes that do not count for the path length (NFRAX), by index.
    pub nfrax: Vec<usize>,
    /// Factors from program to machine coordinates per axis (resources 17 and 18); 1 = not mirrored.
    pub position_factors: Vec<f64>,
    /// G codes that call a subprogram: code in tenths, its name.
    pub g_functions: Vec<(u16, String)>,
    /// M functions that the dialect leaves to the machine (din66025.md section 16).
    pub m_functions: Vec<MFunction>,
    /// Common double that takes S, common integer that takes H.
    pub speed_cd: u32,
    pub auxiliary_ci: u32,
}

/// What a machine settles over the dialect profile (din66025.md section 20); None = as the profile says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DialectOptions {
    /// Unit of P in a dwell.
    pub dwell_p_unit: Option<DwellUnit>,
    pub arc_centre: Option<ArcCentre>,
    /// Value of one increment, in the unit of the program, for numbers without a point; 0 = they are units.
    pub integer_increment: Option<f64>,
    pub macros: Option<bool>,
    pub oword: Option<bool>,
    pub vacant_zero: Option<bool>,
    /// X words are diameters.
    pub diameter: Option<bool>,
    /// U V W are incremental X Y Z where no such axes are.
    pub uvw_incremental: Option<bool>,
    pub keep_g92: Option<bool>,
    pub nested_comments: Option<bool>,
    /// Clearance above the last depth of a peck cycle, mm.
    pub peck_clearance: Option<f64>,
    /// An M function without assignment is an error (GC513).
    pub strict_m: Option<bool>,
    /// D of G41, G42 is the tool radius itself.
    pub d_is_radius: Option<bool>,
    /// M02, M30 in a subprogram are an error (GC615).
    pub strict_end: Option<bool>,
    /// M06 without a T word since the last one is an error (GC516).
    pub m6_needs_t: Option<bool>,
    /// Rapids join with their neighbours instead of standing still.
    pub rapid_blend: Option<bool>,
    /// How often M99 goes back to the start of the main program.
    pub main_loop: Option<u32>,
    /// G33 without a spindle axis: a straight move with the feed of the lead.
    pub thread_as_feed: Option<bool>,
    /// G84 without a spindle axis: feed with reversal of the spindle.
    pub tapping_floating: Option<bool>,
    /// E is the feed at the end of the block.
    pub end_feed: Option<bool>,
    /// G07 and G08 switch diameter programming on and off.
    pub g07_g08: Option<bool>,
    /// G-code system A of lathes: G98, G99 are feed modes, G90, G92, G94 cycles.
    pub g_system_a: Option<bool>,
    /// G41, G42 are available.
    pub radius_correction: Option<bool>,
    /// Exact stops wait for the in-position window.
    pub exact_in_position: Option<bool>,
    /// A program starts with G95.
    pub feed_per_revolution: Option<bool>,
    /// Corners above this angle stop, degrees.
    pub corner_angle: Option<f64>,
    /// EQ and NE hold within this difference; 0 = exactly.
    pub equal_tolerance: Option<f64>,
}

/// Meaning of I J K without G90.1 or G91.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArcCentre {
    Incremental,
    Absolute,
    /// MODEREG bit 12 set: incremental; clear: absolute under G90.
    LikeController,
}

/// Digital outputs of the standard M functions, as bit masks (O1 = bit 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutputMasks {
    pub spindle_cw: u32,
    pub spindle_ccw: u32,
    /// M08.
    pub coolant1: u32,
    /// M07.
    pub coolant2: u32,
    pub clamp: u32,
    /// Inputs that M10 and M11 wait for.
    pub clamp_wait: u32,
    pub unclamp_wait: u32,
}

impl Default for OutputMasks {
    fn default() -> Self {
        OutputMasks {
            spindle_cw: 1,
            spindle_ccw: 1 << 1,
            coolant1: 1 << 2,
            coolant2: 1 << 3,
            clamp: 1 << 4,
            clamp_wait: 0,
            unclamp_wait: 0,
        }
    }
}

/// The main spindle (din66025.md sections 6, 8, 16).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spindle {
    /// Index of the rotary axis that cuts threads (G33, G84); part programs have no letter for it.
    pub axis: Option<usize>,
    /// Highest speed, 1/min; 0 = not watched.
    pub limit: f64,
    /// Axis whose motor command port takes the speed, and the speed at 10 V, 1/min.
    pub command: Option<(usize, f64)>,
    /// Wait behind M03 and M04, s.
    pub dwell_s: f64,
}

/// A user M function: outputs reset and set, a common integer written, then inputs waited for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MFunction {
    pub number: u32,
    pub set: u32,
    pub reset: u32,
    /// Inputs that must be active before motion goes on; 0 = no wait.
    pub wait: u32,
    pub ci: Option<(u32, i32)>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
    /// Mask of the inverted digital inputs.
    pub fn inverted_inputs(&self) -> u32 {
        self.inputs.iter().filter(|i| i.inverted).fold(0, |mask, i| mask | 1 << (i.number - 1))
    }
    /// Levels of the digital inputs while nothing is wrong: no switch is actuated, all drives are ready.
    pub fn resting_inputs(&self) -> u32 {
        let ready = self.inputs.iter().filter(|i| matches!(i.function, Some((_, InputFunction::DriveReady))));
        self.inverted_inputs() ^ ready.fold(0, |mask, i| mask | 1 << (i.number - 1))
    }
    pub fn sample_time_s(&self) -> f64 {
        f64::from(self.controller.sample_ticks) * 64e-6
    }
}
