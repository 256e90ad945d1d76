"""Tasks of a batch on a Dask cluster: the same worker processes, started where there is room.

The code of cnc-front travels to every worker once, part, subprograms beside it and machine file with the task. A worker
that dies costs a retry, not the task.
"""

from __future__ import annotations

import importlib
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cnc_front.batch import ship
from cnc_front.batch.parts import BESIDE_BYTES, Part, Task
from cnc_front.batch.pool import Limits, Outcome, run_all
from cnc_front.errors import Exit, UsageError

#: Times that a task is given to another worker when the one it had died.
RETRIES = 5
#: What travels with a part at most, bytes.
LUGGAGE_BYTES = 1 << 26


def on_cluster(
    address: str, arguments_of: Callable[[Task], list[str]], limits: Limits, interrupted: Callable[[], bool]
) -> Callable[[Sequence[Task]], Iterator[Outcome]]:
    """A runner of tasks on the cluster at `address`; UsageError where there is none."""
    try:
        dask: Any = importlib.import_module("distributed")  # has no types
    except ImportError:
        raise UsageError("--cluster needs the extra `cluster`: pip install 'cnc-front[cluster]'") from None

    def run(tasks: Sequence[Task]) -> Iterator[Outcome]:
        try:
            client = dask.Client(address, timeout=20)
        except (OSError, ValueError, TimeoutError) as error:
            raise UsageError(f"no cluster at {address}: {error}") from None
        with client:
            _send_code(client)
            yield from _results(dask, client, tasks, arguments_of, limits, interrupted)

    return run


def _send_code(client: Any) -> None:
    """Every worker has the code of this installation, also one that comes later; UsageError where it does not run."""
    by_value: Any = importlib.import_module("cloudpickle")
    plugins: Any = importlib.import_module("distributed.diagnostics.plugin")
    by_value.register_pickle_by_value(ship)
    kind = type("Code", (ship.Code, plugins.WorkerPlugin), {"__module__": ship.__name__})
    try:
        client.register_plugin(kind(ship.packed()))
    except RuntimeError as error:
        raise UsageError(str(error)) from None


def _results(
    dask: Any,
    client: Any,
    tasks: Sequence[Task],
    arguments_of: Callable[[Task], list[str]],
    limits: Limits,
    interrupted: Callable[[], bool],
) -> Iterator[Outcome]:
    by_key = {task.key: task for task in tasks}
    futures = [
        client.submit(execute, task, luggage(task), arguments_of(task), limits, key=task.key, retries=RETRIES)
        for task in tasks
    ]
    for future in dask.as_completed(futures):
        if interrupted():
            client.cancel(futures)
            return
        task = by_key[future.key]
        if future.status == "finished":
            yield replace(future.result(), task=task)
        else:
            yield Outcome(task, Exit.STOPPED, None, "killed", str(future.exception()), 0.0)
        future.release()


def luggage(task: Task) -> dict[str, bytes]:
    """The files that a worker needs, by name: the folder of the part as far as it may be called, and the machine."""
    files = {task.part.path.name: task.part.path.read_bytes()} if task.part.path.is_file() else {}
    size = 0
    for file in sorted(task.part.path.parent.iterdir()) if task.part.path.parent.is_dir() else ():
        if file.name in files or not file.is_file() or file.stat().st_size >= BESIDE_BYTES:
            continue
        size += file.stat().st_size
        if size < LUGGAGE_BYTES:
            files[file.name] = file.read_bytes()
    if task.machine:
        files[".machine.toml"] = Path(task.machine).read_bytes()
    return files


def execute(task: Task, files: dict[str, bytes], arguments: list[str], limits: Limits) -> Outcome:
    """On a worker of the cluster: the task in a process of its own."""
    with tempfile.TemporaryDirectory(prefix="cnc-front-") as folder:
        for name, data in files.items():
            (Path(folder) / name).write_bytes(data)
        here = Path(folder) / task.part.path.name
        local = replace(task, part=Part(task.part.name, here, task.part.sha256, task.part.bytes))
        options = ["--machine", str(Path(folder) / ".machine.toml")] if task.machine else []
        rest = arguments[3:] if task.machine else arguments[1:]
        outcome = next(run_all([local], lambda _: [str(here), *options, *rest], 1, limits))
    if outcome.run is not None:  # places as on the machine of the user
        outcome.run["job"]["path"] = str(task.part.path)
        outcome.run["machine"]["path"] = arguments[2] if task.machine else None
    return outcome
