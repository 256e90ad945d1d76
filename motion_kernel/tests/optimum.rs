//! Look-ahead is optimal: junction speeds against brute force, for all that is visible when a move starts.

mod common;

use common::chain::*;
use common::*;
use motion_kernel::Mcu;
use motion_kernel::registers::{ErrorReg, ModeReg};
use proptest::prelude::*;
use std::collections::BTreeMap;

const CHECKED: ModeReg = ModeReg(LOOKAHEAD.0 | 1 << 7);
const MDVEL: f64 = 0.5;
const MAXVEL: f64 = 200.0;
const MAXACC: f64 = 1000.0;

/// What limits a chain, from its geometry alone.
struct Limits {
    /// Highest squared speed at the start of each element, and at its end when nothing follows.
    junction_v2: Vec<f64>,
    /// Path velocity, acceleration, length and programmed target velocity of each.
    vl: Vec<f64>,
    ac: Vec<f64>,
    length: Vec<f64>,
    tvl: Vec<f64>,
}

fn limits(chain: &Chain, check: bool) -> Limits {
    let mut found = Limits { junction_v2: vec![], vl: vec![], ac: vec![], length: vec![], tvl: vec![] };
    for (n, Placed { curve, element }) in chain.placed.iter().enumerate() {
        let share = curve.tangent(0.0).iter().fold(0.0, |most: f64, t| most.max(t.abs()));
        let (vl, ac) = match (curve.radius > 0.0, check) {
            (true, _) => (element.vl.min((curve.radius * MAXACC).sqrt()), element.ac),
            (false, true) => (element.vl.min(MAXVEL / share), element.ac.min(MAXACC / share)),
            (false, false) => (element.vl, element.ac),
        };
        let tvl = if element.goes_on && n + 1 < chain.placed.len() { element.vl } else { 0.0 };
        let turn = if n == 0 { 0.0 } else { chain.turn(n).iter().fold(0.0, |most: f64, t| most.max(t.abs())) };
        let corner = if turn > 1e-12 { MDVEL / turn } else { f64::INFINITY };
        let before = if n == 0 { 0.0 } else { f64::min(found.tvl[n - 1], found.vl[n - 1]) };
        found.junction_v2.push(corner.min(before).min(vl).powi(2));
        found.vl.push(vl);
        found.ac.push(ac);
        found.length.push(curve.length);
        found.tvl.push(tvl);
    }
    found
}

impl Limits {
    fn gain_v2(&self, n: usize) -> f64 {
        2.0 * self.ac[n] * self.length[n]
    }
    /// Highest squared speed at the start of element `first` when the elements up to `last` are known and nothing is
    /// behind them: every limit ahead, one by one, with standstill at the end if `stops`.
    fn reachable(&self, first: usize, last: usize, stops: bool) -> f64 {
        let (mut most, mut way) = (f64::INFINITY, 0.0);
        for n in first..last {
            most = most.min(self.junction_v2[n] + way);
            way += self.gain_v2(n);
        }
        if stops { most.min(way) } else { most }
    }
    /// Shortest time for element `n` between two squared speeds; None if its acceleration does not allow it.
    fn time(&self, n: usize, v2: f64, w2: f64) -> Option<f64> {
        let (gain, slack) = (self.gain_v2(n), 1e-9 * (1.0 + v2 + w2));
        if (v2 - w2).abs() > gain + slack {
            return None;
        }
        let top = (0.5 * (v2 + w2 + gain)).max(v2).max(w2).sqrt().min(self.vl[n]);
        let ramps = (2.0 * top * top - v2 - w2) / (2.0 * self.ac[n]);
        Some((2.0 * top - v2.sqrt() - w2.sqrt()) / self.ac[n] + (self.length[n] - ramps).max(0.0) / top)
    }
}

/// Start and end speed of the moves that the kernel is seen in, by index. `each` runs before every sample.
fn planned(m: &mut Mcu, mut each: impl FnMut(&mut Mcu)) -> BTreeMap<usize, (f64, f64)> {
    let mut speeds = BTreeMap::new();
    let all = m.all_axes();
    each(m);
    m.ssms(all);
    loop {
        m.run(1);
        match m.current_move(0) {
            Some(mv) => speeds.insert(mv.number as usize - 1, (mv.profile.start_v(), mv.profile.end_v)),
            None => return speeds,
        };
        each(m);
    }
}

#[track_caller]
fn same(v: f64, v2: f64) {
    close(v, v2.sqrt(), 1e-9 * (1e-3 + v));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    /// A dynamic program over the time: of all combinations of junction speeds (a grid of them, and those planned) none
    /// takes less time than the speeds planned, and the best one is the planned one.
    // shows: pcap.wrmdvel.effect, pcap.rdmdvel.use, pcap.wrmdvel.enable
    #[test]
    fn no_choice_of_junction_speeds_takes_less_time(chain in chain(9), check: bool) {
        let limits = limits(&chain, check);
        let n = chain.placed.len();
        let seen = planned(&mut chain.spooled(if check { CHECKED } else { LOOKAHEAD }), |_| ());
        let mut candidates: Vec<Vec<f64>> = Vec::new();
        for k in 0..=n {
            let of_kernel = [seen.get(&k).map(|v| v.0), k.checked_sub(1).and_then(|k| seen.get(&k)).map(|v| v.1)];
            let most = if k == 0 || k == n { 0.0 } else { limits.junction_v2[k] };
            let mut row: Vec<f64> = (0..=24).map(|i| most * f64::from(i) / 24.0).collect();
            // a junction between two moves shorter than a sample is not seen: its best speed by the closed form
            let mut best = 0.0;
            for k in 1..=k.min(n - 1) {
                best = f64::min(best + limits.gain_v2(k - 1), limits.reachable(k, n, true));
            }
            row.push(if k == n { 0.0 } else { best });
            row.extend(of_kernel.into_iter().flatten().map(|v| v * v));
            candidates.push(row);
        }
        // least time to each candidate, and where it came from
        let mut least: Vec<Vec<(f64, usize)>> = vec![vec![(0.0, 0); candidates[0].len()]];
        for k in 0..n {
            let reach = |w2: f64| {
                let from = candidates[k].iter().zip(&least[k]).enumerate();
                let times = from.filter_map(|(i, (v2, (t, _)))| Some((t + limits.time(k, *v2, w2)?, i)));
                times.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
            };
            least.push(candidates[k + 1].iter().map(|w2| reach(*w2)).collect());
        }
        let mut at = 0;
        for k in (1..=n).rev() {
            if k < n {
                let v2 = candidates[k][at];
                if let Some((start_v, _)) = seen.get(&k) {
                    same(*start_v, v2);
                }
                if let Some((_, end_v)) = seen.get(&(k - 1)) {
                    same(*end_v, v2);
                }
            }
            at = least[k][at].1;
        }
    }

    /// With LookAheadDepth, and with moves that come while others run, each move ends with the highest speed from which
    /// the visible ones can stop. SpoolerDeepToLess says when the end of the spooler, and not that of the window, decided.
    #[test]
    fn the_plan_is_the_optimum_of_the_visible_window(
        chain in chain(30),
        check: bool,
        depth in prop_oneof![Just(0u32), 1..8u32],
        feed in prop::collection::vec((0..3usize, 0..4usize), 1..20),
        ahead in prop_oneof![Just(1000usize), 1..5usize],
    ) {
        let limits = limits(&chain, check);
        let n = chain.placed.len();
        let mut m = mcu_of(chain.machine(), if check { CHECKED } else { LOOKAHEAD });
        m.registers_mut().lookahead_depth = depth;
        // known[i]: how many moves were spooled when move i was planned
        let (mut spooled, mut known, mut feed) = (0, vec![0; n], feed.into_iter().cycle());
        let mut reported = BTreeMap::new();
        let seen = planned(&mut m, |m| {
            let now = m.current_move(0).map_or(0, |mv| mv.number as usize);
            if now > 0 {
                reported.insert(now - 1, m.errorreg().has(ErrorReg::SpoolerDeepToLess));
            }
            let (wait, more) = feed.next().expect("endless");
            let room = if spooled <= now { 1 } else { 0 } + if wait == 0 { more } else { 0 };
            for _ in 0..if now == 0 { ahead } else { room } {
                if spooled < n {
                    chain.enter(m, spooled);
                    spooled += 1;
                }
            }
            known[now..].fill(spooled);
        });
        let (mut v2, mut starved) = (0.0, false);
        for i in 0..n {
            let last = if depth == 0 { known[i] } else { known[i].min(i + 1 + depth as usize) };
            let reach = v2 + limits.gain_v2(i);
            let bound = if last > i + 1 { limits.reachable(i + 1, last, true) } else { 0.0 };
            let goes_on = last == known[i] && limits.tvl[last - 1] > 0.0;
            let free = if last > i + 1 { limits.reachable(i + 1, last, false) } else { f64::INFINITY };
            starved |= goes_on && bound.min(reach) < free.min(reach);
            if let Some(&(start_v, end_v)) = seen.get(&i) {
                same(start_v, v2);
                same(end_v, bound.min(reach));
                prop_assert_eq!(reported[&i], starved, "in move {}", i);
            }
            v2 = bound.min(reach);
        }
    }
}

// shows: errorreg.spooler-deep-to-less
#[test]
fn a_window_that_ends_inside_the_spooler_is_no_lack_of_profiles() {
    let mut m = mcu("X", LOOKAHEAD);
    m.registers_mut().lookahead_depth = 2;
    for n in 1..=10 {
        line(&mut m, &[f64::from(n) * 0.5], 50.0, 500.0, 50.0);
    }
    let all = m.all_axes();
    m.ssms(all);
    let mut reported = BTreeMap::new();
    loop {
        m.run(1);
        let Some(mv) = m.current_move(0) else { break };
        reported.insert(mv.number, m.errorreg().has(ErrorReg::SpoolerDeepToLess));
    }
    // the window of move 8 reaches the end of the spooler, whose last move would go on
    assert!(reported.iter().all(|(number, reported)| *reported == (*number >= 8)), "{reported:?}");
}

/// The work of the planning, in moves looked at, is a few per entry: however they come, whatever the window is, also
/// when the whole spooler is deleted from behind.
#[test]
fn planning_costs_a_few_steps_per_entry() {
    const N: u32 = 20_000;
    let speed = |n: u32| 10.0 + f64::from(n.wrapping_mul(2_654_435_761) >> 16 & 63);
    let spoolers = |depth: u32| {
        let mut machine = machine("X");
        machine.controller.spool_memory_bytes = 96 * (N + 1);
        let mut m = mcu_of(machine, LOOKAHEAD);
        m.registers_mut().lookahead_depth = depth;
        m
    };
    let enter = |m: &mut Mcu, n: u32| line(m, &[f64::from(n + 1) * 0.1], speed(n), 500.0, speed(n));
    let go_on = |m: &mut Mcu| {
        for _ in 0..500 {
            m.run(1000);
            if m.stands() {
                return;
            }
        }
        panic!("still under way");
    };
    let all = set(&[0]);
    for depth in [0, 1, 50, 10_000] {
        // all at once
        let mut m = spoolers(depth);
        (0..N).for_each(|n| _ = enter(&mut m, n));
        m.ssms(all);
        go_on(&mut m);
        assert!(m.planning_steps() <= 5 * u64::from(N), "{} for {depth}", m.planning_steps());
        assert!(m.planning_steps() >= u64::from(N) - 1, "it counts");
        // while they run, then deleted in the middle of it, and as many again
        let mut m = spoolers(depth);
        for n in 0..N {
            enter(&mut m, n);
            if n == 100 || n == N / 2 {
                m.ssms(all);
            }
            if n > 100 && n % 4 == 0 {
                m.run(1);
            }
            if n == N / 2 - 1 {
                m.sdels(all);
                m.run(1000);
            }
        }
        go_on(&mut m);
        assert!(m.planning_steps() <= 5 * u64::from(N), "{} for {depth}", m.planning_steps());
    }
}
