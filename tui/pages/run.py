"""Run: where values, program and path stand at each size and in each view (ui-guide section 2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import TYPE_CHECKING

from textual.geometry import Region
from textual.strip import Strip

from tui.pages.base import Page
from tui.plot import PathPicture
from tui.program import ProgramView
from tui.rows import Row, beside
from tui.values import WIDE, Shown, compact_rows, short_row, wide_rows
from tui.widgets import Body

if TYPE_CHECKING:
    from tui.app import Terminal

VIEWS = ("both", "path", "values")
#: From this size of the whole screen on, values stand beside the path, not above it.
WIDE_COLUMNS, WIDE_ROWS = 110, 32
#: Width of the program at 80 columns.
NARROW = 37
NOWHERE = Region(0, 0, 0, 0)


class RunPage(Page):
    """Values, program and path."""

    name = "run"

    def __init__(self, app: Terminal) -> None:
        super().__init__(app)
        self.view = VIEWS[0]
        self.areas = Areas()
        self._frames = 0
        self._values: tuple[object, list[Strip]] = (None, [])

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """It fills the screen at every size."""
        parts = Parts(shown, self.app.picture, self.app.program)
        rows, self.areas = run_page(parts, self._numbers(shown, width, height), self.view, width, height)
        return rows

    def _numbers(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """Numbers change at most at 5 Hz: faster nobody reads them; a change of state shows at once."""
        s = shown.snapshot
        self._frames += 1
        key = (s.state, s.override_set, len(s.axes), shown.job, self.view, width, height, bool(shown.stale_s))
        if self._values[0] != key or self._frames % 2 or not self.app.paced:
            self._values = (key, value_rows(shown, self.view, width, height))
        return self._values[1]

    def leave(self) -> None:
        """Nothing is drawn that the mouse could meet."""
        self.areas = Areas()

    def scroll(self, by: int) -> None:
        """Moves the cursor in the program."""
        self.app.program.move(by, self.app.engine.snapshot().line)

    def key_view(self) -> None:
        """The next view."""
        self.view = VIEWS[(VIEWS.index(self.view) + 1) % len(VIEWS)]

    def key_fit(self) -> None:
        """The whole path."""
        self.app.picture.fit_all()

    def key_plane(self) -> None:
        """The path from another side."""
        self.app.picture.next_plane()

    def key_seek(self, seconds: int) -> None:
        """Winds a recording."""
        self.app.operation.seek(f"{seconds:+d}")

    def key_zoom(self, steps: int) -> None:
        """Nearer or farther."""
        self.app.picture.zoom(steps)

    def key_pan(self, x: int, y: int) -> None:
        """Moves the window on the path by a quarter."""
        area = self.areas.picture
        self.app.picture.pan(x * area.width // 4, y * area.height // 4)

    def key_current(self) -> None:
        """Back to the current block."""
        self.app.program.choose(0)

    def clicked(self, event: Body.Clicked) -> None:
        """A click chooses a block, in the program or by its path."""
        program, picture = self.areas.program, self.areas.picture
        if program.contains(event.x, event.y):
            line = self.app.program.line_at(event.y - program.y)
        elif picture.contains(event.x, event.y):
            line = self.app.picture.line_at(event.x - picture.x, event.y - picture.y)
        else:
            line = None
        if line is not None:
            self.app.program.choose(line)

    def wheel(self, event: Body.Wheel) -> None:
        """The wheel zooms the path and scrolls the program."""
        if self.areas.picture.contains(event.x, event.y):
            self.key_zoom(-event.by)
        else:
            super().wheel(event)

    def dragged(self, event: Body.Dragged) -> None:
        """Dragging moves the window on the path."""
        if self.areas.picture.contains(event.x, event.y):
            self.app.picture.pan(-event.dx, event.dy)


@dataclass(frozen=True, slots=True)
class Areas:
    """Where the mouse meets the program and the picture; zero-sized where one is not shown."""

    program: Region = NOWHERE
    picture: Region = NOWHERE


@dataclass(frozen=True, slots=True)
class Parts:
    """What a page is put together from."""

    shown: Shown
    picture: PathPicture
    program: ProgramView

    def path(self, width: int, height: int) -> list[Strip]:
        """Head, picture, legend."""
        words, snapshot, job = self.shown.words, self.shown.snapshot, self.shown.job
        at = {axis.name: axis.actual for axis in snapshot.axes}
        tool = None
        if job is not None and at:
            x, y, z = (at.get(name, 0.0) for name in job.plot.axes)
            tool = (x, y, z)
        rows = self.picture.rows(width, height - 2, tool, self.program.chosen)
        return [self.picture.head(width, words), *rows, self.picture.legend(width, words)]

    def lines(self, width: int, height: int) -> list[Strip]:
        """The part program; without one, how to get one."""
        if self.shown.job is None:
            style = self.shown.look.text
            texts = wrap(self.shown.words("no_job"), width - 2)
            return [Row(style).add(f" {text}").strip(width) for text in [*texts, *[""] * (height - len(texts))]]
        return self.program.rows(width, height, self.shown.snapshot.line, self.picture.over)

    def rule(self, width: int, label: str = "") -> Strip:
        """A horizontal line, with a word near its end."""
        look = self.shown.look
        row = Row(look.dim).add(look.rule() * (width - len(label) - 3 if label else width))
        return row.add(f" {label} ", look.text).add(look.rule()).strip(width) if label else row.strip(width)

    def bar(self, height: int) -> list[Strip]:
        """A vertical line."""
        return [Row(self.shown.look.dim).add(self.shown.look.rule(vertical=True)).strip(1)] * height


def is_wide(columns: int, rows: int) -> bool:
    """Whether a screen has room for values beside the path."""
    return columns >= WIDE_COLUMNS and rows >= WIDE_ROWS


def run_page(parts: Parts, values: Sequence[Strip], view: str, width: int, height: int) -> tuple[list[Strip], Areas]:
    """The rows of the page. `values`: what `value_rows` gave for this view and size."""
    if view == "path":
        return [*values, *parts.path(width, height - 1)], Areas(picture=Region(0, 2, width, height - 3))
    if view == "values" or not is_wide(width, height + 3):
        return _stacked(parts, values, view, width, height)
    top = len(values) + 1
    left = [*values, parts.rule(WIDE), *parts.lines(WIDE, height - top)]
    room = width - WIDE - 1
    rows = [beside(*row) for row in zip(left, parts.bar(height), parts.path(room, height), strict=True)]
    return rows, Areas(Region(0, top, WIDE, height - top), Region(WIDE + 1, 1, room, height - 2))


def _stacked(parts: Parts, values: Sequence[Strip], view: str, width: int, height: int) -> tuple[list[Strip], Areas]:
    top = len(values) + 1
    below = height - top
    if view == "values":
        rows = [*values, parts.rule(width), *parts.lines(width, below)]
        return rows, Areas(program=Region(0, top, width, below))
    # the plane stands in the rule: the picture has no head line here
    head = [*values, parts.rule(width, parts.picture.plane if parts.shown.job else "")]
    room = width - NARROW - 1
    picture = parts.path(room, below + 1)[1:]  # no head line: it would cost a row
    columns = zip(parts.lines(NARROW, below), parts.bar(below), picture, strict=True)
    rows = [*head, *(beside(*row) for row in columns)]
    return rows, Areas(Region(0, top, NARROW, below), Region(NARROW + 1, top, room, below - 1))


def value_rows(shown: Shown, view: str, width: int, height: int) -> list[Strip]:
    """Positions and progress as the view wants them."""
    if view == "path":
        return [short_row(shown, width)]
    if view == "values":
        return [strip.adjust_cell_length(width, shown.look.text) for strip in wide_rows(shown)]
    return wide_rows(shown) if is_wide(width, height + 3) else compact_rows(shown, width)
