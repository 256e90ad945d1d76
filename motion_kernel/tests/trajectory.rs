//! The structures of motion commands (4.3.2.4 to 4.3.2.6) and a command for each name.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::sap::tables::Command;
use motion_kernel::trace::Trace;
use motion_kernel::trajectory::{Cmp, Hmp, Lmp, PerAxis};

fn dtm(values: &[(usize, f64)]) -> PerAxis {
    let mut dtm = [f64::NAN; 18]; // what is not selected is not read
    values.iter().for_each(|&(a, x)| dtm[a] = x);
    dtm
}
fn ends(m: &Mcu) -> Vec<f64> {
    m.status().axes.iter().map(|a| a.dp).collect()
}
fn end_speed(trace: &Trace, axes: usize) -> f64 {
    let last = |a: usize| speeds(trace, a, 0.0)[trace.len() - 1].powi(2);
    (0..axes).map(last).sum::<f64>().sqrt()
}
#[track_caller]
fn all_close(is: &[f64], want: &[f64]) {
    assert_eq!(is.len(), want.len());
    is.iter().zip(want).for_each(|(is, want)| close(*is, *want, 1e-9));
}

// shows: struct.lmp.dtm, pcap.mla.dtm-index
#[test]
fn targets_stand_at_the_number_of_their_axis() {
    let mut m = mcu("XYZUV", EXACT);
    // in any order, and axis 4 always in dtm[4]
    let list = AxisList::new(&[4, 1]);
    let lmp = Lmp { ac: 500.0, vl: 50.0, tvl: 0.0, dtm: dtm(&[(1, 2.0), (4, 7.0)]) };
    assert_eq!(m.mla(&list, &lmp), Entered::Yes);
    record(&mut m);
    all_close(&ends(&m), &[0.0, 2.0, 0.0, 0.0, 7.0]);
    assert_eq!(m.mlr(&list, &lmp), Entered::Yes);
    record(&mut m);
    all_close(&ends(&m), &[0.0, 4.0, 0.0, 0.0, 14.0]);
    assert_eq!([m.smla(&list, &lmp), m.smlr(&list, &lmp)], [Entered::Yes; 2]);
    run(&mut m);
    all_close(&ends(&m), &[0.0, 4.0, 0.0, 0.0, 14.0]);
}

/// Highest path velocity, time of the first ramp and velocity at the end of a spooled command of X and Y.
fn measured(enter: impl Fn(&mut Mcu) -> Entered) -> [f64; 3] {
    let mut m = mcu("XYZ", EXACT);
    assert_eq!(enter(&mut m), Entered::Yes);
    m.ssms(set(&[0, 1, 2]));
    let mut trace = Trace::default();
    m.pass(4000, &mut trace);
    let top = trace.v_plan.iter().copied().fold(0.0, f64::max);
    [top, (trace.v_plan[19] - trace.v_plan[9]) / (10.0 * TA), end_speed(&trace, 3)]
}

// shows: struct.lmp.ac, struct.lmp.vl, struct.lmp.tvl
#[test]
fn path_values_of_a_line() {
    let lmp = Lmp { ac: 300.0, vl: 30.0, tvl: 5.0, dtm: dtm(&[(0, 30.0), (1, 40.0)]) };
    all_close(&measured(|m| m.smla(&xy(), &lmp)), &[30.0, 300.0, 5.0]);
}

// shows: struct.cmp.ac, struct.cmp.vl, struct.cmp.tvl
#[test]
fn path_values_of_a_circle() {
    let cmp = Cmp { ac: 300.0, vl: 30.0, tvl: 5.0, phi: 180.0, dtca1: 20.0, dtca2: 0.0 };
    all_close(&measured(|m| m.smca(&xy(), &cmp)), &[30.0, 300.0, 5.0]);
}

// shows: struct.hmp.ac, struct.hmp.vl, struct.hmp.tvl
#[test]
fn path_values_of_a_helix() {
    let hmp = Hmp { ac: 300.0, vl: 30.0, tvl: 5.0, phi: 180.0, dtca1: 20.0, dtca2: 0.0, dtm: dtm(&[(2, 30.0)]) };
    let list = AxisList::new(&[0, 1, 2]);
    all_close(&measured(|m| m.smha(&list, &hmp)), &[30.0, 300.0, 5.0]);
}

// shows: struct.cmp.phi, struct.cmp.dtca
#[test]
fn a_circle_by_angle_around_the_centre_of_first_and_second_axis() {
    // first axis Z, second X: centre 10 in Z
    let list = AxisList::new(&[2, 0]);
    let v = Cmp { ac: 500.0, vl: 50.0, tvl: 0.0, ..Cmp::default() };
    let mut m = mcu("XYZ", EXACT);
    assert_eq!(m.mca(&list, &Cmp { phi: 90.0, dtca1: 10.0, dtca2: 0.0, ..v }), Entered::Yes);
    record(&mut m);
    all_close(&ends(&m), &[-10.0, 0.0, 10.0]);
    assert_eq!(m.mcr(&list, &Cmp { phi: -450.0, dtca1: 0.0, dtca2: 10.0, ..v }), Entered::Yes);
    record(&mut m);
    all_close(&ends(&m), &[0.0, 0.0, 0.0]);
    assert_eq!(m.smca(&list, &Cmp { phi: 90.0, dtca1: 10.0, dtca2: 0.0, ..v }), Entered::Yes);
    assert_eq!(m.smcr(&list, &Cmp { phi: -90.0, dtca1: 0.0, dtca2: 10.0, ..v }), Entered::Yes);
    run(&mut m);
    all_close(&ends(&m), &[0.0, 0.0, 0.0]);
}

// shows: struct.hmp.phi, struct.hmp.dtca, struct.hmp.dtm
#[test]
fn a_helix_by_angle_takes_the_linear_axes_from_dtm() {
    let list = AxisList::new(&[2, 0, 4, 1]);
    let mut m = mcu("XYZUV", EXACT);
    let hmp =
        Hmp { ac: 500.0, vl: 50.0, tvl: 0.0, phi: -90.0, dtca1: 10.0, dtca2: 0.0, dtm: dtm(&[(4, 3.0), (1, -2.0)]) };
    // targets of the circle axes are not read
    let hmp = Hmp {
        dtm: {
            let mut d = hmp.dtm;
            (d[2], d[0]) = (0.0, 0.0);
            d
        },
        ..hmp
    };
    assert_eq!(m.mha(&list, &hmp), Entered::Yes);
    record(&mut m);
    all_close(&ends(&m), &[10.0, -2.0, 10.0, 0.0, 3.0]);
    assert_eq!(m.mhr(&list, &Hmp { phi: 90.0, dtca1: 0.0, dtca2: -10.0, ..hmp }), Entered::Yes);
    record(&mut m);
    all_close(&ends(&m), &[0.0, -4.0, 0.0, 0.0, 6.0]);
    assert_eq!(m.smha(&list, &hmp), Entered::Yes);
    assert_eq!(m.smhr(&list, &Hmp { phi: 90.0, dtca1: 0.0, dtca2: -10.0, ..hmp }), Entered::Yes);
    run(&mut m);
    all_close(&ends(&m), &[0.0, -4.0, 0.0, 0.0, 6.0]);
}

// shows: struct.hmp.phi-target-mode, struct.hmp.dtm-target-mode
#[test]
fn a_helix_in_target_form_takes_all_targets_from_dtm() {
    let list = AxisList::new(&[2, 0, 1]);
    for (phi, end, quarter) in [(1e-100, [10.0, 5.0, 10.0], 1.0), (-1e-100, [10.0, 5.0, 10.0], -1.0)] {
        let mut m = mcu("XYZ", EXACT);
        // from (Z, X) = (0, 0) around (10, 0) to (10, 10): three quarters counter-clockwise, one clockwise
        let hmp = Hmp {
            ac: 500.0,
            vl: 50.0,
            tvl: 0.0,
            phi,
            dtca1: 10.0,
            dtca2: 0.0,
            dtm: dtm(&[(0, 10.0), (1, 5.0), (2, 10.0)]),
        };
        assert_eq!(m.smha(&list, &hmp), Entered::Yes);
        let trace = run(&mut m);
        all_close(&ends(&m), &end);
        let lowest = dp(&trace, 0).into_iter().fold(f64::INFINITY, f64::min);
        assert_eq!(lowest < -9.9, quarter > 0.0, "direction by the sign of phi");
    }
}

// shows: kernel.mode.s-prefix
#[test]
fn spooled_commands_carry_an_s_for_both_ways_of_programming() {
    // PCAP: every kind has both names (the pairs of trajectory.rs); rw_SymPas: the same names
    for kind in MoveKind::ALL {
        let spooled = kind.name();
        let direct = spooled.strip_prefix('s').expect("s first");
        for name in [spooled, direct] {
            assert!(Command::by_name(name).is_some(), "{name}");
        }
    }
    for name in ["smca3d", "smcr3d", "mca3d", "mcr3d"] {
        assert!(Command::by_name(name).is_some(), "{name}");
    }
    let mut m = mcu("XY", EXACT);
    let lmp = Lmp { ac: 500.0, vl: 50.0, tvl: 0.0, dtm: dtm(&[(0, 1.0), (1, 1.0)]) };
    assert_eq!(m.smla(&xy(), &lmp), Entered::Yes);
    m.run(500);
    assert_eq!(m.rddp(0), 0.0, "spooled: waits for ssms");
    assert_eq!(m.mla(&xy(), &lmp), Entered::Yes);
    m.run(500);
    assert_eq!(m.rddp(0), 1.0, "direct: executed at once");
}
