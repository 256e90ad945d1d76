"""What the commands of the line mode share: the engine, the loaded job, and the question that waits for a yes."""

from __future__ import annotations

from collections.abc import Callable

from cnc_front.engine import AxisValues, Engine, Job, Switches, wait_for
from cnc_front.errors import CompileError
from cnc_front.german import in_language, refusal
from tui.operation import Operation
from tui.plain_words import way
from tui.words import Words

#: The engine needs so long at most to show the effect of a wish, s.
ECHO_S = 0.5


class Desk:
    """Of one session. `say` prints a line."""

    def __init__(self, engine: Engine, words: Words, say: Callable[[str], None]) -> None:
        self.engine, self.words, self.say = engine, words, say
        self.operation = Operation(engine, words, say)
        self.job: Job | None = None
        #: the MDI block that `start` executes; empty: none is checked; None: `start` is for the job
        self.block: str | None = None
        #: what `yes` does; any other command lets it go
        self.pending: Callable[[], None] | None = None

    def ask(self, question: str, then: Callable[[], None]) -> None:
        """Reads a question out; `yes` does it."""
        self.say(question)
        self.say(self.words("plain_yes"))
        self.pending = then

    def answer(self) -> None:
        """Does what was asked."""
        then, self.pending = self.pending, None
        if then is None:
            self.say(self.words("plain_not_asked"))
        else:
            then()

    def usage(self, id: str) -> None:
        """How a command is typed."""
        self.say(self.words("plain_usage", way=way(id, self.words.language)))

    def axis(self, name: str) -> AxisValues | None:
        """An axis by its name; says so where there is none."""
        found = next((axis for axis in self.engine.snapshot().axes if axis.name == name.upper()), None)
        if found is None:
            self.say(self.words("no_axis", axis=name[:20]))
        return found

    def tell_axis(self, axis: AxisValues) -> None:
        """Where it is."""
        values = (axis.actual, axis.command, axis.to_go, axis.following * 1000)
        self.say(self.words("plain_axis", axis=axis.name, unit=axis.unit, values=values))

    def switches_after(self, before: Switches) -> Switches:
        """The switches once the engine has taken over what was asked, or not."""
        wait_for(lambda: self.engine.snapshot().switches != before, ECHO_S)
        return self.engine.snapshot().switches

    def is_free(self) -> bool:
        """Nothing is under way; else says so."""
        busy = self.operation.is_underway
        if busy:
            self.say(self.words("hand_busy"))
        return not busy

    def refuse(self, error: Exception, path: str = "") -> None:
        """Why something cannot be done: every finding in a line of its own."""
        if isinstance(error, CompileError):
            for diagnostic in error.diagnostics:
                self.say(in_language(diagnostic, self.words.language))
        else:
            said = refusal(error, self.words.language)
            self.say(f"{path}: {said}" if path else said)
