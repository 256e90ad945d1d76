"""tune: parameters swept over the emulator; --override-sweep: a table of runs."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from cnc_front.jobs import load_machine
from cnc_front.tune import rank
from cnc_front.variation import Parameter, present, varied
from tests.app.conftest import ROOT, Cli

BRACKET = ROOT / "examples/jobs/bracket.nc"


@pytest.fixture(scope="module")
def tuned(cli: Cli, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, Path]:
    folder = tmp_path_factory.mktemp("tune") / "out"
    ranges = ("--range", "mdvel=0.5:2:0.5", "--range", "kp=0.4:0.8:0.2:abs")
    ran = cli("tune", BRACKET, "--vary", "mdvel,kp", "--for", "time", *ranges, "--out", folder, "--json")
    assert ran.code == 0
    return ran.object, folder


def test_every_combination_and_the_machine_as_it_is(tuned: tuple[dict, Path]) -> None:
    result, _ = tuned
    assert result["schema"] == "cnc-front/tune/1" and len(result["rows"]) == 4 * 3 + 1
    given = sorted((r["values"]["mdvel"], r["values"]["kp"]) for r in result["rows"] if r["values"])
    assert given == [(m, k) for m in (0.5, 1.0, 1.5, 2.0) for k in (0.4, 0.6, 0.8)]
    # larger steps at corners: faster, and further from the path
    by_mdvel = [r for m in (0.5, 1.0, 1.5, 2.0) for r in result["rows"] if r["values"] == {"mdvel": m, "kp": 0.6}]
    times = [r["machine_time_s"] for r in by_mdvel]
    deviations = [r["deviation_max_mm"] for r in by_mdvel]
    assert times == sorted(times, reverse=True) and deviations == sorted(deviations)
    assert len(set(times)) == 4


def test_the_best_within_tolerance_is_first_and_no_run_beats_the_curve(tuned: tuple[dict, Path]) -> None:
    rows = [r for r in tuned[0]["rows"] if r["within"]]
    assert tuned[0]["rows"][: len(rows)] == rows
    assert rows[0]["machine_time_s"] == min(r["machine_time_s"] for r in rows)
    curve = [r for r in rows if r["pareto"]]
    assert len(curve) >= 3
    for row in curve:
        better = [r for r in rows if r["machine_time_s"] <= row["machine_time_s"] and r not in curve]
        assert all(r["deviation_max_mm"] >= row["deviation_max_mm"] for r in better)


def test_what_is_promised_is_what_a_run_gives(tuned: tuple[dict, Path], cli: Cli, tmp_path: Path) -> None:
    best = tuned[0]["rows"][0]
    machine = load_machine(None)
    chosen = {
        Parameter("mdvel", "axis", ()): best["values"]["mdvel"],
        Parameter("kp", "pidf", (), absolute=True): best["values"]["kp"],
    }
    (tmp_path / "best.toml").write_text(varied(machine, chosen, ["X", "Y", "Z"]).text, "utf-8")
    run = cli("run", BRACKET, "--machine", tmp_path / "best.toml", "--json").object
    assert run["machine_time_s"] == pytest.approx(best["machine_time_s"])
    assert run["deviation"]["actual"]["max_mm"] == pytest.approx(best["deviation_max_mm"])


def test_the_page_shows_every_run(tuned: tuple[dict, Path]) -> None:
    result, folder = tuned
    html = (folder / "report.html").read_text("utf-8")
    assert html.count("<circle") == 13 and "<polyline" in html
    assert not re.search(r"https?://|@import|url\(", html)
    assert json.loads((folder / "tune.json").read_text("utf-8")) == result
    best = result["rows"][0]
    assert f"{best['machine_time_s']:.3f}" in html and f"{best['deviation_max_mm'] * 1e3:.2f}" in html


def test_a_limit_that_none_keeps_is_exit_1_and_says_so(cli: Cli) -> None:
    span = ("--vary", "lag_s", "--range", "lag_s=1:2:1", "--tolerance", "0.0001", "--axes", "X")
    ran = cli("tune", BRACKET, *span, "--lang", "de")
    assert ran.code == 1 and "Grenze 0.1 um" in ran.out and "wie bisher" in ran.out


def test_only_the_named_axes_change() -> None:
    machine = load_machine(None)
    changed = varied(machine, {Parameter("kfca", "pidf", ()): 2.0, Parameter("trac_feed", "gcode", ()): 0.5}, ["Y"])
    kfca = Parameter("kfca", "pidf", ())
    assert present(kfca, changed, ["X", "Y", "Z"]) == {"X": 4.77088e-5, "Y": 2 * 4.77088e-5, "Z": 4.77088e-5}
    assert present(Parameter("trac_feed", "gcode", ()), changed, []) == {"": 500.0}
    backlash = varied(machine, {Parameter("backlash", "plant", (), absolute=True): 0.01}, ["Z"])
    assert present(Parameter("backlash", "plant", ()), backlash, ["X", "Z"]) == {"X": 0.0, "Z": 0.01}


def test_rows_that_did_not_run_come_last() -> None:
    row = {"values": {}, "within": True, "status": "completed", "machine_time_s": 2.0, "deviation_max_mm": 0.01}
    refused = row | {"within": False, "status": "refused", "machine_time_s": None, "deviation_max_mm": None}
    slow = row | {"machine_time_s": 3.0, "deviation_max_mm": 0.02}
    ranked = rank([refused, slow, row], "time")
    assert [r["status"] for r in ranked] == ["completed", "completed", "refused"]
    assert [r["pareto"] for r in ranked] == [True, False, False]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--vary", "nonsense"), "nonsense"),
        (("--vary", ","), "--vary"),
        (("--vary", "kp", "--range", "kp"), "--range"),
        (("--vary", "kp", "--range", "mdvel=1:2:1"), "mdvel"),
        (("--vary", "kp", "--range", "kp=2:1:1"), "kp"),
        (("--vary", "kp", "--range", "kp=0:1:0.1"), "0:1:0.1"),
        (("--vary", "ki"), "abs"),
        (("--vary", "kp,mdvel,maxacc,lag_s"), "combinations"),
        (("--vary", "kp", "--axes", "Q"), "Q"),
        (("--vary", "kp", "--for", "money"), "money"),
        ((), "--vary"),
    ],
)
def test_what_cannot_be_varied_is_refused(cli: Cli, options: tuple[str, ...], said: str) -> None:
    ran = cli("tune", BRACKET, *options)
    assert ran.code == 2 and ran.out == "" and said in ran.err


def test_an_override_sweep(cli: Cli, tmp_path: Path) -> None:
    ran = cli("run", BRACKET, "--override-sweep", "0.5:1.4:0.3", "--report", tmp_path / "r", "--json")
    rows = ran.object["override_sweep"]
    assert [row["factor"] for row in rows] == [0.5, 0.8, 1.1, 1.4]
    alone = cli("run", BRACKET, "--override", "0.8", "--json").object
    assert rows[1]["machine_time_s"] == alone["machine_time_s"]
    assert rows[1]["actual_max_mm"] == alone["deviation"]["actual"]["max_mm"]
    assert all(row["path_change_mm"] < 1e-9 and row["velocity_ratio_error_pct"] < 1e-6 for row in rows)
    assert rows[3]["verdict"] == "FAIL", "the drives end at 250 mm/s"
    html = (tmp_path / "r/report.html").read_text("utf-8")
    assert 'id="override-sweep"' in html and f"{rows[2]['machine_time_s']:.3f}" in html
    text = cli("run", BRACKET, "--override-sweep", "0.5:1.4:0.3", "--lang", "de").out
    assert "Bahnänderung" in text and f"{rows[2]['machine_time_s']:.3f}" in text


@pytest.mark.parametrize("span", ["x", "1:2", "0:1:0.1", "1:0.5:0.1", "1:20:1", "0.001:1:0.001", "nan:1:1"])
def test_an_override_sweep_that_is_none_is_refused(cli: Cli, span: str) -> None:
    ran = cli("run", BRACKET, "--override-sweep", span)
    assert ran.code == 2 and "--override-sweep" in ran.err
