//! What a block with an error leaves behind (docs/dialect.md, section 0): its modal words and the end of its motion, as
//! far as they can be read, so that the rest of the program is judged without consequences of that error.

use crate::block::{AXIS_LETTERS, Block};
use crate::codes::Group;
use crate::diagnostics::{Fault, Id};
use crate::modal::{Feed, MotionMode};
use crate::program::Run;
use crate::translate::Translator;

/// Codes beside which axis words are no target of the block's motion.
const OTHER_TARGETS: [u16; 9] = [40, 280, 300, 520, 530, 680, 740, 920, 1070];

impl Translator<'_> {
    /// After an error in a block whose words are known: `cut` if its end was not read.
    #[cold]
    pub(crate) fn salvage(&mut self, block: &Block, faults: &[Fault]) {
        let found = self.faults.len();
        self.sink.tracking = None;
        // an error of its own in one of them leaves the others standing
        let _ = self.unit_and_feed(block);
        if let Some(g) = block.code_of(Group::Plane) {
            let _ = self.set_plane(g);
        }
        self.dimensions(block);
        let _ = self.spindle_speed(block, block.g(920));
        if let Some(word) = block.word(b'T') {
            self.select_tool(word.value as u32);
        }
        if block.m(6).is_some() {
            self.state.modal.in_spindle = self.state.modal.tool;
        }
        self.faults.truncate(found);
        self.salvage_motion(block);
        self.salvage_position(block, faults);
        let modal = &mut self.state.modal;
        if block.cut || faults.iter().any(|f| f.id == Id::GC504) {
            // F or S may have stood there
            modal.feed = modal.feed.or(Some(Feed { raw: 1.0, mm: 1.0 }));
            modal.speed = modal.speed.or(Some(1.0));
            modal.speed_limit = modal.speed_limit.or(Some(1.0));
        }
    }
    fn salvage_motion(&mut self, block: &Block) {
        match block.code_of(Group::Motion) {
            _ if block.refused_motion => self.state.modal.motion = MotionMode::Unknown,
            Some(g) => {
                self.set_motion(g);
                if matches!(self.state.modal.motion, MotionMode::Cycle(_) | MotionMode::Thread) {
                    // its sticky words may be the error
                    self.state.modal.motion = MotionMode::Unknown;
                }
            }
            None => {}
        }
    }
    /// The axes that the block names are where they were to go, or nobody knows where.
    fn salvage_position(&mut self, block: &Block, faults: &[Fault]) {
        let lexical = |f: &Fault| f.id < Id::GC301 || (Id::GC701..=Id::GC719).contains(&f.id);
        let moved_otherwise = block.g.iter().any(|g| OTHER_TARGETS.contains(&g.code.tenths));
        if block.cut || moved_otherwise || faults.iter().any(|f| lexical(f) && !f.id.is_warning()) {
            self.lose_position();
            return;
        }
        let doubtful = faults.iter().any(|f| is_about_ends(f.id) || f.id == Id::GC301) || block.refused_motion;
        let before = self.state.unknown;
        let Ok(target) = self.target(block) else {
            return self.lose_position();
        };
        (self.state.program, self.state.machine) = (target.program, target.machine);
        if doubtful {
            self.state.unknown = before | target.named;
        }
    }
    /// Nobody knows where the axes should be.
    pub fn lose_position(&mut self) {
        self.state.unknown = self.group.lettered();
    }
    /// A block behind a motion function that is not understood: only where it goes is of interest.
    #[cold]
    pub(crate) fn pass_over(&mut self, block: &Block) -> crate::diagnostics::Check<()> {
        self.used = u32::MAX;
        if block.has_any(AXIS_LETTERS) {
            let target = self.target(block)?;
            (self.state.program, self.state.machine) = (target.program, target.machine);
        }
        Ok(())
    }
}

/// Errors of an arc that may come from its start or end.
pub(crate) fn is_about_ends(id: Id) -> bool {
    matches!(id, Id::GC401 | Id::GC402 | Id::GC408 | Id::GC409 | Id::GC410)
}

/// What may follow from an error before, once a bad line may have set variables, or opened a loop.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Doubts {
    variables: bool,
    loops: bool,
}

impl Doubts {
    /// Notes what a line with an error may have done.
    #[cold]
    pub fn note(&mut self, text: &[u8]) {
        self.variables |= text.contains(&b'=');
        let statement = &text[crate::statements::head_length(text)..];
        let first = statement.iter().find(|b| !b.is_ascii_whitespace()).map(u8::to_ascii_uppercase);
        self.loops |= matches!(first, Some(b'W' | b'D' | b'E' | b'I' | b'O'));
    }
    fn explain(self, id: Id) -> bool {
        match id {
            Id::GC702 | Id::GC706 => self.variables,
            Id::GC606 | Id::GC607 | Id::GC608 => self.loops,
            _ => false,
        }
    }
}

impl Run<'_, '_, '_> {
    /// A bad block ends the program, or the subprogram, all the same.
    #[cold]
    pub(crate) fn salvage(&mut self, block: &Block, text: &[u8], faults: &[Fault]) {
        self.t.salvage(block, faults);
        self.note_inch(text);
        if block.m(2).or(block.m(30)).is_some() {
            self.program_end(Some("M30"));
        } else if block.m(99).or(block.m(17)).is_some() {
            self.flows.leave(&mut self.variables);
        }
    }
    /// Is this error only the consequence of one before?
    pub(crate) fn follows(&self, fault: &Fault) -> bool {
        self.doubts.explain(fault.id)
    }
}
