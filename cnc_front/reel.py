"""A recording as a film: what does not change while it is shown, an index of it, and the place that is shown.

Nothing is emulated or judged anew: values stand as they were recorded. One chunk is in memory at a time.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths as native_paths
from cnc_front.engine import Job
from cnc_front.errors import UsageError
from cnc_front.jobs import JobSource
from cnc_front.messages import text
from cnc_front.recording import Columns, Recorded, content_of, open_recording
from cnc_front.sap_deliver import lanes_of
from cnc_front.sap_measure import Measuring
from cnc_front.sap_places import Places
from cnc_front.sim_job import CHORD_MM, MAX_POINTS, path_plot

#: Of a job that spools nothing every so many samples are drawn.
EVERY = 16
#: Events stand behind at most so many messages of columns that they belong to.
BETWEEN = 80
#: Bits of the flags of a sample.
MOVING, WAITING, HELD = 1, 4, 8
#: Tasks whose lines stand in Columns["standing"].
TASKS = 4
COLUMNS = ("dp", "load", "rp", "factor", "v_plan", "entry", "flags")


@dataclass(frozen=True, slots=True)
class Index:
    """What reading a recording once has told. `starts`, `lines`: first sample of each stretch of one source line."""

    samples: int
    starts: NDArray[np.int64]
    lines: NDArray[np.int64]
    events: list[dict[str, Any]]
    result: dict[str, Any] | None
    damage: str | None
    #: every EVERYth set point of a job that spools nothing
    points: NDArray[np.float64]

    def sample_of(self, line: int, behind: int) -> int | None:
        """First sample of a source line, the next one behind a sample, else the first of all; None if it never ran."""
        found = self.starts[self.lines == line]
        later = found[found > behind]
        return int(later[0]) if len(later) else int(found[0]) if len(found) else None

    def next_change(self, sample: int) -> int:
        """Where the source line changes behind a sample."""
        place = int(np.searchsorted(self.starts, sample, side="right"))
        return int(self.starts[place]) if place < len(self.starts) else self.samples


def index_of(
    recorded: Recorded,
    lines_of: Callable[[Columns], NDArray[np.int64]],
    axes: Sequence[str],
    sample_s: float,
    *,
    points: bool,
) -> Index:
    """Reads all of a recording; `points`: also the set points."""
    starts, lines, driven = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], []
    samples, last, told = 0, -1, 0
    recent: deque[Columns] = deque(maxlen=BETWEEN)
    for columns in recorded.columns():
        _measured(recorded.events[told:], recent, axes, sample_s)
        told = len(recorded.events)
        recent.append(columns)
        line = lines_of(columns)
        if not len(line):
            continue
        changes = np.flatnonzero(np.diff(line, prepend=last))
        starts.append(changes + samples)
        lines.append(line[changes])
        if points:
            driven.append(columns["dp"][-samples % EVERY :: EVERY])
        samples, last = samples + len(line), int(line[-1])
    _measured(recorded.events[told:], recent, axes, sample_s)
    events = sorted(recorded.events, key=lambda event: (event["t_s"], event["kind"] == "host"))
    path = np.concatenate(driven) if driven else np.zeros((0, 0))
    return Index(samples, np.concatenate(starts), np.concatenate(lines), events, recorded.result, recorded.damage, path)


def _measured(events: list[dict[str, Any]], recent: Iterable[Columns], axes: Sequence[str], sample_s: float) -> None:
    """Gives events of an axis its `following` error and `set_point`. They stand behind the samples they came with."""
    for event in events:
        if event["axis"] not in axes:
            continue
        axis, sample = axes.index(event["axis"]), round(float(event["t_s"]) / sample_s)
        for columns in recent:
            row = sample - columns["first_sample"]
            if 0 <= row < len(columns["flags"]):
                event["set_point"] = float(columns["dp"][row, axis])
                event["following"] = event["set_point"] - float(columns["rp"][row, axis])


class Reel:
    """A recording, read once."""

    def __init__(self, path: str) -> None:
        """Raises CompileError for what is no recording of ours."""
        with content_of(path):
            recorded = open_recording(path)
            self.path, self.metadata, self.modal = path, recorded.metadata, recorded.modal
            self.is_sap = self.metadata.get("language", "din66025") != "din66025"
            self.places = Places.parse(self.metadata["places"]) if self.is_sap else None
            self.machine = native_kernel.Machine.parse(recorded.machine_text.encode(), self.metadata["machine_path"])
            self.sample_s = self.machine.sample_time_us * 1e-6
            self.schedule = tuple((float(t), float(f)) for t, f in json.loads(self.metadata["schedule"]))
            self._lanes = lanes_of(recorded.sequence) if self.is_sap else [(recorded.sequence, None)]
            self.paths = [native_paths.Path(columns) for columns, _ in self._lanes]
            if not any(len(path.blocks()["line"]) for path in self.paths):
                self.paths = []  # nothing was spooled: there is no programmed contour
            self._entries, self._entry_lines = self._commands()
            self.index = index_of(
                recorded, self.lines_of, self.machine.axis_names, self.sample_s, points=not self.paths
            )
            self.line = self.paths[0].polyline(CHORD_MM, MAX_POINTS) if self.paths else _polyline(self.index)
            self.blocks = self.paths[0].blocks() if self.paths else {}
            self.job = self._view(recorded)
            #: path length where each block begins, its command, nominal time where it ends
            self.entries = self.blocks.get("entry", np.zeros(0, np.uint32))
            length, speed = (self.blocks.get(name, np.zeros(0)) for name in ("length_mm", "vl"))
            self.ends_s = np.cumsum(length / np.maximum(speed, 1e-9))
            self.length_mm = self.paths[0].length_mm if self.paths else float(self.line["s_mm"][-1:].sum())
            changes = np.flatnonzero(np.diff(self.line["lines"]))
            #: the vertex at which the block of each vertex ends
            self.ends = np.append(changes, max(len(self.line["lines"]) - 1, 0))

    def _view(self, recorded: Recorded) -> Job:
        names = list(self.machine.axis_names)
        lines = JobSource(self.metadata["job_path"], recorded.job, self.metadata.get("language", "din66025")).text()
        ranges = self.paths[0].extents if self.paths else [(float(c.min()), float(c.max())) for c in self._columns()]
        return Job(
            path=self.path,
            name=Path(self.path).name,
            lines=self.places.labelled(lines) if self.places is not None else lines.splitlines(),
            plot=path_plot(self.line, self.machine, self.modal),
            extents=dict(zip(names, ranges, strict=False)),
            tolerance_mm=float(self.metadata["tolerance_mm"]),
            path_mm=sum(path.length_mm for path in self.paths),
        )

    def _commands(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Numbers of the commands of a rw_SymPas job, rising, and their lines in the text of all tasks."""
        blocks = [path.blocks() for path in self.paths] if self.is_sap else []
        if not blocks:
            return np.zeros(0, np.int64), np.zeros(0, np.int64)
        numbers, lines = (np.concatenate([b[name].astype(np.int64) for b in blocks]) for name in ("entry", "line"))
        order = np.argsort(numbers)
        return numbers[order], lines[order]

    def lines_of(self, columns: Columns) -> NDArray[np.int64]:
        """The source line of each sample; of a rw_SymPas job in the text of all its tasks."""
        line: NDArray[np.int64] = columns["line"].astype(np.int64)
        if not len(self._entries):
            return line
        entry = columns["entry"].astype(np.int64)
        place = np.minimum(np.searchsorted(self._entries, entry), len(self._entries) - 1)
        return np.where(self._entries[place] == entry, self._entry_lines[place], line)

    def _columns(self) -> Iterator[NDArray[np.float64]]:
        return iter(self.index.points.T) if len(self.index.points) else iter(())

    @property
    def first_task(self) -> tuple[int, int]:
        """Its number, and what is added to its lines in the text of all tasks."""
        task = self.places.texts[0].task if self.places is not None else 0
        return task, self.places.first(task) if self.places is not None else 0

    def trackers(self) -> list[native_paths.Tracker]:
        """Fresh ones for all paths, the plotted one first."""
        if self.is_sap and self.paths:
            return Measuring.of(
                [(columns, rows or []) for columns, rows in self._lanes], {"sample_time_s": self.sample_s}
            ).trackers
        return [native_paths.Tracker(path, sample_time_s=self.sample_s) for path in self.paths]

    def modal_at(self, line: int) -> str:
        """The modal state at a source line, as far as it is recorded."""
        place = bisect_right(self.modal, line, key=lambda change: change[0])
        return self.modal[place - 1][1] if place else ""

    def sample_at(self, place: str, now: int, language: str) -> int:
        """The sample of a time ("1:23.5", "83.5", "+5", "-5" s) or block ("N620", "L12"). Raises UsageError."""
        wanted = place.strip().upper().rstrip("S")
        try:
            if wanted[:1] in "+-":
                seconds = now * self.sample_s + float(wanted)
            elif wanted[:1] in "NL":
                return self._block(wanted, now, language)
            else:
                parts = [float(part) for part in wanted.split(":")]
                seconds = sum(part * 60**k for k, part in enumerate(reversed(parts)))
            return min(max(round(seconds / self.sample_s), 0), self.index.samples)
        except (ValueError, OverflowError):
            raise UsageError(text("replay_place", language, text=place.strip()[:20])) from None

    def _block(self, wanted: str, now: int, language: str) -> int:
        line = int(wanted[1:]) if wanted[0] == "L" else self._line_of(int(wanted[1:]))
        found = self.index.sample_of(line, now) if line else None
        if found is None:
            raise UsageError(text("replay_block", language, text=wanted[:20]))
        return min(found + 1, self.index.samples)  # as it begins

    def _line_of(self, number: int) -> int:
        """The source line of a block number; 0 if there is none."""
        for index, line in enumerate(self.job.lines):
            words = line[:40].lstrip(" \t/0123456789").upper()
            digits = words[1:].split("N")[0].lstrip() if words[:1] == "N" else ""
            count = next((k for k, sign in enumerate(digits) if not sign.isdecimal()), len(digits))
            if count and int(digits[:count]) == number:
                return index + 1
        return 0


def _polyline(index: Index) -> dict[str, Any]:
    """The way of the set points of a job that spooled nothing, as toolpaths gives polylines."""
    points = index.points
    stride = max(1, len(points) // MAX_POINTS)
    points = points[::stride]
    if not len(points):
        return {"points": points, "lines": np.zeros(0, np.uint32), "rapid": np.zeros(0, bool), "s_mm": np.zeros(0)}
    samples = np.arange(len(points)) * EVERY * stride
    place = np.maximum(np.searchsorted(index.starts, samples, side="right") - 1, 0)
    way = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1)
    lines = index.lines[place].astype(np.uint32)
    return {"points": points, "lines": lines, "rapid": np.zeros(len(points), bool), "s_mm": np.cumsum(way)}


class Film:
    """A reel from its first sample on; `position` samples have been shown."""

    def __init__(self, reel: Reel) -> None:
        """Raises CompileError where the file is there no more."""
        self.reel = reel
        self.trackers = reel.trackers()
        if self.trackers:
            self.trackers[0].watch(reel.line["s_mm"])
        self.position, self.is_over = 0, False
        self.max_mm, self.max_line = 0.0, 0
        self._last_line = 0
        #: what stood in the controller when it was last told
        self.standing: list[int] = []
        self._chunk: Columns | None = None  # the chunk being shown, and the next sample of it
        self._lines = np.zeros(0, np.int64)
        self._at = 0
        self._chunks = open_recording(reel.path).columns()

    def advance(self, samples: int) -> None:
        """Shows the next samples. Raises CompileError for senseless columns."""
        with content_of(self.reel.path):
            while samples > 0 and not self.is_over:
                if self._chunk is None or self._at >= len(self._chunk["flags"]):
                    if not self._next():
                        return
                    continue
                assert self._chunk is not None
                count = min(samples, len(self._chunk["flags"]) - self._at)
                self._measure(self._chunk, slice(self._at, self._at + count))
                self._at += count
                self.position += count
                samples -= count

    def _next(self) -> bool:
        chunk = next(self._chunks, None)
        if chunk is None:
            self.is_over = True
            return False
        self._chunk, self._at, self._lines = chunk, 0, self.reel.lines_of(chunk)
        if len(chunk["standing"]):
            self.standing = chunk["standing"].tolist()
        return True

    def _measure(self, chunk: Columns, part: slice) -> None:
        columns = [np.ascontiguousarray(chunk[name][part]) for name in COLUMNS]
        for tracker in self.trackers:
            tracker.feed_columns(self.position, *columns)
        lines = self._lines[part]
        moving = np.flatnonzero(lines)
        if len(moving):
            self._last_line = int(lines[moving[-1]])
        deviation = chunk["deviation_mm"][part]
        worst = int(np.argmax(deviation))
        if float(deviation[worst]) > self.max_mm:
            self.max_mm, self.max_line = float(deviation[worst]), int(lines[worst])

    def value(self, name: str) -> Any:
        """The sample shown last, of a column; None before the first."""
        return self._chunk[name][self._at - 1] if self._chunk is not None and self._at else None

    @property
    def line(self) -> int:
        """The source line: of the motion, or the last one before; of a rw_SymPas job the one that its first task
        executes between motions."""
        moving = int(self._lines[self._at - 1]) if self._at else 0
        if moving or not self.reel.is_sap or not self.standing or not self.position:
            return moving or self._last_line
        task, first = self.reel.first_task
        line = self.standing[2 * len(self.reel.machine.axis_names) + task]
        return first + line if line else 0

    def spoolers(self) -> tuple[list[float], int] | None:
        """Share of each axis' spooler that is used, and the commands that wait in the fullest; None: not recorded."""
        axes = len(self.reel.machine.axis_names)
        if not self.standing:
            return None
        memory = self.reel.machine.spool_memory_bytes
        return [used / memory for used in self.standing[0 : 2 * axes : 2]], max(self.standing[1 : 2 * axes : 2])

    @property
    def speed(self) -> float:
        """Spindle speed."""
        return float(np.array(self.standing[-2:], np.uint32).view(np.float64)[0]) if self.standing else 0.0

    def driven(self) -> tuple[int, NDArray[np.float32]]:
        """How many vertices are done, and the largest deviation up to each, mm."""
        vertices = len(self.reel.line["lines"])
        if not self.trackers:
            share = self.position / max(self.reel.index.samples, 1)
            return int(share * vertices), np.zeros(vertices, np.float32)
        values, approaching = self.trackers[0].watched()
        return (vertices if self.is_over and self.is_complete else approaching), values

    @property
    def is_complete(self) -> bool:
        """The recorded run came to its end."""
        return (self.reel.index.result or {}).get("status") == "completed" and not self.reel.index.damage
