"""A CNC task under the eyes of its programmer: steps, breakpoints, variables by name."""

from __future__ import annotations

from motion_kernel.driver import Driver
from motion_kernel.structures import TaskStatus

Value = bool | int | float

#: Bit of CNCTS.running: the task waits for a step or to go on.
WAITS = 2


class TaskView:
    """One CNC task that executes a rw_SymPas program. Emulated time passes in `step` and `go` only."""

    def __init__(self, mcu: Driver, task: int) -> None:
        self._driver, self._task = mcu, task
        mcu._mcu.rdcncts(task)  # IndexError for a task that is not there

    @property
    def status(self) -> TaskStatus:
        """CNCTS of the task (4.3.2.10)."""
        return TaskStatus(*self._driver._mcu.rdcncts(self._task))

    @property
    def line(self) -> int:
        """Source line that comes next, or is being executed."""
        return self.status.csrcline

    @property
    def calls(self) -> list[str]:
        """Names of the routines being executed, the main program first."""
        return self._driver._mcu.calls(self._task)

    @property
    def overflow(self) -> bool:
        """An Integer operation has wrapped to 32 bits since the start of the task."""
        return self._driver._mcu.has_overflowed(self._task)

    @property
    def variables(self) -> dict[str, Value]:
        """Variables that the routine being executed sees, by name: its own hide those of the main program. An axis
        name or AXIS variable has the number of its axis."""
        rows = self._driver._mcu.task_variables(self._task)
        return {name: value for name, _, value in sorted(rows, key=lambda row: not row[1])}

    def break_at(self, *lines: int) -> None:
        """Stops before statements on these source lines, and on no others. ValueError without a rw_SymPas program."""
        if not self._driver._mcu.break_at(self._task, list(lines)):
            raise ValueError(f"CNC task {self._task} has no rw_SymPas program")

    def step(self, *, over: bool = False, samples: int = 100_000) -> bool:
        """Executes one source line, into routines or over them. True once it is done; False where it still waits after
        that many samples, or the task has ended."""
        if over:
            self._driver._mcu.step_over(self._task)
        else:
            self._driver._mcu.stepcnct(self._task)
        return self._until_waiting(samples)

    def go(self, samples: int = 1_000_000) -> bool:
        """Runs on to the next breakpoint. True at one; False at the end of the task, or after that many samples."""
        self._driver._mcu.contcnct(self._task)
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
