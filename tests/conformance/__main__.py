"""Counts the rows of the catalogue that a passing test shows.

usage: python -m tests.conformance RUST.json PYTHON.json   (written by `make test`)
Exit code 1 on a claim that does not hold: an unknown id, or a test that failed, was skipped or did not run.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

from .catalogue import Row, read_catalogue
from .claims import Claim, claims_under

ROOT = Path(__file__).parents[2]
RUST_FOLDERS = ["motion_kernel", "gcode", "sympas", "toolpaths", "cnc_front"]


def module_of(claim: Claim, root: Path) -> str:
    """Module path that the file of a claim has below the root source file of its test binary."""
    parts = claim.file.relative_to(root.parent).with_suffix("").parts
    return "" if claim.file == root else "::".join(part for part in parts if part != "mod")


def results_of(claim: Claim, tests: list[dict[str, str]]) -> list[dict[str, str]]:
    """The results that belong to a claim: same binary and function; its module decides between namesakes."""
    named = [test for test in tests if test["name"].split("::")[-1] == claim.function]
    own = [test for test in named if Path(test["root"]) == claim.file]
    near = own or [test for test in named if Path(test["root"]).parent in claim.file.parents]
    if len(near) < 2:
        return near
    return [test for test in near if test["name"].startswith(module_of(claim, Path(test["root"])))]


def judge_rust(claims: list[Claim], tests: list[dict[str, str]]) -> tuple[set[str], list[str]]:
    """Rows that passing Rust tests show, and what is wrong with the others' claims."""
    shown: set[str] = set()
    wrong: list[str] = []
    for claim in claims:
        found = results_of(claim, tests)
        if not claim.function:
            wrong.append(f"{claim}: 'shows' is not directly above a #[test]")
        elif len(found) != 1:
            wrong.append(f"{claim}: {len(found)} tests named {claim.function} ran, one expected")
        elif found[0]["outcome"] != "passed":
            wrong.append(f"{claim}: {claim.function} {found[0]['outcome']}")
        else:
            shown |= set(claim.ids)
    return shown, wrong


def judge_python(results: dict[str, dict[str, object]]) -> tuple[set[str], list[str]]:
    """The same for Python tests."""
    shown: set[str] = set()
    wrong: list[str] = []
    for nodeid, result in results.items():
        ids = result["shows"]
        assert isinstance(ids, list)
        if ids and result["outcome"] != "passed":
            wrong.append(f"{nodeid}: {result['outcome']}, but claims {', '.join(ids)}")
        else:
            shown |= set(ids)
    return shown, wrong


def table(rows: dict[str, Row], shown: set[str]) -> list[str]:
    """One line per catalogue and area, then the total."""
    counted = [row for row in rows.values() if not row.note]
    total = Counter((row.catalogue, row.area) for row in counted)
    done = Counter((row.catalogue, row.area) for row in counted if row.id in shown)
    lines = []
    for catalogue in dict.fromkeys(row.catalogue for row in counted):
        areas = [key for key in total if key[0] == catalogue]
        lines.append(f"{catalogue}: {sum(done[key] for key in areas)} of {sum(total[key] for key in areas)}")
        lines += [f"  {key[1]:<20} {done[key]:4} of {total[key]:4}" for key in areas]
    return [*lines, f"conformance: {done.total()} of {total.total()} rows shown"]


def main(rust: str, python: str) -> int:
    rows = read_catalogue(Path(__file__).parent)
    by_rust, wrong = judge_rust(claims_under(ROOT, RUST_FOLDERS), json.loads(Path(rust).read_text("utf-8")))
    by_python, wrong_python = judge_python(json.loads(Path(python).read_text("utf-8")))
    shown = by_rust | by_python
    wrong += wrong_python
    wrong += [f"{row}: unknown row id" for row in sorted(shown - rows.keys())]
    print(*(f"error: {text}" for text in wrong), sep="\n", end="\n" if wrong else "", file=sys.stderr)
    print(*table(rows, shown), sep="\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
