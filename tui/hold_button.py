"""The HOLD button: the one thing on screen with which a mouse acts on motion, and all it does is stop it."""

from __future__ import annotations

from collections.abc import Callable

from textual import events
from textual.app import App
from textual.reactive import reactive
from textual.strip import Strip
from textual.widget import Widget

from tui.look import Look
from tui.rows import Row
from tui.words import Words

#: Its size in cells, and the narrowest screen that it does not crowd.
WIDTH, HEIGHT, ROOM, SMALLEST_ROWS = 16, 2, 100, 24


class HoldButton(Widget):
    """Stands in the lower right corner of every screen and of every dialog, above what is there. It holds as soon as it
    is pressed, with whichever button; a release means nothing."""

    ALLOW_SELECT = False
    #: there is something to hold
    moves: reactive[bool] = reactive(False)
    DEFAULT_CSS = f"HoldButton {{ layer: above; dock: bottom; width: {WIDTH}; height: {HEIGHT}; }}"

    def __init__(self, look: Look, words: Words, hold: Callable[[], None], mouse: bool) -> None:
        """`hold`: what a press does. `mouse`: it is ours; else the button is never there."""
        super().__init__()
        self._look, self._words, self._hold, self._mouse = look, words, hold, mouse

    @property
    def room(self) -> int:
        """How many columns of the two lowest rows it takes; 0: it is not there."""
        width, height = self.app.size
        return WIDTH if self._mouse and width >= ROOM and height >= SMALLEST_ROWS else 0

    def on_mount(self) -> None:
        self.place()

    def place(self) -> None:
        """Moves it into the corner, or takes it away where there is no room."""
        self.display = self.room > 0
        self.styles.offset = (self.app.size.width - WIDTH, 0)

    def render_line(self, y: int) -> Strip:
        """Two rows, with brackets, so that it is seen to be one thing without colours too."""
        word = self._words("hold_button") if y == 0 else self._words("hold_button_way")
        return Row(self._look.inverse if self.moves else self._look.bar).add(f"[{word:^{WIDTH - 2}}]").strip(WIDTH)

    def on_mouse_down(self, event: events.MouseDown) -> None:
        event.stop()
        self._hold()


def buttons(app: App[None]) -> list[HoldButton]:
    """That of the screen, and of each dialog above it."""
    return [button for screen in app.screen_stack for button in screen.query(HoldButton)]
