//! Machine files: every finding has its place, and no input makes the reader panic.

use motion_kernel::machine::{BUILTIN, Machine, MachineDiagnostic, Side};
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

#[test]
fn lists_of_lines_and_m_functions_are_checked() {
    let with = |more: &str| findings(&format!("{BUILTIN}\n{more}"))[0].id;
    assert_eq!(with("[gcode.outputs]\nclamp = [33]"), "MC106");
    assert_eq!(with("[gcode.outputs]\nclamp = 3"), "MC105");
    assert_eq!(with("[[gcode.m]]\nset = [3]"), "MC104");
    assert_eq!(with("[[gcode.m]]\nnumber = 3"), "MC111");
    assert_eq!(with("[[gcode.m]]\nnumber = 100\n[[gcode.m]]\nnumber = 100"), "MC111");
    assert_eq!(with("[[gcode.m]]\nnumber = 100\nci = 99"), "MC111");
    assert_eq!(with("[[gcode.tool]]\nnumber = 7\n[[gcode.tool]]\nnumber = 7"), "MC111");
    assert_eq!(with("[gcode.dialect]\noword = 1"), "MC105");
    assert_eq!(with("[gcode.references]\nP5 = { X = 1 }"), "MC103");
    assert_eq!(with("[gcode.references]\nP2 = { Q = 1 }"), "MC103");
}

#[test]
fn inputs_are_checked() {
    let with = |more: &str| findings(&format!("{BUILTIN}\n[[input]]\n{more}"))[0].id;
    assert_eq!(with("number = 17"), "MC106");
    assert_eq!(with("inverted = true"), "MC104");
    assert_eq!(with("number = 1\nfunction = \"EO\""), "MC104");
    assert_eq!(with("number = 1\naxis = \"X\""), "MC104");
    assert_eq!(with("number = 1\nfunction = \"EO\"\naxis = \"Q\""), "MC107");
    assert_eq!(with("number = 1\nfunction = \"LSL\"\naxis = \"X\""), "MC107");
    let text = format!("{BUILTIN}\n[[input]]\nnumber = 2\nfunction = \"LSR_SMD\"\naxis = \"Y\"\ninverted = true\n");
    let machine = Machine::parse(text.as_bytes()).expect("valid");
    assert_eq!(machine.inverted_inputs(), 2);
    assert_eq!(Machine::parse(machine.show().as_bytes()), Ok(machine));
}

#[test]
fn a_machine_with_every_option_is_shown_and_read_back() {
    let more = "[gcode.outputs]\nclamp = []\nspindle_ccw = [1, 32]\n[[gcode.m]]\nnumber = 100\nset = [2]\nci = 5\n\
        value = -3\n[gcode.references]\nP4 = { Y = 2.5 }\n[gcode.offsets]\nG57 = { Z = 1e-3 }\n[gcode.dialect]\n\
        dwell_p_unit = \"s\"\narc_centre = \"likeController\"\ninteger_increment = 0.001\nmacros = false\n\
        oword = true\nvacant_zero = true\ndiameter = true\nuvw_incremental = false\nkeep_g92 = true\n\
        nested_comments = false\npeck_clearance = 0.5\nstrict_m = true\n[[gcode.tool]]\nnumber = 99\nlength = 80.0\n";
    let machine = Machine::parse(format!("{BUILTIN}\n{more}").as_bytes()).expect("valid");
    assert_eq!(machine.gcode.outputs.spindle_ccw, 0x8000_0001);
    assert_eq!(machine.gcode.references[2], Some(vec![0.0, 2.5, 0.0]));
    assert_eq!(Machine::parse(machine.show().as_bytes()), Ok(machine));
}

#[test]
fn a_file_full_of_errors_is_refused_quickly_with_the_first_hundred() {
    for (text, id) in [
        ("[[axis]]\n".repeat(100_000), "MC106"),
        ("axis = [".to_owned() + &"1,".repeat(400_000) + "]", "MC106"),
        ("x".repeat(1_000_000) + " = 1", "MC103"),
        ((0..80_000).map(|n| format!("k{n}=1\n")).collect(), "MC103"),
        ("a = ".to_owned() + &"[".repeat(500_000), "MC102"),
        ("a = \"".to_owned() + &"x".repeat(1_000_000), "MC102"),
    ] {
        let start = std::time::Instant::now();
        let list = findings(&text);
        assert!(list.len() <= 100 && list.iter().any(|d| d.id == id), "{id}: {:?}", &list[..2.min(list.len())]);
        assert!(list.iter().all(|d| d.message.len() < 1000 && d.hint.len() < 1000));
        assert!(start.elapsed().as_secs() < 5, "{id} took {:?}", start.elapsed());
    }
}

#[test]
fn nineteen_axes_are_too_many() {
    let axis = |n: usize| {
        format!("[[axis]]\nname = \"A{n}\"\nletter = \"\"\ncounts_per_unit = 1\nrapid = 1\nacceleration = 1\n")
    };
    let text: String = (0..19).map(axis).collect();
    assert_eq!(findings(&text).iter().map(|d| d.id).collect::<Vec<_>>(), ["MC109"]);
    let text: String = (0..18).map(axis).collect();
    assert_eq!(Machine::parse(text.as_bytes()).expect("18 axes are allowed").axes.len(), 18);
}

#[test]
fn the_page_about_machine_files_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/machine-file.md");
    let page = std::fs::read_to_string(path).expect("docs/machine-file.md");
    assert!(page == motion_kernel::machine::machine_reference(), "write the page again, its head says how");
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

/// The largest and smallest values that the reader accepts still give a machine that runs.
#[test]
fn extreme_machines_run_without_panic() {
    let axis = |n: usize, numbers: &str| format!("[[axis]]\nname = \"A{n}\"\nletter = \"\"\n{numbers}\n");
    let large = "counts_per_unit = 1e9\nrapid = 1e9\nacceleration = 1e9\nstart = 1e9\neffradius = 1e9\n\
        pidf = { kp = 1e9, ki = 1e9, kd = 1e9, kpl = 1.0, kfcv = 1e9, kfca = 1e9 }\n\
        plant = { lag_s = 10.0, full_speed = 1e9, backlash = 1e9, full_acceleration = 1e9, inertia = 1e3 }";
    let small = "kind = \"rotary\"\ncounts_per_unit = 1e-9\nrapid = 1e-9\nacceleration = 1e-9\neffradius = 1e-9\nslsp = 1e-9\n\
        plant = { control = \"torque\", lag_s = 0.0, full_speed = 1e-9, full_acceleration = 1e-9, inertia = 1e-3, \
        friction = 1e9, damping = 1e6 }";
    let controller = "[controller]\nsample_ticks = 1000\nspool_memory_bytes = 29826161\nclock_hz = 1e9\n";
    for numbers in [large, small] {
        let text: String = (0..18).map(|n| axis(n, numbers)).collect::<String>() + controller;
        let machine = Machine::parse(text.as_bytes()).expect("within bounds");
        let mut mcu = motion_kernel::Mcu::new(std::sync::Arc::new(machine));
        mcu.prepare_gcode();
        for a in 0..18 {
            mcu.wrdp(a, mcu.rddp(a) * 0.999 + 1e-9);
        }
        mcu.run(200);
        assert!((0..18).all(|a| mcu.rdrp(a).is_finite() && mcu.status().axes[a].load.is_finite()));
    }
}

/// A million entries have room in three axes; what all axes have together is bounded.
#[test]
fn spool_memory_is_bounded_in_all() {
    let machine = |axes: usize, bytes: u32| {
        let numbers = "counts_per_unit = 1e4\nrapid = 100\nacceleration = 1000\n";
        let axis = |n: usize| format!("[[axis]]\nname = \"A{n}\"\nletter = \"\"\n{numbers}");
        let text = (0..axes).map(axis).collect::<String>() + &format!("[controller]\nspool_memory_bytes = {bytes}\n");
        Machine::parse(text.as_bytes())
    };
    assert_eq!(machine(3, 128_000_000).err(), None);
    let findings = machine(5, 128_000_000).expect_err("too much together");
    assert_eq!((findings.len(), findings[0].id, findings[0].line), (1, "MC107", 32));
    assert!(findings[0].message.contains("5 axes"), "{}", findings[0].message);
}

#[test]
fn what_an_axis_has_beside_drive_and_loop_is_read_checked_and_shown() {
    let keys = "mpe = 1.0\nhome_velocity = 5.0\nhome_acceleration = 50.0\nhome_direction = \"right\"\nbacklash_compensation = 0.02\n\
                backlash_hysteresis = 0.1\nindex = { position = 1.0, period = 5.0, width = 0.01, inverted = true }\n\
                encoder = { counts_per_unit = 4000.0, feedback = true }\n\
                port = { max = 30000.0, min = -20000.0, positive = 50.0, negative = 60.0, inverted = true }";
    let outputs = "\n[[output]]\nnumber = 2\non = true\n[[output]]\nnumber = 3\naxis = \"Y\"\nfunction = \"PAE\"\n";
    let text = BUILTIN.replacen("mpe = 1.0", keys, 1) + outputs;
    let text = text.replacen("sample_ticks = 20", "stop_at = [\"mpe\", \"saf\"]", 1);
    let machine = Machine::parse(text.as_bytes()).expect("valid");
    let equipment = &machine.axes[0].equipment;
    assert_eq!((equipment.home.velocity, equipment.backlash_hysteresis), (Some(5.0), 0.1));
    assert_eq!((equipment.home.side, machine.axes[1].equipment.home.side), (Side::Right, Side::Left));
    assert!(equipment.index.is_some_and(|i| i.inverted && i.period == 5.0));
    assert!(equipment.encoder.is_some_and(|e| e.feedback) && equipment.port.inverted);
    assert_eq!(
        machine.outputs.iter().map(|o| (o.number, o.on, o.amplifier_of)).collect::<Vec<_>>(),
        [(2, true, None), (3, false, Some(1))]
    );
    assert_eq!(machine.controller.stop_at.names().collect::<Vec<_>>(), ["mpe", "saf"]);
    assert_eq!(Machine::parse(machine.show().as_bytes()), Ok(machine));

    let id = |from: &str, to: &str| {
        let text = text.replacen(from, to, 1);
        findings(&text).into_iter().map(|d| d.id).collect::<Vec<_>>()
    };
    assert_eq!(id("width = 0.01", "width = 5.0"), ["MC110"]);
    assert_eq!(id("width = 0.01, ", ""), ["MC104"]);
    assert_eq!(id("\"right\"", "\"up\""), ["MC107"]);
    assert_eq!(id("\"right\"", "1"), ["MC105"]);
    assert_eq!(id("max = 30000.0", "max = -25000.0"), ["MC110"]);
    assert_eq!(id("max = 30000.0", "max = 40000.0"), ["MC106"]);
    assert_eq!(id("positive = 50.0", "positive = -1.0"), ["MC106"]);
    assert_eq!(id("number = 3\naxis", "number = 9\naxis"), ["MC106"]);
    assert_eq!(id("axis = \"Y\"\nfunction = \"PAE\"", "axis = \"Q\"\nfunction = \"PAE\""), ["MC107"]);
    assert_eq!(id("axis = \"Y\"\nfunction = \"PAE\"", "function = \"PAE\""), ["MC104"]);
    assert_eq!(id("axis = \"Y\"\nfunction = \"PAE\"", "axis = \"Y\""), ["MC104"]);
    for word in ["pe", "mpee", "referenced"] {
        assert_eq!(id("\"mpe\"", &format!("\"{word}\"")), ["MC107"], "{word}");
    }
}

#[test]
fn the_dry_run_feed_is_that_of_the_file_up_to_the_feed_limit() {
    let with = |line: &str| BUILTIN.replacen("[gcode] ", &format!("[gcode]\n{line} "), 1);
    let machine = Machine::parse(with("dry_feed = 25.0").as_bytes()).expect("valid");
    assert_eq!(machine.gcode.dry_feed, 25.0);
    assert_eq!(Machine::parse(machine.show().as_bytes()), Ok(machine));
    let builtin = Machine::builtin();
    assert_eq!(builtin.gcode.dry_feed, builtin.gcode.feed_limit);
    let found = findings(&with("dry_feed = 1e6"));
    assert_eq!(found.iter().map(|d| d.id).collect::<Vec<_>>(), ["MC110"]);
    assert!(found[0].message.contains("above feed_limit"), "{}", found[0].message);
    assert_eq!(findings(&with("dry_feed = 0.0"))[0].id, "MC106");
}
