//! Paths that could fool a foot point, and faults of known size.

mod common;

use std::sync::Arc;

use common::{Program, Run, TA, random_program};
use toolpaths::{Chunk, PathError, PerSample, Tracker, TrackerOptions};

#[test]
fn clean_lines_arcs_and_helices_have_no_deviation() {
    let mut p = Program::new(&[0.0, 0.0, 5.0]);
    p.rapid = true;
    p.feed = 200.0;
    p.line(&[10.0, 0.0, 5.0]).line(&[10.0, 0.0, 0.0]);
    p.rapid = false;
    p.feed = 20.0;
    p.line(&[20.0, 0.0, 0.0]);
    p.helix(0, 1, [20.0, 10.0], 90.0, &[0.0, 0.0, 0.0]);
    p.helix(0, 1, [25.0, 10.0], -1080.0, &[0.0, 0.0, -3.0]);
    p.helix(2, 0, [-3.0, 20.0], 180.0, &[0.0, 10.0, 0.0]);
    for factor in [0.1, 1.0, 2.0] {
        let m = p.run(|_| factor).measure(&p);
        assert!(m.summary.setpoint.max_mm < 1e-9, "{:?}", m.summary.setpoint);
        assert!(m.summary.actual.max_mm < 1e-9);
        assert!(m.summary.completed, "{} mm missing", m.summary.missing_mm);
        let pct = m.summary.feed.programmed_reached_pct.unwrap();
        assert!(pct > 99.0, "reached {pct}");
        assert!(m.summary.feed.max_over_pct.unwrap() < 1e-3, "{:?}", m.summary.feed);
    }
}

#[test]
fn out_and_back_on_one_line_and_full_circles_run_to_the_end() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[10.0, 0.0]).line(&[0.0, 0.0]).line(&[10.0, 0.0]).line(&[5.0, 0.0]).line(&[7.0, 0.0]);
    p.helix(0, 1, [6.0, 0.0], 360.0, &[0.0; 2]).helix(0, 1, [6.0, 0.0], 360.0, &[0.0; 2]);
    p.helix(0, 1, [6.0, 0.0], -720.0, &[0.0; 2]);
    let m = p.run(|_| 1.0).measure(&p);
    assert!(m.summary.setpoint.max_mm < 1e-9);
    assert!(m.summary.completed && m.summary.missing_mm < 1e-9);
    let total = p.path().unwrap().length_mm();
    let expected: f64 = p.pieces.iter().map(|piece| piece.length()).sum();
    assert!((total - expected).abs() < 1e-9);
    assert!((m.summary.path_length_mm - expected).abs() < 1e-9);
    // the foot keeps time with the path: no pass is skipped or taken early
    for k in 0..m.s_setpoint_mm.len() {
        let run = ((k + 1) as f64 * TA * 10.0).min(expected);
        assert!((m.s_setpoint_mm[k] - run).abs() < 0.06, "sample {k}: {} for {run}", m.s_setpoint_mm[k]);
    }
}

/// An Archimedean spiral of passes 50 um apart, in short lines.
fn spiral() -> Program {
    let at = |a: f64| [0.05 / std::f64::consts::TAU * a * a.cos(), 0.05 / std::f64::consts::TAU * a * a.sin()];
    let mut p = Program::new(&at(12.0));
    for k in 1..4000 {
        p.line(&at(12.0 + 0.05 * f64::from(k)));
    }
    p
}

#[test]
fn the_foot_never_jumps_to_a_neighbouring_pass() {
    let p = spiral();
    for radial in [0.0, 0.02, 0.03, 0.045, -0.03, -0.045] {
        let mut run = p.run(|_| 1.0);
        for k in 0..run.len() {
            for column in [&mut run.dp, &mut run.load] {
                let (x, y) = (column[2 * k], column[2 * k + 1]);
                let r = x.hypot(y);
                column[2 * k] += radial * x / r;
                column[2 * k + 1] += radial * y / r;
            }
        }
        let m = run.measure(&p);
        let size = f64::abs(radial);
        assert!((m.summary.setpoint.max_mm - size).abs() < 0.02 * size + 1e-9, "{radial}: {:?}", m.summary.setpoint);
        assert!((m.summary.actual.max_mm - size).abs() < 0.02 * size + 1e-9, "{radial}: {:?}", m.summary.actual);
        // outwards is to the right of a counter-clockwise spiral
        let signed = if radial > 0.0 { m.summary.actual.right_mm } else { m.summary.actual.left_mm };
        assert!((signed - size).abs() < 0.02 * size + 1e-9);
    }
}

/// First-order lag of the load side, and a second-order one that overshoots.
fn lag(run: &mut Run, time_constant: f64) {
    let (a, k) = (run.axes, 1.0 - (-TA / time_constant).exp());
    for i in a..run.load.len() {
        run.load[i] = run.load[i - a] + k * (run.dp[i] - run.load[i - a]);
    }
    settle(run, k);
}

/// Lets the load side come to rest at the end.
fn settle(run: &mut Run, k: f64) {
    let end = run.dp_at(run.len() - 1).to_vec();
    for _ in 0..200 {
        let last = run.load[run.load.len() - run.axes..].to_vec();
        let load: Vec<f64> = last.iter().zip(&end).map(|(l, e)| l + k * (e - l)).collect();
        run.push(&end, *run.command.last().unwrap(), 1.0, 0.0);
        let at = run.load.len() - run.axes;
        run.load[at..].copy_from_slice(&load);
    }
}

#[test]
fn a_lagging_load_side_does_not_deviate_on_a_straight_line_or_at_its_reversal() {
    let mut p = Program::new(&[0.0, 0.0]);
    for (to, feed) in [(10.0, 5.0), (2.0, 50.0), (6.0, 1.0), (6.5, 100.0), (0.0, 20.0)] {
        p.feed = feed;
        p.line(&[to, 0.0]);
    }
    let mut run = p.run(|_| 1.0);
    lag(&mut run, 0.02);
    let m = run.measure(&p);
    // the turning point is rounded off; the way back lies on the way out
    assert!(m.summary.actual.max_mm < 1e-6, "{:?}", m.summary.actual);
    assert!(m.summary.setpoint.max_mm < 1e-9);
    assert!(m.summary.lag_max_mm > 0.9, "{}", m.summary.lag_max_mm);
    assert!(m.s_actual_mm.last().unwrap() > &(m.summary.path_length_mm - 1e-3));
}

#[test]
fn a_corner_cut_by_lag_deviates_as_much_as_the_nearest_leg() {
    let turns = [30.0f64, 60.0, 90.0, 100.0, 110.0, 120.0, 130.0, 140.0, 150.0, 160.0, 170.0, 178.0];
    let lags = [(20.0, 0.02), (5.0, 0.05), (60.0, 0.05), (100.0, 0.01)];
    for (degrees, (feed, time_constant)) in turns.iter().flat_map(|t| lags.map(|l| (t, l))) {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let mut p = Program::new(&[0.0, 0.0]);
        p.feed = feed;
        p.line(&[10.0, 0.0]).line(&[10.0 + 10.0 * cos, 10.0 * sin]);
        let mut run = p.run(|_| 1.0);
        lag(&mut run, time_constant);
        let m = run.measure(&p);
        // nearest point of both legs that is not behind the last one
        let leg = |x: f64, y: f64, ux: f64, uy: f64, from: f64| {
            let t = (x * ux + y * uy).clamp(from, 10.0);
            ((x - t * ux).hypot(y - t * uy), t)
        };
        let (mut behind, mut expected) = (0.0f64, 0.0f64);
        for k in 0..run.len() {
            let (x, y) = (run.load[2 * k], run.load[2 * k + 1]);
            let second = leg(x - 10.0, y, cos, sin, (behind - 10.0).max(0.0));
            let first = if behind < 10.0 { leg(x, y, 1.0, 0.0, behind) } else { (f64::INFINITY, 0.0) };
            let (d, t) = if first.0 <= second.0 { first } else { (second.0, second.1 + 10.0) };
            (behind, expected) = (t, expected.max(d));
        }
        let found = m.summary.actual.max_mm;
        assert!((found - expected).abs() < 1e-9, "{degrees} at {feed}, {time_constant}: {found} for {expected}");
    }
}

#[test]
fn an_overshoot_at_a_stop_is_given_back() {
    // stops in the middle of a straight line, at a corner, and before a dwell
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[5.0, 0.0]).line(&[10.0, 0.0]).line(&[10.0, 5.0]);
    let whole = p.run(|_| 1.0);
    let mut run = Run { axes: 2, ..Run::default() };
    let mut last = 0;
    for k in 0..whole.len() {
        let (at, command) = (whole.dp_at(k), whole.command[k]);
        if command != last {
            // stands for 40 samples; the load side swings past the stop by 8 um and back
            let stop = [p.columns.target[2 * last], p.columns.target[2 * last + 1]];
            for i in 0..40 {
                run.push(&stop, last, 1.0, 0.0);
                let swing = 0.008 * (f64::from(i) / 40.0 * std::f64::consts::PI).sin();
                let at = run.load.len() - 2;
                run.load[at] += swing;
            }
            last = command;
        }
        run.push(at, command, 1.0, 10.0);
    }
    let m = run.measure(&p);
    assert!(m.summary.setpoint.max_mm < 1e-9);
    let rows = m.tracker.as_ref().unwrap().blocks();
    assert!(rows[0].actual.max_mm < 1e-6, "a stop on a straight line: {:?}", rows[0]);
    let first_stop = run.command.iter().filter(|&&c| c == 0).count() + 60;
    assert!(m.actual_mm[..first_stop].iter().all(|d| *d < 1e-6), "swings back along the line");
    assert!((m.summary.actual.max_mm - 0.008).abs() < 1e-4, "beyond the corner: {:?}", m.summary.actual);
}

#[test]
fn merged_blocks_deviate_by_at_most_their_chord() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[1.0, 0.0]);
    p.merged(&[vec![1.02, 0.0005], vec![1.04, 0.0009], vec![1.06, 0.0003]], &[1.08, 0.0]);
    p.line(&[2.0, 0.0]);
    let m = p.run(|_| 1.0).measure(&p);
    assert_eq!(m.summary.merged.blocks, 3);
    assert!((m.summary.merged.max_mm - 0.0009).abs() < 1e-12);
    assert!(m.summary.setpoint.max_mm > 0.0003 && m.summary.setpoint.max_mm <= m.summary.merged.max_mm + 1e-6);
    let path = p.path().unwrap();
    let lines: Vec<(u32, u32)> = path.blocks().iter().map(|b| (b.line, b.entry)).collect();
    assert_eq!(lines, [(10, 1), (17, 2), (18, 2), (19, 2), (20, 2), (30, 3)]);
    assert!(m.summary.completed);
}

#[test]
fn a_path_not_completed_is_reported() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[10.0, 0.0]).line(&[10.0, 10.0]);
    let whole = p.run(|_| 1.0);
    let mut run = Run { axes: 2, ..Run::default() };
    for k in 0..whole.len() * 3 / 4 {
        run.push(whole.dp_at(k), whole.command[k], 1.0, 10.0);
    }
    let m = run.measure(&p);
    assert!(!m.summary.completed);
    assert!((m.summary.missing_mm - 5.0).abs() < 0.1, "{}", m.summary.missing_mm);
    assert_eq!(m.summary.reached_line, 20);
    assert!(m.summary.setpoint.max_mm < 1e-9, "what was run is clean");
}

#[test]
fn a_skipped_block_is_no_clean_run() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[2.0, 0.0]).line(&[2.0, 2.0]).line(&[4.0, 2.0]).line(&[4.0, 4.0]);
    let whole = p.run(|_| 1.0);
    let mut run = Run { axes: 2, ..Run::default() };
    for k in (0..whole.len()).filter(|&k| whole.command[k] != 1) {
        run.push(whole.dp_at(k), whole.command[k], 1.0, 10.0);
    }
    let m = run.measure(&p);
    assert!(m.summary.setpoint.max_mm > 0.5, "{:?}", m.summary.setpoint);
}

#[test]
fn a_program_without_motion_measures_the_distance_from_its_start() {
    let p = Program::new(&[1.0, 2.0, 3.0]);
    let mut run = Run { axes: 3, ..Run::default() };
    run.push(&[1.0, 2.0, 3.0], 0, 1.0, 0.0);
    run.push(&[1.0, 2.0, 3.5], 0, 1.0, 0.0);
    let m = run.measure(&p);
    assert!((m.summary.setpoint.max_mm - 0.5).abs() < 1e-12);
    assert!(m.summary.completed);
    assert!(m.tracker.unwrap().blocks().is_empty());
    assert_eq!(p.path().unwrap().extents(), vec![(1.0, 1.0), (2.0, 2.0), (3.0, 3.0)]);
}

#[test]
fn damaged_sequences_are_refused_with_line_and_cause() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[5.0, 0.0]).helix(0, 1, [5.0, 5.0], 90.0, &[0.0, 0.0]);
    let clean = p.clone();
    assert!(clean.path().is_ok());
    p.columns.center[2] += 0.02;
    let text = p.path().unwrap_err().to_string();
    assert!(text.contains("line 20") && text.contains("mm off its target"), "{text}");
    let mut p = clean.clone();
    p.columns.target[0] = f64::NAN;
    assert!(p.path().unwrap_err().to_string().contains("line 10"));
    let mut p = clean.clone();
    p.columns.vl[1] = 0.0;
    assert!(matches!(p.path(), Err(PathError::Value { command: 2, line: 20, .. })));
    let mut p = clean.clone();
    p.columns.phi.pop();
    assert!(matches!(p.path(), Err(PathError::Column { name: "phi", expected: 2, found: 1 })));
    let mut p = clean.clone();
    p.columns.c2[1] = 9;
    assert!(p.path().is_err());
    let mut p = clean;
    p.columns.effradius_of[0] = 3;
    assert!(p.path().is_err());
}

#[test]
fn extents_and_polyline_contain_what_arcs_reach() {
    let mut p = Program::new(&[0.0, 0.0, 0.0]);
    p.line(&[10.0, 0.0, 0.0]).helix(0, 1, [10.0, 5.0], 180.0, &[0.0, 0.0, -2.0]).line(&[0.0, 10.0, -2.0]);
    let path = p.path().unwrap();
    let extents = path.extents();
    assert!((extents[0].1 - 15.0).abs() < 1e-12 && extents[0].0 == 0.0, "{extents:?}");
    assert_eq!(extents[2], (-2.0, 0.0));
    let line = path.polyline(0.001, 100_000);
    assert_eq!(line.lines.first(), Some(&10));
    assert_eq!(line.lines.last(), Some(&30));
    for (k, xyz) in line.points.chunks(3).enumerate().filter(|(k, _)| line.lines[*k] == 20) {
        let r = (xyz[0] - 10.0).hypot(xyz[1] - 5.0);
        assert!((r - 5.0).abs() < 1e-9, "vertex {k}");
    }
    assert!(line.s_mm.windows(2).all(|w| w[1] > w[0]));
    // long lines are cut, so that a deviation shows where it is
    assert!(line.s_mm.windows(2).all(|w| w[1] - w[0] < 0.01 * path.length_mm()));
    assert!(line.points.chunks(3).filter(|xyz| xyz[1] == 0.0 && xyz[2] == 0.0).count() > 100);
    // chord error is kept
    let arc = line.lines.iter().filter(|&&l| l == 20).count() as f64;
    let step = std::f64::consts::PI / arc;
    assert!(5.0 * (1.0 - (step / 2.0).cos()) <= 0.001, "{arc} chords");
    assert!(path.polyline(0.001, 10).lines.len() <= 12);
}

#[test]
fn block_times_add_up_to_the_machine_time() {
    let p = random_program(11, 3, 30);
    let run = p.run(|_| 0.7);
    let m = run.measure(&p);
    let time: f64 = m.tracker.as_ref().unwrap().blocks().iter().map(|b| b.time_s).sum();
    assert!((time - run.len() as f64 * TA).abs() < 1e-9, "{time}");
    // programmed velocity at factor 0.7, but for the last interval
    let tracker = m.tracker.unwrap();
    for (stats, block) in tracker.blocks().iter().zip(tracker.path().blocks()) {
        let mean = block.length / stats.moving_s;
        assert!((mean / (0.7 * block.vl) - 1.0).abs() < 0.2 || block.length < 1.0, "{mean} for {}", 0.7 * block.vl);
    }
}

#[test]
fn a_watched_polyline_gets_the_deviation_of_each_piece() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[1.0, 0.0]).line(&[2.0, 0.0]).line(&[3.0, 0.0]);
    let mut run = p.run(|_| 1.0);
    run.shift(1, |x| x[1] += 0.004);
    let path = Arc::new(p.path().unwrap());
    let mut tracker =
        Tracker::new(Arc::clone(&path), TrackerOptions { sample_time_s: TA, ..TrackerOptions::default() });
    // vertices closer than the samples, and the ends of the lines
    let s_mm: Vec<f64> = [0.0, 0.5, 0.501, 0.502, 1.0, 2.0, 3.0].to_vec();
    tracker.watch(&s_mm);
    let half = run.command.iter().filter(|&&c| c == 0).count() + 10;
    let mut feed = |from: usize, to: usize| {
        let rows = from * 2..to * 2;
        let chunk = Chunk {
            first_sample: from as u64,
            dp: &run.dp[rows.clone()],
            load: &run.load[rows.clone()],
            rp: &run.load[rows],
            factor: &run.factor[from..to],
            v_plan: &run.v_plan[from..to],
            ..Chunk::default()
        };
        tracker.feed(&chunk, &mut PerSample::default());
        let (max, at) = tracker.watched();
        (max.to_vec(), at)
    };
    let (max, at) = feed(0, half);
    assert_eq!(at, 5);
    assert!(max[1..5].iter().all(|d| *d < 1e-6), "{max:?}");
    assert!((max[5] - 0.004).abs() < 1e-6 && max[6].is_nan(), "{max:?}");
    let (max, at) = feed(half, run.len());
    assert_eq!(at, 6);
    assert!(max[6] < 0.0041, "{max:?}");
    // shifted up, to the left of a line to the right
    assert!((tracker.watched_signed()[5] - 0.004).abs() < 1e-6);
}

#[test]
fn a_late_load_side_does_not_jump_to_the_pass_that_the_set_point_is_on() {
    let p = spiral();
    for radial in [0.0, 0.03, 0.045, -0.03, -0.045] {
        let mut run = p.run(|_| 1.0);
        // late by 100 samples, 1.28 mm: two turns at the start
        for k in (0..run.len()).rev() {
            let (x, y) = (run.dp[2 * k.saturating_sub(100)], run.dp[2 * k.saturating_sub(100) + 1]);
            let r = x.hypot(y);
            run.load[2 * k] = x + radial * x / r;
            run.load[2 * k + 1] = y + radial * y / r;
        }
        let m = run.measure(&p);
        let size = f64::abs(radial);
        assert!((m.summary.actual.max_mm - size).abs() < 0.02 * size + 1e-9, "{radial}: {:?}", m.summary.actual);
        assert!((m.summary.lag_max_mm - 1.28).abs() < 0.1, "{radial}: {}", m.summary.lag_max_mm);
    }
}

#[test]
fn passes_over_each_other_are_told_apart_beside_the_path_too() {
    // out and back, and turns of a circle, far from the origin: rounding decides which pass seems nearer
    for off in [1e-8, 1e-6, 1e-4, 1e-2] {
        let mut p = Program::new(&[317.3, -211.7, 100.3]);
        p.feed = 100.0;
        for k in 0..30 {
            let out = 1.0 + 0.01 * f64::from(k);
            p.line(&[317.3 - 4.1 * out, -211.7 + 1.9 * out, 100.3 - 5.2 * out]).line(&[317.3, -211.7, 100.3]);
        }
        p.helix(0, 1, [312.1, -210.4], 1080.0, &[0.0, 0.0, 100.3]);
        let mut run = p.run(|_| 1.0);
        // square to the lines
        let (nx, ny) = (1.9 * off / 1.9f64.hypot(4.1), 4.1 * off / 1.9f64.hypot(4.1));
        for command in 0..60 {
            run.shift(command, |x| {
                x[0] += nx;
                x[1] += ny;
            });
        }
        run.shift(60, |x| {
            let (dx, dy) = (x[0] - 312.1, x[1] + 210.4);
            x[0] += off * dx / dx.hypot(dy);
            x[1] += off * dy / dx.hypot(dy);
        });
        let m = run.measure(&p);
        assert!((m.summary.setpoint.max_mm - off).abs() < 1e-9, "{off}: {:?}", m.summary.setpoint);
        assert!((m.summary.actual.max_mm - off).abs() < 1e-9, "{off}: {:?}", m.summary.actual);
        assert!(m.summary.completed);
    }
}

#[test]
fn a_load_side_faster_than_its_block_is_followed() {
    // half a millimetre behind: still in the slow block when the set point is in the fast one
    let mut p = Program::new(&[0.0, 0.0]);
    p.feed = 0.5;
    p.line(&[1.0, 0.0]);
    p.feed = 50.0;
    p.helix(0, 1, [1.0, 4.0], 90.0, &[0.0, 0.0]);
    let mut run = p.run(|_| 1.0);
    for k in 0..run.len() {
        let (x, y) = (run.dp[2 * k], run.dp[2 * k + 1]);
        let s = if y == 0.0 { x } else { 1.0 + 4.0 * (x - 1.0).atan2(4.0 - y) } - 0.5;
        let behind = if s < 1.0 {
            [s.max(0.0), 0.0]
        } else {
            [1.0 + 4.0 * ((s - 1.0) / 4.0).sin(), 4.0 - 4.0 * ((s - 1.0) / 4.0).cos()]
        };
        run.load[2 * k..2 * k + 2].copy_from_slice(&behind);
    }
    let m = run.measure(&p);
    assert!(m.summary.actual.max_mm < 1e-9, "{:?}", m.summary.actual);
    assert!((m.summary.lag_max_mm - 0.5).abs() < 1e-6);
}

#[test]
fn left_is_left_on_arcs_of_both_directions() {
    for (phi, outwards) in [(180.0, "right"), (-180.0, "left")] {
        let mut p = Program::new(&[5.0, 0.0]);
        p.helix(0, 1, [0.0, 0.0], phi, &[0.0, 0.0]);
        let mut run = p.run(|_| 1.0);
        run.shift(0, |x| x.iter_mut().for_each(|x| *x *= 1.001));
        let d = run.measure(&p).summary.actual;
        let (out, other) = if outwards == "right" { (d.right_mm, d.left_mm) } else { (d.left_mm, d.right_mm) };
        assert!((out - 0.005).abs() < 1e-9 && other == 0.0, "{phi}: {d:?}");
    }
}

#[test]
fn speeds_of_merged_blocks_and_at_reversals_are_those_of_the_set_point() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[1.0, 0.0]);
    p.merged(&[vec![1.5, 0.004], vec![1.52, -0.004]], &[2.5, 0.0]);
    let m = p.run(|_| 1.0).measure(&p);
    assert!(m.summary.override_.velocity_ratio_error_pct.unwrap() < 1e-6, "{:?}", m.summary.override_);
    assert!(m.summary.feed.max_over_pct.unwrap() < 1e-6, "{:?}", m.summary.feed);
    assert!(m.summary.feed.programmed_reached_pct.unwrap() > 98.0, "{:?}", m.summary.feed);
    for k in 0..20 {
        let mut p = Program::new(&[0.0, 0.0]);
        p.feed = 100.0;
        p.line(&[3.0 + 0.01 * f64::from(k), 0.0]).line(&[0.0, 0.0]);
        let m = p.run(|_| 1.0).measure(&p);
        assert!(m.summary.feed.max_over_pct.unwrap() < 1e-6, "{k}: {:?}", m.summary.feed);
    }
}
