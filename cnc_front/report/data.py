"""What a report is made of, and its reduction to plain lists that fit into one HTML file."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cnc_front.report.limits import LimitData, block_columns, limit_plot

if TYPE_CHECKING:
    from cnc_front.time_optimal import TimeOptimal

#: Vertices of the path picture and rows of the block table inside the HTML; everything is in blocks.csv.
#: The vertices are for 3 axes, fewer with more, so that the page stays under 20 MiB.
PLOT_POINTS = 250_000
HTML_BLOCKS = 3_000
HTML_EVENTS = 1_000
#: Worst blocks listed at the top.
FINDINGS = 5

#: Upper edges of the histogram of the deviation, um.
HISTOGRAM_UM = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, math.inf)


class Histogram:
    """Counts samples per class of deviation, and those above the limit, chunk by chunk."""

    def __init__(self, limit_mm: float) -> None:
        self._limit_mm = limit_mm
        self.over_limit = 0
        self._edges = np.array(HISTOGRAM_UM[:-1], dtype=np.float32) / np.float32(1e3)
        self.counts = np.zeros(len(HISTOGRAM_UM), dtype=np.int64)

    def add(self, deviation_mm: NDArray[np.float32]) -> None:
        """Adds samples."""
        self.over_limit += int(np.count_nonzero(deviation_mm > self._limit_mm))
        classes = np.searchsorted(self._edges, deviation_mm, side="left")
        self.counts += np.bincount(classes, minlength=len(HISTOGRAM_UM))


@dataclass(slots=True)
class ReportInput:
    """Everything a report shows. `run` is the object of design 3.2, the rest comes from toolpaths.

    `plot_deviation_mm` and `plot_signed_mm` (+ left, NaN where nothing is left or right) belong to the vertices of
    `polyline`; `blocks` and `measured` have one row per programmed block; `summary` is that of Tracker.finish.
    """

    run: dict[str, Any]
    summary: dict[str, Any]
    job_lines: list[str]
    axes: list[str]
    units: list[str]
    mpe: list[float]
    sample_time_s: float
    polyline: dict[str, NDArray[Any]]
    plot_deviation_mm: NDArray[np.float32]
    plot_signed_mm: NDArray[np.float32]
    blocks: dict[str, NDArray[Any]]
    measured: dict[str, NDArray[Any]]
    series: dict[str, Any]
    histogram: Histogram
    events: list[dict[str, Any]] = field(default_factory=list)
    note: str = ""
    #: polar curves of the circles of `run["circularity"]`
    circles: list[dict[str, Any]] = field(default_factory=list)
    limits: LimitData = field(default_factory=LimitData)
    time_optimal: TimeOptimal | None = None
    #: cnc_front.geometry.checks.Checks: drawing and setup, if there were any
    checks: Any = None


def block_table(report: ReportInput) -> list[dict[str, Any]]:
    """One row per programmed block, in the order of execution."""
    blocks, measured = report.blocks, report.measured
    limit_um = report.run["verdict"]["tolerance_mm"] * 1e3
    moving = measured["moving_s"]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(moving > 0, blocks["length_mm"] / moving, np.nan)
    columns: dict[str, Any] = {
        "line": blocks["line"],
        "length_mm": blocks["length_mm"],
        "time_s": measured["time_s"],
        "programmed_mm_min": blocks["vl"] * 60,
        "mean_mm_min": mean * 60,
        "max_mm_min": measured["speed_max"] * 60,
        "max_um": measured["actual_max_mm"] * 1e3,
        "rms_um": measured["actual_rms_mm"] * 1e3,
        "setpoint_max_um": measured["setpoint_max_mm"] * 1e3,
        "left_um": measured["signed_max_mm"] * 1e3,
        "right_um": -measured["signed_min_mm"] * 1e3,
    } | block_columns(measured, report.axes)
    names = list(columns)
    lists = [column if isinstance(column, list) else np.asarray(column).tolist() for column in columns.values()]
    rapid = blocks["rapid"].tolist()
    rows = []
    for values, is_rapid in zip(zip(*lists, strict=True), rapid, strict=True):
        row = dict(zip(names, map(finite, values), strict=True))
        row["verdict"] = verdict_of(row["max_um"], limit_um)
        rows.append(row | {"rapid": is_rapid, "text": source_line(report.job_lines, values[0])})
    return rows


def verdict_of(max_um: float | None, limit_um: float) -> str:
    """Of one block; empty where it was not driven."""
    return "" if max_um is None else "pass" if max_um <= limit_um else "fail"


def worst_vertices(report: ReportInput) -> NDArray[np.int64]:
    """Per block the vertex of the polyline at the end of the piece with the largest deviation."""
    s_mm = report.polyline["s_mm"]
    if len(s_mm) == 0:
        return np.zeros(len(report.blocks["line"]), dtype=np.int64)
    deviation = np.nan_to_num(report.plot_deviation_mm, nan=-1.0)
    begin = report.blocks["s0_mm"]
    first = np.minimum(np.searchsorted(s_mm, begin, side="right"), len(s_mm) - 1)
    behind = np.searchsorted(s_mm, begin + report.blocks["length_mm"] * (1 + 1e-9), side="right")
    pieces = zip(first.tolist(), np.maximum(behind, first + 1).tolist(), strict=True)
    return np.array([a + int(deviation[a:b].argmax()) for a, b in pieces], dtype=np.int64)


def gaps(report: ReportInput) -> NDArray[np.bool_]:
    """True at the vertices before which blocks were left out of the polyline (of a very long program): between
    them and the vertex before lies no piece of the path, so nothing may be drawn there."""
    s_mm, begin = report.polyline["s_mm"], report.blocks["s0_mm"]
    if len(s_mm) < 2:
        return np.zeros(len(s_mm), dtype=np.bool_)
    inset = np.diff(s_mm) * 1e-3
    first = np.searchsorted(begin, s_mm[:-1] + inset, side="right")
    last = np.searchsorted(begin, s_mm[1:] - inset, side="right")
    return np.concatenate([[False], first != last])


def findings(report: ReportInput, rows: list[dict[str, Any]], vertices: NDArray[np.int64]) -> list[dict[str, Any]]:
    """The blocks with the largest deviation, worst first, with the place of it (to a vertex of the plotted path)."""
    order = sorted(range(len(rows)), key=lambda k: -(rows[k]["max_um"] or 0.0))[:FINDINGS]
    limit_um = report.run["verdict"]["tolerance_mm"] * 1e3
    found = []
    for k in (k for k in order if rows[k]["max_um"]):
        row, vertex = rows[k], int(vertices[k])
        position = map(finite, report.polyline["points"][vertex].tolist())
        found.append(
            {key: row[key] for key in ("line", "text", "max_um", "rms_um", "verdict")}
            | {"of_limit_pct": finite(100 * row["max_um"] / limit_um) if limit_um > 0 else 0.0}
            | {"vertex": vertex, "position": dict(zip(report.axes, position, strict=True))}
        )
    return found


#: Figures of toolpaths that design 3.2 does not name.
TIMES = ("feed_s", "rapid_s", "standstill_s", "lag_max_mm")
FIGURES = ("max_mm", "p997_mm", "p99_mm", "p95_mm", "rms_mm", "mean_mm", "left_mm", "right_mm")


def statistics(report: ReportInput) -> dict[str, Any]:
    """Percentiles, sides, times and the share of samples above the limit; what is unknown is None."""
    total = int(report.histogram.counts.sum())
    sides = {key: {f: known(report.summary[key][f]) for f in FIGURES} for key in ("actual", "setpoint")}
    share = 100 * report.histogram.over_limit / total if total else 0.0
    return sides | {key: known(report.summary[key]) for key in TIMES} | {"over_limit_pct": share}


def known(value: float | None) -> float | None:
    """The number, None for NaN and infinity, which JSON lacks."""
    return value if value is not None and math.isfinite(value) else None


def source_line(lines: list[str], number: float) -> str:
    """Text of a 1-based source line, shortened."""
    index = int(number) - 1
    return lines[index].strip()[:80] if 0 <= index < len(lines) else ""


def finite(value: Any) -> Any:
    """A number that JSON can hold: six significant digits, None for NaN and infinity."""
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value


def brief(value: float) -> float | None:
    """For drawing: three significant digits."""
    return float(f"{value:.3g}") if math.isfinite(value) else None


def band(pair: tuple[NDArray[np.float32], NDArray[np.float32]], scale: float = 1.0) -> list[list[float | None]]:
    """Minimum and maximum curves as lists."""
    return [[finite(float(v)) for v in (side.astype(np.float64) * scale)] for side in pair]


def feed_max(rows: list[dict[str, Any]], factors: NDArray[np.float32]) -> float:
    """Highest programmed feed times override, mm/min; 0 without any feed block."""
    factor = float(np.nanmax(factors, initial=1.0)) if len(factors) else 1.0
    return max((row["programmed_mm_min"] or 0.0 for row in rows if not row["rapid"]), default=0.0) * factor


def plot_data(report: ReportInput, rows: list[dict[str, Any]], vertices: NDArray[np.int64]) -> dict[str, Any]:
    """The data that the script of the HTML draws."""
    rows = [row | {"vertex": vertex} for row, vertex in zip(rows, vertices.tolist(), strict=True)]
    line, length, time = report.polyline, report.series["over_length"], report.series["over_time"]
    # 0 / 1 per vertex instead of booleans: a third of the bytes
    worst = sorted(rows, key=lambda row: -(row["max_um"] or 0.0))[:HTML_BLOCKS]
    return {
        "axes": report.axes,
        "units": report.units,
        "mpe": report.mpe,
        "toleranceUm": report.run["verdict"]["tolerance_mm"] * 1e3,
        "path": {
            "points": np.round(line["points"], 4).T.tolist(),
            "lines": line["lines"].tolist(),
            "rapid": line["rapid"].astype(int).tolist(),
            "gap": gaps(report).astype(int).tolist(),
            "sMm": np.round(line["s_mm"], 3).tolist(),
            "um": [finite(float(v)) for v in report.plot_deviation_mm.astype(np.float64) * 1e3],
            "signedUm": [brief(float(v)) for v in report.plot_signed_mm.astype(np.float64) * 1e3],
        },
        "extents": np.column_stack([line["points"].min(0), line["points"].max(0)]).tolist()
        if len(line["points"])
        else [],
        "feedMax": feed_max(rows, time["factor"][1]),
        "alarms": report.run["alarms"],
        "length": {
            "step": length["bucket_mm"],
            "actualUm": band(length["actual_mm"], 1e3),
            "setpointUm": band(length["setpoint_mm"], 1e3),
        },
        "time": {
            "step": time["samples_per_bucket"] * report.sample_time_s,
            "speed": band(time["speed"], 60.0),
            "programmed": band(time["programmed"], 60.0),
            "factor": band(time["factor"], 100.0),
            "following": [band(pair) for pair in time["following"]],
        },
        "limits": limit_plot(report.limits, report.axes, report.sample_time_s),
        "histogram": {"upTo": [finite(v) for v in HISTOGRAM_UM], "counts": report.histogram.counts.tolist()},
        "blocks": sorted(worst, key=lambda row: row["line"]),
        "blockCount": len(rows),
        "events": report.events[:HTML_EVENTS],
        "eventCount": len(report.events),
    }
