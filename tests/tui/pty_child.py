"""Runs the terminal on the tests' own engine in a process of its own: `pty_child.py LOG`. Each call goes to LOG."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import tui.app
from cnc_front.engine import Snapshot, State
from tests.tui.fake import FakeEngine
from tui.app import Terminal
from tui.launch import hold_when_hung_up
from tui.look import make_look
from tui.words import Words


class Logged(FakeEngine):
    """Everything moves all the time while it runs, so that every frame has much to draw."""

    log = Path(sys.argv[1])

    def _did(self, call: str, **values: object) -> None:
        super()._did(call, **values)
        with self.log.open("a") as file:
            file.write(f"{call}\n")

    def snapshot(self) -> Snapshot:
        if self.now.state is not State.RUNNING:
            return replace(self.now)
        t = time.monotonic() * 37 % 1000
        return replace(self.now, axes=tuple(replace(axis, actual=t, following=t / 1e5) for axis in self.now.axes))


def main() -> None:
    tui.app.REFRESH_S = 0.05  # drawing at 20 Hz, the most that the guide asks for
    engine = Logged()
    engine.run_half()
    terminal = Terminal(engine, make_look("dark", "quadrant"), Words(), job="bracket_07.nc")
    hold_when_hung_up(engine, terminal.leave_from_thread)
    engine.load = lambda path: engine.job  # type: ignore[method-assign]
    terminal.run()


if __name__ == "__main__":
    main()
