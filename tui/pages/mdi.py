"""MDI: one block at a time. Enter checks it and leaves the field, `r` executes it; modes carry over to the next."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from textwrap import wrap
from typing import TYPE_CHECKING

from textual.strip import Strip

from cnc_front.diagnostics import Diagnostic
from cnc_front.engine import Mode, Snapshot, State, Stop
from cnc_front.errors import CompileError, UsageError
from cnc_front.german import localized
from tui.pages.base import Page
from tui.pages.manual import axis_rows
from tui.rows import Row
from tui.states import FACES, STARTABLE, UNDERWAY
from tui.values import Shown
from tui.widgets import PathField
from tui.words import Words

if TYPE_CHECKING:
    from tui.app import Terminal

#: Blocks kept for Up.
HISTORY = 500


@dataclass(slots=True)
class Entry:
    """A block that was executed."""

    clock: str
    text: str
    state: State | None = None  # None: not over yet
    stop: Stop = Stop.NONE  # what ended it, if it did not end by itself
    seconds: float = 0.0

    def watch(self, s: Snapshot) -> None:
        """Takes over how it ends."""
        is_over = s.mode is Mode.MDI and s.state not in UNDERWAY
        if self.state is None and is_over and s.mdi != self.text:
            self.state, self.stop, self.seconds = s.state, s.stop, s.machine_time_s


class MdiPage(Page):
    """A field, what was found in it, and what was executed."""

    name = "mdi"

    def __init__(self, app: Terminal) -> None:
        super().__init__(app)
        self.field = PathField(app.words("mdi_field"), id="block")
        self.entries: deque[Entry] = deque(maxlen=HISTORY)
        self.findings: tuple[Diagnostic, ...] = ()
        self._checked = ""
        self._back = 0

    def rows(self, shown: Shown, width: int, height: int) -> list[Strip]:
        """What was found, axes, modal state, history."""
        s = shown.snapshot
        self._watch(shown)
        rows = finding_rows(shown, self._checked, self.findings, width)
        if s.mdi:
            rows.append(Row(shown.look.strong).add(f" {shown.words('mdi_ready', block=s.mdi)}"))
        rows += axis_rows(shown)
        rows.append(Row(shown.look.text).add(f" {s.mdi_modal or shown.words('mdi_modal')}", shown.look.dim))
        rows.append(Row(shown.look.dim).add(shown.look.rule() * width))
        rows += [_entry_row(shown, entry) for entry in reversed(self.entries)]
        rows += [Row(shown.value).add(f"   > {line}") for line in reversed(s.output)]
        rows.append(Row(shown.look.dim).add(f" {shown.words('mdi_keys')}"))
        return [row.strip(width) for row in rows]

    def _watch(self, shown: Shown) -> None:
        """How the newest block ends."""
        if self.entries:
            self.entries[-1].watch(shown.snapshot)

    def enter(self) -> None:
        """The field has the focus."""
        super().enter()
        self._back = 0

    def leave(self) -> None:
        """Findings of a block that was not executed stay; the field is left."""

    def escape(self) -> bool:
        """Leaves the field; one stays here."""
        focused = self.field is not None and self.field.has_focus
        if focused:
            self.app.screen.set_focus(None)
        return focused

    def scroll(self, by: int) -> None:
        """In the field: blocks of before. Else the page."""
        if self.field is None or not self.field.has_focus:
            self.top += by
        elif abs(by) == 1 and self.entries:
            self._back = max(0, min(self._back - by, len(self.entries)))
            self.field.value = self.entries[-self._back].text if self._back else ""
            self.field.cursor_position = len(self.field.value)

    def submitted(self, text: str) -> None:
        """Checks the block, beside the screen."""
        if not text.strip():
            return
        if self.app.operation.is_underway:
            self.app.say(self.app.words("hand_busy"))
            return
        self.app.run_worker(lambda: self._check(text), thread=True, exclusive=True, group="mdi")

    def _check(self, text: str) -> None:
        try:
            self.app.engine.check_mdi(text)
        except CompileError as error:
            self.app.call_from_thread(self._refused, text, localized(error.diagnostics, self.app.words.language))
        except UsageError as error:
            self.app.call_from_thread(self.app.say, str(error))
        else:
            self.app.call_from_thread(self._accepted, text)

    def _refused(self, text: str, findings: tuple[Diagnostic, ...]) -> None:
        self._checked, self.findings = text.strip(), findings
        self.app.say_finding(findings)

    def _accepted(self, text: str) -> None:
        self._checked, self.findings, self._back = text.strip(), (), 0
        self.app.say(self.app.words("mdi_checked", block=text.strip()[:40]))
        if self.app.page is self and len(self.app.screen_stack) == 1:
            self.app.screen.set_focus(None)
        self.app.tick()

    def start(self, waited_s: float) -> bool:
        """Executes the block that was checked. Without one nothing starts here, least of all the job."""
        s = self.app.engine.snapshot()
        if s.state in UNDERWAY:
            return False
        if not s.mdi:
            self.app.say(self.app.words("mdi_nothing"))
        elif self.app.operation.start_mdi(waited_s):
            self.entries.append(Entry(f"{self.app.clock():%H:%M:%S}", s.mdi))
            if self.field is not None:
                self.field.value = ""
        return True


def finding_rows(shown: Shown, text: str, findings: tuple[Diagnostic, ...], width: int) -> list[Row]:
    """The block, a caret below the place, what is wrong and what to do."""
    look, rows = shown.look, []
    for finding in [f for f in findings if not f.is_warning][:3]:
        rows.append(Row(look.text).add(f"   {text[: width - 4]}"))
        rows.append(Row(look.bad).add(" " * (2 + min(finding.column, width - 6)) + "^"))
        rows += [Row(look.bad).add(f"   {line}") for line in wrap(f"{finding.id} {finding.message}", width - 6)]
        hint = wrap(f"{shown.words('hint')} {finding.hint}", width - 6) if finding.hint else []
        rows += [Row(look.dim).add(f"   {line}") for line in hint]
    return rows


def _entry_row(shown: Shown, entry: Entry) -> Row:
    look = shown.look
    row = Row(shown.value).add(f"   {entry.clock}  ", look.dim).add(entry.text[:40]).at(54, "")
    return row.add(entry_end(entry, shown.words), look.warn if _was_stopped(entry) else None)


def _was_stopped(entry: Entry) -> bool:
    return entry.state in (State.NO_JOB, *STARTABLE) and entry.stop is not Stop.NONE


def entry_end(entry: Entry, words: Words) -> str:
    """How a block has ended; empty while it has not."""
    if entry.state is None:
        return ""
    if _was_stopped(entry):
        return words(f"mdi_{entry.stop.name.lower()}")
    word = FACES[entry.state]
    is_done = entry.state in (State.DONE, State.READY, State.NO_JOB)
    done = words("mdi_done") if is_done else words.pick(word.english, word.german)
    return done + (f"  {entry.seconds:.1f} s" if entry.seconds else "")
