"""Line mode for screen readers and scripts: one line for each event, one a second while a job runs, commands as words.

The same engine, the same rules (`Operation`) and the same messages as on the screen. A thread reads the commands, so
that a hold is passed on at once, whatever is being printed.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable
from datetime import datetime
from pathlib import Path
from typing import TextIO

from cnc_front.engine import Engine, State
from cnc_front.errors import CompileError, UsageError
from cnc_front.messages import text as message
from cnc_front.outcome import Outcome
from tui.archive import Archive
from tui.keeper import Keeper
from tui.look import make_look
from tui.messages import Messages
from tui.operation import number_of
from tui.plain_controller import Controller
from tui.plain_desk import Desk
from tui.plain_hand import Hand
from tui.plain_mdi import Mdi
from tui.plain_queue import Queue
from tui.plain_search import Search
from tui.plain_words import VERBS, nearest, verb_of, way
from tui.program import block_name
from tui.rows import clean
from tui.states import FACES, UNDERWAY
from tui.values import Shown, minutes, progress
from tui.words import Words

#: How often it looks at the engine, s.
TICK_S = 0.05
#: `wait` gives a command this long to have an effect, s.
ECHO_S = 0.5
#: After the input ended: longest wait for standstill, s.
STANDSTILL_S = 5.0


class Plain:
    """A session. `clock`: the time of day."""

    def __init__(
        self, engine: Engine, words: Words, out: TextIO, archive: Archive, clock: Callable[[], datetime] = datetime.now
    ) -> None:
        self._engine, self._words, self._out, self._clock = engine, words, out, clock
        self._messages = Messages(words)
        self._desk = Desk(engine, words, self._print)
        self._operation = self._desk.operation
        self._hand, self._mdi, self._queue = Hand(self._desk), Mdi(self._desk), Queue(self._desk)
        self._keeper = Keeper(engine, archive, self._print)
        self._look = make_look("mono", "ascii")
        self._commands: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        own = {verb.id: getattr(self, f"_do_{verb.id}") for verb in VERBS if hasattr(self, f"_do_{verb.id}")}
        #: what each command does with the words behind it
        self.deeds: dict[str, Callable[[str], None]] = dict(own)
        for room in (Search(self._desk), Controller(self._desk), self._hand, self._mdi, self._queue):
            self.deeds |= room.deeds()
        self._message = ""
        self._every_s, self._told_at = 1.0, 0.0
        self._waits_until: float | None = None
        self._asked_at = 0.0
        self._revision = 0
        self._outcome = 0
        self._is_over = False

    # ---- the loop

    def run(self, lines: Iterable[str], job: str | None = None) -> None:
        """Until `quit` or the end of the input, which holds."""
        self._print(self._words("start_line"))
        self._print(self._words("plain_hello"))
        if job is not None:
            self._load(job)
        threading.Thread(target=self._read, args=(lines,), name="commands", daemon=True).start()
        while not self._is_over:
            self._watch()
            self._obey()
        self._watch()

    def _read(self, lines: Iterable[str]) -> None:
        """The thread that reads: a hold goes to the engine before anything else happens."""
        for line in lines:
            if verb_of(line.split()[0] if line.split() else "") == "hold":
                self._operation.hold()
            self._commands.put(line)
        self._commands.put(None)

    def hold(self) -> None:
        """Feed hold, from a signal."""
        self._operation.hold()

    def _obey(self) -> None:
        if self._waits_until is not None:
            time.sleep(TICK_S)
            state = self._operation.state
            rests = state in _STANDS or (state not in UNDERWAY and not self._queue.goes_on)
            is_settled = time.monotonic() - self._asked_at > ECHO_S and rests
            if is_settled or time.monotonic() > self._waits_until:
                self._waits_until = None
            return
        try:
            line = self._commands.get(timeout=TICK_S)
        except queue.Empty:
            return
        if line is None:
            self._end_of_input()
        else:
            self._do(line)

    def _end_of_input(self) -> None:
        """Nobody is there any more: a closed terminal holds."""
        if self._operation.state in (State.RUNNING, State.WAITING):
            self._operation.hold()
            self._print(self._words("hold_hup"))
        deadline = time.monotonic() + STANDSTILL_S
        while self._operation.state in (State.RUNNING, State.HOLDING) and time.monotonic() < deadline:
            time.sleep(TICK_S)
        self._is_over = True

    # ---- what is told

    def _shown(self) -> Shown:
        return Shown(self._engine.snapshot(), self._desk.job, self._look, self._words)

    def _watch(self) -> None:
        """Tells what happened since the last look, and once in a while how far the job is."""
        self._follow()
        shown, now = self._shown(), time.monotonic()
        before = len(self._messages.log)
        self._messages.watch(shown, self._clock())
        self._keeper.watch(shown, self._clock())
        for entry in list(self._messages.log)[before:] if before < len(self._messages.log) else ():
            self._print(" ".join(part for part in (entry.clock, entry.code, entry.text) if part))
        if len(self._messages.log) > 100:
            self._messages.log.clear()
        for room in (self._hand, self._mdi):
            room.watch(shown.snapshot)
        outcome = self._engine.outcome()
        if outcome is not None and outcome.number != self._outcome:
            self._outcome = outcome.number
            self._tell_outcome(outcome)
        self._queue.watch(shown.snapshot, outcome)
        if shown.snapshot.state is State.RUNNING and self._every_s and now - self._told_at >= self._every_s:
            self._told_at = now
            self._print(self._status(shown))

    def _follow(self) -> None:
        """The job as it is loaded now, and what the machine has to say."""
        snapshot = self._engine.snapshot()
        if snapshot.revision != self._revision:
            self._revision = snapshot.revision
            self._desk.job = self._engine.current_job() or self._desk.job
        if snapshot.message != self._message:
            self._message = snapshot.message
            if self._message and not snapshot.replay:
                self._print(self._message)

    def _print(self, text: str) -> None:
        self._out.write("\n".join(clean(line) for line in text.split("\n")) + "\n")
        self._out.flush()

    def _status(self, shown: Shown) -> str:
        s, words = shown.snapshot, self._words
        face = FACES[s.state]
        place = block_name(shown.job.lines, s.line) if shown.job and s.line else ""
        axes = " ".join(f"{axis.name} {axis.actual:+.3f}" for axis in s.axes)
        share = int(progress(s) * 100)
        parts = [
            f"{words.pick(face.english, face.german)} {place}".strip(),
            axes,
            f"F {s.feed_actual:.0f}",
            f"{words('override')} {s.override_set * 100:.0f} %",
            f"{share} %, {minutes(s.machine_time_s)} / {minutes(s.time_total_s)}",
            f"{words('deviation')} max {s.deviation_max_mm * 1000:.1f} um",
        ]
        return ", ".join(part for part in parts if part)

    def _tell_outcome(self, outcome: Outcome) -> None:
        verdict, language = outcome.run["verdict"], self._words.language
        self._print(f"{self._words('report_title')} {Path(outcome.path).name}: {verdict['word']}")
        for reason in verdict["reasons"]:
            values = {key: value for key, value in reason.items() if key != "id"}
            self._print(message(reason["id"], language, **values))
        for finding in outcome.worst:
            name = block_name(outcome.report.job_lines, finding.line)
            self._print(f"{name}: max {finding.max_um:.1f} um, RMS {finding.rms_um:.1f} um: {finding.text}")

    # ---- commands

    def _do(self, line: str) -> None:
        words = line.split()
        verb = verb_of(words[0] if words else "")
        if verb is None:
            near, text = nearest(words[0]), line.strip()[:40]
            if near is not None:
                self._print(self._words("plain_near", text=text, near=way(near, self._words.language)))
            else:
                self._print(self._words("plain_unknown", text=text))
            return
        if verb != "yes":
            self._desk.pending = None
        if verb != "wait":
            self._asked_at = time.monotonic()
        if verb in ("jog", "yes", "start"):
            self._message = ""  # the same refusal again is told again
        self.deeds[verb](line.strip().partition(" ")[2].strip())

    def _do_yes(self, _: str) -> None:
        self._desk.answer()

    def _do_hold(self, _: str) -> None:
        """The reading thread has passed it on already, perhaps before a command that stood in front of it."""
        self._operation.hold()
        self._print(self._words("plain_hold"))

    def _do_step(self, text: str) -> None:
        if text:
            self._hand.set_step(text)
        else:
            self._operation.step(0.0)

    def _do_reset(self, text: str) -> None:
        if text.lower() in ("yes", "ja"):
            self._operation.arm_reset()
            self._operation.confirm()
        else:
            self._print(self._words("plain_reset"))

    def _do_single(self, _: str) -> None:
        self._operation.toggle_single_block()
        on = not self._engine.snapshot().single_block
        self._print(self._words("plain_single_on" if on else "plain_single_off"))

    def _do_override(self, text: str) -> None:
        self._operation.override_from(text)

    def _do_speed(self, text: str) -> None:
        factor = 0.0 if text in ("max", "0") else number_of(text)
        if factor is None or not 0 <= factor <= 1000:
            self._print(self._words("plain_speed_bad", text=text[:20]))
        else:
            self._engine.set_speed(factor)

    def _do_status(self, _: str) -> None:
        shown = self._shown()
        self._print(self._status(shown))
        current = self._messages.current(shown, False)[0]
        if current:
            self._print(current)

    def _do_position(self, _: str) -> None:
        for axis in self._engine.snapshot().axes:
            self._desk.tell_axis(axis)

    def _do_alarms(self, _: str) -> None:
        entries = self._keeper.book.open
        for entry in entries:
            state = self._words("alarm_active" if entry.active else "alarm_gone")
            place = f"{entry.alarm.code} {entry.alarm.axis} {entry.block}".strip()
            self._print(f"{entry.at:%H:%M:%S} {place} {state}: {entry.alarm.text}")
        if not entries:
            self._print(self._words("alarms_none"))

    def _do_acknowledge(self, _: str) -> None:
        gone = [entry for entry in self._keeper.book.open if not entry.active]
        for entry in gone:
            self._keeper.acknowledge(entry)
            self._print(self._words("ack_done", code=entry.alarm.code, axis=entry.alarm.axis))
        for entry in self._keeper.book.open:
            self._print(self._words("ack_refused", code=entry.alarm.code, axis=entry.alarm.axis, name=entry.name))

    def _do_report(self, _: str) -> None:
        outcome = self._engine.outcome()
        if outcome is None:
            self._print(self._words("report_none"))
        else:
            self._tell_outcome(outcome)

    def _do_export(self, text: str) -> None:
        from tui.export import export

        outcome = self._engine.outcome()
        self._print(self._words("report_none") if outcome is None else export(outcome, text, self._words)[0])

    def _do_load(self, text: str) -> None:
        if self._operation.is_underway:
            self._print(self._words("job_busy"))
        else:
            self._load(text)

    def _load(self, path: str) -> None:
        try:
            job = self._engine.load(path)
        except (CompileError, UsageError, OSError) as error:
            self._desk.refuse(error, path)
        else:
            self._desk.job, self._desk.block = job, None
            deadline = time.monotonic() + ECHO_S
            while self._operation.state is State.NO_JOB and time.monotonic() < deadline:
                time.sleep(TICK_S / 5)
            total = self._engine.snapshot().path_total_mm
            self._print(self._words("loaded", name=job.name, lines=len(job.lines), path=total))
            for name, (low, high) in job.extents.items():
                self._print(f"{name} {low:+.3f} .. {high:+.3f}")
            for warning in job.warnings[:20]:
                self._print(warning)

    def _do_wait(self, text: str) -> None:
        """Until the job stands, at most so many seconds."""
        self._waits_until = time.monotonic() + (number_of(text) or 86400.0)

    def _do_every(self, text: str) -> None:
        seconds = number_of(text)
        if seconds is None or not 0 <= seconds <= 3600:
            self._print(self._words("plain_every_bad", text=text[:20]))
        else:
            self._every_s = seconds

    def _do_help(self, _: str) -> None:
        for verb in VERBS:
            self._print(way(verb.id, self._words.language))
        self._print(self._words("help_stop"))

    def _do_quit(self, text: str) -> None:
        if self._operation.is_underway and text.lower() not in ("yes", "ja"):
            self._operation.hold()
            self._print(self._words("plain_quit"))
        else:
            self._is_over = True


#: States in which the job goes on only by a command.
_STANDS = (State.HOLD, State.STEP, State.STOPPED)
