"""The trade-off of time and deviation as SVG: one point a run, the curve of those that none beats in both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import Any

WIDTH, HEIGHT = 1160, 460
LEFT, RIGHT, TOP, BOTTOM = 80, 20, 20, 44


def scatter(rows: Sequence[dict[str, Any]], tolerance_mm: float, words: dict[str, str]) -> str:
    """SVG text; empty without two runs. The deviation has a logarithmic axis."""
    points = [row for row in rows if row["deviation_max_mm"] and row["machine_time_s"]]
    if len(points) < 2:
        return ""
    times = [row["machine_time_s"] for row in points]
    logs = [math.log10(row["deviation_max_mm"] * 1e3) for row in points]
    limit = math.log10(tolerance_mm * 1e3)
    x = _scale(min(times), max(times), LEFT, WIDTH - RIGHT)
    y = _scale(min([*logs, limit]), max([*logs, limit]), HEIGHT - BOTTOM, TOP)
    parts = [f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(words["curve"])}">']
    parts += [_line(LEFT, y(limit), WIDTH - RIGHT, y(limit), "limit")]
    parts += [_text(LEFT + 6, y(limit) - 5, f"{words['limit']} {tolerance_mm * 1e3:g} µm", "start")]
    for power in range(math.floor(min([*logs, limit])), math.ceil(max([*logs, limit])) + 1):
        for step in (1, 2, 5):
            value = power + math.log10(step)
            if min([*logs, limit]) <= value <= max([*logs, limit]):
                parts += [_line(LEFT, y(value), WIDTH - RIGHT, y(value), "grid")]
                parts += [_text(LEFT - 8, y(value) + 4, f"{step * 10**power:g}", "end")]
    # so many that neighbouring labels differ
    digits = max(0, 1 - math.floor(math.log10(max(max(times) - min(times), 1e-6) / 5)))
    for k in range(6):
        value = min(times) + (max(times) - min(times)) * k / 5
        parts.append(_text(x(value), HEIGHT - BOTTOM + 18, f"{value:.{digits}f}", "middle"))
    parts.append(_text(WIDTH - RIGHT, HEIGHT - 6, words["time_axis"], "end"))
    parts.append(_text(4, 12, words["deviation_axis"], "start"))
    curve = sorted(
        (row["machine_time_s"], math.log10(row["deviation_max_mm"] * 1e3)) for row in points if row["pareto"]
    )
    if len(curve) > 1:
        path = " ".join(f"{x(t):.1f},{y(d):.1f}" for t, d in curve)
        parts.append(f'<polyline class="curve" points="{path}"/>')
    for row, time, value in zip(points, times, logs, strict=True):
        kind = "now" if row["values"] is None else "good" if row["within"] else "bad"
        named = words["present"] if row["values"] is None else ", ".join(f"{k} {v:g}" for k, v in row["values"].items())
        title = f"{named}: {time:.3f} s, {row['deviation_max_mm'] * 1e3:.2f} µm"
        radius = 6 if row["pareto"] or row["values"] is None else 4
        parts.append(
            f'<circle class="{kind}" cx="{x(time):.1f}" cy="{y(value):.1f}" r="{radius}">'
            f"<title>{escape(title)}</title></circle>"
        )
    return "".join([*parts, "</svg>"])


def _scale(low: float, high: float, first: float, last: float) -> Any:
    room = max(high - low, 1e-9)
    low, room = low - 0.04 * room, 1.08 * room
    return lambda value: first + (last - first) * (value - low) / room


def _line(x0: float, y0: float, x1: float, y1: float, kind: str) -> str:
    return f'<line class="{kind}" x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"/>'


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'
