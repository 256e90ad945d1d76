"""Large part programs, translated while they are read: memory does not grow with them.

A program that jumps, loops or calls has to look back: it is compiled whole, as are small ones, parts (--from, --to),
and what a recording or a report needs. Findings, motion and result are the same either way.
"""

from __future__ import annotations

import hashlib
import stat
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cnc_front._native import gcode as native_gcode
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.jobs import CompileOptions, MachineFile, language_at, shown
from cnc_front.readiness import finding

#: Programs up to this size are compiled whole, bytes: it takes little memory and the text is at hand.
WHOLE_BYTES = 1 << 20
#: Bytes that are read at a time.
BLOCK = 1 << 20
#: Who takes the commands of a stream: the controller, and the tracker that measures it.
EXECUTES, MEASURES = 0, 1


class MustBeWhole(Exception):
    """The program jumps, loops or calls: what was begun counts for nothing."""


def streams(path: str, options: CompileOptions) -> bool:
    """True for a part program that is large, and wanted from its beginning to its end."""
    if options.start or options.stop or options.strict or options.mdi or options.dry_feed is not None:
        return False
    try:
        status = Path(path).stat()
    except OSError:
        return False
    size = status.st_size
    fits = stat.S_ISREG(status.st_mode) and WHOLE_BYTES < size <= native_gcode.MOST_BYTES
    return fits and language_at(path, options.language) == "din66025"


def _stamp(path: str) -> tuple[int, int]:
    status = Path(path).stat()
    return status.st_size, status.st_mtime_ns


class FileSource:
    """A part program in its file; its hash and its lines are counted beside the run."""

    language = "din66025"

    def __init__(self, path: str) -> None:
        """Raises OSError."""
        self.path = path
        self._stamp = _stamp(path)
        self._read: Future[tuple[str, int]] | None = None

    def count(self) -> None:
        """Begins to count, in a thread."""
        pool = ThreadPoolExecutor(1, "hash")
        self._read = pool.submit(_hash_and_lines, self.path)
        pool.shutdown(wait=False)

    def check_unchanged(self) -> None:
        """Raises CompileError (GC114) if the file is not what it was."""
        try:
            same = _stamp(self.path) == self._stamp
        except OSError:
            same = False
        if not same:
            raise CompileError([finding(shown(self.path), "GC114")])

    def _counted(self) -> tuple[str, int]:
        if self._read is None:
            self.count()
        assert self._read is not None
        return self._read.result()

    @property
    def sha256(self) -> str:
        """Hash of the bytes."""
        return self._counted()[0]

    @property
    def lines(self) -> int:
        """Lines of the text, by its line ends."""
        return self._counted()[1]


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


@dataclass(slots=True)
class StreamedJob:
    """A program that is translated while it runs. `warnings` and `facts` are known once it is `settle`d."""

    source: FileSource
    machine: MachineFile
    program: native_gcode.Stream
    warnings: tuple[Diagnostic, ...] = ()
    facts: dict[str, Any] = field(default_factory=lambda: {"start": None})
    settled: bool = False

    def settle(self) -> None:
        """The run needs no more commands: waits for the end of the translation.

        Raises CompileError for errors in the text and for a file that changed meanwhile, MustBeWhole, OSError.
        """
        self.settled = True
        for user in (EXECUTES, MEASURES):
            self.program.send_away(user)
        found = self.program.finish()
        self.source.check_unchanged()
        self.warnings, self.facts = judged(found)


def judged(
    found: tuple[list[tuple[str, int, int, int, str, str, str]], dict[str, Any]] | None,
) -> tuple[tuple[Diagnostic, ...], dict[str, Any]]:
    """Warnings and facts of a translation; raises MustBeWhole, CompileError."""
    if found is None:
        raise MustBeWhole
    rows, facts = found
    diagnostics = tuple(Diagnostic(*row) for row in rows)
    if any(not d.is_warning for d in diagnostics):
        raise CompileError(diagnostics)
    return diagnostics, facts


def _switches(options: CompileOptions) -> dict[str, Any]:
    return {
        "profile": options.profile,
        "optional_stop": options.optional_stop,
        "block_delete": list(options.block_delete),
    }


def begin(path: str, machine: MachineFile, options: CompileOptions) -> StreamedJob:
    """Begins to translate a program for a run; raises OSError."""
    source = FileSource(path)
    program = native_gcode.Stream(path, shown(path), machine.machine, **_switches(options))
    source.count()
    return StreamedJob(source, machine, program)


def check(path: str, machine: MachineFile, options: CompileOptions) -> tuple[Diagnostic, ...]:
    """All findings of a program; raises MustBeWhole, CompileError (GC114), OSError."""
    source = FileSource(path)
    found = native_gcode.check_once(path, shown(path), machine.machine, **_switches(options))
    source.check_unchanged()
    if found is None:
        raise MustBeWhole
    return tuple(Diagnostic(*row) for row in found[0])


def sound(path: str, machine: MachineFile, options: CompileOptions) -> tuple[Diagnostic, ...]:
    """The warnings of a program without errors; raises as `check`, and CompileError."""
    diagnostics = check(path, machine, options)
    if any(not d.is_warning for d in diagnostics):
        raise CompileError(diagnostics)
    return diagnostics


def listing(path: str, machine: MachineFile, options: CompileOptions, *, json: bool) -> native_gcode.StreamListing:
    """The listing of a program that was checked, piece by piece while it is translated; raises OSError."""
    program = native_gcode.Stream(path, shown(path), machine.machine, users=1, **_switches(options))
    return program.listing(path, json)
