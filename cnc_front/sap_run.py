"""A dry run of rw_SymPas jobs: up to four tasks on one controller, to their end.

A job starts as after a boot, open loop and not referenced (design D28). What its tasks spool is listed as it runs; the
path is known when the job is over, so it is measured in a second, identical run (sap_measure.py).
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import sympas as native_sympas
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.execution import HARMLESS, AlarmEvent, End, Happened, LogEntry
from cnc_front.jobs import JobSource, MachineFile, StimulusFile, shown
from cnc_front.sap_places import Places
from cnc_front.scan import begin_scan
from cnc_front.schedule import Schedule
from cnc_front.spooled import Listing

#: Samples between two looks: the application reads what a task writes, and continues a task that halts at writeln.
CHUNK = 256
TASKS = 4
#: Bits of CNCTS.running (4.3.2.10).
EXECUTES, HALTED_AT_WRITELN = 1, 4


@dataclass(slots=True)
class Task:
    """One task and its program."""

    number: int
    source: JobSource
    program: native_sympas.Program
    warnings: tuple[Diagnostic, ...]
    output: str = ""
    error: tuple[int, int] | None = None  # number and line in its file
    line: int = 0  # being executed
    place: int = 0  # the same, or that of the error, as Places counts lines


@dataclass(frozen=True, slots=True)
class SapOptions:
    """What a run may vary."""

    max_time_s: float = 86400.0
    interrupted: Callable[[], bool] = lambda: False
    stimulus: StimulusFile | None = None
    schedule: Schedule = ((0.0, 1.0),)
    #: resources that are recorded every sample
    scan: tuple[str, ...] = ()
    #: told the machine time, s, now and then
    progress: Callable[[float], None] = lambda seconds: None


@dataclass(slots=True)
class SapRun:
    """Tasks on a controller. `run` carries them to their end."""

    machine: MachineFile
    tasks: list[Task]
    options: SapOptions = field(default_factory=SapOptions)
    #: takes the samples as they come
    sink: Callable[[native_kernel.Chunk, Happened], None] | None = None
    mcu: native_kernel.Mcu = field(init=False)
    places: Places = field(init=False)
    alarms: list[AlarmEvent] = field(init=False, default_factory=list)
    log: list[LogEntry] = field(init=False, default_factory=list)
    listing: Listing = field(init=False, default_factory=Listing)
    #: None while it runs
    end: End | None = field(init=False, default=None)
    wall_time_s: float = field(init=False, default=0.0)
    #: longest ramp time that an override change met, s
    trovrst_s: float = field(init=False, default=0.0)
    _pending: deque[tuple[int, float]] = field(init=False)

    def __post_init__(self) -> None:
        self.mcu = native_kernel.Mcu(self.machine.machine)
        self.mcu.list_commands()
        if self.options.stimulus is not None:
            self.mcu.add_stimulus(self.options.stimulus.stimulus)
        if self.options.scan:
            begin_scan(self.mcu, self.options.scan, list(self.machine.machine.axis_names))
        self.places = Places.of(self.tasks)
        for task in self.tasks:
            task.output, task.error, task.line, task.place = "", None, 0, 0
            try:
                self.mcu.load(task.number, task.program)
            except ValueError as error:  # an autocode file of a larger machine
                hint = "compile the job for this machine"
                where = shown(task.source.path)
                raise CompileError([Diagnostic(where, 1, 1, 1, "CF202", str(error), hint)]) from None
            self.mcu.number_lines(task.number, self.places.first(task.number))
        self._pending = deque((round(t / self.sample_time_s), f) for t, f in self.options.schedule)
        self._override_at(0)
        for task in self.tasks:
            self.mcu.startcnct(task.number)

    @property
    def sample_time_s(self) -> float:
        """Sample time of the controller."""
        return self.machine.machine.sample_time_us * 1e-6

    @property
    def machine_time_s(self) -> float:
        """Emulated time so far."""
        return self.mcu.samples() * self.sample_time_s

    def run(self, samples: int | None = None) -> SapRun:
        """To the end of all tasks and of motion, or until time or the user ends it; or for so many samples."""
        begun = time.monotonic()
        most = samples if samples is not None else math.ceil(self.options.max_time_s / self.sample_time_s)
        while self.end is None:
            chunk = self.mcu.advance(self._until_next_change(min(CHUNK, max(1, most - self.mcu.samples()))))
            happened = self._collect()
            if self.sink is not None:
                self.sink(chunk, happened)
            self.options.progress(self.machine_time_s)
            if chunk.stop == "finished" and not self._continued():
                self.end = End.TASK_ERROR if any(task.error for task in self.tasks) else End.FINISHED
            elif self.options.interrupted():
                self.end = End.INTERRUPTED
            elif self.mcu.samples() >= most or (samples is None and self._is_overdue(begun)):
                self.end = End.TIME_LIMIT
        self.wall_time_s = time.monotonic() - begun
        return self

    def _is_overdue(self, begun: float) -> bool:
        return time.monotonic() - begun > self.options.max_time_s

    def _until_next_change(self, samples: int) -> int:
        now = self.mcu.samples()
        self._override_at(now)
        return min(samples, self._pending[0][0] - now) if self._pending else samples

    def _override_at(self, now: int) -> None:
        """Changes the override where that is due; TROVRST is what the job made of it."""
        while self._pending and self._pending[0][0] <= now:
            factor = self._pending.popleft()[1]
            if now or factor != 1.0:
                self.trovrst_s = max(self.trovrst_s, self.mcu.read_register("trovrst") if now else 0.0)
                self.mcu.write_register("trovr", factor)
                self.mcu.utrovr(list(range(self.mcu.axis_count())))

    def _collect(self) -> Happened:
        for task in self.tasks:
            task.output += self.mcu.take_output(task.number)
            errnum, errline, _, line, *_ = self.mcu.rdcncts(task.number)
            task.error = (errnum, errline) if errnum else None
            task.line, task.place = line, self.mcu.place(task.number)
        self._continued()
        self.listing.take(self.mcu.take_listing())
        names, new = self.machine.machine.axis_names, []
        for sample, kind, axis, name, on, line, value in self.mcu.events():
            who = names[axis] if kind != "task" and 0 <= axis < len(names) else ""
            entry = LogEntry(sample * self.sample_time_s, kind, who, name, on, line, value)
            new.append(entry)
            if on and (kind == "errorreg" or (kind == "axst" and name not in HARMLESS)):
                self.alarms.append(AlarmEvent(entry.t_s, who, value, name, line))
        self.log += new
        return tuple(new)

    def _continued(self) -> bool:
        """The application has read the output of a task that halts at writeln (MODEREG bit 26): it goes on."""
        halted = [t.number for t in self.tasks if self.mcu.rdcncts(t.number)[2] & HALTED_AT_WRITELN]
        for number in halted:
            self.mcu.contcnct(number)
        return bool(halted)
