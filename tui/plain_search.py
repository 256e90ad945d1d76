"""Block search in the line mode: blocks read out, the state before one, and a start there, as `G` on Run."""

from __future__ import annotations

from collections.abc import Callable

from cnc_front.errors import CompileError, UsageError
from cnc_front.search import start_text
from tui.plain_desk import Desk
from tui.program import block_name, find_block

#: Blocks read out at once, and characters of each.
BLOCKS, LONGEST = 10, 200


class Search:
    """Finds blocks of the loaded job."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk

    def deeds(self) -> dict[str, Callable[[str], None]]:
        """What its commands do."""
        return {"blocks": self._blocks, "block": self._block, "search": self._search}

    def _line(self, text: str) -> int:
        """The line of a block, of the current one without a name; 0, and says so, where there is none."""
        desk = self._desk
        lines = desk.job.lines if desk.job else ()
        line = find_block(lines, text) if text else desk.engine.snapshot().line or 1
        if not lines:
            desk.say(desk.words("goto_job"))
        elif not line or line > len(lines):
            desk.say(desk.words("goto_none", text=text[:20]))
        else:
            return line
        return 0

    def _block(self, text: str) -> None:
        self._read(self._line(text), 1)

    def _blocks(self, text: str) -> None:
        self._read(self._line(text), BLOCKS)

    def _read(self, first: int, count: int) -> None:
        lines = self._desk.job.lines if self._desk.job else ()
        for line in range(first, min(first + count, len(lines) + 1)) if first else ():
            self._desk.say(f"{block_name(lines, line)}: {lines[line - 1][:LONGEST]}")

    def _search(self, text: str) -> None:
        desk, block = self._desk, text.upper()
        if desk.engine.snapshot().replay:
            desk.operation.seek(text)
        elif desk.operation.is_underway:
            desk.say(desk.words("job_busy"))
        elif not block:
            desk.usage("search")
        elif block == "0" and desk.job:
            self._start_at("")
        elif self._line(block):
            self._ask(block)

    def _ask(self, block: str) -> None:
        desk = self._desk
        try:
            start = desk.engine.search(block)
        except (CompileError, UsageError, OSError) as error:
            desk.refuse(error)
        else:
            units = {axis.name: axis.unit for axis in desk.engine.snapshot().axes}
            question = f"{start_text(start, units, desk.words.language)}\n{desk.words('start_at_way')}"
            desk.ask(question, lambda: self._start_at(block))

    def _start_at(self, block: str) -> None:
        desk = self._desk
        try:
            job = desk.engine.start_at(block)
        except (CompileError, UsageError, OSError) as error:
            desk.refuse(error)
        else:
            desk.block = None
            name = block_name(job.lines, int(block)) if block.isdecimal() else block
            desk.say(desk.words("start_at_done", block=name) if block else desk.words("start_at_top"))
