//! The one table of G and M codes: modal group and decision (docs/dialect.md, sections 5, 6, 16).

use crate::diagnostics::Id;

/// Modal groups: two members in one block exclude each other (GC302).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    OneShot,
    Motion,
    Plane,
    Distance,
    ArcCentre,
    FeedMode,
    Unit,
    RadiusCorrection,
    LengthCorrection,
    PathMode,
    CycleReturn,
    ZeroOffset,
    SpindleMode,
    Scaling,
    Mirror,
    Rotation,
    Cylinder,
    /// Calls a subprogram of the machine file (`[[gcode.g]]`).
    Call,
    /// Accepted in any number, nothing happens.
    Nothing,
}

impl Group {
    pub const fn bit(self) -> u32 {
        1 << self as u32
    }
    pub const fn name(self) -> &'static str {
        match self {
            Group::OneShot => "one-shot",
            Group::Motion => "motion",
            Group::Plane => "plane",
            Group::Distance => "dimension",
            Group::ArcCentre => "arc centre",
            Group::FeedMode => "feed mode",
            Group::Unit => "unit",
            Group::RadiusCorrection => "radius correction",
            Group::LengthCorrection => "length correction",
            Group::PathMode => "path mode",
            Group::CycleReturn => "cycle return",
            Group::ZeroOffset => "zero offset",
            Group::SpindleMode => "spindle mode",
            Group::Scaling => "scaling",
            Group::Mirror => "mirror",
            Group::Rotation => "rotation",
            Group::Cylinder => "cylinder",
            Group::Call => "call",
            Group::Nothing => "none",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    Yes,
    /// Accepted without effect, with a warning.
    Ignored,
    /// Rejected with this error.
    Refused(Id),
}

/// A G code: its number in tenths (G91.1 = 911).
#[derive(Clone, Copy, Debug)]
pub struct GCode {
    pub tenths: u16,
    pub group: Group,
    pub decision: Decision,
}

use Decision::{Ignored, Refused, Yes};
use Group::*;

/// Every G code that is not simply unknown (GC305).
pub const G_CODES: &[(u16, Group, Decision)] = &[
    (0, Motion, Yes),
    (10, Motion, Yes),
    (20, Motion, Yes),
    (30, Motion, Yes),
    (40, OneShot, Yes),
    (60, Motion, Refused(Id::GC306)),
    (70, Nothing, Refused(Id::GC305)),
    (71, Cylinder, Yes),
    (80, Nothing, Ignored),
    (90, Nothing, Yes),
    (100, OneShot, Yes),
    (110, Nothing, Yes),
    (150, Nothing, Ignored),
    (170, Plane, Yes),
    (180, Plane, Yes),
    (190, Plane, Yes),
    (200, Unit, Yes),
    (210, Unit, Yes),
    (230, Nothing, Ignored),
    (280, OneShot, Yes),
    (300, OneShot, Yes),
    (310, Motion, Refused(Id::GC307)),
    (330, Motion, Yes),
    (340, Motion, Refused(Id::GC308)),
    (350, Motion, Refused(Id::GC308)),
    (380, Motion, Refused(Id::GC307)),
    (382, Motion, Refused(Id::GC307)),
    (383, Motion, Refused(Id::GC307)),
    (384, Motion, Refused(Id::GC307)),
    (385, Motion, Refused(Id::GC307)),
    (400, RadiusCorrection, Yes),
    (410, RadiusCorrection, Yes),
    (420, RadiusCorrection, Yes),
    (430, LengthCorrection, Yes),
    (440, LengthCorrection, Yes),
    (490, LengthCorrection, Yes),
    (500, Scaling, Yes),
    (501, Mirror, Yes),
    (510, Scaling, Yes),
    (511, Mirror, Yes),
    (520, OneShot, Yes),
    (530, ZeroOffset, Yes),
    (540, ZeroOffset, Yes),
    (541, ZeroOffset, Yes),
    (550, ZeroOffset, Yes),
    (560, ZeroOffset, Yes),
    (570, ZeroOffset, Yes),
    (580, ZeroOffset, Yes),
    (590, ZeroOffset, Yes),
    (600, PathMode, Yes),
    (610, PathMode, Yes),
    (611, PathMode, Yes),
    (620, Nothing, Ignored),
    (630, Nothing, Refused(Id::GC308)),
    (640, PathMode, Yes),
    (650, OneShot, Yes),
    (680, Rotation, Yes),
    (690, Rotation, Yes),
    (700, Unit, Yes),
    (710, Unit, Yes),
    (720, Motion, Refused(Id::GC317)),
    (730, Motion, Yes),
    (740, OneShot, Yes),
    (750, OneShot, Yes),
    (760, Motion, Refused(Id::GC317)),
    (770, Motion, Refused(Id::GC317)),
    (780, Motion, Refused(Id::GC317)),
    (790, Motion, Refused(Id::GC317)),
    (800, Motion, Yes),
    (810, Motion, Yes),
    (820, Motion, Yes),
    (830, Motion, Yes),
    (840, Motion, Yes),
    (850, Motion, Yes),
    (860, Motion, Yes),
    (870, Motion, Refused(Id::GC320)),
    (880, Motion, Refused(Id::GC320)),
    (890, Motion, Yes),
    (900, Distance, Yes),
    (901, ArcCentre, Yes),
    (910, Distance, Yes),
    (911, ArcCentre, Yes),
    (920, OneShot, Yes),
    (921, OneShot, Yes),
    (922, OneShot, Yes),
    (923, OneShot, Yes),
    (930, FeedMode, Yes),
    (940, FeedMode, Yes),
    (950, FeedMode, Yes),
    (960, SpindleMode, Yes),
    (970, SpindleMode, Yes),
    (980, CycleReturn, Yes),
    (990, CycleReturn, Yes),
    (1070, Cylinder, Yes),
];

/// Looks a G code up; unknown ones are refused with GC305.
#[inline]
pub fn g_code(tenths: u16) -> GCode {
    if tenths <= 30 && tenths.is_multiple_of(10) {
        return GCode { tenths, group: Motion, decision: Yes };
    }
    match G_CODES.binary_search_by_key(&tenths, |row| row.0) {
        Ok(row) => GCode { tenths, group: G_CODES[row].1, decision: G_CODES[row].2 },
        Err(_) => GCode { tenths, group: Nothing, decision: Refused(Id::GC305) },
    }
}

/// What two G codes of one group do in one block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beside {
    Twice,
    Clash,
    /// Only the first, or only the second counts.
    First,
    Second,
}

/// `G00 G80`: the cycle ends and the motion code holds, as Fanuc's and Haas' groups 9 and 1 have it.
pub fn beside(first: u16, second: u16) -> Beside {
    match (first, second) {
        _ if first == second => Beside::Twice,
        (0 | 10 | 20 | 30, 800) => Beside::First,
        (800, 0 | 10 | 20 | 30) => Beside::Second,
        _ => Beside::Clash,
    }
}

/// The number as people write it: 911 -> "91.1".
pub fn number(tenths: u16) -> String {
    if tenths.is_multiple_of(10) { format!("{}", tenths / 10) } else { format!("{}.{}", tenths / 10, tenths % 10) }
}

/// Groups of M codes (two members in one block: GC302, M07 with M08 excepted).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MGroup {
    Stop,
    Tool,
    Spindle,
    Coolant,
    Override,
    Clamp,
    Gear,
    User,
}

impl MGroup {
    pub const fn name(self) -> &'static str {
        match self {
            MGroup::Stop => "stop",
            MGroup::Tool => "tool",
            MGroup::Spindle => "spindle",
            MGroup::Coolant => "coolant",
            MGroup::Override => "override",
            MGroup::Clamp => "clamp",
            MGroup::Gear => "gear",
            MGroup::User => "user",
        }
    }
}

/// The group of an M code.
pub const fn m_group(m: u16) -> MGroup {
    match m {
        0 | 1 | 2 | 17 | 29 | 30 | 60 | 98 | 99 => MGroup::Stop,
        6 => MGroup::Tool,
        3 | 4 | 5 | 13 | 14 | 19 => MGroup::Spindle,
        7..=9 => MGroup::Coolant,
        10 | 11 => MGroup::Clamp,
        40..=45 => MGroup::Gear,
        48 | 49 => MGroup::Override,
        _ => MGroup::User,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_sorted_and_found() {
        assert!(G_CODES.windows(2).all(|w| w[0].0 < w[1].0));
        assert_eq!(g_code(911).group, ArcCentre);
        assert_eq!(g_code(120).decision, Refused(Id::GC305));
        assert_eq!(g_code(60).decision, Refused(Id::GC306));
        assert_eq!((number(911), number(540)), ("91.1".to_owned(), "54".to_owned()));
        assert!(G_CODES.iter().all(|row| g_code(row.0).group == row.1 && g_code(row.0).decision == row.2));
    }
}
