"""Speed beside LinuxCNC's stand-alone interpreter: `python -m benches.peer [PAIRS]`.

Each row runs one of our commands and a reference command in turn, PAIRS times (5), as whole processes. Printed are the
medians of wall time, of processor time and of the ratio ours/reference pair by pair, which a busy machine changes
little, and our highest memory. The reference is `rs274 -g` (Debian package linuxcnc-uspace) interpreting the million
short lines of a1m.ngc; without it those rows are skipped, and this says so. A recording is compared with the same run
without one. Issues 3, 4 and 7 ask for what stands in the last column.
"""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from benches.__main__ import GENERATOR, ROOT, generator

COMPILE = """
import sys
from cnc_front.jobs import CompileOptions, compile_job, load_machine, read_job
job = compile_job(read_job(sys.argv[1]), load_machine(None), CompileOptions())
"""
#: a job translated to autocode as a stream, as `run` and `translate` do
TRANSLATE = """
import sys
from cnc_front._native import gcode
from cnc_front.jobs import CompileOptions, load_machine
for segment in gcode.Stream(sys.argv[1], sys.argv[1], load_machine(None).machine, CompileOptions(), 1):
    pass
"""
#: a job simulated to the end of its motion, nothing measured
SIMULATE = (
    COMPILE
    + """
from cnc_front.execution import Execution
execution = Execution(job)
while execution.advance(1 << 16) is not None:
    pass
"""
)


@dataclass(frozen=True, slots=True)
class Cost:
    """What a process took: seconds of wall and processor, MiB."""

    wall_s: float
    cpu_s: float
    peak_mib: float


def cost(command: Sequence[str], folder: Path) -> Cost:
    """Runs a command to its end in a folder; what it prints is thrown away."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    begun = time.perf_counter()
    with subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    wall_s = time.perf_counter() - begun
    if process.returncode not in (0, 1):
        raise RuntimeError(f"{' '.join(command)}: exit code {process.returncode}")
    return Cost(wall_s, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def row(name: str, ours: Sequence[str], reference: Sequence[str], folder: Path, pairs: int, wanted: str) -> str:
    """One line of the table."""
    both = [(cost(ours, folder), cost(reference, folder)) for _ in range(pairs)]

    def median(value: Callable[[Cost, Cost], float]) -> float:
        return statistics.median(value(a, b) for a, b in both)

    return (
        f"{name:<26}{median(lambda a, b: a.wall_s):8.2f}{median(lambda a, b: a.cpu_s):8.2f}"
        f"{median(lambda a, b: b.wall_s):9.2f}{median(lambda a, b: b.cpu_s):8.2f}"
        f"{median(lambda a, b: a.wall_s / b.wall_s):9.3f}{median(lambda a, b: a.cpu_s / b.cpu_s):8.3f}"
        f"{max(a.peak_mib for a, _ in both):8.0f}  {wanted}"
    )


def ours(*arguments: str) -> list[str]:
    """A command line of cnc-front."""
    return [sys.executable, "-m", "cnc_front", *arguments]


def main(pairs: int) -> None:
    if not GENERATOR.is_file():
        print(f"skipped: all of benches.peer (its workloads come from {GENERATOR}, which is not there)")
        return
    gen = generator()
    print(f"median of {pairs} pairs of processes; seconds, ratios ours/reference, MiB; load {os.getloadavg()[0]:.1f}")
    print(f"{'':<26}{'ours':>16}{'reference':>17}{'ratio':>17}{'peak':>8}")
    print(f"{'':<26}{'wall':>8}{'cpu':>8}{'wall':>9}{'cpu':>8}{'wall':>9}{'cpu':>8}{'MiB':>8}  wanted")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        gen.short(1_000_000, str(folder / "a1m.ngc"))
        gen.pocket(100_000, str(folder / "b100k.ngc"))
        rs274 = shutil.which("rs274")
        if rs274 is None:
            print("skipped: the rows beside rs274 (not installed: Debian package linuxcnc-uspace)")
        else:
            reference = [rs274, "-g", "a1m.ngc"]
            for title, command, wanted in (
                ("check a1m", ours("check", "-q", "a1m.ngc"), "at most 0.1 (issue 4), 200 MiB"),
                ("a1m to autocode", [sys.executable, "-c", TRANSLATE, "a1m.ngc"], "at most 0.25 (issue 4), 200 MiB"),
                ("a1m to end of motion", [sys.executable, "-c", SIMULATE, "a1m.ngc"], "wall below 1 (issue 3)"),
                ("a1m to verdict", ours("run", "-q", "a1m.ngc"), "wall below 1 (issue 7)"),
                ("b100k to verdict, to a1m", ours("run", "-q", "b100k.ngc"), "4.25 s where rs274 takes 4 (issue 7)"),
            ):
                print(row(title, command, reference, folder, pairs, wanted), flush=True)
        plain, recorded = ours("run", "-q", "b100k.ngc"), ours("run", "-q", "b100k.ngc", "--record", "b.mcap")
        print(row("b100k recorded, to plain", recorded, plain, folder, pairs, "wall at most 1.6 (issue 7)"), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
