"""Service: per axis what the controller reports."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from textual.strip import Strip

from tui.pages.base import Page
from tui.rows import Row
from tui.values import Shown

if TYPE_CHECKING:
    from tui.app import Terminal

#: Values that changed are marked for so long, s.
MARK_S = 2.0


class ServicePage(Page):
    """Axes and status bits."""

    name = "service"

    def __init__(self, app: Terminal) -> None:
        super().__init__(app)
        self._changes = Changes()

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """All of it; it scrolls."""
        return service_rows(shown, self._changes, time.monotonic(), width)


@dataclass(slots=True)
class Changes:
    """Remembers when each value of the service page last changed."""

    _values: dict[str, str] = field(default_factory=dict)
    _at: dict[str, float] = field(default_factory=dict)

    def is_fresh(self, name: str, value: str, now: float) -> bool:
        """Whether a value changed within the last two seconds."""
        if name in self._values and self._values[name] != value:
            self._at[name] = now
        self._values[name] = value
        return now - self._at.get(name, -MARK_S) < MARK_S


def service_rows(shown: Shown, changes: Changes, now: float, width: int) -> list[Strip]:
    """Per axis what the controller reports; changed values are marked with `*`."""
    look, words = shown.look, shown.words
    rows = [Row(look.strong).add(f" {words('service_title')}"), Row(look.dim).add(f" {words('service_head')}")]
    for axis in shown.snapshot.axes:
        values = (
            (16, f"{axis.command:+.4f}"),
            (28, f"{axis.actual:+.4f}"),
            (37, f"{round(axis.following, 4) + 0.0:+.4f}"),
            (46, f"{axis.mpe:g}"),
            (54, f"{axis.spool_fill * 100:.0f} %"),
        )
        row = Row(shown.value).add(f" {axis.name} {axis.unit}", look.strong)
        for end, text in values:
            row.until(end, text)
        bits = " ".join(axis.bits)
        fresh = changes.is_fresh(axis.name, bits, now)
        rows.append(row.at(55, "*" if fresh else " ", look.warn).add(" " + bits, look.warn if fresh else shown.value))
        if not axis.referenced:
            rows.append(Row(look.warn).at(57, words("not_referenced")))
    return [row.strip(width) for row in rows]
