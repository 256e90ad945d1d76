//! Whatever stands in the columns: an error or a path, never a panic, a hang or a silent pass.

mod common;

use std::sync::Arc;

use common::{Columns, Program, TA};
use proptest::prelude::*;
use toolpaths::{Chunk, PerSample, Tracker, TrackerOptions};

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -100.0..100.0f64,
        1 => Just(0.0),
        1 => prop::sample::select(vec![1e-300, 1e-12, 1e9, -1e300, f64::NAN, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE]),
    ]
}

fn columns() -> impl Strategy<Value = Columns> {
    (1usize..5, 0usize..6).prop_flat_map(|(axes, n)| {
        let numbers = |len: usize| prop::collection::vec(number(), len);
        let bytes = |len: usize, top: u8| prop::collection::vec(0..top, len);
        let counts = |len: usize, top: u32| prop::collection::vec(0..top, len);
        (
            (numbers(axes), bytes(n, 4), counts(n, 99), prop::collection::vec(any::<bool>(), n), numbers(n * axes)),
            (bytes(n, 5), bytes(n, 5), numbers(2 * n), numbers(n), prop::collection::vec(0.001..200.0f64, n)),
            (counts(n, 4), counts(n, 3), counts(3, 99), numbers(3 * axes), numbers(2 * axes), counts(n, 3)),
            (numbers(n * axes), bytes(n, 5), numbers(3 * n), numbers(3 * n), any::<[bool; 2]>()),
        )
            .prop_map(move |(a, b, c, d)| Columns {
                axes,
                start: a.0,
                kind: a.1,
                line: a.2,
                rapid: a.3,
                target: a.4,
                c1: b.0,
                c2: b.1,
                center: b.2,
                phi: b.3.iter().map(|phi| phi * 5.0).collect(),
                vl: b.4,
                via_first: c.0,
                via_count: c.1,
                via_line: c.2,
                via_target: c.3,
                effradius: c.4,
                effradius_of: c.5.iter().map(|&row| row as u16).collect(),
                begin: if d.4[0] { d.0 } else { Vec::new() },
                c3: if d.4[1] { d.1 } else { Vec::new() },
                center3: if d.4[1] { d.2 } else { Vec::new() },
                normal: if d.4[1] { d.3 } else { Vec::new() },
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_columns_and_samples_are_taken_or_refused(columns in columns(), samples in prop::collection::vec(number(), 80)) {
        let Ok(path) = toolpaths::Path::new(columns.view()) else { return Ok(()) };
        prop_assert!(path.length_mm().is_finite() && path.length_mm() >= 0.0);
        prop_assert_eq!(path.extents().len(), columns.axes);
        let line = path.polyline(0.01, 1000);
        prop_assert_eq!(line.points.len(), line.lines.len() * columns.axes);
        let rows = samples.len() / columns.axes;
        let dp = &samples[..rows * columns.axes];
        let factor: Vec<f64> = (0..rows).map(|k| (k % 5) as f64 * 0.5).collect();
        let mut tracker = Tracker::new(Arc::new(path), TrackerOptions { sample_time_s: TA, ..TrackerOptions::default() });
        let chunk = Chunk { first_sample: 0, dp, load: dp, rp: dp, factor: &factor, v_plan: &factor, ..Chunk::default() };
        tracker.feed(&chunk, &mut PerSample::default());
        let summary = tracker.finish();
        prop_assert_eq!(summary.samples, rows as u64);
        if dp.iter().any(|x| x.is_nan()) {
            prop_assert!(summary.actual.max_mm == f64::INFINITY);
        }
    }
}

#[test]
fn a_move_beyond_all_numbers_is_refused() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[1e300, 1e300]);
    let text = p.path().unwrap_err().to_string();
    assert!(text.contains("line 10") && text.contains("longer than numbers reach"), "{text}");
}
