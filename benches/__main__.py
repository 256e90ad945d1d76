"""First figures of speed: `make bench`, or `python -m benches [JOB...]`.

Per job, the best of several runs on one core: blocks compiled per second, machine seconds simulated per second with
the loop of 3 axes closed, and the same with the path check. Each also as cost in reference additions (one step of a
serial float64 sum, numpy.cumsum, measured in the same run), so that figures of two machines can be compared.
Jobs: examples/jobs/engraving.nc, and the workloads of ../shared/bench/gen.py where that exists.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from cnc_front.execution import Execution
from cnc_front.jobs import CompiledJob, CompileOptions, compile_job, load_machine, read_job
from cnc_front.run import CHUNK, RunOptions, dry_run

ROOT = Path(__file__).parents[1]
GENERATOR = Path(os.environ.get("CNC_FRONT_SHARED", ROOT.parent / "shared")) / "bench" / "gen.py"
ADDITIONS = 5_000_000
REPEATS = 3


def best(work: Callable[[], object]) -> float:
    """Least seconds of REPEATS calls."""

    def once() -> float:
        begun = time.perf_counter()
        work()
        return time.perf_counter() - begun

    return min(once() for _ in range(REPEATS))


def generator() -> Any:
    """The module that writes the workloads of LinuxCNC and others."""
    spec = importlib.util.spec_from_file_location("gen", GENERATOR)
    assert spec and spec.loader
    gen = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(gen)
    return gen


def workloads(folder: Path) -> Iterator[Path]:
    """The jobs; generated ones land in `folder`."""
    yield ROOT / "examples" / "jobs" / "engraving.nc"
    if not GENERATOR.is_file():
        print(f"skipped: the workloads of {GENERATOR} (not there)")
        return
    gen = generator()
    for name, write in {
        "a100k.ngc": lambda path: gen.short(100_000, path),
        "b100k.ngc": lambda path: gen.pocket(100_000, path),
        "c2k.ngc": lambda path: gen.part(2000, path),
    }.items():
        write(str(folder / name))
        yield folder / name


def simulate(job: CompiledJob) -> int:
    """Runs a job without looking at it; returns the samples."""
    execution = Execution(job)
    while execution.advance(CHUNK) is not None:
        pass
    return execution.mcu.samples()


def measure(path: Path, addition_s: float) -> str:
    """One row of the table."""
    source, machine, options = read_job(str(path)), load_machine(None), CompileOptions()
    job = compile_job(source, machine, options)
    blocks = job.facts["blocks"]
    compile_s = best(lambda: compile_job(source, machine, options))
    samples = simulate(job)
    machine_s = samples * machine.machine.sample_time_us * 1e-6
    kernel_s = best(lambda: simulate(job))
    whole_s = best(lambda: dry_run(job, RunOptions()))
    return (
        f"{path.name:<14}{blocks:>8}{blocks / compile_s:>12,.0f}{compile_s / blocks / addition_s:>8.0f}"
        f"{machine_s:>11.1f}{machine_s / kernel_s:>11,.0f}{kernel_s / samples / addition_s:>8.0f}"
        f"{machine_s / whole_s:>11,.0f}{whole_s / samples / addition_s:>8.0f}"
    )


def main(jobs: list[str]) -> None:
    numbers = np.ones(ADDITIONS)
    addition_s = best(lambda: np.cumsum(numbers, out=numbers)) / ADDITIONS
    print(f"one reference addition: {addition_s * 1e9:.2f} ns; best of {REPEATS} runs")
    print(f"{'':<14}{'compile':>28}{'':>11}{'kernel':>19}{'kernel and check':>19}")
    print(f"{'job':<14}{'blocks':>8}{'blocks/s':>12}{'adds':>8}{'machine s':>11}", end="")
    print(f"{'s per s':>11}{'adds':>8}{'s per s':>11}{'adds':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for path in map(Path, jobs) if jobs else workloads(Path(folder)):
            print(measure(path, addition_s), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
