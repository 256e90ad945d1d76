//! Canned cycles (docs/dialect.md, section 13): drilling along the normal of the plane.

use crate::block::{AXIS_LETTERS, Block, bit, mask};
use crate::codes::Group;
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::mfunc::dwell_seconds;
use crate::modal::{CycleWords, FeedMode};
use crate::target::Target;
use crate::translate::Translator;

/// One repetition of a cycle, in program coordinates of the drilling axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hole {
    slot: usize,
    pub bottom: f64,
    pub retract: f64,
    pub words: CycleWords,
}

impl Translator<'_> {
    /// Step 19 with a cycle active.
    pub(crate) fn cycle(&mut self, block: &Block, code: u16) -> Check<()> {
        self.used |= AXIS_LETTERS | mask("RQPKLF");
        let (pair, normal) = self.state.modal.plane.letters();
        let span = block.code_of(Group::Motion).map_or(block.span, |g| g.span);
        if self.state.modal.cylinder.is_some() {
            return Err(Fault::with(Id::GC321, span, &[&format!("G{}", crate::codes::number(code))]));
        }
        if self.state.modal.feed_mode == FeedMode::InverseTime {
            return Err(Fault::new(Id::GC323, span));
        }
        if let Some((_, word)) = block.first_of(mask("ABC")) {
            return Err(Fault::new(Id::GC324, word.span));
        }
        if code == 840 {
            self.check_tapping(block)?;
        }
        let slot = self.group.slot(normal).ok_or_else(|| Fault::with(Id::GC801, span, &[&char::from(normal)]))?;
        let words = self.cycle_words(block, code, slot, normal)?;
        let count = self.repetitions(block)?;
        for _ in 0..count {
            let level = self.state.program[slot];
            let retract = words.retract.expect("checked");
            let bottom = words.bottom.expect("checked");
            let hole = if self.state.modal.incremental {
                Hole { slot, retract: level + retract, bottom: level + retract + bottom, words }
            } else {
                Hole { slot, retract, bottom, words }
            };
            if hole.retract <= hole.bottom {
                return Err(Fault::new(Id::GC415, block.span_of(b'R')));
            }
            self.hole(block, code, &hole, pair)?;
        }
        Ok(())
    }
    /// Sticky words, new ones replacing the old.
    fn cycle_words(&mut self, block: &Block, code: u16, slot: usize, normal: u8) -> Check<CycleWords> {
        let mut words =
            self.state.cycle.unwrap_or(CycleWords { initial: self.state.program[slot], ..Default::default() });
        if block.has(normal) {
            words.bottom = Some(self.coordinate(block, normal, slot));
        }
        words.retract = self.length(block, b'R').or(words.retract);
        words.peck = self.length(block, b'Q').or(words.peck);
        if let Some(p) = block.word(b'P') {
            words.dwell_s = dwell_seconds(&self.dialect, b'P', p.value, p.integer_form);
        }
        let missing = |what: &str| Fault::with(Id::GC325, block.span, &[&what]);
        words.retract.ok_or_else(|| missing("R"))?;
        words.bottom.ok_or_else(|| missing("bottom"))?;
        if matches!(code, 730 | 830) && words.peck.is_none_or(|q| q <= 0.0) {
            let code = block.code_of(Group::Motion).map_or(block.span, |g| g.span);
            return Err(Fault::new(Id::GC416, block.word(b'Q').map_or(code, |w| w.span)));
        }
        self.state.cycle = Some(words);
        Ok(words)
    }
    fn repetitions(&mut self, block: &Block) -> Check<u32> {
        let letter = if block.has(b'L') { b'L' } else { b'K' };
        let Some(count) = block.whole(letter)? else { return Ok(1) };
        if (0..=9999).contains(&count) {
            return Ok(count as u32);
        }
        Err(Fault::with(Id::GC616, block.span_of(letter), &[&count]))
    }

    fn hole(&mut self, block: &Block, code: u16, hole: &Hole, pair: [u8; 2]) -> Check<()> {
        if self.state.program[hole.slot] < hole.retract {
            self.depth(block, hole, hole.retract, true)?;
        }
        let mut target = Target { program: self.state.program, machine: self.state.machine, named: 0 };
        for letter in pair.into_iter().filter(|l| block.mask & AXIS_LETTERS & bit(*l) != 0) {
            let (slot, relative) = self.slot_of(block, letter)?;
            let value = self.coordinate(block, letter, slot);
            let incremental = self.state.modal.incremental || relative;
            target.program[slot] = if incremental { target.program[slot] + value } else { value };
        }
        target.machine = self.state.frame.to_machine(&target.program);
        self.check_limits(block, &target.machine);
        self.line_to(block, &target, true)?;
        self.depth(block, hole, hole.retract, true)?;
        self.drill(block, code, hole)?;
        let out = if self.state.modal.return_to_r { hole.retract } else { hole.retract.max(hole.words.initial) };
        let slow = matches!(code, 850 | 890);
        if slow {
            self.depth(block, hole, hole.retract, false)?;
        }
        self.depth(block, hole, out, true)?;
        if code == 860 {
            self.spindle_again();
        }
        Ok(())
    }
    /// The way down.
    fn drill(&mut self, block: &Block, code: u16, hole: &Hole) -> Check<()> {
        if code == 840 {
            return self.tap(block, hole);
        }
        let clearance = self.dialect.peck_clearance.unwrap_or(if self.state.modal.inch { 0.04 * 25.4 } else { 1.0 });
        if let (Some(peck), 730 | 830) = (hole.words.peck, code) {
            let mut level = hole.retract;
            while level > hole.bottom {
                let next = (level - peck).max(hole.bottom);
                self.depth(block, hole, next, false)?;
                if next > hole.bottom {
                    if code == 830 {
                        self.depth(block, hole, hole.retract, true)?;
                        self.depth(block, hole, (next + clearance).min(hole.retract), true)?;
                    } else {
                        self.depth(block, hole, (next + clearance).min(hole.retract), true)?;
                    }
                }
                level = next;
                if self.sink.commands > self.options.limits.commands {
                    return Ok(());
                }
            }
        } else {
            self.depth(block, hole, hole.bottom, false)?;
        }
        if hole.words.dwell_s > 0.0 && matches!(code, 820 | 830 | 860 | 890 | 730) {
            self.wait_seconds(hole.words.dwell_s, Span::new(block.span.start as usize, block.span.end as usize))?;
        }
        if code == 860 {
            self.spindle_stop();
        }
        Ok(())
    }
    /// A move of the drilling axis alone.
    pub(crate) fn depth(&mut self, block: &Block, hole: &Hole, level: f64, rapid: bool) -> Check<()> {
        let target = self.level(block, hole, level);
        self.line_to(block, &target, rapid)
    }
    pub(crate) fn level(&mut self, block: &Block, hole: &Hole, level: f64) -> Target {
        let mut target = Target { program: self.state.program, machine: self.state.machine, named: 1 << hole.slot };
        target.program[hole.slot] = level;
        target.machine = self.state.frame.to_machine(&target.program);
        self.check_limits(block, &target.machine);
        target
    }
}
