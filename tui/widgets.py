"""Widgets of rows: they show what they are given and redraw only the cells that changed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rich.style import Style
from textual import events
from textual.binding import Binding
from textual.geometry import Region
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Input

from tui.rows import changed_span


class Rows(Widget):
    """A block of rows."""

    def __init__(self, blank: Style, id: str) -> None:
        super().__init__(id=id)
        self._blank = blank
        self._rows: Sequence[Strip] = ()

    def put(self, rows: Sequence[Strip]) -> None:
        """Shows other rows; only what differs is sent to the terminal."""
        old, self._rows = self._rows, rows
        if len(old) != len(rows):
            self.refresh()
            return
        spans = [(y, changed_span(a, b)) for y, (a, b) in enumerate(zip(old, rows, strict=True)) if a is not b]
        regions = [Region(span[0], y, span[1] - span[0], 1) for y, span in spans if span]
        if regions:
            self.refresh(*regions)

    def render_line(self, y: int) -> Strip:
        """One row."""
        width = self.size.width
        return (
            self._rows[y].adjust_cell_length(width, self._blank)
            if y < len(self._rows)
            else Strip.blank(width, self._blank)
        )

    @property
    def text(self) -> str:
        """What is shown, without colours."""
        return "\n".join(row.text.rstrip() for row in self._rows)


class PathField(Input):
    """A path to type; the arrows belong to the page below it."""

    BINDINGS: ClassVar = [
        Binding("up", "app.scroll(-1)", show=False),
        Binding("down", "app.scroll(1)", show=False),
        Binding("pageup", "app.scroll(-20)", show=False),
        Binding("pagedown", "app.scroll(20)", show=False),
    ]

    def __init__(self, placeholder: str, id: str) -> None:
        super().__init__(id=id, placeholder=placeholder, compact=True, select_on_focus=False)


class Body(Rows):
    """The part between header and message line. Click selects, wheel scrolls, drag pans; nothing moves an axis."""

    class Clicked(Message):
        """The operator pointed at a cell."""

        def __init__(self, x: int, y: int) -> None:
            super().__init__()
            self.x, self.y = x, y

    class Wheel(Message):
        """The operator turned the wheel over a cell: 1 towards them (down), -1 away."""

        def __init__(self, x: int, y: int, by: int) -> None:
            super().__init__()
            self.x, self.y, self.by = x, y, by

    class Dragged(Message):
        """The operator pulled what is shown by so many cells."""

        def __init__(self, x: int, y: int, dx: int, dy: int) -> None:
            super().__init__()
            self.x, self.y, self.dx, self.dy = x, y, dx, dy

    def on_click(self, event: events.Click) -> None:
        self.post_message(self.Clicked(int(event.x), int(event.y)))

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        self.post_message(self.Wheel(int(event.x), int(event.y), 1))

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        self.post_message(self.Wheel(int(event.x), int(event.y), -1))

    def on_mouse_move(self, event: events.MouseMove) -> None:
        if event.button == 1 and (event.delta_x or event.delta_y):
            self.post_message(self.Dragged(int(event.x), int(event.y), int(event.delta_x), int(event.delta_y)))
