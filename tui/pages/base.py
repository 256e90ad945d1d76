"""What a page is: rows made by pure functions, and what its keys do."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from textual.strip import Strip
from textual.widgets import Input

from tui.rows import Row
from tui.values import Shown
from tui.widgets import Body

if TYPE_CHECKING:
    from tui.app import Terminal


class Page:
    """One of the pages between header and message line. Its keys stand in tui.keys (column `page`): the action
    `name(1)` calls `key_name(1)`. A page that needs keys, a text field or the mouse overrides what is below."""

    name: ClassVar[str] = ""

    def __init__(self, app: Terminal) -> None:
        self.app = app
        self.top = 0
        #: the text field above the rows; shown and with the focus while the page is
        self.field: Input | None = None

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """The page; rows beyond `height` are reached by scrolling."""
        return []

    def visible(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """Exactly `height` rows of it."""
        rows = self.rows(shown, width, height)
        self.top = max(0, min(self.top, len(rows) - height))
        rows = rows[self.top : self.top + height]
        return rows + [Row(shown.look.text).strip(width)] * (height - len(rows))

    def enter(self) -> None:
        """The operator came to this page."""
        self.top = 0
        if self.field is not None:
            self.field.focus()

    def leave(self) -> None:
        """The operator goes to another page."""

    def escape(self) -> bool:
        """Esc (which has already held): True if it left something on this page, so that one stays here."""
        return False

    def confirm(self) -> None:
        """Enter, when nothing was announced."""

    def next(self) -> None:
        """The operator wants the next message."""

    def start(self, waited_s: float) -> bool:
        """`r`: True if the page has something of its own to start, or to say about it; `waited_s`: age of the key."""
        return False

    def scroll(self, by: int) -> None:
        """Arrows and page keys, in rows."""
        self.top += by

    def typed(self, text: str) -> None:
        """The text field changed."""

    def submitted(self, text: str) -> None:
        """Enter in the text field."""

    def clicked(self, event: Body.Clicked) -> None:
        """The operator pointed at a cell."""

    def wheel(self, event: Body.Wheel) -> None:
        """The wheel scrolls."""
        self.scroll(3 * event.by)

    def dragged(self, event: Body.Dragged) -> None:
        """The operator pulled what is shown."""
