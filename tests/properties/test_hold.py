"""Hold is real (design D5): at random times in programs of lines, arcs, helices and chains of short blocks, also twice
in one block, the set points before and after lie on the path, and the end is as much later as the stops explain."""

from __future__ import annotations

import math
import os
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.execution import End
from cnc_front.jobs import CompileOptions, JobSource, load_machine
from cnc_front.sim_job import LoadedJob, load_source
from cnc_front.sim_run import SimRun

Floats = NDArray[np.float64]

#: Holds in all; HOLDS=2000 looks longer.
HOLDS = int(os.environ.get("HOLDS", "200"))
PROGRAMS = 20
ON_PATH_MM = 1e-9
SAMPLE_S = 1.28e-3


def lines(chance: random.Random) -> Iterator[str]:
    for _ in range(6):
        yield f"G1 X{chance.uniform(-40, 40):.3f} Y{chance.uniform(-40, 40):.3f} F{chance.randint(300, 6000)}"


def arcs(chance: random.Random) -> Iterator[str]:
    """Half circles: their ends are exact in the program."""
    x = 0.0
    for turn in range(5):
        width = chance.randint(4, 30) * (-1) ** turn
        yield f"G{chance.choice((2, 3))} X{x + width} Y0 I{width / 2} J0 F{chance.randint(600, 6000)}"
        x += width


def helices(chance: random.Random) -> Iterator[str]:
    z = 0.0
    for _ in range(3):
        z -= chance.randint(1, 8)
        yield f"G3 X0 Y0 Z{z} I{chance.randint(3, 15)} J0 F{chance.randint(600, 5000)}"


def chain(chance: random.Random) -> Iterator[str]:
    """A curve in blocks of about a tenth of a millimetre: braking takes many of them."""
    radius, feed = chance.uniform(5, 15), chance.randint(2000, 6000)
    for n in range(1, 400):
        angle = n * 0.1 / radius
        x, y = radius * math.sin(angle), radius * (1 - math.cos(angle)) * (1 + 0.1 * math.sin(7 * angle))
        yield f"G1 X{x:.4f} Y{y:.4f} Z{-n / 1000:.4f} F{feed}"


def mixed(chance: random.Random) -> Iterator[str]:
    yield "G0 X20 Y10"
    yield f"G1 X{chance.randint(30, 60)} Y10 F{chance.randint(1000, 6000)}"
    yield "G91 G3 X10 Y10 I0 J10"
    yield "G1 Y12"
    yield "G90 G0 X0 Y0 Z5"


KINDS: tuple[Callable[[random.Random], Iterator[str]], ...] = (lines, arcs, helices, chain, mixed)


@cache
def loaded(number: int) -> LoadedJob:
    text = "\n".join(["G21 G17 G90 G94 G64 P0", *KINDS[number % len(KINDS)](random.Random(number)), "M30", ""])
    return load_source(
        JobSource(f"hold{number}.nc", text.encode(), "din66025"), load_machine(None), CompileOptions(), None
    )


@dataclass
class Driven:
    """A finished run: way of the set points per sample, the worst distance of one from the path."""

    way: Floats
    off_path_mm: float
    missing_mm: float
    end: tuple[float, ...]
    samples: int


@dataclass(frozen=True)
class Pause:
    """Samples at which the operator held, at which the axes stood, and at which they went on."""

    held: int
    stood: int
    resumed: int


def drive(job: LoadedJob, holds: list[int], wait: int = 137) -> tuple[Driven, list[Pause]]:
    """Runs a job and holds at these samples of its own time (standstill not counted)."""
    run = SimRun(job, 1.0)
    points: list[Floats] = []
    measure = run._measure

    def measured(chunk: native_kernel.Chunk) -> None:
        points.append(np.array(chunk.dp))
        measure(chunk)

    run._measure = measured  # type: ignore[method-assign]
    pauses: list[Pause] = []
    for at in holds:
        while not run.is_over and run.samples < at:
            run.advance(at - run.samples)
        if run.is_over:
            break
        held = run.samples
        run.hold()
        while not run.execution.held and not run.is_over:
            run.advance(1)
        if run.is_over:
            break
        stood = run.samples
        run.advance(wait)
        pauses.append(Pause(held, stood, run.samples))
        run.go_on(single_block=False)
    while not run.is_over:
        run.advance(1 << 14)
    assert run.execution.end is End.FINISHED and not run.execution.alarms
    dp = np.concatenate(points)
    steps = np.linalg.norm(np.diff(dp, axis=0, prepend=dp[:1]), axis=1)
    result = run.tracker.finish()
    missing = float(result["missing_mm"])
    assert result["completed"] and result["merged"][1] == 0.0
    return Driven(np.cumsum(steps), float(result["setpoint"]["max_mm"]), missing, tuple(dp[-1]), run.samples), pauses


def explained(job: LoadedJob, before: Driven, after: Driven, pause: Pause) -> None:
    """The end is later by what the stop costs: braking on the way that it needs, standstill, then acceleration
    with the path acceleration up to the speed of the run without the stop; from there on all is as without it."""
    acc = float(np.min(job.job.program.sequence()["ac"]))
    assert np.array_equal(before.way[: pause.held], after.way[: pause.held]), "until then nothing is different"
    speed = np.diff(before.way, prepend=0.0) / SAMPLE_S
    at, stand = after.way[pause.held - 1], after.way[pause.stood - 1]
    fastest = speed[pause.held - 1 : pause.held + 3].max()
    assert stand - at <= fastest**2 / (2 * acc) + 3 * fastest * SAMPLE_S + 1e-6, "brakes on the way it needs"
    assert after.way[pause.resumed - 1] - stand < 1e-9, "stands until it is told to go on"
    rest = max(int(np.searchsorted(before.way, stand)), pause.held)
    ahead = before.way[rest:] - stand
    slower = np.flatnonzero(np.sqrt(2 * acc * np.maximum(ahead, 0.0)) < speed[rest:])
    meets = int(slower[-1]) + 1 if len(slower) else 0  # samples until the speed is that of the other run again
    accelerating = np.sqrt(2 * ahead[min(meets, len(ahead) - 1)] / acc) / SAMPLE_S if meets else 0.0
    expected = pause.resumed + accelerating + before.samples - rest - meets
    # behind the end of the path the axes settle for 8 samples, behind a stop there once more
    allowed = 2.0 if before.way[-1] - stand > 1e-3 else 12.0
    assert abs(after.samples - expected) <= allowed


@pytest.mark.parametrize("number", range(PROGRAMS))
def test_hold_at_random_times(number: int) -> None:
    job, chance = loaded(number), random.Random(1000 + number)
    plain, _ = drive(job, [])
    moving = np.flatnonzero(np.diff(plain.way) > 0)
    for n in range(max(1, HOLDS // PROGRAMS)):
        at = chance.randint(int(moving[0]) + 1, int(moving[-1]))
        once, stops = drive(job, [at])
        runs = [(plain, once, stops[-1])]
        if n % 3 == 0:  # and once more soon after it has gone on: often in the same block
            again = stops[0].resumed + chance.randint(2, 40)
            if again < once.samples - 20:
                twice, both = drive(job, [at, again])
                runs.append((once, twice, both[-1]))
        for before, after, pause in runs:
            assert after.off_path_mm <= ON_PATH_MM, "before and after the stop"
            assert abs(after.missing_mm) <= ON_PATH_MM and after.end == plain.end
            explained(job, before, after, pause)


def test_the_check_sees_a_stop_that_leaves_the_path() -> None:
    """`js` instead of a hold: each axis on its own ramp."""
    job = loaded(1)
    run = SimRun(job, 1.0)
    run.advance(900)
    run.execution.mcu.js([0, 1, 2])
    run.advance(400)
    assert float(run.tracker.finish()["setpoint"]["max_mm"]) > ON_PATH_MM
