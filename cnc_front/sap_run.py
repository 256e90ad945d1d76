"""A dry run of rw_SymPas jobs: up to four tasks on one controller, to their end.

A job starts as after a boot, open loop and not referenced (design D28). There is no programmed path to compare with:
the verdict says whether every task came to its end, and what went wrong.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import sympas as native_sympas
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError, Exit
from cnc_front.execution import HARMLESS, AlarmEvent, End
from cnc_front.jobs import JobSource, MachineFile, StimulusFile, shown
from cnc_front.messages import text
from cnc_front.verdict import EMPTY, SCHEMA, Reason, job_object, machine_object

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
    error: tuple[int, int] | None = None  # number and line
    line: int = 0  # being executed


@dataclass(frozen=True, slots=True)
class SapOptions:
    """What a run may vary."""

    max_time_s: float = 86400.0
    interrupted: Callable[[], bool] = lambda: False
    #: told the machine time, s, now and then
    progress: Callable[[float], None] = lambda seconds: None
    stimulus: StimulusFile | None = None


@dataclass(slots=True)
class SapRun:
    """Tasks on a controller. `run` carries them to their end."""

    machine: MachineFile
    tasks: list[Task]
    options: SapOptions = field(default_factory=SapOptions)
    mcu: native_kernel.Mcu = field(init=False)
    alarms: list[AlarmEvent] = field(init=False, default_factory=list)
    end: End = field(init=False, default=End.FINISHED)
    wall_time_s: float = field(init=False, default=0.0)

    def __post_init__(self) -> None:
        self.mcu = native_kernel.Mcu(self.machine.machine)
        if self.options.stimulus is not None:
            self.mcu.add_stimulus(self.options.stimulus.stimulus)
        for task in self.tasks:
            try:
                self.mcu.load(task.number, task.program)
            except ValueError as error:  # an autocode file of a larger machine
                hint = "compile the job for this machine"
                where = shown(task.source.path)
                raise CompileError([Diagnostic(where, 1, 1, 1, "CF202", str(error), hint)]) from None
        for task in self.tasks:
            self.mcu.startcnct(task.number)

    @property
    def machine_time_s(self) -> float:
        """Emulated time so far."""
        return self.mcu.samples() * self.machine.machine.sample_time_us * 1e-6

    def run(self) -> SapRun:
        """To the end of all tasks and of motion, or until time or the user ends it."""
        begun = time.monotonic()
        most = math.ceil(self.options.max_time_s / (self.machine.machine.sample_time_us * 1e-6))
        while True:
            chunk = self.mcu.advance(min(CHUNK, max(1, most - self.mcu.samples())))
            self._collect()
            self.options.progress(self.machine_time_s)
            if chunk.stop == "finished" and not self._continued():
                break
            if self.options.interrupted():
                self.end = End.INTERRUPTED
                break
            if self.mcu.samples() >= most or time.monotonic() - begun > self.options.max_time_s:
                self.end = End.TIME_LIMIT
                break
        if self.end is End.FINISHED and any(task.error for task in self.tasks):
            self.end = End.TASK_ERROR
        self.wall_time_s = time.monotonic() - begun
        return self

    def _collect(self) -> None:
        for task in self.tasks:
            task.output += self.mcu.take_output(task.number)
            errnum, errline, _, line, *_ = self.mcu.rdcncts(task.number)
            task.error = (errnum, errline) if errnum else None
            task.line = line
        self._continued()
        names = self.machine.machine.axis_names
        for sample, kind, axis, name, on, line, value in self.mcu.events():
            if on and (kind == "errorreg" or (kind == "axst" and name not in HARMLESS)):
                who = names[axis] if kind == "axst" and 0 <= axis < len(names) else ""
                t_s = sample * self.machine.machine.sample_time_us * 1e-6
                self.alarms.append(AlarmEvent(t_s, who, value, name, line))

    def _continued(self) -> bool:
        """The application has read the output of a task that halts at writeln (MODEREG bit 26): it goes on."""
        halted = [t.number for t in self.tasks if self.mcu.rdcncts(t.number)[2] & HALTED_AT_WRITELN]
        for number in halted:
            self.mcu.contcnct(number)
        return bool(halted)

    def reasons(self) -> tuple[Reason, ...]:
        """Why the run is no PASS, worst first."""
        found = [
            Reason("sap_error", {"task": t.number, "errnum": t.error[0], "line": t.error[1]})
            for t in self.tasks
            if t.error
        ]
        if self.end is End.TIME_LIMIT:
            found.append(Reason("time_limit", {"seconds": self.options.max_time_s}))
            alive = [t for t in self.tasks if self.mcu.rdcncts(t.number)[2] & EXECUTES]
            found += [Reason("sap_goes_on", {"task": t.number, "line": t.line}) for t in alive]
        if self.end is End.INTERRUPTED:
            found.append(Reason("interrupted", {}))
        for a in self.alarms:
            found.append(Reason("alarm", {"axis": a.axis, "name": a.name, "line": a.line, "t_s": a.t_s}))
        warnings = sum(len(t.warnings) for t in self.tasks)
        if warnings and not found:
            found.append(Reason("warnings", {"count": warnings}))
        return tuple(found)

    @property
    def exit(self) -> Exit:
        """What the process returns."""
        if self.end is End.INTERRUPTED:
            return Exit.INTERRUPTED
        if self.end is not End.FINISHED:
            return Exit.STOPPED
        return Exit.CHECK_FAILED if self.alarms else Exit.DONE

    @property
    def word(self) -> str:
        """PASS, WARN or FAIL."""
        if self.exit is not Exit.DONE:
            return "FAIL"
        return "WARN" if self.reasons() else "PASS"

    def as_json(self) -> dict[str, Any]:
        """The object of design 3.2 as far as it has a meaning, and `tasks`."""
        status, first = self.mcu.status(), self.tasks[0]
        failed = next((t for t in self.tasks if t.error), None)
        error = None
        if failed and failed.error:
            values = {"task": failed.number, "errnum": failed.error[0], "line": failed.error[1]}
            error = {"id": "CF301", "message": text("sap_error", "en", **values), "column": None, **values}
        elif self.end is not End.FINISHED:
            reason = next(r for r in self.reasons() if r.id in ("time_limit", "interrupted"))
            id = "CF303" if self.end is End.TIME_LIMIT else "CF304"
            error = {"id": id, "message": text(reason.id, "en", **reason.values)}
            error |= {"line": first.line, "column": None, "task": None, "errnum": None}
        words = {End.FINISHED: "completed", End.TASK_ERROR: "failed"}
        return EMPTY | {
            "schema": SCHEMA,
            "job": job_object(first.source, first.source.path),
            "machine": machine_object(self.machine, self.machine.path),
            "stimulus": self.options.stimulus.as_json() if self.options.stimulus else None,
            "status": words.get(self.end, "stopped"),
            "error": error,
            "machine_time_s": self.machine_time_s,
            "wall_time_s": self.wall_time_s,
            "samples": self.mcu.samples(),
            "sample_time_us": self.machine.machine.sample_time_us,
            "alarms": [
                {"t_s": a.t_s, "axis": a.axis, "bit": a.bit, "name": a.name, "line": a.line} for a in self.alarms
            ],
            "error_register": status["errorreg"],
            "output": first.output.splitlines(),
            "files": {"recording": None, "report": None},
            "diagnostics": [d.as_json() for t in self.tasks for d in t.warnings],
            "verdict": {"word": self.word, "reasons": [{"id": r.id, **r.values} for r in self.reasons()]},
            "tasks": [
                {
                    "task": t.number,
                    "path": shown(t.source.path),
                    "errnum": t.error[0] if t.error else 0,
                    "errline": t.error[1] if t.error else 0,
                    "csrcline": t.line,
                    "output": t.output.splitlines(),
                }
                for t in self.tasks
            ],
            "position": {
                name: axis["load"] for name, axis in zip(self.machine.machine.axis_names, status["axes"], strict=True)
            },
        }

    def as_text(self, language: str) -> str:
        """Verdict, figures, what the tasks wrote."""
        rows = [f"{shown(self.tasks[0].source.path)}: {self.word}"]
        rows += [f"  {text(r.id, language, **r.values)}" for r in self.reasons()[:10]]
        axes = zip(self.machine.machine.axis_names, self.mcu.status()["axes"], self.machine.machine.units, strict=True)
        where = "  ".join(f"{name} {axis['load']:.4f} {unit}" for name, axis, unit in axes)
        name = f"{self.machine.machine.name} ({self.machine.path or text('builtin', language)})"
        rows += [
            f"  {text('machine', language):<22} {name}",
            f"  {text('time', language):<22} {self.machine_time_s:.3f} s ({self.wall_time_s:.2f} s)",
            f"  {text('position', language):<22} {where}",
        ]
        for task in self.tasks:
            if task.output:
                head = [f"{text('task', language)} {task.number}:"] if len(self.tasks) > 1 else []
                rows += ["", *head, *task.output.splitlines()]
        return "\n".join(rows)
