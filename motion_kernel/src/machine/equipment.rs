//! What an axis has beside drive and loop: homing, index pulse, second encoder, limits of its motor command port;
//! and the digital outputs with a function.

use super::file::{BIG, TINY};
use super::section::Section;
use super::*;

/// Largest motor command in digits (32767 = 10 V).
const FULL: f64 = crate::controller::FULL_SCALE;

/// Beside drive and loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Equipment {
    /// hvl and hac of the home commands; None = a quarter of jvl, and jac.
    pub home: Home,
    pub index: Option<Index>,
    pub encoder: Option<Encoder>,
    pub port: Port,
    /// Compensation of play in the gear, and how far the set point must come back before it acts, axis units.
    pub backlash_compensation: f64,
    pub backlash_hysteresis: f64,
}

/// Home velocity and acceleration (hvl, hac), and on which side the application looks for the reference switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Home {
    pub velocity: Option<f64>,
    pub acceleration: Option<f64>,
    pub side: Side,
}

impl Default for Home {
    fn default() -> Self {
        Home { velocity: None, acceleration: None, side: Side::Left }
    }
}

pub(super) const SIDES: [(&str, Side); 2] = [("left", Side::Left), ("right", Side::Right)];

/// Index pulse of the encoder: active for `width` from `position` on, again every `period` (0 = a single pulse).
/// Positions are those of the machine as it boots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Index {
    pub position: f64,
    pub period: f64,
    pub width: f64,
    /// The signal is active low: between the pulses.
    pub inverted: bool,
}

/// Encoder of a stepper axis on its auxiliary channel (encoder verification).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    pub counts_per_unit: f64,
    /// Actual positions come from it ("Use Encoder for position feedback").
    pub feedback: bool,
}

/// Limits of the motor command (mcpmax, mcpmin) and what is added to it to either side of 0 (mcpcp, mcpcn), digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    pub max: f64,
    pub min: f64,
    pub positive: f64,
    pub negative: f64,
    /// The output signal is inverted.
    pub inverted: bool,
}

impl Default for Port {
    fn default() -> Self {
        Port { max: FULL, min: -FULL, positive: 0.0, negative: 0.0, inverted: false }
    }
}

/// A digital output of the base board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// 1 to 8.
    pub number: u32,
    /// Its state after ra and rs.
    pub on: bool,
    /// PAE: enables the power amplifier of this axis.
    pub amplifier_of: Option<usize>,
}

pub(super) const OUTPUT_FUNCTIONS: [(&str, ()); 1] = [("PAE", ())];

pub(super) fn equipment(section: &Section<'_, '_>, unit: &str) -> Equipment {
    Equipment {
        home: Home {
            velocity: section.number_if_given("home_velocity", &format!("{unit}/s"), TINY..=BIG),
            acceleration: section.number_if_given("home_acceleration", &format!("{unit}/s2"), TINY..=BIG),
            side: section.word("home_direction", &SIDES, Side::Left),
        },
        index: section.section("index").map(|s| index(s, unit)),
        encoder: section.section("encoder").map(|s| encoder(s, unit)),
        port: section.section("port").map_or_else(Port::default, port),
        backlash_compensation: section.number("backlash_compensation", unit, 0.0..=BIG, 0.0),
        backlash_hysteresis: section.number("backlash_hysteresis", unit, 0.0..=BIG, 0.0),
    }
}

fn index(section: Section<'_, '_>, unit: &str) -> Index {
    let index = Index {
        position: section.number("position", unit, -BIG..=BIG, 0.0),
        period: section.number("period", unit, 0.0..=BIG, 0.0),
        width: section.required("width", unit, TINY..=BIG),
        inverted: section.flag("inverted").unwrap_or(false),
    };
    if index.period > 0.0 && index.width >= index.period {
        section.finding("width", "MC110", "the pulse must be shorter than its period");
    }
    section.done();
    index
}

fn encoder(section: Section<'_, '_>, unit: &str) -> Encoder {
    let encoder = Encoder {
        counts_per_unit: section.required("counts_per_unit", &format!("counts/{unit}"), TINY..=BIG),
        feedback: section.flag("feedback").unwrap_or(false),
    };
    section.done();
    encoder
}

fn port(section: Section<'_, '_>) -> Port {
    let port = Port {
        max: section.number("max", "digits", -FULL..=FULL, FULL),
        min: section.number("min", "digits", -FULL..=FULL, -FULL),
        positive: section.number("positive", "digits", 0.0..=FULL, 0.0),
        negative: section.number("negative", "digits", 0.0..=FULL, 0.0),
        inverted: section.flag("inverted").unwrap_or(false),
    };
    if port.min >= port.max {
        section.finding("max", "MC110", "the largest motor command must lie above the smallest");
    }
    section.done();
    port
}

pub(super) fn output(section: Section<'_, '_>, axes: &[Axis]) -> Output {
    let number = section.required_integer("number", 1..=8).unwrap_or(1);
    let function = section.word_if_given("function", &OUTPUT_FUNCTIONS);
    let name = section.text("axis");
    let axis = name.and_then(|name| axes.iter().position(|a| a.name == name));
    match (name, axis, function) {
        (Some(name), None, _) => section.finding("axis", "MC107", &format!("there is no axis {name}")),
        (None, _, Some(())) => section.finding("function", "MC104", "the axis that the function is for is missing"),
        (Some(_), Some(_), None) => section.finding("axis", "MC104", "the function that the axis is for is missing"),
        _ => {}
    }
    let output =
        Output { number, on: section.flag("on").unwrap_or(false), amplifier_of: axis.filter(|_| function.is_some()) };
    section.done();
    output
}
