"""A session of an operator, recorded as text: load, check, run with hold, override, alarm and recovery, report.

The real terminal on the real emulator; only the clock is the script's, so every frame is the same each time.
"""

from __future__ import annotations

import asyncio
import shutil
import time
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from cnc_front.engine import State
from cnc_front.sim import SimEngine
from tests.tui.stage import NARROW, Stage
from tui.app import Terminal
from tui.look import make_look
from tui.words import Words

ROOT = Path(__file__).parents[2]
DOCUMENT = ROOT / "docs/session.md"
#: Samples per step of emulated time.
STEP = 64
#: The first two lines of the document.
HEAD = """# A session in the terminal

Recorded from the real terminal on the emulator by `tests/tui/session.py`; a test compares it with what the terminal
shows now (`RENEW_FRAMES=1 python -m pytest tests/tui/test_session.py` records it anew).
"""


class Stepped(SimEngine):
    """The engine without a thread: wishes are obeyed at once, time passes when the script says so."""

    def _work(self) -> None:
        """Nothing happens by itself."""

    def _wish(self, wish: Callable[[], None]) -> None:
        wish()
        self._publish()

    def run_until(self, true: Callable[[], bool]) -> None:
        """Lets emulated time pass until something is so."""
        for _ in range(1_000_000):
            if true():
                break
            if not self._machine.moves_on:
                raise AssertionError(f"nothing moves: {self.snapshot().state}")
            self._machine.advance(STEP)
            self._publish()
        self._deviation_at = 0.0
        self._publish()


class Session:
    """Keys, emulated time, and the frames taken on the way."""

    def __init__(self, stage: Stage, engine: Stepped) -> None:
        self.stage, self.engine = stage, engine
        self.text = HEAD

    async def frame(self, what: str) -> None:
        """Takes a frame; `what` says what the operator did."""
        self.stage.app.messages.index = 0
        screen = await self.stage.frame()
        self.text += f"\n## {what}\n\n```text\n{screen.rstrip()}\n```\n"

    async def state(self, *states: State) -> None:
        """Waits for what other threads do: compiling, the estimate of the time."""
        await self.stage.until(lambda: self.engine.snapshot().state in states)

    async def loaded(self) -> None:
        """The job is compiled and its time is known."""
        before = self.engine.snapshot().revision
        await self.stage.press("enter")
        await self.stage.until(lambda: self.engine.snapshot().revision > before)
        deadline = time.monotonic() + 30
        while self.engine.snapshot().time_total_s is None and time.monotonic() < deadline:
            await asyncio.sleep(0.01)
            self.engine._publish()
        await self.stage.frame()


async def operate(session: Session, folder: Path) -> None:
    """The session itself."""
    stage, engine = session.stage, session.engine

    def done_mm() -> float:
        return engine.snapshot().path_done_mm

    await session.frame("`cnc-front tui`: nothing is loaded")
    await stage.press("f2", *"contour")
    await session.loaded()
    await session.frame("`F2`, a name, `Enter`: the job is compiled and checked against limits")
    await stage.press("f3", "r")
    await session.state(State.RUNNING)
    engine.run_until(lambda: done_mm() > 40)
    await session.frame("`F3` `r`: it runs")
    await stage.press("space")
    engine.run_until(lambda: engine.snapshot().state is State.HOLD)
    await session.frame("`Space`: feed hold, on the path")
    await stage.press(*["minus"] * 8, "r")
    await session.state(State.RUNNING)
    engine.run_until(lambda: done_mm() > 62)
    await session.frame("`-` eight times, `r`: on with an override of 60 %")
    await stage.press("asterisk")
    engine.run_until(lambda: engine.snapshot().state is State.ALARM)
    await stage.press("f6")
    await session.frame("`*`: 100 % again. A limit switch trips; `F6` names cause and remedy")
    await stage.press("delete")
    await session.frame("`Del` is refused: the cause is still there")
    (folder / "contour.stim").unlink()  # the mechanic has been there
    await stage.press("ctrl+x", "enter")
    await session.frame("The switch is repaired. `^X` `Enter` resets")
    await stage.press("delete")
    await session.frame("`Del` acknowledges")
    await stage.press("f2")
    await session.loaded()
    await stage.press("f3", "r")
    await session.state(State.RUNNING)
    engine.run_until(lambda: engine.snapshot().state is State.DONE)
    await session.frame("`F2` `Enter` checks the job again, `F3` `r`: it runs to its end")
    await stage.press("f7")
    await session.frame("`F7`: the report; `e` would write it as HTML")


def record(folder: Path) -> str:
    """The document, from a session in an empty folder that is the present one."""
    for name in ("contour.nc", "machine.toml"):
        shutil.copy(ROOT / "examples/faults" / name, folder)
    shutil.copy(ROOT / "examples/faults/limit_sma.stim", folder / "contour.stim")

    async def run() -> str:
        engine = Stepped(speed=0)
        clock = datetime(2026, 3, 4, 12, 31, 7)
        look = make_look("dark", "ascii")
        app = Terminal(engine, look, Words("en"), clock=lambda: clock, paced=False, settle_s=0.0)
        app.operation.late_s = 60.0
        async with app.run_test(size=NARROW) as pilot:
            session = Session(Stage(app, engine, pilot), engine)  # type: ignore[arg-type]
            await operate(session, folder)
        engine.close()
        return session.text

    return asyncio.run(run())
