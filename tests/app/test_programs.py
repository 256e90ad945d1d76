"""The 40 real part programs of ../shared/nc: those that compile run to their end on their path, the others are
refused with every problem named. The programs are not ours, so the folder may be missing; that is shown as skips."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from tests.app.conftest import ROOT, Cli
from tests.app.programs import FOLDER, Row, rows
from tests.app.test_bad_input import PLACE

RUNS = [row for row in rows() if not row.ids]
REFUSED = [row for row in rows() if row.ids]

needs_programs = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"no part programs in {FOLDER}")


@needs_programs
@pytest.mark.parametrize("row", RUNS, ids=[row.file for row in RUNS])
def test_runs_on_its_path(cli: Cli, row: Row, tmp_path: Path) -> None:
    ran = cli("run", FOLDER / row.file, "--json", "-q", *row.options(tmp_path), timeout=300)
    run = ran.object
    assert ran.code == 0, (ran.err, run.get("verdict"))
    assert run["status"] == "completed"
    assert run["deviation"]["setpoint"]["max_mm"] <= run["merged"]["max_mm"] + 1e-6
    assert run["merged"]["max_mm"] <= 0.1, "no more than a G64 P of these programs"
    assert run["alarms"] == []
    assert run["error_register"] == []


@needs_programs
@pytest.mark.parametrize("row", REFUSED, ids=[row.file for row in REFUSED])
def test_is_refused_with_every_problem_named(cli: Cli, row: Row, tmp_path: Path) -> None:
    path = FOLDER / row.file
    ran = cli("check", path, *row.options(tmp_path))
    assert ran.code == 2
    found = list(PLACE.finditer(ran.err))
    assert {m["id"] for m in found if m["id"].startswith("GC")} == row.ids
    length = len(path.read_bytes().splitlines())
    assert all(1 <= int(m["line"]) <= length + 1 for m in found)
    errors = sum(m["id"].startswith("GC") for m in found)
    assert ran.err.count("hint:") >= errors, "each error says what to do"


@needs_programs
@pytest.mark.parametrize("name", [row.file for row in RUNS if row.machine == "mill3" and not row.profile][:6])
def test_override_changes_no_path(cli: Cli, name: str) -> None:
    run = cli("run", FOLDER / name, "--json", "-q", "--override", "0:1,1:0.3,2:1.2", timeout=300).object
    assert run["status"] == "completed"
    assert run["deviation"]["setpoint"]["max_mm"] <= run["merged"]["max_mm"] + 1e-6


@needs_programs
def test_every_program_has_its_row() -> None:
    with (FOLDER / "index.csv").open(newline="") as file:
        names = {Path(row["file"]).name for row in csv.DictReader(file)}
    assert names == {row.file for row in rows()}


VARIANTS = sorted((Path(__file__).parent / "variants").glob("*.nc"))


@pytest.mark.parametrize("path", VARIANTS, ids=[path.name for path in VARIANTS])
def test_variants_of_cam_systems_and_controls_run(cli: Cli, path: Path) -> None:
    """Written for this test in the manner of the posts and controls in their names (NAME.PROFILE.nc)."""
    run = cli("run", path, "--json", "-q", "--profile", path.suffixes[0][1:]).object
    assert run["diagnostics"] == [] or {d["id"][:2] for d in run["diagnostics"]} == {"GW"}
    assert run["status"] == "completed" and run["alarms"] == []
    assert run["deviation"]["setpoint"]["max_mm"] <= run["merged"]["max_mm"] + 1e-6


def test_the_page_shows_every_row() -> None:
    lines = (ROOT / "docs" / "programs.md").read_text("utf-8").splitlines()
    shown = {line.split("|")[1].strip(): line for line in lines if line.startswith("|")}
    for row in rows():
        assert ("refused" if row.ids else "runs") in shown[row.file]
        assert all(id in shown[row.file] for id in row.ids)
