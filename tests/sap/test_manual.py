"""The twelve programs of the language reference do what their first comment says."""

from __future__ import annotations

from pathlib import Path

import pytest

import sympas
from motion_kernel import Machine, Mcu
from tests.sap.jobs import CELL, Job

PROGRAMS = Path(__file__).parents[2] / "sympas" / "tests" / "programs" / "manual"


def started(name: str, machine: Machine = CELL, task: int = 0) -> Job:
    """The program in its task, just started."""
    job = Job("begin end.", machine, task)
    job.mcu = Mcu(machine)
    job.mcu.load(task, sympas.compile(next(PROGRAMS.glob(f"{name}*.src")), machine))
    job.mcu.startcnct(task)
    return job


def finished(name: str) -> Job:
    """The program, run to its end without a runtime error."""
    job = started(name).run()
    status = job.mcu.rdcncts(0)
    assert (status.errnum, status.running) == (0, 0), f"line {status.errline or status.csrcline}"
    return job


def test_output_and_stop_at_writeln() -> None:
    job = started("P01")
    assert not job.mcu.rdcncts(0).running & 4
    job.run(1.0)
    assert (job.ci(0), job.ci(1)) == (35, 0)
    assert job.mcu.rdcncts(0).running & 4 and job.mcu.gettskinfo(0) == 2
    assert job.mcu.gettskstr(0) == "second line"
    job.mcu.contcnct(0)
    job.run()
    assert (job.ci(1), job.mcu.rdcncts(0).running) == (1, 0)


def test_expressions() -> None:
    job = finished("P02")
    want = [2, 1, 5, 16, 7, 5, -1, 3, -1, 3, 1, 0, 4, 1, 3, 1, 2147483647]
    assert [job.ci(n) for n in range(17)] == want
    assert [job.cd(n) for n in range(5)] == [3.5, 3.5, 14.0, -4.0, 1.0]


def test_loops() -> None:
    job = finished("P03")
    assert [job.ci(n) for n in range(8)] == [55, 30, 30, 5, -1, 4, 0, 2]


def test_routines() -> None:
    job = finished("P04")
    assert [job.ci(n) for n in range(5)] == [10, 5, 120, 1, 3]
    assert [job.cd(n) for n in range(2)] == [5.0, 6.0]


def test_time_and_mathematics() -> None:
    job = finished("P05")
    assert 1562 <= job.ci(0) < 1562 + 100 and 100 < job.ci(1) <= 157
    want = [5.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 81.0, 3.0, 0.0, 8.0]
    assert [job.cd(n) for n in range(15)] == pytest.approx(want, abs=1e-12)
    assert 1.0 < job.mcu.samples * 0.00128 < 1.5


def test_jogging() -> None:
    job = finished("P06")
    assert [job.cd(n) for n in range(3)] == pytest.approx([50.0, 10.0, 20.0])
    assert 20 < job.cd(3) < 1020
    assert not any(job.mcu.rdaxst(axis).cl for axis in ("A1", "A2"))


def test_homing() -> None:
    job = started("P07")
    job.run(0.5)
    job.mcu.set_inputs(1 << 8 | 1 << 9)  # both reference switches
    job.run()
    assert job.ci(0) == 1
    assert [job.mcu.rdrp(axis) for axis in ("A1", "A2")] == pytest.approx([0.0, 100.0], abs=0.02)


def test_contour() -> None:
    job = finished("P08")
    assert [job.cd(n) for n in range(8)] == pytest.approx([30, 40, 0, 0, 10, -10, 0, 0], abs=1e-3)
    assert job.cd(8) == pytest.approx(100.0, abs=0.1)


def test_helix() -> None:
    job = finished("P09")
    assert [job.cd(n) for n in range(6)] == pytest.approx([20, 0, -18] * 2, abs=1e-3)


def test_spooling() -> None:
    job = finished("P10")
    assert [job.ci(n) for n in (0, 1, 10)] == [5, 1, 1]
    assert job.cd(20) == 2.5
    assert [job.mcu.rddp(axis) for axis in ("A1", "A2", "A3")] == pytest.approx([0, 40, 6], abs=1e-3)
    assert not job.mcu.rddigo("A1") & 4


def test_events() -> None:
    job = started("P11")
    job.run(0.2)
    for level in (1, 0):
        job.mcu.set_inputs(level)
        job.run(0.1)
        assert job.mcu.rddigo("A1") >> 1 & 1 == level
    job.mcu.wrci(9, 1)
    job.run(0.5)
    assert (job.mcu.rdcncts(0).running & 1, job.ci(8)) == (0, 0)
    job.mcu.contcnct(0)
    job.run()
    assert job.ci(8) == 1
    urgent = started("P11")
    urgent.run(0.1)
    urgent.mcu.set_inputs(1 << 4 | 1 << 7)  # emergency out and user input at once
    urgent.run(0.5)
    assert (urgent.ci(0), urgent.ci(5)) == (999, 0)
    urgent.mcu.contcnct(0)
    urgent.run(0.1)
    assert not urgent.mcu.rdcncts(0).running & 1, "abort cannot be continued"


def test_tasks() -> None:
    assert sympas.compile(PROGRAMS / "P12Tasks.src", CELL).task == 1
    job = started("P12", task=1)
    job.load("begin while true do CI30 := CI30 + 1; end.", 2)
    job.run()
    assert [job.ci(0), job.ci(1), job.ci(20)] == [1234, 1, 0]
    assert [job.cd(n) for n in range(4)] == [1.5, 2.25, 15.0, 0.0]
    assert job.ci(30) > 5000
    assert not any(job.mcu.rdcncts(task).running & 1 for task in range(4)), "rs stops them all"
