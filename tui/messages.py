"""The message line: what matters most now, the rest behind `n`, and the log of this session."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

from cnc_front.engine import Snapshot, State, Stop
from cnc_front.german import one_line
from tui.program import block_name
from tui.states import FACES, RESUMABLE
from tui.values import Shown
from tui.words import TEXTS, Words

#: What was said stays in the line for so long, s.
SAID_S = 8.0
#: Lines of the log kept.
LOG = 500


@dataclass(frozen=True, slots=True)
class Logged:
    """One line of the log of this session."""

    clock: str
    code: str
    text: str


class Messages:
    """Collects what was said and what the state says."""

    def __init__(self, words: Words, clock: str = "%H:%M:%S") -> None:
        self._words, self._format = words, clock
        self._said = ("", -SAID_S)
        self.log: deque[Logged] = deque(maxlen=LOG)
        self._known: set[tuple[float, str, str]] = set()
        self._state: State | None = None
        self._state_at = 0.0
        self._since = ""
        self.index = 0

    def say(self, text: str, now: datetime, code: str = "") -> None:
        """Shows a message for some seconds and keeps it in the log."""
        self._said, self.index = (text, time.monotonic()), 0
        self.log.append(Logged(now.strftime(self._format), code, text))

    def watch(self, shown: Shown, now: datetime) -> None:
        """Puts changes of state and new alarms into the log."""
        s, clock = shown.snapshot, now.strftime(self._format)
        if s.state is not self._state:
            face = FACES[s.state]
            words = [self._words.pick(face.english, face.german), self._why(s)]
            place = block_name(shown.job.lines, s.line) if shown.job and s.line else ""
            self.log.append(Logged(clock, "", " ".join(word for word in (*words, place) if word)))
            self._since = clock
            self._state, self._state_at, self.index = s.state, time.monotonic(), 0
        if not s.alarms:
            self._known.clear()
        for alarm in s.alarms:
            key = (alarm.t_s, alarm.code, alarm.axis)
            if key not in self._known:
                self._known.add(key)
                self.log.append(Logged(clock, alarm.code, f"{alarm.axis} {alarm.text}".strip()))

    def _why(self, s: Snapshot) -> str:
        """Why it stands, where the state's own word does not say it."""
        if s.state in (State.STOPPED, State.ALARM):
            return s.why
        if s.state is not State.WAITING:
            return ""
        numbers = ", ".join(str(number) for number in s.waits_for)
        return self._words(f"wait_{s.why}", numbers=numbers) if f"wait_{s.why}" in TEXTS else s.why

    def next(self) -> None:
        """The next message."""
        self.index += 1

    def current(self, shown: Shown, armed: bool) -> tuple[str, str, bool]:
        """Text, name of its style, and whether there are more."""
        if armed:
            return self._words("reset_armed"), "hold", False
        active = list(self._active(shown))
        if not active:
            return "", "dim", False
        text, style = active[self.index % len(active)]
        return text, style, len(active) > 1

    def _active(self, shown: Shown) -> Iterator[tuple[str, str]]:
        s, words, job = shown.snapshot, self._words, shown.job
        said, at = self._said
        of_state = self._of_state(shown), "hold" if s.state in RESUMABLE else "text"
        if s.replay and s.message:
            yield s.message, "strong"
        if of_state[0] and self._state_at > at:
            yield of_state
        if said and time.monotonic() - at < SAID_S:
            yield said, "strong"
        for alarm in reversed(s.alarms):
            place = f" {block_name(job.lines, alarm.line)}" if job and alarm.line else ""
            yield f"{alarm.code} {alarm.axis}{place} {alarm.text}", "alarm" if alarm.stopped else "bad"
        if of_state[0] and self._state_at <= at:
            yield of_state
        if s.message and not s.replay:
            yield s.message, "strong"
        if job and s.deviation_max_mm > job.tolerance_mm:
            block, limit = block_name(job.lines, s.deviation_max_line), job.tolerance_mm * 1000
            over = words("deviation_over", block=block, um=s.deviation_max_mm * 1000, limit=limit)
            yield f"! {over} {words('tolerance_of')}", "bad"
        for warning in job.warnings if job else ():
            yield f"! {one_line(warning, words.language)}", "warn"
        if s.state in (State.NO_JOB, State.READY):
            yield words("start_line"), "dim"

    def _of_state(self, shown: Shown) -> str:
        """Why it stands, since when, which of the four stops that is, and what goes on from there."""
        s, words = shown.snapshot, self._words
        if s.state is State.STOPPED:
            known = f"stopped_{s.why}"
            text = words(known, tool=s.tool) if known in TEXTS else words("stopped", why=s.why)
            return f"{text} ({self._since})"
        if s.state is State.WAITING:
            return words("waits_since", what=self._why(s), clock=self._since)
        if s.state is State.RUNNING and s.why == "home":
            return words("hand_does_home")
        if s.state in (State.HOLD, State.STEP, State.ABORTED, State.ALARM) and s.stop is not Stop.NONE:
            return words(f"stop_{s.stop.name.lower()}")
        return {State.HOLD: words("hold_text"), State.STEP: words("step_text")}.get(s.state, "")
