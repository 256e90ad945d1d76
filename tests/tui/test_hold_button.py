"""The HOLD button: on every screen and in every dialog, in the same corner; it is all that the mouse does to motion."""

from __future__ import annotations

from pathlib import Path

import pytest
from textual.pilot import Pilot

from tests.tui.fake import FakeEngine
from tests.tui.stage import NARROW, WIDE, Stage, play
from tests.tui.test_debugger import Play, played
from tests.tui.test_terminal import CHILD, lines_of, window
from tui.debugger import Debugger
from tui.hold_button import WIDTH, HoldButton
from tui.pages import PAGES

CORNER = (WIDE[0] - WIDTH // 2, WIDE[1] - 1)
#: Keys that open each dialog, behind the keys of a page.
DIALOGS = (
    ("ctrl+q",),
    ("equals_sign",),
    ("g",),
    ("ctrl+f",),
    ("G",),
    ("f4", "e"),
    ("f7", "e"),
)


async def holds(stage: Stage) -> bool:
    """A press in the corner, without a release."""
    stage.engine.calls.clear()
    stage.engine.run_half()
    await stage.pilot.mouse_down(offset=CORNER)
    await stage.pilot.pause()
    return stage.engine.calls == ["hold"]


@pytest.mark.parametrize("language", ["en", "de"])
def test_it_holds_from_every_page_and_field(language: str) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        for number in range(1, len(PAGES) + 1):
            await stage.press(f"f{number}")
            last = (await stage.frame()).splitlines()[-2:]
            assert last[0][-WIDTH:].strip("[] ") == ("HOLD" if language == "en" else "HALT")
            assert await holds(stage), stage.app.page.name
            await stage.press("escape")

    play(script, language=language)


@pytest.mark.parametrize("keys", DIALOGS)
def test_it_holds_from_every_dialog(keys: tuple[str, ...]) -> None:
    from tests.tui.ended import ended

    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.ended = ended()
        await stage.press(*keys)
        assert len(stage.app.screen_stack) == 2, keys
        await stage.pilot.resize_terminal(110, 30)
        await stage.pilot.resize_terminal(*WIDE)
        await stage.pilot.pause()
        assert await holds(stage), keys
        assert len(stage.app.screen_stack) == 2, "a hold answers nothing"

    play(script)


def test_it_shows_whether_there_is_something_to_hold() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        button = stage.app.query_one(HoldButton)
        assert not button.moves
        stage.engine.run_half()
        stage.app.tick()
        assert button.moves

    play(script)


def test_a_narrow_screen_and_one_without_mouse_have_none() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        assert "click" not in await stage.frame()
        assert not stage.app.query_one(HoldButton).display
        await stage.pilot.resize_terminal(*WIDE)
        await stage.pilot.pause()
        stage.app.query_one(HoldButton)._mouse = False
        await stage.pilot.resize_terminal(WIDE[0] - 1, WIDE[1])
        assert "click" not in await stage.frame()
        assert not await holds(stage)

    play(script, FakeEngine(), NARROW)


def test_it_holds_on_the_screen_of_sympas_jobs(tmp_path: Path) -> None:
    async def script(pilot: Pilot[None], app: Debugger) -> None:
        assert not app.query_one(HoldButton).display
        await pilot.press("equals_sign")
        assert len(app.screen_stack) == 2
        await pilot.resize_terminal(*WIDE)
        await pilot.pause()
        await pilot.mouse_down(offset=CORNER)
        await pilot.pause()
        assert app.session.held, "in its dialog"
        await pilot.press("r", "r")
        await pilot.pause()
        assert not app.session.held
        await pilot.mouse_down(offset=CORNER)
        await pilot.pause()
        assert app.session.held

    act: Play = script
    played(tmp_path, act)


def test_a_real_mouse_in_a_real_terminal(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with window([*CHILD, str(log)], WIDE) as screen:
        screen.shows("click")
        screen.type(f"\x1b[<0;{CORNER[0]};{CORNER[1]}M")
        assert screen.until(lambda: lines_of(log) == ["hold"], "hold") < 5.0
