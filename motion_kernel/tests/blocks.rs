//! Single block in what is spooled already: hold at the end of a line, then line by line.

mod common;

use common::contour::{check_on_path, contour, distance, enter, place};
use common::*;
use motion_kernel::autocode::MoveKind::Smla;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::motion::MotionCommand;
use motion_kernel::registers::Axst;
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};
use proptest::prelude::*;

/// A line of X Y of that source line.
fn block(m: &mut Mcu, line: u32, x: f64, tvl: f64) {
    let axes = AxisList::new(&[0, 1]);
    let command = MotionCommand {
        kind: Smla,
        axes: &axes,
        targets: &[x, 0.0],
        center: [0.0; 2],
        phi: 0.0,
        vl: 20.0,
        ac: 100.0,
        tvl,
        rapid: false,
        line,
    };
    assert_eq!(m.spool(&command), Entered::Yes);
}
fn until_held(m: &mut Mcu) -> Trace {
    let mut trace = Trace::default();
    assert_eq!(m.advance(50_000, &mut trace).stop, Stop::Held);
    trace
}
fn x(m: &Mcu) -> f64 {
    m.status().axes[0].dp
}
/// Blocks of 5 mm, lines 1, 2, 3 ...; started, and `samples` later.
fn running(blocks: u32, samples: u64) -> Mcu {
    let mut m = mcu("XY", LOOKAHEAD);
    for n in 1..=blocks {
        block(&mut m, n, f64::from(n) * 5.0, if n < blocks { 20.0 } else { 0.0 });
    }
    m.ssms(set(&[0, 1]));
    m.run(samples);
    m
}

#[test]
fn the_hold_comes_at_the_end_of_the_line() {
    let mut m = running(10, 300); // in block 2, at full speed
    assert_eq!(m.status().entry, 2);
    m.hold_at_block_end();
    let trace = until_held(&mut m);
    assert_eq!((x(&m), trace.entry.iter().max()), (10.0, Some(&2)));
    assert!(speeds(&trace, 0, trace.dp[0]).windows(2).skip(1).all(|w| (w[1] - w[0]).abs() <= 100.0 * TA + 1e-6));
    m.run(500);
    assert_eq!(x(&m), 10.0);
    m.resume();
    record(&mut m);
    assert_eq!(x(&m), 50.0);
}

#[test]
fn where_the_line_is_too_short_to_brake_it_is_the_next() {
    let mut m = running(10, 0);
    while x(&m) < 9.0 {
        m.run(1);
    }
    m.hold_at_block_end();
    until_held(&mut m);
    assert_eq!(x(&m), 15.0, "2 mm are needed, 1 mm was left");
}

#[test]
fn a_line_of_several_moves_is_one_block() {
    let mut m = mcu("XY", LOOKAHEAD);
    for n in 1..=60u32 {
        block(&mut m, n.div_ceil(6), f64::from(n) * 0.5, if n < 60 { 20.0 } else { 0.0 });
    }
    m.ssms(set(&[0, 1]));
    m.run(200);
    m.hold_at_block_end();
    until_held(&mut m);
    assert_eq!(x(&m), 6.0, "lines end each 3 mm");
    for line in 3..=10 {
        assert!(m.step_block());
        until_held(&mut m);
        close(x(&m), f64::from(line) * 3.0, 1e-12);
    }
    assert!(!m.step_block(), "nothing is spooled any more");
}

#[test]
fn steps_take_functions_and_waits_as_lines_of_their_own() {
    let mut m = mcu("XY", LOOKAHEAD);
    block(&mut m, 1, 5.0, 20.0);
    block(&mut m, 2, 10.0, 0.0);
    m.ssf(0, 7, 1.0, 3);
    for axis in [0, 1] {
        m.ssf(axis, 1003, 20.0 * 100.0, 4);
    }
    block(&mut m, 5, 15.0, 0.0);
    m.ssms(set(&[0, 1]));
    m.run(20);
    m.hold_at_block_end();
    until_held(&mut m);
    let mut seen = vec![];
    while m.step_block() {
        let trace = until_held(&mut m);
        seen.push((x(&m), m.ci(7), trace.len() > 90));
    }
    assert_eq!(seen, [(10.0, 0, true), (10.0, 1, false), (10.0, 1, true), (15.0, 1, true)]);
    assert!(!m.axst(0).has(Axst::saf));
}

#[test]
fn a_hold_stops_at_once_even_then() {
    let mut m = running(10, 300);
    m.hold_at_block_end();
    let before = x(&m);
    m.hold();
    until_held(&mut m);
    close(x(&m) - before, 2.0, 1e-9);
    assert!(m.step_block());
    until_held(&mut m);
    assert_eq!(x(&m), 10.0, "the rest of the cut block");
    m.resume();
    record(&mut m);
    assert_eq!(x(&m), 50.0);
}

#[test]
fn resuming_before_the_end_of_the_line_goes_on() {
    let mut m = running(10, 300);
    m.hold_at_block_end();
    m.run(10);
    m.resume();
    record(&mut m);
    assert_eq!(x(&m), 50.0);
}

#[test]
fn without_lookahead_it_rests_too() {
    let mut m = mcu("XY", EXACT);
    for n in 1..=4u32 {
        block(&mut m, n, f64::from(n) * 5.0, 20.0);
    }
    m.ssms(set(&[0, 1]));
    m.run(300);
    m.hold_at_block_end();
    until_held(&mut m);
    assert_eq!(x(&m), 10.0);
    for n in 3..=4 {
        assert!(m.step_block());
        until_held(&mut m);
        assert_eq!(x(&m), f64::from(n) * 5.0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn stops_at_block_ends_stay_on_the_path(blocks in contour(20), holds in prop::collection::vec((1u64..150, 0usize..3), 1..6)) {
        let mut m = mcu("XYZ", LOOKAHEAD);
        let placed = place(&blocks);
        (0..placed.len()).for_each(|n| assert!(enter(&mut m, &placed, n)));
        m.ssms(set(&[0, 1, 2]));
        let mut trace = Trace::default();
        for (samples, steps) in holds {
            if m.advance(samples, &mut trace).stop == Stop::Finished {
                return Ok(());
            }
            check_on_path(&trace, &placed);
            m.hold_at_block_end();
            check_on_path(&until_held(&mut m), &placed);
            let at: Vec<f64> = m.status().axes.iter().map(|a| a.dp).collect();
            let ends = placed.iter().enumerate().filter(|(n, _)| n % 2 == 1 || n + 1 == placed.len());
            let near = ends.map(|(_, b)| distance(&[at[0], at[1], at[2]], &b.end)).fold(f64::INFINITY, f64::min);
            prop_assert!(near < 1e-9, "stands {near:e} mm off any line end");
            for _ in 0..steps {
                if m.step_block() {
                    check_on_path(&until_held(&mut m), &placed);
                }
            }
            m.resume();
        }
        check_on_path(&record(&mut m), &placed);
        for (axis, end) in m.status().axes.iter().zip(placed[placed.len() - 1].end) {
            close(axis.dp, end, 1e-9);
        }
    }
}
