//! Look-ahead (MODEREG bit 0): speeds at the junctions of spooled moves.
//!
//! A chain is a run of moves of the same axes, spooled one after the other. The squared speed at the start
//! of move i may not exceed, for any later junction k, `J_k² + 2·Σ a·L` between them: so with the prefix
//! sums P of `2·a·L` it is `min over k >= i of (J_k² + P_k) − P_i`, with standstill after the last move as
//! the last term. The minimum is kept in a queue of candidates with ascending keys (sliding window minimum,
//! linked through the moves), so a move costs amortised constant time however deep the spooler is. The window
//! is all that is spooled, or LookAheadDepth moves of it. This is the backward pass; the forward pass happens
//! when a move starts and its start speed is known.

use crate::axes::MAX_AXES;
use crate::cause::{Cause, Limit};
use crate::spooler::{Move, Moves, NONE};

/// Unit tangents per axis in the metric of design D7: travel per path length.
pub type Tangent = [f64; MAX_AXES];

/// A run of moves of the same axes.
#[derive(Clone, Copy, Debug)]
struct Chain {
    /// First move not planned yet, and the newest.
    first: u32,
    last: u32,
    /// Queue of candidates for the minimum, the newest move that was in it, and how many moves it covers.
    front: u32,
    back: u32,
    seen_last: u32,
    seen: u32,
    /// Sums and queue do not fit the moves any more.
    stale: bool,
    end_prefix_v2: f64,
    end_tangent: Tangent,
    live: u32,
    planned_since_rebase: u32,
}

/// The bound at the end of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndBound {
    pub v2: f64,
    /// What decided.
    pub limit: Limit,
    /// The end of the spooler decided, although its last move would go on (ErrorReg bit 17).
    pub starved: bool,
}

/// All chains of a controller.
#[derive(Debug, Default)]
pub struct Lookahead {
    chains: Vec<Chain>,
    free: Vec<u32>,
    steps: u64,
}

impl Lookahead {
    pub fn with_capacity(capacity: usize) -> Self {
        Lookahead { chains: Vec::with_capacity(capacity), free: Vec::with_capacity(capacity), steps: 0 }
    }

    /// How many moves the planning has looked at since boot: a measure of its work.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The tangent at the end of the newest move of the chain of `slot`, if that move is `slot`.
    pub fn end_tangent(&self, moves: &Moves, slot: u32) -> Option<&Tangent> {
        let chain = &self.chains[moves[slot].chain as usize];
        (chain.last == slot).then_some(&chain.end_tangent)
    }

    /// Adds a new move behind `after`, or as the first of a new chain. Its `junction_v2` is set. Returns the
    /// tangent at the end of the chain, to be overwritten with that of the new move.
    pub fn append(&mut self, moves: &mut Moves, slot: u32, after: Option<u32>) -> &mut Tangent {
        let id = match after {
            Some(previous) => moves[previous].chain,
            None => self.new_chain(),
        };
        let chain = &mut self.chains[id as usize];
        let mv = &mut moves[slot];
        mv.chain = id;
        mv.prefix_v2 = chain.end_prefix_v2;
        (mv.next, mv.previous) = (NONE, NONE);
        chain.end_prefix_v2 += 2.0 * mv.ac * (mv.to - mv.from);
        chain.live += 1;
        if chain.first == NONE {
            chain.first = slot;
        } else {
            let last = chain.last;
            moves[slot].previous = last;
            moves[last].next = slot;
        }
        chain.last = slot;
        &mut chain.end_tangent
    }

    /// Takes `slot` out of what is still to plan and returns the bound at its end.
    pub fn plan(&mut self, moves: &mut Moves, slot: u32, depth: u32) -> EndBound {
        let id = moves[slot].chain as usize;
        let in_order = self.chains[id].first == slot;
        self.unlink(moves, slot);
        let chain = &mut self.chains[id];
        chain.planned_since_rebase += 1;
        let shrunk = depth > 0 && chain.seen > depth;
        if chain.stale || shrunk || !in_order || chain.planned_since_rebase > chain.live {
            self.steps += rebuild(chain, moves);
        }
        self.steps += extend(chain, moves, depth);
        let chain = &self.chains[id];
        if chain.first == NONE {
            let v2 = if chain.last == slot { passing_v2(moves, slot) } else { 0.0 };
            let starved = moves[slot].tvl > 0.0 && !moves[slot].passes;
            return EndBound { v2, limit: end_limit(&moves[slot]), starved };
        }
        bound_at(chain, moves)
    }

    /// A move disappears from a chain before or after it was planned.
    pub fn remove(&mut self, moves: &mut Moves, slot: u32) {
        let id = moves[slot].chain;
        if !moves[slot].planned {
            self.chains[id as usize].stale = true;
            self.unlink(moves, slot);
        }
        let chain = &mut self.chains[id as usize];
        if chain.last == slot {
            chain.last = NONE;
        }
        chain.live -= 1;
        if chain.live == 0 {
            self.free.push(id);
        }
    }

    /// Puts the rest of a cut move before everything still to plan; it starts from standstill.
    pub fn insert_first(&mut self, moves: &mut Moves, slot: u32, cut: u32) {
        let id = moves[cut].chain;
        let chain = &mut self.chains[id as usize];
        let next = chain.first;
        let mv = &mut moves[slot];
        mv.chain = id;
        mv.junction_v2 = 0.0;
        (mv.next, mv.previous) = (next, NONE);
        if next == NONE {
            chain.last = slot;
        } else {
            moves[next].previous = slot;
        }
        chain.first = slot;
        chain.live += 1;
        chain.stale = true;
    }

    /// The first move of the chain of `slot` that is still to plan.
    pub fn first_unplanned(&self, moves: &Moves, slot: u32) -> u32 {
        self.chains[moves[slot].chain as usize].first
    }

    /// The limits of a move in the chain of `slot` were changed.
    pub fn refresh(&mut self, moves: &Moves, slot: u32) {
        self.chains[moves[slot].chain as usize].stale = true;
    }

    fn new_chain(&mut self) -> u32 {
        let chain = Chain {
            first: NONE,
            last: NONE,
            front: NONE,
            back: NONE,
            seen_last: NONE,
            seen: 0,
            stale: false,
            end_prefix_v2: 0.0,
            end_tangent: [0.0; MAX_AXES],
            live: 0,
            planned_since_rebase: 0,
        };
        if let Some(id) = self.free.pop() {
            self.chains[id as usize] = chain;
            return id;
        }
        self.chains.push(chain);
        (self.chains.len() - 1) as u32
    }

    /// Out of the list of unplanned moves and out of the queue of candidates.
    fn unlink(&mut self, moves: &mut Moves, slot: u32) {
        let chain = &mut self.chains[moves[slot].chain as usize];
        let (next, previous) = (moves[slot].next, moves[slot].previous);
        if previous == NONE {
            chain.first = next
        } else {
            moves[previous].next = next
        }
        if next != NONE {
            moves[next].previous = previous;
        }
        if chain.stale || previous != NONE {
            chain.stale = true;
        } else if chain.seen > 0 {
            leave(chain, moves, slot);
        }
    }
}

/// Key of a candidate: squared speed limit at its start, measured from the begin of the chain.
fn key(moves: &Moves, slot: u32) -> f64 {
    moves[slot].junction_v2 + moves[slot].prefix_v2
}

/// Bound at the start of the first unplanned move of a chain, with standstill at the end of the window.
fn bound_at(chain: &Chain, moves: &Moves) -> EndBound {
    let start_v2 = moves[chain.first].prefix_v2;
    let behind = moves[chain.seen_last].next;
    let least = key(moves, chain.front);
    let (end, last) = match behind {
        NONE if chain.last == NONE => (chain.end_prefix_v2, None),
        NONE => (chain.end_prefix_v2 + passing_v2(moves, chain.last), Some(&moves[chain.last])),
        next => (moves[next].prefix_v2, None),
    };
    let goes_on = last.is_some_and(|last| last.tvl > 0.0 && !last.passes);
    let limit = match last {
        _ if least <= end => moves[chain.front].limits.junction,
        Some(last) => end_limit(last),
        None if behind == NONE => Limit::of(Cause::EndOfSpool),
        None => Limit::of(Cause::Depth),
    };
    EndBound { v2: (least.min(end) - start_v2).max(0.0), limit, starved: goes_on && end < least }
}

/// What limits the speed at the end of the last move of a chain.
fn end_limit(last: &Move) -> Limit {
    Limit::of(match last.tvl {
        _ if last.passes => Cause::TargetVelocity,
        tvl if tvl > 0.0 => Cause::Starved,
        _ => Cause::EndOfSpool,
    })
}

/// Squared velocity after the last move of a chain: 0, but for `sstvl` (4.4.122).
fn passing_v2(moves: &Moves, last: u32) -> f64 {
    let mv = &moves[last];
    if mv.passes { mv.tvl.clamp(0.0, mv.vl).powi(2) } else { 0.0 }
}

/// Sums from 0 again, so that they keep their precision, and an empty queue. Returns the moves looked at.
fn rebuild(chain: &mut Chain, moves: &mut Moves) -> u64 {
    (chain.front, chain.back, chain.planned_since_rebase) = (NONE, NONE, 0);
    (chain.seen_last, chain.seen, chain.stale) = (NONE, 0, false);
    let (mut slot, mut prefix_v2, mut steps) = (chain.first, 0.0, 0);
    while slot != NONE {
        let mv = &mut moves[slot];
        mv.prefix_v2 = prefix_v2;
        prefix_v2 += 2.0 * mv.ac * (mv.to - mv.from);
        slot = mv.next;
        steps += 1;
    }
    chain.end_prefix_v2 = prefix_v2;
    steps
}

/// Takes moves into the queue until it covers `depth` of them, 0: all. Returns the moves looked at.
fn extend(chain: &mut Chain, moves: &mut Moves, depth: u32) -> u64 {
    let mut steps = 0;
    while depth == 0 || chain.seen < depth {
        let slot = if chain.seen_last == NONE { chain.first } else { moves[chain.seen_last].next };
        if slot == NONE {
            break;
        }
        steps += queue_push(chain, moves, slot);
        (chain.seen_last, chain.seen) = (slot, chain.seen + 1);
    }
    steps
}

/// A later candidate with a smaller key makes all larger ones before it superfluous.
fn queue_push(chain: &mut Chain, moves: &mut Moves, slot: u32) -> u64 {
    let (new_key, mut steps) = (key(moves, slot), 1);
    while chain.back != NONE && key(moves, chain.back) >= new_key {
        chain.back = moves[chain.back].queue_previous;
        steps += 1;
    }
    (moves[slot].queue_previous, moves[slot].queue_next) = (chain.back, NONE);
    if chain.back == NONE {
        chain.front = slot
    } else {
        moves[chain.back].queue_next = slot
    }
    chain.back = slot;
    steps
}

/// The first move leaves the window. It is the front of the queue, or was superseded.
fn leave(chain: &mut Chain, moves: &mut Moves, slot: u32) {
    chain.seen -= 1;
    if chain.seen_last == slot {
        chain.seen_last = NONE;
    }
    if chain.front == slot {
        chain.front = moves[slot].queue_next;
        if chain.front == NONE { chain.back = NONE } else { moves[chain.front].queue_previous = NONE }
    }
}
