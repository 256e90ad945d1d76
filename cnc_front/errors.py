"""What can end a command early, as values that the outermost layer prints, and the exit codes of design 3.1."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

from cnc_front.diagnostics import Diagnostic


class Exit(IntEnum):
    """Exit codes of every command."""

    DONE = 0
    CHECK_FAILED = 1
    BAD_INPUT = 2
    STOPPED = 3
    INTERRUPTED = 130


class UsageError(Exception):
    """An argument that cannot be used: a wrong value, an output that would overwrite something (exit 2)."""


class CompileError(Exception):
    """A job, machine file or include that does not compile; `diagnostics` names every finding (exit 2)."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        super().__init__("\n".join(str(d) for d in diagnostics))
        self.diagnostics = tuple(diagnostics)
