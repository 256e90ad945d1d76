"""Colours and glyphs: themes dark, light, ansi (16 colours) and mono (ui-guide section 5).

No fact is carried by colour alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from rich.style import Style

GLYPHS = ("quadrant", "braille", "half", "ascii")


@dataclass(frozen=True, slots=True)
class Look:
    """Every style of the screen; each has a value, since a Segment without one crashes under NO_COLOR."""

    name: str
    glyphs: str
    text: Style
    dim: Style
    strong: Style
    good: Style
    warn: Style
    bad: Style
    todo: Style
    tool: Style
    bar: Style  # header and key line
    target: Style  # the loudest thing on screen
    inverse: Style
    hold: Style
    alarm: Style
    cursor: Style

    @property
    def background(self) -> str:
        """Colour behind everything; empty where the terminal's own is used."""
        return self.text.bgcolor.name if self.text.bgcolor else ""

    @property
    def foreground(self) -> str:
        """Colour of text."""
        return self.text.color.name if self.text.color else ""

    @property
    def is_ansi(self) -> bool:
        """The terminal's own colours, or none."""
        return self.name in ("mono", "ansi")

    @property
    def is_plain(self) -> bool:
        """Only ASCII characters for lines, bars and the path."""
        return self.glyphs == "ascii"

    def rule(self, vertical: bool = False) -> str:
        """The character of a dividing line."""
        return ("|" if vertical else "-") if self.is_plain else ("│" if vertical else "─")

    def gauge(self, share: float, width: int) -> tuple[str, str]:
        """The full and the empty part of a bar of `width` cells."""
        full = max(0, min(width, round(share * width)))
        return ("#" if self.is_plain else "█") * full, ("." if self.is_plain else "░") * (width - full)


def _colours(background: str, text: str, **colour: str) -> dict[str, Style]:
    """Styles of a colour theme; an inverse one has its colour behind the background's."""
    flat = {name: Style(color=colour[name], bgcolor=background) for name in ("dim", "good", "warn", "bad", "todo")}
    return flat | {
        "text": Style(color=text, bgcolor=background),
        "strong": Style(color=colour["strong"], bgcolor=background, bold=True),
        "tool": Style(color=background, bgcolor=colour["strong"], bold=True),
        "bar": Style(color=text, bgcolor=colour["panel"]),
        "target": Style(color=colour["target_ink"], bgcolor=colour["target"], bold=True),
        "inverse": Style(color=background, bgcolor=text, bold=True),
        "hold": Style(color=colour["hold_ink"], bgcolor=colour["hold"], bold=True),
        "alarm": Style(color=colour["alarm_ink"], bgcolor=colour["bad"], bold=True),
        "cursor": Style(color=text, bgcolor=colour["panel"], bold=True),
    }


_MONO = {
    "text": Style(bold=False),
    "dim": Style(dim=True),
    "strong": Style(bold=True),
    "good": Style(bold=False),
    "warn": Style(bold=True),
    "bad": Style(bold=True, underline=True),
    "todo": Style(dim=True),
    "tool": Style(bold=True, reverse=True),
    "bar": Style(bold=False),
    "target": Style(bold=True, reverse=True),
    "inverse": Style(reverse=True),
    "hold": Style(bold=True, reverse=True),
    "alarm": Style(bold=True, reverse=True, underline=True),
    "cursor": Style(reverse=True),
}

THEMES: Mapping[str, Mapping[str, Style]] = {
    "dark": _colours(
        "#1b1d1f",
        "#d0d0d0",
        dim="#8a949c",
        strong="#ffffff",
        good="#56b4e9",
        warn="#f0e442",
        bad="#ff6a13",
        todo="#7a8793",
        panel="#2b3036",
        target="#8ecbff",
        target_ink="#10202c",
        hold="#f0e442",
        hold_ink="#1b1d1f",
        alarm_ink="#1b1d1f",
    ),
    "light": _colours(
        "#ffffff",
        "#202020",
        dim="#5f6870",
        strong="#000000",
        good="#005a9c",
        warn="#7a5c00",
        bad="#b33c00",
        todo="#6b747c",
        panel="#e2e6ea",
        target="#0067b0",
        target_ink="#ffffff",
        hold="#ffe14d",
        hold_ink="#202020",
        alarm_ink="#ffffff",
    ),
    "ansi": _colours(
        "black",
        "white",
        dim="white",
        strong="bright_white",
        good="bright_cyan",
        warn="bright_yellow",
        bad="bright_red",
        todo="bright_black",
        panel="blue",
        target="bright_cyan",
        target_ink="black",
        hold="bright_yellow",
        hold_ink="black",
        alarm_ink="black",
    ),
    "mono": _MONO,
}


def choose_look(theme: str | None, glyphs: str | None, environment: Mapping[str, str]) -> Look:
    """What was asked for, else what NO_COLOR and TERM allow: a Linux console has no quadrants, "dumb" no colours."""
    term = environment.get("TERM", "")
    plain = term in ("dumb", "linux", "vt100", "vt220")
    colourless = bool(environment.get("NO_COLOR")) or term in ("dumb", "vt100", "vt220")
    usual = "mono" if colourless else "ansi" if term == "linux" else "dark"
    return make_look(theme or usual, glyphs or ("ascii" if plain else "quadrant"))


def make_look(theme: str, glyphs: str) -> Look:
    """A look by the names of its theme and its glyphs."""
    styles = THEMES[theme]
    return Look(theme, glyphs, **{field.name: styles[field.name] for field in fields(Look)[2:]})
