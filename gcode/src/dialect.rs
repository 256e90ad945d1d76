//! What a program is read with: options of the caller over the machine file over the profile (section 20).

use std::sync::Arc;

pub use motion_kernel::machine::ArcCentre;
use motion_kernel::machine::{DwellUnit, Machine, Profile};

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
}

/// Size and count limits; tests lower them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    pub bytes: usize,
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
            errors: 100,
            blocks: 100_000_000,
            idle_blocks: 2_000_000,
            calls: 10,
            commands: 12_000_000,
        }
    }
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
    pub peck_clearance: f64,
    pub strict_m: bool,
    /// D of G41, G42 is the tool radius itself.
    pub d_is_radius: bool,
    /// M29 announces rigid tapping and ends no subprogram.
    pub rigid_m29: bool,
    /// Cycles are a group beside the motions: G80 brings back the motion from before.
    pub cycles_apart: bool,
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
            peck_clearance: own.peck_clearance.unwrap_or(1.0),
            strict_m: own.strict_m.unwrap_or(false),
            d_is_radius: own.d_is_radius.unwrap_or(false),
            rigid_m29: profile == Profile::Fanuc,
            cycles_apart: profile == Profile::Fanuc,
        }
    }
}
