"""What the screen of rw_SymPas jobs shows, as texts: source with its current line, variables, tasks, output."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.text import Text

from tui.look import Look
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.sap_debug import DebugSession, TaskState


def source(session: DebugSession, number: int, look: Look, place: tuple[int, int], height: int) -> Text:
    """The lines around the cursor: breakpoint, number, text; the line that comes next stands out. `place`: line that
    comes next, line under the cursor."""
    current, cursor = place
    lines, breaks = session.lines(number), session.views[number].breaks
    first = max(1, min(cursor - height // 2, len(lines) - height + 1))
    out = Text(no_wrap=True, overflow="ellipsis")
    for n in range(first, min(len(lines), first + height - 1) + 1):
        style = look.target if n == current else look.cursor if n == cursor else look.text
        mark, arrow = "*" if n in breaks else " ", ">" if n == current else " "
        out.append(f"{mark}{arrow}{n:>5}  {lines[n - 1]}\n", style=style)
    return out


def variables(session: DebugSession, number: int, look: Look) -> Text:
    """Routines being executed; variables of the last of them, then those of the program."""
    view = session.views[number]
    calls = " > ".join(name or "main" for name in view.calls) or "-"
    out = Text(f"{calls}\n", style=look.dim, no_wrap=True, overflow="ellipsis")
    for name, is_global, value in view.rows:
        shown = f"{value:.9g}" if isinstance(value, float) else str(value)
        out.append(f" {name} = {shown}\n", style=look.dim if is_global else look.strong)
    return out


def task_line(state: TaskState, look: Look, words: Words, *, chosen: bool) -> Text:
    """Number, file, state, line, events of a task; state as word and symbol, not as colour alone."""
    style = look.alarm if state.state == "error" else look.inverse if chosen else look.bar
    word = words(f"task_{state.state}")
    text = (
        f" {state.number} {state.name}  {SYMBOLS[state.state]} {word} {state.error} {words('debug_line')} {state.line}"
    )
    if state.handler:
        text += f"  ! {state.handler}"
    if state.events:
        text += f"  {words('events')} {' '.join(state.events)}"
    return Text(text, style=style, no_wrap=True, overflow="ellipsis")


#: As on the other screens (ui-guide section 4).
SYMBOLS = {"runs": ">", "waits": "~", "step": "=", "halted": "=", "rests": "#", "error": "!!"}


def tasks(session: DebugSession, chosen: int, look: Look, words: Words) -> Text:
    """One line a task."""
    rows = [task_line(session.state(t), look, words, chosen=t.number == chosen) for t in session.tasks]
    return Text("\n", no_wrap=True, overflow="ellipsis").join(rows)


def output(session: DebugSession, look: Look, height: int) -> Text:
    """The last lines that the tasks wrote."""
    return Text("\n".join(session.output[-max(1, height) :]), style=look.text, no_wrap=True, overflow="ellipsis")
