//! Faults of known size are found at the right block with the right size (issue 7).

mod common;

use common::{Program, Random, TA};

fn close(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= 0.02 * expected
}

/// A rectangle with an arc, 3 axes; commands 0..=6, source lines 10, 20, ...
fn part() -> Program {
    let mut p = Program::new(&[0.0, 0.0, 0.0]);
    p.feed = 20.0;
    p.line(&[10.0, 0.0, 0.0]).line(&[20.0, 10.0, 0.0]).line(&[20.0, 20.0, 0.0]);
    p.helix(0, 1, [15.0, 20.0], 180.0, &[0.0, 0.0, 0.0]).line(&[10.0, 5.0, -2.0]).line(&[0.0, 5.0, -2.0]);
    p.helix(0, 1, [0.0, 0.0], 90.0, &[0.0, 0.0, -1.0]);
    p
}

#[test]
fn a_block_shifted_by_5_um() {
    for (command, shift) in [(0, [0.0, 0.005, 0.0]), (1, [-0.003535534, 0.003535534, 0.0]), (4, [0.005, 0.0, 0.0])] {
        let p = part();
        let mut run = p.run(|_| 1.0);
        run.shift(command, |x| x.iter_mut().zip(shift).for_each(|(x, d)| *x += d));
        let m = run.measure(&p);
        for d in [&m.summary.setpoint, &m.summary.actual] {
            assert!(close(d.max_mm, 0.005), "command {command}: {d:?}");
            assert_eq!(d.worst.line, command as u32 * 10 + 10);
        }
        let rows = m.tracker.as_ref().unwrap().blocks();
        let off: Vec<bool> = rows.iter().map(|b| b.setpoint.max_mm > 1e-4).collect();
        let expected: Vec<bool> = (0..rows.len()).map(|i| i == command).collect();
        assert!(off == expected || off.iter().zip(&expected).filter(|(a, b)| a != b).count() <= 1, "{off:?}");
        assert!(m.summary.completed);
    }
}

#[test]
fn an_arc_with_its_centre_off_by_20_um() {
    let p = part();
    let mut run = p.run(|_| 1.0);
    run.shift(3, |x| x[1] += 0.02);
    let m = run.measure(&p);
    assert!(close(m.summary.setpoint.max_mm, 0.02), "{:?}", m.summary.setpoint);
    assert_eq!(m.summary.setpoint.worst.line, 40);
    // counter-clockwise: outwards is to the right
    assert!(close(m.summary.setpoint.right_mm, 0.02), "{:?}", m.summary.setpoint);
}

#[test]
fn a_lag_of_one_sample_on_one_axis() {
    let mut p = Program::new(&[0.0, 0.0, 0.0]);
    p.feed = 50.0;
    p.line(&[0.0, 5.0, 0.0]).line(&[10.0, 15.0, 0.0]).line(&[20.0, 15.0, 0.0]).line(&[20.0, 15.0, 5.0]);
    let mut run = p.run(|_| 1.0);
    for k in (1..run.len()).rev() {
        run.load[k * 3] = run.load[(k - 1) * 3];
    }
    run.load[0] = 0.0;
    let m = run.measure(&p);
    // across a line at 45 degrees: v TA / 2
    assert!(close(m.summary.actual.max_mm, 50.0 * TA / 2.0), "{:?}", m.summary.actual);
    assert_eq!(m.summary.actual.worst.line, 20);
    // X behind on a line to the upper right: the position is to the left
    assert!(close(m.summary.actual.left_mm, 50.0 * TA / 2.0));
    assert!(m.summary.setpoint.max_mm < 1e-9);
}

#[test]
fn swapped_axes() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.line(&[3.0, 0.0]).line(&[3.0, 1.0]).line(&[0.0, 1.0]).line(&[0.0, 0.0]);
    let mut run = p.run(|_| 1.0);
    run.shift(0, |x| x.swap(0, 1));
    let m = run.measure(&p);
    assert!(close(m.summary.setpoint.max_mm, 3.0), "{:?}", m.summary.setpoint);
    assert_eq!(m.summary.setpoint.worst.line, 10);
    assert!(m.summary.completed, "the foot finds back to the path");
    let rows = m.tracker.as_ref().unwrap().blocks();
    assert!(rows[2..].iter().all(|b| b.setpoint.max_mm < 1e-6), "blocks after the fault are clean: {rows:?}");
}

#[test]
fn backlash_of_10_um_on_the_load_side() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.feed = 20.0;
    p.line(&[10.0, 0.0]).line(&[10.0, 5.0]).line(&[5.0, 5.0]).line(&[5.0, 10.0]);
    let mut run = p.run(|_| 1.0);
    // the load follows when the play of 10 um is used up
    let mut load = [0.0f64, 0.0];
    for k in 0..run.len() {
        for (a, load) in load.iter_mut().enumerate() {
            let motor = run.dp[2 * k + a];
            *load = load.clamp(motor - 0.01, motor);
            run.load[2 * k + a] = *load;
        }
    }
    let m = run.measure(&p);
    // with motor ahead of load by the whole play after the way out, X hangs back 10 um while Y moves
    assert!(close(m.summary.actual.max_mm, 0.01), "{:?}", m.summary.actual);
    assert_eq!(m.summary.actual.worst.line, 20);
    assert!(m.summary.setpoint.max_mm < 1e-9);
}

#[test]
fn a_wrong_effradius_on_the_cylinder_surface() {
    // a full circle of 5 mm on a cylinder of radius 20 mm, executed as if it were 20.2 mm
    let radius = 20.0;
    let mut p = Program::with_rotary(&[0.0, 0.0], &[Some(radius), None]);
    p.helix(0, 1, [5.0f64.to_degrees() / radius, 0.0], 360.0, &[0.0, 0.0]);
    let mut run = p.run(|_| 1.0);
    run.shift(0, |x| x[0] *= 20.0 / 20.2);
    let m = run.measure(&p);
    // the far side of the circle, 10 mm round the cylinder, is missed by 1 %
    assert!(close(m.summary.setpoint.max_mm, 10.0 * (1.0 - 20.0 / 20.2)), "{:?}", m.summary.setpoint);
    assert_eq!(m.summary.setpoint.worst.line, 10);
}

#[test]
fn shifts_of_random_blocks_are_found_with_their_size() {
    let mut r = Random::new(5);
    for seed in 0..200 {
        let axes = 3;
        let mut p = Program::new(&[0.0; 3]);
        p.feed = 15.0;
        let mut heading = 0.0f64;
        for _ in 0..8 {
            heading += r.range(-1.2, 1.2);
            let length = r.range(1.0, 5.0);
            let at = p.position().to_vec();
            p.line(&[at[0] + length * heading.cos(), at[1] + length * heading.sin(), at[2] + r.range(-0.5, 0.5)]);
        }
        let command = r.pick(8);
        let size = 10f64.powf(r.range(-4.0, -2.0));
        let from =
            if command == 0 { vec![0.0; 3] } else { p.columns.target[(command - 1) * axes..command * axes].to_vec() };
        let to = &p.columns.target[command * axes..(command + 1) * axes];
        let along = [to[0] - from[0], to[1] - from[1]];
        let norm = along[0].hypot(along[1]);
        let sign = if r.unit() < 0.5 { 1.0 } else { -1.0 };
        let normal = [-along[1] / norm * size * sign, along[0] / norm * size * sign];
        let mut run = p.run(|_| 1.0);
        run.shift(command, |x| {
            x[0] += normal[0];
            x[1] += normal[1];
        });
        let m = run.measure(&p);
        assert!(close(m.summary.setpoint.max_mm, size), "seed {seed}: {size} {:?}", m.summary.setpoint);
        assert_eq!(m.summary.setpoint.worst.line, command as u32 * 10 + 10, "seed {seed}");
        let side = if sign > 0.0 { m.summary.setpoint.left_mm } else { m.summary.setpoint.right_mm };
        assert!(close(side, size), "seed {seed}: {:?}", m.summary.setpoint);
    }
}
