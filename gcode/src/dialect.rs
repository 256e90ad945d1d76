//! What a program is read with: options of the caller over the machine file over the profile (section 20).

use std::sync::Arc;

use crate::codes::{Decision, GCode, Group, g_code};
use crate::diagnostics::Id;
use crate::part::At;
pub use motion_kernel::machine::ArcCentre;
use motion_kernel::machine::{DwellUnit, Machine, Profile};
use motion_kernel::registers::ModeReg;

/// Reads a subprogram file by its name; `None` if there is none.
pub type Library = Arc<dyn Fn(&str) -> Option<Vec<u8>> + Send + Sync>;

/// How a program is to be compiled. `Options::default()` is what `run` and `check` use.
#[derive(Clone, Default)]
pub struct Options {
    /// Dialect profile; `None`: that of the machine file.
    pub profile: Option<Profile>,
    /// M01 stops.
    pub optional_stop: bool,
    /// Levels of block delete that are switched on, bit n = level n.
    pub block_delete: u16,
    /// Only diagnostics are wanted: no program is kept.
    pub check_only: bool,
    /// Subprograms in other files.
    pub library: Option<Library>,
    pub limits: Limits,
    /// First and last block of the part that is wanted.
    pub from: Option<At>,
    pub to: Option<At>,
    /// Warnings of the linter too.
    pub strict: bool,
    /// Dry-run feed, mm/s: feed moves go at it instead of F; threads and tapping keep theirs.
    pub dry_feed: Option<f64>,
    /// A block of MDI, which has no end of its own: spindle and coolant stay as they are behind it.
    pub mdi: bool,
}

/// Size and count limits; tests lower them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    pub bytes: usize,
    /// Bytes of a text that is kept in memory.
    pub held: usize,
    pub errors: usize,
    pub blocks: u64,
    /// Blocks in a row that command nothing: an endless loop is found after seconds.
    pub idle_blocks: u64,
    pub calls: usize,
    /// Motion commands and spool functions in all, a bound on memory.
    pub commands: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            bytes: 256 << 20,
            held: 256 << 20,
            errors: 100,
            blocks: 100_000_000,
            idle_blocks: 2_000_000,
            calls: 10,
            commands: 12_000_000,
        }
    }
}

/// D without G41 or G42 (section 22): Fanuc keeps it, LinuxCNC refuses it, elsewhere it must agree with the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoneD {
    Modal,
    Refused,
    OfTool,
}

/// The settled dialect of one compilation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dialect {
    /// Value of one increment for numbers without point; 0 = units.
    pub integer_increment: f64,
    /// Unit of P in a dwell, s.
    pub dwell_p: f64,
    pub arc_centre: ArcCentre,
    pub macros: bool,
    pub oword: bool,
    pub vacant_zero: bool,
    /// X words are diameters.
    pub diameter: bool,
    pub lathe: bool,
    pub keep_g92: bool,
    pub nested_comments: bool,
    /// U V W without such axes are incremental X Y Z.
    pub uvw_incremental: bool,
    /// mm; `None`: 1 mm, with inch units 0.04 inch.
    pub peck_clearance: Option<f64>,
    pub strict_m: bool,
    /// D of G41, G42 is the tool radius itself.
    pub d_is_radius: bool,
    /// M29 announces rigid tapping and ends no subprogram.
    pub rigid_m29: bool,
    /// What D without G41 or G42 means.
    pub lone_d: LoneD,
    /// Cycles are a group beside the motions: G80 brings back the motion from before.
    pub cycles_apart: bool,
    /// M02, M30 in a subprogram are errors.
    pub strict_end: bool,
    /// M06 needs a T word.
    pub m6_needs_t: bool,
    /// Rapids join with their neighbours.
    pub rapid_blend: bool,
    /// How often M99 starts the main program again.
    pub main_loop: u32,
    /// The machine has an axis that cuts threads.
    pub spindle_axis: bool,
    pub thread_as_feed: bool,
    pub tapping_floating: bool,
    /// E is the feed at the end of the block.
    pub end_feed: bool,
    pub g07_g08: bool,
    pub g_system_a: bool,
    pub radius_correction: bool,
    pub exact_in_position: bool,
    pub feed_per_revolution: bool,
    /// Cosine of the angle above which corners stop; -1: none does.
    pub corner_cos: f64,
    /// Difference within which EQ and NE hold.
    pub equal_tolerance: f64,
    /// The machine file has G functions of its own.
    pub calls_by_g: bool,
}

impl Dialect {
    pub fn new(machine: &Machine, options: &Options) -> Self {
        let profile = options.profile.unwrap_or(machine.gcode.profile);
        let linuxcnc = profile == Profile::Linuxcnc;
        let lathe = profile == Profile::Lathe;
        let own = &machine.gcode.dialect; // what the machine file settles over the profile
        let by_profile = if linuxcnc { DwellUnit::Seconds } else { DwellUnit::Milliseconds };
        let dwell_unit = own.dwell_p_unit.unwrap_or(by_profile);
        Dialect {
            integer_increment: own.integer_increment.unwrap_or(0.0),
            dwell_p: if dwell_unit == DwellUnit::Seconds { 1.0 } else { 1e-3 },
            arc_centre: own.arc_centre.unwrap_or(ArcCentre::Incremental),
            macros: own.macros.unwrap_or(true),
            oword: own.oword.unwrap_or(linuxcnc),
            vacant_zero: own.vacant_zero.unwrap_or(matches!(profile, Profile::Fanuc | Profile::Linuxcnc)),
            diameter: own.diameter.unwrap_or(lathe),
            lathe,
            keep_g92: own.keep_g92.unwrap_or(linuxcnc),
            nested_comments: own.nested_comments.unwrap_or(profile != Profile::Fanuc),
            uvw_incremental: own.uvw_incremental.unwrap_or(lathe),
            peck_clearance: own.peck_clearance,
            strict_m: own.strict_m.unwrap_or(false),
            d_is_radius: own.d_is_radius.unwrap_or(false),
            rigid_m29: profile == Profile::Fanuc,
            lone_d: match profile {
                Profile::Fanuc => LoneD::Modal,
                Profile::Linuxcnc => LoneD::Refused,
                _ => LoneD::OfTool,
            },
            cycles_apart: profile == Profile::Fanuc,
            strict_end: own.strict_end.unwrap_or(false),
            m6_needs_t: own.m6_needs_t.unwrap_or(false),
            rapid_blend: own.rapid_blend.unwrap_or(false),
            main_loop: own.main_loop.unwrap_or(0),
            spindle_axis: machine.gcode.spindle.axis.is_some(),
            thread_as_feed: own.thread_as_feed.unwrap_or(false),
            tapping_floating: own.tapping_floating.unwrap_or(false),
            end_feed: own.end_feed.unwrap_or(false),
            g07_g08: own.g07_g08.unwrap_or(false),
            g_system_a: own.g_system_a.unwrap_or(false),
            radius_correction: own.radius_correction.unwrap_or(true),
            exact_in_position: own.exact_in_position.unwrap_or(false),
            feed_per_revolution: own.feed_per_revolution.unwrap_or(false),
            corner_cos: corner_cos(own.corner_angle, machine),
            equal_tolerance: own.equal_tolerance.unwrap_or(0.0),
            calls_by_g: !machine.gcode.g_functions.is_empty(),
        }
    }
}

impl Dialect {
    /// A G code as the machine's options have it.
    #[inline]
    pub fn code(&self, tenths: u16) -> GCode {
        let settled = self.spindle_axis && !(self.g_system_a || self.g07_g08 || self.calls_by_g);
        if tenths <= 30 || settled {
            return g_code(tenths);
        }
        let alone = |option: bool| !self.spindle_axis && !option;
        let yes = |group| GCode { tenths, group, decision: Decision::Yes };
        match tenths {
            330 if alone(self.thread_as_feed) => GCode { decision: Decision::Refused(Id::GC308), ..g_code(tenths) },
            840 if alone(self.tapping_floating) => GCode { decision: Decision::Refused(Id::GC308), ..g_code(tenths) },
            980 if self.g_system_a => g_code(940),
            990 if self.g_system_a => g_code(950),
            900 | 920 | 940 if self.g_system_a => GCode { decision: Decision::Refused(Id::GC317), ..g_code(tenths) },
            70 | 80 if self.g07_g08 => yes(Group::Nothing),
            _ if self.calls_by_g && tenths >= 1000 && tenths != 1070 && tenths.is_multiple_of(10) => yes(Group::Call),
            _ => g_code(tenths),
        }
    }
}

/// With look-ahead the controller takes corners as its mdvel allows, without it they stop.
fn corner_cos(angle: Option<f64>, machine: &Machine) -> f64 {
    let look_ahead = ModeReg(machine.gcode.modereg).has(ModeReg::LookAhead);
    let angle = angle.unwrap_or(if look_ahead { 180.0 } else { 1.0 });
    if angle >= 180.0 { -1.0 } else { angle.to_radians().cos() }
}
