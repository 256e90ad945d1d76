"""A night's batch in small: `python -m benches.batch [PROGRAMS]`, 1,000 generated programs on two machines.

Sizes from 2 to 50,000 lines, as many small as large on a logarithmic scale. Told are wall time with one worker and with
all cores (issue 9 asks for 1.8 on two), the largest memory of a worker, and that every result is there once.
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
from pathlib import Path

ROOT = Path(__file__).parents[1]
MACHINES = ("mill3", "mill4a")


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


def batch(folder: Path, out: Path, jobs: int) -> float:
    """Seconds of a batch from nothing."""
    machines = [
        word for name in MACHINES for word in ("--machine", str(ROOT / "examples" / "machines" / f"{name}.toml"))
    ]
    command = [sys.executable, "-m", "cnc_front", "batch", str(folder), *machines]
    begun = time.perf_counter()
    subprocess.run([*command, "--out", str(out), "--jobs", str(jobs), "--reports", "1", "-q"], cwd=ROOT, check=False)
    return time.perf_counter() - begun


def main() -> None:
    """Prints the figures."""
    programs = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "parts"
        folder.mkdir()
        lines = write(folder, programs)
        seconds = {jobs: batch(folder, Path(name) / f"out{jobs}", jobs) for jobs in (1, os.cpu_count() or 1)}
        most = max(seconds)
        with sqlite3.connect(Path(name) / f"out{most}" / "results.sqlite") as base:
            count, distinct, machine_s = base.execute(
                "SELECT count(*), count(DISTINCT part || machine), sum(machine_time_s) FROM results"
            ).fetchone()
    blocks, peak = 2 * lines, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    hours = machine_s / 3600
    print(f"{programs} programs of {lines} lines: {count} results, {distinct} distinct, {hours:.1f} machine hours")
    for jobs, took in seconds.items():
        print(f"{jobs} worker(s): {took:.1f} s, {took / blocks * 1e6:.1f} s per million blocks")
    print(f"speed-up {seconds[1] / seconds[most]:.2f}, largest process {peak:.0f} MiB")


if __name__ == "__main__":
    main()
