"""Cutter radius correction G41, G42 against an offset that knows nothing of it: pyclipper offsets the contour.

Random closed contours of lines and arcs, the tool on both sides: where it fits, the corrected path and the ring of the
other offset lie within 1e-6 mm of each other, both ways; where it surely does not fit, the translator says so, and
only there. RADIUS_CONTOURS sets how many (default 100; 1000 take some minutes).
"""

from __future__ import annotations

import math
import os
import random
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import KDTree

import gcode
from motion_kernel import Machine

pyclipper = pytest.importorskip("pyclipper", reason="the independent offset needs pyclipper (a dev dependency)")

CONTOURS = int(os.environ.get("RADIUS_CONTOURS", "100"))
LIMIT = 1e-6
#: Sagitta of the polygons that stand for arcs: what the reference itself is off.
SAGITTA = 3.5e-7
#: Clipper reckons in integers.
SCALE = 1e9
#: Points on the sides of a ring are so near that the nearest of them shows the nearest side, mm.
SPACING = 0.02
Point = tuple[float, float]
MILL = (Path(__file__).parents[2] / "examples" / "machines" / "mill3.toml").read_text("utf-8")


@dataclass(frozen=True)
class Edge:
    """A line, or an arc with its centre and sweep in radians."""

    a: Point
    b: Point
    centre: Point | None = None
    sweep: float = 0.0

    def points(self, count: int) -> Any:
        """`count` + 1 points from start to end, (n, 2)."""
        t = np.linspace(0.0, 1.0, count + 1)[:, None]
        if self.centre is None:
            return np.array(self.a) + t * (np.array(self.b) - np.array(self.a))
        v = np.array(self.a) - np.array(self.centre)
        cos, sin = np.cos(t * self.sweep), np.sin(t * self.sweep)
        return np.array(self.centre) + np.hstack((v[0] * cos - v[1] * sin, v[0] * sin + v[1] * cos))

    def dense(self) -> Any:
        """Points whose chords are within SAGITTA."""
        if self.centre is None:
            return self.points(1)
        radius = math.dist(self.a, self.centre)
        return self.points(math.ceil(abs(self.sweep) / math.sqrt(8 * SAGITTA / radius)))

    def left(self, points: Any) -> Any:
        """Unit normals to the left at points of the edge."""
        if self.centre is None:
            d = np.array(self.b) - np.array(self.a)
            return np.tile(np.array([-d[1], d[0]]) / math.hypot(*d), (len(points), 1))
        inward = (np.array(self.centre) - points) * math.copysign(1.0, self.sweep)
        return inward / np.linalg.norm(inward, axis=1)[:, None]

    def text(self) -> str:
        end = f"X{self.b[0]:.12f} Y{self.b[1]:.12f}"
        if self.centre is None:
            return f"G1 {end}\n"
        i, j = self.centre[0] - self.a[0], self.centre[1] - self.a[1]
        return f"G{3 if self.sweep > 0 else 2} {end} I{i:.12f} J{j:.12f}\n"


def bent(a: Point, b: Point, sweep: float) -> Edge:
    """The arc from a to b with a signed sweep."""
    if sweep == 0.0:
        return Edge(a, b)
    dx, dy = b[0] - a[0], b[1] - a[1]
    h = 0.5 / math.tan(0.5 * abs(sweep)) * math.copysign(1.0, sweep)
    return Edge(a, b, (0.5 * (a[0] + b[0]) - h * dy, 0.5 * (a[1] + b[1]) + h * dx), sweep)


def contour(rng: random.Random) -> list[Edge]:
    """Corners at rising angles about the origin, some edges bent; the first is straight."""
    n = rng.randint(3, 9)
    corners = []
    for i in range(n):
        angle = math.tau * (i + rng.uniform(-0.3, 0.3)) / n
        radius = rng.uniform(5.0, 14.0)
        corners.append((round(radius * math.cos(angle), 4), round(radius * math.sin(angle), 4)))
    if rng.random() < 0.5:
        corners.reverse()
    bends = [0.0] + [rng.choice([0.0, 0.0, 1.0, -1.0]) * math.radians(rng.uniform(20.0, 80.0)) for _ in corners[1:]]
    return [bent(a, corners[(i + 1) % n], bends[i]) for i, a in enumerate(corners)]


def polygon(edges: list[Edge]) -> Any | None:
    """The contour as a counter-clockwise polygon, (n, 2); None if it crosses itself."""
    points = np.vstack([edge.dense()[:-1] for edge in edges])
    path = np.round(points * SCALE).astype(np.int64).tolist()
    if not pyclipper.Orientation(path):
        path.reverse()
    simple = pyclipper.SimplifyPolygon(path, pyclipper.PFT_NONZERO)
    if len(simple) != 1 or abs(pyclipper.Area(simple[0]) / pyclipper.Area(path) - 1.0) > 1e-9:
        return None
    return path


def is_counter_clockwise(edges: list[Edge]) -> bool:
    corners = np.array([edge.a for edge in edges])
    x, y = corners.T
    return bool(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0)


def split(edges: list[Edge]) -> list[Edge]:
    """The contour as programmed: from the middle of the first edge around to it."""
    middle = tuple(edges[0].points(2)[1])
    return [Edge(middle, edges[0].b), *edges[1:], Edge(edges[0].a, middle)]


def program(edges: list[Edge], left: bool, radius: float) -> str:
    """On and off at right angles where the contour, already split, begins."""
    beside = edges[0].points(1)[:1] + edges[0].left(edges[0].points(1)[:1]) * (2 if left else -2) * radius
    on, off = (f"X{p[0]:.12f} Y{p[1]:.12f}" for p in (edges[0].a, beside[0]))
    contour = "".join(edge.text() for edge in edges)
    return f"G0 {off}\nG{41 if left else 42} D1 G1 {on} F3000\n{contour}G40 G1 {off}\nM30\n"


class Ring:
    """A closed polygon to which distances are asked: its points, with more on long sides, in a tree."""

    def __init__(self, points: Any) -> None:
        sides = np.linalg.norm(np.diff(points, axis=0), axis=1)
        counts = np.maximum(1, np.ceil(sides / SPACING).astype(int))
        first = np.repeat(np.arange(len(counts)), counts)
        t = (np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[first]
        self.points = points[first] + t[:, None] * (points[first + 1] - points[first])
        self.tree = KDTree(self.points)

    def distance(self, points: Any) -> Any:
        """Distance of points from the sides next to the nearest points of the ring: at a corner those of both sides."""
        _, nearest = self.tree.query(points, k=8)
        n = len(self.points)
        return np.min([self._from_side(points, (near + k) % n) for near in nearest.T for k in (-1, 0)], axis=0)

    def _from_side(self, points: Any, first: Any) -> Any:
        a, b = self.points[first], self.points[(first + 1) % len(self.points)]
        d, v = b - a, points - a
        t = np.clip(np.sum(v * d, axis=1) / np.maximum(np.sum(d * d, axis=1), 1e-300), 0.0, 1.0)
        return np.linalg.norm(v - t[:, None] * d, axis=1)


def reference(shape: Any, signed: float) -> list[Ring]:
    """The rings that the tool centre follows: the polygon grown (signed > 0) or shrunk."""
    offset = pyclipper.PyclipperOffset(2.0, SAGITTA * SCALE)
    offset.AddPath(shape, pyclipper.JT_ROUND, pyclipper.ET_CLOSEDPOLYGON)
    rings = [np.array(ring) / SCALE for ring in offset.Execute(signed * SCALE)]
    return [Ring(np.vstack((ring, ring[:1]))) for ring in rings]


def fits(edges: list[Edge], shape: Any, left: bool, signed: float) -> bool:
    """One ring to which every edge contributes."""
    rings = reference(shape, signed)
    if len(rings) != 1:
        return False
    for edge in edges:
        points = edge.points(24)[1:-1]
        beside = points + edge.left(points) * (abs(signed) if left else -abs(signed))
        if rings[0].distance(beside).min() > LIMIT:
            return False
    return True


def corrected(sequence: dict[str, Any]) -> list[tuple[Any, Any, Any, float]]:
    """Start, end, centre, sweep in degrees of each piece between approach and departure."""
    ends = np.vstack((sequence["start"][None, :], sequence["target"]))[:, :2]
    return [(ends[k], ends[k + 1], sequence["center"][k], float(sequence["phi"][k])) for k in range(2, len(ends) - 2)]


def sampled(piece: tuple[Any, Any, Any, float]) -> Any:
    start, end, centre, phi = piece
    edge = Edge(tuple(start), tuple(end), tuple(centre) if phi else None, math.radians(phi))
    return edge.points(8)


def distance(points: Any, piece: tuple[Any, Any, Any, float]) -> Any:
    """Exact distance of points from a piece."""
    start, end, centre, phi = piece
    ends = np.minimum(np.linalg.norm(points - start, axis=1), np.linalg.norm(points - end, axis=1))
    if not phi:
        d = end - start
        t = (points - start) @ d / (d @ d)
        beside = np.linalg.norm(points - start - t[:, None] * d, axis=1)
        return np.where((t >= 0) & (t <= 1), beside, ends)
    u, v = start - centre, points - centre
    turned = np.degrees(np.arctan2(u[0] * v[:, 1] - u[1] * v[:, 0], v @ u)) * math.copysign(1.0, phi) % 360.0
    beside = np.abs(np.linalg.norm(v, axis=1) - math.hypot(*u))
    return np.where(turned <= abs(phi), beside, ends)


def apart(pieces: list[tuple[Any, Any, Any, float]], rings: list[Ring]) -> float:
    """The largest distance of the corrected path from the one ring, and of the ring from the path."""
    if len(rings) != 1:
        return math.inf
    there = rings[0].distance(np.vstack([sampled(piece) for piece in pieces])).max()
    theirs = rings[0].points[:: max(1, len(rings[0].points) // 300)]
    back = np.min([distance(theirs, piece) for piece in pieces], axis=0).max()
    return float(max(there, back))


def compile_for(text: str, radius: float) -> gcode.Program | set[str]:
    machine = f"{MILL}\n[[gcode.tool]]\nnumber = 1\nradius = {radius!r}\n"
    try:
        return gcode.compile(text, Machine.parse(machine))
    except gcode.CompileError as error:
        return {d.id for d in error.diagnostics if not d.is_warning}


def test_corrected_paths_are_the_independent_offset() -> None:
    rng = random.Random(8001)
    followed = gouges = doubtful = crossed = 0
    worst = 0.0
    for _ in range(CONTOURS):  # each with the tool on both sides
        edges = contour(rng)
        shape = polygon(edges)
        if shape is None:
            crossed += 1
            continue
        counter_clockwise = is_counter_clockwise(edges)
        edges = split(edges)
        radius = round(rng.uniform(0.3, 4.0), 3)
        for left in (True, False):
            inside = counter_clockwise == left
            sign = -1.0 if inside else 1.0
            text = program(edges, left, radius)
            found = compile_for(text, radius)
            if isinstance(found, set):
                assert not fits(edges, shape, left, sign * radius * 1.02), f"invented {found}, radius {radius}\n{text}"
                gouges += 1
                continue
            off = apart(corrected(found.sequence()), reference(shape, sign * radius))
            if off > LIMIT and not fits(edges, shape, left, sign * radius * 1.02):
                assert fits(edges, shape, left, sign * radius * 0.98), f"missed, radius {radius}\n{text}"
                doubtful += 1
                continue
            assert off <= LIMIT, f"{off} mm apart, radius {radius}\n{text}"
            worst = max(worst, off)
            followed += 1
    counts = f"{gouges} gouges confirmed, {doubtful} doubtful, {crossed} cross themselves"
    print(f"{followed} paths followed within {worst:.1e} mm, {counts}")
    assert followed > CONTOURS // 2 and gouges > CONTOURS // 20
    assert doubtful + crossed < CONTOURS // 4


def test_the_measure_can_fail() -> None:
    piece = (np.array([0.0, 0.0]), np.array([2.0, 0.0]), np.array([1.0, 0.0]), 180.0)
    assert distance(np.array([[1.0, -1.0]]), piece)[0] == pytest.approx(0.0)
    assert distance(np.array([[1.0, 1.0]]), piece)[0] == pytest.approx(math.sqrt(2.0))
    square = [Edge((0, 0), (9, 0)), Edge((9, 0), (9, 9)), Edge((9, 9), (0, 9)), Edge((0, 9), (0, 0))]
    assert fits(square, polygon(square), True, -4.4) and not fits(square, polygon(square), True, -4.6)
