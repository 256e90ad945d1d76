"""Pictures of a path, coloured by its deviation (palette of ui-guide section 5). OpenCV is loaded only here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Blue, green, red: background, not driven, good, warning, bad, text.
BACKGROUND, TODO, GOOD, WARN, BAD, TEXT = (
    (31, 29, 27),
    (147, 135, 122),
    (233, 180, 86),
    (66, 228, 240),
    (19, 106, 255),
    (208, 208, 208),
)
#: Sub-pixel bits of OpenCV's drawing.
SHIFT = 4
MARGIN = 60


def grades(deviation_um: NDArray[Any], limit_um: float) -> NDArray[np.int8]:
    """0 not driven, 1 up to half of the limit, 2 up to the limit, 3 above, per vertex."""
    with np.errstate(invalid="ignore"):
        grade = np.where(deviation_um <= limit_um / 2, 1, np.where(deviation_um <= limit_um, 2, 3))
    return np.where(np.isnan(deviation_um), 0, grade).astype(np.int8)


def path_picture(
    points: NDArray[np.float64],
    rapid: NDArray[np.bool_],
    deviation_um: NDArray[Any],
    limit_um: float,
    size: tuple[int, int] = (1600, 1000),
) -> NDArray[np.uint8]:
    """The path (n, 2) in mm as an image (height, width, 3); a millimetre is as long across as up.

    Each piece has the colour of the deviation at its end; rapids are thin. A scale bar gives the measure.
    """
    import cv2

    width, height = size
    image = np.full((height, width, 3), BACKGROUND, np.uint8)
    if len(points) == 0:
        return image
    pixels, scale = _to_pixels(points, width, height)
    grade = grades(deviation_um, limit_um)
    for value, colour, thickness in ((0, TODO, 1), (1, GOOD, 2), (2, WARN, 2), (3, BAD, 3)):
        for piece in _pieces(pixels, (grade == value) & ~rapid):
            cv2.polylines(image, [piece], False, colour, thickness, cv2.LINE_AA, SHIFT)
    for piece in _pieces(pixels, rapid):
        cv2.polylines(image, [piece], False, TODO, 1, cv2.LINE_AA, SHIFT)
    _scale_bar(image, scale)
    return image


def _to_pixels(points: NDArray[np.float64], width: int, height: int) -> tuple[NDArray[np.int32], float]:
    low, high = points.min(axis=0), points.max(axis=0)
    span = np.maximum(high - low, 1e-6)
    scale = float(min((width - 2 * MARGIN) / span[0], (height - 2 * MARGIN) / span[1]))
    centred = (points - (low + high) / 2) * scale
    flipped = np.column_stack([width / 2 + centred[:, 0], height / 2 - centred[:, 1]])
    return np.round(flipped * 2**SHIFT).astype(np.int32), scale


def _pieces(pixels: NDArray[np.int32], chosen: NDArray[np.bool_]) -> list[NDArray[np.int32]]:
    """Runs of consecutive chosen pieces; piece k joins vertex k-1 and k."""
    marked = np.concatenate([[False], chosen[1:], [False]])
    starts = np.flatnonzero(~marked[:-1] & marked[1:])
    ends = np.flatnonzero(marked[:-1] & ~marked[1:])
    return [pixels[a : b + 1] for a, b in zip(starts, ends, strict=True)]


def _scale_bar(image: NDArray[np.uint8], scale: float) -> None:
    import cv2

    height, width = image.shape[:2]
    room = width / 5 / scale
    length = max((m * 10.0**p for p in range(-4, 6) for m in (1, 2, 5) if m * 10.0**p <= room), default=1e-4)
    left, base = MARGIN, height - MARGIN // 2
    cv2.line(image, (left, base), (left + round(length * scale), base), TEXT, 2, cv2.LINE_AA)
    cv2.putText(image, f"{length:g} mm", (left, base - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.6, TEXT, 1, cv2.LINE_AA)


def write_png(path: Path, image: NDArray[np.uint8]) -> None:
    """Writes an image; raises OSError."""
    import cv2

    done, data = cv2.imencode(".png", image)
    if not done:
        raise OSError(f"{path}: the picture cannot be encoded")
    path.write_bytes(data.tobytes())
