"""The keymap file: other keys for actions, one line each, `action = key, key`. `cnc-front tui --keys` prints the table.

Hold cannot be unbound: Space and Esc stay what they are, whatever the file says; it may only give hold more keys.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from textual.keys import Keys, _character_to_key

from cnc_front.errors import UsageError
from tui.debug_keys import ALL_KEYS, PAGE, SHARED
from tui.keys import Key
from tui.words import Words

#: Keys that always hold.
FIXED = {"hold": "space", "escape": "escape"}
#: A keymap larger than this is none.
MOST_BYTES = 100_000
_PRINTABLE = [chr(code) for code in range(33, 127)]
_NAMES = (
    {key.value for key in Keys}
    | {"space", "hyphen"}
    | {_character_to_key(sign) for sign in _PRINTABLE}
    | {re.sub("[ -]", "_", unicodedata.name(sign).lower()) for sign in _PRINTABLE}
)
_MODIFIERS = ("ctrl", "shift", "alt")


def place(asked: str | None, environment: Mapping[str, str]) -> str | None:
    """The file: as asked, else CNC_FRONT_KEYMAP, else `cnc-front/keymap` in the XDG configuration, if it is there."""
    named = asked or environment.get("CNC_FRONT_KEYMAP")
    if named:
        return named
    config = environment.get("XDG_CONFIG_HOME", "")
    folder = Path(config) if config.startswith("/") else Path(environment.get("HOME", "~")).expanduser() / ".config"
    usual = folder / "cnc-front" / "keymap"
    return str(usual) if usual.is_file() else None


def read_keymap(path: str) -> tuple[Key, ...]:
    """The tables of keys of both screens with what the file changes. Raises UsageError: file:line and what to do."""
    try:
        with Path(path).open("rb") as file:
            text = file.read(MOST_BYTES).decode("utf-8")
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise UsageError(f"{path}: no text in UTF-8") from None
    return changed(ALL_KEYS, text.splitlines(), path)


def changed(keys: Sequence[Key], lines: Iterable[str], file: str) -> tuple[Key, ...]:
    """The table with the lines of a keymap obeyed. Raises UsageError."""
    table = {name_of(key): key for key in keys}
    given: dict[str, int] = {}
    for number, line in enumerate(lines, 1):
        text = line.partition(" #")[0].strip()
        if not text or text.startswith("#"):
            continue
        place = f"{file}:{number}"
        action, equals, wanted = (part.strip() for part in text.partition(" ="))
        if not equals:
            raise UsageError(f"{place}: '{text[:60]}' is not ACTION = KEY, KEY")
        if action not in table:
            raise UsageError(f"{place}: unknown action '{action[:40]}'; cnc-front tui --keys lists them")
        if action in given:
            raise UsageError(f"{place}: {action} stands in line {given[action]} already")
        given[action] = number
        names = _names(wanted, place)
        if action in FIXED and FIXED[action] not in names:
            names.insert(0, FIXED[action])
        table[action] = replace(table[action], keys=",".join(names), shown=" ".join(map(_shown, names)))
    for action, number in given.items():
        _refuse_clash(table, action, f"{file}:{number}")
    return tuple(table[name_of(key)] for key in keys)


def name_of(key: Key) -> str:
    """The name of an action in a keymap: `override(5)`, `run:zoom(1)`."""
    return f"{key.page}:{key.action}" if key.page else key.action


def _names(wanted: str, place: str) -> list[str]:
    names = [_name(word.strip(), place) for word in wanted.split(",") if word.strip()]
    if not names:
        raise UsageError(f"{place}: no key; write one, e.g. f9, ctrl+k, x")
    return names


def _name(word: str, place: str) -> str:
    """Textual's name of a key."""
    *modifiers, key = word.split("+") if len(word) > 1 else [word]
    if len(key) == 1 and key.isprintable():
        name = _character_to_key(key) if not modifiers else key.lower()
    else:
        name = key.lower()
    if not key or (len(key) > 1 and name not in _NAMES) or any(m.lower() not in _MODIFIERS for m in modifiers):
        raise UsageError(f"{place}: '{word[:30]}' is no key; write x, f9, ctrl+k, shift+up, comma, delete ...")
    return "+".join([*(m.lower() for m in modifiers), name])


def _shown(name: str) -> str:
    """As help prints it."""
    return name.replace("ctrl+", "^").upper() if name.startswith("ctrl+") else name


def _refuse_clash(table: Mapping[str, Key], action: str, place: str) -> None:
    """No two actions of one page on one key; what counts on all pages counts on each."""
    key = table[action]
    for other_action, other in table.items():
        if other is key or not _meet(key, other):
            continue
        shared = set(key.keys.split(",")) & set(other.keys.split(","))
        if shared:
            raise UsageError(f"{place}: {min(shared)} belongs to {other_action} already; give that another key first")


def _meet(one: Key, other: Key) -> bool:
    """Both count on some page; on the screen of rw_SymPas jobs count its own and those that it shares."""
    if (one.page == PAGE) != (other.page == PAGE):
        main = other if one.page == PAGE else one
        return not main.page and main.action in SHARED.values()
    return not (one.page and other.page) or one.page == other.page


def table_text(keys: Sequence[Key], words: Words) -> str:
    """The table as a keymap file that changes nothing."""
    rows = [f"# {words('keymap_head')}"]
    for key in keys:
        text = words.pick(key.english, key.german)
        rows.append(f"{name_of(key):<24} = {key.keys.replace(',', ', '):<24}" + (f" # {text}" if text else ""))
    return "\n".join(row.rstrip() for row in rows)
