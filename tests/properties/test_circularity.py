"""Circular tests by ISO 230-4 against closed forms: gain mismatch, backlash at the quadrants, lag of the loops."""

from __future__ import annotations

import cmath
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog

from cnc_front import jobs
from tests.properties.test_diagnosis import TA, Matrix, Run
from toolpaths.circularity import Contour, least_squares, zone

# run in and out along tangents, so that no start from rest is part of a circle
BOTH_WAYS = """G21 G90 G17 G64
G1 X20 Y-30 F{feed}
Y0
G3 X20 Y0 I-20 J0
G1 Y30
Y0
G2 X20 Y0 I-20 J0
G1 Y-30
M30
"""
ANGLES = np.arange(720) * math.tau / 720


def contour(low: NDArray[np.float64], high: NDArray[np.float64] | None = None) -> Contour:
    high = low if high is None else high
    return Contour(ANGLES, low, ANGLES, high, ANGLES, 0.5 * (low + high))


@pytest.mark.parametrize("seed", range(8))
def test_the_minimum_zone_is_that_of_linear_programming(seed: int) -> None:
    random = np.random.default_rng(seed)
    shapes = [
        1e-3 * (np.cos(2 * ANGLES + k) + random.normal(0, 0.2, 720) + 3 * np.sin(ANGLES)) for k in range(1 + seed % 2)
    ]
    contours = [contour(r, r + abs(random.normal(0, 1e-4, 720))) for r in shapes]
    radius = np.concatenate([part for c in contours for part in (c.low, c.high)])
    angle = np.tile(ANGLES, 2 * len(contours))
    basis = np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
    one = -np.ones((len(angle), 1))
    bounds = [(None, None)] * 4
    best = linprog(
        [0, 0, 0, 1], np.block([[basis, one], [-basis, one]]), np.concatenate([radius, -radius]), bounds=bounds
    )
    assert zone(contours)[0] == pytest.approx(2 * best.fun, rel=1e-9)


def test_an_excentric_circle_is_round() -> None:
    width, centre = zone([contour(0.003 * np.cos(ANGLES) - 0.001 * np.sin(ANGLES) + 0.01)])
    assert width == pytest.approx(0.0, abs=1e-12)
    assert centre == pytest.approx((0.003, -0.001), abs=1e-12)
    assert least_squares([contour(0.01 + 0.003 * np.cos(ANGLES))])[0] == pytest.approx(0.01)


@pytest.fixture(scope="module")
def both() -> Run:
    return Run(BOTH_WAYS.format(feed=600))


def circles_of(run: Run, change: object = None) -> list[dict[str, object]]:
    if change is None:
        return run.measured(run.columns, run.sequence)["circularity"]  # type: ignore[no-any-return]
    return run.spoilt(change, "load")["circularity"]  # type: ignore[no-any-return, arg-type]


def test_a_clean_machine_is_round_both_ways(both: Run) -> None:
    ccw, cw = circles_of(both)
    assert (ccw["line"], ccw["direction"], ccw["pair"]) == (4, "ccw", 1)
    assert (cw["line"], cw["direction"], cw["pair"]) == (7, "cw", 0)
    assert ccw["radius_mm"] == pytest.approx(20) and ccw["feed_mm_min"] == pytest.approx(600)
    for circle in (ccw, cw):
        assert 0 < circle["circular_mm"] < 1e-3  # type: ignore[operator]
        assert circle["circular_mm"] <= circle["radial_max_mm"] - circle["radial_min_mm"]  # type: ignore[operator]
        assert circle["bidirectional_mm"] >= circle["circular_mm"]  # type: ignore[operator]


def test_a_gain_mismatch_is_an_ellipse(both: Run) -> None:
    def change(x: Matrix) -> None:
        # the load is exactly on the set point, X 1 per mille too far about the centre
        x[:] = both.columns["dp"]
        x[:, 0] *= 1.001

    for circle in circles_of(both, change):
        assert circle["radial_max_mm"] == pytest.approx(0.02, rel=1e-3)
        assert circle["radial_min_mm"] == pytest.approx(0.0, abs=1e-5)
        assert circle["circular_mm"] == pytest.approx(0.02, rel=1e-3)
        assert circle["bidirectional_mm"] == pytest.approx(0.02, rel=1e-3), "the same ellipse both ways"
        assert circle["mean_bidirectional_mm"] == pytest.approx(0.01, rel=2e-3)


def test_backlash_steps_at_the_quadrants(both: Run) -> None:
    play = 0.01

    def change(x: Matrix) -> None:
        x[:] = both.columns["dp"]
        load = x[0, 0] - play / 2
        for k in range(len(x)):
            load = min(max(load, x[k, 0] - play / 2), x[k, 0] + play / 2)
            x[k, 0] = load

    ccw, cw = circles_of(both, change)
    # behind by half the play against the motion of X: r = -play/2 * sign(dx) * cos; both signs on each path
    for circle in (ccw, cw):
        assert circle["radial_max_mm"] == pytest.approx(play / 2, rel=0.02)
        assert circle["radial_min_mm"] == pytest.approx(-play / 2, rel=0.02)
    # the paths mirror each other: together they reach from -play/2 to play/2 on either side
    assert ccw["bidirectional_mm"] == pytest.approx(play, rel=0.02)
    assert ccw["mean_bidirectional_mm"] == pytest.approx(0.0, abs=1e-4)


def test_the_lag_of_the_loops_makes_circles_small(tmp_path: Path) -> None:
    """Without feed-forward and drive lag a sampled loop of gain K follows a circle with the magnitude of its response:
    y(k+1) = y(k) + K TA (e(k) + e(k-1)) / 2 by the bilinear PIDF filter (design D26)."""
    text = jobs.load_machine(None).text.replace("kfcv = 0.0131068, kfca = 0.0000477088", "kfcv = 0.0, kfca = 0.0")
    assert text.count("kfcv = 0.0,") == 3
    soft = tmp_path / "soft.toml"
    soft.write_text(text.replace("lag_s = 0.003", "lag_s = 0.0"), "utf-8")
    feed, radius = 1200.0, 20.0
    gain = 0.6553 * 10000 * 250 / 32767 * TA
    z = cmath.exp(1j * feed / 60 / radius * TA)
    error = gain * (1 + 1 / z) / 2
    shrunk = radius * (abs(error / (z - 1 + error)) - 1)
    assert shrunk == pytest.approx(-0.0035, rel=0.01)
    for circle in circles_of(Run(BOTH_WAYS.format(feed=feed), str(soft))):
        assert circle["radial_min_mm"] == pytest.approx(shrunk, abs=1.5e-4), "to the count of 0.1 um"
        assert circle["mean_bidirectional_mm"] == pytest.approx(shrunk, rel=0.03)
