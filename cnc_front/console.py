"""The engine behind the terminal: the emulator, and in front of it a recording while one is shown."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cnc_front.engine import Engine, Job, Snapshot, State, wait_for
from cnc_front.errors import UsageError
from cnc_front.messages import text
from cnc_front.outputs import is_recording

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome

#: Revisions of recordings begin here, so that none is one of the emulator.
RECORDINGS = 1_000_000


class Console:
    """Implements cnc_front.engine.Engine: every call but those below goes to what is shown. The emulator stands while
    a recording is shown, and is as it was when the recording is put away."""

    def __init__(self, machine: Engine, language: str = "en") -> None:
        self._machine, self._language = machine, language
        self._shown = machine
        self._revision = RECORDINGS

    def __getattr__(self, name: str) -> Any:
        return getattr(self._shown, name)

    def load(self, path: str, wanted: Callable[[], bool] = lambda: True) -> Job:
        """A recording is shown; anything else is a job for the emulator. Raises CompileError, UsageError."""
        if not (path.lower().endswith(".mcap") or is_recording(Path(path))):
            job = self._machine.load(path, wanted)
            self._show(self._machine)
            return job
        if self._machine.snapshot().state not in (State.NO_JOB, State.READY, State.DONE, State.ABORTED, State.ALARM):
            raise UsageError(text("hand_refused", self._language))
        from cnc_front.replay import ReplayEngine

        self._revision += 1
        speed = self._shown.snapshot().speed_factor
        replay = ReplayEngine(path, language=self._language, speed=speed, revision=self._revision)
        if not wanted():
            replay.close()
            raise UsageError(text("load_let_go", self._language))
        self._show(replay)
        return replay.job

    def reset(self) -> None:
        """Of a recording: back to its beginning; at its beginning it is put away."""
        snapshot = self._shown.snapshot()
        if snapshot.replay and snapshot.state is State.READY:
            self._show(self._machine)
        else:
            self._shown.reset()

    def outcome(self) -> Outcome | None:
        """The run that ended last on the emulator, also while a recording is shown."""
        return self._machine.outcome()

    def _show(self, engine: Engine) -> None:
        before, self._shown = self._shown, engine
        if before is not self._machine and before is not engine:
            before.close()

    def wait(self, seconds: float, until: Callable[[Snapshot], bool]) -> bool:
        """As Engine says, of what is shown at each moment."""
        return wait_for(lambda: until(self._shown.snapshot()), seconds)

    def close(self) -> None:
        """Ends both."""
        self._show(self._machine)
        self._machine.close()
