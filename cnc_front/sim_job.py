"""A part program loaded for the terminal: compiled, drawn, and with tables that turn entries into progress."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths as native_paths
from cnc_front.engine import Job, PathPlot
from cnc_front.execution import End, Execution
from cnc_front.jobs import CompiledJob, CompileOptions, JobSource, MachineFile, StimulusFile, compile_job
from cnc_front.load_check import load_check

#: Chords of the plotted path deviate by at most this, mm; and it has at most so many points.
CHORD_MM = 0.01
MAX_POINTS = 200_000
#: Bounds on the run that finds the machine time of a job: machine and wall seconds.
ESTIMATE_MACHINE_S = 12 * 3600.0
ESTIMATE_WALL_S = 60.0


@dataclass(slots=True)
class LoadedJob:
    """A compiled job with all that the screen needs to know about it."""

    job: CompiledJob
    stimulus: native_kernel.Stimulus | None
    view: Job
    path: native_paths.Path
    #: what is plotted, as toolpaths gives it
    polyline: dict[str, Any]
    #: path length at each vertex of the plot
    vertex_s_mm: NDArray[np.float64]
    #: per programmed block: number of its motion command, path length where it begins, nominal time where it ends
    entries: NDArray[np.uint32]
    begins_mm: NDArray[np.float64]
    ends_s: NDArray[np.float64]
    #: machine time of the whole job; None while unknown
    time_total_s: float | None = field(default=None)
    stimulus_file: StimulusFile | None = None

    def done_mm(self, entry: int, into_entry_mm: float) -> float:
        """Path length at a place in a motion command (1-based number)."""
        first = int(np.searchsorted(self.entries, entry))
        if first >= len(self.entries):
            return self.path.length_mm
        return min(float(self.begins_mm[first]) + into_entry_mm, self.path.length_mm)

    def spooled_s(self, entry: int, waiting: int) -> float:
        """Nominal time of the commands that wait in the spooler behind the current one."""
        first, last = np.searchsorted(self.entries, [entry, entry + waiting], side="right")
        return self._ends_at(int(last)) - self._ends_at(int(first))

    def _ends_at(self, blocks: int) -> float:
        return float(self.ends_s[blocks - 1]) if blocks > 0 else 0.0

    def fact(self, name: str, line: int) -> Any:
        """The value of a list of changes ("modal", "feeds") that holds at a source line; None before the first."""
        changes: Sequence[tuple[int, Any]] = self.job.facts[name]
        index = bisect_right(changes, line, key=lambda change: change[0])
        return changes[index - 1][1] if index else None


def load_source(
    source: JobSource, machine: MachineFile, options: CompileOptions, stimulus: StimulusFile | None
) -> LoadedJob:
    """Compiles and draws a job. Raises CompileError with every diagnostic."""
    compiled = compile_job(source, machine, options)
    programmed = native_paths.Path(compiled.program.sequence())
    line = programmed.polyline(CHORD_MM, MAX_POINTS)
    blocks = programmed.blocks()
    names = list(compiled.machine.machine.axis_names)
    extents = dict(zip(names, programmed.extents, strict=True))
    view = Job(
        path=source.path,
        name=Path(source.path).name,
        lines=source.text().splitlines(),
        plot=path_plot(line, compiled.machine.machine, compiled.facts["modal"]),
        extents=extents,
        tolerance_mm=compiled.machine.machine.tolerance_mm,
        warnings=tuple(f"{d.line}:{d.column}: {d.id}: {d.message}" for d in compiled.warnings),
        check=load_check(compiled, extents),
        path_mm=programmed.length_mm,
    )
    return LoadedJob(
        compiled,
        stimulus.stimulus if stimulus else None,
        view,
        programmed,
        line,
        line["s_mm"],
        blocks["entry"],
        blocks["s0_mm"],
        np.cumsum(blocks["length_mm"] / np.maximum(blocks["vl"], 1e-9)),
        stimulus_file=stimulus,
    )


def path_plot(line: dict[str, Any], machine: native_kernel.Machine, modal: Sequence[tuple[int, str]] = ()) -> PathPlot:
    """Of three axes: X, Y, Z and then any other linear ones; rotary axes only where there are no two linear ones.

    `line`: as toolpaths gives it; `modal`: changes of the modal state by source line.
    """
    names = list(machine.axis_names)
    linear = [name for name, kind in zip(names, machine.kinds, strict=True) if kind != "rotary"]
    usual = [name for name in ("X", "Y", "Z") if name in linear]
    wanted = [*usual, *(name for name in linear if name not in usual)]
    wanted += [name for name in names if name not in wanted][: max(0, 2 - len(wanted))]
    points = np.zeros((len(line["lines"]), 3))
    for column, name in enumerate(wanted[:3]):
        points[:, column] = line["points"][:, names.index(name)]
    axes = [*wanted[:3], "", "", ""][:3]
    plane = next((word for word in (modal[0][1].split() if modal else ()) if word in ("G17", "G18", "G19")), "G17")
    return PathPlot(points, line["lines"], line["rapid"], (axes[0], axes[1], axes[2]), plane)


def run_time_s(job: CompiledJob, superseded: Callable[[], bool]) -> float | None:
    """Machine time of a job at override 1 with every stop acknowledged at once; None if it does not end in time."""
    execution = Execution(job, max_machine_s=ESTIMATE_MACHINE_S)
    deadline = time.monotonic() + ESTIMATE_WALL_S
    while execution.advance(1 << 14) is not None:
        if superseded() or time.monotonic() > deadline:
            return None
    return execution.machine_time_s if execution.end is End.FINISHED else None
