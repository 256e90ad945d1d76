//! `check --strict`: what runs but smells (docs/dialect.md, section 24).

use crate::block::{Block, mask};
use crate::diagnostics::{Fault, Id, Span, columns};
use crate::index::definition;
use crate::program::Run;
use crate::sink::Circle;
use crate::source::Lines;
use crate::target::Target;
use crate::translate::Translator;

/// A feed that changes by more than this factor within a contour leaves a mark.
const FEED_JUMP: f64 = 4.0;
/// Arcs nearer than this to nothing or to a full circle hang on the last digit of their end point, degrees.
const NEAR: f64 = 1.0;
const NOTHING: f64 = 1e-6;

/// What the linter remembers from block to block.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lint {
    /// F of the feed move before, while the tool has not left the contour.
    feed: Option<f64>,
    /// Level that the last rapid along the normal of the plane went up to, program coordinates.
    retract: Option<f64>,
}

impl Translator<'_> {
    /// A straight move, before it is made.
    pub(crate) fn lint_line(&mut self, block: &Block, target: &Target, rapid: bool) {
        if !self.options.strict {
            return;
        }
        let (pair, normal) = self.state.modal.plane.letters();
        let (from, to) = (self.state.program, target.program);
        let across = pair.iter().filter_map(|l| self.group.slot(*l)).any(|s| (to[s] - from[s]).abs() > NOTHING);
        if !rapid && across {
            return self.lint_feed(block);
        }
        self.lint.feed = None; // a plunge has a feed of its own
        let Some(slot) = self.group.slot(normal).filter(|_| rapid) else { return };
        let before = self.lint.retract;
        if to[slot] > from[slot] + NOTHING {
            self.lint.retract = Some(to[slot]);
        }
        let level = from[slot].min(to[slot]);
        if let Some(retract) = before.filter(|r| across && level < r - NOTHING) {
            let unit = self.state.modal.unit();
            let args: [&dyn std::fmt::Display; 3] = [&char::from(normal), &round(level / unit), &round(retract / unit)];
            let span = block.first_of(mask("XYZUVW")).map_or(block.span, |w| w.1.span);
            self.faults.push(Fault::with(Id::GW943, span, &args));
        }
    }
    pub(crate) fn lint_arc(&mut self, block: &Block, circle: &Circle) {
        if !self.options.strict {
            return;
        }
        self.lint_feed(block);
        let sweep = circle.sweep.abs() % 360.0;
        if sweep > 0.0 && !(NEAR..=360.0 - NEAR).contains(&sweep) {
            self.faults.push(Fault::with(Id::GW942, block.span, &[&round(circle.sweep.abs())]));
        }
    }
    fn lint_feed(&mut self, block: &Block) {
        let Some(feed) = self.state.modal.feed.map(|f| f.mm).filter(|_| !block.has(b'E')) else { return };
        if let Some(before) = self.lint.feed.replace(feed)
            && block.has(b'F')
            && (feed > before * FEED_JUMP || before > feed * FEED_JUMP)
        {
            self.faults.push(Fault::with(Id::GW941, block.span_of(b'F'), &[&round(before), &round(feed)]));
        }
    }
}

/// Where a subprogram of the main file begins.
#[derive(Debug)]
pub(crate) struct Definition {
    line: u32,
    /// Of the line, in columns.
    columns: Span,
    name: String,
}

impl Run<'_, '_, '_> {
    /// Remembers what a line of the main file begins; a name that stands twice counts where it stands first.
    #[inline]
    pub(crate) fn note_definition(&mut self, line: u32, text: &[u8]) {
        if self.t.options.strict
            && let Some(name) = definition(text)
        {
            let columns = columns(text, Span::new(0, text.trim_ascii_end().len()));
            self.definitions.push(Definition { line, columns, name });
        }
    }
    /// GW944 for every subprogram of the main file that nobody called.
    pub(crate) fn lint_subprograms(&mut self) {
        if !self.t.options.strict {
            return;
        }
        if self.open.is_none() {
            self.definitions.clear();
            let mut lines = Lines::new(self.flows.main_source());
            while let Some((line, text)) = lines.next_line() {
                self.note_definition(line, text);
            }
        }
        let mut known = std::mem::take(&mut self.flows.called);
        for Definition { line, columns, name } in std::mem::take(&mut self.definitions) {
            let fault = Fault::with(Id::GW944, columns, &[&name]);
            if known.insert(name) && line > self.program_line {
                self.report_to_main(line, &fault);
            }
        }
    }
}

fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
