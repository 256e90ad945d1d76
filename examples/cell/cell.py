"""A cell of four CNC tasks and a PC: an order of three parts, with an emergency stop in the middle of the second.

Task 0 homes and mills, task 1 watches with event handlers, task 2 is the PLC, task 3 talks to this program through
common variables, the common buffer and its output string. Run it: `python examples/cell/cell.py`.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from pathlib import Path

import sympas
from motion_kernel import Machine, Mcu

HERE = Path(__file__).parent
PROGRAMS = ("contour.src", "monitor.src", "plc.src", "talk.src")
#: The world outside: switches at the left end, a clamp that takes its time.
WORLD = """
while X < -20: input 3 on
while Y < -25: input 4 on
whenever output 1 on after 0.2 s: input 2 on
whenever output 1 off after 0.1 s: input 2 off
"""
ORDER, MADE, STOPPED, EMERGENCIES = 20, 21, 24, 30
PART, EMERGENCY = 1 << 0, 1 << 4


@dataclass
class Cell:
    """The controller with its programs, and the operator beside it."""

    mcu: Mcu = field(init=False)
    inputs: int = 0
    said: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        machine = Machine.load(HERE / "machine.toml")
        self.mcu = Mcu(machine)
        self.mcu.add_stimulus(WORLD)
        for name in PROGRAMS:
            program = sympas.compile(HERE / name, machine)
            task = program.task
            assert task is not None
            self.mcu.load(task, program)
            self.mcu.startcnct(task)

    def wait(self, seconds: float) -> None:
        """Lets time pass and listens to task 3."""
        for _ in range(round(seconds / 0.01)):
            self.mcu.advance(8)
            if self.mcu.gettskinfo(3) & 2:
                self.said.append(self.mcu.gettskstr(3))

    def switch(self, bits: int, on: bool) -> None:
        """The operator's inputs; those of the world keep their state."""
        for bit in (PART, EMERGENCY):
            if bits & bit:
                number = bit.bit_length()
                self.mcu.add_stimulus(f"at 0 s: input {number} {'on' if on else 'off'}")

    def where(self) -> tuple[float, float, int]:
        """Position and parts made, as task 3 keeps them in its common buffer."""
        x, y, made = struct.unpack("<ddi", self.mcu.rdcbcnct(3, 20))
        return x, y, made

    def until(self, number: int, value: int, seconds: float = 30.0) -> None:
        """Waits for a common integer; TimeoutError after that machine time."""
        for _ in range(round(seconds / 0.05)):
            if self.mcu.rdci(number) == value:
                return
            self.wait(0.05)
        raise TimeoutError(f"CI{number} did not become {value}")


def main() -> Cell:
    """The whole order."""
    cell = Cell()
    cell.wait(0.5)
    cell.mcu.wrci(ORDER, 3)
    for part in (1, 2, 3):
        cell.switch(PART, True)
        if part == 2:
            cell.until(23, 1)
            cell.wait(0.6)
            cell.switch(EMERGENCY, True)
            cell.until(STOPPED, 1)
            cell.wait(1.0)
            cell.switch(EMERGENCY, False)
            cell.mcu.wrci(STOPPED, 2)
        cell.until(MADE, part)
        cell.switch(PART, False)
        cell.wait(0.5)
    cell.wait(0.5)
    return cell


if __name__ == "__main__":
    done = main()
    print(*done.said, sep="\n")
    print(f"{done.where()[2]} parts, {done.mcu.rdci(EMERGENCIES)} emergency stop, {done.mcu.samples * 0.00128:.1f} s")
