//! What each programmed block measured.

/// Measured values of one block; ranges are empty (min > max) where no sample fell into it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockStats {
    /// Machine time that the set point spent in the block, shared out by length in intervals that cross blocks.
    pub time_s: f64,
    /// Part of it in motion; length over this is the mean velocity.
    pub moving_s: f64,
    /// Path velocity of the set point, mm/s.
    pub speed_min: f32,
    pub speed_max: f32,
    /// Deviation of the set point: samples, largest, sum of squares.
    pub setpoint: BlockDeviation,
    /// Deviation of the load side.
    pub actual: BlockDeviation,
    /// Signed deviation of the load side in the plane, + = left; NaN where there is no direction in the plane.
    pub signed_min_mm: f32,
    pub signed_max_mm: f32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BlockDeviation {
    pub samples: u32,
    pub max_mm: f32,
    pub squares: f64,
}

impl BlockDeviation {
    #[inline]
    pub fn add(&mut self, d: f64) {
        self.samples += 1;
        self.squares += d * d;
        self.max_mm = if d as f32 > self.max_mm { d as f32 } else { self.max_mm };
    }
    /// Root mean square, NaN without samples.
    pub fn rms_mm(&self) -> f64 {
        (self.squares / f64::from(self.samples)).sqrt()
    }
}

impl Default for BlockStats {
    fn default() -> Self {
        BlockStats {
            time_s: 0.0,
            moving_s: 0.0,
            speed_min: f32::INFINITY,
            speed_max: f32::NEG_INFINITY,
            setpoint: BlockDeviation::default(),
            actual: BlockDeviation::default(),
            signed_min_mm: f32::NAN,
            signed_max_mm: f32::NAN,
        }
    }
}

impl BlockStats {
    /// An interval (or the share of one) in which the set point ran `length` mm through this block.
    #[inline]
    pub fn pass(&mut self, time_s: f64, length: f64, speed: f64) {
        self.time_s += time_s;
        if length > 0.0 {
            self.moving_s += time_s;
            self.speed_min = self.speed_min.min(speed as f32);
            self.speed_max = self.speed_max.max(speed as f32);
        }
    }
    #[inline]
    pub fn add_signed(&mut self, signed: f64) {
        // f32::min and max ignore NaN on either side
        self.signed_min_mm = self.signed_min_mm.min(signed as f32);
        self.signed_max_mm = self.signed_max_mm.max(signed as f32);
    }
}
