"""Threads and tapping with a spindle axis, run to the end on servo drives."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cnc_front.execution import Execution
from cnc_front.jobs import CompileOptions, compile_job, load_machine, read_job
from tests.app.conftest import ROOT, Cli

MILL3S = ROOT / "examples" / "machines" / "mill3s.toml"
JOB = "G21 G90\nG0 X10 Y0 Z5\nM3 S600\nG84 X10 Z-12 R2 F600\nX30\nG80\nG33 X20 Z-20 K1.5\nZ-26\nG0 Z20\nM5\nM30\n"


def test_a_run_is_on_the_path_and_without_alarms(tmp_path: Path, cli: Cli) -> None:
    job = tmp_path / "tap.nc"
    job.write_text(JOB)
    for override in ("1", "0:1,2:0.4,4:1.2"):
        ran = cli("run", job, "--machine", MILL3S, "--override", override, "--json").object
        assert ran["status"] == "completed" and ran["alarms"] == [] and ran["error_register"] == []
        assert ran["deviation"]["setpoint"]["max_mm"] < 1e-6
        assert ran["verdict"]["word"] == "PASS", ran["verdict"]


def test_the_load_keeps_the_lead_through_acceleration_and_reversal(tmp_path: Path) -> None:
    job = tmp_path / "tap.nc"
    job.write_text("G0 Z5\nM3 S600\nG84 Z-12 R2 F600\nG80\nM30\n")
    execution = Execution(compile_job(read_job(str(job)), load_machine(str(MILL3S)), CompileOptions()))
    rows = []
    while (chunk := execution.advance(4096)) is not None:
        rows.append(np.asarray(chunk.load))
    load = np.concatenate(rows)
    depth, turns = 2.0 - load[:, 2], load[:, 3] / 360.0
    cutting = turns > 0.05
    assert turns.max() > 13.9
    # 1 mm a turn; set points agree exactly, drives to their lag
    assert np.abs(depth - turns)[cutting].max() < 0.03
