//! What the compiler has to say, as values: id, place, message, remedy. Only the outermost layer prints them.

use std::collections::HashSet;
use std::fmt::Display;

pub use crate::catalogue::{CATALOGUE, Id, Language};
use crate::source::{Sources, Span};

/// One finding. Lines and columns count from 1 in characters; `end_column` is the last column of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    pub file: String,
    pub line: u32,
    pub column: u32,
    pub end_column: u32,
    pub id: Id,
    /// A name that is close to an unknown one.
    pub suggestion: Option<String>,
    /// The source line, for the caret below it.
    pub text: String,
    arguments: Vec<Phrase>,
}

/// What fills a hole of a message: text of the program as it is, or words that have a translation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Phrase([String; 2]);

impl Phrase {
    pub fn new(english: &str, german: &str) -> Self {
        Phrase([english.to_owned(), german.to_owned()])
    }
    fn get(&self, language: Language) -> &str {
        &self.0[usize::from(language == Language::German)]
    }
}

impl<T: Display> From<T> for Phrase {
    fn from(value: T) -> Self {
        let text = value.to_string();
        Phrase([text.clone(), text])
    }
}

impl Diagnostic {
    pub fn is_warning(&self) -> bool {
        self.id.is_warning()
    }
    pub fn message(&self, language: Language) -> String {
        let mut text = String::new();
        let mut rest = self.id.texts(language)[0];
        for argument in &self.arguments {
            let Some((head, tail)) = rest.split_once('{') else { break };
            text.push_str(head);
            text.push_str(argument.get(language));
            rest = tail.split_once('}').map_or("", |(_, after)| after);
        }
        text + rest
    }
    /// What to do about it; empty if the message says it all.
    pub fn hint(&self, language: Language) -> String {
        match (&self.suggestion, language) {
            (Some(name), Language::English) => format!("did you mean '{name}'?"),
            (Some(name), Language::German) => format!("ist '{name}' gemeint?"),
            (None, _) => self.id.texts(language)[1].to_owned(),
        }
    }
    /// The source line with a caret below the place; empty where the line is.
    pub fn excerpt(&self) -> String {
        if self.text.trim().is_empty() {
            return String::new();
        }
        let text: String = self.text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let before = " ".repeat(self.column as usize - 1);
        let width = text.chars().count().saturating_sub(self.column as usize - 1);
        let carets = ((self.end_column + 1 - self.column) as usize).min(width).max(1);
        format!("  {text}\n  {before}{}", "^".repeat(carets))
    }
    /// Place, message, excerpt, hint.
    pub fn render(&self, language: Language) -> String {
        let place = format!("{}:{}:{}", self.file, self.line, self.column);
        let mut out = format!("{place}: {}: {}", self.id.name(), self.message(language));
        for (before, text) in [("", self.excerpt()), ("  hint: ", self.hint(language))] {
            if !text.is_empty() {
                out += &format!("\n{before}{text}");
            }
        }
        out
    }
}

impl Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.render(Language::English))
    }
}

/// A finding before it is tied to its line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    pub id: Id,
    pub span: Span,
    pub arguments: Vec<Phrase>,
    pub suggestion: Option<String>,
}

impl Fault {
    pub fn new(id: Id, span: Span) -> Self {
        Fault { id, span, arguments: Vec::new(), suggestion: None }
    }
    /// Fills the next hole of the message.
    pub fn with(mut self, argument: impl Into<Phrase>) -> Self {
        self.arguments.push(argument.into());
        self
    }
    pub fn suggest(mut self, name: Option<&str>) -> Self {
        self.suggestion = name.map(str::to_owned);
        self
    }
}

/// Errors after which nothing more is worth reading, and warnings that are kept.
const MAX_ERRORS: usize = 100;
const MAX_WARNINGS: usize = 500;

/// Collects findings, each once per place.
#[derive(Debug, Default)]
pub struct Reports {
    list: Vec<Fault>,
    seen: HashSet<(u16, u32, u32, Id)>,
    errors: usize,
    warnings: usize,
}

impl Reports {
    pub fn add(&mut self, fault: Fault) {
        let (errors, warnings) = if fault.id.is_warning() { (0, 1) } else { (1, 0) };
        let room = self.errors + errors <= MAX_ERRORS && self.warnings + warnings <= MAX_WARNINGS;
        if !room {
            if errors == 1 && self.errors == MAX_ERRORS {
                self.errors += 1;
                self.list.push(Fault::new(Id::SP114, fault.span).with(MAX_ERRORS));
            }
            return;
        }
        if self.seen.insert((fault.span.file, fault.span.line, fault.span.column, fault.id)) {
            self.errors += errors;
            self.warnings += warnings;
            self.list.push(fault);
        }
    }
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }
    /// True once more than the allowed errors were found.
    pub fn stopped(&self) -> bool {
        self.errors > MAX_ERRORS
    }
    /// All findings by place, the one that says "stopped" last.
    pub fn finish(self, sources: &Sources) -> Vec<Diagnostic> {
        let mut list = self.list;
        list.sort_by_key(|f| (f.id == Id::SP114, f.span.file, f.span.line, f.span.column));
        list.into_iter().map(|fault| resolve(fault, sources)).collect()
    }
}

fn resolve(fault: Fault, sources: &Sources) -> Diagnostic {
    let Fault { id, span, arguments, suggestion } = fault;
    Diagnostic {
        file: sources.name(span.file).to_owned(),
        line: span.line,
        column: span.column,
        end_column: span.column + span.length.max(1) - 1,
        id,
        suggestion,
        text: sources.line(span.file, span.line).to_owned(),
        arguments,
    }
}

/// The candidate that a misspelt name most likely means: other case first, then one or two letters off.
pub fn closest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let reach = match name.len() {
        0..=1 => 0,
        2..=4 => 1,
        _ => 2,
    };
    let cost = |c: &str| if c.eq_ignore_ascii_case(name) { 0 } else { distance(name, c, reach) };
    candidates.filter(|c| *c != name).map(|c| (cost(c), c)).filter(|(d, _)| *d <= reach).min().map(|(_, c)| c)
}

/// Letters to insert, delete, replace or swap; anything above `most` counts as `most + 1`.
fn distance(a: &str, b: &str, most: usize) -> usize {
    if a.len().abs_diff(b.len()) > most || a.len() > 64 {
        return most + 1;
    }
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = match (i, j) {
                (0, _) => j,
                (_, 0) => i,
                _ => {
                    let change = usize::from(!a[i - 1].eq_ignore_ascii_case(&b[j - 1]));
                    let plain = (rows[i - 1][j] + 1).min(rows[i][j - 1] + 1).min(rows[i - 1][j - 1] + change);
                    let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                    if swapped { plain.min(rows[i - 2][j - 2] + 1) } else { plain }
                }
            };
        }
    }
    rows[a.len()][b.len()].min(most + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_name_finds_its_neighbour() {
        let names = || ["Position", "Speed", "i", "TRVL"].into_iter();
        assert_eq!(closest("position", names()), Some("Position"));
        assert_eq!(closest("Psoition", names()), Some("Position"));
        assert_eq!(closest("trvl", names()), Some("TRVL"));
        assert_eq!(closest("Torque", names()), None);
    }
}
