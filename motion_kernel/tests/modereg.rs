//! Each bit of MODEREG has an effect of its own (6.3.1.5, table 36), seen through commands of the application.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::functions::Entered;
use motion_kernel::machine::DriveKind;
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use motion_kernel::trace::Trace;

const OFF: ModeReg = ModeReg(0);

fn x() -> AxisList {
    AxisList::new(&[0])
}
fn v_plan(trace: &Trace, entry: u32) -> Vec<f64> {
    (0..trace.len()).filter(|k| trace.entry[*k] == entry).map(|k| trace.v_plan[k]).collect()
}
fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}
/// Largest change of the speed of an axis between two samples, in mm/s, beyond what `ac` explains.
fn worst_step(trace: &Trace, axis: usize, ac: f64) -> f64 {
    let v = speeds(trace, axis, 0.0);
    v.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max) - ac * TA
}

// shows: modereg.default-0
#[test]
fn after_boot_no_bit_is_set() {
    let m = Mcu::new(std::sync::Arc::new(machine("XYZ")));
    assert_eq!(m.modereg(), OFF);
}

// shows: modereg.read-modify-write
#[test]
fn bits_are_changed_one_by_one() {
    let mut m = mcu("X", ModeReg::ExactTargetPos | ModeReg::OvrMode);
    m.set_modereg(ModeReg(m.modereg().0 | 1));
    assert_eq!(m.modereg(), ModeReg::LookAhead | ModeReg::ExactTargetPos | ModeReg::OvrMode);
    m.set_modereg(ModeReg(m.modereg().0 & !1));
    assert_eq!(m.modereg(), ModeReg::ExactTargetPos | ModeReg::OvrMode);
}

/// A job with a bit of everything: chain with corners, circle, override, jog, stop. All that can be observed.
fn job(modereg: ModeReg) -> (Vec<f64>, Vec<f64>, ErrorReg, Vec<Axst>) {
    let mut m = mcu("XYC", modereg);
    m.parameters_mut(2).scale = 0.7;
    for n in 1..6 {
        line(&mut m, &[f64::from(n), f64::from(n % 2), f64::from(n)], 20.0, 300.0, 20.0);
    }
    arc(&mut m, [5.0, 5.0], 200.0, &[3.0], 20.0, 300.0, 0.0);
    m.wrtrovr(0.7);
    let all = m.all_axes();
    m.ssms(all);
    let mut trace = Trace::default();
    m.pass(200, &mut trace);
    let (mut dp, mut rp) = (trace.dp.clone(), trace.rp.clone());
    m.utrovr(all);
    m.pass(800, &mut trace);
    dp.extend(&trace.dp);
    rp.extend(&trace.rp);
    m.ms(set(&[0, 1]));
    m.ja(&AxisList::new(&[2]), &[350.0]);
    m.pass(500, &mut trace);
    line(&mut m, &[0.0, 0.0], 0.0, 300.0, 0.0);
    dp.extend(&trace.dp);
    rp.extend(&trace.rp);
    (dp, rp, m.errorreg(), (0..3).map(|a| m.axst(a)).collect())
}

// shows: modereg.bit-02-free, modereg.bit-04-free, modereg.bit-14-free, modereg.bit-16-23-free
// shows: modereg.bit-30-31-free
#[test]
fn free_bits_have_no_effect() {
    for base in [OFF, LOOKAHEAD] {
        let plain = job(base);
        for bit in [2, 4, 14, 16, 17, 18, 19, 20, 21, 22, 23, 30, 31] {
            assert!(job(base | ModeReg(1 << bit)) == plain, "bit {bit}");
        }
        // the job would notice
        for bit in [1, 10, 25, 29] {
            assert!(job(ModeReg(base.0 ^ 1 << bit)) != plain, "bit {bit}");
        }
    }
}

fn corner(modereg: ModeReg, tvl: f64) -> (Trace, Mcu) {
    let mut m = mcu("XY", modereg);
    line(&mut m, &[10.0, 0.0], 20.0, 300.0, tvl);
    line(&mut m, &[10.0, 10.0], 20.0, 300.0, tvl);
    m.ssms(set(&[0, 1]));
    let mut trace = Trace::default();
    m.pass(2000, &mut trace);
    (trace, m)
}

// shows: modereg.lookahead
#[test]
fn lookahead_keeps_velocity_steps_below_mdvel_and_ends_with_standstill() {
    let (trace, m) = corner(EXACT, 20.0);
    assert!(worst_step(&trace, 0, 300.0) > 9.0, "as programmed: straight round the corner");
    assert!(m.status().axes[1].dv > 15.0, "and on behind the last profile");
    let (trace, m) = corner(LOOKAHEAD, 20.0);
    let mdvel = m.parameters(0).mdvel;
    assert!(worst_step(&trace, 0, 300.0) <= mdvel && worst_step(&trace, 1, 300.0) <= mdvel);
    assert!(v_plan(&trace, 1).last().expect("executed") > &(mdvel / 2.0), "not slower than needed");
    assert!(m.stands());
    assert_eq!([m.rddp(0), m.rddp(1)], [10.0, 10.0]);
}

// shows: modereg.lookahead.needs-target-velocity
#[test]
fn without_target_velocities_lookahead_has_nothing_to_limit() {
    let collinear = |tvl: f64| {
        let mut m = mcu("X", LOOKAHEAD);
        (1..=4).for_each(|n| _ = line(&mut m, &[f64::from(n) * 5.0], 20.0, 300.0, tvl));
        let trace = run(&mut m);
        (2..=4).map(|entry| v_plan(&trace, entry)[0]).fold(f64::INFINITY, f64::min)
    };
    assert!(collinear(20.0) > 19.9);
    assert!(collinear(0.0) < 300.0 * TA + 1e-9, "every profile stops");
}

// shows: modereg.lookahead.circle-velocity
#[test]
fn lookahead_limits_circles_by_the_smallest_maxacc_of_their_plane() {
    let top = |modereg: ModeReg, maxacc: [f64; 3]| {
        let mut m = mcu("XYZ", modereg);
        (0..3).for_each(|a| m.parameters_mut(a).maxacc = maxacc[a]);
        arc(&mut m, [4.0, 0.0], 720.0, &[0.0], 60.0, 2000.0, 0.0);
        let trace = run(&mut m);
        for (a, most) in maxacc.iter().copied().enumerate().take(2) {
            let v = speeds(&trace, a, 0.0);
            let limit = if most > 0.0 && modereg.has(ModeReg::LookAhead) { most } else { f64::INFINITY };
            let cruising = v[v.len() / 3..v.len() * 2 / 3].windows(2).all(|w| (w[1] - w[0]).abs() <= limit * TA * 1.01);
            assert!(cruising, "axis {a} within its maxacc");
        }
        most(&trace.v_plan)
    };
    close(top(LOOKAHEAD, [100.0, 25.0, 1.0]), 10.0, 1e-9); // sqrt(4 * 25); Z is no axis of the plane
    close(top(LOOKAHEAD, [100.0, 0.0, 1.0]), 20.0, 1e-9);
    close(top(EXACT, [100.0, 25.0, 1.0]), 60.0, 1e-9);
}

// shows: modereg.s-profile
#[test]
fn s_profile_shapes_the_ramps_by_jerkrel() {
    let ramp = |modereg: ModeReg, jerkrel: f64| {
        let mut m = mcu("X", modereg);
        m.parameters_mut(0).jerkrel = jerkrel;
        line(&mut m, &[20.0], 20.0, 100.0, 0.0);
        let trace = run(&mut m);
        let v = speeds(&trace, 0, 0.0);
        let peak = v.windows(2).map(|w| (w[1] - w[0]) / TA).fold(0.0, f64::max);
        (peak, v[5], trace.len())
    };
    let (peak, early, samples) = ramp(EXACT, 1.0);
    close(peak, 100.0, 1e-6);
    for jerkrel in [0.2, 0.6, 1.0] {
        let (s_peak, s_early, s_samples) = ramp(EXACT | ModeReg::SProfile, jerkrel);
        close(s_peak, 100.0 * (1.0 + jerkrel), 3.0);
        assert!(s_early < early / 1.5 && s_samples == samples, "gently, in the same time");
    }
    assert_eq!(ramp(EXACT | ModeReg::SProfile, 0.0), (peak, early, samples));
}

// shows: modereg.notriangle
#[test]
fn notriangle_goes_on_with_the_higher_junction_velocity() {
    let chain = |modereg: ModeReg| {
        let mut m = mcu("XY", modereg);
        for n in 1..=4 {
            let side = if n % 2 == 1 { 0.05 } else { 0.0 };
            line(&mut m, &[2.0 * f64::from(n), side], 60.0, 500.0, if n < 4 { 60.0 } else { 0.0 });
        }
        let trace = run(&mut m);
        let inside = v_plan(&trace, 2);
        (inside[0].max(inside[inside.len() - 1]), most(&inside), most(&v_plan(&trace, 1)))
    };
    let (_, top, _) = chain(LOOKAHEAD);
    let (ends, flat, first) = chain(LOOKAHEAD | ModeReg::NoTriangle);
    assert!(top > flat + 5.0 && flat <= ends + 1e-9, "{top} {flat} {ends}");
    assert!(first <= flat + 1e-9, "from standstill no faster than at its end");
    // only in look-ahead mode
    let triangle = |modereg: ModeReg| {
        let mut m = mcu("X", modereg);
        line(&mut m, &[2.0], 60.0, 500.0, 5.0);
        line(&mut m, &[4.0], 60.0, 500.0, 0.0);
        most(&v_plan(&run(&mut m), 2))
    };
    assert_eq!(triangle(EXACT), triangle(EXACT | ModeReg::NoTriangle));
    assert!(triangle(LOOKAHEAD) > 20.0);
    close(triangle(LOOKAHEAD | ModeReg::NoTriangle), 5.0, 1e-9);
    // between two standstills the triangle stays
    let mut m = mcu("X", LOOKAHEAD | ModeReg::NoTriangle);
    line(&mut m, &[2.0], 60.0, 500.0, 0.0);
    assert!(most(&run(&mut m).v_plan) > 30.0);
}

/// Design D16: a junction slower than a thousandth of the triangle is standstill, or the first move would crawl.
#[test]
fn notriangle_does_not_crawl_to_a_tiny_last_move() {
    let samples = |modereg: ModeReg| {
        let mut m = mcu("X", modereg);
        line(&mut m, &[10.0], 100.0, 500.0, 100.0);
        line(&mut m, &[10.0 + 1e-6], 100.0, 500.0, 0.0);
        run(&mut m).len()
    };
    assert_eq!(samples(LOOKAHEAD | ModeReg::NoTriangle), samples(LOOKAHEAD));
}

/// Path velocity, target velocity and acceleration that a line of X and Y really has.
fn line_of(modereg: ModeReg, change: impl Fn(&mut Mcu)) -> [f64; 3] {
    let mut m = mcu("XYZ", modereg);
    change(&mut m);
    line(&mut m, &[12.0, 16.0], 50.0, 500.0, 50.0);
    m.ssms(set(&[0, 1]));
    let mut trace = Trace::default();
    m.pass(2500, &mut trace);
    let end_v = m.status().axes[0].dv.hypot(m.status().axes[1].dv);
    [most(&trace.v_plan), end_v, (trace.v_plan[9] - trace.v_plan[4]) / (5.0 * TA)]
}

// shows: modereg.chkmaxvel
#[test]
fn chkmaxvel_reduces_velocity_target_velocity_and_acceleration_of_lines() {
    let limits = |m: &mut Mcu| {
        (m.parameters_mut(0).maxvel, m.parameters_mut(1).maxvel) = (15.0, 16.0); // Y: 16 of 0.8
        (m.parameters_mut(0).maxacc, m.parameters_mut(1).maxacc) = (120.0, 1000.0); // X: 120 of 0.6
    };
    let [v, tvl, ac] = line_of(EXACT, limits);
    [(v, 50.0), (tvl, 50.0), (ac, 500.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-6));
    let [v, tvl, ac] = line_of(EXACT | ModeReg::ChkMaxVel, limits);
    [(v, 20.0), (tvl, 20.0), (ac, 200.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-6));
    let [v, tvl, ac] = line_of(EXACT | ModeReg::ChkMaxVel, |m| {
        (0..2).for_each(|a| (m.parameters_mut(a).maxvel, m.parameters_mut(a).maxacc) = (0.0, 0.0));
    });
    [(v, 50.0), (tvl, 50.0), (ac, 500.0)].into_iter().for_each(|(is, want)| close(is, want, 1e-6));
}

// shows: modereg.chkmaxvel.nfrax-included
#[test]
fn chkmaxvel_supervises_no_feed_rate_axes_too() {
    let [v, tvl, _] = line_of(EXACT | ModeReg::ChkMaxVel, |m| {
        m.registers_mut().nfrax = AxisSet::single(1);
        m.parameters_mut(1).maxvel = 16.0; // Y travels 16 mm to 12 of path
    });
    close(v, 12.0, 1e-6);
    close(tvl, 15.0 * 16.0 / 12.0 / 20.0 * 20.0, 5.0); // both axes, as vectors: 12 and 16 mm/s
    assert!(tvl > 19.9);
}

/// Where X stands after an absolute and some relative moves that are no whole counts (10 counts/mm).
fn ends_at(modereg: ModeReg) -> [f64; 2] {
    let mut machine = machine("X");
    machine.axes[0].counts_per_unit = 10.0;
    let mut m = mcu_of(machine, modereg);
    line(&mut m, &[1.234], 20.0, 300.0, 0.0);
    run(&mut m);
    let first = m.rddp(0);
    for _ in 0..10 {
        spool(&mut m, MoveKind::Smlr, &x(), &[0.04], [0.0; 2], 0.0, [20.0, 300.0, 0.0]);
        spool(&mut m, MoveKind::Smlr, &x(), &[0.16], [0.0; 2], 0.0, [20.0, 300.0, 0.0]);
    }
    run(&mut m);
    [first, m.rddp(0)]
}

// shows: modereg.exacttargetpos, modereg.exacttargetpos.default-rounding
#[test]
fn exacttargetpos_ends_off_the_counts() {
    let [first, last] = ends_at(ModeReg::ExactTargetPos);
    close(first, 1.234, 0.0);
    close(last, 3.234, 1e-9);
    let [first, last] = ends_at(OFF);
    close(first, 1.2, 1e-12);
    // 0.04 rounds to nothing (and is discarded), 0.16 to 0.2: errors add up
    close(last, 3.2, 1e-9);
    // with a target velocity nothing is rounded
    let mut m = mcu("X", OFF);
    line(&mut m, &[1.000_037], 20.0, 300.0, 20.0);
    line(&mut m, &[2.0], 20.0, 300.0, 0.0);
    let trace = run(&mut m);
    let entry = trace.entry.iter().position(|e| *e == 2).expect("executed");
    let v = (dp(&trace, 0)[entry] - dp(&trace, 0)[entry - 1]) / TA;
    close(v, 20.0, 1e-9);
}

// shows: modereg.shortestrotatoricdistance
#[test]
fn shortest_rotatoric_distance_sends_a_rotary_axis_the_short_way() {
    let way = |modereg: ModeReg, from: f64, to: f64| {
        let mut m = mcu("XC", modereg);
        m.parameters_mut(1).jvl = 500.0;
        m.wrdp(1, from);
        m.ja(&AxisList::new(&[1]), &[to]);
        m.run(6000);
        m.rddp(1) - from
    };
    assert_eq!(way(EXACT, 10.0, 350.0), 340.0);
    let short = EXACT | ModeReg::ShortestRotatoricDistance;
    for (from, to, want) in
        [(10.0, 350.0, -20.0), (350.0, 10.0, 20.0), (10.0, 100.0, 90.0), (0.0, 725.0, 5.0), (-100.0, 90.0, -170.0)]
    {
        close(way(short, from, to), want, 1e-9);
    }
    // a linear axis goes where it is told
    let mut m = mcu("XC", short);
    m.ja(&x(), &[350.0]);
    m.run(8000);
    assert_eq!(m.rddp(0), 350.0);
}

// shows: modereg.rotatoricunit
#[test]
fn rotatoricunit_takes_distances_of_rotary_axes_in_their_own_unit() {
    let turned = |modereg: ModeReg| {
        let mut m = mcu("XBC", modereg);
        (1..3).for_each(|a| m.parameters_mut(a).scale = 100f64.to_radians()); // effradius 100 mm
        let list = AxisList::new(&[0, 1, 2]);
        spool(&mut m, MoveKind::Smlr, &list, &[25.0, 60.0, 30.0], [0.0; 2], 0.0, [50.0, 500.0, 0.0]);
        run(&mut m);
        [m.rddp(0), m.rddp(1), m.rddp(2)]
    };
    let circumference = [25.0, 0.6f64.to_degrees(), 0.3f64.to_degrees()];
    turned(ModeReg::ExactTargetPos).iter().zip(circumference).for_each(|(is, want)| close(*is, want, 1e-9));
    let degrees = turned(ModeReg::ExactTargetPos | ModeReg::RotatoricUnit);
    degrees.iter().zip([25.0, 60.0, 30.0]).for_each(|(is, want)| close(*is, want, 1e-9));
}

// shows: modereg.forbidtargetvel
#[test]
fn forbidtargetvel_resets_when_profiles_end_with_a_velocity() {
    let ends = |modereg: ModeReg, kind: u32, tvl: f64| {
        let mut m = mcu("XY", modereg);
        m.parameters_mut(0).jtvl = tvl;
        match kind {
            0 => {
                line(&mut m, &[5.0, 5.0], 10.0, 300.0, 10.0);
                line(&mut m, &[10.0, 10.0], 10.0, 300.0, tvl);
                m.ssms(set(&[0, 1]));
            }
            1 => {
                let command = motion_kernel::trajectory::Lmp { ac: 300.0, vl: 10.0, tvl, dtm: [10.0; 18] };
                assert_eq!(m.mla(&xy(), &command), Entered::Yes);
            }
            _ => _ = m.ja(&x(), &[10.0]),
        }
        m.run(3000);
        (m.errorreg().has(ErrorReg::errTargetVel), m.axst(0).has(Axst::cl), m.status().axes[0].dv != 0.0)
    };
    for kind in 0..3 {
        assert_eq!(ends(EXACT, kind, 10.0), (false, true, true), "runs on");
        assert_eq!(ends(EXACT | ModeReg::ForbidTargetVel, kind, 10.0), (true, false, false), "rs: open loop");
        assert_eq!(ends(EXACT | ModeReg::ForbidTargetVel, kind, 0.0), (false, true, false));
    }
}

// shows: modereg.ms-decel
#[test]
fn ms_decel_brakes_with_trac_in_interpolation_units() {
    let way = |modereg: ModeReg, units: (i32, i32), trac: f64| {
        let mut m = mcu("X", modereg);
        line(&mut m, &[100.0], 20.0, 100.0, 0.0);
        m.ssms(set(&[0]));
        m.run(500);
        assert!(m.ctru(units.0, units.1));
        m.registers_mut().trac = trac;
        let before = m.rddp(0);
        m.ms(set(&[0]));
        m.run(500);
        m.rddp(0) - before
    };
    let decel = EXACT | ModeReg::MS_DECEL;
    close(way(EXACT, (0, 0), 400.0), 2.0, 1e-9);
    close(way(decel, (0, 0), 400.0), 0.5, 1e-9);
    close(way(decel, (1, 0), 400.0 / 25.4), 0.5, 1e-9); // inch
    close(way(decel, (0, 1), 400.0 * 3600.0), 0.5, 1e-9); // minutes
}

fn overrides_after_utrovr(modereg: ModeReg) -> (f64, f64, f64) {
    let mut m = mcu("XY", modereg);
    m.wrjovr(0, 0.9);
    m.wrtrovr(0.4);
    m.utrovr(set(&[0]));
    m.run(1);
    (m.rdjovr(0), m.rdjovr(1), m.status().factor)
}

// shows: modereg.ovrmode, modereg.ovrmode.default
#[test]
fn ovrmode_leaves_the_jog_override_alone() {
    assert_eq!(overrides_after_utrovr(EXACT), (0.4, 1.0, 0.4));
    assert_eq!(overrides_after_utrovr(EXACT | ModeReg::OvrMode), (0.9, 1.0, 0.4));
}

// shows: modereg.jsatsaf
#[test]
fn jsatsaf_stops_all_axes_in_position_control() {
    let asynchronous = |modereg: ModeReg| {
        let mut m = mcu("XYZU", modereg);
        m.ol(set(&[3]));
        line(&mut m, &[40.0, 40.0], 20.0, 300.0, 0.0);
        m.ssms(set(&[0, 1]));
        m.ja(&AxisList::new(&[2]), &[100.0]);
        m.run(300);
        m.wrjovr(0, 0.5);
        m.run(1);
        let saf = m.axst(0).has(Axst::saf) && m.axst(1).has(Axst::saf) && !m.axst(2).has(Axst::saf);
        let before = m.rddp(2);
        m.run(100);
        let moving: Vec<bool> = (0..4).map(|a| m.rddv(a) != 0.0).collect();
        (saf, m.errorreg().has(ErrorReg::JSatSAFdone), moving, m.rddp(2) - before)
    };
    let (saf, done, moving, _) = asynchronous(EXACT);
    assert_eq!((saf, done, &moving[..]), (true, false, &[true, true, true, false][..]));
    let (saf, done, moving, way) = asynchronous(EXACT | ModeReg::JSatSAF);
    assert_eq!((saf, done, &moving[..]), (true, true, &[false; 4][..]), "Z too, which had nothing to do with it");
    close(way, 50.0 * 50.0 / (2.0 * 2000.0), 0.1); // with its sdec
}

// shows: modereg.inhibitprofilerefuse, modereg.inhibitprofilerefuse.default
#[test]
fn inhibitprofilerefuse_silences_the_message_of_discarded_profiles() {
    let cases = [
        ([1.0, 1.0], [0.0, 300.0, 0.0], ErrorReg::VelocityZero),
        ([1.0, 1.0], [20.0, 0.0, 0.0], ErrorReg::AccelZero),
        ([0.0, 0.0], [20.0, 300.0, 0.0], ErrorReg::ZeroProfile),
    ];
    for (target, [vl, ac, tvl], bit) in cases {
        for (modereg, message) in [(EXACT, true), (EXACT | ModeReg::InhibitProfileRefuse, false)] {
            let mut m = mcu("XY", modereg);
            assert_eq!(line(&mut m, &target, vl, ac, tvl), Entered::Discarded);
            assert!(m.errorreg().has(bit), "{bit:?}");
            assert_eq!(m.errorreg().has(ErrorReg::CheckMonitorScreen), message, "{bit:?}");
            assert_eq!(m.status().axes[0].mcis, 0);
        }
    }
}

// shows: modereg.simulationmode
#[test]
fn simulationmode_puts_out_nothing_and_simulates_the_actual_position() {
    for drive in [DriveKind::Servo, DriveKind::Stepper] {
        let mut machine = machine("X");
        machine.axes[0].drive = drive;
        machine.axes[0].pidf.kp = 20.0;
        let mut m = mcu_of(machine, EXACT | ModeReg::SimulationMode);
        line(&mut m, &[30.0], 20.0, 300.0, 0.0);
        m.ssms(set(&[0]));
        let mut trace = Trace::default();
        let mut commands = 0;
        for _ in 0..1500 {
            m.pass(1, &mut trace);
            commands += i32::from(m.rdmcp(0) != 0);
            close(trace.rp[0], trace.dp[0], 20.0 * TA + 1e-4);
        }
        assert_eq!(commands, 0, "{drive:?}: nothing for the drive");
        close(m.rdrp(0), 30.0, 1e-4);
        // the motor itself never moved
        m.set_modereg(EXACT);
        m.run(1);
        m.ol(set(&[0]));
        m.run(2);
        assert!(m.rdrp(0) < 1.0, "{drive:?}: {}", m.rdrp(0));
    }
    // without the bit the controller acts
    let mut machine = machine("X");
    machine.axes[0].drive = DriveKind::Servo;
    machine.axes[0].pidf.kp = 20.0;
    let mut m = mcu_of(machine, EXACT);
    m.wrdp(0, 1.0);
    m.run(1);
    assert!(m.rdmcp(0) > 0);
}

// shows: modereg.clearzeroposition
#[test]
fn clearzeroposition_clears_the_offset_and_keeps_the_positions() {
    let mut m = mcu("XY", EXACT);
    m.ja(&x(), &[20.0]);
    m.run(3000);
    assert!(m.szpa(0, 5.0) && m.szpr(1, 2.0));
    assert_eq!((m.rdrp(0), m.zero_offset(0), m.zero_offset(1)), (15.0, 5.0, 2.0));
    // taken back, the positions would be the old ones again
    assert!(m.szpa(0, 0.0));
    assert_eq!((m.rdrp(0), m.zero_offset(0)), (20.0, 0.0));
    assert!(m.szpa(0, 5.0));
    m.set_modereg(EXACT | ModeReg::ClearZeroPosition);
    m.run(1);
    assert_eq!((m.rdrp(0), m.rddp(0), m.rdrp(1)), (15.0, 15.0, -2.0));
    assert_eq!((m.zero_offset(0), m.zero_offset(1)), (0.0, 0.0));
    // while it is set the reference position can be shifted at any time
    assert!(m.szpr(0, 1.0));
    assert_eq!((m.rdrp(0), m.zero_offset(0)), (14.0, 0.0));
}
