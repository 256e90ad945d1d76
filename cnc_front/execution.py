"""The stepping core: one job on the emulated controller, chunk by chunk.

`run` and the terminal's engine drive the same object. It applies the override schedule at exact samples,
acknowledges what waits for the application (or leaves that to the operator), and turns kernel events into
alarms and log entries.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from enum import StrEnum

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.errors import CompileError
from cnc_front.jobs import CompiledJob, shown
from cnc_front.readiness import not_ready
from cnc_front.schedule import Schedule
from cnc_front.streaming import StreamedJob


class End(StrEnum):
    """Why a job is over."""

    FINISHED = "finished"
    FAULT = "fault"
    TASK_ERROR = "task_error"
    TIME_LIMIT = "time_limit"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True, slots=True)
class AlarmEvent:
    """An error bit that came up: axst of an axis or ErrorReg of the controller."""

    t_s: float
    axis: str
    bit: int
    name: str
    line: int
    #: set point minus actual position, and set point, in that sample, axis units; None where no sample tells
    following: float | None = None
    set_point: float | None = None


@dataclass(frozen=True, slots=True)
class Fault:
    """The alarm that stopped a job, and where the axes were."""

    alarm: AlarmEvent
    position: dict[str, float]


@dataclass(frozen=True, slots=True)
class HostEvent:
    """Something the program told the application in step with motion: M00, M06, MSG, T ..."""

    t_s: float
    line: int
    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class LogEntry:
    """Any kernel event, for the recording."""

    t_s: float
    kind: str
    axis: str
    name: str
    on: bool
    line: int
    value: int


#: What happened in a stretch of time, in order.
Happened = tuple[LogEntry | HostEvent, ...]

#: Status bits that are no fault when they come up.
HARMLESS = frozenset({"pe", "cl", "ip", "ui", "lpsf", "referenced", "refh"})

#: Bit of CNCTS.running: the task waits for the next single step (4.3.2.10).
WAITS_FOR_STEP = 2


@dataclass(slots=True)
class Execution:
    """A running job. `advance` is the only way time passes."""

    job: CompiledJob | StreamedJob
    schedule: Schedule = ((0.0, 1.0),)
    max_machine_s: float = math.inf
    #: what the world outside does, beside the rules of the machine file
    stimulus: native_kernel.Stimulus | None = None
    #: resources to scan, by name
    scan: tuple[str, ...] = ()
    #: run and batch acknowledge M00, M06 ... at the next sample (design D29); the terminal waits for the operator
    acknowledges: bool = True
    #: a controller that is ready for part programs already; a new one without
    on: native_kernel.Mcu | None = None
    mcu: native_kernel.Mcu = field(init=False)
    sample_time_s: float = field(init=False)
    alarms: list[AlarmEvent] = field(init=False, default_factory=list)
    host_events: list[HostEvent] = field(init=False, default_factory=list)
    #: host events that were forgotten: those before the first of `host_events`
    forgotten: int = field(init=False, default=0)
    log: list[LogEntry] = field(init=False, default_factory=list)
    output: str = field(init=False, default="")
    end: End | None = field(init=False, default=None)
    #: what stopped the job; it ends once the axes stand
    fault: Fault | None = field(init=False, default=None)
    #: number of the runtime error and line of a task that stopped
    task_error: tuple[int, int] | None = field(init=False, default=None)
    #: command (ssf number) that waits for the application while `acknowledges` is off
    waits: int = field(init=False, default=0)
    #: a feed hold has come to rest; a single step is done. The operator's engine clears both when it goes on.
    held: bool = field(init=False, default=False)
    stepped: bool = field(init=False, default=False)
    _axes: list[str] = field(init=False)
    _pending: deque[tuple[int, float]] = field(init=False)
    _new: list[LogEntry | HostEvent] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        machine = self.job.machine.machine
        self.sample_time_s = machine.sample_time_us * 1e-6
        self._axes = list(machine.axis_names)
        self.mcu = self.on or native_kernel.Mcu(machine)
        if self.on is None:
            self.mcu.prepare_gcode()
        if self.job.source.language == "din66025":
            problems = not_ready(self.mcu, machine, shown(self.job.source.path))
            if problems:
                raise CompileError(problems)
        if self.stimulus is not None:
            self.mcu.add_stimulus(self.stimulus)
        if self.scan:
            from cnc_front.scan import begin_scan

            begin_scan(self.mcu, self.scan, self._axes)
        self.mcu.load(0, self.job.program)
        self._pending = deque((round(t / self.sample_time_s), f) for t, f in self.schedule)
        self._take_initial_override(machine.trovrst_s)
        self.mcu.startcnct(0)

    def _take_initial_override(self, trovrst_s: float) -> None:
        """The factor at time 0 holds before motion starts, so it does not ramp."""
        if self._pending and self._pending[0][0] == 0:
            self.mcu.write_register("trovrst", 0.0)
            self._apply(self._pending.popleft()[1])
            self.mcu.write_register("trovrst", trovrst_s)

    def _apply(self, factor: float) -> None:
        self.mcu.write_register("trovr", factor)
        self.mcu.utrovr(list(range(len(self._axes))))

    @property
    def machine_time_s(self) -> float:
        """Emulated time so far."""
        return self.mcu.samples() * self.sample_time_s

    def set_override(self, factor: float) -> None:
        """The operator's override, from the next sample on, with TROVRST."""
        self._pending.clear()
        self._apply(factor)

    def advance(self, samples: int) -> native_kernel.Chunk | None:
        """Up to `samples` samples; fewer at override changes and whenever the controller has something to say.
        None once the job is over."""
        if self.end is not None:
            return None
        chunk = self.mcu.advance(self._until_next_change(samples))
        self._collect_events(chunk)
        self._react(chunk.stop, chunk.stop_value)
        return chunk

    def _until_next_change(self, samples: int) -> int:
        now = self.mcu.samples()
        while self._pending and self._pending[0][0] <= now:
            self._apply(self._pending.popleft()[1])
        if self._pending:
            samples = min(samples, self._pending[0][0] - now)
        if math.isfinite(self.max_machine_s):
            samples = min(samples, max(1, math.ceil(self.max_machine_s / self.sample_time_s) - now))
        return samples

    def _react(self, stop: str, value: int) -> None:
        if stop == "fault":
            self._stop_at_fault(value)
        elif stop == "finished" and self.fault is not None:
            self.end = End.FAULT
        elif stop == "finished":
            self.stepped = self.mcu.rdcncts(0)[2] & WAITS_FOR_STEP != 0
            self.end = None if self.stepped else End.FINISHED
        elif stop == "held":
            self.held = True
        elif stop == "task_error":
            self.end = End.TASK_ERROR
        elif stop == "acknowledge":
            self.waits = value
            if self.acknowledges:
                self.acknowledge()
        if self.end is None and self.machine_time_s >= self.max_machine_s:
            self.end = End.TIME_LIMIT

    def _stop_at_fault(self, axis: int) -> None:
        """An application would stop all axes; the job ends as they stand. Further faults change nothing."""
        if self.fault is not None:
            return
        name = self._axes[axis]
        alarm = next(
            (a for a in self.alarms if a.axis == name and a.t_s == self.alarms[-1].t_s),
            self.alarms[-1] if self.alarms else AlarmEvent(self.machine_time_s, name, 0, "", 0),
        )
        loads = (float(values["load"]) for values in self.mcu.status()["axes"])
        self.fault = Fault(alarm, dict(zip(self._axes, loads, strict=True)))
        self.mcu.stop_job()
        self.waits, self.held, self.stepped = 0, False, False

    def acknowledge(self) -> None:
        """The operator has done what the program waits for."""
        self.waits = 0
        self.mcu.acknowledge()

    def forget(self) -> None:
        """What was logged and told so far is not needed again: a long run in little memory."""
        self.log.clear()
        self.forgotten += len(self.host_events)
        self.host_events.clear()

    def happened(self) -> Happened:
        """Log entries and host events since the last call."""
        new, self._new = tuple(self._new), []
        return new

    def _collect_events(self, chunk: native_kernel.Chunk) -> None:
        for sample, kind, axis, name, on, line, value in self.mcu.events():
            t_s = sample * self.sample_time_s
            who = self._axes[axis] if kind != "task" and 0 <= axis < len(self._axes) else ""
            if kind == "host":
                self._host_event(t_s, value)
                continue
            entry = LogEntry(t_s, kind, who, name, on, line, value)
            self.log.append(entry)
            self._new.append(entry)
            if kind == "task":
                self.task_error = (value, line)
            elif on and (kind == "errorreg" or (kind == "axst" and name not in HARMLESS)):
                self.alarms.append(
                    AlarmEvent(t_s, who, value, name, line, *_measured(chunk, sample, axis if who else -1))
                )
        self.output += self.mcu.take_output(0)

    def _host_event(self, t_s: float, number: int) -> None:
        told = self.job.program.event(number) if number >= 0 else None
        if told is not None:
            line, kind, text = told
            event = HostEvent(t_s, line, kind, text)
            self.host_events.append(event)
            self._new.append(event)


def _measured(chunk: native_kernel.Chunk, sample: int, axis: int) -> tuple[float | None, float | None]:
    """Following error and set point of an axis in the sample of an event; None without an axis."""
    row = sample - chunk.first_sample
    if axis < 0 or not 0 <= row < len(chunk):
        return None, None
    set_point = float(chunk.dp[row, axis])
    return set_point - float(chunk.rp[row, axis]), set_point
