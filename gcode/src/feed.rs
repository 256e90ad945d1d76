//! Path speed of a block (docs/dialect.md, section 8): TRVL = L_c / T.

use crate::block::Block;
use crate::diagnostics::{Check, Fault, Id};
use crate::group::{ContourGroup, Point};
use crate::modal::FeedMode;
use crate::sink::Circle;
use crate::translate::Translator;

/// Lengths of a block: the one the controller counts, and the one that F refers to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// L_c: all axes, rotary ones with effradius.
    pub path: f64,
    /// L_f: linear axes; rotary ones in degrees if nothing else moves.
    pub feed: f64,
    /// No linear axis moves.
    pub rotary_only: bool,
    /// Only axes move that do not count for the path (NFRAX).
    pub without_feed: bool,
}

impl Lengths {
    pub fn of(group: &ContourGroup, from: &Point, to: &Point, circle: Option<&Circle>) -> Self {
        let (mut linear, mut rotary, mut degrees, mut uncounted) = (0.0, 0.0, 0.0, 0.0);
        for (slot, axis) in group.axes.iter().enumerate() {
            if circle.is_some_and(|c| c.slots.contains(&slot)) {
                continue;
            }
            let d = to[slot] - from[slot];
            if axis.rotary && !axis.on_surface {
                *(if axis.counts { &mut rotary } else { &mut uncounted }) += (d * axis.metric).powi(2);
                degrees += d * d;
            } else {
                linear += (d * axis.metric).powi(2);
            }
        }
        if let Some(circle) = circle {
            linear += (circle.radius * circle.sweep.to_radians()).powi(2);
        }
        let rotary_only = linear == 0.0;
        let feed = if rotary_only { degrees } else { linear };
        let counted = linear + rotary;
        let without_feed = counted == 0.0 && uncounted > 0.0;
        let path = if without_feed { uncounted } else { counted };
        Lengths { path: path.sqrt(), feed: feed.sqrt(), rotary_only, without_feed }
    }
}

impl Translator<'_> {
    /// F word: value and unit are those of this block.
    pub(crate) fn feed_word(&mut self, block: &Block) -> Check<()> {
        let Some(word) = block.word(b'F') else { return Ok(()) };
        if word.value <= 0.0 {
            return Err(Fault::new(Id::GC504, word.span));
        }
        let modal = &mut self.state.modal;
        let feed = crate::modal::Feed { raw: word.value, mm: word.value * modal.unit() };
        if modal.feed != Some(feed) {
            modal.feed = Some(feed);
            self.sink.flush();
            self.facts.feed_changed(self.line, feed.mm);
        }
        Ok(())
    }

    /// Path speed in mm/s at factor 1.
    pub(crate) fn path_speed(&mut self, block: &Block, lengths: &Lengths) -> Check<f64> {
        if lengths.without_feed {
            return Err(Fault::new(Id::GC804, block.span));
        }
        let modal = &self.state.modal;
        if modal.feed_mode == FeedMode::InverseTime && !block.has(b'F') {
            return Err(Fault::new(Id::GC502, block.span));
        }
        let Some(feed) = modal.feed else { return Err(Fault::new(Id::GC501, block.span)) };
        let per_minute = if lengths.rotary_only { feed.raw } else { feed.mm };
        let speed = match modal.feed_mode {
            FeedMode::PerMinute if lengths.path == lengths.feed => per_minute / 60.0,
            FeedMode::PerMinute => per_minute / 60.0 * (lengths.path / lengths.feed),
            FeedMode::InverseTime => lengths.path * feed.raw / 60.0,
            FeedMode::PerRevolution => per_minute * self.revolutions(block)? / 60.0 * (lengths.path / lengths.feed),
        };
        let speed = self.options.dry_feed.unwrap_or(speed);
        let limit = self.machine.gcode.feed_limit;
        if speed > limit {
            self.limited(block, feed.raw, speed, limit);
            return Ok(limit);
        }
        Ok(speed)
    }
    #[cold]
    pub(crate) fn limited(&mut self, block: &Block, value: f64, speed: f64, limit: f64) {
        if self.limited_feed != Some(value) {
            self.limited_feed = Some(value);
            let shown = format!("{:.3}", speed * 60.0);
            self.faults.push(Fault::with(Id::GW925, block.span_of(b'F'), &[&shown, &(limit * 60.0)]));
        }
    }
}

impl Translator<'_> {
    /// E: the path speed at the end of the block, where the machine file enables it (section 4).
    pub(crate) fn end_speed(&mut self, block: &Block, vl: f64) -> Check<f64> {
        let Some(word) = block.word(b'E').filter(|_| self.dialect.end_feed) else { return Ok(f64::INFINITY) };
        self.used |= crate::block::bit(b'E');
        if word.value <= 0.0 {
            return Err(Fault::new(Id::GC504, word.span));
        }
        // the same unit and the same lengths as F
        Ok(self.state.modal.feed.map_or(vl, |feed| vl * (word.value / feed.raw)))
    }
}
