"""`cnc-front run` of rw_SymPas jobs measures what their tasks spool: path, override, recording, report, verdict."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnc_front.cli import run_command_line
from cnc_front.sap_places import Places, Text

HEAD = """program P;
begin
  MODEREG := $101;  TROVRST := 0.2;
  cl(X, Y, Z);
  X.mdvel := 20.0;  Y.mdvel := 20.0;  Z.mdvel := 20.0;
  X.maxacc := 800.0;  Y.maxacc := 800.0;  Z.maxacc := 800.0;
  TRAC := 800.0;  TRVL := 30.0;  TRTVL := 0.0;
"""
#: Direct move, plane contour, direct move, circle in space and helix.
SLOT = (
    HEAD
    + """  jaw(X := 5.0, Y := 3.0);
  TRTVL := 30.0;
  smla(X := 10.0, Y := 10.0);
  smlr(X := 30.0, Y := 0.0);
  smca(X := 40.0, Y := 20.0, PHI := 180.0);
  smla(X := 10.0, Y := 30.0, TRTVL := 0.0);
  smcr(X := 0.0, Y := -10.0, PHI := 180.0);
  ssmsw(X, Y);
  jaw(X := 0.0, Y := 0.0, Z := 5.0);
  smcr3d(X := 0.0, Y := 10.0, Z := 0.0, PN1 := 1.0, PN2 := 0.3, PN3 := 0.2, PHI := 300.0);
  smla(X := 1.0, Y := 2.0, Z := 3.0);
  smhr(X := 4.0, Y := 0.0, Z := 6.0, PHI := 360.0);
  ssmsw(X, Y, Z);
  writeln('done');
end.
"""
)
Run = Callable[..., tuple[int, dict[str, Any]]]


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs texts, the first as the job and the others in the tasks 1, 2 ...; exit code and the JSON object."""

    def inner(*texts: str, options: tuple[str, ...] = ()) -> tuple[int, dict[str, Any]]:
        arguments = []
        for number, text in enumerate(texts):
            path = tmp_path / f"job{number}.src"
            path.write_text(text)
            arguments += ["--task", f"{number}={path}"] if number else [str(path)]
        code = run_command_line(["run", *arguments, "--json", "--lang", "en", *options])
        return code, json.loads(capsys.readouterr().out)

    return inner


def line_of(text: str, part: str) -> int:
    return next(n for n, line in enumerate(text.splitlines(), 1) if part in line)


def test_what_is_spooled_is_measured_and_direct_moves_are_not(run: Run) -> None:
    code, result = run(SLOT)
    assert (code, result["verdict"]["word"]) == (0, "PASS")
    assert result["commands"] == {"smla": 3, "smlr": 1, "smca": 1, "smcr": 1, "smcr3d": 1, "smhr": 1}
    # by hand; the radius of the circle in space is the part of (0, 10, 0) at right angles to its normal
    flat = math.dist((5, 3), (10, 10)) + 30 + 10 * math.pi + 30 + 10 * math.pi
    normal = np.array([1.0, 0.3, 0.2]) / np.linalg.norm([1.0, 0.3, 0.2])
    arm = np.array([0.0, -10.0, 0.0])
    arm -= normal * (normal @ arm)
    phi = math.radians(300)
    center = np.array([0.0, 0.0, 5.0]) - arm
    end = center + arm * math.cos(phi) + np.cross(normal, arm) * math.sin(phi)
    space = np.linalg.norm(arm) * phi + math.dist(end, (1, 2, 3)) + math.hypot(2 * math.pi * 4, 6)
    assert result["path_length_mm"] == pytest.approx(flat + float(space), abs=1e-9)
    assert result["deviation"]["setpoint"]["max_mm"] < 1e-9
    assert 0.001 < result["deviation"]["actual"]["max_mm"] < 0.05
    assert [(c["axes"], c["stretches"]) for c in result["contours"]] == [(["X", "Y", "Z"], 2)]
    assert 0 < result["measured_s"] < result["machine_time_s"]


def test_a_tolerance_that_is_exceeded_ends_with_1_and_names_the_place(run: Run) -> None:
    code, result = run(SLOT, options=("--tolerance", "0.001"))
    worst = result["deviation"]["actual"]["worst"]
    assert code == 1
    reason = result["verdict"]["reasons"][0]
    assert (reason["id"], reason["task"], reason["line"]) == ("sap_tolerance", 0, worst["line"])
    assert result["verdict"]["tolerance_from"] == "option"


def test_the_override_of_the_command_line_changes_time_and_not_the_path(run: Run) -> None:
    _, full = run(SLOT)
    code, half = run(SLOT, options=("--override", "0:1,1:0.5,4:1.2"))
    assert code == 0
    assert half["machine_time_s"] > full["machine_time_s"]
    assert half["deviation"]["setpoint"]["max_mm"] < 1e-9
    assert half["override"]["path_change_mm"] < 1e-9
    assert half["override"]["settling_ok"] is True
    assert half["override"]["schedule"] == [[0.0, 1.0], [1.0, 0.5], [4.0, 1.2]]
    # an override of one axis alone takes the axes apart: that is what must be found
    alone = SLOT.replace(
        "smla(X := 10.0, Y := 30.0, TRTVL", "TROVR := 0.5;  utrovr(X);  smla(X := 10.0, Y := 30.0, TRTVL"
    )
    code, broken = run(alone.replace("  smlr(X := 30.0", "  ssms(X, Y);  wt(3000);  smlr(X := 30.0"))
    assert code == 1
    assert broken["deviation"]["setpoint"]["max_mm"] > 1.0
    assert {"alarm", "sap_setpoint"} <= {r["id"] for r in broken["verdict"]["reasons"]}


def test_a_recording_and_its_report_say_the_same_as_the_run(run: Run, tmp_path: Path) -> None:
    recording = tmp_path / "slot.mcap"
    watch = "begin\n  TRAC := 500.0;\n  TRVL := 10.0;\n  wt(20000);\nend.\n"
    code, result = run(SLOT, watch, options=("--record", str(recording), "--report", str(tmp_path / "live")))
    assert code == 0
    assert run_command_line(["report", str(recording), str(tmp_path / "again")]) == 0
    reports = [json.loads((tmp_path / name / "report.json").read_text()) for name in ("live", "again")]
    for key in ("path_length_mm", "deviation", "feed", "override", "following_error"):
        assert reports[0]["result"][key] == reports[1]["result"][key] == result[key], key
    blocks = [(tmp_path / name / "blocks.csv").read_text() for name in ("live", "again")]
    assert blocks[0] == blocks[1]
    assert "smcr3d" in (tmp_path / "live" / "report.html").read_text()


GROUPS = (
    HEAD
    + """  smla(X := 20.0, Y := 10.0);
  smca(X := 20.0, Y := 20.0, PHI := 90.0);
  ssmsw(X, Y);
end.
"""
)
BESIDE = """begin
  wt(1000);
  TRVL := 5.0;
  smla(Z := 4.0);
  smla(Z := -2.0);
  ssmsw(Z);
end.
"""


def test_groups_of_axes_that_run_side_by_side_have_a_path_each(run: Run) -> None:
    code, result = run(GROUPS, BESIDE)
    assert (code, result["verdict"]["word"]) == (0, "PASS"), result["verdict"]
    lanes = {tuple(c["axes"]): c for c in result["contours"]}
    assert set(lanes) == {("X", "Y"), ("Z",)}
    assert lanes[("Z",)]["path_length_mm"] == pytest.approx(10.0)
    assert all(c["setpoint_max_mm"] < 1e-9 for c in lanes.values())
    assert result["path_length_mm"] == pytest.approx(math.hypot(20, 10) + 5 * math.pi + 10)
    # the worst place is one of the task that gave the command
    _, strict = run(GROUPS, BESIDE, options=("--tolerance", "0.000001"))
    assert strict["deviation"]["actual"]["worst"]["task"] in (0, 1)


def test_axes_that_are_spooled_apart_are_told(run: Run) -> None:
    mixed = HEAD + "  smla(X := 20.0, Y := 10.0);\n  smla(X := 30.0, Y := 10.0, Z := 5.0);\n  ssmsw(X, Y, Z);\nend.\n"
    code, result = run(mixed)
    assert code == 1
    apart = [r for r in result["verdict"]["reasons"] if r["id"] == "sap_apart"]
    assert apart, result["verdict"]


def test_a_contour_that_is_broken_off_is_measured_up_to_there(run: Run) -> None:
    stop = HEAD + "  smla(X := 200.0, Y := 10.0);\n  ssms(X, Y);\n  wt(15625);\n  STOP(X, Y);\n  wt(8000);\nend.\n"
    for command in ("js", "msw"):
        code, result = run(stop.replace("STOP", command))
        assert (code, result["verdict"]["word"]) == (0, "WARN")
        assert [r["id"] for r in result["verdict"]["reasons"]] == ["sap_cut"]
        assert result["deviation"]["setpoint"]["max_mm"] < 1e-9
        assert result["measured_s"] < 1.3


def test_without_exact_targets_the_half_count_of_a_stop_is_no_finding(run: Run) -> None:
    text = HEAD.replace("$101", "$1") + "".join(
        f"  smlr(X := {0.1 + 0.00123 * n:.5f}, Y := 0.00037);\n" for n in range(40)
    )
    code, result = run(text + "  smcr(X := 0.123456, Y := 3.3, PHI := 77.0);\n  ssmsw(X, Y);\nend.\n")
    assert code == 0, result["verdict"]
    assert 1e-6 < result["deviation"]["setpoint"]["max_mm"] < 1e-3


def test_a_job_that_spools_nothing_has_no_contour(run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = HEAD + "  jaw(X := 5.0);\nend.\n"
    recording, report = tmp_path / "jog.mcap", tmp_path / "report"
    code, result = run(job, options=("--record", str(recording), "--report", str(report)))
    assert code == 0
    assert (result["deviation"], result["contours"]) == (None, [])
    page = (report / "report.html").read_text()
    assert "no motion command was spooled" in page
    assert run_command_line(["report", str(recording), str(tmp_path / "again")]) == 0
    assert "no motion command was spooled" in (tmp_path / "again/report.html").read_text()


def test_inches_and_arcs_to_a_target(run: Run) -> None:
    text = (
        HEAD + "  PU := 1;  TRVL := 1.0;  TRAC := 20.0;\n  smla(X := 1.0, Y := 0.0);\n  DTCA1 := 1.0;  DTCA2 := 1.0;\n"
    )
    code, result = run(text + "  PHI := 0.0;  smha(X := 2.0, Y := 1.0);\n  ssmsw(X, Y);\nend.\n")
    assert code == 0, result["verdict"]
    assert result["path_length_mm"] == pytest.approx(25.4 * (1 + math.pi / 2), rel=1e-9)


def test_the_same_job_gives_the_same_bytes(run: Run, tmp_path: Path) -> None:
    files = [tmp_path / "a.mcap", tmp_path / "b.mcap"]
    for file in files:
        assert run(GROUPS, BESIDE, options=("--record", str(file)))[0] == 0
    assert files[0].read_bytes() == files[1].read_bytes()


def test_lines_of_several_texts_have_one_number() -> None:
    places = Places((Text(0, 0, None), Text(10, 2, None), Text(25, 2, "inc/axes.inc"), Text(30, 1, None)))
    found = [tuple(places.at(line).values()) for line in (1, 10, 11, 25, 26, 31)]
    include = "inc/axes.inc"
    assert found == [(0, None, 1), (0, None, 10), (2, None, 1), (2, None, 15), (2, include, 1), (1, None, 1)]
    assert places.at(0) == {"task": 0, "file": None, "line": 0}
    assert Places.parse(places.as_json()) == places


def test_translate_lists_what_a_job_spools(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "slot.src"
    path.write_text(SLOT)
    assert run_command_line(["translate", str(path), "--json"]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [row["cmd"] for row in rows] == ["smla", "smlr", "smca", "smla", "smcr", "smcr3d", "smla", "smhr"]
    assert rows[1]["target"] == {"X": 40.0, "Y": 10.0}
    assert (rows[2]["plane"], rows[2]["center"], rows[2]["phi"]) == (["X", "Y"], {"X": 40.0, "Y": 20.0}, 180.0)
    assert (rows[3]["line"], rows[3]["tvl"], rows[3]["task"]) == (line_of(SLOT, "Y := 30.0"), 0.0, 0)
    assert (rows[5]["center"], rows[5]["normal"]) == ({"X": 0.0, "Y": 10.0, "Z": 5.0}, [1.0, 0.3, 0.2])
    path.write_text(HEAD + "  smla(X := 1.0, Y := 1.0);\n  ssmsw(X, Y);\n  CI0 := 1 mod (CI0 - CI0);\nend.\n")
    assert run_command_line(["translate", str(path), "--json"]) == 3
    assert "8000 hex" in capsys.readouterr().err
