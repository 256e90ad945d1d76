//! Paths that could fool a foot point, and faults of known size.

mod common;

use common::{Program, TA};

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
