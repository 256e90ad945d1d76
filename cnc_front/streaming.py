"""Part programs, translated while they run: memory does not grow with them.

A program is checked from its beginning to its end; if it is sound, it is translated again, and its commands go to
controller, measurement and recording as they come. Of one that jumps, loops or calls only the text is in memory. What
needs the path as a whole (a report, a sweep ...) compiles a CompiledJob instead (cnc_front.jobs). Findings, motion,
result and recording are the same either way.
"""

from __future__ import annotations

import hashlib
import stat
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cnc_front._native import gcode as native_gcode
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.jobs import CompileOptions, MachineFile, cannot_read, language_at, shown
from cnc_front.readiness import finding

#: Bytes that are read at a time.
BLOCK = 1 << 20
#: Who takes the commands of a stream: the controller, the tracker that measures it, and a recording.
EXECUTES, MEASURES, RECORDS = 0, 1, 2


def streams(path: str, language: str | None) -> bool:
    """True for the file of a part program. Raises CompileError (GC106) for one that is too large even for this."""
    try:
        status = Path(path).stat()
    except OSError:
        return False
    if not stat.S_ISREG(status.st_mode) or language_at(path, language) != "din66025":
        return False
    if status.st_size > native_gcode.MOST_BYTES:
        raise CompileError([finding(shown(path), "GC106", native_gcode.MOST_BYTES >> 20)])
    return True


class FileSource:
    """A part program in its file; its hash and its lines are counted beside the run."""

    language = "din66025"

    def __init__(self, path: str) -> None:
        """Raises CompileError (GC112)."""
        self.path = path
        self._read: Future[tuple[str, int]] | None = None
        with self._reading():
            self._stamp = self._status()

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """A disk that fails is a fault of the job (GC112), not of what is written."""
        try:
            yield
        except OSError as error:
            raise cannot_read(self.path, "GC112", error.strerror or str(error)) from None

    def _status(self) -> tuple[int, ...]:
        status = Path(self.path).stat()
        return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns

    def count(self) -> None:
        """Begins to count, in a thread."""
        pool = ThreadPoolExecutor(1, "hash")
        self._read = pool.submit(_hash_and_lines, self.path)
        pool.shutdown(wait=False)

    def check_unchanged(self) -> None:
        """Raises CompileError (GC114) if the file is not what it was."""
        try:
            same = self._status() == self._stamp
        except OSError:
            same = False
        if not same:
            raise CompileError([finding(shown(self.path), "GC114")])

    @contextmanager
    def used(self) -> Iterator[None]:
        """Whoever uses what is read from the file does it in here: raises CompileError (GC114, GC112)."""
        try:
            with self._reading():
                yield
        except (CompileError, ValueError):
            self.check_unchanged()  # it explains all else
            raise
        self.check_unchanged()

    def _counted(self) -> tuple[str, int]:
        if self._read is None:
            self.count()
        assert self._read is not None
        with self._reading():
            return self._read.result()

    @property
    def sha256(self) -> str:
        """Hash of the bytes."""
        return self._counted()[0]

    @property
    def lines(self) -> int:
        """Lines of the text, by its line ends."""
        return self._counted()[1]

    @property
    def content(self) -> str:
        """Where the text is."""
        return self.path


def _hash_and_lines(path: str) -> tuple[str, int]:
    """Hash of a file, and its lines as JobSource.lines counts them."""
    digest, lines, last = hashlib.sha256(), 0, b""
    with Path(path).open("rb") as file:
        while block := file.read(BLOCK):
            digest.update(block)
            lines += block.count(b"\n") + block.count(b"\r") - block.count(b"\r\n")
            lines -= last == b"\r" and block[:1] == b"\n"
            last = block[-1:]
    return digest.hexdigest(), lines + (last not in (b"", b"\n", b"\r"))


@dataclass(frozen=True, slots=True)
class StreamedJob:
    """A sound program that is translated while it runs."""

    source: FileSource
    machine: MachineFile
    program: native_gcode.Stream
    warnings: tuple[Diagnostic, ...]
    facts: dict[str, Any]
    #: who takes the commands
    users: tuple[int, ...]
    #: as of a CompiledJob; only the terminal has it, which streams nothing
    dry_feed: None = None

    def settle(self) -> None:
        """The run needs no more commands: waits for the end of the translation.

        Raises CompileError for a file that changed meanwhile or that a disk failed to give.
        """
        with self.source.used():
            for user in self.users:
                self.program.send_away(user)
            _sound(self.program.finish()[0])


def _sound(rows: list[tuple[str, int, int, int, str, str, str]]) -> tuple[Diagnostic, ...]:
    """The warnings of a program without errors; raises CompileError."""
    diagnostics = tuple(Diagnostic(*row) for row in rows)
    if any(not d.is_warning for d in diagnostics):
        raise CompileError(diagnostics)
    return diagnostics


def check(path: str, machine: MachineFile, options: CompileOptions) -> tuple[Diagnostic, ...]:
    """All findings of a program; raises CompileError (GC114, GC112)."""
    source = FileSource(path)
    with source.used():
        rows, _ = native_gcode.check_once(path, shown(path), machine.machine, options)
    return tuple(Diagnostic(*row) for row in rows)


def sound(
    source: FileSource, machine: MachineFile, options: CompileOptions
) -> tuple[tuple[Diagnostic, ...], dict[str, Any]]:
    """Warnings and facts of a program without errors; raises CompileError."""
    with source.used():
        rows, facts = native_gcode.check_once(source.path, shown(source.path), machine.machine, options)
        return _sound(rows), facts


def begin(source: FileSource, machine: MachineFile, options: CompileOptions, *, recorded: bool) -> StreamedJob:
    """Checks a program and begins to translate it for a run, which is `recorded` or not; raises CompileError."""
    source.count()
    warnings, facts = sound(source, machine, options)
    users = (EXECUTES, MEASURES, RECORDS) if recorded else (EXECUTES, MEASURES)
    program = native_gcode.Stream(source.path, shown(source.path), machine.machine, options, len(users))
    return StreamedJob(source, machine, program, warnings, facts, users)


def listing(source: FileSource, machine: MachineFile, options: CompileOptions, *, json: bool) -> Iterator[str]:
    """The listing of a sound program, piece by piece while it is translated; raises CompileError (GC114, GC112)."""
    with source.used():
        program = native_gcode.Stream(source.path, shown(source.path), machine.machine, options, 1)
        yield from program.listing(source.path, json)
        _sound(program.finish()[0])
