"""`run --override-sweep 0.1:1.5:0.1`: one run for each override factor, side by side in one table."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from cnc_front.errors import UsageError
from cnc_front.evidence import evidence_keys
from cnc_front.jobs import CompiledJob
from cnc_front.messages import text
from cnc_front.run import RunOptions, dry_run
from cnc_front.schedule import HIGHEST
from cnc_front.verdict import judge

#: Points of a sweep.
MOST = 200

Task = TypeVar("Task")
Result = TypeVar("Result")


def parse_range(text: str, option: str, most: int = MOST) -> tuple[float, ...]:
    """FROM:TO:STEP with both ends, or one number; rising positive numbers. Raises UsageError with what is wrong."""
    parts = text.split(":")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) == 1:
        numbers = [numbers[0], numbers[0], 1.0]
    if len(numbers) != 3 or not all(0 < number < 1e9 for number in numbers):
        raise UsageError(f"{option}: '{text}' is no FROM:TO:STEP of positive numbers, e.g. 0.1:1.5:0.1")
    first, last, step = numbers
    if last < first:
        raise UsageError(f"{option}: {first:g} to {last:g} does not rise")
    count = int((last - first) / step + 1e-9) + 1
    if count > most:
        raise UsageError(f"{option}: {count} values; at most {most}")
    # decimal steps give decimal values
    return tuple(float(f"{first + k * step:.12g}") for k in range(count))


def parse_sweep(text: str | None) -> tuple[float, ...]:
    """The factors of --override-sweep; none without it."""
    if text is None:
        return ()
    factors = parse_range(text, "--override-sweep")
    if factors[-1] > HIGHEST:
        raise UsageError(f"--override-sweep: factor {factors[-1]:g} is above {HIGHEST:g}")
    return factors


def side_by_side(tasks: Iterable[Task], work: Callable[[Task], Result]) -> list[Result]:
    """Results in the order of the tasks. The emulator and the tracker release the GIL, so threads use every core."""
    with ThreadPoolExecutor(os.cpu_count() or 1, "sweep") as pool:
        return list(pool.map(work, tasks))


@dataclass(frozen=True, slots=True)
class Swept:
    """A run at one factor: word of its verdict, status, machine time, summary of toolpaths, `axes` of its evidence."""

    word: str
    status: str
    machine_time_s: float
    summary: dict[str, Any]
    axes: dict[str, Any]


def override_sweep(factors: Sequence[float], run: Callable[[float], Swept]) -> list[dict[str, Any]]:
    """One row per factor, held from the start. Accelerations are the largest of any axis, in % of its maxacc."""

    def one(factor: float) -> dict[str, Any]:
        swept = run(factor)
        summary, axes = swept.summary, swept.axes.values()
        loads = [100 * a["acceleration_max"] / a["acceleration_limit"] for a in axes if a["acceleration_limit"] > 0]
        return {
            "factor": factor,
            "verdict": swept.word,
            "status": swept.status,
            "machine_time_s": swept.machine_time_s,
            "actual_max_mm": summary["actual"]["max_mm"],
            "setpoint_max_mm": summary["setpoint"]["max_mm"],
            "path_change_mm": summary["path_change_mm"],
            "velocity_ratio_error_pct": summary["velocity_ratio_error_pct"],
            "programmed_reached_pct": summary["programmed_reached_pct"],
            "acceleration_of_maxacc_pct": max(loads, default=None),
        }

    return side_by_side(factors, one)


def job_at(job: CompiledJob, options: RunOptions, tolerance_mm: float) -> Callable[[float], Swept]:
    """Runs of a part program at a factor."""
    quiet = replace(options, progress=lambda execution: None, sweep=(), time_optimal=False)

    def run(factor: float) -> Swept:
        result = dry_run(job, replace(quiet, schedule=((0.0, factor),)))
        axes = evidence_keys(result.tracker, result.summary, job.machine.machine, tolerance_mm)["axes"]
        word = judge(result, tolerance_mm).word
        return Swept(word, result.status, result.execution.machine_time_s, result.summary, axes)

    return run


def sweep_text(rows: Sequence[dict[str, Any]], language: str) -> list[str]:
    """The table for people, every column as wide as its head."""
    head = text("sweep_head", language).split("|")
    lines = ["  " + "  ".join(head)]
    for row in rows:
        figures = (
            f"{row['factor']:g}",
            row["verdict"],
            f"{row['machine_time_s']:.3f}",
            f"{row['actual_max_mm'] * 1e3:.2f}",
            f"{row['path_change_mm'] * 1e3:.4f}",
            _figure(row["velocity_ratio_error_pct"], 4),
            _figure(row["programmed_reached_pct"], 1),
            _figure(row["acceleration_of_maxacc_pct"], 0),
        )
        lines.append("  " + "  ".join(value.rjust(len(name)) for value, name in zip(figures, head, strict=True)))
    return lines


def _figure(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
