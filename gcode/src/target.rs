//! Words of a block -> lengths, coordinates and the target of a motion (docs/dialect.md, sections 4 and 10).

use crate::block::{AXIS_LETTERS, Block};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::group::Point;
use crate::modal::MotionMode;
use crate::translate::Translator;

/// A resolved target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub program: Point,
    pub machine: Point,
    /// Slots that the block names.
    pub named: u32,
}

impl Translator<'_> {
    /// Columns of the block in the main file; empty for one of another file.
    #[inline]
    pub(crate) fn place(&self, block: &Block) -> Span {
        if self.in_main { block.columns } else { Span::default() }
    }
    /// A length word in mm.
    pub(crate) fn length(&self, block: &Block, letter: u8) -> Option<f64> {
        block.word(letter).map(|w| self.increments(w.value, w.integer_form) * self.state.modal.unit())
    }
    /// Numbers without point are least increments, if the dialect says so.
    #[inline]
    pub(crate) fn increments(&self, value: f64, integer_form: bool) -> f64 {
        if integer_form && self.dialect.integer_increment > 0.0 {
            value * self.dialect.integer_increment
        } else {
            value
        }
    }
    /// An axis word as a program coordinate: mm or degrees.
    #[inline]
    pub(crate) fn coordinate(&self, block: &Block, letter: u8, slot: usize) -> f64 {
        let Some(word) = block.word(letter) else { return 0.0 };
        let value = self.increments(word.value, word.integer_form);
        if self.group.axes[slot].rotary {
            return value;
        }
        let value = value * self.state.modal.unit();
        if self.state.modal.diameter && matches!(letter, b'X' | b'U') { value * 0.5 } else { value }
    }
    /// The slot of an axis word, and whether it is an incremental U V W.
    #[inline]
    pub(crate) fn slot_of(&self, block: &Block, letter: u8) -> Check<(usize, bool)> {
        if let Some(slot) = self.group.slot(letter) {
            return Ok((slot, false));
        }
        let main = letter.wrapping_sub(b'U').wrapping_add(b'X');
        if self.dialect.uvw_incremental
            && matches!(letter, b'U' | b'V' | b'W')
            && let Some(slot) = self.group.slot(main)
        {
            return Ok((slot, true));
        }
        let excluded = self.machine.axes.iter().any(|a| a.letter.is_none() && a.name.as_bytes() == [letter]);
        let id = if excluded { Id::GC802 } else { Id::GC801 };
        Err(Fault::with(id, block.span_of(letter), &[&char::from(letter)]))
    }

    /// The target that the axis words name.
    #[inline]
    pub(crate) fn target(&mut self, block: &Block) -> Check<Target> {
        let mut target = Target { program: self.state.program, machine: self.state.machine, named: 0 };
        let plain = self.state.frame.is_plain();
        let mut letters = block.mask & AXIS_LETTERS;
        while letters != 0 {
            let letter = b'A' + letters.trailing_zeros() as u8;
            letters &= letters - 1;
            let (slot, relative) = self.slot_of(block, letter)?;
            let value = self.coordinate(block, letter, slot);
            if self.state.modal.incremental || relative {
                target.program[slot] += value;
                target.machine[slot] += value;
            } else {
                let value = if self.group.axes[slot].modulo { self.short_way(slot, value) } else { value };
                target.program[slot] = value;
                target.machine[slot] = value + self.state.frame.shift()[slot];
                self.state.unknown &= !(1 << slot);
            }
            target.named |= 1 << slot;
        }
        if !plain {
            target.machine = self.state.frame.to_machine(&target.program);
        }
        self.used |= AXIS_LETTERS;
        self.target_program = target.program;
        Ok(target)
    }

    /// A rotary axis under G00 G90 goes to the nearest equal angle, at half a turn in the positive sense.
    #[cold]
    fn short_way(&self, slot: usize, value: f64) -> f64 {
        if self.state.modal.motion != MotionMode::Rapid {
            return value;
        }
        let from = self.state.program[slot];
        let way = (value - from).rem_euclid(360.0);
        from + if way > 180.0 { way - 360.0 } else { way }
    }
}
