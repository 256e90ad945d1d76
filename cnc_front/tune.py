"""`cnc-front tune JOB --vary mdvel,kp --for time`: what machine parameters would give, swept over the emulator."""

from __future__ import annotations

import argparse
import itertools
import json
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from cnc_front import outputs
from cnc_front.errors import CompileError, Exit, UsageError
from cnc_front.interrupt import interruptible
from cnc_front.jobs import CompileOptions, JobSource, MachineFile, compile_job, load_machine, load_stimulus, read_job
from cnc_front.messages import language_from, text
from cnc_front.run import RunOptions, dry_run
from cnc_front.schedule import parse_schedule
from cnc_front.sweep import parse_range, side_by_side
from cnc_front.variation import Parameter, find, present, varied
from cnc_front.verdict import judge

SCHEMA = "cnc-front/tune/1"
DEFAULT_RANGE = "0.5:2:0.25"
#: Runs of a sweep.
MOST = 500
ABSOLUTE = ":abs"
#: Rows of the text.
SHOWN = 20

Row = dict[str, Any]


def tune(options: argparse.Namespace) -> int:
    """The command. Exit code 1 where no combination keeps the tolerance."""
    folder = outputs.check_report(options.out, [options.job, options.machine or ""], "--out") if options.out else None
    source, machine = read_job(options.job, options.language), load_machine(options.machine, options.job)
    if source.language != "din66025":
        raise UsageError("tune is for part programs; rw_SymPas jobs set their own dynamics")
    axes = _axes(options.axes, machine)
    parameters = _parameters(options.vary, options.range, machine, axes)
    tolerance = options.tolerance if options.tolerance is not None else machine.machine.tolerance_mm
    rows = _rows(source, machine, parameters, axes, tolerance, options)
    ranked = rank(rows, options.goal)
    result = {
        "schema": SCHEMA,
        "job": {"path": source.path, "sha256": source.sha256},
        "machine": {"name": machine.machine.name, "sha256": machine.sha256},
        "goal": options.goal,
        "tolerance_mm": tolerance,
        "axes": axes,
        "parameters": [
            {"name": p.name, "place": p.place, "absolute": p.absolute, "present": present(p, machine, axes)}
            for p in parameters
        ],
        "rows": ranked,
    }
    language = language_from(options.lang)
    if folder is not None:
        write(result, folder, language)
    print(json.dumps(result, allow_nan=False) if options.json else "\n".join(table(result, language)))
    if any(row["status"] == "interrupted" for row in ranked):
        return Exit.INTERRUPTED
    return Exit.DONE if ranked and ranked[0]["within"] else Exit.CHECK_FAILED


def _axes(asked: str | None, machine: MachineFile) -> list[str]:
    names = list(machine.machine.axis_names)
    if asked is None:
        return names
    chosen = [name for name in asked.split(",") if name]
    unknown = [name for name in chosen if name not in names]
    if unknown or not chosen:
        raise UsageError(f"--axes: the machine has no axis '{', '.join(unknown)}' (it has {', '.join(names)})")
    return chosen


def _parameters(vary: str, ranges: Sequence[str], machine: MachineFile, axes: Sequence[str]) -> list[Parameter]:
    given = {}
    for entry in ranges:
        name, equals, span = entry.partition("=")
        if not equals:
            raise UsageError(f"--range: '{entry}' is no NAME=FROM:TO:STEP, e.g. mdvel=0.5:2:0.25")
        given[name] = span
    names = list(dict.fromkeys(name.strip() for name in vary.split(",") if name.strip()))
    if not names:
        raise UsageError("--vary: name at least one number of the machine file, e.g. mdvel,kp")
    if missing := given.keys() - set(names):
        raise UsageError(f"--range: {', '.join(sorted(missing))} is not in --vary")
    parameters = [_parameter(name, given.get(name, DEFAULT_RANGE), machine, axes) for name in names]
    count = 1
    for parameter in parameters:
        count *= len(parameter.values)
    if count > MOST:
        raise UsageError(f"--vary: {count} combinations; at most {MOST} (narrow --range)")
    return parameters


def _parameter(name: str, span: str, machine: MachineFile, axes: Sequence[str]) -> Parameter:
    absolute = span.endswith(ABSOLUTE)
    values = parse_range(span.removesuffix(ABSOLUTE), f"--range {name}", MOST)
    parameter = Parameter(name, find(name, machine), values, absolute)
    if not absolute and all(value == 0 for value in present(parameter, machine, axes).values()):
        raise UsageError(f"--vary: {name} is 0 in the machine file; give values: --range {name}=FROM:TO:STEP:abs")
    return parameter


def _rows(
    source: JobSource,
    machine: MachineFile,
    parameters: Sequence[Parameter],
    axes: Sequence[str],
    tolerance: float,
    options: argparse.Namespace,
) -> list[Row]:
    """The machine as it is, then every combination."""
    compiling = CompileOptions(profile=options.profile, language=options.language)
    schedule = parse_schedule(options.override)
    # the job must compile on the machine as it is; a combination on which it does not is a row that says so
    compile_job(source, machine, compiling)
    grid = [None, *itertools.product(*(p.values for p in parameters))]
    with interruptible() as interrupted:

        def one(values: tuple[float, ...] | None) -> Row:
            row: Row = {
                "values": None if values is None else {p.name: v for p, v in zip(parameters, values, strict=True)}
            }
            if interrupted():
                return row | NOTHING | {"status": "interrupted"}
            try:
                chosen = dict(zip(parameters, values, strict=True)) if values else {}
                job = compile_job(source, varied(machine, chosen, axes), compiling)
                stimulus = load_stimulus(None, options.job, job.machine)
                result = dry_run(job, RunOptions(schedule, options.max_time, interrupted, stimulus=stimulus))
            except CompileError as error:
                first = error.diagnostics[0]
                return row | NOTHING | {"status": "refused", "reason": f"{first.id} {first.message}"}
            verdict = judge(result, tolerance)
            summary = result.summary
            return row | {
                "status": result.status,
                "within": verdict.word != "FAIL",
                "verdict": verdict.word,
                "machine_time_s": result.execution.machine_time_s,
                "deviation_max_mm": summary["actual"]["max_mm"],
                "line": summary["actual"]["worst"]["line"],
                "reason": text(verdict.reasons[0].id, "en", **verdict.reasons[0].values) if verdict.reasons else "",
            }

        return side_by_side(grid, one)


NOTHING: Row = {
    "within": False,
    "verdict": "FAIL",
    "machine_time_s": None,
    "deviation_max_mm": None,
    "line": None,
    "reason": "",
}


def rank(rows: Sequence[Row], goal: str) -> list[Row]:
    """Best within tolerance first, then the rest; `pareto` marks rows than which none is better in both."""
    measured = [row for row in rows if row["deviation_max_mm"] is not None and row["status"] == "completed"]
    figures = [(row["machine_time_s"], row["deviation_max_mm"]) for row in measured]

    def beaten(row: Row) -> bool:
        time, deviation = row["machine_time_s"], row["deviation_max_mm"]
        return any(t <= time and d <= deviation and (t, d) != (time, deviation) for t, d in figures)

    marked = [row | {"pareto": row in measured and not beaten(row)} for row in rows]
    keys = ("machine_time_s", "deviation_max_mm") if goal == "time" else ("deviation_max_mm", "machine_time_s")

    def key(row: Row) -> tuple[bool, list[float]]:
        return not row["within"], [float("inf") if row[name] is None else row[name] for name in keys]

    return sorted(marked, key=key)


def table(result: dict[str, Any], language: str) -> list[str]:
    """The first rows for people; `*` marks the trade-off curve."""
    names = [p["name"] for p in result["parameters"]]
    unit = {p["name"]: "" if p["absolute"] else "x" for p in result["parameters"]}
    lines = [text("tune_head", language, names="  ".join(f"{name:>10}" for name in names))]
    for row in result["rows"][:SHOWN]:
        lines.append("  ".join([_cells(row, names, unit, language), _measured(row)]))
    rest = len(result["rows"]) - SHOWN
    if rest > 0:
        lines.append(text("tune_more", language, count=rest))
    lines.append(text("tune_foot", language, limit_um=result["tolerance_mm"] * 1e3))
    return lines


def _cells(row: Row, names: Sequence[str], unit: dict[str, str], language: str) -> str:
    if row["values"] is None:
        return text("tune_present", language).rjust(12 * len(names) - 2)
    return "  ".join(f"{unit[name]}{row['values'][name]:g}".rjust(10) for name in names)


def _measured(row: Row) -> str:
    if row["deviation_max_mm"] is None:
        return f"{row['verdict']:7}  {row['status']} {row['reason']}"
    mark = "*" if row["pareto"] else " "
    figures = f"{row['machine_time_s']:10.3f}  {row['deviation_max_mm'] * 1e3:12.2f}  {row['line']:6} {mark}"
    return f"{row['verdict']:7}{figures}  {row['reason'] if not row['within'] else ''}".rstrip()


def write(result: dict[str, Any], folder: Path, language: str) -> None:
    """tune.html and tune.json; the page is marked as ours, so that a later run may replace it."""
    from jinja2 import Environment, StrictUndefined

    from cnc_front.report.words_tune import WORDS
    from cnc_front.scatter import scatter

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    room = files("cnc_front.report")
    template = environment.from_string((room / "tune.html.j2").read_text(encoding="utf-8"))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / outputs.REPORT_FILE).write_text(
        template.render(
            mark=outputs.REPORT_MARK,
            css=(room / "report.css").read_text(encoding="utf-8"),
            words=WORDS[language],
            language=language,
            result=result,
            names=[p["name"] for p in result["parameters"]],
            picture=scatter(result["rows"], result["tolerance_mm"], WORDS[language]),
        ),
        encoding="utf-8",
    )
    (folder / "tune.json").write_text(json.dumps(result, indent=1, allow_nan=False), encoding="utf-8")
