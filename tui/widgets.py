"""Widgets show and ask; the application decides (style-examples 15)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rich.style import Style
from textual import events
from textual.geometry import Size
from textual.message import Message
from textual.reactive import reactive
from textual.strip import Strip
from textual.widget import Widget

from tui.looks import Line, strip
from tui.raster import CLASS_STYLES, Raster


class Lines(Widget):
    """Shows lines made by a function of the width; redraws only what changed."""

    def __init__(self, id: str, styles: dict[str, Style], ground: str = "text") -> None:
        super().__init__(id=id)
        self._looks = styles
        self._ground = ground
        self._shown: list[Line] = []
        self.source: Callable[[int], Sequence[Line]] = lambda width: []

    def update(self) -> None:
        """Asks for the lines again."""
        lines = list(self.source(self.size.width))
        if lines != self._shown:
            grows = len(lines) != len(self._shown)
            self._shown = lines
            self.refresh(layout=grows)

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """As many rows as there are lines."""
        return max(1, len(self._shown))

    def on_resize(self) -> None:
        """A new width may mean other lines."""
        self.update()

    def render_line(self, y: int) -> Strip:
        """One line."""
        line = self._shown[y] if y < len(self._shown) else []
        return strip(line, self.size.width, self._looks, self._ground)


class ProgramView(Widget):
    """The program with a cursor on the block that is driven; follows it unless the operator looks elsewhere."""

    cursor: reactive[int] = reactive(0)  # 1-based line, 0 = none
    top: reactive[int] = reactive(0)

    class Selected(Message):
        """The operator looks at a line."""

        def __init__(self, line: int) -> None:
            super().__init__()
            self.line = line

    def __init__(self, styles: dict[str, Style]) -> None:
        super().__init__(id="program")
        self._looks = styles
        self.lines: Sequence[str] = ()
        self.marks: dict[int, str] = {}
        self._following = True

    def show(self, lines: Sequence[str]) -> None:
        """Another program."""
        self.lines, self.marks = lines, {}
        self.top = self.cursor = 0
        self._following = True
        self.refresh()

    def mark(self, line: int, text: str) -> None:
        """A remark at the end of one line, e.g. its deviation; earlier ones are dropped."""
        if self.marks != {line: text}:
            self.marks = {line: text}
            self.refresh()

    def watch_cursor(self, line: int) -> None:
        """Pages rather than scrolls: a page flip is a fraction of the bytes."""
        height = max(1, self.size.height)
        if self._following and line and not self.top < line <= self.top + height:
            self.top = max(0, line - 1 - height // 4)
        self.refresh()

    def look(self, line: int) -> None:
        """Shows a line without following."""
        self._following = False
        self.top = max(0, min(line - 1 - self.size.height // 2, len(self.lines) - 1))

    def scroll(self, rows: int) -> None:
        """Looks through the program; following goes on at the next start."""
        self._following = False
        self.top = max(0, min(self.top + rows, len(self.lines) - 1))

    def follow(self) -> None:
        """Back to the block that is driven."""
        self._following = True
        self.watch_cursor(self.cursor)

    def on_mouse_scroll_down(self) -> None:
        """Wheel."""
        self.scroll(3)

    def on_mouse_scroll_up(self) -> None:
        """Wheel."""
        self.scroll(-3)

    def on_click(self, event: events.Click) -> None:
        """A click selects."""
        self.post_message(self.Selected(self.top + event.y + 1))

    def render_line(self, y: int) -> Strip:
        """One line of the program."""
        number = self.top + y + 1
        width = self.size.width
        if number > len(self.lines):
            return strip([], width, self._looks)
        current = number == self.cursor
        mark = self.marks.get(number, "")
        text = self.lines[number - 1].expandtabs(8).rstrip()[: max(0, width - 9 - len(mark))]
        sign = ">" if current else " "
        line: Line = [
            (f"{sign}{number:>6} ", "inverse" if current else "soft"),
            (text, "cursor" if current else "text"),
        ]
        if mark:
            line.append((" " + mark, "bad"))
        return strip(line, width, self._looks, "cursor" if current else "text")


class PathPlotView(Widget):
    """The path, coloured by deviation, with the tool."""

    def __init__(self, styles: dict[str, Style]) -> None:
        super().__init__(id="plot")
        self._looks = styles
        self.raster: Raster | None = None
        self.tool: tuple[float, float] | None = None
        self._rows: list[Line] = []
        self._drag: tuple[int, int] | None = None
        self.title: Line = []
        self.legend: Line = []

    def show(self, raster: Raster | None) -> None:
        """Another path, fitted."""
        self.raster = raster
        self._fit_size(self.size)
        if raster is not None:
            raster.fit()
        self.redraw()

    def _fit_size(self, size: Size) -> None:
        if self.raster is not None:
            self.raster.resize(size.width, max(0, size.height - 2))

    def on_resize(self, event: events.Resize) -> None:
        """A new size; the view stays where it was unless it was never set."""
        first = self.raster is not None and self.raster.columns == 0
        self._fit_size(event.size)
        if first and self.raster is not None:
            self.raster.fit()
        self.redraw()

    def redraw(self) -> None:
        """Takes over what the raster holds now."""
        self._rows = self.raster.lines() if self.raster is not None else []
        self.refresh()

    def on_mouse_scroll_down(self) -> None:
        """Wheel: further away."""
        self._change(lambda raster: raster.zoom(1 / 1.25))

    def on_mouse_scroll_up(self) -> None:
        """Wheel: closer."""
        self._change(lambda raster: raster.zoom(1.25))

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Begins to drag."""
        self._drag = (event.x, event.y)
        self.capture_mouse()

    def on_mouse_up(self) -> None:
        """Ends to drag."""
        self._drag = None
        self.release_mouse()

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Drag pans."""
        if self._drag is not None:
            dx, dy = event.x - self._drag[0], event.y - self._drag[1]
            self._drag = (event.x, event.y)
            self._change(lambda raster: raster.pan(dx, dy))

    def _change(self, change: Callable[[Raster], None]) -> None:
        if self.raster is not None:
            change(self.raster)
            self.redraw()

    def fit(self) -> None:
        """The whole path."""
        self._change(Raster.fit)

    def zoom(self, factor: float) -> None:
        """Closer or further away."""
        self._change(lambda raster: raster.zoom(factor))

    def render_line(self, y: int) -> Strip:
        """Title, picture, legend."""
        width = self.size.width
        if y == 0:
            return strip(self.title, width, self._looks)
        if y == self.size.height - 1:
            return strip(self.legend, width, self._looks)
        row = self._rows[y - 1] if y - 1 < len(self._rows) else []
        return strip(self._with_tool(row, y - 1), width, self._looks)

    def _with_tool(self, row: Line, y: int) -> Line:
        at = self.raster.cell_of(*self.tool) if self.raster is not None and self.tool is not None else None
        if at is None or at[1] != y:
            return row
        text = "".join(piece for piece, _ in row).ljust(at[0] + 1)
        styles = [style for piece, style in row for _ in piece]
        styles += [CLASS_STYLES[0]] * (len(text) - len(styles))
        cells: Line = list(zip(text, styles, strict=True))
        cells[at[0]] = ("@", "inverse")
        return cells
