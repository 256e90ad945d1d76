"""Circular tests by ISO 230-4 from the full circles of a program: closed formulas over the radius by angle.

`Tracker.evidence()["circles"]` holds, per circle and class of the angle, extremes and mean of (radius - nominal radius)
about the programmed centre. All results in mm. Figures of ISO 230-4:2005:

- circular deviation G: least radial distance of two concentric circles about the actual path (minimum zone);
- bidirectional circular deviation G(b): the same about both paths of a circle, clockwise and counter-clockwise;
- radial deviation F: largest and smallest radius beyond the nominal path, about the programmed centre;
- mean bidirectional radial deviation D: radius of the least-squares circle of both paths beyond the nominal one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
#: A circle of which less was driven is not judged (share of the classes of its angle).
DRIVEN = 0.95
#: Centres and radii that close are one circle, mm.
SAME_MM = 1e-6
#: Most exchanges of the search for the minimum zone; a dozen do.
EXCHANGES = 200


@dataclass(frozen=True, slots=True)
class Contour:
    """One path round a circle: radius beyond the nominal one by angle (rad), extremes and means."""

    low_angle: Vector
    low: Vector
    high_angle: Vector
    high: Vector
    mean_angle: Vector
    mean: Vector

    @staticmethod
    def of(circle: dict[str, Any]) -> Contour:
        """From one circle of the evidence; classes without samples are left out."""
        driven = circle["samples"] > 0
        n = len(driven)
        middle = (np.arange(n) + 0.5) * (2 * math.pi / n)
        names = ("min_angle", "min_mm", "max_angle", "max_mm")
        low_angle, low, high_angle, high = (circle[name][driven] for name in names)
        return Contour(low_angle, low, high_angle, high, middle[driven], circle["mean_mm"][driven])


def zone(contours: Sequence[Contour]) -> tuple[float, tuple[float, float]]:
    """Least radial distance of two concentric circles about the paths, and their centre.

    Stiefel's exchange: four points that a circle misses by the same amount on alternating sides, of which one is
    replaced by the point missed most, until none is missed by more."""
    angle = np.concatenate([part for c in contours for part in (c.low_angle, c.high_angle)])
    radius = np.concatenate([part for c in contours for part in (c.low, c.high)])
    basis = np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
    reference = [int(np.argmin(np.abs(angle - k * math.pi / 2))) for k in range(4)]
    level, circle = _levelled(basis[reference], radius[reference])
    for _ in range(EXCHANGES):
        missed = radius - basis @ circle
        worst = int(np.argmax(np.abs(missed)))
        if abs(missed[worst]) <= level * (1 + 1e-12) + 1e-15:
            break
        candidates = [[*reference[:k], worst, *reference[k + 1 :]] for k in range(4)]
        levels = [_levelled(basis[points], radius[points]) for points in candidates]
        best = max(range(4), key=lambda k: levels[k][0])
        if levels[best][0] <= level:
            break
        reference, (level, circle) = candidates[best], levels[best]
    missed = radius - basis @ circle
    return float(missed.max() - missed.min()), (float(circle[1]), float(circle[2]))


def _levelled(basis: Vector, radius: Vector) -> tuple[float, Vector]:
    """The circle (radius, centre) that misses four points by the same amount on alternating sides, and the amount."""
    # weights that no circle can see: their signs say on which side each point is missed
    weights = np.array([(-1) ** k * np.linalg.det(np.delete(basis, k, axis=0)) for k in range(4)])
    total = float(np.abs(weights).sum())
    if total < 1e-12:
        return -1.0, np.zeros(3)
    level = float(weights @ radius) / total
    circle = np.linalg.lstsq(basis, radius - level * np.sign(weights), rcond=None)[0]
    return abs(level), circle


def least_squares(contours: Sequence[Contour]) -> tuple[float, tuple[float, float]]:
    """Radius beyond the nominal one and centre of the least-squares circle of the paths, by the class means."""
    angle = np.concatenate([c.mean_angle for c in contours])
    mean = np.concatenate([c.mean for c in contours])
    columns = np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
    radius, x, y = np.linalg.lstsq(columns, mean, rcond=None)[0]
    return float(radius), (float(x), float(y))


def circles(found: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """One entry per circle that was driven all round, in the order of the program. `pair` is the index of the entry of
    the same circle the other way round, with which `bidirectional_mm` and `mean_bidirectional_mm` are."""
    whole = [circle for circle in found if np.mean(circle["samples"] > 0) >= DRIVEN]
    contours = [Contour.of(circle) for circle in whole]
    entries = [_alone(circle, contour) for circle, contour in zip(whole, contours, strict=True)]
    for i, circle in enumerate(whole):
        if entries[i]["pair"] is not None:
            continue
        other = next(
            (k for k in range(i + 1, len(whole)) if entries[k]["pair"] is None and _paired(circle, whole[k])), None
        )
        if other is None:
            continue
        both = (contours[i], contours[other])
        figures = {"bidirectional_mm": zone(both)[0], "mean_bidirectional_mm": least_squares(both)[0]}
        entries[i] |= figures | {"pair": other}
        entries[other] |= figures | {"pair": i}
    return entries


def _alone(circle: dict[str, Any], contour: Contour) -> dict[str, Any]:
    width, centre = zone([contour])
    return {
        "blocks": circle["blocks"],
        "axes": circle["axes"],
        "radius_mm": circle["radius_mm"],
        "velocity_mm_s": circle["vl"],
        "direction": "ccw" if circle["ccw"] else "cw",
        "circular_mm": width,
        "radial_max_mm": float(contour.high.max()),
        "radial_min_mm": float(contour.low.min()),
        "centre_mm": centre,
        "pair": None,
        "bidirectional_mm": None,
        "mean_bidirectional_mm": None,
    }


def _paired(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """The same circle, the other way round."""
    off = math.dist(one["center"], other["center"])
    near = max(off, abs(one["radius_mm"] - other["radius_mm"])) <= SAME_MM
    return near and one["axes"] == other["axes"] and bool(one["ccw"]) != bool(other["ccw"])
