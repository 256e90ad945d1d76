//! The thinned channel that Foxglove plots as it is: JSON with its schema, one message a sample.

use std::io::Write;

use crate::columns::ColumnsView;

/// Samples per message of the thinned channel: 32 * 1.28 ms gives about 25 Hz, which is what a plot over minutes can
/// show. Twice as many cost a tenth of the run.
pub const EVERY: usize = 32;

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
pub fn message(view: &ColumnsView, k: usize, axes: &[String], sample_time_s: f64, out: &mut Vec<u8>) {
    let t_s = (view.first_sample + k as u64 + 1) as f64 * sample_time_s;
    out.extend_from_slice(br#"{"t_s":"#);
    number(out, t_s);
    let _ = write!(out, r#","line":{},"speed":"#, view.line[k]);
    number(out, view.v_plan[k] * view.factor[k]);
    out.extend_from_slice(br#","override":"#);
    number(out, view.factor[k]);
    out.extend_from_slice(br#","deviation_um":"#);
    number(out, f64::from(view.deviation_mm[k]) * 1e3);
    out.extend_from_slice(br#","axes":{"#);
    for (a, name) in axes.iter().enumerate() {
        let at = k * view.axes + a;
        let comma = if a > 0 { "," } else { "" };
        let _ = write!(out, r#"{comma}"{name}":{{"set":"#);
        number(out, view.dp[at]);
        out.extend_from_slice(br#","actual":"#);
        number(out, view.load[at]);
        out.extend_from_slice(br#","following":"#);
        number(out, view.dp[at] - view.rp[at]);
        out.push(b'}');
    }
    out.extend_from_slice(b"}}");
}

/// A JSON number with six decimals; `null` for what JSON has no number for. In whole millionths and by pairs of digits,
/// since the general formatting of a float costs several times as much, and there are a thousand of these a second of
/// machine time.
fn number(out: &mut Vec<u8>, value: f64) {
    let millionths = value * 1e6;
    if millionths.abs() < 1e15 {
        let whole = nearest(millionths);
        let mut digits = [b'0'; 24];
        let (mut at, point) = (digits.len(), digits.len() - 7);
        let (mut units, mut parts) = (whole.unsigned_abs() / 1_000_000, (whole.unsigned_abs() % 1_000_000) as u32);
        while at > point + 1 {
            at -= 2;
            digits[at..at + 2].copy_from_slice(&PAIRS[parts as usize % 100]);
            parts /= 100;
        }
        at = point;
        digits[at] = b'.';
        while units >= 10 {
            at -= 2;
            digits[at..at + 2].copy_from_slice(&PAIRS[units as usize % 100]);
            units /= 100;
        }
        if units > 0 || at == point {
            at -= 1;
            digits[at] = b'0' + units as u8;
        }
        if whole < 0 {
            at -= 1;
            digits[at] = b'-';
        }
        out.extend_from_slice(&digits[at..]);
    } else if value.is_finite() {
        let _ = write!(out, "{value:e}");
    } else {
        out.extend_from_slice(b"null");
    }
}

/// "00" to "99"
const PAIRS: [[u8; 2]; 100] = {
    let (mut pairs, mut n) = ([[0; 2]; 100], 0);
    while n < 100 {
        pairs[n] = [b'0' + n as u8 / 10, b'0' + n as u8 % 10];
        n += 1;
    }
    pairs
};

/// As `f64::round`, which is a call here, for what fits well into an i64.
fn nearest(value: f64) -> i64 {
    let whole = value as i64;
    let rest = value - whole as f64;
    whole + i64::from(rest >= 0.5) - i64::from(rest <= -0.5)
}

/// A JSON string. Axis names are letters, digits and `_`, so nothing needs an escape.
fn quoted(name: &str) -> String {
    format!("\"{name}\"")
}

#[cfg(test)]
mod tests {
    use super::number;
    use proptest::prelude::*;

    #[test]
    fn numbers_are_those_of_json() {
        let text = |value| {
            let mut out = Vec::new();
            number(&mut out, value);
            String::from_utf8(out).expect("text")
        };
        assert_eq!(text(0.0), "0.000000");
        assert_eq!(text(-0.25), "-0.250000");
        assert_eq!(text(-1e-9), "0.000000");
        assert_eq!(text(12.3456789), "12.345679");
        assert_eq!(text(-7.0000005), "-7.000001");
        assert_eq!(text(9.9999999), "10.000000");
        assert_eq!(text(105.000001), "105.000001");
        assert_eq!(text(-998877665.5), "-998877665.500000");
        assert_eq!(text(1e12), "1e12");
        assert_eq!(text(f64::NAN), "null");
        assert_eq!(text(f64::NEG_INFINITY), "null");
    }
    proptest! {
        #[test]
        fn numbers_are_rounded_to_millionths(value in prop_oneof![-1e8..1e8f64, -10.0..10.0f64, -1e-5..1e-5f64]) {
            let mut out = Vec::new();
            number(&mut out, value);
            let text = String::from_utf8(out).expect("text");
            let rounded = (value * 1e6).round() / 1e6 + 0.0; // no -0
            prop_assert_eq!(text, format!("{rounded:.6}"));
        }
    }
}
