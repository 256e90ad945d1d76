"""A CNC task under the eyes of its programmer: steps, breakpoints, variables by name."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import PurePath
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
    def files(self) -> list[tuple[str, int]]:
        """Files of the program, the job first, and what is added to their lines to make places of them: a place is one
        number for a line of any file. Empty without a rw_SymPas program."""
        return self._native.task_files(self._task) or []

    @property
    def place(self) -> int:
        """Place that comes next, or at which the task failed."""
        return int(self._native.place(self._task))

    def place_of(self, line: int | str) -> int:
        """The place of a line of the job (57), or of an include ('axes.inc:5'). ValueError for another file."""
        if isinstance(line, int):
            return line
        name, _, number = line.rpartition(":")
        found = [first for path, first in self.files if PurePath(path).name == name or path == name]
        if len(found) != 1 or not number.isdigit():
            names = ", ".join(PurePath(path).name for path, _ in self.files)
            raise ValueError(f"'{line}' is no FILE:LINE of this program, whose files are {names}")
        return found[0] + int(number)

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
    def rows(self) -> list[tuple[str, int, Value]]:
        """Name, number of the call (as in `calls`; 0: the main program), value of all variables of the routines being
        executed; those of the innermost come first."""
        return sorted(self._native.task_variables(self._task), key=lambda row: -row[1])

    @property
    def variables(self) -> dict[str, Value]:
        """Variables that the routine being executed sees, by name: its own hide those of the main program. An axis
        name or AXIS variable has the number of its axis."""
        seen = (0, len(self.calls) - 1)
        return {name: value for name, call, value in reversed(self.rows) if call in seen}

    def is_axis(self, name: str) -> bool:
        """The name is an axis or an AXIS variable of the program."""
        return name in self._native.task_axes(self._task)

    def assign(self, name: str, value: Value) -> None:
        """Sets a variable that the routine being executed sees, as an assignment of the language would. ValueError for
        an unknown name or a value that its type does not take."""
        self._native.set_task_variable(self._task, name, value)

    @property
    def breaks(self) -> frozenset[int]:
        """Places of the breakpoints."""
        return self._breaks

    def break_at(self, *lines: int | str) -> None:
        """Stops before statements on these lines (57, or 'axes.inc:5' of an include), and on no others. ValueError for
        a line on which no statement begins, or without a rw_SymPas program."""
        places = [self.place_of(line) for line in lines]
        known = self._native.break_places(self._task)
        for line, place in zip(lines, places, strict=True):
            if place not in known and self.files:
                near = min((p for p in known if p > place), default=None)
                hint = f"; the next one: {self.text_of(near)}" if near else ""
                raise ValueError(f"no statement begins on line {line}{hint}")
        self.break_at_places(places)

    def break_at_places(self, places: Iterable[int]) -> None:
        """As break_at, for places of statements."""
        self._breaks = frozenset(places)
        if not self._native.break_at(self._task, sorted(self._breaks)):
            raise ValueError(f"CNC task {self._task} has no rw_SymPas program")

    def text_of(self, place: int) -> str:
        """A place as people write it: the line, or FILE:LINE of an include."""
        path, first = max(((p, f) for p, f in self.files if f < place), key=lambda row: row[1])
        return f"{PurePath(path).name}:{place - first}" if first else str(place)

    def next_break(self, place: int) -> int | None:
        """The first place from there on where a breakpoint can be; None behind the last."""
        return min((p for p in self._native.break_places(self._task) if p >= place), default=None)

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
