//! The layout of a `/columns` message: full-rate samples, column after column.
//!
//! All numbers little-endian: u64 first sample, u32 n samples, u32 a axes; then f64 (n, a) set points `dp`, load
//! side `load`, encoder `rp`; f64 (n) effective override `factor`, nominal path velocity `v_plan`; u32 (n) source
//! `line`, motion command `entry`, `flags`; f32 (n) `deviation_mm` of the load side from the programmed path.

use crate::Error;

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
}

const HEAD: usize = 16;
/// More axes than the controller has are no recording of ours.
const MAX_AXES: usize = 18;

fn bytes_per_sample(axes: usize) -> usize {
    3 * 8 * axes + 2 * 8 + 3 * 4 + 4
}

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
        }
    }
    /// Appends the message to `out`.
    pub fn encode(&self, out: &mut Vec<u8>) {
        out.extend(self.first_sample.to_le_bytes());
        out.extend((self.len() as u32).to_le_bytes());
        out.extend((self.axes as u32).to_le_bytes());
        let from = out.len();
        out.resize(from + self.len() * bytes_per_sample(self.axes), 0);
        let mut rest = &mut out[from..];
        // fixed-size pieces of a slice: the compiler makes a plain copy of it
        for column in [self.dp, self.load, self.rp, self.factor, self.v_plan] {
            let (own, behind) = rest.split_at_mut(8 * column.len());
            own.chunks_exact_mut(8).zip(column).for_each(|(bytes, value)| bytes.copy_from_slice(&value.to_le_bytes()));
            rest = behind;
        }
        for column in [self.line, self.entry, self.flags] {
            let (own, behind) = rest.split_at_mut(4 * column.len());
            own.chunks_exact_mut(4).zip(column).for_each(|(bytes, value)| bytes.copy_from_slice(&value.to_le_bytes()));
            rest = behind;
        }
        let deviations = rest.chunks_exact_mut(4).zip(self.deviation_mm);
        deviations.for_each(|(bytes, value)| bytes.copy_from_slice(&value.to_le_bytes()));
    }
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
    }
    /// Reads a message back.
    ///
    /// # Errors
    /// If the length contradicts the head.
    pub fn decode(data: &[u8]) -> Result<Columns, Error> {
        let bad = || Error::Content("a message of /columns has the wrong length".to_owned());
        let (head, mut rest) = data.split_at_checked(HEAD).ok_or_else(bad)?;
        let first_sample = u64::from_le_bytes(head[..8].try_into().expect("8 bytes"));
        let number = |at: usize| u32::from_le_bytes(head[at..at + 4].try_into().expect("4 bytes")) as usize;
        let (n, axes) = (number(8), number(12));
        if axes > MAX_AXES || rest.len() != n.saturating_mul(bytes_per_sample(axes)) {
            return Err(bad());
        }
        let mut take = |bytes: usize| {
            let (column, after) = rest.split_at(bytes);
            rest = after;
            column
        };
        let f64s =
            |bytes: &[u8]| bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes"))).collect();
        let u32s =
            |bytes: &[u8]| bytes.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().expect("4 bytes"))).collect();
        Ok(Columns {
            first_sample,
            axes,
            dp: f64s(take(8 * n * axes)),
            load: f64s(take(8 * n * axes)),
            rp: f64s(take(8 * n * axes)),
            factor: f64s(take(8 * n)),
            v_plan: f64s(take(8 * n)),
            line: u32s(take(4 * n)),
            entry: u32s(take(4 * n)),
            flags: u32s(take(4 * n)),
            deviation_mm: take(4 * n)
                .chunks_exact(4)
                .map(|b| f32::from_le_bytes(b.try_into().expect("4 bytes")))
                .collect(),
        })
    }
}
