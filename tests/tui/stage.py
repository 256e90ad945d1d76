"""Puts the terminal on a stage without a terminal: fixed size, fixed clock, frames only when the test asks."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Awaitable, Callable
from datetime import datetime
from pathlib import Path
from typing import Any

from textual import events
from textual.pilot import Pilot

from tests.tui.fake import FakeEngine
from tui.app import Terminal
from tui.keys import KEYS
from tui.look import make_look
from tui.words import Words

FRAMES = Path(__file__).with_name("frames")
WIDE, NARROW = (120, 40), (80, 24)

Script = Callable[["Stage"], Awaitable[None]]


class Stage:
    """The running terminal, its engine, and hands to press keys."""

    def __init__(self, app: Terminal, engine: FakeEngine, pilot: Pilot[None]) -> None:
        self.app, self.engine, self.pilot = app, engine, pilot

    async def press(self, *keys: str) -> None:
        """Presses keys and lets everything that follows from them happen."""
        await self.pilot.press(*keys)
        await self.pilot.pause()
        self.app.tick()

    async def rush(self, keys: list[str]) -> None:
        """Many keys at once, without waiting for each to be drawn."""
        for key in keys:
            self.app.post_message(events.Key(key, key if len(key) == 1 else None))
        await self.pilot.pause()
        self.app.tick()

    async def until(self, true: Callable[[], object], seconds: float = 10.0) -> None:
        """Waits for a condition."""
        deadline = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < deadline, f"never true; the screen was:\n{self.text}"
            await asyncio.sleep(0.005)
            self.app.tick()

    async def load(self, path: str = "bracket_07.nc") -> None:
        """Loads the engine's job."""
        self.app.load(path)
        await self.until(lambda: self.app.job is self.engine.job and not any(w.is_running for w in self.app.workers))
        self.app.tick()
        self.app.messages._said = ("", 0.0)
        self.app.messages.log.clear()  # loading goes on beside the frames: the order of its lines is not fixed

    async def frame(self) -> str:
        """The characters of the screen, when nothing is left to draw."""
        await self.pilot.pause()
        self.app.tick()
        await self.pilot.pause()
        return self.text

    @property
    def text(self) -> str:
        """The characters of the screen."""
        strips = self.app.screen._compositor.render_strips()
        return "\n".join(strip.text.rstrip() for strip in strips) + "\n"

    @property
    def message(self) -> str:
        """The message line."""
        self.app.tick()
        return self.app.screen_stack[0].query_one("#message").text  # type: ignore[attr-defined, no-any-return]


def play(script: Script, engine: Any = None, size: tuple[int, int] = WIDE, **look: Any) -> None:
    """Runs a script on a fresh terminal. `engine`: any cnc_front.engine.Engine; the fake one if none is given."""

    async def run() -> None:
        theme, glyphs = look.get("theme", "dark"), look.get("glyphs", "ascii")
        acting = engine or FakeEngine()
        app = Terminal(
            acting,
            make_look(theme, glyphs),
            Words(look.get("language", "en")),
            clock=lambda: datetime(2026, 3, 4, 12, 31, 7),
            paced=False,
            settle_s=0.0,
            archive=look.get("archive"),
            keys=look.get("keys", KEYS),
        )
        app.operation.late_s = 60.0  # the machine of the tests may be slow
        async with app.run_test(size=size) as pilot:
            await script(Stage(app, acting, pilot))

    asyncio.run(run())


def same_frame(name: str, text: str) -> None:
    """Compares with tests/tui/frames/NAME.txt; RENEW_FRAMES=1 writes the files anew (look at the difference)."""
    file = FRAMES / f"{name}.txt"
    if os.environ.get("RENEW_FRAMES"):
        FRAMES.mkdir(exist_ok=True)
        file.write_text(text, "utf-8")
    assert file.is_file(), f"no frame {name}; write it with RENEW_FRAMES=1"
    expected = file.read_text("utf-8")
    assert text == expected, f"{name} looks different; this is now:\n{text}\nand this was:\n{expected}"
