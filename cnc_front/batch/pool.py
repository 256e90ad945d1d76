"""Worker processes of a batch. A worker that dies, hangs or eats memory costs the task it had, and is replaced."""

from __future__ import annotations

import json
import selectors
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import IO, Any

from cnc_front.batch.parts import Task
from cnc_front.errors import Exit

#: Why a task has no answer: its worker died twice, gave no answer in time, or got no more memory.
KILLED, HANGS, MEMORY = "killed", "hangs", "memory"


@dataclass(frozen=True, slots=True)
class Limits:
    """What one task may take: machine and wall time in s, memory in MiB (0: as much as there is)."""

    max_time_s: float = 86400.0
    max_memory_mib: int = 0
    #: a worker that does not answer its own time limit is killed after that much longer
    grace_s: float = 10.0


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a task. `run` is the object of `run --json`; None where there is none."""

    task: Task
    code: int
    run: dict[str, Any] | None
    #: "", or why there is no answer
    lost: str
    stderr: str
    wall_s: float


class Worker:
    """One worker process and the task it has."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._process: subprocess.Popen[str] | None = None
        self.task: Task | None = None
        self.begun = 0.0

    def give(self, task: Task, arguments: list[str]) -> None:
        """Starts a task; a process that is not there is started too."""
        if self._process is None or self._process.poll() is not None:
            command = [sys.executable, "-m", "cnc_front.batch.worker", str(self._limits.max_memory_mib)]
            pipe = subprocess.PIPE
            self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True)
        self.task, self.begun = task, time.monotonic()
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(arguments) + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # it died meanwhile: reading says so

    @property
    def answers(self) -> IO[str]:
        """Where its answer comes."""
        assert self._process is not None and self._process.stdout is not None
        return self._process.stdout

    def take(self) -> Outcome:
        """The answer, or what the death of the process means."""
        assert self.task is not None and self._process is not None
        line = self.answers.readline()
        if not line:
            code = self._process.wait()
            # the allocator of Rust aborts where Python would raise
            lost = MEMORY if self._limits.max_memory_mib and code == -6 else KILLED
            return self._lost(lost, f"the worker ended with {code}")
        answer = json.loads(line)
        wall = time.monotonic() - self.begun
        lost = MEMORY if answer.get("memory") else ""
        outcome = Outcome(self.task, answer["code"], answer["run"], lost, answer["stderr"], wall)
        self.task = None
        return outcome

    def overdue(self) -> bool:
        """The task takes longer than its own limit allows."""
        most = self._limits.max_time_s + self._limits.grace_s
        return self.task is not None and time.monotonic() - self.begun > most

    def kill(self) -> Outcome:
        """Ends a worker that hangs."""
        assert self._process is not None
        self._process.kill()
        self._process.wait()
        return self._lost(HANGS, "no answer within the time limit")

    def _lost(self, how: str, why: str) -> Outcome:
        assert self.task is not None
        outcome = Outcome(self.task, Exit.STOPPED, None, how, why, time.monotonic() - self.begun)
        self.task, self._process = None, None
        return outcome

    def close(self) -> None:
        """Ends the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()


def run_all(
    tasks: Iterable[Task],
    arguments_of: Callable[[Task], list[str]],
    jobs: int,
    limits: Limits,
    interrupted: Callable[[], bool] = lambda: False,
) -> Iterator[Outcome]:
    """Outcomes as they come, from `jobs` worker processes.

    A task whose worker died is tried once more: it may have been killed by somebody. One that kills its worker each
    time is lost.
    """
    waiting = deque(tasks)
    workers = [Worker(limits) for _ in range(max(1, min(jobs, len(waiting))))]
    again: set[str] = set()
    try:
        with selectors.DefaultSelector() as selector:
            for worker in workers:
                _next(worker, waiting, arguments_of, selector)
            while selector.get_map() and not interrupted():
                ready = {key.data for key, _ in selector.select(timeout=0.5)}
                for worker in workers:
                    if worker in ready or worker.overdue():
                        selector.unregister(worker.answers)
                        outcome = worker.take() if worker in ready else worker.kill()
                        if outcome.lost == KILLED and outcome.task.key not in again:
                            again.add(outcome.task.key)
                            waiting.appendleft(outcome.task)
                        else:
                            yield outcome
                        _next(worker, waiting, arguments_of, selector)
    finally:
        for worker in workers:
            worker.close()


def _next(
    worker: Worker, waiting: deque[Task], arguments_of: Callable[[Task], list[str]], selector: selectors.BaseSelector
) -> None:
    if waiting:
        task = waiting.popleft()
        worker.give(task, arguments_of(task))
        selector.register(worker.answers, selectors.EVENT_READ, worker)
