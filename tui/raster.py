"""Draws polylines into a bitmap of cell parts and turns it into characters. NumPy only, no Python loop over points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Bitmap = NDArray[np.uint8]
Floats = NDArray[np.float64]

#: Parts per cell: (across, down).
PARTS = {"quadrant": (2, 2), "braille": (2, 4), "half": (1, 2), "ascii": (1, 1)}

#: Bit of each part, row by row, and the character of each sum of bits.
_QUADRANTS = " ▘▝▀▖▌▞▛▗▚▐▜▄▙▟█"
_BRAILLE_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]], np.uint8)
_CHARS: dict[str, tuple[NDArray[np.uint8], str]] = {
    "quadrant": (np.array([[1, 2], [4, 8]], np.uint8), _QUADRANTS),
    "half": (np.array([[1], [2]], np.uint8), " ▀▄█"),
    "braille": (_BRAILLE_BITS, " " + "".join(chr(0x2800 + bits) for bits in range(1, 256))),
}


@dataclass(frozen=True, slots=True)
class Window:
    """Which part of the plane is on screen: its middle, and millimetres per column. A cell is 1:2, mm stay square."""

    x_mm: float
    y_mm: float
    mm_per_column: float
    columns: int
    rows: int
    glyphs: str = "ascii"

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the bitmap."""
        across, down = PARTS[self.glyphs]
        return self.rows * down, self.columns * across

    def pixels(self, points: Floats) -> Floats:
        """Bitmap coordinates (x right, y down) of points (n, 2) in mm."""
        across, down = PARTS[self.glyphs]
        height, width = self.shape
        x = (points[:, 0] - self.x_mm) * (across / self.mm_per_column) + width / 2
        y = (self.y_mm - points[:, 1]) * (down / (2 * self.mm_per_column)) + height / 2
        return np.column_stack((x, y))

    def millimetres(self, column: float, row: float) -> tuple[float, float]:
        """The place under the middle of a cell."""
        return (
            self.x_mm + (column + 0.5 - self.columns / 2) * self.mm_per_column,
            self.y_mm - (row + 0.5 - self.rows / 2) * 2 * self.mm_per_column,
        )


def fit(points: Floats, columns: int, rows: int, glyphs: str) -> Window:
    """The window that shows all points with a narrow margin."""
    if not len(points):
        return Window(0.0, 0.0, 1.0, columns, rows, glyphs)
    low = np.array([column.min() for column in points.T])
    high = np.array([column.max() for column in points.T])
    middle, size = (low + high) / 2, high - low
    scale = max(float(size[0]) / max(columns - 2, 1), float(size[1]) / max(2 * (rows - 1), 1), 1e-6)
    return Window(float(middle[0]), float(middle[1]), scale, columns, rows, glyphs)


def _clip(start: Floats, step: Floats, width: float, height: float) -> tuple[Floats, Floats]:
    """Liang-Barsky: from which to which share of its length each segment lies in the bitmap (from > to: nowhere)."""
    enters, leaves = np.zeros(len(start)), np.ones(len(start))
    for axis, size in ((0, width), (1, height)):
        moves = np.abs(step[:, axis]) > 1e-12
        safe = np.where(moves, step[:, axis], 1.0)
        a, b = -start[:, axis] / safe, (size - start[:, axis]) / safe
        outside = ~moves & ((start[:, axis] < 0) | (start[:, axis] >= size))
        enters = np.where(moves, np.maximum(enters, np.minimum(a, b)), np.where(outside, 2.0, enters))
        leaves = np.where(moves, np.minimum(leaves, np.maximum(a, b)), leaves)
    return enters, leaves


def draw(bitmap: Bitmap, pixels: Floats, first: int, last: int, classes: NDArray[np.uint8]) -> None:
    """Draws the segments that end at points first..last-1, each with the class of its end; the highest class wins."""
    first = max(first, 1)
    if last > first:
        start = pixels[first - 1 : last - 1]
        draw_pieces(bitmap, start, pixels[first:last] - start, classes[first:last])


def draw_pieces(bitmap: Bitmap, start: Floats, step: Floats, classes: NDArray[np.uint8]) -> None:
    """Draws straight pieces (n, 2) from `start` over `step`, each with its class; the highest class wins."""
    longest = np.maximum(np.abs(step[:, 0]), np.abs(step[:, 1]))
    short = longest < 1
    wanted = classes[short]
    # of a piece within two pixels its ends are enough; a long program is made of these
    _put(bitmap, start[short], wanted)
    _put(bitmap, start[short] + step[short], wanted)
    rest = ~short & (classes > 0)
    if rest.any():
        _draw_long(bitmap, start[rest], step[rest], classes[rest])


def _draw_long(bitmap: Bitmap, start: Floats, step: Floats, classes: NDArray[np.uint8]) -> None:
    height, width = bitmap.shape
    enters, leaves = _clip(start, step, width, height)
    seen = enters <= leaves
    start, step, enters, leaves, wanted = start[seen], step[seen], enters[seen], leaves[seen], classes[seen]
    if not len(start):
        return
    counts = np.ceil(np.abs(step).max(axis=1) * (leaves - enters)).astype(np.int64) + 1
    owner = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = enters[owner] + (leaves - enters)[owner] * (number / np.maximum(counts - 1, 1)[owner])
    _put(bitmap, start[owner] + step[owner] * share[:, None], wanted[owner])


def _put(bitmap: Bitmap, places: Floats, classes: NDArray[np.uint8]) -> None:
    """Single pixels; those outside, and class 0, are left out."""
    height, width = bitmap.shape
    x, y = places[:, 0], places[:, 1]
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    flat = y[inside].astype(np.int64) * width + x[inside].astype(np.int64)
    shade, view = classes[inside], bitmap.reshape(-1)
    for level in range(1, int(shade.max(initial=0)) + 1):
        spots = flat[shade == level]
        view[spots] = np.maximum(view[spots], level)


def cells(bitmap: Bitmap, glyphs: str, letters: str) -> tuple[list[str], Bitmap]:
    """One string per row of cells, and the class of each cell. `letters[class]` is the ASCII character of a class."""
    across, down = PARTS[glyphs]
    height, width = bitmap.shape
    blocks = bitmap.reshape(height // down, down, width // across, across)
    classes: Bitmap = blocks.max(axis=(1, 3))
    if glyphs == "ascii":
        table = np.array(list(letters))
        codes = table[np.minimum(classes, len(letters) - 1)]
    else:
        bits, characters = _CHARS[glyphs]
        sums = ((blocks > 0) * bits[None, :, None, :]).sum(axis=(1, 3))
        codes = np.array(list(characters))[sums]
    return ["".join(row) for row in codes], classes
