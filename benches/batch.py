"""A night's batch in small: `python -m benches.batch [PROGRAMS]`, 1,000 generated programs on two machines.

Sizes from 2 to 50,000 lines, as many small as large on a logarithmic scale. Told are wall time on one core and on all
of them (issue 9 asks for 1.8 on two), what loops that share nothing gain from them, the largest memory of a worker, and
that every result is there once.
"""

from __future__ import annotations

import math
import os
import random
import resource
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[1]
MACHINES = ("mill3", "mill4a")
CORES = len(os.sched_getaffinity(0))


def write(folder: Path, programs: int) -> int:
    """Programs of random lines; returns how many lines in all."""
    dice, total = random.Random(9), 0
    for n in range(programs):
        lines = round(math.exp(dice.uniform(math.log(2), math.log(50_000))))
        x = y = 0.0
        text = ["G90 G17 G64", "G00 X0 Y0 Z5", "F6000"]
        for _ in range(lines):
            x, y = (max(-300.0, min(300.0, v + dice.gauss(0, 0.6))) for v in (x, y))
            text.append(f"G01 X{x:.3f} Y{y:.3f}")
        (folder / f"p{n:04}.nc").write_text("\n".join([*text, "M30", ""]))
        total += lines
    return total


def batch(folder: Path, out: Path, cores: int) -> float:
    """Seconds of a batch from nothing, on the first `cores` cores with a worker each."""
    machines = [
        word for name in MACHINES for word in ("--machine", str(ROOT / "examples" / "machines" / f"{name}.toml"))
    ]
    rest = ["--jobs", str(cores), "--reports", "1", "-q"]
    command = [sys.executable, "-m", "cnc_front", "batch", str(folder), *machines, "--out", str(out), *rest]
    begun = time.perf_counter()
    with pinned(cores):
        subprocess.run(command, cwd=ROOT, check=False)
    return time.perf_counter() - begun


@contextmanager
def pinned(cores: int) -> Iterator[None]:
    """What is started here stays on the first `cores` cores."""
    all_of_them = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(all_of_them)[:cores])
    try:
        yield
    finally:
        os.sched_setaffinity(0, all_of_them)


def loops(cores: int) -> float:
    """Seconds for as many equal loops as there are cores, on the first `cores` of them."""
    begun = time.perf_counter()
    with pinned(cores):
        command = [sys.executable, "-c", "for n in range(60_000_000): pass"]
        for running in [subprocess.Popen(command) for _ in range(CORES)]:
            running.wait()
    return time.perf_counter() - begun


def main() -> None:
    """Prints the figures."""
    programs = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "parts"
        folder.mkdir()
        lines = write(folder, programs)
        seconds = {cores: batch(folder, Path(name) / f"out{cores}", cores) for cores in (1, CORES)}
        most = max(seconds)
        with sqlite3.connect(Path(name) / f"out{most}" / "results.sqlite") as base:
            count, distinct, machine_s = base.execute(
                "SELECT count(*), count(DISTINCT part || machine), sum(machine_time_s) FROM results"
            ).fetchone()
    blocks, peak = 2 * lines, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    hours = machine_s / 3600
    print(f"{programs} programs of {lines} lines: {count} results, {distinct} distinct, {hours:.1f} machine hours")
    for cores, took in seconds.items():
        print(f"{cores} core(s): {took:.1f} s, {took / blocks * 1e6:.1f} s per million blocks")
    ideal = loops(1) / loops(CORES)
    print(f"speed-up {seconds[1] / seconds[most]:.2f} (loops that share nothing: {ideal:.2f})")
    print(f"largest process {peak:.0f} MiB")


if __name__ == "__main__":
    main()
