"""Developing a program: steps, breakpoints, variables by name."""

from __future__ import annotations

from pathlib import Path

import pytest

import sympas
from motion_kernel import Mcu
from tests.sap.jobs import CELL, LOOPS, Job

HIDING = """var x : integer;
procedure P(n : integer);
var x : double;
begin
  x := n * 1.5;
  CI0 := 1;
end;
begin
  x := 7;
  P(3);
end.
"""
OVERFLOW = """var i : integer;  t : timer;
begin
  t := CLOCK;  t := t - 100000;  i := 2147483647;  wt(100);
  i := i + 1;  CI0 := i;  wt(100);
end.
"""
WRAP = """var t : timer;
begin
  t := CLOCK + 3000;
  repeat wt(20); CI0 := CI0 + 1; until CLOCK > t;
  CI1 := CLOCK;
end.
"""


def loaded() -> Job:
    job = Job(LOOPS)
    job.mcu.stopcnct(0)
    return job


def test_steps_go_line_by_line_and_into_routines() -> None:
    task = loaded().mcu.task(0)
    lines = []
    while task.step():
        lines.append(task.line)
    assert lines == [10, 11, 6, 12, 13, 14], "a line that repeats itself is one step (errata Q17)"
    assert task.variables["sum"] == 6 and task.variables["mean"] == 3.0


def test_a_step_over_passes_the_routine() -> None:
    job = loaded()
    task = job.mcu.task(0)
    task.break_at(11)
    assert task.go() and task.line == 11
    assert task.step(over=True) and task.line == 12
    assert task.variables["mean"] == 3.0


def test_breakpoints_stop_before_their_line_every_time() -> None:
    task = loaded().mcu.task(0)
    task.break_at(10)
    seen = []
    while task.go():
        seen.append((task.line, task.variables["i"], task.variables["sum"]))
    assert seen == [(10, 1, 0), (10, 2, 1), (10, 3, 3)]
    assert task.status.running == 0


def test_variables_of_the_routine_hide_those_of_the_program() -> None:
    job = Job(HIDING)
    task = job.mcu.task(0)
    task.break_at(6)
    assert task.go()
    assert task.calls[-1] == "P" and task.variables["x"] == 4.5 and task.variables["n"] == 3
    task.break_at()
    task.go()
    assert job.ci(0) == 1


def test_an_axis_variable_shows_its_axis() -> None:
    job = Job("var V : axis;\nbegin\n  V.an := 2;\n  CI0 := 1;\nend.")
    task = job.mcu.task(0)
    task.break_at(4)
    assert task.go() and task.variables["V"] == 2 and task.variables["A3"] == 2


def test_breakpoints_need_a_program() -> None:
    with pytest.raises(ValueError, match="no rw_SymPas program"):
        loaded().mcu.task(1).break_at(3)
    with pytest.raises(IndexError):
        loaded().mcu.task(4)


def test_breakpoints_stand_on_statements() -> None:
    task = loaded().mcu.task(0)
    with pytest.raises(ValueError, match="no statement begins on line 7; the next one: 9"):
        task.break_at(7)
    with pytest.raises(ValueError, match=r"no statement begins on line 99$"):
        task.break_at(99)
    assert task.breaks == frozenset()


def test_lines_of_includes_are_places_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "job.src").write_text("begin\n  CI0 := 1;\n  {$I inc/twice.inc}\n  CI0 := 2;\nend.\n")
    (tmp_path / "inc").mkdir()
    (tmp_path / "inc/twice.inc").write_text("CI1 := 1;\nCI1 := 2;\n")
    mcu = Mcu(CELL)
    mcu.load(0, sympas.compile(tmp_path / "job.src", CELL))
    task = mcu.task(0)
    assert [Path(path).name for path, _ in task.files] == ["job.src", "twice.inc"]
    mcu.startcnct(0)
    task.break_at("twice.inc:2")
    assert task.go() and (task.line, task.text_of(task.place), mcu.rdci(1)) == (2, "twice.inc:2", 1)
    assert task.step() and (task.line, task.text_of(task.place)) == (4, "4")
    mcu.startcnct(0)
    task.break_at(2)
    assert task.go() and task.place == 2
    assert not task.go(), "line 2 of the include is another"
    with pytest.raises(ValueError, match=r"no FILE:LINE of this program, whose files are job.src, twice.inc"):
        task.break_at("thrice.inc:2")


def test_variables_are_set_as_an_assignment_would() -> None:
    task = loaded().mcu.task(0)
    task.break_at(6)
    assert task.go()
    task.assign("n", 9)  # of the routine
    task.assign("mean", 2)  # of the program, Integer to Double
    assert (task.variables["n"], task.variables["mean"]) == (9, 2.0)
    assert task.step() and task.variables["mean"] == 4.5
    for name, value in (("sum", 1.5), ("sum", True), ("mean", False), ("nothing", 1)):
        with pytest.raises(ValueError, match=name):
            task.assign(name, value)


def test_variables_of_callers() -> None:
    text = (
        "procedure In(n : integer);\nbegin\n  CI0 := n;\nend;\nprocedure Out(n : integer);\nbegin\n  In(n + 1);\nend;\n"
    )
    job = Job(text + "begin\n  Out(4);\nend.\n")
    task = job.mcu.task(0)
    task.break_at(3)
    assert task.go() and task.calls[1:] == ["Out", "In"]
    assert [row for row in task.rows if row[1]] == [("n", 2, 5), ("n", 1, 4)]
    assert task.variables["n"] == 5


@pytest.mark.shows("sympas.timer.integer-overflow-flag")
def test_an_integer_overflow_wraps_and_is_seen() -> None:
    job = Job(OVERFLOW)
    job.mcu.advance(3)
    assert not job.mcu.task(0).overflow
    job.run()
    assert job.mcu.task(0).overflow and job.ci(0) == -2147483648


@pytest.mark.shows("sympas.timer.clock.wraps", "sympas.timer.wraparound-compare")
def test_the_clock_wraps() -> None:
    job = Job(WRAP)
    job.mcu.set_clock(-1000)
    job.run()
    assert job.ci(0) == pytest.approx(150, abs=3)
    assert 1900 < job.ci(1) < 2200
