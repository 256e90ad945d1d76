"""Plays a recording in the terminal: an Engine that reads columns instead of moving a machine. Read-only.

Nothing is emulated or judged anew: values stand as they were recorded. One chunk is in memory at a time.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths as native_paths
from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import AxisValues, Job, Snapshot, State, Switches, wait_for
from cnc_front.errors import CompileError, UsageError
from cnc_front.jobs import JobSource
from cnc_front.messages import text
from cnc_front.outcome import Outcome
from cnc_front.recording import Columns, Recorded, content_of, open_recording
from cnc_front.search import Start
from cnc_front.service import Service
from cnc_front.sim_job import CHORD_MM, MAX_POINTS, path_plot

#: Wall seconds between steps, and the largest step that a slow machine catches up.
TICK_S, LAG_S = 0.01, 0.25
#: Samples per step without pacing.
SLICE = 8192
#: Bit of the flags of a sample: waits (dwell, input).
WAITING, MOVING = 4, 1


class Film:
    """A recording from its first sample on; `position` samples have been shown."""

    def __init__(self, path: str) -> None:
        """Raises CompileError for what is no recording of a part program."""
        with content_of(path):
            self.recorded: Recorded = open_recording(path)
            metadata = self.recorded.metadata
            if metadata.get("language", "din66025") != "din66025":
                hint = "cnc-front report shows it"
                message = "recordings of rw_SymPas jobs cannot be replayed"
                raise CompileError([Diagnostic(path, 1, 1, 1, "CF401", message, hint)])
            parsed = native_kernel.Machine.parse(self.recorded.machine_text.encode(), metadata["machine_path"])
            self.machine = parsed
            self.sample_s = parsed.sample_time_us * 1e-6
            self.path = native_paths.Path(self.recorded.sequence)
            self.line = self.path.polyline(CHORD_MM, MAX_POINTS)
            self.tracker = native_paths.Tracker(self.path, sample_time_s=self.sample_s)
            self.tracker.watch(self.line["s_mm"])
            blocks = self.path.blocks()
            self.entries, self.feeds = blocks["entry"], blocks["vl"]
            self.job = self._view(path)
        self.position, self.is_over = 0, False
        self.max_mm, self.max_line = 0.0, 0
        self.last: Columns | None = None  # the chunk being shown, and the next sample of it
        self.at = 0
        self._chunks: Iterator[Columns] = self.recorded.columns()
        lines = self.line["lines"]
        changes = np.flatnonzero(np.diff(lines)) if len(lines) else np.zeros(0, np.int64)
        #: the vertex at which the block of each vertex ends
        self.ends = np.append(changes, max(len(lines) - 1, 0))

    def _view(self, path: str) -> Job:
        names = list(self.machine.axis_names)
        source = JobSource(self.recorded.metadata["job_path"], self.recorded.job, "din66025")
        return Job(
            path=path,
            name=Path(path).name,
            lines=source.text().splitlines(),
            plot=path_plot(self.line, self.machine),
            extents=dict(zip(names, self.path.extents, strict=True)),
            tolerance_mm=float(self.recorded.metadata["tolerance_mm"]),
        )

    def advance(self, samples: int) -> None:
        """Shows the next samples. Raises CompileError for senseless columns."""
        with content_of(self.job.path):
            while samples > 0 and not self.is_over:
                if self.last is None or self.at >= len(self.last["flags"]):
                    chunk = next(self._chunks, None)
                    if chunk is None:
                        self.is_over = True
                        return
                    self.last, self.at = chunk, 0
                    continue
                count = min(samples, len(self.last["flags"]) - self.at)
                self._measure(slice(self.at, self.at + count))
                self.at += count
                self.position += count
                samples -= count

    def _measure(self, part: slice) -> None:
        assert self.last is not None
        names = ("dp", "load", "rp", "factor", "v_plan", "entry", "flags")
        columns = {name: np.ascontiguousarray(self.last[name][part]) for name in names}
        self.tracker.feed_columns(self.position, *(columns[name] for name in names))
        deviation = self.last["deviation_mm"][part]
        worst = int(np.argmax(deviation))
        if float(deviation[worst]) > self.max_mm:
            self.max_mm, self.max_line = float(deviation[worst]), int(self.last["line"][part][worst])

    def value(self, name: str) -> Any:
        """The sample shown last, of a column."""
        return self.last[name][self.at - 1] if self.last is not None and self.at else None

    def driven(self) -> tuple[int, NDArray[np.float32]]:
        """How many vertices are done, and the largest deviation up to each, mm."""
        values, approaching = self.tracker.watched()
        return approaching, values


class ReplayEngine:
    """The Engine protocol of cnc_front.engine on a recording. Whatever would move a machine is refused."""

    def __init__(self, path: str, *, language: str = "en", speed: float = 1.0) -> None:
        """Opens the recording; raises CompileError."""
        self._path, self._language, self._speed = path, language, max(0.0, speed)
        self._lock = threading.Lock()
        self._film = Film(path)
        self._state, self._message, self._revision = State.READY, "", 1
        self._snapshot = self._look()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._work, name="replay", daemon=True)
        self._thread.start()

    # ---- what may be done

    def load(self, path: str) -> Job:
        """The recording from its beginning; raises UsageError for anything else."""
        if path != self._path:
            raise UsageError(text("replay_only", self._language))
        self.reset()
        return self._film.job

    def current_job(self) -> Job | None:
        """The recorded program."""
        return self._film.job

    def start(self) -> None:
        """Plays; from the beginning when it is over."""
        with self._lock:
            if self._state not in (State.DONE, State.ABORTED) or self._rewind():
                self._set(State.RUNNING)

    def hold(self) -> None:
        """Pauses."""
        with self._lock:
            if self._state in (State.RUNNING, State.WAITING):
                self._set(State.HOLD)

    def resume(self) -> None:
        """Plays on."""
        self.start()

    def reset(self) -> None:
        """Back to the beginning."""
        with self._lock:
            if self._rewind():
                self._set(State.READY)

    def set_speed(self, factor: float) -> None:
        """Recorded seconds per wall second; 0 plays as fast as possible."""
        with self._lock:
            self._speed = max(0.0, factor)
            self._snapshot = self._look()

    # ---- what is refused

    def _refuse(self, *_: object) -> None:
        with self._lock:
            self._message = text("replay_only", self._language)
            self._snapshot = self._look()

    def step(self) -> None:
        """Refused."""
        self._refuse()

    def set_override(self, factor: float) -> None:
        """Refused."""
        self._refuse()

    def set_rapid(self, factor: float) -> None:
        """Refused."""
        self._refuse()

    def set_single_block(self, on: bool) -> None:
        """Refused."""
        self._refuse()

    def set_switches(self, switches: Switches) -> None:
        """Refused."""
        self._refuse()

    def jog(self, axis: str, distance: float) -> None:
        """Refused."""
        self._refuse()

    def home(self, axes: Sequence[str]) -> None:
        """Refused."""
        self._refuse()

    def set_zero(self, axis: str) -> None:
        """Refused."""
        self._refuse()

    def force_input(self, number: int, on: bool) -> None:
        """Refused."""
        self._refuse()

    def start_mdi(self) -> None:
        """Refused."""
        self._refuse()

    def check_mdi(self, block: str) -> None:
        """Raises UsageError."""
        raise UsageError(text("replay_only", self._language))

    def search(self, block: str) -> Start:
        """Raises UsageError."""
        raise UsageError(text("replay_only", self._language))

    def start_at(self, block: str) -> Job:
        """Raises UsageError."""
        raise UsageError(text("replay_only", self._language))

    # ---- what is shown

    def snapshot(self) -> Snapshot:
        """The sample shown last."""
        return self._snapshot

    def new_deviation(self, since: int) -> tuple[int, NDArray[np.float32]]:
        """As Engine says."""
        with self._lock:
            reached, values = self._film.driven()
        return reached, values[since if since <= reached else 0 : reached]

    def outcome(self) -> Outcome | None:
        """None: nothing is run or judged."""
        return None

    def service(self) -> Service | None:
        """None: there is no controller."""
        return None

    def wait(self, seconds: float, until: Callable[[Snapshot], bool]) -> bool:
        """Waits until a snapshot fulfils `until`, at most `seconds`."""
        return wait_for(lambda: until(self._snapshot), seconds)

    def close(self) -> None:
        """Ends the thread."""
        self._closing.set()
        self._thread.join(timeout=5.0)

    # ---- the thread

    def _work(self) -> None:
        before, owed = time.monotonic(), 0.0
        while not self._closing.wait(TICK_S):
            now = time.monotonic()
            passed, before = min(now - before, LAG_S), now
            with self._lock:
                if self._state not in (State.RUNNING, State.WAITING):
                    owed = 0.0
                    continue
                owed += passed * self._speed / self._film.sample_s
                samples = int(owed) if self._speed else SLICE
                owed = owed - samples if self._speed else 0.0
                self._play(samples)

    def _play(self, samples: int) -> None:
        film = self._film
        try:
            film.advance(samples)
        except CompileError as error:
            self._set(State.ABORTED, error.diagnostics[0].message)
            return
        if film.is_over:
            result = film.recorded.result or {"status": "failed"}
            cut = film.recorded.damage or result.get("status") in ("stopped", "failed")
            note = text("replay_cut", self._language, reason=film.recorded.damage or "") if cut else ""
            self._set(State.ABORTED if cut else State.DONE, note)
        else:
            flags = int(film.value("flags") or 0)
            self._set(State.WAITING if flags & WAITING and not flags & MOVING else State.RUNNING)

    def _rewind(self) -> bool:
        """To the first sample; False (and said) where the file is there no more."""
        if not self._film.position:
            return True
        try:
            self._film = Film(self._path)
        except (CompileError, OSError) as error:
            reason = error.diagnostics[0].message if isinstance(error, CompileError) else str(error)
            self._set(State.ABORTED, reason)
            return False
        self._revision += 1
        return True

    def _set(self, state: State, message: str = "") -> None:
        self._state, self._message = state, message
        self._snapshot = self._look()

    def _look(self) -> Snapshot:
        film, waits = self._film, self._state is State.WAITING
        entry = int(film.value("entry") or 0)
        place = int(np.searchsorted(film.entries, entry))
        programmed = float(film.feeds[place]) * 60 if entry and place < len(film.feeds) else 0.0
        factor = film.value("factor")
        effective = 1.0 if factor is None else float(factor)
        return replace(
            self._empty(),
            why={State.WAITING: "dwell", State.HOLD: "hold"}.get(self._state, ""),
            machine_time_s=film.position * film.sample_s,
            time_total_s=(film.recorded.result or {}).get("machine_time_s"),
            line=0 if waits else int(film.value("line") or 0),
            axes=self._axes(),
            feed_programmed=programmed,
            feed_actual=float(film.value("v_plan") or 0.0) * effective * 60,  # v_plan is nominal
            override_set=effective,
            override_effective=effective,
            path_done_mm=self._done_mm(),
            deviation_now_mm=float(film.value("deviation_mm") or 0.0),
            deviation_max_mm=film.max_mm,
            deviation_max_line=film.max_line,
        )

    def _empty(self) -> Snapshot:
        total = self._film.path.length_mm
        return Snapshot(
            self._state, "", 0.0, 0, (), 0.0, 0.0, 1.0, 1.0, 0.0, total, None, 0.0, 0.0, 0, 0.0, "", 0, "", "",
            self._speed, False, self._message, revision=self._revision, replay=True,
        )  # fmt: skip

    def _done_mm(self) -> float:
        film = self._film
        if self._state is State.DONE:
            return film.path.length_mm
        place = film.value("dp")
        _, next_vertex = film.tracker.watched()
        if place is None or next_vertex >= len(film.line["s_mm"]):
            return 0.0 if place is None else film.path.length_mm
        left = float(np.linalg.norm(film.line["points"][next_vertex] - place))
        return max(0.0, float(film.line["s_mm"][next_vertex]) - left)

    def _axes(self) -> tuple[AxisValues, ...]:
        film, machine = self._film, self._film.machine
        actual, command = film.value("rp"), film.value("dp")
        points = film.line["points"]
        if actual is None or command is None:
            actual = command = points[0] if len(points) else np.zeros(len(machine.axis_names))
        target = command
        if len(points):
            vertex = min(film.tracker.watched()[1], len(points) - 1)
            target = points[film.ends[np.searchsorted(film.ends, vertex)]]
        rows = zip(machine.axis_names, machine.units, actual, command, target, machine.mpe, strict=True)
        return tuple(
            AxisValues(name, unit, float(a), float(c), float(t - c), float(c - a), mpe, True, 0.0, ())
            for name, unit, a, c, t, mpe in rows
        )
