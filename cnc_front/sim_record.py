"""The recording of a run of the terminal: as of `run --record`, with what the operator did at its time."""

from __future__ import annotations

from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.deliver import run_metadata
from cnc_front.execution import Happened, LogEntry
from cnc_front.jobs import shown
from cnc_front.recording import RecordingSink
from cnc_front.run import RECORDED, RunOptions
from cnc_front.sim_job import LoadedJob

#: Columns of a chunk as the writer takes them.
_MATRICES, _NUMBERS, _WORDS = ("dp", "load", "rp"), ("factor", "v_plan"), ("line", "entry", "flags")


def next_file(folder: Path, job: str) -> Path:
    """The first free name for a recording of a job: part-1.mcap, part-2.mcap ..."""
    names = (folder / f"{Path(job).stem}-{n}.mcap" for n in count(1))
    return next(name for name in names if not name.exists())


class RunRecording:
    """Gathers the short slices of a paced run, since a message for each would be larger than what it holds."""

    def __init__(self, folder: Path, loaded: LoadedJob, override: float) -> None:
        """Creates the file; raises OSError."""
        job = loaded.job
        options = RunOptions(schedule=((0.0, override),), stimulus=loaded.stimulus_file)
        metadata = run_metadata(job, options, job.machine.machine.tolerance_mm, "machine")
        self.path = next_file(folder, job.source.path)
        self._sink = RecordingSink(self.path, job, metadata, modal=job.facts["modal"])
        self._chunks: list[tuple[native_kernel.Chunk, NDArray[np.float32]]] = []
        self._samples = 0
        self._happened: list[Any] = []

    def write(self, chunk: native_kernel.Chunk, deviation_mm: NDArray[np.float32], happened: Happened) -> None:
        """A slice; raises OSError, maybe for an earlier one."""
        if len(chunk):
            self._chunks.append((chunk, deviation_mm))
            self._samples += len(chunk)
        self._happened += happened
        if self._samples >= RECORDED:
            self._flush()

    def did(self, t_s: float, name: str, value: int) -> None:
        """What the operator did."""
        self._happened.append(LogEntry(t_s, "operator", "", name, True, 0, value))

    def _flush(self) -> None:
        if self._chunks:
            chunks = [chunk for chunk, _ in self._chunks]

            def joined(name: str) -> NDArray[Any]:
                return np.concatenate([getattr(chunk, name) for chunk in chunks])

            self._sink.write_gathered(
                (chunks[0].first_sample, chunks[-1].standing),
                [joined(name) for name in _MATRICES],
                [joined(name) for name in _NUMBERS],
                [joined(name) for name in _WORDS],
                np.concatenate([deviation for _, deviation in self._chunks]),
            )
        self._sink.tell(tuple(self._happened))
        self._chunks, self._samples, self._happened = [], 0, []

    def finish(self, run_object: dict[str, Any]) -> None:
        """Adds the result and closes the file; raises OSError."""
        self._flush()
        self._sink.add_commands()
        self._sink.finish(run_object)

    @property
    def name(self) -> str:
        """For people, and for `files.recording`."""
        return shown(self.path)
