"""What `run` tells of rw_SymPas jobs beside their contour: axes, findings, circles, samples, sweep, drawing."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.cli import run_command_line
from cnc_front.execution import End
from cnc_front.jobs import CompileOptions, compile_autocode, load_machine, read_job
from cnc_front.sap_measure import measured_run
from cnc_front.sap_run import SapOptions, SapRun, Task

#: A direct move, a rectangle of 30 x 20 mm at (10, 10), a direct move.
RECTANGLE = """program P;
begin
  MODEREG := $101;
  cl(X, Y, Z);
  X.mdvel := 20.0;  Y.mdvel := 20.0;
  TRAC := 800.0;  TRVL := 30.0;  TRTVL := 0.0;
  jaw(X := 10.0, Y := 10.0, Z := 5.0);
  jaw(Z := -2.0);
  smla(X := 40.0, Y := 10.0);
  smla(X := 40.0, Y := 30.0);
  smla(X := 10.0, Y := 30.0);
  smla(X := 10.0, Y := 10.0);
  ssmsw(X, Y);
  jaw(X := -7.0, Y := 0.0);
end.
"""
DIRECT = "begin\n  cl(X);\n  jaw(X := 5.0);\nend.\n"
#: The rectangle on a page of 100 mm, whose Y counts from below.
SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">
<rect x="10" y="70" width="30" height="20"/></svg>"""
Run = Callable[..., tuple[int, dict[str, Any]]]


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    def inner(text: str, *options: str, **more: str) -> tuple[int, dict[str, Any]]:
        path = tmp_path / "job.src"
        path.write_text(text)
        for name, content in more.items():
            (tmp_path / f"{name}.inc").write_text(content)
        code = run_command_line(["run", str(path), "--json", "--lang", "en", *options])
        return code, json.loads(capsys.readouterr().out)

    return inner


def machine_with(tmp_path: Path, old: str, new: str) -> str:
    """The built-in machine, changed."""
    text = native_kernel.Machine.builtin_text()
    assert old in text
    path = tmp_path / "machine.toml"
    path.write_text(text.replace(old, new))
    return str(path)


def test_axes_are_told_for_the_whole_run(run: Run) -> None:
    code, result = run(RECTANGLE)
    axes = result["axes"]
    assert code == 0
    assert axes["X"]["range"] == pytest.approx([-7.0, 40.0], abs=1e-4)
    assert axes["Z"]["range"] == pytest.approx([-2.0, 5.0], abs=1e-4), "direct moves count"
    assert axes["X"]["limit_margin"] == pytest.approx(560.0, abs=1e-4)
    assert axes["X"]["velocity_max"] == pytest.approx(50.0, rel=1e-6), "jvl of the jogs is above TRVL"
    assert 0 < axes["Y"]["acceleration_max"] < 1100
    assert result["following_error"]["Z"]["max"] > 0 and 0 < result["motor_command"]["Z"]["peak_pct"] < 100
    assert (result["findings"], result["circularity"]) == ([], [])
    code, result = run(DIRECT)
    assert (code, result["deviation"]) == (0, None)
    assert result["axes"]["X"]["range"] == pytest.approx([0.0, 5.0], abs=1e-4)


def test_findings_and_circles_name_file_and_line(run: Run, tmp_path: Path) -> None:
    slow = machine_with(tmp_path, "kfcv = 0.0131068, ", "")
    lines = [line for line in RECTANGLE.splitlines(keepends=True) if "smla" not in line]
    job = "{$I round.inc}\n" + "".join(lines[1:]).replace("ssmsw(X, Y);", "Round;")
    rounds = "procedure Round;\nbegin\n  smcr(X := 12.0, Y := 0.0, PHI := 720.0);\n  ssmsw(X, Y);\nend;\n"
    code, result = run(job, "--machine", slow, "--tolerance", "0.002", round=rounds)
    include = str(tmp_path / "round.inc")
    assert code == 1 and result["verdict"]["word"] == "FAIL"
    worst = result["deviation"]["actual"]["worst"]
    assert (worst["task"], worst["file"], worst["line"]) == (0, include, 3)
    reason = next(r for r in result["verdict"]["reasons"] if r["id"] == "sap_tolerance")
    assert (reason["file"], reason["line"]) == (include, 3)
    [circle] = result["circularity"]
    assert (circle["file"], circle["line"], circle["last_line"], circle["plane"]) == (include, 3, 3, ["X", "Y"])
    assert circle["radius_mm"] == pytest.approx(12.0)
    assert result["findings"], "what is missing from the feed-forward has a name"
    assert {"task", "file", "line"} <= result["findings"][0].keys()


def test_an_error_in_an_include_names_it(run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deep = "procedure Deep;\nbegin\n  CI0 := 1 mod (CI1 - CI1);\nend;\n"
    code, result = run("{$I a.inc}\nbegin\n  CI1 := 7;\n  Deep;\nend.\n", a="{$I b.inc}\n", b=deep)
    error, include = result["error"], str(tmp_path / "b.inc")
    assert (code, error["errnum"], error["file"], error["line"]) == (3, 0x8000, include, 3)
    assert (result["tasks"][0]["errline"], error["message"].endswith(f"line 3 ({include})")) == (3, True)
    assert run_command_line(["run", str(tmp_path / "job.src"), "--lang", "de"]) == 3
    assert f"Zeile 3 ({include})" in capsys.readouterr().out


def test_an_autocode_file_brings_no_texts_along(run: Run, tmp_path: Path) -> None:
    job = RECTANGLE.replace("program P;", "{$I secret.inc}").replace("X := 40.0, Y := 10.0", "X := Far, Y := 10.0")
    code, _ = run(job, "--report", str(tmp_path / "r"), secret="const Far = 40.0;\n")
    assert code == 0
    target = str(tmp_path / "job.cnc")
    assert run_command_line(["translate", str(tmp_path / "job.src"), "--output", target]) == 0
    assert run_command_line(["run", target, "--report", str(tmp_path / "r"), "--record", str(tmp_path / "r.mcap")]) == 0
    assert b"Far = 40.0" not in (tmp_path / "r.mcap").read_bytes()
    blocks = (tmp_path / "r/blocks.csv").read_text().splitlines()
    assert [row.partition(",")[0] for row in blocks[1:]] == ["9", "10", "11", "12"]
    assert all(row.endswith(",False,") for row in blocks[1:]), "lines without text"


def test_samples_of_a_job(run: Run, tmp_path: Path) -> None:
    import pyarrow.parquet as parquet

    for text in (RECTANGLE, DIRECT):
        recording, report = tmp_path / "r.mcap", tmp_path / "r"
        code, result = run(text, "--record", str(recording), "--report", str(report), "--samples")
        assert code == 0 and run_command_line(["report", str(recording), str(tmp_path / "again"), "--samples"]) == 0
        table = parquet.read_table(report / "samples.parquet")
        assert table.equals(parquet.read_table(tmp_path / "again/samples.parquet"))
        assert table.num_rows == result["samples"]
        columns = {name: table[name].to_numpy() for name in table.column_names}
        assert columns["t_s"][-1] == pytest.approx(result["machine_time_s"])
        span = np.ptp(columns["dp_X"])
        assert span == pytest.approx(np.ptp(result["axes"]["X"]["range"]))
        if result["deviation"]:
            assert columns["deviation_mm"].max() == pytest.approx(result["deviation"]["actual"]["max_mm"], rel=1e-6)


def test_override_sweep_of_a_job(run: Run) -> None:
    code, result = run(RECTANGLE, "--override-sweep", "0.5:1:0.5")
    half, full = result["override_sweep"]
    assert code == 0 and (half["factor"], full["factor"], full["verdict"]) == (0.5, 1.0, "PASS")
    assert full["machine_time_s"] == result["machine_time_s"]
    assert full["actual_max_mm"] == result["deviation"]["actual"]["max_mm"]
    assert half["machine_time_s"] > 1.5 * full["machine_time_s"] and half["path_change_mm"] < 1e-9
    assert 50 < full["acceleration_of_maxacc_pct"] < 110


@pytest.mark.parametrize("whole", [True, False])
def test_a_job_against_its_drawing(run: Run, tmp_path: Path, whole: bool) -> None:
    (tmp_path / "part.svg").write_text(SVG)
    recording, report = tmp_path / "r.mcap", tmp_path / "r"
    text = RECTANGLE if whole else RECTANGLE.replace("smla(X := 10.0, Y := 30.0);", "smla(X := 10.0, Y := 30.5);")
    options = ("--reference", str(tmp_path / "part.svg"), "--record", str(recording), "--report", str(report))
    code, result = run(text, *options)
    drawing = result["reference"]
    assert code == (0 if whole else 1)
    assert drawing["actual"]["extra_mm"] == pytest.approx(0.0, abs=0.1), "direct moves are no contour"
    assert drawing["missing_mm"] == pytest.approx(0.0, abs=0.1)
    assert drawing["setpoint"]["max_mm"] == pytest.approx(0.0 if whole else 0.5, abs=1e-4)
    assert (report / "report.html").is_file()
    assert run_command_line(["report", str(recording), str(tmp_path / "again")]) == 0
    again = json.loads((tmp_path / "again/report.json").read_text())["result"]
    assert again["reference"]["actual"] == drawing["actual"] and again["axes"] == result["axes"]
    assert again["deviation"] == result["deviation"]


def test_a_drawing_needs_axes_x_and_y(run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "part.svg").write_text(SVG)
    (tmp_path / "job.src").write_text(DIRECT)
    other = machine_with(tmp_path, 'name = "X"', 'name = "A1"')
    options = ["--machine", other, "--reference", str(tmp_path / "part.svg")]
    (tmp_path / "job.src").write_text(DIRECT.replace("X", "A1"))
    assert run_command_line(["run", str(tmp_path / "job.src"), *options]) == 2
    assert "axes X and Y" in capsys.readouterr().err


def test_resources_are_scanned(run: Run, tmp_path: Path) -> None:
    recording = tmp_path / "r.mcap"
    code, result = run(RECTANGLE, "--record", str(recording), "--scan", "dp.X")
    with recording.open("rb") as file:
        rows = [json.loads(message.data) for _, _, message in make_reader(file).iter_messages(topics=["/scan"])]
    assert (code, len(rows)) == (0, result["samples"])
    assert max(row["dp_X"] for row in rows) == pytest.approx(result["axes"]["X"]["range"][1])


def test_an_interrupted_job_is_measured_up_to_there(tmp_path: Path) -> None:
    text = RECTANGLE.replace("  smla(X := 40.0", "  while TRUE do begin\n  smla(X := 40.0", 1)
    (tmp_path / "job.src").write_text(text.replace("ssmsw(X, Y);", "ssmsw(X, Y); end;"))
    machine = load_machine(None)
    source = read_job(str(tmp_path / "job.src"))
    program, _ = compile_autocode(source, machine, CompileOptions())
    assert program is not None
    passed = [0.0]
    options = SapOptions(interrupted=lambda: passed[-1] > 20.0, progress=passed.append)
    result = measured_run(lambda: SapRun(machine, [Task(0, source, program, ())], options))
    assert result.run.end is End.INTERRUPTED and 20.0 < result.run.machine_time_s < 20.5
    assert result.measured_s == pytest.approx(result.run.machine_time_s, abs=1.0)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["--from", "2"], "no blocks to begin at"),
        (["--to", "3"], "no block to end at"),
        (["--time-optimal"], "waits and inputs"),
        (["--setup", "x.toml"], "names no tools"),
        (["--samples"], "--samples needs --report"),
    ],
)
def test_what_makes_no_sense_is_refused_with_the_reason(
    options: list[str], why: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "job.src").write_text(DIRECT)
    assert run_command_line(["run", str(tmp_path / "job.src"), *options]) == 2
    err = capsys.readouterr().err
    assert options[0] in err and why in err and err.count("\n") == 1
