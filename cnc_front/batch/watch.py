"""`cnc-front batch --watch DIR`: dry-runs what CAM drops into a folder and lays a verdict beside each program."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from cnc_front.batch import command, parts
from cnc_front.batch.pool import run_all
from cnc_front.batch.store import Row, Store, row_of
from cnc_front.errors import Exit, UsageError
from cnc_front.interrupt import interruptible

#: Between two looks at the folder, s. A file that has not changed from one look to the next is complete.
PAUSE_S = 1.0
ENDING = ".verdict.txt"


def watch(options: argparse.Namespace) -> int:
    """Looks until it is interrupted; with `--once` until nothing new is left."""
    folder = Path(options.watch)
    if not folder.is_dir():
        raise UsageError(f"{folder} is no folder")
    out = Path(options.out)
    store = Store(out)
    seen: dict[Path, tuple[int, int]] = {}
    with interruptible() as interrupted:
        while not interrupted():
            programs = (f for f in sorted(folder.rglob("*")) if f.suffix.lower() in parts.SUFFIXES and f.is_file())
            now = {f: _stamp(f) for f in programs}
            steady = [f for f, stamp in now.items() if seen.get(f) == stamp]
            fresh = steady != [] and _serve(steady, options, out, store)
            if options.once and seen == now and not fresh:
                break
            seen = now
            time.sleep(PAUSE_S)
    store.close()
    return Exit.DONE


def _stamp(file: Path) -> tuple[int, int]:
    try:
        status = file.stat()
    except OSError:
        return (0, 0)
    return (status.st_size, status.st_mtime_ns)


def _serve(files: list[Path], options: argparse.Namespace, out: Path, store: Store) -> bool:
    """Runs the programs without a result. True if there were any."""
    known = store.known()
    todo = [t for t in command.tasks_of([str(f) for f in files], options, out) if t.key not in known]
    for outcome in run_all(todo, command.arguments_of(options), options.jobs or 1, command.limits_of(options)):
        store.put(outcome)
        _lay_beside(outcome.task.part.path, row_of(outcome))
    return bool(todo)


def _lay_beside(program: Path, row: Row) -> None:
    """One line a machine; that of this one is replaced."""
    target = program.with_name(program.name + ENDING)
    figures = f", {row['deviation_max_mm'] * 1e3:.2f} um" if row["deviation_max_mm"] is not None else ""
    time_s = f", {row['machine_time_s']:.1f} s" if row["machine_time_s"] is not None else ""
    line = f"{row['verdict']} on {row['machine_name']}{figures}{time_s} {row['reason']}".rstrip() + "\n"
    begun = [] if not target.is_file() else target.read_text("utf-8").splitlines(keepends=True)
    others = [text for text in begun if f" on {row['machine_name']}" not in text]
    target.write_text("".join([*others, line]), "utf-8")
