//! The real part programs of ../shared/nc (or of CNC_FRONT_NC): which compile, and why the others are refused.

mod common;

use std::collections::BTreeSet;
use std::path::PathBuf;

use common::{example, mill3};
use gcode::{Options, compile};
use motion_kernel::machine::Profile;

/// Where the programs are kept; they are not part of this repository.
fn folder() -> Option<PathBuf> {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/nc");
    let given = std::env::var_os("CNC_FRONT_NC").map(PathBuf::from);
    [given, Some(beside)].into_iter().flatten().find(|p| p.is_dir())
}

/// (file, machine, profile, ids of all errors: none = it compiles)
type Row = (&'static str, &'static str, Profile, &'static [&'static str]);

const DIN: Profile = Profile::Din;
const LINUXCNC: Profile = Profile::Linuxcnc;

const PROGRAMS: &[Row] = &[
    ("3d-flower-mold.nc", "mill3", DIN, &[]),
    ("cambam-handle.nc", "mill3", DIN, &[]),
    ("comments.gcode", "mill3", DIN, &[]),
    ("deskproto-botomata.nc", "mill3", DIN, &[]),
    ("fanuc0t-lathe.nc", "mill3", Profile::Lathe, &[]),
    ("fusion-parallel-inch.nc", "mill3", DIN, &[]),
    ("helix-full-turns.gcode", "mill3", DIN, &[]),
    ("laser-abs-centre.tap", "mill3", DIN, &[]),
    ("lathe-turn.nc", "mill3", Profile::Lathe, &[]),
    ("mach3-clamp-inch.nc", "mill3", DIN, &[]),
    ("mach3-pocket-r.tap", "mill3", DIN, &[]),
    ("named-param-cutout.ngc", "mill3", LINUXCNC, &[]),
    ("no-spaces.gcode", "mill3", DIN, &[]),
    ("oword-encoder.ngc", "mill3", LINUXCNC, &[]),
    ("pcb2gcode-all-inch.ngc", "mill3", DIN, &[]),
    ("peck-g83.nc", "mill3", DIN, &[]),
    ("planes-incremental.nc", "mill3", DIN, &[]),
    ("planes-r-inch.gcode", "mill3", DIN, &[]),
    ("pycam-cat-outline.ngc", "mill3", DIN, &[]),
    ("rotary-4axis-finish.nc", "mill4a", DIN, &[]),
    ("sketchucam-rword.gcode", "mill3", DIN, &[]),
    ("thread-helix-360.nc", "mill3", DIN, &[]),
    ("vcarve-openvoronoi.ngc", "mill3", DIN, &[]),
    ("vectric-rotary-a.gcode", "mill4a", DIN, &[]),
    ("vectric-scorpion.nc", "mill3", DIN, &[]),
    ("vertical-slot.ngc", "mill3", DIN, &[]),
    // no B axis on any of our machines
    ("b-axis-faces.nc", "mill4a", DIN, &["GC801"]),
    // M16, G96 without a limit of the speed, U and W of a lathe
    ("fanuc-lathe-macro.nc", "mill3", DIN, &["GC503", "GC510", "GC801"]),
    // G28 X-910: outside the travel of the machine
    ("fanuc0m-mill.nc", "mill3", DIN, &["GC413"]),
    // millimetre values under G20, and no F at all
    ("freecad-centroid.ngc", "mill3", DIN, &["GC413", "GC501"]),
    // offsets of a larger machine, tool life variables, G0 with G80, G41 with a tool number that has no tool
    ("haas-threadmill.nc", "mill3", DIN, &["GC302", "GC413", "GC701"]),
    // G01 without F
    ("line-skip.gcode", "mill3", DIN, &["GC501"]),
    // G41 D1.5: D is a tool number here
    ("mach3-db25-g98.tap", "mill3", DIN, &["GC210"]),
    // #5420 and #5421: positions under LinuxCNC's own numbers
    ("pcb2gcode-tiled-sub.ngc", "mill3", LINUXCNC, &["GC701"]),
    // M29 ends a subprogram, not the program
    ("rotary-shaft-inch.nc", "mill4a", DIN, &["GC614"]),
    ("sinumerik-5axis.mpf", "mill3", DIN, &["GC215", "GC220", "GC305", "GC606", "GC610", "GC801"]),
    ("sinumerik-arc-cr.mpf", "mill3", DIN, &["GC404", "GC406"]),
];

/// Other dialects altogether: refused, whatever the ids are.
const FOREIGN: &[&str] = &["philips3000-lathe.nc", "sinumerik840d.mpf", "sinumerik850-drill.nc"];

#[test]
fn the_table_holds() {
    let Some(folder) = folder() else {
        println!("SKIPPED: no folder with the 40 part programs (CNC_FRONT_NC)");
        return;
    };
    let mut wrong = Vec::new();
    for (file, machine, profile, expected) in PROGRAMS {
        let machine = if *machine == "mill3" { mill3() } else { example(machine) };
        let options = Options { profile: Some(*profile), ..Options::default() };
        let source = std::fs::read(folder.join(file)).expect("a file of the folder");
        let compiled = compile(&source, file, &machine, &options);
        let found: BTreeSet<&str> = compiled.diagnostics.iter().filter(|d| !d.is_warning()).map(|d| d.id).collect();
        if found != expected.iter().copied().collect() {
            wrong.push(format!("{file}: {found:?}, expected {expected:?}"));
        }
        println!("{file}: {}", if found.is_empty() { "compiles".to_owned() } else { format!("refused, {found:?}") });
    }
    for file in FOREIGN {
        let source = std::fs::read(folder.join(file)).expect("a file of the folder");
        let compiled = compile(&source, file, &mill3(), &Options::default());
        assert!(compiled.has_errors() && compiled.diagnostics.iter().all(|d| d.is_warning() || !d.hint.is_empty()));
        println!("{file}: refused, a foreign dialect");
    }
    assert_eq!(PROGRAMS.len() + FOREIGN.len(), 40);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
