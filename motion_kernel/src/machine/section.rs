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
];

/// Collects findings; shared by all sections of one file.
pub(super) struct Findings<'t> {
    text: &'t str,
    list: RefCell<Vec<MachineDiagnostic>>,
}

impl<'t> Findings<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        Findings { text, list: RefCell::default() }
    }
    pub(super) fn add(&self, span: Range<usize>, id: &'static str, message: String, hint: Option<String>) {
        let (line, column) = self.position(span.start);
        let (end_line, end) = self.position(span.end.max(span.start + 1) - 1);
        let end_column = if end_line == line { end } else { column };
        let hint = hint.unwrap_or_else(|| {
            let row = MC_IDS.iter().find(|(known, _)| *known == id);
            row.map_or_else(String::new, |(_, hint)| (*hint).to_owned())
        });
        self.list.borrow_mut().push(MachineDiagnostic { line, column, end_column, id, message, hint });
    }
    pub(super) fn into_list(self) -> Vec<MachineDiagnostic> {
        let mut list = self.list.into_inner();
        list.sort_by_key(|d| (d.line, d.column));
        list
    }
    fn position(&self, offset: usize) -> (u32, u32) {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &self.text[..offset];
        let start = before.rfind('\n').map_or(0, |n| n + 1);
        (before.matches('\n').count() as u32 + 1, before[start..].chars().count() as u32 + 1)
    }
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
        let message = format!("{}.{key}: {wanted} expected, {} given", self.name, value.get_ref().type_str());
        self.findings.add(value.span(), "MC105", message, None);
    }

    /// A number with unit and bounds; without the key, the default.
    pub(super) fn number(&self, key: &'static str, unit: &str, bounds: RangeInclusive<f64>, default: f64) -> f64 {
        self.number_if_given(key, unit, bounds).unwrap_or(default)
    }

    /// A number without default.
    pub(super) fn required(&self, key: &'static str, unit: &str, bounds: RangeInclusive<f64>) -> f64 {
        if !self.has(key) {
            self.asked.borrow_mut().push(key);
            let message = format!("{}.{key} is missing ({unit})", self.name);
            self.findings.add(self.span.clone(), "MC104", message, Some(format!("add: {key} = ...")));
            return f64::NAN;
        }
        self.number_if_given(key, unit, bounds).unwrap_or(f64::NAN)
    }

    pub(super) fn number_if_given(&self, key: &'static str, unit: &str, bounds: RangeInclusive<f64>) -> Option<f64> {
        let value = self.get(key)?;
        let Some(number) = as_number(value.get_ref()) else {
            self.wrong_type(key, value, "a number");
            return None;
        };
        if bounds.contains(&number) {
            return Some(number);
        }
        let (lo, hi) = (bounds.start(), bounds.end());
        let message = format!("{}.{key}: {number} is outside {lo} .. {hi} {unit}", self.name);
        self.findings.add(value.span(), "MC106", message, None);
        None
    }

    /// A whole number within bounds.
    pub(super) fn integer(&self, key: &'static str, bounds: RangeInclusive<u32>, default: u32) -> u32 {
        let Some(value) = self.get(key) else { return default };
        let Some(number) = as_number(value.get_ref()).filter(|n| n.fract() == 0.0) else {
            self.wrong_type(key, value, "a whole number");
            return default;
        };
        if number >= f64::from(*bounds.start()) && number <= f64::from(*bounds.end()) {
            return number as u32;
        }
        let message = format!("{}.{key}: {number} is outside {} .. {}", self.name, bounds.start(), bounds.end());
        self.findings.add(value.span(), "MC106", message, None);
        default
    }

    pub(super) fn text(&self, key: &'static str) -> Option<&'a str> {
        let value = self.get(key)?;
        let text = value.get_ref().as_str();
        if text.is_none() {
            self.wrong_type(key, value, "a text");
        }
        text
    }

    /// One word of a list; the table gives the meaning of each.
    pub(super) fn word<T: Copy>(&self, key: &'static str, words: &[(&str, T)], default: T) -> T {
        let Some(text) = self.text(key) else { return default };
        if let Some((_, meaning)) = words.iter().find(|(w, _)| *w == text) {
            return *meaning;
        }
        let list: Vec<&str> = words.iter().map(|(w, _)| *w).collect();
        let message = format!("{}.{key}: unknown word '{text}'", self.name);
        self.findings.add(self.span_of(key), "MC107", message, Some(format!("one of {}", list.join(", "))));
        default
    }

    /// A list of texts.
    pub(super) fn texts(&self, key: &'static str) -> Option<Vec<(&'a str, Range<usize>)>> {
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
        let tables = items.iter().enumerate().filter_map(|(n, item)| {
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
        self.findings.add(self.span_of(key), id, format!("{}: {message}", self.name), None);
    }
    pub(super) fn finding_at(&self, span: Range<usize>, id: &'static str, message: &str, hint: Option<String>) {
        self.findings.add(span, id, format!("{}: {message}", self.name), hint);
    }

    /// Complains about every key that was never asked for.
    pub(super) fn done(self) {
        let asked = self.asked.borrow();
        for (key, _) in self.table {
            let name: &str = key.get_ref();
            if !asked.contains(&name) {
                let hint = nearest(name, &asked).map(|near| format!("did you mean {near}?"));
                self.findings.add(key.span(), "MC103", format!("{}.{name}: unknown key", self.name), hint);
            }
        }
    }

    fn child_name(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) }
    }
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
