//! The thinned channel that Foxglove plots as it is: JSON with its schema, one message a sample.

use std::fmt::Write;

use crate::columns::ColumnsView;

/// Samples per message of the thinned channel: 16 * 1.28 ms gives about 50 Hz.
pub const EVERY: usize = 16;

/// JSON schema of a `/state` message for these axes.
pub fn schema(axes: &[String]) -> String {
    let one = r#"{"type":"object","properties":{"set":{"type":"number"},"actual":{"type":"number"},"following":{"type":"number"}}}"#;
    let per_axis: Vec<String> = axes.iter().map(|name| format!("{}:{one}", quoted(name))).collect();
    format!(
        concat!(
            r#"{{"type":"object","title":"State","properties":{{"t_s":{{"type":"number"}},"line":{{"type":"integer"}},"#,
            r#""speed":{{"type":"number"}},"override":{{"type":"number"}},"deviation_um":{{"type":"number"}},"#,
            r#""axes":{{"type":"object","properties":{{{}}}}}}}}}"#
        ),
        per_axis.join(",")
    )
}

/// The sample of each group of [`EVERY`] with the largest deviation, so that no peak is lost.
pub fn chosen(view: &ColumnsView) -> impl Iterator<Item = usize> {
    let largest = |from: usize| {
        let to = (from + EVERY).min(view.len());
        (from..to).max_by(|&a, &b| view.deviation_mm[a].total_cmp(&view.deviation_mm[b])).unwrap_or(from)
    };
    (0..view.len()).step_by(EVERY).map(largest)
}

/// The message of sample `k`; `before` is the sample before it, for the path speed of the set point.
pub fn message(view: &ColumnsView, k: usize, axes: &[String], sample_time_s: f64, out: &mut String) {
    let t_s = (view.first_sample + k as u64 + 1) as f64 * sample_time_s;
    out.push_str(r#"{"t_s":"#);
    number(out, t_s);
    let _ = write!(out, r#","line":{},"speed":"#, view.line[k]);
    number(out, view.v_plan[k] * view.factor[k]);
    out.push_str(r#","override":"#);
    number(out, view.factor[k]);
    out.push_str(r#","deviation_um":"#);
    number(out, f64::from(view.deviation_mm[k]) * 1e3);
    out.push_str(r#","axes":{"#);
    for (a, name) in axes.iter().enumerate() {
        let at = k * view.axes + a;
        let comma = if a > 0 { "," } else { "" };
        let _ = write!(out, r#"{comma}"{name}":{{"set":"#);
        number(out, view.dp[at]);
        out.push_str(r#","actual":"#);
        number(out, view.load[at]);
        out.push_str(r#","following":"#);
        number(out, view.dp[at] - view.rp[at]);
        out.push('}');
    }
    out.push_str("}}");
}

/// A JSON number with six decimals; `null` for what JSON has no number for. In whole millionths, since the general
/// formatting of a float costs several times as much, and there are a thousand of these a second of machine time.
fn number(out: &mut String, value: f64) {
    let millionths = (value * 1e6).round();
    if millionths.abs() < 1e15 {
        let whole = millionths as i64;
        let mut digits = [b'0'; 24];
        let (mut at, mut rest) = (digits.len(), whole.unsigned_abs());
        while rest > 0 || at > digits.len() - 8 {
            at -= 1;
            if at == digits.len() - 7 {
                digits[at] = b'.';
            } else {
                digits[at] = b'0' + (rest % 10) as u8;
                rest /= 10;
            }
        }
        if whole < 0 {
            out.push('-');
        }
        out.push_str(std::str::from_utf8(&digits[at..]).unwrap_or("null"));
    } else if value.is_finite() {
        let _ = write!(out, "{value:e}");
    } else {
        out.push_str("null");
    }
}

/// A JSON string. Axis names are letters, digits and `_`, so nothing needs an escape.
fn quoted(name: &str) -> String {
    format!("\"{name}\"")
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_are_those_of_json() {
        let text = |value| {
            let mut out = String::new();
            number(&mut out, value);
            out
        };
        assert_eq!(text(0.0), "0.000000");
        assert_eq!(text(-0.25), "-0.250000");
        assert_eq!(text(-1e-9), "0.000000");
        assert_eq!(text(12.3456789), "12.345679");
        assert_eq!(text(-7.0000005), "-7.000001");
        assert_eq!(text(1e12), "1e12");
        assert_eq!(text(f64::NAN), "null");
        assert_eq!(text(f64::NEG_INFINITY), "null");
    }
}
