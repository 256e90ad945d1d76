//! Nanoseconds per sample for both traces together: `cargo run --release -p toolpaths --example bench`.
//! Prints one line per workload: name, samples, ns per sample.

#[path = "../tests/common/mod.rs"]
mod common;

use std::sync::Arc;
use std::time::Instant;

use common::{Program, Run, TA};
use toolpaths::{Chunk, PerSample, Tracker, TrackerOptions};

/// Rounded rectangles, lines and quarter circles, as in pocketing.
fn pocket(rings: u32) -> Program {
    let mut p = Program::new(&[0.0, 0.0, 5.0]);
    p.feed = 33.0;
    for ring in 0..rings {
        let h = 2.0 + 0.5 * f64::from(ring % 40);
        let (r, s, z) = (0.4 * h, 0.6 * h, -f64::from(ring / 40));
        p.line(&[h, -s, z]).line(&[h, s, z]).helix(0, 1, [s, s], 90.0, &[0.0, 0.0, z]);
        p.line(&[-s, h, z]).helix(0, 1, [-s, s], 90.0, &[0.0, 0.0, z]);
        p.line(&[-h, -s, z]).helix(0, 1, [-s, -s], 90.0, &[0.0, 0.0, z]);
        p.line(&[s, -h, z]).helix(0, 1, [s, -s], 90.0, &[0.0, 0.0, z]);
        assert!(r > 0.0);
    }
    p
}

/// Short lines on a smooth spatial curve.
fn short_lines(n: u32) -> Program {
    let at = |k: u32| {
        let a = f64::from(k) * 0.002;
        [
            120.0 * a.cos() + 20.0 * (7.0 * a).cos(),
            80.0 * a.sin() + 15.0 * (5.0 * a).sin(),
            -5.0 + 4.0 * (3.0 * a).sin(),
        ]
    };
    let mut p = Program::new(&at(0));
    p.feed = 50.0;
    for k in 1..=n {
        p.line(&at(k));
    }
    p
}

fn helices(n: u32) -> Program {
    let mut p = Program::new(&[5.0, 0.0, 0.0]);
    p.feed = 20.0;
    for k in 1..=n {
        p.helix(0, 1, [0.0, 0.0], 360.0, &[0.0, 0.0, -0.3 * f64::from(k)]);
    }
    p
}

/// A load side that lags by 20 ms and is off by some um.
fn lag(run: &mut Run) {
    let (a, k) = (run.axes, 1.0 - (-TA / 0.02f64).exp());
    for i in a..run.load.len() {
        run.load[i] = run.load[i - a] + k * (run.dp[i] - run.load[i - a]);
    }
}

fn measure(name: &str, program: &Program) {
    let mut run = program.run(|_| 1.0);
    lag(&mut run);
    let start = Instant::now();
    let path = Arc::new(program.path().expect("a path"));
    let built = start.elapsed();
    let mut best = f64::INFINITY;
    let mut summary = None;
    for _ in 0..20 {
        let mut tracker = Tracker::new(Arc::clone(&path), TrackerOptions { sample_time_s: TA, ..Default::default() });
        let mut actual = vec![0.0; 4096];
        let start = Instant::now();
        for first in (0..run.len()).step_by(4096) {
            let last = (first + 4096).min(run.len());
            let rows = first * run.axes..last * run.axes;
            let chunk = Chunk {
                first_sample: first as u64,
                dp: &run.dp[rows.clone()],
                load: &run.load[rows.clone()],
                rp: &run.load[rows],
                factor: &run.factor[first..last],
                v_plan: &run.v_plan[first..last],
                ..Chunk::default()
            };
            tracker.feed(&chunk, &mut PerSample { actual_mm: &mut actual, ..PerSample::default() });
        }
        best = best.min(start.elapsed().as_secs_f64() / run.len() as f64 * 1e9);
        summary = Some(tracker.finish());
    }
    let summary = summary.expect("rounds");
    println!(
        "{name}: {} blocks, {} samples, {best:.1} ns/sample for both traces, path built in {:.1} ns/block; \
         set point {:.2e} mm, actual {:.4} mm",
        path.blocks().len(),
        run.len(),
        built.as_secs_f64() / path.blocks().len() as f64 * 1e9,
        summary.setpoint.max_mm,
        summary.actual.max_mm
    );
}

fn main() {
    measure("pocket", &pocket(400));
    if std::env::args().len() > 1 {
        return;
    }
    measure("short lines", &short_lines(100_000));
    measure("helices", &helices(200));
}
