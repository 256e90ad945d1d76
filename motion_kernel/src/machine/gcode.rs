//! The part of a machine file that stands for part programs: what a G-code run starts with (design D19), tools,
//! offsets, and what the machine settles about the dialect (din66025.md sections 16 and 20).

use super::file::{BIG, TINY};
use super::section::Section;
use super::*;
use crate::registers::ModeReg;

pub(super) const PROFILES: [(&str, Profile); 4] =
    [("din", Profile::Din), ("fanuc", Profile::Fanuc), ("linuxcnc", Profile::Linuxcnc), ("lathe", Profile::Lathe)];
pub(super) const ARC_CENTRES: [(&str, ArcCentre); 3] = [
    ("incremental", ArcCentre::Incremental),
    ("absolute", ArcCentre::Absolute),
    ("likeController", ArcCentre::LikeController),
];
pub(super) const DWELL_UNITS: [(&str, DwellUnit); 2] = [("ms", DwellUnit::Milliseconds), ("s", DwellUnit::Seconds)];

impl GcodeDefaults {
    /// Design D19: what a G-code run starts with where the file says nothing.
    pub fn for_axes(axes: usize) -> Self {
        let bits = ModeReg::LookAhead
            | ModeReg::ChkMaxVel
            | ModeReg::ExactTargetPos
            | ModeReg::RotatoricUnit
            | ModeReg::JSatSAF;
        GcodeDefaults {
            modereg: bits.0,
            trovrst_s: 0.5,
            feed_limit: 100.0,
            dry_feed: 100.0,
            trac_feed: 1000.0,
            trac_rapid: 1000.0,
            start_fill: 200,
            merge_tolerance: 0.001,
            tools: (1..=50).map(|number| Tool { number, length: 0.0, radius: 0.0 }).collect(),
            offsets: std::array::from_fn(|_| vec![0.0; axes]),
            references: [None, None, None],
            profile: Profile::Din,
            dialect: DialectOptions::default(),
            outputs: OutputMasks::default(),
            spindle: Spindle::default(),
            nfrax: Vec::new(),
            position_factors: vec![1.0; axes],
            g_functions: Vec::new(),
            m_functions: Vec::new(),
            speed_cd: 200,
            auxiliary_ci: 200,
        }
    }
}

pub(super) fn gcode_defaults(section: Section<'_, '_>, axes: &[Axis]) -> GcodeDefaults {
    let default = GcodeDefaults::for_axes(axes.len());
    let feed_limit = section.number("feed_limit", "mm/s", TINY..=BIG, default.feed_limit);
    let gcode = GcodeDefaults {
        modereg: modereg(&section).unwrap_or(default.modereg),
        trovrst_s: section.number("trovrst_s", "s", 0.0..=1000.0, default.trovrst_s),
        feed_limit,
        dry_feed: section.number("dry_feed", "mm/s", TINY..=BIG, feed_limit),
        trac_feed: section.number("trac_feed", "mm/s2", TINY..=BIG, default.trac_feed),
        trac_rapid: section.number("trac_rapid", "mm/s2", TINY..=BIG, default.trac_rapid),
        start_fill: section.integer("start_fill", 1..=1_000_000, default.start_fill),
        merge_tolerance: section.number("merge_tolerance", "mm", 0.0..=1.0, default.merge_tolerance),
        tools: tools(&section, default.tools),
        offsets: offsets(&section, axes),
        references: references(&section, axes),
        profile: section.word("profile", &PROFILES, default.profile),
        dialect: section.section("dialect").map_or_else(DialectOptions::default, dialect),
        outputs: section.section("outputs").map_or_else(OutputMasks::default, outputs),
        spindle: section.section("spindle").map_or_else(Spindle::default, |s| spindle(s, axes)),
        nfrax: nfrax(&section, axes),
        position_factors: position_factors(&section, axes),
        g_functions: g_functions(&section),
        m_functions: m_functions(&section),
        speed_cd: section.integer("speed_cd", 0..=999, default.speed_cd),
        auxiliary_ci: common_integer(&section, "auxiliary_ci").unwrap_or(default.auxiliary_ci),
    };
    if gcode.dialect.exact_in_position == Some(true)
        && let Some(axis) = axes.iter().find(|a| a.letter.is_some() && a.ipw == 0.0)
    {
        let message = format!("exact_in_position would wait for ever: ipw of axis {} is 0", axis.name);
        section.finding("dialect", "MC110", &message);
    }
    if gcode.dry_feed > feed_limit {
        section.finding(
            "dry_feed",
            "MC110",
            &format!("above feed_limit ({feed_limit} mm/s), which the path may not pass"),
        );
    }
    section.done();
    gcode
}

fn modereg(section: &Section<'_, '_>) -> Option<u32> {
    let mut bits = ModeReg::default();
    for (name, span) in section.texts("modereg")? {
        match ModeReg::by_name(name) {
            Some(bit) => bits.set(bit),
            None => {
                let known: Vec<&str> = ModeReg::ALL.iter().map(|(_, name, _)| *name).collect();
                let hint = super::section::nearest(name, &known).map(|n| format!("did you mean {n}?"));
                section.finding_at(span, "MC107", &format!("MODEREG has no bit '{name}'"), hint);
            }
        }
    }
    Some(bits.0)
}

fn tools(section: &Section<'_, '_>, default: Vec<Tool>) -> Vec<Tool> {
    let mut tools = default;
    let mut given = std::collections::BTreeSet::new();
    for entry in section.sections("tool") {
        let number = entry.required_integer("number", 1..=99_999_999);
        let tool = Tool {
            number: number.unwrap_or(0),
            length: entry.number("length", "mm", -BIG..=BIG, 0.0),
            radius: entry.number("radius", "mm", 0.0..=BIG, 0.0),
        };
        if number.is_some_and(|n| !given.insert(n)) {
            entry.finding("number", "MC111", "this tool stands twice");
        }
        entry.done();
        tools.push(tool);
    }
    tools.sort_by_key(|t| t.number); // stable: the last one given for a number counts
    tools.reverse();
    tools.dedup_by_key(|t| t.number);
    tools.reverse();
    tools
}

/// Values per axis name in the order of the axes; axes not named keep the value of `default`.
fn per_axis(section: &Section<'_, '_>, axes: &[Axis], default: impl Fn(&Axis) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> = axes.iter().map(default).collect();
    for (axis, value, span) in section.numbers() {
        match axes.iter().position(|a| a.name == axis) {
            Some(index) if value.abs() <= BIG => values[index] = value,
            Some(_) => section.finding_at(span, "MC106", &format!("{axis}: position too large"), None),
            None => section.finding_at(span, "MC103", &format!("there is no axis {axis}"), None),
        }
    }
    values
}

fn offsets(section: &Section<'_, '_>, axes: &[Axis]) -> [Vec<f64>; 6] {
    let table = section.section("offsets");
    let sets = ["G54", "G55", "G56", "G57", "G58", "G59"].map(|name| {
        let entry = table.as_ref().and_then(|table| table.section(name));
        entry.map_or_else(|| vec![0.0; axes.len()], |entry| per_axis(&entry, axes, |_| 0.0))
    });
    table.into_iter().for_each(Section::done);
    sets
}

fn references(section: &Section<'_, '_>, axes: &[Axis]) -> [Option<Vec<f64>>; 3] {
    let table = section.section("references");
    let sets = ["P2", "P3", "P4"].map(|name| {
        let entry = table.as_ref().and_then(|table| table.section(name));
        entry.map(|entry| per_axis(&entry, axes, |axis| axis.reference))
    });
    table.into_iter().for_each(Section::done);
    sets
}

fn dialect(section: Section<'_, '_>) -> DialectOptions {
    let options = DialectOptions {
        dwell_p_unit: section.word_if_given("dwell_p_unit", &DWELL_UNITS),
        arc_centre: section.word_if_given("arc_centre", &ARC_CENTRES),
        integer_increment: section.number_if_given("integer_increment", "unit", 0.0..=1.0),
        macros: section.flag("macros"),
        oword: section.flag("oword"),
        vacant_zero: section.flag("vacant_zero"),
        diameter: section.flag("diameter"),
        uvw_incremental: section.flag("uvw_incremental"),
        keep_g92: section.flag("keep_g92"),
        nested_comments: section.flag("nested_comments"),
        peck_clearance: section.number_if_given("peck_clearance", "mm", 0.0..=100.0),
        strict_m: section.flag("strict_m"),
        d_is_radius: section.flag("d_is_radius"),
        strict_end: section.flag("strict_end"),
        m6_needs_t: section.flag("m6_needs_t"),
        rapid_blend: section.flag("rapid_blend"),
        main_loop: section.integer_if_given("main_loop", 0..=9999),
        thread_as_feed: section.flag("thread_as_feed"),
        tapping_floating: section.flag("tapping_floating"),
        end_feed: section.flag("end_feed"),
        g07_g08: section.flag("g07_g08"),
        g_system_a: section.flag("g_system_a"),
        radius_correction: section.flag("radius_correction"),
        exact_in_position: section.flag("exact_in_position"),
        feed_per_revolution: section.flag("feed_per_revolution"),
        corner_angle: section.number_if_given("corner_angle", "degree", 0.0..=180.0),
        equal_tolerance: section.number_if_given("equal_tolerance", "", 0.0..=1.0),
    };
    section.done();
    options
}

/// Lines 1 to 32 as a bit mask.
fn lines(section: &Section<'_, '_>, key: &'static str, default: u32) -> u32 {
    section.integers(key, 1..=32).map_or(default, |list| list.iter().fold(0, |mask, n| mask | 1 << (n - 1)))
}

fn outputs(section: Section<'_, '_>) -> OutputMasks {
    let default = OutputMasks::default();
    let masks = OutputMasks {
        spindle_cw: lines(&section, "spindle_cw", default.spindle_cw),
        spindle_ccw: lines(&section, "spindle_ccw", default.spindle_ccw),
        coolant1: lines(&section, "coolant1", default.coolant1),
        coolant2: lines(&section, "coolant2", default.coolant2),
        clamp: lines(&section, "clamp", default.clamp),
        clamp_wait: lines(&section, "clamp_wait", 0),
        unclamp_wait: lines(&section, "unclamp_wait", 0),
    };
    section.done();
    masks
}

/// An axis of the file by its name; a finding where there is none.
fn named_axis(section: &Section<'_, '_>, key: &'static str, axes: &[Axis]) -> Option<usize> {
    let name = section.text(key)?;
    let found = axes.iter().position(|a| a.name == name);
    if found.is_none() {
        section.finding(key, "MC107", &format!("there is no axis {name}"));
    }
    found
}

fn spindle(section: Section<'_, '_>, axes: &[Axis]) -> Spindle {
    let axis = named_axis(&section, "axis", axes);
    let command = named_axis(&section, "command_axis", axes);
    let full_speed = section.number("full_speed", "1/min", TINY..=BIG, 10_000.0);
    if axis.is_some_and(|a| axes[a].kind != AxisKind::Rotary || axes[a].letter.is_some()) {
        section.finding("axis", "MC110", "the spindle axis is rotary and has letter = \"\"");
    }
    if command.is_some_and(|a| a > 7 || axes[a].letter.is_some() || Some(a) == axis) {
        section.finding(
            "command_axis",
            "MC110",
            "one of the first 8 axes, with letter = \"\", and not the spindle axis",
        );
    }
    let spindle = Spindle {
        axis,
        limit: section.number("limit", "1/min", 0.0..=BIG, 0.0),
        command: command.map(|a| (a, full_speed)),
        dwell_s: section.number("dwell_s", "s", 0.0..=86_400.0, 0.0),
    };
    section.done();
    spindle
}

fn nfrax(section: &Section<'_, '_>, axes: &[Axis]) -> Vec<usize> {
    let mut list = Vec::new();
    for (name, span) in section.texts("nfrax").unwrap_or_default() {
        match axes.iter().position(|a| a.name == name && a.kind == AxisKind::Rotary) {
            Some(axis) => list.push(axis),
            None => section.finding_at(span, "MC107", &format!("there is no rotary axis {name}"), None),
        }
    }
    list
}

fn position_factors(section: &Section<'_, '_>, axes: &[Axis]) -> Vec<f64> {
    let table = section.section("position_factors");
    let factors = table.as_ref().map_or_else(|| vec![1.0; axes.len()], |table| per_axis(table, axes, |_| 1.0));
    if let Some(zero) = factors.iter().position(|f| *f == 0.0) {
        section.finding("position_factors", "MC106", &format!("{}: a factor is not 0", axes[zero].name));
    }
    factors
}

/// G codes of the machine: those without a meaning of their own, whole numbers from 100 on.
fn g_functions(section: &Section<'_, '_>) -> Vec<(u16, String)> {
    let mut functions: Vec<(u16, String)> = Vec::new();
    for entry in section.sections("g") {
        let number = entry.required_integer("number", 100..=999);
        let tenths = number.unwrap_or(100) as u16 * 10;
        if tenths == 1070 || functions.iter().any(|f| f.0 == tenths) {
            entry.finding("number", "MC111", "this G function has its meaning already");
        }
        let name = entry.text("subprogram").unwrap_or_default();
        if name.is_empty() || !name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') {
            entry.finding("subprogram", "MC107", "letters, digits and '_'");
        }
        functions.push((tenths, name.to_owned()));
        entry.done();
    }
    functions
}

/// M functions with a meaning of their own in every dialect.
pub fn has_fixed_meaning(m: u32) -> bool {
    matches!(m, 0..=11 | 13 | 14 | 17 | 19 | 29 | 30 | 36..=49 | 60 | 62..=66 | 98 | 99)
}

fn m_functions(section: &Section<'_, '_>) -> Vec<MFunction> {
    let mut functions: Vec<MFunction> = Vec::new();
    for entry in section.sections("m") {
        let number = entry.required_integer("number", 0..=999);
        if number.is_some_and(|m| has_fixed_meaning(m) || functions.iter().any(|f| f.number == m)) {
            entry.finding("number", "MC111", "this M function has its meaning already");
        }
        let function = MFunction {
            number: number.unwrap_or(0),
            set: lines(&entry, "set", 0),
            reset: lines(&entry, "reset", 0),
            wait: lines(&entry, "wait", 0),
            ci: m_integer(&entry),
        };
        entry.done();
        functions.push(function);
    }
    functions
}

/// The common integer that an M function writes, and the value.
fn m_integer(entry: &Section<'_, '_>) -> Option<(u32, i32)> {
    let value = entry.number("value", "", f64::from(i32::MIN)..=f64::from(i32::MAX), 1.0);
    if value.fract() != 0.0 {
        entry.finding("value", "MC105", "a whole number expected");
    }
    Some((common_integer(entry, "ci")?, value as i32))
}

/// A common integer that is free for use: CI99 belongs to the waits (4.4.123).
fn common_integer(section: &Section<'_, '_>, key: &'static str) -> Option<u32> {
    let number = section.integer_if_given(key, 0..=999)?;
    if number == crate::mcu::WAIT_CI as u32 {
        section.finding(key, "MC111", "CI99 is reserved for the waits of the spooler");
    }
    Some(number)
}
