"""The rows of the manual that tests can show: conformance-*.csv beside this file (id, chapter, area, name, must)."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Row:
    id: str
    catalogue: str  # kernel, resources, sympas
    area: str
    note: bool  # a remark for the reader, not a behaviour: left out of every count


def read_catalogue(folder: Path) -> dict[str, Row]:
    """All rows by id. Raises ValueError on an id that occurs twice or an empty catalogue."""
    rows: dict[str, Row] = {}
    for file in sorted(folder.glob("conformance-*.csv")):
        with file.open(encoding="utf-8", newline="") as lines:
            for line in csv.DictReader(lines):
                row = Row(line["id"], file.stem.removeprefix("conformance-"), line["area"], "[note]" in line["must"])
                if rows.setdefault(row.id, row) is not row:
                    raise ValueError(f"{file.name}: id {row.id} occurs twice")
    if not rows:
        raise ValueError(f"no conformance-*.csv in {folder}")
    return rows
