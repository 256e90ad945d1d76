"""The operator's terminal. It shows what the engine reports and passes wishes on; nothing here moves an axis."""

from __future__ import annotations

import contextlib
import signal
import time
from pathlib import Path
from typing import ClassVar, TypeVar

import numpy as np
from rich.style import Style
from textual.app import App, ComposeResult
from textual.binding import Binding
from textual.containers import Container
from textual.widget import Widget
from textual.widgets import Input

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Engine, Job, Snapshot, State
from cnc_front.errors import CompileError, UsageError
from tui import lines
from tui.dialogs import Ask, Page
from tui.lines import Shown
from tui.looks import Line, palette
from tui.raster import Raster, grades
from tui.widgets import Lines, PathPlotView, ProgramView
from tui.words import Say

W = TypeVar("W", bound=Widget)
REFRESH_HZ = 10
#: Seconds that a reset stays armed.
ARMED_S = 3.0
SPEEDS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 0.0)
OVERRIDES = (0.05, 2.0)
VIEWS = ("both", "path", "values")
MINIMUM = (80, 24)


class Terminal(App[int]):
    """The Run screen and its dialogs."""

    CSS_PATH = "terminal.tcss"
    ENABLE_COMMAND_PALETTE = False
    ESCAPE_TO_MINIMIZE = False
    BINDINGS: ClassVar = [
        Binding("space", "hold_key(' ')", priority=True),
        Binding("escape", "hold_key('')", priority=True),
        Binding("ctrl+x", "arm_reset", priority=True),
        Binding("ctrl+q", "ask_quit", priority=True),
        ("r", "start"), ("t", "step"), ("b", "single_block"),
        ("plus", "override(0.05)"), ("minus", "override(-0.05)"), ("asterisk", "override(0)"),
        ("equals_sign", "ask_override"), ("full_stop", "speed(1)"), ("comma", "speed(-1)"),
        ("v", "view"), ("f", "fit"), ("z", "zoom(1.5)"), ("Z", "zoom(0.6667)"),
        ("up", "scroll(-1)"), ("down", "scroll(1)"), ("pageup", "scroll(-15)"), ("pagedown", "scroll(15)"),
        ("g", "ask_line"), ("n", "next_message"),
        ("f1", "help"), ("question_mark", "help"), ("f2", "ask_job"), ("o", "ask_job"), ("f3", "run_screen"),
        ("f6", "alarms"), ("enter", "confirm"),
    ]  # fmt: skip

    def __init__(self, engine: Engine, *, language: str = "en", theme: str = "dark", glyphs: str = "quadrant",
                 job: str | None = None, clock: bool = True) -> None:  # fmt: skip
        """`job` is loaded at once; it never starts by itself."""
        super().__init__()
        self.engine = engine
        self.say = Say(language)
        self.job: Job | None = None
        self._first_job = job
        self._looks_theme = theme
        self._looks: dict[str, Style] = palette(theme)
        self._glyphs = glyphs
        self._clock = clock
        self._view = "both"
        self._driven = 0
        self._armed_until = 0.0
        self._messages: list[tuple[str, str]] = [(self.say("estop"), "soft")]
        self._message_at = 0
        self._last: Snapshot | None = None
        self._last_change = 0.0
        self._alarms_seen = 0
        self._asked = _Asked()

    # ---- layout

    def compose(self) -> ComposeResult:
        """Header, values, program, path, message and key line."""
        self.add_class(f"theme-{self._looks_theme}")
        yield Lines("header", self._looks)
        with Container(id="body"):
            yield Lines("values", self._looks)
            yield ProgramView(self._looks)
            yield PathPlotView(self._looks)
        yield Lines("message", self._looks)
        yield Lines("keys", self._looks, "panel")

    def on_mount(self) -> None:
        """Connects the lines to the engine and begins to look at it."""
        self._find("#header", Lines).source = lambda width: [self._header(width)]
        self._find("#values", Lines).source = lambda width: lines.values(self._shown(), width)
        self._find("#message", Lines).source = lambda width: [self._message_line()]
        self._find("#keys", Lines).source = lambda width: [lines.keys(self._shown(), width)]
        with contextlib.suppress(AttributeError, ValueError):  # no SIGHUP here, or not the main thread
            signal.signal(signal.SIGHUP, self._hang_up)
        self._layout()
        self.set_interval(1 / REFRESH_HZ, self.look)
        if self._first_job is not None:
            self.load(self._first_job)

    def on_resize(self) -> None:
        """Another size may mean another layout."""
        self._layout()

    @property
    def _wide(self) -> bool:
        return self.size.width >= 110 and self.size.height >= 34

    def _layout(self) -> None:
        small = self.size.width < MINIMUM[0] or self.size.height < MINIMUM[1]
        for name, on in (("wide", self._wide), ("small", small), *((f"view-{v}", v == self._view) for v in VIEWS)):
            self.screen_stack[0].set_class(on, name)
        body, program, plot = self._find("#body", Container), self._find(ProgramView), self._find(PathPlotView)
        # the grid is filled in order: wide, the plot stands beside both; narrow, right of the program
        if self._wide:
            body.move_child(plot, before=program)
        else:
            body.move_child(plot, after=program)
        self.call_after_refresh(self.look)

    def _find(self, selector: str | type[W], kind: type[W] | None = None) -> W:
        """A widget of the Run screen, also while a dialog stands before it."""
        base = self.screen_stack[0]
        return base.query_one(selector, kind) if kind is not None else base.query_one(selector)  # type: ignore[arg-type,return-value]

    def _shown(self) -> Shown:
        stale = self._last is not None and time.monotonic() - self._last_change > 1.0
        moving = self._last is not None and self._last.state in (State.RUNNING, State.HOLDING)
        clock = time.strftime("%H:%M:%S") if self._clock else ""
        return Shown(self.engine.snapshot(), self.job, self.say, self._wide, stale and moving, clock)

    def _header(self, width: int) -> Line:
        shown = self._shown()
        if width < MINIMUM[0] or self.size.height < MINIMUM[1]:
            symbol, style, word = self.say.state(shown.snapshot.state.value)
            alarms = f"! {len(shown.snapshot.alarms)} "
            return [(f"[SIM] {symbol} {word} ", style), (alarms, "bad"), ("SPACE " + self.say("key_hold"), "inverse"),
                    (" " + self.say("too_small"), "warn")]  # fmt: skip
        return lines.header(shown, width)

    # ---- looking at the engine

    def look(self) -> None:
        """Takes over what the engine reports now; changed regions are drawn."""
        snapshot = self.engine.snapshot()
        if snapshot != self._last:
            self._last, self._last_change = snapshot, time.monotonic()
        program = self._find(ProgramView)
        program.cursor = snapshot.line
        if self.job is not None and snapshot.deviation_max_mm > self.job.tolerance_mm:
            program.mark(snapshot.deviation_max_line, f"!{snapshot.deviation_max_mm * 1e3:.1f}um")
        self._take_alarms(snapshot)
        self._draw_path(snapshot)
        if self._armed_until and time.monotonic() > self._armed_until:
            self._armed_until = 0.0
        for name in ("header", "values", "message", "keys"):
            self._find(f"#{name}", Lines).update()

    def _take_alarms(self, snapshot: Snapshot) -> None:
        for alarm in snapshot.alarms[self._alarms_seen :]:
            place = f"{alarm.axis} {self.say('line')} {alarm.line}" if alarm.line else alarm.axis
            self.tell(f"{alarm.code} {place} {alarm.text}", "bad")
        self._alarms_seen = len(snapshot.alarms)

    def _draw_path(self, snapshot: Snapshot) -> None:
        plot = self._find(PathPlotView)
        if plot.raster is None or self.job is None:
            return
        reached, values = self.engine.new_deviation(self._driven)
        first = self._driven if reached >= self._driven else 0
        if reached < self._driven:
            plot.raster.reset()
        changed = len(values) > 0 or reached < self._driven
        # the vertex being approached may still grow worse: it is drawn again next time
        self._driven = max(0, reached - 1)
        plot.raster.drive(first, grades(np.asarray(values), self.job.tolerance_mm))
        where = {axis.name: axis.actual for axis in snapshot.axes}
        tool = (where.get(self.job.plot.axes[0], 0.0), where.get(self.job.plot.axes[1], 0.0))
        if changed or tool != plot.tool:
            plot.tool = tool
            plot.redraw()
        self._title(plot, plot.raster)

    def _title(self, plot: PathPlotView, raster: Raster) -> None:
        assert self.job is not None
        axes, tolerance = "".join(self.job.plot.axes[:2]), self.job.tolerance_mm * 1e3
        by = f"   {self.say('by_deviation')}" if self._wide else ""
        plot.title = [(f"{self.say('path')} {axes}{by}", "soft")]
        plot.legend = [
            (f". {self.say('todo')}  ", "todo"), (f"- <={tolerance / 2:g}  ", "good"), (f"* <={tolerance:g}  ", "warn"),
            (f"# >{tolerance:g} um  ", "bad"), (f"@ {self.say('tool')}", "text"),
            (f"  {self.say('col')} {raster.view.mm_per_column:.3g} mm" if self._wide else "", "soft"),
        ]  # fmt: skip

    # ---- messages

    def tell(self, text: str, style: str = "text") -> None:
        """A new message; it shows at once."""
        self._messages.append((text, style))
        del self._messages[:-200]
        self._message_at = len(self._messages) - 1

    def _message_line(self) -> Line:
        snapshot = self.engine.snapshot()
        if self._armed_until:
            return [(f" ! {self.say('reset_armed')}", "warn_inverse")]
        if self.job is None and len(self._messages) == 1:
            return [(" " + self.say("no_job"), "text")]
        if snapshot.message and self._message_at == len(self._messages) - 1 and self._messages[-1][1] != "bad":
            return [(f" {snapshot.message}", "text")]
        text, style = self._messages[self._message_at]
        more = (
            f"   {self._message_at + 1}/{len(self._messages)} {self.say('details')}" if len(self._messages) > 1 else ""
        )
        room = max(0, self.size.width - len(more) - 1)
        return [(f" {text}"[:room].ljust(room), style), (more, "soft")]

    def action_next_message(self) -> None:
        """Goes through the messages."""
        self._message_at = (self._message_at + 1) % len(self._messages)
        self.look()

    # ---- jobs

    def load(self, path: str) -> None:
        """Compiles a job in a worker; no motion starts."""
        self.tell(self.say("loading", name=Path(path).name), "soft")
        self.run_worker(lambda: self._load(path), thread=True, exclusive=True, group="load")

    def _load(self, path: str) -> None:
        try:
            job = self.engine.load(path)
        except CompileError as error:
            self.call_from_thread(self._refuse, [_one_line(d) for d in error.diagnostics])
        except (UsageError, OSError) as error:
            self.call_from_thread(self._refuse, [str(error)])
        else:
            self.call_from_thread(self._take, job)

    def _refuse(self, texts: list[str]) -> None:
        for text in reversed(texts[:50]):
            self.tell(text, "bad")

    def _take(self, job: Job) -> None:
        self.job, self._driven, self._alarms_seen = job, 0, 0
        self._find(ProgramView).show(job.lines)
        raster = Raster(np.ascontiguousarray(job.plot.points[:, :2]), job.plot.rapid, self._glyphs)
        self._find(PathPlotView).show(raster)
        for warning in reversed(job.warnings[:50]):
            self.tell(warning, "warn")
        counts = {"name": job.name, "lines": len(job.lines), "warnings": len(job.warnings)}
        self.tell(self.say("loaded", **counts), "text")
        self._layout()

    # ---- wishes of the operator

    def action_hold_key(self, text: str) -> None:
        """Space and Esc. In a text field Space is a blank; Esc leaves the dialog and holds."""
        if text and isinstance(self.focused, Input):
            self.focused.insert_text_at_cursor(text)
            return
        self.engine.hold()
        if not text and len(self.screen_stack) > 1:
            self.pop_screen()
        if self.engine.snapshot().state in (State.RUNNING, State.HOLDING, State.WAITING):
            self.tell(self.say("held"), "warn")
        self._armed_until = 0.0
        self.look()

    def action_start(self) -> None:
        """r: start, or go on."""
        self._find(ProgramView).follow()
        if self.engine.snapshot().state in (State.HOLD, State.HOLDING, State.STEP, State.STOPPED):
            self.engine.resume()
        else:
            self.engine.start()
        self.look()

    def action_step(self) -> None:
        """t."""
        self._find(ProgramView).follow()
        self.engine.step()

    def action_single_block(self) -> None:
        """b."""
        self.engine.set_single_block(not self.engine.snapshot().single_block)

    def action_override(self, change: float) -> None:
        """+ - *."""
        now = self._asked.recent("override", self.engine.snapshot().override_set)
        factor = 1.0 if change == 0 else min(max(round(now + change, 2), OVERRIDES[0]), OVERRIDES[1])
        self._asked.note("override", factor)
        self.engine.set_override(factor)

    def action_speed(self, step: int) -> None:
        """, and . go through the simulation speeds; the last is as fast as possible."""
        now = self._asked.recent("speed", self.engine.snapshot().speed_factor)
        place = SPEEDS.index(now) if now in SPEEDS else SPEEDS.index(1.0)
        speed = SPEEDS[min(max(place + step, 0), len(SPEEDS) - 1)]
        self._asked.note("speed", speed)
        self.engine.set_speed(speed)

    def action_arm_reset(self) -> None:
        """Ctrl+X; Enter within 3 s does it."""
        self._armed_until = time.monotonic() + ARMED_S
        self.look()

    def action_confirm(self) -> None:
        """Enter."""
        if self._armed_until and time.monotonic() <= self._armed_until:
            self.engine.reset()
            self._armed_until = 0.0
            self.tell(self.say("reset_done"), "warn")
            self.look()

    # ---- views and dialogs

    def action_view(self) -> None:
        """v."""
        self._view = VIEWS[(VIEWS.index(self._view) + 1) % len(VIEWS)]
        self._layout()

    def action_fit(self) -> None:
        """f."""
        self._find(PathPlotView).fit()

    def action_zoom(self, factor: float) -> None:
        """z and Z."""
        self._find(PathPlotView).zoom(factor)

    def action_scroll(self, rows: int) -> None:
        """Looks through the program."""
        self._find(ProgramView).scroll(rows)

    def action_run_screen(self) -> None:
        """F3: back to the Run screen."""
        while len(self.screen_stack) > 1:
            self.pop_screen()

    def action_help(self) -> None:
        """F1."""
        texts = [f"{key:<14} {what}" for key, what in self.say.help()]
        self._page(self.say("key_help"), [*texts, "", self.say("estop")])

    def action_alarms(self) -> None:
        """F6."""
        alarms = self.engine.snapshot().alarms
        texts = [f"{a.t_s:9.3f} s  {a.code} {a.axis} {self.say('line')} {a.line}  {a.text}" for a in alarms]
        self._page(self.say("alarms"), texts or [self.say("no_alarms")])

    def _page(self, title: str, texts: list[str]) -> None:
        if len(self.screen_stack) == 1:
            self.push_screen(Page(title, texts))

    def action_ask_quit(self) -> None:
        """Ctrl+Q asks."""
        if len(self.screen_stack) == 1:
            page = Page(self.say("quit_title"), [], self.say("enter_quit"), asks=True)
            self.push_screen(page, lambda yes: self.exit(0) if yes else None)

    def action_ask_job(self) -> None:
        """F2."""
        self._ask("open_title", lambda text: self.load(text) if text else None)

    def action_ask_line(self) -> None:
        """g."""
        self._ask("goto_title", self._go_to)

    def action_ask_override(self) -> None:
        """=."""
        self._ask("override_title", self._take_override, f"{self.engine.snapshot().override_set * 100:g}")

    def _ask(self, title: str, take, value: str = "") -> None:  # type: ignore[no-untyped-def]  # a callback of text
        if len(self.screen_stack) == 1:
            ask = Ask(self.say(title), self.say("enter_esc"), value)
            self.push_screen(ask, lambda text: take(text.strip()) if text is not None else None)

    def _go_to(self, text: str) -> None:
        count = len(self.job.lines) if self.job is not None else 0
        if text.isdecimal() and 1 <= int(text) <= count:
            self._find(ProgramView).look(int(text))
        else:
            self.tell(self.say("no_line", text=text), "warn")

    def _take_override(self, text: str) -> None:
        try:
            factor = float(text) / 100
        except ValueError:
            self.tell(self.say("bad_value", text=text), "warn")
            return
        self.engine.set_override(min(max(factor, OVERRIDES[0]), OVERRIDES[1]))

    def on_program_view_selected(self, message: ProgramView.Selected) -> None:
        """A click in the program tells the block."""
        if self.job is not None and message.line <= len(self.job.lines):
            self.tell(f"{self.say('line')} {message.line}: {self.job.lines[message.line - 1].strip()}", "text")

    # ---- the end

    def _hang_up(self, *_: object) -> None:
        """A closed terminal holds (ui-guide section 4); a slow or frozen one does not."""
        self.engine.hold()
        deadline = time.monotonic() + 2.0
        while self.engine.snapshot().state in (State.RUNNING, State.HOLDING) and time.monotonic() < deadline:
            time.sleep(0.01)
        self.exit(129)


class _Asked:
    """What was asked for within the last moment: keys that come faster than the engine answers add up."""

    def __init__(self) -> None:
        self._values: dict[str, tuple[float, float]] = {}

    def note(self, name: str, value: float) -> None:
        """A wish that is on its way."""
        self._values[name] = (value, time.monotonic())

    def recent(self, name: str, reported: float) -> float:
        """The wish if it is fresh, else what the engine reports."""
        value, at = self._values.get(name, (reported, 0.0))
        return value if time.monotonic() - at < 0.5 else reported


def _one_line(diagnostic: Diagnostic) -> str:
    hint = f" ({diagnostic.hint})" if diagnostic.hint else ""
    return f"{diagnostic.line}:{diagnostic.column} {diagnostic.id} {diagnostic.message}{hint}"
