"""Reading one table of a TOML file: every value is asked for once with its bounds; what nobody asked for is an error.

The counterpart of the machine file's reader for files that only Python reads. Positions come from the same TOML parser.
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from cnc_front._native import files as native_files
from cnc_front.diagnostics import Diagnostic

#: Ids of findings, each with the remedy that is shown where no better hint exists.
IDS = {
    "SU101": "save the file as UTF-8",
    "SU102": "mend the TOML syntax here",
    "SU103": "remove the key or correct its spelling",
    "SU104": "add the key",
    "SU105": "give a value of the other type",
    "SU106": "give a value inside the range",
    "SU107": "use one of the words listed",
    "SU108": "take another number or name",
    "SU109": "give a closed STL, PLY or 3MF mesh in millimetres",
    "SU110": "correct one of the two",
    "SU111": "give a coarser resolution or a smaller blank",
}
MOST_FINDINGS = 100
MOST_TABLES = 1000
Path = tuple[str, ...]


@dataclass(slots=True)
class Findings:
    """Collects what is wrong with one text."""

    file: str
    text: str
    found: list[Diagnostic] = field(default_factory=list)
    _places: dict[Path, tuple[int, int]] = field(default_factory=dict)

    def add(self, path: Path, id: str, message: str, hint: str = "") -> None:
        """A finding at the value of that path, or at the nearest table above it."""
        place = next((self._places[path[:n]] for n in range(len(path), 0, -1) if path[:n] in self._places), (0, 0))
        self.at(place, id, message, hint)

    def at(self, place: tuple[int, int], id: str, message: str, hint: str = "") -> None:
        """A finding at bytes of the text."""
        if len(self.found) >= MOST_FINDINGS:
            return
        data = self.text.encode()
        before = data[: place[0]].decode("utf-8", "ignore")
        line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
        inside = data[place[0] : place[1]].decode("utf-8", "ignore").split("\n", maxsplit=1)[0]
        message = message if len(message) <= 200 else message[:200] + "..."
        end = column + max(len(inside), 1) - 1
        self.found.append(Diagnostic(self.file, line, column, end, id, message, hint or IDS[id]))

    def sorted(self) -> list[Diagnostic]:
        """In the order of the file."""
        return sorted(self.found, key=lambda d: (d.line, d.column))


def read_toml(data: bytes, file: str) -> tuple[dict[str, Any] | None, Findings]:
    """The values of a TOML text (None where it has no sense), and the findings so far."""
    try:
        text = data.decode("utf-8")
        binary = "\0" in text
    except UnicodeDecodeError:
        text, binary = "", True
    findings = Findings(file, text)
    if binary:
        findings.at((0, 0), "SU101", "the file is no UTF-8 text")
        return None, findings
    for path, kind, said, start, end in native_files.toml_values(text):
        if kind == "error":
            findings.at((start, end), "SU102", said)
        else:
            findings._places.setdefault(tuple(path), (start, end))
    if findings.found:
        return None, findings
    try:
        return tomllib.loads(text), findings
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        findings.at((0, 0), "SU102", str(error))
        return None, findings


class Section:
    """One table. Getters return a sound value even where they add a finding, so that all findings are found."""

    def __init__(self, table: dict[str, Any], path: Path, findings: Findings) -> None:
        self.table, self.path, self.findings = table, path, findings
        self._asked: list[str] = []

    def name(self, key: str) -> str:
        """The key as people write it: tool[2].diameter."""
        text = ""
        for part in (*self.path, key):
            text += f"[{int(part) + 1}]" if part.isdigit() else f".{part}" if text else part
        return text

    def fault(self, key: str, id: str, message: str, hint: str = "") -> None:
        """A finding at the value of a key."""
        self.findings.add((*self.path, key), id, f"{self.name(key)}: {message}", hint)

    def has(self, key: str) -> bool:
        """The key is there."""
        return key in self.table

    def _get(self, key: str, *, required: bool) -> Any:
        self._asked.append(key)
        if required and key not in self.table:
            self.findings.add(self.path, "SU104", f"{self.name(key)} is missing")
        return self.table.get(key)

    def number(self, key: str, low: float, high: float, default: float | None = None) -> float:
        """A number in mm within bounds (both included); without a default it is required."""
        value = self._get(key, required=default is None)
        standard = low if default is None else default
        if value is None:
            return standard
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.fault(key, "SU105", f"a number expected, {_kind(value)} given")
            return standard
        if not low <= value <= high:
            self.fault(key, "SU106", f"{value:g} is outside {low:g} .. {high:g}")
            return standard
        return float(value)

    def whole(self, key: str, low: int, high: int, default: int | None = None) -> int:
        """A whole number within bounds."""
        value = self._get(key, required=default is None)
        standard = low if default is None else default
        if value is None:
            return standard
        if isinstance(value, bool) or not isinstance(value, int):
            self.fault(key, "SU105", f"a whole number expected, {_kind(value)} given")
            return standard
        if not low <= value <= high:
            self.fault(key, "SU106", f"{value} is outside {low} .. {high}")
            return standard
        return value

    def word(self, key: str, words: Sequence[str], default: str | None = None) -> str:
        """One of some words."""
        value = self._get(key, required=default is None)
        standard = words[0] if default is None else default
        if value is None:
            return standard
        if value not in words:
            self.fault(key, "SU107", f"{str(value)[:40]!r} is none of {', '.join(words)}")
            return standard
        return str(value)

    def text(self, key: str, default: str | None = None) -> str:
        """A text that is not empty."""
        value = self._get(key, required=default is None)
        if value is None:
            return default or ""
        if not isinstance(value, str) or not value.strip() or "\0" in value:
            self.fault(key, "SU105", f"a text expected, {_kind(value)} given")
            return default or ""
        return value

    def point(self, key: str, default: tuple[float, float, float] | None = None) -> tuple[float, float, float]:
        """X, Y and Z in mm."""
        value = self._get(key, required=default is None)
        standard = (0.0, 0.0, 0.0) if default is None else default
        if value is None:
            return standard
        numbers = (
            [v for v in value if isinstance(v, int | float) and not isinstance(v, bool)] if _is_list(value) else []
        )
        if not _is_list(value) or len(value) != 3 or len(numbers) != 3:
            self.fault(key, "SU105", "three numbers [X, Y, Z] expected")
            return standard
        if not all(-1e5 <= v <= 1e5 for v in numbers):
            self.fault(key, "SU106", "a coordinate is outside -1e5 .. 1e5 mm")
            return standard
        return float(numbers[0]), float(numbers[1]), float(numbers[2])

    def child(self, key: str) -> Section | None:
        """A table, None without it."""
        value = self._get(key, required=False)
        if value is None:
            return None
        if not isinstance(value, dict):
            self.fault(key, "SU105", f"a table expected, {_kind(value)} given")
            return None
        return Section(value, (*self.path, key), self.findings)

    def children(self, key: str) -> list[Section]:
        """A list of tables."""
        value = self._get(key, required=False)
        if value is None:
            return []
        if not _is_list(value) or not all(isinstance(item, dict) for item in value):
            self.fault(key, "SU105", "a list of tables expected")
            return []
        if len(value) > MOST_TABLES:
            self.fault(key, "SU106", f"more than {MOST_TABLES} tables")
            return []
        return [Section(item, (*self.path, key, str(k)), self.findings) for k, item in enumerate(value)]

    def finish(self) -> None:
        """What nobody asked for is an error."""
        for key in self.table:
            if key not in self._asked:
                near = difflib.get_close_matches(key, self._asked, 1)
                hint = f"did you mean {near[0]}?" if near else f"known here: {', '.join(self._asked)}"
                self.fault(key, "SU103", "unknown key", hint)


def _is_list(value: Any) -> bool:
    return isinstance(value, list)


def _kind(value: Any) -> str:
    names = {bool: "a flag", str: "a text", list: "a list", dict: "a table", int: "a number", float: "a number"}
    return names.get(type(value), "something else")
