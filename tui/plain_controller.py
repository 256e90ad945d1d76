"""The controller in the line mode: registers, tasks, variables, inputs; forced inputs and the dry-run feed."""

from __future__ import annotations

from collections.abc import Callable

from cnc_front.engine import wait_for
from cnc_front.service import Bit, Service, ServiceAxis
from tui.pages.manual import INPUTS
from tui.pages.service import numbers_of, task_state
from tui.plain_desk import ECHO_S, Desk
from tui.plain_words import part_of


class Controller:
    """Service, and the inputs and the dry-run feed of Manual and Run."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk

    def deeds(self) -> dict[str, Callable[[str], None]]:
        """What its commands do."""
        return {
            "registers": self._registers,
            "tasks": self._tasks,
            "variables": self._variables,
            "inputs": self._inputs,
            "force": self._force,
            "release": lambda _: self._desk.operation.release(),
            "dryfeed": self._dry_feed,
            "dryrun": self._dry_run,
        }

    def _service(self) -> Service | None:
        """What the controller says now, not what it said when somebody asked last; says so where it says nothing."""
        engine = self._desk.engine
        old = engine.service()
        wait_for(lambda: engine.service() is not old, ECHO_S)
        service = engine.service()
        if service is None:
            self._desk.say(self._desk.words("plain_no_answer"))
        return service

    def _registers(self, name: str) -> None:
        desk = self._desk
        if name and desk.axis(name) is None:
            return
        service = self._service()
        if service is None:
            return
        if not name:
            self._bits("errorreg", service.errorreg)
        for axis in service.axes:
            if name.upper() in ("", axis.name):
                self._axis(axis, whole=bool(name))

    def _axis(self, axis: ServiceAxis, *, whole: bool) -> None:
        """Its status bits; with `whole` its spooler and gains before."""
        desk = self._desk
        if whole:
            facts = {"entries": axis.entries, "free": axis.free, "mpe": axis.mpe, "unit": axis.unit}
            spooler = desk.words(f"spool_{axis.spooler.lower()}")
            desk.say(desk.words("plain_loop", axis=axis.name, spooler=spooler, override=axis.override * 100, **facts))
            gains = " ".join(f"{name} {value:g}" for name, value in axis.gains)
            desk.say(f"{axis.name}: {desk.words('gains')} {gains}")
        self._bits(f"{axis.name} axst", axis.axst)

    def _bits(self, register: str, bits: tuple[Bit, ...]) -> None:
        """The bits that are set, one a line."""
        desk = self._desk
        on = [bit for bit in bits if bit.on]
        for bit in on:
            desk.say(desk.words("plain_register", register=register, number=bit.number, name=bit.name, text=bit.text))
        if not on:
            desk.say(desk.words("plain_bits_none", register=register))

    def _tasks(self, _: str) -> None:
        desk, service = self._desk, self._service()
        for task in service.tasks if service else ():
            line = f", {desk.words('line', n=task.line)}" if task.line else ""
            desk.say(f"{desk.words('cnc_task')} {task.number}: {desk.words(task_state(task))}{line}")

    def _variables(self, _: str) -> None:
        desk, service = self._desk, self._service()
        if service is None:
            return
        for number, integer in service.integers:
            desk.say(f"CI{number} = {integer}")
        for number, double in service.doubles:
            desk.say(f"CD{number} = {double:g}")
        if not service.integers and not service.doubles:
            desk.say(desk.words("plain_variables_none"))

    def _inputs(self, _: str) -> None:
        desk, s = self._desk, self._desk.engine.snapshot()
        desk.say(desk.words("plain_inputs", inputs=numbers_of(s.inputs), outputs=numbers_of(s.outputs)))
        if s.forced:
            desk.say(desk.words("forced", numbers=" ".join(map(str, s.forced))))

    def _force(self, text: str) -> None:
        desk = self._desk
        number, _, level = text.partition(" ")
        part = part_of(level.strip())
        if part not in ("on", "off"):
            desk.usage("force")
        elif not (number.isdecimal() and len(number) < 5 and 1 <= int(number) <= INPUTS):
            desk.say(desk.words("input_bad", text=number[:20], last=INPUTS))
        else:
            desk.operation.force(int(number), part == "on")
            wait_for(lambda: int(number) in desk.engine.snapshot().forced, ECHO_S)

    def _dry_feed(self, text: str) -> None:
        before = self._desk.engine.snapshot().switches
        self._desk.operation.dry_feed_from(text)
        self._desk.switches_after(before)

    def _dry_run(self, _: str) -> None:
        desk, before = self._desk, self._desk.engine.snapshot().switches
        desk.operation.switch("dry_run")
        if not desk.operation.is_underway:
            on = desk.switches_after(before).dry_run
            feed = desk.engine.snapshot().dry_feed
            desk.say(desk.words("plain_dry_on" if on else "plain_dry_off", feed=feed))
