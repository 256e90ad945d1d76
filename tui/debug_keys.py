"""Keys of the screen of rw_SymPas jobs: some are those of the main screen, the rest is its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tui.keys import KEYS, Key
from tui.words import Words

#: The page of a keymap on which keys of this screen alone count.
PAGE = "debug"

#: Actions here, and whose keys of the main screen they have.
SHARED = {
    "hold": "hold",
    "leave": "escape",
    "resume": "start",
    "step('into')": "step",
    "move(-1)": "scroll(-1)",
    "move(1)": "scroll(1)",
    "move(-10)": "scroll(-20)",
    "move(10)": "scroll(20)",
    "help": "show('help')",
    "quit": "ask_quit",
}

_HELP = (
    Key("hold", "", "", "hold: axes and tasks stop", "Halt: Achsen, Tasks stehen", everywhere=True),
    Key("leave", "", "", "hold, leaves a question", "Halt, verlässt eine Frage", everywhere=True),
    Key("resume", "", "", "all tasks go on", "alle Tasks weiter"),
    Key("step('on')", "R", "R", "this task goes on", "dieser Task weiter", page=PAGE),
    Key("step('into')", "", "", "step, into routines", "Schritt, in Routinen"),
    Key("step('over')", "T", "T", "step over routines", "Schritt über Routinen", page=PAGE),
    Key("step('out')", "U", "U", "out of the routine", "aus der Routine hinaus", page=PAGE),
    Key("toggle_break", "b", "b", "breakpoint on/off", "Haltepunkt ein/aus", page=PAGE),
    Key("assign", "equals_sign", "=", "set a variable", "Variable setzen", page=PAGE),
    Key("move(-1)", "", "", "cursor by a line", "Marke zeilenweise"),
    Key("move(1)", "", "", "", ""),
    Key("move(-10)", "", "", "cursor by a page", "Marke seitenweise"),
    Key("move(10)", "", "", "", ""),
    Key("current", "c", "c", "back to the current line", "zur laufenden Zeile", page=PAGE),
    Key("next_task", "tab", "Tab", "next task", "nächster Task", everywhere=True, page=PAGE),
    Key("view", "v", "v", "one task / side by side", "ein Task / nebeneinander", page=PAGE),
    Key("help", "", "", "this help on/off", "diese Hilfe ein/aus"),
    Key("quit", "", "", "quit", "Ende", everywhere=True),
)

#: What this screen has for itself, as a keymap names it: `debug:toggle_break`.
DEBUG_KEYS = tuple(key for key in _HELP if key.page)

#: All that a keymap file can change.
ALL_KEYS = (*KEYS, *DEBUG_KEYS)

#: Key line: action, English, German; the last ones are dropped where they do not fit.
_LINE = (
    ("hold", "Hold", "Halt"),
    ("resume", "Go on", "weiter"),
    ("step('into')", "Step", "Schritt"),
    ("step('over')", "over", "darüber"),
    ("step('out')", "out", "hinaus"),
    ("toggle_break", "Break", "Haltep."),
    ("help", "Help", "Hilfe"),
    ("view", "View", "Sicht"),
    ("next_task", "Task", "Task"),
)


def main_keys(keys: Sequence[Key]) -> tuple[Key, ...]:
    """Those of the main screen."""
    return tuple(key for key in keys if key.page != PAGE)


def debug_keys(keys: Sequence[Key]) -> tuple[Key, ...]:
    """The whole table of this screen, from all keys: each with the keys that it has now."""
    main = {key.action: key for key in keys if not key.page}
    own = {key.action: key for key in keys if key.page == PAGE}
    table = []
    for key in _HELP:
        now = own.get(key.action, key) if key.page else main[SHARED[key.action]]
        table.append(replace(key, keys=now.keys, shown=now.shown))
    return tuple(table)


def help_text(table: Sequence[Key], words: Words) -> str:
    """All keys, a line each."""
    rows = [key for key in table if key.shown and key.english]
    return "\n".join(f" {words.key(key.shown):<11} {words.pick(key.english, key.german)}" for key in rows) + "\n"


def line_text(table: Sequence[Key], words: Words, width: int) -> str:
    """As much of the key line as fits."""
    shown = {key.action: words.key(key.shown).split(" ")[0] for key in table}
    shown["hold"] = words.key("SPACE")
    texts = [f"{shown[action]} {words.pick(english, german)}" for action, english, german in _LINE]
    gap = "  " if len("  ".join(texts)) < width else " "
    while texts and len(gap.join(texts)) >= width:
        texts.pop()
    return f" {gap.join(texts)}"
