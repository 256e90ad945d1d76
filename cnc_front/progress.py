"""What a run says on stderr while it goes on: what the program told the operator, and on a terminal how far it is."""

from __future__ import annotations

import sys
import time

from cnc_front.execution import Execution
from cnc_front.messages import text

#: Host events that operators care about; `run` acknowledges those that wait (design D29).
SHOWN = frozenset({"MSG", "M00", "M01", "M06", "M19", "M60"})
#: Lines printed at most: a loop of tool changes must not flood the screen.
MOST_LINES = 200
#: Wall seconds before the first progress line and between two.
EVERY_S = 0.5


class Progress:
    """Called after every chunk."""

    def __init__(self, language: str, *, quiet: bool) -> None:
        self._language = language
        self._quiet = quiet
        self._terminal = sys.stderr.isatty() and not quiet
        self._seen = 0
        self._printed = 0
        self._last = time.monotonic()
        self._drawn = False

    def __call__(self, execution: Execution) -> None:
        if self._quiet:
            return
        for event in execution.host_events[self._seen - execution.forgotten :]:
            if event.kind in SHOWN and self._printed < MOST_LINES:
                self._erase()
                values = {"t_s": event.t_s, "line": event.line, "kind": event.kind, "text": event.text}
                print(text("log_event", self._language, **values).rstrip(), file=sys.stderr)
                self._printed += 1
        self._seen = execution.forgotten + len(execution.host_events)
        self.at(execution.machine_time_s)

    def at(self, seconds: float) -> None:
        """Says how far the run is, machine time, on a terminal and not too often."""
        now = time.monotonic()
        if self._terminal and now - self._last >= EVERY_S:
            self._last, self._drawn = now, True
            running = text("running", self._language, seconds=seconds)
            print(f"\r{running}\x1b[K", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        """The run is over; the progress line goes away."""
        self._erase()

    def _erase(self) -> None:
        if self._drawn:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
            self._drawn = False
