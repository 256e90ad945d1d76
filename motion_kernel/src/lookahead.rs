//! Look-ahead (MODEREG bit 0): speeds at the junctions of spooled moves.
//!
//! A chain is a run of moves of the same axes, spooled one after the other. The squared speed at the start
//! of move i may not exceed, for any later junction k, `J_k² + 2·Σ a·L` between them: so with the prefix
//! sums P of `2·a·L` it is `min over k >= i of (J_k² + P_k) − P_i`, with standstill after the last move as
//! the last term. The minimum is kept in a queue of candidates with ascending keys (sliding window minimum,
//! linked through the moves), so a move costs amortised constant time however deep the spooler is. This is
//! the backward pass; the forward pass happens when a move starts and its start speed is known.

use crate::axes::MAX_AXES;
use crate::spooler::{Moves, NONE};

/// Unit tangents per axis in the metric of design D7: travel per path length.
pub type Tangent = [f64; MAX_AXES];

/// A run of moves of the same axes.
#[derive(Clone, Copy, Debug)]
struct Chain {
    /// First move not planned yet, and the newest.
    first: u32,
    last: u32,
    /// Queue of candidates for the minimum.
    front: u32,
    back: u32,
    end_prefix_v2: f64,
    end_tangent: Tangent,
    live: u32,
    planned_since_rebase: u32,
}

/// The bound at the end of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndBound {
    pub v2: f64,
    /// The end of the spooler decided, although its last move would go on (ErrorReg bit 17).
    pub starved: bool,
}

/// All chains of a controller.
#[derive(Debug, Default)]
pub struct Lookahead {
    chains: Vec<Chain>,
    free: Vec<u32>,
}

impl Lookahead {
    pub fn with_capacity(capacity: usize) -> Self {
        Lookahead { chains: Vec::with_capacity(capacity), free: Vec::with_capacity(capacity) }
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
        queue_push(chain, moves, slot);
        &mut chain.end_tangent
    }

    /// Takes `slot` out of what is still to plan and returns the bound at its end.
    pub fn plan(&mut self, moves: &mut Moves, slot: u32, depth: u32) -> EndBound {
        let id = moves[slot].chain as usize;
        let in_order = self.chains[id].first == slot;
        self.unlink(moves, slot);
        let chain = &mut self.chains[id];
        chain.planned_since_rebase += 1;
        if !in_order || chain.planned_since_rebase > chain.live {
            rebuild(chain, moves);
        }
        let chain = &self.chains[id];
        if chain.first == NONE {
            let v2 = if chain.last == slot { passing_v2(moves, slot) } else { 0.0 };
            return EndBound { v2, starved: moves[slot].tvl > 0.0 && !moves[slot].passes };
        }
        bound_at(chain, moves, depth)
    }

    /// A move disappears from a chain before or after it was planned.
    pub fn remove(&mut self, moves: &mut Moves, slot: u32) {
        let id = moves[slot].chain;
        if !moves[slot].planned {
            self.unlink(moves, slot);
            rebuild(&mut self.chains[id as usize], moves);
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
        rebuild(chain, moves);
    }

    /// The first move of the chain of `slot` that is still to plan.
    pub fn first_unplanned(&self, moves: &Moves, slot: u32) -> u32 {
        self.chains[moves[slot].chain as usize].first
    }

    /// Recomputes the sums of the chain of `slot` (a target velocity was changed).
    pub fn refresh(&mut self, moves: &mut Moves, slot: u32) {
        rebuild(&mut self.chains[moves[slot].chain as usize], moves);
    }

    fn new_chain(&mut self) -> u32 {
        let chain = Chain {
            first: NONE,
            last: NONE,
            front: NONE,
            back: NONE,
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
        queue_remove(chain, moves, slot);
    }
}

/// Key of a candidate: squared speed limit at its start, measured from the begin of the chain.
fn key(moves: &Moves, slot: u32) -> f64 {
    moves[slot].junction_v2 + moves[slot].prefix_v2
}

/// Bound at the start of the first unplanned move of a chain.
fn bound_at(chain: &Chain, moves: &Moves, depth: u32) -> EndBound {
    let start_v2 = moves[chain.first].prefix_v2;
    let behind_v2 = if chain.last == NONE { 0.0 } else { passing_v2(moves, chain.last) };
    let (mut least, mut end) = (f64::INFINITY, chain.end_prefix_v2 + behind_v2);
    if depth == 0 {
        least = key(moves, chain.front);
    } else {
        let mut slot = chain.first;
        for _ in 0..depth {
            if slot == NONE {
                break;
            }
            least = least.min(key(moves, slot));
            end = moves[slot].prefix_v2 + 2.0 * moves[slot].ac * (moves[slot].to - moves[slot].from);
            slot = moves[slot].next;
        }
        end += if slot == NONE { behind_v2 } else { 0.0 };
    }
    let goes_on = chain.last != NONE && moves[chain.last].tvl > 0.0 && !moves[chain.last].passes;
    EndBound { v2: (least.min(end) - start_v2).max(0.0), starved: goes_on && end < least }
}

/// Squared velocity after the last move of a chain: 0, but for `sstvl` (4.4.122).
fn passing_v2(moves: &Moves, last: u32) -> f64 {
    let mv = &moves[last];
    if mv.passes { mv.tvl.clamp(0.0, mv.vl).powi(2) } else { 0.0 }
}

/// Sums from 0 again, so that they keep their precision, and the queue of candidates anew.
fn rebuild(chain: &mut Chain, moves: &mut Moves) {
    (chain.front, chain.back, chain.planned_since_rebase) = (NONE, NONE, 0);
    let (mut slot, mut prefix_v2) = (chain.first, 0.0);
    while slot != NONE {
        let mv = &mut moves[slot];
        mv.prefix_v2 = prefix_v2;
        prefix_v2 += 2.0 * mv.ac * (mv.to - mv.from);
        let next = mv.next;
        queue_push(chain, moves, slot);
        slot = next;
    }
    chain.end_prefix_v2 = prefix_v2;
}

/// A later candidate with a smaller key makes all larger ones before it superfluous.
fn queue_push(chain: &mut Chain, moves: &mut Moves, slot: u32) {
    let new_key = key(moves, slot);
    while chain.back != NONE && key(moves, chain.back) >= new_key {
        let back = chain.back;
        chain.back = moves[back].queue_previous;
        (moves[back].queue_previous, moves[back].queue_next) = (NONE, NONE);
    }
    (moves[slot].queue_previous, moves[slot].queue_next) = (chain.back, NONE);
    if chain.back == NONE {
        chain.front = slot
    } else {
        moves[chain.back].queue_next = slot
    }
    chain.back = slot;
}

fn queue_remove(chain: &mut Chain, moves: &mut Moves, slot: u32) {
    let (next, previous) = (moves[slot].queue_next, moves[slot].queue_previous);
    if chain.front == slot {
        chain.front = next;
    } else if previous == NONE {
        return; // superseded earlier, no longer in the queue
    }
    if chain.back == slot {
        chain.back = previous;
    }
    if next != NONE {
        moves[next].queue_previous = previous;
    }
    if previous != NONE {
        moves[previous].queue_next = next;
    }
    (moves[slot].queue_next, moves[slot].queue_previous) = (NONE, NONE);
}
