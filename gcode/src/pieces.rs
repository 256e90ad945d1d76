//! The motion commands of a program in pieces of equal size, wherever its segments were cut: what a recording keeps.

use std::borrow::Borrow;
use std::collections::VecDeque;

use motion_kernel::autocode::Program;
use motion_kernel::machine::Machine;

use crate::sequence::{Radii, SequenceColumns, Sequencer};

/// Columns of a program, piece by piece. Each stands for itself: its `start` is where the one before ends.
pub struct Pieces {
    sequencer: Sequencer,
    size: usize,
    full: VecDeque<SequenceColumns>,
    /// The piece that is being filled; `None` behind the last.
    open: Option<SequenceColumns>,
}

impl Pieces {
    /// Pieces of `size` commands; only the last one has fewer.
    pub fn new(machine: &Machine, size: usize) -> Self {
        let start: Vec<f64> = machine.axes.iter().map(|axis| axis.start).collect();
        let open = SequenceColumns { axes: start.len(), start, ..SequenceColumns::default() };
        Pieces { sequencer: Sequencer::new(machine), size, full: VecDeque::new(), open: Some(open) }
    }
    /// The next piece, of the segments that `more` gives; `None` behind the last. There is one at least.
    pub fn next<P: Borrow<Program>>(
        &mut self,
        machine: &Machine,
        more: &mut dyn FnMut() -> Option<P>,
    ) -> Option<SequenceColumns> {
        while self.full.is_empty() && self.open.is_some() {
            match more() {
                Some(segment) => self.add(segment.borrow()),
                None => self.full.extend(self.open.take()),
            }
        }
        let mut piece = self.full.pop_front()?;
        if piece.effradius.is_empty() {
            piece.effradius = Radii::new(machine).now; // no command has any
        }
        Some(piece)
    }
    fn add(&mut self, segment: &Program) {
        let columns = self.sequencer.next(segment);
        let mut at = 0;
        while let Some(open) = &mut self.open
            && at < columns.kind.len()
        {
            let end = columns.kind.len().min(at + self.size - open.kind.len());
            (at..end).for_each(|row| open.push_row(&columns, row));
            at = end;
            if open.kind.len() == self.size {
                let start = columns.target[(at - 1) * columns.axes..at * columns.axes].to_vec();
                let next = SequenceColumns { axes: columns.axes, start, ..SequenceColumns::default() };
                self.full.extend(self.open.replace(next));
            }
        }
    }
}

impl SequenceColumns {
    /// Appends a command of another table.
    fn push_row(&mut self, from: &SequenceColumns, row: usize) {
        let a = self.axes;
        self.kind.push(from.kind[row]);
        self.line.push(from.line[row]);
        self.rapid.push(from.rapid[row]);
        self.target.extend_from_slice(&from.target[row * a..(row + 1) * a]);
        self.c1.push(from.c1[row]);
        self.c2.push(from.c2[row]);
        self.center.extend_from_slice(&from.center[row * 2..(row + 1) * 2]);
        self.phi.push(from.phi[row]);
        self.vl.push(from.vl[row]);
        self.ac.push(from.ac[row]);
        self.tvl.push(from.tvl[row]);
        let (first, count) = (from.via_first[row] as usize, from.via_count[row] as usize);
        self.via_first.push(self.via_line.len() as u32);
        self.via_count.push(count as u32);
        self.via_line.extend_from_slice(&from.via_line[first..first + count]);
        self.via_target.extend_from_slice(&from.via_target[first * a..(first + count) * a]);
        let of = usize::from(from.effradius_of[row]);
        let number = self.radii_row(&from.effradius[of * a..(of + 1) * a]);
        self.effradius_of.push(number);
    }
    /// Number of a row of effective radii, the newest first; a new one if it is not there.
    fn radii_row(&mut self, radii: &[f64]) -> u16 {
        let same = |row: &[f64]| row.iter().zip(radii).all(|(a, b)| a.to_bits() == b.to_bits());
        let rows = self.effradius.chunks_exact(self.axes);
        if let Some(number) = rows.enumerate().rev().find(|(_, row)| same(row)).map(|(number, _)| number) {
            return number as u16;
        }
        self.effradius.extend_from_slice(radii);
        (self.effradius.len() / self.axes - 1) as u16
    }
}
