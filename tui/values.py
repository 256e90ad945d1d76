"""Positions, feed, progress, deviation and spooler as rows: wide (56 columns) and compact (80 columns)."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan

from rich.style import Style
from textual.strip import Strip

from cnc_front.engine import AxisValues, Job, Snapshot, State
from tui.look import Look
from tui.program import block_name
from tui.rows import Row
from tui.words import Words

#: Below this share the effective override is called low (ui-guide section 4).
LOW_OVERRIDE = 0.2
BAR = 8
WIDE = 56


@dataclass(frozen=True, slots=True)
class Shown:
    """All that the rows of one frame are made of."""

    snapshot: Snapshot
    job: Job | None
    look: Look
    words: Words
    #: seconds since the engine last reported, where that is too long ago; else 0
    stale_s: float = 0.0
    #: seconds between frames, smoothed
    pulse_s: float = 0.1

    @property
    def value(self) -> Style:
        """Values that are old are dimmed (and marked, so that it is not carried by colour alone)."""
        return self.look.dim if self.stale_s else self.look.text

    @property
    def doubt(self) -> str:
        """The mark of old values."""
        return "?" if self.stale_s else " "


def minutes(seconds: float | None) -> str:
    """m:ss or h:mm:ss; `?` while unknown."""
    if seconds is None:
        return "?"
    whole = int(seconds)
    hours, rest = divmod(whole, 3600)
    return f"{hours}:{rest // 60:02d}:{rest % 60:02d}" if hours else f"{rest // 60}:{rest % 60:02d}"


def progress(snapshot: Snapshot) -> float:
    """Share of the job that is done, by the path of the motion model."""
    if snapshot.state is State.DONE:
        return 1.0
    return min(snapshot.path_done_mm / snapshot.path_total_mm, 1.0) if snapshot.path_total_mm > 0 else 0.0


def _following(axis: AxisValues) -> str:
    return f"{axis.following * 1000:+.1f}" if abs(axis.following) >= 5e-5 else "0.0"


def _to_go(axis: AxisValues) -> str:
    return f"{axis.to_go:+.4f}" if abs(axis.to_go) >= 5e-5 else "0.0000"


def _axis_row(shown: Shown, axis: AxisValues, ends: tuple[int, int, int], bar: int) -> Row:
    """Name, actual, to go, following error and its bar against mpe, R for referenced."""
    look, share = shown.look, abs(axis.following) / axis.mpe if axis.mpe > 0 else 0.0
    style = look.good if share < 0.5 else look.warn if share < 1 else look.bad
    degrees = "" if axis.unit == "mm" else "°"
    row = Row(shown.value).add(f" {axis.name}", look.strong)
    row.until(ends[0], f"{axis.actual:+.4f}", look.dim if shown.stale_s else look.strong).add(degrees or shown.doubt)
    row.until(ends[1], _to_go(axis)).add(degrees)
    row.until(ends[2], _following(axis)).add(degrees and "m°")
    full, _ = look.gauge(share, BAR)
    row.at(bar, look.rule(vertical=True), look.dim).add(full, style).add(" " * (BAR - len(full)))
    row.add(look.rule(vertical=True) + " ", look.dim)
    return row.add("R" if axis.referenced else "-", look.text if axis.referenced else look.warn)


def _head(shown: Shown, ends: tuple[int, int, int], bar: int) -> Row:
    words, dim = shown.words, shown.look.dim
    row = Row(dim).until(ends[0] + 1, f"{words('actual')} mm").until(ends[1] + 1, f"{words('to_go')} mm")
    return row.until(bar - 2, words("follow")).at(bar, "0").until(bar + BAR + 2, words("limit"))


def _feed(shown: Shown) -> str:
    return f"{shown.snapshot.feed_actual:.0f} / {shown.snapshot.feed_programmed:.0f} mm/min"


def is_low(snapshot: Snapshot) -> bool:
    """It runs, but so slowly that it may seem to stand."""
    return snapshot.state is State.RUNNING and snapshot.override_effective < LOW_OVERRIDE


def _deviation_style(shown: Shown) -> Style:
    limit = shown.job.tolerance_mm if shown.job else 0.05
    worst = shown.snapshot.deviation_max_mm
    return shown.look.bad if worst > limit else shown.look.warn if worst > limit / 2 else shown.value


def wide_rows(shown: Shown) -> list[Strip]:
    """The left part at 120x40: one row more for each axis beyond three."""
    s, look, words = shown.snapshot, shown.look, shown.words
    ends, value = (16, 29, 40), shown.value
    rows = [_head(shown, ends, 44)]
    rows += [_axis_row(shown, axis, ends, 44) for axis in s.axes]
    rows.append(_pulse(shown))
    feed = Row(value).add(" F", look.dim).at(8, _feed(shown))
    feed.at(31, f"{words('override')} {words('set')} {s.override_set * 100:.0f} % ")
    feed.add(f"{words('effective')} {s.override_effective * 100:.0f} %", look.warn if is_low(s) else value)
    done = f"{s.path_done_mm:.1f} / {s.path_total_mm:.1f} mm"
    path = Row(value).add(f" {words('path')}", look.dim).at(8, done)
    path.at(31, f"{words('time')} {minutes(s.machine_time_s)} / {minutes(s.time_total_s)} (sim)")
    rows += [feed, path, _bar(shown, 46), _deviation(shown), _spooler(shown), _modes(shown)]
    return [row.strip(WIDE) for row in rows]


def _pulse(shown: Shown) -> Row:
    """How fresh the screen is."""
    words, row = shown.words, Row(shown.look.dim)
    if shown.stale_s:
        return row.until(WIDE - 1, words("stale", seconds=shown.stale_s), shown.look.warn)
    if shown.pulse_s > 0.3:
        return row.until(WIDE - 1, words("lag", seconds=shown.pulse_s), shown.look.warn)
    return row.until(WIDE - 1, words("live", hz=1 / max(shown.pulse_s, 0.01)))


def _bar(shown: Shown, width: int) -> Row:
    share, look = progress(shown.snapshot), shown.look
    full, rest = look.gauge(share, width)
    row = Row(shown.value).add(" [", look.dim).add(full, look.good).add(rest, look.todo).add("]", look.dim)
    return row.add(f" {int(share * 100)} %")


def _deviation(shown: Shown) -> Row:
    s, words = shown.snapshot, shown.words
    row = Row(shown.value).add(f" {words('deviation')}", shown.look.dim)
    row.at(8, f"{words('now')} {s.deviation_now_mm * 1000:.1f} um   ")
    worst = f"max {s.deviation_max_mm * 1000:.1f} um"
    if s.deviation_max_line and shown.job:
        worst += f" @{block_name(shown.job.lines, s.deviation_max_line)}"
    row.add(worst, _deviation_style(shown))
    limit = shown.job.tolerance_mm * 1000 if shown.job else 0
    return row.at(row.width + 3, f"{words('tolerance')} {limit:g} um") if limit else row


def _spooler(shown: Shown) -> Row:
    row = Row(shown.value).add(f" {shown.words('spool')}", shown.look.dim).add("  ")
    for axis in shown.snapshot.axes[:4]:
        row.add(f"{axis.name} {_known(axis.spool_fill * 100, 0)} %  ")
    return row.at(row.width + 1, f"{shown.words('empty_in')} {_known(shown.snapshot.spool_empty_s, 1)} s")


def _known(value: float, digits: int) -> str:
    """A number, or `-` for one that an older recording does not hold."""
    return "-" if isnan(value) else f"{value:.{digits}f}"


def _modes(shown: Shown) -> Row:
    s = shown.snapshot
    if not s.modal:
        return Row(shown.value)
    words = [s.modal, f"T{s.tool}", *(word for word in (s.spindle, s.coolant) if word)]
    gap = "   " if len("   ".join(words)) < WIDE - 1 else " "
    return Row(shown.value).add(" " + gap.join(words))


def compact_rows(shown: Shown, width: int) -> list[Strip]:
    """The top part at 80x24: values left, feed, override, deviation, spooler right, progress below."""
    s, look, words = shown.snapshot, shown.look, shown.words
    ends, value = (14, 26, 37), shown.value
    rows = [_head(shown, ends, 40), *(_axis_row(shown, axis, ends, 40) for axis in s.axes)]
    while len(rows) < 4:
        rows.append(Row(value))
    override = f"{words('set')} {s.override_set * 100:.0f} {words('effective')} {s.override_effective * 100:.0f} %"
    worst = f"{s.deviation_now_mm * 1000:.1f} max {s.deviation_max_mm * 1000:.1f} um"
    fill = max((axis.spool_fill for axis in s.axes), default=0.0)
    right = (
        ("F", _feed(shown), value),
        (words("override"), override, look.warn if is_low(s) else value),
        (words("deviation"), worst, _deviation_style(shown)),
        (words("spool"), f"{_known(fill * 100, 0)} %  {_known(s.spool_empty_s, 1)} s", value),
    )
    for row, (name, text, style) in zip(rows, right, strict=False):
        row.at(54, name, look.dim).at(60 if name == words("spool") else 59, text, style)
    clock = f"{minutes(s.machine_time_s)} / {minutes(s.time_total_s)} sim"
    rest = f"{clock}  {s.path_done_mm:.0f}/{s.path_total_mm:.0f} mm"
    bar = _bar(shown, max(8, min(36, 66 - len(rest))))
    bar.at(bar.width + 2, rest)
    return [row.strip(width) for row in (*rows, bar)]


def short_row(shown: Shown, width: int) -> Strip:
    """Positions and override in one row, above the picture that fills the screen."""
    s = shown.snapshot
    row = Row(shown.value)
    for axis in s.axes[:4]:
        row.add(f" {axis.name}", shown.look.dim).add(f" {axis.actual:+.3f}{shown.doubt}")
    override = f"{shown.words('override')} {s.override_set * 100:.0f}/{s.override_effective * 100:.0f} %"
    return row.until(width - 1, f"F {s.feed_actual:.0f}  {override}  {int(progress(s) * 100)} %").strip(width)
