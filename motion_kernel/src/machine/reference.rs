//! The reference page of the machine file (`docs/machine-file.md`): kinds, ranges and defaults come from the reader
//! itself, which notes every key it asks for; here stand only the explanations.

use std::fmt::Write;

use toml::de::DeTable;

use super::file::machine;
use super::section::{Findings, Key, MC_IDS, Section};

/// A file that has every table once, so that the reader asks for every key.
const EVERY_TABLE: &str = "
controller = {}
[[axis]]
name = 'X'
rapid = 200.0
acceleration = 1000.0
counts_per_unit = 1e4
limits = { left = -1.0, right = 1.0 }
zero_offsets = {}
pidf = {}
plant = {}
index = { width = 0.1 }
encoder = { counts_per_unit = 1.0 }
port = {}
[[input]]
number = 1
[[output]]
number = 1
[gcode]
dialect = {}
outputs = {}
spindle = {}
position_factors = {}
g = [{ number = 100, subprogram = 'A' }]
tool = [{ number = 1 }]
m = [{ number = 100 }]
offsets = {}
references = {}
";

/// Key, what it means, and the default where it is no constant (empty: as the reader says).
const TEXTS: &[(&str, &str, &str)] = &[
    ("name", "Name of the machine, shown in reports.", "machine"),
    ("tolerance_mm", "Verdict of a run: largest deviation of the load side from the programmed contour.", ""),
    ("stimulus", "What the world outside does in every run: rules as in `docs/stimulus.md`.", "none"),
    ("controller.sample_ticks", "Sample time TA in units of 64 us (2.1.2.3); 20 = 1.28 ms.", ""),
    ("controller.spool_memory_bytes", "Spool memory of each axis (2.2.8); all axes together at most 536870912.", ""),
    ("controller.direct_latency", "Samples from a direct command to its effect (design D2).", ""),
    ("controller.statements_per_sample", "Statements of a CNC task in one sample (design D4).", ""),
    ("controller.lookahead_depth", "Entries that the look-ahead considers; 0 = all that are spooled.", ""),
    ("controller.clock_hz", "Clock of the step pulses (4.4.162): 66.66666 MHz APCI-8008, 70 MHz APCI-8001.", ""),
    (
        "controller.stop_at",
        "Status bits (4.4.45: eo, dnr, lslh, lsrh, lsls, lsrs, mpe, dhef, cef, ui, saf) at which `run` stops all axes and ends the job with exit code 3; others are alarms only.",
        "eo, dnr, lslh, lsrh",
    ),
    ("axis.name", "1 to 8 letters, digits or _, a letter first; unique.", "required"),
    (
        "axis.letter",
        "Address in part programs, one of X Y Z A B C U V W; \"\" = not for part programs.",
        "the name, if it is one letter",
    ),
    ("axis.kind", "linear: positions in mm; rotary: in degrees.", ""),
    ("axis.drive", "servo: closed loop over the motor command; stepper: whole steps.", ""),
    ("axis.counts_per_unit", "Encoder counts (stepper: steps) per mm or degree.", ""),
    ("axis.slsp", "Counts (steps) per motor revolution (4.4.102): revolutions of linear axes under PU rev.", ""),
    ("axis.rapid", "Speed of the axis under G00.", ""),
    ("axis.acceleration", "What the axis can do; default of the values below.", ""),
    ("axis.jog_velocity", "Jog velocity jvl.", "rapid / 4"),
    ("axis.jog_target_velocity", "Velocity jtvl with which jogs end (4.4.153).", ""),
    ("axis.jog_acceleration", "Jog acceleration jac.", "acceleration"),
    ("axis.stop_deceleration", "Stop deceleration sdec: `js`, software limits with SMD (4.4.168).", "acceleration"),
    ("axis.mdvel", "Largest velocity step at a corner (4.4.163); 0 = not watched.", ""),
    ("axis.maxvel", "Velocity limit of ChkMaxVel (4.4.161); 0 = not watched.", ""),
    ("axis.maxacc", "Acceleration limit of ChkMaxVel and of arcs (4.4.160); 0 = not watched.", ""),
    ("axis.jerkrel", "Share of S ramps: 0 trapezoid, 1 fully rounded (4.4.76).", ""),
    ("axis.mpe", "Following error limit (4.4.165).", ""),
    ("axis.ipw", "In-position window (4.4.149); 0 = never in position.", ""),
    (
        "axis.effradius",
        "Radius at which a rotary axis counts for path length and feed (2.3.4).",
        "180 / pi: 1 mm a degree",
    ),
    ("axis.display_unit", "Unit of rddpd, rdrpd and rdtpd (4.4.58).", "mm, degree for a rotary axis"),
    ("axis.zero_offsets.set0", "Zero offset of the axis under `azo` 0 (4.4.3).", ""),
    ("axis.zero_offsets.set1", "Zero offset under `azo` 1.", ""),
    ("axis.zero_offsets.set2", "Zero offset under `azo` 2.", ""),
    ("axis.zero_offsets.set3", "Zero offset under `azo` 3.", ""),
    ("axis.zero_offsets.set4", "Zero offset under `azo` 4.", ""),
    ("axis.modulo", "G00 under G90 turns this rotary axis by the short way (section 11).", "false"),
    ("axis.start", "Position of the axis when a run begins.", ""),
    ("axis.reference", "Reference position of G28, machine coordinate.", ""),
    ("axis.home_velocity", "Velocity hvl of jhi, jhl, jhr (4.4.148).", "jog_velocity / 4"),
    ("axis.home_acceleration", "Acceleration hac of jhi, jhl, jhr (4.4.147).", "jog_acceleration"),
    (
        "axis.home_direction",
        "Side on which the terminal's home search looks for the switch (jhl, jhr); the index is searched the other way.",
        "",
    ),
    ("axis.backlash_compensation", "Way that the motor is sent further to the left after a reversal.", ""),
    ("axis.backlash_hysteresis", "Way back before a reversal counts.", ""),
    ("axis.index.position", "Where an index pulse of the encoder begins, machine coordinate.", ""),
    ("axis.index.period", "Distance of the index pulses; 0 = a single one.", ""),
    ("axis.index.width", "Width of a pulse.", "required"),
    ("axis.index.inverted", "The index signal is active between the pulses (polarity, 4.4.52).", "false"),
    ("axis.encoder.counts_per_unit", "Encoder of a stepper axis on its auxiliary channel (register aux).", ""),
    ("axis.encoder.feedback", "Actual positions come from that encoder, times gfaux (4.4.67).", "false"),
    ("axis.port.max", "Largest motor command mcpmax (32767 = 10 V).", ""),
    ("axis.port.min", "Smallest motor command mcpmin.", ""),
    ("axis.port.positive", "Zero compensation mcpcp: added to positive motor commands.", ""),
    ("axis.port.negative", "Zero compensation mcpcn: subtracted from negative motor commands.", ""),
    ("axis.port.inverted", "The output signal is inverted (4.4.162).", "false"),
    ("axis.limits.left", "Left software limit sll (2.4).", ""),
    ("axis.limits.right", "Right software limit slr; right of the left one.", ""),
    ("axis.limits.function", "What happens there: TOM motor off, SMA abrupt stop, SMD braking with sdec.", ""),
    ("axis.pidf.kp", "Proportional gain, digits per count (2.1.2.1; 32767 digits = 10 V).", ""),
    ("axis.pidf.ki", "Integral coefficient KP / TN, digits per count and second.", ""),
    ("axis.pidf.kd", "Derivative coefficient KP * TV, digits per count/s.", ""),
    ("axis.pidf.kpl", "Shortens the lag of the filter to (1 - kpl) * TA / 2 (2.1.2.2); not above 0.95.", ""),
    ("axis.pidf.kfcv", "Feed-forward of velocity, digits per count/s.", ""),
    ("axis.pidf.kfca", "Feed-forward of acceleration, digits per count/s2.", ""),
    ("axis.plant.control", "What the motor command means to the drive: a velocity or a torque.", ""),
    ("axis.plant.lag_s", "First-order lag of the velocity loop; torque control: of the torque.", ""),
    ("axis.plant.full_speed", "Axis velocity at 10 V; torque control: the highest there is.", "1.25 * rapid"),
    (
        "axis.plant.full_acceleration",
        "Acceleration of inertia 1: at 10 V (torque control, needed there), else the most the drive gives; 0 = no bound.",
        "",
    ),
    ("axis.plant.inertia", "Inertia of drive and load, 1 = as in the other values.", ""),
    ("axis.plant.friction", "Deceleration of inertia 1 by dry friction (torque control).", ""),
    ("axis.plant.damping", "Deceleration of inertia 1 per velocity by viscous friction (torque control).", ""),
    ("axis.plant.coast_s", "Time constant in which a velocity-controlled axis runs out without power.", ""),
    ("axis.plant.reversed", "A positive output drives the axis to the left (for port.inverted).", "false"),
    ("axis.plant.backlash", "Play between motor (encoder) and load.", ""),
    ("input.number", "Digital input of the base board. One with several functions has several tables.", ""),
    ("input.inverted", "The input is active when its level is low (4.4.52).", "false"),
    ("input.axis", "Name of the axis that the function is for.", "none"),
    (
        "input.function",
        "Limit switch left or right with TOM, SMA or SMD (2.4); EO, DR, UI, REF: status bits eo, dnr (while inactive), ui, refh of the axis (4.4.45); LP latches its position (4.4.82).",
        "none",
    ),
    ("output.number", "Digital output of the base board.", ""),
    ("output.on", "Its state after boot, ra and rs (4.4.42, 4.4.113).", "false"),
    ("output.axis", "Name of the axis that the function is for.", "none"),
    ("output.function", "PAE: on while the loop of the axis is closed; without it the drive has no power.", "none"),
    (
        "gcode.modereg",
        "MODEREG bits by name (6.3.1.5, table 36).",
        "LookAhead, ChkMaxVel, ExactTargetPos, RotatoricUnit, JSatSAF",
    ),
    ("gcode.trovrst_s", "Time for an override change of 1.0 (TROVRST); 0 = at once.", ""),
    ("gcode.feed_limit", "Highest path feed.", ""),
    (
        "gcode.dry_feed",
        "Dry-run feed of the terminal, at most feed_limit; the operator may choose another.",
        "feed_limit",
    ),
    ("gcode.trac_feed", "Path acceleration of feed moves.", ""),
    ("gcode.trac_rapid", "Path acceleration of rapid moves.", ""),
    ("gcode.start_fill", "Entries that are spooled before motion starts.", ""),
    ("gcode.merge_tolerance", "Chord tolerance for merging very short blocks (G64 P).", ""),
    ("gcode.tool.number", "Tool or offset number; tools 1 to 50 exist with length and radius 0.", ""),
    ("gcode.tool.length", "Length correction of G43 H.", ""),
    ("gcode.tool.radius", "Radius correction of G41, G42 D.", ""),
    ("gcode.profile", "Dialect where none is chosen per program (din66025.md section 20).", ""),
    ("gcode.dialect.dwell_p_unit", "Unit of P in G04.", "s in linuxcnc, else ms"),
    (
        "gcode.dialect.arc_centre",
        "Meaning of I J K without G90.1, G91.1; likeController: by MODEREG CenterAlwaysRel.",
        "incremental",
    ),
    ("gcode.dialect.integer_increment", "Value of one increment for numbers without a point; 0 = they are units.", "0"),
    ("gcode.dialect.macros", "Statements: IF, WHILE, GOTO, assignments.", "true"),
    ("gcode.dialect.oword", "O-word control flow.", "true in linuxcnc, else false"),
    ("gcode.dialect.vacant_zero", "Variables never set read as 0.", "true in fanuc and linuxcnc, else false"),
    ("gcode.dialect.diameter", "X words are diameters.", "true in lathe, else false"),
    (
        "gcode.dialect.uvw_incremental",
        "U V W are incremental X Y Z where no such axes are.",
        "true in lathe, else false",
    ),
    ("gcode.dialect.keep_g92", "G92 survives the program end.", "true in linuxcnc, else false"),
    ("gcode.dialect.nested_comments", "Parentheses inside a comment are counted.", "false in fanuc, else true"),
    ("gcode.dialect.peck_clearance", "Clearance above the last depth in peck drilling.", "1"),
    ("gcode.dialect.strict_m", "An M function without assignment is an error (GC513), not a warning.", "false"),
    ("gcode.dialect.d_is_radius", "D of G41, G42 is the tool radius itself, not a tool number.", "false"),
    ("gcode.dialect.strict_end", "M02 or M30 in a subprogram is an error (GC615); else it ends the program.", "false"),
    ("gcode.dialect.m6_needs_t", "M06 needs a T word since the last M06 (GC516).", "false"),
    ("gcode.dialect.rapid_blend", "G00 joins with its neighbours; else it stands still at both ends.", "false"),
    (
        "gcode.dialect.main_loop",
        "How often M99 goes back to the start of the main program, each time behind a stop.",
        "0",
    ),
    (
        "gcode.dialect.thread_as_feed",
        "G33 without a spindle axis: a straight move with feed lead * S (GW916).",
        "false",
    ),
    (
        "gcode.dialect.tapping_floating",
        "G84 without a spindle axis: feed with reversal of the spindle (GW919).",
        "false",
    ),
    ("gcode.dialect.end_feed", "E is the feed at the end of the block; else GC214.", "false"),
    ("gcode.dialect.g07_g08", "G07 switches diameter programming on, G08 off.", "false"),
    ("gcode.dialect.g_system_a", "G-code system A: G98, G99 are G94, G95; G90, G92, G94 are cycles (GC317).", "false"),
    ("gcode.dialect.radius_correction", "G41 and G42 are available; else GC312.", "true"),
    ("gcode.dialect.exact_in_position", "G60, G61, G09 wait for the in-position window of all axes.", "false"),
    ("gcode.dialect.feed_per_revolution", "A program starts with G95.", "false"),
    (
        "gcode.dialect.corner_angle",
        "Corners above this angle between two moves stop (section 9).",
        "180 with LookAhead, else 1",
    ),
    ("gcode.dialect.equal_tolerance", "EQ and NE hold within this difference; 0 = exactly.", "0"),
    ("gcode.nfrax", "Rotary axes that do not count for the path length (NFRAX).", "[]"),
    ("gcode.spindle.axis", "Rotary axis with letter \"\" that cuts threads (G33, G84) in its position loop.", "none"),
    ("gcode.spindle.limit", "Highest speed in 1/min (GC515), limit of G96 too; 0 = not watched.", ""),
    ("gcode.spindle.command_axis", "Axis (one of the first 8) whose motor command takes the speed (1200 + n).", "none"),
    ("gcode.spindle.full_speed", "Speed at 10 V of that motor command, 1/min.", ""),
    ("gcode.spindle.dwell_s", "Wait behind M03 and M04.", ""),
    ("gcode.g.number", "G function without a meaning of its own, 100 to 999, that calls a subprogram.", ""),
    ("gcode.g.subprogram", "Its name or number; the words of the block become variables as with G65.", "required"),
    ("gcode.outputs.spindle_cw", "Digital outputs of M03.", "[1]"),
    ("gcode.outputs.spindle_ccw", "Digital outputs of M04.", "[2]"),
    ("gcode.outputs.coolant1", "Digital outputs of M08.", "[3]"),
    ("gcode.outputs.coolant2", "Digital outputs of M07.", "[4]"),
    ("gcode.outputs.clamp", "Digital outputs of M10, M11.", "[5]"),
    ("gcode.outputs.clamp_wait", "Inputs that M10 waits for.", "[]"),
    ("gcode.outputs.unclamp_wait", "Inputs that M11 waits for.", "[]"),
    (
        "gcode.m.number",
        "M function without a meaning of its own: 12, 15, 16, 18, 20-28, 31-35, 50-59, 61, 67-97, 100-999.",
        "",
    ),
    ("gcode.m.set", "Digital outputs it sets.", "[]"),
    ("gcode.m.reset", "Digital outputs it resets.", "[]"),
    ("gcode.m.wait", "Inputs that must be active before motion goes on.", "[]"),
    ("gcode.m.ci", "Common integer it writes, in step with motion; not 99.", "none"),
    ("gcode.m.value", "What it writes there, a whole number.", ""),
    ("gcode.speed_cd", "Common double that takes S.", ""),
    ("gcode.auxiliary_ci", "Common integer that takes H; not 99.", "200"),
];

/// Tables with axis names as keys, which the reader cannot list.
const HEAD: &str = "# The machine file

<!-- Written by `cargo run -p motion_kernel --example machine_reference > docs/machine-file.md`; a test compares it. -->

A machine file is TOML. `examples/machines/mill3.toml` is commented and is also the built-in machine;
`cnc-front machine show FILE` prints a file resolved with all defaults, `cnc-front machine check FILE` reports what is
wrong with it. Lengths are in mm, positions of rotary axes in degrees (read degree for mm below), times in s. A key that is
not listed here is an error. Axes are driven in the order of their `[[axis]]` tables, at most 18.
";

const OFFSETS: &str = "
## gcode.offsets

Work offsets: `G54` to `G59`, each a table of positions per axis name: `G55 = { X = 120.0, Y = 40.0 }`. Axes not named have 0.

## gcode.position_factors

Factors from program to machine coordinates per axis name (resources Mirror and PositionFactor): `X = -1.0` mirrors X, other
values scale it. They act before the work offset. Axes not named have 1.

## gcode.references

Positions of G30 in machine coordinates: `P2`, `P3`, `P4`, each a table of positions per axis name: `P2 = { X = 10.0 }`. Axes
not named go to their `reference`. A position without a table is unknown to programs (GC311).
";

/// The page as Markdown.
pub fn machine_reference() -> String {
    let mut page = HEAD.to_owned();
    let mut group = None;
    for key in keys() {
        let (table, name) = key.path.rsplit_once('.').unwrap_or(("", &key.path));
        if group.as_deref() != Some(table) {
            page += &heading(table);
            group = Some(table.to_owned());
        }
        let (_, text, own) = explanation(&key).unwrap_or(&("", "", ""));
        let default = if own.is_empty() { &key.default } else { *own };
        let kind = if key.range.is_empty() { key.kind.to_owned() } else { format!("{}: {}", key.kind, key.range) };
        writeln!(page, "| `{name}` | {kind} | {default} | {text} |").expect("writing to a String");
    }
    page += OFFSETS;
    page += "\n## Diagnostics\n\n| id | what to do |\n|---|---|\n";
    for (id, remedy) in MC_IDS {
        writeln!(page, "| {id} | {remedy} |").expect("writing to a String");
    }
    page
}

fn heading(table: &str) -> String {
    let title = match table {
        "" => "Top level".to_owned(),
        "axis" | "input" | "output" | "gcode.tool" | "gcode.m" | "gcode.g" => format!("\\[\\[{table}\\]\\]"),
        _ => table.to_owned(),
    };
    format!("\n## {title}\n\n| key | value | default | meaning |\n|---|---|---|---|\n")
}

fn explanation(key: &Key) -> Option<&'static (&'static str, &'static str, &'static str)> {
    TEXTS.iter().find(|(path, _, _)| *path == key.path)
}

/// Every key that the reader asks for, tables together and in their order of appearance.
fn keys() -> Vec<Key> {
    let findings = Findings::new(EVERY_TABLE);
    let (table, _) = DeTable::parse_recoverable(EVERY_TABLE);
    machine(Section::new("", table.get_ref(), 0..0, &findings));
    let table_of = |key: &Key| key.path.rsplit_once('.').map_or(String::new(), |(table, _)| table.to_owned());
    let keys = findings.into_keys();
    let mut tables: Vec<String> = Vec::new();
    for table in keys.iter().map(table_of) {
        if !tables.contains(&table) {
            tables.push(table);
        }
    }
    tables.sort_by_key(|table| (!table.is_empty(), table.split('.').next() == Some("gcode")));
    let mut sorted = keys;
    sorted.sort_by_key(|key| tables.iter().position(|table| *table == table_of(key)));
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_explained_and_every_explanation_belongs_to_a_key() {
        let keys = keys();
        let unexplained: Vec<&str> =
            keys.iter().filter(|k| explanation(k).is_none()).map(|k| k.path.as_str()).collect();
        assert_eq!(unexplained, Vec::<&str>::new());
        let orphans = TEXTS.iter().filter(|(path, _, _)| !keys.iter().any(|k| k.path == *path)).map(|row| row.0);
        assert_eq!(orphans.collect::<Vec<_>>(), Vec::<&str>::new());
    }

    #[test]
    fn every_default_is_told() {
        for key in keys() {
            let (_, _, own) = explanation(&key).expect("explained");
            assert!(!own.is_empty() || !key.default.is_empty(), "{}", key.path);
        }
    }
}
