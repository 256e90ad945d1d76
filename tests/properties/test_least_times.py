"""The time-optimal bound of a run (design D27): the closed form of a line is toppra's, the bound of an arc is one, and
no random program beats it, at any override, with any shape of ramps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths
from cnc_front.jobs import CompiledJob, CompileOptions, JobSource, MachineFile, compile_job
from cnc_front.run import RunOptions, RunResult, dry_run
from cnc_front.time_optimal import axis_limits, time_optimal
from toolpaths.optimal import Arc, least_times, trapezoid
from toolpaths.toppra_arcs import arc_time

BUILTIN = native_kernel.Machine.builtin().show()
SHAPED = BUILTIN.replace('"ChkMaxVel"', '"ChkMaxVel", "SProfile"')


def compiled(text: str, machine: str = BUILTIN) -> CompiledJob:
    """A part program for a machine."""
    file = MachineFile("", machine, "", native_kernel.Machine.parse(machine.encode(), ""))
    return compile_job(JobSource("generated.nc", text.encode(), "din66025"), file, CompileOptions())


def ran(job: CompiledJob, schedule: tuple[tuple[float, float], ...] = ((0.0, 1.0),)) -> RunResult:
    return dry_run(job, RunOptions(schedule=schedule, time_optimal=True))


near = st.floats(0, 60)


@settings(max_examples=60, deadline=None, phases=[Phase.generate])
@given(st.floats(0.01, 50), near, near, st.floats(1, 60), st.floats(50, 2000))
def test_the_closed_form_of_a_line_is_the_time_of_toppra(
    length: float, v0: float, v1: float, v_max: float, acc: float
) -> None:
    v0, v1 = min(v0, v_max), min(v1, v_max)
    if abs(v1 * v1 - v0 * v0) > 2 * acc * length:
        v1 = v0
    closed = float(trapezoid(*map(np.array, (length, v0, v1, v_max, acc))))
    # an arc so large that it is a line: only the path itself has a limit
    straight = Arc(1e9, 0.0, 1e-9, 1.0, np.array([1e6, 1e6]), acc, 0)
    by_toppra = arc_time(straight, length, (v0, v1), v_max, 2000)
    assert by_toppra is not None
    assert closed == pytest.approx(by_toppra, rel=3e-3)
    assert closed <= by_toppra * (1 + 1e-6)


@settings(max_examples=40, deadline=None, phases=[Phase.generate])
@given(st.floats(0.3, 20), st.floats(0, 6), st.floats(0.2, 6), st.floats(5, 90), st.floats(200, 2000))
def test_the_closed_form_of_an_arc_needs_no_more_than_toppra(
    radius: float, angle: float, sweep: float, v_max: float, acc: float
) -> None:
    arc = Arc(radius, angle, 1 / radius, 1.0, np.array([acc, acc]), np.inf, 0)
    most_v, most_a = arc.relaxed()
    length = radius * sweep
    closed = float(trapezoid(*map(np.array, (length, 0.0, 0.0, min(v_max, most_v), most_a))))
    by_toppra = arc_time(arc, length, (0.0, 0.0), v_max, 200)
    assert by_toppra is not None
    assert closed <= by_toppra
    assert by_toppra <= 3 * closed


tenths = st.integers(-300, 300).map(lambda n: n / 10)
feeds = st.integers(200, 6000)
words = st.one_of(
    st.tuples(tenths, tenths, tenths, feeds).map(lambda w: f"G1 X{w[0]} Y{w[1]} Z{w[2]} F{w[3]}"),
    st.tuples(tenths, tenths, feeds).map(lambda w: f"G91 G1 X{w[0] / 20} Y{w[1] / 20} F{w[2]}\nG90"),
    st.tuples(st.integers(1, 99), st.integers(-99, 99), st.integers(-20, 20), feeds).map(
        lambda w: f"G91 G2 X0 Y0 Z{w[2] / 10} I{w[0] / 10} J{w[1] / 10} F{w[3]}\nG90"
    ),
    st.sampled_from(["G4 F0.02", "G61", "G64", "G0 X1 Y2 Z3", "G0 X60 Z-20", "M0"]),
)
programs = st.lists(words, min_size=1, max_size=12).map(lambda w: "\n".join(["G17 G21 G90 F1000", *w, "M30", ""]))
schedules = st.sampled_from(
    [
        ((0.0, 1.0),),
        ((0.0, 0.5),),
        ((0.0, 1.0), (0.3, 0.4), (0.9, 1.5), (1.5, 0.8)),
        ((0.0, 1.2), (1.0, 0.1), (3.0, 1.0)),
    ]
)


@settings(max_examples=40, deadline=None, phases=[Phase.generate])
@given(programs, schedules, st.booleans(), st.sampled_from(["", "trovrst_s = 0.0", "trovrst_s = 2.0"]))
def test_no_command_is_faster_than_its_bound(
    text: str, schedule: tuple[tuple[float, float], ...], shaped: bool, ramps: str
) -> None:
    machine = (SHAPED if shaped else BUILTIN).replace("trovrst_s = 0.5", ramps or "trovrst_s = 0.5")
    job = compiled(text, machine)
    result = ran(job, schedule)
    native, sequence = job.machine.machine, job.program.sequence()
    bound = least_times(sequence, result.tracker.passages(), axis_limits(native), native.sample_time_us * 1e-6, 20)
    assert np.all(bound.taken >= bound.least * (1 - 1e-9) - 1e-9), bound.taken - bound.least
    optimal = time_optimal(sequence, result.path, result.tracker, native, result.summary["samples"])
    assert 0 < optimal.seconds <= result.execution.machine_time_s
    assert sum(optimal.gap_of.values()) == pytest.approx(result.execution.machine_time_s - optimal.seconds, abs=1e-9)


def test_the_gap_is_where_time_is_lost() -> None:
    """Half the override costs as much as the motion takes; a hold of the path acceleration below that of the axes costs
    what the closed form says."""
    text = "G17 G21 G90\nG1 X100 F3000\nG1 Y100\nM30\n"
    job = compiled(text)
    result = ran(job, ((0.0, 0.5),))
    native = job.machine.machine
    optimal = time_optimal(job.program.sequence(), result.path, result.tracker, native, result.summary["samples"])
    assert max(optimal.gap_of, key=lambda limit: optimal.gap_of[limit]) == "override"
    assert optimal.seconds == pytest.approx(result.execution.machine_time_s / 2, rel=0.02)
    # one diagonal: axes with 1000 mm/s² each allow sqrt(2) times the path acceleration of 1000 mm/s²
    job = compiled("G17 G21 G90\nG1 X50 Y50 F6000\nM30\n")
    result = ran(job)
    optimal = time_optimal(job.program.sequence(), result.path, result.tracker, native, result.summary["samples"])
    lost = 100 * 0.1 - 100 * 0.1 / 2**0.5 - 0.5 * 100**2 * (1 / 1000 - 1 / 1414.2) * 2 / 100
    assert result.execution.machine_time_s - optimal.seconds == pytest.approx((0.1 - 0.1 / 2**0.5), abs=0.004), lost
    assert [row["first_line"] for row in optimal.sections] == [2]


def test_without_being_asked_nothing_is_collected() -> None:
    job = compiled("G1 X10 F1000\nM30\n")
    assert isinstance(dry_run(job, RunOptions()).tracker, toolpaths.Tracker)
    assert len(dry_run(job, RunOptions()).tracker.passages()["samples"]) == 0
