//! Circles in space, and runs of which only parts are on a path.

mod common;

use std::f64::consts::PI;
use std::sync::Arc;

use common::{Columns, Random, TA};
use toolpaths::{Chunk, Path, PathError, PerSample, Stretch, Stretches, Summary, Tracker, TrackerOptions};

/// A circle in space by the rotation formula of Rodrigues: nothing of it is in the crate.
struct Turn {
    start: [f64; 3],
    center: [f64; 3],
    normal: [f64; 3],
}

impl Turn {
    fn at(&self, angle: f64) -> [f64; 3] {
        let n = self.normal;
        let size = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        let n = n.map(|x| x / size);
        let v: [f64; 3] = std::array::from_fn(|i| self.start[i] - self.center[i]);
        let along = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
        let cross = [n[1] * v[2] - n[2] * v[1], n[2] * v[0] - n[0] * v[2], n[0] * v[1] - n[1] * v[0]];
        let (sin, cos) = angle.sin_cos();
        std::array::from_fn(|i| self.center[i] + v[i] * cos + cross[i] * sin + n[i] * along * (1.0 - cos))
    }
    fn radius(&self) -> f64 {
        let (a, b) = (self.at(0.0), self.at(PI));
        0.5 * (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    }
}

/// Moves, one after the other, each from where it begins.
#[derive(Default)]
struct Moves(Columns);

impl Moves {
    fn new(axes: usize) -> Moves {
        let columns = Columns { axes, start: vec![0.0; axes], effradius: vec![f64::NAN; axes], ..Columns::default() };
        Moves(columns)
    }
    fn add(&mut self, kind: u8, begin: &[f64], target: &[f64], turn: Option<(&Turn, f64)>) -> &mut Self {
        let c = &mut self.0;
        let (center, normal, phi) = turn.map_or(([0.0; 3], [0.0; 3], 0.0), |(t, phi)| (t.center, t.normal, phi));
        c.kind.push(kind);
        c.line.push(c.kind.len() as u32);
        c.rapid.push(false);
        c.begin.extend(begin);
        c.target.extend(target);
        c.c1.push(0);
        c.c2.push(1);
        c.c3.push(2);
        c.phi.push(phi);
        c.vl.push(10.0);
        c.center.extend([center[0], center[1]]);
        c.center3.extend(center);
        c.normal.extend(normal);
        c.via_first.push(0);
        c.via_count.push(0);
        c.effradius_of.push((c.effradius.len() / c.axes - 1) as u16);
        self
    }
    fn ring(&mut self, turn: &Turn, phi: f64) -> &mut Self {
        self.add(2, &turn.start, &turn.at(phi.to_radians()), Some((turn, phi)))
    }
    fn path(&self) -> Result<Path, PathError> {
        Path::new(self.0.view())
    }
}

fn a_turn(random: &mut Random) -> Turn {
    let mut point = |size: f64| std::array::from_fn(|_| size * (2.0 * random.unit() - 1.0));
    Turn { start: point(20.0), center: point(20.0), normal: point(3.0) }
}

/// Samples along a turn, moved by `change(angle)`.
fn samples(turn: &Turn, phi: f64, change: impl Fn(f64, [f64; 3]) -> [f64; 3]) -> Vec<f64> {
    let n = (turn.radius() * phi.abs().to_radians() / (10.0 * TA)).ceil() as usize;
    (0..=n)
        .flat_map(|k| {
            let angle = phi.to_radians() * k as f64 / n as f64;
            change(angle, turn.at(angle))
        })
        .collect()
}

fn measure(path: Path, dp: &[f64], stretches: Option<Vec<Stretch>>) -> (Vec<f32>, Summary) {
    let n = dp.len() / path.axes();
    let (ones, zeros) = (vec![1.0; n], vec![0.0; n]);
    let chunk = Chunk { dp, load: dp, rp: dp, factor: &ones, v_plan: &zeros, ..Chunk::default() };
    let mut tracker = Tracker::new(Arc::new(path), TrackerOptions { sample_time_s: TA, ..TrackerOptions::default() });
    let mut actual = vec![0.0; n];
    let mut out = PerSample { actual_mm: &mut actual, ..PerSample::default() };
    match stretches {
        Some(list) => Stretches::new(list).feed(&mut tracker, &chunk, &mut out),
        None => tracker.feed(&chunk, &mut out),
    }
    (actual, tracker.finish())
}

#[test]
fn a_circle_in_space_is_where_the_rotation_formula_has_it() {
    let mut random = Random::new(7);
    for round in 0..60 {
        let turn = a_turn(&mut random);
        let phi = (random.unit() - 0.4) * 900.0;
        if turn.radius() < 1.0 || phi.abs() < 5.0 {
            continue;
        }
        let mut moves = Moves::new(3);
        moves.ring(&turn, phi);
        let path = moves.path().expect("a circle");
        let length = turn.radius() * phi.abs().to_radians();
        assert!((path.length_mm() - length).abs() < 1e-9 * length, "round {round}");
        let exact = measure(path.clone(), &samples(&turn, phi, |_, p| p), None).1;
        assert!(exact.setpoint.max_mm < 1e-9 && exact.completed, "round {round}: {exact:?}");
        // the extents are those of many points
        let extents = path.extents();
        let points = samples(&turn, phi, |_, p| p);
        for (a, extent) in extents.iter().enumerate() {
            let of_axis = || points.iter().skip(a).step_by(3).copied();
            let (low, high) = (of_axis().fold(f64::MAX, f64::min), of_axis().fold(f64::MIN, f64::max));
            assert!(extent.0 <= low + 1e-9 && extent.0 >= low.min(0.0) - 1e-3, "round {round}");
            assert!(extent.1 >= high - 1e-9 && extent.1 <= high.max(0.0) + 1e-3, "round {round}");
        }
    }
}

#[test]
fn what_is_beside_a_circle_in_space_is_measured_as_far_as_it_is() {
    let turn = Turn { start: [10.0, 0.0, 2.0], center: [0.0, 0.0, 2.0], normal: [0.0, 0.5, 1.0] };
    let axis = {
        let size = 1.25_f64.sqrt();
        [0.0, 0.5 / size, 1.0 / size]
    };
    let foot = [0.0, 0.0, 2.0];
    let path = || {
        let mut moves = Moves::new(3);
        moves.ring(&turn, 200.0);
        moves.path().expect("a circle")
    };
    let along = samples(&turn, 200.0, |_, p| std::array::from_fn(|i| p[i] + 0.25 * axis[i]));
    assert!((measure(path(), &along, None).1.setpoint.max_mm - 0.25).abs() < 1e-9);
    let wider = samples(&turn, 200.0, |_, p| std::array::from_fn(|i| foot[i] + (p[i] - foot[i]) * 1.01));
    let summary = measure(path(), &wider, None).1.setpoint;
    assert!((summary.max_mm - 0.01 * turn.radius()).abs() < 1e-9);
    assert!((summary.right_mm.abs() - 0.01 * turn.radius()).abs() < 1e-9 || summary.left_mm < 1e-9, "{summary:?}");
}

#[test]
fn a_circle_that_is_none_is_refused_and_so_is_an_end_that_is_not_on_it() {
    let turn = Turn { start: [10.0, 0.0, 0.0], center: [0.0; 3], normal: [0.0; 3] };
    let mut none = Moves::new(3);
    none.add(2, &turn.start, &[0.0; 3], Some((&turn, 90.0)));
    assert!(matches!(none.path(), Err(PathError::Value { command: 1, .. })));
    let turn = Turn { normal: [0.0, 0.0, 1.0], ..turn };
    let mut astray = Moves::new(3);
    astray.add(2, &turn.start, &[0.0, 10.001, 0.0], Some((&turn, 90.0)));
    let Err(PathError::ArcEnd { off_mm, .. }) = astray.path() else { panic!("refused") };
    assert!((off_mm - 0.001).abs() < 1e-9);
    let mut sound = Moves::new(3);
    sound.add(2, &turn.start, &[0.0, 10.0, 0.0], Some((&turn, 90.0)));
    assert!(sound.path().is_ok());
}

fn stretch(begin: u64, end: u64, command: usize) -> Stretch {
    Stretch { begin, end, command, settles: true }
}

/// Two lines along X with a direct move between them that is nowhere near the path.
fn two_lines() -> (Moves, Vec<f64>, Vec<Stretch>) {
    let step = 10.0 * TA;
    let mut moves = Moves::new(3);
    moves.add(0, &[0.0; 3], &[1000.0 * step, 0.0, 0.0], None);
    moves.add(0, &[0.0, 500.0, 7.0], &[1000.0 * step, 500.0, 7.0], None);
    let first = (0..1000).flat_map(|k| [(k + 1) as f64 * step, 0.0, 0.0]);
    let rest = (0..50).flat_map(|_| [1000.0 * step, 0.0, 0.0]);
    let between = (0..100).flat_map(|k| [1000.0 * step * (1.0 - 0.01 * f64::from(k + 1)), 5.0 * f64::from(k + 1), 7.0]);
    let second = (0..1000).flat_map(|k| [(k + 1) as f64 * step, 500.0, 7.0]);
    let dp = first.chain(rest).chain(between).chain(second).collect();
    (moves, dp, vec![stretch(0, 999, 0), stretch(1150, 2149, 1)])
}

#[test]
fn what_is_between_two_stretches_is_not_measured_and_all_else_is() {
    let (moves, dp, list) = two_lines();
    let (actual, summary) = measure(moves.path().unwrap(), &dp, Some(list.clone()));
    assert!(summary.setpoint.max_mm < 1e-9 && summary.completed, "{summary:?}");
    assert_eq!(summary.samples, 2050, "the rest at the end of the first is measured, the way between is not");
    assert!(actual[1050..1150].iter().all(|d| *d == 0.0));
    // as one run it would be far off
    assert!(measure(moves.path().unwrap(), &dp, None).1.setpoint.max_mm > 1.0);
    for (sample, expected) in [(500, 0.3), (1020, 0.3), (1100, 0.0), (1700, 0.3)] {
        let mut bent = dp.clone();
        bent[3 * sample + 1] += 0.3;
        let (actual, summary) = measure(moves.path().unwrap(), &bent, Some(list.clone()));
        // a set point that moves at rest ends the stretch there
        let expected = if sample == 1020 { 0.0 } else { expected };
        assert!((summary.setpoint.max_mm - expected).abs() < 1e-9, "sample {sample}: {}", summary.setpoint.max_mm);
        assert!((f64::from(actual[sample]) - expected).abs() < 1e-6);
    }
}

#[test]
fn axes_that_take_no_part_may_be_anywhere() {
    let (mut moves, mut dp, list) = two_lines();
    moves.0.effradius = vec![f64::NAN, f64::NAN, 0.0];
    for k in 0..dp.len() / 3 {
        dp[3 * k + 2] = 0.001 * k as f64;
    }
    let (_, summary) = measure(moves.path().unwrap(), &dp, Some(list));
    assert!(summary.setpoint.max_mm < 1e-9 && summary.completed);
}
