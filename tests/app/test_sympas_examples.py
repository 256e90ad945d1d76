"""The jobs of examples/sympas do what their comments say."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cnc_front.cli import run_command_line

FOLDER = Path(__file__).parents[2] / "examples" / "sympas"
Run = Callable[[str], dict[str, Any]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def inner(name: str) -> dict[str, Any]:
        job, machine = str(FOLDER / name), str(FOLDER / "machine.toml")
        assert run_command_line(["run", job, "--machine", machine, "--json"]) == 0
        found: dict[str, Any] = json.loads(capsys.readouterr().out)
        assert found["verdict"]["word"] == "PASS"
        return found

    return inner


def test_pick_homes_and_latches(run: Run) -> None:
    lines = run("pick.src")["output"]
    places = [float(line.split(" at ")[1].split()[0]) for line in lines]
    # 62 mm on the scale of the machine; the index that becomes zero is that at -18 mm
    assert places == pytest.approx([80.0] * 3, abs=0.002)


def test_shear_runs_with_the_material(run: Run) -> None:
    found = run("shear.src")
    off = [float(line.split(": ")[1].split()[0]) for line in found["output"]]
    assert len(off) == 4 and max(map(abs, off)) < 50.0 * 1.28e-3, "less than a sample interval"
    assert found["axes"]["Y"]["velocity_max"] == pytest.approx(50.0, rel=1e-6), "never faster than the material"


def test_drill_drives_its_table(run: Run) -> None:
    found = run("drill.src")
    assert found["output"] == ["6 features spooled, 20 commands", "done"]
    assert found["commands"] == {"smla": 18, "smlr": 1, "smha": 1, "ssf": 12}
    stops = [(10, 10), (90, 10), (20, 30), (62, 55), (10, 80), (90, 80)]
    leaves = [stops[0], stops[1], (80, 30), *stops[3:]]
    ways = math.dist((0, 0, 0), (10, 10, 2)) + sum(map(math.dist, leaves, stops[1:]))
    assert found["path_length_mm"] == pytest.approx(ways + 12 * 5 + 60 + 2 * math.pi * 12, rel=1e-9)
    [circle] = found["circularity"]
    assert circle["radius_mm"] == pytest.approx(12.0) and circle["circular_mm"] < 0.005
