"""The path as characters: NumPy rasterises into classes of sub-cells, cells become glyphs. Millimetres stay square."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: Classes of a sub-cell, in rising order of attention.
EMPTY, TODO, GOOD, WARN, BAD = range(5)
CLASS_STYLES = ("text", "todo", "good", "warn", "bad")
ASCII = " .-*#"
#: Sub-cells of a cell across and down.
GLYPH_SETS = {"ascii": (1, 1), "half": (1, 2), "quadrant": (2, 2), "braille": (2, 4)}
_QUADRANTS = " ▘▝▀▖▌▞▛▗▚▐▜▄▙▟█"
_BRAILLE_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))


@dataclass(slots=True)
class View:
    """What part of the plane is shown: centre in mm and mm per column."""

    x: float = 0.0
    y: float = 0.0
    mm_per_column: float = 1.0


class Raster:
    """A path of n vertices drawn into `columns` x `rows` cells."""

    def __init__(self, points: NDArray[np.float64], rapid: NDArray[np.bool_], glyphs: str = "quadrant") -> None:
        """`points` (n, 2) in mm."""
        self.points = points
        self.rapid = rapid
        self.glyphs = glyphs
        self.classes = np.full(len(points), TODO, np.int8)
        self.view = View()
        self.columns = self.rows = 0
        self._bitmap = np.zeros((0, 0), np.int8)

    def resize(self, columns: int, rows: int) -> None:
        """New size in cells; the view stays."""
        self.columns, self.rows = columns, rows
        self.redraw()

    def fit(self) -> None:
        """The whole path with a margin of two columns."""
        if len(self.points) == 0:
            return
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        width = max(1, self.columns - 4)
        height = max(1, self.rows - 2) * 2  # a cell is twice as high as wide
        scale = max((high[0] - low[0]) / width, (high[1] - low[1]) / height, 1e-6)
        x, y = ((low + high) / 2).tolist()
        self.view = View(x, y, scale)
        self.redraw()

    def zoom(self, factor: float) -> None:
        """Closer (factor above 1) or further away about the centre."""
        self.view.mm_per_column = min(max(self.view.mm_per_column / factor, 1e-6), 1e6)
        self.redraw()

    def pan(self, columns: int, rows: int) -> None:
        """Shifts the picture by cells."""
        self.view.x -= columns * self.view.mm_per_column
        self.view.y += rows * 2 * self.view.mm_per_column
        self.redraw()

    def redraw(self) -> None:
        """Draws everything anew."""
        across, down = GLYPH_SETS[self.glyphs]
        self._bitmap = np.zeros((self.rows * down, self.columns * across), np.int8)
        if len(self.points) > 1 and self.columns and self.rows:
            self._draw(1, len(self.points))

    def drive(self, first: int, grades: NDArray[np.int8]) -> None:
        """Vertices from `first` on were driven with these classes; only they are drawn."""
        last = min(first + len(grades), len(self.points))
        if last <= first:
            return
        self.classes[first:last] = grades[: last - first]
        if self._bitmap.size:
            self._draw(max(1, first), last)

    def reset(self) -> None:
        """Nothing is driven yet."""
        self.classes[:] = TODO
        self.redraw()

    def cell_of(self, x: float, y: float) -> tuple[int, int] | None:
        """Column and row of a point, None outside."""
        column = round((x - self.view.x) / self.view.mm_per_column + self.columns / 2 - 0.5)
        row = round((self.view.y - y) / (2 * self.view.mm_per_column) + self.rows / 2 - 0.5)
        return (column, row) if 0 <= column < self.columns and 0 <= row < self.rows else None

    def _draw(self, first: int, last: int) -> None:
        """Pieces first-1..first up to last-2..last-1, clipped to a margin of one picture around the view."""
        across, down = GLYPH_SETS[self.glyphs]
        height, width = self._bitmap.shape
        scale = np.array([across / self.view.mm_per_column, -down / (2 * self.view.mm_per_column)])
        centre = np.array([self.view.x, self.view.y])
        at = (self.points[first - 1 : last] - centre) * scale + np.array([width, height]) / 2
        a, b = at[:-1], at[1:]
        keep = np.all((np.maximum(a, b) >= 0) & (np.minimum(a, b) < [width, height]), axis=1)
        a, b, classes = a[keep], b[keep], self.classes[first:last][keep]
        if len(a) == 0:
            return
        delta = np.clip(b - a, -4 * (width + height), 4 * (width + height))
        steps = np.ceil(np.abs(delta).max(axis=1)).astype(np.int64) + 1
        which = np.repeat(np.arange(len(a)), steps)
        part = (np.arange(len(which)) - np.repeat(np.cumsum(steps) - steps, steps)) / np.repeat(
            np.maximum(steps - 1, 1), steps
        )
        cells = np.floor(a[which] + delta[which] * part[:, None]).astype(np.int64)
        inside = np.all((cells >= 0) & (cells < [width, height]), axis=1)
        np.maximum.at(self._bitmap, (cells[inside, 1], cells[inside, 0]), classes[which[inside]])

    def lines(self) -> list[list[tuple[str, str]]]:
        """All rows as runs of (text, style name)."""
        if not self._bitmap.size:
            return []
        across, down = GLYPH_SETS[self.glyphs]
        blocks = self._bitmap.reshape(self.rows, down, self.columns, across)
        worst = blocks.max(axis=(1, 3))
        texts = self._texts(blocks, worst)
        return [_runs(text, row) for text, row in zip(texts, worst, strict=True)]

    def _texts(self, blocks: NDArray[np.int8], worst: NDArray[np.int8]) -> list[str]:
        if self.glyphs == "ascii":
            return ["".join(ASCII[c] for c in row) for row in worst.tolist()]
        on = blocks > 0
        if self.glyphs == "half":
            codes = on[:, 0, :, 0] + 2 * on[:, 1, :, 0]
            return ["".join(" ▀▄█"[c] for c in row) for row in codes.tolist()]
        if self.glyphs == "quadrant":
            codes = on[:, 0, :, 0] + 2 * on[:, 0, :, 1] + 4 * on[:, 1, :, 0] + 8 * on[:, 1, :, 1]
            return ["".join(_QUADRANTS[c] for c in row) for row in codes.tolist()]
        bits = sum(on[:, r, :, c] * _BRAILLE_BITS[r][c] for r in range(4) for c in range(2))
        return ["".join(chr(0x2800 + c) if c else " " for c in row) for row in np.asarray(bits).tolist()]


def _runs(text: str, classes: NDArray[np.int8]) -> list[tuple[str, str]]:
    cuts = np.flatnonzero(np.diff(classes)) + 1
    starts = [0, *cuts.tolist()]
    ends = [*cuts.tolist(), len(text)]
    return [(text[a:b], CLASS_STYLES[classes[a]]) for a, b in zip(starts, ends, strict=True) if b > a]


def grades(deviation_mm: NDArray[np.float32], tolerance_mm: float) -> NDArray[np.int8]:
    """Class per vertex: good up to half of the tolerance, warning up to it, bad above."""
    with np.errstate(invalid="ignore"):
        grade = np.where(deviation_mm <= tolerance_mm / 2, GOOD, np.where(deviation_mm <= tolerance_mm, WARN, BAD))
    return np.where(np.isnan(deviation_mm), TODO, grade).astype(np.int8)
