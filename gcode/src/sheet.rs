//! What `translate` prints: the commands as JSON Lines, or as a sheet to be read beside the source, piece by piece.

use std::fmt::Write;

use motion_kernel::autocode::{HOST_EVENT_CI, Instr, Move, Program, Ssf};
use motion_kernel::machine::Machine;

use crate::listing::objects;
use crate::mfunc::spool;
use crate::once::{Input, Reader};
use crate::sequence::Radii;
use crate::source::{Lines, Mark, decode};

/// Instructions a piece is made of.
const PIECE: usize = 4096;

/// Where the listing of a program stands. [`Sheet::piece`] goes on until it returns nothing.
pub struct Sheet {
    json: bool,
    at: usize,
    begun: bool,
    radii: Radii,
    /// The text, where it is read beside the program: the commands come in the order of its lines.
    following: Option<Reader<'static>>,
    /// Place of each source line, and whether it commands anything (text only).
    lines: Vec<Mark>,
    commands: Vec<bool>,
    /// Source line printed last.
    shown: u32,
}

impl Sheet {
    pub fn new(program: &Program, machine: &Machine, source: &[u8], json: bool) -> Self {
        let (mut lines, mut commands) = (Vec::new(), Vec::new());
        if !json {
            let mut reader = Lines::new(source);
            loop {
                let mark = reader.mark();
                if reader.next_line().is_none() {
                    break;
                }
                lines.push(mark);
            }
            commands = vec![false; lines.len() + 2];
            for line in &program.lines {
                if let Some(known) = commands.get_mut(*line as usize) {
                    *known = true;
                }
            }
        }
        Sheet { json, at: 0, begun: false, radii: Radii::new(machine), following: None, lines, commands, shown: 0 }
    }
    /// For a program that comes in segments: a sheet beside `text`, JSON without one. [`Sheet::piece`] then lists a
    /// segment, [`Sheet::next_segment`] goes to the next.
    pub fn following(machine: &Machine, text: Option<Input<'static>>) -> Self {
        let (json, following) = (text.is_none(), text.map(Reader::every_line));
        let (lines, commands, radii) = (Vec::new(), Vec::new(), Radii::new(machine));
        Sheet { json, at: 0, begun: false, radii, following, lines, commands, shown: 0 }
    }
    /// The next piece is the first of another segment.
    pub fn next_segment(&mut self) {
        self.at = 0;
    }
    /// The next piece of the listing, whole lines; `None` at its end.
    pub fn piece(&mut self, program: &Program, machine: &Machine, source: &[u8]) -> Option<String> {
        if self.at >= program.code.len() {
            return None;
        }
        let mut out = String::new();
        if !std::mem::replace(&mut self.begun, true) && !self.json {
            head(machine, &mut out);
        }
        let end = (self.at + PIECE).min(program.code.len());
        for (line, instr) in program.lines[self.at..end].iter().copied().zip(program.code[self.at..end].iter().copied())
        {
            let changed = self.radii.follow(&instr, program);
            if self.json {
                objects(program, machine, &self.radii, line, instr, &mut out);
                continue;
            }
            let Some(text) = self.command(program, machine, &instr, changed) else { continue };
            self.source_line(line, source, &mut out);
            let _ = writeln!(out, "{:>9}{text}", "");
        }
        self.at = end;
        Some(out)
    }
    /// The line of a command with its text, after the lines before it that command nothing.
    fn source_line(&mut self, line: u32, source: &[u8], out: &mut String) {
        if line == self.shown {
            return;
        }
        let gap = self.shown + 1..line;
        let in_order = self.following.is_some();
        let silent =
            self.shown < line && (in_order || !gap.clone().any(|n| self.commands.get(n as usize).is_none_or(|c| *c)));
        let first = if silent { gap.start } else { line };
        for n in first..=line {
            let text = match &mut self.following {
                Some(reader) => reader.line(n),
                None => (n as usize).checked_sub(1).and_then(|i| self.lines.get(i)).and_then(|mark| {
                    let mut reader = Lines::new(source);
                    reader.go(*mark);
                    reader.next_line().map(|line| line.1)
                }),
            };
            let Some(text) = text else { continue };
            let _ = writeln!(out, "{n:>7} | {}", decode(text.trim_ascii_end()));
        }
        self.shown = line;
    }
    fn command(&self, program: &Program, machine: &Machine, instr: &Instr, changed: bool) -> Option<String> {
        match *instr {
            Instr::EffRadius(axis) if changed => {
                let name = &machine.axes[usize::from(axis)].name;
                Some(format!("wrEffRadius {name}  {} mm", self.radii.now[usize::from(axis)]))
            }
            Instr::Spool(number) => Some(move_text(program, machine, &program.moves[number as usize])),
            Instr::Ssf(number) => Some(function_text(program, machine, &program.ssfs[number as usize])),
            Instr::Drain(_) => Some("wait until all is done".to_owned()),
            Instr::WriteText(number) => Some(format!("write \"{}\"", program.texts[number as usize])),
            Instr::Writeln => Some("writeln".to_owned()),
            Instr::Halt => Some("end".to_owned()),
            _ => None,
        }
    }
}

/// All objects of a program, one a line.
pub fn listing_json(program: &Program, machine: &Machine) -> impl Iterator<Item = String> {
    let mut sheet = Sheet::new(program, machine, b"", true);
    let mut all = Vec::new();
    while let Some(piece) = sheet.piece(program, machine, b"") {
        all.extend(piece.lines().map(str::to_owned));
    }
    all.into_iter()
}

fn head(machine: &Machine, out: &mut String) {
    let axes: Vec<&str> = machine.group().iter().map(|a| machine.axes[a].name.as_str()).collect();
    let _ = writeln!(out, "machine {}, axes {}: machine coordinates in mm and degrees", machine.name, axes.join(" "));
    let _ = writeln!(out, "vl, tvl: path speed and speed at the end in mm/s; ac: path acceleration in mm/s2");
    let _ = writeln!(out, "   line | source, below it what the controller gets\n");
}

fn move_text(program: &Program, machine: &Machine, mv: &Move) -> String {
    let axes = program.axes_of(mv);
    let targets = axes.iter().zip(program.targets_of(mv));
    let targets: Vec<String> = targets.map(|(a, v)| format!("{} {v:.4}", machine.axes[a].name)).collect();
    let mut out = format!("{}  {}", mv.kind.name(), targets.join("  "));
    if !mv.kind.is_linear() {
        let name = |i: usize| &machine.axes[axes.at(i)].name;
        let [a, b] = mv.center;
        let _ = write!(out, "  centre {} {a:.4} {} {b:.4}  phi {:.4}", name(0), name(1), mv.phi);
    }
    let _ = write!(out, "  vl {:.4}  ac {}  tvl {:.4}", mv.vl, mv.ac, mv.tvl);
    if mv.rapid {
        out.push_str("  rapid");
    }
    let merged = program.vias_of(mv);
    if let (Some(first), Some(last)) = (merged.first(), merged.last()) {
        let _ = write!(out, "  (with the {} blocks of lines {} to {})", merged.len(), first.line, last.line);
    }
    out
}

/// A spool function by its number, and what it means.
fn function_text(program: &Program, machine: &Machine, ssf: &Ssf) -> String {
    let axes: Vec<&str> = ssf.axes.iter().map(|a| machine.axes[a].name.as_str()).collect();
    let lines = |value: f64| {
        let set = (0..32).filter(|i| value as u32 & 1 << i != 0).map(|i| (i + 1).to_string());
        set.collect::<Vec<_>>().join(" ")
    };
    let meaning = match ssf.command {
        HOST_EVENT_CI => {
            program.event(ssf.value).map_or(String::new(), |e| format!("tell the application: {} {}", e.kind, e.text))
        }
        spool::HALT => "halt".to_owned(),
        spool::SET_OUTPUTS => format!("set output {}", lines(ssf.value)),
        spool::RESET_OUTPUTS => format!("reset output {}", lines(ssf.value)),
        spool::WAIT => format!("wait {} s", (ssf.value * 64.0).round() / 1e6),
        spool::WAIT_INPUTS => format!("wait for input {}", lines(ssf.value)),
        spool::WAIT_HOST => "wait for the application".to_owned(),
        command if command < 1000 => format!("CI{command} = {}", ssf.value),
        command if (spool::WRITE_CD..spool::WRITE_CD + 1000).contains(&command) => {
            format!("CD{} = {}", command - spool::WRITE_CD, ssf.value)
        }
        _ => String::new(),
    };
    format!("ssf {} {} {}  {}", axes.join("|"), ssf.command, ssf.value, meaning.trim_end()).trim_end().to_owned()
}
