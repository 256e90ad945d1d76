//! A machine printed back as a machine file, resolved with all defaults: reading it again gives the same machine.

use std::fmt::{Display, Write};

use super::equipment::{OUTPUT_FUNCTIONS, SIDES};
use super::file::{CONTROLS, DRIVES, INPUT_FUNCTIONS, KINDS, LIMIT_FUNCTIONS};
use super::gcode::{ARC_CENTRES, DWELL_UNITS, PROFILES};
use super::*;
use crate::registers::ModeReg;
use crate::units::POSITION_UNITS;
use crate::zero::ZERO_OFFSET_SETS;

impl Machine {
    /// The resolved machine file.
    pub fn show(&self) -> String {
        let mut out = Out(String::new());
        out.text("name", &self.name);
        out.value("tolerance_mm", number(self.tolerance_mm));
        if let Some(stimulus) = &self.stimulus {
            out.text("stimulus", &stimulus.text);
        }
        out.controller(&self.controller);
        self.axes.iter().for_each(|axis| out.axis(axis));
        self.inputs.iter().for_each(|input| out.input(input, &self.axes));
        self.outputs.iter().for_each(|output| out.digital_output(output, &self.axes));
        out.gcode(&self.gcode, &self.axes);
        out.0
    }
}

struct Out(String);

/// A number that TOML reads back as the same double.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn word<T: PartialEq>(words: &[(&'static str, T)], meaning: &T) -> &'static str {
    words.iter().find(|(_, m)| m == meaning).map_or("", |(word, _)| word)
}

/// A bit mask as the list of its lines 1 to 32.
fn lines(mask: u32) -> String {
    let list: Vec<String> = (0..32).filter(|n| mask >> n & 1 == 1).map(|n| (n + 1).to_string()).collect();
    format!("[{}]", list.join(", "))
}

impl Out {
    fn line(&mut self, text: impl Display) {
        writeln!(self.0, "{text}").expect("writing to a String");
    }
    fn value(&mut self, key: &str, value: impl Display) {
        self.line(format_args!("{key} = {value}"));
    }
    fn text(&mut self, key: &str, text: &str) {
        let quoted = toml::Value::from(text).to_string();
        self.value(key, quoted);
    }
    fn names<'n>(&mut self, key: &str, names: impl Iterator<Item = &'n str>) {
        let quoted: Vec<String> = names.map(|name| format!("\"{name}\"")).collect();
        self.value(key, format_args!("[{}]", quoted.join(", ")));
    }
    fn controller(&mut self, c: &Controller) {
        self.line("\n[controller]");
        self.value("sample_ticks", c.sample_ticks);
        self.value("spool_memory_bytes", c.spool_memory_bytes);
        self.value("direct_latency", c.direct_latency);
        self.value("statements_per_sample", c.statements_per_sample);
        self.value("lookahead_depth", c.lookahead_depth);
        self.value("clock_hz", number(c.clock_hz));
        self.names("stop_at", c.stop_at.names());
    }
    fn limits(&mut self, limits: Option<&SoftwareLimits>) {
        let Some(SoftwareLimits { left, right, function }) = limits else { return };
        let (left, right, function) = (number(*left), number(*right), word(&LIMIT_FUNCTIONS, function));
        self.value("limits", format_args!("{{ left = {left}, right = {right}, function = \"{function}\" }}"));
    }
    fn zero_offsets(&mut self, offsets: &[f64; ZERO_OFFSET_SETS]) {
        if *offsets != [0.0; ZERO_OFFSET_SETS] {
            let sets = offsets.iter().enumerate().map(|(n, x)| format!("set{n} = {}", number(*x)));
            self.value("zero_offsets", format_args!("{{ {} }}", sets.collect::<Vec<_>>().join(", ")));
        }
    }
    fn axis(&mut self, a: &Axis) {
        self.line("\n[[axis]]");
        self.text("name", &a.name);
        self.text("letter", &a.letter.map(String::from).unwrap_or_default());
        self.text("kind", word(&KINDS, &a.kind));
        self.text("drive", word(&DRIVES, &a.drive));
        self.text("display_unit", word(&POSITION_UNITS, &a.display));
        let numbers = [
            ("counts_per_unit", a.counts_per_unit),
            ("slsp", a.slsp),
            ("rapid", a.rapid),
            ("acceleration", a.acceleration),
            ("jog_velocity", a.jog_velocity),
            ("jog_acceleration", a.jog_acceleration),
            ("jog_target_velocity", a.jog_target_velocity),
            ("stop_deceleration", a.stop_deceleration),
            ("mdvel", a.mdvel),
            ("maxvel", a.maxvel),
            ("maxacc", a.maxacc),
            ("jerkrel", a.jerkrel),
            ("mpe", a.mpe),
            ("ipw", a.ipw),
            ("effradius", a.effradius),
            ("start", a.start),
            ("reference", a.reference),
        ];
        for (key, value) in numbers {
            self.value(key, number(value));
        }
        self.value("modulo", a.modulo);
        self.limits(a.limits.as_ref());
        self.zero_offsets(&a.zero_offsets);
        let PidfGains { kp, ki, kd, kpl, kfcv, kfca } = a.pidf;
        self.value(
            "pidf",
            format_args!(
                "{{ kp = {kp:?}, ki = {ki:?}, kd = {kd:?}, kpl = {kpl:?}, kfcv = {kfcv:?}, kfca = {kfca:?} }}"
            ),
        );
        self.equipment(&a.equipment);
        self.line("[axis.plant]");
        self.text("control", word(&CONTROLS, &a.plant.control));
        let numbers = [
            ("lag_s", a.plant.lag_s),
            ("full_speed", a.plant.full_speed),
            ("backlash", a.plant.backlash),
            ("full_acceleration", a.plant.full_acceleration),
            ("inertia", a.plant.inertia),
            ("friction", a.plant.friction),
            ("damping", a.plant.damping),
            ("coast_s", a.plant.coast_s),
        ];
        for (key, value) in numbers {
            self.value(key, number(value));
        }
        self.value("reversed", a.plant.reversed);
    }
    fn equipment(&mut self, e: &Equipment) {
        let Home { velocity, acceleration, side } = e.home;
        for (key, value) in [("home_velocity", velocity), ("home_acceleration", acceleration)] {
            if let Some(value) = value {
                self.value(key, number(value));
            }
        }
        self.text("home_direction", word(&SIDES, &side));
        if let Some(Index { position, period, width, inverted }) = e.index {
            let numbers = format!("position = {position:?}, period = {period:?}, width = {width:?}");
            self.value("index", format_args!("{{ {numbers}, inverted = {inverted} }}"));
        }
        if let Some(Encoder { counts_per_unit, feedback }) = e.encoder {
            self.value("encoder", format_args!("{{ counts_per_unit = {counts_per_unit:?}, feedback = {feedback} }}"));
        }
        let Port { max, min, positive, negative, inverted } = e.port;
        let numbers = format!("max = {max:?}, min = {min:?}, positive = {positive:?}, negative = {negative:?}");
        self.value("port", format_args!("{{ {numbers}, inverted = {inverted} }}"));
        self.value("backlash_compensation", number(e.backlash_compensation));
        self.value("backlash_hysteresis", number(e.backlash_hysteresis));
    }
    fn digital_output(&mut self, output: &Output, axes: &[Axis]) {
        self.line("\n[[output]]");
        self.value("number", output.number);
        self.value("on", output.on);
        if let Some(axis) = output.amplifier_of {
            self.text("axis", &axes[axis].name);
            self.text("function", OUTPUT_FUNCTIONS[0].0);
        }
    }
    fn input(&mut self, input: &Input, axes: &[Axis]) {
        self.line("\n[[input]]");
        self.value("number", input.number);
        self.value("inverted", input.inverted);
        if let Some((axis, function)) = input.function {
            self.text("axis", &axes[axis].name);
            self.text("function", word(&INPUT_FUNCTIONS, &function));
        }
    }
    fn gcode(&mut self, g: &GcodeDefaults, axes: &[Axis]) {
        self.line("\n[gcode]");
        self.text("profile", word(&PROFILES, &g.profile));
        self.names("modereg", ModeReg(g.modereg).names());
        self.value("trovrst_s", number(g.trovrst_s));
        self.value("feed_limit", number(g.feed_limit));
        self.value("dry_feed", number(g.dry_feed));
        self.value("trac_feed", number(g.trac_feed));
        self.value("trac_rapid", number(g.trac_rapid));
        self.value("start_fill", g.start_fill);
        self.value("merge_tolerance", number(g.merge_tolerance));
        self.value("speed_cd", g.speed_cd);
        self.value("auxiliary_ci", g.auxiliary_ci);
        let nfrax: Vec<String> =
            g.nfrax.iter().map(|&a| toml::Value::from(axes[a].name.as_str()).to_string()).collect();
        self.value("nfrax", format_args!("[{}]", nfrax.join(", ")));
        self.dialect(&g.dialect);
        self.outputs(&g.outputs);
        self.spindle(&g.spindle, axes);
        g.g_functions.iter().for_each(|(tenths, name)| {
            self.line("\n[[gcode.g]]");
            self.value("number", tenths / 10);
            self.text("subprogram", name);
        });
        g.m_functions.iter().for_each(|m| self.m_function(m));
        for tool in g.tools.iter().filter(|t| t.number > 50 || t.length != 0.0 || t.radius != 0.0) {
            self.line("\n[[gcode.tool]]");
            self.value("number", tool.number);
            self.value("length", number(tool.length));
            self.value("radius", number(tool.radius));
        }
        self.line("\n[gcode.position_factors]");
        axes.iter().zip(&g.position_factors).for_each(|(a, factor)| self.value(&a.name, number(*factor)));
        self.line("\n[gcode.offsets]");
        for (set, code) in g.offsets.iter().zip(54..) {
            self.per_axis(&format!("G{code}"), axes, set);
        }
        self.line("\n[gcode.references]");
        for (set, p) in g.references.iter().zip(2..) {
            if let Some(set) = set {
                self.per_axis(&format!("P{p}"), axes, set);
            }
        }
    }
    fn per_axis(&mut self, key: &str, axes: &[Axis], values: &[f64]) {
        let list: Vec<String> = axes.iter().zip(values).map(|(a, v)| format!("{} = {v:?}", a.name)).collect();
        self.value(key, format_args!("{{ {} }}", list.join(", ")));
    }
    /// A key of the dialect; what the profile settles stands as a comment.
    fn option<T>(&mut self, key: &str, value: &Option<T>, text: impl Fn(&T) -> String) {
        match value {
            Some(value) => self.value(key, text(value)),
            None => self.line(format_args!("# {key}: as the profile")),
        }
    }
    fn dialect(&mut self, d: &DialectOptions) {
        self.line("\n[gcode.dialect]");
        self.option("dwell_p_unit", &d.dwell_p_unit, |unit| format!("\"{}\"", word(&DWELL_UNITS, unit)));
        self.option("arc_centre", &d.arc_centre, |centre| format!("\"{}\"", word(&ARC_CENTRES, centre)));
        self.option("integer_increment", &d.integer_increment, |value| number(*value));
        self.option("peck_clearance", &d.peck_clearance, |value| number(*value));
        self.option("main_loop", &d.main_loop, u32::to_string);
        self.option("corner_angle", &d.corner_angle, |value| number(*value));
        self.option("equal_tolerance", &d.equal_tolerance, |value| number(*value));
        let flags = [
            ("macros", d.macros),
            ("oword", d.oword),
            ("vacant_zero", d.vacant_zero),
            ("diameter", d.diameter),
            ("uvw_incremental", d.uvw_incremental),
            ("keep_g92", d.keep_g92),
            ("nested_comments", d.nested_comments),
            ("strict_m", d.strict_m),
            ("d_is_radius", d.d_is_radius),
            ("strict_end", d.strict_end),
            ("m6_needs_t", d.m6_needs_t),
            ("rapid_blend", d.rapid_blend),
            ("thread_as_feed", d.thread_as_feed),
            ("tapping_floating", d.tapping_floating),
            ("end_feed", d.end_feed),
            ("g07_g08", d.g07_g08),
            ("g_system_a", d.g_system_a),
            ("radius_correction", d.radius_correction),
            ("feed_per_revolution", d.feed_per_revolution),
            ("exact_in_position", d.exact_in_position),
        ];
        for (key, flag) in flags {
            self.option(key, &flag, bool::to_string);
        }
    }
    fn outputs(&mut self, o: &OutputMasks) {
        self.line("\n[gcode.outputs]");
        let masks = [
            ("spindle_cw", o.spindle_cw),
            ("spindle_ccw", o.spindle_ccw),
            ("coolant1", o.coolant1),
            ("coolant2", o.coolant2),
            ("clamp", o.clamp),
            ("clamp_wait", o.clamp_wait),
            ("unclamp_wait", o.unclamp_wait),
        ];
        for (key, mask) in masks {
            self.value(key, lines(mask));
        }
    }
    fn spindle(&mut self, s: &Spindle, axes: &[Axis]) {
        self.line("\n[gcode.spindle]");
        if let Some(axis) = s.axis {
            self.text("axis", &axes[axis].name);
        }
        self.value("limit", number(s.limit));
        if let Some((axis, full_speed)) = s.command {
            self.text("command_axis", &axes[axis].name);
            self.value("full_speed", number(full_speed));
        }
        self.value("dwell_s", number(s.dwell_s));
    }
    fn m_function(&mut self, m: &MFunction) {
        self.line("\n[[gcode.m]]");
        self.value("number", m.number);
        for (key, mask) in [("set", m.set), ("reset", m.reset), ("wait", m.wait)] {
            self.value(key, lines(mask));
        }
        if let Some((ci, value)) = m.ci {
            self.value("ci", ci);
            self.value("value", value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builtin_is_valid_and_reads_back_the_same() {
        let machine = Machine::builtin();
        assert_eq!(machine.axes.len(), 3);
        assert_eq!(Machine::parse(machine.show().as_bytes()), Ok(machine));
    }

    #[test]
    fn a_changed_value_is_shown() {
        let mut machine = Machine::builtin();
        machine.axes[1].limits = None;
        machine.axes[2].plant.backlash = 0.01;
        assert_eq!(Machine::parse(machine.show().as_bytes()), Ok(machine));
    }
}
