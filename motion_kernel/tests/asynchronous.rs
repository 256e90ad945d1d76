//! Several interpolations at once, and the monitoring of spoolers that fall apart (2.2.8.3, 2.3.5).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::autocode::MoveKind::*;
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::functions::Entered;
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use motion_kernel::trace::Trace;

fn saf(m: &Mcu) -> Vec<usize> {
    (0..m.status().axes.len()).filter(|a| m.axst(*a).has(Axst::saf)).collect()
}
fn circle(m: &mut Mcu, axes: [usize; 2], radius: f64, v: f64) {
    let list = AxisList::new(&axes);
    assert_eq!(spool(m, Smcr, &list, &[0.0; 2], [radius, 0.0], 360.0, [v, 500.0, 0.0]), Entered::Yes);
}
fn pass(m: &mut Mcu, samples: u64) -> Trace {
    let mut trace = Trace::default();
    m.pass(samples, &mut trace);
    trace
}
/// Largest distance of two axes from a circle around (radius, 0).
fn off_circle(trace: &Trace, [x, y]: [usize; 2], radius: f64) -> f64 {
    let points = dp(trace, x).into_iter().zip(dp(trace, y));
    points.map(|(x, y)| ((x - radius).hypot(y) - radius).abs()).fold(0.0, f64::max)
}

// shows: interp.parallel.synchronous-spool, interp.concurrent, spool.interpolation-synchronous
#[test]
fn interpolations_started_together_run_in_step() {
    let mut m = mcu("XYZUVW", EXACT);
    circle(&mut m, [0, 1], 10.0, 20.0);
    circle(&mut m, [3, 2], 10.0, 20.0);
    let list = AxisList::new(&[4, 5]);
    spool(&mut m, Smla, &list, &[30.0, 40.0], [0.0; 2], 0.0, [20.0, 500.0, 0.0]);
    m.ssms(m.all_axes());
    let trace = pass(&mut m, 2800);
    assert!(off_circle(&trace, [0, 1], 10.0) < 1e-9 && off_circle(&trace, [3, 2], 10.0) < 1e-9);
    assert_eq!((dp(&trace, 0), dp(&trace, 1)), (dp(&trace, 3), dp(&trace, 2)), "in step, sample for sample");
    let on_line = dp(&trace, 4).into_iter().zip(dp(&trace, 5)).all(|(v, w)| (v * 4.0 - w * 3.0).abs() < 1e-9);
    assert!(on_line && saf(&m).is_empty() && m.stands());
}

// shows: interp.parallel.independent
#[test]
fn interpolations_of_other_axes_start_stop_and_are_overridden_on_their_own() {
    let alone = {
        let mut m = mcu("XYZU", EXACT);
        circle(&mut m, [0, 1], 10.0, 20.0);
        m.ssms(set(&[0, 1]));
        pass(&mut m, 2800)
    };
    let mut m = mcu("XYZU", EXACT);
    circle(&mut m, [0, 1], 10.0, 20.0);
    circle(&mut m, [2, 3], 4.0, 7.0);
    m.ssms(set(&[0, 1]));
    let mut parts = vec![pass(&mut m, 300)];
    m.ssms(set(&[2, 3]));
    parts.push(pass(&mut m, 400));
    m.wrtrovr(0.25);
    m.utrovr(set(&[2, 3]));
    parts.push(pass(&mut m, 400));
    assert!(m.rddv(2) != 0.0);
    m.ms(set(&[2, 3]));
    parts.push(pass(&mut m, 400));
    m.ol(set(&[2, 3]));
    parts.push(pass(&mut m, 1300));
    let x: Vec<f64> = parts.iter().flat_map(|t| dp(t, 0)).collect();
    let y: Vec<f64> = parts.iter().flat_map(|t| dp(t, 1)).collect();
    assert!(x == dp(&alone, 0) && y == dp(&alone, 1), "the first circle notices nothing");
    assert!(parts.iter().all(|t| off_circle(t, [2, 3], 4.0) < 1e-9));
    assert!(saf(&m).is_empty());
}

#[test]
fn saf_names_the_axes_of_the_group_and_no_other() {
    let mut m = mcu("XYZUV", EXACT);
    circle(&mut m, [0, 1], 10.0, 20.0);
    circle(&mut m, [2, 3], 10.0, 20.0);
    m.ja(&AxisList::new(&[4]), &[100.0]);
    m.ssms(set(&[0, 1, 2, 3]));
    m.run(200);
    assert!(saf(&m).is_empty());
    m.wrtrovr(0.7);
    m.utrovr(set(&[0, 1, 3]));
    m.run(1);
    assert_eq!(saf(&m), [2, 3], "X and Y were overridden together");
    // it stays until something clears it, axis by axis
    m.run(5000);
    assert_eq!(saf(&m), [2, 3]);
    m.jr(&AxisList::new(&[2]), &[1.0]);
    assert_eq!(saf(&m), [3]);
    m.cl(set(&[3]));
    assert!(saf(&m).is_empty());
}

/// Ways in which spoolers fall apart. After each the axes 0 and 1 are asynchronous.
fn break_apart(m: &mut Mcu, way: usize) {
    match way {
        0 => _ = m.wrjovr(1, 0.9),
        1 => m.utrovr(AxisSet::single(0)),
        2 => m.sstps(set(&[1])), // stops behind its current command
        3 => m.sdels(set(&[0])),
        4 => m.js(set(&[1])),
        5 => m.ms(set(&[0])),
        6 => m.ol(set(&[1])),
        _ => _ = m.jr(&AxisList::new(&[0]), &[1.0]),
    }
}

// shows: spool.saf.detect
#[test]
fn every_way_of_falling_apart_is_noticed() {
    for way in 0..8 {
        let mut m = mcu("XY", EXACT);
        m.wrtrovr(0.9);
        for n in 1..=40 {
            line(&mut m, &[f64::from(n), f64::from(n)], 20.0, 500.0, if n < 40 { 20.0 } else { 0.0 });
        }
        m.ssms(set(&[0, 1]));
        m.run(300);
        assert!(saf(&m).is_empty());
        break_apart(&mut m, way);
        m.run(100);
        assert!(!saf(&m).is_empty(), "way {way}");
    }
}

#[test]
fn jsatsaf_stops_every_closed_axis_with_its_own_sdec_and_discards() {
    for way in 0..8 {
        let mut m = mcu("XYZ", EXACT | ModeReg::JSatSAF);
        m.wrtrovr(0.9);
        m.parameters_mut(2).sdec = 100.0;
        for n in 1..=40 {
            line(&mut m, &[f64::from(n), f64::from(n)], 20.0, 500.0, if n < 40 { 20.0 } else { 0.0 });
        }
        let z = AxisList::new(&[2]);
        spool(&mut m, Smla, &z, &[500.0], [0.0; 2], 0.0, [40.0, 1000.0, 40.0]);
        spool(&mut m, Smla, &z, &[600.0], [0.0; 2], 0.0, [40.0, 1000.0, 0.0]);
        m.ssms(m.all_axes());
        m.run(300);
        break_apart(&mut m, way);
        let mut z_before = m.rddp(2);
        while !m.errorreg().has(ErrorReg::JSatSAFdone) {
            z_before = m.rddp(2);
            m.run(1);
        }
        m.run(400);
        assert!(m.stands(), "way {way}");
        let status = m.status();
        assert!(status.axes.iter().all(|a| a.mcis == 0 && a.lsm == a.memory), "way {way}: spoolers are empty");
        close(m.rddp(2) - z_before, 40.0 * 40.0 / 200.0, 40.0 * TA + 1e-9);
        // the axes can be driven again
        m.cl(m.all_axes());
        m.set_modereg(EXACT);
        assert!(saf(&m).is_empty());
        assert_eq!(line(&mut m, &[0.0; 3], 50.0, 500.0, 0.0), Entered::Yes);
        m.wrtrovr(1.0);
        m.utrovr(m.all_axes());
        m.wrjovr(1, 1.0);
        m.ssms(m.all_axes());
        m.run(20_000);
        assert_eq!([m.rddp(0), m.rddp(1), m.rddp(2)], [0.0; 3], "way {way}");
    }
}

/// Memory of each spooler follows its own entries, whatever happens to them.
#[test]
fn spool_memory_is_counted_per_axis() {
    let mut m = mcu("XYZ", LOOKAHEAD);
    let memory = m.status().axes[0].memory;
    let used = |m: &Mcu| [0, 1, 2].map(|a| memory - m.status().axes[a].lsm);
    line(&mut m, &[5.0, 5.0], 20.0, 500.0, 20.0); // 96 bytes in X and Y
    assert_eq!(used(&m), [96, 96, 0]);
    arc(&mut m, [10.0, 5.0], 90.0, &[3.0], 20.0, 500.0, 0.0); // 128 in the plane, 96 beside it
    assert_eq!(used(&m), [224, 224, 96]);
    m.ssf(0, 5, 1.0, 0);
    m.ssf(2, 1003, 1e6, 0);
    assert_eq!(used(&m), [256, 224, 128]);
    m.spd(1, &[5.0; 10]);
    assert_eq!(used(&m), [256, 336, 128]);
    assert_eq!([0, 1, 2].map(|a| m.status().axes[a].mcis), [2, 3, 1]);
    m.ssms(set(&[0, 1]));
    m.run(1);
    assert_eq!(used(&m), [160, 240, 128], "free as execution begins");
    // a hold cuts the line in two and a resume goes on: the rest takes memory until it is executed
    m.hold();
    m.run(300);
    assert_eq!(used(&m), [256, 336, 128]);
    m.resume();
    m.run(1);
    assert_eq!(used(&m), [160, 240, 128]);
    m.ms(set(&[0, 1]));
    assert_eq!(used(&m), [0, 0, 128]);
    m.sdels(set(&[2]));
    assert_eq!(used(&m), [0, 0, 0]);
    m.run(500);
    assert_eq!(m.moves_in_use(), 0, "and nothing is left of the moves");
}
