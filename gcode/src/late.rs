//! Findings that come when their line is behind: blocks slowed down by merging, hints about the whole program.

use crate::block::Block;
use crate::diagnostics::{Fault, Id, Place, Span};
use crate::program::Run;
use crate::source::Lines;

impl<'s> Run<'_, '_, 's> {
    /// GW926 for the blocks that were slowed down since the last call.
    #[cold]
    pub(crate) fn report_slowed(&mut self) {
        for (line, columns) in std::mem::take(&mut self.t.sink.slowed) {
            if columns != Span::default() || !self.reports.keeps_warnings() {
                self.report_columns(line, &Fault::new(Id::GW926, columns));
                continue;
            }
            // a block of another file is known by its call only
            let text = self.main_line(line);
            let span = Span::new(0, text.trim_ascii_end().len().max(1));
            self.report(line, text, &Fault::new(Id::GW926, span));
        }
    }
    /// A finding whose span is in columns.
    fn report_columns(&mut self, line: u32, fault: &Fault) {
        let (file_index, file) = self.flows.file();
        self.reports.add_columns(Place { file_index, file, line, text: b"" }, fault, fault.span);
    }
    /// Text of a line of the main file, read again.
    fn main_line(&mut self, line: u32) -> &'s [u8] {
        let mut lines = self.behind.take().filter(|lines| lines.mark().line <= line);
        let lines = lines.get_or_insert_with(|| Lines::new(self.flows.main_source()));
        let mut found: &'s [u8] = b" ";
        let mut before = lines.clone();
        while lines.mark().line <= line {
            before = lines.clone();
            let Some((_, text)) = lines.next_line() else { break };
            found = text;
        }
        self.behind = Some(before);
        found
    }

    /// Inch programs rarely reach farther than a metre and a half: the hint stands at the last G20 or G70.
    pub(crate) fn hint_inch(&mut self) {
        let reach = self.t.facts.high.iter().zip(&self.t.facts.low).map(|(h, l)| h.abs().max(l.abs()));
        let reach = reach.fold(0.0, f64::max) / 25.4;
        if !self.t.state.modal.inch || reach <= 60.0 {
            return;
        }
        let fault = Fault::with(Id::GW934, self.inch, &[&format!("{reach:.1}")]);
        self.report_columns(self.t.inch.0, &fault);
    }

    /// GW904 at the first word that is read as increments.
    pub(crate) fn note_increments(&mut self, line: u32, text: &[u8], block: &Block) {
        let letters = crate::block::AXIS_LETTERS | crate::block::CENTRE_LETTERS | crate::block::mask("RQ");
        let increment = self.t.dialect.integer_increment;
        if increment == 0.0 || self.told.increments {
            return;
        }
        if let Some((_, word)) = block.first_of(block.integer_letters(letters)) {
            self.told.increments = true;
            self.report(line, text, &Fault::with(Id::GW904, word.span, &[&increment]));
        }
    }
}
