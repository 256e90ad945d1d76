"""What would have been possible: the time-optimal bound of a run (design D27), in all and per section of the program.

A section runs from stop to stop of the program. Bound of the run: its machine time less what its motion commands took
longer than they had to, between the speeds that they had at their ends; standstill between them counts as it was.
"""

from __future__ import annotations

import importlib.util
import tomllib
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths as native_paths
from cnc_front.errors import UsageError
from cnc_front.verdict import limit_name
from toolpaths.optimal import AxisLimits, least_times

#: Sections that a report lists, those with the largest gap.
SECTIONS = 50


def check_available() -> None:
    """Raises UsageError where toppra is not installed."""
    if importlib.util.find_spec("toppra") is None:
        raise UsageError("--time-optimal needs toppra; install cnc-front[optimal] (or: pip install toppra)")


@dataclass(frozen=True, slots=True)
class TimeOptimal:
    """The bound; where the gap to it is, and why. `gap_of` has seconds per limit, most first."""

    seconds: float
    gap_of: dict[str, float]
    sections: list[dict[str, Any]]
    section_count: int
    arcs: int
    arcs_by_toppra: int

    def as_json(self) -> dict[str, Any]:
        """For report.json."""
        return {
            "seconds": self.seconds,
            "gap_of": self.gap_of,
            "sections": self.sections,
            "section_count": self.section_count,
            "arcs": self.arcs,
            "arcs_by_toppra": self.arcs_by_toppra,
        }


def axis_limits(machine: native_kernel.Machine) -> AxisLimits:
    """Of the machine file: maxvel and maxacc where they are watched, else rapid and acceleration."""
    rows = machine.dynamics()
    velocity = np.array([maxvel or rapid for _, maxvel, _, rapid, _ in rows])
    acceleration = np.array([maxacc or acceleration for _, _, maxacc, _, acceleration in rows])
    text = tomllib.loads(machine.show())
    shaped = "SProfile" in text["gcode"]["modereg"]
    over = 1.0 + max(axis["jerkrel"] for axis in text["axis"]) if shaped else 1.0
    return AxisLimits(velocity, acceleration, over)


def time_optimal(
    sequence: dict[str, NDArray[Any]],
    path: native_paths.Path,
    tracker: native_paths.Tracker,
    machine: native_kernel.Machine,
    samples: int,
) -> TimeOptimal:
    """The bound of a run that was measured with passages; after Tracker.finish."""
    sample_time_s = machine.sample_time_us * 1e-6
    passages = tracker.passages()
    found = least_times(sequence, passages, axis_limits(machine), sample_time_s)
    gap = np.maximum(found.taken - found.least, 0.0)
    n = len(gap)
    causes = _causes(path, tracker, n)
    time_s = passages["samples"][:n] * sample_time_s
    section = (
        np.concatenate([[0], np.cumsum(sequence["tvl"][:n] <= 0)[:-1]]).astype(np.int64) if n else np.zeros(0, int)
    )
    rows = _sections(section, sequence["line"][:n], time_s, gap, causes, machine.axis_names)
    return TimeOptimal(
        samples * sample_time_s - float(gap.sum()),
        _gap_of(gap, causes, machine.axis_names),
        sorted(rows, key=lambda row: (-row["gap_s"], row["first_line"]))[:SECTIONS],
        len(rows),
        found.arcs,
        found.by_toppra,
    )


def _causes(path: native_paths.Path, tracker: native_paths.Tracker, commands: int) -> NDArray[np.int64]:
    """Per motion command what limited it below its velocity, or, where it always had that, what set it."""
    blocks, measured = path.blocks(), tracker.blocks()
    causes = np.zeros(commands + 1, dtype=np.int64)
    entry = np.minimum(blocks["entry"], commands)
    causes[entry] = np.where(measured["slow_limit"] > 0, measured["slow_limit"], measured["limit"])
    return causes[1:]


def _gap_of(gap: NDArray[np.float64], causes: NDArray[np.int64], axes: list[str]) -> dict[str, float]:
    sums = {int(code): float(gap[causes == code].sum()) for code in np.unique(causes)}
    return {
        limit_name(code, axes): seconds for code, seconds in sorted(sums.items(), key=lambda i: -i[1]) if seconds > 0
    }


def _sections(
    section: NDArray[np.int64],
    line: NDArray[np.uint32],
    time_s: NDArray[np.float64],
    gap: NDArray[np.float64],
    causes: NDArray[np.int64],
    axes: list[str],
) -> list[dict[str, Any]]:
    """One row per section that was driven, with the cause of most of its gap."""
    begins = np.flatnonzero(np.diff(section, prepend=-1))
    rows = []
    for a, b in pairwise([*begins.tolist(), len(section)]):
        taken_s, gap_s = float(time_s[a:b].sum()), float(gap[a:b].sum())
        if taken_s <= 0:
            continue
        most = int(causes[a + int(gap[a:b].argmax())])
        if b - a > 1:
            most = int(np.bincount(causes[a:b], weights=gap[a:b]).argmax())
        rows.append(
            {"first_line": int(line[a]), "last_line": int(line[b - 1]), "commands": b - a}
            | {"time_s": taken_s, "least_s": taken_s - gap_s, "gap_s": gap_s}
            | {"limit": limit_name(most, axes) if most and gap_s > 0 else ""}
        )
    return rows
