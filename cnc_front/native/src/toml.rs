//! Where the values of a TOML text stand, for files that Python reads: `cnc_front._native.files`.

use pyo3::prelude::*;
use toml::de::{DeTable, DeValue};

pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(toml_values, module)?)
}

/// Path of a value (keys and list indices), kind, text of a scalar, first and last offset in bytes.
type Row = (Vec<String>, &'static str, String, usize, usize);

/// All values of a text in the order of the file. An error is one row of kind "error" with the message as text.
#[pyfunction]
fn toml_values(text: &str) -> Vec<Row> {
    let mut rows = Vec::new();
    let (table, errors) = DeTable::parse_recoverable(text);
    for error in &errors {
        let span = error.span().unwrap_or(0..0);
        rows.push((Vec::new(), "error", error.message().to_owned(), span.start, span.end));
    }
    walk_table(table.get_ref(), &[], &mut rows);
    rows
}

fn walk_table(table: &DeTable<'_>, path: &[String], rows: &mut Vec<Row>) {
    for (key, value) in table {
        let below = [path, &[key.get_ref().to_string()]].concat();
        let span = if value.get_ref().is_table() || value.get_ref().is_array() { key.span() } else { value.span() };
        walk(value.get_ref(), below, (span.start, span.end), rows);
    }
}

fn walk(value: &DeValue<'_>, path: Vec<String>, (start, end): (usize, usize), rows: &mut Vec<Row>) {
    let scalar = match value {
        DeValue::String(text) => text.to_string(),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(flag) => flag.to_string(),
        _ => String::new(),
    };
    rows.push((path.clone(), value.type_str(), scalar, start, end));
    match value {
        DeValue::Table(table) => walk_table(table, &path, rows),
        DeValue::Array(list) => {
            for (number, item) in list.iter().enumerate() {
                let below = [path.as_slice(), &[number.to_string()]].concat();
                let span = item.span();
                walk(item.get_ref(), below, (span.start, span.end), rows);
            }
        }
        _ => {}
    }
}
