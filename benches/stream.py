"""Memory of large part programs: `python -m benches.stream [LINES]` (10,000,000).

Every way to read a generated program of short blocks, and one a tenth as long: wall time, lines per second, highest
memory, and its ratio, which stays about 1. Issue 4 asks that memory stays bounded. A recording takes 0.3 kB a line of
disk.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from benches.__main__ import GENERATOR, generator
from benches.peer import cost, ours


def main(lines: int) -> None:
    if not GENERATOR.is_file():
        print(f"skipped: all of benches.stream (its workloads come from {GENERATOR}, which is not there)")
        return
    gen = generator()
    print(f"{'':<18}{'lines':>12}{'wall s':>10}{'lines/s':>12}{'peak MiB':>10}{'ratio':>8}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sizes = (lines // 10, lines)
        for size in sizes:
            gen.short(size, str(folder / f"{size}.ngc"))
        part = ["--from", str(lines // 50), "--to", str(lines // 20)]
        for title, arguments in (
            ("check", ["check", "-q"]),
            ("check --strict", ["check", "-q", "--strict"]),
            ("check a part", ["check", "-q", *part]),
            ("translate", ["translate", "-q"]),
            ("translate --json", ["translate", "-q", "--json"]),
            ("run", ["run", "-q", "--max-time", "1e6"]),
            ("run a part", ["run", "-q", "--max-time", "1e6", *part]),
            ("run --record", ["run", "-q", "--max-time", "1e6", "--record", "run.mcap"]),
        ):
            least = 0.0
            for size in sizes:
                took = cost(ours(*arguments, f"{size}.ngc"), folder)
                least = least or took.peak_mib
                ratio = f"{took.peak_mib / least:8.2f}"
                per_second = size / took.wall_s
                print(
                    f"{title:<18}{size:>12}{took.wall_s:>10.1f}{per_second:>12.0f}{took.peak_mib:>10.0f}{ratio}",
                    flush=True,
                )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000_000)
