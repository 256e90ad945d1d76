//! Look-ahead (MODEREG bit 0) and the limits of the axes: junction speeds against a plain two-pass computation.

mod common;

use common::contour::{Block, Placed, Shape, contour, enter, length, place};
use common::*;
use motion_kernel::Mcu;
use motion_kernel::registers::{ErrorReg, ModeReg};
use motion_kernel::trace::Trace;
use proptest::prelude::*;

const MDVEL: f64 = 0.5;
const MAXACC: f64 = 1000.0;

/// Unit tangents at start and end of a block, computed from its geometry.
fn tangents(b: &Placed) -> ([f64; 3], [f64; 3]) {
    let l = length(b);
    match b.block.shape {
        Shape::Line(d) => (d.map(|x| x / l), d.map(|x| x / l)),
        Shape::Arc(c, phi, dz) => {
            let sign = phi.signum();
            let around = |p: [f64; 3]| {
                let (rx, ry) = (p[0] - b.start[0] - c[0], p[1] - b.start[1] - c[1]);
                let share = phi.abs().to_radians() / l;
                [-sign * ry * share, sign * rx * share, dz / l]
            };
            (around(b.start), around(b.end))
        }
    }
}

/// Path velocity of a block within the limits of the axes.
fn limited(b: &Placed) -> f64 {
    match b.block.shape {
        Shape::Line(_) => b.block.vl,
        Shape::Arc(c, ..) => b.block.vl.min((c[0].hypot(c[1]) * MAXACC).sqrt()),
    }
}

/// Start speeds of all blocks and 0 after the last: backward pass, then forward pass.
fn brute_force(placed: &[Placed]) -> Vec<f64> {
    let n = placed.len();
    let mut v2 = vec![0.0; n + 1];
    for k in 1..n {
        let (before, after) = (tangents(&placed[k - 1]).1, tangents(&placed[k]).0);
        let turn = (0..3).map(|i| (after[i] - before[i]).abs()).filter(|d| *d > 1e-12).map(|d| MDVEL / d);
        let tvl = if placed[k - 1].block.goes_on { limited(&placed[k - 1]) } else { 0.0 };
        let v = turn.fold(f64::INFINITY, f64::min).min(tvl).min(limited(&placed[k]));
        v2[k] = v * v;
    }
    for k in (0..n).rev() {
        v2[k] = f64::min(v2[k], v2[k + 1] + 2.0 * placed[k].block.ac * length(&placed[k]));
    }
    for k in 0..n {
        v2[k + 1] = f64::min(v2[k + 1], v2[k] + 2.0 * placed[k].block.ac * length(&placed[k]));
    }
    v2.iter().map(|v2| v2.sqrt()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    // shows: spool.load-while-running, pcap.rdlsm.any-time
    #[test]
    fn blocks_that_come_while_running_only_raise_speeds(blocks in contour(40), each in 1u64..20) {
        let mut m = mcu("XYZ", LOOKAHEAD);
        let placed = place(&blocks);
        let expected = brute_force(&placed);
        enter(&mut m, &placed, 0);
        let all = m.all_axes();
        m.ssms(all);
        let mut trace = Trace::default();
        for n in 1..placed.len() {
            m.advance(each, &mut trace);
            if let Some(mv) = m.current_move(0) {
                prop_assert!(mv.profile.end_v <= expected[mv.number as usize] * (1.0 + 1e-9) + 1e-9);
            }
            enter(&mut m, &placed, n);
            m.ssms(all);
        }
        record(&mut m);
        for (axis, end) in m.status().axes.iter().zip(placed[placed.len() - 1].end) {
            close(axis.dp, end, 1e-9);
        }
    }
}

fn blocks(shapes: &[Shape], vl: f64, ac: f64) -> Vec<Placed> {
    let block = |shape: &Shape| Block { shape: shape.clone(), vl, ac, goes_on: true };
    place(&shapes.iter().map(block).collect::<Vec<_>>())
}

/// Highest path velocity in block `entry`.
fn top(trace: &Trace, entry: u32) -> f64 {
    let here = trace.entry.iter().zip(&trace.v_plan).filter(|(e, _)| **e == entry);
    here.map(|(_, v)| *v).fold(0.0, f64::max)
}

fn square(mode: ModeReg, change: impl Fn(&mut Mcu)) -> (Trace, ErrorReg) {
    let mut m = mcu("XYZ", mode);
    change(&mut m);
    let placed = blocks(&[Shape::Line([10.0, 0.0, 0.0]), Shape::Line([0.0, 10.0, 0.0])], 50.0, 500.0);
    for n in 0..2 {
        enter(&mut m, &placed, n);
    }
    let trace = run(&mut m);
    (trace, m.errorreg())
}
fn speed_at_corner(trace: &Trace) -> f64 {
    let corner = trace.entry.iter().position(|e| *e == 2).expect("second block");
    trace.v_plan[corner]
}

// shows: pcap.wrmdvel.zero
#[test]
fn mdvel_0_switches_an_axis_off() {
    close(speed_at_corner(&square(LOOKAHEAD, |_| ()).0), MDVEL, 500.0 * TA);
    let (free, _) = square(LOOKAHEAD, |m| (0..3).for_each(|a| m.parameters_mut(a).mdvel = 0.0));
    close(speed_at_corner(&free), 50.0, 500.0 * TA);
    let (one, _) = square(LOOKAHEAD, |m| {
        m.parameters_mut(0).mdvel = 0.0;
        m.parameters_mut(1).mdvel = 7.0;
    });
    close(speed_at_corner(&one), 7.0, 500.0 * TA);
}

// shows: pcap.wrmaxvel.effect, pcap.wrmaxvel.enable, pcap.wrmaxvel.zero, pcap.rdmaxvel.use
#[test]
fn chk_max_vel_limits_lines_by_maxvel() {
    let slow = |m: &mut Mcu| m.parameters_mut(0).maxvel = 12.0;
    let (unchecked, _) = square(LOOKAHEAD, slow);
    assert!(top(&unchecked, 1) > 49.0);
    let (checked, _) = square(LOOKAHEAD | ModeReg::ChkMaxVel, slow);
    close(top(&checked, 1), 12.0, 1e-9);
    assert!(top(&checked, 2) > 49.0, "the other axis is free");
    let (off, _) = square(LOOKAHEAD | ModeReg::ChkMaxVel, |m| m.parameters_mut(0).maxvel = 0.0);
    assert!(top(&off, 1) > 49.0);
}

// shows: pcap.wrmaxacc.effect, pcap.wrmaxacc.enable, pcap.wrmaxacc.zero, pcap.rdmaxacc.use
#[test]
fn chk_max_vel_limits_lines_by_maxacc() {
    let samples_to_40 = |mode, maxacc: f64| {
        let (trace, _) = square(mode, |m| m.parameters_mut(0).maxacc = maxacc);
        trace.v_plan.iter().position(|v| *v >= 40.0).expect("reaches 40 mm/s") as f64 * TA
    };
    close(samples_to_40(LOOKAHEAD | ModeReg::ChkMaxVel, 200.0), 40.0 / 200.0, 2.0 * TA);
    close(samples_to_40(LOOKAHEAD, 200.0), 40.0 / 500.0, 2.0 * TA);
    close(samples_to_40(LOOKAHEAD | ModeReg::ChkMaxVel, 0.0), 40.0 / 500.0, 2.0 * TA);
}

/// Limits of a rotary axis stand in the machine file in degrees, whatever its effective radius.
#[test]
fn rotary_axes_keep_their_limits_in_degrees() {
    for effradius in [10.0, 57.29577951308232, 200.0] {
        let mut machine = machine("XC");
        (machine.axes[1].effradius, machine.axes[1].maxvel) = (effradius, 90.0);
        let mut m = mcu_of(machine, LOOKAHEAD | ModeReg::ChkMaxVel);
        line(&mut m, &[0.0, 180.0], 1e4, 1e4, 0.0);
        let fastest = speeds(&run(&mut m), 1, 0.0).into_iter().fold(0.0, f64::max);
        close(fastest, 90.0, 1e-6);
    }
}

#[test]
fn arcs_are_limited_by_the_square_root_of_radius_times_maxacc() {
    for (mode, expected) in [(LOOKAHEAD, (2.0 * MAXACC).sqrt()), (EXACT, 100.0)] {
        let mut m = mcu("XYZ", mode);
        arc(&mut m, [2.0, 0.0], 3600.0, &[0.0], 100.0, 2000.0, 0.0);
        close(top(&run(&mut m), 1), expected, 1e-9);
    }
}

// shows: pcap.wrmdvel.bit6
#[test]
fn no_triangle_keeps_the_higher_junction_speed() {
    let zigzag = [Shape::Line([3.0, 0.02, 0.0]), Shape::Line([3.0, -0.02, 0.0]), Shape::Line([3.0, 0.02, 0.0])];
    let speeds = |mode: ModeReg| {
        let mut m = mcu("XYZ", mode);
        let placed = blocks(&zigzag, 100.0, 500.0);
        for n in 0..3 {
            enter(&mut m, &placed, n);
        }
        let junction = brute_force(&placed)[1];
        (top(&run(&mut m), 2), junction)
    };
    let (triangle, junction) = speeds(LOOKAHEAD);
    assert!(triangle > junction + 5.0);
    let (flat, junction) = speeds(LOOKAHEAD | ModeReg::NoTriangle);
    close(flat, junction, 1e-9);
    // between two standstills the triangle stays
    let mut m = mcu("X", LOOKAHEAD | ModeReg::NoTriangle);
    line(&mut m, &[2.0], 500.0, 500.0, 0.0);
    close(top(&run(&mut m), 1), (500.0f64 * 2.0).sqrt(), 500.0 * TA);
}

// shows: pcap.wrmdvel.tvl-positive
#[test]
fn without_target_velocity_there_is_a_stop() {
    let mut m = mcu("X", LOOKAHEAD);
    line(&mut m, &[10.0], 50.0, 500.0, 0.0);
    line(&mut m, &[20.0], 50.0, 500.0, 0.0);
    let trace = run(&mut m);
    let second = trace.entry.iter().position(|e| *e == 2).expect("second block");
    assert!(trace.v_plan[second] <= 500.0 * TA);
}

// shows: errorreg.spooler-deep-to-less
#[test]
fn too_few_blocks_in_the_spooler_are_reported() {
    let placed = blocks(&vec![Shape::Line([0.5, 0.0, 0.0]); 40], 50.0, 500.0);
    let mut m = mcu("XYZ", LOOKAHEAD);
    for n in 0..40 {
        enter(&mut m, &placed, n);
    }
    run(&mut m);
    assert_eq!(m.errorreg().0, 0, "the last block is programmed to stop");
    let mut m = mcu("XYZ", LOOKAHEAD);
    for n in 0..3 {
        enter(&mut m, &placed, n);
    }
    let all = m.all_axes();
    m.ssms(all);
    m.run(50);
    assert!(m.errorreg().has(ErrorReg::SpoolerDeepToLess));
    for n in 3..40 {
        enter(&mut m, &placed, n);
    }
    record(&mut m);
}

#[test]
fn a_limited_depth_plans_with_fewer_blocks() {
    let placed = blocks(&vec![Shape::Line([0.5, 0.0, 0.0]); 40], 50.0, 500.0);
    let top_speed = |depth| {
        let mut m = mcu("XYZ", LOOKAHEAD);
        m.registers_mut().lookahead_depth = depth;
        for n in 0..40 {
            enter(&mut m, &placed, n);
        }
        let trace = run(&mut m);
        trace.v_plan.iter().copied().fold(0.0, f64::max)
    };
    close(top_speed(0), 50.0, 1e-9);
    // one block of braking path at the end of the present one, and a triangle inside it
    close(top_speed(1), (2.0f64 * 500.0 * 0.5 + 500.0 * 0.5).sqrt(), 500.0 * TA);
    assert!(top_speed(3) > top_speed(1) && top_speed(3) < 50.0);
}

#[test]
fn chains_of_different_axes_do_not_join() {
    let mut m = mcu("XYZ", LOOKAHEAD);
    line(&mut m, &[5.0, 0.0], 50.0, 500.0, 50.0);
    line(&mut m, &[10.0, 0.0, 0.0], 50.0, 500.0, 0.0);
    let (first, second) = (run(&mut m), m.status());
    let change = first.entry.iter().position(|e| *e == 2).expect("second block");
    assert!(first.v_plan[change] < 500.0 * TA + 1e-9);
    close(second.axes[0].dp, 10.0, 0.0);
}

#[test]
fn a_target_velocity_above_the_maximum_is_capped() {
    let mut m = mcu("X", LOOKAHEAD);
    line(&mut m, &[10.0], 20.0, 500.0, 60.0);
    line(&mut m, &[20.0], 60.0, 500.0, 0.0);
    let trace = run(&mut m);
    let second = trace.entry.iter().position(|e| *e == 2).expect("second block");
    close(trace.v_plan[second], 20.0, 500.0 * TA);
}

/// Whatever the length of the job, the sums stay as short as the spooler (they would lose their precision).
#[test]
fn sums_start_anew_now_and_then() {
    let mut m = mcu("X", LOOKAHEAD);
    let all = m.all_axes();
    let per_block = 2.0 * 500.0 * 0.1;
    for n in 1..=5000u32 {
        line(&mut m, &[f64::from(n) * 0.1], 50.0, 500.0, 50.0);
        if n > 30 {
            m.ssms(all);
            m.run(2);
            let waiting = f64::from(m.status().axes[0].mcis) + 2.0;
            if let Some(mv) = m.current_move(0) {
                assert!(mv.prefix_v2 <= 2.0 * waiting * per_block, "{} after {n} blocks", mv.prefix_v2);
            }
        }
    }
}
