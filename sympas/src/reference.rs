//! The reference page `docs/sympas.md`: predefined names from the controller's tables, messages from the catalogue.

use std::fmt::Write;

use motion_kernel::sap::tables::{
    Access, BitQualifier, Command, Event, Form, Function, Qualifier, SystemParameter, TaskCommand, command,
};

use crate::catalogue::CATALOGUE;
use crate::lexer::{MAX_INCLUDE_LEVELS, MAX_SOURCE_MIB};
use crate::parser::{MAX_HEIGHT, MAX_NESTING};

const HEAD: &str = "# rw_SymPas jobs

<!-- Written by `cargo run -p sympas --example sympas_reference > docs/sympas.md`; a test compares it. -->

Stand-alone jobs (`.src`) as chapters 5 and 6 of the programming manual describe them. A job starts as after a boot: open
loop, not referenced.

| command | what |
|---|---|
| `cnc-front check job.src` | every error and warning: file, line, column, id, the line with a caret, what to do |
| `cnc-front translate job.src` | the instructions of the job (`--autocode` says the same) |
| `cnc-front translate job.src --output job.cnc` | the autocode file, versioned and checksummed |
| `cnc-front run job.src --task 1=monitor.src` | runs up to four tasks; `job.cnc` works too |

`run` measures what the tasks spool (`smla`, `smca`, `smha`, their relative forms, circles in space) as it does part
programs: `--tolerance`, `--override`, `--record`, `--report`, `--json`. Direct moves (`ja`, `mla` ...) have no programmed
contour and are left out; `measured_s` says for how long something was measured. The path is what was spooled when the
job ran, so the job runs twice, in the same way. Groups of axes that run side by side (task 0 on X and Y, task 1 on Z)
have a path each (`contours`). Spooling for other axes while some of them still execute a command takes them apart: that
is a finding. A contour that `js`, `ms` or `rs` breaks off is measured up to there and makes the verdict WARN. Without
ExactTargetPos a stop may be off by half a count. `translate job.src --json` lists what a job spools.

`findings`, `circularity`, `--samples`, `--scan`, `--override-sweep` and `--reference` (the machine needs axes X and Y) mean
what they mean for part programs; direct moves are no part of a drawing. `axes`, `following_error` and the curves of a report
over time are of the whole run, direct moves too, and are told where nothing was spooled. `--from`, `--to`,
`--time-optimal` and `--setup` are refused: a job has no blocks, waits for inputs, and names no tools.

What a job does in an include is told with its file: task 0, line 9 of `ring.inc` (`task`, `line`, `file` in JSON; `file`
null: the text of the task itself). In samples, recordings and reports one number names a line of all texts, a task's text
first, its includes behind it, the tasks behind each other; the report says which. `errline` and `csrcline` are lines of
their file.

The job itself runs in the task of its `{$TASK n}`, else in task 0. A run ends when all tasks have ended and the axes
stand, or at `--max-time`; a runtime error stops its task only. Where MODEREG bit 26 (StopAtWriteln) halts a task, the run
takes its output and continues it.

`cnc-front tui job.src --task 1=monitor.src` steps through the tasks: `t` a line, into routines, `T` over them, `U` out, `b` a
breakpoint (also in the includes, which stand behind the job; on a line without statement at the next one), `R` this task goes
on, `r` all tasks, Space holds, `=` sets a variable (`n = 5`, `CI3 = 1`), Tab the next task, `v` all side by side. The `.stim`
beside the job acts. In Python `task = mcu.task(0)` has `break_at(57, 'ring.inc:5')`, `go()`, `step(over=True)`, `step_out()`,
`calls`, `variables`, `rows` (those of the callers too), `assign(name, value)`, `line`, `place`, `text_of(place)`.

In Python `sympas.compile(text_or_path, machine)` gives a `Program` for `Mcu.load(task, program)`; `sympas.load(path)`
reads an autocode file. Messages are English or German (`--lang de`).

## Readings of the manual

- Keywords, commands, functions, TRUE and FALSE in any case; all other names as they are printed.
- Both operands of `and` and `or` are evaluated. `/` of two Integers is integral. Integers wrap to 32 bits.
- Real arithmetic runs in double precision; a Single is rounded where it is stored.
- A `for` loop evaluates both bounds once, start value first, and assigns the start value even if there is no pass;
  afterwards the variable holds the last value used.
- Arguments and operands are evaluated from left to right.
- A runtime error, `csrcline` and a single step name the line on which the statement begins; `until` its own.
";

/// The whole page.
pub fn page() -> String {
    let mut out = HEAD.to_owned();
    limits(&mut out);
    commands(&mut out);
    registers(&mut out);
    messages(&mut out);
    out
}

fn limits(out: &mut String) {
    use motion_kernel::sap::code::{MOST_FRAME, MOST_GLOBALS};
    let _ = write!(
        out,
        "
## Limits

| what | most |
|---|---|
| source text with its includes | {MAX_SOURCE_MIB} MiB |
| include levels | {MAX_INCLUDE_LEVELS} |
| statements and parentheses within each other | {MAX_NESTING} |
| operators in a row | {MAX_HEIGHT} |
| global variables and axes, with the first 2048 different constants | {MOST_GLOBALS} |
| variables and intermediate values of a routine | {MOST_FRAME} |
| axes of a command | {} |
",
        motion_kernel::axes::MAX_AXES
    );
}

fn form_text(form: Form) -> &'static str {
    match form {
        Form::Nothing => "",
        Form::Axes => "A1, ...",
        Form::OneAxis => "A1",
        Form::Values { path: false } => "A1 := value, ...",
        Form::Values { path: true } => "A1 := value, ..., TRAC, TRVL, TRTVL",
        Form::Circle => "A1 := centre, A2 := centre, PHI, TRAC, TRVL, TRTVL",
        Form::Helix => "A1 := centre, A2 := centre, A3 := target, ..., PHI, DTCA1, DTCA2, TRAC, TRVL, TRTVL",
        Form::Circle3d => "A1, A2, A3 := centre, PN1, PN2, PN3, PHI, TRAC, TRVL, TRTVL",
        Form::SpoolFunction => "A1 := value, ..., SSFP",
    }
}

fn commands(out: &mut String) {
    *out += "\n## Commands (6.6)\n\nPath parameters (upper case) are optional: `PHI := 90.0` assigns the system parameter.\n
| command | waiting form | arguments |\n|---|---|---|\n";
    for item in Command::ALL {
        let waiting = format!("{}w", item.name());
        let waiting = if command(&waiting).is_some() { waiting } else { String::new() };
        let _ = writeln!(out, "| {} | {waiting} | {} |", item.name(), form_text(item.form()));
    }
    for item in TaskCommand::ALL {
        let _ = writeln!(out, "| {} | | Integer constant 0..3 |", item.name());
    }
    let events: Vec<&str> = Event::ALL.iter().map(|e| e.name()).collect();
    let _ = write!(
        out,
        "| abort, stop | | |
| azo | | Integer constant 0..4 |
| enev, disev | | {} |
| wt | | Integer, ticks of 64 us |
| wrcbi, wrcbs, wrcbd | | offset, value |
| write, writeln | | strings and values |

Functions: {}, power(base, exponent), rdcbi, rdcbs, rdcbd (offset).
",
        events.join(", "),
        Function::ALL.iter().map(|f| f.name()).collect::<Vec<_>>().join(", ")
    );
}

fn access_text(access: Access) -> &'static str {
    match access {
        Access::Read => "r",
        Access::ReadWrite => "r/w",
        Access::ReadClear => "r, writing clears latched flags",
    }
}

fn registers(out: &mut String) {
    let mut table = |title: &str, rows: Vec<(&str, motion_kernel::sap::tables::Type, Access, &str)>| {
        let _ = write!(out, "\n## {title}\n\n| name | type | access | meaning |\n|---|---|---|---|\n");
        for (name, kind, access, text) in rows {
            let _ = writeln!(out, "| {name} | {} | {} | {text} |", kind.name(), access_text(access));
        }
    };
    table("System parameters (6.3.1)", SystemParameter::ALL.iter().map(|p| p.row()).collect());
    table("Axis qualifiers (6.3.3), `axis.name`", Qualifier::ALL.iter().map(|q| q.row()).collect());
    table("Bits (6.3.4), `axis.name.n` with n from 1", BitQualifier::ALL.iter().map(|q| q.row()).collect());
    *out += "\nBeside these: `CI0` to `CI999` (Integer), `CD0` to `CD999` (Double), `SysVarInt[n]`, `SysVarDbl[n]`, `axis.an`,
`axis.varint[n]`, `axis.vardbl[n]`.\n";
}

fn messages(out: &mut String) {
    *out += "\n## Messages of the compiler\n\n3 and 91 are the manual's numbers; SP are errors, SW warnings.\n
| id | message | what to do |\n|---|---|---|\n";
    for (_, name, [text, hint], _) in CATALOGUE {
        let _ = writeln!(out, "| {name} | {} | {} |", text.replace('|', "\\|"), hint.replace('|', "\\|"));
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_page_is_up_to_date() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/sympas.md");
        let written = std::fs::read_to_string(file).expect("the page");
        assert_eq!(written, super::page(), "cargo run -p sympas --example sympas_reference > docs/sympas.md");
    }
}
