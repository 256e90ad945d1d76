"""--from, --to and block search as operators meet them; the sheet of `translate`; `check --strict`."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from cnc_front.errors import CompileError
from cnc_front.jobs import CompileOptions, load_machine, read_job
from cnc_front.search import search
from tests.app.conftest import ROOT, Cli

CAM = ROOT / "examples" / "jobs" / "cam.nc"
PART = """N10 G21 G90 G55 T3 M6
N20 S2000 M3 M8
N30 G0 X10 Y5 Z20
N40 G91 G1 Z-25 F300
N50 X10 (first cut)
N60 Y7
N70 G90 G0 Z20
N80 M9
N90 X0
M30
"""


@pytest.fixture
def part(tmp_path: Path) -> Path:
    path = tmp_path / "part.nc"
    path.write_text(PART, encoding="utf-8")
    return path


def commands(text: str) -> list[dict[str, object]]:
    return [c for c in map(json.loads, text.splitlines()) if c["cmd"] != "ssf"]


def test_a_part_runs_to_its_end_on_its_path(cli: Cli, part: Path) -> None:
    run = cli("run", part, "--from", "N60", "--json", "--lang", "de")
    assert run.code == 0
    assert "Start in Zeile 6: G1 G17 G91 G21 G94 G40 G49 G64 G55" in run.err
    start = run.object["start"]
    assert (start["line"], start["in_spindle"], start["spindle"], start["flood"]) == (6, 3, 3, True)
    assert start["program"] == {"X": 20.0, "Y": 5.0, "Z": -5.0}
    assert run.object["deviation"]["setpoint"]["max_mm"] <= 1e-6
    whole = cli("run", part, "--json", "-q").object
    assert whole["start"] is None and whole["path_length_mm"] > run.object["path_length_mm"]


def test_the_commands_behind_the_start_are_those_of_the_whole(cli: Cli) -> None:
    whole = commands(cli("translate", CAM, "--json", "-q").out)
    lines = [int(str(c["line"])) for c in whole]
    middle = lines[len(lines) // 2]
    part = commands(cli("translate", CAM, "--json", "-q", "--from", middle).out)
    rest = whole[lines.index(middle) :]
    assert part[-len(rest) :] == rest and 1 <= len(part) - len(rest) <= 3
    upto = commands(cli("translate", CAM, "--json", "-q", "--to", middle).out)
    ends = [c["target"] for c in whole if int(str(c["line"])) <= middle]
    assert [c["target"] for c in upto] == ends


def test_search_is_an_api(part: Path) -> None:
    source, machine = read_job(str(part)), load_machine(None)
    start = search(source, machine, CompileOptions(), "N70")
    assert (start["machine"]["Y"], start["feed"], start["modal"].split()[2]) == (12.0, 300.0, "G91")
    with pytest.raises(CompileError) as caught:
        search(source, machine, CompileOptions(), "N77")
    assert [d.id for d in caught.value.diagnostics if not d.is_warning] == ["GC617"]


@pytest.mark.parametrize("value", ["-3", "N", "x", "1.5", "N999999999"])
def test_what_is_no_block_is_bad_usage(cli: Cli, part: Path, value: str) -> None:
    ran = cli("check", f"--from={value}", part)
    assert ran.code == 2 and value in ran.err


def test_the_sheet_shows_each_line_once_and_in_order(cli: Cli, part: Path) -> None:
    sheet = cli("translate", part, "-q").out.splitlines()
    shown = [int(m[1]) for m in (re.match(r" *(\d+) \| ", line) for line in sheet) if m]
    assert shown == list(range(1, 11))
    cut = next(i for i, line in enumerate(sheet) if "first cut" in line)
    assert sheet[cut + 1].split()[:3] == ["smla", "X", "20.0000"]
    assert any("set output 1 3" in line for line in sheet)


def test_strict_is_only_said_when_asked_for(cli: Cli, tmp_path: Path) -> None:
    path = tmp_path / "smells.nc"
    path.write_text("G0 Z5\nX5\nG1 Z-1 F100\nG0 X10\nM30\n%L7\nM17\n", encoding="utf-8")
    assert "GW94" not in cli("check", path).err
    strict = cli("check", "--strict", path)
    assert strict.code == 0
    assert re.findall(r":(\d+):\d+: (GW94\d)", strict.err) == [("4", "GW943"), ("6", "GW944")]
