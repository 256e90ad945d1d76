"""What limits the path velocity: constructed motions in which each cause is the known one, at a known place, for a time
that follows from closed forms; and the sums of random programs, which are those of the run."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnc_front.jobs import CompileOptions, JobSource, compile_job, load_machine
from cnc_front.run import RunOptions, dry_run
from cnc_front.verdict import limits_object
from motion_kernel import Machine, Mcu, ModeReg
from motion_kernel.causes import Cause, english, limit_of

AXES = ("X", "Y")
MDVEL, MAXVEL, MAXACC = 10.0, 100.0, {"X": 400.0, "Y": 300.0}
MACHINE = "[controller]\nsample_ticks = 1\n" + "".join(
    f'[[axis]]\nname = "{name}"\nletter = "{name}"\ncounts_per_unit = 1e4\nrapid = 200\nacceleration = 1000\n'
    f"mdvel = {MDVEL}\nmaxvel = {MAXVEL}\nmaxacc = {MAXACC[name]}\n"
    for name in AXES
)
TA = 64e-6
#: Path acceleration of all motions, mm/s²; below maxacc, so that the check does not lower it.
AC = 250.0
CHECKS = ("LookAhead", "ChkMaxVel", "ExactTargetPos")

Stretches = list[tuple[str, float]]


def named(code: int) -> str:
    """`mdvel X`."""
    cause, axis = limit_of(code)
    return cause if axis is None else f"{cause} {AXES[axis]}"


def seen(flags: np.ndarray) -> Stretches:
    """Causes one after the other, with their seconds."""
    return [(named(code), TA * len(list(run))) for code, run in groupby((flags >> 8).tolist())]


def ramp(v0: float, v1: float, ac: float = AC) -> float:
    """Seconds from one velocity to the other."""
    return abs(v1 - v0) / ac


def cruise(length: float, v0: float, v: float, v1: float, ac: float = AC) -> float:
    """Seconds at `v` of a line that begins with v0 and ends with v1."""
    return (length - (2 * v * v - v0 * v0 - v1 * v1) / (2 * ac)) / v


@dataclass
class Case:
    """Commands, and the causes that follow; the rest of the time the machine stands."""

    give: Callable[[Mcu], None]
    expected: Stretches
    bits: tuple[str, ...] = CHECKS
    #: what happens at these seconds
    later: dict[float, Callable[[Mcu], None]] = field(default_factory=dict)
    controller: str = ""


def line(x: float, y: float = 0.0, *, vl: float = 50.0, ac: float = AC, tvl: float = 0.0) -> Callable[[Mcu], None]:
    return lambda mcu: mcu.smla({"X": x, "Y": y}, vl=vl, ac=ac, tvl=tvl) or pytest.fail("not entered")


def chain(*commands: Callable[[Mcu], object]) -> Callable[[Mcu], None]:
    return lambda mcu: [command(mcu) for command in commands] and None


V = 50.0
UP = ramp(0, V)
CORNER = MDVEL / 0.6  # from X into (0.8, 0.6): Y changes most
ARC = math.sqrt(MAXACC["Y"])  # of 1 mm radius, by the smaller maxacc
WAY = math.pi / 2
WINDOW = math.sqrt(2 * AC)  # from which it can stop within 1 mm
PEAK = math.sqrt(AC + WINDOW**2)  # of a triangle of 1 mm from and to that

CASES = {
    "feed between two stops": Case(line(30), [("stop", UP), ("feed", cruise(30, 0, V, 0)), ("end_of_spool", UP)]),
    "a corner": Case(
        chain(line(30, tvl=V), line(54, 18)),
        [
            ("stop", UP),
            ("feed", cruise(30, 0, V, CORNER)),
            ("mdvel Y", 2 * ramp(V, CORNER)),
            ("feed", cruise(30, CORNER, V, 0)),
            ("end_of_spool", UP),
        ],
    ),
    "a corner seen from many short moves before and behind it": Case(
        chain(
            line(20, tvl=V),
            *(line(20 + n, tvl=V) for n in range(1, 11)),
            *(line(30 + 0.8 * n, 0.6 * n, tvl=V) for n in range(1, 11)),
            line(54, 18),
        ),
        [
            ("stop", UP),
            ("feed", cruise(30, 0, V, CORNER)),
            ("mdvel Y", 2 * ramp(V, CORNER)),
            ("feed", cruise(30, CORNER, V, 0)),
            ("end_of_spool", UP),
        ],
    ),
    "a slower move between faster ones": Case(
        chain(line(30, tvl=V), line(40, vl=20, tvl=20), line(70)),
        [
            ("stop", UP),
            ("feed", cruise(30, 0, V, 20) + 2 * ramp(V, 20) + 0.5 + cruise(30, 20, V, 0)),
            ("end_of_spool", UP),
        ],
    ),
    "maxvel of an axis": Case(
        line(160, 120, vl=200, ac=AC),
        [("stop", ramp(0, 125)), ("maxvel X", cruise(200, 0, 125, 0)), ("end_of_spool", ramp(0, 125))],
    ),
    "a move too short for its velocity": Case(line(4), [("ramp", 2 * math.sqrt(4 / AC))]),
    "the same with a lower acceleration by maxacc": Case(
        line(2, ac=1000), [("maxacc X", 2 * math.sqrt(2 / MAXACC["X"]))]
    ),
    "maxacc on an arc": Case(
        chain(line(20, tvl=V), lambda mcu: mcu.smca({"X": 20.0, "Y": 1.0}, 90, vl=V, ac=AC, tvl=V), line(21, 21)),
        [
            ("stop", UP),
            ("feed", cruise(20, 0, V, ARC)),
            ("arc_maxacc Y", 2 * ramp(V, ARC) + WAY / ARC),
            ("feed", cruise(20, ARC, V, 0)),
            ("end_of_spool", UP),
        ],
    ),
    "a target velocity of the program": Case(
        chain(line(30, tvl=15), line(60)),
        [
            ("stop", UP),
            ("feed", cruise(30, 0, V, 15)),
            ("target_velocity", 2 * ramp(V, 15)),
            ("feed", cruise(30, 15, V, 0)),
            ("end_of_spool", UP),
        ],
    ),
    "a stop of the program": Case(
        chain(line(30), line(60)),
        [
            ("stop", UP),
            ("feed", cruise(30, 0, V, 0)),
            ("stop", 2 * UP),
            ("feed", cruise(30, 0, V, 0)),
            ("end_of_spool", UP),
        ],
    ),
    "moves shorter than a sample": Case(
        chain(line(30, tvl=V), *(line(30 + 1.2 * V * TA * n, tvl=V) for n in range(1, 301)), line(60)),
        [
            ("stop", UP),
            ("feed", cruise(30, 0, V, V)),
            ("short_block", 300 * 1.2 * TA),
            ("feed", cruise(30 - 360 * V * TA, V, V, 0)),
            ("end_of_spool", UP),
        ],
    ),
    "nothing follows a move that goes on": Case(
        line(30, tvl=V), [("stop", UP), ("feed", cruise(30, 0, V, 0)), ("starved", UP + 0.1)]
    ),
    "a window of two moves": Case(
        chain(line(30, tvl=V), line(31, tvl=V), line(32, tvl=V), line(33)),
        [
            ("stop", UP),
            ("feed", cruise(30, 0, V, WINDOW)),
            ("lookahead_depth", ramp(V, WINDOW) + 3 * ramp(WINDOW, PEAK)),
            ("ramp", ramp(WINDOW, PEAK) + ramp(WINDOW, 0)),
        ],
        controller="lookahead_depth = 1",
    ),
    "half the override": Case(
        chain(lambda mcu: (mcu.wrtrovr(0.5), mcu.utrovr(AXES)), line(30)),
        [("override", 2 * (2 * UP + cruise(30, 0, V, 0)))],
    ),
    "a hold": Case(
        line(60),
        [
            ("stop", UP),
            ("feed", 0.5 - UP),
            ("hold", 1.0 + UP),
            ("feed", cruise(60, 0, V, 0) - (0.5 - UP) - UP),
            ("end_of_spool", UP),
        ],
        later={0.5: lambda mcu: mcu.hold(), 1.5: lambda mcu: mcu.resume()},
    ),
    "a dwell": Case(
        chain(line(30), lambda mcu: [mcu.ssf(a, 1003, 5000) for a in AXES], line(60)),
        [
            ("stop", UP),
            ("feed", cruise(30, 0, V, 0)),
            ("stop", UP),
            ("dwell", 5000 * TA),
            ("stop", UP),
            ("feed", cruise(30, 0, V, 0)),
            ("end_of_spool", UP),
        ],
    ),
    "a wait for an input": Case(
        chain(line(30), lambda mcu: [mcu.ssf(a, 1004, 1) for a in AXES]),
        [("stop", UP), ("feed", cruise(30, 0, V, 0)), ("end_of_spool", UP), ("wait", 0.1)],
    ),
    "NoTriangle": Case(
        chain(line(30, tvl=15), line(31, tvl=15), line(61)),
        [
            ("stop", UP),
            ("feed", cruise(30, 0, V, 15)),
            ("target_velocity", ramp(V, 15)),
            ("ramp", 1 / 15),
            ("target_velocity", ramp(V, 15)),
            ("feed", cruise(30, 15, V, 0)),
            ("end_of_spool", UP),
        ],
        bits=(*CHECKS, "NoTriangle"),
    ),
    "a jog": Case(lambda mcu: mcu.jr({"X": 1.0}) and None, [("end_of_spool", 2 * TA), ("direct", 0.0)]),
    "set points of the application": Case(
        lambda mcu: mcu.spd("X", [n * 1e-4 for n in range(500)]) and None, [("points", 500 * TA)]
    ),
}


def trace_of(case: Case) -> np.ndarray:
    """The flags of the run of a case, from the sample in which its first motion begins."""
    mcu = Mcu(Machine.parse(MACHINE.replace("[[axis]]", f"{case.controller}\n[[axis]]", 1)))
    mcu.cl(AXES)
    mcu.wrmodereg(ModeReg.of(*case.bits))
    case.give(mcu)
    mcu.ssms(AXES)
    times = [0.0, *case.later, sum(seconds for _, seconds in case.expected) + 0.05]
    flags = []
    for before, after in pairwise(times):
        mcu.advance(round(after / TA) - round(before / TA))
        flags.append(mcu.trace.flags)
        case.later.get(after, lambda mcu: None)(mcu)
    return np.concatenate(flags)


@pytest.mark.parametrize("name", CASES)
def test_the_known_cause_is_named_at_its_place_for_its_time(name: str) -> None:
    case = CASES[name]
    found = seen(trace_of(case))
    assert [cause for cause, _ in found][: len(case.expected)] == [cause for cause, _ in case.expected], found
    at, due = 0.0, 0.0
    for (cause, seconds), (_, wanted) in zip(found, case.expected[:-1], strict=False):
        at, due = at + seconds, due + wanted
        assert at == pytest.approx(due, abs=2.1 * TA), f"{cause} ends at {at} s, not at {due} s: {found}"
    assert found[len(case.expected) - 1][1] >= case.expected[-1][1] - 2.1 * TA


def gcode(text: str) -> dict:
    """The summary of a part program on the built-in mill."""
    job = compile_job(JobSource("constructed.nc", text.encode(), "din66025"), load_machine(None), CompileOptions())
    result = dry_run(job, RunOptions())
    samples = result.execution.mcu.samples()
    assert sum(n for _, n in result.summary["limits"]) == samples == result.summary["samples"]
    names, sample_time_s = job.machine.machine.axis_names, job.machine.machine.sample_time_us * 1e-6
    limits = limits_object(result.summary["limits"], names, sample_time_s)
    assert sum(limits.values()) == pytest.approx(result.execution.machine_time_s, rel=1e-12)
    return limits


def test_a_rapid_and_the_time_before_the_first_motion() -> None:
    # the mill: rapid 200 mm/s with 1000 mm/s²; the spooler stands until the task has spooled enough
    limits = gcode("G0 X200\nM30\n")
    assert limits["rapid"] == pytest.approx(cruise(200, 0, 200, 0, 1000), abs=2 * 1.28e-3)
    assert limits["stop"] == pytest.approx(ramp(0, 200, 1000), abs=2 * 1.28e-3)
    assert 0 < limits["idle"] <= 2 * 1.28e-3


def test_every_cause_is_among_the_cases() -> None:
    shown = {cause.split()[0] for case in CASES.values() for cause, _ in case.expected}
    assert shown | {"rapid", "idle"} == set(Cause) - {"unknown"}


def test_the_page_about_causes_has_all_of_them() -> None:
    page = (Path(__file__).parents[2] / "docs/limits.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)` \| (.+?) \| .+ \|$", page, re.MULTILINE)
    assert rows == [(cause, english(cause)) for cause in Cause if cause != "unknown"]


words = st.one_of(
    st.tuples(st.integers(-40, 40), st.integers(-40, 40), st.integers(300, 6000)).map(
        lambda w: f"G1 X{w[0] / 4} Y{w[1] / 4} F{w[2]}"
    ),
    st.tuples(st.integers(-20, 20), st.integers(1, 20)).map(lambda w: f"G91 G2 X0 Y0 I{w[0] / 4} J{w[1] / 4}\nG90"),
    st.sampled_from(["G4 F0.02", "G61", "G64", "G0 X1 Y2 Z3", "M0", "G9 G1 X5 F1000", "M3 S1000"]),
)


@settings(max_examples=40)
@given(st.lists(words, min_size=1, max_size=30))
def test_the_causes_of_random_programs_sum_to_the_run(lines: list[str]) -> None:
    limits = gcode("\n".join(["G17 G21 G90 F1000", *lines, "M30", ""]))
    assert "unknown" not in limits
    assert all(cause.partition(" ")[0] in set(Cause) for cause in limits)
