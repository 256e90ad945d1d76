"""`cnc-front batch`: from paths to a store, pages, reports of the worst, and one exit code."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from cnc_front.batch import parts
from cnc_front.batch.pages import write_pages
from cnc_front.batch.parts import Task
from cnc_front.batch.pool import Limits, Outcome, run_all
from cnc_front.batch.store import Row, Store
from cnc_front.errors import Exit, UsageError
from cnc_front.interrupt import interruptible
from cnc_front.jobs import load_machine
from cnc_front.messages import language_from, text

#: Bytes of text that take as long as starting a part does.
TASK_BYTES = 5_000

Runner = Callable[[Sequence[Task]], Iterator[Outcome]]


def batch(options: argparse.Namespace) -> int:
    """Runs what is not known yet, keeps it, and writes the pages. The exit code is that of the worst result."""
    if options.watch:
        from cnc_front.batch.watch import watch

        return watch(options)
    if not options.paths:
        raise UsageError("batch needs PATH... or --watch DIR")
    out = Path(options.out)
    wanted = tasks_of(options.paths, options, out)
    store = Store(out)
    with interruptible() as interrupted:
        known = set() if options.again else store.known()
        # the largest first: none of them is left for one worker at the end, when the others have nothing to do
        todo = sorted((task for task in wanted if task.key not in known), key=lambda task: -task.part.bytes)
        size = sum(t.part.bytes + TASK_BYTES for t in todo)
        progress = Progress(len(wanted), len(wanted) - len(todo), size, options)
        failed: list[Row] = []

        def over() -> bool:
            return interrupted() or (options.fail_fast and bool(failed))

        for outcome in runner(options, over)(todo):
            row = store.put(outcome)
            progress.tell(outcome, row)
            failed += [row] if row["code"] else []
            if options.json:
                print(json.dumps({name: row[name] for name in row if name not in ("run", "stderr")}), flush=True)
            if over():
                break
        stopped = interrupted()
    keys = {task.key for task in wanted}
    rows = [row for row in store.rows() if row["key"] in keys]
    reports = {} if stopped or (failed and options.fail_fast) else worst_reports(rows, wanted, options, out)
    write_pages(out, rows, reports)
    store.close()
    if not options.json:
        from cnc_front.batch.table import table

        print(table(rows, out / "index.html", language_from(options.lang)))
    return Exit.INTERRUPTED if stopped else max((row["code"] for row in rows), default=int(Exit.DONE))


def tasks_of(paths: Sequence[str], options: argparse.Namespace, out: Path) -> list[Task]:
    """Every part on every machine."""
    machines = []
    for path in options.machine or [None]:
        machine = load_machine(path)
        machines.append((path or "", machine.machine.name, machine.text))
    return parts.tasks(parts.find(paths, out / "unpacked"), machines, run_options(options))


def run_options(options: argparse.Namespace) -> list[str]:
    """The options of `run` that hold for every part."""
    chosen = ["--max-time", repr(options.max_time), "--override", options.override]
    if options.profile is not None:
        chosen += ["--profile", options.profile]
    if options.tolerance is not None:
        chosen += ["--tolerance", repr(options.tolerance)]
    return chosen


def arguments_of(options: argparse.Namespace) -> Callable[[Task], list[str]]:
    """The command line of `run` for a task."""
    common, of_paths = run_options(options), ("--tolerance", "--override", "--profile")
    pairs = [common[n : n + 2] for n in range(0, len(common), 2)]

    def arguments(task: Task) -> list[str]:
        machine = ["--machine", str(Path(task.machine).resolve())] if task.machine else []
        # a rw_SymPas job has no programmed path
        job = [p for p in pairs if task.part.path.suffix.lower() != ".src" or p[0] not in of_paths]
        return [str(task.part.path), *machine, *(word for pair in job for word in pair)]

    return arguments


def limits_of(options: argparse.Namespace) -> Limits:
    """What one task may take."""
    return Limits(options.max_time, options.max_memory)


def runner(options: argparse.Namespace, interrupted: Callable[[], bool]) -> Runner:
    """Runs tasks on this machine, or on a cluster."""
    if options.cluster:
        from cnc_front.batch.cluster import on_cluster

        return on_cluster(options.cluster, arguments_of(options), limits_of(options), interrupted)
    jobs = options.jobs or os.cpu_count() or 1
    return lambda tasks: run_all(tasks, arguments_of(options), jobs, limits_of(options), interrupted)


def worst_reports(rows: Sequence[Row], tasks: Sequence[Task], options: argparse.Namespace, out: Path) -> dict[str, str]:
    """Reports of the worst results that ran, made by running them once more; those that are there stay."""
    by_key = {task.key: task for task in tasks}
    ran = [row for row in rows if row["run"] is not None and row["deviation_max_mm"] is not None]
    made: dict[str, str] = {}
    todo: list[Task] = []
    for row in ran[: options.reports]:
        made[row["key"]] = f"reports/{row['key'][:16]}/report.html"
        if not (out / made[row["key"]]).is_file():
            todo.append(by_key[row["key"]])
    arguments = arguments_of(options)

    def with_report(task: Task) -> list[str]:
        return [*arguments(task), "--report", str((out / made[task.key]).parent.resolve())]

    for outcome in run_all(todo, with_report, options.jobs or os.cpu_count() or 1, limits_of(options)):
        if not (out / made[outcome.task.key]).is_file():
            del made[outcome.task.key]
    return made


class Progress:
    """One line a result on stderr, with the rest time by the size of what is left."""

    def __init__(self, total: int, done: int, todo_bytes: int, options: argparse.Namespace) -> None:
        self.total, self.done, self.left = total, done, todo_bytes
        self.quiet, self.language = options.quiet, language_from(options.lang)
        self.spent, self.bytes = 0.0, 0
        if done and not self.quiet:
            print(text("batch_known", self.language, done=done, total=total), file=sys.stderr)

    def tell(self, outcome: Outcome, row: Row) -> None:
        """A result has come."""
        size = outcome.task.part.bytes + TASK_BYTES
        self.done, self.left = self.done + 1, self.left - size
        self.spent, self.bytes = self.spent + outcome.wall_s, self.bytes + size
        if self.quiet:
            return
        rest = self.spent / self.bytes * self.left
        figures = f"{row['deviation_max_mm'] * 1e3:.2f} um" if row["deviation_max_mm"] is not None else ""
        facts = {"name": row["part"], "machine": row["machine_name"], "rest": rest}
        begin = text("batch_line", self.language, done=self.done, total=self.total, **facts)
        print(f"{begin} {row['verdict']} {figures} {row['reason']}".rstrip(), file=sys.stderr)
