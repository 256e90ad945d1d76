//! From the text of a stimulus to its rules: one rule a line, every error with line and column.

use super::{Action, Compare, Condition, Rule, Stimulus, Trigger};
use crate::latch::FIRST_STROBE;
use crate::machine::{Machine, MachineDiagnostic, nearest};
use crate::mcu::COMMONS;

/// Ids of diagnostics in a stimulus, each with the remedy that is shown where no better hint exists.
pub const ST_IDS: &[(&str, &str)] = &[
    ("ST101", "save the file as UTF-8"),
    ("ST102", "write one of the words expected here"),
    ("ST103", "use the name of an axis of the machine file"),
    ("ST104", "give a number inside the range"),
    ("ST105", "use when or whenever, or an action that has an opposite"),
    ("ST106", "split the text"),
];

/// Every word of the language, for the manual page and for hints.
pub const WORDS: [&str; 26] = [
    "at", "when", "whenever", "while", "and", "after", "input", "output", "line", "ci", "on", "off", "bouncing",
    "pulsing", "blocked", "free", "encoder", "cut", "mended", "drive", "pushed", "bus", "error", "supply", "low",
    "lost",
];

const MOST_BYTES: usize = 1 << 20;
const MOST_RULES: usize = 1000;
const BIG: f64 = 1e9;
/// Pulses a second.
const MIN_HZ: f64 = 1e-3;
const MOST_HZ: f64 = 1e6;

/// A piece of a line with its columns, counted from 1.
#[derive(Clone, Copy, Debug)]
struct Token<'t> {
    text: &'t str,
    column: u32,
}

/// One finding: columns, id, message, hint.
struct Fault {
    token: (u32, u32),
    id: &'static str,
    message: String,
    hint: Option<String>,
}

impl Stimulus {
    /// Reads a text for the axes of a machine (their names).
    ///
    /// # Errors
    /// Every finding, one a line at most, in the order of lines.
    pub fn parse(text: &str, axes: &[&str]) -> Result<Stimulus, Vec<MachineDiagnostic>> {
        let mut findings = Vec::new();
        let mut rules = Vec::new();
        if text.len() > MOST_BYTES {
            let message = "larger than 1 MiB".to_owned();
            return Err(vec![diagnostic(1, Fault { token: (1, 1), id: "ST106", message, hint: None })]);
        }
        for (number, line) in (1..).zip(text.lines()) {
            let tokens = tokens(line);
            if tokens.is_empty() {
                continue;
            }
            let end = line.chars().count() as u32 + 1;
            match (Reader { tokens: &tokens, at: 0, end, axes }).rule() {
                Ok(_) if rules.len() == MOST_RULES => {
                    let message = format!("more than {MOST_RULES} rules");
                    let token = (tokens[0].column, tokens[0].column);
                    findings.push(diagnostic(number, Fault { token, id: "ST106", message, hint: None }));
                    break;
                }
                Ok(rule) => rules.push(rule),
                Err(fault) if findings.len() < 100 => findings.push(diagnostic(number, fault)),
                Err(_) => break,
            }
        }
        if findings.is_empty() { Ok(Stimulus { text: text.to_owned(), rules }) } else { Err(findings) }
    }

    /// As [`Stimulus::parse`], from the bytes of a file for a machine.
    ///
    /// # Errors
    /// As there; ST101 for what is no text.
    pub fn read(bytes: &[u8], machine: &Machine) -> Result<Stimulus, Vec<MachineDiagnostic>> {
        let Some(text) = std::str::from_utf8(bytes).ok().filter(|text| !text.contains('\0')) else {
            let message = "not a text file in UTF-8".to_owned();
            return Err(vec![diagnostic(1, Fault { token: (1, 1), id: "ST101", message, hint: None })]);
        };
        let axes: Vec<&str> = machine.axes.iter().map(|axis| axis.name.as_str()).collect();
        Stimulus::parse(text.strip_prefix('\u{feff}').unwrap_or(text), &axes)
    }
}

fn diagnostic(line: u32, fault: Fault) -> MachineDiagnostic {
    let remedy = || ST_IDS.iter().find(|(id, _)| *id == fault.id).map_or(String::new(), |row| row.1.to_owned());
    let hint = fault.hint.unwrap_or_else(remedy);
    let (column, end_column) = fault.token;
    MachineDiagnostic { line, column, end_column, id: fault.id, message: fault.message, hint }
}

/// Words, numbers and single signs of a line; a comment begins with #.
fn tokens(line: &str) -> Vec<Token<'_>> {
    let mut found: Vec<Token<'_>> = Vec::new();
    let mut begin: Option<(usize, u32)> = None;
    let mut column = 0;
    let mut close = |begin: &mut Option<(usize, u32)>, end: usize| {
        if let Some((at, column)) = begin.take() {
            found.push(Token { text: &line[at..end], column });
        }
    };
    for (at, c) in line.char_indices() {
        column += 1;
        let sign = matches!(c, ':' | ',' | '>' | '<' | '=' | '#');
        if sign || c.is_whitespace() {
            close(&mut begin, at);
        } else if begin.is_none() {
            begin = Some((at, column));
        }
        if c == '#' {
            return found;
        }
        if sign {
            begin = Some((at, column));
            close(&mut begin, at + 1);
        }
    }
    close(&mut begin, line.len());
    found
}

struct Reader<'r, 't> {
    tokens: &'r [Token<'t>],
    at: usize,
    /// Column behind the line.
    end: u32,
    axes: &'r [&'r str],
}

type Read<T> = Result<T, Fault>;

impl<'t> Reader<'_, 't> {
    fn peek(&self) -> Option<&'t str> {
        self.tokens.get(self.at).map(|token| token.text)
    }
    fn skip(&mut self, word: &str) -> bool {
        let found = self.peek() == Some(word);
        self.at += usize::from(found);
        found
    }
    /// Columns of a token, or of the end of the line.
    fn columns(&self, at: usize) -> (u32, u32) {
        let Some(token) = self.tokens.get(at) else { return (self.end, self.end) };
        (token.column, token.column + token.text.chars().count().max(1) as u32 - 1)
    }
    fn fault<T>(&self, at: usize, id: &'static str, message: String, hint: Option<String>) -> Read<T> {
        let clip = |text: String| text.chars().take(200).collect::<String>();
        Err(Fault { token: self.columns(at), id, message: clip(message), hint: hint.map(clip) })
    }
    /// The next token is none of these words.
    fn unexpected<T>(&self, words: &[&str]) -> Read<T> {
        let given = self.peek().map_or("the end of the line".to_owned(), |text| format!("'{text}'"));
        let near = self.peek().and_then(|text| nearest(text, words)).map(|near| format!("did you mean {near}?"));
        self.fault(self.at, "ST102", format!("{given} where {} is expected", words.join(", ")), near)
    }
    fn expect(&mut self, word: &str) -> Read<()> {
        if self.skip(word) { Ok(()) } else { self.unexpected(&[word]) }
    }
    /// One of two words: true for the first.
    fn either(&mut self, first: &str, second: &str) -> Read<bool> {
        if self.skip(first) {
            Ok(true)
        } else if self.skip(second) {
            Ok(false)
        } else {
            self.unexpected(&[first, second])
        }
    }
    fn number(&mut self, bounds: std::ops::RangeInclusive<f64>) -> Read<f64> {
        let Some(value) = self.peek().and_then(|text| text.parse::<f64>().ok()) else {
            return self.unexpected(&["a number"]);
        };
        if !bounds.contains(&value) {
            let message = format!("{value} is outside {} .. {}", bounds.start(), bounds.end());
            return self.fault(self.at, "ST104", message, None);
        }
        self.at += 1;
        Ok(value)
    }
    fn whole(&mut self, least: u32, most: u32) -> Read<u32> {
        let at = self.at;
        let value = self.number(f64::from(least)..=f64::from(most))?;
        if value.fract() != 0.0 {
            return self.fault(at, "ST104", format!("{value} is no whole number"), None);
        }
        Ok(value as u32)
    }
    /// A time in s or ms.
    fn seconds(&mut self) -> Read<f64> {
        let value = self.number(0.0..=BIG)?;
        Ok(if self.either("s", "ms")? { value } else { value * 1e-3 })
    }
    /// A position or distance; its unit may be written, and is that of the axis.
    fn distance(&mut self) -> Read<f64> {
        let value = self.number(-BIG..=BIG)?;
        let _ = self.skip("mm") || self.skip("deg");
        Ok(value)
    }

    fn rule(&mut self) -> Read<Rule> {
        let trigger = self.trigger()?;
        let mut rule = Rule { trigger, conditions: Vec::new(), delay_s: 0.0, actions: Vec::new() };
        if !matches!(trigger, Trigger::At(_)) {
            rule.conditions.push(self.condition()?);
            while self.skip("and") {
                rule.conditions.push(self.condition()?);
            }
            if self.skip("after") {
                rule.delay_s = self.seconds()?;
            }
        }
        if !self.skip(":") {
            let mut words = vec![":"];
            if !rule.conditions.is_empty() && rule.delay_s == 0.0 {
                words.extend(["and", "after"]);
            }
            return self.unexpected(&words);
        }
        loop {
            let at = self.at;
            let action = self.action()?;
            if trigger == Trigger::While && action.opposite().is_none() {
                return self.fault(at, "ST105", "a while rule has no end for this".to_owned(), None);
            }
            rule.actions.push(action);
            if self.peek().is_none() {
                return Ok(rule);
            }
            self.expect(",")?;
        }
    }

    fn trigger(&mut self) -> Read<Trigger> {
        match self.peek() {
            Some("at") => {
                self.at += 1;
                Ok(Trigger::At(self.seconds()?))
            }
            Some(word @ ("when" | "whenever" | "while")) => {
                self.at += 1;
                Ok(match word {
                    "when" => Trigger::When,
                    "whenever" => Trigger::Whenever,
                    _ => Trigger::While,
                })
            }
            _ => self.unexpected(&["at", "when", "whenever", "while"]),
        }
    }

    fn condition(&mut self) -> Read<Condition> {
        if self.skip("input") {
            return Ok(Condition::Input { number: self.whole(1, 16)?, on: self.either("on", "off")? });
        }
        if self.skip("output") {
            return Ok(Condition::Output { number: self.whole(1, 8)?, on: self.either("on", "off")? });
        }
        if self.skip("line") {
            return Ok(Condition::Line { compare: self.compare(true)?, value: self.number(0.0..=BIG)? });
        }
        if self.skip("ci") {
            let number = self.whole(0, COMMONS as u32 - 1)? as usize;
            return Ok(Condition::Ci { number, compare: self.compare(true)?, value: self.number(-BIG..=BIG)? });
        }
        let axis = self.axis(&["input", "output", "line", "ci"])?;
        Ok(Condition::Position { axis, compare: self.compare(false)?, value: self.distance()? })
    }
    fn compare(&mut self, equal: bool) -> Read<Compare> {
        let signs = [(">", Compare::Above), ("<", Compare::Below), ("=", Compare::Equal)];
        let signs = if equal { &signs[..] } else { &signs[..2] };
        for (sign, compare) in signs {
            if self.skip(sign) {
                return Ok(*compare);
            }
        }
        self.unexpected(&signs.iter().map(|row| row.0).collect::<Vec<_>>())
    }
    /// The axis whose name comes next, where other words could stand too.
    fn axis(&mut self, others: &[&str]) -> Read<usize> {
        let text = self.peek();
        let found = text.and_then(|text| self.axes.iter().position(|name| *name == text));
        if let Some(axis) = found {
            self.at += 1;
            return Ok(axis);
        }
        let words: Vec<&str> = self.axes.iter().chain(others).copied().collect();
        match text {
            Some(text) if text.chars().all(|c| c.is_alphanumeric() || c == '_') && nearest(text, others).is_none() => {
                let hint = format!("one of {}", words.join(", "));
                self.fault(self.at, "ST103", format!("there is no axis {text}"), Some(hint))
            }
            _ => self.unexpected(&words),
        }
    }

    /// `input 14 pulsing 10 kHz`: pulses are shorter than a sample, so only strobe inputs notice them.
    fn pulsing(&mut self, at: usize, number: u32) -> Read<Action> {
        if number <= FIRST_STROBE as u32 {
            return self.fault(at, "ST104", format!("input {number} is no strobe input (14, 15, 16)"), None);
        }
        let at = self.at;
        let value = self.number(MIN_HZ..=MOST_HZ)?;
        let hz = if self.either("Hz", "kHz")? { value } else { value * 1e3 };
        if hz > MOST_HZ {
            return self.fault(at, "ST104", format!("{hz} Hz is more than {MOST_HZ}"), None);
        }
        Ok(Action::Pulsing { number, hz })
    }

    fn action(&mut self) -> Read<Action> {
        if self.skip("input") {
            let at = self.at;
            let number = self.whole(1, 16)?;
            if self.skip("pulsing") {
                return self.pulsing(at, number);
            }
            let on = self.either("on", "off")?;
            let bounce_s = if self.skip("bouncing") { self.seconds()? } else { 0.0 };
            return Ok(Action::Input { number, on, bounce_s });
        }
        if self.skip("bus") {
            return self.expect("error").map(|()| Action::BusError);
        }
        if self.skip("supply") {
            return Ok(Action::SupplyLow { deep: !self.either("low", "lost")? });
        }
        let axis = self.axis(&["input", "bus", "supply"])?;
        match self.peek() {
            Some(word @ ("blocked" | "free")) => {
                self.at += 1;
                Ok(Action::Blocked { axis, on: word == "blocked" })
            }
            Some("encoder") => {
                self.at += 1;
                Ok(Action::EncoderCut { axis, on: self.either("cut", "mended")? })
            }
            Some("drive") => {
                self.at += 1;
                Ok(Action::DriveOff { axis, on: self.either("off", "on")? })
            }
            Some("pushed") => {
                self.at += 1;
                Ok(Action::Pushed { axis, distance: self.distance()? })
            }
            _ => self.unexpected(&["blocked", "free", "encoder", "drive", "pushed"]),
        }
    }
}
