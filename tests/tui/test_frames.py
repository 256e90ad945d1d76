"""Frames: the characters of every page at both sizes, in both languages, with colours and without."""

from __future__ import annotations

import pytest

from cnc_front.engine import Alarm, State
from tests.tui.ended import registers
from tests.tui.fake import FakeEngine
from tests.tui.stage import NARROW, WIDE, Stage, play, same_frame

SIZES = {"wide": WIDE, "narrow": NARROW}


def loaded(engine: FakeEngine) -> None:
    engine.run_half()


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("theme", ["dark", "mono"])
def test_run_page(size: str, language: str, theme: str) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        text = await stage.frame()
        assert all(len(line) <= SIZES[size][0] for line in text.splitlines())
        # without colours the characters are the same: no fact is carried by colour alone
        same_frame(f"run-{size}-{language}", text)

    play(script, size=SIZES[size], language=language, theme=theme)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("view", [1, 2])
def test_other_views(size: str, view: int) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        await stage.press(*["v"] * view)
        same_frame(f"run-{size}-{('both', 'path', 'values')[view]}", await stage.frame())

    play(script, size=SIZES[size])


@pytest.mark.parametrize("glyphs", ["quadrant", "braille", "half"])
def test_glyphs(glyphs: str) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        same_frame(f"run-narrow-{glyphs}", await stage.frame())

    play(script, size=NARROW, glyphs=glyphs)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("theme", ["dark", "mono"])
@pytest.mark.parametrize("page", ["help", "alarms", "service", "jobs", "empty", "question"])
def test_other_pages(page: str, language: str, size: str, theme: str, tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cam.nc").touch()
    (tmp_path / "parts").mkdir()
    keys = {"help": "f1", "alarms": "f6", "service": "f8", "jobs": "f2", "question": "ctrl+q"}

    async def script(stage: Stage) -> None:
        if page != "empty":
            await stage.load()
            stage.engine.run_half()
            if page == "alarms":
                fault = Alarm(
                    48.2, "E107", "Y", 9, "following error 0.52 mm > 0.5 mm (mpe); check drive and gains", True, "mpe"
                )
                stage.engine.show(state=State.ALARM, why="mpe", alarms=(fault,))
            stage.engine.registers = registers(language)
            await stage.press(keys[page])
        same_frame(f"{page}-{size}-{language}", await stage.frame())

    play(script, size=SIZES[size], language=language, theme=theme)


@pytest.mark.parametrize("state", list(State))
def test_every_state_has_word_and_symbol_in_the_header(state: State) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        stage.engine.show(state=state, why="M00" if state is State.STOPPED else "dwell")
        head = (await stage.frame()).splitlines()[0]
        from tui.states import FACES

        assert f" {FACES[state].symbol} {FACES[state].english} " in head
        assert "[SIM x50]" in head and "12:31:07" in head

    play(script, size=NARROW)


def test_colours_are_those_of_the_guide() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        await stage.frame()
        strips = stage.app.screen._compositor.render_strips()
        styles = {segment.text.strip(): segment.style for segment in strips[0] if segment.style}
        assert styles["[SIM x50]"].bgcolor.name == "#8ecbff"
        colours = {s.style.color.name for strip in strips for s in strip if s.style and s.style.color}
        assert {"#56b4e9", "#f0e442", "#ff6a13", "#7a8793"} <= colours

    play(script)


def test_mono_uses_no_colour() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        await stage.frame()
        colours = {
            colour.name
            for strip in stage.app.screen._compositor.render_strips()
            for s in strip
            for colour in (s.style.color, s.style.bgcolor)
            if s.style and colour
        }
        assert colours <= {"default"}, colours

    play(script, theme="mono")


@pytest.mark.parametrize("size", [(79, 24), (80, 23), (40, 8), (12, 2)])
def test_too_small(size: tuple[int, int]) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        stage.engine.show(alarms=(Alarm(1.0, "E107", "Y", 9, "mpe", False, "mpe"),))
        text = await stage.frame()
        if size[0] >= 40:
            assert "[SIM x50]" in text and "> RUNNING" in text and "!!1" in text
        if size[0] >= 70:
            assert "too small, need 80x24" in text and "SPACE Hold" in text
        await stage.press("space")
        assert stage.engine.calls[-1] == "hold"

    play(script, size=size)
