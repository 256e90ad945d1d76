"""rw_SymPas jobs under the eyes of their programmer: the terminal's view of the tasks that `Mcu.task(n)` gives."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.jobs import MachineFile, StimulusFile, shown
from cnc_front.sap_places import joined
from cnc_front.sap_run import SapOptions, SapRun, Task
from motion_kernel.debug import TaskEye

#: Common variables.
COMMON = re.compile(r"(CI|CD)(\d{1,3})")
#: Lines of output that are kept.
OUTPUT_LINES = 500
#: State of a task by the bits of CNCTS.running (4.3.2.10), most telling first.
WORDS = ((4, "halted"), (2, "step"), (8, "waits"), (1, "runs"))


@dataclass(frozen=True, slots=True)
class TaskState:
    """One CNC task as the screen shows it."""

    number: int
    name: str
    #: runs, waits, step, halted, rests (not begun, stopped or at its end), error
    state: str
    #: line in its file, and place: its line among those of all files of the task (see TaskEye.files)
    line: str
    place: int
    error: str
    #: events that it has enabled, and the handler being executed
    events: tuple[str, ...]
    handler: str


@dataclass(slots=True)
class DebugSession:
    """Tasks on a controller that stands still between `advance` calls. Tasks wait before their first line."""

    run: SapRun
    views: dict[int, TaskEye] = field(default_factory=dict)
    output: list[str] = field(default_factory=list)
    #: a hold has stopped axes and tasks; `resume` goes on
    held: bool = False
    _lines: dict[int, list[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for task in self.tasks:
            self.views[task.number] = TaskEye(self.mcu, task.number)
            self.mcu.number_lines(task.number, 0)  # every task counts for itself here
            self.mcu.stopcnct(task.number)
            self._lines[task.number] = joined([task]).text().splitlines()

    @property
    def mcu(self) -> native_kernel.Mcu:
        """The controller."""
        return self.run.mcu

    @property
    def tasks(self) -> Sequence[Task]:
        """The tasks that have a program."""
        return self.run.tasks

    def lines(self, number: int) -> list[str]:
        """The source text of a task, its includes behind it, as places count."""
        return self._lines[number]

    def titles(self, number: int) -> dict[int, str]:
        """Names of the includes of a task, by what is added to their lines."""
        return {first: Path(path).name for path, first in self.views[number].files if first}

    def state(self, task: Task) -> TaskState:
        """Where a task is."""
        view, number = self.views[task.number], task.number
        status, name = view.status, Path(shown(task.source.path)).name
        events, handler, place = tuple(view.events), view.handler, view.place
        line = view.text_of(place) if place else "0"
        if status.errnum:
            error = f"{status.errnum} ({status.errnum:X}h)"
            return TaskState(number, name, "error", line, place, error, events, handler)
        word = next((word for bit, word in WORDS if status.running & bit), "rests")
        return TaskState(number, name, word, line, place, "", events, handler)

    def toggle_break(self, number: int, place: int) -> int | None:
        """Sets a breakpoint, or takes it away; on a line without statement at the next one in its file. The place; None
        where no statement follows."""
        view = self.views[number]
        found = view.next_break(place)
        if found is None or self._file_at(number, found) != self._file_at(number, place):
            return None
        view.break_at_places(view.breaks ^ {found})
        return found

    def _file_at(self, number: int, place: int) -> int:
        return max((first for _, first in self.views[number].files if first < place), default=0)

    def assign(self, number: int, text: str) -> None:
        """Sets a variable, or a common one (CI5, CD7): `name := value` or `name = value`. ValueError if it cannot."""
        name, _, given = text.replace(":=", "=").partition("=")
        name, value = name.strip(), value_of(given.strip())
        common = COMMON.fullmatch(name)
        if common is None or name in self.views[number].variables:
            self.views[number].assign(name, value)
        elif common[1] == "CD":
            self.mcu.wrcd(int(common[2]), float(value))
        elif isinstance(value, float) or not -(2**31) <= value < 2**31:
            raise ValueError(f"'{name}' does not take that value")
        else:
            self.mcu.wrci(int(common[2]), int(value))

    def go(self, number: int) -> None:
        """Lets a task run on to its next breakpoint, or starts it anew where nothing is left to continue."""
        self.mcu.contcnct(number)
        if not self.views[number].status.running & 1:
            self.mcu.startcnct(number)

    def go_all(self) -> None:
        """Lets all tasks run on that have something to continue; where none has, all start anew."""
        for number in self.views:
            self.mcu.contcnct(number)
        if not any(view.status.running & 1 for view in self.views.values()):
            for number in self.views:
                self.mcu.startcnct(number)

    def pause(self, number: int) -> None:
        """Stops a task before its next line; one that is not running stays as it is."""
        if self.views[number].status.running & 1:
            self.mcu.stepcnct(number)

    def hold(self) -> None:
        """Brakes all axes along their path and stops all tasks; nothing is lost."""
        self.mcu.hold()
        self.held = True

    def resume(self) -> None:
        """Goes on behind a hold: axes, and the tasks where they were."""
        self.mcu.resume()
        self.held = False

    def position(self, axis: int) -> float:
        """Set position of an axis, in its unit."""
        return self.mcu.read_axis_register(axis, "dp")

    @property
    def travels(self) -> bool:
        """Some axis is at work, or has something to do."""
        return not all("pe" in axis["axst"] for axis in self.mcu.status()["axes"])

    @property
    def works(self) -> bool:
        """Some task runs or some axis is at work: time has to pass."""
        runs = any(self.state(task).state in ("runs", "waits") for task in self.tasks)
        return (runs and not self.held) or self.travels

    def advance(self, seconds: float) -> None:
        """Lets machine time pass; less where nothing is left to happen."""
        self.mcu.advance(max(1, round(seconds / self.run.sample_time_s)))
        self.mcu.events()  # the list is full some day
        self.mcu.take_listing()
        for task in self.tasks:
            text = self.mcu.take_output(task.number)
            self.output += [f"{task.number}: {line}" for line in text.splitlines()]
        del self.output[:-OUTPUT_LINES]


def value_of(text: str) -> bool | int | float:
    """A literal of the language: TRUE, FALSE, 12, $1F, 1.5. ValueError for anything else."""
    word = text.upper()
    if word in ("TRUE", "FALSE"):
        return word == "TRUE"
    try:
        return int(word[1:], 16) if word.startswith("$") else int(word)
    except ValueError:
        pass
    try:
        return float(word)
    except ValueError:
        raise ValueError(f"'{text}' is no number, TRUE or FALSE") from None


def debug_session(machine: MachineFile, tasks: list[Task], stimulus: StimulusFile | None = None) -> DebugSession:
    """Loads the tasks; every one waits before its first line. `stimulus`: what the world outside does."""
    return DebugSession(SapRun(machine, tasks, SapOptions(stimulus=stimulus)))
