"""The picture of the path: done and to do, coloured by deviation, with the tool and the chosen block."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from rich.style import Style
from textual.strip import Strip

from cnc_front.engine import Job
from tui.look import Look
from tui.plane import Plane, planes_of
from tui.raster import Bitmap, Window, cells, draw, draw_pieces, fit
from tui.rows import Row
from tui.words import Words

#: Classes of a part of the path, rising: the worst one in a cell shows.
TODO, GOOD, WARN, BAD = 1, 2, 3, 4
LETTERS = " .-*#"
ZOOM = 1.5


class PathPicture:
    """Holds the bitmap of one job; draws anew only when the window changes, else only what was driven since."""

    def __init__(self, look: Look) -> None:
        self._look = look
        self._vertices = np.zeros((0, 3))
        self._points = np.zeros((0, 2))  # the vertices in the plane that is shown
        self._lines = np.zeros(0, np.uint32)
        self._drawn = np.zeros(0, bool)
        self._deviation = np.zeros(0, np.float32)
        self._classes = np.zeros(0, np.uint8)
        self._tolerance_mm = 0.05
        self._pixels = np.zeros((0, 2))
        self._bitmap: Bitmap = np.zeros((0, 0), np.uint8)
        self._window: Window | None = None
        self._fits = True
        self._planes: tuple[Plane, ...] = (Plane("XY", (1, 0, 0), (0, 1, 0)),)
        self._chosen_plane = ""  # by the operator; empty: the first one
        self._plane = self._planes[0]
        self._marked: tuple[object, Bitmap] = (None, self._bitmap)
        self.reached = 0
        #: deviation per source line, mm; only lines beyond the tolerance
        self.over: dict[int, float] = {}

    def take(self, job: Job) -> None:
        """Shows another job. Rapids are left out: they hide the part; unless there is nothing else."""
        plot = job.plot
        self._vertices, self._lines = plot.points, plot.lines
        self._drawn = ~plot.rapid if not plot.rapid.all() else np.ones(len(plot.rapid), bool)
        self._tolerance_mm = job.tolerance_mm
        self._planes = planes_of(plot, self._vertices[self._drawn])
        self._look_at(next((p for p in self._planes if p.name == self._chosen_plane), self._planes[0]))
        self._begin_again()

    @property
    def plane(self) -> str:
        """Name of the plane that is shown: its axes, or ISO."""
        return self._plane.name

    def next_plane(self) -> None:
        """Looks at the path from another side; the whole of it."""
        place = self._planes.index(self._plane)
        self._look_at(self._planes[(place + 1) % len(self._planes)])
        self._chosen_plane = self._plane.name

    def _look_at(self, plane: Plane) -> None:
        self._plane, self._points = plane, plane.project(self._vertices)
        self.fit_all()

    def _begin_again(self) -> None:
        self._deviation = np.full(len(self._points), np.nan, np.float32)
        self._classes = np.where(self._drawn, TODO, 0).astype(np.uint8)
        self.reached, self.over = 0, {}
        if self._window is not None:
            self._draw_all(self._window)

    def driven(self, reached: int, values: NDArray[np.float32]) -> None:
        """Takes what the engine measured from `self.reached` on; a smaller index means a new start."""
        if reached < self.reached:
            self._begin_again()
        first = self.reached
        count = min(len(values), len(self._points) - first)
        if count <= 0:
            return
        last = first + count
        self._deviation[first:last] = values[:count]
        self._classify(first, last)
        if self._window is not None:
            draw(self._bitmap, self._pixels, first, last, self._classes)
        self.reached = reached

    def _classify(self, first: int, last: int) -> None:
        value = self._deviation[first:last]
        shade = np.select([value <= self._tolerance_mm / 2, value <= self._tolerance_mm], [GOOD, WARN], BAD)
        shade = np.where(np.isnan(value), TODO, shade)
        self._classes[first:last] = np.where(self._drawn[first:last], shade, 0)
        beyond = np.flatnonzero(value > self._tolerance_mm)
        if len(beyond):
            lines, owner = np.unique(self._lines[first + beyond], return_inverse=True)
            worst = np.zeros(len(lines), np.float32)
            np.maximum.at(worst, owner, value[beyond])
            for line, most in zip(lines.tolist(), worst.tolist(), strict=True):
                self.over[line] = max(self.over.get(line, 0.0), most)

    # ---- the window

    def fit_all(self) -> None:
        """The whole path."""
        self._fits, self._window = True, None

    def zoom(self, steps: int) -> None:
        """Nearer (positive) or farther, about the middle."""
        if self._window is not None:
            self._change(replace(self._window, mm_per_column=self._window.mm_per_column / ZOOM**steps))

    def pan(self, columns: float, rows: float) -> None:
        """Moves the window by cells: to the right, up."""
        if self._window is not None:
            mm = self._window.mm_per_column
            place = (self._window.x_mm + columns * mm, self._window.y_mm + rows * 2 * mm)
            self._change(replace(self._window, x_mm=place[0], y_mm=place[1]))

    def _change(self, window: Window) -> None:
        self._fits = False
        self._draw_all(replace(window, mm_per_column=min(max(window.mm_per_column, 1e-5), 1e5)))

    def _draw_all(self, window: Window) -> None:
        self._window = window
        self._bitmap = np.zeros(window.shape, np.uint8)
        self._pixels = window.pixels(self._points)
        draw(self._bitmap, self._pixels, 0, len(self._pixels), self._classes)

    def _window_of(self, columns: int, rows: int) -> Window:
        window = self._window
        if window is None or (self._fits and (window.columns, window.rows) != (columns, rows)):
            window = fit(self._points[self._drawn], columns, rows, self._look.glyphs)
        elif (window.columns, window.rows) != (columns, rows):
            window = replace(window, columns=columns, rows=rows)
        if window is not self._window:
            self._draw_all(window)
        return window

    def line_at(self, column: int, row: int) -> int | None:
        """The source line whose path passes nearest to a cell, if one passes within two cells."""
        if self._window is None or not len(self._points):
            return None
        place = np.array(self._window.millimetres(column, row))
        away = np.abs(self._points - place) / (self._window.mm_per_column * np.array([1.0, 2.0]))
        distance = np.where(self._drawn, away.max(axis=1), np.inf)
        nearest = int(distance.argmin())
        return int(self._lines[nearest]) if distance[nearest] <= 2 else None

    # ---- rows

    def rows(self, columns: int, rows: int, tool: tuple[float, float, float] | None, chosen: int) -> list[Strip]:
        """The picture in so many rows; `tool`: where it is, along the axes of the plot; `chosen` is the source line to
        mark (0: none)."""
        window = self._window_of(columns, rows)
        texts, classes = cells(self._bitmap, window.glyphs, LETTERS)
        classes = classes.copy()
        if chosen:
            self._mark(classes, window, chosen)
        lines = [list(text) for text in texts]
        if tool is not None:
            self._put_tool(lines, classes, window, tool)
        look = self._look
        styles = [look.text, look.todo, look.good, look.warn, look.bad, look.inverse, look.tool]
        return [_coloured(line, row, styles, look.text, columns) for line, row in zip(lines, classes, strict=True)]

    def _mark(self, classes: Bitmap, window: Window, line: int) -> None:
        """Cells of the path of one source line become class 5 (inverse)."""
        if self._marked[0] != (line, window, self._plane):
            ends = np.flatnonzero((self._lines == line) & self._drawn)
            ends = ends[ends > 0]
            mask = np.zeros(window.shape, np.uint8)
            start = self._pixels[ends - 1]
            draw_pieces(mask, start, self._pixels[ends] - start, np.ones(len(ends), np.uint8))
            down, across = mask.shape[0] // window.rows, mask.shape[1] // window.columns
            hit = mask.reshape(window.rows, down, window.columns, across).max(axis=(1, 3))
            self._marked = ((line, window, self._plane), hit)
        classes[(self._marked[1] > 0) & (classes > 0)] = 5

    def _put_tool(
        self, lines: list[list[str]], classes: Bitmap, window: Window, tool: tuple[float, float, float]
    ) -> None:
        down, across = window.shape[0] // window.rows, window.shape[1] // window.columns
        x, y = window.pixels(self._plane.project(np.array([tool])))[0]
        column, row = int(x // across), int(y // down)
        if 0 <= column < window.columns and 0 <= row < window.rows:
            lines[row][column], classes[row, column] = "@", 6

    def head(self, width: int, words: Words) -> Strip:
        """The line above the picture: plane, scale, keys."""
        look, row = self._look, Row(self._look.dim)
        wide = width >= 60
        row.add(" " + words("plot_head" if wide else "plot_head_short", plane=self.plane))
        if wide:
            row.until(width, words("plot_keys"))
        return row.add("", look.dim).strip(width)

    def legend(self, width: int, words: Words) -> Strip:
        """What the classes mean; the glyph mode `ascii` tells them by character, the others by colour and word."""
        look, half, full = self._look, self._tolerance_mm * 500, self._tolerance_mm * 1000
        row = Row(look.dim)
        signs = LETTERS[1:] if look.is_plain else "■" * 4
        row.add(" ").add(signs[0], look.todo).add(f" {words('todo')} ")
        row.add(signs[1], look.good).add(f" <={half:g} ")
        row.add(signs[2], look.warn).add(f" <={full:g} ")
        row.add(signs[3], look.bad).add(f" >{full:g}um ")
        row.add("@", look.tool).add(f" {words('tool')}")
        if width >= 60 and self._window is not None:
            row.until(width, f"1 col = {self._window.mm_per_column:.3g} mm")
        return row.strip(width)


def _coloured(text: list[str], classes: Bitmap, styles: list[Style], blank: Style, width: int) -> Strip:
    """One row of cells as runs of equal class."""
    row = Row(blank)
    edges = [0, *(np.flatnonzero(np.diff(classes)) + 1).tolist(), len(text)]
    for begin, end in pairwise(edges):
        row.add("".join(text[begin:end]), styles[int(classes[begin])])
    return row.strip(width)
