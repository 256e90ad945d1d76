//! A program that is read once, in windows and segments of any size, gives what the whole compilation gives.

mod common;

use std::path::Path;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

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
    assert!(read_once * 2 > all, "of only {read_once} of {all} no text is kept");
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
fn a_program_that_looks_back_goes_on_in_its_text() {
    let middles = [
        "M98 P5\n",
        "M98 P5 L3\nX1\nM98 P6\n",
        "GOTO 5000\nX7\n",
        "#1=3\nWHILE [#1 GT 0] DO1\nG1 X#1\n#1=#1-1\nEND1\n",
        "#2=0\nN4000 G1 X3\n#2=#2+1\nIF [#2 LT 3] GOTO 4000\nIF [#2 LT 3] GOTO 7\n",
        "M98 P77\n",
        "G65 P5 X3\n",
        "L5\n",
        "END1\n",
        "WHILE [1 EQ 1] DO1\n",
        "GOTO 6\n",
    ];
    let end = "N5000 G1 X20\nM30\nO5\nG91 G1 X1\nG90\nM99\nO6\nM98 P5\nM99\nO8\nM99\n";
    let limits = gcode::Limits { idle_blocks: 3000, commands: 5000, ..gcode::Limits::default() };
    for strict in [false, true] {
        let options = Options { strict, limits, ..Options::default() };
        for middle in middles {
            for (window, every) in [(1, 3), (4096, 100)] {
                assert!(!same_once(&long(middle, end), &mill3(), &options, window, every), "{middle:?}");
            }
        }
    }
    // M99 in the main program, which starts again from its first block
    let mut again = mill3();
    again.gcode.dialect.main_loop = Some(3);
    assert!(!same_once(&long("", "M99\n"), &again, &Options::default(), 100, 30));
    assert!(same_once(&long("", "M30\n"), &again, &Options::default(), 100, 30));
}

#[test]
fn a_text_without_line_ends_is_taken_whole() {
    assert!(same_once(&vec![b'x'; 3 << 20], &mill3(), &Options::default(), 1 << 18, 9), "a line of 3 MiB");
    let late = [long("", ""), vec![b' '; 3 << 20], b"\nG1 X5\nM98 P9\n".to_vec()].concat();
    assert!(!same_once(&late, &mill3(), &Options::default(), 1 << 18, 9));
}

/// The linter finds the same, also where what it looks for is not known before the end.
#[test]
fn the_linter_finds_the_same() {
    let strict = Options { strict: true, ..Options::default() };
    let middles = ["G1 X0 F60\nX10 F6000\n", "G0 Z50\nG0 Z1\nX50\n", "G2 X10.001 Y0 I5 J0\nG1 X0\nG2 X0.001 Y0 R5\n"];
    let ends =
        ["M30\nO5\nM99\nO5\nM99\n%L7\n", "M30\n%\nO9\n", "O2\nG1 X1\nM30\n(O4)\nN4 O4 (a)\nM98 P4\n  :77 \u{e4}\n"];
    for (middle, end) in middles.iter().flat_map(|m| ends.iter().map(move |e| (m, e))) {
        for (window, every) in [(1, 3), (333, 9)] {
            assert!(same_once(&long(middle, end), &mill3(), &strict, window, every));
            let text = [b"%\nO1\n".as_slice(), &long(middle, end)[2..]].concat();
            assert!(same_once(&text, &mill3(), &strict, window, every));
        }
    }
}

/// Block search over windows: found in the first or the last, not at all, twice, and what was left behind.
#[test]
fn parts_are_the_same() {
    let middle =
        "T1 M6\nM3 S500\nM8\nwrite \"a\", CI5\nCI7=5\n(MSG, a)\nN1000 G1 X5\nG41 D1 X90 Y20\nN1100 X100\nG40 X40 Y90\n";
    let mut machine = mill3();
    machine.gcode.tools[0].radius = 1.5;
    let places = ["1", "3", "5", "N7", "N299", "305", "N1000", "N1100", "320", "600", "9999", "N9999", "N3"];
    let at = |text: &str| match text.strip_prefix('N') {
        Some(number) => gcode::At::Block(number.parse().unwrap()),
        None => gcode::At::Line(text.parse().unwrap()),
    };
    let text = long(middle, "N3 X1\nM30\nN1\n");
    let parts = places.iter().flat_map(|a| places.iter().map(move |b| (Some(at(a)), Some(at(b)))));
    let halves = places.iter().flat_map(|a| [(Some(at(a)), None), (None, Some(at(a)))]);
    for (from, to) in parts.step_by(11).chain(halves) {
        for (strict, check_only) in [(false, false), (true, true)] {
            let options = Options { from, to, strict, check_only, ..Options::default() };
            assert!(same_once(&text, &machine, &options, 200, 7), "{from:?} {to:?}");
        }
    }
    let looping =
        long("#1=2\nWHILE [#1 GT 0] DO1\nN700 G1 X#1\n#1=#1-1\nEND1\nM98 P5\nN800 X9\n", "M30\nO5\nN900 X2\nM99\n");
    for from in ["N5", "N700", "N800", "N900"].map(at) {
        let options = Options { from: Some(from), to: Some(at("N800")), ..Options::default() };
        assert!(!same_once(&looping, &machine, &options, 100, 7), "{from:?}");
    }
}

#[test]
fn a_text_that_is_too_large_or_shrinks_or_fails_is_told() {
    let limits = gcode::Limits { bytes: 5000, held: 3000, ..gcode::Limits::default() };
    let options = Options { limits, ..Options::default() };
    let ids = |text: &[u8]| -> Vec<_> {
        common::once(text, &mill3(), &options, 100, 9).1.diagnostics.iter().map(|d| (d.id, d.line)).collect()
    };
    assert_eq!(ids(&long("", "M30\n")), [("GC106", 1)]);
    let short = |end: &str| [&long("", "")[..4000], b"\n", end.as_bytes()].concat();
    assert_eq!(ids(&short("M30\n")), []);
    let found = ids(&short("M98 P5\nX1 $\nM30\nO5\nM99\n"));
    assert!(matches!(found[..], [("GC106", line)] if line > 200), "{found:?}");

    let opened = AtomicUsize::new(0);
    let failing = |how: usize| {
        opened.store(0, Relaxed);
        let open = || -> std::io::Result<gcode::Input<'static>> {
            match (opened.fetch_add(1, Relaxed), how) {
                (0, _) => Ok(Box::new(std::io::Cursor::new(long("M98 P5\n", "M30\nO5\nM99\n")))),
                (_, 0) => Ok(Box::new(std::io::Cursor::new(b"M30\n".to_vec()))),
                _ => Err(std::io::Error::other("the disk")),
            }
        };
        gcode::compile_once(&open, "t.nc", &mill3(), &Options::default(), None, 100).unwrap_err().to_string()
    };
    assert_eq!(failing(0), "the file became shorter while it was read");
    assert_eq!(failing(1), "the disk");
}
