"""What `-h` begins with: examples, one table. A test reads each with the real parser."""

from __future__ import annotations

#: By command, "" for all: command line and what it is for.
EXAMPLES: dict[str, tuple[tuple[str, str], ...]] = {
    "": (
        ("cnc-front run part.nc", "dry-run, verdict on stdout"),
        ("cnc-front run part.nc --report out --json", "with HTML report, result as JSON"),
        ("cnc-front check a.nc b.nc", "compile only, name every problem"),
        ("cnc-front translate part.nc", "the spooled command sequence"),
        ("cnc-front tui part.nc", "operator's terminal"),
        ("cnc-front tune part.nc --vary mdvel,kp", "what other machine parameters would give"),
        ("cnc-front batch parts/ --machine mill.toml", "many parts, with an index of the worst"),
        ("cnc-front history --verdict FAIL --since 7d", "what ran here before"),
    ),
    "run": (
        ("cnc-front run part.nc", "dry-run, verdict on stdout"),
        ("cnc-front run part.nc --machine mill.toml --tolerance 0.02", "another machine, a limit of 20 um"),
        ("cnc-front run part.nc --report out --record part.mcap", "report and recording"),
        ("cnc-front run part.nc --override 0:1,5:0.5", "feed override halved at 5 s"),
        ("cnc-front run part.nc --from N120 --to N200", "a part of the program"),
        ("cnc-front run cell.src --task 1=plc.src", "a rw_SymPas job with a second task"),
    ),
    "check": (
        ("cnc-front check a.nc b.nc", "compile only, name every problem"),
        ("cnc-front check part.nc --machine mill.toml --strict", "on this machine, and what smells"),
    ),
    "translate": (
        ("cnc-front translate part.nc", "the spooled command sequence"),
        ("cnc-front translate part.nc --json", "as JSON Lines"),
        ("cnc-front translate job.src --output job.cnc", "autocode of a rw_SymPas job"),
    ),
    "report": (("cnc-front report part.mcap out", "report of a recorded run, without running it again"),),
    "machine": (
        ("cnc-front machine show > mill.toml", "the built-in mill, to begin a machine file with"),
        ("cnc-front machine check mill.toml", "is it valid?"),
    ),
    "tui": (
        ("cnc-front tui part.nc", "operate a job on the screen"),
        ("cnc-front tui part.nc --speed max --lang de", "as fast as possible, in German"),
        ("cnc-front tui part.nc --plain", "line mode, for screen readers and scripts"),
        ("cnc-front tui part.mcap", "replay a recording"),
    ),
    "history": (
        ("cnc-front history --since 7d", "runs of the last week"),
        ("cnc-front history 17", "one run, whole"),
        ("cnc-front history --alarms --json", "alarms, a line of JSON for each"),
    ),
    "tune": (
        ("cnc-front tune part.nc --vary mdvel,kp", "times and deviations over two parameters"),
        ("cnc-front tune part.nc --vary mdvel --for deviation --out out", "smallest deviation first, with a page"),
    ),
    "batch": (
        ("cnc-front batch parts/ --machine mill.toml", "many parts, with an index of the worst"),
        ("cnc-front batch a.nc b.nc -j 2 --fail-fast", "two at a time, to the first that is not good"),
        ("cnc-front batch --watch inbox", "what CAM drops into a folder"),
    ),
    "compare": (
        ("cnc-front compare before.mcap after.mcap", "what changed between two runs"),
        ("cnc-front compare out/monday out/tuesday --json", "two batches"),
    ),
}


def examples_text(command: str) -> str:
    """The lines for a command; empty where there are none."""
    rows = EXAMPLES.get(command, ())
    width = max((len(line) for line, _ in rows), default=0)
    return "".join(["examples:\n", *(f"  {line:<{width}}  {what}\n" for line, what in rows), "\n"]) if rows else ""
