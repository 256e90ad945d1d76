"""Diagnostics in German: one table (german.tsv) beside the English catalogue of the compilers.

A finding is translated where it is printed, by the template that its English message was made from; what the table does
not know stays English, so a message is never lost. Ids of the table without an English text are those of the native
catalogue; `hint` and `word` rows are remedies and words that stand inside messages.
"""

from __future__ import annotations

import csv
import re
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path

from cnc_front._native import gcode as native_gcode
from cnc_front.diagnostics import Diagnostic

TABLE = Path(__file__).with_name("german.tsv")
PLACEHOLDER = re.compile(r"\{[^}]*\}")

#: English template as a pattern, German template, German hint.
Row = tuple[re.Pattern[str], str, str]


def _pattern(template: str) -> re.Pattern[str]:
    parts = [re.escape(part) for part in PLACEHOLDER.split(template)]
    return re.compile("(.*?)".join(parts), re.DOTALL)


@cache
def table() -> dict[str, list[Row]]:
    """Templates by id, in the order of the file."""
    english = {id: message for id, message, _ in native_gcode.catalogue()}
    rows: dict[str, list[Row]] = defaultdict(list)
    with TABLE.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE):
            template = row["english"] or english.get(row["id"], "")
            rows[row["id"]].append((_pattern(template), row["german"], row["hint"]))
    return rows


def _translated(kind: str, text: str) -> tuple[str, str] | None:
    """Text and hint by the first row of that id that fits."""
    for pattern, german, hint in table().get(kind, []):
        if found := pattern.fullmatch(text):
            values = iter([_word(value) for value in found.groups()])
            return PLACEHOLDER.sub(lambda _, v=values: next(v, ""), german), hint  # type: ignore[misc]
    return None


@cache
def _words() -> dict[str, str]:
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)
        return {row["english"]: row["german"] for row in rows if row["id"] == "word"}


def _word(text: str) -> str:
    known = _words().get(text)
    if known is None and text.endswith(")") and " (" in text:  # a value with a remark behind it
        value, remark = text.split(" (", 1)
        return value + _words().get(f" ({remark}", f" ({remark}")
    return text if known is None else known


def german(diagnostic: Diagnostic) -> Diagnostic:
    """The finding in German, or as it is where the table does not know it."""
    found = _translated(diagnostic.id, diagnostic.message)
    if found is None:
        return diagnostic
    message, hint = found
    if diagnostic.hint and not hint:
        hint = (_translated("hint", diagnostic.hint) or (diagnostic.hint, ""))[0]
    return replace(diagnostic, message=message, hint=hint if diagnostic.hint else "")


def refusal(error: Exception, language: str) -> str:
    """What a wrong request is told, in that language where the table knows it (rows `usage`)."""
    found = _translated("usage", str(error)) if language == "de" else None
    return str(error) if found is None else found[0]


def in_language(diagnostic: Diagnostic, language: str) -> str:
    """The finding as people read it, in "en" or "de"."""
    if language != "de":
        return str(diagnostic)
    return str(german(diagnostic)).replace("\n  hint: ", "\n  Hinweis: ", 1)


def localized(diagnostics: Iterable[Diagnostic], language: str) -> tuple[Diagnostic, ...]:
    """Findings whose message and hint are in that language."""
    return tuple(german(d) if language == "de" else d for d in diagnostics)


def one_line(finding: str, language: str) -> str:
    """A finding that is one line of text, "12:3: GW908: duplicate N10", as Job.warnings has them."""
    place, id, message = finding.split(": ", 2) if finding.count(": ") > 1 else (finding, "", "")
    found = _translated(id, message) if language == "de" else None
    return finding if found is None else f"{place}: {id}: {found[0]}"
