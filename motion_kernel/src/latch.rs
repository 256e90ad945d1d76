//! Signals of single axes and latched positions: index and strobe (4.4.52), lps (4.4.27), LP inputs (4.4.82), index
//! latch (4.4.83). Strobe inputs and the index latch inside a sample, between the positions of two samples.

use crate::axes::AxisSet;
use crate::homing::Search;
use crate::machine::{self, Machine};
use crate::mcu::Mcu;
use crate::plant::whole;
use crate::registers::{Axst, Digi};

/// Ways to latch a position, in ascending priority (errata 4.4.82).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum By {
    #[default]
    Input,
    Lps,
    Strobe,
}

/// Index of the digital input that latches axis 0 in real time; those of axes 1 and 2 follow.
pub(crate) const FIRST_STROBE: usize = 13;
pub(crate) const STROBES: usize = 3;

/// Signals, latches and compensation of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Signals {
    /// Bits 16 to 23 of its digi word.
    pub digi: Digi,
    lp: f64,
    lpndx: f64,
    /// Sample and way of the last latch: the highest of a sample counts.
    latched: (u64, By),
    /// lps: samples between two latches, and until the next.
    every: u32,
    left: u32,
    index: Option<IndexTrack>,
    /// The index became active in this sample.
    pub index_edge: bool,
    pub search: Option<Search>,
    pub backlash: crate::offsets::Backlash,
}

/// Where the index pulses are, in counts of the machine.
#[derive(Clone, Copy, Debug)]
struct IndexTrack {
    position: i64,
    period: i64,
    width: i64,
    inverted: bool,
    /// Counts a sample ago.
    before: i64,
}

impl IndexTrack {
    fn new(index: &machine::Index, counts_per_unit: f64, counts: i64) -> Self {
        IndexTrack {
            position: whole(index.position * counts_per_unit),
            period: whole(index.period * counts_per_unit),
            width: whole(index.width * counts_per_unit).max(1),
            inverted: index.inverted,
            before: counts,
        }
    }
    fn is_active(&self, counts: i64) -> bool {
        let inside = counts.saturating_sub(self.position);
        let inside = if self.period > 0 { inside.rem_euclid(self.period) } else { inside };
        (0..self.width).contains(&inside) != self.inverted
    }
    /// The last place between two positions where the signal became active.
    fn activation(&self, from: i64, to: i64) -> Option<i64> {
        let rises = to > from;
        // upwards a pulse begins at its first count, downwards at its last; an inverted one beside them
        let offset = match (rises, self.inverted) {
            (true, false) => 0,
            (false, false) => self.width - 1,
            (true, true) => self.width,
            (false, true) => -1,
        };
        let base = self.position.saturating_add(offset);
        let place = if self.period == 0 {
            base
        } else if rises {
            base.saturating_add(to.saturating_sub(base).div_euclid(self.period).saturating_mul(self.period))
        } else {
            let periods = -base.saturating_sub(to).div_euclid(self.period);
            base.saturating_add(periods.saturating_mul(self.period))
        };
        let passed = if rises { from < place && place <= to } else { to <= place && place < from };
        passed.then_some(place)
    }
}

impl Signals {
    pub fn of(machine: &Machine, loops: &[crate::position_loop::PositionLoop]) -> Vec<Signals> {
        let signals = machine.axes.iter().zip(loops).map(|(axis, position_loop)| {
            let counts = position_loop.machine_counts();
            let index = axis.equipment.index.as_ref();
            let index = index.map(|index| IndexTrack::new(index, axis.counts_per_unit, counts));
            let mut digi = Digi::default();
            digi.put(Digi::index, index.is_some_and(|index| index.is_active(counts)));
            let backlash = crate::offsets::Backlash::of(axis);
            Signals { digi, index, backlash, ..Signals::default() }
        });
        signals.collect()
    }
    pub fn has_index(&self) -> bool {
        self.index.is_some()
    }
}

impl Mcu {
    /// Latches the actual position every `mst` samples (lps); 0 ends it.
    pub fn lps(&mut self, axis: usize, mst: u32) {
        (self.signals[axis].every, self.signals[axis].left) = (mst, mst);
        let one = AxisSet::single(axis);
        self.attend_to(|attention| {
            let latching = attention.latching.without(one);
            attention.latching = if mst > 0 { latching.union(one) } else { latching };
        });
    }
    /// The latched position, axis units (rdlp); reading clears lpsf.
    pub fn rdlp(&mut self, axis: usize) -> f64 {
        self.set_status(axis, Axst::lpsf, false);
        self.signals[axis].lp
    }
    /// The same without clearing anything (rdap).
    pub fn latched(&self, axis: usize) -> f64 {
        self.signals[axis].lp
    }
    /// Sets the latched position (wrlp).
    pub fn wrlp(&mut self, axis: usize, lp: f64) -> bool {
        let ok = lp.is_finite();
        if ok {
            self.signals[axis].lp = lp;
        }
        ok
    }
    /// The position latched by the index, axis units (rdlpndx).
    pub fn rdlpndx(&self, axis: usize) -> f64 {
        self.signals[axis].lpndx
    }
    /// Sets it (wrlpndx).
    pub fn wrlpndx(&mut self, axis: usize, lp: f64) -> bool {
        let ok = lp.is_finite();
        if ok {
            self.signals[axis].lpndx = lp;
        }
        ok
    }

    fn latch(&mut self, a: usize, by: By, position: f64) {
        let signals = &mut self.signals[a];
        if signals.latched.0 == self.sample && signals.latched.1 > by {
            return;
        }
        (signals.lp, signals.latched) = (position, (self.sample, by));
    }

    pub(crate) fn latch_in_step(&mut self, a: usize) {
        self.signals[a].left -= 1;
        if self.signals[a].left == 0 {
            self.signals[a].left = self.signals[a].every;
            self.latch(a, By::Lps, self.loops[a].rp());
            self.set_status(a, Axst::lpsf, true);
        }
    }

    /// Inputs that have become active, at this fraction of the last sample: strobes latch there, LP inputs take the
    /// position of the sample.
    pub(crate) fn latch_inputs(&mut self, risen: u32, fraction: f64) {
        for a in 0..self.axes.len() {
            if self.axis_inputs.get(a).is_some_and(|inputs| risen & inputs.latch != 0) {
                self.latch(a, By::Input, self.loops[a].rp());
                self.set_status(a, Axst::lpsf, true);
            }
            if a < STROBES && risen >> (FIRST_STROBE + a) & 1 == 1 {
                self.strobe(a, fraction);
            }
        }
    }
    /// The strobe of an axis at this fraction of the last sample.
    pub(crate) fn strobe(&mut self, a: usize, fraction: f64) {
        if a >= self.axes.len() {
            return;
        }
        self.latch(a, By::Strobe, self.counts_at(a, fraction) as f64 * self.loops[a].unit_per_count);
        self.signals[a].digi.set(Digi::strobe);
        if a == 0 {
            self.record_strobe(fraction);
        }
    }

    /// Level, stored edge and latch of the index.
    pub(crate) fn watch_index(&mut self, a: usize) {
        let position_loop = &self.loops[a];
        let signals = &mut self.signals[a];
        let Some(index) = &mut signals.index else { return };
        let counts = position_loop.machine_counts();
        let from = std::mem::replace(&mut index.before, counts);
        if position_loop.special.cut {
            signals.index_edge = false;
            return;
        }
        signals.digi.put(Digi::index, index.is_active(counts));
        let activation = index.activation(from, counts);
        signals.index_edge = activation.is_some();
        if let Some(place) = activation {
            signals.digi.set(Digi::index_edge);
            signals.lpndx = position_loop.coordinate_of(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every place where the signal becomes active on the way, count by count.
    fn walked(track: &IndexTrack, from: i64, to: i64) -> Option<i64> {
        let step = if to > from { 1 } else { -1 };
        let (mut at, mut last) = (from, None);
        while at != to {
            let was = track.is_active(at);
            at += step;
            if track.is_active(at) && !was {
                last = Some(at);
            }
        }
        last
    }

    #[test]
    fn activations_are_those_of_a_walk_over_all_counts() {
        for period in [0, 7, 20] {
            for inverted in [false, true] {
                let track = IndexTrack { position: 3, period, width: 4, inverted, before: 0 };
                for from in -45..45 {
                    for to in -45..45 {
                        assert_eq!(track.activation(from, to), walked(&track, from, to), "{track:?} {from} {to}");
                    }
                }
            }
        }
    }
}
