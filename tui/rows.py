"""Rows of styled text with fixed columns: what every part of the screen is built of."""

from __future__ import annotations

from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip

#: Control characters would move the terminal's cursor; programs may contain any of them.
_CLEAN = dict.fromkeys([*range(32), 127, *range(128, 160)], "·") | {9: " "}


def clean(text: str) -> str:
    """Text that is safe to write to a terminal."""
    return text.translate(_CLEAN)


class Row:
    """Builds one row from left to right."""

    def __init__(self, style: Style) -> None:
        self._style = style
        self._segments: list[Segment] = []
        self.width = 0

    def add(self, text: str, style: Style | None = None) -> Row:
        """Appends text."""
        if text:
            segment = Segment(clean(text), style or self._style)
            self._segments.append(segment)
            self.width += segment.cell_length
        return self

    def at(self, column: int, text: str, style: Style | None = None) -> Row:
        """Appends text that begins at a column, or right after what stands there."""
        self.add(" " * (column - self.width))
        return self.add(text, style)

    def until(self, column: int, text: str, style: Style | None = None) -> Row:
        """Appends text that ends before a column."""
        return self.at(max(column - len(text), self.width), text, style)

    def strip(self, width: int) -> Strip:
        """The row, cut or filled to a width."""
        return Strip(self._segments, self.width).adjust_cell_length(width, self._style)


def beside(*strips: Strip) -> Strip:
    """Strips side by side."""
    return Strip.join(strips)


def changed_span(old: Strip, new: Strip) -> tuple[int, int] | None:
    """First and last+1 cell in which two rows of equal length differ; None if they are equal."""
    if old == new:
        return None
    before, after = list(old), list(new)
    start = 0
    while before and after and before[0] == after[0]:
        start += before.pop(0).cell_length
        after.pop(0)
    end = new.cell_length
    while before and after and before[-1] == after[-1]:
        end -= before.pop().cell_length
        after.pop()
    return start, max(end, start + 1)
