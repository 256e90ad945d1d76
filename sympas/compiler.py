"""The compiler's Python face."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from cnc_front._native import sympas as native
from motion_kernel import Diagnostic, Machine


class CompileError(Exception):
    """A job with errors; `diagnostics` names every finding, warnings included."""

    def __init__(self, diagnostics: tuple[Diagnostic, ...]) -> None:
        super().__init__("\n".join(map(str, diagnostics)))
        self.diagnostics = diagnostics


class Program:
    """A compiled job: register code of a CNC task."""

    def __init__(self, program: native.Program, warnings: tuple[Diagnostic, ...] = ()) -> None:
        self.native = program
        self.warnings = warnings

    @property
    def task(self) -> int | None:
        """The task of `{$TASK n}`, 0 to 3; None where the job names none."""
        return self.native.task

    def listing(self) -> list[str]:
        """The disassembly, line by line."""
        return self.native.listing()

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the autocode file (.cnc)."""
        Path(path).write_bytes(self.native.encode())


def compile(
    source: str | bytes | PathLike[str], machine: Machine, *, filename: str | None = None, language: str = "en"
) -> Program:
    """Compiles a job for a machine: its text (str, bytes), or the path of its file (os.PathLike).

    Includes are looked for beside the file. `language` of messages is en or de. Raises CompileError with every
    finding, OSError where the file cannot be read.
    """
    folder: str | None = None
    if isinstance(source, PathLike):
        path = Path(source)
        data, name, folder = path.read_bytes(), filename or str(path), str(path)
    else:
        data, name = source.encode() if isinstance(source, str) else source, filename or "<text>"
    program, rows = native.compile(data, name, machine.native, path=folder, language=language)
    diagnostics = tuple(Diagnostic(*row) for row in rows)
    if program is None:
        raise CompileError(diagnostics)
    return Program(program, diagnostics)


def load(path: str | PathLike[str]) -> Program:
    """Reads an autocode file (.cnc). Raises ValueError for a damaged one, or one that no task may execute."""
    return Program(native.decode(Path(path).read_bytes()))
