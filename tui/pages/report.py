"""Report: verdict, worst blocks, plots in text of the run that ended last; export, and compare with an earlier one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from textual.strip import Strip

from cnc_front.messages import text as message
from tui.charts import columns, histogram, pointer
from tui.export import default_folder, export, how_to_open
from tui.findings import View, finding_rows, lines_of, place_of, worst_rows
from tui.pages.base import Page
from tui.program import block_name
from tui.rows import Row
from tui.values import Shown, minutes
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome
    from tui.app import Terminal

#: Rows of a chart; of one that stands for one axis.
CHART, SMALL = 5, 3


class ReportPage(Page):
    """The run that ended last."""

    name = "report"

    def __init__(self, app: Terminal) -> None:
        super().__init__(app)
        self.cursor = 0
        self._exported: tuple[int, str] = (0, "")  # number of the run, and where its report is
        self._compared = -1  # index of the earlier run; -1: none
        self._rows: tuple[object, list[Strip]] = (None, [])

    def enter(self) -> None:
        """Compares with nothing yet."""
        super().enter()
        self._compared = -1
        if (outcome := self.app.engine.outcome()) is not None:
            self.app.keeper.archive.look_up(str(Path(outcome.path).absolute()))

    @property
    def earlier(self) -> Sequence[dict[str, Any]]:
        """Earlier runs of the same job; the one shown was kept as the newest of them."""
        return self.app.keeper.archive.runs[1:]

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """All of it; it scrolls. Made anew only if something changed."""
        outcome = self.app.engine.outcome()
        before = self.earlier[self._compared] if 0 <= self._compared < len(self.earlier) else None
        exported = self._exported[1] if outcome and outcome.number == self._exported[0] else ""
        key = (outcome and outcome.number, shown.job, self.cursor, before and before["id"], width, exported)
        if self._rows[0] != key:
            view = View(shown.look, shown.words, width)
            self._rows = (key, report_rows(view, outcome, self.cursor, before, exported))
        return self._rows[1]

    def scroll(self, by: int) -> None:
        """Chooses a finding or block; beyond the last one, and by page keys, the page scrolls."""
        outcome = self.app.engine.outcome()
        last = len(lines_of(outcome)) - 1 if outcome else -1
        if abs(by) == 1 and 0 <= self.cursor + by <= last and (by > 0 or self.top == 0):
            self.cursor += by
        else:
            super().scroll(by)

    def confirm(self) -> None:
        """The run page shows the chosen block."""
        outcome = self.app.engine.outcome()
        lines = lines_of(outcome) if outcome is not None else []
        if self.cursor < len(lines):
            self.app.action_show("run")
            self.app.program.choose(lines[self.cursor])

    def key_compare(self) -> None:
        """The earlier run before this one, then the one before that, then none."""
        self._compared = self._compared + 1 if self._compared + 1 < len(self.earlier) else -1
        if not self.earlier:
            self.app.say(self.app.words("compare_none"))

    def key_replay(self) -> None:
        """Shows the newest recording, of the job that ran if there is one."""
        outcome = self.app.engine.outcome()
        job = str(Path(outcome.path).absolute()) if outcome is not None else None

        def found(path: str) -> None:
            if path:
                self.app.call_later(self.app.load, path)
            else:
                self.app.call_later(self._no_recording)

        self.app.keeper.archive.find_recording(job, found)

    def _no_recording(self) -> None:
        self.app.say(self.app.words("replay_found_none"))

    def key_export(self) -> None:
        """Asks for a folder."""
        outcome = self.app.engine.outcome()
        if outcome is None:
            self.app.say(self.app.words("report_none"))
            return
        words = self.app.words
        title = words("export_ask", folder=default_folder(outcome))
        self.app.ask(title, words("field_keys"), lambda typed: self._export(outcome, typed.strip()))

    def _export(self, outcome: Outcome, folder: str) -> None:
        words = self.app.words

        def write() -> None:
            told, page = export(outcome, folder, words)
            if page is not None:
                self._exported = (outcome.number, how_to_open(page, words))
                self.top = 0
            self.app.call_from_thread(self.app.say, told)

        self.app.say(words("exporting", folder=folder or default_folder(outcome)))
        self.app.run_worker(write, thread=True, group="export")


def report_rows(
    view: View, outcome: Outcome | None, cursor: int, before: dict[str, Any] | None, exported: str = ""
) -> list[Strip]:
    """Verdict and figures, findings, worst blocks, comparison, plots. `exported`: where the report was written to."""
    look, words = view.look, view.words
    if outcome is None:
        texts = (words("report_title"), words("report_none"))
        return [Row(look.text).add(f" {text}").strip(view.width) for text in texts]
    rows = list(_head(view, outcome))
    rows += [Row(look.strong).add(f" {text}") for text in wrap(exported, view.width - 3)]
    rows += [*finding_rows(view, outcome, cursor), *worst_rows(view, outcome, cursor)]
    if before is not None:
        rows += _comparison(view, outcome, before)
    lines = lines_of(outcome)
    rows += _plots(view, outcome, lines[cursor] if cursor < len(lines) else 0)
    return [row.strip(view.width) for row in rows]


def _head(view: View, outcome: Outcome) -> Iterator[Row]:
    look, words, run = view.look, view.words, outcome.run
    verdict = run["verdict"]
    style = {"PASS": look.good, "WARN": look.warn}.get(verdict["word"], look.bad)
    mark = {"PASS": "v", "WARN": "!"}.get(verdict["word"], "x")
    row = Row(look.strong).add(f" {words('report_title')}  ").add(Path(outcome.path).name).add("  ")
    row.add(f"{mark} {verdict['word']}", style).add(f"  {words('tolerance')} {verdict['tolerance_mm'] * 1e3:g} um")
    yield row.until(view.width - 1, words("report_keys" if view.width >= 100 else "report_keys_short"), look.dim)
    for reason in verdict["reasons"][:4]:
        values = {key: value for key, value in reason.items() if key != "id"}
        for text in wrap(message(reason["id"], words.language, **values), view.width - 4):
            yield Row(style).add(f"   {text}")
    for text in wrap("   ".join(_figures(view, run)), view.width - 4):
        yield Row(look.text).add(f"   {text}")


def _figures(view: View, run: dict[str, Any]) -> Iterator[str]:
    words, actual = view.words, run["deviation"]["actual"]
    for name, key in (("max", "max_mm"), ("99 %", "p99_mm"), ("RMS", "rms_mm")):
        yield f"{name} {actual[key] * 1e3:.1f} um" if actual[key] is not None else f"{name} -"
    yield f"{words('time')} {minutes(run['machine_time_s'])}"
    yield f"{run['path_length_mm']:.1f} mm"
    if run["feed"]["programmed_reached_pct"] is not None:
        yield f"{words('feed_reached')} {run['feed']['programmed_reached_pct']:.0f} %"


def _comparison(view: View, outcome: Outcome, before: dict[str, Any]) -> Iterator[Row]:
    """Figures now, before, and the difference; blocks that are new among the worst, and those that went."""
    look, words, run, old = view.look, view.words, outcome.run, before["run"]
    when = datetime.fromisoformat(before["at"]).astimezone()
    head = words("compare_head", number=before["id"], date=f"{when:%Y-%m-%d %H:%M}", verdict=before["verdict"])
    yield Row(look.strong).add(f" {head}")
    yield Row(look.dim).add(f"   {words('compare_columns')}")
    for name, new_value, old_value, unit in _pairs(words, run, old):
        row = Row(look.text).add(f"   {name}").until(33, _number(new_value, unit)).until(48, _number(old_value, unit))
        if new_value is not None and old_value is not None:
            change = new_value - old_value
            worse = change > 1e-9 and unit == "um"
            row.until(63, f"{change:+.2f} {unit}", look.warn if worse else look.text)
        yield row
    yield from _changed(view, old, run)
    lines = {f["line"] for f in old.get("worst", ())}
    if lines:
        new = [f.line for f in outcome.worst if f.line not in lines]
        gone = sorted(lines - {f.line for f in outcome.worst})
        listing = outcome.report.job_lines
        for id, found in (("compare_new", new), ("compare_gone", gone)):
            yield Row(look.text).add(f"   {words(id)}: {', '.join(block_name(listing, n) for n in found) or '-'}")


def _changed(view: View, old: dict[str, Any], run: dict[str, Any]) -> Iterator[Row]:
    """Findings, alarms and reasons of the verdict that are new, and those that are cured."""
    from cnc_front.compare import changed_findings

    look, words = view.look, view.words
    new, cured = changed_findings(old, run, words.language)
    for id, style, told in (("compare_findings_new", look.bad, new), ("compare_findings_cured", look.good, cured)):
        for text in told:
            lines = wrap(f"{words(id)}: {text}", view.width - 6)
            yield from (Row(style).add(("   " if n == 0 else "      ") + line) for n, line in enumerate(lines))
    if not new and not cured:
        yield Row(look.text).add(f"   {words('compare_findings_same')}")


def _number(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value:.2f} {unit}"


def _pairs(
    words: Words, new: dict[str, Any], old: dict[str, Any]
) -> Iterator[tuple[str, float | None, float | None, str]]:
    def um(run: dict[str, Any], key: str) -> float | None:
        value = ((run.get("deviation") or {}).get("actual") or {}).get(key)
        return None if value is None else value * 1e3

    for name, key in (("max", "max_mm"), ("99 %", "p99_mm"), ("RMS", "rms_mm")):
        yield f"{words('deviation')} {name}", um(new, key), um(old, key), "um"
    yield words("time"), new["machine_time_s"], old.get("machine_time_s"), "s"
    yield words("alarms_count"), float(len(new["alarms"])), float(len(old.get("alarms") or ())), ""


def _plots(view: View, outcome: Outcome, line: int) -> Iterator[Row]:
    """Charts; `line`: the source line that is chosen, to be pointed at."""
    from cnc_front.report.data import HISTOGRAM_UM

    look, words, report = view.look, view.words, outcome.report
    limit = outcome.run["verdict"]["tolerance_mm"] * 1e3
    length, time = report.series["over_length"], report.series["over_time"]
    deviation = np.asarray(length["actual_mm"][1], dtype=np.float64) * 1e3
    yield Row(look.strong).add(f" {words('plot_deviation')}")
    # beside a deviation of some um, a limit far above would press it flat
    near = limit if np.nanmax(deviation, initial=0.0) > limit / 5 else None
    ends = ("0 mm", f"{len(deviation) * length['bucket_mm']:.0f} mm")
    place = place_of(outcome, line)
    mark = None if place is None else (place, block_name(report.job_lines, line))
    yield from columns(look, deviation, view.width - 1, CHART, limit=near, ends=ends)
    if mark is not None:
        yield pointer(look, view.width - 1, mark)
    yield from _following(view, outcome)
    yield Row(look.strong).add(f" {words('plot_velocity')}")
    speed = np.asarray(time["speed"][1], dtype=np.float64) * 60
    seconds = len(speed) * time["samples_per_bucket"] * report.sample_time_s
    yield from columns(look, speed, view.width - 1, CHART, ends=("0 s", f"{seconds:.1f} s"))
    yield Row(look.strong).add(f" {words('plot_histogram')}")
    labels = [f"<= {edge:g}" if math.isfinite(edge) else f"> {HISTOGRAM_UM[-2]:g}" for edge in HISTOGRAM_UM]
    over = int(np.searchsorted(HISTOGRAM_UM, limit)) + 1
    yield from histogram(look, labels, report.histogram.counts.tolist(), view.width, over)


def _following(view: View, outcome: Outcome) -> Iterator[Row]:
    """Following error of each axis that has one, against mpe where that is near."""
    look, words, report = view.look, view.words, outcome.report
    time = report.series["over_time"]
    rows = zip(report.axes, report.units, report.mpe, time["following"], strict=True)
    for axis, unit, mpe, (low, high) in rows:
        most = np.maximum(np.abs(np.asarray(low, np.float64)), np.abs(np.asarray(high, np.float64))) * 1e3
        if not np.nanmax(most, initial=0.0) > 0:
            continue
        title = words("plot_following", axis=axis, unit="um" if unit == "mm" else "m°")
        yield Row(look.strong).add(f" {title}").add(f"   mpe {mpe * 1e3:g}", look.dim)
        near = mpe * 1e3 if np.nanmax(most) > mpe * 200 else None
        seconds = len(most) * time["samples_per_bucket"] * report.sample_time_s
        yield from columns(look, most, view.width - 1, SMALL, limit=near, ends=("0 s", f"{seconds:.1f} s"))
