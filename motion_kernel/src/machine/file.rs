//! From the text of a machine file to a validated [`Machine`]: which keys there are, their units,
//! bounds and defaults. `docs/machine-file.md` explains them to people.

use toml::de::DeTable;

use super::section::{Findings, MachineDiagnostic, Section};
use super::*;
use crate::axes::MAX_AXES;
use crate::registers::ModeReg;

/// The 3-axis mill that is used where no machine file is given; `examples/machines/mill3.toml` itself.
pub const BUILTIN: &str = include_str!("../../../examples/machines/mill3.toml");

/// Larger files are no machine files.
const MAX_BYTES: usize = 1 << 20;
const BIG: f64 = 1e9;
const TINY: f64 = 1e-9;

impl Machine {
    /// Reads a machine file and checks all of it.
    ///
    /// # Errors
    /// Every finding of the file (MC101 ...), in the order of lines.
    pub fn parse(bytes: &[u8]) -> Result<Machine, Vec<MachineDiagnostic>> {
        let text = std::str::from_utf8(bytes).ok().filter(|t| t.len() <= MAX_BYTES && !t.contains('\0'));
        let Some(text) = text else {
            let findings = Findings::new("");
            findings.add(0..0, "MC101", "not a text file in UTF-8 of at most 1 MiB".to_owned(), None);
            return Err(findings.into_list());
        };
        let findings = Findings::new(text);
        let (table, errors) = DeTable::parse_recoverable(text);
        for error in &errors {
            findings.add(error.span().unwrap_or(0..0), "MC102", error.message().to_owned(), None);
        }
        if !errors.is_empty() {
            return Err(findings.into_list());
        }
        let machine = machine(Section::new("", table.get_ref(), 0..0, &findings));
        let list = findings.into_list();
        if list.is_empty() { Ok(machine) } else { Err(list) }
    }

    /// The built-in 3-axis mill.
    pub fn builtin() -> Machine {
        Machine::parse(BUILTIN.as_bytes()).expect("the built-in machine file is valid (test builtin_is_valid)")
    }
}

fn machine(file: Section<'_, '_>) -> Machine {
    let axes: Vec<Axis> = file.sections("axis").into_iter().map(axis).collect();
    check_axes(&file, &axes);
    let controller = file.section("controller").map_or_else(Controller::default, controller);
    let gcode = match file.section("gcode") {
        Some(section) => gcode_defaults(section, &axes),
        None => GcodeDefaults::for_axes(axes.len()),
    };
    let machine = Machine {
        name: file.text("name").unwrap_or("machine").to_owned(),
        tolerance_mm: file.number("tolerance_mm", "mm", TINY..=BIG, 0.05),
        axes,
        controller,
        gcode,
    };
    file.done();
    machine
}

fn check_axes(file: &Section<'_, '_>, axes: &[Axis]) {
    if axes.is_empty() || axes.len() > MAX_AXES {
        file.finding("axis", "MC109", &format!("{} axes", axes.len()));
    }
    for (n, axis) in axes.iter().enumerate() {
        let twin = axes[..n].iter().any(|a| a.name == axis.name || (a.letter.is_some() && a.letter == axis.letter));
        if twin {
            file.finding("axis", "MC108", &format!("the name or letter of axis {} stands twice", axis.name));
        }
    }
}

impl Default for Controller {
    fn default() -> Self {
        Controller {
            sample_ticks: 20,
            spool_memory_bytes: 148_480,
            direct_latency: 2,
            statements_per_sample: 20,
            lookahead_depth: 0,
        }
    }
}

fn controller(section: Section<'_, '_>) -> Controller {
    let default = Controller::default();
    let controller = Controller {
        sample_ticks: section.integer("sample_ticks", 1..=1_000, default.sample_ticks),
        spool_memory_bytes: section.integer("spool_memory_bytes", 4_096..=1 << 30, default.spool_memory_bytes),
        direct_latency: section.integer("direct_latency", 0..=100, default.direct_latency),
        statements_per_sample: section.integer("statements_per_sample", 1..=100_000, default.statements_per_sample),
        lookahead_depth: section.integer("lookahead_depth", 0..=1_000_000, default.lookahead_depth),
    };
    section.done();
    controller
}

fn axis(section: Section<'_, '_>) -> Axis {
    let name = section.text("name").unwrap_or_default().to_owned();
    let legal = (1..=8).contains(&name.len()) && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !legal || name.starts_with(|c: char| c.is_ascii_digit()) {
        section.finding("name", "MC107", "a name has 1 to 8 letters, digits or _ and starts with a letter");
    }
    let kind = section.word("kind", &KINDS, AxisKind::Linear);
    let unit = if kind == AxisKind::Linear { "mm" } else { "degree" };
    let acceleration = section.required("acceleration", &format!("{unit}/s2"), TINY..=BIG);
    let rapid = section.required("rapid", &format!("{unit}/s"), TINY..=BIG);
    let axis = Axis {
        letter: letter(&section, &name),
        drive: section.word("drive", &DRIVES, DriveKind::Servo),
        kind,
        counts_per_unit: section.required("counts_per_unit", &format!("counts/{unit}"), TINY..=BIG),
        rapid,
        acceleration,
        jog_velocity: section.number("jog_velocity", "unit/s", TINY..=BIG, rapid / 4.0),
        jog_acceleration: section.number("jog_acceleration", "unit/s2", TINY..=BIG, acceleration),
        stop_deceleration: section.number("stop_deceleration", "unit/s2", TINY..=BIG, acceleration),
        mdvel: section.number("mdvel", "unit/s", 0.0..=BIG, 0.0),
        maxvel: section.number("maxvel", "unit/s", 0.0..=BIG, 0.0),
        maxacc: section.number("maxacc", "unit/s2", 0.0..=BIG, 0.0),
        jerkrel: section.number("jerkrel", "", 0.0..=1.0, 1.0),
        mpe: section.number("mpe", unit, TINY..=BIG, 1.0),
        ipw: section.number("ipw", unit, 0.0..=BIG, 0.01),
        limits: limits(&section, unit),
        pidf: section.section("pidf").map_or_else(PidfGains::default, pidf),
        plant: section.section("plant").map_or(Plant::for_rapid(rapid), |s| plant(s, rapid)),
        effradius: section.number("effradius", "mm", TINY..=BIG, 180.0 / std::f64::consts::PI),
        start: section.number("start", unit, -BIG..=BIG, 0.0),
        reference: section.number("reference", unit, -BIG..=BIG, 0.0),
        name,
    };
    section.done();
    axis
}

pub(super) const KINDS: [(&str, AxisKind); 2] = [("linear", AxisKind::Linear), ("rotary", AxisKind::Rotary)];
pub(super) const DRIVES: [(&str, DriveKind); 2] = [("servo", DriveKind::Servo), ("stepper", DriveKind::Stepper)];
pub(super) const LIMIT_FUNCTIONS: [(&str, LimitFunction); 4] = [
    ("off", LimitFunction::Off),
    ("TOM", LimitFunction::Tom),
    ("SMA", LimitFunction::Sma),
    ("SMD", LimitFunction::Smd),
];
pub(super) const PROFILES: [(&str, Profile); 4] =
    [("din", Profile::Din), ("fanuc", Profile::Fanuc), ("linuxcnc", Profile::Linuxcnc), ("lathe", Profile::Lathe)];
pub(super) const DWELL_UNITS: [(&str, DwellUnit); 2] = [("ms", DwellUnit::Milliseconds), ("s", DwellUnit::Seconds)];
/// Address letters of part programs that may name an axis (din66025.md section 4).
pub const AXIS_LETTERS: &str = "XYZABCUVW";

fn letter(section: &Section<'_, '_>, name: &str) -> Option<char> {
    let text = match section.text("letter") {
        Some("") => return None, // not for part programs
        Some(text) => text,
        None => name.get(..1).filter(|_| name.len() == 1)?,
    };
    let letter = text.chars().next().filter(|c| text.len() == 1 && AXIS_LETTERS.contains(*c));
    if letter.is_none() {
        section.finding("letter", "MC107", &format!("'{text}' is not one of {AXIS_LETTERS}"));
    }
    letter
}

fn limits(section: &Section<'_, '_>, unit: &str) -> Option<SoftwareLimits> {
    let inner = section.section("limits")?;
    let limits = SoftwareLimits {
        left: inner.required("left", unit, -BIG..=BIG),
        right: inner.required("right", unit, -BIG..=BIG),
        function: inner.word("function", &LIMIT_FUNCTIONS, LimitFunction::Sma),
    };
    if limits.left >= limits.right {
        inner.finding("right", "MC110", "the right limit must lie right of the left one");
    }
    inner.done();
    Some(limits)
}

fn pidf(section: Section<'_, '_>) -> PidfGains {
    let gain = |key| section.number(key, "", 0.0..=BIG, 0.0);
    let gains = PidfGains {
        kp: gain("kp"),
        ki: gain("ki"),
        kd: gain("kd"),
        kpl: section.number("kpl", "", 0.0..=1.0, 0.0),
        kfcv: gain("kfcv"),
        kfca: gain("kfca"),
    };
    section.done();
    gains
}

impl Plant {
    /// A drive with a quarter of reserve over the rapid speed.
    pub(super) fn for_rapid(rapid: f64) -> Plant {
        Plant { lag_s: 0.003, full_speed: 1.25 * rapid, backlash: 0.0 }
    }
}

fn plant(section: Section<'_, '_>, rapid: f64) -> Plant {
    let default = Plant::for_rapid(rapid);
    let plant = Plant {
        lag_s: section.number("lag_s", "s", 0.0..=10.0, default.lag_s),
        full_speed: section.number("full_speed", "unit/s", TINY..=BIG, default.full_speed),
        backlash: section.number("backlash", "unit", 0.0..=BIG, 0.0),
    };
    section.done();
    plant
}

impl GcodeDefaults {
    /// Design D19: what a G-code run starts with where the file says nothing.
    pub(super) fn for_axes(axes: usize) -> Self {
        let bits = ModeReg::LookAhead
            | ModeReg::ChkMaxVel
            | ModeReg::ExactTargetPos
            | ModeReg::RotatoricUnit
            | ModeReg::JSatSAF;
        GcodeDefaults {
            modereg: bits.0,
            trovrst_s: 0.5,
            feed_limit: 100.0,
            trac_feed: 1000.0,
            trac_rapid: 1000.0,
            start_fill: 200,
            merge_tolerance: 0.001,
            tools: (1..=50).map(|number| Tool { number, length: 0.0, radius: 0.0 }).collect(),
            offsets: std::array::from_fn(|_| vec![0.0; axes]),
            dwell_p_unit: DwellUnit::Milliseconds,
            profile: Profile::Din,
        }
    }
}

fn gcode_defaults(section: Section<'_, '_>, axes: &[Axis]) -> GcodeDefaults {
    let default = GcodeDefaults::for_axes(axes.len());
    let profile = section.word("profile", &PROFILES, default.profile);
    let dwell = if profile == Profile::Linuxcnc { DwellUnit::Seconds } else { DwellUnit::Milliseconds };
    let gcode = GcodeDefaults {
        modereg: modereg(&section).unwrap_or(default.modereg),
        trovrst_s: section.number("trovrst_s", "s", 0.0..=1000.0, default.trovrst_s),
        feed_limit: section.number("feed_limit", "mm/s", TINY..=BIG, default.feed_limit),
        trac_feed: section.number("trac_feed", "mm/s2", TINY..=BIG, default.trac_feed),
        trac_rapid: section.number("trac_rapid", "mm/s2", TINY..=BIG, default.trac_rapid),
        start_fill: section.integer("start_fill", 1..=1_000_000, default.start_fill),
        merge_tolerance: section.number("merge_tolerance", "mm", 0.0..=1.0, default.merge_tolerance),
        tools: tools(&section, default.tools),
        offsets: offsets(&section, axes),
        dwell_p_unit: section.word("dwell_p_unit", &DWELL_UNITS, dwell),
        profile,
    };
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
    for entry in section.sections("tool") {
        let number = entry.integer("number", 1..=99_999_999, 0);
        let tool = Tool {
            number,
            length: entry.number("length", "mm", -BIG..=BIG, 0.0),
            radius: entry.number("radius", "mm", 0.0..=BIG, 0.0),
        };
        if number == 0 {
            entry.finding("number", "MC104", "a tool needs its number");
        }
        entry.done();
        tools.retain(|t| t.number != number);
        tools.push(tool);
    }
    tools.sort_by_key(|t| t.number);
    tools
}

fn offsets(section: &Section<'_, '_>, axes: &[Axis]) -> [Vec<f64>; 6] {
    const NAMES: [&str; 6] = ["G54", "G55", "G56", "G57", "G58", "G59"];
    let mut offsets: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; axes.len()]);
    let Some(table) = section.section("offsets") else { return offsets };
    for (set, name) in offsets.iter_mut().zip(NAMES) {
        let Some(entry) = table.section(name) else { continue };
        for (axis, value, span) in entry.numbers() {
            match axes.iter().position(|a| a.name == axis) {
                Some(index) if value.abs() <= BIG => set[index] = value,
                Some(_) => entry.finding_at(span, "MC106", "offset too large", None),
                None => entry.finding_at(span, "MC103", &format!("there is no axis {axis}"), None),
            }
        }
    }
    table.done();
    offsets
}
