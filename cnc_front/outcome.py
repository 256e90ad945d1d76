"""A run that is over, for the report screen and the history: result, worst blocks, what a report is made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cnc_front.deliver import Plotting, events_of, judged
from cnc_front.jobs import CompiledJob
from cnc_front.report.data import FINDINGS, ReportInput, source_line
from cnc_front.run import RunResult


@dataclass(frozen=True, slots=True)
class Finding:
    """A block and its deviation; `line` is the source line."""

    line: int
    text: str
    max_um: float
    rms_um: float


@dataclass(frozen=True, slots=True, eq=False)  # compared by identity: it holds arrays
class Outcome:
    """`number` counts the runs of an engine; `run` is the object of `run --json`; `worst`: the worst blocks first."""

    number: int
    path: str
    code: int
    run: dict[str, Any]
    worst: tuple[Finding, ...]
    report: ReportInput

    def kept(self) -> dict[str, Any]:
        """The object for the history: with the worst blocks, so that a later run can be compared with it."""
        worst = [{"line": f.line, "text": f.text, "max_um": f.max_um, "rms_um": f.rms_um} for f in self.worst]
        return self.run | {"worst": worst}


def outcome_of(
    result: RunResult,
    plotting: Plotting,
    number: int,
    tolerance_mm: float | None = None,
    recording: str | None = None,
) -> Outcome:
    """Judges a run that is over; nothing is measured again. Call it once for a run. `recording`: its file."""
    verdict, run = judged(result, tolerance_mm, {"recording": recording, "report": None})
    assert isinstance(result.job, CompiledJob)  # the terminal compiles whole programs
    machine, source = result.job.machine.machine, result.job.source
    report = plotting.report_input(run, result.summary, source, machine, events_of(result))
    return Outcome(number, source.path, int(verdict.exit), run, worst_blocks(report), report)


def worst_blocks(report: ReportInput, most: int = FINDINGS) -> tuple[Finding, ...]:
    """The blocks with the largest deviation, without making a table of a million blocks."""
    worst = np.nan_to_num(np.asarray(report.measured["actual_max_mm"]), nan=0.0)
    order = np.argsort(-worst, kind="stable")[:most].tolist()
    rms, lines = report.measured["actual_rms_mm"], report.blocks["line"]
    return tuple(
        Finding(
            int(lines[k]), source_line(report.job_lines, lines[k]), float(worst[k]) * 1e3, float(rms[k] or 0.0) * 1e3
        )
        for k in order
        if worst[k] > 0
    )
