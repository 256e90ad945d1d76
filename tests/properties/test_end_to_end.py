"""Whole runs of generated programs: the set point lies on the path, whatever the override; twice is the same."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cnc_front._native import toolpaths
from cnc_front.execution import End, Execution
from cnc_front.jobs import CompiledJob, CompileOptions, JobSource, compile_job, load_machine
from cnc_front.schedule import Schedule

SLOW = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
coordinate = st.integers(-4000, 4000).map(lambda n: n / 100)


@dataclass(frozen=True)
class Block:
    """One motion: `G1` with X Y Z, or an arc by its sweep about a centre given as an offset."""

    x: float
    y: float
    z: float
    feed: int
    sweep: float | None = None

    def text(self, at: tuple[float, float, float]) -> tuple[str, tuple[float, float, float]]:
        """The block from a position, and the position after it."""
        if self.sweep is None:
            return f"G1 X{self.x:.4f} Y{self.y:.4f} Z{self.z:.4f} F{self.feed}", (self.x, self.y, self.z)
        i, j = round(self.x / 4, 4), round(self.y / 4, 4)
        if math.hypot(i, j) < 0.5:
            i = 1.0
        angle = math.radians(self.sweep)
        cos, sin = math.cos(angle), math.sin(angle)
        end = (at[0] + i - i * cos + j * sin, at[1] + j - i * sin - j * cos)
        code = "G3" if self.sweep > 0 else "G2"
        x, y = round(end[0], 6), round(end[1], 6)
        return f"{code} X{x:.6f} Y{y:.6f} Z{self.z:.4f} I{i:.4f} J{j:.4f} F{self.feed}", (x, y, self.z)


blocks = st.lists(
    st.builds(
        Block,
        coordinate,
        coordinate,
        st.integers(-500, 500).map(lambda n: n / 100),
        st.integers(100, 6000),
        st.none() | st.integers(5, 350).map(float) | st.integers(-350, -5).map(float),
    ),
    min_size=1,
    max_size=12,
)
schedules = st.lists(st.tuples(st.integers(1, 40), st.integers(10, 150)), max_size=4).map(
    lambda points: ((0.0, 1.0), *((t / 10, f / 100) for t, f in sorted(dict(points).items())))
)


def program(parts: list[Block]) -> bytes:
    """A part program of these blocks."""
    at, lines = (0.0, 0.0, 0.0), ["G21 G17 G90 G94 G64"]
    for part in parts:
        text, at = part.text(at)
        lines.append(text)
    return "\n".join([*lines, "M30", ""]).encode()


def compiled(text: bytes) -> CompiledJob:
    """On the built-in mill."""
    return compile_job(JobSource("generated.nc", text, "din66025"), load_machine(None), CompileOptions())


@dataclass
class Measured:
    """Set points of a run and the summary of its tracker."""

    dp: np.ndarray
    load: np.ndarray
    summary: dict
    end: End | None
    time_s: float


def run(text: bytes, schedule: Schedule = ((0.0, 1.0),), chunk: int = 1 << 14) -> Measured:
    """From text to figures, in chunks of that size."""
    job = compiled(text)
    path = toolpaths.Path(job.program.sequence())
    execution = Execution(job, schedule, max_machine_s=3600.0)
    tracker = toolpaths.Tracker(
        path, sample_time_s=execution.sample_time_s, schedule=list(schedule), trovrst_s=job.machine.machine.trovrst_s
    )
    dp, load = [], []
    while (part := execution.advance(chunk)) is not None:
        if len(part):
            tracker.feed(part)
            dp.append(part.dp)
            load.append(part.load)
    return Measured(np.vstack(dp), np.vstack(load), tracker.finish(), execution.end, execution.machine_time_s)


@SLOW
@given(blocks, schedules)
def test_set_points_lie_on_the_path_at_any_override(parts: list[Block], schedule: Schedule) -> None:
    measured = run(program(parts), schedule)
    summary = measured.summary
    assert measured.end is End.FINISHED
    assert summary["completed"], f"{summary['missing_mm']} mm missing"
    assert summary["setpoint"]["max_mm"] <= summary["merged"][1] + 1e-9


@SLOW
@given(blocks, schedules, st.integers(1, 5000))
def test_the_same_run_twice_is_the_same_to_the_last_bit(parts: list[Block], schedule: Schedule, chunk: int) -> None:
    text = program(parts)
    first, second = run(text, schedule), run(text, schedule, chunk)
    assert np.array_equal(first.dp, second.dp)
    assert np.array_equal(first.load, second.load)


@SLOW
@given(blocks)
def test_it_ends_at_the_programmed_point_and_no_faster_than_programmed(parts: list[Block]) -> None:
    at, least_s, z = (0.0, 0.0, 0.0), 0.0, 0.0
    for part in parts:
        _, end = part.text(at)
        if part.sweep is None:
            length = math.dist(at, end)
        else:
            i, j = round(part.x / 4, 4), round(part.y / 4, 4)
            radius = math.hypot(1.0 if math.hypot(i, j) < 0.5 else i, j)
            length = math.hypot(radius * math.radians(abs(part.sweep)), end[2] - z)
        least_s += length / (part.feed / 60)
        at, z = end, end[2]
    measured = run(program(parts))
    assert measured.dp[-1] == pytest.approx(at, abs=1e-9)
    assert measured.time_s >= least_s * (1 - 1e-9)


@SLOW
@given(blocks, st.integers(20, 99))
def test_a_constant_override_stretches_time_and_leaves_the_path(parts: list[Block], percent: int) -> None:
    text, factor = program(parts), percent / 100
    plain, slowed = run(text), run(text, ((0.0, factor),))
    # what is left of a sample is lost only at the two ends, settling at the end aside
    assert slowed.summary["setpoint"]["max_mm"] <= slowed.summary["merged"][1] + 1e-9
    moving = plain.summary["feed_s"]
    assert slowed.summary["feed_s"] * factor == pytest.approx(moving, abs=0.01 + 0.01 * moving)


@SLOW
@given(blocks, st.floats(0.1, 0.9))
def test_splitting_a_line_changes_nothing(parts: list[Block], share: float) -> None:
    lines = [p for p in parts if p.sweep is None and p.feed >= 600][:1]
    if not lines or math.dist((0, 0, 0), (lines[0].x, lines[0].y, lines[0].z)) < 5:
        return
    end, feed = (lines[0].x, lines[0].y, lines[0].z), lines[0].feed
    middle = tuple(round(share * v, 9) for v in end)
    whole = f"G1 X{end[0]} Y{end[1]} Z{end[2]} F{feed}\nM30\n"
    split = f"G1 X{middle[0]:.9f} Y{middle[1]:.9f} Z{middle[2]:.9f} F{feed}\nX{end[0]} Y{end[1]} Z{end[2]}\nM30\n"
    a, b = run(whole.encode()), run(split.encode())
    n = min(len(a.dp), len(b.dp))
    assert np.abs(a.dp[:n] - b.dp[:n]).max() <= 1e-6
