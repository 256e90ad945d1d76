//! Radius correction on its way to autocode: holds one block back until the next one fixes its end.

use motion_kernel::axes::AxisSet;

use crate::arc;
use crate::correction::{Corner, Element, Offset, Piece, Vector, Watch};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::motion::outside;
use crate::segments::Direct;
use crate::sink::{Circle, Motion, Sink};

/// What stands between the block that is held back and the next one.
#[derive(Clone, Debug)]
pub(crate) enum Held {
    /// A motion of other axes only.
    Motion(Motion),
    Ssf(u32, AxisSet, u16, f64, bool),
    Event(u32, String, String),
    Direct(u32, Direct),
    Stop,
    Flush,
}

/// The block whose corrected end is not known yet.
#[derive(Clone, Debug)]
struct Pending {
    motion: Motion,
    element: Element,
    from: Vector,
    lead_in: bool,
}

/// State of an active correction.
#[derive(Clone, Debug)]
pub(crate) struct Tracking {
    slots: [usize; 2],
    offset: Offset,
    pending: Option<Pending>,
    held: Vec<Held>,
    watch: Watch,
    /// The next motion in the plane leads onto the contour.
    lead_in: bool,
    /// G40 was given: the next motion in the plane leads away from it.
    off: bool,
    /// End of the contour as programmed.
    programmed: Vector,
}

const NOTHING: f64 = 1e-9;

impl Sink {
    /// G41 or G42 acts: targets are not where the axes go.
    pub fn is_correcting(&self) -> bool {
        self.tracking.as_ref().is_some_and(|t| !t.off)
    }
    /// Axes stand beside the programmed path.
    pub fn is_displaced(&self) -> bool {
        self.tracking.is_some()
    }
    pub(crate) fn is_holding(&self) -> bool {
        self.tracking.as_ref().is_some_and(|t| t.pending.is_some())
    }
    /// True if the action has to wait for the block that is held back.
    pub(crate) fn hold(&mut self, action: impl FnOnce() -> Held) -> bool {
        match &mut self.tracking {
            Some(t) if t.pending.is_some() => {
                t.held.push(action());
                true
            }
            _ => false,
        }
    }

    /// G41, G42: `programmed` is the present end of the path in the plane; `offset` > 0 is left of it.
    pub(crate) fn start_correction(
        &mut self,
        slots: [usize; 2],
        offset: f64,
        programmed: Vector,
        span: Span,
    ) -> Check<()> {
        self.finish_pending(span)?;
        let (offset, held, watch) = (Offset(offset), Vec::new(), Watch::default());
        self.tracking =
            Some(Tracking { slots, offset, pending: None, held, watch, lead_in: true, off: false, programmed });
        Ok(())
    }
    /// G40: the contour ends beside its last point.
    pub(crate) fn stop_correction(&mut self, span: Span) -> Check<()> {
        self.finish_pending(span)?;
        if let Some(t) = &mut self.tracking {
            t.off = true;
        }
        Ok(())
    }
    /// End of the program: nothing more will come.
    pub(crate) fn close_correction(&mut self, span: Span) -> Check<()> {
        let result = self.finish_pending(span);
        self.tracking = None;
        result
    }
    fn finish_pending(&mut self, span: Span) -> Check<()> {
        let Some(t) = &mut self.tracking else { return Ok(()) };
        let Some(p) = t.pending.take() else { return Ok(()) };
        let end = t.offset.beside_end(&p.element);
        self.write_pending(&p, Corner { end, link: None, start: end }, None, span)
    }

    /// A motion while a correction is active.
    pub(crate) fn track(&mut self, motion: Motion, span: Span) -> Check<()> {
        let t = self.tracking.as_mut().expect("the caller looked");
        let end = t.slots.map(|s| motion.target[s]);
        let element = Element { start: t.programmed, end, arc: motion.circle.map(|c| (c.centre, c.sweep)) };
        if element.is_nothing() {
            t.watch.clear();
            if !self.hold(|| Held::Motion(motion)) {
                self.beside(motion);
            }
            return Ok(());
        }
        t.programmed = end;
        if (t.off || t.lead_in) && element.arc.is_some() {
            return Err(Fault::with(Id::GC419, span, &[&"an arc as first or last move"]));
        }
        if t.off {
            let from = t.slots.map(|s| self.position[s]);
            self.tracking = None;
            return self.write_piece(&motion, &Piece { start: from, end, arc: None }, span);
        }
        if t.lead_in {
            (t.lead_in, t.pending) = (false, None);
            t.watch.begin();
            let from = t.slots.map(|s| self.position[s]);
            t.pending = Some(Pending { motion, element, from, lead_in: true });
            return Ok(());
        }
        self.next_element(motion, element, span)
    }
    fn next_element(&mut self, motion: Motion, element: Element, span: Span) -> Check<()> {
        let t = self.tracking.as_mut().expect("the caller looked");
        t.offset.check(&element, span)?;
        t.watch.element(&element, t.offset.0.abs(), span)?;
        let p = t.pending.take();
        let from = match &p {
            Some(p) if p.lead_in => {
                let start = t.offset.beside_start(&element);
                self.write_pending(p, Corner { end: start, link: None, start }, Some(&motion), span)?;
                start
            }
            Some(p) => {
                let corner = t.offset.corner(&p.element, &element, span)?;
                self.write_pending(p, corner, Some(&motion), span)?;
                corner.start
            }
            None => t.offset.beside_start(&element),
        };
        let pending = Pending { motion, element, from, lead_in: false };
        self.tracking.as_mut().expect("still active").pending = Some(pending);
        Ok(())
    }

    /// Writes the block that was held back, the arc about its corner, and what waited behind it.
    fn write_pending(&mut self, p: &Pending, corner: Corner, next: Option<&Motion>, span: Span) -> Check<()> {
        let t = self.tracking.as_mut().expect("the caller looked");
        let radius = t.offset.0.abs();
        let held = std::mem::take(&mut t.held);
        let piece = if p.lead_in {
            Piece { start: p.from, end: corner.end, arc: None }
        } else {
            let piece = t.offset.piece(&p.element, p.from, corner.end, span)?;
            t.watch.piece(&piece, radius, span)?;
            piece
        };
        if let Some(link) = &corner.link {
            t.watch.piece(link, radius, span)?;
        }
        self.write_piece(&p.motion, &piece, span)?;
        if let Some(link) = corner.link {
            let rapid = p.motion.rapid || next.is_some_and(|n| n.rapid);
            let link = if rapid { Piece { arc: None, ..link } } else { link };
            self.write_piece(&Motion { rapid, exact: false, ..p.motion }, &link, span)?;
        }
        for action in held {
            self.release(action);
        }
        Ok(())
    }
    fn release(&mut self, action: Held) {
        match action {
            Held::Motion(motion) => self.beside(motion),
            Held::Ssf(line, axes, command, value, wait) => self.ssf(line, axes, command, value, wait),
            Held::Event(line, kind, text) => self.event(line, &kind, &text),
            Held::Direct(line, what) => self.direct(line, what),
            Held::Stop => self.stop(),
            Held::Flush => self.flush(),
        }
    }
    /// A motion of other axes: the plane stays where the correction has put it.
    fn beside(&mut self, mut motion: Motion) {
        let slots = self.tracking.as_ref().map_or([0, 1], |t| t.slots);
        for slot in slots {
            motion.target[slot] = self.position[slot];
        }
        motion.length = self.group.distance(&self.position, &motion.target);
        if motion.length >= NOTHING {
            self.reach(&motion.target);
            self.pass(motion);
        }
    }
    /// A motion with another way in the plane.
    fn write_piece(&mut self, template: &Motion, piece: &Piece, span: Span) -> Check<()> {
        let slots = self.plane;
        let mut motion = Motion { circle: None, slack: 0.0, ..*template };
        (motion.target[slots[0]], motion.target[slots[1]]) = (piece.end[0], piece.end[1]);
        let start = slots.map(|s| self.position[s]);
        if let Some((centre, sweep)) = piece.arc {
            let radius = (start[0] - centre[0]).hypot(start[1] - centre[1]);
            motion.circle = Some(Circle { slots, centre, sweep, radius });
            self.check_corrected(&arc::bounds(start, centre, sweep, piece.end), span)?;
        }
        self.check_corrected(&[0, 1].map(|i| (piece.end[i], piece.end[i])), span)?;
        let lengths = crate::feed::Lengths::of(&self.group, &self.position, &motion.target, motion.circle.as_ref());
        motion.length = lengths.path;
        if motion.rapid && motion.length >= NOTHING {
            motion.vl = self.group.rapid_speed(&self.position, &motion.target, motion.length);
        }
        if motion.length >= NOTHING {
            self.reach(&motion.target);
            self.pass(motion);
        }
        Ok(())
    }
    /// GC413 for the corrected path.
    fn check_corrected(&mut self, bounds: &[(f64, f64); 2], span: Span) -> Check<()> {
        for (slot, (low, high)) in self.plane.into_iter().zip(bounds) {
            self.low[slot] = self.low[slot].min(*low);
            self.high[slot] = self.high[slot].max(*high);
            let axis = &self.group.axes[slot];
            let Some((least, most)) = axis.limits else { continue };
            let bad = |v: &&f64| !(**v >= least - NOTHING && **v <= most + NOTHING);
            if let Some(worst) = [low, high].into_iter().find(bad) {
                let note = " (tool centre)";
                return Err(outside(char::from(axis.letter), *worst, (least, most), note, span));
            }
        }
        Ok(())
    }
}
