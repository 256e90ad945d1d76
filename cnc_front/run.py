"""A dry run from job to result: the main job of the product, top to bottom."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths as native_paths
from cnc_front.execution import End, Execution, Happened
from cnc_front.jobs import CompiledJob, StimulusFile
from cnc_front.schedule import Schedule
from cnc_front.streaming import EXECUTES, StreamedJob

#: Samples per chunk: large enough that Python costs nothing, small enough to answer Ctrl+C within a blink.
CHUNK = 1 << 16
#: The same for a recording, which tells at the end of each chunk what stands in the spoolers.
RECORDED = 2000


class Sink(Protocol):
    """Takes the samples of a run as they come, e.g. a recording. Called from another thread than the run's."""

    def write(self, chunk: native_kernel.Chunk, deviation_mm: NDArray[np.float32], happened: Happened) -> None:
        """One chunk, the deviation of the load side per sample, and what was logged since the last."""


class Watcher(Protocol):
    """Looks at what the tracker measures, e.g. for a report."""

    def begin(self, path: native_paths.Path, tracker: native_paths.Tracker) -> None:
        """Before the first sample."""

    def add(self, deviation_mm: NDArray[np.float32]) -> None:
        """The deviation of the load side for the next samples."""


@dataclass(frozen=True, slots=True)
class RunOptions:
    """What a run may vary beside the job and the machine."""

    schedule: Schedule = ((0.0, 1.0),)
    max_time_s: float = 86400.0
    #: asked after every chunk: the user wants the run to end here
    interrupted: Callable[[], bool] = lambda: False
    #: told after every chunk how far the run is
    progress: Callable[[Execution], None] = lambda execution: None
    #: override factors of a sweep beside the run itself
    sweep: tuple[float, ...] = ()
    #: samples.parquet beside the report
    samples: bool = False
    #: what the world outside does
    stimulus: StimulusFile | None = None
    #: resources that are recorded every sample (motion_kernel.scanner)
    scan: tuple[str, ...] = ()
    #: collect what the time-optimal bound needs
    time_optimal: bool = False


@dataclass(slots=True)
class RunResult:
    """What a run measured. `summary` is that of toolpaths.Tracker.finish."""

    job: CompiledJob | StreamedJob
    options: RunOptions
    execution: Execution
    summary: dict[str, Any]
    #: None for a streamed job: its path is behind
    path: native_paths.Path | None
    tracker: native_paths.Tracker
    wall_time_s: float

    @property
    def status(self) -> str:
        """completed, stopped (fault, time limit, interrupted) or failed (runtime error)."""
        if self.execution.end is End.FINISHED:
            return "completed"
        return "failed" if self.execution.end is End.TASK_ERROR else "stopped"


def dry_run(
    job: CompiledJob | StreamedJob, options: RunOptions, sink: Sink | None = None, watcher: Watcher | None = None
) -> RunResult:
    """Runs a job to its end, or until something stops it, and measures it against its path."""
    begun = time.monotonic()
    stimulus = options.stimulus.stimulus if options.stimulus else None
    path = native_paths.Path(job.program.sequence()) if isinstance(job, CompiledJob) else None
    execution = Execution(job, options.schedule, options.max_time_s, stimulus=stimulus, scan=options.scan)
    tracker = _tracker(job, path, options)
    if watcher is not None and path is not None:
        watcher.begin(path, tracker)

    def measure(chunk: native_kernel.Chunk, happened: Happened) -> None:
        deviation = tracker.feed(chunk)
        if sink is not None:
            sink.write(chunk, deviation, happened)
        if watcher is not None:
            watcher.add(deviation)

    # the controller runs ahead by one chunk while the one before is measured and written
    with ThreadPoolExecutor(1, "measure") as worker:
        measured: Future[None] | None = None
        samples = CHUNK if sink is None else RECORDED
        while (chunk := execution.advance(samples)) is not None:
            happened = execution.happened()
            if measured is not None:
                measured.result()
            measured = worker.submit(measure, chunk, happened) if len(chunk) or happened else None
            options.progress(execution)
            if isinstance(job, StreamedJob):
                execution.forget()
            if execution.end is None and options.interrupted():
                execution.end = End.INTERRUPTED
            if execution.end is None and time.monotonic() - begun > options.max_time_s:
                execution.end = End.TIME_LIMIT
        if measured is not None:
            measured.result()
    if isinstance(job, StreamedJob):
        job.program.send_away(EXECUTES)
    summary = tracker.finish()
    return RunResult(job, options, execution, summary, path, tracker, time.monotonic() - begun)


def _tracker(
    job: CompiledJob | StreamedJob, path: native_paths.Path | None, options: RunOptions
) -> native_paths.Tracker:
    machine = job.machine.machine
    sample_time_s, schedule = machine.sample_time_us * 1e-6, list(options.schedule)
    if isinstance(job, StreamedJob):
        return native_paths.Tracker.growing(
            job.program, sample_time_s=sample_time_s, schedule=schedule, trovrst_s=machine.trovrst_s
        )
    assert path is not None
    return native_paths.Tracker(
        path,
        sample_time_s=sample_time_s,
        schedule=schedule,
        trovrst_s=machine.trovrst_s,
        passages=options.time_optimal,
    )
