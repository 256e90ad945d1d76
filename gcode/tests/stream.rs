//! The translator thread: users at different speeds, errors, panics, users that go away.

mod common;

use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use common::{flat, mill3};
use gcode::stream::{Counts, Segments, Stream};
use gcode::{Options, compile};
use motion_kernel::autocode::Program;

fn text(lines: usize) -> String {
    let mut text = String::from("G21 G90 F6000\n");
    for n in 0..lines {
        text += &format!("G1 X{} Y{}.5\n", n % 100, n % 7);
        if n % 1000 == 0 {
            text += &format!("(MSG, {n})\n");
        }
    }
    text + "M30\n"
}

fn start(input: impl Read + Clone + Send + Sync + 'static, users: usize) -> (Stream, Vec<Segments>) {
    let open = move || -> io::Result<gcode::Input<'static>> { Ok(Box::new(input.clone())) };
    Stream::start(Box::new(open), "t.nc".to_owned(), Arc::new(mill3()), Options::default(), users).unwrap()
}

fn all(segments: Segments) -> Vec<Program> {
    segments.map(|segment| (*segment).clone()).collect()
}

#[test]
fn every_user_gets_the_whole_program_at_his_own_speed() {
    let text = text(50_000);
    let whole = compile(text.as_bytes(), "t.nc", &mill3(), &Options::default()).program.unwrap();
    let (mut stream, mut users) = start(io::Cursor::new(text), 2);
    let (mut slow, fast) = (users.remove(0), users.remove(0));
    let first = slow.next().unwrap();
    // the fast one needs far more than may wait while nobody asks
    let fast = std::thread::spawn(|| all(fast)).join().unwrap();
    let slow: Vec<Program> = std::iter::once((*first).clone()).chain(all(slow)).collect();
    assert!(fast.len() > 10 && fast == slow);
    assert!(flat(&fast, &mill3()) == flat(std::slice::from_ref(&whole), &mill3()));
    let compiled = stream.finish().unwrap().unwrap();
    assert!(!compiled.has_errors() && stream.finish().is_none());
    let mut counts = Counts::default();
    counts.add(&whole);
    assert_eq!(stream.counts(), counts);
    for (n, event) in whole.events.iter().enumerate() {
        assert_eq!(stream.event(n).as_ref(), Some(event));
    }
    assert_eq!(stream.event(whole.events.len()), None);
    assert_eq!(stream.event(3), None, "forgotten");
}

/// Counts what is read.
#[derive(Clone)]
struct Counted(io::Cursor<String>, Arc<AtomicUsize>);

impl Read for Counted {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n = self.0.read(into)?;
        self.1.fetch_add(n, Ordering::Relaxed);
        Ok(n)
    }
}

#[test]
fn the_translator_waits_for_its_users_and_ends_with_them() {
    let (text, read) = (text(400_000), Arc::new(AtomicUsize::new(0)));
    let size = text.len();
    let (stream, mut users) = start(Counted(io::Cursor::new(text), read.clone()), 1);
    users[0].next().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert!(read.load(Ordering::Relaxed) < size / 4, "{} of {size} bytes", read.load(Ordering::Relaxed));
    let begun = Instant::now();
    drop(stream);
    assert!(begun.elapsed() < Duration::from_secs(20) && users[0].next().is_none());
    assert!(read.load(Ordering::Relaxed) < size / 2);
}

#[test]
fn who_is_sent_away_holds_nobody_up() {
    let (mut stream, mut users) = start(io::Cursor::new(text(100_000)), 2);
    users[0].next().unwrap();
    stream.send_away(0);
    assert!(users.remove(1).count() > 10);
    assert!(users[0].next().is_none());
    assert!(!stream.finish().unwrap().unwrap().has_errors());
}

#[test]
fn an_error_ends_the_segments_and_every_error_is_reported() {
    let text =
        format!("{}G1 X1 Q1\n{}G1 Z1 $\nM30\n", text(30_000).replace("M30", ""), text(30_000).replace("M30", ""));
    let whole = compile(text.as_bytes(), "t.nc", &mill3(), &Options::default());
    let (mut stream, mut users) = start(io::Cursor::new(text), 1);
    let count = users.remove(0).count();
    let found = stream.finish().unwrap().unwrap();
    assert!((3..12).contains(&count), "{count}");
    assert_eq!(found.diagnostics, whole.diagnostics);
    assert!(found.diagnostics.iter().filter(|d| !d.is_warning()).count() == 2);
}

#[test]
fn a_program_that_looks_back_streams_on() {
    let text = text(20_000).replace("M30", "M98 P5 L3") + "M30\nO5\nG1 X1\nX2\nM99\n";
    let whole = compile(text.as_bytes(), "t.nc", &mill3(), &Options::default()).program.unwrap();
    let (mut stream, mut users) = start(io::Cursor::new(text), 1);
    let segments = all(users.remove(0));
    assert!(segments.len() > 3 && flat(&segments, &mill3()) == flat(std::slice::from_ref(&whole), &mill3()));
    assert!(stream.finish().unwrap().unwrap().facts.looks_back);
}

/// Gives some text, then fails.
#[derive(Clone)]
struct Breaks(io::Cursor<String>, bool);

impl Read for Breaks {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self.0.read(into)? {
            0 if self.1 => panic!("the translator"),
            0 => Err(io::Error::other("the disk")),
            n => Ok(n),
        }
    }
}

#[test]
fn a_disk_that_fails_and_a_panic_of_the_translator_reach_the_caller() {
    let (mut stream, mut users) = start(Breaks(io::Cursor::new(text(50_000)), false), 1);
    users.remove(0).for_each(drop);
    assert_eq!(stream.finish().unwrap().unwrap_err().to_string(), "the disk");
    let (mut stream, mut users) = start(Breaks(io::Cursor::new(text(50_000)), true), 1);
    users.remove(0).for_each(drop);
    let panic = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| stream.finish())).unwrap_err();
    assert_eq!(panic.downcast_ref::<&str>(), Some(&"the translator"));
}
