"""A monkey at the keys of the terminal with the emulator behind it: nothing crashes or freezes, no axis moves unasked,
and hold works from wherever the monkey has gone. MONKEY_KEYS sets how many keys each seed presses."""

from __future__ import annotations

import asyncio
import os
import random
import time
from pathlib import Path
from typing import Any

import pytest
from textual.widgets import Input

from cnc_front.engine import Snapshot, State
from cnc_front.sim import SimEngine
from tests.app.conftest import ROOT
from tests.tui.stage import Stage, play
from tui.keys import KEYS

PRESSES = int(os.environ.get("MONKEY_KEYS", "10000"))
BATCH = 40
#: What starts a motion, and keys without which it must not have been asked for.
ASKED_BY = {
    "start": {"r"},
    "resume": {"r"},
    "start_mdi": {"r"},
    "step": {"t"},
    "jog": {"left", "right", "up", "down", "pageup", "pagedown"},
    "home": {"enter"},
}
STANDS = (State.NO_JOB, State.READY, State.HOLD, State.STEP, State.STOPPED, State.DONE, State.ABORTED, State.ALARM)
#: ^Q is left out: Enter behind it ends the program, as it should.
FINGERS = [
    *(key for row in KEYS for key in row.keys.split(",") if key != "ctrl+q"),
    *"rrtjjgGXYZ0123456789.-;F ",
    *("enter", "enter", "escape", "space", "left", "right", "home", "end", "backspace", "delete", "ctrl+a", "ctrl+k"),
]
PROGRAMS = {
    "a.nc": "G90 G21\nN10 G0 X10 Y5\nN20 G1 X60 F900\nN30 G3 X70 Y15 I0 J10\nM00\nN40 G1 Y0 F3000\nX0\nM30\n",
    "b.nc": "G90 G21\nT2 M06\nG4 P300\n/G1 X5 F600\nM01\nG1 X0 Y0 Z-1 F600\nZ0\nM30\n",
    "bad.nc": "G1 X\n",
}


class Watched(SimEngine):
    """Notes what it was asked for."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self.asked: list[str] = []
        super().__init__(*arguments, **options)

    def __getattribute__(self, name: str) -> Any:
        if name in ASKED_BY or name == "hold":
            object.__getattribute__(self, "asked").append(name)
        return super().__getattribute__(name)


def places(snapshot: Snapshot) -> list[float]:
    return [axis.command for axis in snapshot.axes]


async def stands(engine: SimEngine, seconds: float = 20.0) -> None:
    """Waits until what was asked for is done and nothing moves."""
    deadline = time.monotonic() + seconds
    while not engine._wishes.empty() or engine._machine.moves_on:
        assert time.monotonic() < deadline, engine.snapshot()
        await asyncio.sleep(0.005)
    await asyncio.sleep(0.01)


async def rush(stage: Stage, keys: list[str]) -> None:
    """The keys are obeyed, and the screen is drawn, within a deadline: else it is frozen."""
    async with asyncio.timeout(30):
        await stage.rush(keys)


async def hold_from_here(stage: Stage, engine: Watched) -> None:
    """Esc holds everywhere, Space everywhere but in a text field."""
    in_field = isinstance(stage.app.focused, Input)
    for key in ("escape",) if in_field else ("space", "escape"):
        engine.asked.clear()
        await stage.press(key)
        assert "hold" in engine.asked, (key, stage.app.page.name, stage.app.screen_stack)
    await stands(engine)
    assert engine.snapshot().state in (*STANDS, State.WAITING), engine.snapshot()
    before = places(engine.snapshot())
    await asyncio.sleep(0.02)
    assert places(engine.snapshot()) == before


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_ten_thousand_keys(seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in PROGRAMS.items():
        Path(name).write_text(text)
    chance = random.Random(seed)
    engine = Watched(str(ROOT / "examples" / "pcap" / "cell.toml"), speed=0)

    async def script(stage: Stage) -> None:
        stage.app.load("a.nc")
        await stage.until(lambda: stage.app.job is not None)
        for count in range(PRESSES // BATCH):
            keys = chance.choices(FINGERS, k=BATCH)
            if chance.random() < 0.3:  # without the keys that start something nothing may start
                keys = [key for key in keys if not any(key in by for by in ASKED_BY.values())]
                await stands(engine)
                engine.asked.clear()
                before = places(engine.snapshot())
                await rush(stage, keys)
                await stands(engine)
                moved = [name for name in engine.asked if name != "hold"]
                assert not moved and places(engine.snapshot()) == before, (keys, moved)
            else:
                engine.asked.clear()
                await rush(stage, keys)
                for name in set(engine.asked) - {"hold"}:
                    assert ASKED_BY[name] & set(keys), (name, keys)
            assert stage.app.is_running and not stage.app._exit
            if count % 5 == 0:
                await hold_from_here(stage, engine)
            if chance.random() < 0.05:
                await stage.pilot.resize_terminal(chance.randint(10, 160), chance.randint(3, 50))
        while len(stage.app.screen_stack) > 1:
            await stage.press("escape")
        await hold_from_here(stage, engine)
        assert "internal error" not in engine.snapshot().message

    try:
        play(script, engine)
    finally:
        engine.close()
