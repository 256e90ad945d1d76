"""The 40 real part programs of ../shared/nc: those that compile run to their end on their path, the others are
refused with every problem named. The programs are not ours, so the folder may be missing; that is shown as skips."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from tests.app.conftest import ROOT, Cli
from tests.app.test_bad_input import PLACE

FOLDER = next((p / "shared" / "nc" for p in ROOT.parents if (p / "shared" / "nc").is_dir()), ROOT.parent / "shared/nc")
MACHINES = ROOT / "examples" / "machines"

#: Programs that run: file, machine, dialect profile (empty: that of the machine file).
RUNS = [
    ("3d-flower-mold.nc", "mill3", ""),
    ("cambam-handle.nc", "mill3", ""),
    ("comments.gcode", "mill3", ""),
    ("deskproto-botomata.nc", "mill3", ""),
    ("fanuc0t-lathe.nc", "mill3", "lathe"),  # F0.3 is mm/min here: 19 hours of machine time
    ("fusion-parallel-inch.nc", "mill3", ""),
    ("helix-full-turns.gcode", "mill3", ""),
    ("laser-abs-centre.tap", "mill3", ""),
    ("lathe-turn.nc", "mill3", "lathe"),
    ("mach3-clamp-inch.nc", "mill3", ""),
    ("mach3-pocket-r.tap", "mill3", ""),
    ("named-param-cutout.ngc", "mill3", "linuxcnc"),
    ("no-spaces.gcode", "mill3", ""),
    ("oword-encoder.ngc", "mill3", "linuxcnc"),
    ("pcb2gcode-all-inch.ngc", "mill3", ""),
    ("peck-g83.nc", "mill3", ""),
    ("planes-incremental.nc", "mill3", ""),
    ("planes-r-inch.gcode", "mill3", ""),
    ("pycam-cat-outline.ngc", "mill3", ""),
    ("rotary-4axis-finish.nc", "mill4a", ""),
    ("sketchucam-rword.gcode", "mill3", ""),
    ("thread-helix-360.nc", "mill3", ""),
    ("vcarve-openvoronoi.ngc", "mill3", ""),
    ("vectric-rotary-a.gcode", "mill4a", ""),
    ("vectric-scorpion.nc", "mill3", ""),
    ("vertical-slot.ngc", "mill3", ""),
]

#: Programs that are refused: file, machine, some of the ids that must be named.
REFUSED = [
    ("b-axis-faces.nc", "mill3", {"GC801"}),  # a B axis
    ("fanuc-lathe-macro.nc", "mill3", {"GC510"}),  # M16, variables of a macro
    ("fanuc0m-mill.nc", "mill3", {"GC413"}),  # 910 mm of travel
    ("freecad-centroid.ngc", "mill3", {"GC413", "GC501"}),  # millimetres meant as inches
    ("haas-threadmill.nc", "mill3", {"GC413", "GC701"}),  # system variables
    ("line-skip.gcode", "mill3", {"GC501"}),  # no feed
    ("mach3-db25-g98.tap", "mill3", {"GC210"}),  # D1.5
    ("pcb2gcode-tiled-sub.ngc", "mill3", {"GC701"}),  # #5420
    ("philips3000-lathe.nc", "mill3", {"GC503"}),  # a dialect of its own
    ("rotary-shaft-inch.nc", "mill4a", {"GC614"}),  # M29 outside a subprogram
    ("sinumerik-5axis.mpf", "mill3", {"GC801"}),
    ("sinumerik-arc-cr.mpf", "mill3", {"GC404"}),
    ("sinumerik840d.mpf", "mill3", {"GC801"}),
    ("sinumerik850-drill.nc", "mill3", {"GC801"}),
]

needs_programs = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"no part programs in {FOLDER}")


@needs_programs
@pytest.mark.parametrize(("name", "machine", "profile"), RUNS, ids=[row[0] for row in RUNS])
def test_runs_on_its_path(cli: Cli, name: str, machine: str, profile: str) -> None:
    options = ["--profile", profile] if profile else []
    ran = cli("run", FOLDER / name, "--json", "-q", "--machine", MACHINES / f"{machine}.toml", *options, timeout=300)
    run = ran.object
    assert ran.code == 0, (ran.err, run.get("verdict"))
    assert run["status"] == "completed"
    assert run["deviation"]["setpoint"]["max_mm"] <= run["merged"]["max_mm"] + 1e-6
    assert run["merged"]["max_mm"] <= 0.1, "no more than a G64 P of these programs"
    assert run["alarms"] == []
    assert run["error_register"] == []


@needs_programs
@pytest.mark.parametrize(("name", "machine", "ids"), REFUSED, ids=[row[0] for row in REFUSED])
def test_is_refused_with_every_problem_named(cli: Cli, name: str, machine: str, ids: set[str]) -> None:
    path = FOLDER / name
    ran = cli("check", path, "--machine", MACHINES / f"{machine}.toml")
    assert ran.code == 2
    found = list(PLACE.finditer(ran.err))
    assert {m["id"] for m in found} >= ids
    length = len(path.read_bytes().splitlines())
    assert all(1 <= int(m["line"]) <= length + 1 for m in found)
    errors = sum(m["id"].startswith("GC") for m in found)
    assert ran.err.count("hint:") >= errors, "each error says what to do"


@needs_programs
@pytest.mark.parametrize("name", [row[0] for row in RUNS if row[1] == "mill3" and not row[2]][:6])
def test_override_changes_no_path(cli: Cli, name: str) -> None:
    run = cli("run", FOLDER / name, "--json", "-q", "--override", "0:1,1:0.3,2:1.2", timeout=300).object
    assert run["status"] == "completed"
    assert run["deviation"]["setpoint"]["max_mm"] <= run["merged"]["max_mm"] + 1e-6


@needs_programs
def test_every_program_has_its_row() -> None:
    with (FOLDER / "index.csv").open(newline="") as file:
        names = {Path(row["file"]).name for row in csv.DictReader(file)}
    assert (len(RUNS), len(REFUSED)) == (26, 14)
    assert names == {row[0] for row in [*RUNS, *REFUSED]}
