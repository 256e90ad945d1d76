"""The pages that fill the screen between header and message line: help, alarms, service, jobs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import wrap

from rich.style import Style
from textual.strip import Strip

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Job
from tui.keys import KEYS
from tui.look import Look
from tui.program import block_name
from tui.rows import Row
from tui.states import FACES
from tui.values import Shown, minutes
from tui.words import Words

#: Values that changed are marked for so long, s.
MARK_S = 2.0
#: Files listed in the jobs page.
_FILES = 200
_JOB_ENDINGS = {".nc", ".ngc", ".gcode", ".tap", ".mpf", ".spf", ".cnc", ".din", ".iso", ".txt", ".src"}


@dataclass(frozen=True, slots=True)
class Logged:
    """One line of the log of this session."""

    clock: str
    code: str
    text: str


def help_rows(look: Look, words: Words, width: int) -> list[Strip]:
    """All keys, then all states, from their tables."""
    rows = [Row(look.strong).add(f" {words('help_title')}"), Row(look.warn).add(f" {words('help_stop')}")]
    for key in KEYS:
        if key.shown:
            text = words.pick(key.english, key.german)
            rows.append(Row(look.text).add(f"  {key.shown}", look.strong).at(16, text))
    rows += [Row(look.text), Row(look.strong).add(f" {words('help_states')}")]
    for face in FACES.values():
        row = (
            Row(look.text)
            .add("  ")
            .add(f"{face.symbol} {words.pick(face.english, face.german)}", _face(look, face.style))
        )
        rows.append(row.at(18, words.pick(*face.leaves_by)))
    rows.append(Row(look.dim).add(f" {words('help_scroll')}"))
    return [row.strip(width) for row in rows]


def _face(look: Look, name: str) -> Style:
    style: Style = getattr(look, name)
    return style


def alarm_rows(shown: Shown, log: Sequence[Logged], width: int) -> list[Strip]:
    """What the controller reports as faults, then what happened, newest first."""
    look, words = shown.look, shown.words
    rows = [Row(look.strong).add(f" {words('alarms_title')}"), Row(look.dim).add(f"  {words('alarm_head')}")]
    lines = shown.job.lines if shown.job else ()
    for alarm in shown.snapshot.alarms:
        row = Row(look.bad).add(f"  {alarm.t_s:9.3f} s").at(14, alarm.code).at(20, alarm.axis)
        block = block_name(lines, alarm.line) if alarm.line else ""
        rows.append(row.at(26, block).at(35, ("!! " if alarm.stopped else "") + alarm.text))
    if not shown.snapshot.alarms:
        rows.append(Row(look.text).add(f"  {words('alarms_none')}"))
    rows += [Row(look.text), Row(look.strong).add(f" {words('log_title')}")]
    rows += [Row(look.text).add(f"  {entry.clock}  {entry.code:<6}{entry.text}") for entry in reversed(log)]
    return [row.strip(width) for row in rows]


@dataclass(slots=True)
class Changes:
    """Remembers when each value of the service page last changed."""

    _values: dict[str, str] = field(default_factory=dict)
    _at: dict[str, float] = field(default_factory=dict)

    def is_fresh(self, name: str, value: str, now: float) -> bool:
        """Whether a value changed within the last two seconds."""
        if name in self._values and self._values[name] != value:
            self._at[name] = now
        self._values[name] = value
        return now - self._at.get(name, -MARK_S) < MARK_S


def service_rows(shown: Shown, changes: Changes, now: float, width: int) -> list[Strip]:
    """Per axis what the controller reports; changed values are marked with `*`."""
    look, words = shown.look, shown.words
    rows = [Row(look.strong).add(f" {words('service_title')}"), Row(look.dim).add(f" {words('service_head')}")]
    for axis in shown.snapshot.axes:
        values = (
            (16, f"{axis.command:+.4f}"),
            (28, f"{axis.actual:+.4f}"),
            (37, f"{round(axis.following, 4) + 0.0:+.4f}"),
            (46, f"{axis.mpe:g}"),
            (54, f"{axis.spool_fill * 100:.0f} %"),
        )
        row = Row(shown.value).add(f" {axis.name} {axis.unit}", look.strong)
        for end, text in values:
            row.until(end, text)
        bits = " ".join(axis.bits)
        fresh = changes.is_fresh(axis.name, bits, now)
        rows.append(row.at(55, "*" if fresh else " ", look.warn).add(" " + bits, look.warn if fresh else shown.value))
        if not axis.referenced:
            rows.append(Row(look.warn).at(57, words("not_referenced")))
    return [row.strip(width) for row in rows]


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
