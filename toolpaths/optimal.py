"""The least time that motion commands could take: between the speeds they had, at no more than the programmed velocity,
with every axis within its limits (design D27).

A line has a closed form. For arcs and helices there is one for weaker limits (the corner of the box that the
accelerations of the axes span), which needs less time than any motion can; where that leaves most open, toppra computes
the motion itself. Each figure is a lower bound: what a command took is never less.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: toppra costs about 4 ms an arc with this grid, which makes its time too long by up to 0.3 %.
GRID = 100
GRID_ERROR = 0.005
#: So many arcs at most, those first where the closed form leaves most open.
MOST_ARCS = 1000


@dataclass(frozen=True, slots=True)
class AxisLimits:
    """Per axis, in axis units: velocity and acceleration; `over` is how much an S-shaped ramp exceeds its mean."""

    velocity: Floats
    acceleration: Floats
    over: float = 1.0


@dataclass(slots=True)
class LeastTimes:
    """Per motion command, in seconds: what it took between its first and its last sample, and the least possible."""

    taken: Floats
    least: Floats
    #: arcs and helices, and how many of them toppra computed
    arcs: int = 0
    by_toppra: int = 0


def trapezoid(length: Floats, v0: Floats, v1: Floats, v_max: Floats, acc: Floats) -> Floats:
    """Least time along a line between two speeds; as much acceleration as these speeds need at least."""
    with np.errstate(divide="ignore", invalid="ignore"):
        acc = np.maximum(acc, np.abs(v1 * v1 - v0 * v0) / (2 * length))
        top = np.maximum(np.maximum(v_max, v0), v1)
        peak = np.minimum(np.sqrt(np.maximum(acc * length + (v0 * v0 + v1 * v1) / 2, 0.0)), top)
        ramps = (2 * peak * peak - v0 * v0 - v1 * v1) / (2 * acc)
        time = (2 * peak - v0 - v1) / acc + np.maximum(length - ramps, 0.0) / peak
    return np.where(length > 0, time, 0.0)


class Commands:
    """Motion commands of a run with what is needed for their bounds; columns of the sequence and of the tracker."""

    def __init__(
        self,
        sequence: dict[str, NDArray[Any]],
        passages: dict[str, NDArray[Any]],
        limits: AxisLimits,
        sample_time_s: float,
    ) -> None:
        n = min(len(sequence["kind"]), len(passages["samples"]))
        self.sequence, self.limits = sequence, limits
        self.p = {name: column[:n] for name, column in passages.items()}
        radius = sequence["effradius"][sequence["effradius_of"][:n]]
        #: mm per axis unit; 0 for an axis that is no part of the path
        self.scale = np.where(np.isnan(radius), 1.0, np.radians(radius))
        self.taken = (self.p["last"] - self.p["first"]).astype(np.float64) * sample_time_s
        self.way = np.nan_to_num((self.p["end"] - self.p["begin"]) * self.scale)
        self.turns = sequence["kind"][:n] == 1
        factor = np.maximum(self.p["factor_max"], 1.0)
        self.v0, self.v1 = self.p["v"][:, 0], self.p["v"][:, 1]
        #: F, times an override above 1
        self.v_max = sequence["vl"][:n] * factor
        #: what the plan may have used along the path
        self.planned = np.maximum(sequence["ac"][:n] * limits.over * factor**2, self.p["a_max"])
        # an override steps at the begin of a sample: so far the set point may be ahead of a motion without steps
        self.lead = (factor - np.minimum(self.p["factor_min"], factor)) * self.p["v_max"] * sample_time_s / 2
        self.length = np.where(self.turns, np.diff(self.p["s_mm"])[:, 0], np.linalg.norm(self.way, axis=1))
        self.sample_time_s = sample_time_s

    def along(self, most: Floats, slope: Floats) -> Floats:
        """The path velocity (or acceleration) at which the first axis reaches its limit."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(slope > 1e-12, most * self.scale / slope, np.inf).min(axis=1))

    def reached(self, v_max: Floats) -> Floats:
        """A limit of the path velocity that the run kept; F where it did not."""
        return np.asarray(np.where(self.p["v_max"] > v_max * (1 + 1e-9), self.v_max, np.minimum(v_max, self.v_max)))

    def lines(self) -> Floats:
        """Least times as if all were lines."""
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.abs(self.way) / self.length[:, np.newaxis]
        v_max = self.reached(self.along(self.limits.velocity, slope))
        acc = np.maximum(self.along(self.limits.acceleration, slope), self.planned)
        return trapezoid(np.maximum(self.length - self.lead, 0.0), self.v0, self.v1, v_max, acc)

    def arc(self, i: int) -> Arc:
        """Command `i`, which is an arc or a helix."""
        s, c = self.sequence, [int(self.sequence["c1"][i]), int(self.sequence["c2"][i])]
        start = s["target"][i - 1] if i else s["start"]
        radius = float(np.hypot(*((start[c] - s["center"][i]) * self.scale[i, c])))
        out = (self.p["begin"][i, c] - s["center"][i]) * self.scale[i, c]
        along = (s["target"][i] - start) * self.scale[i]
        along[c] = 0.0
        phi = float(np.radians(s["phi"][i]))
        length = float(np.hypot(radius * phi, np.linalg.norm(along)))
        flat, deep = radius * abs(phi) / length, np.abs(along) / length
        # between two samples a little more than at them
        v = self.p["v_max"][i] + self.planned[i] * self.sample_time_s
        most = self.limits.acceleration * self.scale[i]
        plane = np.maximum(most[c], np.hypot(self.planned[i] * flat, (v * flat) ** 2 / radius))
        with np.errstate(divide="ignore"):
            others = np.where(deep > 1e-12, np.maximum(most, self.planned[i] * deep) / deep, np.inf)
        others[c] = np.inf
        return Arc(radius, float(np.arctan2(out[1], out[0])), phi / length, flat, plane, float(others.min()), i)

    def relaxed(self, arc: Arc) -> float:
        """Least time of an arc as if it were a line within the limits that no motion along it can exceed."""
        v_max, acc = arc.relaxed()
        i, length = arc.command, self.length[arc.command] - self.lead[arc.command]
        values = (max(length, 0.0), self.v0[i], self.v1[i], min(v_max, self.v_max[i]), acc)
        return float(trapezoid(*(np.array(value) for value in values)))


@dataclass(frozen=True, slots=True)
class Arc:
    """An arc or a helix: angle at its first sample, radians per mm, share of the path in the plane of the circle, and
    the accelerations that the two axes of the plane, and the path for the sake of the other axes, may have."""

    radius: float
    angle: float
    bend: float
    flat: float
    plane: Floats
    path_acc: float
    command: int

    def relaxed(self) -> tuple[float, float]:
        """Path velocity and acceleration that no motion within the limits can exceed."""
        corner = float(np.hypot(*self.plane))
        return float(np.sqrt(corner * self.radius)) / self.flat, min(corner / self.flat, self.path_acc)


def least_times(
    sequence: dict[str, NDArray[Any]],
    passages: dict[str, NDArray[Any]],
    limits: AxisLimits,
    sample_time_s: float,
    most_arcs: int = MOST_ARCS,
) -> LeastTimes:
    """The bound of every motion command of a run, from the columns of its program and of Tracker.passages."""
    commands = Commands(sequence, passages, limits, sample_time_s)
    least = commands.lines()
    arcs = [commands.arc(int(i)) for i in np.flatnonzero(commands.turns & (commands.length > 0))]
    for arc in arcs:
        least[arc.command] = commands.relaxed(arc)
    open_s = commands.taken - least
    chosen = sorted(arcs, key=lambda arc: (-open_s[arc.command], arc.command))[:most_arcs]
    by_toppra = 0
    if chosen:
        from toolpaths.toppra_arcs import arc_time

        for arc in chosen:
            i = arc.command
            length = commands.length[i] - commands.lead[i]
            time_s = arc_time(arc, length, (commands.v0[i], commands.v1[i]), commands.v_max[i], GRID)
            if time_s is not None:
                least[i] = max(least[i], time_s * (1 - GRID_ERROR))
                by_toppra += 1
    # a command without way along the path (an axis that does not count), or one without two samples, stays as it was
    known = (commands.length > 0) & (commands.p["samples"] > 1)
    return LeastTimes(commands.taken, np.where(known, least, commands.taken), len(arcs), by_toppra)
