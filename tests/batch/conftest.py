"""Programs and commands of batch tests."""

from __future__ import annotations

import random
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
MILLS = [ROOT / "examples" / "machines" / f"{name}.toml" for name in ("mill3", "mill4a")]


def program(seed: int, blocks: int) -> str:
    """A contour of lines and arcs."""
    dice = random.Random(seed)
    lines = ["G90 G17 G64", "G00 X0 Y0 Z5", "F1200"]
    for n in range(blocks):
        x, y = dice.uniform(-20, 20), dice.uniform(-20, 20)
        lines.append(f"N{n + 1} G01 X{x:.3f} Y{y:.3f} Z{dice.uniform(-3, 0):.3f}")
    return "\n".join([*lines, "M30", ""])


@pytest.fixture
def parts(tmp_path: Path) -> Path:
    """A folder of small programs."""
    folder = tmp_path / "parts"
    folder.mkdir()
    for n in range(8):
        (folder / f"part{n}.nc").write_text(program(n, 2 + 3 * n))
    return folder


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "cnc_front", *map(str, arguments)]


def batch(*arguments: object, code: int | None = 0) -> subprocess.CompletedProcess[str]:
    """Runs `cnc-front batch`; its exit code must be that one."""
    ran = subprocess.run(command("batch", *arguments), cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert code is None or ran.returncode == code, ran.stderr
    assert "Traceback" not in ran.stderr and "internal error" not in ran.stderr
    return ran


def results(out: Path) -> list[dict[str, Any]]:
    """Every row of the store, without the times on the wall."""
    with sqlite3.connect(out / "results.sqlite") as base:
        base.row_factory = sqlite3.Row
        rows = [dict(row) for row in base.execute("SELECT * FROM results ORDER BY key")]
    base.close()
    for row in rows:
        del row["wall_s"]
    return rows


def machines() -> list[object]:
    return [word for path in MILLS for word in ("--machine", path)]
