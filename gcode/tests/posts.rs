//! Programs as controls and CAM systems write them: each mistake is told once, where it is, and all of a line at once;
//! what would change the path silently is refused.

mod common;

use common::{mill3, points, program_for};
use gcode::{Options, compile};
use motion_kernel::machine::{Machine, Profile};

fn under(profile: Profile) -> Options {
    Options { profile: Some(profile), ..Options::default() }
}
/// The errors of a program as `id:line:column`.
fn errors(profile: Profile, machine: &Machine, text: &str) -> Vec<String> {
    let found = compile(text.as_bytes(), "t.nc", machine, &under(profile)).diagnostics;
    found.iter().filter(|d| !d.is_warning()).map(|d| format!("{}:{}:{}", d.id, d.line, d.column)).collect()
}

#[test]
fn every_mistake_of_a_program_is_told_once() {
    let (din, linuxcnc) = (Profile::Din, Profile::Linuxcnc);
    let programs: [(Profile, &str, &[&str]); 10] = [
        // decimal commas, letters for digits, slips
        (
            din,
            "G0 X1,5 Y-3,5\nX O\nX1.2.3 Z--5\nX1 0 Y5,5\nM30\n",
            &["GC205:1:6", "GC205:1:12", "GC202:2:1", "GC202:2:3", "GC204:3:2", "GC204:3:9", "GC203:4:4", "GC205:4:8"],
        ),
        // a word that could not be read gives no consequences
        (din, "G1 X10 F1OO\nG2 X1.2.3 Y5\nG1 X5\nM30\n", &["GC201:1:10", "GC204:2:5"]),
        // LinuxCNC: a slip in an O-word; its end is no second mistake
        (linuxcnc, "o<drill> cal [1]\no100 whille [#1 LT 3]\no100 endwhile\nM2\n", &["GC610:1:10", "GC610:2:6"]),
        (linuxcnc, "o<drill>\nM2\n", &["GC610:1:1"]),
        (din, "o<drill> sub\no<drill> cal\nM2\n", &["GC611:1:1"]),
        // Sinumerik
        (
            din,
            "R1=10\nG0 X=R1\nX=IC(10)\nMCALL CYCLE83(10,0)\nFOR R3=1 TO 5\nENDE:\nM30\n",
            &["GC215:1:1", "GC215:2:6", "GC715:3:3", "GC201:4:1", "GC201:5:1", "GC201:6:1"],
        ),
        // Okuma
        (din, "VC1=10\nG0 X=VC1+5\nIF[VC1 EQ 10]NA20\nM30\n", &["GC219:1:1", "GC219:2:6", "GC219:3:4"]),
        // Heidenhain
        (din, "%NEU G71 *\nN10 G90 *\nN20 G0 X5 *\nN30 M30 *\n", &["GC107:2:9"]),
        // printers, plasma tables
        (linuxcnc, "G92 E0\nM66 P3 L3 Q1\nM3 $0 S1\nM2\n", &["GC214:1:5", "GC511:2:11", "GC107:3:4"]),
        // Haas: without its P it would be an event for the application
        (Profile::Fanuc, "M97 P100\nM30\nN100 X0\nM99\n", &["GC510:1:1"]),
    ];
    for (profile, text, expected) in programs {
        assert_eq!(errors(profile, &mill3(), text), expected, "{text}");
    }
}

/// Tool 1 has a radius of 1 mm, tool 5 of 4 mm.
fn two_tools() -> Machine {
    let tools = "\n[[gcode.tool]]\nnumber = 1\nradius = 1.0\n[[gcode.tool]]\nnumber = 5\nradius = 4.0\n";
    Machine::parse(format!("{}{tools}", motion_kernel::machine::BUILTIN).as_bytes()).expect("a valid machine file")
}

#[test]
fn d_before_g41_is_never_passed_over() {
    let (machine, text) = (two_tools(), "T1 M6\nD5\nG0 X0 Y0\nG41 G1 X10 F100\nX20\nG40 Y9\nM30\n");
    let fanuc = program_for(text, &machine, &under(Profile::Fanuc));
    assert_eq!(points(&fanuc)[0][..2], [10.0, 4.0], "modal as on the control");
    assert_eq!(errors(Profile::Din, &machine, text), ["GC310:4:1"], "the tool says 1 mm, D says 4 mm");
    assert_eq!(errors(Profile::Linuxcnc, &machine, text), ["GC326:2:1"]);
    let same = program_for(&text.replace("D5", "D1"), &machine, &under(Profile::Din));
    assert_eq!(points(&same)[0][..2], [10.0, 1.0]);
    let changed = text.replace("D5\n", "").replace("X20", "X20 D5");
    assert_eq!(errors(Profile::Fanuc, &machine, &changed), ["GC326:4:5"], "another radius in the middle of a contour");
}
