//! Properties of random chains in 2 to 6 axes: set points against the geometry of common/chain.rs, dynamics from
//! differences of the path length travelled.

mod common;

use common::chain::*;
use common::*;
use motion_kernel::axes::AxisSet;
use motion_kernel::functions::Entered;
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};
use proptest::prelude::*;

const S: ModeReg = ModeReg(LOOKAHEAD.0 | 1 << 1);
const CHECKED: ModeReg = ModeReg(LOOKAHEAD.0 | 1 << 7);
const MODES: [ModeReg; 5] = [LOOKAHEAD, EXACT, S, CHECKED, ModeReg(CHECKED.0 | 1 << 6)];
const MDVEL: f64 = 0.5;
const MAXVEL: f64 = 200.0;
const MAXACC: f64 = 1000.0;

fn started(chain: &Chain, mode: ModeReg) -> Mcu {
    let mut m = chain.spooled(mode);
    let all = m.all_axes();
    m.ssms(all);
    m
}
fn give(m: &mut Mcu, factor: f64, seconds: f64) {
    let all = m.all_axes();
    m.wrtrovrst(seconds);
    assert!(m.wrtrovr(factor));
    m.utrovr(all);
}

/// The axes stand at the end of the chain: at the programmed number itself after a line.
fn ends(m: &Mcu, chain: &Chain) {
    let line = matches!(chain.placed[chain.placed.len() - 1].element.shape, Shape::Line { .. });
    let tolerance = if line { 0.0 } else { 1e-12 * chain.extent() };
    for ((axis, end), scale) in m.status().axes.iter().zip(chain.end()).zip(&chain.scale) {
        assert!((axis.dp - end).abs() * scale <= tolerance, "{} is not {end}", axis.dp);
        assert!(axis.axst.has(Axst::pe) && !axis.axst.has(Axst::saf));
    }
}

/// Path acceleration and velocities over samples at a constant factor <= 1 (design D18).
fn check_path_dynamics(chain: &Chain, trace: &Trace, lengths: &[f64], factor: f64, over: f64) {
    let noise = 1e-12 * chain.extent();
    let number = |k: usize| if trace.entry[k] == 0 { chain.placed.len() } else { trace.entry[k] as usize };
    for k in 0..lengths.len() {
        let s = |back: usize| if k < back { 0.0 } else { lengths[k - back] };
        let first = if k < 2 { 1 } else { number(k - 2) };
        let most = |f: fn(&Placed) -> f64| chain.placed[first - 1..number(k)].iter().map(f).fold(0.0, f64::max);
        let acceleration = (s(0) - 2.0 * s(1) + s(2)).abs() / TA / TA;
        let allowed = most(|b| b.element.ac) * factor * factor * over + 4.0 * noise / TA / TA;
        assert!(acceleration <= allowed, "sample {k}: {acceleration} mm/s² of {allowed}");
        let limit = |b: &Placed| {
            let arc = if b.curve.radius > 0.0 { (b.curve.radius * MAXACC).sqrt() } else { f64::INFINITY };
            b.element.vl.min(arc)
        };
        let (v, allowed) = ((s(0) - s(1)) / TA, most(limit) * factor + 2.0 * noise / TA);
        assert!(v <= allowed, "sample {k}: {v} mm/s of {allowed}");
    }
}

/// From sample to sample the speed of an axis changes by no more than its ramp, its share of the curvature (v²/r within
/// maxacc on arcs) and mdvel for every junction in between.
fn check_axis_steps(chain: &Chain, trace: &Trace, factor: f64, over: f64) {
    let n = trace.axes;
    let noise = 1e-12 * chain.extent();
    let number = |k: usize| if trace.entry[k] == 0 { chain.placed.len() } else { trace.entry[k] as usize };
    for k in 2..trace.len() {
        let passed = &chain.placed[number(k - 2) - 1..number(k)];
        let ramp = passed.iter().map(|b| b.element.ac).fold(0.0, f64::max) * over;
        let allowed = (ramp + MAXACC) * factor * factor * TA + (passed.len() - 1) as f64 * MDVEL * factor;
        for a in 0..n {
            let x = |back: usize| trace.dp[(k - back) * n + a] * chain.scale[a];
            let step = (x(0) - 2.0 * x(1) + x(2)).abs() / TA;
            assert!(step <= allowed + 4.0 * noise / TA, "axis {a}, sample {k}: {step} mm/s of {allowed}");
        }
    }
}

/// With ChkMaxVel no axis on a line exceeds maxvel or maxacc.
fn check_axis_limits(chain: &Chain, trace: &Trace, factor: f64) {
    let n = trace.axes;
    for k in 2..trace.len() {
        let entry = trace.entry[k];
        if entry == 0 || trace.entry[k - 2] != entry || chain.placed[entry as usize - 1].curve.radius > 0.0 {
            continue;
        }
        for a in 0..n {
            let x = |back: usize| trace.dp[(k - back) * n + a] * chain.scale[a];
            let noise = 1e-12 * chain.extent();
            let (v, acc) = ((x(0) - x(1)) / TA, (x(0) - 2.0 * x(1) + x(2)) / TA / TA);
            assert!(v.abs() <= MAXVEL * factor + noise / TA, "axis {a}, sample {k}: {v} mm/s");
            assert!(acc.abs() <= MAXACC * factor * factor + 4.0 * noise / TA / TA, "axis {a}, sample {k}: {acc} mm/s²");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    // shows: kernel.override.during-profile, kernel.override.trajectory-synchronous, spool.override-synchronous
    // shows: pcap.wrtrovr.during-path, pcap.utrovr
    #[test]
    fn set_points_lie_on_the_path_at_any_override(
        chain in prop_oneof![3 => chain(20), 1 => chain_in_space(20)],
        mode in 0..MODES.len(),
        nfrax in prop_oneof![Just(0), 1..64u32],
        schedule in prop::collection::vec((1u64..300, 0.05..1.5f64, 0.0..0.4f64), 1..8),
    ) {
        let mut m = mcu_of(chain.machine(), MODES[mode]);
        m.registers_mut().nfrax = AxisSet(nfrax);
        for n in 0..chain.placed.len() {
            prop_assert_eq!(chain.enter(&mut m, n), Entered::Yes);
        }
        let all = m.all_axes();
        m.ssms(all);
        let mut travelled = 0.0;
        for (samples, factor, seconds) in schedule.into_iter().cycle().take(1000).chain([(100_000, 1.0, 0.0)]) {
            give(&mut m, factor, seconds);
            let mut trace = Trace::default();
            let advanced = m.advance(samples, &mut trace);
            travelled = chain.follow(&trace, travelled).last().copied().unwrap_or(travelled);
            if advanced.stop == Stop::Finished {
                break;
            }
        }
        ends(&m, &chain);
        close(travelled, chain.placed.iter().map(|b| b.curve.length).sum(), 1e-9 * chain.extent());
    }

    /// At a constant factor up to 1 (design D18) no path acceleration and no speed on an arc beyond their limits.
    #[test]
    fn path_dynamics_are_kept(
        chain in chain(20),
        mode in prop_oneof![Just(LOOKAHEAD), Just(S), Just(CHECKED), Just(MODES[4])],
        jerkrel in 0.0..1.0f64,
        factor in prop_oneof![Just(1.0), 0.2..1.0f64],
    ) {
        let mut m = chain.spooled_on(chain.machine_with(jerkrel), mode);
        give(&mut m, factor, 0.0);
        let trace = run(&mut m);
        let lengths = chain.follow(&trace, 0.0);
        let over = if mode.has(ModeReg::SProfile) { 1.0 + jerkrel } else { 1.0 };
        check_path_dynamics(&chain, &trace, &lengths, factor, over);
        check_axis_steps(&chain, &trace, factor, over);
        if mode.has(ModeReg::ChkMaxVel) {
            check_axis_limits(&chain, &trace, factor);
        }
        ends(&m, &chain);
    }

    /// The speed planned at a junction, times the change of the unit tangent, is no more than mdvel in any axis.
    #[test]
    fn no_junction_steps_by_more_than_mdvel(chain in chain(30), check: bool) {
        let mut m = started(&chain, if check { CHECKED } else { LOOKAHEAD });
        let mut before: Option<(usize, f64)> = None;
        while !m.stands() || before.is_none() {
            m.run(1);
            let Some(mv) = m.current_move(0) else { break };
            let (n, start_v, end_v) = (mv.number as usize - 1, mv.profile.start_v(), mv.profile.end_v);
            if let Some((last, v)) = before && last + 1 == n {
                close(start_v, v, 1e-9 * (1.0 + v));
            }
            for (junction, v) in [(n, start_v), (n + 1, end_v)] {
                let turn = if junction > 0 && junction < chain.placed.len() { chain.turn(junction) } else { vec![1e9] };
                let step = turn.iter().map(|t| t.abs()).filter(|t| *t > 1e-12).fold(0.0, f64::max) * v;
                prop_assert!(step <= MDVEL * (1.0 + 1e-9), "{} mm/s at junction {}", step, junction);
            }
            before = Some((n, end_v));
        }
    }

    /// Splitting lines at random points, into pieces of two samples or more, changes no set point (trapezoid).
    #[test]
    fn split_lines_are_the_lines(
        chain in chain(8),
        cuts in prop::collection::vec(0.0..1.0f64, 1..12),
        schedule in prop::collection::vec((5u64..300, 0.1..1.5f64, 0.0..0.3f64), 1..5),
    ) {
        let split = split(&chain, &cuts);
        let tolerance = 1e-9 * chain.extent();
        let (mut one, mut many) = (started(&chain, LOOKAHEAD), started(&split, LOOKAHEAD));
        for (samples, factor, seconds) in schedule.into_iter().cycle() {
            let mut traces = [Trace::default(), Trace::default()];
            for (m, trace) in [&mut one, &mut many].into_iter().zip(&mut traces) {
                give(m, factor, seconds);
                m.pass(samples, trace);
            }
            for (k, (a, b)) in traces[0].dp.iter().zip(&traces[1].dp).enumerate() {
                let scale = chain.scale[k % chain.axes()];
                prop_assert!((a - b).abs() * scale <= tolerance, "sample {}: {a} is not {b}", k / chain.axes());
            }
            if one.stands() && many.stands() {
                break;
            }
        }
    }

    /// S ramps take the time and the way of the trapezoid (design 4.3), command by command.
    #[test]
    fn s_profiles_take_the_time_of_the_trapezoid(chain in chain(20), jerkrel in 0.0..1.0f64) {
        let durations = |mode: ModeReg| {
            let mut m = chain.spooled_on(chain.machine_with(jerkrel), mode);
            let all = m.all_axes();
            m.ssms(all);
            let mut found = vec![None; chain.placed.len()];
            let mut samples = 0;
            loop {
                m.run(1);
                samples += 1;
                let Some(mv) = m.current_move(0) else { break };
                found[mv.number as usize - 1] = Some(mv.profile.end_t);
            }
            (found, samples)
        };
        let ((plain, samples), (shaped, same)) = (durations(LOOKAHEAD), durations(S));
        prop_assert!(u64::abs_diff(samples, same) <= 1, "{samples} and {same} samples");
        for (a, b) in plain.iter().zip(&shaped) {
            if let (Some(a), Some(b)) = (a, b) {
                close(*a, *b, 1e-9 * a);
            }
        }
    }

    /// At any constant factor the sample time only says how often one looks: with half and a quarter of it the set
    /// points of the same instants are the same.
    #[test]
    fn a_shorter_sample_time_gives_the_same_instants(
        chain in prop_oneof![3 => chain(7), 1 => chain_in_space(7)],
        mode in 0..MODES.len(),
        factor in 0.2..1.5f64,
    ) {
        let sampled = |parts: usize| {
            let mut machine = chain.machine();
            machine.controller.sample_ticks = 20 / parts as u32;
            let mut m = chain.spooled_on(machine, MODES[mode]);
            give(&mut m, factor, 0.0);
            let all = m.all_axes();
            m.ssms(all);
            (parts, m, Trace::default())
        };
        let mut runs = [1, 2, 4].map(sampled);
        while runs.iter().any(|(_, m, _)| !m.stands() || m.samples() == 0) {
            for (parts, m, trace) in &mut runs {
                m.pass(500 * *parts as u64, trace);
            }
            let [(_, _, coarse), fine @ ..] = &runs;
            for (parts, _, fine) in fine {
                let rows = fine.dp.chunks(fine.axes).skip(parts - 1).step_by(*parts);
                for (k, (a, b)) in coarse.dp.chunks(coarse.axes).zip(rows).enumerate() {
                    for ((a, b), scale) in a.iter().zip(b).zip(&chain.scale) {
                        prop_assert!((a - b).abs() * scale <= 1e-9 * chain.extent(), "sample {k}: {a} is not {b}");
                    }
                }
            }
        }
    }

    /// While the factor ramps, the clock is summed in steps of a sample: with half the sample time the distance to
    /// what a very short one gives halves, too.
    #[test]
    fn ramps_of_the_override_converge(from in 0.1..0.6f64, to in 0.8..1.5f64, seconds in 0.2..1.0f64) {
        let at_half_a_second = |ticks: u32| {
            let mut machine = machine("XY");
            machine.controller.sample_ticks = ticks;
            let mut m = mcu_of(machine, EXACT);
            line(&mut m, &[300.0, -100.0], 40.0, 300.0, 0.0);
            give(&mut m, from, 0.0);
            let all = m.all_axes();
            m.ssms(all);
            m.run(u64::from(4000 / ticks));
            give(&mut m, to, seconds);
            m.run(u64::from(8000 / ticks));
            m.rddp(0)
        };
        let exact = at_half_a_second(1);
        let off: Vec<f64> = [20, 10, 5].map(|ticks| (at_half_a_second(ticks) - exact).abs()).to_vec();
        prop_assert!(off[0] > 1e-6, "the ramp shows: {:?}", off);
        // 19, 9 and 4 ticks away from the exact one
        prop_assert!(off[1] <= 0.55 * off[0] && off[2] <= 0.55 * off[1], "{:?}", off);
    }
}

/// The chain with its lines cut at those shares, as far as every piece takes two samples or more.
fn split(chain: &Chain, cuts: &[f64]) -> Chain {
    let mut placed = Vec::new();
    for (n, b) in chain.placed.iter().enumerate() {
        let mut shares: Vec<f64> = cuts.iter().map(|c| (c + n as f64 * 0.37).fract()).collect();
        shares.sort_by(f64::total_cmp);
        let least = 2.0 * TA * b.element.vl / b.curve.length;
        let mut from = 0.0;
        for share in shares.into_iter().chain([1.0]) {
            let is_line = b.curve.radius == 0.0;
            if share < 1.0 && (!is_line || share - from < least || 1.0 - share < least) {
                continue;
            }
            let whole = from == 0.0 && share == 1.0;
            let mut piece = b.clone();
            if !whole {
                let end = if share == 1.0 { b.curve.at(1.0) } else { b.curve.at(share) };
                piece.curve.start = b.curve.at(from);
                piece.curve.drift = end.iter().zip(&piece.curve.start).map(|(e, s)| e - s).collect();
                piece.curve.length *= share - from;
            }
            piece.element.goes_on |= share < 1.0;
            placed.push(piece);
            from = share;
        }
    }
    Chain { scale: chain.scale.clone(), placed }
}

/// The oracle notices: a set point a little off, one of another element, and one that runs back.
#[test]
fn the_oracle_notices_what_is_wrong() {
    let arc = Shape::Arc { towards: 0.3, radius: 4.0, phi: 200.0, further: vec![3.0] };
    let corner = Shape::Line { direction: vec![1.0, 2.0, -0.5] };
    let element = |shape: Shape| Element {
        order: vec![0, 2, 1],
        shape,
        length: 10.0,
        smooth: false,
        vl: 40.0,
        ac: 500.0,
        goes_on: true,
    };
    let chain = Chain::new(3, 0.0, &[element(corner), element(arc)]);
    let mut m = chain.spooled(LOOKAHEAD);
    let trace = run(&mut m);
    assert_eq!(m.errorreg(), ErrorReg(0));
    let notices = |change: &dyn Fn(&mut Trace)| {
        let mut changed = trace.clone();
        change(&mut changed);
        std::panic::catch_unwind(|| chain.follow(&changed, 0.0)).is_err()
    };
    assert!(!notices(&|_| ()));
    let middle = trace.entry.iter().position(|e| *e == 2).expect("the arc") + 100;
    for k in [30, middle] {
        for a in 0..3 {
            assert!(notices(&|t| t.dp[k * 3 + a] += 1e-7));
        }
        assert!(notices(&|t| t.entry[k] = 3 - t.entry[k]));
        assert!(notices(&|t| (0..3).for_each(|a| t.dp[k * 3 + a] = t.dp[(k - 5) * 3 + a])));
    }
}
