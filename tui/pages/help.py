"""Help: all keys, all states, from their tables."""

from __future__ import annotations

from collections.abc import Sequence

from rich.style import Style
from textual.strip import Strip

from tui.keys import KEYS, Key
from tui.look import Look
from tui.pages.base import Page
from tui.rows import Row
from tui.states import FACES
from tui.values import Shown
from tui.words import Words


class HelpPage(Page):
    """All keys and states."""

    name = "help"

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """All of it; it scrolls."""
        return help_rows(shown.look, shown.words, width, self.app.keys_table)


def help_rows(look: Look, words: Words, width: int, keys: Sequence[Key] = KEYS) -> list[Strip]:
    """All keys, then all states, from their tables."""
    rows = [Row(look.strong).add(f" {words('help_title')}"), Row(look.warn).add(f" {words('help_stop')}")]
    for key in keys:
        if key.shown:
            text = words.pick(key.english, key.german)
            rows.append(Row(look.text).add(f"  {words.key(key.shown)}", look.strong).at(16, text))
    rows += [Row(look.text), Row(look.strong).add(f" {words('help_states')}")]
    for face in FACES.values():
        row = (
            Row(look.text)
            .add("  ")
            .add(f"{face.symbol} {words.pick(face.english, face.german)}", _face(look, face.style))
        )
        rows.append(row.at(18, words.pick(*face.leaves_by)))
    rows.append(Row(look.dim).add(f" {words('help_scroll')}"))
    return [row.strip(width) for row in rows]


def _face(look: Look, name: str) -> Style:
    style: Style = getattr(look, name)
    return style
