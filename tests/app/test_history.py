"""The history of runs and alarms: what is kept, who may write at once, and that it never stands in the way of a run."""

from __future__ import annotations

import argparse
import json
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from cnc_front.history import MOST_LINES, Filter, History, HistoryError, place
from cnc_front.history_arguments import since
from tests.app.conftest import ROOT, Cli

PROGRAM = "N10 G90 G21 G17\nN20 G1 X10 F3000\nN30 M30\n"
ALARM = {"t_s": 1.5, "axis": "X", "bit": 7, "name": "mpe", "line": 4, "block": "N20"}


def run_object(word: str = "PASS", **more: object) -> dict[str, object]:
    return {"status": "completed", "alarms": [], "verdict": {"word": word, "reasons": []}} | more


def test_where_it_stands() -> None:
    assert place("x.sqlite", {"CNC_FRONT_HISTORY": "y"}) == Path("x.sqlite")
    assert place("off", {"CNC_FRONT_HISTORY": "y"}) is None
    assert place(None, {"CNC_FRONT_HISTORY": "y"}) == Path("y")
    assert place(None, {"CNC_FRONT_HISTORY": ""}) is None and place(None, {"CNC_FRONT_HISTORY": "off"}) is None
    assert place(None, {"XDG_STATE_HOME": "/s", "HOME": "/h"}) == Path("/s/cnc-front/history.sqlite")
    assert place(None, {"XDG_STATE_HOME": "s", "HOME": "/h"}) == Path("/h/.local/state/cnc-front/history.sqlite")


def test_runs_are_kept_and_found(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    file = tmp_path / "state" / "history.sqlite"
    env = {"CNC_FRONT_HISTORY": str(file)}
    good, bad = job(PROGRAM, "good.nc"), job("N10 G1 X5\nN20 M30\n", "bad.nc")
    assert cli("history", env=env).out == f"no runs in {file}\n" and not file.exists(), "reading makes no file"
    assert cli("history", "--alarms", env=env).out == f"no alarms in {file}\n"
    plain = cli("run", good, "--json", env={"CNC_FRONT_HISTORY": "off"}).object
    kept = cli("run", good, "--json", env=env).object
    assert plain | {"wall_time_s": 0} == kept | {"wall_time_s": 0}, "the result is not changed by keeping it"
    assert cli("run", bad, env=env).code == 2
    assert cli(
        "run", ROOT / "examples/faults/contour.nc", "--stimulus", ROOT / "examples/faults/limit_sma.stim", env=env
    )
    rows = [json.loads(line) for line in cli("history", "--json", env=env).out.splitlines()]
    assert [(r["name"], r["verdict"], r["code"]) for r in rows[1:]] == [("bad.nc", "ERROR", 2), ("good.nc", "PASS", 0)]
    assert rows[2]["job"] == str(good) and rows[2]["deviation_max_mm"] == kept["deviation"]["actual"]["max_mm"]
    assert rows[0]["alarms"] > 0 and rows[0]["verdict"] == "FAIL"
    assert [
        json.loads(x)["name"] for x in cli("history", "--json", "--verdict", "ERROR", env=env).out.splitlines()
    ] == ["bad.nc"]
    assert len(cli("history", "--json", "--job", "good", env=env).out.splitlines()) == 1
    assert cli("history", "--since", "2999-01-01", "--json", env=env).out == ""
    assert "bad.nc" in cli("history", "--since", "1d", env=env).out
    whole = json.loads(cli("history", 1, "--json", env=env).out)
    assert whole["run"]["samples"] == kept["samples"]
    assert "good.nc: PASS" in cli("history", 1, env=env).out
    assert "contour.nc" in cli("history", "--alarms", env=env).out
    assert cli("history", 99, env=env).code == 2


@pytest.mark.parametrize(
    "content", [b"this is no data base, but long enough to be read" * 99, b"SQLite format 3\0" * 99]
)
def test_a_damaged_file_is_told_and_the_run_goes_on(
    content: bytes, cli: Cli, job: Callable[..., Path], tmp_path: Path
) -> None:
    file = tmp_path / "history.sqlite"
    file.write_bytes(content)
    ran = cli("run", job(PROGRAM), "--history", file)
    assert ran.code == 0 and "PASS" in ran.out and "CF50" in ran.err and str(file) in ran.err
    listed = cli("history", "--history", file, "--lang", "de")
    assert listed.code == 3 and "CF50" in listed.err and not listed.out
    assert file.read_bytes() == content, "what is not ours is left alone"


def test_other_tables_and_later_versions_are_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "other.sqlite"
    base = sqlite3.connect(file)
    base.execute("CREATE TABLE theirs (x)")
    base.commit()
    with pytest.raises(HistoryError, match="CF502"):
        History(file).add_run(run_object(), "a.nc", "run", 0)
    base.execute("PRAGMA user_version = 99")
    base.commit()
    with pytest.raises(HistoryError, match="CF503"):
        History(file).runs(Filter())
    assert [row[0] for row in base.execute("SELECT name FROM sqlite_master")] == ["theirs"]
    base.close()


def test_a_place_that_cannot_be_written(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    ran = cli("run", job(PROGRAM), "--history", tmp_path / "file" / "history.sqlite")
    assert ran.code == 0 and "CF501" in ran.err


def test_several_processes_write_at_once(tmp_path: Path) -> None:
    file = tmp_path / "history.sqlite"
    code = (
        "import sys; from pathlib import Path; from cnc_front.history import History\n"
        "for n in range(25): History(Path(sys.argv[1])).add_run({'alarms': [], 'n': n}, 'a.nc', sys.argv[2], 0)"
    )
    writers = [subprocess.Popen([sys.executable, "-c", code, str(file), str(n)], cwd=ROOT) for n in range(4)]
    assert [writer.wait(60) for writer in writers] == [0] * 4
    rows = History(file).runs(Filter(limit=1000))
    assert len(rows) == 100 and {row["source"] for row in rows} == {"0", "1", "2", "3"}
    assert History(file).recent_jobs(9)[0]["id"] == 100 and len(History(file).recent_jobs(9)) == 1


def test_only_so_many_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cnc_front.history.MOST_RUNS", 3)
    store = History(tmp_path / "h")
    flood = [{"id": "GW904"}] * 500
    for n in range(5):
        store.add_run(run_object(diagnostics=flood, output=[str(n)] * 500), "a.nc", "run", 0)
    assert [row["id"] for row in store.runs(Filter())] == [5, 4, 3]
    kept = store.run(5)
    assert kept and kept["warnings"] == 500 and len(kept["run"]["diagnostics"]) == MOST_LINES


def test_alarms_are_acknowledged(tmp_path: Path) -> None:
    store = History(tmp_path / "h")
    number = store.add_alarm(ALARM, "/parts/a.nc", "tui")
    store.acknowledge(number)
    (row,) = store.alarms(Filter(job="parts"))
    assert row["code"] == "E107" and row["block"] == "N20" and row["acknowledged"] >= row["at"]
    assert store.alarms(Filter(job="other")) == []


@pytest.mark.parametrize("text", ["7d", "5h", "30m", "2w", "2026-03-04", "2026-03-04T12:30", "2026-03-04T12:30+01:00"])
def test_times(text: str) -> None:
    assert len(since(text)) == 20


@pytest.mark.parametrize("text", ["", "7", "d", "9999999d", "yesterday", "2026-13-01"])
def test_times_that_are_none(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="neither a date"):
        since(text)
