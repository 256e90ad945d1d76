"""The narrow protocol between whoever operates a run (terminal, command line) and what executes it.

The engine owns its own thread; nothing here blocks on motion. A link to a real board could stand here later.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class State(StrEnum):
    """States of ui-guide section 4 that the emulator can be in."""

    NO_JOB = "NO JOB"
    READY = "READY"
    RUNNING = "RUNNING"
    HOLDING = "HOLDING"  # braking on the path
    HOLD = "HOLD"
    STEP = "STEP"  # stopped at the end of a block (single block)
    STOPPED = "STOPPED"  # M00, M01: waits for the operator
    WAITING = "WAITING"  # dwell or input
    DONE = "DONE"
    ABORTED = "ABORTED"
    ALARM = "ALARM"


@dataclass(frozen=True, slots=True)
class AxisValues:
    """One axis, in its own unit (mm or degrees)."""

    name: str
    unit: str
    actual: float
    command: float
    to_go: float
    following: float
    mpe: float
    referenced: bool
    spool_fill: float  # 0..1
    bits: tuple[str, ...]  # names of the axst bits that are set


@dataclass(frozen=True, slots=True)
class Alarm:
    """A fault with place, fact and remedy; `code` is stable, text is translated."""

    t_s: float
    code: str
    axis: str
    line: int
    text: str
    stopped: bool


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What the controller reports at one instant; never what the operator last asked for."""

    state: State
    why: str  # why it stands: "M00", "dwell", "hold", ...
    machine_time_s: float
    line: int  # source line that the path is on, 0 before motion
    axes: tuple[AxisValues, ...]
    feed_programmed: float  # mm/min
    feed_actual: float
    override_set: float
    override_effective: float
    path_done_mm: float
    path_total_mm: float
    time_total_s: float | None  # from the motion model, None while unknown
    deviation_now_mm: float
    deviation_max_mm: float
    deviation_max_line: int
    spool_empty_s: float
    modal: str  # "G1 G17 G90 G54 G40"
    tool: int
    spindle: str
    coolant: str
    speed_factor: float  # simulated seconds per wall second asked for, 0 = as fast as possible
    single_block: bool
    message: str = ""
    alarms: tuple[Alarm, ...] = ()


@dataclass(frozen=True, slots=True)
class PathPlot:
    """Programmed path as a polyline in machine mm, and which block each vertex belongs to."""

    points: NDArray[np.float64]  # (n, 3)
    lines: NDArray[np.uint32]  # (n,)
    rapid: NDArray[np.bool_]  # (n,) the piece that ends here is a rapid
    axes: tuple[str, str, str] = ("X", "Y", "Z")


@dataclass(frozen=True, slots=True)
class Job:
    """A loaded part program."""

    path: str
    name: str
    lines: Sequence[str]
    plot: PathPlot
    extents: dict[str, tuple[float, float]]
    tolerance_mm: float
    warnings: tuple[str, ...] = field(default=())


class Engine(Protocol):
    """Every call returns at once; effects show in later snapshots."""

    def load(self, path: str) -> Job:
        """Compiles a job (may take seconds: call it from a worker). Raises CompileError, no motion starts."""

    def start(self) -> None: ...
    def hold(self) -> None: ...
    def resume(self) -> None: ...
    def step(self) -> None: ...
    def reset(self) -> None:
        """Brakes on the path, drops the spooler; the job must be started again."""

    def set_override(self, factor: float) -> None: ...
    def set_single_block(self, on: bool) -> None: ...
    def set_speed(self, factor: float) -> None:
        """Simulated seconds per wall second; 0 runs as fast as possible."""

    def snapshot(self) -> Snapshot: ...
    def new_deviation(self, since: int) -> tuple[int, NDArray[np.float32]]:
        """Deviation (mm) per path-plot vertex driven since index `since` (NaN: not yet driven), and the new index."""

    def close(self) -> None: ...
