"""The part program beside the path. Only the lines on screen are touched, so a million lines cost nothing."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from textual.strip import Strip

from tui.look import Look
from tui.rows import Row

_NUMBER = re.compile(r"\s*/?\d?\s*N(\d+)", re.IGNORECASE)
_SKIP = re.compile(r"\s*/\d?")
#: Lines searched for a block number at a time and in all, from the cursor on.
_SEARCH = 2_000_000


def block_name(lines: Sequence[str], line: int) -> str:
    """`N620` where the block has a number, else `L12` (source line)."""
    if 0 < line <= len(lines) and (match := _NUMBER.match(lines[line - 1][:40])):
        return f"N{match.group(1)}"
    return f"L{line}"


def find_block(lines: Sequence[str], text: str) -> int | None:
    """The source line of a block `N620` (first one), or of a line number `12`."""
    wanted = text.strip().upper()
    if wanted.isdecimal() and len(wanted) < 10:
        return int(wanted) if 0 < int(wanted) <= len(lines) else None
    if not (wanted.startswith("N") and wanted[1:].isdecimal() and len(wanted) < 20):
        return None
    number = int(wanted[1:])
    for index in range(min(len(lines), _SEARCH)):
        match = _NUMBER.match(lines[index][:40])
        if match and len(match.group(1)) < 20 and int(match.group(1)) == number:
            return index + 1
    return None


def find_text(lines: Sequence[str], text: str, after: int) -> int | None:
    """The next source line behind `after` that contains a text in any case; from the top where there is none."""
    wanted = text.strip().upper()
    order = (range(after, len(lines)), range(min(after, len(lines))))
    return next((index + 1 for part in order for index in part if wanted in lines[index].upper()), None)


class ProgramView:
    """Follows the current block by flipping pages; a chosen block stays until the operator lets it go."""

    def __init__(self, look: Look) -> None:
        self._look = look
        self.lines: Sequence[str] = ()
        self.top = 0
        self.chosen = 0

    def take(self, lines: Sequence[str]) -> None:
        """Shows another program."""
        self.lines, self.top, self.chosen = lines, 0, 0

    def choose(self, line: int) -> None:
        """Puts the cursor on a source line (counts from 1; 0: follow the run again)."""
        self.chosen = max(0, min(line, len(self.lines)))

    def move(self, by: int, current: int) -> None:
        """Moves the cursor, from the current block if there was none."""
        self.choose(max(1, (self.chosen or max(current, 1)) + by))

    def line_at(self, row: int) -> int | None:
        """The source line in a row of the view."""
        line = self.top + row + 1
        return line if line <= len(self.lines) else None

    def rows(self, width: int, height: int, current: int, over_mm: Mapping[int, float]) -> list[Strip]:
        """The lines on screen."""
        shown = (self.chosen or max(current, 1)) - 1
        if not self.top <= shown < self.top + height:
            self.top = shown - height // 4
        self.top = max(0, min(self.top, len(self.lines) - height))
        return [self._row(index, width, current, over_mm) for index in range(self.top, self.top + height)]

    def _row(self, index: int, width: int, current: int, over_mm: Mapping[int, float]) -> Strip:
        look = self._look
        if index >= len(self.lines):
            return Row(look.text).strip(width)
        # what lies beyond the edge is not looked at: a line may be a megabyte long
        text, line = self.lines[index][: width + 8].rstrip("\r\n"), index + 1
        style = look.cursor if line == self.chosen else look.strong if line == current else look.text
        skip = _SKIP.match(text)
        mark = ">" if line == current else "/" if skip else " "
        row = Row(style).add(mark, look.inverse if line == current else style)
        row.add(" " if width >= 50 else "").add(text[skip.end() :].lstrip() if skip else text)
        if line in over_mm:
            note = f" !{over_mm[line] * 1000:.1f}um"
            kept = row.strip(width - len(note))
            return Strip.join([kept, Row(look.bad).add(note).strip(len(note))])
        return row.strip(width)
