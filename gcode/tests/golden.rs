//! Golden translations, compared as numbers: each reviewed against docs/dialect.md.

mod common;

use common::{Command, commands, example, motions, program, program_for};
use gcode::{Options, listing_json, sequence};
use motion_kernel::autocode::Instr;
use motion_kernel::machine::Profile;

const TOLERANCE: f64 = 1e-9;

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= TOLERANCE
}
fn all_close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| close(*a, *b))
}

/// What is expected of one motion.
enum Want {
    /// line, to, vl, tvl
    Feed(u32, [f64; 3], f64, f64),
    Rapid(u32, [f64; 3], f64),
    /// line, end, first axis, second axis, centre, phi, vl, tvl
    Arc(u32, [f64; 3], [usize; 2], [f64; 2], f64, f64, f64),
}

fn assert_motions(text: &str, want: &[Want]) {
    let program = program(text);
    let found = motions(&program);
    assert_eq!(found.len(), want.len(), "{found:#?}");
    for (found, want) in found.iter().zip(want) {
        match (found, want) {
            (Command::Line { line, to, vl, tvl, rapid: false }, Want::Feed(l, t, v, e)) => {
                assert!(*line == *l && all_close(to, t) && close(*vl, *v) && close(*tvl, *e), "{found:?}");
            }
            (Command::Line { line, to, vl, tvl, rapid: true }, Want::Rapid(l, t, v)) => {
                assert!(*line == *l && all_close(to, t) && close(*vl, *v) && *tvl == 0.0, "{found:?}");
            }
            (Command::Arc { line, axes, to, center, phi, vl, tvl }, Want::Arc(l, t, plane, c, p, v, e)) => {
                let in_order: Vec<f64> = axes.iter().map(|a| t[*a]).collect();
                assert!(*line == *l && axes[..2] == plane[..] && all_close(to, &in_order), "{found:?}");
                assert!(all_close(center, c) && close(*phi, *p) && close(*vl, *v) && close(*tvl, *e), "{found:?}");
            }
            _ => panic!("{found:?}"),
        }
    }
}

use Want::{Arc, Feed, Rapid};

/// The examples of section 17.
#[test]
fn lines_arcs_and_a_helix() {
    let text = "G00 X0 Y0 Z5\nG01 X10 Y0 F600\nG03 X20 Y10 I0 J10\nG02 X20 Y10 I5 J0\nG03 X20 Y10 Z-3 I-5 J0 P4\nM30\n";
    assert_motions(
        text,
        &[
            Rapid(1, [0.0, 0.0, 5.0], 200.0),
            Feed(2, [10.0, 0.0, 5.0], 10.0, 10.0),
            Arc(3, [20.0, 10.0, 5.0], [0, 1], [10.0, 10.0], 90.0, 10.0, 10.0),
            Arc(4, [20.0, 10.0, 5.0], [0, 1], [25.0, 10.0], -360.0, 10.0, 10.0),
            Arc(5, [20.0, 10.0, -3.0], [0, 1], [15.0, 10.0], 1440.0, 10.0, 0.0),
        ],
    );
}

#[test]
fn planes_and_radius_form() {
    let text = "F600\nG18 G02 X30 Z0 R15\nG17 G3 X30 Y40 R-20\nG19 G2 Y50 Z10 J10 K0\nM2\n";
    assert_motions(
        text,
        &[
            Arc(2, [30.0, 0.0, 0.0], [2, 0], [0.0, 15.0], -180.0, 10.0, 10.0),
            Arc(3, [30.0, 40.0, 0.0], [0, 1], [30.0, 20.0], 180.0, 10.0, 10.0),
            Arc(4, [30.0, 50.0, 10.0], [1, 2], [50.0, 0.0], -90.0, 10.0, 0.0),
        ],
    );
}

#[test]
fn inch_feed_and_offsets() {
    let text =
        "G20 G1 X1 F10\nG21 X50\nG10 L2 P2 X100 Y-50\nG55 X0 F20 Y0\nG52 X5\nX0\nG53 G0 X1\nG92 X7\nG0 X8\nM30\n";
    assert_motions(
        text,
        &[
            Feed(1, [25.4, 0.0, 0.0], 254.0 / 60.0, 254.0 / 60.0),
            // F was programmed in inch: it stays 254 mm/min
            Feed(2, [50.0, 0.0, 0.0], 254.0 / 60.0, 20.0 / 60.0),
            Feed(4, [100.0, -50.0, 0.0], 20.0 / 60.0, 20.0 / 60.0),
            Feed(6, [105.0, -50.0, 0.0], 20.0 / 60.0, 0.0),
            Rapid(7, [1.0, -50.0, 0.0], 200.0),
            Rapid(9, [2.0, -50.0, 0.0], 200.0),
        ],
    );
}

#[test]
fn reference_run_and_length_correction() {
    let mut machine = common::mill3();
    machine.gcode.tools[2].length = 40.0;
    let text = "T3 M6\nG43 G0 Z100 H3\nG91 G28 Z10\nG90 G49 Z0\nM30\n";
    let program = program_for(text, &machine, &Options::default());
    let z: Vec<f64> = common::ends(&program).iter().map(|e| e[2]).collect();
    assert_eq!(z, [140.0, 150.0, 0.0]);
}

#[test]
fn exact_stop_and_rapid_end_at_standstill() {
    let text = "G1 X10 F600\nG61 X20\nG64 X30\nG9 X40\nX50\nG4 X0\nX60\nM30\n";
    let tvl: Vec<f64> = program(text).moves.iter().map(|m| m.tvl).collect();
    assert_eq!(tvl, [10.0, 0.0, 10.0, 0.0, 0.0, 0.0]);
}

#[test]
fn without_look_ahead_corners_stop() {
    let mut machine = common::mill3();
    machine.gcode.modereg &= !1;
    let text = "G1 X10 F600\nX20\nG3 X30 Y10 J10\nG1 Y20\nX40\nM30\n";
    let tvl: Vec<f64> = program_for(text, &machine, &Options::default()).moves.iter().map(|m| m.tvl).collect();
    assert_eq!(tvl, [10.0, 10.0, 10.0, 0.0, 0.0]);
}

fn ssf(line: u32, axes: &[usize], command: u16, value: f64) -> Command {
    Command::Ssf { line, axes: axes.to_vec(), command, value }
}
fn event(line: u32, kind: &str, text: &str) -> Command {
    Command::Event { line, kind: kind.to_owned(), text: text.to_owned() }
}
/// Everything but motion and the instructions that start the spoolers.
fn functions(text: &str) -> Vec<Command> {
    let is_function = |c: &Command| matches!(c, Command::Ssf { .. } | Command::Event { .. });
    commands(&program(text)).into_iter().filter(is_function).collect()
}

#[test]
fn switching_functions() {
    let text = "M3 S1000\nM8\nM7\nM4\nM5\nM9\nM10\nM11\nM62 P7\nM63 P7\nH5\nT4\n(MSG, mind the clamp)\nM30\n";
    let x = &[0][..];
    assert_eq!(
        functions(text),
        [
            ssf(1, x, 20200, 1000.0),
            ssf(1, x, 1002, 2.0),
            ssf(1, x, 1001, 1.0),
            ssf(2, x, 1001, 4.0),
            ssf(3, x, 1001, 8.0),
            ssf(4, x, 1002, 1.0),
            ssf(4, x, 1001, 2.0),
            ssf(5, x, 1002, 3.0),
            ssf(6, x, 1002, 12.0),
            ssf(7, x, 1001, 16.0),
            ssf(8, x, 1002, 16.0),
            ssf(9, x, 1001, 128.0),
            ssf(10, x, 1002, 128.0),
            ssf(11, x, 200, 5.0),
            event(12, "T", "4"),
            event(13, "MSG", "mind the clamp"),
            ssf(14, x, 1002, 15.0),
            event(14, "M30", ""),
        ]
    );
}

// shows: gcode.block-structure
#[test]
fn waits_go_to_all_axes_and_stop_the_path() {
    let text = "G1 X10 F600\nG4 P500\nX20\nM0\nX30\nM6 T2\nX40\nM66 P3 L3\nM30\n";
    let all = &[0, 1, 2][..];
    let found = functions(text);
    assert_eq!(found[0], ssf(2, all, 1003, 7813.0));
    assert_eq!(found[1..3], [event(4, "M00", ""), ssf(4, all, 1000, 0.0)]);
    assert_eq!(found[3..6], [event(6, "T", "2"), event(6, "M06", "2"), ssf(6, all, 1025, 1.0)]);
    assert_eq!(found[6], ssf(8, all, 1004, 8.0));
    assert!(program(text).moves.iter().all(|m| m.tvl == 0.0));
}

#[test]
fn optional_stop_and_block_delete_are_switches() {
    let text = "M1\n/G0 X1\n/2 G0 X2\nM30\n";
    assert_eq!(functions(text).len(), 2);
    let options = Options { optional_stop: true, block_delete: 1 << 2, ..Options::default() };
    let program = program_for(text, &common::mill3(), &options);
    assert_eq!(common::ends(&program), [[1.0, 0.0, 0.0]]);
    assert!(commands(&program).contains(&event(1, "M01", "")));
}

#[test]
fn an_mcode_before_and_one_after_the_motion() {
    let text = "G1 X10 F600 M8\nX20 M9\nM30\n";
    let kinds: Vec<&str> = commands(&program(text))
        .iter()
        .map(|c| match c {
            Command::Line { .. } => "line",
            Command::Ssf { command: 1001, .. } => "on",
            Command::Ssf { command: 1002, .. } => "off",
            _ => "",
        })
        .filter(|k| !k.is_empty())
        .collect();
    assert_eq!(kinds, ["on", "line", "line", "off", "off"]);
}

#[test]
fn cycles_drill() {
    let text = "G0 Z20\nG99 G83 X10 Y5 Z-5 R2 Q3 F120\nX20\nG98 G81 X30 Z-4 R2\nG80\nM30\n";
    let z: Vec<(f64, f64, bool)> =
        program(text).moves.iter().zip(common::ends(&program(text))).map(|(m, e)| (e[0], e[2], m.rapid)).collect();
    assert_eq!(
        z[..8],
        [
            (0.0, 20.0, true),
            (10.0, 20.0, true),
            (10.0, 2.0, true),
            (10.0, -1.0, false),
            (10.0, 2.0, true),
            (10.0, 0.0, true),
            (10.0, -4.0, false),
            (10.0, 2.0, true),
        ]
    );
    assert_eq!(z[z.len() - 1], (30.0, 20.0, true));
}

#[test]
fn scaling_mirror_and_rotation() {
    let half =
        program("G51 X0 Y0 P2\nG1 X10 Y5 F600\nG50\nG51.1 X0\nG1 X10 Y0\nG50.1\nG68 X0 Y0 R90\nG1 X10 Y0\nM30\n");
    let ends = common::ends(&half);
    let want = [[20.0, 10.0, 0.0], [-10.0, 0.0, 0.0], [0.0, 10.0, 0.0]];
    assert!(ends.iter().zip(&want).all(|(e, w)| all_close(e, w)), "{ends:?}");
    assert_motions(
        "G51.1 X0\nG2 X10 Y10 I10 F600\nM30\n",
        &[Arc(2, [-10.0, 10.0, 0.0], [0, 1], [-10.0, 0.0], 90.0, 10.0, 0.0)],
    );
}

#[test]
fn rotary_axes_count_with_their_radius() {
    let machine = example("mill4a");
    let options = Options::default();
    let alone = program_for("G1 A90 F360\nM30\n", &machine, &options);
    assert!(close(alone.moves[0].vl, 6.0));
    let mixed = program_for("G1 X10 A90 F600\nM30\n", &machine, &options);
    // T = 10 mm / 10 mm/s, and the controller counts sqrt(10² + 90²) mm
    assert!(close(mixed.moves[0].vl, 8200f64.sqrt()));
    let inverse = program_for("G93 G1 X10 A90 F60\nM30\n", &machine, &options);
    assert!(close(inverse.moves[0].vl, 8200f64.sqrt()));
}

#[test]
fn feed_per_revolution_and_lathe() {
    let turn = program("S1200 M3\nG95 G1 X10 F0.2\nM30\n");
    assert!(close(turn.moves[0].vl, 4.0));
    let options = Options { profile: Some(Profile::Lathe), ..Options::default() };
    let lathe = program_for("G0 X100 Z5\nG1 U10 W-5 F100\nM30\n", &common::mill3(), &options);
    assert_eq!(common::ends(&lathe), [[50.0, 0.0, 5.0], [55.0, 0.0, 0.0]]);
}

// shows: gcode.g02-g03.center-default
#[test]
fn arc_centres_absolute_or_relative() {
    let relative = program("G0 X10 Y10\nG2 X20 Y10 I5 F600\nM30\n");
    let absolute = program("G90.1\nG0 X10 Y10\nG2 X20 Y10 I15 J10 F600\nM30\n");
    assert_eq!(relative.moves[1], absolute.moves[1]);
}

#[test]
fn subprograms_in_four_notations() {
    let body = "G91 G1 X10 F600\n";
    let expanded = format!("{body}{body}{body}G90\nM30\n");
    let texts = [
        format!("L100 O3\nG90\nM30\n%L 100\n{body}M17\n"),
        format!("M98 P100 L3\nG90\nM30\nO100\n{body}M99\n"),
        format!("M98 P30100\nG90\nM30\n:100\n{body}M99\n"),
        format!("L BODY O3\nG90\nM30\n%L BODY\n{body}M29\n"),
        format!("#1=0\nWHILE [#1 LT 3] DO1\n{body}#1=[#1+1]\nEND1\nM30\n"),
        format!("#1=3\nN10 {body}#1=#1-1\nIF [#1 GT 0] GOTO 10\nM30\n"),
    ];
    for text in &texts {
        assert_eq!(common::ends(&program(text)), common::ends(&program(&expanded)), "{text}");
    }
    let options = Options { profile: Some(Profile::Linuxcnc), ..Options::default() };
    let o_words = [
        format!("o100 sub\n{body}o100 endsub\no1 repeat [3]\no100 call\no1 endrepeat\nM30\n"),
        format!("#1=0\no2 while [#1 LT 3]\n{body}#1=[#1+1]\no2 endwhile\nM30\n"),
        format!("#1=0\no2 do\n{body}#1=[#1+1]\no2 while [#1 LT 3]\nM30\n"),
        format!("#1=2\no3 if [#1 EQ 1]\nX5\no3 elseif [#1 EQ 2]\n{body}{body}{body}o3 else\nX7\no3 endif\nM30\n"),
    ];
    for text in &o_words {
        let found = common::ends(&program_for(text, &common::mill3(), &options));
        assert_eq!(found, common::ends(&program(&expanded)), "{text}");
    }
}

#[test]
fn m99_p_returns_to_a_block_of_the_caller() {
    let expanded = common::ends(&program("G91\nX1\nX1\nX4\nM30\n"));
    for text in [
        "G91\nM98 P7 L2\nX2\nN20 X4\nM30\nO7\nX1\nM99 P20\n", // behind the last repetition
        "G91\nX1\nL7\nX2\nN20 X4\nM30\n%L 7\nX1\nM99 P20\nN20 X8\n", // not its own N20
        "G91\nX1\nL7\nX2\nM30\n%L 8\nX1\nM99 P20\n%L 7\nL8\nX2\nN20 X4\nM2\n", // caller in between
    ] {
        assert_eq!(common::ends(&program(text)), expanded, "{text}");
    }
}

#[test]
fn a_common_variable_needs_no_blank_behind_its_address() {
    let found = common::ends(&program("CI5=3 CD7=4\nG0XCI5YCD7\nG1X=CI5Y5FCI5\nM30\n"));
    assert_eq!(found, common::ends(&program("X3 Y4\nG1 Y5 F3\nM30\n")));
}

#[test]
fn an_assignment_needs_no_blank_behind_a_number_of_one_digit() {
    let found = common::ends(&program("N1#1=5\nN2#[2]=-#1\nG1F9X-#2Y+[#1]\nM30\n"));
    assert_eq!(found, common::ends(&program("G1 X5 Y5 F9\nM30\n")));
}

#[test]
fn factors_and_angles_are_no_arc_words() {
    for word in ["G51 I2 J2", "G51 P2", "G68 R45"] {
        let text = format!("G1 X10 F600\nG2 X20 I5\n{word}\nM30\n");
        assert_eq!(motions(&program(&text)).len(), 2, "{text}");
    }
    let text = "G1 X10 F600\nG2 X20 I5\nM19 R90\nM30\n";
    assert_eq!(motions(&program(text)).len(), 2);
    let angle = |c: &Command| matches!(c, Command::Event { kind, text, .. } if kind == "M19" && text == "90");
    assert!(commands(&program(text)).iter().any(angle));
}

// shows: gcode.o-parameter
#[test]
fn the_o_parameter_repeats_a_call() {
    for (count, motions) in [("", 1), (" O1", 1), (" O4", 4), (" O0", 0)] {
        let text = format!("L5{count}\nM30\n%L5\nG91 G1 X1 F600\nM17\n");
        assert_eq!(program(&text).moves.len(), motions, "{text}");
    }
}

// shows: gcode.write, gcode.writeln, gcode.string-quotation-marks, gcode.write.expressions, gcode.block-numbers, gcode.common-variables
#[test]
fn write_puts_text_and_values_out() {
    let text =
        "CI0 = 5\n#1=2\nN0100 write \"say \"\"hi\"\"\", CI0, #1*1.5, 1 LT 2\nN0110 writeln \u{201C}end\u{201D}\nM30\n";
    let found = commands(&program(text));
    assert!(found.contains(&ssf(1, &[0], 0, 5.0)));
    let rest: Vec<&Command> = found.iter().filter(|c| matches!(c, Command::Text(_) | Command::Other(_))).collect();
    let texts = ["say \"hi\"", "3", "1", "end"].map(|t| Command::Text(t.to_owned()));
    let want = [
        &texts[0],
        &Command::Other(Instr::LoadCi(0)),
        &Command::Other(Instr::WriteValue),
        &texts[1],
        &texts[2],
        &texts[3],
        &Command::Other(Instr::Writeln),
        &Command::Other(Instr::Halt),
    ];
    assert_eq!(rest, want);
}

#[test]
fn work_offsets_have_six_sets() {
    let mut machine = common::mill3();
    for (set, offsets) in machine.gcode.offsets.iter_mut().enumerate() {
        *offsets = vec![10.0 * set as f64, 0.0, 0.0];
    }
    let text = "G54 G0 X1\nG55 X1\nG56 X1\nG57 X1\nG58 G0 X1\nG59 G0 X1\nG53\nX1\nM30\n";
    let x: Vec<f64> = common::ends(&program_for(text, &machine, &Options::default())).iter().map(|e| e[0]).collect();
    assert_eq!(x, [1.0, 11.0, 21.0, 31.0, 41.0, 51.0, 1.0]);
}

#[test]
fn short_blocks_are_merged_with_their_points() {
    let steps: String =
        (1..=40).map(|i| format!("X{:.3} Y{:.4}\n", 0.05 * f64::from(i), 1e-4 * f64::from(i % 2))).collect();
    let compiled = common::run(&format!("G1 F3000\n{steps}M30\n"));
    let program = compiled.program.expect("no error");
    let points = common::points(&program);
    assert_eq!(points.len(), 40);
    assert!(program.moves.len() < 20);
    assert!(compiled.facts.merged.max_mm <= 0.001 && compiled.facts.merged.blocks == 40 - program.moves.len() as u64);
    // 2 samples at 50 mm/s are 0.128 mm
    let ends = common::ends(&program);
    assert!(ends[..ends.len() - 1].windows(2).all(|w| w[1][0] - w[0][0] > 0.1));
    let columns = sequence(&program, &common::mill3());
    assert_eq!(columns.via_count.iter().sum::<u32>() as usize, columns.via_line.len());
}

#[test]
fn the_listing_is_json_lines() {
    let program = program("G1 X10 F600\nG2 X20 I5\nM8\nM30\n");
    let lines: Vec<String> = listing_json(&program, &common::mill3()).collect();
    assert_eq!(
        lines[0],
        r#"{"cmd":"smla","line":1,"target":{"X":10.0,"Y":0.0,"Z":0.0},"vl":10.0,"ac":1000.0,"tvl":10.0}"#
    );
    assert_eq!(
        lines[1],
        r#"{"cmd":"smha","line":2,"plane":["X","Y"],"center":{"X":15.0,"Y":0.0},"phi":-180.0,"target":{"X":20.0,"Y":0.0,"Z":0.0},"vl":10.0,"ac":1000.0,"tvl":0.0}"#
    );
    assert_eq!(lines[2], r#"{"cmd":"ssf","line":3,"axis":"X","command":1001,"value":4.0}"#);
}

#[test]
fn facts_for_the_operator() {
    let compiled = common::run("T2 M6\nG0 X10 Z5\nG1 X-20 F300\nG2 I5 F600\nG20\nM30\n");
    let facts = &compiled.facts;
    assert_eq!((facts.low[0], facts.high[0], facts.high[2], facts.tools.as_slice()), (-20.0, 10.0, 5.0, &[2][..]));
    assert_eq!((facts.low[1], facts.high[1]), (-5.0, 5.0));
    assert_eq!(gcode::Facts::at(&facts.feeds, 3), Some(&300.0));
    assert_eq!(facts.motion_blocks, 3);
    assert_eq!(facts.modal_at(2), "G0 G17 G90 G21 G94 G40 G49 G64 G54");
    assert_eq!(facts.modal_at(4), "G2 G17 G90 G21 G94 G40 G49 G64 G54");
}

#[test]
fn alarms_of_macros_stop_with_their_text() {
    let text = "#1=1\nIF [#1 EQ 2] THEN #3000=7 (NOT THIS)\nIF [#1 EQ 1] THEN #3000=15 (TOOL LIFE EXPIRED)\nM30\n";
    let found = functions(text);
    assert_eq!(found[..2], [event(3, "ALARM", "15 TOOL LIFE EXPIRED"), ssf(3, &[0, 1, 2], 1000, 0.0)]);
}

#[test]
fn a_deleted_block_is_only_read() {
    let options = Options { block_delete: 1 << 1, ..Options::default() };
    let program = program_for("/ #1=[1/0]\n/G0 X#7\nG0 X5\nM30\n", &common::mill3(), &options);
    assert_eq!(common::ends(&program), [[5.0, 0.0, 0.0]]);
    let compiled = gcode::compile(b"/G0 X(\nM30\n", "t.nc", &common::mill3(), &options);
    assert!(compiled.has_errors());
}

#[test]
fn a_macro_call_has_variables_of_its_own() {
    let text = "#1=7\nG65 P10 A2 X5 L2\nG0 X#1\nM30\nO10\nG91 G1 X#24 Y#1 F600\n#1=0\nG90\nM99\n";
    let ends = common::ends(&program(text));
    assert_eq!(ends, [[5.0, 2.0, 0.0], [10.0, 2.0, 0.0], [7.0, 2.0, 0.0]]);
}

#[test]
fn one_mistake_is_one_error() {
    // the arc starts where the bad block should have ended: nothing is said about it
    let compiled = common::run("G1 X0 F100\nG1 X100 V5\nG2 X110 Y10 R11\nG2 X120 Y0 R1\nM30\n");
    let found: Vec<(&str, u32)> = compiled.diagnostics.iter().map(|d| (d.id, d.line)).collect();
    assert_eq!(found, [("GC801", 2), ("GC410", 4)]);
}
