//! What stands around the program on a tape: leader, `%` at its start and end.

use crate::block::{AXIS_LETTERS, Block, mask};
use crate::diagnostics::{Fault, Id, Span};
use crate::program::{Mode, Run};
use crate::source::{Lines, check_length};
use crate::statements::head_length;

/// Lines in which the first `%` is looked for.
pub(crate) const LEADER_LINES: usize = 50;

impl Run<'_, '_, '_> {
    /// `%`: start of the program, its end, or the start of another one.
    pub(crate) fn tape_mark(&mut self, line: u32, text: &[u8]) {
        let trimmed = text[head_length(text)..].trim_ascii();
        let name = trimmed[1..].trim_ascii();
        let span = Span::new(0, text.len());
        if !self.begun && !self.ended && !self.flows.starts_subprogram(name) {
            let foreign = [(&b"_N_"[..], "Sinumerik"), (b"MPF", "Sinumerik"), (b"PM", "Philips")];
            let found = foreign.iter().find(|f| name.to_ascii_uppercase().starts_with(f.0)).map(|f| f.1);
            if let Some(dialect) = found.or(name.ends_with(b"*").then_some("Heidenhain")) {
                self.report(line, text, &Fault::with(Id::GW903, span, &[&dialect]));
            }
            self.mode = Mode::Run;
            return;
        }
        if self.flows.depth() > 0 {
            self.flows.leave(&mut self.variables);
            return;
        }
        if !self.ended && self.begun && self.mode == Mode::Run {
            self.next_program();
        }
        self.mode = if name.is_empty() || name.starts_with(b"(") { Mode::Ignore } else { Mode::Read };
    }
    pub(crate) fn warn_missing_end(&mut self) {
        if self.t.options.mdi {
            return;
        }
        let (line, span, text) = self.last.clone();
        self.report(line, &text, &Fault::new(Id::GW909, Span { end: span.end.max(1), ..span }));
    }

    /// Leader text before the first `%` is not part of the program: the number of the first line that is. `lines`
    /// begin with the text and are 50 at least, or all.
    pub(crate) fn leader(&mut self, mut lines: Lines<'_>, block: &mut Block) -> u32 {
        let mut found = 1;
        let mut text_before = None;
        self.mode = Mode::Read;
        for _ in 0..LEADER_LINES {
            let Some((line, text)) = lines.next_line() else { break };
            if text.trim_ascii().starts_with(b"%") {
                found = line;
                break;
            }
            // a line that is too long is not worth parsing
            let too_long = check_length(text).is_err();
            if !too_long {
                self.read(line, text, block);
            }
            let bad = too_long || self.faults.iter().any(|f| !f.id.is_warning());
            self.faults.clear();
            if !bad && (block.has_any(AXIS_LETTERS | mask("TSF")) || !block.g.is_empty() || !block.m.is_empty()) {
                break;
            }
            if (bad || !block.is_empty()) && text_before.is_none() {
                text_before = Some((line, text));
            }
        }
        self.mode = Mode::Run;
        if let Some((line, text)) = text_before.filter(|_| found > 1) {
            self.report(line, text, &Fault::new(Id::GW901, Span::new(0, text.len())));
        }
        found
    }
}

/// `N890 %`, as Mach3 ends a tape.
pub(crate) fn is_numbered_mark(text: &[u8]) -> bool {
    text.trim_ascii_end().ends_with(b"%") && text[head_length(text)..].trim_ascii() == b"%"
}
