//! Where a motion command was first and last seen, and how fast: what a bound on its time is computed from.

/// A motion command between its first and its last sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Passage {
    /// Numbers of the first and the last sample, and how many belong to the command.
    pub first: u64,
    pub last: u64,
    pub samples: u64,
    /// Path length at the foot of the set point there, mm.
    pub s_mm: [f64; 2],
    /// Path velocity there, mm/s: planned velocity times override.
    pub v: [f64; 2],
    /// Most of it, of its change per second and of the override between them.
    pub v_max: f64,
    pub a_max: f64,
    pub factor_max: f64,
    pub factor_min: f64,
}

/// The passages of a run, by number of the motion command.
#[derive(Clone, Debug, Default)]
pub struct Passages {
    list: Vec<Passage>,
    /// (commands, axes), axis units.
    begin: Vec<f64>,
    end: Vec<f64>,
    axes: usize,
    last_v: f64,
}

impl Passages {
    pub(crate) fn new(axes: usize) -> Passages {
        Passages { axes, ..Passages::default() }
    }

    /// A sample of motion command `entry` (from 1; 0: none).
    #[inline]
    pub(crate) fn add(&mut self, sample: u64, entry: u32, s: f64, (v, factor): (f64, f64), rate: f64, dp: &[f64]) {
        let last_v = std::mem::replace(&mut self.last_v, v);
        let Some(index) = (entry as usize).checked_sub(1) else { return };
        if index >= self.list.len() {
            self.list.resize(index + 1, Passage::default());
            self.begin.resize((index + 1) * self.axes, f64::NAN);
            self.end.resize((index + 1) * self.axes, f64::NAN);
        }
        let passage = &mut self.list[index];
        let row = index * self.axes..(index + 1) * self.axes;
        if passage.samples == 0 {
            (passage.first, passage.s_mm[0], passage.v[0]) = (sample, s, v);
            passage.factor_min = factor;
            self.begin[row.clone()].copy_from_slice(dp);
        } else {
            passage.a_max = passage.a_max.max((v - last_v).abs() * rate);
        }
        passage.samples += 1;
        (passage.last, passage.s_mm[1], passage.v[1]) = (sample, s, v);
        passage.v_max = passage.v_max.max(v);
        passage.factor_max = passage.factor_max.max(factor);
        passage.factor_min = passage.factor_min.min(factor);
        self.end[row].copy_from_slice(dp);
    }

    pub fn list(&self) -> &[Passage] {
        &self.list
    }
    /// Set points at the first and at the last sample of each command, row by row; NaN for those never seen.
    pub fn ends(&self) -> (&[f64], &[f64]) {
        (&self.begin, &self.end)
    }
}
