//! Curves for plots, reduced by minimum and maximum so that no peak is lost, in bounded memory.

/// Smallest and largest value per bucket; NaN where a bucket is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MinMax {
    pub min: Vec<f32>,
    pub max: Vec<f32>,
}

impl MinMax {
    /// Empty ranges while collecting: comparisons are then plain, and NaN never enters.
    fn empty(n: usize) -> Self {
        MinMax { min: vec![f32::INFINITY; n], max: vec![f32::NEG_INFINITY; n] }
    }
    #[inline]
    fn add(&mut self, bucket: usize, value: f32) {
        if value < self.min[bucket] {
            self.min[bucket] = value;
        }
        if value > self.max[bucket] {
            self.max[bucket] = value;
        }
    }
    fn push(&mut self, range: Range) {
        self.min.push(range.min as f32);
        self.max.push(range.max as f32);
    }
    fn halve(&mut self) {
        self.min = self.min.chunks(2).map(|c| c.iter().copied().fold(f32::INFINITY, f32::min)).collect();
        self.max = self.max.chunks(2).map(|c| c.iter().copied().fold(f32::NEG_INFINITY, f32::max)).collect();
    }
    fn finish(&mut self) {
        for (min, max) in self.min.iter_mut().zip(&mut self.max).filter(|(min, max)| min > max) {
            (*min, *max) = (f32::NAN, f32::NAN);
        }
    }
}

/// A range being collected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub min: f64,
    pub max: f64,
}

impl Default for Range {
    fn default() -> Self {
        Range::EMPTY
    }
}

impl Range {
    pub const EMPTY: Range = Range { min: f64::INFINITY, max: f64::NEG_INFINITY };
    #[inline]
    pub fn add(&mut self, value: f64) {
        self.min = if value < self.min { value } else { self.min };
        self.max = if value > self.max { value } else { self.max };
    }
}

/// Deviation over path length: `buckets` equal parts of the programmed path, by the foot point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LengthSeries {
    pub bucket_mm: f64,
    per_mm: f64,
    pub setpoint_mm: MinMax,
    pub actual_mm: MinMax,
    /// Signed deviation of the load side in the plane, + = left.
    pub signed_mm: MinMax,
}

impl LengthSeries {
    pub(crate) fn new(length_mm: f64, buckets: usize) -> Self {
        let n = buckets.max(1);
        LengthSeries {
            bucket_mm: length_mm / n as f64,
            // an empty path has one place only
            per_mm: if length_mm > 0.0 { n as f64 / length_mm } else { 0.0 },
            setpoint_mm: MinMax::empty(n),
            actual_mm: MinMax::empty(n),
            signed_mm: MinMax::empty(n),
        }
    }
    #[inline]
    fn bucket(&self, s: f64) -> usize {
        ((s * self.per_mm) as usize).min(self.actual_mm.min.len() - 1)
    }
    #[inline]
    pub(crate) fn add(&mut self, s_setpoint: f64, setpoint: f32, s_actual: f64, actual: f32, signed: f32) {
        let (set, act) = (self.bucket(s_setpoint), self.bucket(s_actual));
        self.setpoint_mm.add(set, setpoint);
        self.actual_mm.add(act, actual);
        self.signed_mm.add(act, signed);
    }
    pub(crate) fn finish(&mut self) {
        [&mut self.setpoint_mm, &mut self.actual_mm, &mut self.signed_mm].into_iter().for_each(MinMax::finish);
    }
}

/// Curves over machine time. Buckets hold `samples_per_bucket` samples; when all are full, pairs are joined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeSeries {
    pub samples_per_bucket: u64,
    /// Path velocity of the set point, mm/s.
    pub speed: MinMax,
    /// Programmed path velocity times override, mm/s.
    pub programmed: MinMax,
    pub factor: MinMax,
    pub deviation_actual_mm: MinMax,
    /// Per axis, in axis units.
    pub following: Vec<MinMax>,
    capacity: usize,
    filled: u64,
    current: [Range; 4],
    current_following: Vec<Range>,
}

impl TimeSeries {
    pub(crate) fn new(axes: usize, buckets: usize) -> Self {
        let following = vec![MinMax::default(); axes];
        let current_following = vec![Range::EMPTY; axes];
        let capacity = buckets.max(2).next_multiple_of(2);
        TimeSeries { samples_per_bucket: 1, following, capacity, current_following, ..TimeSeries::default() }
    }

    /// One sample: path velocity, programmed velocity, factor, deviation of the load side, and set points and
    /// encoder positions, whose difference is the following error.
    #[inline]
    pub(crate) fn add(&mut self, values: [f64; 4], dp: &[f64], rp: &[f64]) {
        for (range, value) in self.current.iter_mut().zip(values) {
            range.add(value);
        }
        for (range, (d, r)) in self.current_following.iter_mut().zip(dp.iter().zip(rp)) {
            range.add(d - r);
        }
        self.filled += 1;
        if self.filled == self.samples_per_bucket {
            self.close_bucket();
        }
    }

    /// The last bucket may hold fewer samples.
    pub(crate) fn finish(&mut self) {
        if self.filled > 0 {
            self.close_bucket();
        }
        self.columns().for_each(MinMax::finish);
    }

    fn close_bucket(&mut self) {
        let (own, following) = (self.current, std::mem::take(&mut self.current_following));
        self.columns().zip(own.iter().chain(&following)).for_each(|(column, range)| column.push(*range));
        self.current = [Range::EMPTY; 4];
        self.current_following = following;
        self.current_following.fill(Range::EMPTY);
        self.filled = 0;
        if self.speed.min.len() == self.capacity {
            self.columns().for_each(MinMax::halve);
            self.samples_per_bucket *= 2;
        }
    }

    fn columns(&mut self) -> impl Iterator<Item = &mut MinMax> {
        let own = [&mut self.speed, &mut self.programmed, &mut self.factor, &mut self.deviation_actual_mm];
        own.into_iter().chain(self.following.iter_mut())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_peak_is_lost_and_memory_is_bounded() {
        let mut series = TimeSeries::new(1, 64);
        for k in 0..10_000u32 {
            let peak = if k == 7_777 { 42.0 } else { 1.0 };
            series.add([peak, 0.0, 1.0, 0.0], &[0.0], &[peak]);
        }
        series.finish();
        assert!(series.speed.max.len() <= 64);
        let bucket = (7_777 / series.samples_per_bucket) as usize;
        assert_eq!(series.speed.max[bucket], 42.0);
        assert_eq!(series.speed.max.iter().filter(|&&v| v == 42.0).count(), 1);
        assert_eq!(series.following[0].min[bucket], -42.0);
        assert_eq!(series.speed.min[bucket], 1.0);
    }
}
