"""What the report screen lets one choose: the named findings of a run with cause and remedy, then its worst blocks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from tui.look import Look
from tui.program import block_name
from tui.rows import Row
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome

#: Named findings shown (ui-guide section 2: the worst five).
HEAD = 5


@dataclass(frozen=True, slots=True)
class View:
    """How it is drawn."""

    look: Look
    words: Words
    width: int


def lines_of(outcome: Outcome) -> list[int]:
    """The source line of each thing that can be chosen, in the order of the rows."""
    named = [int(found["line"]) for found in (outcome.run.get("findings") or [])[:HEAD]]
    return [*named, *(finding.line for finding in outcome.worst)]


def place_of(outcome: Outcome, line: int) -> float | None:
    """Where on the path, as a share of its length, a source line deviates most; None if it is not on the path."""
    blocks, measured = outcome.report.blocks, outcome.report.measured
    found = np.flatnonzero(np.asarray(blocks["line"]) == line)
    total = float(outcome.run["path_length_mm"] or 0.0)
    if not len(found) or total <= 0:
        return None
    worst = np.nan_to_num(np.asarray(measured["actual_max_mm"])[found], nan=-1.0)
    block = int(found[int(worst.argmax())])
    return min((float(blocks["s0_mm"][block]) + float(blocks["length_mm"][block]) / 2) / total, 1.0)


def finding_rows(view: View, outcome: Outcome, cursor: int) -> Iterator[Row]:
    """Named findings with their remedies."""
    from cnc_front.evidence import finding_text, remedy_text  # the first screen does not need what judges

    look, words = view.look, view.words
    findings = outcome.run.get("findings") or []
    if not findings:
        return
    yield Row(look.dim).add(f"   {words('findings_head')}")
    for k, found in enumerate(findings[:HEAD]):
        over = found["max_mm"] > outcome.run["verdict"]["tolerance_mm"]
        block = block_name(outcome.report.job_lines, found["line"])
        texts = wrap(f"{block}: {finding_text(found, words.language)}", view.width - 5)
        for n, text in enumerate(texts):
            row = _marked(look, k == cursor and n == 0)
            yield row.add(text, look.bad if over else look.warn)
        for n, text in enumerate(wrap(remedy_text(found, words.language), view.width - 9)):
            yield Row(look.text).add(("   -> " if n == 0 else "      ") + text)
    if len(findings) > HEAD:
        yield Row(look.dim).add(f"   + {len(findings) - HEAD}")


def worst_rows(view: View, outcome: Outcome, cursor: int) -> Iterator[Row]:
    """The worst blocks; `cursor` counts from the first finding."""
    look, words = view.look, view.words
    limit = outcome.run["verdict"]["tolerance_mm"] * 1e3
    first = len((outcome.run.get("findings") or [])[:HEAD])
    yield Row(look.dim).add(f"   {words('worst_head')}")
    for k, finding in enumerate(outcome.worst):
        style = look.bad if finding.max_um > limit else look.text
        row = _marked(look, first + k == cursor)
        row.add(block_name(outcome.report.job_lines, finding.line), style).until(21, f"{finding.max_um:.1f}", style)
        row.until(30, f"{finding.rms_um:.1f}", style)
        row.until(39, f"{100 * finding.max_um / limit:.0f} %" if limit else "-", style)
        yield row.at(42, finding.text, style)


def _marked(look: Look, chosen: bool) -> Row:
    return Row(look.text).add(" > " if chosen else "   ", look.cursor if chosen else look.text)
