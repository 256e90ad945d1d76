"""Verdict, JSON object and text of a rw_SymPas job that ran."""

from __future__ import annotations

from typing import Any

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.errors import Exit
from cnc_front.evidence import evidence_keys, finding_text, motor_commands
from cnc_front.execution import AlarmEvent, End
from cnc_front.geometry.judging import geometry_rows
from cnc_front.jobs import shown
from cnc_front.messages import text
from cnc_front.sap_measure import Measured, Measuring, exit_of
from cnc_front.sap_places import Places
from cnc_front.sap_run import EXECUTES, SapRun, Task
from cnc_front.sweep import sweep_text
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


def judge(result: Measured, tolerance_mm: float, more: tuple[Reason, ...] = ()) -> Verdict:
    """Every task to its end, no alarm, load side within the tolerance of what was spooled, set points on it; and what
    else was found (`more`)."""
    stopped = _why_stopped(result)
    failed = (*_findings(result, tolerance_mm), *more)
    code = exit_of(result.run, failed=bool(failed))
    if code is not Exit.DONE:
        return Verdict("FAIL", (*stopped, *failed), code, tolerance_mm)
    warnings = _warnings(result)
    return Verdict("WARN" if warnings else "PASS", warnings, code, tolerance_mm)


def _why_stopped(result: Measured) -> tuple[Reason, ...]:
    run, at = result.run, result.places.at
    found = [Reason("sap_error", {"errnum": t.error[0]} | at(t.place)) for t in run.tasks if t.error]
    if run.end is End.TIME_LIMIT:
        found.append(Reason("time_limit", {"seconds": run.options.max_time_s}))
        alive = [t for t in run.tasks if run.mcu.rdcncts(t.number)[2] & EXECUTES]
        found += [Reason("sap_goes_on", at(t.place)) for t in alive]
    if run.end is End.INTERRUPTED:
        found.append(Reason("interrupted", {}))
    return tuple(found)


def _findings(result: Measured, tolerance_mm: float) -> tuple[Reason, ...]:
    found, at = [], result.places.at
    if result.refused:
        found.append(Reason("listing_refused", {"text": result.refused}))
    actual, setpoint = result.summary["actual"], result.summary["setpoint"]
    slack = SETPOINT_SLACK_MM + result.paths.rounding_mm
    for id, deviation, limit in (("sap_tolerance", actual, tolerance_mm), ("sap_setpoint", setpoint, slack)):
        if deviation["max_mm"] > limit:
            um = {"max_um": deviation["max_mm"] * 1e3, "limit_um": limit * 1e3}
            found.append(Reason(id, um | at(deviation["worst"]["line"])))
    found += [Reason("sap_apart", at(line)) for line in result.paths.apart[:NAMED]]
    for a in result.run.alarms:
        found.append(Reason("alarm" if a.line else "alarm_idle", _alarm(a, result)))
    return tuple(found)


def _alarm(a: AlarmEvent, result: Measured) -> dict[str, Any]:
    """An alarm; line 0: no motion command was being executed."""
    return {"axis": a.axis, "name": a.name, "t_s": a.t_s} | result.places.at(a.line)


def _warnings(result: Measured) -> tuple[Reason, ...]:
    found = [Reason("sap_cut", result.places.at(line)) for line in result.paths.cut[:NAMED]]
    warnings = sum(len(t.warnings) for t in result.run.tasks)
    return (*found, *([Reason("warnings", {"count": warnings})] if warnings else []))


def _error(result: Measured, verdict: Verdict) -> dict[str, Any] | None:
    run = result.run
    if run.end is End.FINISHED or not verdict.reasons:
        return None
    failed = next((t for t in run.tasks if t.error), None)
    if failed and failed.error and run.end is End.TASK_ERROR:
        values = {"errnum": failed.error[0]} | result.places.at(failed.place)
        return {"id": "CF301", "message": text("sap_error", "en", **values), "column": None, **values}
    reason = next(r for r in verdict.reasons if r.id in ("time_limit", "interrupted"))
    found = {"id": "CF303" if run.end is End.TIME_LIMIT else "CF304"}
    found["message"] = text(reason.id, "en", **reason.values)
    return found | {"line": run.tasks[0].line, "column": None, "task": None, "errnum": None}


def run_status(run: SapRun) -> str:
    """completed, failed (runtime error) or stopped."""
    words = {End.FINISHED: "completed", End.TASK_ERROR: "failed"}
    return words.get(run.end, "stopped") if run.end else "stopped"


def run_object(result: Measured, verdict: Verdict, files: dict[str, str | None]) -> dict[str, Any]:
    """The object of design 3.2; beside it `tasks`, `contours` and `measured_s`."""
    run = result.run
    first, machine = run.tasks[0], run.machine.machine
    axes = run.mcu.status()["axes"]
    found = EMPTY | {
        "schema": SCHEMA,
        "job": job_object(first.source, first.source.path),
        "machine": machine_object(run.machine, run.machine.path),
        "stimulus": run.options.stimulus.as_json() if run.options.stimulus else None,
        "status": run_status(run),
        "error": _error(result, verdict),
        "machine_time_s": run.machine_time_s,
        "wall_time_s": run.wall_time_s,
        "samples": run.mcu.samples(),
        "sample_time_us": machine.sample_time_us,
        "commands": dict(run.listing.counts),
        "alarms": [{"bit": a.bit} | _alarm(a, result) for a in run.alarms],
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
    measured = measured_keys(result.summary, machine, result.schedule)
    found |= {"motor_command": motor_commands(run.mcu, machine.axis_names)}
    if not result.has_contour:
        return found | {key: measured[key] for key in ("following_error", "override")}
    found |= measured
    _with_tasks(found, result)
    return found


def evidence_of(
    measuring: Measuring, places: Places, machine: native_kernel.Machine, tolerance_mm: float
) -> dict[str, Any]:
    """`findings`, `circularity` and `axes` of the object of a run, of all lanes; those of axes are the same in each."""
    together: dict[str, Any] = {"findings": [], "circularity": []}
    for tracker, summary in zip(measuring.trackers, measuring.summaries, strict=True):
        found = evidence_keys(tracker, summary, machine, tolerance_mm)
        together["findings"] += [entry | places.at(entry["line"]) for entry in found["findings"]]
        for circle in found["circularity"]:
            last = places.at(circle["last_line"])["line"]
            together["circularity"].append(circle | places.at(circle["line"]) | {"last_line": last})
        together.setdefault("axes", found["axes"])
    return together


def _task(task: Task) -> dict[str, Any]:
    errnum, errline = task.error or (0, 0)
    found = {"task": task.number, "path": shown(task.source.path), "errnum": errnum, "errline": errline}
    return found | {"csrcline": task.line, "output": task.output.splitlines()}


def place_deviations(run: dict[str, Any], places: Places) -> None:
    """Lines of the worst places with the task and file that they are of."""
    for deviation in run["deviation"].values():
        deviation["worst"] |= places.at(deviation["worst"]["line"])


def _with_tasks(found: dict[str, Any], result: Measured) -> None:
    """The measured figures with their places; the figures of every lane."""
    place_deviations(found, result.places)
    names = result.run.machine.machine.axis_names
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
        *([("stimulus", run["stimulus"]["path"])] if run["stimulus"] else []),
        ("time", f"{run['machine_time_s']:.3f} s ({run['wall_time_s']:.2f} s)"),
        ("position", "  ".join(f"{name} {value:.4f} {unit}" for (name, value), unit in units)),
        *_figures(result, verdict, run, language),
        *geometry_rows(run, language),
        *(("findings", finding_text(found, language)) for found in run["findings"][:5]),
        *((key, run["files"][key]) for key in ("recording", "report") if run["files"][key]),
    ]
    rows += [f"  {say(label):<22} {value}" for label, value in figures]
    if run["override_sweep"]:
        rows += ["", *sweep_text(run["override_sweep"], language)]
    for task in result.run.tasks:
        if task.output:
            head = [f"{say('task')} {task.number}:"] if len(result.run.tasks) > 1 else []
            rows += ["", *head, *task.output.splitlines()]
    return "\n".join(rows)


def _figures(result: Measured, verdict: Verdict, run: dict[str, Any], language: str) -> list[tuple[str, str]]:
    """What was measured; a job that spools nothing has no contour."""

    def say(id: str, **values: Any) -> str:
        return text(id, language, **values)

    if not result.has_contour:
        return [("path", say("sap_no_contour"))]
    actual, setpoint, feed = run["deviation"]["actual"], run["deviation"]["setpoint"], run["feed"]
    place = say("sap_at", **actual["worst"])
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
