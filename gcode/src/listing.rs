//! The spooled command sequence as JSON Lines of design 3.3.

use std::fmt::Write;

use motion_kernel::autocode::{Instr, Move, Program};
use motion_kernel::machine::Machine;

use crate::sequence::Radii;

/// The objects of one instruction, one a line: none, one, or one per axis of a spool function.
pub(crate) fn objects(program: &Program, machine: &Machine, radii: &Radii, line: u32, instr: Instr, out: &mut String) {
    match instr {
        Instr::Spool(number) => {
            out.push_str(&move_json(program, machine, radii, line, &program.moves[number as usize]));
            out.push('\n');
        }
        Instr::Ssf(number) => {
            let ssf = &program.ssfs[number as usize];
            for axis in ssf.axes.iter() {
                let (name, value) = (json_string(&machine.axes[axis].name), number_json(ssf.value));
                let command = ssf.command;
                let _ =
                    writeln!(out, r#"{{"cmd":"ssf","line":{line},"axis":{name},"command":{command},"value":{value}}}"#);
            }
        }
        _ => {}
    }
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
