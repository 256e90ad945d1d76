"""Alarms: what is wrong now, what is gone but not acknowledged, and the log, of this session and of those before."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from textwrap import wrap
from typing import Any

from rich.style import Style
from textual.strip import Strip

from cnc_front.alarms import alarm_text
from tui.alarm_book import AlarmBook, Entry
from tui.messages import Logged
from tui.pages.base import Page
from tui.rows import Row
from tui.values import Shown
from tui.words import Words

#: Column of the text.
TEXT = 46
#: Column of the text in the log.
LOG_TEXT = 18


class AlarmsPage(Page):
    """Alarms and log."""

    name = "alarms"

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """All of it; it scrolls."""
        app = self.app
        return alarm_rows(shown, app.keeper.book, app.messages.log, app.keeper.earlier_alarms, width)

    def scroll(self, by: int) -> None:
        """Chooses an alarm; beyond the last one, and by page keys, the page scrolls."""
        book = self.app.keeper.book
        last = len(book.open) - 1
        if abs(by) == 1 and 0 <= book.cursor + by <= last and (by > 0 or self.top == 0):
            book.cursor += by
        else:
            super().scroll(by)

    def next(self) -> None:
        """The next alarm, round and round."""
        book = self.app.keeper.book
        book.cursor = (book.cursor + 1) % max(len(book.open), 1)

    def key_acknowledge(self) -> None:
        """Only when the cause is gone."""
        entry, words = self.app.keeper.book.chosen, self.app.words
        if entry is None:
            self.app.say(words("ack_none"))
        elif entry.active:
            self.app.say(words("ack_refused", code=entry.alarm.code, axis=entry.alarm.axis, name=entry.name))
        else:
            self.app.keeper.acknowledge(entry)
            self.app.say(words("ack_done", code=entry.alarm.code, axis=entry.alarm.axis))


def alarm_rows(
    shown: Shown, book: AlarmBook, log: Sequence[Logged], earlier: Sequence[dict[str, Any]], width: int
) -> list[Strip]:
    """Open alarms with cause and remedy, the log of the session newest first, alarms of earlier sessions."""
    look, words = shown.look, shown.words
    rows = [Row(look.strong).add(f" {words('alarms_title')}").until(width - 1, words("alarms_keys"), look.dim)]
    rows.append(Row(look.dim).add(words("alarm_head")))
    chosen = book.chosen
    for entry in book.open:
        rows += _entry_rows(shown, entry, entry is chosen, width)
    if chosen is None:
        rows.append(Row(look.text).add(f"  {words('alarms_none')}"))
    rows += [Row(look.text), Row(look.strong).add(f" {words('log_title')}")]
    rows += [row for entry in reversed(log) for row in _log_rows(shown, entry, width)]
    rows += [Row(look.dim).add(f"  {_seen(entry, words)}") for entry in book.done]
    if earlier:
        rows += [Row(look.text), Row(look.strong).add(f" {words('earlier_title')}")]
        rows += [_earlier_row(shown, row, words.language) for row in earlier]
    return [row.strip(width) for row in rows]


def _log_rows(shown: Shown, entry: Logged, width: int) -> list[Row]:
    """When, code, and the text in as many rows as it needs."""
    first, *more = wrap(entry.text, width - LOG_TEXT - 1) or [""]
    rows = [Row(shown.look.text).add(f"  {entry.clock}").at(12, entry.code).at(LOG_TEXT, first)]
    return rows + [Row(shown.look.text).at(LOG_TEXT, text) for text in more]


def _seen(entry: Entry, words: Words) -> str:
    place = f"{entry.alarm.axis} {entry.block}".strip()
    return f"{entry.at:%H:%M:%S}  {entry.alarm.code:<6}{place} {entry.name} {words('acknowledged')}"


def _entry_rows(shown: Shown, entry: Entry, chosen: bool, width: int) -> list[Row]:
    """One open alarm: its columns and cause, then the remedy below the cause."""
    look, words, alarm = shown.look, shown.words, entry.alarm
    style = (look.alarm if alarm.stopped else look.bad) if entry.active else look.dim
    state = words("alarm_active") if entry.active else words("alarm_gone")
    row = Row(style).add(">" if chosen else " ", look.cursor if chosen else look.text)
    row.add(f"{entry.at:%H:%M:%S}").until(20, f"{alarm.t_s:.3f} s").at(21, alarm.code).at(26, alarm.axis)
    row.at(29, entry.block).at(38, state)
    cause = wrap(entry.cause, max(width - TEXT - 1, 20)) or [""]
    rows = [row.at(TEXT, cause[0])]
    rows += [Row(style).at(TEXT, text) for text in cause[1:]]
    if entry.remedy:
        texts = wrap(f"-> {entry.remedy}", max(width - TEXT - 1, 20))
        rows += [Row(look.text).at(TEXT, text) for text in texts]
    return rows


def _earlier_row(shown: Shown, row: dict[str, Any], language: str) -> Row:
    look = shown.look
    when = datetime.fromisoformat(row["at"]).astimezone()
    _, what = alarm_text(row["name"], row["bit"], row["axis"], language)
    seen: Style = look.dim if row["acknowledged"] else look.text
    line = Row(seen).add(f"  {when:%Y-%m-%d %H:%M}").at(20, row["code"]).at(26, row["axis"]).at(29, row["block"])
    return line.at(38, Path(row["job"]).name[:18]).at(58, what)
