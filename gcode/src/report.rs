//! Findings of a program on their way to the reports.

use crate::block::Block;
use crate::diagnostics::{Fault, Id, Place};
use crate::program::{Mode, Run};

impl Run<'_, '_, '_> {
    /// Reports what the translator found in this block, and what merging slowed down.
    #[cold]
    pub(crate) fn settle(&mut self, line: u32, text: &[u8]) {
        let mut bad = false;
        for fault in std::mem::take(&mut self.t.faults) {
            bad |= !fault.id.is_warning();
            self.report(line, text, &fault);
        }
        if bad {
            self.t.sink.drop_program();
        }
        self.report_slowed();
    }
    /// Reports what reading the line found; true if the block cannot be executed.
    #[cold]
    pub(crate) fn report_all(&mut self, line: u32, text: &[u8], block: &Block) -> bool {
        let faults = std::mem::take(&mut self.faults);
        let bad = faults.iter().any(|f| !f.id.is_warning());
        for fault in &faults {
            if self.told_before(fault, text) || self.follows(fault) {
                continue;
            }
            self.report(line, text, fault);
        }
        if bad {
            self.any_block = true;
            self.doubts.note(text);
            self.t.sink.drop_program();
            if self.mode == Mode::Run && !self.is_skipped(block) {
                self.t.line = self.flows.source_line(line);
                self.salvage(block, text, &faults);
            }
        }
        bad
    }
    /// What concerns the dialect as a whole is told once: O-words, `*` at the end of each block.
    fn told_before(&mut self, fault: &Fault, text: &[u8]) -> bool {
        let star = fault.id == Id::GC107 && text.get(fault.span.start as usize) == Some(&b'*');
        fault.id == Id::GC611 && std::mem::replace(&mut self.told.oword, true)
            || star && std::mem::replace(&mut self.told.star, true)
    }
    pub(crate) fn report(&mut self, line: u32, text: &[u8], fault: &Fault) {
        let (file_index, file) = self.flows.file();
        self.reports.add(Place { file_index, file, line, text }, fault);
    }

    /// A finding in the main file; its span is in columns.
    pub(crate) fn report_to_main(&mut self, line: u32, fault: &Fault) {
        let place = Place { file_index: 0, file: self.flows.main_name(), line, text: b"" };
        self.reports.add_columns(place, fault, fault.span);
    }
}
