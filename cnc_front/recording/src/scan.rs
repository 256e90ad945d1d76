//! Scanned resources, which Foxglove plots as they are: JSON with its schema, one message a sample.

use std::io::Write;

/// JSON schema of a `/scan` message.
pub fn schema(names: &[String]) -> String {
    let each: Vec<String> = names.iter().map(|name| format!(r#","{}":{{"type":"number"}}"#, key(name))).collect();
    format!(r#"{{"type":"object","title":"Scan","properties":{{"t_s":{{"type":"number"}}{}}}}}"#, each.concat())
}

/// The message of a sample; null where a resource was BUSY.
pub fn message(t_s: f64, names: &[String], values: &[f64], out: &mut Vec<u8>) {
    let t_s = (t_s * 1e9).round() / 1e9; // messages are named by nanoseconds
    let _ = write!(out, r#"{{"t_s":{t_s}"#);
    for (name, value) in names.iter().zip(values) {
        let _ = write!(out, r#","{}":"#, key(name));
        let _ = if value.is_finite() { write!(out, "{value}") } else { write!(out, "null") };
    }
    out.push(b'}');
}

/// A name that paths of plots can hold: a dot separates members there.
fn key(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}
