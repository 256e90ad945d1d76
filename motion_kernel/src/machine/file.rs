//! From the text of a machine file to a validated [`Machine`]: which keys there are, their units,
//! bounds and defaults. `docs/machine-file.md` explains them to people.

use toml::de::DeTable;

use super::equipment::{equipment, output};
use super::gcode::gcode_defaults;
use super::section::{Findings, MachineDiagnostic, Section, nearest};
use super::*;
use crate::axes::MAX_AXES;
use crate::units::{POSITION_UNITS, PositionUnit};
use crate::zero::ZERO_OFFSET_SETS;

/// The 3-axis mill that is used where no machine file is given; `examples/machines/mill3.toml` itself.
pub const BUILTIN: &str = include_str!("../../../examples/machines/mill3.toml");

/// Larger files are no machine files.
const MAX_BYTES: usize = 1 << 20;
pub(super) const BIG: f64 = 1e9;
pub(super) const TINY: f64 = 1e-9;

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

pub(super) fn machine(file: Section<'_, '_>) -> Machine {
    let axes: Vec<Axis> = file.sections("axis").into_iter().map(axis).collect();
    check_axes(&file, &axes);
    let controller = file.section("controller").map_or_else(Controller::default, |part| controller(part, axes.len()));
    let gcode = match file.section("gcode") {
        Some(section) => gcode_defaults(section, &axes),
        None => GcodeDefaults::for_axes(axes.len()),
    };
    let machine = Machine {
        inputs: file.sections("input").into_iter().map(|section| input(section, &axes)).collect(),
        outputs: file.sections("output").into_iter().map(|section| output(section, &axes)).collect(),
        stimulus: stimulus(&file, &axes),
        name: file.text("name").unwrap_or("machine").to_owned(),
        tolerance_mm: file.number("tolerance_mm", "mm", TINY..=BIG, 0.05),
        axes,
        controller,
        gcode,
    };
    file.done();
    machine
}

/// The rules in a machine file; their findings stand at the lines of the file.
fn stimulus(file: &Section<'_, '_>, axes: &[Axis]) -> Option<Stimulus> {
    let text = file.text("stimulus")?;
    let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
    match Stimulus::parse(text, &names) {
        Ok(stimulus) => Some(stimulus),
        Err(findings) => {
            findings.into_iter().for_each(|finding| file.finding_in_text("stimulus", finding));
            None
        }
    }
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
            clock_hz: 66.66666e6, // APCI-8008; 70 MHz on the APCI-8001
            stop_at: Axst::eo | Axst::dnr | Axst::lslh | Axst::lsrh,
        }
    }
}

/// Bytes that the spoolers of all axes may have together; the emulator takes about six times as much.
const SPOOL_MEMORY_IN_ALL: u64 = 1 << 29;

fn controller(section: Section<'_, '_>, axes: usize) -> Controller {
    let default = Controller::default();
    let controller = Controller {
        sample_ticks: section.integer("sample_ticks", 1..=1_000, default.sample_ticks),
        spool_memory_bytes: section.integer("spool_memory_bytes", 4_096..=1 << 28, default.spool_memory_bytes),
        direct_latency: section.integer("direct_latency", 0..=100, default.direct_latency),
        statements_per_sample: section.integer("statements_per_sample", 1..=100_000, default.statements_per_sample),
        lookahead_depth: section.integer("lookahead_depth", 0..=1_000_000, default.lookahead_depth),
        clock_hz: section.number("clock_hz", "Hz", 1e6..=1e9, default.clock_hz),
        stop_at: stop_at(&section).unwrap_or(default.stop_at),
    };
    if u64::from(controller.spool_memory_bytes) * axes as u64 > SPOOL_MEMORY_IN_ALL {
        let bound = format!("{axes} axes have more than {SPOOL_MEMORY_IN_ALL} bytes together");
        section.finding("spool_memory_bytes", "MC107", &bound);
    }
    section.done();
    controller
}

/// Status bits that tell of a fault.
const STOPPING: Axst = Axst(
    Axst::eo.0
        | Axst::dnr.0
        | Axst::lslh.0
        | Axst::lsrh.0
        | Axst::lsls.0
        | Axst::lsrs.0
        | Axst::mpe.0
        | Axst::dhef.0
        | Axst::cef.0
        | Axst::ui.0
        | Axst::saf.0,
);

fn stop_at(section: &Section<'_, '_>) -> Option<Axst> {
    let mut bits = Axst::default();
    for (name, span) in section.texts("stop_at")? {
        match Axst::by_name(name).filter(|bit| STOPPING.has(*bit)) {
            Some(bit) => bits.set(bit),
            None => {
                let known: Vec<&str> = STOPPING.names().collect();
                let near = nearest(name, &known).map(|near| format!("did you mean {near}?"));
                let hint = near.unwrap_or_else(|| format!("one of {}", known.join(", ")));
                section.finding_at(span, "MC107", &format!("stop_at: '{name}' is no axst bit of a fault"), Some(hint));
            }
        }
    }
    Some(bits)
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
        slsp: section.number("slsp", "counts", TINY..=BIG, 10_000.0),
        rapid,
        acceleration,
        jog_velocity: section.number("jog_velocity", &format!("{unit}/s"), TINY..=BIG, rapid / 4.0),
        jog_target_velocity: section.number("jog_target_velocity", &format!("{unit}/s"), -BIG..=BIG, 0.0),
        jog_acceleration: section.number("jog_acceleration", &format!("{unit}/s2"), TINY..=BIG, acceleration),
        stop_deceleration: section.number("stop_deceleration", &format!("{unit}/s2"), TINY..=BIG, acceleration),
        mdvel: section.number("mdvel", &format!("{unit}/s"), 0.0..=BIG, 0.0),
        maxvel: section.number("maxvel", &format!("{unit}/s"), 0.0..=BIG, 0.0),
        maxacc: section.number("maxacc", &format!("{unit}/s2"), 0.0..=BIG, 0.0),
        jerkrel: section.number("jerkrel", "", 0.0..=1.0, 1.0),
        mpe: section.number("mpe", unit, TINY..=BIG, 1.0),
        ipw: section.number("ipw", unit, 0.0..=BIG, 0.01),
        limits: limits(&section, unit),
        pidf: section.section("pidf").map_or_else(PidfGains::default, pidf),
        plant: section.section("plant").map_or(Plant::for_rapid(rapid), |s| plant(s, rapid, unit)),
        effradius: section.number("effradius", "mm", TINY..=BIG, 180.0 / std::f64::consts::PI),
        display: section.word("display_unit", &POSITION_UNITS, display_default(kind)),
        zero_offsets: section.section("zero_offsets").map_or([0.0; ZERO_OFFSET_SETS], |s| zero_offsets(s, unit)),
        modulo: section.flag("modulo").unwrap_or(false),
        start: section.number("start", unit, -BIG..=BIG, 0.0),
        reference: section.number("reference", unit, -BIG..=BIG, 0.0),
        equipment: equipment(&section, unit),
        name,
    };
    section.done();
    axis
}

/// The unit of the axis itself.
fn display_default(kind: AxisKind) -> PositionUnit {
    if kind == AxisKind::Linear { PositionUnit::Mm } else { PositionUnit::Deg }
}

fn zero_offsets(section: Section<'_, '_>, unit: &str) -> [f64; ZERO_OFFSET_SETS] {
    let sets = ["set0", "set1", "set2", "set3", "set4"].map(|set| section.number(set, unit, -BIG..=BIG, 0.0));
    section.done();
    sets
}

pub(super) const KINDS: [(&str, AxisKind); 2] = [("linear", AxisKind::Linear), ("rotary", AxisKind::Rotary)];
pub(super) const DRIVES: [(&str, DriveKind); 2] = [("servo", DriveKind::Servo), ("stepper", DriveKind::Stepper)];
pub(super) const CONTROLS: [(&str, DriveControl); 2] =
    [("velocity", DriveControl::Velocity), ("torque", DriveControl::Torque)];
pub(super) const LIMIT_FUNCTIONS: [(&str, LimitFunction); 4] = [
    ("off", LimitFunction::Off),
    ("TOM", LimitFunction::Tom),
    ("SMA", LimitFunction::Sma),
    ("SMD", LimitFunction::Smd),
];
/// Address letters of part programs that may name an axis (din66025.md section 4).
pub const AXIS_LETTERS: &str = "XYZABCUVW";

pub(super) const INPUT_FUNCTIONS: [(&str, InputFunction); 11] = [
    ("LSL_TOM", InputFunction::Limit(Side::Left, LimitFunction::Tom)),
    ("LSL_SMA", InputFunction::Limit(Side::Left, LimitFunction::Sma)),
    ("LSL_SMD", InputFunction::Limit(Side::Left, LimitFunction::Smd)),
    ("LSR_TOM", InputFunction::Limit(Side::Right, LimitFunction::Tom)),
    ("LSR_SMA", InputFunction::Limit(Side::Right, LimitFunction::Sma)),
    ("LSR_SMD", InputFunction::Limit(Side::Right, LimitFunction::Smd)),
    ("EO", InputFunction::EmergencyOut),
    ("DR", InputFunction::DriveReady),
    ("UI", InputFunction::User),
    ("REF", InputFunction::Reference),
    ("LP", InputFunction::Latch),
];

fn input(section: Section<'_, '_>, axes: &[Axis]) -> Input {
    let number = section.required_integer("number", 1..=16).unwrap_or(1);
    let function = section.word_if_given("function", &INPUT_FUNCTIONS);
    let name = section.text("axis");
    let axis = name.and_then(|name| axes.iter().position(|a| a.name == name));
    match (name, axis, function) {
        (Some(name), None, _) => section.finding("axis", "MC107", &format!("there is no axis {name}")),
        (None, _, Some(_)) => section.finding("function", "MC104", "the axis that the function is for is missing"),
        (Some(_), Some(_), None) => section.finding("axis", "MC104", "the function that the axis is for is missing"),
        _ => {}
    }
    let input = Input { number, inverted: section.flag("inverted").unwrap_or(false), function: axis.zip(function) };
    section.done();
    input
}

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
    pub fn for_rapid(rapid: f64) -> Plant {
        Plant {
            control: DriveControl::Velocity,
            lag_s: 0.003,
            full_speed: 1.25 * rapid,
            backlash: 0.0,
            full_acceleration: 0.0,
            inertia: 1.0,
            friction: 0.0,
            damping: 0.0,
            coast_s: 0.1,
            reversed: false,
        }
    }
}

fn plant(section: Section<'_, '_>, rapid: f64, unit: &str) -> Plant {
    let default = Plant::for_rapid(rapid);
    let acc_unit = format!("{unit}/s2");
    let plant = Plant {
        control: section.word("control", &CONTROLS, default.control),
        lag_s: section.number("lag_s", "s", 0.0..=10.0, default.lag_s),
        full_speed: section.number("full_speed", &format!("{unit}/s"), TINY..=BIG, default.full_speed),
        backlash: section.number("backlash", unit, 0.0..=BIG, 0.0),
        full_acceleration: section.number("full_acceleration", &acc_unit, 0.0..=BIG, 0.0),
        inertia: section.number("inertia", "", 1e-3..=1e3, 1.0),
        friction: section.number("friction", &acc_unit, 0.0..=BIG, 0.0),
        damping: section.number("damping", "1/s", 0.0..=1e6, 0.0),
        coast_s: section.number("coast_s", "s", 1e-4..=100.0, default.coast_s),
        reversed: section.flag("reversed").unwrap_or(false),
    };
    if plant.control == DriveControl::Torque && plant.full_acceleration == 0.0 {
        section.finding("control", "MC104", "a torque-controlled drive needs full_acceleration");
    }
    section.done();
    plant
}
