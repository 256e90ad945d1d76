"""Manual, MDI, switches, rapid override and start at block: every key, and what the engine is asked for."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import pytest
from textual import events
from textual.widgets import Input

from cnc_front.engine import Mode, Snapshot, State, Stop, Switches
from tests.tui.ended import registers
from tests.tui.fake import AXES, FakeEngine
from tests.tui.stage import NARROW, WIDE, Stage, play, same_frame

GAINS = (("kp", 0.6553), ("ki", 0.0), ("kd", 0.0), ("kpl", 0.0), ("kfcv", 0.0131), ("kfca", 0.00005))
HOW = ("switch", "switch+index", "index")
EQUIPPED = tuple(
    replace(axis, limits=(-600.0, 600.0), jog_feed=3000.0, gains=GAINS, homing=how, home_side=side, home_place=place)
    for axis, how, side, place in zip(AXES, HOW, ("left", "right", "left"), (2, 3, 1), strict=True)
)


def equipped() -> FakeEngine:
    """A machine at rest whose axes can be homed, without a job."""
    engine = FakeEngine()
    engine.show(axes=EQUIPPED, inputs=0b100, outputs=0b101)
    return engine


def asked(*keys: str, page: str = "f4", engine: FakeEngine | None = None, **values: Any) -> list[str]:
    """What the engine is asked for by keys on a page."""
    acting = engine or equipped()
    acting.show(**values)

    async def script(stage: Stage) -> None:
        await stage.press(page)
        acting.calls.clear()
        await stage.press(*keys)

    play(script, acting, NARROW)
    return acting.calls


@pytest.mark.parametrize(
    ("keys", "calls"),
    [
        (("j", "right"), ["jog X 0.1"]),
        (("j", "left", "left"), ["jog X -0.1", "jog X -0.1"]),
        (("j", "up", "down"), ["jog Y 0.1", "jog Y -0.1"]),
        (("j", "pageup", "pagedown"), ["jog Z 0.1", "jog Z -0.1"]),
        (("j", "i", "right", "i", "right", "i", "right"), ["jog X 1", "jog X 10", "jog X 0.001"]),
        (("j", "tab", "right", "tab", "right", "tab", "right"), ["jog Y 0.1", "jog Z 0.1", "jog X 0.1"]),
        (("j", "z", "right", "x", "right"), ["jog Z 0.1", "jog X 0.1"]),
        (("j", "a", "right"), ["jog X 0.1"]),
        (("right", "up", "pagedown"), []),
        (("j", "j", "right"), []),
        (("j", "escape", "right"), ["hold"]),
        (("j", "f3", "f4", "right"), []),
        (("h",), []),
        (("h", "enter"), ["home X"]),
        (("y", "h", "escape"), ["hold"]),
        (("H", "enter"), ["home Z X Y"]),
        (("w", "enter"), ["zero X"]),
        (("w", "escape"), ["hold"]),
        (("e", "5", "enter"), ["input 5 True"]),
        (("e", "3", "enter"), ["input 3 False"]),
        (("e", "1", "7", "enter"), []),
    ],
)
def test_manual_keys(keys: tuple[str, ...], calls: list[str]) -> None:
    assert asked(*keys) == calls


def test_presses_during_a_step_are_dropped_not_queued() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.press("f4", "j", "right")
        engine.show(state=State.RUNNING, mode=Mode.MANUAL)
        await stage.press("right", "right")
        engine.show(state=State.NO_JOB)
        await stage.press("right")
        assert engine.calls == ["jog X 0.1", "jog X 0.1"]

    play(script, engine)


def test_a_late_press_is_dropped() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.press("f4", "j")
        stage.app.operation.late_s = 0.25
        late = events.Key("right", None)
        late.time = time.monotonic() - 0.3
        stage.app.post_message(late)
        await stage.until(lambda: "dropped" in stage.message)
        assert engine.calls == []

    play(script, engine)


def test_jogging_ends_when_idle_or_without_focus() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        page: Any = stage.app.pages["manual"]
        await stage.press("f4", "j")
        assert "ON   [j]" in await stage.frame()
        page._used -= 31.0
        await stage.frame()
        assert "30 s without a step" in stage.message and "off  [j]" in await stage.frame()
        await stage.press("j")
        stage.app.post_message(events.AppBlur())
        await stage.press("right")
        assert engine.calls == []

    play(script, engine)


def test_the_wheel_moves_no_axis() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        from textual.events import MouseScrollDown, MouseScrollUp

        await stage.press("f4", "j")
        body = stage.app.query_one("#body")
        for kind in (MouseScrollDown, MouseScrollUp):
            body.post_message(kind(body, 5, 5, 0, 0, 0, False, False, False))
        await stage.pilot.pause()
        assert engine.calls == []

    play(script, engine)


def test_a_job_under_way_refuses_the_hand() -> None:
    for key in ("j", "h", "w"):
        engine = FakeEngine()

        async def script(stage: Stage, engine: FakeEngine = engine, key: str = key) -> None:
            await stage.load()
            engine.run_half()
            engine.show(axes=EQUIPPED)
            await stage.press("f4")
            engine.calls.clear()
            await stage.press(key, "enter")
            assert engine.calls == [] and "under way" in stage.message and len(stage.app.screen_stack) == 1

        play(script, engine)


def test_a_job_does_not_start_while_jogging() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.load()
        await stage.press("f4", "j", "r")
        assert "start" not in engine.calls and "Jog is on" in stage.message
        await stage.press("escape", "r")
        assert engine.calls[-1] == "start"

    play(script, engine)


def test_homing_says_order_and_direction_and_what_cannot_be_homed() -> None:
    async def script(stage: Stage) -> None:
        await stage.press("f4", "H")
        text = " ".join((await stage.frame()).replace("|", " ").split())
        assert "Z right to the next index" in text and "X left onto the switch" in text
        await stage.press("escape")
        stage.engine.show(axes=AXES)
        await stage.press("f4", "h")
        assert "X: no reference switch" in stage.message and len(stage.app.screen_stack) == 1

    play(script, equipped())


# ---- MDI


def test_mdi_checks_with_enter_and_starts_with_r() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.press("f5", *"G1 X5 F500".replace(" ", "~").replace("~", " "))
        assert engine.calls == []
        await stage.press("enter")
        await stage.until(lambda: "r executes it" in stage.message)
        assert stage.app.focused is None and engine.calls == ["check G1 X5 F500"]
        await stage.press("r")
        assert engine.calls[-1] == "mdi G1 X5 F500"
        await stage.press("r")
        assert engine.calls[-1] == "mdi G1 X5 F500", "once"
        engine.show(state=State.DONE, machine_time_s=0.8)
        assert "G1 X5 F500" in await stage.frame() and "done  0.8 s" in stage.text
        await stage.press("f5", "up")
        assert stage.app.focused is not None and stage.app.focused.value == "G1 X5 F500"  # type: ignore[attr-defined]
        await stage.press("down")
        assert stage.app.focused.value == ""  # type: ignore[attr-defined]

    play(script, engine)


def test_a_bad_mdi_block_shows_a_caret_and_starts_nothing() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.press("f5", *"G1 Q7")
        await stage.press("enter")
        await stage.until(lambda: "GC214" in stage.text)
        lines = (await stage.frame()).splitlines()
        row = next(i for i, line in enumerate(lines) if line.strip() == "^")
        assert lines[row - 1].index("Q") == lines[row].index("^")
        assert "drop it" in stage.text and isinstance(stage.app.focused, Input)
        await stage.press("escape", "r")
        assert engine.calls == ["check G1 Q7", "hold"] and "No block" in stage.message

    play(script, engine)


def test_nothing_but_mdi_starts_on_the_mdi_page() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.load()
        await stage.press("f5", "escape", "r")
        assert "start" not in engine.calls and "No block" in stage.message
        engine.show(state=State.HOLD)
        await stage.press("r")
        assert engine.calls[-1] == "resume", "what holds goes on from every page"
        engine.show(state=State.RUNNING)
        await stage.press("f5", "X", "enter")
        assert "under way" in stage.message and "check X" not in engine.calls

    play(script, engine)


# ---- switches, rapid override, start at block, find


@pytest.mark.parametrize(
    ("key", "call", "flag"),
    [
        ("o", "switches optional_stop", "[M01]"),
        ("slash", "switches skip", "[SKP]"),
        ("d", "switches dry_run", "[DRY]"),
        ("p", "switches program_test", "[PRT]"),
    ],
)
def test_switches(key: str, call: str, flag: str) -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.load()
        await stage.press(key)
        assert engine.calls[-1] == call and flag in await stage.frame()
        await stage.press(key)
        assert engine.calls[-1] == "switches" and flag not in await stage.frame()
        engine.show(state=State.HOLD)
        engine.calls.clear()
        await stage.frame()
        await stage.press(key)
        assert engine.calls == []
        assert ("spooler" if key in ("o", "slash") else "standstill") in stage.message

    play(script, engine, NARROW)


@pytest.mark.parametrize(
    ("typed", "feed", "says"),
    [("1200", 1200.0, "1200 mm/min; d switches"), ("1,5", 1.5, ""), ("", None, "as in the machine file")],
)
def test_dry_run_feed_by_value(typed: str, feed: float | None, says: str) -> None:
    engine = equipped()
    engine.show(feed_limit=6000.0, dry_feed=6000.0, switches=Switches(dry_feed=77.0))

    async def script(stage: Stage) -> None:
        await stage.press("D")
        assert "up to 6000 (now 6000" in await stage.frame()
        await stage.press(*(key.replace(",", "comma") for key in typed), "enter")
        assert engine.now.switches.dry_feed == feed and says in stage.message

    play(script, engine, NARROW)


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("page", ["f3", "f4", "f8"])
def test_forced_inputs_are_loud_and_one_key_releases_them(page: str, language: str) -> None:
    engine = equipped()
    engine.registers = registers(language)

    async def script(stage: Stage) -> None:
        word = "FORCED" if language == "en" else "ERZW"
        await stage.press(page)
        assert word not in await stage.frame()
        engine.show(forced=(3, 12))
        rows = (await stage.frame()).splitlines()
        assert f"[{word}" in rows[0] and (page == "f3" or any(f"{word}" in row and "3 12" in row for row in rows[1:]))
        assert page == "f3" or ("releases them" if language == "en" else "gibt frei") in "\n".join(rows)
        await stage.press("E")
        assert engine.calls[-1] == "release" and word not in (await stage.frame()).splitlines()[0]
        engine.calls.clear()
        await stage.press("E")
        assert engine.calls == []

    play(script, engine, NARROW, language=language)


def test_a_block_that_was_stopped_is_not_called_done() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.press("f5", *"G0", "enter")
        await stage.until(lambda: engine.now.mdi)
        await stage.press("r")
        engine.show(state=State.NO_JOB, stop=Stop.FAST_STOP)
        assert "G0" in await stage.frame() and "FAST STOP" in await stage.frame()

    play(script, engine, NARROW)


@pytest.mark.parametrize("typed", ["0", "6001", "fast", "nan"])
def test_a_dry_run_feed_that_cannot_be_is_refused(typed: str) -> None:
    assert asked("D", *typed, "enter", feed_limit=6000.0) == []


def test_the_dry_run_feed_changes_at_standstill_alone() -> None:
    assert asked("D", "5", "enter", feed_limit=6000.0, state=State.RUNNING) == []


def test_rapid_override() -> None:
    assert asked("less_than_sign", "less_than_sign", "less_than_sign", page="f3") == [
        "rapid 0.5",
        "rapid 0.25",
        "rapid 0.25",
    ]
    assert asked("greater_than_sign", page="f3", rapid_set=0.25) == ["rapid 0.5"]


def test_start_at_a_block_shows_the_state_asks_and_does_not_start() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.load()
        engine.calls.clear()
        await stage.press("G", *"n590", "enter")
        await stage.until(lambda: "start at line 7" in stage.text)
        assert "G1 G17 G90" in stage.text and "F2400" in stage.text and "r then starts" in stage.text
        await stage.press("enter")
        await stage.until(lambda: "start at N590" in engine.calls)
        await stage.until(lambda: "r starts" in stage.message)
        assert engine.calls == ["search N590", "start at N590"]
        await stage.press("G", *"N77", "enter")
        assert "no such block" in stage.message
        await stage.press("G", "1", "enter")
        await stage.until(lambda: "GC617" in stage.message)
        await stage.press("G", "0", "enter")
        await stage.until(lambda: "start at " in engine.calls)
        engine.show(state=State.RUNNING)
        await stage.press("G")
        assert len(stage.app.screen_stack) == 1 and "under way" in stage.message

    play(script, engine)


def test_start_at_takes_the_chosen_block() -> None:
    engine = equipped()

    async def script(stage: Stage) -> None:
        await stage.load()
        await stage.press("g", "7", "enter", "G", "enter")
        await stage.until(lambda: "search 7" in engine.calls)

    play(script, engine)


def test_find_goes_round_the_program() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        for line in (4, 9, 4):
            await stage.press("ctrl+f", *("y+4.0000" if line == 4 else "-12.6"), "enter")
            assert stage.app.program.chosen == line
        await stage.press("ctrl+f", *"zzz", "enter")
        assert "not in the program" in stage.message

    play(script, equipped())


# ---- what the screen says


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"state": State.HOLD, "stop": Stop.HOLD}, "HOLD on the path, spooler kept; r goes on"),
        ({"state": State.STEP, "stop": Stop.BLOCK_END}, "BLOCK END, spooler kept; r or t goes on"),
        (
            {"state": State.ABORTED, "stop": Stop.ABORT},
            "ABORT: braked on the path, spooler dropped; r starts from the top",
        ),
        (
            {"state": State.ALARM, "stop": Stop.FAST_STOP},
            "FAST STOP: each axis on its own ramp, contour left; r cannot go on",
        ),
        ({"state": State.WAITING, "why": "inputs", "waits_for": (5, 7)}, "Waits for input 5, 7 since 12:31:07"),
        ({"state": State.WAITING, "why": "dwell"}, "Waits for dwell since 12:31:07"),
        ({"state": State.STOPPED, "why": "M06", "tool": 4}, "M06: tool T4 in? Then r. (12:31:07)"),
        ({"state": State.STOPPED, "why": "M00"}, "M00: program stop; r goes on"),
        ({"state": State.STOPPED, "why": "M19"}, "M19: spindle oriented? Then r"),
        ({"state": State.STOPPED, "why": "M60"}, "M60: pallet changed? Then r"),
    ],
)
def test_the_message_says_which_stop_and_what_goes_on(values: dict[str, Any], said: str) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        stage.engine.show(**values)
        await stage.frame()
        assert said in stage.message

    play(script, size=NARROW)


@pytest.mark.parametrize("size", [WIDE, NARROW])
def test_a_low_override_is_said_beside_running(size: tuple[int, int]) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        assert "override low" not in await stage.frame()
        stage.engine.show(override_effective=0.19)
        assert "> RUNNING" in (await stage.frame()).splitlines()[0]
        assert "override low" in stage.text.splitlines()[0]

    play(script, size=size)


def _at(engine: FakeEngine, page: str) -> Snapshot:
    engine.show(switches=Switches(dry_run=True), rapid_set=0.5)
    if page == "mdi":
        engine.show(
            mdi="G1 X10 F500", mdi_modal="G1 G17 G90 G21 G94 G40 G49 G64 G54", output=("CI20 is 7",), mode=Mode.MDI
        )
    else:
        engine.show(mode=Mode.MANUAL)
    return engine.now


@pytest.mark.parametrize("size", ["wide", "narrow"])
@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("theme", ["dark", "mono"])
@pytest.mark.parametrize("page", ["manual", "mdi"])
def test_frames(page: str, theme: str, language: str, size: str) -> None:
    engine = equipped()
    _at(engine, page)

    async def script(stage: Stage) -> None:
        await stage.press("f4" if page == "manual" else "f5", *(["j"] if page == "manual" else []))
        text = await stage.frame()
        assert all(len(line) <= stage.app.size.width for line in text.splitlines())
        same_frame(f"{page}-{size}-{language}", text)

    play(script, engine, WIDE if size == "wide" else NARROW, language=language, theme=theme)
