"""A rw_SymPas job under the eyes of its programmer: steps, breakpoints, variables. The terminal shows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.jobs import shown
from cnc_front.sap_run import SapOptions, SapRun, Task

#: Bits of CNCTS.running (4.3.2.10).
EXECUTES, WAITS_FOR_STEP, HALTED, WAITS = 1, 2, 4, 8
#: Lines of output that are kept.
OUTPUT_LINES = 500


@dataclass(frozen=True, slots=True)
class TaskState:
    """One CNC task as the screen shows it."""

    number: int
    name: str
    #: runs, waits, step, halted, rests (not begun, stopped or at its end), error
    state: str
    line: int
    error: str


@dataclass(slots=True)
class DebugSession:
    """Tasks on a controller that stands still between `advance` calls. Tasks wait before their first line."""

    run: SapRun
    breaks: dict[int, set[int]] = field(default_factory=dict)
    output: list[str] = field(default_factory=list)
    _lines: dict[int, list[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for task in self.tasks:
            self.mcu.stopcnct(task.number)
            self.breaks[task.number] = set()
            self._lines[task.number] = task.source.text().splitlines()

    @property
    def mcu(self) -> native_kernel.Mcu:
        """The controller."""
        return self.run.mcu

    @property
    def tasks(self) -> Sequence[Task]:
        """The tasks that have a program."""
        return self.run.tasks

    @property
    def machine_time_s(self) -> float:
        """Emulated time so far."""
        return self.run.machine_time_s

    def lines(self, number: int) -> list[str]:
        """The source text of a task."""
        return self._lines[number]

    def state(self, task: Task) -> TaskState:
        """Where a task is."""
        errnum, errline, running, line, *_ = self.mcu.rdcncts(task.number)
        name = Path(shown(task.source.path)).name
        if errnum:
            return TaskState(task.number, name, "error", errline, f"{errnum} ({errnum:X}h)")
        return TaskState(task.number, name, _word(running), line, "")

    def variables(self, number: int) -> list[tuple[str, bool, Any]]:
        """Rows of name, belongs to the main program, value; those of the routine being executed come first."""
        return sorted(self.mcu.task_variables(number), key=lambda row: row[1])

    def calls(self, number: int) -> list[str]:
        """Routines being executed, the main program first."""
        return [name or "main" for name in self.mcu.calls(number)]

    def toggle_break(self, number: int, line: int) -> bool:
        """Sets a breakpoint, or takes it away; True if it is there now."""
        breaks = self.breaks[number]
        breaks.symmetric_difference_update({line})
        self.mcu.break_at(number, sorted(breaks))
        return line in breaks

    def step(self, number: int, *, over: bool = False) -> None:
        """Asks for one source line; time passes in `advance`."""
        if over:
            self.mcu.step_over(number)
        else:
            self.mcu.stepcnct(number)

    def go(self, number: int) -> None:
        """Lets a task run on to its next breakpoint, or starts it anew where nothing is left to continue."""
        self.mcu.contcnct(number)
        if not self.mcu.rdcncts(number)[2] & EXECUTES:
            self.mcu.startcnct(number)

    def pause(self, number: int) -> None:
        """Stops a task before its next line."""
        self.mcu.stepcnct(number)

    def advance(self, seconds: float) -> None:
        """Lets machine time pass; less where nothing is left to happen."""
        samples = max(1, round(seconds / (self.run.machine.machine.sample_time_us * 1e-6)))
        self.mcu.advance(samples)
        for task in self.tasks:
            text = self.mcu.take_output(task.number)
            self.output += [f"{task.number}: {line}" for line in text.splitlines()]
        del self.output[:-OUTPUT_LINES]


def _word(running: int) -> str:
    bits = ((HALTED, "halted"), (WAITS_FOR_STEP, "step"), (WAITS, "waits"), (EXECUTES, "runs"))
    return next((word for bit, word in bits if running & bit), "rests")


def debug_session(machine: Any, tasks: list[Task]) -> DebugSession:
    """Loads the tasks; every one waits before its first line."""
    return DebugSession(SapRun(machine, tasks, SapOptions()))
