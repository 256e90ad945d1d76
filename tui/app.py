"""The application: passes what the engine reports to the widgets and what the operator wants to the engine."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import ClassVar

from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding
from textual.strip import Strip
from textual.theme import Theme
from textual.widgets import Input

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Engine, Job
from cnc_front.errors import CompileError, UsageError
from cnc_front.german import localized
from tui.dialogs import Question
from tui.frame import header, key_row, message_row, small_row
from tui.keys import KEYS, SETTLE_S
from tui.look import Look
from tui.messages import Messages
from tui.operation import HIGH, LOW, Operation
from tui.page import VIEWS, Areas, Parts, run_page, value_rows
from tui.panels import Changes, Check, alarm_rows, files_beginning, help_rows, jobs_rows, service_rows
from tui.plot import PathPicture
from tui.program import ProgramView, find_block
from tui.rows import Row
from tui.states import FACES
from tui.values import Shown
from tui.widgets import Body, PathField, Rows
from tui.words import Words

REFRESH_S = 0.1
#: Values older than this are stale.
STALE_S = 1.0
SMALLEST = (80, 24)
#: Rows of header, message line and key line.
FRAME = 3
#: When to look for the effect of a hold, s after the key.
ECHO_S = (0.015, 0.04)


@dataclass(frozen=True, slots=True)
class Switches:
    """Options of compilation that the header shows."""

    optional_stop: bool = False
    skip: bool = False


class Terminal(App[None]):
    """The operator's terminal."""

    ENABLE_COMMAND_PALETTE = False
    AUTO_FOCUS = None  # a text field gets keys only when the operator went there
    CSS = """
    Screen { layout: vertical; overflow: hidden; }
    Rows { height: 1; width: 100%; }
    #body { height: 1fr; }
    #path { display: none; height: 1; border: none; padding: 0 1; background: $background; color: $foreground; }
    #path:focus { border: none; }
    """
    BINDINGS: ClassVar = [
        Binding(key.keys, key.action, key.english, show=False, priority=key.everywhere) for key in KEYS
    ]

    def __init__(
        self,
        engine: Engine,
        look: Look,
        words: Words,
        *,
        job: str | None = None,
        switches: Switches | None = None,
        clock: Callable[[], datetime] = datetime.now,
        paced: bool = True,
        settle_s: float = SETTLE_S,
    ) -> None:
        """`paced`: draws by itself at 10 Hz; tests call `tick` instead. `clock`: the time of day."""
        super().__init__(ansi_color=look.name == "mono")
        if look.background:
            back, front = look.background, look.foreground
            dark = look.name == "dark"
            theme = Theme("cnc-front", primary=front, foreground=front, background=back, surface=back, dark=dark)
            self.register_theme(theme)
            self.theme = theme.name
        else:
            self.theme = "ansi-dark"
        self.engine, self.look, self.words, self.clock = engine, look, words, clock
        self._first_job, self._paced, self._settle_s = job, paced, settle_s
        self.switches = switches or Switches()
        self.messages = Messages(words)
        self.operation = Operation(engine, words, self.say)
        self.picture, self.program = PathPicture(look), ProgramView(look)
        self.job: Job | None = None
        self.check = Check()
        self.page, self.view = "run", "both"
        self.areas = Areas()
        self._changes = Changes()
        self._top = 0
        self._files: list[str] = []
        self._file = 0
        self._seen = (engine.snapshot(), time.monotonic())
        self._beat, self._pulse_s = time.monotonic(), REFRESH_S
        self._key_at = 0.0
        self._ticks = 0
        self._values: tuple[object, list[Strip]] = (None, [])

    def compose(self) -> ComposeResult:
        """Header, body, message line and key line stay in place on all pages."""
        yield Rows(self.look.bar, "header")
        yield PathField(id="path", compact=True, select_on_focus=False)
        yield Body(self.look.text, "body")
        yield Rows(self.look.text, "message")
        yield Rows(self.look.bar, "keys")

    def on_mount(self) -> None:
        """First frame, first job."""
        self.screen.set_focus(None)
        if self._first_job is not None:
            self.load(self._first_job)
        if self._paced:
            self.set_interval(REFRESH_S, self._beat_once)
        self.tick()

    # ---- drawing

    def _beat_once(self) -> None:
        """Draws in time, and notes how regular that is."""
        now = time.monotonic()
        self._pulse_s += 0.3 * (now - self._beat - self._pulse_s)
        self._beat = now
        self.tick()

    @property
    def is_behind(self) -> bool:
        """The terminal has not yet taken the frame before: a slow line. One more would only delay the keys."""
        writer = getattr(getattr(self._driver, "_writer_thread", None), "_queue", None)
        return writer is not None and not writer.empty()

    def shown(self) -> Shown:
        """What the engine reports now, and how old that is."""
        snapshot, now = self.engine.snapshot(), time.monotonic()
        if snapshot is not self._seen[0]:
            self._seen = (snapshot, now)
        age = now - self._seen[1]
        stale = age if self._paced and age > STALE_S else 0.0
        return Shown(snapshot, self.job, self.look, self.words, stale, self._pulse_s)

    def tick(self) -> None:
        """Draws one frame, unless the terminal is behind; the next regular one then shows what changed."""
        if not self.is_running or not self.screen_stack or self.is_behind:
            return
        self._ticks += 1
        shown, base = self.shown(), self.screen_stack[0]
        if self.job is not None:
            self.picture.driven(*self.engine.new_deviation(self.picture.reached))
        self.messages.watch(shown, self.clock())
        width, height = self.size
        small = width < SMALLEST[0] or height < SMALLEST[1]
        text, style, more = self.messages.current(shown, self.operation.is_armed)
        top, body = base.query_one("#header", Rows), base.query_one(Body)
        if small:
            top.put([small_row(shown, 0, width)])
            body.put([Row(self.look.text).strip(width)])
        else:
            top.put([self._header(shown, width)])
            body.put(self._body(shown, width, height - FRAME - (self.page == "jobs")))
        line = message_row(text, getattr(self.look, style), self.look, self.words, more, width)
        base.query_one("#message", Rows).put([line])
        base.query_one("#keys", Rows).put([key_row(self.look, self.words, width)])

    def _header(self, shown: Shown, width: int) -> Strip:
        on = self.switches
        switches = (("M01", on.optional_stop), ("SKP", on.skip), ("SB", shown.snapshot.single_block))
        warnings = len(self.job.warnings) + bool(self.picture.over) if self.job else 0
        return header(shown, switches, warnings, self.clock(), width)

    def _body(self, shown: Shown, width: int, height: int) -> list[Strip]:
        if self.page == "run":
            parts = Parts(shown, self.picture, self.program)
            rows, self.areas = run_page(parts, self._numbers(shown, width, height), self.view, width, height)
            return rows
        self.areas = Areas()
        if self.page == "jobs":
            return self._cut(jobs_rows(shown, self._files, self._file, self.check, width, height), width, height)
        if self.page == "help":
            rows = help_rows(self.look, self.words, width)
        elif self.page == "alarms":
            rows = alarm_rows(shown, self.messages.log, width)
        else:
            rows = service_rows(shown, self._changes, time.monotonic(), width)
        self._top = max(0, min(self._top, len(rows) - height))
        return self._cut(rows[self._top :], width, height)

    def _cut(self, rows: list[Strip], width: int, height: int) -> list[Strip]:
        return rows[:height] + [Row(self.look.text).strip(width)] * (height - len(rows))

    def _numbers(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """Numbers change at most at 5 Hz: faster nobody reads them; a change of state shows at once."""
        s = shown.snapshot
        key = (s.state, s.override_set, len(s.axes), shown.job, self.view, width, height, bool(shown.stale_s))
        if self._values[0] != key or self._ticks % 2 or not self._paced:
            self._values = (key, value_rows(shown, self.view, width, height))
        return self._values[1]

    def say(self, text: str) -> None:
        """Puts a message into the message line and the log."""
        self.messages.say(text, self.clock())

    # ---- loading, in a worker

    def load(self, path: str) -> None:
        """Compiles a job beside the screen; it replaces the loaded one if it has no errors."""
        if self.operation.is_underway:
            self.say(self.words("job_busy"))
            return
        self.say(self.words("loading", name=path[-50:]))
        self.run_worker(lambda: self._load(path), thread=True, exclusive=True, group="load")

    def _load(self, path: str) -> None:
        try:
            job = self.engine.load(path)
        except CompileError as error:
            self.call_from_thread(self._refused, path, localized(error.diagnostics, self.words.language))
        except (UsageError, OSError) as error:
            self.call_from_thread(self.say, f"{path}: {error}")
        else:
            self.call_from_thread(self._take, job)

    def _take(self, job: Job) -> None:
        self.job, self.check = job, Check(job.name, job)
        self.picture.take(job)
        self.program.take(job.lines)
        total = self.engine.snapshot().path_total_mm
        self.say(self.words("loaded", name=job.name, lines=len(job.lines), path=total))
        self.tick()

    def _refused(self, path: str, findings: tuple[Diagnostic, ...]) -> None:
        self.check = Check(path, None, findings)
        errors = [finding for finding in findings if not finding.is_warning] or list(findings)
        if errors:
            first = errors[0]
            place = f"{Path(first.file).name}:{first.line}:{first.column}:"
            more = f" {self.words('more_errors', n=len(errors) - 1)}" if len(errors) > 1 else ""
            self.say(self.words("load_failed", id=first.id, place=place, text=f"{first.message}{more}"))
        self.tick()

    # ---- keys: motion

    async def on_event(self, event: events.Event) -> None:
        """Remembers when a key was pressed, so that motion keys that waited too long can be dropped."""
        if isinstance(event, events.Key):
            self._key_at = event.time
        await super().on_event(event)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """In a text field Space is a blank; Tab belongs to the jobs page; questions take only what is everywhere."""
        if action == "hold":
            return not isinstance(self.focused, Input)
        if action == "complete":
            return self.page == "jobs" and len(self.screen_stack) == 1
        if action in {"reset", "ask_quit"}:
            return len(self.screen_stack) == 1
        return True

    def action_hold(self) -> None:
        """Feed hold; its effect shows at once, not with the next regular frame."""
        self.operation.hold()
        if self._paced:
            for seconds in ECHO_S:
                self.set_timer(seconds, self.tick)

    def action_escape(self) -> None:
        """Feed hold, and out of where one is."""
        self.action_hold()
        if isinstance(self.screen, Question):
            self.screen.answer(None)
        elif self.page != "run":
            self.action_show("run")

    def action_start(self) -> None:
        """Cycle start or resume."""
        self.program.choose(0)
        self.operation.start(time.monotonic() - self._key_at)

    def action_step(self) -> None:
        """One block."""
        self.program.choose(0)
        self.operation.step(time.monotonic() - self._key_at)

    def action_single_block(self) -> None:
        """Single block on or off."""
        self.operation.toggle_single_block()

    def action_reset(self) -> None:
        """Announces a reset."""
        self.operation.arm_reset()
        self.tick()

    def action_confirm(self) -> None:
        """Does what was announced."""
        self.operation.confirm()

    def action_override(self, percent: int) -> None:
        """Feed override by percent points."""
        self.operation.change_override(percent)

    def action_override_full(self) -> None:
        """Feed override 100 %."""
        self.operation.set_override(100)

    def action_override_value(self) -> None:
        """Asks for the feed override."""
        title = self.words("override_ask", low=LOW, high=HIGH)
        self._ask(title, self.words("field_keys"), self.operation.override_from)

    def action_speed(self, by: int) -> None:
        """Simulation speed."""
        self.operation.change_speed(by)

    def _ask(self, title: str, keys: str, then: Callable[[str], None], *, field: bool = True) -> None:
        def answered(text: str | None) -> None:
            if text is not None:
                then(text)

        self.push_screen(Question(title, keys, field=field, settle_s=self._settle_s), answered)

    def action_ask_quit(self) -> None:
        """Asks whether to end."""
        face = FACES[self.operation.state]
        title = self.words("quit_ask")
        if self.operation.is_underway:
            title += " " + self.words("quit_runs", state=self.words.pick(face.english, face.german))
        self._ask(title, self.words("quit_keys"), lambda _: self.exit(), field=False)

    def leave_from_thread(self) -> None:
        """Ends the program from another thread."""
        if self.is_running and self._loop is not None:
            self._loop.call_soon_threadsafe(self.exit)

    # ---- keys: looking

    def action_show(self, page: str) -> None:
        """Another page; text fields are left."""
        if len(self.screen_stack) > 1:
            return
        self.page, self._top = page, 0
        field = self.query_one("#path", Input)
        field.display = page == "jobs"
        if page == "jobs":
            field.border_title = None
            field.placeholder = self.words("jobs_title")
            field.focus()
            self._list(field.value)
        else:
            self.screen.set_focus(None)
        self.call_after_refresh(self.tick)

    def action_view(self) -> None:
        """The next view of the run page."""
        self.view = VIEWS[(VIEWS.index(self.view) + 1) % len(VIEWS)]
        self.tick()

    def action_fit(self) -> None:
        """The whole path."""
        self.picture.fit_all()
        self.tick()

    def action_zoom(self, steps: int) -> None:
        """Nearer or farther."""
        self.picture.zoom(steps)
        self.tick()

    def action_pan(self, x: int, y: int) -> None:
        """Moves the window on the path by a quarter."""
        area = self.areas.picture
        self.picture.pan(x * area.width // 4, y * area.height // 4)
        self.tick()

    def action_scroll(self, by: int) -> None:
        """Moves the cursor in the program or in the list of files, else the page."""
        if self.page == "run":
            self.program.move(by, self.engine.snapshot().line)
        elif self.page == "jobs":
            self._file = max(0, min(self._file + by, len(self._files) - 1))
        else:
            self._top += by
        self.tick()

    def action_current(self) -> None:
        """Back to the current block."""
        self.program.choose(0)
        self.tick()

    def action_goto(self) -> None:
        """Asks for a block."""
        if self.job is None:
            self.say(self.words("goto_job"))
        else:
            self._ask(self.words("goto"), self.words("field_keys"), self._go_to)

    def _go_to(self, text: str) -> None:
        line = find_block(self.job.lines, text) if self.job else None
        if line is None:
            self.say(self.words("goto_none", text=text.strip()[:20]))
        else:
            self.page = "run"
            self.program.choose(line)
        self.tick()

    def action_next_message(self) -> None:
        """The next message."""
        self.messages.next()
        self.tick()

    # ---- jobs page

    def _list(self, text: str) -> None:
        self._files, self._file = files_beginning(text), 0

    def on_input_changed(self, event: Input.Changed) -> None:
        """Lists what begins with what was typed."""
        if event.input.id == "path":
            self._list(event.value)
            self.tick()

    def action_complete(self) -> None:
        """Takes the chosen file into the text field."""
        if self._files:
            field = self.query_one("#path", Input)
            field.value = self._files[self._file]
            field.cursor_position = len(field.value)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Opens the chosen file, or exactly what was typed; a folder is entered."""
        if self.operation.confirm():
            return
        path = self._files[self._file] if self._files else event.value.strip()
        if path.endswith("/"):
            self.action_complete()
        elif path:
            self.load(path)

    # ---- mouse

    def on_body_clicked(self, event: Body.Clicked) -> None:
        """A click chooses a block, in the program or by its path."""
        if self.areas.program.contains(event.x, event.y):
            line = self.program.line_at(event.y - self.areas.program.y)
        elif self.areas.picture.contains(event.x, event.y):
            line = self.picture.line_at(event.x - self.areas.picture.x, event.y - self.areas.picture.y)
        else:
            line = None
        if line is not None:
            self.program.choose(line)
            self.tick()

    def on_body_wheel(self, event: Body.Wheel) -> None:
        """The wheel zooms the path and scrolls what else there is."""
        if self.areas.picture.contains(event.x, event.y):
            self.action_zoom(-event.by)
        else:
            self.action_scroll(3 * event.by)

    def on_body_dragged(self, event: Body.Dragged) -> None:
        """Dragging moves the window on the path."""
        if self.areas.picture.contains(event.x, event.y):
            self.picture.pan(-event.dx, event.dy)
            self.tick()

    def on_resize(self) -> None:
        """Another size, another layout: at once."""
        self.call_after_refresh(self.tick)
