//! A path that is appended to while it is followed, and forgets what lies behind: it stays as short as the program that
//! is between translation and motion.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::follower::Follower;
use crate::path::{JOINS, Merged, Path, WIDTHS, padded};
use crate::segment::LINE;
use crate::sequence::{PathError, SequenceView};
use crate::tracker::{Tracker, TrackerOptions};

/// A motion command of a sequence, and the row of axis scales that holds for it.
#[derive(Clone, Copy)]
pub(crate) struct Of<'a> {
    pub sequence: &'a SequenceView<'a>,
    pub i: usize,
    pub row: u16,
}

/// Set by whoever finds the path over before he has seen enough of it: what is still to be appended may count.
#[derive(Debug, Default)]
pub(crate) struct EndSeen(AtomicBool);

impl EndSeen {
    #[cold]
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
    /// True if it was set since the last call.
    #[inline]
    pub fn take(&self) -> bool {
        self.0.load(Ordering::Relaxed) && self.0.swap(false, Ordering::Relaxed)
    }
}

impl Clone for EndSeen {
    fn clone(&self) -> Self {
        EndSeen::default()
    }
}

impl Path {
    /// A path to be appended to: it begins at `start`, axis units. [`Path::close`] ends it.
    pub fn begin(start: &[f64]) -> Result<Path, PathError> {
        let axes = start.len();
        let Some(&width) = WIDTHS.iter().find(|&&w| w >= axes && axes > 0) else {
            return Err(PathError::Axes { found: axes });
        };
        Ok(Path {
            axes,
            width,
            segments: Vec::new(),
            starts: Vec::new(),
            slopes: Vec::new(),
            circles: Vec::new(),
            rings: Vec::new(),
            apart: Vec::new(),
            scales: Vec::new(),
            blocks: Vec::new(),
            start: start.to_vec(),
            end: padded(start, width),
            commands: 0,
            merged: Merged::default(),
            gone: 0,
            length: 0.0,
            arc_end_error_mm: 0.0,
            end_seen: EndSeen::default(),
        })
    }
    pub(crate) fn reserve(&mut self, commands: usize) {
        self.segments.reserve(commands);
        self.blocks.reserve(commands);
        self.starts.reserve(commands * self.width);
        self.slopes.reserve(commands * self.width);
    }

    /// The next motion commands; `sequence.start` is not looked at again.
    pub fn append(&mut self, sequence: &SequenceView) -> Result<(), PathError> {
        sequence.check().map_err(|error| error.behind(self.commands))?;
        let (axes, width, first) = (self.axes, self.width, self.blocks.len());
        if sequence.axes != axes {
            return Err(PathError::Axes { found: sequence.axes });
        }
        let rows = self.rows(sequence)?;
        let mut from = std::mem::take(&mut self.end);
        for i in 0..sequence.len() {
            let target = padded(&sequence.target[i * axes..(i + 1) * axes], width);
            let of = Of { sequence, i, row: rows[usize::from(sequence.effradius_of[i])] };
            if let Some(begin) = sequence.space.begin.get(i * axes..(i + 1) * axes) {
                let begin = padded(begin, width);
                if begin.iter().zip(&from).any(|(a, b)| (a - b).abs() > JOINS) {
                    self.apart.push(self.segments.len());
                }
                from = begin;
            }
            match sequence.kind[i] {
                0 => self.push_line(of, &from, &target),
                2 => self.push_ring(of, &from, &target)?,
                _ => self.push_circle(of, &from, &target)?,
            }
            from = target;
        }
        self.end = from;
        self.commands += sequence.len();
        if let Some(block) = self.blocks[first..].iter().find(|block| !block.length.is_finite()) {
            let (command, line) = (block.entry as usize, block.line);
            return Err(PathError::Value { command, line, what: "the move is longer than numbers reach" });
        }
        Ok(())
    }
    /// Nothing more will be appended.
    pub fn close(&mut self) {
        if self.segments.is_empty() {
            self.push_point();
        }
    }

    /// The rows of `scales` that the rows of effective radii stand in, new ones added.
    fn rows(&mut self, sequence: &SequenceView) -> Result<Vec<u16>, PathError> {
        let mut rows = Vec::new();
        for radii in sequence.effradius.chunks_exact(self.axes) {
            let mut scale: Vec<f64> = radii.iter().map(|r| if r.is_nan() { 1.0 } else { r.to_radians() }).collect();
            scale.resize(self.width, 0.0);
            let known = self.scales.chunks_exact(self.width).position(|row| row == scale);
            let row = known.unwrap_or_else(|| {
                self.scales.extend(scale);
                self.scales.len() / self.width - 1
            });
            let what = "more effective radii than can be told apart";
            rows.push(u16::try_from(row).map_err(|_| PathError::Value { command: self.commands, line: 0, what })?);
        }
        Ok(rows)
    }

    /// Forgets the first `count` segments and their blocks: what comes behind is numbered from 0 again. False: nothing is.
    pub(crate) fn forget(&mut self, count: usize) -> bool {
        let Some(next) = self.segments.get(count).filter(|_| self.rings.is_empty() && self.apart.is_empty()) else {
            return false; // what only rw_SymPas jobs have, which come whole
        };
        let block = next.block;
        let circle = self.segments[..count].iter().rev().find(|s| s.circle != LINE).map_or(0, |s| s.circle + 1);
        self.segments.drain(..count);
        self.starts.drain(..count * self.width);
        self.slopes.drain(..count * self.width);
        self.circles.drain(..circle as usize);
        self.blocks.drain(..block as usize);
        self.gone += block;
        for segment in &mut self.segments {
            segment.block -= block;
            if segment.circle != LINE {
                segment.circle -= circle;
            }
        }
        true
    }
    /// Keeps the geometry up to a segment only; lengths and figures stay.
    pub(crate) fn cut_behind(&mut self, segment: usize) {
        let Some(last) = self.segments.get(segment) else { return };
        let block = last.block as usize;
        self.segments.truncate(segment + 1);
        self.starts.truncate((segment + 1) * self.width);
        self.slopes.truncate((segment + 1) * self.width);
        let circles = self.segments.iter().rev().find(|s| s.circle != LINE).map_or(0, |s| s.circle + 1);
        self.circles.truncate(circles as usize);
        self.blocks.truncate(block + 1);
    }
}

/// Appends what follows to a path and tells whether there was anything; it may wait for it.
type More = Box<dyn FnMut(&mut Path) -> Result<bool, PathError> + Send + Sync>;

/// Where the rest of a path comes from.
pub(crate) struct Growth {
    more: More,
    ended: bool,
    error: Option<PathError>,
}

impl fmt::Debug for Growth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Growth(ended: {}, error: {:?})", self.ended, self.error)
    }
}

impl Tracker {
    /// As [`Tracker::new`], for a path that is appended to as it is needed: `more` appends what follows, and is asked
    /// until it returns false. What lies behind is forgotten, so nothing is collected per block and over path length.
    pub fn growing(
        path: Path,
        options: TrackerOptions,
        more: impl FnMut(&mut Path) -> Result<bool, PathError> + Send + Sync + 'static,
    ) -> Tracker {
        let mut tracker = Tracker::new(Arc::new(path), TrackerOptions { buckets: 1, passages: false, ..options });
        tracker.blocks = Vec::new();
        tracker.growth = Some(Growth { more: Box::new(more), ended: false, error: None });
        tracker
    }
    /// Why the rest of the path is none; the path then ends before it.
    pub fn path_error(&self) -> Option<&PathError> {
        self.growth.as_ref().and_then(|growth| growth.error.as_ref())
    }
    /// A foot came to the end of what is known of the path, or its evidence would, and there may be more.
    #[inline]
    pub(crate) fn is_short(&self, path: &Path, at: &Follower, actual: bool) -> bool {
        let Some(growth) = &self.growth else { return false };
        let short = path.end_seen.take();
        !growth.ended && (short || self.evidence.is_short(path, at, actual))
    }
    /// Appends what follows, and forgets what lies behind both feet, as soon as it is the greater part.
    #[cold]
    pub(crate) fn grow(&mut self, path: Arc<Path>) -> Arc<Path> {
        drop(path);
        let own = Arc::make_mut(&mut self.path);
        let feet = [&mut self.setpoint.follower.foot, &mut self.actual.follower.foot];
        let behind = feet[0].segment.min(feet[1].segment).min(self.evidence.first_segment());
        if behind > own.segments.len() / 2 && own.forget(behind) {
            self.evidence.forget(behind);
            for foot in feet {
                foot.segment -= behind;
            }
        }
        if let Some(growth) = self.growth.as_mut().filter(|growth| !growth.ended) {
            growth.ask(own);
            self.evidence.grown(own, growth.ended);
        }
        Arc::clone(&self.path)
    }
    /// The rest of the path, of which only the figures count.
    pub(crate) fn grow_to_end(&mut self) {
        while self.growth.as_ref().is_some_and(|growth| !growth.ended) {
            drop(self.grow(Arc::clone(&self.path)));
            let last = self.setpoint.follower.foot.segment.max(self.actual.follower.foot.segment);
            Arc::make_mut(&mut self.path).cut_behind(last);
        }
    }
}

impl Growth {
    fn ask(&mut self, path: &mut Path) {
        let more = (self.more)(path);
        self.ended = !matches!(more, Ok(true));
        self.error = more.err();
        if self.ended {
            path.close();
        }
    }
}
