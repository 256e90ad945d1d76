//! The spooled command sequence as text: JSON Lines of design 3.3, or a table to read beside the source.

use std::fmt::Write;

use motion_kernel::autocode::{Instr, Move, Program};
use motion_kernel::machine::Machine;

use crate::sequence::Radii;

/// One JSON object per command, in execution order.
pub fn listing_json<'a>(program: &'a Program, machine: &'a Machine) -> impl Iterator<Item = String> + 'a {
    let mut radii = Radii::new(machine);
    commands(program).flat_map(move |(line, instr)| match instr {
        Instr::EffRadius(_) | Instr::Number(_) => {
            radii.follow(&instr, program);
            Vec::new()
        }
        Instr::Spool(number) => vec![move_json(program, machine, &radii, line, &program.moves[number as usize])],
        Instr::Ssf(number) => {
            let ssf = &program.ssfs[number as usize];
            let object = |axis: usize| {
                let name = json_string(&machine.axes[axis].name);
                format!(
                    r#"{{"cmd":"ssf","line":{line},"axis":{name},"command":{},"value":{}}}"#,
                    ssf.command,
                    number_json(ssf.value)
                )
            };
            ssf.axes.iter().map(object).collect()
        }
        _ => Vec::new(),
    })
}

/// A table: line, command, data.
pub fn listing_text<'a>(program: &'a Program, machine: &'a Machine) -> impl Iterator<Item = String> + 'a {
    let mut radii = Radii::new(machine);
    commands(program).filter_map(move |(line, instr)| match instr {
        Instr::EffRadius(axis) if radii.follow(&instr, program) => {
            let name = &machine.axes[usize::from(axis)].name;
            Some(format!("{line:>6}  wrEffRadius  {name} {}", radii.now[usize::from(axis)]))
        }
        Instr::Number(_) => {
            radii.follow(&instr, program);
            None
        }
        Instr::Spool(number) => Some(move_text(program, machine, line, &program.moves[number as usize])),
        Instr::Ssf(number) => {
            let ssf = &program.ssfs[number as usize];
            let axes: Vec<&str> = ssf.axes.iter().map(|a| machine.axes[a].name.as_str()).collect();
            Some(format!("{line:>6}  ssf   {}  {} {}", axes.join("|"), ssf.command, ssf.value))
        }
        Instr::Drain(_) => Some(format!("{line:>6}  drain")),
        Instr::Halt => Some(format!("{line:>6}  end")),
        _ => None,
    })
}

fn commands(program: &Program) -> impl Iterator<Item = (u32, Instr)> + '_ {
    program.lines.iter().copied().zip(program.code.iter().copied())
}

/// A finite number as the shortest JSON text that reads back the same.
fn number_json(value: f64) -> String {
    if value == value.trunc() && value.abs() < 1e15 { format!("{value:.1}") } else { format!("{value}") }
}

fn json_string(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if (c as u32) < 0x20 => out.push_str(&format!("\\u{:04x}", c as u32)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// `{"X":1.0,...}` in the order of the machine.
fn axes_json(machine: &Machine, mut values: Vec<(usize, f64)>) -> String {
    values.sort_by_key(|v| v.0);
    let items: Vec<String> =
        values.iter().map(|(a, v)| format!("{}:{}", json_string(&machine.axes[*a].name), number_json(*v))).collect();
    format!("{{{}}}", items.join(","))
}

fn move_json(program: &Program, machine: &Machine, radii: &Radii, line: u32, mv: &Move) -> String {
    let axes = program.axes_of(mv);
    let named = |values: &[f64]| {
        let each = axes.iter().zip(values).map(|(a, v)| (a, radii.axis_unit(a, *v)));
        axes_json(machine, each.collect())
    };
    let mut out = format!(r#"{{"cmd":"{}","line":{line}"#, mv.kind.name());
    if !mv.kind.is_linear() {
        let (a, b) = (axes.at(0), axes.at(1));
        let plane = [a, b].map(|i| json_string(&machine.axes[i].name)).join(",");
        let center =
            axes_json(machine, vec![(a, radii.axis_unit(a, mv.center[0])), (b, radii.axis_unit(b, mv.center[1]))]);
        let _ = write!(out, r#","plane":[{plane}],"center":{center},"phi":{}"#, number_json(mv.phi));
    }
    let _ = write!(out, r#","target":{}"#, named(program.targets_of(mv)));
    let speeds = [mv.vl, mv.ac, mv.tvl].map(number_json);
    let _ = write!(out, r#","vl":{},"ac":{},"tvl":{}"#, speeds[0], speeds[1], speeds[2]);
    if mv.vias.1 > mv.vias.0 {
        let via = |v: &motion_kernel::autocode::Via| {
            format!(r#"{{"line":{},"target":{}}}"#, v.line, named(program.via_targets(mv, v)))
        };
        let vias: Vec<String> = program.vias_of(mv).iter().map(via).collect();
        let _ = write!(out, r#","via":[{}]"#, vias.join(","));
    }
    let rotary: Vec<(usize, f64)> =
        axes.iter().filter(|&a| !radii.now[a].is_nan()).map(|a| (a, radii.now[a])).collect();
    if !rotary.is_empty() {
        let _ = write!(out, r#","effradius":{}"#, axes_json(machine, rotary));
    }
    out + "}"
}

fn move_text(program: &Program, machine: &Machine, line: u32, mv: &Move) -> String {
    let axes = program.axes_of(mv);
    let targets = axes.iter().zip(program.targets_of(mv));
    let targets: Vec<String> = targets.map(|(a, v)| format!("{}{v:.4}", machine.axes[a].name)).collect();
    let mut out = format!("{line:>6}  {}  {}", mv.kind.name(), targets.join(" "));
    if !mv.kind.is_linear() {
        let _ = write!(out, "  centre ({:.4}, {:.4}) phi {:.4}", mv.center[0], mv.center[1], mv.phi);
    }
    let rapid = if mv.rapid { " rapid" } else { "" };
    let _ = write!(out, "  vl {:.4} ac {} tvl {:.4}{rapid}", mv.vl, mv.ac, mv.tvl);
    if mv.vias.1 > mv.vias.0 {
        let _ = write!(out, "  ({} merged)", mv.vias.1 - mv.vias.0);
    }
    out
}
