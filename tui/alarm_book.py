"""The alarms of this session: which are active, which are gone but not acknowledged, which are done with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime

from cnc_front.engine import Alarm, Job, Snapshot
from tui.program import block_name

#: Entries kept.
MOST = 500


@dataclass(slots=True)
class Entry:
    """One alarm. `number`: its number in the history once it is written there; 0 before."""

    at: datetime
    alarm: Alarm
    block: str
    active: bool = True
    acknowledged: bool = False
    number: int = 0

    @property
    def name(self) -> str:
        """The manual's name of the bit."""
        return self.alarm.name

    @property
    def cause(self) -> str:
        """What happened."""
        return self.alarm.text.partition("; ")[0]

    @property
    def remedy(self) -> str:
        """What to do; empty where nothing is known."""
        return self.alarm.text.partition("; ")[2]


class AlarmBook:
    """Watches what the controller reports. An alarm is active while its bit is set (of the error register: until the
    reset that clears it)."""

    def __init__(self) -> None:
        self.entries: list[Entry] = []
        self.cursor = 0
        self._known: set[tuple[float, str, str]] = set()

    @property
    def open(self) -> list[Entry]:
        """Not acknowledged, newest first."""
        return [entry for entry in reversed(self.entries) if not entry.acknowledged]

    @property
    def done(self) -> list[Entry]:
        """Acknowledged, newest first."""
        return [entry for entry in reversed(self.entries) if entry.acknowledged]

    @property
    def chosen(self) -> Entry | None:
        """The one under the cursor."""
        entries = self.open
        self.cursor = max(0, min(self.cursor, len(entries) - 1))
        return entries[self.cursor] if entries else None

    def watch(self, snapshot: Snapshot, job: Job | None, now: datetime, opened: Callable[[Entry], None]) -> None:
        """Takes over new alarms, calling `opened` for each, and notes whose cause is gone."""
        if not snapshot.alarms:
            self._known.clear()  # a reset, or another run: the same alarm may come again
        reported = {_key(alarm) for alarm in snapshot.alarms}
        for alarm in snapshot.alarms:
            if _key(alarm) not in self._known:
                self._known.add(_key(alarm))
                entry = Entry(now, alarm, block_name(job.lines, alarm.line) if job and alarm.line else "")
                self.entries = [*self.entries[1 - MOST :], entry]
                opened(entry)
        bits = {axis.name: axis.bits for axis in snapshot.axes}
        for entry in self.entries:
            axis = entry.alarm.axis
            stays = _key(entry.alarm) in reported and (not axis or entry.name in bits.get(axis, ()))
            entry.active = entry.active and stays


def _key(alarm: Alarm) -> tuple[float, str, str]:
    return alarm.t_s, alarm.code, alarm.axis
