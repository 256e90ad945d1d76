"""Manual: jog by steps, home, work zero; limits, loops, inputs, outputs and gains beside the axes.

A terminal tells no release of a key, so one press is one step; presses during a step are dropped.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from textual.strip import Strip

from cnc_front.engine import AxisValues, Mode, Snapshot, State
from tui.pages.base import Page
from tui.rows import Row
from tui.values import Shown
from tui.widgets import Body
from tui.words import Words

if TYPE_CHECKING:
    from tui.app import Terminal

#: Steps of `i`, mm or degrees.
STEPS = (0.001, 0.01, 0.1, 1.0, 10.0)
#: Without a step jogging ends by itself, s.
IDLE_S = 30.0
#: What arrows and page keys move, by the rows that they scroll elsewhere: letter, direction.
WAYS = {-1: ("Y", 1.0), 1: ("Y", -1.0), -20: ("Z", 1.0), 20: ("Z", -1.0)}
INPUTS, OUTPUTS = 16, 8


class ManualPage(Page):
    """Jog, home, work zero, inputs."""

    name = "manual"

    def __init__(self, app: Terminal) -> None:
        super().__init__(app)
        self.step = 2
        self.selected = 0
        self.is_on = False
        self._used = 0.0

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """Axes, keys, work zero, inputs and outputs, gains."""
        if self.is_on and time.monotonic() - self._used > IDLE_S:
            self._off("jog_idle")
        axes = shown.snapshot.axes
        self.selected = min(self.selected, max(0, len(axes) - 1))
        rows = [*axis_rows(shown, self.selected, STEPS[self.step], self.is_on), _rule(shown, width)]
        rows += key_rows(shown, self.selected, width)
        rows += [_rule(shown, width), *zero_rows(shown), *home_rows(shown), *input_rows(shown), *gain_rows(shown)]
        return [row.strip(width) for row in rows]

    # ---- what ends jogging

    def enter(self) -> None:
        """Jogging begins only with its key."""
        super().enter()
        self.is_on = False

    def leave(self) -> None:
        """Another page, or the terminal lost the focus."""
        self.is_on = False

    def escape(self) -> bool:
        """Jog off; one stays here."""
        was, self.is_on = self.is_on, False
        return was

    def _off(self, id: str) -> None:
        self.is_on = False
        self.app.say(self.app.words(id))

    def start(self, waited_s: float) -> bool:
        """A job does not start while jogging is on."""
        if self.is_on:
            self.app.say(self.app.words("jog_first"))
        return self.is_on

    # ---- keys

    def key_jog_on(self) -> None:
        """Jogging on or off."""
        if self.is_on:
            self.is_on = False
        elif self._is_free():
            self.is_on, self._used = True, time.monotonic()

    def key_way(self, direction: int) -> None:
        """Left and right: one step of the selected axis."""
        axes = self._axes()
        if axes:
            self._step(axes[self.selected], direction)

    def scroll(self, by: int) -> None:
        """Up and down: Y; page keys: Z."""
        letter, direction = WAYS[by]
        axis = next((axis for axis in self._axes() if axis.name == letter), None)
        if axis is None:
            self.app.say(self.app.words("no_axis", axis=letter))
        else:
            self._step(axis, direction)

    def wheel(self, event: Body.Wheel) -> None:
        """No mouse moves an axis."""

    def _step(self, axis: AxisValues, direction: float) -> None:
        if not self.is_on:
            self.app.say(self.app.words("jog_is_off"))
            return
        self._used = time.monotonic()
        self.app.operation.jog(axis.name, direction * STEPS[self.step], self.app.waited_s)

    def key_size(self) -> None:
        """The next step size."""
        self.step = (self.step + 1) % len(STEPS)

    def key_next_axis(self) -> None:
        """The next axis."""
        self.selected = (self.selected + 1) % max(1, len(self._axes()))

    def key_axis(self, letter: str) -> None:
        """An axis by its letter."""
        names = [axis.name for axis in self._axes()]
        if letter in names:
            self.selected = names.index(letter)
        else:
            self.app.say(self.app.words("no_axis", axis=letter))

    def key_home(self) -> None:
        """Asks, with way and direction, then homes the selected axis."""
        axes = self._axes()
        if axes and self._is_free():
            self._ask_home([axes[self.selected]])

    def key_home_all(self) -> None:
        """Asks, with order, ways and directions, then homes all axes that can be; away from the work first."""
        if self._is_free():
            self._ask_home(sorted(self._axes(), key=lambda axis: axis.home_place))

    def _ask_home(self, axes: Sequence[AxisValues]) -> None:
        names, title = home_question(axes, self.app.words)
        if names:
            self.app.ask(title, self.app.words("home_keys"), lambda _: self._home(names), field=False)
        else:
            self.app.say(title)

    def _home(self, names: Sequence[str]) -> None:
        self.is_on = False
        self.app.operation.home(names)

    def key_zero(self) -> None:
        """Asks, then the work zero of the selected axis is where it stands."""
        axes, words = self._axes(), self.app.words
        if axes and self._is_free():
            axis = axes[self.selected]
            title = words("zero_ask", axis=axis.name, at=axis.command, was=axis.zero)
            name = axis.name
            self.app.ask(title, words("zero_keys"), lambda _: self.app.operation.set_zero(name), field=False)

    def key_input(self) -> None:
        """Asks for the number of an input, and forces it to what it is not."""
        words = self.app.words
        self.app.ask(words("input_ask", last=INPUTS), words("field_keys"), self._force)

    def _force(self, text: str) -> None:
        number = int(text) if text.strip().isdecimal() and len(text) < 5 else 0
        if not 1 <= number <= INPUTS:
            self.app.say(self.app.words("input_bad", text=text.strip()[:20], last=INPUTS))
            return
        self.app.operation.force(number)

    def _is_free(self) -> bool:
        """Nothing is under way; else says so."""
        busy = self.app.operation.is_underway
        if busy:
            self.app.say(self.app.words("hand_busy"))
        return not busy

    def _axes(self) -> tuple[AxisValues, ...]:
        return self.app.engine.snapshot().axes


def _rule(shown: Shown, width: int) -> Row:
    return Row(shown.look.dim).add(shown.look.rule() * width)


def axis_rows(shown: Shown, selected: int = -1, step: float | None = None, is_on: bool = False) -> list[Row]:
    """Positions, limits and state per axis; with a `step` how the selected one is jogged beside them."""
    look, words, s = shown.look, shown.words, shown.snapshot
    head = (
        Row(look.dim)
        .until(17, f"{words('actual')} mm")
        .until(29, f"{words('limit')} -")
        .until(41, f"{words('limit')} +")
    )
    rows = [head.at(44, words("axis_state"))]
    for index, axis in enumerate(s.axes):
        cursor = index == selected
        row = (
            Row(shown.value)
            .add(">" if cursor else " ", look.strong)
            .add(axis.name, look.cursor if cursor else look.strong)
        )
        row.until(16, f"{axis.actual:+.4f}", look.dim if shown.stale_s else look.strong).add(
            "°" if axis.unit != "mm" else " "
        )
        low, high = axis.limits or (None, None)
        row.until(29, "-" if low is None else f"{low:.3f}").until(41, "-" if high is None else f"{high:.3f}")
        rows.append(_axis_state(row, shown, axis))
    if step is None:
        return rows
    jog = _jog_texts(shown, s.axes[selected] if s.axes else None, step, is_on)
    rows[0].at(66, words("jog"), look.dim)
    while len(rows) < 1 + len(jog):
        rows.append(Row(shown.value))
    for row, (text, style) in zip(rows[1:], jog, strict=False):
        row.at(66, text, getattr(look, style))
    return rows


def _axis_state(row: Row, shown: Shown, axis: AxisValues) -> Row:
    look, words = shown.look, shown.words
    if not axis.referenced:
        return row.at(44, "?  ", look.warn).add(words("not_referenced").upper(), look.warn)
    row.at(44, "R  ")
    closed, there = "cl" in axis.bits, "pe" in axis.bits
    row.add(words("hand_loop_on") if closed else words("hand_loop_off"), shown.value if closed else look.warn)
    return row.add("  " + (words("at_rest") if there else words("moves")))


def _jog_texts(shown: Shown, axis: AxisValues | None, step: float, is_on: bool) -> list[tuple[str, str]]:
    words = shown.words
    if axis is None:
        return []
    unit = "mm" if axis.unit == "mm" else "°"
    state = (words("jog_on"), "inverse") if is_on else (words("jog_off"), "dim")
    feed = f"{axis.jog_feed:.0f} {unit}/min"
    return [(f"{step:.3f} {unit} [i]", "text"), (feed, "text"), state]


def key_rows(shown: Shown, selected: int, width: int) -> list[Row]:
    """The keys of this page."""
    words, axes = shown.words, shown.snapshot.axes
    name = axes[selected].name if axes else "X"
    return [Row(shown.look.dim).add(f" {words(id, axis=name)}"[:width]) for id in ("manual_keys_1", "manual_keys_2")]


def zero_rows(shown: Shown) -> list[Row]:
    """Work zero and program coordinates, two axes a row."""
    rows, words, axes = [], shown.words, shown.snapshot.axes
    for first in range(0, len(axes), 2):
        row = Row(shown.value).add(f" {words('work_zero')}" if not first else "", shown.look.dim).at(16, "")
        for axis in axes[first : first + 2]:
            row.add(f"{axis.name} ", shown.look.strong).add(f"{axis.zero:+.4f}  {words('program_at')} ")
            row.add(f"{axis.actual - axis.zero + 0.0:+.4f}   ")
        rows.append(row)
    return rows


def home_way(axis: AxisValues, words: Words, form: str = "home") -> str:
    """How an axis finds its reference: to which side, onto what."""
    to, back = ("left", "right") if axis.home_side == "left" else ("right", "left")
    return words(f"{form}_{axis.homing.replace('+', '_')}", to=words(f"home_{to}"), back=words(f"home_{back}"))


def home_question(axes: Sequence[AxisValues], words: Words) -> tuple[list[str], str]:
    """Which of these axes can be homed, in this order, and what is asked before, or why it cannot be done."""
    able = [axis for axis in axes if axis.homing]
    without = ", ".join(axis.name for axis in axes if not axis.homing)
    ways = ", ".join(f"{axis.name} {home_way(axis, words)}" for axis in able)
    texts = [words("home_ask", ways=ways)] if able else []
    texts += [words("home_none", axes=without)] if without else []
    return [axis.name for axis in able], "\n".join(texts)


def home_rows(shown: Shown) -> list[Row]:
    """In which order and to which side all axes are homed, two in a row."""
    words, look = shown.words, shown.look
    able = sorted((axis for axis in shown.snapshot.axes if axis.homing), key=lambda axis: axis.home_place)
    texts = [f"{axis.home_place} {axis.name} {home_way(axis, words, 'home_short')}" for axis in able]
    without = [axis.name for axis in shown.snapshot.axes if not axis.homing]
    texts += [words("home_cannot", axes=" ".join(without))] if without else []
    rows = []
    for first in range(0, len(texts), 2):
        row = Row(shown.value).add(f" {words('home_title')}" if not first else "", look.dim)
        rows.append(row.at(16, texts[first]).at(48, "".join(texts[first + 1 : first + 2])))
    return rows


def _bits(row: Row, shown: Shown, value: int, count: int) -> Row:
    """Numbers; in brackets those that are on, so that it is not carried by colour alone."""
    for n in range(count):
        on = bool(value >> n & 1)
        row.add(f"[{n + 1}]" if on else f" {n + 1} ", shown.look.strong if on else shown.look.dim)
    return row


def input_rows(shown: Shown) -> list[Row]:
    """Digital inputs and outputs."""
    s, words, look = shown.snapshot, shown.words, shown.look
    inputs = Row(shown.value).add(f" {words('hand_inputs')}", look.dim).at(16, "")
    outputs = Row(shown.value).add(f" {words('hand_outputs')}", look.dim).at(16, "")
    return [_bits(inputs, shown, s.inputs, INPUTS), *forced_rows(shown), _bits(outputs, shown, s.outputs, OUTPUTS)]


def forced_rows(shown: Shown) -> list[Row]:
    """Which inputs are forced, and how they are released; nothing where none is."""
    numbers = " ".join(map(str, shown.snapshot.forced))
    return [Row(shown.look.hold).add(f" {shown.words('forced_way', numbers=numbers)} ")] if numbers else []


def gain_rows(shown: Shown) -> list[Row]:
    """PIDF gains per axis; they are set in the machine file."""
    rows = [Row(shown.look.dim).add(f" {shown.words('hand_gains')}")]
    for axis in shown.snapshot.axes:
        if axis.gains:
            texts = "  ".join(f"{name} {value:g}" for name, value in axis.gains)
            rows.append(Row(shown.value).add(f"  {axis.name}", shown.look.strong).add(f"  {texts}"))
    return rows if len(rows) > 1 else []


def is_jogging(s: Snapshot) -> bool:
    """A step or a home search is under way."""
    return s.mode is Mode.MANUAL and s.state is State.RUNNING
