"""Polar pictures of full circles, as a ballbar draws them. OpenCV is loaded only when drawing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toolpaths.raster import BACKGROUND, GOOD, GRID, SHIFT, TEXT, TODO, Image

Vector = NDArray[np.float64]
#: Share of the picture that the nominal radius takes, and that the largest deviation takes beside it.
RADIUS, ROOM = 0.3, 0.13


def polar_picture(angle: Vector, low_um: Vector, high_um: Vector, size: int = 900) -> Image:
    """Smallest and largest radius beyond the nominal one by angle (rad, counter-clockwise from the right); the scale of
    the deviation is printed as the distance of the dashed rings."""
    import cv2

    image: Image = np.full((size, size, 3), BACKGROUND, np.uint8)
    middle, radius = size / 2, RADIUS * size
    most = max(float(np.abs(low_um).max(initial=0.0)), float(np.abs(high_um).max(initial=0.0)), 1e-6)
    scale = ROOM * size / most
    step = ring_step(most)
    cv2.line(image, (0, size // 2), (size, size // 2), GRID, 1)
    cv2.line(image, (size // 2, 0), (size // 2, size), GRID, 1)
    for um, colour in ((-step, GRID), (0.0, TODO), (step, GRID)):
        cv2.circle(image, (size // 2, size // 2), round(radius + um * scale), colour, 1, cv2.LINE_AA)
    for band in (low_um, high_um):
        along = radius + band * scale
        points = np.column_stack([middle + along * np.cos(angle), middle - along * np.sin(angle)])
        pixels = np.round(points * (1 << SHIFT)).astype(np.int32)
        for piece in np.split(pixels, np.nonzero(np.diff(angle) > 0.05)[0] + 1):
            cv2.polylines(image, [piece], False, GOOD, 2, cv2.LINE_AA, SHIFT)
    text = f"rings +-{step:g} um, largest {most:.3g} um"
    cv2.putText(image, text, (16, size - 20), cv2.FONT_HERSHEY_SIMPLEX, 0.6, TEXT, 1, cv2.LINE_AA)
    return image


def ring_step(most: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above a positive value."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(m * power for m in (1, 2, 5) if m * power <= most * (1 + 1e-12)))
