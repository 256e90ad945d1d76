"""The message line: what matters most now, the rest behind `n`, and the log of this session."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from textwrap import wrap

from cnc_front.engine import Alarm, Job, Snapshot, State, Stop
from cnc_front.german import one_line
from tui.program import block_name
from tui.states import FACES, RESUMABLE
from tui.values import Shown
from tui.words import TEXTS, Words

#: What was said stays in the line for so long, s.
SAID_S = 8.0
#: Warnings behind `n`; the Jobs screen lists them all.
MOST_WARNINGS = 50
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
        self._replayed = ""  # the last message of a recording
        self.index = 0
        #: what goes on just now, before everything else
        self.activity = ""

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
        if s.replay and s.message != self._replayed:
            self._replayed = s.message
            if s.message:
                self.log.append(Logged(clock, "", s.message))
        if not s.alarms:
            self._known.clear()
        for alarm in s.alarms:
            key = (alarm.t_s, alarm.code, alarm.axis)
            if key not in self._known:
                self._known.add(key)
                self.log.append(Logged(clock, alarm.code, _placed(alarm, shown.job)))

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

    def current(self, shown: Shown, armed: bool, width: int = 1000) -> tuple[str, str, bool]:
        """Text, name of its style, and whether there are more. What does not fit into `width` comes in parts."""
        if armed:
            return self._words("replay_reset" if shown.snapshot.replay else "reset_armed"), "hold", False
        active = list(self._active(shown))
        alone = len(active) == 1 and len(active[0][0]) <= width - 2
        room = width - 2 - (0 if alone else len(self._words("details")) + 1)
        parts = [(part, style) for text, style in active for part in _parts(text, room)]
        if not parts:
            return "", "dim", False
        text, style = parts[self.index % len(parts)]
        return text, style, len(parts) > 1

    def _active(self, shown: Shown) -> Iterator[tuple[str, str]]:
        s, words, job = shown.snapshot, self._words, shown.job
        said, at = self._said
        stands = [(text, "hold" if s.state in RESUMABLE else "text") for text in [self._of_state(shown)] if text]
        # what stopped the job comes first, then the newest
        newest = [a for stopped in (True, False) for a in s.alarms[::-1] if a.stopped is stopped]
        alarms = [(f"{a.code} {_placed(a, job)}", "alarm" if a.stopped else "bad") for a in newest]
        told = self._state_at <= at  # something was said since the state changed
        first, then = ([], [*alarms, *stands]) if told else (stands, alarms)
        if s.state is State.ALARM and not told:
            first, then = [*alarms, *stands], []
        if self.activity:
            yield self.activity, "strong"
        if s.replay and s.message:
            yield s.message, "strong"
        yield from first
        if said and time.monotonic() - at < SAID_S:
            yield said, "strong"
        yield from then
        if s.message and not s.replay:
            yield s.message, "strong"
        if job and s.deviation_max_mm > job.tolerance_mm:
            block, limit = block_name(job.lines, s.deviation_max_line), job.tolerance_mm * 1000
            over = words("deviation_over", block=block, um=s.deviation_max_mm * 1000, limit=limit)
            yield f"! {over} {words('tolerance_of')}", "bad"
        for warning in job.warnings[:MOST_WARNINGS] if job else ():
            yield f"! {one_line(warning, words.language)}", "warn"
        if s.state in (State.NO_JOB, State.READY):
            yield words("start_line"), "dim"

    def _of_state(self, shown: Shown) -> str:
        """Why it stands, since when, which of the four stops that is, and what goes on from there."""
        s, words = shown.snapshot, self._words
        if s.replay:
            return words("replay_paused") if s.state in (State.HOLD, State.STEP) else ""
        if s.state is State.STOPPED:
            known = f"stopped_{s.why}"
            text = words(known, tool=s.tool) if known in TEXTS else words("stopped", why=s.why)
            return f"{text} ({self._since})"
        if s.state is State.WAITING:
            return words("waits_since", what=self._why(s), clock=self._since)
        if s.state is State.RUNNING and s.why == "home":
            return words("hand_does_home")
        if s.state is State.HOLD and s.why == "jog":
            return s.message  # not all of it goes on
        if s.state in (State.HOLD, State.STEP, State.ABORTED, State.ALARM) and s.stop is not Stop.NONE:
            return words(f"stop_{s.stop.name.lower()}")
        return {State.HOLD: words("hold_text"), State.STEP: words("step_text")}.get(s.state, "")


def _placed(alarm: Alarm, job: Job | None) -> str:
    """Axis, block and text."""
    block = block_name(job.lines, alarm.line) if job and alarm.line else ""
    return " ".join(word for word in (alarm.axis, block, alarm.text) if word)


def _parts(text: str, width: int) -> list[str]:
    """A text in pieces of at most `width` cells; all but the last end with dots."""
    pieces = wrap(text, max(width - 4, 20)) if len(text) > width else [text]
    return [f"{piece} ..." for piece in pieces[:-1]] + pieces[-1:]
