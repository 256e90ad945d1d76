"""Jobs that run one after the other. One that fails does not stop the rest, unless that was asked for."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Engine, Snapshot, State
from cnc_front.errors import CompileError, Exit, UsageError
from cnc_front.german import localized
from tui.states import UNDERWAY
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome


@dataclass(slots=True)
class Queued:
    """A job of the queue. `state`: waiting, loading, loaded, running, done."""

    path: str
    state: str = "waiting"
    verdict: str = ""
    detail: str = ""
    findings: tuple[Diagnostic, ...] = ()
    #: number of the outcome that was there when it started
    before: int = 0

    @property
    def name(self) -> str:
        """For people."""
        return Path(self.path).name


class JobQueue:
    """The queue; `say` tells what happens. Jobs are loaded in threads of their own."""

    def __init__(self, engine: Engine, words: Words, say: Callable[[str], None]) -> None:
        self._engine, self._words, self._say = engine, words, say
        self.entries: list[Queued] = []
        self.is_active = False
        self.stops_at_failure = False
        self._current: Queued | None = None

    def add(self, path: str) -> None:
        """Puts a job at the end."""
        self.entries.append(Queued(path))

    def remove(self, index: int) -> None:
        """Takes a job out, unless it is the one being run."""
        if 0 <= index < len(self.entries) and self.entries[index] is not self._current:
            del self.entries[index]

    def start(self) -> None:
        """Runs what waits; once everything is done, all of it again."""
        if not self.entries:
            self._say(self._words("queue_empty"))
        elif self._engine.snapshot().state in UNDERWAY:
            self._say(self._words("job_busy"))
        else:
            if all(entry.state == "done" for entry in self.entries):
                self.entries = [Queued(entry.path) for entry in self.entries]
            self.is_active = True

    def stop(self) -> None:
        """The job that runs is the last one."""
        self.is_active = False
        self._say(self._words("queue_stops"))

    def watch(self, snapshot: Snapshot, outcome: Outcome | None) -> None:
        """Called for every frame: takes the next step."""
        entry = self._current
        if entry is None:
            if self.is_active:
                self._next(snapshot)
        elif entry.state == "loaded" and snapshot.state is State.READY:
            entry.before = outcome.number if outcome else 0
            entry.state = "running"
            self._engine.start()
        elif entry.state == "running" and outcome is not None and outcome.number != entry.before:
            self._ended(entry, outcome)
        elif entry.state == "done":
            self._current = None
            self._after(entry)

    def _next(self, snapshot: Snapshot) -> None:
        waiting = [entry for entry in self.entries if entry.state == "waiting"]
        if not waiting:
            self.is_active = False
            good = sum(entry.verdict in ("PASS", "WARN") for entry in self.entries)
            self._say(self._words("queue_done", good=good, all=len(self.entries)))
        elif snapshot.state not in UNDERWAY:
            self._current = waiting[0]
            waiting[0].state = "loading"
            threading.Thread(target=self._load, args=(waiting[0],), name="queue-load", daemon=True).start()

    def _load(self, entry: Queued) -> None:
        try:
            self._engine.load(entry.path)
            entry.state = "loaded"
        except CompileError as error:
            entry.findings = localized(error.diagnostics, self._words.language)
            first = next((d for d in entry.findings if not d.is_warning), entry.findings[0])
            entry.detail = f"{first.line}:{first.column}: {first.id}: {first.message}"
            entry.verdict, entry.state = "ERROR", "done"
        except (UsageError, OSError) as error:
            entry.verdict, entry.detail = "ERROR", str(error)
            entry.state = "done"

    def _ended(self, entry: Queued, outcome: Outcome) -> None:
        run = outcome.run
        entry.verdict, entry.state = run["verdict"]["word"], "done"
        worst = outcome.worst[0] if outcome.worst else None
        place = f" @L{worst.line}" if worst else ""
        entry.detail = f"max {run['deviation']['actual']['max_mm'] * 1e3:.1f} um{place}, {run['machine_time_s']:.1f} s"
        if outcome.code == Exit.INTERRUPTED:
            entry.verdict = "ABORT"

    def _after(self, entry: Queued) -> None:
        """Whether the queue goes on: an operator's reset always ends it."""
        failed = entry.verdict not in ("PASS", "WARN")
        if self.is_active and (entry.verdict == "ABORT" or (failed and self.stops_at_failure)):
            self.is_active = False
            self._say(self._words("queue_stopped", name=entry.name, verdict=entry.verdict))
