"""Keys that act on the machine: what they ask of `Operation`, and what they ask the operator first."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from textual.app import App

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Engine
from cnc_front.errors import CompileError, UsageError
from cnc_front.german import localized, refusal
from cnc_front.search import Start, start_text
from tui.dialogs import Question
from tui.hold_button import HoldButton
from tui.look import Look
from tui.operation import HIGH, LOW, Operation
from tui.program import ProgramView, block_name, find_block
from tui.states import FACES
from tui.words import Words

if TYPE_CHECKING:
    from tui.pages import Page

#: When to look for the effect of a hold, s after the key.
ECHO_S = (0.015, 0.04)


class MotionKeys(App[None]):
    """The part of the application behind the keys of ui-guide section 3 that move something."""

    engine: Engine
    words: Words
    look: Look
    #: whether the mouse is ours
    mouse: bool
    operation: Operation
    program: ProgramView
    page: Page
    paced: bool
    settle_s: float
    key_at: float

    def say(self, text: str) -> None:
        """Puts a message into the message line and the log."""

    def tick(self) -> None:
        """Draws one frame."""

    @property
    def waited_s(self) -> float:
        """Age of the last key."""
        return time.monotonic() - self.key_at

    def ask(self, title: str, keys: str, then: Callable[[str], None], *, field: bool = True) -> None:
        """Asks; `then` gets the answer, unless the operator leaves."""

        def answered(text: str | None) -> None:
            if text is not None:
                then(text)

        button = HoldButton(self.look, self.words, self.action_hold, self.mouse)
        self.push_screen(Question(title, keys, button, field=field, settle_s=self.settle_s), answered)

    # ---- hold, start, step, reset

    def action_hold(self) -> None:
        """Feed hold; its effect shows at once, not with the next regular frame."""
        self.operation.hold()
        if self.paced:
            for seconds in ECHO_S:
                self.set_timer(seconds, self.tick)

    def action_start(self) -> None:
        """Cycle start or resume."""
        self.program.choose(0)
        if self.operation.is_resumable or not self.page.start(self.waited_s):
            self.operation.start(self.waited_s)

    def action_step(self) -> None:
        """One block."""
        self.program.choose(0)
        self.operation.step(self.waited_s)

    def action_single_block(self) -> None:
        """Single block on or off."""
        self.operation.toggle_single_block()

    def action_reset(self) -> None:
        """Announces a reset."""
        self.operation.arm_reset()
        self.tick()

    def action_confirm(self) -> None:
        """Does what was announced."""
        if not self.operation.confirm():
            self.page.confirm()
        self.tick()

    # ---- overrides, switches, speed

    def action_override(self, percent: int) -> None:
        """Feed override by percent points."""
        self.operation.change_override(percent)

    def action_override_full(self) -> None:
        """Feed override 100 %."""
        self.operation.set_override(100)

    def action_override_value(self) -> None:
        """Asks for the feed override."""
        title = self.words("override_ask", low=LOW, high=HIGH)
        self.ask(title, self.words("field_keys"), self.operation.override_from)

    def action_rapid(self, by: int) -> None:
        """Rapid override up or down."""
        self.operation.change_rapid(by)

    def action_switch(self, name: str) -> None:
        """Optional stop, block skip, dry-run feed, program test."""
        self.operation.switch(name)

    def action_dry_feed(self) -> None:
        """Asks for the dry-run feed."""
        s = self.engine.snapshot()
        if self.operation.is_underway:
            self.say(self.words("switch_standstill"))
        else:
            title = self.words("dry_feed_ask", most=s.feed_limit, now=s.dry_feed)
            self.ask(title, self.words("field_keys"), self.operation.dry_feed_from)

    def action_release(self) -> None:
        """No input is forced any more."""
        self.operation.release()

    def action_speed(self, by: int) -> None:
        """Simulation speed."""
        self.operation.change_speed(by)

    # ---- start at block

    def action_start_at(self) -> None:
        """Asks for a block, shows the state before it, asks again; `r` then starts there."""
        if self.engine.snapshot().replay:
            self.ask(self.words("replay_ask"), self.words("field_keys"), self.operation.seek)
        elif self.operation.is_underway:
            self.say(self.words("job_busy"))
        elif self.program.lines:
            chosen = self.program.chosen
            self.ask(self.words("start_at"), self.words("field_keys"), lambda text: self._search(text or str(chosen)))
        else:
            self.say(self.words("goto_job"))

    def _search(self, block: str) -> None:
        block = block.strip().upper()
        if block in ("", "0"):
            self._start_at("")
        elif find_block(self.program.lines, block) is None:
            self.say(self.words("goto_none", text=block[:20]))
        else:
            self.run_worker(lambda: self._find_state(block), thread=True, exclusive=True, group="load")

    def _find_state(self, block: str) -> None:
        try:
            start = self.engine.search(block)
        except CompileError as error:
            self.call_from_thread(self.say_finding, error.diagnostics)
        except (UsageError, OSError) as error:
            self.call_from_thread(self.say, refusal(error, self.words.language))
        else:
            self.call_from_thread(self._confirm_start, block, start)

    def _confirm_start(self, block: str, start: Start) -> None:
        units = {axis.name: axis.unit for axis in self.engine.snapshot().axes}
        title = f"{start_text(start, units, self.words.language)}\n{self.words('start_at_way')}"
        self.ask(title, self.words("start_at_keys"), lambda _: self._start_at(block), field=False)

    def _start_at(self, block: str) -> None:
        self.run_worker(lambda: self._load_part(block), thread=True, exclusive=True, group="load")

    def _load_part(self, block: str) -> None:
        try:
            job = self.engine.start_at(block)
        except CompileError as error:
            self.call_from_thread(self.say_finding, error.diagnostics)
        except (UsageError, OSError) as error:
            self.call_from_thread(self.say, refusal(error, self.words.language))
        else:
            line = self.program.chosen or 1
            name = block if not block.isdecimal() else block_name(job.lines, int(block))
            said = self.words("start_at_done", block=name) if block else self.words("start_at_top")
            self.call_from_thread(self._took_part, said, line)

    def _took_part(self, said: str, line: int) -> None:
        self.say(said)
        self.tick()
        self.program.choose(line)

    def say_finding(self, findings: tuple[Diagnostic, ...]) -> None:
        """The first error of several."""
        shown = [finding for finding in localized(findings, self.words.language) if not finding.is_warning]
        first = (shown or list(findings))[0]
        place = f"{first.line}:{first.column}:"
        self.say(self.words("load_failed", id=first.id, place=place, text=first.message))
        self.tick()

    # ---- end

    def action_ask_quit(self) -> None:
        """Asks whether to end."""
        face = FACES[self.operation.state]
        title = self.words("quit_ask")
        if self.operation.is_underway:
            title += " " + self.words("quit_runs", state=self.words.pick(face.english, face.german))
        self.ask(title, self.words("quit_keys"), lambda _: self.exit(), field=False)

    def leave_from_thread(self) -> None:
        """Ends the program from another thread."""
        if self.is_running and self._loop is not None:
            self._loop.call_soon_threadsafe(self.exit)
