"""`cnc-front run` of rw_SymPas jobs: tasks, output, errors, time limit."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from cnc_front.cli import run_command_line

ROOT = Path(__file__).parents[2]
Write = Callable[[str, str], Path]
MOVE = """program Move;
begin
  cl(X, Y);
  shp(X := 0.0, Y := 0.0);
  TRAC := 500.0;  TRVL := 50.0;  TRTVL := 0.0;
  mlaw(X := 10.0, Y := 5.0);
  writeln('X=', X.dp);
  CI5 := 1;
end.
"""
WATCH = """{$TASK 1}
begin
  while CI5 = 0 do wt(100);
  writeln('seen');
end.
"""


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def inner(name: str, text: str) -> Path:
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return inner


def run(*arguments: str | Path) -> int:
    return run_command_line(["run", *map(str, arguments), "--lang", "en"])


@pytest.mark.shows("directive.task.default")
def test_a_job_runs_to_its_end(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    path = write("move.src", MOVE)
    assert run(path) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"{path}: PASS\n") and out.endswith("\nX=10.0\n")
    assert run(path, "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["status"], result["verdict"]["word"], result["output"]) == ("completed", "PASS", ["X=10.0"])
    assert result["position"]["X"] == pytest.approx(10.0, abs=0.01)
    assert [task["task"] for task in result["tasks"]] == [0]


@pytest.mark.shows("directive.task", "directive.task.becomes-default")
def test_several_tasks(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    move, watch = write("move.src", MOVE), write("watch.src", WATCH)
    assert run(move, "--task", f"1={watch}", "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert [(t["task"], t["output"]) for t in result["tasks"]] == [(0, ["X=10.0"]), (1, ["seen"])]
    # {$TASK 1} is the task of the job itself, so that number is taken
    assert run(watch, "--task", f"0={move}") == 0
    assert "task 1:\nseen" in capsys.readouterr().out
    assert run(watch, "--task", f"1={move}") == 2
    assert "two jobs for one task" in capsys.readouterr().err


def test_a_runtime_error_stops_its_task_only(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    bad = write("bad.src", "var i : integer;\nbegin\n  i := 1 mod i;\nend.\n")
    assert run(bad, "--task", f"2={write('move.src', MOVE)}", "--json") == 3
    result = json.loads(capsys.readouterr().out)
    assert (result["status"], result["error"]["errnum"], result["error"]["line"]) == ("failed", 0x8000, 3)
    assert result["tasks"][1]["output"] == ["X=10.0"]
    assert run(bad) == 3
    assert "task 0: runtime error 8000 hex at line 3" in capsys.readouterr().out


def test_an_endless_loop_ends_by_the_time_limit(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    path = write("endless.src", "begin\n  while TRUE do\n    CI0 := CI0 + 1;\nend.\n")
    assert run(path, "--max-time", "2") == 3
    out = capsys.readouterr().out
    assert "time limit of 2 s reached (--max-time)" in out
    assert "task 0 is at line 2" in out or "task 0 is at line 3" in out


def test_the_application_reads_on_where_writeln_stops(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    text = "var i : integer;\nbegin\n  MODEREG := MODEREG or $04000000;\n  for i := 1 to 3 do writeln(i);\nend.\n"
    assert run(write("lines.src", text), "--json") == 0
    assert json.loads(capsys.readouterr().out)["output"] == ["1", "2", "3"]


def test_an_autocode_file_runs_like_its_source(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    source = write("watch.src", WATCH.replace("CI5 = 0", "CI5 > 0"))
    target = source.with_suffix(".cnc")
    assert run_command_line(["translate", str(source), "--output", str(target)]) == 0
    assert run(target, "--json") == 0
    assert [(t["task"], t["output"]) for t in json.loads(capsys.readouterr().out)["tasks"]] == [(1, ["seen"])]


def test_an_autocode_file_of_a_larger_machine_is_refused(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    source = write("watch.src", WATCH)
    target, four = source.with_suffix(".cnc"), ROOT / "examples" / "machines" / "mill4a.toml"
    assert run_command_line(["translate", str(source), "--output", str(target), "--machine", str(four)]) == 0
    assert run(target) == 2
    assert "CF202: compiled for more axes than the machine has" in capsys.readouterr().err


def test_tasks_are_for_jobs(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    path, part = write("move.src", MOVE), write("part.nc", "G0 X1\nM30\n")
    for option in (["--task", "7=x.src"], ["--task", "x"], ["--task", f"1={part}"]):
        assert run(path, *option) == 2
    assert run(part, "--task", f"1={path}") == 2
    assert "--task is for rw_SymPas jobs" in capsys.readouterr().err


def test_errors_of_every_job_are_named(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    bad = write("bad.src", "begin\n  i := 1;\nend.\n")
    assert run(write("move.src", MOVE), "--task", f"1={bad}", "--json") == 2
    out, err = capsys.readouterr()
    assert json.loads(out)["error"]["id"] == "3" and f"{bad}:2:3: 3: undeclared identifier 'i'" in err
