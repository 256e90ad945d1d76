"""What the operator may do in which state, and what is said about it. Knows the engine, not the screen."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from cnc_front.engine import Engine, Mode, State
from cnc_front.errors import UsageError
from tui.keys import LATE_S
from tui.states import RESUMABLE, STARTABLE, UNDERWAY
from tui.words import Words

#: Feed override, percent. The controller refuses 0.
LOW, HIGH, STEP = 5, 150, 5
#: Lowest dry-run feed, mm/min.
LOWEST_FEED = 1.0
SPEEDS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 0.0)
#: Rapid override, percent (ui-guide section 3).
RAPIDS = (25, 50, 100)
#: Levels of block delete that the key switches on, where none was chosen on the command line.
SKIP = tuple(range(10))
#: An announced reset waits so long for Enter, s.
ARMED_S = 3.0
#: The engine has not yet reported what was asked for less than this ago, s.
_ECHO_S = 0.3

Say = Callable[[str], None]


def number_of(text: str) -> float | None:
    """What was typed, with a point or a comma; None for what is no finite number."""
    try:
        number = float(text.strip().replace(",", "."))
    except ValueError:
        return None
    return number if math.isfinite(number) else None


class Operation:
    """Turns wishes into calls of the engine, or says why not. Every method returns at once."""

    def __init__(self, engine: Engine, words: Words, say: Say) -> None:
        self._engine, self._words, self._say = engine, words, say
        self.late_s = LATE_S
        #: told of every hold and reset
        self.stopped: Callable[[], None] = lambda: None
        self._armed_at = -ARMED_S
        self._override = (-1.0, 1.0)  # when, and what was asked for
        self._speed = (-1.0, 1.0)
        self._skip = engine.snapshot().switches.skip or SKIP

    @property
    def state(self) -> State:
        """What the controller reports."""
        return self._engine.snapshot().state

    @property
    def is_underway(self) -> bool:
        """A job has begun and is not over."""
        return self.state in UNDERWAY

    @property
    def is_resumable(self) -> bool:
        """`r` goes on."""
        return self.state in RESUMABLE

    # ---- motion

    def hold(self) -> None:
        """Never asks, never refuses, is never late."""
        self._engine.hold()
        self.stopped()

    def start(self, waited_s: float) -> None:
        """Cycle start from the top, or goes on; `waited_s`: age of the key."""
        state = self.state
        if self._is_late(waited_s):
            return
        if state in RESUMABLE:
            self._engine.resume()
        elif self._engine.snapshot().replay or state in STARTABLE:
            self._engine.start()
        else:
            self._refuse(state)

    def step(self, waited_s: float) -> None:
        """One block, from standstill."""
        state = self.state
        if self._is_late(waited_s):
            return
        if state in RESUMABLE or state in STARTABLE:
            self._engine.step()
        elif state in (State.RUNNING, State.WAITING, State.HOLDING):
            self._say(self._words("no_step"))
        else:
            self._refuse(state)

    def _is_late(self, waited_s: float) -> bool:
        if waited_s > self.late_s:
            self._say(self._words("dropped"))
        return waited_s > self.late_s

    def _refuse(self, state: State) -> None:
        reason = {State.NO_JOB: "no_job", State.HOLDING: "brakes", State.ALARM: "no_start_alarm"}
        self._say(self._words(reason.get(state, "runs_already")))

    def start_mdi(self, waited_s: float) -> bool:
        """Executes the MDI block that was checked; False if the key came too late."""
        if self._is_late(waited_s):
            return False
        self._engine.start_mdi()
        return True

    def jog(self, axis: str, distance: float, waited_s: float) -> None:
        """One step; presses during a step are dropped."""
        snapshot = self._engine.snapshot()
        if self.is_underway and snapshot.mode is not Mode.MANUAL:
            self._say(self._words("hand_busy"))
        elif not self.is_underway and not self._is_late(waited_s):
            self._engine.jog(axis, distance)

    def home(self, axes: Sequence[str]) -> None:
        """Home search, at standstill."""
        if self.is_underway:
            self._say(self._words("hand_busy"))
        else:
            self._engine.home(axes)

    def set_zero(self, axis: str) -> None:
        """Work zero, at standstill."""
        if self.is_underway:
            self._say(self._words("hand_busy"))
        else:
            self._engine.set_zero(axis)

    def force(self, number: int, on: bool | None = None) -> None:
        """Forces an input on or off; to what it is not, where that is not said."""
        if on is None:
            on = not self._engine.snapshot().inputs >> (number - 1) & 1
        self._engine.force_input(number, on)
        self._say(self._words("input_on" if on else "input_off", number=number))

    def release(self) -> None:
        """No input is forced any more."""
        forced = self._engine.snapshot().forced
        if forced:
            self._engine.release_inputs()
        self._say(self._words("released" if forced else "forced_none", numbers=" ".join(map(str, forced))))

    def switch(self, name: str) -> None:
        """Optional stop, block skip, dry-run feed, program test: on or off, at standstill before the start."""
        now = self._engine.snapshot().switches
        if self.is_underway:
            self._say(self._words("switch_spooled" if name in ("skip", "optional_stop") else "switch_standstill"))
            return
        changed = {
            "optional_stop": replace(now, optional_stop=not now.optional_stop),
            "skip": replace(now, skip=() if now.skip else self._skip),
            "dry_run": replace(now, dry_run=not now.dry_run),
            "program_test": replace(now, program_test=not now.program_test),
        }
        self._engine.set_switches(changed[name])

    def dry_feed_from(self, text: str) -> None:
        """Dry-run feed as typed, mm/min, at standstill before the start; nothing typed: that of the machine file."""
        s = self._engine.snapshot()
        feed = number_of(text) if text.strip() else None
        if self.is_underway:
            self._say(self._words("switch_standstill"))
        elif text.strip() and (feed is None or not LOWEST_FEED <= feed <= s.feed_limit):
            self._say(self._words("dry_feed_bad", text=text.strip()[:20], low=LOWEST_FEED, most=s.feed_limit))
        else:
            self._engine.set_switches(replace(s.switches, dry_feed=feed))
            said = "dry_feed_machine" if feed is None else "dry_feed_set" if s.switches.dry_run else "dry_feed_off"
            self._say(self._words(said, feed=feed))

    def change_rapid(self, by: int) -> None:
        """To the next of RAPIDS."""
        now = round(self._engine.snapshot().rapid_set * 100)
        place = min(range(len(RAPIDS)), key=lambda i: abs(RAPIDS[i] - now))
        self._engine.set_rapid(RAPIDS[min(max(place + by, 0), len(RAPIDS) - 1)] / 100)

    def toggle_single_block(self) -> None:
        """Stops at block ends, or no more."""
        self._engine.set_single_block(not self._engine.snapshot().single_block)

    # ---- reset, in two keys

    @property
    def is_armed(self) -> bool:
        """Enter would reset now."""
        return time.monotonic() - self._armed_at < ARMED_S

    def arm_reset(self) -> None:
        """Announces; `confirm` within three seconds does it."""
        if self.state is not State.NO_JOB:
            self._armed_at = time.monotonic()

    def confirm(self) -> bool:
        """Resets if that was announced in time."""
        if not self.is_armed:
            return False
        self._armed_at = -ARMED_S
        if self.is_underway and not self._engine.snapshot().replay:
            self._say(self._words("reset_done"))
        self._engine.reset()
        self.stopped()
        return True

    # ---- override and speed

    def change_override(self, percent: float) -> None:
        """By so many percent points, from what is set now."""
        asked_at, asked = self._override
        now = asked if time.monotonic() - asked_at < _ECHO_S else self._engine.snapshot().override_set
        self.set_override(round(now * 100 + percent))

    def set_override(self, percent: float) -> None:
        """In percent, kept within LOW..HIGH."""
        factor = min(max(percent, LOW), HIGH) / 100
        self._override = (time.monotonic(), factor)
        self._engine.set_override(factor)

    def override_from(self, text: str) -> None:
        """What was typed."""
        percent = number_of(text.strip().rstrip("%"))
        if percent is not None and LOW <= percent <= HIGH:
            self.set_override(percent)
        else:
            self._say(self._words("override_bad", text=text.strip()[:20], low=LOW, high=HIGH))

    def seek(self, place: str) -> None:
        """Winds a recording."""
        try:
            self._engine.seek(place)
        except UsageError as error:
            self._say(str(error))

    def change_speed(self, by: int) -> None:
        """To the next of SPEEDS."""
        asked_at, asked = self._speed
        now = asked if time.monotonic() - asked_at < _ECHO_S else self._engine.snapshot().speed_factor
        order = [speed or float("inf") for speed in SPEEDS]
        place = min(range(len(order)), key=lambda i: (abs(order[i] - now) if now else -order[i], i))
        speed = SPEEDS[min(max(place + by, 0), len(SPEEDS) - 1)]
        self._speed = (time.monotonic(), speed)
        self._engine.set_speed(speed)
