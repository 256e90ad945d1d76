//! Any bytes as part program: no panic, no hang, at most 64 bytes of memory per input byte while checking.
//!
//! A few seconds with the same cases in every run; `FUZZ_SECONDS=3600` goes on from a seed of the clock.
#![allow(unsafe_code)] // a global allocator cannot be written without

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

use gcode::{At, Limits, Options, compile};
use motion_kernel::machine::{Machine, Profile};

struct Counting;
thread_local! {
    /// Bytes that this thread holds, and the most it held.
    static HELD: Cell<(isize, isize)> = const { Cell::new((0, 0)) };
}
fn take(bytes: isize) {
    let (held, most) = HELD.get();
    HELD.set((held + bytes, most.max(held + bytes)));
}

// SAFETY: every call goes to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        take(layout.size() as isize);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        take(-(layout.size() as isize));
        unsafe { System.dealloc(ptr, layout) }
    }
    unsafe fn realloc(&self, ptr: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        // while it moves, both are there
        take(new_size as isize);
        take(-(layout.size() as isize));
        unsafe { System.realloc(ptr, layout, new_size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What a compilation may hold whatever the text is: variables, files, tables of the reports.
const BASE: isize = 1 << 20;
const PER_BYTE: isize = 64;
/// No text of these sizes may take longer, in the slowest build on a busy machine.
const SLOWEST: Duration = Duration::from_secs(300);

const WORDS: &[&str] = &[
    "G0",
    "G1",
    "G2",
    "G3",
    "G4",
    "G7.1",
    "G10",
    "G17",
    "G18",
    "G19",
    "G20",
    "G21",
    "G28",
    "G33",
    "G40",
    "G41",
    "G42",
    "G43",
    "G49",
    "G50",
    "G51",
    "G51.1",
    "G52",
    "G53",
    "G54",
    "G54.1",
    "G60",
    "G64",
    "G65",
    "G68",
    "G69",
    "G73",
    "G80",
    "G81",
    "G83",
    "G84",
    "G90",
    "G91",
    "G92",
    "G93",
    "G94",
    "G95",
    "G96",
    "G97",
    "X1",
    "Y-2.5",
    "Z",
    "A90",
    "B1",
    "C10",
    "I5",
    "J-5",
    "K1",
    "R5",
    "F100",
    "S500",
    "T3",
    "D1",
    "H2",
    "P2",
    "Q1",
    "L3",
    "E1",
    "N10",
    "N20",
    "N99999999",
    "O1",
    "O2",
    ":3",
    "M0",
    "M3",
    "M6",
    "M30",
    "M62",
    "M66",
    "M98",
    "M99",
    "M17",
    "%",
    "%L5",
    "L5",
    "/",
    "/2",
    "(a",
    ")",
    "(MSG, x)",
    ";",
    "\"",
    "write",
    "writeln",
    "\"t\"",
    ",",
    "=",
    "#1",
    "#[",
    "]",
    "[",
    "##2",
    "#3000",
    "CI5",
    "CD6",
    "CI99",
    "x_y",
    "#<n>",
    "+",
    "-",
    "*",
    "**",
    "SQRT[",
    "ATAN[",
    "MOD",
    "GT",
    "EQ",
    "IF",
    "THEN",
    "GOTO",
    "WHILE",
    "DO1",
    "DO2",
    "END1",
    "END2",
    "o1 sub",
    "o1 endsub",
    "o1 call",
    "o1 while",
    "o1 endwhile",
    "o1 if",
    "o1 else",
    "o1 endif",
    "o1 repeat",
    "o1 endrepeat",
    "o1 do",
    "1",
    "0",
    "1e9",
    "99999999999",
    ".5",
    "-.",
    "\u{e4}",
    "\0",
    "\r",
    "\n",
    "\n",
    "\n",
    "\n",
    "\n",
    "\n",
];

/// xorshift64*: the same cases everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }
    fn below(&mut self, n: usize) -> usize {
        (self.next() >> 16) as usize % n.max(1)
    }
    fn one<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }
}

/// Good programs to be spoiled: the examples, the variants of the tests, the corpus where it is.
fn programs() -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folders = ["examples/jobs", "tests/app/variants", "../../shared/nc"].map(|f| root.join(f));
    let files = folders.iter().filter_map(|f| std::fs::read_dir(f).ok()).flatten().flatten().map(|e| e.path());
    let mut files: Vec<_> = files.filter(|p| p.is_file()).collect();
    files.sort();
    let texts = files.iter().filter_map(|p| std::fs::read(p).ok());
    texts.filter(|t| t.len() < 20_000).collect()
}

fn words(random: &mut Random) -> Vec<u8> {
    let mut text = String::new();
    for _ in 0..random.below(120) {
        text += WORDS[random.below(WORDS.len())];
        text += ["", " ", " ", "\t"][random.below(4)];
    }
    text.into_bytes()
}
fn bytes(random: &mut Random) -> Vec<u8> {
    (0..random.below(300)).map(|_| random.next() as u8).collect()
}
fn spoiled(random: &mut Random, programs: &[Vec<u8>]) -> Vec<u8> {
    let mut text = random.one(programs).clone();
    for _ in 0..1 + random.below(8) {
        let at = random.below(text.len());
        let end = (at + random.below(12)).min(text.len());
        let new: Vec<u8> = match random.below(3) {
            0 => WORDS[random.below(WORDS.len())].bytes().collect(),
            1 => (0..random.below(6)).map(|_| random.next() as u8).collect(),
            _ => text[at..end].repeat(1 + random.below(3)),
        };
        text.splice(at..end, new);
    }
    text
}
/// One short piece with a counter, again and again: what grows with the text grows fast.
fn repeated(random: &mut Random) -> Vec<u8> {
    let piece: String = (0..1 + random.below(5)).map(|_| format!("{} ", WORDS[random.below(WORDS.len())])).collect();
    let (step, mut text) = (1 + random.below(5000), String::new());
    for n in 0..20_000 {
        text += &match random.below(8) {
            0 => format!("N{} {piece}\n", n * step),
            1 => format!("O{n} {piece}\n"),
            2 => format!("F{} {piece}\n", 1 + n),
            _ => format!("{piece}\n"),
        };
        if text.len() > 200_000 {
            break;
        }
    }
    text.into_bytes()
}

fn options(random: &mut Random) -> Options {
    let at = |random: &mut Random| match random.below(6) {
        0 => Some(At::Line(random.below(30) as u32)),
        1 => Some(At::Block(10)),
        _ => None,
    };
    let profile = *random.one(&[Profile::Din, Profile::Fanuc, Profile::Linuxcnc, Profile::Lathe]);
    Options {
        profile: Some(profile),
        from: at(random),
        to: at(random),
        strict: random.below(2) == 0,
        block_delete: random.next() as u16,
        ..Options::default()
    }
}

fn machines() -> Vec<Machine> {
    let mut machines: Vec<Machine> = ["mill4a", "mill4c", "xy-stepper"].map(common::example).into();
    machines.push(common::mill3());
    for machine in &mut machines {
        machine.gcode.tools[0].radius = 1.5;
    }
    machines
}

/// Checks one text, then translates it with less room; the first text that does wrong ends the test.
fn judge(text: &[u8], machine: &Machine, options: &Options) {
    let shown = || String::from_utf8_lossy(&text[..text.len().min(2000)]).into_owned();
    let begun = Instant::now();
    let before = HELD.get().0;
    HELD.set((before, before));
    let limits = Limits { blocks: 300_000, idle_blocks: 100_000, commands: 200_000, ..Limits::default() };
    let checked = compile(text, "t.nc", machine, &Options { check_only: true, limits, ..options.clone() });
    let most = HELD.get().1 - before;
    let allowed = BASE + PER_BYTE * text.len() as isize;
    assert!(most <= allowed, "{most} bytes for {} of text, allowed {allowed}\n{}", text.len(), shown());
    let less = Limits { commands: 20_000, ..limits };
    let made = compile(text, "t.nc", machine, &Options { limits: less, ..options.clone() });
    assert_eq!(made.program.is_none(), made.has_errors(), "{}", shown());
    // small windows and segments: their ends fall everywhere
    let (window, every) = (1 + text.len() % 97, 1 + text.len() as u32 % 5);
    common::same_once(text, machine, &Options { limits: less, ..options.clone() }, window, every);
    if !made.has_errors() {
        assert!(!checked.has_errors(), "{:?}\n{}", checked.diagnostics, shown());
    }
    let lines = text.iter().filter(|b| matches!(b, b'\n' | b'\r')).count() as u32 + 1;
    for d in checked.diagnostics.iter().chain(&made.diagnostics) {
        assert!(d.line >= 1 && d.line <= lines && d.column >= 1 && !d.message.is_empty(), "{d:?}\n{}", shown());
    }
    assert!(begun.elapsed() < SLOWEST, "{:?}\n{}", begun.elapsed(), shown());
}

#[test]
fn any_text_ends_soon_and_in_little_memory() {
    let seconds: Option<u64> = std::env::var("FUZZ_SECONDS").ok().and_then(|s| s.parse().ok());
    let clock = SystemTime::UNIX_EPOCH.elapsed().map_or(1, |t| t.as_nanos() as u64 | 1);
    let mut random = Random(if seconds.is_some() { clock } else { 0x9E37_79B9_7F4A_7C15 });
    let (programs, machines) = (programs(), machines());
    let begun = Instant::now();
    let mut count = 0;
    let more = |count: u32| seconds.map_or(count < 400, |s| begun.elapsed() < Duration::from_secs(s));
    while more(count) {
        let text = match random.below(20) {
            0..3 => bytes(&mut random),
            3..11 => words(&mut random),
            11..19 => spoiled(&mut random, &programs),
            _ => repeated(&mut random),
        };
        let options = options(&mut random);
        judge(&text, random.one(&machines), &options);
        count += 1;
    }
    println!("{count} texts in {:?}", begun.elapsed());
}

/// A block that held a finding for each of its 50,000 pecks took 13 MB.
#[test]
fn many_pecks_outside_the_limits_are_one_finding() {
    let text = b"G90 G17\nG0 X0 Y0 Z0\nG83 X5 Y5 Z-101010 F60 Q2 R3\nG80\nM30\n";
    judge(text, &common::mill3(), &Options::default());
    let made = compile(text, "t.nc", &common::mill3(), &Options { check_only: true, ..Options::default() });
    let outside: Vec<_> = made.diagnostics.iter().filter(|d| d.id == "GC413").collect();
    assert_eq!((outside.len(), outside[0].line), (1, 3), "{:?}", made.diagnostics);
}
