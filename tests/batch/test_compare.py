"""Two batches side by side, and a folder that is watched."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from tests.batch.conftest import ROOT, batch, command, program


def test_changes_are_named_with_their_reasons(parts: Path, tmp_path: Path) -> None:
    for name in ("part4.nc", "part5.nc", "part6.nc", "part7.nc"):
        (parts / name).unlink()
    (parts / "cured.nc").write_text("G01 X1 F100\nG01 Q*\nM30\n")
    (parts / "gone.nc").write_text(program(9, 3))
    before, after = tmp_path / "before", tmp_path / "after"
    batch(parts, "--out", before, "--reports", 1, code=2)
    (parts / "cured.nc").write_text("G01 X1 F100\nM30\n")
    (parts / "gone.nc").unlink()
    (parts / "new.nc").write_text(program(10, 3))
    (parts / "part1.nc").write_text((parts / "part1.nc").read_text().replace("F1200", "F600"))
    (parts / "part2.nc").write_text("G01 X1 F100\nG01 Q*\nM30\n")
    batch(parts, "--out", after, "--reports", 1, code=2)
    ran = subprocess.run(command("compare", before, after, "--json"), cwd=ROOT, capture_output=True, text=True)
    changes = {Path(c["part"]).name: c for c in json.loads(ran.stdout)}
    found = {name: c["change"] for name, c in changes.items()}
    assert found["cured.nc"] == "cured" and found["gone.nc"] == "gone" and found["new.nc"] == "new"
    assert found["part2.nc"] == "broken" and found["part1.nc"] in ("better", "worse", "slower")
    assert found["part0.nc"] == found["part3.nc"] == "same"
    assert changes["part1.nc"]["why"] == "the part changed" and "GC" in changes["part2.nc"]["reason"][1]
    assert ran.returncode == 1
    text = subprocess.run(command("compare", before, after), cwd=ROOT, capture_output=True, text=True).stdout
    assert "broken" in text and "2 of 7 are the same" in text


def test_a_folder_without_results_is_told(tmp_path: Path) -> None:
    ran = subprocess.run(command("compare", tmp_path, tmp_path), cwd=ROOT, capture_output=True, text=True)
    assert ran.returncode == 2 and "results.sqlite" in ran.stderr


def test_a_watched_folder_gets_verdicts(parts: Path, tmp_path: Path) -> None:
    (parts / "wrong.nc").write_text("G01 X1 F100\nG01 Q*\nM30\n")
    out = tmp_path / "out"
    batch("--watch", parts, "--once", "--out", out)
    assert (parts / "part1.nc.verdict.txt").read_text().startswith("PASS on mill3, ")
    assert (parts / "wrong.nc.verdict.txt").read_text().startswith("FAIL on mill3 GC")
    (parts / "wrong.nc").write_text("G01 X1 F100\nM30\n")
    batch("--watch", parts, "--once", "--out", out)
    assert (parts / "wrong.nc.verdict.txt").read_text().startswith("PASS on mill3")
