//! What a machine file settles about part programs: dialect, outputs, M functions, reference positions.

use gcode::{Options, compile, listing_json};
use motion_kernel::machine::{BUILTIN, Machine};

fn machine(more: &str) -> Machine {
    Machine::parse(format!("{BUILTIN}\n{more}").as_bytes()).expect("a valid machine file")
}

/// The listing of a program, or the ids of its errors.
fn translated(machine: &Machine, program: &str) -> Result<Vec<String>, Vec<String>> {
    let compiled = compile(program.as_bytes(), "job.nc", machine, &Options::default());
    match &compiled.program {
        Some(program) => Ok(listing_json(program, machine).collect()),
        None => Err(compiled.diagnostics.iter().map(|d| d.id.to_string()).collect()),
    }
}

fn ssf(machine: &Machine, program: &str) -> Vec<(u32, f64)> {
    let field = |line: &str, key: &str| -> f64 {
        let rest = &line[line.find(key).expect("the key") + key.len()..];
        rest[..rest.find([',', '}']).expect("an end")].parse().expect("a number")
    };
    let lines = translated(machine, program).expect("compiles");
    let functions = lines.iter().filter(|l| l.contains("\"ssf\"") && l.contains("\"axis\":\"X\""));
    functions.map(|l| (field(l, "\"command\":") as u32, field(l, "\"value\":"))).collect()
}

#[test]
fn outputs_stand_in_the_machine_file() {
    let own = machine("[gcode.outputs]\nspindle_cw = [7]\nspindle_ccw = [7, 8]\ncoolant1 = [9]");
    assert_eq!(ssf(&own, "S100 M3\nM8\nM5\nM2")[1..4], [(1002, 128.0), (1001, 64.0), (1001, 256.0)]);
    assert_eq!(ssf(&Machine::builtin(), "M3\nM2")[..2], [(1002, 2.0), (1001, 1.0)]);
}

#[test]
fn a_line_of_both_spindle_directions_does_not_drop() {
    let own = machine("[gcode.outputs]\nspindle_cw = [1]\nspindle_ccw = [1, 2]");
    assert_eq!(ssf(&own, "M4\nM3\nM2")[..3], [(1001, 3.0), (1002, 2.0), (1001, 1.0)]);
}

#[test]
fn an_m_function_of_the_machine_file() {
    let own = machine("[[gcode.m]]\nnumber = 110\nset = [6]\nreset = [5]\nwait = [3]\nci = 7\nvalue = -2");
    assert_eq!(ssf(&own, "M110\nM2")[..4], [(7, -2.0), (1002, 16.0), (1001, 32.0), (1004, 4.0)]);
    let strict = machine("[gcode.dialect]\nstrict_m = true");
    assert_eq!(translated(&strict, "M110\nM2").unwrap_err(), ["GC513"]);
}

#[test]
fn speed_and_auxiliary_function_go_where_the_machine_file_says() {
    let text = BUILTIN.replacen("[gcode] ", "[gcode]\nspeed_cd = 12\nauxiliary_ci = 13\n", 1);
    let own = Machine::parse(text.as_bytes()).expect("valid");
    assert_eq!(ssf(&own, "S500\nH4\nM2")[..2], [(20_012, 500.0), (13, 4.0)]);
}

#[test]
fn further_reference_positions() {
    let own = machine("[gcode.references]\nP3 = { X = 10.0, Z = -5.0 }");
    let lines = translated(&own, "G30 P3 X1 Y2 Z3\nM2").expect("compiles");
    assert!(lines[1].contains("\"target\":{\"X\":10.0,\"Y\":0.0,\"Z\":-5.0}"), "{}", lines[1]);
    assert_eq!(translated(&own, "G30 X1\nM2").unwrap_err(), ["GC311"]);
}

#[test]
fn dialect_options_go_before_the_profile() {
    let dwell = |own: &Machine| ssf(own, "G4 P2\nM2")[0];
    assert_eq!(dwell(&machine("[gcode.dialect]\ndwell_p_unit = \"s\"")), (1003, 31_250.0));
    assert_eq!(dwell(&Machine::builtin()), (1003, 31.0));
    let text =
        BUILTIN.replacen("[gcode] ", "[gcode]\nprofile = \"linuxcnc\"\ndialect = { dwell_p_unit = \"ms\" }\n", 1);
    assert_eq!(dwell(&Machine::parse(text.as_bytes()).expect("valid")), (1003, 31.0));
    let absolute = machine("[gcode.dialect]\narc_centre = \"absolute\"");
    let arc = &translated(&absolute, "G0 X5\nG3 X5 I15 J0 F100\nM2").expect("compiles")[1];
    assert!(arc.contains("\"center\":{\"X\":15.0,\"Y\":0.0}"), "{arc}");
}

// shows: modereg.centeralwaysrel
#[test]
fn center_always_rel_takes_centres_from_the_block_start() {
    let centre = |bit: &str, text: &str| {
        let text_of = BUILTIN.replacen("modereg = [", &format!("modereg = [{bit}"), 1);
        let head = "[gcode]\ndialect = { arc_centre = \"likeController\" }\n";
        let own = Machine::parse(text_of.replacen("[gcode] ", head, 1).as_bytes()).expect("valid");
        let arc = translated(&own, text).expect("compiles").remove(1);
        let begin = arc.find("\"center\":").expect("an arc");
        arc[begin..].split('}').next().expect("closed").to_owned()
    };
    let absolute = "G90 G0 X5\nG3 X5 I15 J0 F100\nM2";
    assert_eq!(centre("\"CenterAlwaysRel\", ", absolute), "\"center\":{\"X\":20.0,\"Y\":0.0");
    assert_eq!(centre("", absolute), "\"center\":{\"X\":15.0,\"Y\":0.0", "like the targets of G90");
    let incremental = "G91 G0 X5\nG3 X0 I15 J0 F100\nM2";
    assert_eq!(centre("\"CenterAlwaysRel\", ", incremental), "\"center\":{\"X\":20.0,\"Y\":0.0");
    assert_eq!(centre("", incremental), "\"center\":{\"X\":20.0,\"Y\":0.0");
}
