"""The screen of rw_SymPas jobs: one task with variables and output, or up to four side by side.

It draws what a session says and passes keys on; machine time passes only while a task or an axis is at work. Keys mean
what they mean on the other screens: Space holds, `r` goes on, `t` steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from rich.text import Text
from textual.app import App, ComposeResult
from textual.containers import Grid, Horizontal, Vertical
from textual.widgets import Input, Static

from tui import debug_panes as panes
from tui.debug_keys import ALL_KEYS, debug_keys, help_text, line_text
from tui.dialogs import Question
from tui.hold_button import HoldButton, buttons
from tui.keys import Key
from tui.look import Look
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.sap_debug import DebugSession

#: Frames and machine time a frame, s: as fast as life.
FRAME_S = 0.05


class Debugger(App[None]):
    """Steps through the CNC tasks of a job."""

    CSS = """
    Screen { layers: default above; }
    Static { text-wrap: nowrap; text-overflow: ellipsis; }
    #one { height: 1fr; }
    #source { width: 3fr; height: 100%; }
    #side { width: 2fr; min-width: 26; }
    #variables { height: 1fr; }
    #tasks { height: 4; }
    #output { height: 4; }
    #keys, #head { height: 1; }
    #all { height: 1fr; grid-size: 2; grid-gutter: 0 1; }
    .task { height: 100%; }
    """
    ENABLE_COMMAND_PALETTE = False

    def __init__(
        self,
        session: DebugSession,
        look: Look,
        words: Words,
        mouse: bool = True,
        keys: Sequence[Key] = ALL_KEYS,
    ) -> None:
        """`keys`: those of all screens, with what a keymap changed."""
        super().__init__()
        self.keys_table = debug_keys(keys)
        self._bindings.key_to_bindings.clear()  # Textual's own: ctrl+q quits, whatever the table says
        for key in self.keys_table:
            self._bindings.bind(key.keys, key.action, key.english, show=False, priority=key.everywhere)
        self.session, self.look, self.words, self.mouse = session, look, words, mouse
        self.number = session.tasks[0].number
        #: line under the cursor; follows the task until it is moved
        self.cursor, self.follows = 1, True
        self.side_by_side, self.helps = False, False
        self.message = ""

    def compose(self) -> ComposeResult:
        yield Static(id="head")
        with Horizontal(id="one"):
            yield Static(id="source")
            with Vertical(id="side"):
                yield Static(id="variables")
        with Grid(id="all"):
            for task in self.session.tasks:
                yield Static(id=f"task{task.number}", classes="task")
        yield Static(id="tasks")
        yield Static(id="output")
        yield Static(id="keys")
        yield HoldButton(self.look, self.words, self.action_hold, self.mouse)

    def on_mount(self) -> None:
        self.screen.styles.background = self.look.background or None
        self.query_one("#tasks").styles.height = len(self.session.tasks)
        self._show_view()
        self.session.advance(0.0)
        self.draw()
        self.set_interval(FRAME_S, self.tick)

    def on_resize(self) -> None:
        self.call_after_refresh(self._resized)

    def _resized(self) -> None:
        for button in buttons(self):
            button.place()
        self.draw()

    # ---- keys

    def action_hold(self) -> None:
        """Brakes axes along their path and stops the tasks; leaves a question."""
        if isinstance(self.screen, Question):
            self.screen.answer(None)
        self.session.hold()
        self._say("debug_held")

    def action_leave(self) -> None:
        """Hold, as from everywhere."""
        self.action_hold()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """In a text field Space and other keys of hold are typed, as on the main screen; Esc holds there too."""
        return not isinstance(self.focused, Input) if action == "hold" else True

    def action_resume(self) -> None:
        """Goes on: behind a hold where everything was, else all tasks."""
        if self.session.held:
            self.session.resume()
        else:
            self.session.go_all()
        self._say("")

    def action_step(self, what: Literal["into", "over", "out", "on"]) -> None:
        """A step, or the chosen task alone goes on; one that takes time goes on frame by frame."""
        if self.session.held:
            return self._say("debug_resume_first")
        if what == "on":
            self.session.go(self.number)
        else:
            self.session.views[self.number].ask(what)
        self.session.advance(FRAME_S)
        self._say("")

    def _say(self, message: str) -> None:
        key = next(key.shown for key in self.keys_table if key.action == "resume")
        self.message, self.follows = self.words(message, key=key) if message else "", True
        self.draw()

    def action_toggle_break(self) -> None:
        """At the cursor, or at the next statement behind it, where the cursor goes then."""
        place = self.session.toggle_break(self.number, self.cursor)
        self.message = self.words("debug_no_statement") if place is None else ""
        self.cursor, self.follows = place or self.cursor, False
        self.draw()

    def action_assign(self) -> None:
        """Asks for a new value of a variable."""
        button = HoldButton(self.look, self.words, self.action_hold, self.mouse)
        question = Question(self.words("debug_assign"), self.words("debug_assign_keys"), button, field=True)
        self.push_screen(question, self._assign)

    def _assign(self, text: str | None) -> None:
        self.message = ""
        if text:
            try:
                self.session.assign(self.number, text)
            except ValueError:
                self.message = f"{self.words('debug_not_set')}: {text}"
        self.draw()

    def action_current(self) -> None:
        self.follows = True
        self.draw()

    def action_move(self, by: int) -> None:
        self.follows = False
        self.cursor = max(1, min(len(self.session.lines(self.number)), self.cursor + by))
        self.draw()

    def action_next_task(self) -> None:
        numbers = [task.number for task in self.session.tasks]
        self.number = numbers[(numbers.index(self.number) + 1) % len(numbers)]
        self.action_current()

    def action_view(self) -> None:
        """One task with its variables, or all side by side."""
        self.side_by_side = not self.side_by_side
        self._show_view()
        self.call_after_refresh(self.draw)

    def action_help(self) -> None:
        self.helps = not self.helps
        self.draw()

    def _show_view(self) -> None:
        self.query_one("#one").display = not self.side_by_side
        self.query_one("#all").display = self.side_by_side
        self.query_one("#tasks").display = not self.side_by_side  # each says it itself there

    # ---- drawing

    def tick(self) -> None:
        """A frame: time passes while some task or axis is at work."""
        if self.session.works:
            self.session.advance(FRAME_S)
            self.draw()

    def draw(self) -> None:
        """Everything anew: a screen is a few dozen lines."""
        if not self.query("#head"):
            return  # a refresh that comes after the end
        session, look, words = self.session, self.look, self.words
        chosen = next(t for t in session.tasks if t.number == self.number)
        state = session.state(chosen)
        if self.follows and state.place:
            self.cursor = state.place
        hold = f"  = {words('debug_hold')}" if session.held else ""
        word = f"{panes.SYMBOLS[state.state]} {words(f'task_{state.state}')} {state.error}"
        what = f"{words('cnc_task')} {state.number}: {word}{hold}"
        head = f" [SIM]  {state.name}  {what}  {session.run.machine_time_s:.3f} s"
        self._put("head", Text(head, style=look.hold if session.held else look.bar, no_wrap=True))
        if self.side_by_side:
            for task in session.tasks:
                self._put(f"task{task.number}", self._pane(task.number))
        else:
            height = max(1, self.query_one("#source").size.height)
            text = (
                self.help()
                if self.helps
                else panes.source(session, self.number, look, (state.place, self.cursor), height)
            )
            self._put("source", text)
            self._put("variables", panes.variables(session, self.number, look))
        self._put("tasks", panes.tasks(session, self.number, look, words))
        self.query_one(HoldButton).moves = session.works
        self._put("output", panes.output(session, look, self.query_one("#output").size.height))
        keys = f" {self.message}" if self.message else line_text(self.keys_table, words, self.size.width)
        self._put("keys", Text(keys, style=look.bar, no_wrap=True))

    def _put(self, name: str, text: Text) -> None:
        self.query_one(f"#{name}", Static).update(text)

    def _pane(self, number: int) -> Text:
        """One of the tasks side by side: its state, then its source."""
        task = next(t for t in self.session.tasks if t.number == number)
        state = self.session.state(task)
        chosen = number == self.number
        head = panes.task_line(state, self.look, self.words, chosen=chosen)
        cursor = self.cursor if chosen else max(1, state.place)
        height = max(1, self.query_one(f"#task{number}").size.height - 1)
        text = (
            self.help()
            if self.helps and chosen
            else panes.source(self.session, number, self.look, (state.place, cursor), height)
        )
        return head.append("\n").append_text(text)

    def help(self) -> Text:
        """All keys."""
        return Text(help_text(self.keys_table, self.words), style=self.look.text)
