"""Deviation of real runs against a slow reference that knows neither the kernel's nor toolpaths' geometry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cnc_front import jobs
from cnc_front._native import toolpaths
from cnc_front.execution import Execution

JOBS = Path(__file__).parents[2] / "examples" / "jobs"
TA = 1.28e-3
Points = NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """A block: its length and its positions at shares 0..1 of it. Linear axes only."""

    length: float
    at: Callable[[Points], Points]


def line(start: Points, end: Points) -> Curve:
    return Curve(float(np.linalg.norm(end - start)), lambda u: start + np.outer(u, end - start))


def helix(start: Points, end: Points, axes: tuple[int, int], center: Points, phi: float) -> Curve:
    radius = start[list(axes)] - center
    straight = end - start
    straight[list(axes)] = 0.0

    def at(u: Points) -> Points:
        points = start + np.outer(u, straight)
        sin, cos = np.sin(u * phi), np.cos(u * phi)
        points[:, axes[0]] = center[0] + radius[0] * cos - radius[1] * sin
        points[:, axes[1]] = center[1] + radius[0] * sin + radius[1] * cos
        return points

    return Curve(float(np.hypot(np.hypot(*radius) * phi, np.linalg.norm(straight))), at)


def curves_of(sequence: dict[str, NDArray[Any]]) -> list[Curve]:
    """The path as programmed, block by block, with the blocks that merged lines replace."""
    here = sequence["start"].copy()
    targets = sequence["target"].reshape(-1, len(here))
    vias = sequence["via_target"].reshape(-1, len(here))
    curves = []
    for i, kind in enumerate(sequence["kind"]):
        if kind == 0:
            first = sequence["via_first"][i]
            for end in [*vias[first : first + sequence["via_count"][i]], targets[i]]:
                curves.append(line(here, end))
                here = end
        else:
            axes = (int(sequence["c1"][i]), int(sequence["c2"][i]))
            center = sequence["center"].reshape(-1, 2)[i]
            curves.append(helix(here, targets[i].copy(), axes, center, float(np.radians(sequence["phi"][i]))))
        here = targets[i]
    return [curve for curve in curves if curve.length > 0]


class Reference:
    """Nearest distance within a stretch of the path: dense points, then denser ones about the best."""

    STEP = 5e-3

    def __init__(self, curves: list[Curve]) -> None:
        self.curves = curves
        self.s0 = np.concatenate([[0.0], np.cumsum([c.length for c in curves])])
        grids = [np.linspace(0, 1, int(c.length / self.STEP) + 2) for c in curves]
        self.s = np.concatenate([s0 + c.length * u for s0, c, u in zip(self.s0, curves, grids, strict=False)])
        self.points = np.concatenate([c.at(u) for c, u in zip(curves, grids, strict=True)])
        self.owner = np.repeat(np.arange(len(curves)), [len(u) for u in grids])

    def distance(self, x: Points, low: float, high: float) -> tuple[float, float]:
        """Distance of `x` from the path between two path lengths, and the path length there."""
        a, b = np.searchsorted(self.s, low), np.searchsorted(self.s, high, side="right")
        best = a + int(np.argmin(((self.points[a:b] - x) ** 2).sum(1)))
        found = (np.inf, 0.0)
        for i in {self.owner[best], self.owner[max(best - 1, a)], self.owner[min(best + 1, b - 1)]}:
            found = min(found, self._refined(int(i), x, self.s[best], (low, high)))
        return found

    def _refined(self, i: int, x: Points, s: float, limits: tuple[float, float]) -> tuple[float, float]:
        curve, span = self.curves[i], self.STEP
        u = (s - self.s0[i]) / curve.length
        first, last = (np.clip((np.array(limits) - self.s0[i]) / curve.length, 0, 1)).tolist()
        for _ in range(3):
            grid = np.clip(np.linspace(u - span / curve.length, u + span / curve.length, 401), first, last)
            points = curve.at(grid)
            # pieces between grid points: their chords err by less than 1e-12 mm in the last round
            step = np.diff(points, axis=0)
            square = np.maximum((step**2).sum(1), 1e-300)
            share = np.clip(((x - points[:-1]) * step).sum(1) / square, 0, 1)
            off = np.linalg.norm(points[:-1] + share[:, None] * step - x, axis=1)
            best = int(np.argmin(off))
            u, span = float(grid[best]), span / 100
        return float(off[best]), float(self.s0[i] + u * curve.length)


@dataclass(frozen=True)
class Traced:
    """All samples of a run, and what the tracker said of them."""

    reference: Reference
    dp: Points
    load: Points
    actual_mm: NDArray[np.float32]
    summary: dict[str, Any]
    feet: Points


def follow(reference: Reference, dp: Points) -> Points:
    """Path length of the set points, by a search ahead that is far wider than the tracker's."""
    feet = np.zeros(len(dp))
    i = 0
    for k, x in enumerate(dp):
        ahead = np.searchsorted(reference.s, reference.s[i] + 0.6)
        i += int(np.argmin(((reference.points[i : ahead + 1] - x) ** 2).sum(1)))
        feet[k] = reference.s[i]
    return feet


def run(text: str, machine_file: str | None = None) -> Traced:
    machine = jobs.load_machine(machine_file)
    source = jobs.JobSource("part.nc", text.encode(), "din66025")
    job = jobs.compile_job(source, machine, jobs.CompileOptions())
    sequence = job.program.sequence()
    tracker = toolpaths.Tracker(toolpaths.Path(sequence), sample_time_s=TA)
    execution = Execution(job)
    found, dp, load = [], [], []
    while (chunk := execution.advance(4096)) is not None:
        found.append(tracker.feed(chunk))
        dp.append(chunk.dp.copy())
        load.append(chunk.load.copy())
    reference = Reference(curves_of(sequence))
    points = np.concatenate(dp)
    return Traced(
        reference, points, np.concatenate(load), np.concatenate(found), tracker.finish(), follow(reference, points)
    )


def head(name: str, lines: int) -> str:
    """The first blocks of an example, as a program of its own."""
    text = (JOBS / name).read_text("utf-8").splitlines()[:lines]
    return "\n".join([*text, "M30", ""])


def expected(traced: Traced, k: int) -> float:
    """Deviation of the load side at a sample, by the reference."""
    return traced.reference.distance(traced.load[k], traced.feet[k] - 3.0, traced.feet[k] + 0.1)[0]


def expected_forward(traced: Traced, k: int) -> float:
    """The same, where the load side swings back: its foot does not go back behind where it has been."""
    reference, been = traced.reference, 0.0
    for j in range(max(0, k - 60), k):
        set_foot = reference.distance(traced.dp[j], traced.feet[j] - 0.01, traced.feet[j] + 0.01)[1]
        foot = reference.distance(traced.load[j], max(been, traced.feet[j] - 3.0), traced.feet[j] + 0.1)[1]
        been = max(been, min(foot, set_foot))
    return reference.distance(traced.load[k], max(been, traced.feet[k] - 3.0), traced.feet[k] + 0.1)[0]


@pytest.mark.parametrize(("name", "lines"), [("bracket.nc", 60), ("cam.nc", 40), ("engraving.nc", 500)])
def test_deviation_of_a_real_run_is_that_of_the_slow_reference(name: str, lines: int) -> None:
    traced = run(head(name, lines))
    assert traced.summary["completed"]
    assert traced.summary["path_length_mm"] == pytest.approx(traced.reference.s0[-1], rel=1e-12)
    worst = int(np.argmax(traced.actual_mm))
    samples = {*range(0, len(traced.dp), max(1, len(traced.dp) // 1500)), *range(max(0, worst - 20), worst + 1)}
    swung_back = 0
    for k in samples:
        found = float(traced.actual_mm[k])
        # f32 of the per-sample column: 6e-8 relative
        if found != pytest.approx(expected(traced, k), abs=1e-9, rel=1e-7):
            swung_back += 1
            # the reference's feet lie on a grid of 2.5e-9 mm
            assert found == pytest.approx(expected_forward(traced, k), abs=1e-7), f"sample {k}"
    assert swung_back <= len(samples) // 50
    assert traced.summary["actual"]["max_mm"] == pytest.approx(float(traced.actual_mm.max()), rel=1e-6)


def test_a_backlash_is_seen_on_the_load_side_only(tmp_path: Path) -> None:
    text = jobs.load_machine(None).text
    assert text.count("full_speed = 250.0 }") >= 2
    machine = tmp_path / "worn.toml"
    machine.write_text(text.replace("full_speed = 250.0 }", "full_speed = 250.0, backlash = 0.1 }", 2), "utf-8")
    # on the way out the load hangs back by half of the play in X, and keeps that while Y runs; then the other way
    program = "G21 G90 G17 G61\nG1 X4 F30\nG1 Y4\nG1 X2\nM30\n"
    worn, sound = run(program, str(machine)).summary, run(program).summary
    # the motor swings past its stops by less than a micrometre and takes the load along
    assert worn["actual"]["max_mm"] == pytest.approx(0.05, rel=0.02)
    assert worn["actual"]["worst"]["line"] in (3, 4)
    assert worn["actual"]["left_mm"] == pytest.approx(0.05, rel=0.02)
    assert sound["actual"]["max_mm"] < 0.001
    assert worn["setpoint"]["max_mm"] < 1e-9


def test_the_reference_knows_a_circle() -> None:
    circle = helix(np.array([5.0, 0, 0]), np.array([5.0, 0, 0]), (0, 1), np.zeros(2), 2 * np.pi)
    reference = Reference([circle])
    distance, s = reference.distance(np.array([0.0, 5.003, 0.004]), 0.0, 30.0)
    assert distance == pytest.approx(0.005, abs=1e-12)
    assert s == pytest.approx(2.5 * np.pi, abs=1e-6)
