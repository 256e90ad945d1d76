"""The verdict of a run: PASS, WARN or FAIL with reasons, the exit code, and the object of `run --json`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import Exit
from cnc_front.execution import End
from cnc_front.jobs import JobSource, MachineFile, shown
from cnc_front.readiness import reported
from cnc_front.run import RunResult
from cnc_front.streaming import FileSource
from motion_kernel.causes import limit_of

#: How far the set point may leave the path beyond what merging allows, mm (design 3.1).
SETPOINT_SLACK_MM = 1e-6


@dataclass(frozen=True, slots=True)
class Reason:
    """One thing that made a verdict: a message id of cnc_front.messages and its values."""

    id: str
    values: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Verdict:
    """PASS, WARN (kept, but there were warnings) or FAIL; why; and what the process returns."""

    word: str
    reasons: tuple[Reason, ...]
    exit: Exit
    tolerance_mm: float


def judge(result: RunResult, tolerance_mm: float | None, more: tuple[Reason, ...] = ()) -> Verdict:
    """Design 3.1: tolerance on the load side, set point on the path, no alarm, the job ran to its end; and what else
    was found (`more`)."""
    limit = tolerance_mm if tolerance_mm is not None else result.job.machine.machine.tolerance_mm
    stopped = _why_stopped(result)
    if stopped is not None:
        code = Exit.INTERRUPTED if result.execution.end is End.INTERRUPTED else Exit.STOPPED
        return Verdict("FAIL", (stopped, *_findings(result, limit), *more), code, limit)
    findings = (*_findings(result, limit), *more)
    if findings:
        return Verdict("FAIL", findings, Exit.CHECK_FAILED, limit)
    remarks = _remarks(result)
    return Verdict("WARN" if remarks else "PASS", remarks, Exit.DONE, limit)


def with_findings(verdict: Verdict, findings: list[dict[str, Any]]) -> Verdict:
    """What was kept, but with a cause of deviation that could be named, is worth a warning."""
    if verdict.word == "FAIL" or not findings:
        return verdict
    return replace(verdict, word="WARN", reasons=(*verdict.reasons, Reason("named_findings", {"count": len(findings)})))


def _remarks(result: RunResult) -> tuple[Reason, ...]:
    """What is worth a warning although everything was kept."""
    remarks = []
    if result.job.warnings:
        remarks.append(Reason("warnings", {"count": len(result.job.warnings)}))
    if result.job.dry_feed is not None:
        remarks.append(Reason("dry_feed_run", {"feed": result.job.dry_feed * 60.0}))
    return tuple(remarks)


def _why_stopped(result: RunResult) -> Reason | None:
    execution = result.execution
    if execution.end is End.TASK_ERROR:
        number, line = execution.task_error or (0, 0)
        return Reason("task_error", {"errnum": number, "line": line})
    if execution.end is End.FAULT and execution.fault is not None:
        alarm = execution.fault.alarm
        place = " ".join(f"{axis} {value:.3f}" for axis, value in execution.fault.position.items())
        values = {"axis": alarm.axis, "name": alarm.name, "line": alarm.line, "t_s": alarm.t_s, "place": place}
        return Reason("fault", values)
    if execution.end is End.TIME_LIMIT:
        return Reason("time_limit", {"seconds": result.options.max_time_s})
    if execution.end is End.INTERRUPTED:
        return Reason("interrupted", {})
    return None


def _findings(result: RunResult, limit: float) -> tuple[Reason, ...]:
    summary = result.summary
    actual, setpoint = summary["actual"], summary["setpoint"]
    merged_mm = summary["merged"][1]
    reasons = []
    if actual["max_mm"] > limit:
        values = {"max_um": actual["max_mm"] * 1e3, "limit_um": limit * 1e3, "line": actual["worst"]["line"]}
        reasons.append(Reason("tolerance", values))
    if setpoint["max_mm"] > merged_mm + SETPOINT_SLACK_MM:
        values = {"max_um": setpoint["max_mm"] * 1e3, "line": setpoint["worst"]["line"]}
        reasons.append(Reason("setpoint", values))
    if result.execution.end is End.FINISHED and not summary["completed"]:
        reasons.append(Reason("incomplete", {"missing_mm": summary["missing_mm"], "line": summary["reached_line"]}))
    for alarm in result.execution.alarms:
        reasons.append(Reason("alarm", {"axis": alarm.axis, "name": alarm.name, "line": alarm.line, "t_s": alarm.t_s}))
    return tuple(reasons)


#: Keys of design 3.2 in their order, all unknown.
KEYS = (
    *("schema", "job", "machine", "status", "error", "machine_time_s", "wall_time_s", "samples", "sample_time_us"),
    *("commands", "path_length_mm", "merged", "deviation", "following_error", "feed", "override", "time_optimal_s"),
    *("alarms", "error_register", "output", "files", "diagnostics", "stimulus"),
    *("findings", "circularity", "axes", "motor_command", "override_sweep"),
    *("reference", "material", "collisions"),
)
EMPTY: dict[str, Any] = dict.fromkeys(KEYS)
SCHEMA = "cnc-front/run/1"


def job_object(source: JobSource | FileSource | None, path: str) -> dict[str, Any]:
    """`job` of design 3.2; what is unknown is null."""
    path = shown(path)
    if source is None:
        return {"path": path, "language": None, "sha256": None, "lines": None}
    return {"path": path, "language": source.language, "sha256": source.sha256, "lines": source.lines}


def machine_object(machine: MachineFile | None, path: str | None) -> dict[str, Any]:
    """`machine` of design 3.2."""
    if machine is None:
        return {"path": shown(path) if path else None, "name": None, "sha256": None}
    return {"path": shown(machine.path) or None, "name": machine.machine.name, "sha256": machine.sha256}


def failed_object(
    path: str,
    source: JobSource | FileSource | None,
    machine_path: str | None,
    machine: MachineFile | None,
    diagnostics: tuple[Diagnostic, ...],
) -> dict[str, Any]:
    """The object for a job or machine file that does not compile."""
    first = next((d for d in diagnostics if not d.is_warning), None)
    error = None
    if first is not None:
        error = {"id": first.id, "message": first.message, "line": first.line, "column": first.column}
        error |= {"task": None, "errnum": None}
    return EMPTY | {
        "schema": SCHEMA,
        "job": job_object(source, path),
        "machine": machine_object(machine, machine_path),
        "status": "failed",
        "error": error,
        "diagnostics": [d.as_json() for d in diagnostics],
    }


def run_object(result: RunResult, verdict: Verdict, files: dict[str, str | None]) -> dict[str, Any]:
    """The object of design 3.2 for a job that ran."""
    summary, execution, job = result.summary, result.execution, result.job
    return (
        EMPTY
        | {
            "schema": SCHEMA,
            "job": job_object(job.source, job.source.path),
            "machine": machine_object(job.machine, job.machine.path),
            "stimulus": result.options.stimulus.as_json() if result.options.stimulus else None,
            "status": result.status,
            "error": _error(result),
            "machine_time_s": execution.machine_time_s,
            "wall_time_s": result.wall_time_s,
            "samples": execution.mcu.samples(),
            "sample_time_us": job.machine.machine.sample_time_us,
            "commands": {name: count for name, count in job.program.counts() if count},
            "alarms": [
                {"t_s": a.t_s, "axis": a.axis, "bit": a.bit, "name": a.name, "line": a.line} for a in execution.alarms
            ],
            "error_register": execution.mcu.status()["errorreg"],
            "output": execution.output.splitlines(),
            "files": files,
            "start": job.facts["start"],
            "diagnostics": [d.as_json() for d in (*job.warnings, *_register(result))],
            "verdict": {
                "word": verdict.word,
                "tolerance_mm": verdict.tolerance_mm,
                "reasons": [{"id": r.id, **r.values} for r in verdict.reasons],
            },
        }
        | measured_keys(summary, job.machine.machine, result.options.schedule)
    )


def _register(result: RunResult) -> tuple[Diagnostic, ...]:
    """What the error register says, at the block of its first bit."""
    execution = result.execution
    first = next((alarm.line for alarm in execution.alarms if not alarm.axis), 0)
    return reported(execution.mcu, shown(result.job.source.path), first)


def measured_keys(summary: dict[str, Any], machine: native_kernel.Machine, schedule: Any) -> dict[str, Any]:
    """The keys of design 3.2 that come from measuring the samples; the same for a run and for its recording."""
    names = machine.axis_names
    feed: dict[str, Any] = {key: summary[key] for key in ("programmed_reached_pct", "max_over_pct")}
    errors = zip(names, summary["following_error"], strict=True)
    overrides = ("path_change_mm", "velocity_ratio_error_pct", "settling_ok", "settling_s", "settling_allowed_s")
    return {
        "path_length_mm": summary["path_length_mm"],
        "merged": {"blocks": summary["merged"][0], "max_mm": summary["merged"][1]},
        "deviation": {key: _deviation(summary[key], names) for key in ("setpoint", "actual")},
        "following_error": {name: {"max": most, "rms": rms} for name, (most, rms) in errors},
        "feed": feed | {"limits": limits_object(summary["limits"], names, machine.sample_time_us * 1e-6)},
        "override": {"schedule": [list(p) for p in schedule]} | {key: summary[key] for key in overrides},
    }


def limits_object(limits: list[tuple[int, int]], names: list[str], sample_time_s: float) -> dict[str, float]:
    """Seconds per cause that limited the path velocity, most first; `mdvel X` where a cause is that of an axis.

    They sum to the machine time.
    """
    rows = sorted(limits, key=lambda row: (-row[1], row[0]))
    return {limit_name(code, names): samples * sample_time_s for code, samples in rows}


def limit_name(code: int, names: list[str]) -> str:
    """The name of a limit of the kernel: its cause, and the axis where it has one."""
    cause, axis = limit_of(code)
    return str(cause) if axis is None else f"{cause} {names[axis]}"


def partial_object(source: JobSource, machine: Any, recorded: Any, samples: int, tolerance_mm: float) -> dict[str, Any]:
    """The object for a recording that was cut off before its result: what can still be said."""
    sample_time_us = machine.sample_time_us
    reason = {"id": "cut_off", "t_s": samples * sample_time_us * 1e-6}
    return EMPTY | {
        "schema": SCHEMA,
        "job": job_object(source, source.path),
        "machine": {"path": recorded.metadata["machine_path"] or None, "name": machine.name, "sha256": None},
        "status": "stopped",
        "machine_time_s": samples * sample_time_us * 1e-6,
        "samples": samples,
        "sample_time_us": sample_time_us,
        "alarms": [],
        "error_register": [],
        "output": [],
        "files": {"recording": recorded.path, "report": None},
        "diagnostics": [],
        "verdict": {"word": "FAIL", "tolerance_mm": tolerance_mm, "reasons": [reason]},
    }


def _error(result: RunResult) -> dict[str, Any] | None:
    stopped = _why_stopped(result)
    if stopped is None:
        return None
    from cnc_front.messages import text

    ids = {"task_error": "CF301", "fault": "CF302", "time_limit": "CF303", "interrupted": "CF304"}
    failed = stopped.id == "task_error"
    return {
        "id": ids[stopped.id],
        "message": text(stopped.id, "en", **stopped.values),
        "line": stopped.values.get("line") or None,
        "column": None,
        "task": 0 if failed else None,
        "errnum": stopped.values["errnum"] if failed else None,
    } | _place(result)


def _place(result: RunResult) -> dict[str, Any]:
    """Which axis a fault was of, when, and where the loads of all axes were."""
    fault = result.execution.fault
    if fault is None or result.execution.end is not End.FAULT:
        return {}
    return {"axis": fault.alarm.axis, "name": fault.alarm.name, "t_s": fault.alarm.t_s, "position": fault.position}


def _deviation(values: dict[str, Any], names: list[str]) -> dict[str, Any]:
    worst = values["worst"]
    position = dict(zip(names, worst["position"], strict=False))
    chosen = {key: values[key] for key in ("max_mm", "rms_mm", "p99_mm")}
    return chosen | {"worst": {"line": worst["line"], "t_s": worst["t_s"], "position": position}}
