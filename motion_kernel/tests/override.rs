//! Trajectory and jog override: the factor of the profile clock (2.2.6, 4.4.132, 4.4.174, 4.4.175, design D1).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::registers::ModeReg;
use motion_kernel::trace::Trace;

fn long_line(mode: ModeReg) -> Mcu {
    let mut m = mcu("XY", mode);
    line(&mut m, &[300.0, 0.0], 20.0, 100.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    m
}
fn set_override(m: &mut Mcu, factor: f64, seconds: f64) {
    m.wrtrovrst(seconds);
    assert!(m.wrtrovr(factor));
    let all = m.all_axes();
    m.utrovr(all);
}
/// Speed of X over the next sample.
fn speed(m: &mut Mcu) -> f64 {
    let before = m.status().axes[0].dp;
    m.run(1);
    (m.status().axes[0].dp - before) / TA
}
fn factors(m: &mut Mcu, samples: u64) -> Vec<f64> {
    let mut trace = Trace::default();
    m.advance(samples, &mut trace);
    trace.factor
}

// shows: kernel.override.default
#[test]
fn the_default_is_1() {
    let mut m = long_line(EXACT);
    assert_eq!(factors(&mut m, 3), [1.0; 3]);
    assert_eq!(m.rdjovr(0), 1.0);
}

// shows: kernel.override.scales-velocity-and-accel, pcap.wrtrovr.accel, pcap.wrtrovr.below-one, pcap.wrtrovr.above-one
#[test]
fn velocity_scales_with_f_and_acceleration_with_its_square() {
    for factor in [0.3, 0.5, 1.2] {
        let mut m = long_line(EXACT);
        set_override(&mut m, factor, 0.0);
        let (first, second) = (speed(&mut m), speed(&mut m));
        close((second - first) / TA, 100.0 * factor * factor, 1e-6);
        m.run(2000);
        close(speed(&mut m), 20.0 * factor, 1e-9);
    }
}

// shows: pcap.wrtrovr, pcap.wrtrovr.buffered, pcap.rdtrovr
#[test]
fn the_factor_is_buffered_until_utrovr() {
    let mut m = long_line(EXACT);
    m.run(500);
    m.wrtrovr(0.5);
    close(speed(&mut m), 20.0, 1e-9);
    assert_eq!(m.status().trovr, 0.5);
    m.utrovr(set(&[0, 1]));
    close(speed(&mut m), 10.0, 1e-9);
}

// shows: pcap.wrtrovr.positive, pcap.wrjovr.positive
#[test]
fn factors_not_above_0_are_refused() {
    let mut m = long_line(EXACT);
    for factor in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(!m.wrtrovr(factor) && !m.wrjovr(0, factor));
    }
    assert_eq!((m.status().trovr, m.rdjovr(0)), (1.0, 1.0));
}

// shows: pcap.wrtrovrst, pcap.wrtrovrst.linear, kernel.override.settling-time, pcap.utrovr.ramp
#[test]
fn the_factor_ramps_linearly_from_the_next_sample_on() {
    let mut m = long_line(EXACT);
    set_override(&mut m, 0.5, 0.5);
    let seen = factors(&mut m, 300);
    let samples = (0.5 * 0.5 / TA).ceil() as usize;
    for (k, factor) in seen.iter().enumerate() {
        close(*factor, (1.0 - (k + 1) as f64 * TA / 0.5).max(0.5), 1e-12);
    }
    assert!(seen[samples - 2] > 0.5 && seen[samples - 1] == 0.5);
    set_override(&mut m, 1.2, 0.2);
    assert_eq!(factors(&mut m, 300).iter().filter(|f| **f < 1.2).count(), (0.7 * 0.2 / TA).ceil() as usize - 1);
}

// shows: pcap.wrtrovrst.zero, pcap.wrtrovrst.too-small
#[test]
fn times_below_a_sample_count_as_0() {
    for seconds in [0.0, 0.9 * TA, -1.0] {
        let mut m = long_line(EXACT);
        set_override(&mut m, 0.25, seconds);
        assert_eq!(factors(&mut m, 2), [0.25; 2]);
    }
}

// shows: kernel.override.copied-to-jovr, pcap.utrovr.jovr, pcap.utrovr.no-jovr, pcap.wrjovr.utrovr
#[test]
fn utrovr_copies_to_jovr_unless_ovr_mode() {
    let mut m = long_line(EXACT);
    set_override(&mut m, 0.5, 0.5);
    m.run(100);
    let ramping = m.rdjovr(0);
    assert!(ramping > 0.5 && ramping < 1.0, "shows the effective factor while it ramps");
    m.run(300);
    assert_eq!(m.rdjovr(0), 0.5);
    let mut m = long_line(EXACT | ModeReg::OvrMode);
    set_override(&mut m, 0.5, 0.0);
    m.run(10);
    assert_eq!(m.rdjovr(0), 1.0);
}

// shows: pcap.wrtrovrst.jog-unaffected, pcap.wrjovr.abrupt
#[test]
fn the_jog_override_is_effective_at_once() {
    let mut m = long_line(EXACT);
    m.wrtrovrst(10.0);
    m.run(500);
    m.wrjovr(0, 0.5);
    close(speed(&mut m), 10.0, 1e-9);
    assert_eq!(m.rdjovr(0), 0.5);
}

// shows: pcap.rs.override, pcap.wrtrovr.reset, pcap.rs.spooler
#[test]
fn rs_sets_all_factors_to_1() {
    let mut m = long_line(EXACT);
    set_override(&mut m, 0.5, 0.0);
    line(&mut m, &[10.0, 0.0], 20.0, 100.0, 0.0);
    m.rs();
    assert!(m.status().axes.iter().all(|a| a.mcis == 0 && a.lsm == a.memory));
    m.run(1);
    assert_eq!((m.status().trovr, m.rdjovr(0), m.status().factor), (1.0, 1.0, 1.0));
}

/// The brake path stays: a line ends at its target at any factor (D1).
#[test]
fn the_path_is_the_same_at_any_factor() {
    let mut slow = long_line(EXACT);
    set_override(&mut slow, 0.5, 0.0);
    let slow = record(&mut slow);
    let fast = record(&mut long_line(EXACT));
    let every_second: Vec<f64> = dp(&slow, 0).into_iter().skip(1).step_by(2).collect();
    assert!(dp(&fast, 0).len().abs_diff(every_second.len()) <= 1);
    for (slow, fast) in every_second.iter().zip(dp(&fast, 0)) {
        close(*slow, fast, 1e-9);
    }
}
