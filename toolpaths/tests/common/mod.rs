//! Programs and set points made by the tests' own geometry, in the plainest form: nothing here is shared with the crate.
#![allow(dead_code)]

use std::sync::Arc;

use toolpaths::{Chunk, Path, PathError, PerSample, SequenceView, Space, Summary, Tracker, TrackerOptions};

pub const TA: f64 = 1.28e-3;

/// Owned columns of a sequence.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    pub axes: usize,
    pub start: Vec<f64>,
    pub kind: Vec<u8>,
    pub line: Vec<u32>,
    pub rapid: Vec<bool>,
    pub target: Vec<f64>,
    pub c1: Vec<u8>,
    pub c2: Vec<u8>,
    pub center: Vec<f64>,
    pub phi: Vec<f64>,
    pub vl: Vec<f64>,
    pub via_first: Vec<u32>,
    pub via_count: Vec<u32>,
    pub via_line: Vec<u32>,
    pub via_target: Vec<f64>,
    pub effradius: Vec<f64>,
    pub effradius_of: Vec<u16>,
    pub begin: Vec<f64>,
    pub c3: Vec<u8>,
    pub center3: Vec<f64>,
    pub normal: Vec<f64>,
}

impl Columns {
    /// The rows of some commands as a sequence of their own.
    pub fn part(&self, rows: std::ops::Range<usize>) -> Columns {
        let (i, j, a) = (rows.start, rows.end, self.axes);
        let via = self.via_first[i] as usize;
        let vias = via..(self.via_first[j - 1] + self.via_count[j - 1]) as usize;
        Columns {
            axes: a,
            start: self.start.clone(),
            kind: self.kind[i..j].to_vec(),
            line: self.line[i..j].to_vec(),
            rapid: self.rapid[i..j].to_vec(),
            target: self.target[i * a..j * a].to_vec(),
            c1: self.c1[i..j].to_vec(),
            c2: self.c2[i..j].to_vec(),
            center: self.center[2 * i..2 * j].to_vec(),
            phi: self.phi[i..j].to_vec(),
            vl: self.vl[i..j].to_vec(),
            via_first: self.via_first[i..j].iter().map(|first| first - via as u32).collect(),
            via_count: self.via_count[i..j].to_vec(),
            via_line: self.via_line[vias.clone()].to_vec(),
            via_target: self.via_target[vias.start * a..vias.end * a].to_vec(),
            effradius: self.effradius.clone(),
            effradius_of: self.effradius_of[i..j].to_vec(),
            ..Columns::default()
        }
    }
    pub fn view(&self) -> SequenceView<'_> {
        SequenceView {
            axes: self.axes,
            start: &self.start,
            kind: &self.kind,
            line: &self.line,
            rapid: &self.rapid,
            target: &self.target,
            c1: &self.c1,
            c2: &self.c2,
            center: &self.center,
            phi: &self.phi,
            vl: &self.vl,
            via_first: &self.via_first,
            via_count: &self.via_count,
            via_line: &self.via_line,
            via_target: &self.via_target,
            effradius: &self.effradius,
            effradius_of: &self.effradius_of,
            space: Space { begin: &self.begin, c3: &self.c3, center: &self.center3, normal: &self.normal },
        }
    }
}

/// A move as the tests evaluate it, in mm of the D7 metric.
#[derive(Clone, Debug)]
pub enum Piece {
    Line { from: Vec<f64>, to: Vec<f64> },
    Helix { from: Vec<f64>, to: Vec<f64>, c1: usize, c2: usize, center: [f64; 2], phi: f64 },
}

impl Piece {
    pub fn length(&self) -> f64 {
        match self {
            Piece::Line { from, to } => from.iter().zip(to).map(|(f, t)| (t - f).powi(2)).sum::<f64>().sqrt(),
            Piece::Helix { from, to, c1, c2, center, phi } => {
                let r = ((from[*c1] - center[0]).powi(2) + (from[*c2] - center[1]).powi(2)).sqrt();
                let others = (0..from.len()).filter(|a| a != c1 && a != c2).map(|a| (to[a] - from[a]).powi(2));
                ((r * phi).powi(2) + others.sum::<f64>()).sqrt()
            }
        }
    }
    /// Position at a share `u` of the length.
    pub fn at(&self, u: f64) -> Vec<f64> {
        match self {
            Piece::Line { from, to } => from.iter().zip(to).map(|(f, t)| f + u * (t - f)).collect(),
            Piece::Helix { from, to, c1, c2, center, phi } => {
                let mut p: Vec<f64> = from.iter().zip(to).map(|(f, t)| f + u * (t - f)).collect();
                let (dx, dy) = (from[*c1] - center[0], from[*c2] - center[1]);
                let (sin, cos) = (u * phi).sin_cos();
                p[*c1] = center[0] + dx * cos - dy * sin;
                p[*c2] = center[1] + dx * sin + dy * cos;
                p
            }
        }
    }
}

/// Builds a program command by command; positions in axis units.
#[derive(Clone, Debug)]
pub struct Program {
    pub columns: Columns,
    /// What the set point runs: one piece per motion command.
    pub pieces: Vec<Piece>,
    pub rotary: Vec<bool>,
    at: Vec<f64>,
    pub feed: f64,
    pub rapid: bool,
}

impl Program {
    pub fn new(start: &[f64]) -> Self {
        Self::with_rotary(start, &vec![None; start.len()])
    }
    /// `radii`: effective radius of rotary axes.
    pub fn with_rotary(start: &[f64], radii: &[Option<f64>]) -> Self {
        let columns = Columns {
            axes: start.len(),
            start: start.to_vec(),
            effradius: radii.iter().map(|r| r.unwrap_or(f64::NAN)).collect(),
            ..Columns::default()
        };
        let rotary = radii.iter().map(Option::is_some).collect();
        Program { columns, pieces: Vec::new(), rotary, at: start.to_vec(), feed: 10.0, rapid: false }
    }
    pub fn set_radius(&mut self, axis: usize, radius: f64) {
        let a = self.columns.axes;
        let mut row = self.columns.effradius[self.columns.effradius.len() - a..].to_vec();
        row[axis] = radius;
        self.columns.effradius.extend(row);
    }
    fn row(&self) -> usize {
        self.columns.effradius.len() / self.columns.axes - 1
    }
    pub fn metric(&self, row: usize, p: &[f64]) -> Vec<f64> {
        let radii = &self.columns.effradius[row * p.len()..(row + 1) * p.len()];
        p.iter().zip(radii).map(|(x, r)| if r.is_nan() { *x } else { x * r * std::f64::consts::PI / 180.0 }).collect()
    }
    pub fn units(&self, row: usize, p: &[f64]) -> Vec<f64> {
        let radii = &self.columns.effradius[row * p.len()..(row + 1) * p.len()];
        p.iter().zip(radii).map(|(x, r)| if r.is_nan() { *x } else { x / r / std::f64::consts::PI * 180.0 }).collect()
    }
    pub fn position(&self) -> &[f64] {
        &self.at
    }
    fn push(&mut self, kind: u8, target: &[f64]) {
        let c = &mut self.columns;
        c.kind.push(kind);
        c.line.push(c.kind.len() as u32 * 10);
        c.rapid.push(self.rapid);
        c.target.extend_from_slice(target);
        c.vl.push(self.feed);
        c.via_first.push(c.via_line.len() as u32);
        c.via_count.push(0);
        c.effradius_of.push((c.effradius.len() / c.axes - 1) as u16);
        self.at = target.to_vec();
    }
    pub fn line(&mut self, target: &[f64]) -> &mut Self {
        let (from, to) = (self.metric(self.row(), &self.at), self.metric(self.row(), target));
        self.pieces.push(Piece::Line { from, to });
        self.columns.c1.push(0);
        self.columns.c2.push(0);
        self.columns.center.extend([0.0, 0.0]);
        self.columns.phi.push(0.0);
        self.push(0, target);
        self
    }
    /// Circle axes c1, c2 about a centre (axis units) by phi degrees; the other axes go to `others`.
    pub fn helix(&mut self, c1: usize, c2: usize, center: [f64; 2], phi: f64, others: &[f64]) -> &mut Self {
        let row = self.row();
        let from = self.metric(row, &self.at);
        let mut c = self.at.clone();
        (c[c1], c[c2]) = (center[0], center[1]);
        let c = self.metric(row, &c);
        let to = self.metric(row, others);
        let piece = Piece::Helix { from, to, c1, c2, center: [c[c1], c[c2]], phi: phi * std::f64::consts::PI / 180.0 };
        let end = self.units(row, &piece.at(1.0));
        let mut target = others.to_vec();
        (target[c1], target[c2]) = (end[c1], end[c2]);
        self.pieces.push(piece);
        self.columns.c1.push(c1 as u8);
        self.columns.c2.push(c2 as u8);
        self.columns.center.extend(center);
        self.columns.phi.push(phi);
        self.push(1, &target);
        self
    }
    /// A line that replaces the blocks through `vias`.
    pub fn merged(&mut self, vias: &[Vec<f64>], target: &[f64]) -> &mut Self {
        self.line(target);
        let c = &mut self.columns;
        *c.via_count.last_mut().unwrap() = vias.len() as u32;
        for (k, via) in vias.iter().enumerate() {
            c.via_line.push(c.kind.len() as u32 * 10 - vias.len() as u32 + k as u32);
            c.via_target.extend_from_slice(via);
        }
        self
    }
    pub fn path(&self) -> Result<Path, PathError> {
        Path::new(self.columns.view())
    }
    /// Set points along the commands, `speed_of(command)` times the programmed velocity, without ramps.
    pub fn run(&self, speed_of: impl Fn(usize) -> f64) -> Run {
        let mut run = Run { axes: self.columns.axes, ..Run::default() };
        let mut left = TA; // time to the next sample
        for (i, piece) in self.pieces.iter().enumerate() {
            let (length, v) = (piece.length(), self.columns.vl[i] * speed_of(i));
            let row = usize::from(self.columns.effradius_of[i]);
            let mut s = v * left;
            while s < length {
                run.push(&self.units(row, &piece.at(s / length)), i, speed_of(i), self.columns.vl[i]);
                s += v * TA;
            }
            left = (s - length) / v;
        }
        let last = self.pieces.len() - 1;
        let end = self.units(usize::from(self.columns.effradius_of[last]), &self.pieces[last].at(1.0));
        for _ in 0..5 {
            run.push(&end, last, speed_of(last), 0.0);
        }
        run
    }
}

/// A made-up trace.
#[derive(Clone, Debug, Default)]
pub struct Run {
    pub axes: usize,
    pub dp: Vec<f64>,
    pub load: Vec<f64>,
    pub factor: Vec<f64>,
    pub v_plan: Vec<f64>,
    /// Command that each sample belongs to.
    pub command: Vec<usize>,
}

impl Run {
    pub fn push(&mut self, p: &[f64], command: usize, factor: f64, v_plan: f64) {
        self.dp.extend_from_slice(p);
        self.load.extend_from_slice(p);
        self.factor.push(factor);
        self.v_plan.push(v_plan);
        self.command.push(command);
    }
    pub fn len(&self) -> usize {
        self.factor.len()
    }
    pub fn dp_at(&self, k: usize) -> &[f64] {
        &self.dp[k * self.axes..(k + 1) * self.axes]
    }
    /// Changes set points and load side of the samples of a command.
    pub fn shift(&mut self, command: usize, change: impl Fn(&mut [f64])) {
        for k in (0..self.len()).filter(|&k| self.command[k] == command).collect::<Vec<_>>() {
            change(&mut self.dp[k * self.axes..(k + 1) * self.axes]);
            change(&mut self.load[k * self.axes..(k + 1) * self.axes]);
        }
    }
    pub fn measure(&self, program: &Program) -> Measured {
        self.measure_with(program, TrackerOptions { sample_time_s: TA, ..TrackerOptions::default() })
    }
    pub fn measure_with(&self, program: &Program, options: TrackerOptions) -> Measured {
        self.measure_by(Tracker::new(Arc::new(program.path().expect("a path")), options))
    }
    pub fn measure_by(&self, mut tracker: Tracker) -> Measured {
        let n = self.len();
        let mut m = Measured::new(n);
        // uneven chunks: results must not depend on them
        let mut first = 0;
        for size in (1..).map(|i| 1 + (i * 37) % 1013) {
            let last = (first + size).min(n);
            let rows = first * self.axes..last * self.axes;
            let chunk = Chunk {
                first_sample: first as u64,
                dp: &self.dp[rows.clone()],
                load: &self.load[rows.clone()],
                rp: &self.load[rows],
                factor: &self.factor[first..last],
                v_plan: &self.v_plan[first..last],
                ..Chunk::default()
            };
            tracker.feed(
                &chunk,
                &mut PerSample {
                    actual_mm: &mut m.actual_mm[first..last],
                    setpoint_mm: &mut m.setpoint_mm[first..last],
                    signed_mm: &mut m.signed_mm[first..last],
                    s_actual_mm: &mut m.s_actual_mm[first..last],
                    s_setpoint_mm: &mut m.s_setpoint_mm[first..last],
                    block: &mut m.block[first..last],
                },
            );
            first = last;
            if first == n {
                break;
            }
        }
        m.summary = tracker.finish();
        m.tracker = Some(tracker);
        m
    }
}

/// What a tracker returned, per sample and in sum.
#[derive(Debug, Default)]
pub struct Measured {
    pub actual_mm: Vec<f32>,
    pub setpoint_mm: Vec<f32>,
    pub signed_mm: Vec<f32>,
    pub s_actual_mm: Vec<f64>,
    pub s_setpoint_mm: Vec<f64>,
    pub block: Vec<u32>,
    pub summary: Summary,
    pub tracker: Option<Tracker>,
}

impl Measured {
    fn new(n: usize) -> Self {
        Measured {
            actual_mm: vec![0.0; n],
            setpoint_mm: vec![0.0; n],
            signed_mm: vec![0.0; n],
            s_actual_mm: vec![0.0; n],
            s_setpoint_mm: vec![0.0; n],
            block: vec![0; n],
            ..Measured::default()
        }
    }
}

/// Small, seeded, good enough for tests (xorshift).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
    pub fn pick(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }
}

/// A random program of lines, arcs and helices in `axes` axes.
pub fn random_program(seed: u64, axes: usize, commands: usize) -> Program {
    let mut r = Random::new(seed);
    let start: Vec<f64> = (0..axes).map(|_| r.range(-50.0, 50.0)).collect();
    let radii: Vec<Option<f64>> = (0..axes).map(|a| (a == 3).then(|| r.range(5.0, 60.0))).collect();
    let mut program = Program::with_rotary(&start, &radii);
    for _ in 0..commands {
        program.feed = r.range(1.0, 100.0);
        program.rapid = r.unit() < 0.1;
        let at = program.position().to_vec();
        let size = 10f64.powf(r.range(-1.5, 1.0));
        let step: Vec<f64> = (0..axes).map(|_| size * r.range(-1.0, 1.0)).collect();
        let to: Vec<f64> = at.iter().zip(&step).map(|(a, s)| a + s).collect();
        if axes > 3 && r.unit() < 0.1 {
            program.set_radius(3, r.range(5.0, 60.0));
        }
        // an arc turns less than a third of a turn per sample, as on any machine with limited acceleration
        let radius = step[..axes.min(3)].iter().map(|s| s.abs()).fold(f64::INFINITY, f64::min);
        if r.unit() < 0.5 {
            program.line(&to);
        } else {
            let pairs: &[(usize, usize)] = if axes == 2 { &[(0, 1)] } else { &[(0, 1), (2, 0), (1, 2)] };
            let (c1, c2) = pairs[r.pick(pairs.len())];
            let phi = if r.unit() < 0.3 { 360.0 * r.range(-2.0, 2.0).round() } else { r.range(-720.0, 720.0) };
            let phi = if phi == 0.0 { 360.0 } else { phi };
            program.feed = program.feed.min((500.0 * radius).sqrt());
            let others = if r.unit() < 0.5 { at.clone() } else { to };
            program.helix(c1, c2, [at[c1] + step[0], at[c2] + step[1]], phi, &others);
        }
    }
    program
}
