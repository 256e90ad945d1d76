"""The screen of a rw_SymPas job, key by key, at 80x24."""

from __future__ import annotations

import argparse
import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest
from textual.pilot import Pilot
from textual.widgets import Static

from cnc_front.jobs import load_machine
from cnc_front.sap_command import load_tasks
from cnc_front.sap_debug import debug_session
from tui.debugger import Debugger
from tui.look import make_look
from tui.words import Words

TEXT = """program Loops;
var i, sum : integer;
    mean : double;
function Half(n : integer) : double;
begin
  Half := n / 2.0;
end;
begin
  for i := 1 to 3 do
    sum := sum + i;
  mean := Half(sum);
  writeln('mean ', mean);
  wt(15625);
  CI0 := 1;
end.
"""
OTHER = "begin\n  while true do begin\n    CI5 := CI5 + 1;\n    wt(1000);\n  end;\nend.\n"

Play = Callable[[Pilot[None], Debugger], Awaitable[None]]


def played(tmp_path: Path, play: Play, *, text: str = TEXT, language: str = "en", theme: str = "dark") -> None:
    """Runs a script of keys on the screen."""
    (tmp_path / "loops.src").write_text(text)
    (tmp_path / "other.src").write_text(OTHER)
    jobs = {"job": str(tmp_path / "loops.src"), "task": [f"2={tmp_path / 'other.src'}"]}
    options = argparse.Namespace(**jobs, machine=None, language=None, lang=language)
    machine = load_machine(None, options.job)
    session = debug_session(machine, load_tasks(options, machine))
    app = Debugger(session, make_look(theme, "ascii"), Words(language))

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
        await pilot.press("s", "s")
        assert "mean := Half(sum);" in marked(app)[0] and "sum = 6" in shown(app, "variables")
        await pilot.press("s")
        assert "Half := n / 2.0;" in marked(app)[0]
        assert "main > Half" in shown(app, "variables") and "n = 6" in shown(app, "variables")
        await pilot.press("s")
        assert "writeln" in marked(app)[0] and "mean = 3" in shown(app, "variables")

    played(tmp_path, play)


def test_a_step_over_passes_the_routine(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("s", "s", "o")
        assert "writeln" in marked(app)[0]

    played(tmp_path, play)


def test_breakpoints_stop_the_task(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("s", *["down"] * 2, "b")
        line = app.cursor
        assert [row[2:7].strip() for row in shown(app, "source").splitlines() if row[0] == "*"] == [str(line)]
        await pilot.press("c")
        await pilot.pause(0.3)
        assert app.session.state(app.session.tasks[0]).line == line
        await pilot.press("b", "c")
        await pilot.pause(2.0)
        assert "at rest" in shown(app, "head") and "0: mean 3.0" in shown(app, "output")

    played(tmp_path, play)


def test_tasks_side_by_side(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("t")
        assert "other.src" in shown(app, "head") and "CNC task 2" in shown(app, "head")
        await pilot.press("a")
        await pilot.pause(0.5)
        assert app.session.mcu.rdci(5) > 0
        await pilot.press("p")
        await pilot.pause(0.5)
        seen = app.session.mcu.rdci(5)
        await pilot.pause(0.3)
        assert app.session.mcu.rdci(5) <= seen + 1 and "before a step" in shown(app, "tasks")

    played(tmp_path, play)


@pytest.mark.parametrize("theme", ["dark", "mono"])
def test_german_and_mono(theme: str, tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("s")
        assert "vor einem Schritt" in shown(app, "head") and "Haltepunkt" in shown(app, "keys")
        assert len(shown(app, "keys")) <= 80

    played(tmp_path, play, language="de", theme=theme)


def test_a_runtime_error_is_shown_at_its_line(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        await pilot.press("c")
        await pilot.pause(0.3)
        assert "RUNTIME ERROR 32768 (8000h)" in shown(app, "head") and "CI0 := 1 / i" in marked(app)[0]
        await pilot.press("c")
        await pilot.pause(0.3)
        assert "RUNTIME ERROR" in shown(app, "head"), "started anew, and again"

    played(tmp_path, play, text="var i : integer;\nbegin\n  CI0 := 1 / i;\nend.\n")


def test_a_task_that_has_stopped_itself_goes_on_behind_it(tmp_path: Path) -> None:
    async def play(pilot: Pilot[None], app: Debugger) -> None:
        for seen in (1, 2):
            await pilot.press("c")
            await pilot.pause(0.3)
            assert app.session.mcu.rdci(0) == seen
        await pilot.press("c")
        await pilot.pause(0.3)
        assert app.session.mcu.rdci(0) == 1, "at its end it starts anew"

    played(tmp_path, play, text="begin\n  CI0 := 1;\n  stop;\n  CI0 := 2;\nend.\n")
