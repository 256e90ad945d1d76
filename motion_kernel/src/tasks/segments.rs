//! Programs that come in segments while they are executed.

use std::fmt;
use std::sync::Arc;

use crate::autocode::Program;
use crate::mcu::Mcu;
use crate::tasks::Task;

/// Where the segments of a program come from.
pub struct Segments {
    source: Box<dyn FnMut() -> Option<Arc<Program>> + Send + Sync>,
    taken: u64,
}

impl Segments {
    /// `source` gives the next segment, as soon as it is there; `None` behind the last. Each has instructions and pools
    /// of its own, and no jump leaves it.
    pub fn new(source: impl FnMut() -> Option<Arc<Program>> + Send + Sync + 'static) -> Self {
        Segments { source: Box::new(source), taken: 0 }
    }
    /// The next segment that has instructions.
    pub(super) fn next(&mut self) -> Option<Arc<Program>> {
        self.taken += 1;
        std::iter::from_fn(&mut self.source).find(|segment| !segment.code.is_empty())
    }
    /// The first segment is gone.
    pub(super) fn has_begun(&self) -> bool {
        self.taken > 1
    }
}

impl Task {
    /// Goes on with the segment behind the one that is done, once it is there: however long it takes, no time passes.
    #[cold]
    pub(super) fn next_segment(&mut self, program: &mut Arc<Program>) {
        if let Some(next) = self.segments.as_mut().and_then(Segments::next) {
            (*program, self.pc) = (next, 0);
        }
    }
}

impl fmt::Debug for Segments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Segments(taken: {})", self.taken)
    }
}

impl Mcu {
    /// Loads a program that comes in segments into a task (0..3): it is executed as if it were whole. The task waits
    /// for a segment between two statements of a sample, so that emulated time does not depend on when it comes.
    /// Such a program can be started until its first segment is done; later that is runtime error 128.
    pub fn load_segments(&mut self, task: usize, mut segments: Segments) {
        self.load(task, segments.next().unwrap_or_default());
        self.tasks[task].segments = Some(segments);
    }
}
