"""MDI in the line mode: a block is checked, `start` executes it; what it wrote and how it ended is told."""

from __future__ import annotations

from collections.abc import Callable

from cnc_front.engine import Snapshot, wait_for
from cnc_front.errors import CompileError, UsageError
from tui.pages.mdi import Entry, entry_end
from tui.plain_desk import Desk
from tui.plain_words import part_of
from tui.states import UNDERWAY

#: The engine has a checked block after so long at most, s.
TAKEN_S = 1.0


class Mdi:
    """Decides what `start` starts: once a block was typed, never the job, unless that is said."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._entry: Entry | None = None
        self._output: tuple[str, ...] = desk.engine.snapshot().output

    def deeds(self) -> dict[str, Callable[[str], None]]:
        """What its commands do."""
        return {"mdi": self._check, "start": self._start, "resume": self._start}

    def watch(self, s: Snapshot) -> None:
        """Tells what statements wrote, and how the block ended."""
        if s.output != self._output:
            for line in _added(self._output, s.output):
                self._desk.say(f"> {line}")
            self._output = s.output
        if self._entry is not None:
            self._entry.watch(s)
            end = entry_end(self._entry, self._desk.words)
            if end:
                self._desk.say(f"{self._entry.text}: {end}")
                self._entry = None

    def _check(self, text: str) -> None:
        desk = self._desk
        if not text:
            desk.usage("mdi")
        elif desk.is_free():
            desk.block = ""  # an earlier block is not executed in place of a wrong one
            try:
                desk.engine.check_mdi(text)
            except (CompileError, UsageError) as error:
                desk.refuse(error)
                return
            if wait_for(lambda: desk.engine.snapshot().mdi == text, TAKEN_S):
                desk.block = text
                desk.say(desk.words("mdi_checked", block=text))

    def _start(self, text: str) -> None:
        desk, s = self._desk, self._desk.engine.snapshot()
        if part_of(text) == "job":
            desk.block = None
        if desk.block is None or s.state in UNDERWAY:
            desk.operation.start(0.0)
        elif not desk.block or s.mdi != desk.block:
            desk.say(desk.words("plain_mdi_nothing"))
        else:
            self._entry, desk.block = Entry("", s.mdi), ""
            desk.operation.start_mdi(0.0)


def _added(before: tuple[str, ...], now: tuple[str, ...]) -> tuple[str, ...]:
    """The lines behind those of before; the oldest of them may have gone."""
    kept = next(n for n in range(len(before), -1, -1) if now[:n] == before[len(before) - n :])
    return now[kept:]
