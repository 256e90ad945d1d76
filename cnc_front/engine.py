"""The narrow protocol between whoever operates a run (terminal, command line) and what executes it.

The engine owns its own thread; nothing here blocks on motion. A link to a real board could stand here later.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from cnc_front.load_check import LoadCheck
    from cnc_front.outcome import Outcome
    from cnc_front.search import Start
    from cnc_front.service import Service


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


class Mode(StrEnum):
    """What moves the axes."""

    AUTO = "AUTO"
    MDI = "MDI"
    MANUAL = "MANUAL"


class Stop(StrEnum):
    """The four stops (ui-guide section 4)."""

    NONE = ""
    HOLD = "HOLD"  # slows on the path, resumable
    BLOCK_END = "BLOCK END"  # finishes the block, the spooler is kept
    ABORT = "ABORT"  # brakes on the path, the spooler is dropped
    FAST_STOP = "FAST STOP"  # each axis on its own ramp, contour left, the spooler is dropped


@dataclass(frozen=True, slots=True)
class Switches:
    """What the operator switched on for a program; it counts when the program is loaded and started."""

    optional_stop: bool = False
    skip: tuple[int, ...] = ()
    #: feed moves at the dry-run feed instead of F
    dry_run: bool = False
    #: the program runs, stops for nobody, and the axes stay where they are
    program_test: bool = False
    #: mm/min; None: that of the machine file
    dry_feed: float | None = None


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
    limits: tuple[float, float] | None = None  # software limits
    zero: float = 0.0  # work offset G54: program coordinate 0 in machine coordinates
    #: kp, ki, kd, kpl, kfcv, kfca by name
    gains: tuple[tuple[str, float], ...] = ()
    jog_feed: float = 0.0  # units a minute
    #: how `home` finds its reference; empty: it cannot
    homing: str = ""
    home_side: str = "left"  # of the switch; the index is searched the other way
    home_place: int = 0  # in the order in which all axes are homed, from 1


@dataclass(frozen=True, slots=True)
class Alarm:
    """A fault with place, fact and remedy; `code` is stable, text is translated, `name` is the manual's of the bit."""

    t_s: float
    code: str
    axis: str
    line: int
    text: str
    stopped: bool
    name: str = ""


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
    mode: Mode = Mode.AUTO
    rapid_set: float = 1.0
    switches: Switches = field(default_factory=Switches)
    stop: Stop = Stop.NONE  # which stop the machine is in
    since_s: float = 0.0  # machine time for which it stands or waits
    waits_for: tuple[int, ...] = ()  # numbers of the inputs that it waits for
    inputs: int = 0  # bit n: input n + 1 is active
    outputs: int = 0
    revision: int = 0  # counts the jobs taken over: another one is `current_job()` now
    start_line: int = 0  # the loaded job begins at this line; 0: at its top
    mdi: str = ""  # the MDI block that was checked and may be started
    mdi_modal: str = ""  # modal state of MDI, behind its last block
    dry_feed: float = 0.0  # mm/min, of the switches or the machine file
    feed_limit: float = 0.0  # mm/min, highest path feed of the machine
    forced: tuple[int, ...] = ()  # inputs that the operator has forced, also in later runs
    replay: bool = False  # a recording is shown; nothing moves
    output: tuple[str, ...] = ()  # what rw_SymPas statements wrote, newest last


@dataclass(frozen=True, slots=True, eq=False)  # compared by identity: it holds arrays
class PathPlot:
    """Programmed path as a polyline in machine mm, and which block each vertex belongs to."""

    points: NDArray[np.float64]  # (n, 3)
    lines: NDArray[np.uint32]  # (n,)
    rapid: NDArray[np.bool_]  # (n,) the piece that ends here is a rapid
    axes: tuple[str, str, str] = ("X", "Y", "Z")  # empty where there are fewer
    plane: str = "G17"  # that the first motion is programmed in


@dataclass(frozen=True, slots=True, eq=False)  # compared by identity: it holds arrays
class Job:
    """A loaded part program."""

    path: str
    name: str
    lines: Sequence[str]
    plot: PathPlot
    extents: dict[str, tuple[float, float]]
    tolerance_mm: float
    warnings: tuple[str, ...] = field(default=())
    check: LoadCheck | None = None
    path_mm: float = 0.0


def wait_for(happened: Callable[[], bool], seconds: float) -> bool:
    """Waits until something has happened, at most `seconds`; False if it has not."""
    deadline = time.monotonic() + seconds
    while not happened():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.002)
    return True


class Engine(Protocol):
    """Every call returns at once; effects show in later snapshots."""

    def load(self, path: str, wanted: Callable[[], bool] = lambda: True) -> Job:
        """Compiles a job (may take seconds: call it from a worker). Raises CompileError, no motion starts; UsageError
        where it is no longer `wanted` when it is done."""

    def current_job(self) -> Job | None:
        """The loaded job; a new one where the machine moved or switches changed since it was checked."""

    def search(self, block: str) -> Start:
        """The state before a block of the loaded job ("N120", "57" for a line), from a worker. Raises CompileError."""

    def start_at(self, block: str) -> Job:
        """Loads the job again, to begin at a block (empty: at its top), from a worker. Raises CompileError."""

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

    def set_rapid(self, factor: float) -> None:
        """Rapid override: TROVR is the lower of both while a rapid block is current (design D30)."""

    def set_switches(self, switches: Switches) -> None:
        """Only while no job is under way: the loaded job is compiled again with them before it starts."""

    def seek(self, place: str) -> None:
        """Winds a recording to a time, s ("1:23.5", "83.5", "+5", "-5"), or a block ("N620", "L12" for a line).
        Raises UsageError for any other place, and where no recording is shown."""

    # ---- manual: only while no job is under way and no axis moves

    def jog(self, axis: str, distance: float) -> None:
        """One step of an axis, mm or degrees; dropped while a step is under way."""

    def home(self, axes: Sequence[str]) -> None:
        """Searches the reference of the axes, one after the other."""

    def set_zero(self, axis: str) -> None:
        """Work offset G54 of an axis: its program coordinate is 0 here."""

    def force_input(self, number: int, on: bool) -> None:
        """Makes a simulated input (1 to 16) active or inactive."""

    def release_inputs(self) -> None:
        """No input is forced any more; a reset does this too."""

    # ---- MDI

    def check_mdi(self, text: str) -> None:
        """Checks one block, G-code or (ending with `;`) a rw_SymPas statement, from a worker; `start_mdi` executes it.
        Raises CompileError with lines and columns of the block, UsageError while a job is under way."""

    def start_mdi(self) -> None: ...

    def snapshot(self) -> Snapshot: ...
    def new_deviation(self, since: int) -> tuple[int, NDArray[np.float32]]:
        """Deviation (mm) per path-plot vertex driven since index `since` (NaN: not yet driven), and the new index."""

    def outcome(self) -> Outcome | None:
        """The run that ended last; None before the first, and while it is not yet judged."""

    def service(self) -> Service | None:
        """Registers, tasks and variables; kept up to date while somebody asks. None before the first answer."""

    def close(self) -> None: ...
