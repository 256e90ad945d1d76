"""The programs of examples/resources run and say what they should."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.app.conftest import ROOT

FOLDER = ROOT / "examples" / "resources"
OUTPUT = {
    "gantry": [
        r"at 100\.00 and 100\.00, askew by \d\d? um at most",
        r"W is stuck: both stopped at 13[12]\.\d and 130\.0",
    ],
    "flying_saw": [rf"belt at +{speed} mm/s: beside the mark over 188 mm, to \d um" for speed in (80, 40, 100)],
    "endat": [
        "without MT0 the axis has None",
        r"EndatSetup\(version=22, bits=24, rotary=True, steps=8192\)",
        "position word 12500",
        "serial number 4711",
        "return code 0x80, 1 CRC error, bus error 1",
        "alarm 1",
        "no reset in closed loop",
        "after the reset: alarm 0 bus error 0",
    ],
}


def test_every_example_is_here() -> None:
    assert {path.stem for path in FOLDER.glob("*.py")} == set(OUTPUT)


@pytest.mark.parametrize("name", OUTPUT)
def test_example(name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", [name])
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(OUTPUT[name]), lines
    for line, pattern in zip(lines, OUTPUT[name], strict=True):
        assert re.fullmatch(pattern, line), line


def test_the_picture_is_that_of_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = tmp_path / "saw.png"
    monkeypatch.setattr(sys, "argv", ["flying_saw", str(drawn)])
    runpy.run_path(str(FOLDER / "flying_saw.py"), run_name="__main__")
    new, old = (cv2.imread(str(path)).astype(int) for path in (drawn, ROOT / "docs" / "flying-saw.png"))
    assert new.shape == old.shape and np.mean(np.abs(new - old).max(axis=2) > 40) < 0.01
