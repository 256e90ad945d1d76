//! Stimulus: the text and its errors, and what the rules do.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::machine::{BUILTIN, Machine};
use motion_kernel::registers::ModeReg;
use motion_kernel::stimulus::{Action, Compare, Condition, ST_IDS, Stimulus, Trigger, WORDS};
use motion_kernel::trace::{EventKind, Trace};

const AXES: [&str; 3] = ["X", "Y", "Z"];

fn parse(text: &str) -> Stimulus {
    Stimulus::parse(text, &AXES).unwrap_or_else(|findings| panic!("{findings:?}"))
}
/// Line, columns and id of every finding.
fn findings(text: &str) -> Vec<(u32, u32, u32, &'static str)> {
    let list = Stimulus::parse(text, &AXES).err().unwrap_or_default();
    list.into_iter().map(|d| (d.line, d.column, d.end_column, d.id)).collect()
}
/// mill3 on its way to X+100 at 50 mm/s.
fn travelling(rules: &str) -> Mcu {
    let mut mcu = mcu_of(Machine::builtin(), ModeReg(0));
    mcu.add_stimulus(&parse(rules));
    line(&mut mcu, &[100.0, 0.0, 0.0], 50.0, 1000.0, 0.0);
    mcu.ssms(mcu.all_axes());
    mcu
}
/// Samples and numbers of the inputs 1 to 16 as they change, from event to event.
fn changes(mcu: &mut Mcu, samples: u64) -> Vec<(u64, u32)> {
    let mut seen = vec![(0, mcu.rddigi(0) & 0xffff)];
    for n in 1..=samples {
        mcu.run(1);
        let now = mcu.rddigi(0) & 0xffff;
        if now != seen[seen.len() - 1].1 {
            seen.push((n, now));
        }
    }
    seen
}

#[test]
fn a_text_becomes_rules() {
    let text = "# faults\nat 2.5 s: input 3 on, input 4 off bouncing 4 ms\n\nwhen X > 100 mm and input 3 on after 20 ms: X \
                blocked # jam\nwhile Y<-5: Y drive off\nwhenever line = 12: Z pushed -0.5 mm, bus error, supply low";
    let rules = parse(text).rules;
    assert_eq!(rules.len(), 4);
    assert_eq!((rules[0].trigger, rules[0].actions.len()), (Trigger::At(2.5), 2));
    assert_eq!(rules[0].actions[1], Action::Input { number: 4, on: false, bounce_s: 0.004 });
    assert_eq!((rules[1].trigger, rules[1].delay_s), (Trigger::When, 0.02));
    let above = Condition::Position { axis: 0, compare: Compare::Above, value: 100.0 };
    assert_eq!(rules[1].conditions, [above, Condition::Input { number: 3, on: true }]);
    assert_eq!(rules[1].actions, [Action::Blocked { axis: 0, on: true }]);
    assert_eq!(rules[2].conditions, [Condition::Position { axis: 1, compare: Compare::Below, value: -5.0 }]);
    assert_eq!(rules[3].conditions, [Condition::Line { compare: Compare::Equal, value: 12.0 }]);
    assert_eq!(
        rules[3].actions,
        [Action::Pushed { axis: 2, distance: -0.5 }, Action::BusError, Action::SupplyLow { deep: false }]
    );
}

#[test]
fn every_error_has_its_place() {
    for (text, place) in [
        ("at 2.5: input 3 on", (1, 7, 7, "ST102")),
        ("\nat 2 s: input 17 on", (2, 15, 16, "ST104")),
        ("at 2 s: input 1.5 on", (1, 15, 17, "ST104")),
        ("at -1 s: input 1 on", (1, 4, 5, "ST104")),
        ("at nan s: input 1 on", (1, 4, 6, "ST104")),
        ("at x s: input 1 on", (1, 4, 4, "ST102")),
        ("if X > 3: input 1 on", (1, 1, 2, "ST102")),
        ("when Q > 3: input 1 on", (1, 6, 6, "ST103")),
        ("when X = 3: input 1 on", (1, 8, 8, "ST102")),
        ("when X > 3", (1, 11, 11, "ST102")),
        ("when X > 3: ", (1, 13, 13, "ST102")),
        ("when X > 3: X", (1, 14, 14, "ST102")),
        ("when X > 3: X bloked", (1, 15, 20, "ST102")),
        ("when X > 3: X blocked Y free", (1, 23, 23, "ST102")),
        ("while X > 3: input 1 on, X pushed 2", (1, 26, 26, "ST105")),
        ("when ci 1000 = 3: X free", (1, 9, 12, "ST104")),
        ("when output 9 on: X free", (1, 13, 13, "ST104")),
        ("when X > 1e99: X free", (1, 10, 13, "ST104")),
        ("when \u{e4}x > 1: X free", (1, 6, 7, "ST103")),
    ] {
        assert_eq!(findings(text), [place], "{text:?}");
    }
    let hint = &Stimulus::parse("when X > 3: X bloked", &AXES).expect_err("an error")[0].hint;
    assert_eq!(hint, "did you mean blocked?");
    let all = findings("at 1: x\nat 2 s: input 3 on\nat 3: y");
    assert_eq!(all.iter().map(|f| f.0).collect::<Vec<_>>(), [1, 3], "every line has its own");
    assert_eq!(findings(&"at 1 s: input 1 on\n".repeat(1001)), [(1001, 1, 1, "ST106")]);
    assert_eq!(findings(&"x\n".repeat(5000)).len(), 100);
    assert_eq!(Stimulus::read(b"\xff", &Machine::builtin()).expect_err("no text")[0].id, "ST101");
}

#[test]
fn no_text_makes_it_panic() {
    let mut state = 1_u64;
    let words: Vec<&str> = WORDS
        .iter()
        .copied()
        .chain([" ", "X", "Y", ":", ",", ">", "<", "=", "3", "-1", "1e9", "s", "ms", "\u{fc}", "#"])
        .collect();
    for _ in 0..20_000 {
        let mut text = String::new();
        for _ in 0..state % 12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            text += words[(state >> 33) as usize % words.len()];
            text += if state >> 60 == 0 { "" } else { " " };
        }
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        for finding in Stimulus::parse(&text, &AXES).err().unwrap_or_default() {
            assert!(finding.column >= 1 && finding.end_column >= finding.column, "{text:?}");
            assert!(ST_IDS.iter().any(|row| row.0 == finding.id) && !finding.hint.is_empty());
        }
    }
}

#[test]
fn a_machine_file_may_have_rules_of_its_own() {
    let text = format!("stimulus = '''\nat 0.1 s: input 3 on\nat 0.2 s: input 3 off\n'''\n{BUILTIN}");
    let machine = Machine::parse(text.as_bytes()).expect("valid");
    assert_eq!(Machine::parse(machine.show().as_bytes()), Ok(machine.clone()));
    let mut mcu = mcu_of(machine, ModeReg(0));
    assert_eq!(changes(&mut mcu, 300), [(0, 0), (79, 4), (157, 0)]);
    for (head, line, column) in [("'''\n", 3, 4), ("'''", 2, 4), ("\"\"\"\r\n", 3, 4)] {
        let tail = &head[..3];
        let text = format!("stimulus = {head}at 1 s: input 1 on\nat x s: input 1 on\n{tail}\n{BUILTIN}");
        let findings = Machine::parse(text.as_bytes()).expect_err("x is no number");
        assert_eq!((findings.len(), findings[0].id), (1, "ST102"));
        assert_eq!((findings[0].line, findings[0].column), (line, column), "{head:?}");
    }
    let findings = Machine::parse(format!("stimulus = 'at x s: input 1 on'\n{BUILTIN}").as_bytes()).expect_err("x");
    assert_eq!((findings[0].line, findings[0].column), (1, 16));
}

#[test]
fn times_are_those_of_the_sample_they_lie_in() {
    let mut mcu =
        travelling("at 0 s: input 1 on\nat 1.28 ms: input 2 on\nat 1.27 ms: input 3 on\nat 12.9 ms: input 1 off");
    assert_eq!(changes(&mut mcu, 20), [(0, 0), (1, 0b101), (2, 0b111), (11, 0b110)]);
}

#[test]
fn when_acts_once_whenever_each_time_while_as_long() {
    let mut mcu = travelling("when X > 10: input 1 on\nwhenever X > 10: input 2 on\nwhile X > 10: input 3 on");
    mcu.run(500);
    assert_eq!(mcu.rddigi(0) & 7, 7);
    mcu.set_inputs(0b100);
    line(&mut mcu, &[0.0, 0.0, 0.0], 50.0, 1000.0, 0.0);
    line(&mut mcu, &[20.0, 0.0, 0.0], 50.0, 1000.0, 0.0);
    let mut lowest = f64::INFINITY;
    let mut seen = Vec::new();
    for _ in 0..4500 {
        mcu.run(1);
        lowest = lowest.min(mcu.machine_position(0));
        if seen.last() != Some(&(mcu.rddigi(0) & 7)) {
            seen.push(mcu.rddigi(0) & 7);
        }
    }
    assert!(lowest < 1e-3);
    assert_eq!(seen, [0b100, 0b000, 0b110], "only 2 and 3 once more");
}

#[test]
fn actions_can_be_delayed() {
    let mut mcu = travelling("when input 1 on after 128 ms: input 2 on\nat 12.9 ms: input 1 on");
    let seen = changes(&mut mcu, 200);
    assert_eq!(seen.iter().map(|s| s.1).collect::<Vec<_>>(), [0, 1, 3]);
    assert!((seen[2].0 as i64 - seen[1].0 as i64 - 100).abs() <= 1, "{seen:?}");
}

#[test]
fn a_contact_bounces() {
    let mut mcu = travelling("at 12.9 ms: input 1 on bouncing 6.4 ms\nat 64 ms: input 1 off bouncing 2.56 ms");
    let seen = changes(&mut mcu, 100);
    let on: Vec<u64> = seen.iter().filter(|s| s.0 < 30).map(|s| s.0).collect();
    assert_eq!(on, [0, 11, 13, 14, 15, 16], "{seen:?}");
    assert_eq!(seen.iter().rfind(|s| s.0 < 30).map(|s| s.1), Some(1), "and stays");
    assert_eq!(seen.last().map(|s| s.1), Some(0));
}

#[test]
fn positions_are_those_of_the_machine() {
    let mut mcu = travelling("when X > 10: input 1 on");
    mcu.shp(0, 100.0);
    mcu.run(100);
    assert_eq!(mcu.rddigi(0) & 1, 0);
    mcu.run(400);
    assert!(mcu.machine_position(0) > 10.0 && mcu.rddigi(0) & 1 == 1);
}

#[test]
fn faults_of_drives_act_and_end() {
    let mut mcu = travelling("while X > 10: X blocked\nat 1.5 s: X pushed -9");
    mcu.run(1000);
    let place = mcu.machine_position(0);
    assert!((10.0..10.1).contains(&place), "{place}");
    mcu.run(500);
    assert!(mcu.machine_position(0) > 9.0, "pushed back it comes free and runs into the block again");
    let mut mcu = travelling("when X > 10: Y encoder cut, Y drive off, bus error, supply lost");
    mcu.run(500);
    assert!(mcu.rddigib(1, 18) == 1 && mcu.rdifsb(22) == 1);
}

#[test]
fn conditions_can_ask_for_outputs_lines_and_variables() {
    let mut mcu = travelling("when output 2 on: input 1 on\nwhen line > 0: input 2 on\nwhen ci 5 = 3: input 3 on");
    mcu.run(10);
    assert_eq!(mcu.rddigi(0) & 7, 2);
    mcu.wrdigob(0, 2, true);
    mcu.set_ci(5, 3);
    mcu.run(1);
    assert_eq!(mcu.rddigi(0) & 7, 7);
}

#[test]
fn the_same_rules_give_the_same_run_in_chunks_of_any_size() {
    let rules =
        "while X > 20: input 14 on bouncing 5 ms\nwhen X > 30 after 17 ms: X blocked\nat 1.2 s: X free, Y pushed 0.3";
    let record = |chunk: u64| {
        let mut mcu = travelling(rules);
        let (mut columns, mut trace) = (Vec::new(), Trace::default());
        for _ in 0..2000 / chunk {
            mcu.pass(chunk, &mut trace);
            columns.extend_from_slice(&trace.rp);
        }
        let events: Vec<_> = mcu.events().into_iter().filter(|e| e.kind == EventKind::Stimulus).collect();
        assert!(events.iter().any(|e| e.name == "blocked" && e.on && e.axis == 0));
        (columns, events, mcu.rdlp(0))
    };
    assert_eq!(record(1), record(1000));
}

#[test]
fn the_page_names_every_word_and_every_id() {
    let page = std::fs::read_to_string("../docs/stimulus.md").expect("docs/stimulus.md");
    for (id, remedy) in ST_IDS {
        assert!(page.contains(&format!("| {id} | {remedy} |")), "{id}");
    }
    for word in WORDS {
        assert!(page.split(|c: char| !c.is_alphanumeric()).any(|w| w == word), "{word}");
    }
}
