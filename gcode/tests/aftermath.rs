//! One mistake is one error, and no error hides another (docs/dialect.md, section 0).

mod common;

use common::run;

/// Line, column and id of every error.
fn errors(text: &str) -> Vec<(u32, u32, &'static str)> {
    let found = run(text).diagnostics;
    found.iter().filter(|d| !d.is_warning()).map(|d| (d.line, d.column, d.id)).collect()
}

#[test]
fn an_error_in_an_arc_hides_none_behind_it() {
    let text = "G0 X0 Y0 Z0\nG2 X10 Y0 I4 J0 F600\nG2 X20 Y0 I5 J0 K3\nG2 X30 Y0 I5 R5\nG3 X40 Y0\n\
                G3 X50 Y0 I5 J0 P0\nG3 X60 Y0 I4 J1\nG1 X70 Y0 Q5\nM15\nG2 X80 Y0 I4\nM30\n";
    let expected = [
        (2, 1, "GC401"),
        (3, 17, "GC404"),
        (4, 14, "GC405"),
        (5, 1, "GC406"),
        (6, 17, "GC407"),
        (7, 1, "GC401"),
        (8, 11, "GC326"),
        (9, 1, "GC510"),
        (10, 1, "GC401"),
    ];
    assert_eq!(errors(text), expected);
    // what else is wrong in the block of the arc
    assert_eq!(errors("G2 X9 Y0 I4 Q7\nM30\n"), [(1, 1, "GC401"), (1, 1, "GC501"), (1, 13, "GC326")]);
    assert_eq!(errors("G2 X9 Y0 I4 F600 M98 P7\nM30\n"), [(1, 1, "GC401"), (1, 18, "GC603")]);
    assert_eq!(errors("F600\nG3 X9 Y0 I4 M30\nG1 Q5\n"), [(2, 1, "GC401")]);
}

#[test]
fn an_end_in_doubt_raises_no_second_error() {
    // X9 should be X8: the arc behind it starts elsewhere
    assert_eq!(errors("F600\nG2 X9 Y0 I4\nX16 I4\nG3 X24 I4\nG3 X30 I4\nM30\n"), [(2, 1, "GC401"), (5, 1, "GC401")]);
    assert_eq!(errors("F600\nG1 X1.2.3\nG2 X16 Y0 I4 J0\nM30\n"), [(2, 5, "GC204")]);
    // other axes are where they were: the extreme of the arc is outside
    assert_eq!(errors("F600 G0 X490 Y0\nG1 Z5 Q3\nG2 X490 Y0 I200 J0\nM30\n").last(), Some(&(3, 1, "GC413")));
}

#[test]
fn modal_words_of_a_bad_block_count() {
    assert_eq!(
        errors("G1 X1 F100 Q3\nX2\nG91 G2 X10 Y10 I10 Q7\nX10 Y10 I10\nM30\n"),
        [(1, 12, "GC326"), (3, 20, "GC326")]
    );
    assert_eq!(errors("G18 G1 X1 F100 Q3\nG2 X3 Z0 I1 K0\nM30\n"), [(1, 16, "GC326")]);
    assert_eq!(errors("G95 S500 F0.1 G43 H99 G1 X1\nX2\nM30\n"), [(1, 19, "GC509")]);
    assert_eq!(errors("G1 X1,5 F100\nX2\nM30\n"), [(1, 6, "GC205")]);
    assert_eq!(errors("G1 X1 F0\nX2\nM30\n"), [(1, 7, "GC504")]);
    assert_eq!(errors("G1 X9000 F100\nX2\nM30\n"), [(1, 4, "GC413")]);
    assert_eq!(errors("G1 X1 F100\nM30 Q5\nFOO\n"), [(2, 5, "GC326"), (3, 1, "GC201")]);
}

#[test]
fn a_refused_function_takes_its_blocks_along() {
    assert_eq!(errors("G1 F100\nG87 X5 Z-5 R2\nX10 R3\nX20 K2\nG80\nG1 X5\nM30\n"), [(2, 1, "GC320")]);
    assert_eq!(errors("G81 X5 Z-5 F100\nX10\nX20\nG80\nX5\nM30\n"), [(1, 1, "GC325"), (5, 1, "GC319")]);
}

#[test]
fn variables_and_loops_in_doubt() {
    assert_eq!(errors("#1=SINH[3]\nG0 X#1\nG0 Y#1\nM30\n"), [(1, 4, "GC715")]);
    assert_eq!(errors("G0 X#1\n#1=3\nM30\n"), [(1, 5, "GC702")]);
    assert_eq!(errors("#1=0\nWHILE [1/#1] DO1\nG0 X1\nEND1\nM30\n"), [(2, 9, "GC710")]);
    assert_eq!(errors("END1\nM30\n"), [(1, 1, "GC606")]);
}

#[test]
fn inch_in_a_bad_block_is_told_where_it_stands() {
    // nothing was executed before it; then a block that is refused when executed, a longer one behind it
    for (text, place) in
        [("G20 G40 o1 if\nG1 X200 F9\nM30\n", (1, 1)), ("G21\nG17 G20 M15\nG1 X200 F9\nX1 Y1\nM30\n", (2, 5))]
    {
        let found = run(text).diagnostics;
        let hint = found.iter().find(|d| d.id == "GW934").map(|d| (d.line, d.column));
        assert_eq!(hint, Some(place), "{found:?}");
    }
}
