"""Material removal on a height map, and what tool and holder meet: fixtures, stock, rapids through material.

Three axes: X, Y, Z are linear and the tool stands along Z. Every body is seen from above: what lies below an overhang
counts as solid. docs/material.md has the definitions and the bounds of error.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native.toolpaths import Chords, HeightMap
from toolpaths.meshes import Triangles

Heights = NDArray[np.float64]
Moves = NDArray[np.float64]

#: Chords of the driven path that the tool is swept along stay this near to the samples, mm.
CHORD_MM = 0.0005
#: Nodes of a map at most, and as many as the default resolution aims at.
MOST_NODES, USUAL_NODES = 25_000_000, 1_000_000
#: Less is no finding: rounding of a body that rests on another, mm.
LEAST_MM = 1e-6
#: Where the target climbs more than this times the resolution between neighbours, it counts as a wall.
WALL_SLOPE = 3.0
RAPID_BIT, TOOL_SHIFT = 32, 33
#: What a machine meets, in the order of the report.
KINDS = ("tool_fixture", "holder_fixture", "holder_stock", "rapid_stock", "flutes_stock")


@dataclass(frozen=True, slots=True)
class Tool:
    """A rotating tool, mm. `gauge` is subtracted from the Z of the machine and gives the tip; `bodies` are shank and
    holder as (radius, height of the lower face above the tip); `flute` is how deep it may cut."""

    number: int
    shape: str
    radius: float
    corner: float
    gauge: float = 0.0
    flute: float = np.inf
    bodies: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Grid:
    """Square cells over a rectangle, mm."""

    x0: float
    y0: float
    step: float
    nx: int
    ny: int

    @classmethod
    def over(cls, low: Any, high: Any, step: float) -> Grid:
        """Cells that cover the rectangle; a side that is no multiple of the step is rounded up."""
        nx, ny = (max(1, int(np.ceil((high[k] - low[k]) / step - 1e-9))) for k in (0, 1))
        return cls(float(low[0]), float(low[1]), step, nx, ny)

    def flat(self, z: float) -> Heights:
        """A plane."""
        return np.full((self.ny, self.nx), z, dtype=np.float64)

    def map(self, z: Heights) -> HeightMap:
        """A height map with these heights."""
        return HeightMap(self.x0, self.y0, self.step, np.ascontiguousarray(z))

    def of_mesh(self, triangles: Triangles, grow: float = 0.0) -> Heights:
        """Heights of a body from above, -inf beside it."""
        heights = self.map(self.flat(-np.inf))
        heights.raise_mesh(np.ascontiguousarray(triangles.reshape(-1, 9)), grow)
        return heights.z()


@dataclass(frozen=True, slots=True)
class Fixture:
    """A body that nothing may touch."""

    name: str
    triangles: Triangles
    clearance: float = 0.0


@dataclass(slots=True)
class Finding:
    """Something met something: kind of KINDS, with what, the line, first sample, place of the node (x, y) and lowest
    height of the tip there, and by how much the body rises above the tool's lower surface, mm."""

    kind: str
    body: str
    tool: int
    line: int
    sample: int
    place: tuple[float, float, float]
    size: float


@dataclass(slots=True)
class Workshop:
    """All that a run is checked against. Coordinates of the setup, mm."""

    tools: dict[int, Tool]
    first_tool: int
    grid: Grid | None = None
    stock: Heights | None = None
    #: underside of the stock: what is cut through ends there
    floor: float = -np.inf
    fixtures: tuple[Fixture, ...] = ()
    rapid_margin: float = 0.05
    resolution: float = 0.1


def usual_step(low: Any, high: Any) -> float:
    """The default resolution: a round number with which a map has about a million nodes."""
    step = float(np.sqrt((high[0] - low[0]) * (high[1] - low[1]) / USUAL_NODES))
    power = 10.0 ** np.floor(np.log10(max(step, 1e-3)))
    return float(min(m * power for m in (1, 2, 5, 10) if m * power >= step * (1 - 1e-9)))


@dataclass(slots=True)
class Removal:
    """Sweeps tools along a driven path. Feed chunks in order, then `finish`."""

    shop: Workshop
    findings: list[Finding] = field(default_factory=list)
    moves: int = 0
    stock: HeightMap | None = None
    _chords: Chords = field(default_factory=lambda: Chords(CHORD_MM))
    _fixtures: list[tuple[str, HeightMap]] = field(default_factory=list)

    def __post_init__(self) -> None:
        shop = self.shop
        if shop.grid is not None and shop.stock is not None:
            self.stock = shop.grid.map(shop.stock)
            self.stock.floor = shop.floor
        for fixture in shop.fixtures:
            # half a diagonal of a cell: no wall falls between the nodes
            grow = shop.resolution * float(np.sqrt(0.5)) + fixture.clearance
            corners = fixture.triangles.reshape(-1, 3)
            low, high = corners.min(axis=0) - grow - shop.resolution, corners.max(axis=0) + grow + shop.resolution
            grid = Grid.over(low, high, shop.resolution)
            self._fixtures.append((fixture.name, grid.map(grid.of_mesh(fixture.triangles, grow))))

    def feed(
        self,
        points: NDArray[np.float64],
        lines: NDArray[np.uint32],
        rapid: NDArray[np.bool_],
        tools: NDArray[np.int64],
        first_sample: int,
    ) -> None:
        """Samples: position of the machine (n, 3) less the setup's zero, source lines, rapids, tools in the spindle."""
        gauges = np.zeros(len(points))
        for number in np.unique(tools).tolist():
            if number in self.shop.tools:
                gauges[tools == number] = self.shop.tools[number].gauge
        tips = np.ascontiguousarray(points - np.column_stack([np.zeros((len(points), 2)), gauges]))
        tags = lines.astype(np.uint64) | (rapid.astype(np.uint64) << np.uint64(RAPID_BIT))
        tags |= tools.astype(np.uint64) << np.uint64(TOOL_SHIFT)
        self._sweep(*self._chords.feed(tips, tags, first_sample))

    def finish(self) -> None:
        """Sweeps what is still open."""
        self._sweep(*self._chords.finish())

    @property
    def volume(self) -> float:
        """Volume removed from the stock so far, mm3: from the map itself, whatever chunks the samples came in."""
        if self.stock is None or self.shop.stock is None:
            return 0.0
        there = np.isfinite(self.shop.stock)
        return float((self.shop.stock[there] - self.stock.z()[there]).sum()) * self.shop.resolution**2

    def _sweep(self, moves: Moves, tags: NDArray[np.uint64], samples: NDArray[np.uint64]) -> None:
        self.moves += len(moves)
        kinds = tags >> np.uint64(RAPID_BIT)
        borders = np.flatnonzero(np.diff(kinds)) + 1
        for part in np.split(np.arange(len(moves)), borders):
            if len(part) == 0:
                continue
            kind = int(kinds[part[0]])
            tool, rapid = self.shop.tools.get(kind >> 1), bool(kind & 1)
            if tool is None:  # T0: an empty spindle
                continue
            lines = (tags[part] & np.uint64(0xFFFFFFFF)).astype(np.uint32)
            self._sweep_tool(tool, rapid, np.ascontiguousarray(moves[part]), lines, samples[part])

    def _sweep_tool(
        self, tool: Tool, rapid: bool, moves: Moves, lines: NDArray[np.uint32], samples: NDArray[np.uint64]
    ) -> None:
        def note(kind: str, body: str, met: NDArray[np.float64], less: float = 0.0) -> None:
            for k in np.flatnonzero(met[:, 0] - less > LEAST_MM).tolist():
                place = (float(met[k, 1]), float(met[k, 2]), float(min(moves[k, 2], moves[k, 5])))
                size = float(met[k, 0] - less)
                self._note(Finding(kind, body, tool.number, int(lines[k]), int(samples[k]), place, size))

        for name, heights in self._fixtures:
            note("tool_fixture", name, heights.probe(moves, tool.radius, tool.corner))
            for radius, above in tool.bodies:
                raised = moves + np.array([0.0, 0.0, above, 0.0, 0.0, above])
                note("holder_fixture", name, heights.probe(raised, radius, 0.0))
        if self.stock is None:
            return
        margin = min(self.shop.rapid_margin, tool.radius / 2) if rapid else None
        met = self.stock.cut(moves, lines, tool.radius, tool.corner, margin, list(tool.bodies))
        note("rapid_stock", "stock", met[:, 4:8])
        note("holder_stock", "stock", met[:, 8:12])
        if np.isfinite(tool.flute):
            note("flutes_stock", "stock", met[:, 0:4], tool.flute)

    def _note(self, found: Finding) -> None:
        """Neighbouring moves of one line are one finding, that of the largest size."""
        for last in reversed(self.findings[-8:]):
            if (last.kind, last.body, last.tool, last.line) == (found.kind, found.body, found.tool, found.line):
                if found.size > last.size:
                    last.size, last.place, last.sample = found.size, found.place, found.sample
                return
        self.findings.append(found)


@dataclass(frozen=True, slots=True)
class Compared:
    """A cut stock against the target, mm per node: + rest, - gouge, NaN where there is no target; 0 within a cell of
    a wall of the target as long as the wall lies within that cell."""

    difference: Heights
    grid: Grid

    def side(self, sign: int, limit: float, lines: NDArray[np.uint32]) -> dict[str, Any]:
        """Rest (+1) or gouge (-1): largest, where, the line that cut there last, area and volume above the limit."""
        size = np.nan_to_num(sign * self.difference, nan=0.0)
        k = int(size.argmax())
        j, i = divmod(k, self.grid.nx)
        cell, over = self.grid.step**2, size > limit
        place = [self.grid.x0 + (i + 0.5) * self.grid.step, self.grid.y0 + (j + 0.5) * self.grid.step]
        there = size[j, i] > 0
        return {
            "max_mm": float(max(size[j, i], 0.0)),
            "place": {"X": round(place[0], 6), "Y": round(place[1], 6)} if there else None,
            "line": (int(lines[j, i]) or None) if there else None,
            "limit_mm": limit,
            "area_mm2": float(np.count_nonzero(over) * cell),
            "volume_mm3": float(size[over].sum() * cell),
        }


def compare(heights: Heights, target: Heights, grid: Grid) -> Compared:
    """The cut stock against the target, node by node along Z."""
    high, low = _around(target, np.maximum, -np.inf), _around(target, np.minimum, np.inf)
    there = np.isfinite(target)
    with np.errstate(invalid="ignore"):
        difference = np.where(there, heights - target, np.nan)
        wall = there & ~(high - low <= WALL_SLOPE * grid.step)
        rest, gouge = np.maximum(heights - high, 0.0), np.maximum(low - heights, 0.0)
    difference[wall] = (rest - gouge)[wall]
    return Compared(difference, grid)


def _around(z: Heights, most: Any, outside: float) -> Heights:
    """Greatest (or least) height of a node and its eight neighbours."""
    for axis in (0, 1):
        wide = np.pad(z, [(1, 1) if k == axis else (0, 0) for k in (0, 1)], constant_values=outside)
        parts = [np.take(wide, range(k, k + z.shape[axis]), axis=axis) for k in (0, 1, 2)]
        z = most(most(parts[0], parts[1]), parts[2])
    return z
