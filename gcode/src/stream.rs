//! A translator thread that runs ahead of those who use its segments: a controller that executes them, a tracker that
//! builds the path from them.

use std::collections::VecDeque;
use std::io::{self, Read};
use std::panic::resume_unwind;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use motion_kernel::autocode::{HostEvent, Instr, MoveKind, Program};
use motion_kernel::machine::Machine;

use crate::dialect::Options;
use crate::once::{Input, Open, WINDOW, compile_once};
use crate::program::Compiled;
use crate::segments::Deliver;

/// Instructions of a segment: a few spoolers full in all are ahead.
const SEGMENT: u32 = 4096;
/// Segments that wait at most, while nobody waits for one.
const AHEAD: usize = 4;

/// Commands so far: motion by kind in the order of [`MoveKind::ALL`], spool functions by axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub moves: [usize; MoveKind::ALL.len()],
    pub functions: usize,
}

impl Counts {
    pub fn add(&mut self, program: &Program) {
        for instr in &program.code {
            match *instr {
                Instr::Spool(n) => self.moves[program.moves[n as usize].kind as usize] += 1,
                Instr::Ssf(n) => self.functions += program.ssfs[n as usize].axes.len(),
                _ => {}
            }
        }
    }
}

/// What translator and users share.
#[derive(Default)]
struct State {
    /// Segments that someone still has to take; `gone` have been taken by all.
    segments: VecDeque<Arc<Program>>,
    gone: usize,
    /// Segments that each user has taken; a user that went away needs none.
    taken: Vec<usize>,
    waiting: usize,
    over: bool,
    cancelled: bool,
    counts: Counts,
    /// Host events from number `first_event` on.
    events: VecDeque<HostEvent>,
    first_event: usize,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
    fn wait<'a>(&self, state: MutexGuard<'a, State>) -> MutexGuard<'a, State> {
        self.changed.wait(state).unwrap_or_else(PoisonError::into_inner)
    }
    /// A new segment. It waits while enough are ahead, unless a user waits: of two users one may need far more.
    fn push(&self, segment: Program) {
        let mut state = self.state();
        while !state.cancelled && state.waiting == 0 && state.segments.len() >= AHEAD {
            state = self.wait(state);
        }
        if state.cancelled {
            return;
        }
        state.counts.add(&segment);
        state.events.extend(segment.events.iter().cloned());
        state.segments.push_back(Arc::new(segment));
        self.forget_taken(&mut state);
        self.changed.notify_all();
    }
    fn forget_taken(&self, state: &mut State) {
        let all = state.taken.iter().copied().min().unwrap_or(usize::MAX);
        while state.gone < all && state.segments.pop_front().is_some() {
            state.gone += 1;
        }
    }
    fn end(&self) {
        self.state().over = true;
        self.changed.notify_all();
    }
}

/// The segments of a program for one of its users.
pub struct Segments {
    shared: Arc<Shared>,
    user: usize,
}

impl Iterator for Segments {
    type Item = Arc<Program>;

    /// The next segment, as soon as it is there; `None` behind the last, and where an error ended the translation.
    fn next(&mut self) -> Option<Arc<Program>> {
        let mut state = self.shared.state();
        while !state.cancelled {
            let at = state.taken[self.user].checked_sub(state.gone)?;
            if let Some(segment) = state.segments.get(at).cloned() {
                state.taken[self.user] += 1;
                self.shared.forget_taken(&mut state);
                self.shared.changed.notify_all();
                return Some(segment);
            }
            if state.over || state.taken[self.user] == usize::MAX {
                return None;
            }
            state.waiting += 1;
            self.shared.changed.notify_all();
            state = self.shared.wait(state);
            state.waiting -= 1;
        }
        None
    }
}

/// How a translation ended; the program has gone to the users.
pub type Outcome = io::Result<Compiled>;

/// A translation that goes on in a thread of its own. Dropped, it stops.
pub struct Stream {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Outcome>>,
}

impl Stream {
    /// Begins to translate what `open` opens, for so many users. Each must take its segments, or be sent away.
    pub fn start(
        open: Box<Open<'static>>,
        filename: String,
        machine: Arc<Machine>,
        options: Options,
        users: usize,
    ) -> io::Result<(Stream, Vec<Segments>)> {
        let shared = Arc::new(Shared::default());
        shared.state().taken = vec![0; users];
        let own = End(shared.clone());
        let translate = move || own.translate(&*open, &filename, &machine, &options);
        let thread = std::thread::Builder::new().name("translator".to_owned()).spawn(translate)?;
        let segments = (0..users).map(|user| Segments { shared: shared.clone(), user }).collect();
        Ok((Stream { shared, thread: Some(thread) }, segments))
    }
    /// The user takes no more segments.
    pub fn send_away(&self, user: usize) {
        let mut state = self.shared.state();
        state.taken[user] = usize::MAX;
        self.shared.forget_taken(&mut state);
        self.shared.changed.notify_all();
    }
    /// Commands translated so far.
    pub fn counts(&self) -> Counts {
        self.shared.state().counts
    }
    /// Host event by its number from 0. They come in order: those before it are forgotten.
    pub fn event(&self, number: usize) -> Option<HostEvent> {
        let mut state = self.shared.state();
        while state.first_event < number && state.events.pop_front().is_some() {
            state.first_event += 1;
        }
        number.checked_sub(state.first_event).and_then(|at| state.events.get(at).cloned())
    }
    /// How it ended, once it has. `None` the second time. A panic of the translator goes on here.
    pub fn finish(&mut self) -> Option<Outcome> {
        self.thread.take().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        self.shared.state().cancelled = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            drop(thread.join()); // a panic of it has nobody left to be told
        }
    }
}

/// The translator's side: whatever ends it, the users learn of it.
struct End(Arc<Shared>);

impl End {
    fn translate(&self, open: &Open<'_>, filename: &str, machine: &Machine, options: &Options) -> Outcome {
        let shared = self.0.clone();
        let deliver = Deliver { every: SEGMENT, to: Box::new(move |segment| shared.push(segment)) };
        let open =
            || -> io::Result<Input<'static>> { Ok(Box::new(Cancellable { input: open()?, shared: self.0.clone() })) };
        let mut outcome = compile_once(&open, filename, machine, options, Some(deliver), WINDOW);
        if let Ok(compiled) = &mut outcome
            && let Some(last) = compiled.program.take()
        {
            self.0.push(last);
        }
        outcome
    }
}

impl Drop for End {
    fn drop(&mut self) {
        self.0.end();
    }
}

/// Reading ends when nobody is interested any more.
struct Cancellable {
    input: Input<'static>,
    shared: Arc<Shared>,
}

impl Read for Cancellable {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.shared.state().cancelled {
            return Err(io::Error::other("cancelled"));
        }
        self.input.read(into)
    }
}
