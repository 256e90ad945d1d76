"""The driver under the PCAP commands: the cards in the PC, the one that is selected, and how emulated time passes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

from cnc_front._native import motion_kernel as native
from motion_kernel.commands import CommandRefused, PcapError
from motion_kernel.machine import Machine

AxisId = str | int
Axes = AxisId | Iterable[AxisId]
InterruptRoutine = Callable[[int], None]

ENDAT_VERSIONS = {"11": 11, "16": 16}  # values of the environment variable MT that mean an ENDAT encoder

TIMEOUT = -4  # return code: no communication with the card
FAILED = 1  # return code: not done


@dataclass(slots=True)
class Card:
    """A controller in the PC."""

    machine: Machine
    emulator: native.Mcu
    booted: bool = True  # the operating system runs
    initialised: bool = True  # it has its system data
    environment: dict[str, str] = field(default_factory=dict)
    routine: InterruptRoutine | None = None
    trace: native.Chunk | None = None
    behind: float = 0.0  # of a sample, while another card is selected
    names: dict[str, int] = field(init=False)

    def __post_init__(self) -> None:
        self.names = {name: index for index, name in enumerate(self.machine.axis_names)}

    def take(self, machine: Machine) -> None:
        """Takes over system data."""
        self.machine, self.initialised, self.trace = machine, True, None
        self.read_environment()
        self.emulator.initialise(machine.native)
        self.__post_init__()

    def read_environment(self) -> None:
        """What the operating system takes from its environment as it starts: MT of each axis (MT0, MT1 ...)."""
        values = (self.environment.get(f"MT{axis}", "").strip() for axis in range(len(self.machine.axis_names)))
        self.emulator.set_endat_environment([ENDAT_VERSIONS.get(mt, 0) for mt in values])


class Driver:
    """Cards, axes by name or index, time. Commands refer to the card that `cardselect` chose."""

    def __init__(self, machine: Machine, *more: Machine) -> None:
        self._cards = [Card(m, native.Mcu(m.native)) for m in (machine, *more)]
        self._card = self._cards[0]
        self._advancing = False
        self.messages: list[str] = []
        self._screen = True

    @property
    def machine(self) -> Machine:
        """The machine of the selected card."""
        return self._card.machine

    @property
    def environment(self) -> dict[str, str]:
        """Environment strings of the selected card, as its firmware set-up keeps them (4.4.12)."""
        return self._card.environment

    def advance(self, samples: int) -> None:
        """Lets that many sample intervals pass, whatever happens in them, and records them in `trace`. Other cards
        get the same time. An interrupt routine is called behind the sample that raised the interrupt."""
        if self._advancing:
            raise RuntimeError("an interrupt routine cannot let time pass")
        _ = self._mcu
        self._advancing = True
        try:
            self._pass(self._card, samples)
            for card in self._cards:
                if card is not self._card:
                    due = card.behind + samples * self.machine.sample_time_s / card.machine.sample_time_s
                    card.behind = due % 1.0
                    self._pass(card, int(due))
        finally:
            self._advancing = False

    def _pass(self, card: Card, samples: int) -> None:
        card.emulator.begin_recording()
        while samples > 0:
            before = card.emulator.interrupts()
            samples -= card.emulator.pass_on(samples)
            if card.routine is not None and card.emulator.interrupts() != before:
                card.routine(1)
        card.trace = card.emulator.take_recording()

    @property
    def trace(self) -> native.Chunk:
        """Columns of the last `advance` as NumPy arrays without a copy: dp, load, rp (samples, axes), line, entry,
        v_plan, factor, flags (samples). Row k is the state at the end of sample first_sample + k."""
        if self._card.trace is None:
            raise RuntimeError("nothing is recorded before the first advance")
        return self._card.trace

    @property
    def samples(self) -> int:
        """Sample intervals since boot."""
        return self._mcu.samples()

    def events(self) -> list[tuple[int, str, int, str, bool, int, int]]:
        """What happened since the last call: (sample, kind, axis or task, name, on, line, value)."""
        return self._mcu.events()

    # ---- inside

    @property
    def _mcu(self) -> native.Mcu:
        """The emulator of the selected card. PcapError (-4) where it does not answer."""
        if not self._card.booted:
            raise PcapError(TIMEOUT, "no operating system runs on the card; load it with bootfile")
        if not self._card.initialised:
            raise PcapError(FAILED, "the card has no system data; send them with txbf2 or initmcusystem3")
        return self._card.emulator

    def _index(self, axis: AxisId) -> int:
        names = self._card.names
        if isinstance(axis, str):
            if axis not in names:
                raise KeyError(f"the machine has no axis {axis}; it has {', '.join(names)}")
            return names[axis]
        if not 0 <= axis < len(names):
            raise IndexError(f"the machine has no axis {axis}; it has 0 to {len(names) - 1}")
        return axis

    def _indices(self, axes: Axes) -> list[int]:
        return [self._index(axes)] if isinstance(axes, str | int) else [self._index(axis) for axis in axes]

    def _axis(self, axis: AxisId) -> dict[str, Any]:
        return self._mcu.read_axis(self._index(axis))

    def _read(self, axis: AxisId, register: str) -> float:
        return self._mcu.read_axis_register(self._index(axis), register)

    def _write(self, axis: AxisId, register: str, value: float, allowed: str = "") -> None:
        """ValueError with what is `allowed` if the value is not."""
        if not self._mcu.write_axis_register(self._index(axis), register, value):
            raise ValueError(f"{register} {value}: must be a finite number{f' {allowed}' if allowed else ''}")

    def _set_axis(self, axis: AxisId, register: str, value: float) -> int:
        """Return code of a write: 0, or 1 if the value is not allowed."""
        return 0 if self._mcu.write_axis_register(self._index(axis), register, value) else FAILED

    def _write_in_state(self, axis: AxisId, register: str, value: float, state: str) -> None:
        """CommandRefused unless the axis is in that state."""
        if not math.isfinite(value):
            raise ValueError(f"{register} {value}: must be a finite number")
        if not self._mcu.write_axis_register(self._index(axis), register, value):
            raise CommandRefused(f"{register} of axis {axis} can be written only {state}")

    def _entered(self, outcome: str, name: str) -> bool:
        if outcome == "refused":
            raise CommandRefused(f"{name}: an axis is in open loop; close it with cl")
        return outcome == "entered"
