"""Pictures of a path, coloured by its deviation (palette of ui-guide section 5). OpenCV is loaded only when drawing."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
Points = NDArray[np.float64]

#: Blue, green, red: background, not driven, good, warning, bad, text, grid.
BACKGROUND, TODO, GOOD, WARN, BAD, TEXT, GRID = (
    (31, 29, 27),
    (147, 135, 122),
    (233, 180, 86),
    (66, 228, 240),
    (19, 106, 255),
    (208, 208, 208),
    (48, 45, 42),
)
#: Colour and thickness of the grades of `grades`; worse is thicker, so that no fact is carried by colour alone.
PENS = ((TODO, 1), (GOOD, 2), (WARN, 3), (BAD, 4))
#: Sub-pixel bits of OpenCV's drawing.
SHIFT = 4
#: Pixels kept free: left, right, top, bottom.
LEFT, RIGHT, TOP, BOTTOM = 96, 40, 40, 100
#: A magnified deviation is drawn as large as this share of the picture.
MAGNIFIED_SHARE = 0.03


@dataclass(frozen=True, slots=True)
class Frame:
    """Where millimetres lie in the picture: one scale for both axes."""

    scale: float
    centre_mm: tuple[float, float]
    centre: tuple[float, float]

    @classmethod
    def around(cls, points: Points, width: int, height: int) -> Frame:
        """The largest scale at which all points fit."""
        room = np.array([width - LEFT - RIGHT, height - TOP - BOTTOM], dtype=np.float64)
        low, high = points.min(axis=0), points.max(axis=0)
        span = np.maximum(high - low, 1e-6)
        middle = (low + high) / 2
        centre = (LEFT + room[0] / 2, TOP + room[1] / 2)
        return cls(float((room / span).min()), (float(middle[0]), float(middle[1])), centre)

    def pixels(self, points: Points) -> Points:
        """Millimetres to pixels; up is up."""
        off = (np.asarray(points, dtype=np.float64) - self.centre_mm) * self.scale
        return np.column_stack([self.centre[0] + off[:, 0], self.centre[1] - off[:, 1]])


def grades(deviation_um: NDArray[Any], limit_um: float) -> NDArray[np.int8]:
    """0 not driven, 1 up to half of the limit, 2 up to the limit, 3 above, per vertex."""
    with np.errstate(invalid="ignore"):
        grade = np.where(deviation_um <= limit_um / 2, 1, np.where(deviation_um <= limit_um, 2, 3))
    return np.where(np.isnan(deviation_um), 0, grade).astype(np.int8)


def path_picture(
    points: Points,
    rapid: NDArray[np.bool_],
    deviation_um: NDArray[Any],
    limit_um: float,
    size: tuple[int, int] = (1600, 1000),
    *,
    axes: tuple[str, str] = ("X", "Y"),
    signed_um: NDArray[Any] | None = None,
    magnify: float | None = None,
    shown: NDArray[np.bool_] | None = None,
) -> Image:
    """The path (n, 2) in mm as an image (height, width, 3); a millimetre is as long across as up.

    Each piece has the colour of the deviation at its end; rapids are thin. With `signed_um` (+ = left of the
    direction of motion) the programmed path is thin too, and the driven one is drawn beside it, its deviation
    `magnify` times as large (default: what can just be seen well); the factor is printed. `shown` is False at the
    vertices that no piece of the path leads to, as in a polyline of which blocks were left out.
    """
    width, height = size
    image: Image = np.full((height, width, 3), BACKGROUND, np.uint8)
    if len(points) == 0:
        return image
    frame = Frame.around(points, width, height)
    draw_ruler(image, frame, axes)
    there = np.ones(len(points), bool) if shown is None else shown
    drawn, factor = points, 0.0
    if signed_um is not None:
        factor = magnify or magnification(signed_um, min(width, height) * MAGNIFIED_SHARE / frame.scale)
        drawn = magnified(points, np.asarray(signed_um, dtype=np.float64) * 1e-3, factor)
        draw_pieces(image, frame, points, there, TODO, 1)
    draw_pieces(image, frame, points, rapid & there, TODO, 1)
    grade = grades(deviation_um, limit_um)
    for value, (colour, thickness) in enumerate(PENS):
        draw_pieces(image, frame, drawn, (grade == value) & ~rapid & there, colour, thickness)
    draw_scale_bar(image, frame.scale)
    _legend(image, limit_um, factor)
    return image


def magnification(signed_um: NDArray[Any], largest_mm: float) -> float:
    """A round factor (1, 2, 5, 10 ...) at which the largest deviation is drawn at most `largest_mm` long."""
    finite = np.abs(signed_um[np.isfinite(signed_um)])
    worst_mm = float(finite.max()) * 1e-3 if finite.size else 0.0
    return max(_round_down(largest_mm / worst_mm), 1.0) if worst_mm > 0 else 1.0


def magnified(points: Points, signed_mm: Points, factor: float) -> Points:
    """The path moved to its left by `factor` times the signed deviation of each vertex; NaN counts as none."""
    along = np.diff(points, axis=0, prepend=points[:1])
    if len(points) > 1:
        along[0] = along[1]
    length = np.hypot(along[:, 0], along[:, 1])
    left = np.column_stack([-along[:, 1], along[:, 0]]) / np.where(length > 0, length, 1.0)[:, None]
    return points + left * (np.nan_to_num(signed_mm) * factor)[:, None]


def draw_pieces(
    image: Image, frame: Frame, points: Points, chosen: NDArray[np.bool_], colour: tuple[int, int, int], thickness: int
) -> None:
    """The chosen pieces; piece k joins vertex k-1 and k."""
    import cv2

    pixels = np.round(frame.pixels(points) * 2**SHIFT).astype(np.int32)
    for piece in _pieces(pixels, chosen):
        cv2.polylines(image, [piece], False, colour, thickness, cv2.LINE_AA, SHIFT)


def _pieces(pixels: NDArray[np.int32], chosen: NDArray[np.bool_]) -> list[NDArray[np.int32]]:
    """Runs of consecutive chosen pieces, as polylines."""
    marked = np.concatenate([[False], chosen[1:], [False]])
    starts = np.flatnonzero(~marked[:-1] & marked[1:])
    ends = np.flatnonzero(marked[:-1] & ~marked[1:])
    return [pixels[a : b + 1] for a, b in zip(starts, ends, strict=True)]


def draw_ruler(image: Image, frame: Frame, axes: tuple[str, str]) -> None:
    """Grid lines at round millimetres, their values and the names of the axes."""
    import cv2

    height, width = image.shape[:2]
    step = _round_up(80 / frame.scale)
    right, base = width - RIGHT, height - BOTTOM
    for x in _marks(frame.centre_mm[0], (right - LEFT) / 2 / frame.scale, step):
        at = round(frame.centre[0] + (x - frame.centre_mm[0]) * frame.scale)
        cv2.line(image, (at, TOP), (at, base), GRID, 1)
        draw_text(image, f"{x:g}", (at, base + 20), centred=True)
    for y in _marks(frame.centre_mm[1], (base - TOP) / 2 / frame.scale, step):
        at = round(frame.centre[1] - (y - frame.centre_mm[1]) * frame.scale)
        cv2.line(image, (LEFT, at), (right, at), GRID, 1)
        draw_text(image, f"{y:g}", (8, at + 5))
    cv2.rectangle(image, (LEFT, TOP), (right, base), TODO, 1)
    draw_text(image, f"{axes[0]} mm", (right - 60, base + 40))
    draw_text(image, f"{axes[1]} mm", (8, TOP - 14))


def _marks(middle: float, half: float, step: float) -> list[float]:
    """Multiples of `step` within `half` of `middle`."""
    first, last = int(np.ceil((middle - half) / step)), int(np.floor((middle + half) / step))
    return [round(k * step, 9) for k in range(first, last + 1)]


def draw_scale_bar(image: Image, scale: float) -> None:
    """A round length in the lower left corner."""
    import cv2

    height, width = image.shape[:2]
    length = _round_down(width / 6 / scale)
    base = height - 20
    cv2.line(image, (LEFT, base), (LEFT + round(length * scale), base), TEXT, 2, cv2.LINE_AA)
    draw_text(image, f"{length:g} mm", (LEFT, base - 8))


def _legend(image: Image, limit_um: float, factor: float) -> None:
    """What the colours mean, and how much the deviation is magnified."""
    import cv2

    height, width = image.shape[:2]
    texts = ("rapid, to do", f"<= {limit_um / 2:g} um", f"<= {limit_um:g} um", f"> {limit_um:g} um")
    x, base = width - RIGHT - 4 * 150, height - 20
    for text, (colour, thickness) in zip(texts, PENS, strict=True):
        cv2.line(image, (x, base - 5), (x + 24, base - 5), colour, thickness, cv2.LINE_AA)
        draw_text(image, text, (x + 30, base))
        x += 150
    if factor:
        draw_text(image, f"deviation x {factor:g}", (width // 2 - 160, base))


def draw_text(image: Image, text: str, at: tuple[int, int], *, centred: bool = False) -> None:
    """Small text, its lower left corner (or middle) at a pixel."""
    import cv2

    size, _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.5, 1)
    left = at[0] - size[0] // 2 if centred else at[0]
    cv2.putText(image, text, (left, at[1]), cv2.FONT_HERSHEY_SIMPLEX, 0.5, TEXT, 1, cv2.LINE_AA)


def _round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(m * power for m in (1, 2, 5) if m * power <= value * (1 + 1e-12)))


def _round_up(value: float) -> float:
    """The smallest of 1, 2, 5, 10 times a power of ten that is not below a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(min(m * power for m in (1, 2, 5, 10) if m * power >= value * (1 - 1e-12)))


def write_png(path: Path, image: Image) -> None:
    """Writes an image; raises OSError."""
    import cv2

    done, data = cv2.imencode(".png", image)
    if not done:
        raise OSError(f"{path}: the picture cannot be encoded")
    path.write_bytes(data.tobytes())
