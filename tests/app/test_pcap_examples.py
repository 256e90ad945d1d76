"""The programs of examples/pcap run and say what they should: homing, teach-in, gear change ..."""

from __future__ import annotations

import re
import runpy

import pytest

from tests.app.conftest import ROOT

FOLDER = ROOT / "examples" / "pcap"
# what each program prints, line by line, as a pattern
OUTPUT = {
    "circle_in_space": [
        r"radius 22\.3607 \+- \d\.\de-1\d, out of its plane by \d\.\de-1\d",
        r"helix of two turns: moved by 0\.000 0\.000 -8\.000",
    ],
    "gear_change": [
        "first gear: 5 mm a revolution, 10 mm are 10000 counts",
        r"the axis has not moved, its position is 40\.00 now",
        "second gear: 20 mm a revolution, 10 mm are 2500 counts",
        "jog velocity 200 mm/s, the motor as fast as before",
    ],
    "homing": [
        r"X: switch found at -80\.\d",
        r"Y: switch found at -50\.\d",
        r"X: index latched, referenced True, now at 0\.\d+",
        r"Y: index latched, referenced True, now at 0\.\d+",
        r"at home: -?0\.00[01] -?0\.00[01]",
    ],
    "measuring": [
        r"the part reaches from 30\.0\d\d to 42\.[45]\d\d: 12\.[45]\d\d mm",
        r"light barrier at 60\.\d\d, to a sample",
        "nothing there up to 95.0",
    ],
    "override": [
        r"factor 1: .*",
        r"factor 0\.25: path velocity 10\.00 mm/s, jog override 0\.25",
        r"factor 1\.5: path velocity 60\.00 mm/s, jog override 1\.5",
        r"factor 1: path velocity 40\.00 mm/s, jog override 1",
        r"off the circle by \d\.\de-1\d mm",
    ],
    "spooling": [r"601 commands with \d{1,4} of 148480 bytes, 1\d\.\d s", r"end at 40\.000 0\.000, ErrorReg \(\)"],
    "synchronised": [
        r"the task waits for a tool at X 20\.0, CI99 is [1-9]\d*",
        r"it went on to Y 20\.0; its buffer holds 'tool 1: 6 mm end mill'",
        r"interrupt at Z -[45]\.\d\d, then back to 0\.00",
    ],
    "teach_in": [r"taught 160 positions, from 0\.\d\d to 1\d\.\d\d and back to \d\.\d\d", r"driven again within \d um"],
    "tuning": [
        r"P alone +1\.\d\d\d mm behind, trembles by 0\.00\d mm",
        r"with velocity +0\.0\d\d mm behind, trembles by 0\.00\d mm",
        r"with both +0\.00\d mm behind, trembles by 0\.00\d mm",
        r"20 times the gain +0\.[1-9]\d\d mm behind, trembles by 0\.[1-9]\d\d mm",
    ],
    "two_cards": [
        "rwmos.elf: the file cannot be opened",
        "the operating system is not loaded .*",
        "return code -4: .*",
        "card 1: mill3, 3 axes",
        r"it is at 25\.00",
        "cell.toml: the file was transferred",
        r"card 1 is a cell now, its X at 0\.00",
        "there is no card 2: -1",
    ],
}


def test_there_are_ten() -> None:
    assert sorted(path.stem for path in FOLDER.glob("*.py")) == sorted(OUTPUT)
    assert len(OUTPUT) == 10


@pytest.mark.parametrize("name", OUTPUT)
def test_example(name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(OUTPUT[name])
    for line, pattern in zip(lines, OUTPUT[name], strict=True):
        assert re.fullmatch(pattern, line.rstrip()), line
