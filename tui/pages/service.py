"""Service: what the controller reports, register by register. Read-only."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rich.style import Style
from textual.strip import Strip

from cnc_front.service import RUNS, STEPS, Bit, Service, ServiceAxis, ServiceTask
from tui.pages.base import Page
from tui.pages.manual import forced_rows
from tui.rows import Row
from tui.values import Shown

if TYPE_CHECKING:
    from tui.app import Terminal

#: Values that changed are marked for so long, s.
MARK_S = 2.0


class ServicePage(Page):
    """Axes, registers, tasks, variables."""

    name = "service"

    def __init__(self, app: Terminal) -> None:
        super().__init__(app)
        self._changes = Changes()

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """All of it; it scrolls."""
        return service_rows(shown, self.app.engine.service(), self._changes, time.monotonic(), width)


@dataclass(slots=True)
class Changes:
    """Remembers when each value of the service page last changed."""

    _values: dict[str, str] = field(default_factory=dict)
    _at: dict[str, float] = field(default_factory=dict)

    def is_fresh(self, name: str, value: str, now: float) -> bool:
        """Whether a value changed within the last two seconds."""
        if name in self._values and self._values[name] != value:
            self._at[name] = now
        self._values[name] = value
        return now - self._at.get(name, -MARK_S) < MARK_S


@dataclass(frozen=True, slots=True)
class Marker:
    """Adds values to rows; one that changed is marked with `*` and a colour."""

    shown: Shown
    changes: Changes
    now: float

    def add(self, row: Row, name: str, value: str, style: Style | None = None) -> Row:
        """Appends a value with room for its mark before it."""
        fresh = self.changes.is_fresh(name, value, self.now)
        look = self.shown.look
        return row.add("*" if fresh else " ", look.warn).add(value, look.warn if fresh else style or self.shown.value)


def service_rows(shown: Shown, service: Service | None, changes: Changes, now: float, width: int) -> list[Strip]:
    """Versions, error register, tasks and variables, then each axis with its status bits."""
    look, words = shown.look, shown.words
    if service is None:
        return [Row(look.strong).add(f" {words('service_title')}").strip(width)]
    mark = Marker(shown, changes, now)
    rows = [*_head(mark, service), *forced_rows(shown), *_tasks(mark, service), *_variables(mark, service, width)]
    for axis in service.axes:
        rows += _axis(mark, axis, width)
    return [row.strip(width) for row in rows]


def _head(mark: Marker, service: Service) -> Iterator[Row]:
    look, words = mark.shown.look, mark.shown.words
    versions = "  ".join(f"{name} {version}" for name, version in service.versions)
    yield Row(look.strong).add(f" {words('service_title')}  ").add(versions, look.dim)
    row = Row(look.text).add(f" {words('samples')}").add(f" {service.samples} x {service.sample_time_us:g} us")
    mark.add(row.add("  trovr"), "trovr", f"{service.trovr * 100:.0f} %")
    inputs = outputs = 0
    for axis in service.axes:
        inputs |= axis.inputs
        outputs |= axis.outputs
    mark.add(row.add(f"  {words('inputs')}"), "inputs", numbers_of(inputs))
    yield mark.add(row.add(f"  {words('outputs')}"), "outputs", numbers_of(outputs))
    title = Row(look.strong).add(f" {words('errorreg')}")
    yield title if any(bit.on for bit in service.errorreg) else title.add("  0", look.text)
    yield from _bit_rows(mark, "errorreg", service.errorreg, look.bad)


def numbers_of(bits: int) -> str:
    """Numbers of what is on, from 1: `1 3`; `-` for none."""
    return " ".join(str(n + 1) for n in range(32) if bits >> n & 1) or "-"


def _bit_rows(mark: Marker, register: str, bits: tuple[Bit, ...], style: Style) -> Iterator[Row]:
    """The bits that are set, and those that changed just now."""
    for bit in bits:
        value = "1" if bit.on else "0"
        fresh = mark.changes.is_fresh(f"{register}.{bit.name}", value, mark.now)
        if bit.on or fresh:
            shown = mark.shown.look.warn if fresh else style
            yield (
                Row(shown)
                .add(f"  {'*' if fresh else ' '}{value}")
                .until(8, str(bit.number))
                .at(9, bit.name)
                .at(28, bit.text)
            )


#: Of the axis status: bits that are no fault.
_GOOD = frozenset({"pe", "cl", "ip", "ui", "lpsf", "referenced", "refh"})


def _axis(mark: Marker, axis: ServiceAxis, width: int) -> Iterator[Row]:
    look, words = mark.shown.look, mark.shown.words
    row = Row(mark.shown.value).add(f" {axis.name} {axis.unit}", look.strong).at(8, words("command"), look.dim)
    row.add(f" {axis.command:+.4f}  ").add(words("actual"), look.dim).add(f" {axis.actual:+.4f}  ")
    row.add(words("following"), look.dim).add(f" {round(axis.following, 4) + 0.0:+.4f} / {axis.mpe:g}")
    yield row
    state = [(axis.is_on("cl"), "loop_on", "loop_off"), (axis.is_on("referenced"), "homed", "not_referenced")]
    row = Row(look.text).add("   ")
    for good, yes, no in state:
        mark.add(row, f"{axis.name}.{yes}", words(yes if good else no), look.text if good else look.warn).add("  ")
    row.add(f"{words('spool')} {words(f'spool_{axis.spooler.lower()}')}")
    mark.add(row, f"{axis.name}.entries", words("entries", n=axis.entries))
    row.add(f", {words('bytes_free', n=axis.free)}")
    if row.width < width - 12:
        row.add(f"  jovr {axis.override * 100:.0f} %")
    yield row
    gains = "  ".join(f"{name} {value:g}" for name, value in axis.gains)
    yield Row(look.text).add(f"    {words('gains')} ", look.dim).add(gains)
    faults = tuple(bit for bit in axis.axst if bit.name not in _GOOD)
    yield from _bit_rows(mark, f"{axis.name}.axst", faults, look.bad)
    yield from _bit_rows(mark, f"{axis.name}.axst", tuple(b for b in axis.axst if b.name in _GOOD), look.text)


def _tasks(mark: Marker, service: Service) -> Iterator[Row]:
    look, words = mark.shown.look, mark.shown.words
    row = Row(look.strong).add(f" {words('tasks')}")
    for task in service.tasks:
        state = task_state(task)
        text = f"{task.number}: {words(state)}" + (f" {words('line', n=task.line)}" if task.line else "")
        mark.add(row.add(" "), f"task{task.number}", text, look.bad if task.error else look.text)
    yield row


def task_state(task: ServiceTask) -> str:
    """The id of the word for its state."""
    if task.error:
        return "task_error"
    return "task_step" if task.running & STEPS else "task_runs" if task.running & RUNS else "task_rests"


def _variables(mark: Marker, service: Service, width: int) -> Iterator[Row]:
    """Common variables that are not 0, as many in a row as fit."""
    look = mark.shown.look
    integers = [(f"CI{n}", str(value)) for n, value in service.integers]
    row = Row(look.text).add(f" {mark.shown.words('variables')}", look.strong)
    for name, value in [*integers, *((f"CD{n}", f"{value:g}") for n, value in service.doubles)]:
        if row.width + len(name) + len(value) + 5 > width:
            yield row
            row = Row(look.text).add(" ")
        mark.add(row.add(" "), name, f"{name}={value}")
    yield row if row.width > 12 else row.add(" -")
