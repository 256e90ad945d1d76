"""Line mode: what Run, Manual, MDI, Jobs and Service can do beside the job that runs; fake and real engine."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cnc_front.engine import State
from cnc_front.sim import SimEngine
from tests.tui.ended import registers
from tests.tui.fake import FakeEngine
from tests.tui.test_by_hand import equipped
from tests.tui.test_plain import FAULTS, session, talk
from tui.archive import Archive
from tui.plain import Plain
from tui.plain_desk import Desk
from tui.plain_queue import Queue
from tui.words import Words


def said(*lines: str, engine: FakeEngine | None = None, language: str = "en", **values: Any) -> tuple[str, list[str]]:
    """What is said to these lines, and what the engine is asked for."""
    acting = engine or equipped()
    acting.show(**values)
    text = session(acting, [f"{line}\n" for line in (*lines, "quit yes")], io.StringIO(), language)
    return text, acting.calls


def loaded() -> FakeEngine:
    """A machine at rest with the tests' job."""
    engine = equipped()
    engine.show(state=State.READY, revision=1)
    return engine


@pytest.mark.parametrize(
    ("lines", "calls", "part"),
    [
        (("search N620",), ["search N620"], "Type: yes"),
        (("search n620", "yes"), ["search N620", "start at N620"], "Starts at N620"),
        (("search 7", "yes"), ["search 7", "start at 7"], "Starts at N600"),
        (("search 7", "status", "yes"), ["search 7"], "Nothing was asked."),
        (("search 7", "yes", "yes"), ["search 7", "start at 7"], "Nothing was asked."),
        (("search 1", "yes"), ["search 1"], "GC617: line 1 is not executed"),
        (("search N7",), [], "N7: no such block."),
        (("search 0",), ["start at "], "Starts at the top"),
        (("search",), [], "Type: search: search N120"),
        (("serch 7",), [], "serch 7: no such command; nearest: search: "),
        (("blocks N560",), [], "N570: N570 G1 X+50.0000 Y+4.0000"),
        (("xyzzyx",), [], "xyzzyx: no such command; help lists them."),
    ],
)
def test_block_search(lines: tuple[str, ...], calls: list[str], part: str) -> None:
    text, asked = said(*lines, engine=loaded())
    assert part in text and asked == calls, text


def test_the_state_before_a_block_is_read_out_and_nothing_starts_under_way() -> None:
    text, _ = said("suche N620", engine=loaded(), language="de")
    assert "G1 G17 G90 G21 G94 G40 G49 G64 G54" in text and "S12000" in text and "Eingeben: ja" in text
    text, calls = said("search 7", "yes", engine=loaded(), state=State.RUNNING)
    assert "A job is under way" in text and "search 7" not in calls
    assert "No program to search." in said("search 7")[0]


def test_a_real_program_starts_at_a_block() -> None:
    text = "\n".join(talk("blocks 12\nsearch 11\nyes\nstart\nwait\nposition\nquit\n", FAULTS / "contour.nc"))
    assert "L13: G0 Z5" in text and "start at line 11" in text and "Starts at L11" in text
    assert "REPORT contour.nc: PASS" in text and "L5: max" not in text, "the blocks before are not run"


@pytest.mark.parametrize(
    ("lines", "calls", "part"),
    [
        (("jog X +",), ["jog X 0.1"], "X jogs +0.1 mm"),
        (("jog y-",), ["jog Y -0.1"], "Y jogs -0.1 mm"),
        (("step X 2.5", "jog X -"), ["jog X -2.5"], "X: jog step 2.5 mm"),
        (("step X 2.5", "jog Y -"), ["jog Y -0.1"], "Y jogs -0.1 mm"),
        (("step X 100", "jog X -"), ["jog X -0.1"], "100: no step from 0.001 to 10."),
        (("step X -1", "jog X -"), ["jog X -0.1"], "-1: no step"),
        (("step X",), [], "?: no step"),
        (("jog X + ", "jog X +"), ["jog X 0.1"], "Dropped: a step is under way"),
        (("jog Q +",), [], "The machine has no axis Q."),
        (("jog X 5",), [], "Type: jog: jog X +"),
        (("home X",), [], "Home in this order: X left onto the switch"),
        (("home x", "yes"), ["home X"], "Type: yes"),
        (("home all", "yes"), ["home Z X Y"], "order: Z right to the next index, X left onto the switch, Y"),
        (("home",), [], "Type: home: home X, home all"),
        (("zero X",), [], "Work zero G54 of X here, at +49.9212 (was +0.0000)?"),
        (("zero X", "yes"), ["zero X"], "Type: yes"),
        (("zero X", "jog Y +", "yes"), ["jog Y 0.1"], "Nothing was asked."),
        (("zero", "zero Q"), [], "The machine has no axis Q."),
        (("step",), ["step"], ""),
    ],
)
def test_by_hand(lines: tuple[str, ...], calls: list[str], part: str) -> None:
    text, asked = said(*lines, engine=loaded())
    assert part in text and asked == calls, text


@pytest.mark.parametrize("line", ["jog X +", "home X", "home all", "zero X", "mdi G1 X1", "tippe X -", "referenz alle"])
def test_by_hand_is_refused_under_way_as_on_the_screen(line: str) -> None:
    text, asked = said(line, "yes", engine=loaded(), state=State.RUNNING)
    assert "Refused: a job is under way; ^X Enter ends it." in text and not asked


def test_axes_moved_by_hand_tell_where_they_arrive() -> None:
    text = "\n".join(talk("step X 2\njog X -\nwait\nzero X\nyes\nwait\nmdi G1 X1 F6000\nstart\nwait\nposition\nquit\n"))
    assert "X: actual -2.0000 mm" in text and "X: G54 zero -2.0000, program coordinate +0.0000" in text
    assert "G1 X1 F6000: done" in text and "X: actual -1.0000 mm" in text
    lines = "mdi G0 X-595\nlos\nwarte\nschritt X 10\n" + "tippe X -\nwarte\n" * 2 + "ende\n"
    text = "\n".join(talk(lines, language="de"))
    assert text.count("der Schritt ginge über den Software-Endschalter") == 2 and text.count("X: Ist -595.0000") == 2


@pytest.mark.parametrize(
    ("lines", "calls", "part"),
    [
        (("mdi G1 X10 F500",), ["check G1 X10 F500"], "G1 X10 F500: checked"),
        (("mdi G1 X10", "start"), ["check G1 X10", "mdi G1 X10"], "checked"),
        (("mdi G1 X10", "resume"), ["check G1 X10", "mdi G1 X10"], "checked"),
        (("mdi G1 X10", "mdi Q", "start"), ["check G1 X10", "check Q"], "No block is checked."),
        (("mdi Q",), ["check Q"], "GC214: address Q is not used"),
        (("mdi G1 X10", "start job"), ["check G1 X10", "start"], "checked"),
        (("mdi G1 X10", "search 0", "los"), ["check G1 X10", "start at ", "start"], "checked"),
        (("mdi",), [], "Type: mdi: mdi G1 X10 F500"),
    ],
)
def test_mdi_executes_what_was_checked_and_never_the_job(lines: tuple[str, ...], calls: list[str], part: str) -> None:
    text, asked = said(*lines, engine=loaded())
    assert part in text and [call for call in asked if call != "hold"] == calls, text


def test_mdi_on_the_real_engine() -> None:
    lines = "mdi writeln(6*7);\nstart\nwait\nstart\nmdi G1 X3 F9\nmdi G1 Q3\nstart\nload {}\nstart\nwait\nquit\n"
    text = "\n".join(talk(lines.format(FAULTS / "contour.nc")))
    assert "> 42" in text and "writeln(6*7);: done" in text and "MDI:1:4: GC326" in text
    assert text.count("No block is checked.") == 2 and "REPORT contour.nc: PASS" in text


@pytest.mark.parametrize(
    ("lines", "calls", "part"),
    [
        (("inputs",), [], "inputs on: 3; outputs on: 1 3"),
        (("force 5 on", "inputs"), ["input 5 True"], "FORCED 5"),
        (("force 3 off",), ["input 3 False"], "Input 3 FORCED off"),
        (("erzwinge 3 aus", "e"), ["input 3 False", "release"], "Inputs 3 released."),
        (("release",), [], "No input is forced."),
        (("force 17 on",), [], "17: not a number from 1 to 16."),
        (("force 3",), [], "Type: force: force 3 on"),
        (("force X 1 on",), [], "Type: force: force 3 on"),
        (("dryfeed 500", "dryrun"), ["switches", "switches dry_run"], "dry-run feed on"),
        (("dryfeed 0",), [], "0: not a feed from 1 to 6000"),
        (("dryrun", "d"), ["switches dry_run", "switches"], "dry-run feed off"),
        (("registers Q",), [], "The machine has no axis Q."),
        (("registers",), [], "The controller has not answered yet"),
    ],
)
def test_the_controller(lines: tuple[str, ...], calls: list[str], part: str) -> None:
    text, asked = said(*lines, engine=loaded(), feed_limit=6000.0)
    assert part in text and asked == calls, text


@pytest.mark.parametrize(
    ("language", "parts"),
    [
        (
            "en",
            ("X axst 13 cl: loop closed", "X: spooler runs,", "kp ", "CNC task 1: at rest", "CI7 = 12", "CD3 = 0.5"),
        ),
        ("de", ("X axst 13 cl: Regelkreis geschlossen", "X: Spooler läuft,", "CNC-Task 1: in Ruhe", "CI7 = 12")),
    ],
)
def test_registers_tasks_and_variables_in_lines(language: str, parts: tuple[str, ...]) -> None:
    engine = loaded()
    engine.registers = replace(registers(language), integers=((7, 12),), doubles=((3, 0.5),))
    text, _ = said("registers x", "tasks", "variables", engine=engine, language=language)
    assert all(part in text for part in parts) and "Y axst" not in text, text
    assert "errorreg" in said("registers", engine=engine)[0]


def test_real_registers_are_those_of_now() -> None:
    text = "\n".join(talk("tasks\nregister\nforce 3 on\ninputs\nregisters X\nquit\n", FAULTS / "contour.nc"))
    assert "CNC task 3: at rest" in text and "errorreg: no bit is set" in text and "X axst 13 cl" in text
    assert "inputs on: 3 9 10 11;" in text and "FORCED 3" in text


def test_the_queue_runs_one_job_after_the_other(tmp_path: Path) -> None:
    bad = tmp_path / "bad.nc"
    bad.write_text("N10 G1 X5\nN20 M30\n")
    lines = "queue start\nqueue add {0}\nqueue add {1}\nqueue add none.nc\nqueue dance\n"
    lines += "queue add {0}\nqueue remove 9\nqueue\nqueue remove 3\nqueue start\nwait\nqueue\nquit\n"
    text = "\n".join(talk(lines.format(FAULTS / "contour.nc", bad)))
    for part in (
        "The queue is empty",
        "none.nc: no such file",
        "Type: queue: ",
        "9: no number",
        "queue 3 contour.nc: waits",
    ):
        assert part in text, text
    after = text.split("Queue done: 1 of 2 good.")[1]
    assert (
        "queue 1 contour.nc: PASS" in after and "queue 2 bad.nc: ERROR 1:1: GC501" in after and "queue 3" not in after
    )


def test_a_hold_stops_a_queue_and_a_reset_ends_it(tmp_path: Path) -> None:
    job = tmp_path / "long.nc"
    job.write_text("G90 G21 G17\nG1 X400 F100\nM30\n")
    engine, out = SimEngine(speed=1), io.StringIO()

    def lines() -> Iterator[str]:
        yield from (f"folge dazu {job}\n", f"folge dazu {job}\n", "folge los\n")
        assert engine.wait(20, lambda s: s.state is State.RUNNING)
        yield "\n"
        assert engine.wait(5, lambda s: s.state is State.HOLD)
        yield from ("folge\n", "abbruch ja\n", "warte\n", "folge\n", "ende ja\n")

    Plain(engine, Words("de"), out, Archive(None, "de")).run(lines())
    engine.close()
    text = out.getvalue()
    assert "Folge 1 long.nc: läuft" in text and "Die Folge steht: long.nc: ABORT" in text, text
    assert text.count("Folge 2 long.nc: wartet") == 2, text


def test_after_a_hold_between_two_jobs_nothing_starts(tmp_path: Path) -> None:
    job = tmp_path / "part.nc"
    job.write_text("G90 G21 G17\nG1 X4 F1000\nM30\n")
    engine = loaded()
    desk = Desk(engine, Words("en"), lambda _: None)
    queue = Queue(desk)
    for words in (f"add {job}", "start"):
        queue.deeds()["queue"](words)
    desk.operation.hold()
    queue.watch(engine.snapshot(), None)
    assert not queue.goes_on and "start" not in engine.calls
