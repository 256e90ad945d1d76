"""Jobs: files to open, and what the load check found."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

from textual.strip import Strip

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Job
from tui.look import Look
from tui.pages.base import Page
from tui.rows import Row
from tui.values import Shown, minutes
from tui.widgets import PathField
from tui.words import Words

if TYPE_CHECKING:
    from tui.app import Terminal

#: Files listed.
_FILES = 200
_JOB_ENDINGS = {".nc", ".ngc", ".gcode", ".tap", ".mpf", ".spf", ".cnc", ".din", ".iso", ".txt", ".src"}


class JobsPage(Page):
    """A path to type, the files that begin with it, the check of what was opened last."""

    name = "jobs"

    def __init__(self, app: Terminal) -> None:
        super().__init__(app)
        self.field = PathField(app.words("jobs_title"), id="path")
        self.check = Check()
        self._files: list[str] = []
        self._file = 0

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """As many files as there is room for, then the check."""
        return jobs_rows(shown, self._files, self._file, self.check, width, height)

    def enter(self) -> None:
        """Lists anew."""
        super().enter()
        if self.field is not None:
            self.typed(self.field.value)

    def scroll(self, by: int) -> None:
        """Another file."""
        self._file = max(0, min(self._file + by, len(self._files) - 1))

    def typed(self, text: str) -> None:
        """Lists what begins with what was typed."""
        self._files, self._file = files_beginning(text), 0

    def key_complete(self) -> None:
        """Takes the chosen file into the text field."""
        if self._files and self.field is not None:
            self.field.value = self._files[self._file]
            self.field.cursor_position = len(self.field.value)

    def submitted(self, text: str) -> None:
        """Opens the chosen file, or exactly what was typed; a folder is entered."""
        path = self._files[self._file] if self._files else text.strip()
        if path.endswith("/"):
            self.key_complete()
        elif path:
            self.app.load(path)


@dataclass(slots=True)
class Check:
    """Result of the last load: a job, or why it was refused."""

    name: str = ""
    job: Job | None = None
    findings: tuple[Diagnostic, ...] = ()


def files_beginning(text: str) -> list[str]:
    """Folders and part programs whose path begins with what was typed; folders first. Never raises."""
    typed = Path(text).expanduser() if text else Path()
    folder, stem = (typed, "") if text.endswith("/") or not text else (typed.parent, typed.name)
    try:
        entries = sorted(entry for entry in folder.iterdir() if entry.name.startswith(stem) and _is_shown(entry, stem))
        folders = [entry for entry in entries if entry.is_dir()]
        files = [entry for entry in entries if entry.is_file() and entry.suffix.lower() in _JOB_ENDINGS]
    except (OSError, ValueError):
        return []
    return [*(f"{entry}/" for entry in folders), *(str(entry) for entry in files)][:_FILES]


def _is_shown(entry: Path, stem: str) -> bool:
    return stem.startswith(".") or not entry.name.startswith(".")


def jobs_rows(shown: Shown, files: Sequence[str], cursor: int, check: Check, width: int, height: int) -> list[Strip]:
    """Files that fit what was typed, then what the load check found. The text field stands above."""
    look, words = shown.look, shown.words
    room = max(3, min(len(files), height // 3))
    top = max(0, min(cursor - room // 2, len(files) - room))
    rows: list[Row] = []
    for index in range(top, min(top + room, len(files))):
        rows.append(
            Row(look.cursor if index == cursor else look.text).add("> " if index == cursor else "  ").add(files[index])
        )
    if not files:
        rows.append(Row(look.dim).add(f"  {words('jobs_none')}"))
    rows += [Row(look.dim).add(f" {words('jobs_keys')}"), Row(look.text)]
    if check.job is not None:
        rows += _passed(shown, check.job)
    elif check.findings:
        rows += _refused(look, words, check, width)
    return [row.strip(width) for row in rows]


def _passed(shown: Shown, job: Job) -> Iterable[Row]:
    look, words, s = shown.look, shown.words, shown.snapshot
    yield Row(look.strong).add(f" {words('check', name=job.name)}: {words('check_clean', n=len(job.warnings))}")
    time = minutes(s.time_total_s)
    yield Row(look.text).add(f"  {words('check_time', time=time, path=s.path_total_mm, lines=len(job.lines))}")
    yield Row(look.dim).add(f"  {words('check_extents')}")
    for name, (low, high) in job.extents.items():
        yield Row(look.text).add(f"  {name}").until(18, f"{low:+.3f}").until(32, f"{high:+.3f}")
    for warning in job.warnings:
        yield Row(look.warn).add(f"  {warning}")


def _refused(look: Look, words: Words, check: Check, width: int) -> Iterable[Row]:
    errors = [finding for finding in check.findings if not finding.is_warning]
    yield Row(look.bad).add(f" {words('check', name=check.name)}: {words('check_bad', n=len(errors))}")
    source = _source_lines(check.findings)
    for finding in check.findings:
        place = f"{finding.line}:{finding.column}: {finding.id} "
        texts = wrap(place + finding.message, width - 6) or [place]
        yield Row(look.text).add(f"  {texts[0]}", look.bad)
        yield from (Row(look.text).add(f"      {text}") for text in texts[1:])
        if finding.line in source:
            yield Row(look.dim).add(f"      {source[finding.line]}")
            yield Row(look.bad).add(" " * (5 + finding.column)).add("^")
        for text in wrap(f"{words('hint')} {finding.hint}", width - 10) if finding.hint else ():
            yield Row(look.dim).add(f"      {text}")


def _source_lines(findings: Sequence[Diagnostic]) -> Mapping[int, str]:
    """The text of lines with a finding, so far as it can be shown in a row."""
    wanted = {finding.line for finding in findings if finding.column < 70}
    lines: dict[int, str] = {}
    if not wanted:
        return lines
    try:
        with Path(findings[0].file).open("rb") as file:
            for number, data in enumerate(file, 1):
                if number in wanted:
                    lines[number] = data[:70].decode("utf-8", "replace").rstrip("\r\n")
                if number > max(wanted):
                    break
    except OSError:
        return {}
    return lines
