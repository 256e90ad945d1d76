"""Every key of the terminal, pressed as an operator would; what arrives at the engine is what counts."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from textual import events
from textual.widgets import Input

from cnc_front.engine import State
from tests.tui.ended import ended
from tests.tui.fake import FakeEngine, make_job
from tests.tui.stage import NARROW, Stage, play
from tui.keys import KEYS, LATE_S
from tui.operation import SPEEDS
from tui.pages import PAGES


def ready() -> FakeEngine:
    engine = FakeEngine()
    engine.run_half()
    return engine


def calls_after(state: State, *keys: str, **values: Any) -> list[str]:
    """What the engine is asked for when keys are pressed in a state."""
    engine = FakeEngine()

    async def script(stage: Stage) -> None:
        await stage.load()
        engine.run_half()
        engine.show(state=state, **values)
        engine.calls.clear()
        await stage.press(*keys)

    play(script, engine, NARROW)
    return engine.calls


@pytest.mark.parametrize(
    ("state", "key", "calls"),
    [
        (State.RUNNING, "space", ["hold"]),
        (State.RUNNING, "escape", ["hold"]),
        (State.READY, "space", ["hold"]),
        (State.READY, "r", ["start"]),
        (State.DONE, "r", ["start"]),
        (State.ABORTED, "r", ["start"]),
        (State.HOLD, "r", ["resume"]),
        (State.STEP, "r", ["resume"]),
        (State.STOPPED, "r", ["resume"]),
        (State.RUNNING, "r", []),
        (State.HOLDING, "r", []),
        (State.ALARM, "r", []),
        (State.NO_JOB, "r", []),
        (State.READY, "t", ["step"]),
        (State.HOLD, "t", ["step"]),
        (State.RUNNING, "t", []),
        (State.ALARM, "t", []),
        (State.RUNNING, "b", ["single True"]),
        (State.RUNNING, "+", ["override 1.05"]),
        (State.RUNNING, "-", ["override 0.95"]),
        (State.RUNNING, "*", ["override 1"]),
        (State.RUNNING, ".", ["speed 100"]),
        (State.RUNNING, ",", ["speed 20"]),
        (State.RUNNING, "enter", []),
        (State.RUNNING, "ctrl+x", []),
        (State.RUNNING, "ctrl+q", []),
    ],
)
def test_keys_that_act_on_the_machine(state: State, key: str, calls: list[str]) -> None:
    names = {"+": "plus_sign", "-": "minus", "*": "asterisk", ".": "full_stop", ",": "comma"}
    assert calls_after(state, names.get(key, key)) == calls


def test_reset_needs_two_keys() -> None:
    assert calls_after(State.RUNNING, "ctrl+x", "enter") == ["reset"]
    assert calls_after(State.RUNNING, "ctrl+x", "enter", "enter") == ["reset"]


def test_reset_is_announced_and_lapses() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        await stage.press("ctrl+x")
        assert "Enter within 3 s" in stage.message
        stage.app.operation._armed_at -= 3.0
        await stage.press("enter")
        assert "reset" not in stage.engine.calls

    play(script)


def test_override_keeps_within_its_range_and_counts_quick_presses() -> None:
    assert calls_after(State.RUNNING, "plus_sign", "plus_sign", "plus_sign")[-1] == "override 1.15"
    assert calls_after(State.RUNNING, "minus", override_set=0.05) == ["override 0.05"]
    assert calls_after(State.RUNNING, "plus_sign", override_set=1.5) == ["override 1.5"]


@pytest.mark.parametrize(
    ("typed", "call"), [("37", "override 0.37"), ("120%", "override 1.2"), ("62,5", "override 0.625")]
)
def test_override_by_value(typed: str, call: str) -> None:
    assert calls_after(State.RUNNING, "equals_sign", *(_name(c) for c in typed), "enter") == [call]


def _name(character: str) -> str:
    return {"%": "percent_sign", ",": "comma", ".": "full_stop"}.get(character, character)


@pytest.mark.parametrize("typed", ["0", "x", "", "1e9", "nan"])
def test_a_bad_override_is_refused(typed: str) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        await stage.press("equals_sign", *typed, "enter")
        assert not [call for call in stage.engine.calls if call.startswith("override")]
        assert "not a number from 5 to 150" in stage.message

    play(script)


def test_speeds_go_up_to_the_fastest_and_down_to_real_time() -> None:
    assert calls_after(State.RUNNING, *["full_stop"] * 9, speed_factor=1.0)[-1] == "speed 0"
    assert calls_after(State.RUNNING, *["comma"] * 9, speed_factor=0.0)[-1] == "speed 1"
    assert len(calls_after(State.RUNNING, *["full_stop"] * 7, speed_factor=1.0)) == len(SPEEDS) - 1


def test_a_motion_key_that_waited_is_dropped() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.app.operation.late_s = LATE_S
        for key in ("r", "t"):
            late = events.Key(key, key)
            late.time = time.monotonic() - 0.3
            stage.app.post_message(late)
            await stage.until(lambda: "dropped" in stage.message)
            stage.app.messages._said = ("", 0.0)
        assert stage.engine.calls == ["load bracket_07.nc"]
        stage.app.operation.late_s = 60.0
        await stage.press("r")
        assert stage.engine.calls[-1] == "start"

    play(script)


def test_a_question_ignores_keys_that_were_meant_for_the_screen_before() -> None:
    async def script(stage: Stage) -> None:
        stage.app.settle_s = 60.0
        await stage.press("ctrl+q", "enter")
        assert stage.app.is_running and len(stage.app.screen_stack) == 2
        await stage.press("escape")
        assert len(stage.app.screen_stack) == 1

    play(script)


def test_quit_asks() -> None:
    async def script(stage: Stage) -> None:
        await stage.press("ctrl+q")
        assert not stage.app._exit
        await stage.press("enter")
        assert stage.app._exit

    play(script)


PLACES: dict[str, Callable[[Stage], Any]] = {
    page: (lambda stage, key=key: stage.press(key))
    for page, key in {
        "run": "f3",
        "help": "f1",
        "alarms": "f6",
        "service": "f8",
        "manual": "f4",
        "mdi field": "f5",
        "report": "f7",
        "find field": "ctrl+f",
        "start field": "G",
        "jobs field": "f2",
        "override field": "equals_sign",
        "goto field": "g",
        "quit question": "ctrl+q",
    }.items()
}


@pytest.mark.parametrize("place", PLACES)
def test_hold_works_everywhere(place: str) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        await PLACES[place](stage)
        if not isinstance(stage.app.focused, Input):
            await stage.press("space")
            assert stage.engine.calls[-1] == "hold"
            stage.engine.calls.clear()
        else:
            await stage.press("space")
            assert stage.app.focused.value == " " and "hold" not in stage.engine.calls
        await stage.press("escape")
        assert stage.engine.calls[-1] == "hold"
        assert len(stage.app.screen_stack) == 1 and stage.app.focused is None

    play(script)


def test_keys_of_motion_are_only_letters_in_a_field() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.calls.clear()
        for key in ("f2", "g", "equals_sign"):
            await stage.press(key, "r", "t", "b", "1", "v")
            assert stage.engine.calls == []
            await stage.press("escape")
            stage.engine.calls.clear()

    play(script)


def test_go_to_block_and_back() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        await stage.press("g", "n", "6", "6", "0", "enter")
        assert stage.app.program.chosen == 13
        await stage.press("g", "3", "enter")
        assert stage.app.program.chosen == 3
        await stage.press("down", "down", "up")
        assert stage.app.program.chosen == 4
        await stage.press("c")
        assert stage.app.program.chosen == 0
        await stage.press("g", *"n77777", "enter")
        assert "no such block" in stage.message

    play(script)


def test_zoom_pan_and_fit() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        whole = await stage.frame()
        await stage.press("0", "0", "shift+right")
        assert await stage.frame() != whole
        await stage.press("f")
        assert await stage.frame() == whole

    play(script)


def test_clicks_choose_blocks_and_never_move_an_axis() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        await stage.frame()
        stage.engine.calls.clear()
        area = stage.app.pages["run"].areas.program
        await stage.pilot.click("#body", offset=(area.x + 5, area.y + 3))
        assert stage.app.program.chosen == 4
        rows = (await stage.frame()).splitlines()
        y = next(i for i, row in enumerate(rows) if "#" in row[58:] and "..." not in row and i > 2)
        await stage.pilot.click("#body", offset=(58 + rows[y][58:].index("#"), y - 1))
        assert stage.app.program.chosen == 5
        assert stage.engine.calls == []

    play(script)


def test_next_message_and_alarm_first() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        stage.engine.show(message="(MSG) check clamps")
        assert "check clamps" in stage.message
        await stage.press("n")
        assert "W204 N580" in stage.message
        await stage.press("n")
        assert "check clamps" in stage.message

    play(script)


def test_load_from_the_jobs_page(tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "parts").mkdir()
    for name in ("cam.nc", "bracket.nc"):
        (tmp_path / "parts" / name).touch()

    async def script(stage: Stage) -> None:
        await stage.press("f2", "p", "tab", "down")
        assert stage.app.query_one("#path", Input).value == "parts/"
        await stage.press("enter")
        await stage.until(lambda: stage.app.job is not None)
        assert stage.engine.calls == ["load parts/cam.nc"]

    play(script)


def test_a_job_that_does_not_compile_is_explained_and_the_loaded_one_stays() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.app.load("bad.nc")
        await stage.until(lambda: stage.app.pages["jobs"].check.findings)
        assert "GC801 bad.nc:4:11: axis W is not configured" in stage.message
        assert stage.app.job is stage.engine.job
        await stage.press("f2")
        text = await stage.frame()
        assert "not loaded: 1 errors" in text and "hint: choose a machine" in text

    play(script)


def test_no_load_while_a_job_is_under_way() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        stage.app.load("other.nc")
        assert "under way" in stage.message
        assert stage.engine.calls == ["load bracket_07.nc"]

    play(script)


def test_the_screen_shows_what_the_engine_reports_not_what_was_asked() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        stage.engine.deaf = True
        await stage.press("space", "minus", "b")
        text = await stage.frame()
        assert "> RUNNING" in text and "OVR set 100 %" in text and "[SB]" not in text
        assert stage.engine.calls[-3:] == ["hold", "override 0.95", "single True"]

    play(script)


def test_old_values_are_marked() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        assert "+49.9170?" not in await stage.frame()
        stage.app.paced = True  # age counts only where frames come by themselves
        stage.app._seen = (stage.engine.now, time.monotonic() - 2.0)
        stage.app.tick()
        await stage.pilot.pause()
        assert "+49.9170?" in stage.text and "RUNNING?" in stage.text and "no news for 2 s" in stage.text

    play(script)


def test_every_key_of_the_table_has_an_action_and_help() -> None:
    from tui.app import Terminal

    taken = [(key, row.page) for row in KEYS for key in row.keys.split(",")]
    assert len(taken) == len(set(taken))
    pages = {page.name: page for page in PAGES}
    for row in KEYS:
        name = row.action.split("(")[0]
        assert hasattr(pages[row.page], f"key_{name}") if row.page else hasattr(Terminal, f"action_{name}"), row
        assert bool(row.english) == bool(row.german) == bool(row.shown)


MONKEY = [
    *(key for row in KEYS for key in row.keys.split(",")),
    *"abz57N/",
    *("left", "right", "home", "end", "backspace", "delete", "ctrl+a", "ctrl+k", "shift+tab", "ctrl+u", "ctrl+w"),
]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_monkey_crashes_nothing_and_starts_nothing_without_its_key(seed: int, tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.chdir(tmp_path)
    chance = random.Random(seed)
    states = [*State]

    async def script(stage: Stage) -> None:
        await stage.load()
        for _ in range(40):
            stage.engine.calls.clear()
            keys = [chance.choice(MONKEY) for _ in range(50)]
            if len(stage.app.screen_stack) > 1 or "ctrl+q" in keys:
                keys = [key for key in keys if key != "enter"]  # Enter would quit
            await stage.rush(keys)
            assert stage.app.is_running and not stage.app._exit
            moves = {"start", "resume"} & set(stage.engine.calls)
            assert not moves or "r" in keys, keys
            assert "step" not in stage.engine.calls or "t" in keys, keys
            if chance.random() < 0.3:
                stage.engine.run_half()
                stage.engine.show(state=chance.choice(states))
            if chance.random() < 0.1:
                await stage.pilot.resize_terminal(chance.randint(10, 160), chance.randint(3, 50))
        while len(stage.app.screen_stack) > 1:
            await stage.press("escape")
        await stage.press("escape", "space")
        assert stage.engine.calls[-1] == "hold"

    play(script, FakeEngine(job=make_job()))


def test_the_key_line_names_no_key_that_does_nothing_here() -> None:
    async def script(stage: Stage) -> None:
        for number, page in enumerate(["help", "jobs", "run", "manual", "mdi", "alarms", "report", "service"], 1):
            await stage.press(f"f{number}")
            line = stage.text.splitlines()[-1]
            assert ("v Sicht" in line) is (page == "run"), page
            assert line.startswith(" LEER Halt"), "the names of a German keyboard"
        await stage.press("f1")
        assert "Leertaste" in stage.text and "Space" not in stage.text

    play(script, language="de")


def test_done_is_no_verdict() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        await stage.frame()
        run = {"verdict": {"word": "FAIL", "reasons": []}}
        stage.engine.ended = replace(ended(), number=1, run=run)
        stage.engine.show(state=State.DONE)
        await stage.frame()
        assert "FAIL; F7 shows the report" in stage.message
        stage.engine.ended = replace(ended(), number=2, run=run)
        stage.app.messages._said = ("", 0.0)
        stage.engine.show(state=State.ALARM)
        await stage.frame()
        assert "F7 shows" not in stage.message, "a run that was stopped says why, not how it was judged"

    play(script)
