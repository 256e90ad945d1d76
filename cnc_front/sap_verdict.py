"""Verdict, JSON object and text of a rw_SymPas job that ran."""

from __future__ import annotations

from typing import Any

from cnc_front.errors import Exit
from cnc_front.execution import End
from cnc_front.jobs import shown
from cnc_front.messages import text
from cnc_front.sap_measure import Measured, exit_of, line_offsets, place_of
from cnc_front.sap_run import EXECUTES
from cnc_front.verdict import (
    EMPTY,
    SCHEMA,
    SETPOINT_SLACK_MM,
    Reason,
    Verdict,
    job_object,
    machine_object,
    measured_keys,
)

#: Most rows of one kind that are named.
NAMED = 10


def judge(result: Measured, tolerance_mm: float) -> Verdict:
    """Every task to its end, no alarm, load side within the tolerance of what was spooled, set points on it."""
    stopped = _why_stopped(result)
    failed = _findings(result, tolerance_mm)
    code = exit_of(result.run, failed=bool(failed))
    if code is not Exit.DONE:
        return Verdict("FAIL", (*stopped, *failed), code, tolerance_mm)
    warnings = _warnings(result)
    return Verdict("WARN" if warnings else "PASS", warnings, code, tolerance_mm)


def _why_stopped(result: Measured) -> tuple[Reason, ...]:
    run = result.run
    found = [
        Reason("sap_error", {"task": t.number, "errnum": t.error[0], "line": t.error[1]}) for t in run.tasks if t.error
    ]
    if run.end is End.TIME_LIMIT:
        found.append(Reason("time_limit", {"seconds": run.options.max_time_s}))
        alive = [t for t in run.tasks if run.mcu.rdcncts(t.number)[2] & EXECUTES]
        found += [Reason("sap_goes_on", {"task": t.number, "line": t.line}) for t in alive]
    if run.end is End.INTERRUPTED:
        found.append(Reason("interrupted", {}))
    return tuple(found)


def _findings(result: Measured, tolerance_mm: float) -> tuple[Reason, ...]:
    found = []
    if result.refused:
        found.append(Reason("listing_refused", {"text": result.refused}))
    if result.summary is not None:
        offsets = line_offsets(result.run.tasks)
        actual, setpoint = result.summary["actual"], result.summary["setpoint"]
        slack = SETPOINT_SLACK_MM + result.paths.rounding_mm
        for id, deviation, limit in (("sap_tolerance", actual, tolerance_mm), ("sap_setpoint", setpoint, slack)):
            if deviation["max_mm"] > limit:
                task, line = place_of(deviation["worst"]["line"], offsets)
                um = {"max_um": deviation["max_mm"] * 1e3, "limit_um": limit * 1e3}
                found.append(Reason(id, um | {"task": task, "line": line}))
    for task, line in result.paths.apart[:NAMED]:
        found.append(Reason("sap_apart", {"task": task, "line": line}))
    for a in result.run.alarms:
        found.append(Reason("alarm", {"axis": a.axis, "name": a.name, "line": a.line, "t_s": a.t_s}))
    return tuple(found)


def _warnings(result: Measured) -> tuple[Reason, ...]:
    found = [Reason("sap_cut", {"task": task, "line": line}) for task, line in result.paths.cut[:NAMED]]
    warnings = sum(len(t.warnings) for t in result.run.tasks)
    return (*found, *([Reason("warnings", {"count": warnings})] if warnings else []))


def _error(result: Measured, verdict: Verdict) -> dict[str, Any] | None:
    run = result.run
    if run.end is End.FINISHED or not verdict.reasons:
        return None
    failed = next((t for t in run.tasks if t.error), None)
    if failed and failed.error and run.end is End.TASK_ERROR:
        values = {"task": failed.number, "errnum": failed.error[0], "line": failed.error[1]}
        return {"id": "CF301", "message": text("sap_error", "en", **values), "column": None, **values}
    reason = next(r for r in verdict.reasons if r.id in ("time_limit", "interrupted"))
    found = {"id": "CF303" if run.end is End.TIME_LIMIT else "CF304"}
    found["message"] = text(reason.id, "en", **reason.values)
    return found | {"line": run.tasks[0].line, "column": None, "task": None, "errnum": None}


def run_object(result: Measured, verdict: Verdict, files: dict[str, str | None]) -> dict[str, Any]:
    """The object of design 3.2; beside it `tasks`, `contours` and `measured_s`."""
    run = result.run
    first, machine = run.tasks[0], run.machine.machine
    axes = run.mcu.status()["axes"]
    words = {End.FINISHED: "completed", End.TASK_ERROR: "failed"}
    found = EMPTY | {
        "schema": SCHEMA,
        "job": job_object(first.source, first.source.path),
        "machine": machine_object(run.machine, run.machine.path),
        "stimulus": run.options.stimulus.as_json() if run.options.stimulus else None,
        "status": words.get(run.end, "stopped") if run.end else "stopped",
        "error": _error(result, verdict),
        "machine_time_s": run.machine_time_s,
        "wall_time_s": run.wall_time_s,
        "samples": run.mcu.samples(),
        "sample_time_us": machine.sample_time_us,
        "commands": dict(run.listing.counts),
        "alarms": [{"t_s": a.t_s, "axis": a.axis, "bit": a.bit, "name": a.name, "line": a.line} for a in run.alarms],
        "error_register": run.mcu.status()["errorreg"],
        "output": first.output.splitlines(),
        "files": files,
        "diagnostics": [d.as_json() for t in run.tasks for d in t.warnings],
        "verdict": {
            "word": verdict.word,
            "tolerance_mm": verdict.tolerance_mm,
            "reasons": [{"id": r.id, **r.values} for r in verdict.reasons],
        },
        "tasks": [_task(task) for task in run.tasks],
        "position": {name: axis["load"] for name, axis in zip(machine.axis_names, axes, strict=True)},
        "measured_s": result.measured_s,
        "contours": [],
    }
    if result.summary is None:
        return found | {"override": {"schedule": [list(p) for p in result.schedule]}}
    found |= measured_keys(result.summary, machine, result.schedule)
    _with_tasks(found, result)
    return found


def _task(task: Any) -> dict[str, Any]:
    errnum, errline = task.error or (0, 0)
    found = {"task": task.number, "path": shown(task.source.path), "errnum": errnum, "errline": errline}
    return found | {"csrcline": task.line, "output": task.output.splitlines()}


def _with_tasks(found: dict[str, Any], result: Measured) -> None:
    """Lines of the measured figures with the task whose text they are of; the figures of every lane."""
    offsets = line_offsets(result.run.tasks)
    names = result.run.machine.machine.axis_names
    for deviation in found["deviation"].values():
        worst = deviation["worst"]
        worst["task"], worst["line"] = place_of(worst["line"], offsets)
    assert result.measuring is not None
    for lane, summary in zip(result.lanes, result.measuring.summaries, strict=True):
        entry = {
            "axes": [name for a, name in enumerate(names) if lane.axes >> a & 1],
            "commands": len(lane.rows),
            "stretches": len(lane.stretches),
            "path_length_mm": summary["path_length_mm"],
        }
        entry |= {f"{key}_max_mm": summary[key]["max_mm"] for key in ("setpoint", "actual")}
        found["contours"].append(entry)


def result_text(result: Measured, verdict: Verdict, run: dict[str, Any], language: str) -> str:
    """Verdict, figures, what the tasks wrote."""

    def say(id: str, **values: Any) -> str:
        return text(id, language, **values)

    machine, rows = result.run.machine.machine, [f"{run['job']['path']}: {verdict.word}"]
    rows += [f"  {say(r.id, **r.values)}" for r in verdict.reasons[:NAMED]]
    units = zip(run["position"].items(), machine.units, strict=True)
    figures = [
        ("machine", f"{machine.name} ({run['machine']['path'] or say('builtin')})"),
        ("time", f"{run['machine_time_s']:.3f} s ({run['wall_time_s']:.2f} s)"),
        ("position", "  ".join(f"{name} {value:.4f} {unit}" for (name, value), unit in units)),
        *_figures(result, verdict, run, language),
        *((key, run["files"][key]) for key in ("recording", "report") if run["files"][key]),
    ]
    rows += [f"  {say(label):<22} {value}" for label, value in figures]
    for task in result.run.tasks:
        if task.output:
            head = [f"{say('task')} {task.number}:"] if len(result.run.tasks) > 1 else []
            rows += ["", *head, *task.output.splitlines()]
    return "\n".join(rows)


def _figures(result: Measured, verdict: Verdict, run: dict[str, Any], language: str) -> list[tuple[str, str]]:
    """What was measured; a job that spools nothing has no contour."""

    def say(id: str, **values: Any) -> str:
        return text(id, language, **values)

    if result.summary is None:
        return [("path", say("sap_no_contour"))]
    actual, setpoint, feed = run["deviation"]["actual"], run["deviation"]["setpoint"], run["feed"]
    place = say("sap_at", task=actual["worst"]["task"], line=actual["worst"]["line"])
    limit = f"{say('limit')} {verdict.tolerance_mm * 1e3:g} um"
    commands = "  ".join(f"{name} {count}" for name, count in run["commands"].items())
    found = [
        ("path", f"{run['path_length_mm']:.3f} mm, {say('sap_measured', seconds=run['measured_s'])}"),
        ("commands", commands),
        ("deviation", f"{actual['max_mm'] * 1e3:.1f} um {place}, {limit}"),
        ("setpoint_deviation", f"{setpoint['max_mm'] * 1e3:.4f} um"),
    ]
    if len(run["contours"]) > 1:
        groups = ", ".join(f"{' '.join(c['axes'])} {c['actual_max_mm'] * 1e3:.1f} um" for c in run["contours"])
        found.append(("sap_groups", groups))
    if feed["programmed_reached_pct"] is not None:
        found.append(("feed", f"{feed['programmed_reached_pct']:.1f} % {say('of_time')}"))
    return found
