"""Keeps what happened: alarms as they come and runs as they end, on the screen and in the history."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from typing import Any

from cnc_front.engine import Engine
from tui.alarm_book import AlarmBook, Entry
from tui.archive import Archive
from tui.values import Shown


class Keeper:
    """`say` puts a message on the screen."""

    def __init__(self, engine: Engine, archive: Archive, say: Callable[[str], None]) -> None:
        self._engine, self.archive, self._say = engine, archive, say
        self.book = AlarmBook()
        self._run = 0
        self._told = ""
        self._job = ""
        archive.read()

    def watch(self, shown: Shown, now: datetime) -> None:
        """Called for every frame."""
        self._job = shown.job.path if shown.job else ""
        replayed = shown.snapshot.replay  # what a recording shows happened, and was kept, before
        self.book.watch(shown.snapshot, shown.job, now, (lambda _: None) if replayed else self._opened)
        outcome = self._engine.outcome()
        if outcome is not None and outcome.number != self._run:
            self._run = outcome.number
            self.archive.keep_run(outcome)
        if self.archive.trouble != self._told:
            self._told = self.archive.trouble
            self._say(self._told)

    def _opened(self, entry: Entry) -> None:
        alarm = entry.alarm
        row = {"t_s": alarm.t_s, "axis": alarm.axis, "bit": int(alarm.code[2:]), "name": entry.name}

        def written(number: int) -> None:
            entry.number = number

        self.archive.keep_alarm(row | {"line": alarm.line, "block": entry.block}, self._job, written)

    def acknowledge(self, entry: Entry) -> None:
        """The operator has seen an alarm whose cause is gone."""
        entry.acknowledged = True
        if entry.number:
            self.archive.acknowledge(entry.number)

    @property
    def earlier_alarms(self) -> Sequence[dict[str, Any]]:
        """Alarms of the history that are none of this session."""
        mine = {entry.number for entry in self.book.entries}
        return [row for row in self.archive.alarms if row["id"] not in mine]
