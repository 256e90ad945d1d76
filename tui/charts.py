"""Charts as rows of characters: columns over an axis, bars of a histogram. Reduced by maximum, so no peak is lost."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rich.style import Style

from tui.look import Look
from tui.rows import Row

#: Cells of the axis on the left.
LEFT = 9
_PARTS = " ▁▂▃▄▅▆▇█"


def reduced(values: NDArray[np.float64], columns: int) -> NDArray[np.float64]:
    """The largest of each of `columns` equal parts; NaN where a part has none. Fewer values are repeated."""
    if len(values) == 0:
        return np.full(columns, np.nan)
    edges = np.linspace(0, len(values), columns + 1)
    first = np.minimum(edges[:-1].astype(int), len(values) - 1)
    behind = np.maximum(np.ceil(edges[1:]).astype(int), first + 1)
    with np.errstate(all="ignore"):
        known = np.where(np.isnan(values), -np.inf, values)
        found = np.array([known[a:b].max() for a, b in zip(first, behind, strict=True)])
    return np.where(np.isinf(found), np.nan, found)


def columns(
    look: Look,
    values: NDArray[np.float64],
    width: int,
    height: int,
    *,
    limit: float | None = None,
    ends: tuple[str, str] = ("", ""),
) -> list[Row]:
    """A chart of `height` rows and a line below it with what stands at both ends. Above `limit` it is marked."""
    places = reduced(values, max(width - LEFT - 1, 1))
    shown = places[~np.isnan(places)]
    top = float(max(shown.max(initial=0.0), (limit or 0.0) * 1.05)) or 1.0
    line = None if limit is None else min(height, math.ceil(limit / top * height)) - 1
    rows = []
    for level in range(height - 1, -1, -1):
        label = _brief(top) if level == height - 1 else _brief(limit) if level == line and limit is not None else ""
        row = Row(look.text).until(LEFT - 1, label, look.dim).at(LEFT, look.rule(vertical=True), look.dim)
        for value in places.tolist():
            row.add(*_cell(look, value, level, top, height, limit, level == line))
        rows.append(row)
    rows.append(Row(look.dim).at(LEFT + 1, ends[0]).until(width, ends[1]))
    return rows


def pointer(look: Look, width: int, mark: tuple[float, str]) -> Row:
    """A line below a chart of that width that points at a place (a share of its axis) and names it."""
    share, name = mark
    column = LEFT + 1 + min(int(share * (width - LEFT - 1)), width - LEFT - 2)
    row = Row(look.dim)
    if column + 2 + len(name) <= width:
        return row.at(column, "^", look.strong).add(f" {name}", look.strong)
    return row.until(column + 1, f"{name} ^", look.strong)


def _brief(value: float) -> str:
    """Three digits, without an exponent."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def _cell(
    look: Look, value: float, level: int, top: float, height: int, limit: float | None, is_limit: bool
) -> tuple[str, Style]:
    """One cell: how much of it the column fills."""
    share = 0.0 if np.isnan(value) else min(max(value / top * height - level, 0.0), 1.0)
    style = look.bad if limit is not None and value > limit else look.good
    if look.is_plain:
        text = "#" if share >= 0.5 else "." if share > 0 and level == 0 else " "
    else:
        text = _PARTS[round(share * 8)] if share > 0 else " "
    if text == " ":
        return ("-", look.dim) if is_limit else (" ", look.text)
    return text, style


def histogram(look: Look, labels: Sequence[str], counts: Sequence[int], width: int, over: int) -> list[Row]:
    """One bar a class that has any, with its share; classes from index `over` on are above the limit."""
    total = sum(counts) or 1
    used = [k for k, count in enumerate(counts) if count]
    rows = []
    for k in range(used[0], used[-1] + 1) if used else ():
        share = counts[k] / total
        style = look.bad if k >= over else look.good
        row = Row(look.text).until(LEFT + 3, labels[k]).until(LEFT + 12, f"{share * 100:.2f} %").add(" ")
        full, _ = look.gauge(share, width - row.width - 1)
        rows.append(row.add(full or ("." if counts[k] else ""), style))
    return rows
