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
    let speed = view.v_plan[k] * view.factor[k];
    let _ = write!(
        out,
        r#"{{"t_s":{t_s:.6},"line":{},"speed":{speed:.6},"override":{:.6},"deviation_um":{:.4},"axes":{{"#,
        view.line[k],
        view.factor[k],
        f64::from(view.deviation_mm[k]) * 1e3
    );
    for (a, name) in axes.iter().enumerate() {
        let at = k * view.axes + a;
        let comma = if a > 0 { "," } else { "" };
        let following = view.dp[at] - view.rp[at];
        let _ = write!(
            out,
            r#"{comma}{}:{{"set":{:.6},"actual":{:.6},"following":{following:.6}}}"#,
            quoted(name),
            view.dp[at],
            view.load[at]
        );
    }
    out.push_str("}}");
}

/// A JSON string. Axis names are letters, digits and `_`, so nothing needs an escape.
fn quoted(name: &str) -> String {
    format!("\"{name}\"")
}
