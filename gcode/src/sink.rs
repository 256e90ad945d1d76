//! The last station before autocode: merges short blocks (section 9, design D6), joins target velocities, writes.

use motion_kernel::autocode::{Builder, HostEvent, Instr, LEAST_SAMPLES, Move, MoveKind, Program, Ssf, Via};
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::machine::Machine;
use motion_kernel::registers::ModeReg;

use crate::diagnostics::{Check, Span};
use crate::dialect::Dialect;
use crate::group::{ContourGroup, Point, SLOTS};
use crate::merging::{Merged, Passed, Run};
use crate::offset_path::{Held, Tracking};
use crate::part::Left;
use crate::segments::Deliver;

/// A circle in the plane of two slots, in machine coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    pub slots: [usize; 2],
    pub centre: [f64; 2],
    /// Degrees, counter-clockwise positive.
    pub sweep: f64,
    pub radius: f64,
}

/// One motion as programmed, resolved to machine coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    pub line: u32,
    /// Columns of the block it comes from.
    pub span: Span,
    pub rapid: bool,
    /// Ends at standstill (G60, G61, G09).
    pub exact: bool,
    pub target: Point,
    pub circle: Option<Circle>,
    /// Path length, mm (design D7).
    pub length: f64,
    pub vl: f64,
    pub ac: f64,
    /// Highest speed at its end (E).
    pub end_vl: f64,
    /// Chord tolerance for merging, mm.
    pub tolerance: f64,
    /// Distance of the motion from the line that replaces it (short arcs).
    pub slack: f64,
}

const MERGE_SAMPLES: f64 = 2.0;
/// The motion that has been written last, as long as nothing stops behind it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Previous {
    vl: f64,
    pub(crate) joins: bool,
    end_vl: f64,
    tangent: Point,
}

pub struct Sink {
    pub(crate) builder: Builder,
    /// Takes the program in segments.
    pub(crate) deliver: Option<Deliver>,
    /// The part that is wanted has not begun: commands are thrown away.
    pub(crate) left: Option<Left>,
    /// Radius correction, if one is active.
    pub(crate) tracking: Option<Tracking>,
    /// Slots of the plane of the correction.
    pub(crate) plane: [usize; 2],
    /// Extents of corrected motions.
    pub(crate) low: Point,
    pub(crate) high: Point,
    pub(crate) keep: bool,
    pub(crate) group: ContourGroup,
    pub(crate) list: u16,
    pub(crate) circle_lists: Vec<([usize; 2], u16)>,
    sample: f64,
    /// Cosine of the angle above which corners stop; -1: none does.
    corner_cos: f64,
    /// Rotary positions are spooled as mm of circumference (MODEREG RotatoricUnit is clear).
    circumference: bool,
    /// Options `rapid_blend` and `exact_in_position` of the machine file.
    rapid_blend: bool,
    in_position: bool,
    pub(crate) position: Point,
    run: Option<Run>,
    spare: Vec<Passed>,
    pub(crate) previous: Option<Previous>,
    pub merged: Merged,
    /// Lines of blocks that were slowed down (GW926), to be reported by the translator.
    pub slowed: Vec<(u32, Span)>,
    pub motions: u64,
    pub commands: u64,
}

impl Sink {
    pub fn new(group: &ContourGroup, machine: &Machine, dialect: &Dialect, keep: bool) -> Self {
        let modereg = ModeReg(machine.gcode.modereg);
        let mut builder = Builder::new(group.set(), machine.gcode.start_fill);
        let list = builder.axis_list(group.axis_list());
        Sink {
            builder,
            deliver: None,
            left: None,
            tracking: None,
            plane: [0, 1],
            low: group.start,
            high: group.start,
            keep,
            group: group.clone(),
            list,
            circle_lists: Vec::new(),
            sample: machine.sample_time_s(),
            corner_cos: dialect.corner_cos,
            circumference: !modereg.has(ModeReg::RotatoricUnit) && group.axes.iter().any(|a| a.rotary),
            rapid_blend: dialect.rapid_blend,
            in_position: dialect.exact_in_position,
            position: group.start,
            run: None,
            spare: Vec::new(),
            previous: None,
            merged: Merged::default(),
            slowed: Vec::new(),
            motions: 0,
            commands: 0,
        }
    }
    pub fn first_axis(&self) -> usize {
        self.group.axes[0].axis
    }
    pub fn set(&self) -> AxisSet {
        self.group.set()
    }
    /// The commands so far; the next one starts from where the axes stand before the program.
    pub(crate) fn begin_again(&mut self, start_fill: u32) -> Program {
        let mut builder = Builder::new(self.group.set(), if self.keep { start_fill } else { 0 });
        self.list = builder.axis_list(self.group.axis_list());
        self.circle_lists.clear();
        (self.position, self.low, self.high) = (self.group.start, self.group.start, self.group.start);
        (self.previous, self.merged) = (None, Merged::default());
        std::mem::replace(&mut self.builder, builder).finish()
    }
    /// Nothing more is kept: an error was found.
    pub fn drop_program(&mut self) {
        if self.keep {
            self.keep = false;
            self.builder = Builder::new(self.group.set(), 0);
        }
    }

    /// A motion of the program; `target` differs from the present position.
    #[inline]
    pub fn motion(&mut self, motion: Motion, span: Span) -> Check<()> {
        if self.tracking.is_some() {
            let result = self.track(motion, span);
            if result.is_err() {
                // what follows would only be consequences
                self.tracking = None;
            }
            return result;
        }
        self.pass(motion);
        Ok(())
    }
    pub(crate) fn reach(&mut self, point: &Point) {
        for slot in 0..SLOTS {
            self.low[slot] = self.low[slot].min(point[slot]);
            self.high[slot] = self.high[slot].max(point[slot]);
        }
    }
    /// A motion as the axes will execute it.
    #[inline]
    pub(crate) fn pass(&mut self, motion: Motion) {
        let straight = motion.circle.is_none() && !motion.rapid && !motion.exact;
        if straight && motion.length < MERGE_SAMPLES * self.sample * motion.vl {
            self.short(motion);
        } else {
            self.close_run();
            self.write(motion, &[]);
        }
    }
    fn short(&mut self, motion: Motion) {
        let time = motion.length / motion.vl;
        if let Some(run) = &mut self.run {
            if let Some(deviation) = run.accepts(&motion, &self.group) {
                run.extend(&motion, time, deviation);
                let chord = self.group.distance(&run.start, &motion.target);
                if chord >= MERGE_SAMPLES * self.sample * run.speed(chord) {
                    self.close_run();
                }
                return;
            }
            self.close_run();
        }
        let mut passed = std::mem::take(&mut self.spare);
        passed.clear();
        let start = self.position;
        self.run = Some(Run { start, last: motion, passed, time, same_speed: true, deviation: motion.slack });
    }
    /// Ends a run of short lines: a change of anything but the target closes it.
    #[inline]
    pub fn flush(&mut self) {
        if self.tracking.is_none() || !self.hold(|| Held::Flush) {
            self.close_run();
        }
    }
    #[inline]
    pub(crate) fn close_run(&mut self) {
        if let Some(run) = self.run.take() {
            self.close(run);
        }
    }
    fn close(&mut self, run: Run) {
        let length = self.group.distance(&run.start, &run.last.target);
        let motion = Motion { length, vl: run.speed(length), ..run.last };
        self.merged.blocks += run.passed.len() as u64;
        self.merged.max_mm = self.merged.max_mm.max(run.deviation);
        self.write(motion, &run.passed);
        self.spare = run.passed;
    }

    fn write(&mut self, motion: Motion, passed: &[Passed]) {
        self.merged.max_mm = self.merged.max_mm.max(motion.slack);
        let mut vl = motion.vl;
        let least = LEAST_SAMPLES * self.sample;
        if motion.length < least * vl {
            vl = motion.length / least;
            if !motion.rapid {
                let slowed = (motion.line, motion.span);
                if self.slowed.last() != Some(&slowed) {
                    self.slowed.push(slowed);
                }
            }
        }
        self.motions += 1;
        self.commands += 1;
        let free = self.corner_cos <= -1.0;
        let tangents = if free { ([0.0; SLOTS], [0.0; SLOTS]) } else { self.tangents(&motion) };
        if let Some(previous) = self.previous
            && previous.joins
            && (!motion.rapid || self.rapid_blend)
            && (free || cosine(&previous.tangent, &tangents.0) >= self.corner_cos)
            && self.keep
            && let Some(last) = self.builder.last_move_mut()
        {
            last.tvl = previous.vl.min(vl).min(previous.end_vl);
        }
        if self.keep {
            self.cut();
            self.emit(&motion, vl, passed);
        }
        let joins = (!motion.rapid || self.rapid_blend) && !motion.exact;
        self.previous = Some(Previous { vl, joins, end_vl: motion.end_vl, tangent: tangents.1 });
        self.position = motion.target;
        if self.in_position && motion.exact {
            self.commands += 1;
            if self.keep {
                self.builder.emit(motion.line, Instr::Drain(self.group.set()));
                self.builder.emit(motion.line, Instr::InPosition(self.group.set()));
            }
        }
    }
    fn emit(&mut self, motion: &Motion, vl: f64, passed: &[Passed]) {
        let n = self.group.len();
        let first = self.builder.via_count();
        for passed in passed {
            let point = self.spooled(&passed.point);
            let target = self.builder.numbers(&point[..n]);
            self.builder.via(Via { line: passed.line, target });
        }
        let vias = if passed.is_empty() { (0, 0) } else { (first, self.builder.via_count()) };
        let Motion { rapid, ac, line, .. } = *motion;
        let end = self.spooled(&motion.target);
        let Some(circle) = motion.circle else {
            let target = self.builder.numbers(&end[..n]);
            let (kind, axes) = (MoveKind::Smla, self.list);
            let mv = Move { kind, rapid, axes, target, vl, ac, tvl: 0.0, phi: 0.0, center: [0.0; 2], vias };
            self.builder.spool(line, mv);
            return;
        };
        let kind = if n == 2 { MoveKind::Smca } else { MoveKind::Smha };
        let mut targets = [0.0; SLOTS];
        for (to, slot) in targets.iter_mut().zip(order(circle.slots, n)) {
            *to = end[slot];
        }
        let mut center = end;
        for (slot, value) in circle.slots.into_iter().zip(circle.centre) {
            center[slot] = value;
        }
        let center = circle.slots.map(|slot| self.spooled(&center)[slot]);
        let axes = self.circle_list(circle.slots);
        let target = self.builder.numbers(&targets[..n]);
        let phi = circle.sweep;
        self.builder.spool(line, Move { kind, rapid, axes, target, vl, ac, tvl: 0.0, phi, center, vias });
    }
    /// A point as motion commands name it (section 11).
    #[inline]
    fn spooled(&self, point: &Point) -> Point {
        let mut point = *point;
        if self.circumference {
            for (value, axis) in point.iter_mut().zip(&self.group.axes).filter(|(_, axis)| axis.rotary) {
                *value *= axis.metric;
            }
        }
        point
    }
    /// The axis list (first, second plane axis, all others) of a circle.
    fn circle_list(&mut self, slots: [usize; 2]) -> u16 {
        if let Some(known) = self.circle_lists.iter().find(|l| l.0 == slots) {
            return known.1;
        }
        let axes: Vec<usize> = order(slots, self.group.len()).map(|slot| self.group.axes[slot].axis).collect();
        let list = self.builder.axis_list(AxisList::new(&axes));
        self.circle_lists.push((slots, list));
        list
    }

    /// Unit tangents at start and end (design D7).
    fn tangents(&self, motion: &Motion) -> (Point, Point) {
        let mut straight = [0.0; SLOTS];
        for (slot, axis) in self.group.axes.iter().enumerate() {
            straight[slot] = (motion.target[slot] - self.position[slot]) * axis.metric / motion.length;
        }
        let Some(circle) = motion.circle else { return (straight, straight) };
        let [a, b] = circle.slots;
        let at = |point: &Point| {
            let mut tangent = straight;
            let part = circle.sweep.to_radians() / motion.length;
            tangent[a] = -(point[b] - circle.centre[1]) * self.group.axes[b].metric * part;
            tangent[b] = (point[a] - circle.centre[0]) * self.group.axes[a].metric * part;
            tangent
        };
        (at(&self.position), at(&motion.target))
    }

    /// The motion before this ends at standstill.
    pub fn stop(&mut self) {
        if self.hold(|| Held::Stop) {
            return;
        }
        self.close_run();
        self.previous = None;
    }
    /// A spool function; `wait` functions need the motion before them to stop.
    pub fn ssf(&mut self, line: u32, axes: AxisSet, command: u16, value: f64, wait: bool) {
        if self.hold(|| Held::Ssf(line, axes, command, value, wait)) {
            return;
        }
        if wait {
            self.stop()
        } else {
            self.flush()
        }
        self.commands += 1;
        if self.begins() {
            self.builder.ssf(line, Ssf { axes, command, value });
        }
    }
    pub fn event(&mut self, line: u32, kind: &str, text: &str) {
        if self.hold(|| Held::Event(line, kind.to_owned(), text.to_owned())) {
            return;
        }
        self.close_run();
        self.commands += 1;
        if self.begins() {
            let axis = self.first_axis();
            self.builder.event(axis, HostEvent { line, kind: kind.to_owned(), text: text.to_owned() });
        }
    }
    /// The program, or its last segment.
    pub fn finish(self) -> Program {
        self.builder.finish()
    }
}

/// Slots in the order of a circle command.
pub fn order(slots: [usize; 2], n: usize) -> impl Iterator<Item = usize> {
    slots.into_iter().chain((0..n).filter(move |slot| !slots.contains(slot)))
}

/// Cosine of the angle between two unit tangents.
fn cosine(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
