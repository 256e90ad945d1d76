"""Writes the drawing and the meshes of the example: plate.dxf, plate.stl, clamp.stl, in the folder of this file.

All are made from the numbers of the drawing alone, not from the part program. `--folder DIR` writes elsewhere.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

Point = tuple[float, float, float]
CENTRE = (40.0, 30.0)
SIZE = (80.0, 60.0)
#: Width, height, corner radius of boss and pocket; heights of the faces.
BOSS, POCKET = (50.0, 30.0, 8.0), (30.0, 14.0, 3.0)
TOP, POCKET_FLOOR, SHOULDER, BOTTOM = 0.0, -3.0, -4.0, -12.0
PER_CORNER = 17


def outline(shape: tuple[float, float, float], z: float) -> list[Point]:
    """A rounded rectangle, counter-clockwise from the right upper corner, PER_CORNER points a corner."""
    width, height, radius = shape
    points = []
    for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        cx, cy = CENTRE[0] + sx * (width / 2 - radius), CENTRE[1] + sy * (height / 2 - radius)
        for k in range(PER_CORNER):
            angle = math.pi / 2 * (quarter + k / (PER_CORNER - 1))
            points.append((cx + radius * math.cos(angle), cy + radius * math.sin(angle), z))
    return points


def rectangle(z: float) -> list[Point]:
    """The blank seen from above, counter-clockwise from the right upper corner."""
    x, y = SIZE
    return [(x, y, z), (0.0, y, z), (0.0, 0.0, z), (x, 0.0, z)]


def strip(upper: Sequence[Point], lower: Sequence[Point]) -> list[tuple[Point, Point, Point]]:
    """Faces between two rings of as many points, the first one inside or above, seen from outside or above."""
    faces = []
    for k in range(len(upper)):
        a, b, c, d = upper[k - 1], upper[k], lower[k - 1], lower[k]
        faces += [(a, c, d), (a, d, b)]
    return faces


def fan(ring: Sequence[Point]) -> list[tuple[Point, Point, Point]]:
    """A convex face that looks up; turned round it looks down."""
    return [(ring[0], ring[k], ring[k + 1]) for k in range(1, len(ring) - 1)]


def shoulder(ring: Sequence[Point], corners: Sequence[Point]) -> list[tuple[Point, Point, Point]]:
    """The face between the foot of the boss and the rectangle around it."""
    faces = []
    for quarter in range(4):
        part = ring[quarter * PER_CORNER : (quarter + 1) * PER_CORNER]
        faces += [(part[k], corners[quarter], part[k + 1]) for k in range(PER_CORNER - 1)]
        following, ahead = ring[(quarter + 1) * PER_CORNER % len(ring)], corners[(quarter + 1) % 4]
        faces += [(part[-1], corners[quarter], ahead), (part[-1], ahead, following)]
    return faces


def part() -> list[tuple[Point, Point, Point]]:
    """The finished plate."""
    boss, foot = outline(BOSS, TOP), outline(BOSS, SHOULDER)
    rim, floor = outline(POCKET, TOP), outline(POCKET, POCKET_FLOOR)
    upper, lower = rectangle(SHOULDER), rectangle(BOTTOM)
    faces = strip(rim, boss) + strip(boss, foot) + strip(floor, rim) + fan(floor)
    faces += shoulder(foot, upper) + strip(upper, lower) + fan(lower[::-1])
    return faces


def box(low: Point, high: Point) -> list[tuple[Point, Point, Point]]:
    """A cuboid."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    upper = [(x1, y1, z1), (x0, y1, z1), (x0, y0, z1), (x1, y0, z1)]
    lower = [(x, y, z0) for x, y, _ in upper]
    return fan(upper) + strip(upper, lower) + fan(lower[::-1])


def stl(name: str, faces: Sequence[tuple[Point, Point, Point]]) -> str:
    """ASCII STL; readers calculate the normals."""
    lines = [f"solid {name}"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x:.6f} {y:.6f} {z:.6f}" for x, y, z in face]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, f"endsolid {name}", ""])


def dxf() -> str:
    """Boss and pocket as closed polylines whose corners are arcs (bulge tan(90 degrees / 4)), each on its layer."""
    rows: list[tuple[int, object]] = [(0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1015"), (9, "$INSUNITS")]
    rows += [(70, 4), (0, "ENDSEC"), (0, "SECTION"), (2, "TABLES"), (0, "TABLE"), (2, "LAYER"), (70, 2)]
    for layer in ("BOSS", "POCKET"):
        rows += [(0, "LAYER"), (100, "AcDbSymbolTableRecord"), (100, "AcDbLayerTableRecord")]
        rows += [(2, layer), (70, 0), (62, 7), (6, "CONTINUOUS")]
    rows += [(0, "ENDTAB"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES")]
    for layer, (width, height, radius) in (("BOSS", BOSS), ("POCKET", POCKET)):
        rows += [(0, "LWPOLYLINE"), (100, "AcDbEntity"), (8, layer), (100, "AcDbPolyline"), (90, 8), (70, 1)]
        for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
            cx, cy = CENTRE[0] + sx * (width / 2 - radius), CENTRE[1] + sy * (height / 2 - radius)
            for k in (0, 1):
                angle = math.pi / 2 * (quarter + k)
                rows += [(10, round(cx + radius * math.cos(angle), 9)), (20, round(cy + radius * math.sin(angle), 9))]
                rows += [(42, round(math.tan(math.pi / 8), 15))] if k == 0 else []
    rows += [(0, "ENDSEC"), (0, "EOF")]
    return "".join(f"{code}\n{value}\n" for code, value in rows)


def main() -> None:
    """Writes the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path(__file__).parent)
    folder: Path = parser.parse_args().folder
    (folder / "plate.dxf").write_text(dxf(), encoding="ascii")
    (folder / "plate.stl").write_text(stl("plate", part()), encoding="ascii")
    (folder / "clamp.stl").write_text(stl("clamp", box((0.0, 0.0, 0.0), (16.0, 12.0, 18.0))), encoding="ascii")


if __name__ == "__main__":
    main()
