"""`cnc-front run`: the JSON object of design 3.2, verdicts, overrides, determinism."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnc_front.execution import Execution
from cnc_front.jobs import CompileOptions, compile_job, load_machine, read_job
from cnc_front.schedule import Schedule
from tests.app.conftest import ROOT, Cli

EXAMPLES = sorted((ROOT / "examples" / "jobs").glob("*.nc"))
OVERRIDES = ("1", "0:1,1:0.3,2:1.2")
SQUARE = "G21 G90 G54 G17\nG0 X0 Y0 Z0\nG1 X40 F3000\nG3 X50 Y10 I0 J10\nG1 Y40\nX0\nY0\nM30\n"

#: Keys of design 3.2 and the types that they may have in a run that was completed.
NUMBER = (int, float)
SCHEMA: dict[str, Any] = {
    "schema": str,
    "job": {"path": str, "language": str, "sha256": str, "lines": int},
    "machine": {"path": (str, type(None)), "name": str, "sha256": str},
    "status": str,
    "error": type(None),
    "machine_time_s": NUMBER,
    "wall_time_s": NUMBER,
    "samples": int,
    "sample_time_us": NUMBER,
    "commands": dict,
    "path_length_mm": NUMBER,
    "merged": {"blocks": int, "max_mm": NUMBER},
    "deviation": {
        name: {
            "max_mm": NUMBER,
            "rms_mm": NUMBER,
            "p99_mm": NUMBER,
            "worst": {"line": int, "t_s": NUMBER, "position": dict},
        }
        for name in ("setpoint", "actual")
    },
    "following_error": dict,
    "feed": {"programmed_reached_pct": (*NUMBER, type(None)), "max_over_pct": (*NUMBER, type(None))},
    "override": {
        "schedule": list,
        "path_change_mm": (*NUMBER, type(None)),
        "velocity_ratio_error_pct": (*NUMBER, type(None)),
        "settling_ok": (bool, type(None)),
        "settling_s": (float, type(None)),
        "settling_allowed_s": (float, type(None)),
    },
    "time_optimal_s": (*NUMBER, type(None)),
    "alarms": list,
    "error_register": list,
    "output": list,
    "files": {"recording": (str, type(None)), "report": (str, type(None))},
    "diagnostics": list,
}


def assert_shape(value: Any, shape: Any, where: str = "") -> None:
    if isinstance(shape, dict):
        assert isinstance(value, dict), where
        for key, inner in shape.items():
            assert key in value, f"{where}.{key} is missing"
            assert_shape(value[key], inner, f"{where}.{key}")
    else:
        assert isinstance(value, shape), f"{where} is {value!r}"


@pytest.mark.parametrize("override", OVERRIDES)
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.name)
def test_examples_stay_on_their_path(cli: Cli, path: Path, override: str) -> None:
    ran = cli("run", path, "--json", "--override", override)
    run = ran.object
    assert ran.code == 0, ran.out
    assert_shape(run, SCHEMA)
    assert (run["schema"], run["status"]) == ("cnc-front/run/1", "completed")
    assert run["deviation"]["setpoint"]["max_mm"] <= run["merged"]["max_mm"] + 1e-6
    assert 0 < run["deviation"]["actual"]["max_mm"] <= 0.05
    assert run["alarms"] == []
    assert run["error_register"] == []
    assert run["samples"] * run["sample_time_us"] * 1e-6 == pytest.approx(run["machine_time_s"])
    assert run["override"]["schedule"][0] == [0.0, 1.0]
    if override != "1":
        assert run["override"]["path_change_mm"] <= 1e-6
        assert run["override"]["settling_ok"] is True
        settling, allowed = (run["override"][key] for key in ("settling_s", "settling_allowed_s"))
        assert settling is None or settling <= allowed


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 3


def test_object_of_a_job_that_does_not_compile(cli: Cli, job: Callable[..., Path]) -> None:
    ran = cli("run", job("G1 X10\nM30\n"), "--json")
    assert ran.code == 2
    run = ran.object
    assert run.keys() >= SCHEMA.keys()
    assert run["status"] == "failed"
    assert run["error"]["id"] == run["diagnostics"][0]["id"]
    assert run["machine_time_s"] is None
    assert set(run["diagnostics"][0]) == {"file", "line", "column", "end_column", "id", "message", "hint"}
    assert run["diagnostics"][0]["id"] in ran.err, "diagnostics stand on stderr too"


def test_tolerance_decides(cli: Cli, job: Callable[..., Path]) -> None:
    path = job(SQUARE)
    kept = cli("run", path, "--json", "--tolerance", "0.05")
    broken = cli("run", path, "--json", "--tolerance", "0.0001")
    assert (kept.code, broken.code) == (0, 1)
    assert [r["id"] for r in broken.object["verdict"]["reasons"]] == ["tolerance"]
    assert kept.object["deviation"] == broken.object["deviation"]


def test_text_for_people_in_both_languages(cli: Cli, job: Callable[..., Path]) -> None:
    path = job(SQUARE)
    english = cli("run", path, "--tolerance", "0.0001")
    german = cli("run", path, "--tolerance", "0.0001", env={"LANG": "de_DE.UTF-8"})
    asked = cli("run", path, "--tolerance", "0.0001", "--lang", "en", env={"LANG": "de_DE.UTF-8"})
    assert "FAIL" in english.out
    assert "contour deviation" in english.out
    assert "Bahnabweichung" in german.out
    assert "contour deviation" in asked.out
    assert "in Zeile 4" in german.out or "in Zeile" in german.out


def test_override_of_a_half_doubles_the_time_of_a_long_line(cli: Cli, job: Callable[..., Path]) -> None:
    path = job("G90 G21\nG1 X500 F600\nM30\n")
    full = cli("run", path, "--json").object["machine_time_s"]
    half = cli("run", path, "--json", "--override", "0.5").object["machine_time_s"]
    # 500 mm at 10 mm/s: 50 s and 100 s; ramps of 20 ms, settling below 0.1 s
    assert full == pytest.approx(50.0, abs=0.15)
    assert half == pytest.approx(100.0, abs=0.15)


def test_later_factors_ramp_with_trovrst_and_begin_at_their_sample() -> None:
    factor = columns(SQUARE, ((0.0, 0.8), (0.5, 0.3)))["factor"]
    sample_s = 1.28e-3
    change = round(0.5 / sample_s)
    assert np.all(factor[:change] == 0.8), "the factor at time 0 does not ramp"
    assert factor[change] == pytest.approx(0.8 - sample_s / 0.5)
    ramp = int(np.argmax(factor <= 0.3 + 1e-12)) - change
    assert ramp * sample_s == pytest.approx(0.5 * 0.5, abs=2 * sample_s)


def columns(text: str, schedule: Schedule = ((0.0, 1.0),), chunk: int = 1 << 16) -> dict[str, Any]:
    """All columns of a run of a text."""
    machine = load_machine(None)
    source = read_job(str(ROOT / "examples" / "jobs" / "cam.nc"))
    source = type(source)("part.nc", text.encode(), "din66025")
    execution = Execution(compile_job(source, machine, CompileOptions()), schedule)
    names = ("dp", "load", "rp", "line", "entry", "v_plan", "factor", "flags")
    parts: dict[str, list[Any]] = {name: [] for name in names}
    while (part := execution.advance(chunk)) is not None:
        for name in names:
            parts[name].append(getattr(part, name))
    return {name: np.concatenate(values) for name, values in parts.items()}


def test_two_runs_are_bit_equal_whatever_the_chunks() -> None:
    text = EXAMPLES[0].read_text()
    schedule = ((0.0, 1.0), (1.0, 0.3), (2.0, 1.2))
    once, again = columns(text, schedule), columns(text, schedule, chunk=777)
    for name, values in once.items():
        assert values.tobytes() == again[name].tobytes(), name


def test_a_difference_is_noticed() -> None:
    one, other = columns(SQUARE), columns(SQUARE.replace("X40", "X40.0001"))
    assert one["dp"].tobytes() != other["dp"].tobytes()


def test_same_object_twice(cli: Cli) -> None:
    first, second = (cli("run", EXAMPLES[0], "--json").object for _ in range(2))
    for run in (first, second):
        del run["wall_time_s"]
    assert first == second


def test_programmed_stops_are_acknowledged_and_logged(cli: Cli, job: Callable[..., Path]) -> None:
    path = job("G90 G21\nG1 X5 F1000\nM00\nT2 M06\nM01\nX10\nM30\n")
    ran = cli("run", path, "--json")
    assert ran.code == 0
    assert "M00" in ran.err
    assert "M06" in ran.err
    assert "M01" not in ran.err, "M01 is off"
    assert "M01" in cli("run", path, "--json", "--optional-stop").err
    assert "M00" not in cli("run", path, "--json", "-q").err


def test_block_delete_is_off_until_asked_for(cli: Cli, job: Callable[..., Path]) -> None:
    path = job("G90 G21\nG1 X5 F1000\n/X100\nX10\nM30\n")
    driven = cli("run", path, "--json").object["path_length_mm"]
    skipped = cli("run", path, "--json", "--skip", "1").object["path_length_mm"]
    assert (driven, skipped) == (pytest.approx(190.0), pytest.approx(10.0))


def test_time_limit_in_machine_seconds(cli: Cli, job: Callable[..., Path]) -> None:
    ran = cli("run", job("G90 G21\nG1 X500 F600\nM30\n"), "--json", "--max-time", "2")
    assert ran.code == 3
    run = ran.object
    assert (run["status"], run["error"]["id"]) == ("stopped", "CF303")
    assert run["machine_time_s"] == pytest.approx(2.0, abs=2e-3)
    assert run["deviation"]["setpoint"]["max_mm"] <= 1e-6


def test_wait_for_an_input_goes_on_to_the_time_limit(cli: Cli, job: Callable[..., Path]) -> None:
    ran = cli("run", job("G90 G21\nM66 P3 L3\nG1 X5 F1000\nM30\n"), "--json", "--max-time", "3")
    assert (ran.code, ran.object["error"]["id"]) == (3, "CF303")


def test_following_error_beyond_mpe_is_an_alarm(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    # no velocity feed-forward: the axis lags by speed over gain, far beyond a limit of 5 um
    text = (ROOT / "examples" / "machines" / "mill3.toml").read_text()
    weak = tmp_path / "weak.toml"
    lines = ["mpe = 0.005" if line.strip().startswith("mpe") else line for line in text.splitlines()]
    assert "mpe = 0.005" in lines
    weak.write_text("\n".join(lines) + "\n")
    ran = cli("run", job(SQUARE), "--json", "--machine", weak)
    run = ran.object
    assert ran.code in (1, 3)
    assert {alarm["name"] for alarm in run["alarms"]} >= {"mpe"}
    first = run["alarms"][0]
    assert first.keys() == {"t_s", "axis", "bit", "name", "line"}
    assert (first["bit"], first["axis"] in "XY", 2 <= first["line"] <= 7) == (7, True, True)
    assert any(reason["id"] in ("alarm", "fault") for reason in run["verdict"]["reasons"])


def test_machine_toml_beside_the_job_is_taken(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    path = job(SQUARE)
    assert cli("run", path, "--json").object["machine"]["path"] is None
    (tmp_path / "machine.toml").write_bytes((ROOT / "examples" / "machines" / "mill4a.toml").read_bytes())
    run = cli("run", path, "--json").object
    assert run["machine"]["path"] == str(tmp_path / "machine.toml")
    assert run["machine"]["name"] == "mill4a"
    given = cli("run", path, "--json", "--machine", ROOT / "examples" / "machines" / "mill3.toml").object
    assert given["machine"]["name"] == "mill3"


def test_recording_and_report_are_written_and_may_be_written_again(cli: Cli, job: Callable[..., Path]) -> None:
    path = job(SQUARE)
    record, report = path.with_suffix(".mcap"), path.parent / "out"
    for _ in range(2):
        ran = cli("run", path, "--json", "--record", record, "--report", report)
        assert ran.code == 0
        assert ran.object["files"] == {"recording": str(record), "report": str(report)}
    assert (report / "report.html").stat().st_size > 1000
    again = cli("report", record, path.parent / "again")
    assert again.code == 0
    one, other = (json.loads((folder / "report.json").read_text()) for folder in (report, path.parent / "again"))
    # the object named run says when and how it ran; all figures are measured again from the columns
    assert one.keys() == other.keys()
    assert {k: v for k, v in one.items() if k != "run"} == {k: v for k, v in other.items() if k != "run"}
