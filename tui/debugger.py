"""The screen of a rw_SymPas job: source with the current line, breakpoints, variables, tasks, output.

It draws what a session says and passes keys on; machine time passes only while a task runs or steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical
from textual.widgets import Static

from tui.look import Look
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.sap_debug import DebugSession

#: Frames and machine time a frame, s: as fast as life.
FRAME_S = 0.05
#: What a step may take before the screen is drawn again, s of machine time.
STEP_S = 1.0


class Debugger(App[None]):
    """Steps through the CNC tasks of a job."""

    CSS = """
    Horizontal { height: 1fr; }
    #source { width: 3fr; height: 100%; }
    #side { width: 2fr; min-width: 26; }
    #variables { height: 2fr; }
    #tasks { height: 6; }
    #output { height: 1fr; }
    #keys, #head { height: 1; }
    """
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        ("s", "step", ""),
        ("o", "over", ""),
        ("c", "go", ""),
        ("a", "all", ""),
        ("p", "pause", ""),
        ("b", "toggle_break", ""),
        ("up", "move(-1)", ""),
        ("down", "move(1)", ""),
        ("pageup", "move(-10)", ""),
        ("pagedown", "move(10)", ""),
        ("t", "next_task", ""),
        ("q", "quit", ""),
    ]

    def __init__(self, session: DebugSession, look: Look, words: Words) -> None:
        super().__init__()
        self.session, self.look, self.words = session, look, words
        self.number = session.tasks[0].number
        #: line under the cursor; follows the task until it is moved
        self.cursor, self.follows = 1, True

    def compose(self) -> ComposeResult:
        yield Static(id="head")
        with Horizontal():
            yield Static(id="source")
            with Vertical(id="side"):
                yield Static(id="variables")
                yield Static(id="tasks")
                yield Static(id="output")
        yield Static(id="keys")

    def on_mount(self) -> None:
        self.screen.styles.background = self.look.background or None
        self.session.advance(0.0)
        self.draw()
        self.set_interval(FRAME_S, self.tick)

    def on_resize(self) -> None:
        self.call_after_refresh(self.draw)

    # ---- keys

    def action_step(self) -> None:
        self.session.step(self.number)
        self._until_stepped()

    def action_over(self) -> None:
        self.session.step(self.number, over=True)
        self._until_stepped()

    def _until_stepped(self) -> None:
        """A step that does not wait is done at once; one that waits goes on frame by frame."""
        self.session.advance(FRAME_S)
        self.follows = True
        self.draw()

    def action_go(self) -> None:
        self.session.go(self.number)
        self.follows = True

    def action_all(self) -> None:
        for task in self.session.tasks:
            self.session.go(task.number)
        self.follows = True

    def action_pause(self) -> None:
        self.session.pause(self.number)
        self.follows = True

    def action_toggle_break(self) -> None:
        self.session.toggle_break(self.number, self.cursor)
        self.draw()

    def action_move(self, by: int) -> None:
        self.follows = False
        self.cursor = max(1, min(len(self.session.lines(self.number)), self.cursor + by))
        self.draw()

    def action_next_task(self) -> None:
        numbers = [task.number for task in self.session.tasks]
        self.number = numbers[(numbers.index(self.number) + 1) % len(numbers)]
        self.follows = True
        self.draw()

    # ---- drawing

    def tick(self) -> None:
        """A frame: time passes while some task is at work."""
        states = [self.session.state(task).state for task in self.session.tasks]
        if any(state in ("runs", "waits") for state in states):
            self.session.advance(FRAME_S)
            self.draw()

    def draw(self) -> None:
        """Everything anew: a screen is a few dozen lines."""
        task = next(t for t in self.session.tasks if t.number == self.number)
        state = self.session.state(task)
        if self.follows and state.line:
            self.cursor = state.line
        word = self.words(f"task_{state.state}")
        head = f" {state.name}  {self.words('cnc_task')} {state.number}: {word} {state.error}"
        self._put("head", Text(f"{head}  {self.session.machine_time_s:.3f} s", style=self.look.bar))
        self._put("source", self.source(state.line))
        self._put("variables", self.variables())
        self._put("tasks", self.tasks())
        self._put("output", self.output())
        self._put("keys", Text(self.words("debug_keys"), style=self.look.bar, no_wrap=True))

    def _put(self, name: str, text: Text) -> None:
        self.query_one(f"#{name}", Static).update(text)

    def source(self, current: int) -> Text:
        """The lines around the cursor: breakpoint, number, text; the line that comes next stands out."""
        lines = self.session.lines(self.number)
        height = max(1, self.query_one("#source").size.height)
        first = max(1, min(self.cursor - height // 2, len(lines) - height + 1))
        breaks = self.session.breaks[self.number]
        out = Text(no_wrap=True, overflow="ellipsis")
        for number in range(first, min(len(lines), first + height - 1) + 1):
            mark = "*" if number in breaks else " "
            arrow = ">" if number == current else " "
            style = self.look.text
            if number == current:
                style = self.look.target
            elif number == self.cursor:
                style = self.look.cursor
            out.append(f"{mark}{arrow}{number:>5}  {lines[number - 1]}\n", style=style)
        return out

    def variables(self) -> Text:
        """Variables of the routine being executed, then those of the program."""
        calls = " > ".join(self.session.calls(self.number)) or "-"
        out = Text(f"{calls}\n", style=self.look.dim, no_wrap=True, overflow="ellipsis")
        for name, is_global, value in self.session.variables(self.number):
            shown = f"{value:.9g}" if isinstance(value, float) else str(value)
            out.append(f" {name} = {shown}\n", style=self.look.dim if is_global else self.look.strong)
        return out

    def tasks(self) -> Text:
        """One line a task."""
        out = Text(no_wrap=True, overflow="ellipsis")
        for task in self.session.tasks:
            state = self.session.state(task)
            style = self.look.strong if state.number == self.number else self.look.text
            word = self.words(f"task_{state.state}")
            out.append(f"{state.number} {state.name} {word} {state.line} {state.error}\n", style=style)
        return out

    def output(self) -> Text:
        """The last lines that the tasks wrote."""
        height = max(1, self.query_one("#output").size.height)
        return Text("\n".join(self.session.output[-height:]), style=self.look.text, no_wrap=True, overflow="ellipsis")
