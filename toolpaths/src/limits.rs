//! How long each cause limited the path velocity: in all, per block, per piece of the plotted path and over time.
//!
//! A cause is a number that the controller records with every sample (16 bits); what it means is not known here. Runs of
//! the same cause are counted as one, so a sample costs a few comparisons.

/// Bits of the controller's flags below the number of the cause.
const SHIFT: u32 = 8;

/// The number of the cause in the flags of a sample; 0 where the controller named none.
#[inline]
pub(crate) fn limit_of(flags: u32) -> u16 {
    (flags >> SHIFT) as u16
}

/// Samples per cause.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally(Vec<(u16, u64)>);

impl Tally {
    fn add(&mut self, limit: u16, samples: u64) {
        match self.0.iter_mut().find(|row| row.0 == limit) {
            Some(row) => row.1 += samples,
            None => self.0.push((limit, samples)),
        }
    }
    fn join(&mut self, other: &Tally) {
        other.0.iter().for_each(|&(limit, samples)| self.add(limit, samples));
    }
    /// Cause and samples, in the order in which they came first.
    pub fn rows(&self) -> &[(u16, u64)] {
        &self.0
    }
    /// The cause of most samples among those that `counts`; of equals the one that came first. 0 for none.
    fn most(&self, counts: impl Fn(u16) -> bool) -> (u16, u64) {
        let chosen = self.0.iter().filter(|row| counts(row.0));
        chosen.fold((0, 0), |most, &row| if row.1 > most.1 { row } else { most })
    }
}

/// What limited a block most.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlockLimit {
    /// Cause of most of its samples, and how many.
    pub limit: u16,
    pub samples: u32,
    /// Cause of most of those that were below the programmed velocity.
    pub slow: u16,
}

/// All tallies of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Limits {
    /// Causes (their low bytes) by which nothing is lost, one bit each.
    at_speed: u64,
    limit: u16,
    run: u64,
    pub total: Tally,
    block: u32,
    in_block: Tally,
    pub blocks: Vec<BlockLimit>,
    /// Path length at the vertices of the plotted path, and the cause of most of the piece that ends there.
    s_mm: Vec<f64>,
    pub pieces: Vec<u16>,
    piece: usize,
    in_piece: Tally,
    capacity: usize,
    pub samples_per_bucket: u64,
    filled: u64,
    in_bucket: Tally,
    pub buckets: Vec<Tally>,
}

impl Limits {
    pub fn new(buckets: usize, at_speed: u64) -> Limits {
        let capacity = buckets.max(2).next_multiple_of(2);
        Limits { at_speed, capacity, samples_per_bucket: 1, ..Limits::default() }
    }

    pub fn watch(&mut self, s_mm: &[f64]) {
        (self.s_mm, self.pieces, self.piece) = (s_mm.to_vec(), vec![0; s_mm.len()], 0);
    }

    /// One sample: its cause, and where the set point is.
    #[inline]
    pub fn add(&mut self, limit: u16, block: u32, s: f64) {
        if limit != self.limit || block != self.block || self.s_mm.get(self.piece).is_some_and(|&end| s > end) {
            self.move_on(limit, block, s);
        }
        self.run += 1;
        self.filled += 1;
        if self.filled == self.samples_per_bucket {
            self.close_bucket();
        }
    }

    /// A sample on no path: it counts in all and over time.
    pub fn add_beside(&mut self, limit: u16) {
        self.flush();
        self.total.add(limit, 1);
        self.in_bucket.add(limit, 1);
        self.filled += 1;
        if self.filled == self.samples_per_bucket {
            self.close_bucket();
        }
    }

    #[cold]
    fn move_on(&mut self, limit: u16, block: u32, s: f64) {
        self.flush();
        if block != self.block {
            self.close_block();
            self.block = block;
        }
        while self.piece + 1 < self.s_mm.len() && s > self.s_mm[self.piece] {
            self.close_piece();
            self.piece += 1;
            // a piece that no sample falls into has the cause with which it is passed
            self.pieces[self.piece] = limit;
        }
        self.limit = limit;
    }

    fn flush(&mut self) {
        let (limit, run) = (self.limit, std::mem::take(&mut self.run));
        if run > 0 {
            for tally in [&mut self.total, &mut self.in_block, &mut self.in_piece, &mut self.in_bucket] {
                tally.add(limit, run);
            }
        }
    }

    fn close_block(&mut self) {
        let tally = std::mem::take(&mut self.in_block);
        let block = self.block as usize;
        if block >= self.blocks.len() {
            self.blocks.resize(block + 1, BlockLimit::default());
        }
        if !tally.0.is_empty() {
            let (limit, samples) = tally.most(|_| true);
            let (slow, _) = tally.most(|limit| self.at_speed >> (limit & 0x3f) & 1 == 0);
            self.blocks[block] = BlockLimit { limit, samples: samples as u32, slow };
        }
    }

    fn close_piece(&mut self) {
        let (limit, samples) = std::mem::take(&mut self.in_piece).most(|_| true);
        if let Some(piece) = self.pieces.get_mut(self.piece).filter(|_| samples > 0) {
            *piece = limit;
        }
    }

    /// When all buckets are full, pairs are joined, as those of [`crate::TimeSeries`].
    fn close_bucket(&mut self) {
        self.flush();
        self.buckets.push(std::mem::take(&mut self.in_bucket));
        self.filled = 0;
        if self.buckets.len() == self.capacity {
            for k in 0..self.capacity / 2 {
                let mut joined = std::mem::take(&mut self.buckets[2 * k]);
                joined.join(&self.buckets[2 * k + 1]);
                self.buckets[k] = joined;
            }
            self.buckets.truncate(self.capacity / 2);
            self.samples_per_bucket *= 2;
        }
    }

    /// The last block, piece and bucket.
    pub fn finish(&mut self) {
        self.flush();
        self.close_block();
        self.close_piece();
        if self.filled > 0 {
            self.close_bucket();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_counts_once_everywhere() {
        let mut limits = Limits::new(64, 1 << 1);
        limits.watch(&[0.0, 10.0, 20.0, 30.0]);
        for k in 0..3000u32 {
            let s = f64::from(k) * 0.01;
            // cause 1 but for the last tenth of each block
            limits.add(if k % 1000 < 900 { 1 } else { 7 }, k / 1000, s);
        }
        limits.finish();
        assert_eq!(limits.total.rows(), [(1, 2700), (7, 300)]);
        assert_eq!(limits.blocks, [BlockLimit { limit: 1, samples: 900, slow: 7 }; 3]);
        assert_eq!(limits.pieces[1..], [1, 1, 1]);
        let sum: u64 = limits.buckets.iter().flat_map(|b| b.rows()).map(|row| row.1).sum();
        assert_eq!(sum, 3000);
        let last: u64 = limits.buckets.iter().flat_map(|b| b.rows()).filter(|row| row.0 == 7).map(|row| row.1).sum();
        assert_eq!(last, 300);
    }
}
