//! A program that is read once, in windows and segments of any size, gives what the whole compilation gives.

mod common;

use std::path::Path;

use common::{example, mill3, same_once};
use gcode::Options;

/// The examples, the variants of the tests, and the corpus where it is.
fn programs() -> Vec<(String, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folders = ["examples/jobs", "tests/app/variants", "../../shared/nc"].map(|f| root.join(f));
    let files = folders.iter().filter_map(|f| std::fs::read_dir(f).ok()).flatten().flatten().map(|e| e.path());
    let mut files: Vec<_> = files.filter(|p| p.is_file() && p.metadata().is_ok_and(|m| m.len() < 300_000)).collect();
    files.sort();
    files.iter().map(|p| (p.display().to_string(), std::fs::read(p).expect("readable"))).collect()
}

#[test]
fn real_programs_give_the_same_in_windows_and_segments_of_any_size() {
    let (mut read_once, mut all) = (0, 0);
    for (name, text) in programs() {
        for (machine, window, every) in [(mill3(), 64, 1), (mill3(), 1000, 7), (example("mill4c"), 1 << 18, 64)] {
            all += 1;
            read_once += u32::from(same_once(&text, &machine, &Options::default(), window, every));
        }
        println!("{name}");
    }
    assert!(read_once * 2 > all, "only {read_once} of {all} are read once");
}

/// A text longer than what is looked at in the beginning, with a tail and whatever is asked for in the middle.
fn long(middle: &str, end: &str) -> Vec<u8> {
    let mut text = String::from("%\n(h\u{e4}lt)\nG21 G90 G17 F600\n");
    for n in 0..300 {
        text += &format!("N{n} G1 X{}.5 Y{}\n", n % 40, n % 7);
    }
    text += middle;
    for n in 0..300 {
        text += &format!("G1 X{}.25 (\u{e4}) Y{}\r\n", n % 30, n % 9);
    }
    (text + end).into_bytes()
}

#[test]
fn windows_end_anywhere() {
    let ends = ["M30\n", "M30", "M30  \t\n\n\u{1a}\0\0\n", "M30\n%\nbehind the tape\n", "", "X1\r", "\n\r\n\r"];
    let middles = [
        "",
        "\n\n\n    \n\t\n\u{13}\n\n\n",
        "G1 X1 Y2 F1e5\nX1.0001\nX1.0002\n(a comment)\n\nX1.0003\nX9\n",
        "(\u{e4}) G1 X50.0001 F60000\n\n\n(\u{fc})\nX80\n",
        "G20\nG1 X0.5 F9\n",
        "G41 D1 X90 Y20\nX100\nM8\nY60\nwrite \"a\"\nX50\nG40 X40 Y90\n",
        "write \"t\", CI5\nwriteln\nM3 S100\nT1 M6\n(MSG, go)\nM0\n",
        "G1 X1 Z\nQ\n$\nG2 X1\n",
        "#5=3\nG1 X#5\nIF [#5 EQ 4] GOTO 5\nX0\n",
        "M99\n",
    ];
    let mut machine = mill3();
    machine.gcode.tools[0].radius = 1.5;
    for (middle, end) in middles.iter().flat_map(|m| ends.iter().map(move |e| (m, e))) {
        for (window, every) in [(1, 3), (13, 1), (77, 5), (4096, 100)] {
            assert!(same_once(&long(middle, end), &machine, &Options::default(), window, every), "{middle:?} {end:?}");
        }
    }
    assert!(same_once(&long("G7.1 C20\nG1 C90\nG7.1 C0\n", "M30\n"), &example("mill4c"), &Options::default(), 50, 2));
}

#[test]
fn what_has_to_look_back_is_compiled_whole() {
    for middle in ["M98 P5\n", "GOTO 5\n", "WHILE [1 EQ 0] DO1\nEND1\n", "G65 P5\n", "L5\n"] {
        assert!(!same_once(&long(middle, "M30\n"), &mill3(), &Options::default(), 500, 9), "{middle}");
    }
    let strict = Options { strict: true, ..Options::default() };
    assert!(!same_once(&long("", "M30\n"), &mill3(), &strict, 500, 9));
    assert!(!same_once(&vec![b'x'; 3 << 20], &mill3(), &Options::default(), 1 << 18, 9), "a line of 3 MiB");
}
