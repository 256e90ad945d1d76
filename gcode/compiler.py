"""The compiler's Python face."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from os import PathLike
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from cnc_front._native import gcode as native
from motion_kernel import Diagnostic, Machine


class CompileError(Exception):
    """A program with errors; `diagnostics` names every finding, warnings included."""

    def __init__(self, diagnostics: tuple[Diagnostic, ...]) -> None:
        super().__init__("\n".join(map(str, diagnostics)))
        self.diagnostics = diagnostics


class Program:
    """A compiled part program: autocode, and what is known about it."""

    def __init__(self, program: native.Program, warnings: tuple[Diagnostic, ...], facts: dict[str, Any]) -> None:
        self.native = program
        self.warnings = warnings
        self.facts = facts

    def listing(self) -> Iterator[dict[str, Any]]:
        """The spooled command sequence, one dict per command (design 3.3)."""
        return (json.loads(line) for piece in self.native.listing(b"", True) for line in piece.splitlines())

    def sequence(self) -> dict[str, NDArray[Any]]:
        """Its motion commands as columns: see toolpaths.Path."""
        return self.native.sequence()

    def counts(self) -> dict[str, int]:
        """How many of each command it spools."""
        return dict(self.native.counts())


def compile(
    source: str | bytes | PathLike[str],
    machine: Machine,
    *,
    filename: str | None = None,
    profile: str | None = None,
    optional_stop: bool = False,
    block_delete: Iterable[int] = (),
    start: str | None = None,
    stop: str | None = None,
) -> Program:
    """Compiles a part program: its text (str, bytes), or the path of its file (os.PathLike).

    `profile` is din, fanuc, linuxcnc or lathe (default: that of the machine file); `block_delete` the levels N
    of `/N` that are skipped; `start` and `stop` the first and last block of a part ("N120", or "57" for a line).
    Subprograms are looked for beside the file. Raises CompileError with every finding, OSError where a file
    cannot be read.
    """
    library = None
    if isinstance(source, PathLike):
        path = Path(source)
        data, name, library = path.read_bytes(), filename or str(path), str(path.parent)
    else:
        data, name = source.encode() if isinstance(source, str) else source, filename or "<text>"
    program, rows, facts = native.compile(
        data,
        name,
        machine.native,
        profile=profile,
        optional_stop=optional_stop,
        block_delete=list(block_delete),
        library=library,
        start=start,
        stop=stop,
    )
    diagnostics = tuple(Diagnostic(*row) for row in rows)
    if program is None:
        raise CompileError(diagnostics)
    return Program(program, diagnostics, facts)
