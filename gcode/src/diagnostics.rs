//! What the compiler has to say, as values: id, place, message, remedy. Only the outermost layer prints them.

use std::collections::HashSet;
use std::fmt::Display;

pub use crate::catalogue::{CATALOGUE, Id};

/// One finding. Lines and columns count from 1 in characters; `end_column` is the last column of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    pub file: String,
    pub line: u32,
    pub column: u32,
    pub end_column: u32,
    pub id: &'static str,
    pub message: String,
    pub hint: &'static str,
}

impl Diagnostic {
    pub fn is_warning(&self) -> bool {
        self.id.starts_with("GW")
    }
}

impl Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}: {}: {}", self.file, self.line, self.column, self.id, self.message)?;
        if self.hint.is_empty() { Ok(()) } else { write!(f, "\n  hint: {}", self.hint) }
    }
}

/// A place in a line: byte offsets, `end` exclusive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    pub start: u32,
    pub end: u32,
}

impl Span {
    pub fn new(start: usize, end: usize) -> Self {
        Span { start: start as u32, end: end as u32 }
    }
}

/// A finding before it is tied to its line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    pub id: Id,
    pub span: Span,
    pub message: String,
}

impl Fault {
    pub fn new(id: Id, span: Span) -> Self {
        Self::with(id, span, &[])
    }
    /// Fills the message of the catalogue with `args`.
    pub fn with(id: Id, span: Span, args: &[&dyn Display]) -> Self {
        Fault { id, span, message: fill(id.template(), args) }
    }
}

pub type Check<T> = Result<T, Fault>;

/// Replaces each `{..}` of the template by the next argument.
fn fill(template: &str, args: &[&dyn Display]) -> String {
    let mut text = String::with_capacity(template.len() + 16);
    let mut rest = template;
    for arg in args {
        let Some((head, tail)) = rest.split_once('{') else { break };
        let tail = tail.split_once('}').map_or("", |(_, after)| after);
        text.push_str(head);
        text.push_str(&arg.to_string());
        rest = tail;
    }
    text + rest
}

/// Warnings kept per compilation; the rest is only counted.
const MAX_WARNINGS: usize = 500;

/// Collects findings, each once per place, in the order they were found.
#[derive(Debug)]
pub struct Reports {
    list: Vec<Diagnostic>,
    seen: HashSet<(u32, u32, u32, Id)>,
    max_errors: usize,
    errors: usize,
    warnings: usize,
    stopped: bool,
}

/// Where a fault lies: file (number and name), line number, text of the line.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    pub file_index: u32,
    pub file: &'a str,
    pub line: u32,
    pub text: &'a [u8],
}

impl Reports {
    pub fn new(max_errors: usize) -> Self {
        Reports { list: Vec::new(), seen: HashSet::new(), max_errors, errors: 0, warnings: 0, stopped: false }
    }
    /// Adds a finding unless this place already has it, or too many have been found.
    pub fn add(&mut self, place: Place, fault: &Fault) {
        let span = columns(place.text, fault.span);
        self.add_columns(place, fault, span);
    }
    /// As `add`, where only the columns of the place are known; `place.text` does not count.
    pub fn add_columns(&mut self, place: Place, fault: &Fault, columns: Span) {
        if self.stopped || !self.seen.insert((place.file_index, place.line, fault.span.start, fault.id)) {
            return;
        }
        if fault.id.is_warning() {
            self.warnings += 1;
            if self.warnings <= MAX_WARNINGS {
                self.list.push(resolve(place, fault.id, columns, fault.message.clone()));
            } else {
                self.seen.remove(&(place.file_index, place.line, fault.span.start, fault.id));
            }
            return;
        }
        if self.errors == self.max_errors {
            self.stopped = true;
            let message = fill(Id::GC111.template(), &[&self.max_errors]);
            self.list.push(resolve(place, Id::GC111, columns, message));
            return;
        }
        self.errors += 1;
        self.list.push(resolve(place, fault.id, columns, fault.message.clone()));
    }
    /// Further warnings are kept, not only counted.
    pub fn keeps_warnings(&self) -> bool {
        self.warnings < MAX_WARNINGS
    }
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }
    /// True once more than the allowed errors were found: nothing more is worth reading.
    pub fn stopped(&self) -> bool {
        self.stopped
    }
    /// All findings by place, and the number of warnings that were only counted.
    pub fn finish(mut self) -> (Vec<Diagnostic>, usize) {
        self.list.sort_by(|a, b| (&a.file, a.line, a.column).cmp(&(&b.file, b.line, b.column)));
        let cut = self.list.iter().position(|d| d.id == "GC111").map(|at| self.list.remove(at));
        self.list.extend(cut);
        (self.list, self.warnings.saturating_sub(MAX_WARNINGS))
    }
}

/// A finding at columns that count from 0, `end` exclusive.
fn resolve(place: Place, id: Id, columns: Span, message: String) -> Diagnostic {
    let (column, file) = (columns.start + 1, place.file.to_owned());
    let end_column = columns.end.max(column);
    Diagnostic { file, line: place.line, column, end_column, id: id.name(), message, hint: id.hint() }
}

/// A place in a line in characters instead of bytes.
#[inline]
pub fn columns(text: &[u8], span: Span) -> Span {
    Span { start: characters(text, span.start as usize), end: characters(text, span.end as usize) }
}

/// Characters before byte `end`: UTF-8 where the line is valid UTF-8, else one per byte (Windows-1252).
pub fn characters(text: &[u8], end: usize) -> u32 {
    let end = end.min(text.len());
    if text.is_ascii() || std::str::from_utf8(text).is_err() {
        return end as u32;
    }
    text[..end].iter().filter(|&&b| b & 0xC0 != 0x80).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_catalogue_is_in_order_and_each_error_has_a_hint() {
        for (index, (id, name, text, hint)) in CATALOGUE.iter().enumerate() {
            assert_eq!(*id as usize, index);
            assert!(!text.is_empty());
            assert_eq!(id.is_warning(), name.starts_with("GW"), "{name}");
            assert!(id.is_warning() || !hint.is_empty(), "{name} has no hint");
        }
        assert!(CATALOGUE.windows(2).all(|w| w[0].1 < w[1].1));
    }

    #[test]
    fn columns_count_characters() {
        let text = "(ä) G1 X\u{2013}5".as_bytes();
        let place = Place { file_index: 0, file: "a.nc", line: 3, text };
        let mut reports = Reports::new(1);
        reports.add(place, &Fault::with(Id::GC104, Span::new(9, 12), &[&'\u{2013}', &"2013"]));
        reports.add(place, &Fault::new(Id::GC113, Span::default()));
        let (list, _) = reports.finish();
        assert_eq!((list[0].column, list[0].end_column), (9, 9));
        assert_eq!(list[0].message, "illegal character '\u{2013}' (U+2013)");
        assert_eq!(list[1].id, "GC111");
    }
}
