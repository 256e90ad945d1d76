"""Questions to the operator. Hold works in all of them: its keys belong to the application and come first."""

from __future__ import annotations

import time

from textual import events
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from tui.hold_button import HoldButton
from tui.keys import SETTLE_S


class Question(ModalScreen[str | None]):
    """A title and, unless it is only to be confirmed, a text field. Enter answers, Esc leaves (and holds)."""

    AUTO_FOCUS = "Input"
    DEFAULT_CSS = """
    Question { align: center middle; background: transparent; layers: default above; }
    Question > Vertical { width: 64; max-width: 100%; height: auto; border: ascii $foreground; padding: 0 1;
        background: $background; }
    Question Static { height: auto; background: $background; color: $foreground; }
    Question Input { border: none; height: 1; padding: 0; background: $background; color: $foreground; }
    Question Input:focus { border: none; }
    """

    def __init__(self, title: str, keys: str, button: HoldButton, *, field: bool, settle_s: float = SETTLE_S) -> None:
        super().__init__()
        self._button = button
        self._title, self._keys, self._field = title, keys, field
        self._settle_s, self._opened = settle_s, time.monotonic()
        self._is_answered = False

    def compose(self) -> ComposeResult:
        """Title, field, keys."""
        with Vertical():
            yield Static(self._title, markup=False)
            if self._field:
                yield Input(select_on_focus=False, compact=True)
            yield Static(self._keys, markup=False)
        yield self._button

    def answer(self, text: str | None) -> None:
        """Closes the question, once: keys may arrive faster than it goes away. None: left without an answer."""
        if not self._is_answered:
            self._is_answered = True
            self.dismiss(text)

    def on_key(self, event: events.Key) -> None:
        """A key that was meant for the screen before must not answer the question."""
        if event.key == "enter" and not self._field:
            event.stop()
            if time.monotonic() - self._opened >= self._settle_s:
                self.answer("")

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """The answer."""
        event.stop()
        self.answer(event.value)
