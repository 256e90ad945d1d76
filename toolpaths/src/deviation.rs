//! Statistics of a deviation over all samples of a run, in bounded memory.

/// Mantissa bits of f32 that the histogram keeps: percentiles are exact to 2^-11 relative (0.05 %), rounded up.
const KEPT_BITS: u32 = 11;
const DROPPED_BITS: u32 = 23 - KEPT_BITS;
/// Smaller deviations share the lowest bin: 2^-40 mm.
const LEAST_EXPONENT: u32 = 127 - 40;
/// Larger ones the highest: 2^20 mm.
const GREATEST_EXPONENT: u32 = 127 + 20;
const BINS: usize = ((GREATEST_EXPONENT - LEAST_EXPONENT) << KEPT_BITS) as usize;

/// Where the largest deviation is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Worst {
    /// Source line of the block that the foot point is on; 0 before any sample.
    pub line: u32,
    /// Machine time, s.
    pub t_s: f64,
    /// Position of all axes then, in axis units, as measured (set point or load side).
    pub position: Vec<f64>,
}

/// `D` of design 3.2, with further percentiles for the report. All in mm, in the metric of design D7.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeviationSummary {
    pub max_mm: f64,
    pub rms_mm: f64,
    pub mean_mm: f64,
    pub p95_mm: f64,
    pub p99_mm: f64,
    pub p997_mm: f64,
    /// Largest signed deviation to the left and to the right of the direction of motion, both >= 0.
    pub left_mm: f64,
    pub right_mm: f64,
    pub worst: Worst,
}

/// Collects deviations.
#[derive(Clone, Debug)]
pub struct Deviations {
    count: u64,
    sum: f64,
    squares: f64,
    pub max: f64,
    max_sample: u64,
    max_line: u32,
    max_position: Vec<f64>,
    left: f64,
    right: f64,
    bins: Vec<u32>,
}

impl Deviations {
    pub fn new() -> Self {
        Deviations {
            count: 0,
            sum: 0.0,
            squares: 0.0,
            max: -1.0,
            max_sample: 0,
            max_line: 0,
            max_position: Vec::new(),
            left: 0.0,
            right: 0.0,
            bins: vec![0; BINS],
        }
    }

    /// `line` gives the source line of the block that the foot is on.
    #[inline]
    pub fn add(&mut self, d: f64, signed: f64, sample: u64, line: impl FnOnce() -> u32, position: &[f64]) {
        self.count += 1;
        self.sum += d;
        self.squares += d * d;
        self.bins[bin(d)] += 1;
        // NaN where the path has no direction in the plane: compares false
        if signed > self.left {
            self.left = signed;
        } else if -signed > self.right {
            self.right = -signed;
        }
        if d > self.max {
            self.max = d;
            self.max_sample = sample;
            self.max_line = line();
            self.max_position.clear();
            self.max_position.extend_from_slice(position);
        }
    }

    /// Least value that at least a share `q` of the samples does not exceed, to the resolution of the histogram.
    pub fn quantile(&self, q: f64) -> f64 {
        let wanted = ((self.count as f64 * q).ceil() as u64).max(1);
        let mut seen = 0u64;
        for (i, n) in self.bins.iter().enumerate() {
            seen += u64::from(*n);
            if seen >= wanted {
                return upper_edge(i).min(self.max.max(0.0));
            }
        }
        self.max.max(0.0)
    }

    pub fn summary(&self, sample_time_s: f64) -> DeviationSummary {
        if self.count == 0 {
            return DeviationSummary::default();
        }
        let n = self.count as f64;
        DeviationSummary {
            max_mm: self.max,
            rms_mm: (self.squares / n).sqrt(),
            mean_mm: self.sum / n,
            p95_mm: self.quantile(0.95),
            p99_mm: self.quantile(0.99),
            p997_mm: self.quantile(0.997),
            left_mm: self.left,
            right_mm: self.right,
            worst: Worst {
                line: self.max_line,
                t_s: (self.max_sample + 1) as f64 * sample_time_s,
                position: self.max_position.clone(),
            },
        }
    }
}

#[inline]
fn bin(d: f64) -> usize {
    let bits = (d as f32).to_bits();
    let least = LEAST_EXPONENT << 23;
    ((bits.max(least) - least) >> DROPPED_BITS).min(BINS as u32 - 1) as usize
}

fn upper_edge(bin: usize) -> f64 {
    let bits = ((bin as u32 + 1) << DROPPED_BITS) + (LEAST_EXPONENT << 23);
    f64::from(f32::from_bits(bits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_sorted_list_within_the_stated_resolution() {
        let mut deviations = Deviations::new();
        let mut sorted: Vec<f64> = (1..=10_000).map(|i| 1e-3 * (f64::from(i) * 0.618).fract().powi(3)).collect();
        for (k, d) in sorted.iter().enumerate() {
            deviations.add(*d, f64::NAN, k as u64, || 7, &[*d]);
        }
        sorted.sort_by(f64::total_cmp);
        for (q, at) in [(0.5, 4999), (0.95, 9499), (0.99, 9899), (1.0, 9999)] {
            let found = deviations.quantile(q);
            assert!(found >= sorted[at] * (1.0 - 1e-7) && found <= sorted[at] * (1.0 + 5e-4), "{q}: {found}");
        }
        let summary = deviations.summary(0.5);
        assert_eq!(summary.worst.position, vec![sorted[9999]]);
        assert_eq!(summary.worst.line, 7);
    }

    #[test]
    fn extreme_deviations_stay_in_the_histogram() {
        assert_eq!(bin(0.0), 0);
        assert_eq!(bin(1e-30), 0);
        assert_eq!(bin(f64::INFINITY), BINS - 1);
        assert!(upper_edge(bin(0.05)) >= 0.05);
    }
}
