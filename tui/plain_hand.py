"""The operator's hand in the line mode: jog by steps, home, work zero, with the questions and refusals of Manual."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from cnc_front.engine import Snapshot
from tui.operation import number_of
from tui.pages.manual import STEPS, home_question
from tui.plain_desk import Desk
from tui.plain_words import part_of
from tui.states import UNDERWAY

#: Where nothing has changed after so long, nothing will, s.
EFFECT_S = 0.5
_JOG = re.compile(r"(\S*?)\s*([+-])")


@dataclass(slots=True)
class Awaited:
    """Something that was asked of axes, to be told once it is over. `before`: what `value` gave then."""

    value: Callable[[Snapshot], object]
    before: object
    tell: Callable[[Snapshot], None]
    asked_at: float
    is_seen: bool = False

    def is_over(self, s: Snapshot) -> bool:
        """It has had its effect and stands, or has none."""
        self.is_seen |= s.state in UNDERWAY or self.value(s) != self.before
        return s.state not in UNDERWAY and (self.is_seen or time.monotonic() - self.asked_at > EFFECT_S)


class Hand:
    """Moves axes."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._steps: dict[str, float] = {}
        self._awaited: Awaited | None = None

    def deeds(self) -> dict[str, Callable[[str], None]]:
        """What its commands do."""
        return {"jog": self._jog, "home": self._home, "zero": self._zero}

    def watch(self, s: Snapshot) -> None:
        """Tells where axes are when they have arrived."""
        if self._awaited is not None and self._awaited.is_over(s):
            self._awaited.tell(s)
            self._awaited = None

    def _await(self, value: Callable[[Snapshot], object], tell: Callable[[Snapshot], None]) -> None:
        self._awaited = Awaited(value, value(self._desk.engine.snapshot()), tell, time.monotonic())

    def _await_axes(self, names: Sequence[str]) -> None:
        """Axes move; their places are told."""

        def tell(s: Snapshot) -> None:
            for axis in s.axes:
                if axis.name in names:
                    self._desk.tell_axis(axis)

        self._await(lambda s: [axis.command for axis in s.axes if axis.name in names], tell)

    # ---- jog

    def set_step(self, text: str) -> None:
        """How far a jog of an axis goes: `X 0.1`."""
        desk, (name, _, size) = self._desk, text.partition(" ")
        axis, step = desk.axis(name), number_of(size)
        if axis is None:
            return
        if step is None or not STEPS[0] <= step <= STEPS[-1]:
            desk.say(desk.words("plain_jog_bad", text=size.strip()[:20] or "?", low=STEPS[0], most=STEPS[-1]))
        else:
            self._steps[axis.name] = step
            desk.say(desk.words("plain_jog_step", axis=axis.name, step=step, unit=axis.unit))

    def _jog(self, text: str) -> None:
        desk, match = self._desk, _JOG.fullmatch(text)
        if match is None or not match[1]:
            desk.usage("jog")
        elif self._awaited is not None:
            desk.say(desk.words("plain_jog_moves"))
        elif (axis := desk.axis(match[1])) is not None and desk.is_free():
            distance = self._steps.get(axis.name, STEPS[2]) * (1 if match[2] == "+" else -1)
            desk.say(desk.words("plain_jogs", axis=axis.name, distance=distance, unit=axis.unit))
            self._await_axes([axis.name])
            desk.operation.jog(axis.name, distance, 0.0)

    # ---- home, work zero

    def _home(self, text: str) -> None:
        desk = self._desk
        if not text:
            desk.usage("home")
        elif part_of(text) == "all":
            axes = sorted(desk.engine.snapshot().axes, key=lambda axis: axis.home_place)
            self._ask_home([axis.name for axis in axes])
        elif (axis := desk.axis(text)) is not None:
            self._ask_home([axis.name])

    def _ask_home(self, wanted: Sequence[str]) -> None:
        desk = self._desk
        axes = {axis.name: axis for axis in desk.engine.snapshot().axes}
        if not desk.is_free():
            return
        names, question = home_question([axes[name] for name in wanted], desk.words)
        if names:
            desk.ask(question, lambda: self._go_home(names))
        else:
            desk.say(question)

    def _go_home(self, names: Sequence[str]) -> None:
        if self._desk.is_free():
            self._await_axes(names)
            self._desk.operation.home(names)

    def _zero(self, text: str) -> None:
        desk = self._desk
        if not text:
            desk.usage("zero")
        elif (axis := desk.axis(text)) is not None and desk.is_free():
            name = axis.name
            question = desk.words("zero_ask", axis=name, at=axis.command, was=axis.zero)
            desk.ask(question, lambda: self._set_zero(name))

    def _set_zero(self, name: str) -> None:
        desk = self._desk

        def tell(s: Snapshot) -> None:
            for axis in s.axes:
                if axis.name == name:
                    at = axis.actual - axis.zero + 0.0
                    desk.say(desk.words("plain_zero_now", axis=name, zero=axis.zero, at=at))

        if desk.is_free():
            self._await(lambda s: [axis.zero for axis in s.axes if axis.name == name], tell)
            desk.operation.set_zero(name)
