//! Random programs: no false finding on clean runs, and agreement with a slow exact reference on runs that are not.

mod common;

use common::{Piece, Program, Random, random_program};

#[test]
fn a_thousand_clean_random_programs_have_no_finding() {
    for seed in 0..1000 {
        let axes = 2 + seed as usize % 3;
        let p = random_program(seed, axes, 12);
        let factor = [0.5, 1.0, 1.3, 2.0][seed as usize % 4];
        let m = p.run(|_| factor).measure(&p);
        let summary = &m.summary;
        assert!(summary.setpoint.max_mm < 1e-9, "seed {seed}: set point {:?}", summary.setpoint);
        assert!(summary.actual.max_mm < 1e-9, "seed {seed}: actual {:?}", summary.actual);
        assert!(summary.completed, "seed {seed}: {} mm missing", summary.missing_mm);
        assert!(summary.feed.max_over_pct.is_none_or(|over| over < 1.0), "seed {seed}: {:?}", summary.feed);
        let length: f64 = p.pieces.iter().map(Piece::length).sum();
        assert!((summary.path_length_mm - length).abs() < 1e-9 * (1.0 + length), "seed {seed}");
    }
}

/// A chain without sharp corners or tight arcs, so that "nearest nearby" and "forward only" are the same point.
fn gentle_program(seed: u64, axes: usize) -> Program {
    let mut r = Random::new(seed);
    let mut p = Program::new(&vec![0.0; axes]);
    p.feed = 8.0;
    let mut heading = r.range(0.0, std::f64::consts::TAU);
    for _ in 0..10 {
        let at = p.position().to_vec();
        let length = r.range(0.5, 4.0);
        let mut to: Vec<f64> = at.iter().map(|x| x + r.range(-0.2, 0.2)).collect();
        if r.unit() < 0.5 {
            heading += r.range(-1.0, 1.0);
            (to[0], to[1]) = (at[0] + length * heading.cos(), at[1] + length * heading.sin());
            p.line(&to);
        } else {
            heading += r.range(-0.8, 0.8);
            let radius = r.range(0.7, 5.0) * if r.unit() < 0.5 { 1.0 } else { -1.0 };
            let phi = r.range(20.0, 320.0);
            let center = [at[0] - radius * heading.sin(), at[1] + radius * heading.cos()];
            p.helix(0, 1, center, phi * radius.signum(), &to);
            heading += (phi * radius.signum()).to_radians();
        }
    }
    p
}

/// Distance to the path within `window` mm about path length `s`: dense sampling, then golden section.
fn reference(pieces: &[(f64, Piece)], s: f64, window: f64, x: &[f64]) -> f64 {
    let total = pieces.last().map(|(s0, p)| s0 + p.length()).unwrap();
    let distance = |s: f64| -> f64 {
        let i = pieces.partition_point(|(s0, _)| *s0 <= s).max(1) - 1;
        let (s0, piece) = &pieces[i];
        let p = piece.at(((s - s0) / piece.length()).clamp(0.0, 1.0));
        p.iter().zip(x).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let (low, high) = ((s - window).max(0.0), (s + window).min(total));
    // junctions are kinks of the distance: they delimit the grid
    let mut knots: Vec<f64> = pieces.iter().map(|(s0, _)| *s0).filter(|&k| k > low && k < high).collect();
    knots.extend([low, high]);
    knots.sort_by(f64::total_cmp);
    let mut best = f64::INFINITY;
    for pair in knots.windows(2) {
        let n = ((pair[1] - pair[0]) / 2e-3).ceil().max(1.0) as usize;
        let at = |i: usize| pair[0] + (pair[1] - pair[0]) * i as f64 / n as f64;
        let nearest = (0..=n).min_by(|&i, &j| distance(at(i)).total_cmp(&distance(at(j)))).unwrap();
        let (mut a, mut b) = (at(nearest.saturating_sub(1)), at((nearest + 1).min(n)));
        for _ in 0..60 {
            let (c, d) = (b - 0.618_033_988_75 * (b - a), a + 0.618_033_988_75 * (b - a));
            if distance(c) < distance(d) { b = d } else { a = c }
        }
        best = best.min(distance(a)).min(distance(b)).min(distance(at(0))).min(distance(at(n)));
    }
    best
}

#[test]
fn deviation_agrees_with_the_slow_exact_reference() {
    let mut worst: f64 = 0.0;
    for seed in 0..40 {
        let axes = 2 + seed as usize % 3;
        let p = gentle_program(seed, axes);
        let mut run = p.run(|_| 1.0);
        let mut r = Random::new(seed + 7);
        let (amplitude, wave): (Vec<f64>, Vec<f64>) =
            (0..axes).map(|_| (r.range(0.0, 3e-3), r.range(5.0, 9.0))).unzip();
        for k in 0..run.len() {
            for a in 0..axes {
                let off = amplitude[a] * (k as f64 / 100.0 * wave[a]).sin();
                run.dp[k * axes + a] += off;
                run.load[k * axes + a] -= off;
            }
        }
        let m = run.measure(&p);
        let mut s0 = 0.0;
        let pieces: Vec<(f64, Piece)> = p
            .pieces
            .iter()
            .cloned()
            .map(|piece| {
                let at = s0;
                s0 += piece.length();
                (at, piece)
            })
            .collect();
        for k in (0..run.len() - 5).step_by(3) {
            let s = (k + 1) as f64 * 8.0 * common::TA;
            let set = reference(&pieces, s, 0.04, run.dp_at(k));
            let load = reference(&pieces, s, 0.04, &run.load[k * axes..(k + 1) * axes]);
            let off = (set - f64::from(m.setpoint_mm[k])).abs().max((load - f64::from(m.actual_mm[k])).abs());
            assert!(
                off < 1e-9,
                "seed {seed} sample {k}: {off:e}; {set} {load} {} {}",
                m.setpoint_mm[k],
                m.actual_mm[k]
            );
            worst = worst.max(off);
        }
    }
    println!("largest difference {worst:e} mm");
}

#[test]
fn the_reference_notices_a_wrong_radius() {
    let mut p = Program::new(&[0.0, 0.0]);
    p.helix(0, 1, [0.0, 5.0], 180.0, &[0.0, 0.0]);
    let pieces = vec![(0.0, p.pieces[0].clone())];
    assert!((reference(&pieces, 3.0, 0.5, &p.pieces[0].at(3.0 / p.pieces[0].length())) - 0.0).abs() < 1e-12);
    let off: Vec<f64> = p.pieces[0].at(0.3).iter().zip([0.0, 5.0]).map(|(x, c)| c + (x - c) * 1.001).collect();
    assert!((reference(&pieces, 0.3 * p.pieces[0].length(), 0.5, &off) - 0.005).abs() < 1e-10);
}
