"""Alarms: what is wrong now, then what happened in this session."""

from __future__ import annotations

from collections.abc import Sequence

from textual.strip import Strip

from tui.messages import Logged
from tui.pages.base import Page
from tui.program import block_name
from tui.rows import Row
from tui.values import Shown


class AlarmsPage(Page):
    """Alarms and log."""

    name = "alarms"

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """All of it; it scrolls."""
        return alarm_rows(shown, self.app.messages.log, width)


def alarm_rows(shown: Shown, log: Sequence[Logged], width: int) -> list[Strip]:
    """What the controller reports as faults, then what happened, newest first."""
    look, words = shown.look, shown.words
    rows = [Row(look.strong).add(f" {words('alarms_title')}"), Row(look.dim).add(f"  {words('alarm_head')}")]
    lines = shown.job.lines if shown.job else ()
    for alarm in shown.snapshot.alarms:
        row = Row(look.bad).add(f"  {alarm.t_s:9.3f} s").at(14, alarm.code).at(20, alarm.axis)
        block = block_name(lines, alarm.line) if alarm.line else ""
        rows.append(row.at(26, block).at(35, ("!! " if alarm.stopped else "") + alarm.text))
    if not shown.snapshot.alarms:
        rows.append(Row(look.text).add(f"  {words('alarms_none')}"))
    rows += [Row(look.text), Row(look.strong).add(f" {words('log_title')}")]
    rows += [Row(look.text).add(f"  {entry.clock}  {entry.code:<6}{entry.text}") for entry in reversed(log)]
    return [row.strip(width) for row in rows]
