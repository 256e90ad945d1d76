"""Finds the claims `// shows: id, id` in Rust sources and ties each to the test that it stands above."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

SHOWS = re.compile(r"^\s*// shows:\s*(.*)$")
ATTRIBUTE = re.compile(r"^\s*(#\[|//)")
FUNCTION = re.compile(r"^\s*(?:pub\s+)?fn\s+(\w+)")
IDS = re.compile(r"[\w.+-]+")


@dataclass(frozen=True, slots=True)
class Claim:
    file: Path
    line: int  # of the comment, from 1
    function: str  # "" where no test follows
    ids: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


def claims_in(file: Path) -> Iterator[Claim]:
    """The claims of one source file. Several `// shows:` lines above one test add up."""
    ids: list[str] = []
    start, has_test = 0, False
    for number, text in enumerate([*file.read_text("utf-8").splitlines(), ""], 1):
        if match := SHOWS.match(text):
            start = start or number
            ids += IDS.findall(match.group(1))
        elif start and ATTRIBUTE.match(text):
            has_test = has_test or text.strip() == "#[test]"
        elif start:
            function = FUNCTION.match(text)
            yield Claim(file, start, function.group(1) if function and has_test else "", tuple(ids))
            ids, start, has_test = [], 0, False


def claims_under(root: Path, folders: list[str]) -> list[Claim]:
    files = (file for folder in folders for file in sorted((root / folder).rglob("*.rs")))
    return [claim for file in files for claim in claims_in(file)]
