"""Cylinder surface G07.1: what `run` measures is the unrolled surface (design D7, D20)."""

from __future__ import annotations

import math
from pathlib import Path

from cnc_front.jobs import CompileOptions, compile_job, load_machine, read_job
from cnc_front.run import RunOptions, RunResult, dry_run
from tests.app.conftest import ROOT, Cli

MILL4C = ROOT / "examples" / "machines" / "mill4c.toml"
JOB = (
    "G21 G90 G17\nG0 X0 Y0 Z10 C0\nG07.1 C25\nG1 Z0 F1200\nG3 C60 Z20 R30\nG1 C90 Z5\n"
    "G07.1 C40\nG2 C60 Z25 R60\nG07.1 C0\nG0 Z10\nM30\n"
)


def run(tmp_path: Path, machine: Path) -> RunResult:
    job = tmp_path / "cylinder.nc"
    job.write_text(JOB)
    return dry_run(compile_job(read_job(str(job)), load_machine(str(machine)), CompileOptions()), RunOptions())


def test_the_deviation_is_that_of_the_surface(tmp_path: Path, cli: Cli) -> None:
    job = tmp_path / "cylinder.nc"
    job.write_text(JOB)
    result = cli("run", job, "--machine", MILL4C, "--json").object
    assert result["status"] == "completed" and result["alarms"] == []
    assert result["deviation"]["setpoint"]["max_mm"] < 1e-6
    assert 0 < result["deviation"]["actual"]["max_mm"] < 0.05


def test_the_path_length_is_measured_with_the_radius_of_each_move(tmp_path: Path) -> None:
    result = run(tmp_path, MILL4C)
    surface = math.hypot(math.radians(30) * 25, 15)  # C90 Z5 behind the first arc

    def arc(chord: float, radius: float) -> float:
        return 2 * radius * math.asin(chord / (2 * radius))

    feed = 10 + arc(math.hypot(math.radians(60) * 25, 20), 30) + surface
    feed += arc(math.hypot(math.radians(30) * 40, 20), 60)
    rapids = 10 + 15  # Z10 before, Z25 to Z10 behind
    assert math.isclose(result.summary["path_length_mm"], feed + rapids, abs_tol=1e-6)


def test_both_settings_of_rotatoric_unit_give_the_same_result(tmp_path: Path) -> None:
    other = tmp_path / "circumference.toml"
    other.write_text(MILL4C.read_text().replace('"RotatoricUnit", ', ""))
    one, two = run(tmp_path, MILL4C), run(tmp_path, other)
    assert one.execution.machine_time_s == two.execution.machine_time_s
    assert abs(one.summary["path_length_mm"] - two.summary["path_length_mm"]) < 1e-9
    assert two.summary["setpoint"]["max_mm"] < 1e-6
