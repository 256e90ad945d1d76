"""A CNC task under the eyes of its programmer: steps, breakpoints, variables by name."""

from __future__ import annotations

from typing import Any, Literal

from motion_kernel.driver import Driver
from motion_kernel.structures import TaskStatus

Value = bool | int | float

#: Bit of CNCTS.running: the task waits for a step or to go on.
WAITS = 2


#: Events of rw_SymPas tasks (6.4) in the order of their priority; the names of their handlers.
EVENTS = ("EVEO", "EVDNR", "EVLSH", "EVLSS", "EVMPE", "EVUI", "EVENDAT")


class TaskEye:
    """One CNC task that executes a rw_SymPas program, looked at. No time passes here: what is asked for (`ask`) happens
    as time goes on."""

    def __init__(self, native: Any, task: int) -> None:
        """`native`: the Mcu of cnc_front._native."""
        self._native, self._task = native, task
        self._breaks: frozenset[int] = frozenset()
        native.rdcncts(task)  # IndexError for a task that is not there

    @property
    def status(self) -> TaskStatus:
        """CNCTS of the task (4.3.2.10)."""
        return TaskStatus(*self._native.rdcncts(self._task))

    @property
    def line(self) -> int:
        """Source line that comes next, or is being executed."""
        return self.status.csrcline

    @property
    def calls(self) -> list[str]:
        """Names of the routines being executed, the main program first."""
        return list(self._native.calls(self._task))

    @property
    def events(self) -> list[str]:
        """Names of the events that the task has enabled (enev)."""
        return list(self._native.enabled_events(self._task))

    @property
    def handler(self) -> str:
        """Name of the event handler being executed, or empty."""
        return next((name for name in reversed(self.calls) if name in EVENTS), "")

    @property
    def overflow(self) -> bool:
        """An Integer operation has wrapped to 32 bits since the start of the task."""
        return bool(self._native.has_overflowed(self._task))

    @property
    def rows(self) -> list[tuple[str, bool, Value]]:
        """Name, belongs to the main program, value; variables of the routine being executed come first."""
        return sorted(self._native.task_variables(self._task), key=lambda row: row[1])

    @property
    def variables(self) -> dict[str, Value]:
        """Variables that the routine being executed sees, by name: its own hide those of the main program. An axis
        name or AXIS variable has the number of its axis."""
        return {name: value for name, _, value in reversed(self.rows)}

    @property
    def breaks(self) -> frozenset[int]:
        """Source lines of the breakpoints."""
        return self._breaks

    def break_at(self, *lines: int) -> None:
        """Stops before statements on these source lines, and on no others. ValueError without a rw_SymPas program."""
        if not self._native.break_at(self._task, sorted(lines)):
            raise ValueError(f"CNC task {self._task} has no rw_SymPas program")
        self._breaks = frozenset(lines)

    def ask(self, what: Literal["into", "over", "out", "on"]) -> None:
        """One source line, into routines or over them; out of the routine being executed; on to a breakpoint."""
        asked = {"into": "stepcnct", "over": "step_over", "out": "step_out", "on": "contcnct"}[what]
        getattr(self._native, asked)(self._task)


class TaskView(TaskEye):
    """A task of a Mcu. Emulated time passes in `step`, `step_out` and `go`."""

    def __init__(self, mcu: Driver, task: int) -> None:
        super().__init__(mcu._mcu, task)
        self._driver = mcu

    def step(self, *, over: bool = False, samples: int = 100_000) -> bool:
        """Executes one source line, into routines or over them. True once it is done; False where it still waits after
        that many samples, or the task has ended."""
        self.ask("over" if over else "into")
        return self._until_waiting(samples)

    def step_out(self, samples: int = 1_000_000) -> bool:
        """Runs to the end of the routine being executed. True once its caller is reached; as `go` in main."""
        self.ask("out")
        return self._until_waiting(samples)

    def go(self, samples: int = 1_000_000) -> bool:
        """Runs on to the next breakpoint. True at one; False at the end of the task, or after that many samples."""
        self.ask("on")
        return self._until_waiting(samples)

    def _until_waiting(self, samples: int) -> bool:
        for _ in range(samples):
            self._driver.advance(1)
            if self.status.running & WAITS:
                return True
            if not self.status.running & 1:
                return False
        return False


class Debugging(Driver):
    """Looking into CNC tasks."""

    def task(self, number: int) -> TaskView:
        """The task 0 to 3; IndexError for others."""
        return TaskView(self, number)

    def set_clock(self, ticks: int) -> None:
        """Sets CLOCK, the ticks of 64 us that rw_SymPas programs read, modulo 2**32."""
        self._mcu.set_clock(ticks % 2**32)
