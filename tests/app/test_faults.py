"""Fault scenes of issue 5: what happened, where and which axis; exit code 3; the recording is complete."""

from __future__ import annotations

import json
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnc_front.recording import open_recording
from tests.app.conftest import ROOT, Cli

FAULTS = ROOT / "examples" / "faults"
CONTOUR, REFERENCE = FAULTS / "contour.nc", FAULTS / "reference.nc"

#: stimulus, job, bit, axis, line of the program, where its load was then, mm
SCENES: list[tuple[str, Path, str, str, int, float]] = [
    ("limit_tom", CONTOUR, "lsrh", "X", 5, 45.0),
    ("limit_sma", CONTOUR, "lsrh", "Y", 7, 25.0),
    ("limit_smd", CONTOUR, "lslh", "X", 10, -5.0),
    ("blocked_axis", CONTOUR, "mpe", "X", 5, 20.0),
    ("drive_dropout", CONTOUR, "dnr", "Y", 7, 20.0),
    ("bouncing_switch", REFERENCE, "lslh", "X", 4, -50.0),
]


def played(cli: Cli, job: Path, stimulus: str, *more: object) -> dict[str, Any]:
    """The result of a run that a fault stopped."""
    ran = cli("run", job, "--stimulus", FAULTS / f"{stimulus}.stim", "--json", *more)
    assert ran.code == 3, ran.err
    run = ran.object
    assert (run["status"], run["error"]["id"], run["verdict"]["word"]) == ("stopped", "CF302", "FAIL")
    return run


def loads(recording: Path) -> Any:
    """Load positions of all samples."""
    return np.concatenate([columns["load"] for columns in open_recording(str(recording)).columns()])


def events(recording: Path) -> list[dict[str, Any]]:
    """What was logged beside the samples."""
    recorded = open_recording(str(recording))
    assert list(recorded.columns()) and recorded.result is not None and recorded.damage is None
    return recorded.events


@pytest.mark.parametrize(("stimulus", "job", "bit", "axis", "line", "place"), SCENES)
def test_scene(
    cli: Cli, tmp_path: Path, stimulus: str, job: Path, bit: str, axis: str, line: int, place: float
) -> None:
    recording = tmp_path / "fault.mcap"
    run = played(cli, job, stimulus, "--record", recording)
    error = run["error"]
    assert (error["name"], error["axis"], error["line"]) == (bit, axis, line)
    assert error["position"][axis] == pytest.approx(place, abs=0.25)
    assert f"{bit} {axis}" in error["message"] and f"line {line}" in error["message"]
    first = run["alarms"][0]
    assert (first["name"], first["axis"], first["t_s"]) == (bit, axis, error["t_s"])
    course = loads(recording)
    assert len(course) == run["samples"], "every sample is recorded"
    assert run["machine_time_s"] > error["t_s"] + 0.01
    assert np.abs(course[-1] - course[-5]).max() < 0.01, "up to the standstill"
    assert any(event["kind"] == "stimulus" for event in events(recording))
    rules = (FAULTS / f"{stimulus}.stim").read_text()
    assert open_recording(str(recording)).metadata["stimulus"] == rules, "the recording says what acted"


def test_emergency_out_takes_all_axes(cli: Cli, tmp_path: Path) -> None:
    recording = tmp_path / "fault.mcap"
    run = played(cli, CONTOUR, "emergency_out", "--record", recording)
    assert run["error"]["name"] == "eo"
    assert run["error"]["t_s"] == pytest.approx(1.5, abs=2e-3)
    assert {a["axis"] for a in run["alarms"] if a["name"] == "eo"} == {"X", "Y", "Z"}
    course = loads(recording)
    assert len(course) == run["samples"]
    end = [event for event in events(recording) if event["kind"] == "outputs"][-1]
    assert end["value"] & 0b1110_0000 == 0, "open loops: the amplifiers have no power"


def test_how_the_limit_functions_differ(cli: Cli, tmp_path: Path) -> None:
    # TOM coasts over the switch, SMA stands on it, SMD brakes with sdec (1000 mm/s2 from 43 mm/s on the arc: 0.94 mm)
    def overrun(stimulus: str, axis: int, direction: int) -> float:
        recording = tmp_path / f"{stimulus}.mcap"
        place = next(scene[5] for scene in SCENES if scene[0] == stimulus)
        played(cli, CONTOUR, stimulus, "--record", recording)
        return float(((loads(recording)[:, axis] - place) * direction).max())

    tom, sma, smd = overrun("limit_tom", 0, 1), overrun("limit_sma", 1, 1), overrun("limit_smd", 0, -1)
    assert 0.1 < tom < 0.6, tom
    assert sma < 0.6, sma
    assert 0.9 < smd < 1.0, smd


def test_the_same_fault_is_the_same_run(cli: Cli, tmp_path: Path) -> None:
    recordings = [tmp_path / f"{n}.mcap" for n in range(2)]
    for recording in recordings:
        played(cli, CONTOUR, "drive_dropout", "--record", recording)
    assert recordings[0].read_bytes() == recordings[1].read_bytes()


def test_without_a_fault_the_same_job_passes(cli: Cli) -> None:
    for job in (CONTOUR, REFERENCE):
        ran = cli("run", job, "--json")
        assert ran.code == 0, ran.object["verdict"]
        assert ran.object["stimulus"] is None and ran.object["alarms"] == []


def test_a_mpe_that_does_not_stop_is_an_alarm(cli: Cli, tmp_path: Path) -> None:
    stimulus = tmp_path / "jam.stim"
    stimulus.write_text("when X > 20: X blocked\n")
    ran = cli("run", CONTOUR, "--stimulus", stimulus, "--machine", ROOT / "examples/machines/mill3.toml", "--json")
    run = ran.object
    assert (ran.code, run["status"], run["error"]) == (1, "completed", None)
    assert {a["name"] for a in run["alarms"]} == {"mpe"}
    assert run["stimulus"]["path"] == str(stimulus)


@pytest.mark.parametrize(
    ("text", "place"),
    [("at 1 s: input 3 on\nwhen X > 20: X bloked\n", ":2:16: ST102: 'bloked'"), ("when Q > 1: X free", ":1:6: ST103:")],
)
def test_errors_have_their_place(cli: Cli, tmp_path: Path, text: str, place: str) -> None:
    stimulus = tmp_path / "bad.stim"
    stimulus.write_text(text)
    ran = cli("run", CONTOUR, "--stimulus", stimulus, "--json")
    assert ran.code == 2 and f"{stimulus}{place}" in ran.err
    assert ran.object["diagnostics"][0]["id"] == place.split()[1].rstrip(":")


def test_a_stimulus_beside_the_job_is_taken(cli: Cli, tmp_path: Path) -> None:
    job = tmp_path / "part.nc"
    job.write_bytes(CONTOUR.read_bytes())
    (tmp_path / "machine.toml").write_bytes((FAULTS / "machine.toml").read_bytes())
    assert cli("run", job, "--json").code == 0
    beside = tmp_path / "part.stim"
    beside.write_text("at 1 s: X blocked\n")
    ran = cli("run", job)
    assert ran.code == 3 and str(beside) in ran.out and "mpe X" in ran.out
    given = cli("run", job, "--stimulus", FAULTS / "limit_smd.stim", "--json").object
    assert given["error"]["name"] == "lslh", "the option counts instead"
    beside.write_text("at 1: X blocked\n")
    assert "part.stim:1:5: ST102" in cli("run", job).err


def test_no_file_and_no_text(cli: Cli, tmp_path: Path) -> None:
    missing = cli("run", CONTOUR, "--stimulus", tmp_path / "none.stim")
    assert missing.code == 2 and "ST100" in missing.err
    bad = tmp_path / "bad.stim"
    bad.write_bytes(b"\xff\xfe\x00")
    assert "ST101" in cli("run", CONTOUR, "--stimulus", bad).err


def test_a_recording_never_overwrites_the_stimulus(cli: Cli, tmp_path: Path) -> None:
    stimulus = tmp_path / "x.mcap"
    stimulus.write_text("at 1 s: input 3 on\n")
    ran = cli("run", CONTOUR, "--stimulus", stimulus, "--record", stimulus)
    assert ran.code == 2 and stimulus.read_text() == "at 1 s: input 3 on\n"


def test_faults_are_told_in_german(cli: Cli) -> None:
    ran = cli("run", CONTOUR, "--stimulus", FAULTS / "limit_smd.stim", "--lang", "de")
    assert ran.code == 3 and "angehalten durch Störung lslh X bei" in ran.out and "Zeile 10, X -5.0" in ran.out


def example(name: str) -> Callable[..., Any]:
    module = runpy.run_path(str(FAULTS / name))
    function: Callable[..., Any] = module["home" if name == "homing.py" else "main"]
    return function


def test_homing_finds_the_same_place_with_a_bouncing_switch() -> None:
    home = example("homing.py")
    first, zero = home(0.0, 5.0)
    assert first < -50.0 and zero == pytest.approx(-50.0, abs=0.01)
    for bounce_ms in (3.0, 8.0, 20.0):
        for start_mm in (5.0, -12.3):
            assert home(bounce_ms, start_mm)[1] == pytest.approx(zero, abs=0.003)


def test_a_blocked_axis_recovers_by_rptodp() -> None:
    error_mm, jump_mm, end_mm = example("recovery.py")()
    assert error_mm > 1.0 and abs(jump_mm) < 0.002 and end_mm == pytest.approx(50.0, abs=0.002)


def test_the_examples_print(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("homing.py", "recovery.py"):
        runpy.run_path(str(FAULTS / name), run_name="__main__")
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4 and json.dumps(lines)
