"""The history behind the terminal: written and read in a thread of its own, since a disk may be slow or full.

What was read stands in attributes that are replaced whole; a frame shows what there is.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cnc_front.history import Filter, History, HistoryError, Row

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome

SOURCE = "tui"
#: Rows read for a screen.
ROWS = 100


class Archive:
    """Without a path nothing is kept and nothing found; every call returns at once."""

    def __init__(self, path: Path | None, language: str) -> None:
        self._history = History(path) if path is not None else None
        self._language = language
        self._worker = ThreadPoolExecutor(1, "history")
        #: newest run of each job; earlier alarms; earlier runs of the job that was asked for, newest first
        self.jobs: tuple[Row, ...] = ()
        self.alarms: tuple[Row, ...] = ()
        self.runs: tuple[Row, ...] = ()
        #: why the history is not used; told once
        self.trouble = ""

    def keep_run(self, outcome: Outcome) -> None:
        """A run is over. Its alarms were kept as they came."""
        self._do(lambda h: h.add_run(outcome.kept(), outcome.path, SOURCE, outcome.code, alarms=False) and None)
        self.read()

    def keep_alarm(self, alarm: Row, job: str, then: Callable[[int], None]) -> None:
        """An alarm came; `then` gets its number, in another thread."""
        self._do(lambda h: then(h.add_alarm(alarm, job, SOURCE)))

    def acknowledge(self, number: int) -> None:
        """The operator acknowledged an alarm."""
        self._do(lambda h: h.acknowledge(number))
        self.read()

    def read(self) -> None:
        """Reads jobs and alarms anew."""
        self._do(self._read)

    def look_up(self, job: str) -> None:
        """Reads the earlier runs of a job, whole."""

        def find(history: History) -> None:
            rows = history.runs(Filter(job=job, limit=ROWS))
            found = [
                history.run(row["id"]) for row in rows if row["job"] == job and row["deviation_max_mm"] is not None
            ]
            self.runs = tuple(row for row in found if row is not None)

        self.runs = ()
        self._do(find)

    def find_recording(self, job: str | None, then: Callable[[str], None]) -> None:
        """The newest recording that is still there, of a job or of any; `then` gets its path ("": none), in another
        thread."""

        def find(history: History) -> None:
            rows = history.runs(Filter(job=job, limit=ROWS))
            then(next((row["recording"] for row in rows if row["recording"] and Path(row["recording"]).is_file()), ""))

        if self._history is None or self.trouble:
            then("")
        self._do(find)

    def _read(self, history: History) -> None:
        self.jobs = tuple(history.recent_jobs(ROWS))
        self.alarms = tuple(history.alarms(Filter(limit=ROWS)))

    def _do(self, task: Callable[[History], Any]) -> None:
        if self._history is not None and not self.trouble:
            self._worker.submit(self._try, task, self._history)

    def _try(self, task: Callable[[History], Any], history: History) -> None:
        if self.trouble:
            return
        try:
            task(history)
        except HistoryError as error:
            self.trouble = error.in_language(self._language)

    def wait(self) -> None:
        """Until everything asked for is done."""
        self._worker.submit(lambda: None).result()

    def close(self) -> None:
        """Writes what is pending."""
        self._worker.shutdown(wait=True)
