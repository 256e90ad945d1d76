//! A machine printed back as a machine file, resolved with all defaults: reading it again gives the same machine.

use std::fmt::{Display, Write};

use super::file::{DRIVES, DWELL_UNITS, KINDS, LIMIT_FUNCTIONS, PROFILES};
use super::*;
use crate::registers::ModeReg;

impl Machine {
    /// The resolved machine file.
    pub fn show(&self) -> String {
        let mut out = Out(String::new());
        out.text("name", &self.name);
        out.value("tolerance_mm", number(self.tolerance_mm));
        out.controller(&self.controller);
        self.axes.iter().for_each(|axis| out.axis(axis));
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
    fn controller(&mut self, c: &Controller) {
        self.line("\n[controller]");
        self.value("sample_ticks", c.sample_ticks);
        self.value("spool_memory_bytes", c.spool_memory_bytes);
        self.value("direct_latency", c.direct_latency);
        self.value("statements_per_sample", c.statements_per_sample);
        self.value("lookahead_depth", c.lookahead_depth);
    }
    fn axis(&mut self, a: &Axis) {
        self.line("\n[[axis]]");
        self.text("name", &a.name);
        self.text("letter", &a.letter.map(String::from).unwrap_or_default());
        self.text("kind", word(&KINDS, &a.kind));
        self.text("drive", word(&DRIVES, &a.drive));
        let numbers = [
            ("counts_per_unit", a.counts_per_unit),
            ("rapid", a.rapid),
            ("acceleration", a.acceleration),
            ("jog_velocity", a.jog_velocity),
            ("jog_acceleration", a.jog_acceleration),
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
        if let Some(limits) = &a.limits {
            let function = word(&LIMIT_FUNCTIONS, &limits.function);
            let (left, right) = (number(limits.left), number(limits.right));
            self.value("limits", format_args!("{{ left = {left}, right = {right}, function = \"{function}\" }}"));
        }
        let PidfGains { kp, ki, kd, kpl, kfcv, kfca } = a.pidf;
        self.value(
            "pidf",
            format_args!(
                "{{ kp = {kp:?}, ki = {ki:?}, kd = {kd:?}, kpl = {kpl:?}, kfcv = {kfcv:?}, kfca = {kfca:?} }}"
            ),
        );
        let Plant { lag_s, full_speed, backlash } = a.plant;
        self.value(
            "plant",
            format_args!("{{ lag_s = {lag_s:?}, full_speed = {full_speed:?}, backlash = {backlash:?} }}"),
        );
    }
    fn gcode(&mut self, g: &GcodeDefaults, axes: &[Axis]) {
        self.line("\n[gcode]");
        self.text("profile", word(&PROFILES, &g.profile));
        let bits: Vec<String> = ModeReg(g.modereg).names().map(|name| format!("\"{name}\"")).collect();
        self.value("modereg", format_args!("[{}]", bits.join(", ")));
        self.value("trovrst_s", number(g.trovrst_s));
        self.value("feed_limit", number(g.feed_limit));
        self.value("trac_feed", number(g.trac_feed));
        self.value("trac_rapid", number(g.trac_rapid));
        self.value("start_fill", g.start_fill);
        self.value("merge_tolerance", number(g.merge_tolerance));
        self.text("dwell_p_unit", word(&DWELL_UNITS, &g.dwell_p_unit));
        for tool in g.tools.iter().filter(|t| t.number > 50 || t.length != 0.0 || t.radius != 0.0) {
            self.line("\n[[gcode.tool]]");
            self.value("number", tool.number);
            self.value("length", number(tool.length));
            self.value("radius", number(tool.radius));
        }
        self.line("\n[gcode.offsets]");
        for (set, code) in g.offsets.iter().zip(54..) {
            let list: Vec<String> = axes.iter().zip(set).map(|(a, v)| format!("{} = {v:?}", a.name)).collect();
            self.value(&format!("G{code}"), format_args!("{{ {} }}", list.join(", ")));
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
