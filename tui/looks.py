"""Colours and glyphs (ui-guide section 5): no fact is carried by colour alone."""

from __future__ import annotations

from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip

#: A line of a screen: pieces of text with the name of their style.
Line = list[tuple[str, str]]

_DARK = {
    "text": "#d0d0d0", "soft": "#9aa3ab", "todo": "#7a8793", "good": "#56b4e9", "warn": "#f0e442", "bad": "#ff6a13",
    "ground": "#1b1d1f", "panel": "#26292c", "sim": "#56b4e9",
}  # fmt: skip
_LIGHT = {
    "text": "#22262a", "soft": "#5d676f", "todo": "#6b7680", "good": "#0b63a5", "warn": "#7a5c00", "bad": "#b83a00",
    "ground": "#ffffff", "panel": "#eceff1", "sim": "#0b63a5",
}  # fmt: skip


def palette(theme: str) -> dict[str, Style]:
    """Styles by name. "mono" has attributes only."""
    if theme == "mono":
        plain = dict.fromkeys(("text", "soft", "todo", "good", "panel", "sim_text"), Style())
        strong = dict.fromkeys(("warn", "bad"), Style(bold=True))
        inverse = dict.fromkeys(("inverse", "warn_inverse", "bad_inverse", "sim"), Style(reverse=True, bold=True))
        return plain | strong | inverse | {"cursor": Style(reverse=True)}
    c = _LIGHT if theme == "light" else _DARK
    styles = {name: Style(color=c[name], bgcolor=c["ground"]) for name in ("text", "soft", "todo", "good", "warn")}
    styles["bad"] = Style(color=c["bad"], bgcolor=c["ground"], bold=True)
    styles["panel"] = Style(color=c["text"], bgcolor=c["panel"])
    styles["inverse"] = Style(color=c["ground"], bgcolor=c["text"], bold=True)
    styles["cursor"] = Style(color=c["text"], bgcolor=c["panel"], bold=True)
    for name, colour in (("warn_inverse", "warn"), ("bad_inverse", "bad"), ("sim", "sim")):
        styles[name] = Style(color=c["ground"], bgcolor=c[colour], bold=True)
    return styles


def strip(line: Line, width: int, styles: dict[str, Style], ground: str = "text") -> Strip:
    """A line cut or filled to `width` cells. Every segment has a style: None crashes under NO_COLOR."""
    segments = [Segment(text, styles[style]) for text, style in line if text]
    return Strip(segments).adjust_cell_length(width, styles[ground])


def width_of(line: Line) -> int:
    """Cells of a line; all our texts are one cell a character."""
    return sum(len(text) for text, _ in line)


def justified(left: Line, right: Line, width: int) -> Line:
    """Left and right part with blanks between; the right part stays whole."""
    room = max(0, width - width_of(right))
    kept: Line = []
    for text, style in left:
        kept.append((text[:room], style))
        room -= len(text[:room])
    return [*kept, (" " * room, "text"), *right]
