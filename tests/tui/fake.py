"""An engine that does what a test says: it obeys at once, moves only when told, and notes every call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import AxisValues, Job, Mode, PathPlot, Snapshot, State, Switches
from cnc_front.errors import CompileError
from cnc_front.outcome import Outcome
from cnc_front.search import Start
from cnc_front.service import Service

PROGRAM = """\
(BRACKET, finish)
N550 G0 X52 Y12
N560 G1 X+50.0000 Y+8.0000 F2400
N570 G1 X+50.0000 Y+4.0000
N580 G2 X+49.9000 Y-4.0000 I-2 J0
N590 G1 X+49.0000 Y-8.0000
N600 (finish pass)
N610 G1 X+49.9000 Y-10.0000
N620 G1 X+48.0000 Y-12.6000
N630 G1 X+44.0000
N640 M8
/N650 G0 Z+5.0000
N660 G0 X0 Y0
N670 G1 X+40.0000 Y-12.0000
N680 M30
"""


def make_job(lines: list[str] | None = None, points: int = 401) -> Job:
    """An ellipse of known size; the first tenth of its vertices belongs to line 5."""
    turn = np.linspace(0, 2 * np.pi, points)
    place = np.column_stack((50 * np.cos(turn), 30 * np.sin(turn), np.zeros(points)))
    owner = np.where(np.arange(points) < points // 10, 5, 9).astype(np.uint32)
    plot = PathPlot(place, owner, np.zeros(points, bool))
    extents = {"X": (-50.0, 50.0), "Y": (-30.0, 30.0), "Z": (-2.0, 5.0)}
    return Job("bracket_07.nc", "bracket_07.nc", lines or PROGRAM.splitlines(), plot, extents, 0.01, path_mm=1940.8)


START: Start = {
    "line": 7,
    "modal": "G1 G17 G90 G21 G94 G40 G49 G64 G54",
    "machine": {"X": 49.0, "Y": -8.0, "Z": -2.0},
    "program": {"X": 49.0, "Y": -8.0, "Z": -2.0},
    "shift": {"X": 0.0, "Y": 0.0, "Z": 0.0},
    "in_spindle": 3,
    "tool": 3,
    "tool_length": 0.0,
    "spindle": 3,
    "speed": 12000.0,
    "flood": True,
    "mist": False,
    "feed": 2400.0,
}


def axis(name: str, actual: float, to_go: float, following_um: float, fill: float) -> AxisValues:
    """An axis in mm with an mpe of 0.02 mm."""
    following = following_um / 1000
    bits = ("pe", "cl", "referenced")
    return AxisValues(name, "mm", actual, actual + following, to_go, following, 0.02, True, fill, bits)


AXES = (
    axis("X", 49.917, 2.001, 4.2, 0.81),
    axis("Y", -12.62, 0.0, -1.1, 0.81),
    axis("Z", -2.0, 0.0, 0.0, 0.04),
)

IDLE = Snapshot(
    State.NO_JOB, "", 0.0, 0, (), 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, None, 0.0, 0.0, 0, 0.0, "", 0, "", "", 1.0, False
)
RUNNING: dict[str, Any] = {
    "state": State.RUNNING,
    "machine_time_s": 49.0,
    "time_total_s": 78.0,
    "line": 9,
    "axes": AXES,
    "feed_programmed": 2400.0,
    "feed_actual": 2398.0,
    "path_done_mm": 1204.3,
    "path_total_mm": 1940.8,
    "deviation_now_mm": 0.0031,
    "deviation_max_mm": 0.0118,
    "deviation_max_line": 5,
    "spool_empty_s": 6.4,
    "modal": "G1 G17 G90 G54 G40",
    "tool": 3,
    "spindle": "M3 S12000",
    "coolant": "M8",
    "speed_factor": 50.0,
}


@dataclass
class FakeEngine:
    """Implements the Engine protocol. `now` is what it reports; `calls` what it was asked for."""

    now: Snapshot = IDLE
    job: Job = field(default_factory=make_job)
    driven: NDArray[np.float32] = field(default_factory=lambda: np.zeros(0, np.float32))
    calls: list[str] = field(default_factory=list)
    ended: Outcome | None = None
    registers: Service | None = None
    deaf: bool = False  # notes what was asked for, but nothing changes

    def show(self, **values: Any) -> None:
        """Reports other values from now on."""
        self.now = replace(self.now, **values)

    def run_half(self) -> None:
        """In the middle of the job: two thirds of the path driven, one place beyond the tolerance of 10 um."""
        values = np.full(self.job.plot.points.shape[0] * 2 // 3, 0.002, np.float32)
        values[30:60], values[36:40] = 0.007, 0.0118
        self.driven = values
        self.show(**RUNNING)

    def _did(self, call: str, **values: Any) -> None:
        self.calls.append(call)
        if not self.deaf:
            self.show(**values)

    def load(self, path: str, wanted: Callable[[], bool] = lambda: True) -> Job:
        self.calls.append(f"load {path}")
        if path.endswith("bad.nc"):
            raise CompileError([Diagnostic(path, 4, 11, 12, "GC801", "axis W is not configured", "choose a machine")])
        self.show(state=State.READY, path_total_mm=1940.8, axes=AXES, revision=self.now.revision + 1)
        return self.job

    def current_job(self) -> Job | None:
        return self.job if self.now.revision else None

    def seek(self, place: str) -> None:
        self.calls.append(f"seek {place}")

    def search(self, block: str) -> Start:
        self.calls.append(f"search {block}")
        if block == "1":
            raise CompileError([Diagnostic("bracket_07.nc", 1, 1, 2, "GC617", "line 1 is not executed", "")])
        return START

    def start_at(self, block: str) -> Job:
        self.calls.append(f"start at {block}")
        self.show(revision=self.now.revision + 1, start_line=7 if block else 0)
        return self.job

    def set_rapid(self, factor: float) -> None:
        self._did(f"rapid {factor:g}", rapid_set=factor)

    def set_switches(self, switches: Switches) -> None:
        on = [name for name in ("optional_stop", "skip", "dry_run", "program_test") if getattr(switches, name)]
        self._did(f"switches {' '.join(on)}".strip(), switches=switches)

    def jog(self, axis: str, distance: float) -> None:
        self._did(f"jog {axis} {distance:g}", mode=Mode.MANUAL)

    def home(self, axes: Sequence[str]) -> None:
        self._did(f"home {' '.join(axes)}", mode=Mode.MANUAL)

    def set_zero(self, axis: str) -> None:
        self._did(f"zero {axis}")

    def force_input(self, number: int, on: bool) -> None:
        mask = 1 << (number - 1)
        self._did(
            f"input {number} {on}", inputs=self.now.inputs | mask if on else self.now.inputs & ~mask, forced=(number,)
        )

    def release_inputs(self) -> None:
        self._did("release", forced=())

    def check_mdi(self, text: str) -> None:
        self.calls.append(f"check {text}")
        if "Q" in text:
            raise CompileError(
                [Diagnostic("MDI", 1, text.index("Q") + 1, 9, "GC214", "address Q is not used", "drop it")]
            )
        self.show(mdi=text)

    def start_mdi(self) -> None:
        self._did(f"mdi {self.now.mdi}", state=State.RUNNING, mode=Mode.MDI, mdi="")

    def start(self) -> None:
        self._did("start", state=State.RUNNING)

    def hold(self) -> None:
        moves = self.now.state in (State.RUNNING, State.WAITING)
        self._did("hold", **({"state": State.HOLD, "why": "hold"} if moves else {}))

    def resume(self) -> None:
        self._did("resume", state=State.RUNNING)

    def step(self) -> None:
        self._did("step", state=State.STEP, single_block=True)

    def reset(self) -> None:
        self._did("reset", state=State.ABORTED)

    def set_override(self, factor: float) -> None:
        self._did(f"override {factor:g}", override_set=factor, override_effective=factor)

    def set_single_block(self, on: bool) -> None:
        self._did(f"single {on}", single_block=on)

    def set_speed(self, factor: float) -> None:
        self._did(f"speed {factor:g}", speed_factor=factor)

    def snapshot(self) -> Snapshot:
        return self.now

    def new_deviation(self, since: int) -> tuple[int, NDArray[np.float32]]:
        return len(self.driven), self.driven[since if since <= len(self.driven) else 0 :]

    def outcome(self) -> Outcome | None:
        return self.ended

    def service(self) -> Service | None:
        return self.registers

    def close(self) -> None:
        self.calls.append("close")
