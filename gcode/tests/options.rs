//! What options of the machine file change (docs/machine-file.md, gcode and gcode.dialect).

mod common;

use std::sync::Arc;

use common::{Command, commands, ends, example, mill3, program_for};
use gcode::{Options, compile};
use motion_kernel::autocode::Instr;
use motion_kernel::machine::{BUILTIN, DialectOptions, Machine, Profile};
use motion_kernel::registers::{Axst, ModeReg};
use motion_kernel::tasks::TaskState;
use motion_kernel::trace::Trace;
use motion_kernel::{Mcu, Stop};

fn with(dialect: DialectOptions) -> Machine {
    let mut machine = mill3();
    machine.gcode.dialect = dialect;
    machine
}
fn plain() -> DialectOptions {
    DialectOptions::default()
}
fn all(text: &str, machine: &Machine) -> Vec<Command> {
    commands(&program_for(text, machine, &Options::default()))
}
fn ids(text: &str, machine: &Machine) -> Vec<&'static str> {
    compile(text.as_bytes(), "t.nc", machine, &Options::default()).diagnostics.iter().map(|d| d.id).collect()
}
fn x(text: &str, machine: &Machine) -> Vec<f64> {
    ends(&program_for(text, machine, &Options::default())).iter().map(|e| e[0]).collect()
}

#[test]
fn rapids_that_blend() {
    let tvl = |machine: &Machine| -> Vec<f64> {
        program_for("G0 X10\nG1 X20 F600\nG0 X50\nX60\nM30\n", machine, &Options::default())
            .moves
            .iter()
            .map(|m| m.tvl)
            .collect()
    };
    assert_eq!(tvl(&mill3()), [0.0; 4]);
    assert_eq!(tvl(&with(DialectOptions { rapid_blend: Some(true), ..plain() })), [10.0, 10.0, 200.0, 0.0]);
}

#[test]
fn the_feed_at_the_block_end() {
    let machine = with(DialectOptions { end_feed: Some(true), ..plain() });
    let tvl = |text: &str| -> Vec<f64> {
        program_for(text, &machine, &Options::default()).moves.iter().map(|m| m.tvl).collect()
    };
    assert_eq!(tvl("G1 X10 F600 E120\nX20\nX30 E9000\nX40\nM30\n"), [2.0, 10.0, 10.0, 0.0]);
    assert_eq!(ids("G1 X10 F600 E0\nM30\n", &machine), ["GC504"]);
    assert_eq!(ids("G0 X10 E5\nM30\n", &machine), ["GC214"]);
}

#[test]
fn the_main_program_again() {
    let machine = with(DialectOptions { main_loop: Some(2), ..plain() });
    for head in ["", "%\n", "%\nO7\n", "O7 (part)\n"] {
        let text = format!("{head}G91 G0 X1\nM8\nM99\n");
        assert_eq!(x(&text, &machine), [1.0, 2.0, 3.0], "{head:?}");
        let stops = all(&text, &machine).iter().filter(|c| matches!(c, Command::Ssf { command: 1000, .. })).count();
        assert_eq!((stops, ids(&text, &machine)), (2, vec!["GW912"]), "{head:?}");
    }
    assert_eq!(x("G91 G0 X1\nM99\n", &mill3()), [1.0]);
}

#[test]
fn the_end_inside_a_subprogram() {
    let text = "L5\nG0 X9\nM30\n%L5\nG0 X1\nM30\nM17\n";
    assert_eq!(x(text, &mill3()), [1.0], "it ends all");
    assert_eq!(ids(text, &with(DialectOptions { strict_end: Some(true), ..plain() })), ["GC615"]);
}

#[test]
fn a_tool_change_needs_its_tool() {
    let machine = with(DialectOptions { m6_needs_t: Some(true), ..plain() });
    assert_eq!(ids("T1\nG0 X1\nM6\nT2 M6\nM30\n", &machine), Vec::<&str>::new());
    assert_eq!(ids("M6\nM30\n", &machine), ["GC516"]);
    assert_eq!(ids("M6\nM30\n", &mill3()), Vec::<&str>::new());
}

#[test]
fn diameter_programming_by_g07_and_g08() {
    let machine = with(DialectOptions { g07_g08: Some(true), ..plain() });
    assert_eq!(x("G0 X10\nG7 X10\nG8 X10\nG7\nG91 X10\nM30\n", &machine), [10.0, 5.0, 10.0, 15.0]);
    assert_eq!(ids("G7 X10\nM30\n", &mill3()), ["GC305"]);
}

#[test]
fn g_code_system_a_of_lathes() {
    let machine = with(DialectOptions { g_system_a: Some(true), ..plain() });
    let vl = |text: &str| program_for(text, &machine, &Options::default()).moves[0].vl;
    assert_eq!(vl("G98 G1 X10 F600\nM30\n"), 10.0);
    assert_eq!(vl("M3 S600\nG99 G1 X10 F0.5\nM30\n"), 5.0);
    for text in ["G90 X10\nM30\n", "G92 X10\nM30\n", "G94 X10\nM30\n"] {
        assert_eq!(ids(text, &machine), ["GC317"], "{text}");
    }
    let lathe = Options { profile: Some(Profile::Lathe), ..Options::default() };
    // G50 with axis words is the preset of a lathe: X40 becomes 100, in diameters
    let program = program_for("G0 X40 Z0\nG50 X100\nG0 X90\nM30\n", &mill3(), &lathe);
    assert_eq!(ends(&program).last().map(|e| e[0]), Some(15.0));
}

#[test]
fn a_lathe_tool_word_names_the_correction_too() {
    let mut machine = mill3();
    (machine.gcode.tools[4].length, machine.gcode.tools[0].length) = (40.0, 10.0);
    let lathe = Options { profile: Some(Profile::Lathe), ..Options::default() };
    // G18: the length acts in Y
    let program = program_for("T0105 M6\nG43 G0 Y1\nT0101 M6\nG43 Y1\nM30\n", &machine, &lathe);
    assert_eq!(ends(&program).iter().map(|e| e[1]).collect::<Vec<_>>(), [41.0, 11.0]);
}

#[test]
fn exact_stops_wait_for_the_window() {
    let machine = with(DialectOptions { exact_in_position: Some(true), ..plain() });
    let text = "G61 G1 X10 F6000\nX20\nG64 X30\nX40\nM30\n";
    let program = program_for(text, &machine, &Options::default());
    let waits: Vec<u32> = program
        .code
        .iter()
        .zip(&program.lines)
        .filter(|(i, _)| matches!(i, Instr::InPosition(_)))
        .map(|(_, l)| *l)
        .collect();
    assert_eq!(waits, [1, 2]);
    let mut mcu = Mcu::new(Arc::new(machine));
    mcu.prepare_gcode();
    mcu.load(0, Arc::new(program));
    mcu.startcnct(0);
    let mut trace = Trace::new(3, 1);
    let mut stood = false;
    for _ in 0..3000 {
        trace.restart(mcu.samples());
        if mcu.advance(1, &mut trace).stop == Stop::Finished {
            break;
        }
        // the second move begins only when the first is in position
        let x = trace.dp[0];
        if x > 10.0 && !stood {
            stood = true;
            assert!((mcu.rdrp(0) - 10.0).abs() < 0.02, "{} {x}", mcu.rdrp(0));
        }
    }
    assert!(stood && mcu.rdaxst(0).has(Axst::ip));
}

#[test]
fn a_window_that_is_never_reached_is_refused() {
    let text =
        format!("{}\n[gcode.dialect]\nexact_in_position = true\n", BUILTIN.replacen("ipw = 0.01", "ipw = 0.0", 1));
    let found = Machine::parse(text.as_bytes()).unwrap_err();
    assert_eq!(found.iter().map(|d| d.id).collect::<Vec<_>>(), ["MC110"]);
}

#[test]
fn rotary_axes_the_short_way() {
    let mut machine = example("mill4a");
    machine.axes[3].modulo = true;
    let a = |text: &str| -> Vec<f64> {
        ends(&program_for(text, &machine, &Options::default())).iter().map(|e| e[3]).collect()
    };
    assert_eq!(a("G0 A350\nA10\nA200\nA20\nG91 A350\nG90 G1 A0 F1000\nM30\n"), [-10.0, 10.0, -160.0, 20.0, 370.0, 0.0]);
    machine.axes[3].modulo = false;
    assert_eq!(ends(&program_for("G0 A350\nM30\n", &machine, &Options::default()))[0][3], 350.0);
}

#[test]
fn position_factors_mirror_and_scale_before_the_offset() {
    let mut machine = mill3();
    machine.gcode.position_factors = vec![-1.0, 1.0, 1.0];
    machine.gcode.offsets[0][0] = 100.0;
    let program = program_for(
        "G0 X10 Y0\nG3 X20 Y10 J10 F600\nG91 G1 X5\nG90 G53 G0 X7\nG92 X0\nX3\nM30\n",
        &machine,
        &Options::default(),
    );
    assert_eq!(ends(&program).iter().map(|e| e[0]).collect::<Vec<_>>(), [90.0, 80.0, 75.0, 7.0, 4.0]);
    assert_eq!((program.moves[1].phi, program.moves[1].center), (-90.0, [90.0, 10.0]));
    let text = format!("{BUILTIN}\n[gcode.position_factors]\nX = 0.0\n");
    assert_eq!(Machine::parse(text.as_bytes()).unwrap_err()[0].id, "MC106");
}

#[test]
fn axes_that_do_not_count_for_the_path() {
    let mut machine = example("mill4a");
    machine.gcode.nfrax = vec![3];
    let program = program_for("G1 X30 A4000 F600\nG0 A0\nM30\n", &machine, &Options::default());
    assert_eq!(program.moves[0].vl, 10.0, "F holds along X alone");
    assert_eq!(ids("G1 A90 F600\nM30\n", &machine), ["GC804"]);
    let columns = gcode::sequence(&program, &machine);
    assert_eq!(columns.effradius[3], 0.0);
    let mut mcu = Mcu::new(Arc::new(machine));
    mcu.prepare_gcode();
    mcu.load(0, Arc::new(program_for("G1 X30 A40 F600\nM30\n", mcu.machine(), &Options::default())));
    mcu.startcnct(0);
    let mut trace = Trace::new(4, 1000);
    mcu.advance(1000, &mut trace);
    let fastest = trace
        .dp
        .chunks(4)
        .map(|r| r[0])
        .collect::<Vec<_>>()
        .windows(2)
        .map(|w| (w[1] - w[0]) / 0.00128)
        .fold(0.0, f64::max);
    assert!((fastest - 10.0).abs() < 1e-6, "{fastest}");
}

#[test]
fn a_g_function_of_the_machine_calls_a_subprogram() {
    let text = format!("{BUILTIN}\n[[gcode.g]]\nnumber = 120\nsubprogram = \"POCKET\"\n");
    let machine = Machine::parse(text.as_bytes()).expect("valid");
    let program = "#24=3\nG120 X5 Y2\nG0 X#24\nM30\n%L POCKET\nG0 X#24 Y#25\nM17\n";
    let found = ends(&program_for(program, &machine, &Options::default()));
    assert_eq!(found, [[5.0, 2.0, 0.0], [3.0, 2.0, 0.0]]);
    assert_eq!(ids("G121 X1\nM30\n", &machine), ["GC305"]);
    assert_eq!(ids("G120 X5\nM30\n", &machine), ["GC603"]);
    assert_eq!(ids(program, &mill3()), ["GC305"]);
    let text = format!("{BUILTIN}\n[[gcode.g]]\nnumber = 107\nsubprogram = \"A/B\"\n");
    let found: Vec<&str> = Machine::parse(text.as_bytes()).unwrap_err().iter().map(|d| d.id).collect();
    assert_eq!(found, ["MC111", "MC107"]);
}

#[test]
fn equal_within_a_difference() {
    let text = "#1=0.3\nIF [#1 EQ 0.1+0.2] GOTO 5\nG0 X1\nN5 G0 X2\nM30\n";
    assert_eq!(x(text, &mill3()), [1.0, 2.0]);
    assert_eq!(x(text, &with(DialectOptions { equal_tolerance: Some(1e-6), ..plain() })), [2.0]);
}

#[test]
fn scale_factors_in_thousandths() {
    let classic = with(DialectOptions { integer_increment: Some(0.001), ..plain() });
    let text = "G51 X0 Y0 Z0 P2000\nG0 X10.\nM30\n";
    assert_eq!(x(text, &classic), [20.0]);
    assert_eq!(x("G51 X0. Y0. Z0. P2.\nG0 X10.\nM30\n", &classic), [20.0]);
}

#[test]
fn a_spindle_in_the_machine_file() {
    let text = BUILTIN.to_owned()
        + "[[axis]]\nname = \"S\"\nletter = \"\"\nkind = \"rotary\"\nrapid = 18000.0\nacceleration = 5e4\ncounts_per_unit = 100.0\n\
           [gcode.spindle]\naxis = \"S\"\nlimit = 3000.0\n";
    // the tables of an axis come before [gcode]
    let machine = Machine::parse(text.as_bytes()).expect("valid");
    assert_eq!((machine.gcode.spindle.axis, machine.gcode.spindle.limit), (Some(3), 3000.0));
    assert_eq!(Machine::parse(machine.show().as_bytes()), Ok(machine));
    for (from, to) in
        [("axis = \"S\"", "axis = \"X\""), ("axis = \"S\"", "axis = \"Q\""), ("axis = \"S\"", "command_axis = \"X\"")]
    {
        assert!(
            Machine::parse(text.replacen(&format!("spindle]\n{from}"), &format!("spindle]\n{to}"), 1).as_bytes())
                .is_err(),
            "{to}"
        );
    }
}

// shows: gcode.writeln-stop
#[test]
fn writeln_stops_the_task() {
    let mut machine = mill3();
    machine.gcode.modereg |= ModeReg::StopAtWriteln.0;
    let program = Arc::new(program_for(
        "G0 X1\nN10 writeln \"one\"\nN20 writeln \"two\"\nG0 X5\nM30\n",
        &machine,
        &Options::default(),
    ));
    let run = |machine: Machine| {
        let mut mcu = Mcu::new(Arc::new(machine));
        mcu.prepare_gcode();
        mcu.load(0, program.clone());
        mcu.startcnct(0);
        mcu
    };
    let mut mcu = run(machine);
    let mut trace = Trace::new(3, 2000);
    for text in ["one\n", "two\n"] {
        trace.restart(mcu.samples());
        assert!(matches!(mcu.advance(2000, &mut trace).stop, Stop::Acknowledge { .. }));
        trace.restart(mcu.samples());
        assert_eq!(mcu.advance(2000, &mut trace).stop, Stop::Budget, "it waits");
        assert_eq!((mcu.task_status(0).state, mcu.take_output(0)), (TaskState::Stopped, text.to_owned()));
        assert_eq!(mcu.rddp(0), 1.0);
        mcu.contcnct(0);
    }
    trace.restart(mcu.samples());
    assert_eq!(mcu.advance(2000, &mut trace).stop, Stop::Finished);
    assert_eq!(mcu.rddp(0), 5.0);
    // without the bit nothing stops
    let mut free = run(mill3());
    trace.restart(0);
    assert_eq!(free.advance(2000, &mut trace).stop, Stop::Finished);
    assert_eq!(free.take_output(0), "one\ntwo\n");
}

// shows: gcode.zero-offset-sets
#[test]
fn five_zero_offset_sets_of_the_controller_and_six_of_programs() {
    let text = format!(
        "{}\n[gcode.offsets]\nG54 = {{ X = 1.0 }}\nG55 = {{ X = 2.0 }}\nG56 = {{ X = 3.0 }}\nG57 = {{ X = 4.0 }}\n\
         G58 = {{ X = 5.0 }}\nG59 = {{ X = 6.0 }}\n",
        BUILTIN.replacen(
            "name = \"X\"",
            "name = \"X\"\nzero_offsets = { set0 = 10.0, set1 = 20.0, set2 = 30.0, set3 = 40.0, set4 = 50.0 }",
            1
        )
    );
    let machine = Machine::parse(text.as_bytes()).expect("valid");
    assert_eq!(
        x("G0 X0\nG55 X0\nG56 X0\nG57 X0\nG58 G0 X0\nG59 G0 X0\nM30\n", &machine),
        [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    );
    // a program runs in machine coordinates: no set of the controller is active
    let mut mcu = Mcu::new(Arc::new(machine));
    mcu.prepare_gcode();
    assert_eq!(mcu.zero_offset(0), 0.0);
    for (set, offset) in [(0, 10.0), (1, 20.0), (2, 30.0), (3, 40.0), (4, 50.0), (5, 0.0), (2, 30.0), (99, 0.0)] {
        mcu.azo(set);
        assert_eq!((mcu.zero_offset(0), mcu.zero_offset(1)), (offset, 0.0), "{set}");
        assert_eq!(mcu.rdrp(0), -offset, "all axes together, nothing moves");
    }
}

#[test]
fn corners_that_stop() {
    let tvl = |angle: Option<f64>| -> Vec<f64> {
        let machine = with(DialectOptions { corner_angle: angle, ..plain() });
        let text = "G1 X10 F600\nX20 Y1\nX20 Y20\nX30 Y20\nM30\n";
        program_for(text, &machine, &Options::default()).moves.iter().map(|m| m.tvl).collect()
    };
    assert_eq!(tvl(None), [10.0, 10.0, 10.0, 0.0]);
    assert_eq!(tvl(Some(30.0)), [10.0, 0.0, 0.0, 0.0]);
    assert_eq!(tvl(Some(85.0)), [10.0, 10.0, 0.0, 0.0]);
    assert_eq!(tvl(Some(1.0)), [0.0; 4]);
}

#[test]
fn a_program_that_starts_with_feed_per_revolution() {
    let machine = with(DialectOptions { feed_per_revolution: Some(true), ..plain() });
    assert_eq!(program_for("S600\nG1 X10 F0.5\nM30\n", &machine, &Options::default()).moves[0].vl, 5.0);
}

#[test]
fn clamps_that_are_waited_for() {
    let mut machine = mill3();
    (machine.gcode.outputs.clamp_wait, machine.gcode.outputs.unclamp_wait) = (1 << 2, 1 << 3);
    let found: Vec<(u32, u16, f64)> = all("G1 X1 F100\nM10\nX2\nM11\nM30\n", &machine)
        .iter()
        .filter_map(|c| {
            if let Command::Ssf { line, command, value, .. } = c { Some((*line, *command, *value)) } else { None }
        })
        .take(4)
        .collect();
    assert_eq!(found, [(2, 1001, 16.0), (2, 1004, 4.0), (4, 1002, 16.0), (4, 1004, 8.0)]);
    // the motion before a wait stops
    assert_eq!(program_for("G1 X1 F100\nM10\nX2\nM30\n", &machine, &Options::default()).moves[0].tvl, 0.0);
}

#[test]
fn tools_that_g10_sets() {
    let text =
        "G10 L1 P1 Z40 R3\nG43 H1 G0 Z0\nG41 D1 G1 X10 F600\nX40\nG40 Y20\nG10 L1 P77 Z5\nG43 H77 Z0\nT77 M6\nM30\n";
    let found = ends(&program_for(text, &mill3(), &Options::default()));
    assert_eq!(found, [[0.0, 0.0, 40.0], [10.0, 3.0, 40.0], [40.0, 3.0, 40.0], [40.0, 20.0, 40.0], [40.0, 20.0, 5.0]]);
    assert_eq!(ids(text, &mill3()), Vec::<&str>::new());
    assert_eq!(ids("G10 L1 P1 R-1\nM30\n", &mill3()), ["GC216"]);
    assert_eq!(ids("G10 L1 P77\nM30\n", &mill3()), ["GC509"]);
}

#[test]
fn the_active_offset_is_the_one_that_p0_sets() {
    assert_eq!(
        x("G54.1 P4\nG10 L2 P0 X7\nG0 X1\nG54 X1\nG54.1 P4 X2\nG54.1 P5 X3\nM30\n", &mill3()),
        [8.0, 1.0, 9.0, 3.0]
    );
    assert_eq!(x("G55 G10 L2 P0 X7\nG0 X1\nG54 X2\nM30\n", &mill3()), [8.0, 2.0]);
}

#[test]
fn the_active_codes_as_variables() {
    let codes = "G18 G91 G90.1 G95 G20 G42 D0 G43 H0 G61 G99 G55";
    let write: Vec<String> = (1..=16).map(|n| format!("#40{n:02}")).collect();
    let text = format!("G92 S500\n{codes}\nG96 S5\nG51.1 X1\nG51 X0 P2\nG1\nwrite {}\nM30\n", write.join(", \" \", "));
    let mut machine = mill3();
    machine.gcode.spindle.limit = 1000.0;
    let found: String = all(&text, &machine)
        .iter()
        .filter_map(|c| if let Command::Text(t) = c { Some(t.clone()) } else { None })
        .collect();
    assert_eq!(found, "1 18 91 90.1 95 20 42 49 61 99 55 96 51 51.1 69 0");
    let found: String = all("G68 X0 Y0 R5\nwrite #4015, \" \", #4016\nM30\n", &machine)
        .iter()
        .filter_map(|c| if let Command::Text(t) = c { Some(t.clone()) } else { None })
        .collect();
    assert_eq!(found, "68 0");
}

#[test]
fn the_clearance_of_peck_drilling() {
    let z = |text: &str, machine: &Machine| -> Vec<f64> {
        ends(&program_for(text, machine, &Options::default())).iter().map(|e| e[2]).collect()
    };
    let own = with(DialectOptions { peck_clearance: Some(0.5), ..plain() });
    let text = "G73 Z-5 R1 Q3 F600\nM30\n";
    assert_eq!(z(text, &mill3()), [1.0, -2.0, -1.0, -5.0, 1.0]);
    assert_eq!(z(text, &own), [1.0, -2.0, -1.5, -5.0, 1.0]);
    let inch = z("G20 G73 Z-5 R1 Q3 F60\nM30\n", &mill3());
    assert!((inch[2] - (-2.0 + 0.04) * 25.4).abs() < 1e-9, "{inch:?}");
}
