"""Contours of drawings: DXF through ezdxf, SVG through svgelements. Lines and arcs stay exact, curves are flattened."""

from __future__ import annotations

import io
import logging
import math
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toolpaths.meshes import FARTHEST_MM, GeometryError, Triangles

#: Chords of splines, ellipses and Bezier curves stay this near to them, mm.
FLATTEN_MM = 1e-4
MOST_PIECES = 1_000_000
#: Blocks of a DXF file inside each other.
MOST_NESTED = 16
SEGMENT, ARC, TRIANGLE = 0, 1, 2
#: $INSUNITS of a DXF file that are lengths, in mm; 0 (no unit) counts as mm.
DXF_UNITS = {0: 1.0, 1: 25.4, 2: 304.8, 4: 1.0, 5: 10.0, 6: 1000.0, 13: 1e-3}

#: Kind and the numbers of a piece as cnc_front._native.toolpaths.Nearest takes them.
Piece = tuple[int, tuple[float, ...]]


@dataclass(slots=True)
class Drawing:
    """Pieces of a contour in the XY plane, or triangles of a surface; mm. `skipped` counts what is no contour."""

    kinds: NDArray[np.uint8]
    data: NDArray[np.float64]
    skipped: dict[str, int] = field(default_factory=dict)

    @property
    def is_surface(self) -> bool:
        """Triangles, to be measured in space."""
        return bool(self.kinds[0] == TRIANGLE)

    def moved(self, offset: Iterable[float]) -> Drawing:
        """The same drawing at another place."""
        x, y, z = offset
        data = self.data.copy()
        arcs = self.kinds == ARC
        data[arcs, 0:2] += (x, y)
        for column in range(0, 9, 3):
            data[~arcs, column : column + 3] += (x, y, z if self.is_surface else 0.0)
        return Drawing(self.kinds, data, self.skipped)

    def lengths(self) -> NDArray[np.float64]:
        """Length of each piece of a contour."""
        straight = np.hypot(self.data[:, 3] - self.data[:, 0], self.data[:, 4] - self.data[:, 1])
        return np.where(self.kinds == ARC, np.abs(self.data[:, 2] * self.data[:, 4]), straight)

    def points(self, piece: NDArray[Any], part: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places (n, 3) on pieces, `part` from 0 to 1 along them."""
        rows, part = self.data[piece], part[:, None]
        straight = rows[:, 0:3] + part * (rows[:, 3:6] - rows[:, 0:3])
        angle = rows[:, 3:4] + part * rows[:, 4:5]
        round_ = np.hstack([rows[:, 0:1] + rows[:, 2:3] * np.cos(angle), rows[:, 1:2] + rows[:, 2:3] * np.sin(angle)])
        round_ = np.hstack([round_, np.zeros((len(rows), 1))])
        return np.where((self.kinds[piece] == ARC)[:, None], round_, straight)


def read_drawing(data: bytes, kind: str, scale: float | None = None, layer: str | None = None) -> Drawing:
    """The contour in the bytes of a DXF or SVG file. `scale` (mm per unit) overrides the unit of the file; `layer`
    takes one layer of a DXF file only. Raises GeometryError."""
    skipped: Counter[str] = Counter()
    try:
        pieces = _dxf(data, scale, layer, skipped) if kind == "dxf" else _svg(data, scale, skipped)
        drawing = _collected(pieces)
    except GeometryError:
        raise
    except Exception as error:  # a reader of foreign files may raise anything
        raise GeometryError(f"cannot be read as {kind.upper()}: {error or type(error).__name__}") from None
    drawing.skipped = dict(sorted(skipped.items()))
    return drawing


def surface(triangles: Triangles) -> Drawing:
    """The surface of a body."""
    return Drawing(np.full(len(triangles), TRIANGLE, np.uint8), np.ascontiguousarray(triangles.reshape(-1, 9)))


def contour(segments: NDArray[np.float64]) -> Drawing:
    """Segments (n, 2, 3) as a contour in the XY plane."""
    data = np.zeros((len(segments), 9))
    data[:, 0:2], data[:, 3:5] = segments[:, 0, :2], segments[:, 1, :2]
    return Drawing(np.zeros(len(segments), np.uint8), data)


def _collected(pieces: Iterator[Piece]) -> Drawing:
    kinds: list[int] = []
    rows: list[tuple[float, ...]] = []
    for kind, numbers in pieces:
        if len(kinds) >= MOST_PIECES:
            raise GeometryError(f"has more than {MOST_PIECES} lines and arcs")
        if not all(abs(number) <= FARTHEST_MM for number in numbers):
            raise GeometryError(f"reaches farther than {FARTHEST_MM:g} mm from its origin; check its unit")
        kinds.append(kind)
        rows.append((*numbers, *(0.0,) * (9 - len(numbers))))
    if not kinds:
        raise GeometryError("holds no contour (lines, arcs, circles, polylines, curves)")
    return Drawing(np.array(kinds, dtype=np.uint8), np.array(rows, dtype=np.float64))


def _chain(points: Iterable[tuple[float, float]]) -> Iterator[Piece]:
    before: tuple[float, float] | None = None
    for point in points:
        if before is not None and point != before:
            yield SEGMENT, (*before, 0.0, *point, 0.0)
        before = point


# ---- DXF


def _dxf(data: bytes, scale: float | None, layer: str | None, skipped: Counter[str]) -> Iterator[Piece]:
    from ezdxf import recover

    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)  # what it mended is not ours to tell
    document, _ = recover.read(io.BytesIO(data))
    if scale is None:
        unit = int(document.header.get("$INSUNITS", 0))
        if unit not in DXF_UNITS:
            raise GeometryError(f"has the unit {unit} ($INSUNITS), which is none of a drawing; give --reference-unit")
        scale = DXF_UNITS[unit]
    used = {entity.dxf.layer for entity in document.modelspace()}
    if layer is not None and layer.lower() not in {name.lower() for name in used}:
        raise GeometryError(f"has nothing on a layer {layer}; there is {', '.join(sorted(used)[:10]) or 'nothing'}")
    hidden = {entry.dxf.name.lower() for entry in document.layers if entry.is_off() or entry.is_frozen()}
    for entity in document.modelspace():
        name = entity.dxf.layer.lower()
        if name in hidden or (layer is not None and name != layer.lower()):
            continue
        yield from _entity(entity, scale, skipped, 0)


def _entity(entity: Any, scale: float, skipped: Counter[str], depth: int) -> Iterator[Piece]:
    kind = entity.dxftype()
    if kind == "LINE":
        start, end = entity.dxf.start, entity.dxf.end
        yield from _chain([(start.x * scale, start.y * scale), (end.x * scale, end.y * scale)])
    elif kind in ("ARC", "CIRCLE"):
        yield from _dxf_arc(entity, scale, skipped)
    elif kind in ("SPLINE", "ELLIPSE"):
        points = entity.flattening(FLATTEN_MM / scale, 8)
        yield from _chain((p.x * scale, p.y * scale) for p in points)
    elif kind in ("LWPOLYLINE", "POLYLINE", "INSERT"):
        if depth >= MOST_NESTED:
            raise GeometryError(f"has blocks nested deeper than {MOST_NESTED}")
        for part in entity.virtual_entities():
            yield from _entity(part, scale, skipped, depth + 1)
    else:
        skipped[kind] += 1


def _dxf_arc(entity: Any, scale: float, skipped: Counter[str]) -> Iterator[Piece]:
    normal = entity.dxf.extrusion
    if abs(normal.x) > 1e-9 or abs(normal.y) > 1e-9:
        skipped[f"{entity.dxftype()} outside the XY plane"] += 1
        return
    radius, center = abs(entity.dxf.radius) * scale, entity.ocs().to_wcs(entity.dxf.center)
    start, sweep = 0.0, 2 * math.pi
    if entity.dxftype() == "ARC":
        start = math.radians(entity.dxf.start_angle)
        sweep = math.radians((entity.dxf.end_angle - entity.dxf.start_angle) % 360.0) or 2 * math.pi
    if normal.z < 0:  # seen from below
        start, sweep = math.pi - start, -sweep
    if radius > 0:
        yield ARC, (center.x * scale, center.y * scale, radius, start, sweep)


# ---- SVG


def _svg(data: bytes, scale: float | None, skipped: Counter[str]) -> Iterator[Piece]:
    from svgelements import SVG, Path, Shape

    # 25.4 pixels an inch: a length in mm keeps its number, and a bare number is one
    page = SVG.parse(io.BytesIO(data), ppi=25.4)
    if str(page.values.get("width", "")).strip().endswith(("mm", "cm")):
        # the library takes a millimetre for 0.0393701 in
        page = SVG.parse(io.BytesIO(data), ppi=1 / 0.0393701)
    factor = scale or 1.0
    height = float(page.height or 0.0) if page.values.get("height") or page.values.get("viewBox") else 0.0

    def place(point: Any) -> tuple[float, float]:
        return float(point.x) * factor, (height - float(point.y)) * factor

    for element in page.elements():
        if isinstance(element, Shape):
            for segment in abs(Path(element)):
                yield from _svg_piece(segment, place, factor)
        elif type(element).__name__ in ("Text", "Image"):
            skipped[type(element).__name__.upper()] += 1


def _svg_piece(segment: Any, place: Any, factor: float) -> Iterator[Piece]:
    from svgelements import Arc, CubicBezier, Move, QuadraticBezier

    if isinstance(segment, Move) or segment.start is None or segment.end is None:
        return
    if isinstance(segment, Arc) and abs(segment.rx - segment.ry) <= 1e-9 * segment.rx:
        (cx, cy), (sx, sy) = place(segment.center), place(segment.start)
        # the page is turned over: what ran clockwise on it now runs counter-clockwise
        sweep = -float(segment.sweep)
        if sweep:
            yield ARC, (cx, cy, math.hypot(sx - cx, sy - cy), math.atan2(sy - cy, sx - cx), sweep)
        return
    if isinstance(segment, Arc):
        bend = max(segment.rx, segment.ry) * float(segment.sweep) ** 2
        count = _chords(bend * factor, segment.rx * factor, segment.ry * factor)
        # by its own angle, in equal steps
        first, step = segment.get_start_t(), segment.sweep / count
        between = [segment.point_at_t(first + k * step) for k in range(1, count)]
        yield from _chain(place(point) for point in (segment.start, *between, segment.end))
        return
    controls = [segment.start, segment.end]
    if isinstance(segment, CubicBezier):
        controls[1:1] = [segment.control1, segment.control2]
    elif isinstance(segment, QuadraticBezier):
        controls[1:1] = [segment.control]
    yield from _chain(_bezier(np.array([place(point) for point in controls])))


def _chords(bend: float, *reach: float) -> int:
    """Chords that keep the tolerance on a curve whose second derivative over its parameter is at most `bend`."""
    if not max(reach) <= FARTHEST_MM:
        raise GeometryError(f"reaches farther than {FARTHEST_MM:g} mm from its origin; check its unit")
    return min(max(1, math.ceil(math.sqrt(bend / (8 * FLATTEN_MM)))), MOST_PIECES)


def _bezier(controls: NDArray[np.float64]) -> list[tuple[float, float]]:
    """Points of a Bezier curve of degree 1, 2 or 3 in equal steps of its parameter, by de Casteljau."""
    degree = len(controls) - 1
    second = np.diff(controls, 2, axis=0) * degree * (degree - 1)
    bend = float(np.hypot(second[:, 0], second[:, 1]).max(initial=0.0))
    t = np.linspace(0.0, 1.0, _chords(bend, float(np.abs(controls).max())) + 1)[:, None]
    rows = [np.broadcast_to(control, (len(t), 2)) for control in controls]
    while len(rows) > 1:
        rows = [a * (1 - t) + b * t for a, b in pairwise(rows)]
    return [(float(x), float(y)) for x, y in rows[0].tolist()]
