"""What the screen of rw_SymPas jobs shows, as texts: source with its current line, variables, tasks, output."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.text import Text

from tui.look import Look
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.sap_debug import DebugSession, TaskState


def source(session: DebugSession, number: int, look: Look, place: tuple[int, int], height: int) -> Text:
    """The lines around the cursor: breakpoint, number, text; the line that comes next stands out. `place`: the one that
    comes next, the one under the cursor. Includes stand behind the job, each below its name."""
    current, cursor = place
    lines, breaks, titles = session.lines(number), session.views[number].breaks, session.titles(number)
    first = max(1, min(cursor - height // 2, len(lines) - height + 1))
    begun = max((begin for begin in titles if begin < first), default=0)
    out = Text(no_wrap=True, overflow="ellipsis")
    for n in range(first, min(len(lines), first + height - 1) + 1):
        style = look.target if n == current else look.cursor if n == cursor else look.text
        mark, arrow = "*" if n in breaks else " ", ">" if n == current else " "
        if n - 1 in titles:
            begun = n - 1
        line = f"{titles[begun]}:{n - begun:<4}" if begun else f"{n:>5} "
        out.append(f"{mark}{arrow}{line} {lines[n - 1]}\n", style=style)
    return out


def variables(session: DebugSession, number: int, look: Look) -> Text:
    """Routines being executed; variables of the last of them, those of its callers, those of the program, axes last."""
    view, axes = session.views[number], session.run.machine.machine.axis_names
    calls = view.calls
    out = Text(
        f"{' > '.join(name or 'main' for name in calls) or '-'}\n", style=look.dim, no_wrap=True, overflow="ellipsis"
    )
    last, innermost = len(calls) - 1, len(calls) - 1
    for name, call, value in sorted(view.rows, key=lambda row: row[1] == 0 and row[0] in axes):
        if call != last:
            out.append(f"{calls[call] or 'main'}\n", style=look.dim)
            last = call
        shown = f"{value:.9g}" if isinstance(value, float) else str(value).upper()
        if view.is_axis(name) and 0 <= int(value) < len(axes):
            shown += f" {axes[int(value)]} dp {session.position(int(value)):.3f}"
        out.append(f" {name} = {shown}\n", style=look.strong if call == innermost else look.dim)
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
