//! The path as programmed: segments in the metric of design D7, in execution order, before merging (design D20).

use crate::growth::{EndSeen, Of};
use crate::ring::Ring;
use crate::segment::{Circle, LINE, Segment, Shape};
use crate::sequence::{MAX_AXES, PathError, SequenceView};

/// One programmed block: a motion command, or one of the blocks that a merged line replaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// 1-based source line.
    pub line: u32,
    /// Motion command that executes it, counted from 1.
    pub entry: u32,
    /// Path length at its start, and its own, mm.
    pub s0: f64,
    pub length: f64,
    /// Programmed path velocity, mm/s.
    pub vl: f64,
    pub rapid: bool,
    /// Largest distance of a skipped end point from its chord, mm, on the path up to here and in the next command.
    pub merged_mm: f64,
}

/// A block by its number in [`Path::blocks`] and its source line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Numbered {
    pub block: u32,
    pub line: u32,
}

/// What merging short blocks did to the path (design D6).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Merged {
    /// Blocks that are no motion command of their own any more.
    pub blocks: u64,
    /// Largest distance of a skipped end point from the line that replaces it.
    pub max_mm: f64,
}

/// The path as a polyline in axis units, for plots: vertex, source line, rapid and path length, one row per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polyline {
    /// (n, axes)
    pub points: Vec<f64>,
    /// Source line of the piece that ends at the vertex.
    pub lines: Vec<u32>,
    pub rapid: Vec<bool>,
    pub s_mm: Vec<f64>,
}

/// Programmed geometry. Immutable once built; shared by trackers.
#[derive(Clone, Debug)]
pub struct Path {
    pub(crate) axes: usize,
    /// Columns per point: `axes` padded to a width that the inner loops are compiled for.
    pub(crate) width: usize,
    pub(crate) segments: Vec<Segment>,
    pub(crate) starts: Vec<f64>,
    pub(crate) slopes: Vec<f64>,
    pub(crate) circles: Vec<Circle>,
    pub(crate) rings: Vec<Ring>,
    /// Segments that begin elsewhere than the one before ends: no foot goes there by itself.
    pub(crate) apart: Vec<usize>,
    /// (rows, width): from axis units to mm; 0 in padding columns.
    pub(crate) scales: Vec<f64>,
    pub(crate) blocks: Vec<Block>,
    pub(crate) start: Vec<f64>,
    /// Where the last motion command ends, and how many there are.
    pub(crate) end: Vec<f64>,
    pub(crate) commands: usize,
    pub(crate) merged: Merged,
    /// Blocks that were forgotten.
    pub(crate) gone: u32,
    pub(crate) length: f64,
    pub(crate) end_seen: EndSeen,
    /// Largest distance between the end of an arc by centre and angle, and its target.
    pub arc_end_error_mm: f64,
}

/// A plotted feed line is cut into pieces of about this share of the whole path.
const LINE_PIECES: f64 = 1000.0;

/// Moves whose ends are no further apart than that, axis units, are one path: rounding to counts is less.
pub(crate) const JOINS: f64 = 1e-3;

/// Widths that the inner loops are compiled for.
pub(crate) const WIDTHS: [usize; 4] = [3, 4, 6, MAX_AXES];

impl Path {
    /// Builds the geometry. Errors name the motion command and its source line.
    pub fn new(sequence: SequenceView) -> Result<Path, PathError> {
        let mut path = Path::begin(sequence.start)?;
        path.reserve(sequence.len());
        path.append(&sequence)?;
        path.close();
        Ok(path)
    }

    /// A program without motion: its path is the start position, its block is none of the program's (entry 0).
    pub(crate) fn push_point(&mut self) {
        let here = padded(&self.start, self.width);
        if self.scales.is_empty() {
            self.scales = (0..self.width).map(|a| if a < self.axes { 1.0 } else { 0.0 }).collect();
        }
        if self.blocks.is_empty() {
            self.blocks.push(Block { line: 0, entry: 0, s0: 0.0, length: 0.0, vl: 0.0, rapid: true, merged_mm: 0.0 });
        }
        self.segments.push(Segment {
            s0: 0.0,
            length: 0.0,
            speed: 1.0,
            slowness: 1.0,
            plane_scale: f64::NAN,
            circle: LINE,
            block: 0,
            scale: 0,
        });
        let start = self.scaled(0, &here);
        self.starts.extend_from_slice(&start);
        self.slopes.extend(std::iter::repeat_n(0.0, self.width));
    }

    /// A line and the blocks it replaces, as programmed.
    pub(crate) fn push_line(&mut self, of: Of, from: &[f64], target: &[f64]) {
        let (axes, width) = (self.axes, self.width);
        let Of { sequence, i, row } = of;
        let mut here = self.scaled(row, from);
        let end = self.scaled(row, target);
        let first = sequence.via_first[i] as usize;
        let via =
            |path: &Path, v: usize| path.scaled(row, &padded(&sequence.via_target[v * axes..(v + 1) * axes], width));
        let vias = first..first + sequence.via_count[i] as usize;
        for v in vias.clone() {
            let off = distance_to_chord(&here, &end, &via(self, v));
            self.merged.blocks += 1;
            self.merged.max_mm = self.merged.max_mm.max(off);
        }
        if let Some(before) = self.blocks.last_mut() {
            before.merged_mm = self.merged.max_mm;
        }
        for v in vias {
            let via = via(self, v);
            self.push_block(of, sequence.via_line[v]);
            self.push_straight(of, &here, &via);
            here = via;
        }
        self.push_block(of, sequence.line[i]);
        self.push_straight(of, &here, &end);
    }

    fn push_straight(&mut self, of: Of, from: &[f64], to: &[f64]) {
        let delta: Vec<f64> = from.iter().zip(to).map(|(f, t)| t - f).collect();
        let length = norm(&delta);
        if length > 0.0 {
            let slope: Vec<f64> = delta.iter().map(|d| d / length).collect();
            self.push_segment(of, length, from, &slope, LINE);
        }
    }

    pub(crate) fn push_circle(&mut self, of: Of, from: &[f64], to: &[f64]) -> Result<(), PathError> {
        let Of { sequence, i, row } = of;
        let (here, end) = (self.scaled(row, from), self.scaled(row, to));
        let (c1, c2) = (usize::from(sequence.c1[i]), usize::from(sequence.c2[i]));
        let scale = &self.scales[usize::from(row) * self.width..];
        let center = [sequence.center[2 * i] * scale[c1], sequence.center[2 * i + 1] * scale[c2]];
        let phi = sequence.phi[i].to_radians();
        let (dx, dy) = (here[c1] - center[0], here[c2] - center[1]);
        let radius = dx.hypot(dy);
        let theta0 = dy.atan2(dx);
        self.check_arc_end(sequence, i, &end, center, radius, theta0 + phi)?;

        let mut delta: Vec<f64> = here.iter().zip(&end).map(|(f, t)| t - f).collect();
        delta[c1] = 0.0;
        delta[c2] = 0.0;
        let straight = norm(&delta);
        let length = (radius * phi).hypot(straight);
        self.push_block(of, sequence.line[i]);
        if length > 0.0 {
            let slope: Vec<f64> = delta.iter().map(|d| d / length).collect();
            let turns = radius * phi.abs() > 0.0;
            let number = if turns { self.circles.len() as u32 } else { LINE };
            if turns {
                let rate = phi / length;
                let (mm_per_radian, helical) = (1.0 / rate, straight > 0.0);
                self.circles.push(Circle { c1, c2, center, radius, theta0, rate, mm_per_radian, helical, ring: LINE });
            }
            self.push_segment(of, length, &here, &slope, number);
        }
        Ok(())
    }

    /// Whether a foot may not go on to a segment from the one before it.
    #[inline]
    pub(crate) fn is_apart(&self, segment: usize) -> bool {
        !self.apart.is_empty() && self.apart.binary_search(&segment).is_ok()
    }

    /// A circle in space; axes beside its three stand still.
    pub(crate) fn push_ring(&mut self, of: Of, from: &[f64], to: &[f64]) -> Result<(), PathError> {
        let Of { sequence, i, row } = of;
        let (here, end) = (self.scaled(row, from), self.scaled(row, to));
        let scale = self.scales[usize::from(row) * self.width..][..self.width].to_vec();
        let (length, number) = self.ring(sequence, i, &scale, &here, &end)?;
        self.push_block(of, sequence.line[i]);
        if length > 0.0 {
            self.push_segment(of, length, &here, &vec![0.0; self.width], number);
        }
        Ok(())
    }

    fn check_arc_end(
        &mut self,
        sequence: &SequenceView,
        i: usize,
        end: &[f64],
        center: [f64; 2],
        radius: f64,
        theta: f64,
    ) -> Result<(), PathError> {
        let (c1, c2) = (usize::from(sequence.c1[i]), usize::from(sequence.c2[i]));
        let (sin, cos) = theta.sin_cos();
        let off = (center[0] + radius * cos - end[c1]).hypot(center[1] + radius * sin - end[c2]);
        self.arc_end_error_mm = self.arc_end_error_mm.max(off);
        // 1e-9 relative is what the translator's centre correction promises (din66025.md section 17)
        let size = radius + center[0].abs() + center[1].abs();
        match off <= 1e-6 + 1e-9 * size {
            true => Ok(()),
            false => Err(PathError::ArcEnd { command: self.commands + i + 1, line: sequence.line[i], off_mm: off }),
        }
    }

    fn push_block(&mut self, of: Of, line: u32) {
        let Of { sequence, i, .. } = of;
        let (vl, rapid) = (sequence.vl[i], sequence.rapid[i]);
        self.blocks.push(Block {
            line,
            entry: (self.commands + i) as u32 + 1,
            s0: self.length,
            length: 0.0,
            vl,
            rapid,
            merged_mm: self.merged.max_mm,
        });
    }

    fn push_segment(&mut self, of: Of, length: f64, from: &[f64], slope: &[f64], circle: u32) {
        let Of { sequence: seq, i, row } = of;
        let plane = slope.get(1).map_or(slope[0].abs(), |y| slope[0].hypot(*y));
        self.segments.push(Segment {
            s0: self.length,
            length,
            speed: seq.vl[i],
            slowness: 1.0 / seq.vl[i],
            // below this a line is a move along the third axis, but for rounding
            plane_scale: if plane > 1e-9 { 1.0 / plane } else { f64::NAN },
            circle,
            block: self.blocks.len() as u32 - 1,
            scale: row,
        });
        self.starts.extend_from_slice(from);
        self.slopes.extend_from_slice(slope);
        self.length += length;
        if let Some(block) = self.blocks.last_mut() {
            block.length += length;
        }
    }

    fn scaled(&self, row: u16, point: &[f64]) -> Vec<f64> {
        let scale = &self.scales[usize::from(row) * self.width..];
        point.iter().zip(scale).map(|(x, k)| x * k).collect()
    }

    /// Length of the programmed path in the metric of design D7, rapids included.
    pub fn length_mm(&self) -> f64 {
        self.length
    }
    /// mm per axis unit, by the first effective radius under which an axis counts; 0 where it never does.
    pub fn mm_per_unit(&self) -> Vec<f64> {
        let first = |a: usize| self.scales.iter().skip(a).step_by(self.width).copied().find(|&k| k > 0.0);
        (0..self.axes).map(|a| first(a).unwrap_or(0.0)).collect()
    }
    pub(crate) fn start(&self) -> &[f64] {
        &self.start
    }
    pub fn axes(&self) -> usize {
        self.axes
    }
    /// Programmed blocks in the order of execution.
    pub fn blocks(&self) -> &[Block] {
        if self.blocks.first().is_some_and(|b| b.entry == 0) { &[] } else { &self.blocks }
    }
    /// By how much merging may keep the set point off the path there.
    #[inline]
    pub(crate) fn merged_near(&self, segment: usize) -> f64 {
        self.block(self.segments[segment].block).merged_mm
    }
    /// Number of the block of a segment from the beginning of the path, and its source line.
    pub(crate) fn numbered(&self, segment: usize) -> Numbered {
        let block = self.segments[segment].block;
        Numbered { block: self.gone + block, line: self.block(block).line }
    }
    pub(crate) fn block(&self, number: u32) -> &Block {
        &self.blocks[number as usize]
    }
    pub fn merged(&self) -> Merged {
        self.merged
    }

    pub(crate) fn shape<const N: usize>(&self, i: usize) -> Shape<'_, N> {
        let at = i * N;
        let circle = self.circles.get(self.segments[i].circle as usize);
        Shape {
            start: self.starts[at..at + N].try_into().expect("width of the path"),
            slope: self.slopes[at..at + N].try_into().expect("width of the path"),
            circle,
            ring: circle.and_then(|c| self.rings.get(c.ring as usize)),
        }
    }

    /// Least and greatest position of every axis on the path, in axis units: (min, max) per axis.
    pub fn extents(&self) -> Vec<(f64, f64)> {
        let mut extents: Vec<(f64, f64)> = self.start.iter().map(|&x| (x, x)).collect();
        let mut grow = |a: usize, x: f64| {
            extents[a].0 = extents[a].0.min(x);
            extents[a].1 = extents[a].1.max(x);
        };
        for (i, segment) in self.segments.iter().enumerate() {
            for t in [0.0, segment.length] {
                self.position(i, t).iter().enumerate().for_each(|(a, &x)| grow(a, x));
            }
            let Some(c) = self.circles.get(segment.circle as usize) else { continue };
            let scale = &self.scales[usize::from(segment.scale) * self.width..];
            if let Some(ring) = self.rings.get(c.ring as usize) {
                ring.extremes(c.radius, segment.length * c.rate).for_each(|(a, x)| grow(a, x / scale[a]));
                continue;
            }
            for (axis, centre, quarter) in [(c.c1, c.center[0], 0.0), (c.c2, c.center[1], 1.0)] {
                let (low, high) = reached(c, segment.length, quarter);
                if low {
                    grow(axis, (centre - c.radius) / scale[axis]);
                }
                if high {
                    grow(axis, (centre + c.radius) / scale[axis]);
                }
            }
        }
        extents
    }

    /// The path as a polyline whose chords stay within `chord_mm` of it, with at most about `max_points` vertices:
    /// beyond that the chord error of arcs is doubled, then blocks are thinned out. Long feed lines are cut too, so
    /// that a deviation shows where it is. First vertex: the start.
    pub fn polyline(&self, chord_mm: f64, max_points: usize) -> Polyline {
        let mut chord = chord_mm.max(1e-6);
        let mut line_mm = self.length / LINE_PIECES;
        let count =
            |chord: f64, line_mm: f64| self.segments.iter().map(|s| self.pieces(s, chord, line_mm)).sum::<usize>();
        while count(chord, line_mm) > max_points.max(2) && chord < 1.0 {
            chord *= 2.0;
            line_mm *= 4.0;
        }
        let keep_every = count(chord, line_mm).div_ceil(max_points.max(2)).max(1);
        let mut line = Polyline::default();
        line.push(&self.start, self.blocks.first().map_or(0, |b| b.line), true, 0.0);
        for (i, segment) in self.segments.iter().enumerate() {
            let block = self.blocks[segment.block as usize];
            let pieces = self.pieces(segment, chord, line_mm);
            // thinning never drops the last point, nor the ends of rapids, which tie the picture together
            if keep_every > 1 && !block.rapid && i % keep_every != 0 && i + 1 != self.segments.len() {
                continue;
            }
            let begin = self.position(i, 0.0);
            if line.ends_off(&begin) {
                line.push(&begin, block.line, true, segment.s0);
            }
            for k in 1..=pieces {
                let t = segment.length * k as f64 / pieces as f64;
                line.push(&self.position(i, t), block.line, block.rapid, segment.s0 + t);
            }
        }
        line
    }

    fn pieces(&self, segment: &Segment, chord: f64, line_mm: f64) -> usize {
        let Some(c) = self.circles.get(segment.circle as usize) else {
            let whole = self.blocks[segment.block as usize].rapid || segment.length <= line_mm;
            return if whole { 1 } else { (segment.length / line_mm).ceil() as usize };
        };
        let step = 2.0 * (1.0 - (chord / c.radius).min(1.0)).acos();
        (segment.length * c.rate.abs() / step.min(1.0)).ceil().clamp(1.0, 1e6) as usize
    }

    /// Position in axis units at `t` mm from the start of a segment.
    pub(crate) fn position(&self, i: usize, t: f64) -> Vec<f64> {
        let (at, segment) = (i * self.width, &self.segments[i]);
        let mut p: Vec<f64> = (0..self.axes).map(|a| self.starts[at + a] + t * self.slopes[at + a]).collect();
        let circle = self.circles.get(segment.circle as usize);
        if let Some((c, ring)) = circle.and_then(|c| Some((c, self.rings.get(c.ring as usize)?))) {
            ring.axes.into_iter().zip(ring.at(c.radius, t * c.rate)).for_each(|(a, x)| p[a] = x);
        } else if let Some(c) = circle {
            let (sin, cos) = (c.theta0 + t * c.rate).sin_cos();
            p[c.c1] = c.center[0] + c.radius * cos;
            p[c.c2] = c.center[1] + c.radius * sin;
        }
        let scale = &self.scales[usize::from(segment.scale) * self.width..];
        // axes that do not count stay in the picture where they began
        p.iter().zip(scale).zip(&self.start).map(|((x, k), start)| if *k > 0.0 { x / k } else { *start }).collect()
    }
}

impl Polyline {
    /// The last vertex is elsewhere: what follows begins anew.
    fn ends_off(&self, point: &[f64]) -> bool {
        let last = &self.points[self.points.len().saturating_sub(point.len())..];
        last.iter().zip(point).any(|(a, b)| (a - b).abs() > JOINS)
    }
    fn push(&mut self, point: &[f64], line: u32, rapid: bool, s_mm: f64) {
        self.points.extend_from_slice(point);
        self.lines.push(line);
        self.rapid.push(rapid);
        self.s_mm.push(s_mm);
    }
}

pub(crate) fn padded(point: &[f64], width: usize) -> Vec<f64> {
    let mut padded = point.to_vec();
    padded.resize(width, 0.0);
    padded
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn distance_to_chord(from: &[f64], to: &[f64], point: &[f64]) -> f64 {
    let along: Vec<f64> = from.iter().zip(to).map(|(f, t)| t - f).collect();
    let off: Vec<f64> = from.iter().zip(point).map(|(f, p)| p - f).collect();
    let square = along.iter().map(|x| x * x).sum::<f64>();
    let dot: f64 = along.iter().zip(&off).map(|(a, o)| a * o).sum();
    let t = if square > 0.0 { (dot / square).clamp(0.0, 1.0) } else { 0.0 };
    norm(&along.iter().zip(&off).map(|(a, o)| o - t * a).collect::<Vec<f64>>())
}

/// Whether an arc passes the least and the greatest coordinate of its circle in an axis; `quarter` 0 for the
/// first circle axis, 1 for the second.
fn reached(c: &Circle, length: f64, quarter: f64) -> (bool, bool) {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};
    let (from, to) = (c.theta0, c.theta0 + length * c.rate);
    let (from, to) = (from.min(to), from.max(to));
    let passes = |angle: f64| from + (angle - from).rem_euclid(TAU) <= to;
    (passes(quarter * FRAC_PI_2 + PI), passes(quarter * FRAC_PI_2))
}
