//! What the plotted path shows of a run.

/// Largest deviation per piece of a polyline, for the terminal's path plot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Watched {
    s_mm: Vec<f64>,
    pub max_mm: Vec<f32>,
    /// Signed deviation in the plane where the largest was found.
    pub signed_mm: Vec<f32>,
    pub at: usize,
}

impl Watched {
    pub fn new(s_mm: &[f64]) -> Watched {
        let none = vec![f32::NAN; s_mm.len()];
        Watched { s_mm: s_mm.to_vec(), max_mm: none.clone(), signed_mm: none, at: 0 }
    }
    #[inline]
    pub fn add(&mut self, s: f64, deviation: f32, signed: f32) {
        while self.at + 1 < self.s_mm.len() && s > self.s_mm[self.at] {
            self.at += 1;
            // a piece that no sample fell into has the deviation with which it was passed
            self.max_mm[self.at] = deviation;
            self.signed_mm[self.at] = signed;
        }
        if let Some(max) = self.max_mm.get_mut(self.at).filter(|max| max.is_nan() || deviation > **max) {
            *max = deviation;
            self.signed_mm[self.at] = signed;
        }
    }
}
