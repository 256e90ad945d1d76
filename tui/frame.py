"""The rows that stay on every screen: header, message line, key line."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

from rich.style import Style
from textual.strip import Strip

from cnc_front.engine import Snapshot
from tui.keys import KEY_LINE, KEYS, Key
from tui.look import Look
from tui.program import block_name
from tui.rows import Row
from tui.states import FACES
from tui.values import Shown, is_low
from tui.words import Words


def target_word(s: Snapshot) -> str:
    """`[SIM x50]` or `[REPLAY]`: the loudest thing on screen."""
    speed = s.speed_factor
    if s.replay:
        return "[REPLAY]" if speed == 1 else f"[REPLAY x{speed:g}]" if speed else "[REPLAY max]"
    return f"[SIM x{speed:g}]" if speed else "[SIM max]"


def _flag(row: Row, look: Look, word: str, on: bool) -> None:
    row.add(" ").add(f"[{word}]" if on else word, look.inverse if on else look.bar)


def header(shown: Shown, switches: tuple[tuple[str, bool], ...], warnings: int, now: datetime, width: int) -> Strip:
    """Target, mode, state, program, block, switches, warnings, clock."""
    s, look, words = shown.snapshot, shown.look, shown.words
    wide = width >= 110
    gap = "  " if wide else " "
    face = FACES[s.state]
    row = Row(look.bar).add(" ").add(target_word(s), look.target).add(gap + words(s.mode.value.lower()) + gap)
    word = f"{face.symbol} {words.pick(face.english, face.german)}{shown.doubt.strip()}"
    row.add(word, getattr(look, face.style)).add(gap)
    if is_low(s):
        row.add(words("low"), look.warn).add(gap)
    right = Row(look.bar)
    if s.forced:
        numbers = ",".join(map(str, s.forced[:4])) + (",.." if len(s.forced) > 4 else "")
        right.add(f" [{words('forced', numbers=numbers) if wide else words('forced_short')}]", look.hold)
    for name, on in switches:
        _flag(right, look, name, on)
    if wide or s.rapid_set != 1.0:
        right.add(f" ROV {s.rapid_set * 100:.0f}", look.warn if s.rapid_set != 1.0 else look.bar)
    right.add("  ").add(*_findings(s, words, look, warnings, wide)).add(gap + f"{now:%H:%M:%S}")
    room = width - row.width - right.width - 1
    block = f"  {block_name(shown.job.lines, s.line)}" if wide and shown.job and s.line else ""
    name = shown.job.name if shown.job else ""
    if len(name) + len(block) > room:
        name = name[: max(0, room - len(block) - 1)] + "~"
    row.add((name + block)[: max(room, 0)])
    row.add(" " * (width - row.width - right.width))
    return Strip.join([row.strip(width - right.width), right.strip(right.width)])


def _findings(s: Snapshot, words: Words, look: Look, warnings: int, wide: bool) -> tuple[str, Style]:
    """How many alarms, or else warnings, there are."""
    if s.alarms:
        count = len(s.alarms)
        text = words("alarm_1") if count == 1 else words("alarm_n", n=count)
        return (text if wide else f"!! {count}"), look.alarm
    if not wide:
        return f"! {warnings}", look.warn if warnings else look.bar
    text = words("warning_1") if warnings == 1 else words("warnings", n=warnings)
    return text, look.warn if warnings else look.bar


def message_row(text: str, style: Style, look: Look, words: Words, more: bool, width: int) -> Strip:
    """One message; `n` shows the next one."""
    note = words("details") if more else ""
    row = Row(style).add(f" {text}"[: width - len(note) - 2])
    filled = row.strip(width - len(note) - 1)
    return Strip.join([filled, Row(look.dim).add(note).strip(len(note) + 1)])


def key_row(look: Look, words: Words, width: int, keys: Sequence[Key] = KEYS, page: str = "run") -> Strip:
    """As many keys as fit, of those that do something on the page."""
    row = Row(look.bar)
    other = {usual.shown: key.shown for usual, key in zip(KEYS, keys, strict=True) if usual.keys != key.keys}
    elsewhere = {key.shown: key.page for key in KEYS if key.page}
    for usual, english, german in KEY_LINE:
        if elsewhere.get(usual, page) != page:
            continue
        key = words.key(other.get(usual, usual))
        text = f"{key} {words.pick(english, german)}"
        if row.width + len(text) + 1 > width:
            break
        row.add(" ").add(key, look.strong if look.name == "mono" else look.bar)
        row.add(f" {words.pick(english, german)} ")
    return row.strip(width)


def small_row(shown: Shown, row_number: int, width: int) -> Strip:
    """Below 80x24 still: target, state, alarm and the way to hold."""
    face, look, words = FACES[shown.snapshot.state], shown.look, shown.words
    if row_number:
        return Row(look.text).strip(width)
    row = Row(look.text).add(target_word(shown.snapshot), look.target).add(" ")
    row.add(f"{face.symbol} {words.pick(face.english, face.german)}", getattr(look, face.style))
    row.add(f" !!{len(shown.snapshot.alarms)}" if shown.snapshot.alarms else "", look.alarm)
    return row.add(f" {words.key('SPACE')} {words.pick('Hold', 'Halt')} | {words('too_small')}").strip(width)
