//! The layout of a `/columns` message: full-rate samples, column after column.
//!
//! Numbers are little-endian: u64 first sample, u32 n samples, u32 a axes; f64 (a) resolution of the encoders. Then, each
//! packed by itself ([`crate::packed`]): per axis the f64 set points `dp`, per axis the load side `load`, per axis the
//! encoder `rp` (as i64 multiples of its resolution, or f64 where that is 0), f64 effective override `factor`, nominal path
//! velocity `v_plan`, u32 source `line`, motion command `entry`, `flags`, and the bits of the f32 `deviation_mm` of the
//! load side from the programmed path. Behind them, where it is known, u32 of the controller at the end of the chunk
//! ([`ColumnsView::standing`]).

use crate::Error;
use crate::packed::{pack, unpack};

/// Samples of a run as columns; matrices row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    pub first_sample: u64,
    pub axes: usize,
    pub dp: Vec<f64>,
    pub load: Vec<f64>,
    pub rp: Vec<f64>,
    pub factor: Vec<f64>,
    pub v_plan: Vec<f64>,
    pub line: Vec<u32>,
    pub entry: Vec<u32>,
    pub flags: Vec<u32>,
    pub deviation_mm: Vec<f32>,
    pub standing: Vec<u32>,
}

/// Borrowed columns, as they come from the controller.
#[derive(Clone, Copy, Debug)]
pub struct ColumnsView<'a> {
    pub first_sample: u64,
    pub axes: usize,
    pub dp: &'a [f64],
    pub load: &'a [f64],
    pub rp: &'a [f64],
    pub factor: &'a [f64],
    pub v_plan: &'a [f64],
    pub line: &'a [u32],
    pub entry: &'a [u32],
    pub flags: &'a [u32],
    pub deviation_mm: &'a [f32],
    /// What stood in the controller behind the last sample; empty where that is not known. Per axis: bytes used in its
    /// spooler, motion commands in it; then the source line that each task executes, and the bits of the f64 spindle
    /// speed, low half first.
    pub standing: &'a [u32],
}

const HEAD: usize = 16;
/// Tasks whose line stands in [`ColumnsView::standing`].
const TASKS: usize = 4;
/// More axes than the controller has are no recording of ours.
const MAX_AXES: usize = 18;

/// More samples than this in one message are none of ours.
const MOST_SAMPLES: usize = 1 << 16;

impl<'a> ColumnsView<'a> {
    pub fn len(&self) -> usize {
        self.flags.len()
    }
    pub fn is_empty(&self) -> bool {
        self.flags.is_empty()
    }
    /// True if all columns have the length of `flags`.
    pub fn is_consistent(&self) -> bool {
        let (n, rows) = (self.len(), self.len() * self.axes);
        [self.dp.len(), self.load.len(), self.rp.len()].iter().all(|&l| l == rows)
            && [self.factor.len(), self.v_plan.len()].iter().all(|&l| l == n)
            && [self.line.len(), self.entry.len(), self.deviation_mm.len()].iter().all(|&l| l == n)
    }
    /// Samples `from..to` of it.
    pub fn slice(&self, from: usize, to: usize) -> ColumnsView<'a> {
        let rows = from * self.axes..to * self.axes;
        ColumnsView {
            first_sample: self.first_sample + from as u64,
            axes: self.axes,
            dp: &self.dp[rows.clone()],
            load: &self.load[rows.clone()],
            rp: &self.rp[rows],
            factor: &self.factor[from..to],
            v_plan: &self.v_plan[from..to],
            line: &self.line[from..to],
            entry: &self.entry[from..to],
            flags: &self.flags[from..to],
            deviation_mm: &self.deviation_mm[from..to],
            standing: if to == self.len() { self.standing } else { &[] },
        }
    }
    /// Appends the message to `out`. `resolution`: axis units per count of each encoder, as far as it is known.
    pub fn encode(&self, resolution: &[f64], out: &mut Vec<u8>) {
        let mut words = Vec::with_capacity(self.len());
        let (mut column, mut counts) = (Vec::with_capacity(self.len()), Vec::with_capacity(self.len()));
        out.extend(self.first_sample.to_le_bytes());
        out.extend((self.len() as u32).to_le_bytes());
        out.extend((self.axes as u32).to_le_bytes());
        let units = out.len();
        out.resize(units + 8 * self.axes, 0);
        for matrix in [self.dp, self.load] {
            for a in 0..self.axes {
                self.axis_of(matrix, a, &mut column);
                pack(&column, &mut words, out);
            }
        }
        for a in 0..self.axes {
            let unit = resolution.get(a).copied().unwrap_or(0.0);
            self.axis_of(self.rp, a, &mut column);
            if in_counts(&column, unit, &mut counts) {
                out[units + 8 * a..units + 8 * (a + 1)].copy_from_slice(&unit.to_le_bytes());
                pack(&counts, &mut words, out);
            } else {
                pack(&column, &mut words, out);
            }
        }
        [self.factor, self.v_plan].into_iter().for_each(|column| pack(column, &mut words, out));
        [self.line, self.entry, self.flags].into_iter().for_each(|column| pack(column, &mut words, out));
        let bits: Vec<u32> = self.deviation_mm.iter().map(|d| d.to_bits()).collect();
        pack(&bits, &mut words, out);
        out.extend(self.standing.iter().flat_map(|word| word.to_le_bytes()));
    }

    fn axis_of(&self, matrix: &[f64], axis: usize, column: &mut Vec<f64>) {
        column.clear();
        column.extend(matrix.chunks_exact(self.axes).map(|row| row[axis]));
    }
}

/// Positions as whole multiples of the resolution; false if one of them is none, to the last bit.
fn in_counts(positions: &[f64], unit: f64, counts: &mut Vec<i64>) -> bool {
    counts.clear();
    if unit <= 0.0 || !unit.is_finite() {
        return false;
    }
    let per_unit = 1.0 / unit;
    // as `round`, which is a call
    counts.extend(positions.iter().map(|x| x * per_unit).map(|y| (y + 0.5_f64.copysign(y)) as i64));
    positions.iter().zip(counts.iter()).all(|(x, &count)| (count as f64 * unit).to_bits() == x.to_bits())
}

impl Columns {
    pub fn view(&self) -> ColumnsView<'_> {
        ColumnsView {
            first_sample: self.first_sample,
            axes: self.axes,
            dp: &self.dp,
            load: &self.load,
            rp: &self.rp,
            factor: &self.factor,
            v_plan: &self.v_plan,
            line: &self.line,
            entry: &self.entry,
            flags: &self.flags,
            deviation_mm: &self.deviation_mm,
            standing: &self.standing,
        }
    }
    /// Becomes a copy of the view; memory is used again.
    pub fn copy_from(&mut self, view: &ColumnsView) {
        fn copy<T: Copy>(to: &mut Vec<T>, from: &[T]) {
            to.clear();
            to.extend_from_slice(from);
        }
        (self.first_sample, self.axes) = (view.first_sample, view.axes);
        let Columns { dp, load, rp, factor, v_plan, .. } = self;
        for (to, from) in
            [dp, load, rp, factor, v_plan].into_iter().zip([view.dp, view.load, view.rp, view.factor, view.v_plan])
        {
            copy(to, from);
        }
        let Columns { line, entry, flags, .. } = self;
        for (to, from) in [line, entry, flags].into_iter().zip([view.line, view.entry, view.flags]) {
            copy(to, from);
        }
        copy(&mut self.deviation_mm, view.deviation_mm);
        copy(&mut self.standing, view.standing);
    }
    /// Reads a message back.
    ///
    /// # Errors
    /// If the length contradicts the head.
    pub fn decode(data: &[u8]) -> Result<Columns, Error> {
        Self::decoded(data).ok_or_else(|| Error::Content("a message of /columns has the wrong length".to_owned()))
    }

    fn decoded(data: &[u8]) -> Option<Columns> {
        let (head, mut rest) = data.split_at_checked(HEAD)?;
        let first_sample = u64::from_le_bytes(head[..8].try_into().ok()?);
        let number = |at: usize| u32::from_le_bytes(head[at..at + 4].try_into().expect("4 bytes")) as usize;
        let (n, axes) = (number(8), number(12));
        if axes > MAX_AXES || n > MOST_SAMPLES {
            return None;
        }
        let (units, behind) = rest.split_at_checked(8 * axes)?;
        rest = behind;
        let mut words = Vec::with_capacity(n);
        let mut matrix = |rest: &mut &[u8], units: Option<&[u8]>| -> Option<Vec<f64>> {
            let mut rows = vec![0.0; n * axes];
            for a in 0..axes {
                let unit =
                    units.map_or(0.0, |u| f64::from_le_bytes(u[8 * a..8 * (a + 1)].try_into().expect("8 bytes")));
                let column = match unit == 0.0 {
                    true => unpack(rest, n, &mut words)?,
                    false => unpack::<i64>(rest, n, &mut words)?.iter().map(|&count| count as f64 * unit).collect(),
                };
                rows.iter_mut().skip(a).step_by(axes).zip(column).for_each(|(place, value)| *place = value);
            }
            Some(rows)
        };
        let (dp, load) = (matrix(&mut rest, None)?, matrix(&mut rest, None)?);
        let rp = matrix(&mut rest, Some(units))?;
        let (factor, v_plan) = (unpack(&mut rest, n, &mut words)?, unpack(&mut rest, n, &mut words)?);
        let mut whole = || unpack::<u32>(&mut rest, n, &mut words);
        let (line, entry, flags) = (whole()?, whole()?, whole()?);
        let deviation_mm = whole()?.into_iter().map(f32::from_bits).collect();
        let (standing, cut) = rest.as_chunks::<4>();
        let standing: Vec<u32> = standing.iter().map(|word| u32::from_le_bytes(*word)).collect();
        let whole = standing.is_empty() || standing.len() == 2 * axes + TASKS + 2;
        let columns =
            Columns { first_sample, axes, dp, load, rp, factor, v_plan, line, entry, flags, deviation_mm, standing };
        (whole && cut.is_empty()).then_some(columns)
    }
}
