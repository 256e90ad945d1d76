"""The table of the real part programs (programs.csv): on which machine and in which dialect each is read, and why
those that do not run are refused. `python -m tests.app.programs FOLDER > docs/programs.md` writes the page."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
FOLDER = next((p / "shared" / "nc" for p in ROOT.parents if (p / "shared" / "nc").is_dir()), ROOT.parent / "shared/nc")
TABLE = Path(__file__).with_name("programs.csv")

#: What a row may change in the machine file: pattern, replacement.
CHANGES = {
    "travel": (r"limits = \{ left = [-\d.]+, right = [\d.]+", "limits = { left = -2000.0, right = 2000.0"),
    "lathe": (
        r"\Z",
        "\n[gcode.spindle]\nlimit = 3000.0\n"
        + "".join(f"\n[[gcode.m]]\nnumber = {m}\nset = [6]\n" for m in (16, 26, 27)),
    ),
    "d_is_radius": (r"\Z", "\n[gcode.dialect]\nd_is_radius = true\n"),
}


INTRODUCTION = """# The part programs of `shared/nc`

{programs} real programs from many CAM systems and people (origins and licences: `nc/index.csv`; they are not part of
this repository). {ran} run to their end on their path, {refused} are refused for the reason given. Written by
`python -m tests.app.programs ../shared/nc`; `tests/app/test_programs.py` holds every row. Deviations in mm: of the set
point (less what merging was allowed), and of the load side of the machine; the limit of the latter is 0.05.

| program | machine | profile | result | set point | machine | machine time |
|---|---|---|---|---|---|---|"""


@dataclass(frozen=True)
class Row:
    """One program: `ids` are all errors that `check` names, none if it runs."""

    file: str
    machine: str
    change: str
    profile: str
    ids: frozenset[str]
    why: str

    def machine_file(self, folder: Path) -> Path:
        """The machine file of the row, written to `folder` where it differs from an example."""
        path = ROOT / "examples" / "machines" / f"{self.machine}.toml"
        if not self.change:
            return path
        changed = folder / f"{self.machine}-{self.change}.toml"
        pattern, replacement = CHANGES[self.change]
        changed.write_text(re.sub(pattern, replacement, path.read_text("utf-8")), encoding="utf-8")
        return changed

    def options(self, folder: Path) -> list[str]:
        """Machine and profile for the command line."""
        profile = ["--profile", self.profile] if self.profile else []
        return ["--machine", str(self.machine_file(folder)), *profile]


def rows() -> list[Row]:
    """The table."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        return [Row(**{**row, "ids": frozenset(row["ids"].split())}) for row in csv.DictReader(file)]  # type: ignore[arg-type]


def _run(row: Row, path: Path, folder: Path) -> dict[str, Any]:
    command = [sys.executable, "-m", "cnc_front", "run", str(path), "--json", "-q", *row.options(folder)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    found: dict[str, Any] = json.loads(done.stdout)
    return found | {"code": done.returncode}


def page(folder: Path) -> Iterator[str]:
    """The page, line by line; runs every program."""
    ran = sum(not row.ids for row in rows())
    yield INTRODUCTION.format(programs=len(rows()), ran=ran, refused=len(rows()) - ran)
    with tempfile.TemporaryDirectory() as scratch:
        for row in rows():
            machine = row.machine + (f" + {row.change}" if row.change else "")
            run = _run(row, folder / row.file, Path(scratch))
            if row.ids:
                why = f"refused: {row.why} ({', '.join(sorted(row.ids))})"
                yield f"| {row.file} | {machine} | {row.profile or 'din'} | {why} | | | |"
                continue
            deviation = run["deviation"]
            set_point = max(0.0, deviation["setpoint"]["max_mm"] - run["merged"]["max_mm"])
            figures = f"{set_point:.1e} | {deviation['actual']['max_mm']:.4f} | {run['machine_time_s']:.0f} s"
            result = f"runs{'; ' + row.why if row.why else ''}" if run["code"] == 0 else f"exit {run['code']}"
            yield f"| {row.file} | {machine} | {row.profile or 'din'} | {result} | {figures} |"


if __name__ == "__main__":
    for line in page(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER):
        print(line)
