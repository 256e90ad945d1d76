//! Circles of three axes in space (4.4.30, 4.4.31, HMP3D of 4.3.2.7), against geometry of the test itself.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use motion_kernel::trace::Trace;
use motion_kernel::trajectory::{Hmp3d, Lmp, PerAxis};
use proptest::prelude::*;

type V3 = [f64; 3];

fn dot(a: V3, b: V3) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
fn sub(a: V3, b: V3) -> V3 {
    std::array::from_fn(|i| a[i] - b[i])
}
fn cross(a: V3, b: V3) -> V3 {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}
fn hmp3d(center: V3, normal: V3, phi: f64, [vl, ac, tvl]: V3) -> Hmp3d {
    let ([dtca1, dtca2, dtca3], [pn1, pn2, pn3]) = (center, normal);
    Hmp3d { ac, vl, tvl, phi, dtca1, dtca2, dtca3, pn1, pn2, pn3, dtm: [0.0; 18] }
}
fn xyz() -> AxisList {
    AxisList::new(&[0, 1, 2])
}
fn points(trace: &Trace) -> Vec<V3> {
    (0..trace.len()).map(|k| std::array::from_fn(|i| trace.dp[k * trace.axes + i])).collect()
}
/// At rest at `start`.
fn at(start: V3, modereg: ModeReg) -> Mcu {
    let mut m = mcu("XYZ", modereg);
    for (a, x) in start.into_iter().enumerate() {
        assert!(m.wrdp(a, x));
    }
    m
}
/// Angle in degrees from `from` to `to` around the normal, as signed turns in -180..180.
fn turn(from: V3, to: V3, n: V3) -> f64 {
    dot(cross(from, to), n).atan2(dot(from, to)).to_degrees()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    // shows: pcap.smca3d, pcap.mca3d.plane, pcap.mca3d.center-projected, pcap.mca3d.phi-unlimited, struct.hmp3d.dtca
    // shows: struct.hmp3d.pn, struct.hmp3d.phi
    #[test]
    fn set_points_stay_on_the_circle_and_turn_by_phi(
        start in prop::array::uniform3(-20.0..20.0f64), center in prop::array::uniform3(-20.0..20.0f64),
        normal in prop::array::uniform3(-3.0..3.0f64), phi in -900.0..900.0f64,
    ) {
        let size = dot(normal, normal).sqrt();
        prop_assume!(size > 0.1 && phi.abs() > 5.0);
        let n = normal.map(|x| x / size);
        // the centre on the plane through the start
        let lift = dot(sub(start, center), n);
        let foot: V3 = std::array::from_fn(|i| center[i] + lift * n[i]);
        let radius = dot(sub(start, foot), sub(start, foot)).sqrt();
        prop_assume!(radius > 0.5);
        let mut m = at(start, EXACT);
        prop_assert_eq!(m.smca3d(&xyz(), &hmp3d(center, normal, phi, [40.0, 400.0, 0.0])), Entered::Yes);
        let (mut turned, mut before) = (0.0, sub(start, foot));
        let mut length = 0.0;
        let mut last = start;
        for p in points(&run(&mut m)) {
            let r = sub(p, foot);
            prop_assert!((dot(r, r).sqrt() - radius).abs() < 1e-9 && dot(sub(p, start), n).abs() < 1e-9);
            turned += turn(before, r, n);
            length += dot(sub(p, last), sub(p, last)).sqrt();
            (before, last) = (r, p);
        }
        prop_assert!((turned - phi).abs() < 1e-7, "turned {turned} of {phi}");
        prop_assert!((length - radius * phi.abs().to_radians()).abs() < 1e-3 * length, "chords are as long as the arc");
    }
}

// shows: pcap.mca3d, pcap.mca3d.phi, pcap.mca3d.center
#[test]
fn in_the_xy_plane_it_is_the_circle_of_mca() {
    let mut m = at([10.0, 0.0, 3.0], EXACT);
    assert_eq!(m.mca3d(&xyz(), &hmp3d([0.0, 0.0, 3.0], [0.0, 0.0, 1.0], 90.0, [20.0, 200.0, 0.0])), Entered::Yes);
    let end = *points(&record(&mut m)).last().expect("recorded");
    [(end[0], 0.0), (end[1], 10.0), (end[2], 3.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-9));
    // a normal of any length, pointing down: the other way round
    assert_eq!(m.mca3d(&xyz(), &hmp3d([0.0, 0.0, 3.0], [0.0, 0.0, -7.0], 90.0, [20.0, 200.0, 0.0])), Entered::Yes);
    let end = *points(&record(&mut m)).last().expect("recorded");
    [(end[0], 10.0), (end[1], 0.0), (end[2], 3.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-9));
}

// shows: pcap.mcr3d, pcap.smcr3d
#[test]
fn relative_centres_count_from_the_start() {
    let circle = hmp3d([-10.0, 0.0, 0.0], [0.0, 1.0, 0.0], 90.0, [20.0, 200.0, 0.0]);
    let mut m = at([10.0, 5.0, 1.0], EXACT);
    assert_eq!(m.mcr3d(&xyz(), &circle), Entered::Yes);
    let end = *points(&record(&mut m)).last().expect("recorded");
    [(end[0], 0.0), (end[1], 5.0), (end[2], -9.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-9));
    // spooled: from the end of the profile spooled before, here 100 further
    let target = {
        let mut dtm: PerAxis = [0.0; 18];
        dtm[..3].copy_from_slice(&[110.0, 0.0, 0.0]);
        dtm
    };
    assert_eq!(m.smla(&xyz(), &Lmp { ac: 500.0, vl: 50.0, tvl: 0.0, dtm: target }), Entered::Yes);
    assert_eq!(m.smcr3d(&xyz(), &circle), Entered::Yes);
    let end = *points(&run(&mut m)).last().expect("recorded");
    [(end[0], 100.0), (end[1], 0.0), (end[2], -10.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-9));
}

// shows: pcap.mca3d.any-axes
#[test]
fn any_three_axes_in_any_order() {
    let mut m = mcu("XYZUV", EXACT);
    let list = AxisList::new(&[4, 0, 3]);
    // first axis V, second X, third U; the normal is that of the third
    assert_eq!(m.smca3d(&list, &hmp3d([10.0, 0.0, 0.0], [0.0, 0.0, 1.0], 90.0, [20.0, 200.0, 0.0])), Entered::Yes);
    let trace = run(&mut m);
    let end = |a| *dp(&trace, a).last().expect("recorded");
    close(end(4), 10.0, 1e-9);
    close(end(0), -10.0, 1e-9);
    assert_eq!([end(1), end(2), end(3)], [0.0; 3]);
    for few in [&[0usize, 1][..], &[0, 1, 2, 3], &[0, 0, 1], &[0, 1, 17]] {
        m.clear_errorreg();
        let circle = hmp3d([1.0; 3], [0.0, 0.0, 1.0], 90.0, [20.0, 200.0, 0.0]);
        assert_eq!(m.smca3d(&AxisList::new(few), &circle), Entered::Discarded);
        assert!(m.errorreg().has(ErrorReg::errAxDef), "{few:?}");
        assert_eq!(m.mca3d(&AxisList::new(few), &circle), Entered::Discarded);
    }
}

// shows: pcap.mca3d.trapezoid, struct.hmp3d.ac, struct.hmp3d.vl, struct.hmp3d.tvl
#[test]
fn the_path_velocity_is_a_trapezoid_in_the_units_of_ctru() {
    let mut m = mcu("XYZ", EXACT);
    assert!(m.ctru(1, 1)); // inch, minutes
    let per_min = 60.0 / 25.4;
    let v = [30.0 * per_min, 300.0 * per_min * 60.0, 10.0 * per_min];
    assert_eq!(m.smca3d(&xyz(), &hmp3d([0.0, 1.0, 1.0], [1.0, 0.0, 0.0], 360.0, v)), Entered::Yes);
    m.ssms(set(&[0, 1, 2]));
    let radius = 25.4 * 2f64.sqrt();
    let (t_up, t_down) = (0.1, 20.0 / 300.0);
    let length = std::f64::consts::TAU * radius;
    let cruise = (length - 0.5 * 30.0 * t_up - 0.5 * (30.0 + 10.0) * t_down) / 30.0;
    let mut k = 0u64;
    while f64::from(k as u32 + 1) * TA < t_up + cruise + t_down {
        m.run(1);
        k += 1;
        let t = k as f64 * TA;
        let left = t_up + cruise + t_down - t;
        let want = (300.0 * t).min(30.0).min(10.0 + 300.0 * left);
        close(m.status().path_v, want, 1e-6);
    }
    m.run(1);
    assert!(m.current_move(0).is_none(), "it takes as long as the closed form says");
    close((0..3).map(|a| m.status().axes[a].dv.powi(2)).sum::<f64>().sqrt(), 10.0, 1e-6);
}

// shows: struct.hmp3d.no-target-mode, struct.hmp3d.dtm, pcap.mca3d.dtm-unused
#[test]
fn there_is_no_target_form_and_dtm_is_not_read() {
    let mut m = mcu("XYZ", EXACT);
    let mut circle = hmp3d([10.0, 0.0, 0.0], [0.0, 0.0, 1.0], 1e-101, [20.0, 200.0, 0.0]);
    circle.dtm = [f64::NAN; 18];
    assert_eq!(m.smca3d(&xyz(), &circle), Entered::Discarded);
    assert_eq!(m.errorreg(), ErrorReg::ZeroProfile | ErrorReg::CheckMonitorScreen);
    circle.phi = 180.0;
    assert_eq!(m.smca3d(&xyz(), &circle), Entered::Yes);
    let end = *points(&run(&mut m)).last().expect("recorded");
    [(end[0], 20.0), (end[1], 0.0), (end[2], 0.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-9));
}

#[test]
fn what_is_no_circle_is_discarded() {
    let v = [20.0, 200.0, 0.0];
    let z = [0.0, 0.0, 1.0];
    let cases = [
        // the centre lies above the start: radius 0 once projected
        (hmp3d([0.0, 0.0, 5.0], z, 90.0, v), ErrorReg::RadiusError | ErrorReg::errCenterPoint),
        (hmp3d([1e-10, 0.0, 5.0], z, 90.0, v), ErrorReg::RadiusError),
        (hmp3d([1.0, 0.0, 0.0], [0.0; 3], 90.0, v), ErrorReg::errCenterPoint),
        (hmp3d([1.0, 0.0, 0.0], [f64::NAN, 0.0, 1.0], 90.0, v), ErrorReg::errCenterPoint),
        (hmp3d([f64::INFINITY, 0.0, 0.0], z, 90.0, v), ErrorReg::errCenterPoint),
        (hmp3d([1.0, 0.0, 0.0], z, f64::NAN, v), ErrorReg::errCenterPoint),
        (hmp3d([1.0, 0.0, 0.0], z, 0.0, v), ErrorReg::ZeroProfile | ErrorReg::CheckMonitorScreen),
        (hmp3d([1.0, 0.0, 0.0], z, 90.0, [0.0, 1.0, 0.0]), ErrorReg::VelocityZero | ErrorReg::CheckMonitorScreen),
    ];
    for (circle, want) in cases {
        let mut m = mcu("XYZ", EXACT);
        assert_eq!(m.smca3d(&xyz(), &circle), Entered::Discarded, "{circle:?}");
        assert_eq!(m.errorreg(), want, "{circle:?}");
    }
    let mut open = Mcu::new(std::sync::Arc::new(machine("XYZ")));
    assert_eq!(open.smca3d(&xyz(), &cases[6].0), Entered::Refused);
    assert!(open.axst(2).has(Axst::dhef));
}

#[test]
fn each_of_its_entries_takes_the_memory_of_a_circle() {
    let mut small = machine("XYZ");
    small.controller.spool_memory_bytes = 300;
    let mut m = mcu_of(small, EXACT);
    let circle = hmp3d([10.0, 0.0, 0.0], [0.0, 0.0, 1.0], 90.0, [20.0, 200.0, 0.0]);
    assert_eq!([m.smca3d(&xyz(), &circle), m.smca3d(&xyz(), &circle)], [Entered::Yes; 2]);
    assert_eq!((0..3).map(|a| m.status().axes[a].lsm).collect::<Vec<_>>(), [44; 3]);
    assert_eq!(m.smca3d(&xyz(), &circle), Entered::Full);
    assert!(m.errorreg().has(ErrorReg::errSpoolerOverrun));
}

#[test]
fn an_override_and_a_stop_keep_it_on_the_circle() {
    let mut m = mcu("XYZ", EXACT);
    let circle = hmp3d([3.0, 4.0, 12.0], [4.0, 3.0, -2.0], 720.0, [40.0, 200.0, 0.0]);
    assert_eq!(m.smca3d(&xyz(), &circle), Entered::Yes);
    let all = m.all_axes();
    m.ssms(all);
    m.wrtrovrst(0.2);
    m.wrtrovr(0.3);
    m.run(300);
    m.utrovr(all);
    let mut trace = Trace::default();
    m.pass(400, &mut trace);
    let n = [4.0, 3.0, -2.0].map(|x: f64| x / 29f64.sqrt());
    let lift = -dot([3.0, 4.0, 12.0], n);
    let foot: V3 = std::array::from_fn(|i| [3.0, 4.0, 12.0][i] + lift * n[i]);
    let radius = dot(foot, foot).sqrt();
    let on_circle = |trace: &Trace| {
        points(trace)
            .iter()
            .all(|p| (dot(sub(*p, foot), sub(*p, foot)).sqrt() - radius).abs() < 1e-9 && dot(*p, n).abs() < 1e-9)
    };
    assert!(on_circle(&trace));
    m.ms(all);
    m.pass(2000, &mut trace);
    assert!(on_circle(&trace) && m.stands());
}

// shows: modereg.lookahead.commands
#[test]
fn look_ahead_leaves_3d_circles_and_direct_moves_as_they_are() {
    let top = |kind: u32| {
        let mut m = mcu("XYZ", LOOKAHEAD);
        for a in 0..3 {
            m.parameters_mut(a).maxacc = 10.0; // sqrt(10 * 10) = 10 mm/s on circles
        }
        let center = [10.0, 0.0];
        let circle = hmp3d([10.0, 0.0, 0.0], [0.0, 0.0, 1.0], 90.0, [40.0, 1000.0, 40.0]);
        match kind {
            0 => assert_eq!(arc(&mut m, center, 90.0, &[], 40.0, 1000.0, 40.0), Entered::Yes),
            1 => assert_eq!(m.smca3d(&xyz(), &circle), Entered::Yes),
            _ => assert_eq!(m.mca3d(&xyz(), &circle), Entered::Yes),
        }
        let mut trace = Trace::default();
        m.ssms(set(&[0, 1, 2]));
        m.pass(2000, &mut trace);
        let fastest = trace.v_plan.iter().copied().fold(0.0, f64::max);
        let runs_on = m.status().axes[1].dv != 0.0;
        (fastest, runs_on)
    };
    assert!((top(0).0 - 10.0).abs() < 1e-9 && !top(0).1, "a circle of look-ahead: slower, and a stop at the end");
    assert_eq!(top(1), (40.0, true), "a 3-D circle as programmed");
    assert_eq!(top(2), (40.0, true), "a direct move as programmed");
}

#[test]
fn a_chain_under_look_ahead_stops_before_a_3d_circle() {
    let mut m = mcu("XYZ", LOOKAHEAD);
    line(&mut m, &[0.0, -10.0, 0.0], 20.0, 500.0, 20.0);
    line(&mut m, &[0.0, -20.0, 0.0], 20.0, 500.0, 20.0);
    m.smcr3d(&xyz(), &hmp3d([10.0, 0.0, 0.0], [0.0, 0.0, 1.0], 90.0, [20.0, 500.0, 20.0]));
    line(&mut m, &[30.0, -30.0, 0.0], 20.0, 500.0, 0.0);
    let trace = run(&mut m);
    let first = |entry: u32| trace.entry.iter().position(|e| *e == entry).expect("executed");
    assert!(trace.v_plan[first(2)] > 19.9, "inside the chain it goes on");
    assert!(trace.v_plan[first(3)] < 500.0 * TA + 1e-9, "into the circle it starts from 0");
    assert!(trace.v_plan[first(4)] > 19.0, "out of it with its own target velocity");
    let end = *points(&trace).last().expect("recorded");
    [(end[0], 30.0), (end[1], -30.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-9));
}
