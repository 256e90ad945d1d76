"""Pictures of a cut height map, of its difference from the target, and of a driven path on a drawing (OpenCV)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toolpaths.drawing import Drawing
from toolpaths.material import Finding, Fixture, Grid, Heights
from toolpaths.raster import (
    BACKGROUND,
    BAD,
    GOOD,
    GRID,
    LEFT,
    RIGHT,
    TEXT,
    TODO,
    WARN,
    Frame,
    Image,
    Points,
    draw_pieces,
    draw_ruler,
    draw_scale_bar,
    draw_text,
    grades,
    magnification,
)

SIZE = (1600, 1000)
#: Beyond so many times the limit a colour is that of the worst class.
GROSS = 5.0
#: Lighter and darker than the palette, for classes within one colour.
DEEP_GOUGE, HIGH_REST, WITHIN = (0, 40, 170), (150, 250, 255), (150, 110, 60)
MARKS = 30


def height_picture(heights: Heights, grid: Grid, findings: list[Finding], fixtures: Sequence[Fixture] = ()) -> Image:
    """The stock after the cut, coloured by height; hulls of the fixtures, the places of the findings numbered."""
    import cv2

    hulls = [cv2.convexHull(f.triangles.reshape(-1, 3)[:, :2].astype(np.float32))[:, 0] for f in fixtures]
    image, frame = _page(grid, [hull.astype(np.float64) for hull in hulls])
    there = np.isfinite(heights)
    low, high = (float(heights[there].min()), float(heights[there].max())) if there.any() else (0.0, 1.0)
    span = max(high - low, 1e-9)
    scaled = np.where(there, (heights - low) / span * 255, 0).astype(np.uint8)
    colours = cv2.applyColorMap(scaled, cv2.COLORMAP_VIRIDIS)
    colours[~there] = BACKGROUND
    _put(image, frame, grid, np.ascontiguousarray(colours))
    for fixture, hull in zip(fixtures, hulls, strict=True):
        pixels = np.round(frame.pixels(hull.astype(np.float64)) * 16).astype(np.int32)
        cv2.polylines(image, [pixels], True, TEXT, 2, cv2.LINE_AA, 4)
        x, y = (frame.pixels(hull.astype(np.float64)).mean(axis=0)).round().astype(int).tolist()
        draw_text(image, fixture.name[:24], (x, y), centred=True)
    _marks(image, frame, findings)
    x, base = LEFT + 330, image.shape[0] - 30
    ramp = cv2.applyColorMap(np.tile(np.arange(256, dtype=np.uint8), (14, 1)), cv2.COLORMAP_VIRIDIS)
    image[base : base + 14, x : x + 256] = ramp
    draw_text(image, f"Z {low:.3f} mm", (x, base - 8))
    draw_text(image, f"{high:.3f} mm", (x + 190, base - 8))
    return image


def difference_picture(difference: Heights, grid: Grid, rest: dict[str, Any], gouge: dict[str, Any]) -> Image:
    """Rest and gouge against the target in classes; the largest of each is marked. `rest`, `gouge`: Compared.side."""
    image, frame = _page(grid)
    rest_mm, gouge_mm = rest["limit_mm"], gouge["limit_mm"]
    value = _pooled(difference, grid, frame)
    colours = np.full((*value.shape, 3), BACKGROUND, np.uint8)
    classes = (
        (np.isfinite(value), WITHIN, "within limits"),
        (value > rest_mm, WARN, f"rest > {rest_mm * 1e3:g} um"),
        (value > GROSS * rest_mm, HIGH_REST, f"rest > {GROSS * rest_mm * 1e3:g} um"),
        (value < -gouge_mm, BAD, f"gouge > {gouge_mm * 1e3:g} um"),
        (value < -GROSS * gouge_mm, DEEP_GOUGE, f"gouge > {GROSS * gouge_mm * 1e3:g} um"),
    )
    for chosen, colour, _ in classes:
        colours[chosen] = colour
    _put(image, frame, grid, colours)
    for side, letter in ((rest, "R"), (gouge, "G")):
        if side["place"] is not None and side["max_mm"] > side["limit_mm"]:
            place = (side["place"]["X"], side["place"]["Y"])
            _mark(image, frame, place, f"{letter} {side['max_mm'] * 1e3:.1f} um")
    _legend(image, [(colour, text) for _, colour, text in classes])
    return image


def reference_picture(
    drawing: Drawing, plot: dict[str, Points], limit_um: float, missing: list[dict[str, Any]], worst: Any
) -> Image:
    """The drawing (thin) and the driven path, coloured by its deviation, which is magnified; missing stretches."""
    import cv2

    width, height = SIZE
    image: Image = np.full((height, width, 3), BACKGROUND, np.uint8)
    lines = _outline(drawing)
    points = np.vstack([*lines, plot["foot"][:, :2]])
    frame = Frame.around(points, width, height)
    draw_ruler(image, frame, ("X", "Y"))
    for line in lines:
        _polyline(image, frame, line, TODO, 1)
    for stretch in missing:
        ends = frame.pixels(np.array([stretch["from"], stretch["to"]])).round().astype(int)
        for end in ends:
            cv2.drawMarker(image, tuple(map(int, end)), BAD, cv2.MARKER_TILTED_CROSS, 14, 2, cv2.LINE_AA)
    if len(plot["signed"]):
        um = np.abs(plot["signed"]) * 1e3
        factor = magnification(plot["signed"] * 1e3, min(width, height) * 0.03 / frame.scale)
        offset = _away(plot)
        drawn = plot["foot"][:, :2] + offset * (np.abs(plot["signed"]) * factor)[:, None]
        joined = np.concatenate([[False], np.diff(plot["sample"]) <= 4 * np.median(np.diff(plot["sample"], prepend=0))])
        grade = grades(um, limit_um)
        for value, colour, thickness in ((1, GOOD, 2), (2, WARN, 3), (3, BAD, 4)):
            draw_pieces(image, frame, drawn, (grade == value) & joined, colour, thickness)
        draw_text(image, f"deviation x {factor:g}", (width // 2 - 160, height - 20))
    if worst is not None:
        _mark(image, frame, (worst["nearest"]["X"], worst["nearest"]["Y"]), "max")
    draw_scale_bar(image, frame.scale)
    rows = [
        (TODO, "drawing"),
        (GOOD, f"<= {limit_um / 2:g} um"),
        (WARN, f"<= {limit_um:g} um"),
        (BAD, f"> {limit_um:g} um"),
    ]
    _legend(image, rows)
    return image


def _away(plot: dict[str, Points]) -> Points:
    """Unit vectors from the drawing towards the path, seen from above."""
    off = plot["at"][:, :2] - plot["foot"][:, :2]
    length = np.hypot(off[:, 0], off[:, 1])
    # with an offset the deviation is a small part of the distance; its sign tells the direction
    unit: Points = off / np.where(length > 0, length, 1.0)[:, None]
    return unit


def _outline(drawing: Drawing) -> list[Points]:
    """Pieces as short polylines."""
    if drawing.is_surface:
        corners = drawing.data.reshape(-1, 3, 3)[:, :, :2]
        return [np.vstack([corner, corner[:1]]) for corner in corners[:20_000]]
    count = np.where(drawing.kinds == 1, 49, 2)
    piece = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count)
    places = drawing.points(piece, number / (count[piece] - 1.0))[:, :2]
    return np.split(places, np.cumsum(count)[:-1])


def _polyline(image: Image, frame: Frame, points: Points, colour: tuple[int, int, int], thickness: int) -> None:
    import cv2

    pixels = np.round(frame.pixels(points) * 16).astype(np.int32)
    cv2.polylines(image, [pixels], False, colour, thickness, cv2.LINE_AA, 4)


def _page(grid: Grid, more: Sequence[Points] = ()) -> tuple[Image, Frame]:
    width, height = SIZE
    image: Image = np.full((height, width, 3), BACKGROUND, np.uint8)
    frame = Frame.around(np.vstack([_corners(grid), *more]), width, height)
    draw_ruler(image, frame, ("X", "Y"))
    draw_scale_bar(image, frame.scale)
    return image, frame


def _corners(grid: Grid) -> Points:
    return np.array(
        [[grid.x0, grid.y0], [grid.x0 + grid.nx * grid.step, grid.y0 + grid.ny * grid.step]], dtype=np.float64
    )


def _pooled(values: Heights, grid: Grid, frame: Frame) -> Heights:
    """Fewer nodes than pixels: of each group the value that is farthest from 0, so that no peak is lost."""
    every = max(1, int(np.floor(1.0 / (frame.scale * grid.step))))
    if every == 1:
        return values
    ny, nx = -(-values.shape[0] // every) * every, -(-values.shape[1] // every) * every
    wide = np.full((ny, nx), np.nan)
    wide[: values.shape[0], : values.shape[1]] = values
    groups = wide.reshape(ny // every, every, nx // every, every).swapaxes(1, 2).reshape(ny // every, nx // every, -1)
    size = np.where(np.isnan(groups), -1.0, np.abs(groups))
    chosen: Heights = np.take_along_axis(groups, size.argmax(axis=2)[..., None], axis=2)[..., 0]
    return chosen


def _put(image: Image, frame: Frame, grid: Grid, colours: NDArray[np.uint8]) -> None:
    """Draws a map into its place; up is up."""
    import cv2

    (left, bottom), (right, top) = frame.pixels(_corners(grid)).round().astype(int).tolist()
    width, height = max(right - left, 1), max(bottom - top, 1)
    shrinks = colours.shape[1] > width
    how = cv2.INTER_AREA if shrinks else cv2.INTER_NEAREST
    image[top : top + height, left : left + width] = cv2.resize(colours[::-1], (width, height), interpolation=how)


def _marks(image: Image, frame: Frame, findings: list[Finding]) -> None:
    """The largest findings by their numbers."""
    largest = sorted(range(len(findings)), key=lambda k: -findings[k].size)[:MARKS]
    for k in sorted(largest):
        _mark(image, frame, findings[k].place[:2], f"{k + 1}")


def _mark(image: Image, frame: Frame, place: tuple[float, float], text: str) -> None:
    import cv2

    x, y = frame.pixels(np.array([place]))[0].round().astype(int).tolist()
    x, y = min(max(x, 12), image.shape[1] - 12), min(max(y, 12), image.shape[0] - 12)
    for colour, thickness in (((0, 0, 0), 5), (BAD, 2)):
        cv2.circle(image, (x, y), 10, colour, thickness, cv2.LINE_AA)
        cv2.line(image, (x - 14, y), (x + 14, y), colour, thickness, cv2.LINE_AA)
        cv2.line(image, (x, y - 14), (x, y + 14), colour, thickness, cv2.LINE_AA)
    size, _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.5, 1)
    left = min(x + 16, image.shape[1] - size[0] - 6)
    cv2.rectangle(image, (left - 3, y - 24), (left + size[0] + 4, y - 2), BACKGROUND, -1)
    draw_text(image, text, (left, y - 8))


def _legend(image: Image, rows: list[tuple[tuple[int, int, int], str]]) -> None:
    import cv2

    width = 150 if len(rows) < 5 else 165
    x, base = image.shape[1] - RIGHT - len(rows) * width, image.shape[0] - 20
    for colour, text in rows:
        cv2.rectangle(image, (x, base - 12), (x + 22, base + 2), colour, -1)
        cv2.rectangle(image, (x, base - 12), (x + 22, base + 2), GRID, 1)
        draw_text(image, text, (x + 28, base))
        x += width
