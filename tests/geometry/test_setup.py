"""Setup files: every mistake at its line and column; jobs that cannot be checked are refused; the example plate."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnc_front.errors import CompileError
from cnc_front.geometry.setup import Setup, parse_setup
from cnc_front.german import german
from tests.app.conftest import ROOT, Cli
from tests.geometry.programs import box_stl

PLATE = ROOT / "examples" / "plate"
GOOD = """zero = [1.0, 2.0, 3.0]
resolution = 0.5
first_tool = 2
rapid_margin = 0.1
follow = "setpoint"

[stock]
from = [0, 0, -10]
to = [40, 30, 0]

[[tool]]
number = 1
shape = "flat"
diameter = 6.0

[[tool]]
number = 2
shape = "bull"
diameter = 10
corner = 1.5
gauge = 80.0
flute = 20.0
length = 40.0
shank = 8.0
holder = [{ diameter = 30.0, length = 20.0 }, { diameter = 50.0, length = 30.0 }]
"""


def parsed(text: str, files: dict[str, bytes] | None = None) -> Setup:
    return parse_setup(text.encode(), "a.setup.toml", (files or {}).__getitem__)


def findings(text: str | bytes, files: dict[str, bytes] | None = None) -> list[str]:
    data = text if isinstance(text, bytes) else text.encode()
    with pytest.raises(CompileError) as caught:
        parse_setup(data, "a.setup.toml", (files or {}).__getitem__)
    for d in caught.value.diagnostics:
        assert d.hint and d.file == "a.setup.toml" and d.end_column >= d.column >= 1
    return [f"{d.line}:{d.column}: {d.id}: {d.message}" for d in caught.value.diagnostics]


def test_a_setup_is_what_it_says() -> None:
    setup = parsed(GOOD)
    assert setup.zero == (1, 2, 3) and setup.follow == "setpoint"
    shop = setup.shop
    assert shop.first_tool == 2 and shop.rapid_margin == 0.1 and shop.floor == -10
    assert shop.grid is not None and (shop.grid.nx, shop.grid.ny, shop.grid.step) == (80, 60, 0.5)
    bull = shop.tools[2]
    assert (bull.radius, bull.corner, bull.gauge, bull.flute) == (5, 1.5, 80, 20)
    assert bull.bodies == ((4.0, 20.0), (15.0, 40.0), (25.0, 60.0))
    assert shop.tools[1].flute == float("inf") and shop.tools[1].bodies == ()


def test_the_default_resolution_gives_about_a_million_nodes() -> None:
    shop = parsed(GOOD.replace("resolution = 0.5\n", "")).shop
    assert shop.grid is not None and shop.grid.step == 0.05


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("resolution = 0.5", "resolution = 0.5 0.6", r"2:\d+: SU102: .*"),
        ("resolution = 0.5", "resolution = 0.00001", "2:14: SU106: resolution: 1e-05 is outside 0.001 .. 10"),
        ("resolution = 0.5", "resolution = 0.001", "2:14: SU111: resolution: 1200000000 nodes, .*"),
        ("resolution = 0.5", "resolution = true", "2:14: SU105: resolution: a number expected, a flag given"),
        ("resolution = 0.5", "resolution = nan", "2:14: SU106: resolution: nan is outside .*"),
        ("resolution = 0.5", "resolutoin = 0.5", "2:14: SU103: resolutoin: unknown key"),
        ("first_tool = 2", "first_tool = 7", "3:14: SU110: first_tool: there is no tool 7"),
        ('follow = "setpoint"', 'follow = "both"', "5:10: SU107: follow: 'both' is none of actual, setpoint"),
        ("zero = [1.0, 2.0, 3.0]", "zero = [1.0, 2.0]", r"1:1: SU105: zero: three numbers \[X, Y, Z\] expected"),
        ("zero = [1.0, 2.0, 3.0]", "zero = [1, 2, 1e9]", "1:1: SU106: zero: a coordinate is outside .*"),
        ("to = [40, 30, 0]", "to = [40, 30, -20]", "9:1: SU110: stock.to: must be above `from` in X, Y and Z"),
        ("to = [40, 30, 0]\n", "", "7:2: SU104: stock.to is missing"),
        ("number = 2", "number = 1", r"17:10: SU108: tool\[2\].number: tool 1 is there twice"),
        ("number = 2", "number = 2.5", r"17:10: SU105: tool\[2\].number: a whole number expected, a number given"),
        ('shape = "bull"', 'shape = "cone"', r"18:9: SU107: tool\[2\].shape: 'cone' is none of flat, ball, bull"),
        ("corner = 1.5", "corner = 5.5", r"20:10: SU110: tool\[2\].corner: 5.5 is more than the radius of the tool"),
        ("flute = 20.0", "flute = 50.0", r"22:9: SU110: tool\[2\].flute: is more than the length of the tool"),
        ("{ diameter = 30.0,", "{ diameter = -1,", r"25:24: SU106: tool\[2\].holder\[1\].diameter: -1 is outside .*"),
        ("{ diameter = 30.0, length = 20.0 }", "7", r"25:1: SU105: tool\[2\].holder: a list of tables expected"),
        ("[stock]", "[stok]", "7:2: SU103: stok: unknown key"),
    ],
)
def test_mistakes_stand_at_their_place(before: str, after: str, expected: str) -> None:
    assert before in GOOD
    found = findings(GOOD.replace(before, after, 1))
    assert any(re.fullmatch(expected, line) for line in found), found


def test_all_mistakes_at_once_and_in_order() -> None:
    found = findings(GOOD.replace("6.0", '"6"').replace("corner = 1.5", "korner = 1").replace("[1.0, 2.0, 3.0]", "5"))
    assert [line.split(": ")[1] for line in found] == ["SU105", "SU105", "SU104", "SU103"]


@pytest.mark.parametrize("data", [b"\xff\xfe", b"a\0b"])
def test_what_is_no_text(data: bytes) -> None:
    assert findings(data)[0].startswith("1:1: SU101")


def test_nothing_to_check() -> None:
    assert any("nothing to check" in line for line in findings('[[tool]]\nnumber=1\nshape="flat"\ndiameter=6'))
    assert any("SU104" in line for line in findings("[stock]\nfrom=[0,0,0]\nto=[1,1,1]"))


def test_meshes_are_refused_at_their_name() -> None:
    text = GOOD + '\n[target]\nfile = "part.stl"\n\n[[fixture]]\nname = "vice"\nfile = "vice.stl"\n'
    body = box_stl((0, 0, -10), (40, 30, -2))
    assert parsed(text, {"part.stl": body, "vice.stl": body}).target is not None
    opened = body.replace(b"facet", b"FACET", 2)
    found = findings(text, {"part.stl": body[: len(body) // 2], "vice.stl": b"solid\nendsolid\n"})
    assert [line.split(": ")[:2] for line in found] == [["28:8", "SU109"], ["32:8", "SU109"]], (found, opened[:9])


def test_a_blank_and_a_target_from_meshes_with_unit_and_place() -> None:
    text = GOOD.replace("from = [0, 0, -10]\nto = [40, 30, 0]", 'file = "blank.stl"\nunit = "inch"\nat = [5, 0, 0]')
    setup = parsed(text, {"blank.stl": box_stl((0, 0, -1), (2, 1, 0))})
    grid = setup.shop.grid
    assert grid is not None and (grid.x0, grid.y0) == (5, 0)
    assert (grid.nx, grid.ny) == (102, 51) and setup.shop.floor == -25.4


@given(st.binary(max_size=300) | st.text(max_size=300).map(str.encode))
@settings(max_examples=200, deadline=None)
def test_whatever_stands_in_the_file_is_a_setup_or_findings(data: bytes) -> None:
    try:
        parse_setup(data, "a.setup.toml", {}.__getitem__)
    except CompileError as error:
        assert error.diagnostics


WORDS = ["zero", "[stock]", "[[tool]]", "[[fixture]]", "from", "to", "file", "=", "[", "]", "{", "}", "1", "-1e300"]
WORDS += ["nan", '"x"', ",", "diameter", "holder", "\n", "\n", "\n"]


@given(st.lists(st.sampled_from(WORDS), max_size=40))
@settings(max_examples=300, deadline=None)
def test_words_of_the_language_in_any_order(words: list[str]) -> None:
    test_whatever_stands_in_the_file_is_a_setup_or_findings.hypothesis.inner_test(" ".join(words).encode())  # type: ignore[attr-defined]


def test_findings_are_told_in_german() -> None:
    with pytest.raises(CompileError) as caught:
        parsed(
            GOOD.replace("6.0", '"6"').replace("corner = 1.5", "korner = 1").replace("first_tool = 2", "first_tool = 9")
        )
    for diagnostic in caught.value.diagnostics:
        assert german(diagnostic).message != diagnostic.message, diagnostic
        assert german(diagnostic).hint != diagnostic.hint, diagnostic


# ---- through the command


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    """A copy of the example."""
    shutil.copytree(PLATE, tmp_path / "plate")
    return tmp_path / "plate"


REFERENCE = ("--reference-layer", "BOSS", "--reference-offset", "left:5")


def test_the_example_passes_and_says_so(cli: Cli) -> None:
    ran = cli("run", PLATE / "plate.nc", "--reference", PLATE / "plate.dxf", *REFERENCE, "--json")
    result = ran.object
    assert ran.code == 0 and result["verdict"]["word"] == "PASS"
    assert result["collisions"] == {"count": 0, "kinds": {}, "findings": []}
    target = result["material"]["target"]
    assert target["gouge"]["max_mm"] < 0.001
    # the corner radius of 0.5 of the second tool stays in the pocket, less the cell beside the wall
    assert 0.1 < target["rest"]["max_mm"] < 0.5 and not target["rest"]["judged"]
    assert result["reference"]["missing_mm"] == 0.0 and result["reference"]["actual"]["max_mm"] < 0.01


def test_its_files_are_what_their_script_writes(tmp_path: Path) -> None:
    subprocess.run([sys.executable, PLATE / "make_plate.py", "--folder", tmp_path], check=True)
    for name in ("plate.dxf", "plate.stl", "clamp.stl"):
        assert (tmp_path / name).read_bytes() == (PLATE / name).read_bytes(), name


SHORT = {"length = 35.0": "length = 25.0", "flute = 20.0": "flute = 3.5"}
STUBBY = {"length = 28.0": "length = 2.5", "flute = 12.0": "flute = 2.5"}
LOW = {"N290 G0 Z10\n": "", "N310 G0 X32 Y30": "N310 G0 X32 Y30 Z-4"}


@pytest.mark.parametrize(
    ("job", "setup", "reason", "least", "most"),
    [
        ({}, {"[-20.0, 24.0": "[-12.0, 24.0"}, "tool_fixture", 9.0, 11.0),
        ({}, SHORT, "flutes_stock", 0.49, 0.51),
        ({}, STUBBY, "holder_stock", 0.4, 0.51),
        ({"N320 G0 Z1\n": "N320 G0 Z-1\n"}, {}, "rapid_stock", 0.9, 1.0),
        (LOW, {}, "rapid_stock", 3.9, 4.0),
    ],
)
def test_what_meets_what_is_named_with_line_and_size(
    cli: Cli, plate: Path, job: dict[str, str], setup: dict[str, str], reason: str, least: float, most: float
) -> None:
    for name, changes in (("plate.nc", job), ("plate.setup.toml", setup)):
        text = (plate / name).read_text()
        for before, after in changes.items():
            assert before in text
            text = text.replace(before, after)
        (plate / name).write_text(text)
    ran = cli("run", plate / "plate.nc", "--json")
    assert ran.code == 1
    found = [f for f in ran.object["collisions"]["findings"] if f["kind"] == reason]
    assert found, ran.object["collisions"]
    assert least <= max(f["size_mm"] for f in found) <= most
    assert all(f["line"] > 0 and f["t_s"] > 0 for f in found)
    assert any(r["id"] == "collision" and r["kind"] == reason for r in ran.object["verdict"]["reasons"])
    assert ran.object["verdict"]["word"] == "FAIL"


def test_a_pocket_too_deep_by_30_um_is_a_gouge(cli: Cli, plate: Path) -> None:
    text = (plate / "plate.nc").read_text()
    (plate / "plate.nc").write_text(text.replace("N340 G1 X32 Z-3", "N340 G1 X32 Z-3.03"))
    ran = cli("run", plate / "plate.nc", "--json")
    gouge = ran.object["material"]["target"]["gouge"]
    assert ran.code == 1 and gouge["max_mm"] == pytest.approx(0.03, abs=0.001)
    lines = (plate / "plate.nc").read_text().splitlines()
    assert lines[gouge["line"] - 1].split()[0] in {"N340", "N350", "N360", "N370", "N380", "N390", "N400"}
    # what the bull nose touches flat, as wide as its face of 5 mm round the pocket
    assert 200 < gouge["area_mm2"] < 400
    text_run = cli("run", plate / "plate.nc", "--lang", "de")
    assert "Untermaß 30.4 um > 20.0 um bei X" in text_run.out


def test_report_and_recording_say_what_the_run_says(cli: Cli, plate: Path, tmp_path: Path) -> None:
    (plate / "plate.setup.toml").write_text(
        (plate / "plate.setup.toml").read_text().replace("[-20.0, 24.0", "[-12.0, 24.0")
    )
    arguments = ("--reference", plate / "plate.dxf", *REFERENCE, "--lang", "de")
    ran = cli(
        "run", plate / "plate.nc", *arguments, "--json", "--record", tmp_path / "a.mcap", "--report", tmp_path / "run"
    )
    assert ran.code == 1
    for name in ("plate.stl", "clamp.stl", "plate.dxf", "plate.setup.toml"):
        (plate / name).unlink()
    assert cli("report", tmp_path / "a.mcap", tmp_path / "again", "--lang", "de").code == 0
    reports = [json.loads((tmp_path / name / "report.json").read_text()) for name in ("run", "again")]
    for key in ("reference", "material", "collisions"):
        assert reports[0]["result"][key] == reports[1]["result"][key] == ran.object[key], key
    for picture in ("reference.png", "material.png", "material-target.png"):
        assert (tmp_path / "run/png" / picture).read_bytes() == (tmp_path / "again/png" / picture).read_bytes(), picture
    page = (tmp_path / "run" / "report.html").read_text()
    shown = dict(re.findall(r'id="fig-([\w-]+)">([^<]*)<', page))
    most = ran.object["reference"]["actual"]["max_mm"]
    assert shown["reference-actual"] == f"{most * 1e3:.3f}"
    assert shown["missing"] == "0.00"
    assert shown["removed"] == f"{ran.object['material']['removed_mm3']:.2f}"
    assert shown["rest"] == f"{ran.object['material']['target']['rest']['max_mm'] * 1e3:.1f}"
    assert shown["collisions"] == str(ran.object["collisions"]["count"])
    assert "Werkzeug trifft Spannmittel" in page and "Gegen die Zeichnung" in page


def test_a_setup_given_to_report_takes_the_place_of_the_recorded_one(cli: Cli, plate: Path, tmp_path: Path) -> None:
    assert cli("run", plate / "plate.nc", "--record", tmp_path / "a.mcap").code == 0
    text = (plate / "plate.setup.toml").read_text().replace("resolution = 0.1", "resolution = 0.4")
    (plate / "other.toml").write_text(text)
    assert cli("report", tmp_path / "a.mcap", tmp_path / "out", "--setup", plate / "other.toml").code == 0
    result = json.loads((tmp_path / "out" / "report.json").read_text())["result"]
    assert result["material"]["resolution_mm"] == 0.4


@pytest.mark.parametrize(
    ("block", "arguments", "message"),
    [
        ("N300 T9 M6", (), "changes to tool 9 in line"),
        ("N430 G0 Z20 A10", ("--machine", ROOT / "examples/machines/mill4a.toml"), "moves A"),
        ("", ("--setup", "nothing.toml"), "SU100"),
        ("", ("--machine", ROOT / "examples/machines/xy-stepper.toml"), "no linear Z"),
    ],
)
def test_jobs_that_cannot_be_checked_are_refused(
    cli: Cli, plate: Path, block: str, arguments: tuple[object, ...], message: str
) -> None:
    lines = (plate / "plate.nc").read_text().splitlines(keepends=True)
    number = block.split(" ")[0] + " "
    text = "".join(block + "\n" if block and line.startswith(number) else line for line in lines)
    if "xy-stepper" in str(arguments):
        text = "%1\nN10 G0 X10 Y10\nN20 G1 X0 F600\nN30 M30\n"
    (plate / "plate.nc").write_text(text)
    ran = cli("run", plate / "plate.nc", *arguments)
    assert ran.code == 2
    assert message in ran.err


def test_tool_0_is_an_empty_spindle(cli: Cli, plate: Path) -> None:
    text = (plate / "plate.nc").read_text().replace("N430 G0 Z20", "N430 G0 Z20\nN435 T0 M6\nN436 G0 Z-9")
    (plate / "plate.nc").write_text(text)
    assert cli("run", plate / "plate.nc").code == 0


def test_a_run_without_them_loads_nothing_heavy() -> None:
    job = ROOT / "examples/jobs/bracket.nc"
    code = (
        "import contextlib, io, sys\nfrom cnc_front.cli import run_command_line\n"
        f"with contextlib.redirect_stdout(io.StringIO()):\n    run_command_line(['run', '-q', {str(job)!r}])\n"
        "print(*{name.split('.')[0] for name in sys.modules})"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert not set(run.stdout.split()) & {"trimesh", "ezdxf", "svgelements", "cv2", "scipy", "networkx", "lxml"}
