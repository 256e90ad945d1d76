//! Machine files: every finding has its place, and no input makes the reader panic.

use motion_kernel::machine::{BUILTIN, Machine, MachineDiagnostic};
use proptest::prelude::*;

fn findings(text: &str) -> Vec<MachineDiagnostic> {
    Machine::parse(text.as_bytes()).expect_err("the file is wrong")
}

fn changed(from: &str, to: &str) -> Vec<(u32, &'static str, String)> {
    assert!(BUILTIN.contains(from), "{from}");
    findings(&BUILTIN.replacen(from, to, 1)).into_iter().map(|d| (d.line, d.id, d.hint)).collect()
}

#[test]
fn every_example_machine_reads() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/machines");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("examples/machines") {
        let path = entry.expect("entry").path();
        let machine = Machine::parse(&std::fs::read(&path).expect("readable")).expect("valid");
        assert_eq!(Some(machine.name.as_str()), path.file_stem().and_then(|s| s.to_str()));
        count += 1;
    }
    assert!(count >= 4);
}

#[test]
fn a_mistyped_key_is_found_with_its_line() {
    let line = 1 + BUILTIN[..BUILTIN.find("maxacc").expect("a key")].matches('\n').count() as u32;
    let found = changed("maxacc = 1000.0", "maxac = 1000.0");
    assert_eq!(found, [(line, "MC103", "did you mean maxacc?".to_owned())]);
}

#[test]
fn all_findings_of_a_file_are_reported() {
    let text = BUILTIN.replacen("rapid = 200.0", "rapid = -1.0", 1).replacen("mpe = 1.0", "mpe = \"x\"", 1);
    let ids: Vec<&str> = findings(&text).iter().map(|d| d.id).collect();
    assert_eq!(ids, ["MC106", "MC105"]);
}

#[test]
fn each_kind_of_error_has_its_id() {
    assert_eq!(changed("rapid = 200.0", "")[0].1, "MC104");
    assert_eq!(changed("\"SMA\"", "\"SMX\"")[0].1, "MC107");
    assert_eq!(changed("name = \"Y\"", "name = \"X\"")[0].1, "MC108");
    assert_eq!(changed("left = -600.0", "left = 700.0")[0].1, "MC110");
    assert_eq!(changed("\"LookAhead\"", "\"LookAhed\"")[0].2, "did you mean LookAhead?");
    assert_eq!(changed("[controller]", "[controller")[0].1, "MC102");
    assert_eq!(changed("rapid = 200.0", "rapid = nan")[0].1, "MC106");
    assert_eq!(findings("")[0].id, "MC109");
    assert_eq!(Machine::parse(&[0xff, 0xfe, 0]).expect_err("binary")[0].id, "MC101");
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = Machine::parse(&bytes);
    }

    #[test]
    fn no_damage_makes_the_reader_panic(at in 0..BUILTIN.len(), cut in 0usize..80, put in "[a-z=\\[\\]{}\"0-9.\n-]{0,12}") {
        let mut bytes = BUILTIN.as_bytes().to_vec();
        let end = (at + cut).min(bytes.len());
        bytes.splice(at..end, put.bytes());
        if let Err(list) = Machine::parse(&bytes) {
            prop_assert!(list.iter().all(|d| d.line >= 1 && d.column >= 1 && d.end_column >= d.column));
        }
    }
}
