//! Samples of a path as few chords: what a tool sweeps, in bounded memory, whatever chunks the samples come in.

/// A straight piece of the path. `tag` is the caller's (line, rapid, tool), `sample` the number of the sample at whose
/// beginning the piece starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chord {
    pub from: [f64; 3],
    pub to: [f64; 3],
    pub tag: u64,
    pub sample: u64,
}

/// Samples that one chord of a level replaces at most; two levels make 1,024.
const WINDOW: usize = 32;

/// Replaces points by chords that stay within the tolerance, mm, of every one of them.
#[derive(Clone, Debug)]
pub struct Chords {
    levels: [Level; 2],
    last: Option<[f64; 3]>,
}

/// Points behind the anchor that the next chord has to pass.
#[derive(Clone, Debug)]
struct Level {
    tolerance2: f64,
    tag: u64,
    sample: u64,
    points: Vec<[f64; 3]>,
}

impl Chords {
    pub fn new(tolerance_mm: f64) -> Chords {
        let half = (tolerance_mm / 2.0).powi(2);
        let level = Level { tolerance2: half, tag: 0, sample: 0, points: Vec::with_capacity(WINDOW + 1) };
        Chords { levels: [level.clone(), level], last: None }
    }

    /// The next point; the piece that leads to it has the tag. What is finished goes to `out`.
    pub fn push(&mut self, point: [f64; 3], tag: u64, sample: u64, out: &mut Vec<Chord>) {
        let from = self.last.unwrap_or(point);
        self.last = Some(point);
        let piece = Chord { from, to: point, tag, sample };
        if let Some(chord) = self.levels[0].push(piece) {
            out.extend(self.levels[1].push(chord));
        }
    }

    /// Whatever is still open.
    pub fn finish(&mut self, out: &mut Vec<Chord>) {
        if let Some(chord) = self.levels[0].take() {
            out.extend(self.levels[1].push(chord));
        }
        out.extend(self.levels[1].take());
    }
}

impl Level {
    /// Adds a piece that begins where the one before ended; returns the chord that it closes.
    fn push(&mut self, piece: Chord) -> Option<Chord> {
        let joins = !self.points.is_empty() && self.tag == piece.tag && self.points.len() <= WINDOW;
        if joins && self.reaches(piece.to) {
            self.points.push(piece.to);
            return None;
        }
        let done = self.take();
        self.points.extend([piece.from, piece.to]);
        (self.tag, self.sample) = (piece.tag, piece.sample);
        done
    }

    fn reaches(&self, to: [f64; 3]) -> bool {
        let from = self.points[0];
        let along: [f64; 3] = std::array::from_fn(|k| to[k] - from[k]);
        let square: f64 = along.iter().map(|x| x * x).sum();
        let scale = if square > 0.0 { 1.0 / square } else { 0.0 };
        self.points[1..].iter().all(|p| {
            let off: [f64; 3] = std::array::from_fn(|k| p[k] - from[k]);
            let t = (off.iter().zip(&along).map(|(a, b)| a * b).sum::<f64>() * scale).clamp(0.0, 1.0);
            off.iter().zip(&along).map(|(a, b)| (a - t * b).powi(2)).sum::<f64>() <= self.tolerance2
        })
    }

    fn take(&mut self) -> Option<Chord> {
        let (from, to) = (*self.points.first()?, *self.points.last()?);
        self.points.clear();
        Some(Chord { from, to, tag: self.tag, sample: self.sample })
    }
}
