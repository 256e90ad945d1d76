"""A run that ended, made by a real dry run of a small program: what the report screen shows is the same each time."""

from __future__ import annotations

from functools import cache

from cnc_front.deliver import Plotting
from cnc_front.execution import Execution
from cnc_front.jobs import CompiledJob, CompileOptions, JobSource, compile_job, load_machine
from cnc_front.outcome import Outcome, outcome_of
from cnc_front.run import RunOptions, dry_run
from cnc_front.service import Service, service_of

PROGRAM = b"""N10 G90 G21 G17
N20 G0 X10 Y5
N30 G1 X40 F3000
N40 G3 X50 Y15 I0 J10
N50 G1 Y40
N60 G1 X20
N70 G1 X0 Y0
N80 M30
"""


@cache
def compiled() -> CompiledJob:
    return compile_job(JobSource("parts/contour.nc", PROGRAM, "din66025"), load_machine(None), CompileOptions())


def ended(number: int = 1, override: float = 1.0, tolerance_mm: float | None = None) -> Outcome:
    """The outcome of a run at that override."""
    job = compiled()
    plotting = Plotting(tolerance_mm or job.machine.machine.tolerance_mm)
    result = dry_run(job, RunOptions(schedule=((0.0, override),)), None, plotting)
    return outcome_of(result, plotting, number, tolerance_mm)


def registers(language: str, samples: int = 500) -> Service:
    """The controller after so many samples of that program."""
    execution = Execution(compiled())
    while execution.mcu.samples() < samples:
        execution.advance(samples - execution.mcu.samples())
    return service_of(execution.mcu, compiled().machine, language)
