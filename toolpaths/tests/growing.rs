//! A path that is appended to while it is followed measures what the whole path does.

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Measured, Program, Random, Run, TA, random_program};
use toolpaths::{Path, PathError, Tracker, TrackerOptions};

/// A tracker whose path comes in parts of so many commands, and how many it has asked for.
fn growing(program: &Program, every: usize) -> (Tracker, Arc<AtomicUsize>) {
    let (columns, asked) = (program.columns.clone(), Arc::new(AtomicUsize::new(0)));
    let (n, count) = (columns.kind.len(), asked.clone());
    let more = move |path: &mut Path| {
        let at = count.fetch_add(1, Ordering::Relaxed) * every;
        if at >= n {
            return Ok(false);
        }
        path.append(&columns.part(at..(at + every).min(n)).view()).map(|()| true)
    };
    let path = Path::begin(&program.columns.start).unwrap();
    let options = TrackerOptions { sample_time_s: TA, ..TrackerOptions::default() };
    (Tracker::growing(path, options, more), asked)
}

fn assert_same(program: &Program, run: &Run, every: usize, what: &str) {
    let (whole, grown) = (run.measure(program), run.measure_by(growing(program, every).0));
    assert_eq!(evidence(&grown), evidence(&whole), "{what}");
    // NaN where there is no direction in the plane: compared as text
    assert_eq!(format!("{:?}", grown.summary), format!("{:?}", whole.summary), "{what}");
    assert_eq!((&grown.actual_mm, &grown.setpoint_mm), (&whole.actual_mm, &whole.setpoint_mm), "{what}");
    assert_eq!((&grown.s_actual_mm, &grown.s_setpoint_mm), (&whole.s_actual_mm, &whole.s_setpoint_mm), "{what}");
    assert_eq!(format!("{:?}", grown.signed_mm), format!("{:?}", whole.signed_mm), "{what}");
}

/// What a diagnosis gets to know.
fn evidence(measured: &Measured) -> String {
    let e = measured.tracker.as_ref().unwrap().evidence();
    let trace = |t: &toolpaths::TraceEvidence| format!("{:?} {:?} {:?}", t.blocks(), t.axes(), t.exchanges());
    let rounds: Vec<_> = e.rounds().collect();
    format!("{}\n{}\n{:?}\n{rounds:?}", trace(&e.setpoint), trace(&e.actual), e.axes)
}

#[test]
fn runs_that_are_true_lag_leave_the_path_or_stop_early_measure_the_same() {
    for seed in 0..30 {
        let axes = 2 + seed as usize % 3;
        let p = random_program(seed, axes, 30);
        let mut r = Random::new(seed + 7);
        let mut run = p.run(|_| [0.5, 1.0, 2.0][seed as usize % 3]);
        let lag = 1 + r.pick(40);
        match seed % 5 {
            0 => {}
            1 => run.load = [run.load[..axes].repeat(lag), run.load.clone()].concat()[..run.load.len()].to_vec(),
            2 => run.load.iter_mut().for_each(|x| *x += r.range(-0.3, 0.3)),
            3 => run.shift(r.pick(30), |x| x[0] += 5.0),
            _ => {
                let n = r.pick(run.len());
                run.dp.truncate(n * axes);
                run.load.truncate(n * axes);
                run.factor.truncate(n);
                run.v_plan.truncate(n);
            }
        }
        for every in [1, 3, 29, 100] {
            assert_same(&p, &run, every, &format!("seed {seed}, parts of {every}"));
        }
    }
}

#[test]
fn circles_and_exchanged_axes_are_found_the_same() {
    let mut p = Program::new(&[0.0, 0.0]);
    for n in 0..90 {
        let (x, y) = (f64::from(n), 0.0);
        p.line(&[x, y]);
        // a full circle in one to four arcs
        (0..=n % 4)
            .for_each(|_| drop(p.helix(0, 1, [x + 3.0, y], 360.0 / f64::from(1 + n % 4), &[x, y]).columns.clone()));
    }
    let mut run = p.run(|_| 1.0);
    for k in 0..run.len() / 3 {
        run.load.swap(2 * k, 2 * k + 1);
    }
    let mut r = Random::new(3);
    run.load[run.dp.len() / 2..].iter_mut().for_each(|x| *x += r.range(-2e-3, 2e-3));
    let found = evidence(&run.measure(&p));
    let rounds = found.matches("Round {").count();
    assert!(found.contains("Swapped") && rounds > 40, "{rounds} circles, {}", found.contains("Swapped"));
    for every in [1, 2, 5, 64, 1000] {
        assert_same(&p, &run, every, "circles");
    }
}

#[test]
fn merged_blocks_rotary_axes_and_programs_without_motion_measure_the_same() {
    let mut p = Program::with_rotary(&[0.0, 0.0, 0.0, 0.0], &[None, None, None, Some(20.0)]);
    for n in 0..40 {
        let x = f64::from(n);
        p.merged(&[vec![x + 0.3, 0.001, 0.0, x], vec![x + 0.6, -0.001, 0.0, x]], &[x + 1.0, 0.0, 0.0, x]);
        p.set_radius(3, 20.0 + f64::from(n % 3));
    }
    for every in [1, 7, 50] {
        assert_same(&p, &p.run(|_| 1.0), every, "merged");
    }
    let empty = Program::new(&[1.0, 2.0]);
    let mut stands = Run { axes: 2, ..Run::default() };
    (0..20).for_each(|_| stands.push(&[1.0, 2.5], 0, 1.0, 0.0));
    assert_same(&empty, &stands, 5, "no motion");
    assert_same(&empty, &Run { axes: 2, ..Run::default() }, 5, "no sample");
}

#[test]
fn the_path_is_asked_for_as_it_is_needed_and_its_rest_only_at_the_end() {
    let mut p = Program::new(&[0.0, 0.0]);
    for n in 1..=2000 {
        p.line(&[f64::from(n), f64::from(n % 2)]);
    }
    let mut run = p.run(|_| 1.0);
    let half = run.len() / 2;
    (run.dp, run.load) = (run.dp[..half * 2].to_vec(), run.load[..half * 2].to_vec());
    (run.factor, run.v_plan) = (run.factor[..half].to_vec(), run.v_plan[..half].to_vec());
    let (mut tracker, asked) = growing(&p, 10);
    let chunk = toolpaths::Chunk {
        dp: &run.dp,
        load: &run.load,
        rp: &run.load,
        factor: &run.factor,
        v_plan: &run.v_plan,
        ..toolpaths::Chunk::default()
    };
    tracker.feed(&chunk, &mut toolpaths::PerSample::default());
    let so_far = asked.load(Ordering::Relaxed);
    assert!((100..=102).contains(&so_far), "{so_far} parts of 200");
    assert!(tracker.path().blocks().len() < 40, "{} blocks are kept", tracker.path().blocks().len());
    let summary = tracker.finish();
    assert!((summary.path_length_mm - 2000.0 * 2f64.sqrt()).abs() < 1e-6 && !summary.completed);
    assert!(tracker.path().blocks().len() < 40, "{} blocks are kept", tracker.path().blocks().len());
    assert_eq!(asked.load(Ordering::Relaxed), 201);
}

#[test]
fn a_fault_in_a_later_part_is_named_by_its_command() {
    let mut p = Program::new(&[0.0, 0.0]);
    for n in 1..=9 {
        p.line(&[f64::from(n), 0.0]);
    }
    p.columns.vl[7] = -1.0;
    let (mut tracker, _) = growing(&p, 2);
    tracker.finish();
    let what = "path velocity is not a positive number";
    assert_eq!(tracker.path_error(), Some(&PathError::Value { command: 8, line: 80, what }));
}
