"""compare of two runs: figures, new and cured findings, blocks, a page with both side by side."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.app.conftest import ROOT, Cli

BRACKET = ROOT / "examples/jobs/bracket.nc"


@pytest.fixture(scope="module")
def runs(cli: Cli, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`good` and `worn` as report and recording, `slow` at another override."""
    folder = tmp_path_factory.mktemp("compare")
    text = cli("machine", "show").out
    (folder / "worn.toml").write_text(text.replace("backlash = 0.0\n", "backlash = 0.012\n", 1), "utf-8")
    for name, options in {
        "good": (),
        "worn": ("--machine", folder / "worn.toml"),
        "slow": ("--override", "0.5"),
    }.items():
        ran = cli("run", BRACKET, *options, "--report", folder / name, "--record", folder / f"{name}.mcap", "--json")
        assert ran.code == 0
    return folder


def figure(changes: dict, name: str) -> dict:
    (found,) = [f for f in changes["figures"] if f["name"] == name]
    return dict(found)


def test_a_run_is_the_same_as_itself(cli: Cli, runs: Path) -> None:
    ran = cli("compare", runs / "good", runs / "good.mcap", "--json")
    changes = ran.object
    assert ran.code == 0 and changes["schema"] == "cnc-front/compare/1"
    assert changes["new"] == changes["cured"] == changes["blocks"] == changes["differs"] == []
    assert {f["trend"] for f in changes["figures"]} == {"same"} and not changes["worse"]


@pytest.mark.parametrize("kind", ["", "/report.json", ".mcap"])
def test_a_worn_axis_is_a_new_finding_and_a_repaired_one_is_cured(cli: Cli, runs: Path, kind: str) -> None:
    good, worn = f"{runs}/good{kind}", f"{runs}/worn{kind}"
    ran = cli("compare", good, worn, "--json")
    changes = ran.object
    assert ran.code == 1 and changes["worse"] and changes["differs"] == ["machine"]
    assert changes["verdict"] == ["PASS", "WARN"]
    (told,) = changes["new"]
    assert "backlash" in told and "axis X" in told and changes["cured"] == []
    assert figure(changes, "deviation_rms")["trend"] == "worse"
    assert max(abs(row["change_um"]) for row in changes["blocks"]) == pytest.approx(6.0, rel=0.3), "half of the play"
    back = cli("compare", worn, good, "--json")
    assert back.code == 0 and back.object["cured"] == [told] and back.object["new"] == []


def test_another_override(cli: Cli, runs: Path) -> None:
    changes = cli("compare", runs / "good.mcap", runs / "slow", "--json").object
    time = figure(changes, "machine_time")
    assert changes["differs"] == ["schedule"]
    assert time["after"] == pytest.approx(2 * time["before"], rel=1e-3) and time["trend"] == "worse"
    assert figure(changes, "deviation_max")["trend"] == "better"
    reports = [json.loads((runs / name / "report.json").read_text("utf-8"))["result"] for name in ("good", "slow")]
    assert time["change"] == pytest.approx(reports[1]["machine_time_s"] - reports[0]["machine_time_s"])


def test_the_page_shows_both_side_by_side(cli: Cli, runs: Path, tmp_path: Path) -> None:
    ran = cli("compare", runs / "good", runs / "worn.mcap", "--out", tmp_path / "page", "--lang", "de")
    assert ran.code == 1 and "neue Befunde: Umkehrspanne" in ran.out
    html = (tmp_path / "page/report.html").read_text("utf-8")
    assert html.count("data:image/png;base64,") == 2 and "Umkehrspanne" in html
    assert not re.search(r"https?://|@import|url\(", html)
    changes = json.loads((tmp_path / "page/compare.json").read_text("utf-8"))
    for f in changes["figures"]:
        assert f["after"] is None or f"{f['after']:.4f}" in html, f


def test_what_is_no_run_is_refused(cli: Cli, runs: Path, tmp_path: Path) -> None:
    (tmp_path / "x.json").write_text('{"schema": "other"}', "utf-8")
    broken = json.loads((runs / "good/report.json").read_text("utf-8"))
    broken["result"]["verdict"] = []
    (tmp_path / "broken.json").write_text(json.dumps(broken), "utf-8")
    (tmp_path / "half.mcap").write_bytes((runs / "good.mcap").read_bytes()[:200])
    for other, said in (
        (tmp_path / "x.json", "other"),
        (tmp_path / "broken.json", "neither"),
        (BRACKET, "neither"),
        (tmp_path, "neither"),
    ):
        ran = cli("compare", runs / "good", other)
        assert ran.code == 2 and ran.out == "" and said in ran.err
    assert "CF401" in cli("compare", runs / "good", tmp_path / "half.mcap").err
    assert cli("compare", tmp_path / "no", tmp_path / "none").code == 2
    assert cli("compare", runs / "good", runs / "worn", "--out", BRACKET).code == 2
    # a page is never written over other files
    (tmp_path / "full").mkdir()
    (tmp_path / "full/own.txt").write_text("mine", "utf-8")
    assert cli("compare", runs / "good", runs / "worn", "--out", tmp_path / "full").code == 2
