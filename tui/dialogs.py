"""Small dialogs. Hold works in all of them: Esc leaves and holds, and so does Space outside of a text field."""

from __future__ import annotations

from typing import ClassVar

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static


class Ask(ModalScreen[str | None]):
    """Asks for a line of text; None if it was left."""

    def __init__(self, title: str, hint: str, value: str = "") -> None:
        super().__init__()
        self._texts = (title, hint, value)

    def compose(self) -> ComposeResult:
        """Title, field, keys."""
        title, hint, value = self._texts
        with Vertical(classes="dialog"):
            yield Static(title, markup=False)
            yield Input(value=value, compact=True)
            yield Static(hint, classes="hint", markup=False)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Enter takes the text."""
        event.stop()
        self.dismiss(event.value)


class Page(ModalScreen[bool]):
    """Shows lines; with `asks`, Enter answers yes."""

    BINDINGS: ClassVar = [("enter", "answer", ""), ("q", "leave", "")]

    def __init__(self, title: str, lines: list[str], hint: str = "", asks: bool = False) -> None:
        super().__init__()
        self._texts = (title, "\n".join(lines), hint)
        self._asks = asks

    def compose(self) -> ComposeResult:
        """Title, text, keys."""
        title, body, hint = self._texts
        with Vertical(classes="dialog wide"):
            yield Static(title, markup=False)
            yield Static(body, markup=False)
            yield Static(hint, classes="hint", markup=False)

    def action_answer(self) -> None:
        """Enter."""
        self.dismiss(self._asks)

    def action_leave(self) -> None:
        """q leaves without answer."""
        self.dismiss(False)
