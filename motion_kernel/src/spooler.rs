//! The spooler of an axis (2.2.8.2) and the moves its entries share.
//!
//! What the axes of an interpolation have in common (length, plan) lives once in [`Moves`]; an entry of a
//! spooler refers to it and carries the course of its own axis. Everything is allocated at start-up.

use crate::axes::AxisSet;
use crate::cause::Limits;
use crate::path::Component;
use crate::profile::Profile;
use std::collections::VecDeque;
use std::ops::{Index, IndexMut};

/// No slot.
pub const NONE: u32 = u32::MAX;

/// Spool memory of an entry in bytes (design D3). Documented for `lsm`; no promise between versions (4.4.84).
pub const BYTES_LINEAR: u32 = 96;
pub const BYTES_CIRCLE: u32 = 128;
pub const BYTES_FUNCTION: u32 = 32;
/// A block of positions (spd) takes this for itself, and so much for each position.
pub const BYTES_POINTS: u32 = 32;
pub const BYTES_POINT: u32 = 8;

/// What an interpolation is for all its axes.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    pub axes: AxisSet,
    /// Number of the motion command in order of execution, and its source line.
    pub number: u32,
    pub line: u32,
    pub rapid: bool,
    /// A direct command (mla, mca, mha ...), not from the spooler.
    pub direct: bool,
    /// A 3-D circle: the look-ahead leaves it as it is programmed (6.3.1.5, bit 0).
    pub plain: bool,
    /// `sstvl` set its target velocity: what comes next may go on with it (4.4.122).
    pub passes: bool,
    /// PcapIndex that its axes show while they execute it.
    pub pcap_index: Option<i32>,
    /// Path velocity of the command, before any limit.
    pub programmed_v: f64,
    /// Length of the whole geometry; this entry travels from `from` to `to` of it (a feed hold cuts moves).
    pub length: f64,
    pub from: f64,
    pub to: f64,
    pub curvature: f64,
    /// Path velocity, acceleration, target velocity after the limits of the axes; the smallest jerkrel.
    pub vl: f64,
    pub ac: f64,
    pub tvl: f64,
    pub jerkrel: f64,
    /// Set when the first axis starts the move; frozen from then on.
    pub planned: bool,
    /// Its plan brakes for `ms` or a hold.
    pub stopping: bool,
    pub profile: Profile,
    /// What limits its velocity (cause.rs).
    pub limits: Limits,
    /// Axes that still hold an entry of it.
    pub users: u32,
    /// Look-ahead: squared speed limit at the start, place in its chain (see lookahead.rs).
    pub junction_v2: f64,
    pub chain: u32,
    pub prefix_v2: f64,
    pub next: u32,
    pub previous: u32,
    pub queue_next: u32,
    pub queue_previous: u32,
}

impl Default for Move {
    /// A move without axes, not planned, in no chain.
    fn default() -> Self {
        Move {
            axes: AxisSet::EMPTY,
            number: 0,
            line: 0,
            rapid: false,
            direct: false,
            plain: false,
            passes: false,
            pcap_index: None,
            programmed_v: 0.0,
            length: 0.0,
            from: 0.0,
            to: 0.0,
            curvature: 0.0,
            vl: 0.0,
            ac: 0.0,
            tvl: 0.0,
            jerkrel: 0.0,
            planned: false,
            stopping: false,
            profile: Profile::default(),
            limits: Limits::default(),
            users: 0,
            junction_v2: 0.0,
            chain: NONE,
            prefix_v2: 0.0,
            next: NONE,
            previous: NONE,
            queue_next: NONE,
            queue_previous: NONE,
        }
    }
}

/// Slab of the moves in all spoolers.
#[derive(Debug, Default)]
pub struct Moves {
    slots: Vec<Move>,
    free: Vec<u32>,
}

impl Moves {
    pub fn with_capacity(capacity: usize) -> Self {
        Moves { slots: Vec::with_capacity(capacity), free: Vec::with_capacity(capacity) }
    }
    /// Stores a move. The slab is as large as all spoolers together, so it does not grow in a sample.
    #[inline]
    pub fn add(&mut self, mv: Move) -> u32 {
        let slot = self.free.pop().unwrap_or_else(|| {
            self.slots.push(Move::default());
            (self.slots.len() - 1) as u32
        });
        self.slots[slot as usize] = mv;
        slot
    }
    /// One axis lets go; true if it was the last and the slot is free again.
    pub fn release(&mut self, slot: u32) -> bool {
        let mv = &mut self[slot];
        mv.users -= 1;
        if mv.users == 0 {
            self.free.push(slot);
            return true;
        }
        false
    }
    /// Slots in use.
    pub fn live(&self) -> usize {
        self.slots.len() - self.free.len()
    }
}

impl Index<u32> for Moves {
    type Output = Move;
    #[inline]
    fn index(&self, slot: u32) -> &Move {
        &self.slots[slot as usize]
    }
}
impl IndexMut<u32> for Moves {
    #[inline]
    fn index_mut(&mut self, slot: u32) -> &mut Move {
        &mut self.slots[slot as usize]
    }
}

/// A spool special function (4.4.123) as entered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Function {
    pub command: u16,
    pub value: f64,
    pub line: u32,
    /// PcapIndex that the axis shows from its execution on (ssfi).
    pub pcap_index: Option<i32>,
}

/// A block of set points, one for each sample (spd, 4.4.117); the values wait in [`Spooler::take_point`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Points {
    pub count: u32,
    /// Distances from where the block begins (spdr).
    pub relative: bool,
    /// PcapIndex of the first point; it counts on with the points (spda, spdr).
    pub pcap_index: Option<i32>,
}

/// One entry of an axis' spooler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Entry {
    Move {
        slot: u32,
        component: Component,
    },
    Function(Function),
    Points(Points),
    /// Where a feed hold comes to rest; what follows waits for `resume` (hold.rs). Takes no memory.
    HoldPoint,
}

impl Entry {
    pub const fn bytes(&self) -> u32 {
        match self {
            Entry::Move { component, .. } if component.is_circle() => BYTES_CIRCLE,
            Entry::Move { .. } => BYTES_LINEAR,
            Entry::Function(_) => BYTES_FUNCTION,
            Entry::Points(points) => BYTES_POINTS + points.count * BYTES_POINT,
            Entry::HoldPoint => 0,
        }
    }
}

/// Whether a spooler is being processed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpoolState {
    /// Direct mode: entries wait for `ssms`.
    #[default]
    Direct,
    Running,
    /// After `sstps`, or in ssf 1000: `ssms` goes on.
    Stopped,
    Halted,
    /// Feed hold: only `resume` goes on.
    Held,
}

/// The queue of one axis.
#[derive(Debug)]
pub struct Spooler {
    ring: VecDeque<Entry>,
    /// Values of the blocks of positions, in their order, those of the block being executed first.
    points: VecDeque<f64>,
    memory: u32,
    used: u32,
    moves: u32,
    pub state: SpoolState,
}

impl Spooler {
    pub fn new(memory: u32) -> Self {
        let most = (memory / BYTES_FUNCTION) as usize + 2;
        let points = VecDeque::new(); // grows in commands of the application only, which stand between samples
        Spooler { ring: VecDeque::with_capacity(most), points, memory, used: 0, moves: 0, state: SpoolState::Direct }
    }
    /// Free memory in bytes (lsm, 4.4.84).
    pub fn left(&self) -> u32 {
        self.memory.saturating_sub(self.used)
    }
    /// Motion commands waiting (mcis, 4.4.87).
    pub fn moves(&self) -> u32 {
        self.moves
    }
    pub fn is_empty(&self) -> bool {
        self.ring.is_empty()
    }
    pub fn len(&self) -> usize {
        self.ring.len()
    }
    /// Appends; the caller has checked [`Spooler::left`].
    pub fn push(&mut self, entry: Entry) {
        self.account(&entry, true);
        self.ring.push_back(entry);
    }
    /// Appends a block of positions.
    pub fn push_points(&mut self, points: Points, values: &[f64]) {
        self.push(Entry::Points(points));
        self.points.extend(values);
    }
    /// The next position of the block being executed.
    pub fn take_point(&mut self) -> Option<f64> {
        self.points.pop_front()
    }
    /// Drops the positions of a block that is broken off; all entries behind it are gone.
    pub fn drop_points(&mut self) {
        self.points.clear();
    }
    /// Puts an entry before all others (a feed hold puts back what it cut).
    pub fn push_front(&mut self, entry: Entry) {
        self.account(&entry, true);
        self.ring.push_front(entry);
    }
    pub fn pop(&mut self) -> Option<Entry> {
        let entry = self.ring.pop_front()?;
        self.account(&entry, false);
        Some(entry)
    }
    /// Takes an entry out of the queue.
    pub fn remove(&mut self, index: usize) -> Option<Entry> {
        let entry = self.ring.remove(index)?;
        self.account(&entry, false);
        Some(entry)
    }
    pub fn insert(&mut self, index: usize, entry: Entry) {
        self.account(&entry, true);
        self.ring.insert(index, entry);
    }
    pub fn pop_back(&mut self) -> Option<Entry> {
        let entry = self.ring.pop_back()?;
        self.account(&entry, false);
        if let Entry::Points(points) = entry {
            self.points.truncate(self.points.len().saturating_sub(points.count as usize));
        }
        Some(entry)
    }
    /// Positions get another number of axis units (gear.rs).
    pub(crate) fn convert(&mut self, ratio: f64) {
        for entry in &mut self.ring {
            if let Entry::Move { component, .. } = entry {
                component.convert(ratio);
            }
        }
        self.points.iter_mut().for_each(|x| *x *= ratio);
    }
    pub fn entries(&self) -> &VecDeque<Entry> {
        &self.ring
    }
    pub fn entry_mut(&mut self, index: usize) -> Option<&mut Entry> {
        self.ring.get_mut(index)
    }
    fn account(&mut self, entry: &Entry, enters: bool) {
        let (bytes, moves) = (entry.bytes(), u32::from(matches!(entry, Entry::Move { .. } | Entry::Points(_))));
        if enters {
            self.used += bytes;
            self.moves += moves;
        } else {
            self.used -= bytes;
            self.moves -= moves;
        }
    }
}
