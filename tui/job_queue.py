"""Jobs that run one after the other. One that fails does not stop the rest, unless that was asked for.

A reset, an alarm and a hold between two jobs make the queue stand: it says why, loses nothing, and goes on on demand.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Engine, Job, Snapshot, State
from cnc_front.errors import CompileError, Exit, UsageError
from cnc_front.german import localized, refusal
from tui.states import UNDERWAY
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome


#: Longest time until a loaded job is ready to start, s.
READY_S = 5.0


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
    #: what the engine loaded; when it was loaded or started, monotonic time
    job: Job | None = None
    since: float = 0.0

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
        #: why it stands before its end; empty: it does not
        self.why = ""
        self._current: Queued | None = None

    def add(self, path: str) -> None:
        """Puts a job at the end."""
        self.entries.append(Queued(path))

    def remove(self, index: int) -> None:
        """Takes a job out, unless it is the one being run."""
        if 0 <= index < len(self.entries) and self.entries[index] is not self._current:
            del self.entries[index]

    def move(self, index: int, by: int) -> int:
        """Exchanges a job with its neighbour `by` (-1: before, 1: behind). Returns where it is then."""
        to = index + by
        if not (0 <= index < len(self.entries) and 0 <= to < len(self.entries)):
            return index
        self.entries[index], self.entries[to] = self.entries[to], self.entries[index]
        return to

    def start(self) -> None:
        """Runs what waits, so behind a stop the next one; once everything is done, all of it again."""
        if not self.entries:
            self._say(self._words("queue_empty"))
        elif self._engine.snapshot().state in UNDERWAY:
            self._say(self._words("job_busy"))
        elif self._engine.snapshot().state is State.ALARM:
            self._say(self._words("queue_alarm"))
        else:
            if all(entry.state == "done" for entry in self.entries):
                self.entries = [Queued(entry.path) for entry in self.entries]
            self.is_active, self.why = True, ""

    def held(self) -> None:
        """The operator holds or resets: between two jobs nothing starts any more."""
        if self.is_active and (self._current is None or self._current.state != "running"):
            self._stand(self._words("queue_held"))

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
        elif entry.state == "loaded":
            self._begin(entry, snapshot, outcome)
        elif entry.state == "running" and outcome is not None and outcome.number != entry.before:
            self._ended(entry, outcome)
        elif entry.state == "running" and snapshot.state is State.READY:
            self._give_up(entry)  # a hold came before the start
        elif entry.state == "done":
            self._current = None
            self._after(entry, snapshot)

    def _begin(self, entry: Queued, snapshot: Snapshot, outcome: Outcome | None) -> None:
        """Starts what was loaded; what must not or cannot start waits on."""
        if self.why:
            self._current, entry.state = None, "waiting"
        elif snapshot.state is State.READY and self._engine.current_job() is entry.job:
            entry.before, entry.since = outcome.number if outcome else 0, time.monotonic()
            entry.state = "running"
            self._engine.start()
        else:
            self._give_up(entry)

    def _give_up(self, entry: Queued) -> None:
        """What does not start in time makes the queue stand before it."""
        if time.monotonic() - entry.since > READY_S:
            self._current, entry.state = None, "waiting"
            self._stand(self._words("queue_not_ready", name=entry.name))

    def _stand(self, why: str) -> None:
        self.is_active, self.why = False, why
        self._say(self._words("queue_stands", why=why))

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
            entry.job, entry.since = self._engine.load(entry.path), time.monotonic()
            entry.state = "loaded"
        except CompileError as error:
            entry.findings = localized(error.diagnostics, self._words.language)
            first = next((d for d in entry.findings if not d.is_warning), entry.findings[0])
            entry.detail = f"{first.line}:{first.column}: {first.id}: {first.message}"
            entry.verdict, entry.state = "ERROR", "done"
        except (UsageError, OSError) as error:
            entry.verdict, entry.detail = "ERROR", refusal(error, self._words.language)
            entry.state = "done"

    def _ended(self, entry: Queued, outcome: Outcome) -> None:
        run = outcome.run
        entry.verdict, entry.state = run["verdict"]["word"], "done"
        worst = outcome.worst[0] if outcome.worst else None
        place = f" @L{worst.line}" if worst else ""
        most = run["deviation"]["actual"]["max_mm"]
        path = "-" if most is None else f"max {most * 1e3:.1f} um{place}"
        entry.detail = f"{path}, {run['machine_time_s']:.1f} s"
        if outcome.code == Exit.INTERRUPTED:
            entry.verdict = "ABORT"

    def _after(self, entry: Queued, snapshot: Snapshot) -> None:
        """Whether the queue goes on: an operator's reset and an alarm always make it stand."""
        failed = entry.verdict not in ("PASS", "WARN")
        stands = entry.verdict == "ABORT" or snapshot.state is State.ALARM or (failed and self.stops_at_failure)
        if self.is_active and stands and any(other.state == "waiting" for other in self.entries):
            alarm = f", {self._words('queue_by_alarm')}" if snapshot.state is State.ALARM else ""
            self._stand(f"{entry.name}: {entry.verdict}{alarm}")
