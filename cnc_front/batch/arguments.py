"""The command lines of `batch` and `compare`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any


def _count(text: str) -> int:
    if not text.isdigit() or not 0 < int(text) < 1_000_000:
        raise argparse.ArgumentTypeError(f"'{text}' is no number from 1 to 999999")
    return int(text)


def add(commands: Any, common: Any, seconds: Callable[[str], float], millimetres: Callable[[str], float]) -> None:
    """Adds both commands to the parser of cnc_front.cli."""
    batch = commands.add_parser("batch", parents=[common], help="dry-run many parts on several machines")
    batch.add_argument("paths", metavar="PATH", nargs="*", help="part programs, folders, globs, .zip")
    batch.add_argument("--machine", metavar="FILE", action="append", default=[], help="machine file (again for more)")
    batch.add_argument("--out", metavar="DIR", default="out/batch", help="results.sqlite, index.html, junit.xml ...")
    batch.add_argument("-j", "--jobs", metavar="N", type=_count, help="worker processes (default: one a core)")
    batch.add_argument("--override", metavar="SCHEDULE", default="1", help="as for run")
    batch.add_argument("--profile", choices=("din", "fanuc", "linuxcnc", "lathe"), help="dialect of the programs")
    batch.add_argument("--tolerance", metavar="MM", type=millimetres, help="limit of the contour deviation")
    batch.add_argument("--max-time", metavar="S", type=seconds, default=86400.0, help="machine and wall time of a part")
    batch.add_argument("--max-memory", metavar="MIB", type=_count, default=0, help="memory of a worker process")
    batch.add_argument("--reports", metavar="N", type=_count, default=10, help="reports of the worst N (default 10)")
    batch.add_argument("--fail-fast", action="store_true", help="end at the first part that is not good")
    batch.add_argument("--again", action="store_true", help="run what is known too")
    batch.add_argument("--watch", metavar="DIR", help="dry-run what is dropped into a folder, verdict beside it")
    batch.add_argument("--once", action="store_true", help="with --watch: end when nothing new is left")
    batch.add_argument("--cluster", metavar="ADDRESS", help="run on a Dask cluster (extra `cluster`)")
    batch.add_argument("--json", action="store_true", help="a line of JSON for each result")
    compare = commands.add_parser("compare", parents=[common], help="what changed between two runs or two batches")
    compare.add_argument("before", metavar="RUN1", help="recording, report folder or report.json; folder of a batch")
    compare.add_argument("after", metavar="RUN2")
    compare.add_argument("--out", metavar="DIR", help="of two runs: a page with both side by side")
    compare.add_argument("--json", action="store_true", help="as JSON")
