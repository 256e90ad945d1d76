"""The screen of a rw_SymPas job, key by key, at 80x24."""

from __future__ import annotations

import argparse
import asyncio
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path

import pytest
from textual.pilot import Pilot
from textual.widgets import Static

from cnc_front.jobs import load_machine, load_stimulus
from cnc_front.sap_command import load_tasks
from cnc_front.sap_debug import debug_session
from tests.sap.jobs import LOOPS
from tui.debug_keys import ALL_KEYS
from tui.debugger import Debugger
from tui.keys import Key
from tui.look import make_look
from tui.words import Words

OTHER = "begin\n  while true do begin\n    CI5 := CI5 + 1;\n    wt(1000);\n  end;\nend.\n"

Play = Callable[[Pilot[None], Debugger], Awaitable[None]]


def played(
    tmp_path: Path,
    play: Play,
    *,
    text: str = LOOPS,
    language: str = "en",
    theme: str = "dark",
    keys: Sequence[Key] = ALL_KEYS,
) -> None:
    """Runs a script of keys on the screen."""
    (tmp_path / "loops.src").write_text(text)
    (tmp_path / "other.src").write_text(OTHER)
    jobs = {"job": str(tmp_path / "loops.src"), "task": [f"2={tmp_path / 'other.src'}"]}
    options = argparse.Namespace(**jobs, machine=None, language=None, lang=language)
    machine = load_machine(None, options.job)
    stimulus = load_stimulus(None, options.job, machine)
    session = debug_session(machine, load_tasks(options, machine), stimulus)
    app = Debugger(session, make_look(theme, "ascii"), Words(language), keys=keys)

    async def go() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            await pilot.pause()
            await play(pilot, app)

    asyncio.run(go())


def shown(app: Debugger, name: str) -> str:
    return str(app.query_one(f"#{name}", Static).content)


def marked(app: Debugger) -> list[str]:
    """Lines with the arrow of the line that comes next."""
    return [line for line in shown(app, "source").splitlines() if line[1:2] == ">"]


def test_steps_over_and_into(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("t", "t")
        assert "mean := Half(sum);" in marked(app)[0] and "sum = 6" in shown(app, "variables")
        await pilot.press("t")
        assert "Half := n / 2.0;" in marked(app)[0]
        assert "main > Half" in shown(app, "variables") and "n = 6" in shown(app, "variables")
        await pilot.press("t")
        assert "writeln" in marked(app)[0] and "mean = 3" in shown(app, "variables")

    played(tmp_path, play)


def test_a_step_over_passes_the_routine(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("t", "t", "T")
        assert "writeln" in marked(app)[0]

    played(tmp_path, play)


def test_breakpoints_stop_the_task(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("t", *["down"] * 2, "b")
        line = app.cursor
        assert [row[2:7].strip() for row in shown(app, "source").splitlines() if row[0] == "*"] == [str(line)]
        await pilot.press("R")
        await pilot.pause(0.3)
        assert app.session.state(app.session.tasks[0]).place == line
        await pilot.press("b", "R")
        await pilot.pause(2.0)
        assert "at rest" in shown(app, "head") and "0: mean 3.0" in shown(app, "output")

    played(tmp_path, play)


def test_a_breakpoint_on_a_line_without_statement_stands_at_the_next(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("b")  # the cursor is on `for`, up to the head of the function
        await pilot.press(*["up"] * 6, "b")
        assert app.session.views[0].breaks == {6, 9} and app.cursor == 6
        await pilot.press(*["down"] * 20, "b")
        assert "no statement follows" in shown(app, "keys") and app.session.views[0].breaks == {6, 9}

    played(tmp_path, play)


def test_a_variable_is_set(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("t", "t", "equals_sign", *"sum:=$1E", "enter")
        assert "sum = 30" in shown(app, "variables")
        await pilot.press("equals_sign", *"sum=1.5", "enter")
        assert "does not take the value: sum=1.5" in shown(app, "keys") and "sum = 30" in shown(app, "variables")
        await pilot.press("equals_sign", *"sum=9", "escape")
        await pilot.pause(0.2)
        assert "HOLD" in shown(app, "head") and "sum = 30" in shown(app, "variables")
        await pilot.press("r", "R")
        await pilot.pause(1.5)
        assert "0: mean 15.0" in shown(app, "output")

    played(tmp_path, play)


WAITS = "begin\n  while CI7 = 0 do wt(100);\n  writeln('seen ', CI7, ' ', CD8);\n  while CI9 = 0 do wt(100);\nend.\n"


def test_common_variables_and_the_stimulus_beside_the_job(tmp_path: Path) -> None:
    (tmp_path / "loops.stim").write_text("when ci 7 = 3: input 1 on\n")

    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("r", "equals_sign", *"CD8=2", "enter", "equals_sign", *"CI7:=3", "enter")
        await pilot.pause(0.5)
        assert "0: seen 3 2.0" in shown(app, "output")
        assert app.session.mcu.rddigi(0) & 1, "the world outside acts"
        await pilot.press("equals_sign", *"CI7=1.5", "enter")
        assert "not set" in shown(app, "keys")

    played(tmp_path, play, text=WAITS)


def test_r_does_not_begin_anew_what_has_ended(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("r")
        await pilot.pause(1.0)
        assert "0: once" in shown(app, "output")
        await pilot.press("r")
        await pilot.pause(0.5)
        assert app.session.output == ["0: once"], "the other task goes on"

    played(tmp_path, play, text="begin\n  writeln('once');\nend.\n")


INCLUDING = "{$I part.inc}\nvar depth : integer;\nbegin\n  depth := 2;\n  Outer(depth);\nend.\n"
PART = """var V : axis;
procedure Inner(n : integer);
begin
  V.an := n;
  CI0 := n / (n - n);
end;
procedure Outer(k : integer);
var twice : integer;
begin
  twice := 2 * k;
  Inner(k - 1);
end;
"""


def test_includes_callers_and_axis_variables(tmp_path: Path) -> None:
    (tmp_path / "part.inc").write_text(PART)

    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("t", "t", "t")
        assert (
            "part.inc:   11  " in marked(app)[0].replace("part.inc:11", "part.inc:   11")
            and "Inner(k - 1)" in marked(app)[0]
        )
        place = app.cursor - 6
        await pilot.press(*["up"] * 6, "b", "R")  # at CI0 := ... of the include
        await pilot.pause(0.3)
        assert app.session.views[0].breaks == {place} and "CI0 := n / (n - n);" in marked(app)[0]
        assert "part.inc:5" in shown(app, "tasks")
        rows = shown(app, "variables").splitlines()
        assert rows[0] == "main > Outer > Inner"
        assert rows[1:6] == [" n = 1", "Outer", " k = 2", " twice = 4", "main"]
        assert " V = 1 Y dp 0.000" in rows and " depth = 2" in rows
        await pilot.press("t")
        await pilot.pause(0.3)
        assert "RUNTIME ERROR" in shown(app, "head") and "part.inc:5" in shown(app, "tasks")

    played(tmp_path, play, text=INCLUDING)


def test_tasks_side_by_side(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("tab")
        assert "other.src" in shown(app, "head") and "CNC task 2" in shown(app, "head")
        await pilot.press("r")
        await pilot.pause(0.5)
        assert app.session.mcu.rdci(5) > 0
        await pilot.press("space")
        seen = app.session.mcu.rdci(5)
        await pilot.pause(0.5)
        assert app.session.mcu.rdci(5) == seen and "HOLD" in shown(app, "head")
        await pilot.press("t")
        assert app.session.mcu.rdci(5) == seen and "r first" in shown(app, "keys"), "a step does not end a hold"
        await pilot.press("r")
        await pilot.pause(0.5)
        assert app.session.mcu.rdci(5) > seen and "HOLD" not in shown(app, "head")
        await pilot.press("v")
        await pilot.pause(0.2)
        assert "mean := Half(sum);" in shown(app, "task0") and "CI5 := CI5 + 1;" in shown(app, "task2")

    played(tmp_path, play)


@pytest.mark.parametrize("theme", ["dark", "mono"])
def test_german_and_mono(theme: str, tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("t")
        assert "vor einem Schritt" in shown(app, "head") and "Schritt" in shown(app, "keys")
        assert len(shown(app, "keys")) <= 80

    played(tmp_path, play, language="de", theme=theme)


def test_a_runtime_error_is_shown_at_its_line(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("R")
        await pilot.pause(0.3)
        assert "RUNTIME ERROR 32768 (8000h)" in shown(app, "head") and "CI0 := 1 / i" in marked(app)[0]
        await pilot.press("R")
        await pilot.pause(0.3)
        assert "RUNTIME ERROR" in shown(app, "head"), "started anew, and again"

    played(tmp_path, play, text="var i : integer;\nbegin\n  CI0 := 1 / i;\nend.\n")


def test_a_task_that_has_stopped_itself_goes_on_behind_it(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        for seen in (1, 2):
            await pilot.press("R")
            await pilot.pause(0.3)
            assert app.session.mcu.rdci(0) == seen
        await pilot.press("R")
        await pilot.pause(0.3)
        assert app.session.mcu.rdci(0) == 1, "at its end it starts anew"

    played(tmp_path, play, text="begin\n  CI0 := 1;\n  stop;\n  CI0 := 2;\nend.\n")


def test_a_step_out_stops_in_the_caller(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("t", "t", "t")
        assert "Half := n / 2.0;" in marked(app)[0]
        await pilot.press("U")
        assert "writeln" in marked(app)[0] and "mean = 3" in shown(app, "variables")
        assert "main >" not in shown(app, "variables")

    played(tmp_path, play)


CONTOUR = """begin
  cl(X, Y);
  TRAC := 500.0;  TRVL := 20.0;  TRTVL := 0.0;
  enev(EVUI);
  smla(X := 40.0, Y := 30.0);
  ssmsw(X, Y);
  CI0 := 1;
end.
"""


@pytest.mark.parametrize("key", ["space", "escape"])
def test_a_hold_brakes_the_axes_on_their_path_and_r_goes_on(key: str, tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        def place() -> tuple[float, float]:
            x, y, *_ = app.session.mcu.status()["axes"]
            return x["dp"], y["dp"]

        await pilot.press("r")
        await pilot.pause(1.0)
        assert "EVUI" in shown(app, "tasks")
        await pilot.press(key)
        await pilot.pause(0.8)
        held = place()
        await pilot.pause(0.3)
        assert place() == held and 1 < held[0] < 40, "at rest"
        assert held[1] == pytest.approx(0.75 * held[0], abs=1e-9), "on the line"
        await pilot.press("r")
        for _ in range(60):
            await pilot.pause(0.1)
            if app.session.mcu.rdci(0):
                break
        assert place() == pytest.approx((40, 30), abs=1e-3) and app.session.mcu.rdci(0) == 1

    played(tmp_path, play, text=CONTOUR)


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_four_tasks_fit_the_screen(size: tuple[int, int], language: str, tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.resize_terminal(*size)
        await pilot.press("r", "v")
        await pilot.pause(0.3)
        panes = [app.query_one(f"#task{n}") for n in (0, 2)]
        assert all(p.region.width >= size[0] // 2 - 2 and p.region.height >= 7 for p in panes)
        assert len(shown(app, "keys")) <= size[0] and len(shown(app, "head").rstrip()) <= 80
        await pilot.press("v", "f1")
        await pilot.pause(0.2)
        assert "^Q" in shown(app, "source")

    played(tmp_path, play, language=language)
