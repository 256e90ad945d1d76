//! Reading one table of a machine file: every value is asked for once with its bounds, and what nobody
//! asked for is an error. A mistyped key in a machine file is a crash into the workpiece.

use std::cell::RefCell;
use std::ops::{Range, RangeInclusive};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A finding in a machine file. Lines and columns count from 1, columns in characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MachineDiagnostic {
    pub line: u32,
    pub column: u32,
    pub end_column: u32,
    pub id: &'static str,
    pub message: String,
    pub hint: String,
}

/// Ids of machine file diagnostics, each with the remedy that is shown where no better hint exists.
pub const MC_IDS: &[(&str, &str)] = &[
    ("MC101", "the file is not text; save it as UTF-8"),
    ("MC102", "mend the TOML syntax here"),
    ("MC103", "remove the key or correct its spelling"),
    ("MC104", "add the key"),
    ("MC105", "give a value of the other type"),
    ("MC106", "give a value inside the range"),
    ("MC107", "use one of the words listed"),
    ("MC108", "names and letters of axes must be unique"),
    ("MC109", "the controller drives 1 to 18 axes"),
    ("MC110", "correct one of the two values"),
    ("MC111", "take another number"),
];

/// More findings than this are not reported.
const MOST_FINDINGS: usize = 100;
/// Longer messages are cut: a file may hold a word of a megabyte.
const MOST_CHARACTERS: usize = 200;

/// Longer lists of tables (axes, tools, M functions) are refused.
const MOST_TABLES: usize = 1000;

/// A key that the reader knows, for the reference page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Key {
    /// Path without the numbers of list elements: `axis.pidf.kp`.
    pub path: String,
    pub kind: &'static str,
    /// Range with unit, or the words allowed.
    pub range: String,
    pub default: String,
}

/// Collects findings, and the keys asked for; shared by all sections of one file.
pub(super) struct Findings<'t> {
    text: &'t str,
    line_starts: Vec<usize>,
    list: RefCell<Vec<MachineDiagnostic>>,
    keys: RefCell<Vec<Key>>,
}

impl<'t> Findings<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        let line_starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Findings { text, line_starts, list: RefCell::default(), keys: RefCell::default() }
    }
    pub(super) fn add(&self, span: Range<usize>, id: &'static str, message: String, hint: Option<String>) {
        let mut list = self.list.borrow_mut();
        if list.len() >= MOST_FINDINGS {
            return;
        }
        let (line, column) = self.position(span.start);
        let (end_line, end) = self.position(span.end.max(span.start + 1) - 1);
        let end_column = if end_line == line { end } else { column };
        let hint = hint.unwrap_or_else(|| {
            let row = MC_IDS.iter().find(|(known, _)| *known == id);
            row.map_or_else(String::new, |(_, hint)| (*hint).to_owned())
        });
        list.push(MachineDiagnostic { line, column, end_column, id, message: clipped(message), hint: clipped(hint) });
    }
    /// No further finding would be reported.
    pub(super) fn is_full(&self) -> bool {
        self.list.borrow().len() >= MOST_FINDINGS
    }
    pub(super) fn into_list(self) -> Vec<MachineDiagnostic> {
        let mut list = self.list.into_inner();
        list.sort_by_key(|d| (d.line, d.column));
        list
    }
    /// The keys asked for, each once, in the order of asking.
    pub(super) fn into_keys(self) -> Vec<Key> {
        let mut keys: Vec<Key> = Vec::new();
        for key in self.keys.into_inner() {
            if !keys.iter().any(|known| known.path == key.path) {
                keys.push(key);
            }
        }
        keys
    }
    fn position(&self, offset: usize) -> (u32, u32) {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let line = self.line_starts.partition_point(|start| *start <= offset);
        let before = &self.text[self.line_starts[line - 1]..offset];
        (line as u32, before.chars().count() as u32 + 1)
    }
}

fn clipped(text: String) -> String {
    if text.len() <= MOST_CHARACTERS {
        return text;
    }
    text.chars().take(MOST_CHARACTERS).chain(['.', '.', '.']).collect()
}

/// A number as people write it: no long rows of zeros.
fn plain(number: f64) -> String {
    if number != 0.0 && !(1e-4..1e7).contains(&number.abs()) { format!("{number:e}") } else { number.to_string() }
}

/// One table of the file.
pub(super) struct Section<'a, 't> {
    name: String,
    table: &'a DeTable<'t>,
    span: Range<usize>,
    findings: &'a Findings<'a>,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a, 't> Section<'a, 't> {
    pub(super) fn new(name: &str, table: &'a DeTable<'t>, span: Range<usize>, findings: &'a Findings<'a>) -> Self {
        Section { name: name.to_owned(), table, span, findings, asked: RefCell::default() }
    }

    /// Remembers a key for the reference page.
    fn note(&self, key: &str, kind: &'static str, range: impl FnOnce() -> String, default: impl FnOnce() -> String) {
        let mut keys = self.findings.keys.borrow_mut();
        if keys.len() < 1000 {
            let path = self.child_name(key);
            let path = path.split(['[', ']']).step_by(2).collect();
            keys.push(Key { path, kind, range: range(), default: default() });
        }
    }

    fn get(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'t>>> {
        self.asked.borrow_mut().push(key);
        self.table.iter().find(|(k, _)| k.get_ref().as_ref() == key).map(|(_, v)| v)
    }

    /// Where a key's value stands, for findings about two values together.
    pub(super) fn span_of(&self, key: &str) -> Range<usize> {
        let found = self.table.iter().find(|(k, _)| k.get_ref().as_ref() == key);
        found.map_or(self.span.clone(), |(_, v)| v.span())
    }

    pub(super) fn has(&self, key: &'static str) -> bool {
        self.table.iter().any(|(k, _)| k.get_ref().as_ref() == key)
    }

    fn wrong_type(&self, key: &str, value: &Spanned<DeValue<'t>>, wanted: &str) {
        let message = format!("{}: {wanted} expected, {} given", self.child_name(key), value.get_ref().type_str());
        self.findings.add(value.span(), "MC105", message, None);
    }

    /// A number with unit and bounds; without the key, the default.
    pub(super) fn number(&self, key: &'static str, unit: &str, bounds: RangeInclusive<f64>, default: f64) -> f64 {
        self.note(key, "number", || range_text(&bounds, unit), || plain(default));
        self.number_in(key, unit, bounds).unwrap_or(default)
    }

    /// A number without default.
    pub(super) fn required(&self, key: &'static str, unit: &str, bounds: RangeInclusive<f64>) -> f64 {
        self.note(key, "number", || range_text(&bounds, unit), || "required".to_owned());
        if self.is_missing(key, unit) {
            return f64::NAN;
        }
        self.number_in(key, unit, bounds).unwrap_or(f64::NAN)
    }

    pub(super) fn number_if_given(&self, key: &'static str, unit: &str, bounds: RangeInclusive<f64>) -> Option<f64> {
        self.note(key, "number", || range_text(&bounds, unit), String::new);
        self.number_in(key, unit, bounds)
    }

    fn number_in(&self, key: &'static str, unit: &str, bounds: RangeInclusive<f64>) -> Option<f64> {
        let value = self.get(key)?;
        let Some(number) = as_number(value.get_ref()) else {
            self.wrong_type(key, value, "a number");
            return None;
        };
        if bounds.contains(&number) {
            return Some(number);
        }
        let message = format!("{}: {number} is outside {}", self.child_name(key), range_text(&bounds, unit));
        self.findings.add(value.span(), "MC106", message, None);
        None
    }

    /// Reports a key that must be there.
    fn is_missing(&self, key: &'static str, unit: &str) -> bool {
        let missing = !self.has(key);
        if missing {
            self.asked.borrow_mut().push(key);
            let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
            let message = format!("{} is missing{unit}", self.child_name(key));
            self.findings.add(self.span.clone(), "MC104", message, Some(format!("add: {key} = ...")));
        }
        missing
    }

    /// A whole number within bounds; without the key, the default.
    pub(super) fn integer(&self, key: &'static str, bounds: RangeInclusive<u32>, default: u32) -> u32 {
        self.note(key, "integer", || integer_range_text(&bounds), || default.to_string());
        self.integer_in(key, bounds).unwrap_or(default)
    }

    pub(super) fn integer_if_given(&self, key: &'static str, bounds: RangeInclusive<u32>) -> Option<u32> {
        self.note(key, "integer", || integer_range_text(&bounds), String::new);
        self.integer_in(key, bounds)
    }

    pub(super) fn required_integer(&self, key: &'static str, bounds: RangeInclusive<u32>) -> Option<u32> {
        self.note(key, "integer", || integer_range_text(&bounds), || "required".to_owned());
        if self.is_missing(key, "") { None } else { self.integer_in(key, bounds) }
    }

    fn integer_in(&self, key: &'static str, bounds: RangeInclusive<u32>) -> Option<u32> {
        let value = self.get(key)?;
        self.integer_of(key, value, &bounds)
    }

    fn integer_of(&self, key: &str, value: &Spanned<DeValue<'t>>, bounds: &RangeInclusive<u32>) -> Option<u32> {
        let Some(number) = as_number(value.get_ref()).filter(|n| n.fract() == 0.0) else {
            self.wrong_type(key, value, "a whole number");
            return None;
        };
        if number >= f64::from(*bounds.start()) && number <= f64::from(*bounds.end()) {
            return Some(number as u32);
        }
        let message = format!("{}: {number} is outside {}", self.child_name(key), integer_range_text(bounds));
        self.findings.add(value.span(), "MC106", message, None);
        None
    }

    /// A list of whole numbers.
    pub(super) fn integers(&self, key: &'static str, bounds: RangeInclusive<u32>) -> Option<Vec<u32>> {
        self.note(key, "list of integers", || integer_range_text(&bounds), String::new);
        let value = self.get(key)?;
        let Some(items) = value.get_ref().as_array() else {
            self.wrong_type(key, value, "a list of whole numbers");
            return None;
        };
        items.iter().map(|item| self.integer_of(key, item, &bounds)).collect()
    }

    /// true or false.
    pub(super) fn flag(&self, key: &'static str) -> Option<bool> {
        self.note(key, "flag", || "true, false".to_owned(), String::new);
        let value = self.get(key)?;
        let flag = value.get_ref().as_bool();
        if flag.is_none() {
            self.wrong_type(key, value, "true or false");
        }
        flag
    }

    pub(super) fn text(&self, key: &'static str) -> Option<&'a str> {
        self.note(key, "text", String::new, String::new);
        self.text_in(key)
    }

    fn text_in(&self, key: &'static str) -> Option<&'a str> {
        let value = self.get(key)?;
        let text = value.get_ref().as_str();
        if text.is_none() {
            self.wrong_type(key, value, "a text");
        }
        text
    }

    /// One word of a list; the table gives the meaning of each.
    pub(super) fn word<T: Copy + PartialEq>(&self, key: &'static str, words: &[(&str, T)], default: T) -> T {
        let name = || words.iter().find(|(_, meaning)| *meaning == default).map_or("", |(word, _)| word).to_owned();
        self.note(key, "word", || word_list(words), name);
        self.word_in(key, words).unwrap_or(default)
    }

    pub(super) fn word_if_given<T: Copy>(&self, key: &'static str, words: &[(&str, T)]) -> Option<T> {
        self.note(key, "word", || word_list(words), String::new);
        self.word_in(key, words)
    }

    fn word_in<T: Copy>(&self, key: &'static str, words: &[(&str, T)]) -> Option<T> {
        let text = self.text_in(key)?;
        if let Some((_, meaning)) = words.iter().find(|(w, _)| *w == text) {
            return Some(*meaning);
        }
        let message = format!("{}: unknown word '{text}'", self.child_name(key));
        self.findings.add(self.span_of(key), "MC107", message, Some(format!("one of {}", word_list(words))));
        None
    }

    /// A list of texts.
    pub(super) fn texts(&self, key: &'static str) -> Option<Vec<(&'a str, Range<usize>)>> {
        self.note(key, "list of texts", String::new, String::new);
        let value = self.get(key)?;
        let texts = value.get_ref().as_array().and_then(|items| {
            items.iter().map(|item| item.get_ref().as_str().map(|text| (text, item.span()))).collect()
        });
        if texts.is_none() {
            self.wrong_type(key, value, "a list of texts");
        }
        texts
    }

    /// A table inside this one, empty if it is not there.
    pub(super) fn section(&self, key: &'static str) -> Option<Section<'a, 't>> {
        let value = self.get(key)?;
        match value.get_ref().as_table() {
            Some(table) => Some(Section::new(&self.child_name(key), table, value.span(), self.findings)),
            None => {
                self.wrong_type(key, value, "a table");
                None
            }
        }
    }

    /// The tables of `[[key]]`.
    pub(super) fn sections(&self, key: &'static str) -> Vec<Section<'a, 't>> {
        let Some(value) = self.get(key) else { return Vec::new() };
        let Some(items) = value.get_ref().as_array() else {
            self.wrong_type(key, value, "tables [[..]]");
            return Vec::new();
        };
        if items.len() > MOST_TABLES {
            let message = format!("{}: {} tables, more than {MOST_TABLES}", self.child_name(key), items.len());
            self.findings.add(value.span(), "MC106", message, None);
        }
        let tables = items.iter().take(MOST_TABLES).enumerate().filter_map(|(n, item)| {
            let Some(table) = item.get_ref().as_table() else {
                self.wrong_type(key, item, "a table");
                return None;
            };
            let name = format!("{}[{}]", self.child_name(key), n + 1);
            Some(Section::new(&name, table, item.span(), self.findings))
        });
        tables.collect()
    }

    /// Keys that are data, not names we know: every key of the table with its number (offsets per axis).
    pub(super) fn numbers(&self) -> Vec<(&'a str, f64, Range<usize>)> {
        let mut list = Vec::new();
        for (key, value) in self.table {
            match as_number(value.get_ref()).filter(|n| n.is_finite()) {
                Some(number) => list.push((key.get_ref().as_ref(), number, key.span())),
                None => self.wrong_type(key.get_ref(), value, "a number"),
            }
        }
        list
    }

    pub(super) fn finding(&self, key: &str, id: &'static str, message: &str) {
        self.findings.add(self.span_of(key), id, format!("{}: {message}", self.child_name(key)), None);
    }
    pub(super) fn finding_at(&self, span: Range<usize>, id: &'static str, message: &str, hint: Option<String>) {
        self.findings.add(span, id, format!("{}: {message}", self.name), hint);
    }

    /// A finding inside the text of a key, by line and column of that text. A text in three quotes begins on the line
    /// below them.
    pub(super) fn finding_in_text(&self, key: &str, finding: MachineDiagnostic) {
        let span = self.span_of(key);
        let value = &self.findings.text[span.clone()];
        let quotes = if value.starts_with("\"\"\"") || value.starts_with("'''") { 3 } else { 1 };
        let below = value[quotes..].starts_with('\n') || value[quotes..].starts_with("\r\n");
        let (line, column) = self.findings.position(span.start + quotes);
        let first = finding.line == 1 && !below;
        let shift = if first { column - 1 } else { 0 };
        let line = line + finding.line - 1 + u32::from(below);
        let mut list = self.findings.list.borrow_mut();
        if list.len() < MOST_FINDINGS {
            let (column, end_column) = (finding.column + shift, finding.end_column + shift);
            list.push(MachineDiagnostic { line, column, end_column, ..finding });
        }
    }

    /// Complains about every key that was never asked for.
    pub(super) fn done(self) {
        let asked = self.asked.borrow();
        for (key, _) in self.table {
            let name: &str = key.get_ref();
            if self.findings.is_full() {
                return;
            }
            if !asked.contains(&name) {
                let hint = nearest(name, &asked).map(|near| format!("did you mean {near}?"));
                self.findings.add(key.span(), "MC103", format!("{}: unknown key", self.child_name(name)), hint);
            }
        }
    }

    fn child_name(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) }
    }
}

/// Bounds with their unit.
fn range_text(bounds: &RangeInclusive<f64>, unit: &str) -> String {
    let (lo, hi) = (*bounds.start(), *bounds.end());
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    if lo == super::file::TINY {
        format!("above 0, at most {}{unit}", plain(hi))
    } else {
        format!("{} .. {}{unit}", plain(lo), plain(hi))
    }
}

fn integer_range_text(bounds: &RangeInclusive<u32>) -> String {
    format!("{} .. {}", bounds.start(), bounds.end())
}

fn word_list<T>(words: &[(&str, T)]) -> String {
    words.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(", ")
}

fn as_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).ok().map(|i| i as f64),
        DeValue::Float(f) => f.as_str().parse().ok(),
        _ => None,
    }
}

/// The known word nearest to a mistyped one, if it is near at all.
pub fn nearest<'w>(word: &str, known: &[&'w str]) -> Option<&'w str> {
    let best = known.iter().map(|k| (distance(word, k), *k)).min_by_key(|(d, _)| *d)?;
    (best.0 <= 1 + word.chars().count() / 4).then_some(best.1)
}

/// Edit distance (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().take(64).enumerate() {
        let mut corner = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let change = corner + usize::from(ca != *cb);
            corner = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(corner + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_word() {
        assert_eq!(nearest("maxac", &["maxvel", "maxacc", "mpe"]), Some("maxacc"));
        assert_eq!(nearest("colour", &["maxvel", "mpe"]), None);
    }
}
