"""What a report is made of, and its reduction to plain lists that fit into one HTML file."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Vertices of the path picture and rows of the block table inside the HTML; everything is in blocks.csv.
PLOT_POINTS = 40_000
HTML_BLOCKS = 3_000
HTML_EVENTS = 1_000

#: Upper edges of the histogram of the deviation, um.
HISTOGRAM_UM = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, math.inf)


class Histogram:
    """Counts samples per class of deviation, chunk by chunk."""

    def __init__(self) -> None:
        self._edges = np.array(HISTOGRAM_UM[:-1], dtype=np.float32) / np.float32(1e3)
        self.counts = np.zeros(len(HISTOGRAM_UM), dtype=np.int64)

    def add(self, deviation_mm: NDArray[np.float32]) -> None:
        """Adds samples."""
        classes = np.searchsorted(self._edges, deviation_mm, side="left")
        self.counts += np.bincount(classes, minlength=len(HISTOGRAM_UM))


@dataclass(slots=True)
class ReportInput:
    """Everything a report shows. `run` is the object of design 3.2, the rest comes from toolpaths."""

    run: dict[str, Any]
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


def block_table(report: ReportInput) -> list[dict[str, Any]]:
    """One row per programmed block, in the order of execution."""
    blocks, measured = report.blocks, report.measured
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
    }
    names = list(columns)
    lists = [np.asarray(column).tolist() for column in columns.values()]
    rapid = blocks["rapid"].tolist()
    return [
        dict(zip(names, map(finite, row), strict=True)) | {"rapid": r, "text": source_line(report.job_lines, row[0])}
        for row, r in zip(zip(*lists, strict=True), rapid, strict=True)
    ]


def source_line(lines: list[str], number: float) -> str:
    """Text of a 1-based source line, shortened."""
    index = int(number) - 1
    return lines[index].strip()[:80] if 0 <= index < len(lines) else ""


def finite(value: Any) -> Any:
    """A number that JSON can hold: six significant digits, None for NaN and infinity."""
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value


def band(pair: tuple[NDArray[np.float32], NDArray[np.float32]], scale: float = 1.0) -> list[list[float | None]]:
    """Minimum and maximum curves as lists."""
    return [[finite(float(v)) for v in (side.astype(np.float64) * scale)] for side in pair]


def plot_data(report: ReportInput, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The data that the script of the HTML draws."""
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
            "um": [finite(float(v)) for v in report.plot_deviation_mm.astype(np.float64) * 1e3],
        },
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
        "histogram": {"upTo": [finite(v) for v in HISTOGRAM_UM], "counts": report.histogram.counts.tolist()},
        "blocks": sorted(worst, key=lambda row: row["line"]),
        "blockCount": len(rows),
        "events": report.events[:HTML_EVENTS],
        "eventCount": len(report.events),
    }
