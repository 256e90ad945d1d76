"""Recordings of runs in MCAP (design 3.5): written as the run goes on, read back for reports.

Layout and topics: cnc_front/recording/src/lib.rs. The stock `mcap` readers and Foxglove read them as they are.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import gcode as native_gcode
from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import recording as native
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.execution import Happened, LogEntry
from cnc_front.jobs import MachineFile, check_held

Columns = dict[str, Any]
#: Keys of the run object that differ between two runs of the same input.
VOLATILE = ("wall_time_s", "files")
JOB, MACHINE, SEQUENCE, RESULT, MODAL = "job", "machine.toml", "sequence.npz", "result.json", "modal.npz"


#: Motion commands in an attachment of their columns: `sequence.npz`, `sequence.1.npz` and so on.
PIECE = 1 << 16
#: Changes of the modal state that a recording holds; of a program with more of them it holds none.
MOST_CHANGES = native_gcode.MOST_CHANGES


class Listed(Protocol):
    """What knows the motion commands of a job."""

    def pieces(self, rows: int) -> Iterator[dict[str, NDArray[Any]]]:
        """Columns of toolpaths.Path, so many rows each; one piece at least."""


class Source(Protocol):
    """The text of a job."""

    @property
    def content(self) -> bytes | str:
        """Its bytes, or the path of its file."""


class Recordable(Protocol):
    """A job that can be recorded (CompiledJob, StreamedJob)."""

    @property
    def source(self) -> Source: ...
    @property
    def machine(self) -> MachineFile: ...
    @property
    def program(self) -> Listed: ...


class RecordingSink:
    """Writes a run into a recording. A run that is cut off leaves a file that can still be read."""

    def __init__(
        self,
        path: Path,
        job: Recordable,
        metadata: dict[str, str],
        more: list[tuple[str, str, bytes]] | None = None,
        scan: Sequence[str] = (),
        modal: Sequence[tuple[int, str]] = (),
    ) -> None:
        """Creates the file, with `more` attachments (name, media type, bytes), a topic for scanned resources, and the
        changes of the modal state by source line; raises OSError."""
        machine = job.machine.machine
        self._pieces = iter(job.program.pieces(PIECE))
        self._written = 0
        attachments = [
            (JOB, "text/plain", job.source.content),
            (MACHINE, "application/toml", job.machine.text.encode()),
            *filter(None, [self._piece()]),
            *([(MODAL, "application/x-npz", _pack_modal(modal))] if 0 < len(modal) <= MOST_CHANGES else []),
            *(more or []),
        ]
        self.path = path
        self._writer = native.Writer(
            path,
            list(machine.axis_names),
            machine.sample_time_us * 1e-6,
            attachments,
            metadata,
            machine.resolution,
            list(scan),
        )

    def _piece(self) -> tuple[str, str, bytes] | None:
        """The next piece of the sequence as an attachment."""
        piece = next(self._pieces, None)
        if piece is None:
            return None
        name = _piece_name(self._written)
        self._written += 1
        return name, "application/x-npz", _pack(piece)

    def add_commands(self, last: int | None = None) -> None:
        """Writes motion commands up to number `last` from 1, or all of them, as far as they are not there."""
        while (last is None or self._written * PIECE < last) and (piece := self._piece()) is not None:
            self._writer.attach(piece)

    def write(self, chunk: native_kernel.Chunk, deviation_mm: NDArray[np.float32], happened: Happened) -> None:
        """One chunk and the deviation of its load side per sample, and the events since the last one."""
        if len(chunk):
            self.add_commands(int(chunk.entry.max()))
            self._writer.write(chunk, deviation_mm)
        self.tell(happened)

    def write_gathered(
        self,
        place: tuple[int, Sequence[int]],
        matrices: list[NDArray[Any]],
        numbers: list[NDArray[Any]],
        words: list[NDArray[Any]],
        deviation_mm: NDArray[np.float32],
    ) -> None:
        """Samples of several chunks: `first_sample` of the first and `standing` of the last; dp, load, rp; factor and
        v_plan; line, entry and flags; the deviation."""
        self.add_commands(int(words[1].max()))
        self._writer.write_columns(place, matrices, numbers, words, deviation_mm)

    def tell(self, happened: Happened) -> None:
        """What happened, behind the samples of its time."""
        for e in happened:
            if isinstance(e, LogEntry):
                self._event(e.t_s, e.kind, e.axis, e.name, e.on, e.line, e.value, "")
            else:
                self._event(e.t_s, "host", "", e.kind, True, e.line, 0, e.text)

    def _event(self, t_s: float, kind: str, axis: str, name: str, on: bool, line: int, value: int, text: str) -> None:
        event = {"t_s": t_s, "kind": kind, "axis": axis, "name": name, "on": on, "line": line}
        self._writer.write_event(t_s, json.dumps(event | {"value": value, "text": text}))

    def finish(self, run_object: dict[str, Any]) -> None:
        """Adds the result and closes the file.

        What differs between two runs of the same input stays out, so that the same run gives the same bytes.
        """
        self._writer.finish(json.dumps(run_object | dict.fromkeys(VOLATILE), allow_nan=False))


@dataclass(slots=True)
class Recorded:
    """A recording opened for reading: what stands before the samples, then the samples."""

    path: str
    job: bytes
    machine_text: str
    metadata: dict[str, str]
    result: dict[str, Any] | None = None
    events: list[dict[str, Any]] = field(default_factory=list)
    damage: str | None = None
    #: changes of the modal state by source line
    modal: list[tuple[int, str]] = field(default_factory=list)
    #: attachments beside job, machine and sequence
    files: dict[str, bytes] = field(default_factory=dict)
    _reader: Any = None
    _first: Columns | None = None
    _sequence: dict[str, NDArray[Any]] | None = None

    @property
    def sequence(self) -> dict[str, NDArray[Any]]:
        """Columns of the motion commands, of a file that was cut off those up to there. Raises CompileError (CF203) for
        more than can be held."""
        assert self._sequence is not None
        if len(self._sequence.get("kind", ())) == PIECE:
            self._sequence = _joined(self._sequence, self.path)
        return self._sequence

    def columns(self) -> Iterator[Columns]:
        """Chunks of columns in order; `events`, `result` and `damage` are complete afterwards."""
        if self._first is not None:
            yield self._first
        while (item := self._reader.next_item()) is not None:
            kind, name, value = item
            if kind == "columns":
                yield value
            elif kind == "event":
                self.events.append(json.loads(value))
            elif name == RESULT:
                self.result = json.loads(value)
        self.damage = self._reader.damage


def open_recording(path: str) -> Recorded:
    """Reads up to the first samples. Raises CompileError for a file that is no recording of ours."""
    if not Path(path).is_file():
        reason = "not a regular file" if Path(path).exists() else "file not found"
        raise CompileError([_unreadable(path, reason)])
    with content_of(path):
        reader = native.Reader(path)
        found: dict[str, Any] = {}
        first, events = None, []
        while first is None and (item := reader.next_item()) is not None:
            kind, name, value = item
            if kind == "columns":
                first = value
            elif kind == "event":
                events.append(json.loads(value))
            else:
                found[name] = value
        sequence = _unpack(found.pop(SEQUENCE))
        job, machine, metadata = found[JOB], found[MACHINE].decode(), found["run"]
        result = json.loads(found[RESULT]) if RESULT in found else None
        modal = _unpack_modal(found[MODAL]) if MODAL in found else []
    own = (JOB, MACHINE, RESULT, MODAL, "run")
    files = {name: bytes(found[name]) for name in found if name not in own and not name.startswith("sequence.")}
    return Recorded(path, job, machine, metadata, result, events, reader.damage, modal, files, reader, first, sequence)


def _piece_name(number: int) -> str:
    return f"sequence.{number}.npz" if number else SEQUENCE


def _joined(first: dict[str, NDArray[Any]], path: str) -> dict[str, NDArray[Any]]:
    """The pieces of a sequence, the first of which is known, as one."""
    pieces = [first]
    reader = native.Reader(path, only="sequence.")
    while (item := reader.next_item()) is not None:
        if item[1] == _piece_name(len(pieces)):
            check_held(path, (len(pieces) + 1) * PIECE)
            pieces.append(_unpack(item[2]))
    vias, radii = 0, 0
    for piece in pieces:
        piece["via_first"] += np.uint32(vias)
        piece["effradius_of"] += np.uint16(radii)
        vias, radii = vias + len(piece["via_line"]), radii + len(piece["effradius"])
    if radii > np.iinfo(np.uint16).max:
        raise ValueError("more effective radii than can be told apart")
    return {name: first[name] if name == "start" else np.concatenate([p[name] for p in pieces]) for name in first}


#: What reading a sound file with senseless content ends in.
SENSELESS = (ValueError, KeyError, TypeError, IndexError, AttributeError, EOFError, MemoryError, zipfile.BadZipFile)


@contextmanager
def content_of(path: str) -> Iterator[None]:
    """Whoever makes sense of the content of a recording does it in here: what has none raises CompileError."""
    try:
        yield
    except (*SENSELESS, native_kernel.MachineError) as error:
        reason = f"there is no {error}" if isinstance(error, KeyError) else str(error) or type(error).__name__
        raise CompileError([_unreadable(path, reason)]) from error


def _unreadable(path: str, reason: str) -> Diagnostic:
    message, hint = f"cannot be read as a recording: {reason}", "give a file written by run --record"
    return Diagnostic(path, 1, 1, 1, "CF401", message, hint)


def _pack(sequence: dict[str, NDArray[Any]]) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **sequence)  # type: ignore[arg-type]  # numpy's stub takes the keywords for its own options
    return buffer.getvalue()


def _unpack(data: bytes) -> dict[str, NDArray[Any]]:
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return {name: np.ascontiguousarray(arrays[name]) for name in arrays.files}


def _pack_modal(modal: Sequence[tuple[int, str]]) -> bytes:
    """A program may change between few states very often: each text once."""
    texts = list(dict.fromkeys(state for _, state in modal))
    number = {state: n for n, state in enumerate(texts)}
    buffer = io.BytesIO()
    rows = np.array([(line, number[state]) for line, state in modal], np.uint32)
    np.savez_compressed(buffer, rows=rows, texts=np.frombuffer("\n".join(texts).encode(), np.uint8))
    return buffer.getvalue()


def _unpack_modal(data: bytes) -> list[tuple[int, str]]:
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        texts = arrays["texts"].tobytes().decode().split("\n")
        return [(line, texts[number]) for line, number in arrays["rows"].tolist()]
