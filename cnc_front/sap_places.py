"""Lines of rw_SymPas jobs: one number for every line of all texts of all tasks.

A task's text counts from 1, its includes stand behind it, and the tasks behind each other. The controller counts so too
(Mcu.number_lines), so that spooled commands, samples, alarms and reports name a line by one number.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from cnc_front._native import sympas as native_sympas
from cnc_front.jobs import JobSource, shown


class Numbered(Protocol):
    """A task with its program."""

    @property
    def number(self) -> int: ...
    @property
    def source(self) -> JobSource: ...
    @property
    def program(self) -> native_sympas.Program: ...


@dataclass(frozen=True, slots=True)
class Text:
    """One text: what is added to its lines, its task, and its path if it is an include."""

    first: int
    task: int
    include: str | None


@dataclass(frozen=True, slots=True)
class Places:
    """All texts of a job, rising."""

    texts: tuple[Text, ...]

    @staticmethod
    def of(tasks: Sequence[Numbered]) -> Places:
        """Those of the tasks, in their order."""
        texts, first = [], 0
        for task in tasks:
            for n, (path, offset) in enumerate(task.program.files):
                texts.append(Text(first + offset, task.number, shown(path) if n else None))
            first += _length(task)
        return Places(tuple(texts))

    def first(self, task: int) -> int:
        """What is added to the lines of a task's own text."""
        return next(text.first for text in self.texts if text.task == task)

    def at(self, line: int) -> dict[str, Any]:
        """`task`, `file` (of an include; None: the text of the task itself) and `line` in it; of line 0 no more than
        that it is unknown."""
        text = next((t for t in reversed(self.texts) if t.first < line), None)
        if text is None:
            return {"task": self.texts[0].task, "file": None, "line": 0}
        return {"task": text.task, "file": text.include, "line": line - text.first}

    def labelled(self, joined: str) -> list[str]:
        """The lines of `joined`; those that are not of the first text say where they stand."""
        labels = {text.first: _label(text) for text in self.texts[1:]}
        rows, first, label = [], 0, ""
        for n, row in enumerate(joined.splitlines()):
            if n in labels:
                first, label = n, labels[n]
            rows.append(f"[{label}:{n + 1 - first}] {row.strip()}" if label else row)
        return rows

    def as_json(self) -> str:
        """For the metadata of a recording."""
        return json.dumps([[text.first, text.task, text.include] for text in self.texts])

    @staticmethod
    def parse(text: str) -> Places:
        """From the metadata of a recording."""
        return Places(tuple(Text(first, task, include) for first, task, include in json.loads(text)))


def joined(tasks: Sequence[Numbered]) -> JobSource:
    """All texts behind each other, as Places counts their lines; of autocode files, and includes that are gone, empty
    lines."""
    first = tasks[0].source
    if len(tasks) == 1 and len(tasks[0].program.files) == 1 and first.language == "sympas":
        return first
    rows: list[str] = []
    for task in tasks:
        files, end = task.program.files, _length(task)
        ends = [offset for _, offset in files[1:]] + [end]
        for n, ((path, offset), behind) in enumerate(zip(files, ends, strict=True)):
            text = _own(task) if n == 0 else _include(task, path)
            lines = text.splitlines()[: behind - offset]
            rows += lines + [""] * (behind - offset - len(lines))
    return JobSource(first.path, "\n".join(rows).encode(), first.language)


def _label(text: Text) -> str:
    return f"{text.task}:{Path(text.include).name}" if text.include else str(text.task)


def _length(task: Numbered) -> int:
    """Lines that a task takes; all of its text where that has no includes."""
    own = len(_own(task).splitlines()) if len(task.program.files) == 1 else 0
    return max(1, own, task.program.places)


def _own(task: Numbered) -> str:
    return task.source.text() if task.source.language == "sympas" else ""


def _include(task: Numbered, path: str) -> str:
    if task.source.language != "sympas":
        return ""  # an autocode file may come from anywhere: what it names is not read
    try:
        return JobSource(path, Path(path).read_bytes(), "sympas").text()
    except OSError:
        return ""
