"""Jobs: files to open, recent jobs, the queue, and what the load check found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from rich.style import Style
from textual.strip import Strip

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Job
from cnc_front.german import localized
from tui.job_queue import JobQueue, Queued
from tui.pages.base import Page
from tui.rows import Row
from tui.values import Shown, minutes
from tui.widgets import PathField

if TYPE_CHECKING:
    from tui.app import Terminal

#: Findings listed.
MOST_FINDINGS = 200
#: Files listed.
_FILES = 200
_JOB_ENDINGS = {".nc", ".ngc", ".gcode", ".tap", ".mpf", ".spf", ".cnc", ".din", ".iso", ".txt", ".src", ".mcap"}


#: What is listed above the check: files that begin with what was typed, jobs of the history, the queue.
LISTS = ("files", "recent", "queue")


class JobsPage(Page):
    """A path to type, the files that begin with it, recent jobs, the queue, the check of what was opened last."""

    name = "jobs"

    def __init__(self, app: Terminal) -> None:
        super().__init__(app)
        self.field = PathField(app.words("jobs_title"), id="path")
        self.check = Check()
        self.queue = JobQueue(app.engine, app.words, app.say)
        self.list = LISTS[0]
        self._typed = ""
        self._files: list[str] = []
        self._cursor = 0

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """The list, then the check."""
        view = View(shown, self.app.keeper.archive.jobs, width)
        rows = self._list_rows(view)
        count, room = len(rows), max(4, min(len(rows), height // 3))
        top = max(0, min(self._cursor - room // 2, count - room))
        head = [list_head(view, self.list, self.queue), *rows[top : top + room], *keys_rows(view, self.list)]
        if self.list == "queue" and self._cursor < count:
            head += refused_rows(view, self.queue.entries[self._cursor : self._cursor + 1])
        head.append(Row(shown.look.text))
        return [row.strip(width) for row in [*head, *check_rows(view, self.check)]]

    def _list_rows(self, view: View) -> list[Row]:
        if self.list == "queue":
            return queue_rows(view, self.queue.entries, self._cursor)
        if self.list == "recent":
            return recent_rows(view, self._paths(), self._cursor)
        return file_rows(view, self._files, self._cursor)

    def _paths(self) -> list[str]:
        """The paths of the present list."""
        if self.list == "queue":
            return [entry.path for entry in self.queue.entries]
        if self.list == "recent":
            return [row["job"] for row in self.app.keeper.archive.jobs if self._typed.lower() in row["job"].lower()]
        return self._files

    @property
    def _chosen(self) -> str:
        """The path under the cursor; empty where there is none."""
        paths = self._paths()
        return paths[self._cursor] if self._cursor < len(paths) else ""

    def enter(self) -> None:
        """Lists anew."""
        super().enter()
        if self.field is not None:
            self.typed(self.field.value)

    def scroll(self, by: int) -> None:
        """Another file; page keys scroll the check."""
        if abs(by) == 1:
            self._cursor = max(0, min(self._cursor + by, len(self._paths()) - 1))
        else:
            super().scroll(by)

    def typed(self, text: str) -> None:
        """Lists what begins with what was typed; recent jobs are those that contain it."""
        self._typed, self._cursor = text, 0
        self._files = files_beginning(text)

    def key_complete(self) -> None:
        """Takes the chosen file into the text field."""
        if self._chosen and self.field is not None and self.list != "queue":
            self.field.value = self._chosen
            self.field.cursor_position = len(self.field.value)

    def key_list(self) -> None:
        """The next list."""
        self.list, self._cursor, self.top = LISTS[(LISTS.index(self.list) + 1) % len(LISTS)], 0, 0

    def key_queue(self) -> None:
        """Into the queue, or out of it."""
        path = self._chosen
        if self.list == "queue":
            self.queue.remove(self._cursor)
            self.scroll(-1)
        elif path.lower().endswith(".mcap"):
            self.app.say(self.app.words("queue_recording"))
        elif path and not path.endswith("/"):
            self.queue.add(path)
            self.app.say(self.app.words("queued", name=Path(path).name, n=len(self.queue.entries)))

    def key_earlier(self) -> None:
        """Moves the chosen job of the queue up."""
        self._move(-1)

    def key_later(self) -> None:
        """Moves it down."""
        self._move(1)

    def _move(self, by: int) -> None:
        if self.list == "queue":
            self._cursor = self.queue.move(self._cursor, by)
        else:
            self.app.say(self.app.words("queue_move"))

    def key_run_queue(self) -> None:
        """Starts the queue, or makes the present job its last one."""
        if self.queue.is_active:
            self.queue.stop()
        elif self.app.waited_s <= self.app.operation.late_s:
            self.queue.start()
        else:
            self.app.say(self.app.words("dropped"))

    def key_stop_at_failure(self) -> None:
        """Whether a job that fails ends the queue."""
        self.queue.stops_at_failure = not self.queue.stops_at_failure

    def submitted(self, text: str) -> None:
        """Opens the chosen file, or exactly what was typed; a folder is entered."""
        path = self._chosen or text.strip()
        if path.endswith("/"):
            self.key_complete()
        elif path:
            self.app.load(path)


@dataclass(frozen=True, slots=True)
class View:
    """How it is drawn. `jobs`: the newest run of each job of the history."""

    shown: Shown
    jobs: Sequence[dict[str, Any]]
    width: int

    def mark(self, chosen: bool) -> Row:
        """A row that begins with the cursor."""
        look = self.shown.look
        return Row(look.cursor if chosen else look.text).add("> " if chosen else "  ")


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


def list_head(view: View, name: str, queue: JobQueue) -> Row:
    """Which list is shown, and what the queue does."""
    look, words = view.shown.look, view.shown.words
    row = Row(look.dim).add(" ")
    for each in LISTS:
        title = words(f"list_{each}") + (f" {len(queue.entries)}" if each == "queue" else "")
        row.add(f"[{title}]" if each == name else f" {title} ", look.strong if each == name else look.dim)
    if queue.is_active:
        row.add(f"  {words('queue_runs')}", look.inverse)
    elif queue.why:
        row.add(f"  {words('queue_stood')}: {queue.why}", look.bad)
    if queue.stops_at_failure:
        row.add(f"  {words('queue_stop_at')}", look.warn)
    return row


def keys_rows(view: View, name: str) -> list[Row]:
    """The keys of the list, in as many rows as they need."""
    look, words = view.shown.look, view.shown.words
    texts = wrap(words("queue_keys" if name == "queue" else "jobs_keys"), view.width - 2)
    return [Row(look.dim).add(f" {text}") for text in texts]


def file_rows(view: View, files: Sequence[str], cursor: int) -> list[Row]:
    """Path, kind, size, last verdict and date of each file."""
    look, words = view.shown.look, view.shown.words
    if not files:
        return [Row(look.dim).add(f"  {words('jobs_none')}")]
    known = {row["job"]: row for row in view.jobs}
    rows = []
    for index, path in enumerate(files):
        row = view.mark(index == cursor).add(path)
        if not path.endswith("/"):
            last = known.get(str(Path(path).absolute()))
            date = f"{local_time(last['at'])} {last['verdict']}" if last else ""
            row.until(view.width - 1, f" {_kind(path)} {_size(path):>8} {date:>22}")
        rows.append(row)
    return rows


def _kind(path: str) -> str:
    kinds = {".src": "SymPas   ", ".mcap": "MCAP     "}
    return kinds.get(Path(path).suffix.lower(), "DIN 66025")


def _size(path: str) -> str:
    try:
        size = Path(path).stat().st_size
    except OSError:
        return "?"
    return f"{size} B" if size < 10_000 else f"{size / 1000:.0f} kB" if size < 10_000_000 else f"{size / 1e6:.0f} MB"


def local_time(stored: str) -> str:
    """Local time of an entry of the history."""
    return datetime.fromisoformat(stored).astimezone().strftime("%Y-%m-%d %H:%M")


def recent_rows(view: View, paths: Sequence[str], cursor: int) -> list[Row]:
    """Jobs of the history, newest first, with their last verdict."""
    known = {row["job"]: row for row in view.jobs}
    rows = []
    for index, path in enumerate(paths):
        last = known[path]
        row = view.mark(index == cursor).add(f"{local_time(last['at'])}  {last['verdict']:<6}")
        most = last["deviation_max_mm"]
        row.until(36, "-" if most is None else f"{most * 1e3:.1f} um")
        room = view.width - 39  # of a long path the end says more than the beginning
        row.at(38, path if len(path) <= room else f"~{path[1 - room :]}")
        rows.append(row)
    return rows or [Row(view.shown.look.dim).add(f"  {view.shown.words('recent_none')}")]


def queue_rows(view: View, entries: Sequence[Queued], cursor: int) -> list[Row]:
    """Each job with its state or verdict."""
    look, words = view.shown.look, view.shown.words
    rows = []
    for index, entry in enumerate(entries):
        row = view.mark(index == cursor).add(f"{entry.name[:30]:<31}")
        style = {"PASS": look.good, "WARN": look.warn, "": look.text}.get(entry.verdict, look.bad)
        rows.append(row.add(f"{entry.verdict or words(f'queue_{entry.state}'):<9}", style).add(f" {entry.detail}"))
    return rows or [Row(look.dim).add(f"  {words('queue_empty')}")]


def refused_rows(view: View, chosen: Sequence[Queued]) -> Iterator[Row]:
    """Why the chosen entry was refused, whole, and what to do."""
    for entry in chosen:
        if entry.verdict == "ERROR":
            first = next((d for d in entry.findings if not d.is_warning), None)
            hint = f" {view.shown.words('hint')} {first.hint}" if first and first.hint else ""
            for text in wrap(f"{entry.name}:{'' if first else ' '}{entry.detail}{hint}", view.width - 4):
                yield Row(view.shown.look.bad).add(f"  {text}")


def check_rows(view: View, check: Check) -> Iterator[Row]:
    """What the load check found."""
    if check.job is not None:
        yield from _passed(view, check.job)
    elif check.findings:
        yield from _refused(view, check)


def _passed(view: View, job: Job) -> Iterator[Row]:
    look, words, s, check = view.shown.look, view.shown.words, view.shown.snapshot, job.check
    yield Row(look.strong).add(f" {words('check', name=job.name)}: {words('check_clean', n=len(job.warnings))}")
    time = minutes(s.time_total_s)
    yield Row(look.text).add(f"  {words('check_time', time=time, path=s.path_total_mm, lines=len(job.lines))}")
    if check is None:
        return
    yield Row(look.dim).add(f"  {words('check_extents')}")
    for axis in check.axes:
        row = Row(look.text if axis.fits else look.bad).add(f"  {axis.name} {axis.unit}")
        row.until(20, f"{axis.low:+.3f}").until(34, f"{axis.high:+.3f}")
        if axis.limits is not None:
            row.at(38, f"{axis.limits[0]:+.3f} .. {axis.limits[1]:+.3f}")
        yield row.at(64, words("within") if axis.fits else words("beyond"))
    tools = " ".join(f"T{tool}" for tool in check.tools) or "-"
    feeds = f"F {check.feeds[0]:g} .. {check.feeds[1]:g} mm/min" if check.feeds else ""
    yield Row(look.text).add(f"  {words('tools')} {tools}   {feeds}   {check.modal}")
    lines = {n: job.lines[n - 1][:70] for n in {d.line for d in check.findings} if 0 < n <= len(job.lines)}
    yield from _findings(view, localized(check.findings, words.language), lines, look.warn)
    if check.more_findings:
        yield Row(look.warn).add(f"  + {check.more_findings}")


def _refused(view: View, check: Check) -> Iterator[Row]:
    look, words = view.shown.look, view.shown.words
    errors = [finding for finding in check.findings if not finding.is_warning]
    yield Row(look.bad).add(f" {words('check', name=check.name)}: {words('check_bad', n=len(errors))}")
    yield from _findings(view, check.findings, _source_lines(check.findings), look.bad)


def _findings(view: View, findings: Sequence[Diagnostic], source: Mapping[int, str], style: Style) -> Iterator[Row]:
    """Block and column, what is wrong, the source line with a caret, what to do."""
    look, words = view.shown.look, view.shown.words
    for finding in findings[:MOST_FINDINGS]:
        place = f"{finding.line}:{finding.column}: {finding.id} "
        texts = wrap(place + finding.message, view.width - 6) or [place]
        yield Row(look.text).add(f"  {texts[0]}", style)
        yield from (Row(look.text).add(f"      {text}") for text in texts[1:])
        if finding.line in source:
            yield Row(look.dim).add(f"      {source[finding.line]}")
            yield Row(style).add(" " * (5 + finding.column)).add("^")
        for text in wrap(f"{words('hint')} {finding.hint}", view.width - 10) if finding.hint else ():
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
