"""How true a rw_SymPas job stays to what it spools: a second, identical run, measured against the listing of the first.

Every lane (spooled.py) has a tracker of its own. What is between the spooled moves (direct moves, waits) has no
programmed contour and is not measured; the deviation there counts as 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths as native_paths
from cnc_front.errors import Exit
from cnc_front.execution import End, Happened
from cnc_front.run import Sink, Watcher
from cnc_front.sap_places import Places
from cnc_front.sap_run import SapRun
from cnc_front.schedule import Schedule
from cnc_front.spooled import Lane, Listing, Paths, paths_of


class Feed(Protocol):
    """Gives a tracker its samples; returns the deviation of the load side."""

    def __call__(self, tracker: native_paths.Tracker) -> NDArray[np.float32]: ...


@dataclass(slots=True)
class Measuring:
    """Trackers of the lanes of a run; the first lane is the longest, the one that is plotted."""

    paths: list[native_paths.Path]
    trackers: list[native_paths.Tracker]
    summaries: list[dict[str, Any]] = field(default_factory=list)

    @staticmethod
    def of(lanes: Sequence[tuple[dict[str, Any], list[tuple[int, int, int, bool]]]], options: Any) -> Measuring:
        """From sequences and stretches. Raises ValueError for a listing that is no path."""
        paths = [native_paths.Path(sequence) for sequence, _ in lanes]
        trackers = [native_paths.Tracker(path, **options) for path in paths]
        for tracker, (_, stretches) in zip(trackers, lanes, strict=True):
            tracker.set_stretches(stretches)
        return Measuring(paths, trackers)

    def feed(self, give: Feed) -> NDArray[np.float32]:
        """Measures samples in every lane; the largest deviation of each sample."""
        return reduce(np.maximum, (give(tracker) for tracker in self.trackers))

    def finish(self) -> dict[str, Any]:
        """The figures of all lanes together, under the keys of Tracker.finish."""
        self.summaries = [tracker.finish() for tracker in self.trackers]
        return together(self.summaries)


def together(summaries: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Worst of deviations, sum of lengths, feed figures weighted by time."""
    if len(summaries) == 1:
        return summaries[0]
    main = dict(summaries[0])
    for key in ("setpoint", "actual"):
        main[key] = max((s[key] for s in summaries), key=lambda deviation: deviation["max_mm"])
    for key in ("max_over_pct", "path_change_mm", "velocity_ratio_error_pct", "lag_max_mm", "missing_mm"):
        main[key] = max((s[key] for s in summaries if s[key] is not None), default=None)
    for key in ("path_length_mm", "feed_s", "rapid_s", "standstill_s"):
        main[key] = sum(s[key] for s in summaries)
    reached = [(s["feed_s"], s["programmed_reached_pct"]) for s in summaries if s["programmed_reached_pct"] is not None]
    weight = sum(seconds for seconds, _ in reached)
    main["programmed_reached_pct"] = sum(t * p for t, p in reached) / weight if weight > 0 else None
    main["settling_ok"] = all(s["settling_ok"] in (None, True) for s in summaries)
    pairs = zip(*(s["following_error"] for s in summaries), strict=True)
    main["following_error"] = [max(errors) for errors in pairs]
    main["completed"] = all(s["completed"] for s in summaries)
    return main


@dataclass(slots=True)
class Measured:
    """A job that ran, and what was measured; without a contour only what is said of axes."""

    run: SapRun
    paths: Paths
    schedule: Schedule
    measuring: Measuring
    summary: dict[str, Any] = field(default_factory=dict)
    #: why the listing is no path
    refused: str = ""

    @property
    def has_contour(self) -> bool:
        """Something was spooled, and it is a path."""
        return bool(self.paths.lanes[0].rows) and not self.refused

    @property
    def lanes(self) -> list[Lane]:
        """Lanes in the order of `measuring`."""
        return self.paths.lanes

    @property
    def places(self) -> Places:
        """What the line numbers mean."""
        return self.run.places

    @property
    def measured_s(self) -> float:
        """Machine time on programmed contours: at most that of the run where lanes run side by side."""
        samples = sum(int(s["samples"]) for s in self.measuring.summaries)
        return min(samples, self.run.mcu.samples()) * self.run.sample_time_s


def measured_run(
    make: Callable[[], SapRun], sink: Callable[[Paths], Sink] | None = None, watcher: Watcher | None = None
) -> Measured:
    """Runs the job, and again to measure it against what it has spooled, or where its samples are wanted."""
    first = make()
    nothing = paths_of(Listing(), 0, first.mcu.axis_count())
    idle = _measuring(first, nothing)
    first.sink = _through(idle, None, None)
    first.run()
    if not first.listing.parts and sink is None and watcher is None:
        return Measured(first, nothing, first.options.schedule, idle, idle.finish())
    second, refused = make(), ""
    if first.end is End.INTERRUPTED:  # what ran up to there is measured; a second Ctrl+C ends the process
        second.options = replace(second.options, interrupted=lambda: False)
    paths = paths_of(first.listing, first.mcu.samples(), first.mcu.axis_count())
    try:
        measuring = _measuring(first, paths)
    except ValueError as error:
        refused, paths = str(error), nothing
        measuring = _measuring(first, paths)
    result = Measured(second, paths, first.options.schedule, measuring, refused=refused)
    if watcher is not None:
        watcher.begin(measuring.paths[0], measuring.trackers[0])
    second.sink = _through(measuring, sink(paths) if sink is not None else None, watcher)
    second.run(first.mcu.samples())
    _end_like(second, first)
    result.summary = measuring.finish()
    return result


def _measuring(run: SapRun, paths: Paths) -> Measuring:
    options = {
        "sample_time_s": run.sample_time_s,
        "schedule": list(run.options.schedule),
        "trovrst_s": run.trovrst_s,
    }
    return Measuring.of([(lane.sequence, lane.stretches) for lane in paths.lanes], options)


def _through(
    measuring: Measuring, sink: Sink | None, watcher: Watcher | None
) -> Callable[[native_kernel.Chunk, Happened], None]:
    def take(chunk: native_kernel.Chunk, happened: Happened) -> None:
        deviation = measuring.feed(lambda tracker: tracker.feed(chunk))
        if sink is not None:
            sink.write(chunk, deviation, happened)
        if watcher is not None:
            watcher.add(deviation)

    return take


def _end_like(second: SapRun, first: SapRun) -> None:
    """The second run ends as the first did; a different course would be a fault of ours, never a result."""
    if second.end is End.INTERRUPTED:
        return
    same = second.mcu.samples() == first.mcu.samples() and second.listing.passages == first.listing.passages
    if not same or [t.output for t in second.tasks] != [t.output for t in first.tasks]:
        raise RuntimeError("two runs of the same job differ")
    second.end = first.end
    second.wall_time_s += first.wall_time_s


def exit_of(run: SapRun, *, failed: bool) -> Exit:
    """What the process returns."""
    if run.end is End.INTERRUPTED:
        return Exit.INTERRUPTED
    if run.end is not End.FINISHED:
        return Exit.STOPPED
    return Exit.CHECK_FAILED if failed else Exit.DONE
