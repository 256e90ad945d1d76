"""Jobs one after the other in the line mode: the queue of the Jobs screen, by words."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from cnc_front.engine import Snapshot
from tui.job_queue import JobQueue
from tui.plain_desk import Desk
from tui.plain_words import part_of

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome


class Queue:
    """Adds, lists, runs; tells the verdict of each job."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._queue = JobQueue(desk.engine, desk.words, desk.say)
        self._states: list[str] = []
        self._is_held = False
        desk.operation.stopped = self._held

    @property
    def goes_on(self) -> bool:
        """Another job may begin by itself."""
        return self._queue.is_active

    def deeds(self) -> dict[str, Callable[[str], None]]:
        """What its commands do."""
        return {"queue": self._do}

    def watch(self, snapshot: Snapshot, outcome: Outcome | None) -> None:
        """Takes the next step, and tells what has changed."""
        if self._is_held:
            self._is_held = False
            self._queue.held()
        self._queue.watch(snapshot, outcome)
        if self._is_held:
            self._desk.engine.hold()  # it came while the next job was being started
        states = [entry.state for entry in self._queue.entries]
        if states != self._states:
            for index, state in enumerate(states):
                if state in ("running", "done") and self._states[index : index + 1] != [state]:
                    self._tell(index)
            self._states = states

    def _held(self) -> None:
        """A hold or reset: it comes in the thread that reads, which must not wait for what is being said."""
        self._is_held = True

    def _tell(self, index: int) -> None:
        entry, words = self._queue.entries[index], self._desk.words
        state = f"{entry.verdict} {entry.detail}" if entry.state == "done" else words(f"queue_{entry.state}")
        self._desk.say(f"{words('list_queue')} {index + 1} {entry.name}: {state}")

    def _do(self, text: str) -> None:
        word, _, rest = text.partition(" ")
        doing = {"add": self._add, "remove": self._remove, "start": self._start, "stop": self._stop}
        part = part_of(word)
        if not word:
            self._list()
        elif part in doing and (rest or part in ("start", "stop")):
            doing[part](rest.strip())
        else:
            self._desk.usage("queue")

    def _list(self) -> None:
        for index in range(len(self._queue.entries)):
            self._tell(index)
        if not self._queue.entries:
            self._desk.say(self._desk.words("plain_queue_none"))

    def _add(self, path: str) -> None:
        desk, file = self._desk, Path(path).expanduser()
        if file.suffix.lower() == ".mcap":
            desk.say(desk.words("queue_recording"))
        elif not file.is_file():
            desk.say(desk.words("plain_queue_file", path=path[:200]))
        else:
            self._queue.add(str(file))
            self._states.append("waiting")
            desk.say(desk.words("queued", name=file.name, n=len(self._queue.entries)))

    def _remove(self, text: str) -> None:
        before = len(self._queue.entries)
        if text.isdecimal() and len(text) < 7:
            self._queue.remove(int(text) - 1)
        if len(self._queue.entries) == before:
            self._desk.say(self._desk.words("plain_queue_number", text=text[:20]))
        else:
            self._states = [entry.state for entry in self._queue.entries]
            self._list()

    def _start(self, _: str) -> None:
        self._desk.block = None
        if not self._queue.entries:
            self._desk.say(self._desk.words("plain_queue_none"))
        elif not self._queue.is_active:
            self._queue.start()
            self._states = [entry.state for entry in self._queue.entries]

    def _stop(self, _: str) -> None:
        if self._queue.is_active:
            self._queue.stop()
        else:
            self._list()
