"""What limited the path velocity, as the report shows it: shares, per block, over time, along the path."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front.messages import limit_text
from cnc_front.verdict import limit_name


@dataclass(slots=True)
class LimitData:
    """From toolpaths: limits by their number, of the whole run, over time and along the plotted path.

    `totals` and `buckets` hold samples; `vertices` has the limit of the piece that ends at each vertex of the polyline,
    0 where it was not driven.
    """

    totals: list[tuple[int, int]] = field(default_factory=list)
    samples_per_bucket: int = 1
    buckets: list[dict[int, int]] = field(default_factory=list)
    vertices: NDArray[np.uint16] = field(default_factory=lambda: np.zeros(0, np.uint16))

    def codes(self) -> list[int]:
        """All limits of the run, longest first."""
        return [code for code, _ in sorted(self.totals, key=lambda row: (-row[1], row[0]))]


def limit_rows(limits: LimitData, axes: list[str], sample_time_s: float) -> list[dict[str, Any]]:
    """One row per limit, longest first: the samples sum to those of the run."""
    samples = dict(limits.totals)
    total = sum(samples.values()) or 1
    return [
        {"limit": limit_name(code, axes), "samples": samples[code], "seconds": samples[code] * sample_time_s}
        | {"share_pct": 100 * samples[code] / total}
        for code in limits.codes()
    ]


def block_columns(measured: dict[str, NDArray[Any]], axes: list[str]) -> dict[str, list[Any]]:
    """Per block what limited it most, and the share of its samples; empty where no sample fell into it."""
    names = {int(code): limit_name(int(code), axes) for code in np.unique(measured["limit"]) if code}
    limit = [names.get(code, "") for code in measured["limit"].tolist()]
    return {"limit": limit, "limit_pct": (100 * measured["limit_share"]).tolist()}


def limit_plot(limits: LimitData, axes: list[str], sample_time_s: float) -> dict[str, Any]:
    """What the script of the page draws: samples per limit and bucket of time, limit per vertex (-1: none)."""
    codes = limits.codes()
    place = {code: k for k, code in enumerate(codes)}
    counts = np.zeros((len(codes), len(limits.buckets)), dtype=np.int64)
    for at, bucket in enumerate(limits.buckets):
        for code, samples in bucket.items():
            counts[place[code], at] = samples
    return {
        "names": [limit_name(code, axes) for code in codes],
        "step": limits.samples_per_bucket * sample_time_s,
        "counts": counts.tolist(),
        "vertices": [place.get(code, -1) for code in limits.vertices.tolist()],
    }


def limit_words(limits: LimitData, axes: list[str], language: str) -> dict[str, str]:
    """Words for the names of all limits of a run."""
    names = (limit_name(code, axes) for code in limits.codes())
    return {name: limit_text(name, language) for name in names}
