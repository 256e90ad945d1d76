//! Curves for plots, reduced by minimum and maximum so that no peak is lost, in bounded memory.

/// Smallest and largest value per bucket; NaN where a bucket is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MinMax {
    pub min: Vec<f32>,
    pub max: Vec<f32>,
}

impl MinMax {
    fn empty(n: usize) -> Self {
        MinMax { min: vec![f32::NAN; n], max: vec![f32::NAN; n] }
    }
    #[inline]
    fn add(&mut self, bucket: usize, value: f32) {
        // f32::min and max ignore NaN on either side
        self.min[bucket] = self.min[bucket].min(value);
        self.max[bucket] = self.max[bucket].max(value);
    }
    fn halve(&mut self) {
        let pairs = |v: &[f32], pick: fn(f32, f32) -> f32| -> Vec<f32> {
            v.chunks(2).map(|c| c.iter().copied().fold(f32::NAN, pick)).collect()
        };
        self.min = pairs(&self.min, f32::min);
        self.max = pairs(&self.max, f32::max);
    }
}

/// Deviation over path length: `buckets` equal parts of the programmed path, by the foot point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LengthSeries {
    pub bucket_mm: f64,
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
            setpoint_mm: MinMax::empty(n),
            actual_mm: MinMax::empty(n),
            signed_mm: MinMax::empty(n),
        }
    }
    #[inline]
    fn bucket(&self, s: f64) -> usize {
        // 0 / 0 on an empty path casts to 0
        ((s / self.bucket_mm) as usize).min(self.actual_mm.min.len() - 1)
    }
    #[inline]
    pub(crate) fn add(&mut self, s_setpoint: f64, setpoint: f32, s_actual: f64, actual: f32, signed: f32) {
        let (set, act) = (self.bucket(s_setpoint), self.bucket(s_actual));
        self.setpoint_mm.add(set, setpoint);
        self.actual_mm.add(act, actual);
        self.signed_mm.add(act, signed);
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
    current: Vec<(f32, f32)>,
}

const NOTHING: (f32, f32) = (f32::NAN, f32::NAN);

impl TimeSeries {
    pub(crate) fn new(axes: usize, buckets: usize) -> Self {
        let following = vec![MinMax::default(); axes];
        let current = vec![NOTHING; 4 + axes];
        let capacity = buckets.max(2).next_multiple_of(2);
        TimeSeries { samples_per_bucket: 1, following, capacity, current, ..TimeSeries::default() }
    }

    /// One sample: the four curves, then following errors.
    #[inline]
    pub(crate) fn add(&mut self, values: [f32; 4], following: impl Iterator<Item = f32>) {
        for (range, value) in self.current.iter_mut().zip(values.into_iter().chain(following)) {
            *range = (range.0.min(value), range.1.max(value));
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
    }

    fn close_bucket(&mut self) {
        let ranges = std::mem::take(&mut self.current);
        for (column, range) in self.columns().zip(&ranges) {
            column.min.push(range.0);
            column.max.push(range.1);
        }
        self.current = ranges;
        self.current.fill(NOTHING);
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
            series.add([peak, 0.0, 1.0, 0.0], [-peak].into_iter());
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
