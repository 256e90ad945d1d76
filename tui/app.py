"""The application: passes what the engine reports to the widgets and what the operator wants to the engine."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding
from textual.strip import Strip
from textual.theme import Theme
from textual.widgets import Input

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Engine, Job, Snapshot, State
from cnc_front.errors import CompileError, UsageError
from cnc_front.german import localized, refusal
from tui.archive import Archive
from tui.dialogs import Question
from tui.frame import header, key_row, message_row, small_row
from tui.hold_button import HoldButton, buttons
from tui.keeper import Keeper
from tui.keys import KEYS, SETTLE_S, Key
from tui.loading import Loading
from tui.look import Look
from tui.messages import Messages
from tui.motion_keys import MotionKeys
from tui.operation import Operation
from tui.pages import PAGES, Page
from tui.pages.jobs import Check, JobsPage
from tui.plot import PathPicture
from tui.program import ProgramView, find_block, find_text
from tui.rows import Row
from tui.states import MOVING
from tui.values import Shown
from tui.widgets import Body, Rows
from tui.words import Words

if TYPE_CHECKING:
    from tui.viewer import Viewer

REFRESH_S = 0.1
#: Values older than this are stale.
STALE_S = 1.0
SMALLEST = (80, 24)
#: Rows of header, message line and key line.
FRAME = 3


class Terminal(MotionKeys):
    """The operator's terminal."""

    ENABLE_COMMAND_PALETTE = False
    AUTO_FOCUS = None  # a text field gets keys only when the operator went there
    CSS = """
    Screen { layout: vertical; overflow: hidden; layers: default above; }
    Rows { height: 1; width: 100%; }
    #body { height: 1fr; }
    .field { display: none; height: 1; border: none; padding: 0 1; background: $background; color: $foreground; }
    .field:focus { border: none; }
    """
    BINDINGS: ClassVar = [
        Binding(key.keys, key.target, key.english, show=False, priority=key.everywhere) for key in KEYS
    ]

    def __init__(
        self,
        engine: Engine,
        look: Look,
        words: Words,
        *,
        job: str | None = None,
        clock: Callable[[], datetime] = datetime.now,
        paced: bool = True,
        settle_s: float = SETTLE_S,
        archive: Archive | None = None,
        keys: Sequence[Key] = KEYS,
        viewer: Viewer | None = None,
        mouse: bool = True,
    ) -> None:
        """`archive`: the history (None: nothing is kept). `keys`: the table with what a keymap changed.
        `viewer`: mirrors the screen in a browser. `mouse`: it is ours, so there is a button that holds.

        `paced`: draws by itself at 10 Hz; tests call `tick` instead. `clock`: the time of day."""
        super().__init__(ansi_color=look.is_ansi)
        if not look.is_ansi:
            back, front = look.background, look.foreground
            dark = look.name == "dark"
            theme = Theme("cnc-front", primary=front, foreground=front, background=back, surface=back, dark=dark)
            self.register_theme(theme)
            self.theme = theme.name
        else:
            self.theme = "ansi-dark"
        self.keys_table, self.viewer, self.mouse = keys, viewer, mouse
        self._bind(keys)
        self.engine, self.look, self.words, self.clock = engine, look, words, clock
        self._first_job, self.paced, self.settle_s = job, paced, settle_s
        self.messages = Messages(words)
        self.loading = Loading()
        self.operation = Operation(engine, words, self.say)
        self.keeper = Keeper(engine, archive or Archive(None, words.language), self.say)
        self.picture, self.program = PathPicture(look), ProgramView(look)
        self.job: Job | None = None
        self._revision = self._told = 0
        self.pages: dict[str, Page] = {page.name: page(self) for page in PAGES}
        self.page = self.pages["run"]
        self.operation.stopped = self.jobs.queue.held
        self._seen = (engine.snapshot(), time.monotonic())
        self._beat, self._pulse_s = time.monotonic(), REFRESH_S
        self.key_at = 0.0

    def _bind(self, keys: Sequence[Key]) -> None:
        """Gives actions their keys of a keymap."""
        for key, usual in zip(keys, KEYS, strict=True):
            if key.keys != usual.keys:
                bound = self._bindings.key_to_bindings
                for name, bindings in list(bound.items()):
                    bound[name] = [binding for binding in bindings if binding.action != key.target]
                self._bindings.bind(key.keys, key.target, key.english, show=False, priority=key.everywhere)

    def compose(self) -> ComposeResult:
        """Header, body, message line and key line stay in place on all pages."""
        yield Rows(self.look.bar, "header")
        for page in self.pages.values():
            if page.field is not None:
                page.field.add_class("field")
                yield page.field
        yield Body(self.look.text, "body")
        yield Rows(self.look.text, "message")
        yield Rows(self.look.bar, "keys")
        yield HoldButton(self.look, self.words, self.action_hold, self.mouse)

    def on_mount(self) -> None:
        """First frame, first job."""
        self.screen.set_focus(None)
        if self.viewer is not None:
            self.say(self.words("viewed", port=self.viewer.port))
        if self._first_job is not None:
            self.load(self._first_job)
        if self.paced:
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
        stale = age if self.paced and age > STALE_S else 0.0
        return Shown(snapshot, self.job, self.look, self.words, stale, self._pulse_s)

    def tick(self) -> None:
        """Draws one frame, unless the terminal is behind; the next regular one then shows what changed."""
        if not self.is_running or not self.screen_stack or self.is_behind:
            return
        shown, base = self.shown(), self.screen_stack[0]
        if shown.snapshot.revision != self._revision:
            self._take(shown.snapshot.revision)
            shown = self.shown()
        if self.job is not None:
            self.picture.driven(*self.engine.new_deviation(self.picture.reached))
        self.messages.watch(shown, self.clock())
        self._tell_verdict(shown.snapshot)
        self.keeper.watch(shown, self.clock())
        self.jobs.queue.watch(shown.snapshot, self.engine.outcome())
        width, height = self.size
        small = width < SMALLEST[0] or height < SMALLEST[1]
        self.messages.activity = self.loading.text(self.words)
        text, style, more = self.messages.current(shown, self.operation.is_armed, width)
        top, body = base.query_one("#header", Rows), base.query_one(Body)
        if small:
            top.put([small_row(shown, 0, width)])
            body.put([Row(self.look.text).strip(width)])
        else:
            top.put([self._header(shown, width)])
            body.put(self.page.visible(shown, width, height - FRAME - (self.page.field is not None)))
        room = width - base.query_one(HoldButton).room
        for button in buttons(self):
            button.moves = shown.snapshot.state in MOVING
        line = message_row(text, getattr(self.look, style), self.look, self.words, more, room)
        base.query_one("#message", Rows).put([line])
        if self.viewer is not None and self.viewer.is_watched:
            self.viewer.show(self.screen._compositor.render_strips())
        base.query_one("#keys", Rows).put([key_row(self.look, self.words, room, self.keys_table, self.page.name)])

    def _header(self, shown: Shown, width: int) -> Strip:
        on = shown.snapshot.switches
        switches = (
            ("PRT", on.program_test),
            ("DRY", on.dry_run),
            ("M01", on.optional_stop),
            ("SKP", bool(on.skip)),
            ("SB", shown.snapshot.single_block),
        )
        more = self.job.check.more_findings if self.job and self.job.check else 0
        warnings = len(self.job.warnings) + more + bool(self.picture.over) if self.job else 0
        return header(shown, switches, warnings, self.clock(), width)

    def _tell_verdict(self, snapshot: Snapshot) -> None:
        """A job that came to its end need not have kept to its path: DONE is no verdict."""
        outcome = self.engine.outcome()
        if (
            outcome is not None
            and outcome.number != self._told
            and snapshot.state is State.DONE
            and not snapshot.replay
        ):
            self._told = outcome.number
            verdict = (outcome.run.get("verdict") or {}).get("word", "")
            self.say(self.words("ended", name=Path(outcome.path).name, verdict=verdict))

    def say(self, text: str) -> None:
        """Puts a message into the message line and the log."""
        self.messages.say(text, self.clock())

    # ---- loading, in a worker

    def load(self, path: str) -> None:
        """Compiles a job beside the screen; it replaces the loaded one if it has no errors."""
        if self.operation.is_underway and not self.engine.snapshot().replay:
            self.say(self.words("job_busy"))
            return
        wanted = self.loading.begin(path)
        self.run_worker(lambda: self._load(path, wanted), thread=True, exclusive=True, group="load")

    def _load(self, path: str, wanted: Callable[[], bool]) -> None:
        done: Callable[[], None]
        try:
            job = self.engine.load(path, wanted)
        except CompileError as error:
            findings = localized(error.diagnostics, self.words.language)
            done = partial(self._refused, path, findings)
        except (UsageError, OSError) as error:
            said = f"{path}: {refusal(error, self.words.language)}"
            done = partial(self.say, said)
        else:
            done = partial(self._loaded, job)
        self.call_from_thread(self._load_ended, wanted, done)

    def _load_ended(self, wanted: Callable[[], bool], done: Callable[[], None]) -> None:
        """Says what became of a load, if somebody still wants to know."""
        if wanted():
            self.loading.end()
            done()
            self.tick()

    def _loaded(self, job: Job) -> None:
        self.say(self.words("loaded", name=job.name, lines=len(job.lines), path=job.path_mm))
        if self.engine.snapshot().replay:
            self.action_show("run")

    def _take(self, revision: int) -> None:
        """The engine has another job, or has checked it again."""
        job = self.engine.current_job()
        self._revision = revision
        self.job = job
        if job is None:  # a recording was put away
            self.picture = PathPicture(self.look)
            self.program.take(())
            return
        gc.freeze()  # a program of a million lines must not be walked through at every collection
        self.jobs.check = Check(job.name, job)
        self.picture.take(job)
        self.program.take(job.lines)

    @property
    def jobs(self) -> JobsPage:
        """The page with the load check and the queue."""
        page = self.pages["jobs"]
        assert isinstance(page, JobsPage)
        return page

    def _refused(self, path: str, findings: tuple[Diagnostic, ...]) -> None:
        self.jobs.check = Check(path, None, findings)
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
            self.key_at = event.time
        await super().on_event(event)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """In a text field Space is a blank; keys of a page count only there; questions take what is everywhere."""
        if action == "hold":
            return not isinstance(self.focused, Input)
        if action == "on_page":
            return bool(parameters) and parameters[0] == self.page.name and len(self.screen_stack) == 1
        if action in {"reset", "ask_quit"}:
            return len(self.screen_stack) == 1
        return True

    def action_escape(self) -> None:
        """Feed hold, and out of where one is."""
        self.action_hold()
        if self.loading.is_active:
            self.say(self.words("load_let_go", name=self.loading.name))
            self.loading.end()
        elif isinstance(self.screen, Question):
            self.screen.answer(None)
        elif not self.page.escape() and self.page.name != "run":
            self.action_show("run")

    # ---- keys: looking

    def action_show(self, name: str) -> None:
        """Another page; text fields are left."""
        if len(self.screen_stack) > 1:
            return
        self.page.leave()
        self.screen.set_focus(None)
        self.page = self.pages[name]
        for page in self.pages.values():
            if page.field is not None:
                page.field.display = page is self.page
        self.page.enter()
        self.call_after_refresh(self.tick)

    def action_on_page(self, _: str, name: str, arguments: tuple[int, ...]) -> None:
        """A key of the page that is shown."""
        getattr(self.page, f"key_{name}")(*arguments)
        self.tick()

    def action_scroll(self, by: int) -> None:
        """Arrows and page keys belong to the page."""
        self.page.scroll(by)
        self.tick()

    def action_goto(self) -> None:
        """Asks for a block."""
        if self.job is None:
            self.say(self.words("goto_job"))
        else:
            self.ask(self.words("goto"), self.words("field_keys"), self._go_to)

    def _go_to(self, text: str) -> None:
        line = find_block(self.job.lines, text) if self.job else None
        if line is None:
            self.say(self.words("goto_none", text=text.strip()[:20]))
        else:
            self.action_show("run")
            self.program.choose(line)
        self.tick()

    def action_find(self) -> None:
        """Asks for a text of the program."""
        if self.job is None:
            self.say(self.words("goto_job"))
        else:
            self.ask(self.words("find"), self.words("field_keys"), self._find)

    def _find(self, text: str) -> None:
        line = find_text(self.program.lines, text, self.program.chosen) if text else None
        if line is None:
            self.say(self.words("find_none", text=text.strip()[:20]))
        else:
            self.action_show("run")
            self.program.choose(line)
        self.tick()

    def on_app_blur(self) -> None:
        """The terminal window has lost the focus: jogging ends, as on a change of the page."""
        self.page.leave()

    def action_next_message(self) -> None:
        """The next message."""
        self.messages.next()
        self.page.next()
        self.tick()

    # ---- what belongs to the page

    def on_input_changed(self, event: Input.Changed) -> None:
        """Its text field."""
        if event.input is self.page.field:
            self.page.typed(event.value)
            self.tick()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Enter in its text field, unless a reset was announced."""
        if not self.operation.confirm():
            self.page.submitted(event.value)
            self.tick()

    def on_body_clicked(self, event: Body.Clicked) -> None:
        """Mouse: click."""
        self.page.clicked(event)
        self.tick()

    def on_body_wheel(self, event: Body.Wheel) -> None:
        """Mouse: wheel."""
        self.page.wheel(event)
        self.tick()

    def on_body_dragged(self, event: Body.Dragged) -> None:
        """Mouse: drag."""
        self.page.dragged(event)
        self.tick()

    def on_resize(self) -> None:
        """Another size, another layout: at once."""
        self.call_after_refresh(self._resized)

    def _resized(self) -> None:
        for button in buttons(self):
            button.place()
        self.tick()
