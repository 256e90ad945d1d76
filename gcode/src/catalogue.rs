//! The one table of all error and warning ids (docs/dialect.md, section 19): id, message, remedy.
//! Everything else that knows an id takes it from here. `{..}` are filled in order of appearance.

macro_rules! catalogue {
    ($($id:ident $text:literal $hint:literal;)*) => {
        /// Ids `GCnnn` are errors, `GWnnn` warnings.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Id { $(#[doc = $text] $id,)* }

        /// Every id with its name, message template and hint.
        pub const CATALOGUE: &[(Id, &str, &str, &str)] = &[$((Id::$id, stringify!($id), $text, $hint),)*];
    };
}

impl Id {
    pub fn name(self) -> &'static str {
        CATALOGUE[self as usize].1
    }
    pub fn template(self) -> &'static str {
        CATALOGUE[self as usize].2
    }
    pub fn hint(self) -> &'static str {
        CATALOGUE[self as usize].3
    }
    pub fn is_warning(self) -> bool {
        self >= Id::GW901
    }
}

catalogue! {
    GC101 "not a text file ({n} control bytes in the first 4 KiB)" "choose the part program, not an executable or a picture";
    GC102 "UTF-16 or UTF-32 text is not supported, save as UTF-8 or ASCII" "save the file as UTF-8 without changing its content";
    GC103 "illegal control character 0x{h}" "delete the character";
    GC104 "illegal character '{c}' (U+{h})" "outside comments this character has no meaning; delete it or type it again";
    GC105 "line longer than 1024 characters ({n})" "break the line into several blocks";
    GC106 "file larger than {n} MiB" "split the program";
    GC107 "'{c}' is not part of this dialect ({dialect hint})" "post-process the program for DIN 66025";
    GC108 "comment is not closed" "add ')' at the end of the comment";
    GC109 "')' without '('" "add '(' or delete ')'";
    GC110 "string is not closed" "add '\"' at the end of the text";
    GC111 "more than {n} errors, stopped" "mend the errors above first";
    GC112 "file cannot be read: {system text}" "check name and access rights";
    GC113 "file is empty or holds no block" "choose a part program";
    GC114 "file changed during translation" "load it again";

    GC201 "unknown word '{text}'" "an address is one letter followed by a value (zero is 0, not O)";
    GC202 "address {a} has no value" "write a number after the address";
    GC203 "number without address" "write an address letter before the number";
    GC204 "malformed number '{text}'" "write one sign at most and one decimal point at most";
    GC205 "decimal comma, use a point" "replace ',' by '.'";
    GC206 "number has more than 40 characters" "shorten the number";
    GC207 "address {a} does not take a sign" "delete the sign";
    GC208 "comment between address and value" "move the comment behind the value";
    GC209 "N must be the first word of the block" "move N to the start of the block";
    GC210 "{a} needs an integer, {v} given" "write a whole number";
    GC211 "'/' is only allowed at block start" "put the rest into a block of its own";
    GC212 "O is only allowed first in the block or together with an L call" "move O to the start, or call with L";
    GC213 "',{a}' (chamfer, rounding) is not supported" "write the chamfer or rounding as G01, G02 or G03";
    GC214 "E is not enabled" "delete the word";
    GC215 "R-parameters (R{n}) are not supported, use #{n}" "use # variables";
    GC216 "value {v} of {a} outside {lo}..{hi}" "correct the value";
    GC217 "G code {v} has more than one decimal place" "correct the G code";
    GC218 "block delete level must be 1..9" "write '/' or '/1' to '/9'";
    GC219 "name '{text}' contains digits" "names hold letters and '_' only";
    GC220 "unexpected '{text}' after {context}" "delete it";
    GC221 "more than 8 M functions in the block" "spread them over two blocks";

    GC301 "address {a} appears twice (first at column {c})" "delete one of them";
    GC302 "{g1} and {g2} belong to one group ({group})" "keep one of them";
    GC303 "{g1} and {g2} both need axis words" "write two blocks";
    GC304 "G04 must not be combined with motion or axis words other than its time" "put the dwell into a block of its own";
    GC305 "G{v} is not supported" "delete it or replace it by supported functions (docs/dialect.md, section 6)";
    GC306 "spline interpolation (G06) is not supported" "let the CAM system put out lines and arcs";
    GC307 "probing (G{v}) is not supported" "remove the probing cycle";
    GC308 "spindle-synchronous function G{v} is not supported" "it needs a spindle axis in the machine file";
    GC309 "G10 L{v} is not supported" "use L2, L20, L1, L10 or L11";
    GC310 "{code} needs {word}" "add the missing word";
    GC311 "reference position P{v} is not defined" "define it in the machine file";
    GC312 "radius correction G{v} is not available (not built, or switched off)" "let the CAM system put out the centre path";
    GC313 "G50 with axis words: use G92" "replace G50 by G92";
    GC314 "G53 with axis words needs G00 or G01" "approach with G00 or G01";
    GC315 "G53 with axis words needs G90" "add G90";
    GC316 "programmable shift G{v} with axis words is not supported, use G52" "replace it by G52";
    GC317 "lathe cycle G{v} is not supported" "let the CAM system put out single moves";
    GC318 "G74 axis words must be 0" "write X0 and so on";
    GC319 "axis words without active motion function" "add G00, G01, G02 or G03";
    GC320 "cycle G{v} is not supported" "write the single moves";
    GC321 "{code} is not allowed in cylinder mode" "switch the cylinder mode off first (radius 0)";
    GC322 "cylinder mode is already active for {a}" "switch it off first (radius 0)";
    GC323 "cycles are not allowed with G93" "programme G94 before the cycle";
    GC324 "rotary axis word in a cycle" "turn the axis in a block before";
    GC325 "cycle without {R or bottom} on first call" "add the missing word";
    GC326 "word {a} has no function in this block" "delete it, or add the function it belongs to";
    GC327 "{code} needs axis words" "add axis words";
    GC328 "plane change not allowed while {mode}" "end the mode first";
    GC329 "unit change in a block with a stored value of the other unit: {a}" "change the unit in a block of its own";

    GC401 "arc end point: radius {r0} at start, {r1} at end, difference {d} > {limit} mm{hint}" "check end point, I J K and the arc centre mode";
    GC402 "arc radius is zero" "check I J K";
    GC403 "scale or position factor 0" "write a factor other than 0";
    GC404 "centre word {a} does not belong to plane G{p}" "check the plane";
    GC405 "R together with {I J K}" "keep either the radius or the centre";
    GC406 "arc without centre and radius" "add I J K or R";
    GC407 "turns P must be an integer >= 1" "correct P";
    GC408 "full circle or no distance with R" "write the full circle with I J K";
    GC409 "arc radius {r} too large" "programme a line";
    GC410 "distance of the points {c} is larger than the diameter {2R}" "check end point and R";
    GC411 "radius 0" "correct R";
    GC412 "arc with unequal scaling of the plane axes" "scale both plane axes alike";
    GC413 "axis {a}: machine position {p} outside {lo}..{hi}{(arc extreme)}" "check target, zero offset and units";
    GC414 "cylinder radius negative" "write a radius >= 0";
    GC415 "cycle: R plane is not above the bottom" "check R and the depth";
    GC416 "peck depth Q missing or not > 0" "add Q > 0";
    GC417 "arc plane contains an axis that is not configured: {a}" "choose another plane or machine";
    GC418 "arc with a rotary axis outside cylinder mode" "turn the rotary axis in a G01 block";

    GC419 "{code} is not allowed while radius correction is active" "programme G40 and a straight move before";
    GC420 "inner arc of radius {r} is smaller than the tool radius {t}" "use a smaller tool";
    GC421 "contour is too narrow for the tool (bottleneck)" "use a smaller tool, or check the side G41/G42";
    GC422 "contour reverses on itself under radius correction" "programme G40 before turning back";

    GC501 "no feed programmed" "add F";
    GC502 "G93 needs F in every feed block" "add F to the block";
    GC503 "G96 without speed limit" "add G92 S before";
    GC504 "feed must be > 0" "correct F";
    GC505 "feed per revolution without spindle speed" "programme S before";
    GC506 "dwell time negative" "correct the time";
    GC507 "dwell without time" "add P or X";
    GC508 "more than one dwell time" "keep one of P, X, U, F";
    GC509 "tool or length offset {v} is not in the table" "add the tool to the machine file";
    GC510 "M{v} is not supported" "delete it, or assign it in the machine file; instead of M97 use M98 and an O subprogram";
    GC511 "M66: only P with L0 or L3" "use L0 or L3, without Q";
    GC512 "dwell longer than 86400 s" "correct the time; P is in the unit of dwell.pUnit";
    GC513 "M{v} has no assignment" "assign it in the machine file";
    GC514 "output or input number {v} outside 0..31" "correct P";
    GC515 "spindle speed {v} above limit {max}" "lower S";
    GC516 "M06 without T" "add T";

    GC601 "more than {n} nested calls" "look for a subprogram that calls itself";
    GC602 "more than {n} {what} (endless loop?)" "check the condition of the loop";
    GC603 "subprogram {name} not found" "define it in this file or put its file beside the program";
    GC604 "illegal subprogram name '{name}'" "use letters, digits and '_' only";
    GC605 "jump target N{v} {missing or ambiguous}" "check the block numbers";
    GC606 "{end} without {begin} or crossed loops" "check the loops";
    GC607 "{begin} without {end}" "add the end";
    GC608 "jump into a loop" "jump to a block outside the loop";
    GC609 "statement must be alone in the block" "write two blocks";
    GC610 "malformed statement, {expected} expected" "IF [condition] GOTO n, WHILE [condition] DOm, o100 sub (docs/dialect.md, section 15.3)";
    GC611 "O-word control flow is not enabled" "choose the linuxcnc profile";
    GC612 "M98 or G65 without P" "add P with the program number";
    GC613 "subprogram {name} defined twice (line {l})" "rename one of them";
    GC614 "M17/M29/M99 outside a subprogram" "end the main program with M30";
    GC615 "M02/M30 inside a subprogram" "end subprograms with M17 or M99";
    GC616 "repeat count {v} outside 0..9999" "correct the count";
    GC617 "{v}, where the part begins or ends, is not there or not executed" "check the number; N120 is a block, 120 a line";
    GC618 "the program cannot start at line {n}: {reason}" "start at a block before, at the level of the main program";

    GC701 "variable #{n} does not exist or is read-only" "use #1..#33, #100..#199, #500..#999";
    GC702 "variable {v} is empty" "assign it before";
    GC703 "variable number is not an integer 1..9999" "correct the number";
    GC704 "variable {v} is set and used in the same block" "write two blocks";
    GC705 "value {v} does not fit a 32-bit integer" "use CD instead of CI";
    GC706 "name '{n}' was never assigned" "assign it before";
    GC707 "CI99 is reserved for wait functions" "use another common variable";
    GC708 "CI/CD index {n} outside 0..999" "correct the index";
    GC709 "expression nested deeper than 32" "use an auxiliary variable";
    GC710 "division by zero" "check the divisor";
    GC711 "argument {v} outside the range of {f}" "check the argument";
    GC712 "result is not a finite number" "check the expression";
    GC713 "']' missing, or ']' without '['" "balance the brackets";
    GC714 "operand expected" "complete the expression; round brackets are comments";
    GC715 "unknown function '{f}'" "see docs/dialect.md, section 15.2";
    GC716 "{f} needs {n} arguments" "add the missing argument";
    GC717 "output text longer than 512 characters" "split the text";
    GC718 "assignment needs '=' and a value" "write #1 = value";
    GC719 "string not allowed here" "strings belong into write and writeln";

    GC801 "axis {a} is not configured" "choose the machine that has the axis (--machine)";
    GC802 "axis {a} must not be used in programs (run-time error 4000h)" "allow it in the machine file";
    GC803 "axis {a} is not referenced" "reference the axis first";
    GC804 "only no-feed axes (NFRAX) move, path speed undefined" "move another axis too or change NFRAX";
    GC805 "controller zero offset active (axis {a}: {v})" "switch the offset off (azo 5, szpa 0)";
    GC806 "axis {a} not in closed loop or not at rest" "close the loop and wait for standstill";
    GC807 "acceleration or rapid speed of the group is 0" "correct the machine file";
    GC808 "effective radius of axis {a} is 0" "correct the machine file";
    GC809 "spool memory of axis {a} exhausted, {n} bytes needed" "raise the spool memory";
    GC810 "controller reported error register {h} ({names})" "see the names in the manual, table 15";

    GW901 "leader before % skipped" "";
    GW902 "text after end of tape ignored" "";
    GW903 "foreign header ({dialect})" "the program is probably not in this dialect";
    GW904 "integer increment input active ({v} per unit)" "values without point are increments";
    GW905 "digits beyond 15 rounded" "";
    GW906 "comment parentheses not balanced" "";
    GW907 "active comment ignored" "only MSG has an effect";
    GW908 "duplicate N{v}" "block numbers should be unique";
    GW909 "no M02/M30" "end the program with M30";
    GW910 "repeat 0: the call is not executed" "";
    GW911 "motion before call: the motion runs first" "";
    GW912 "M99 as program end, treated as M30" "";
    GW913 "repeated code {g}" "";
    GW914 "G{v} has no effect here" "";
    GW915 "G09 without motion" "";
    GW916 "thread as plain feed" "";
    GW917 "radius correction with radius 0" "";
    GW918 "G64 Q ignored" "";
    GW919 "tapping without synchronisation" "";
    GW920 "third centre word {a} = 0 ignored" "";
    GW921 "nearly closed or nearly empty arc ({v} degrees)" "check whether a full circle is meant";
    GW922 "arc centre corrected by {d} mm" "";
    GW923 "radius enlarged to half the chord ({d} mm)" "";
    GW924 "ill-conditioned radius arc" "programme the centre with I J K";
    GW925 "feed {v} limited to {limit} mm/min" "";
    GW926 "block slowed to 1.6 samples" "";
    GW927 "{v} is read ahead of motion and taken as {value}" "";
    GW928 "double assignment of {v}, the last one wins" "";
    GW929 "output text cut" "";
    GW930 "{function} has no assignment, host event only" "";
    GW931 "immediate output is spooled" "";
    GW932 "dwell below one sample" "";
    GW933 "G00 without axis words" "";
    GW934 "program uses inch with metric-looking values ({v} in)" "check G20/G21";
    GW935 "tool change without tool table entry (T{v})" "add the tool to the machine file";

    GW941 "feed jumps from {a} to {b} mm/min within the contour" "";
    GW942 "arc of {v} degrees: the last digit decides between nothing and a full circle" "";
    GW943 "rapid across at {axis} {a}, below the last retract to {b}" "";
    GW944 "subprogram {name} is never called" "";
}
