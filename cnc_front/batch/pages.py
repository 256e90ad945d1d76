"""What people and CI read of a batch: index.html, junit.xml and summary.md. Each is replaced whole."""

from __future__ import annotations

import os
import tempfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from cnc_front.batch.store import Row

TEMPLATE = Path(__file__).with_name("index.html.j2")
#: Rows of the summary.
MOST = 20


def write_pages(folder: Path, rows: Sequence[Row], reports: dict[str, str]) -> None:
    """Writes all pages for the results, worst first. `reports`: folder of the report of a result, by its key."""
    _replace(folder / "index.html", index_html(rows, reports))
    _replace(folder / "junit.xml", junit_xml(rows))
    _replace(folder / "summary.md", summary_md(rows))


def _replace(path: Path, text: str) -> None:
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name)
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(text)
    Path(name).replace(path)


def counts(rows: Sequence[Row]) -> dict[str, int]:
    """How many of each verdict."""
    found = Counter(row["verdict"] for row in rows)
    return {word: found[word] for word in ("FAIL", "WARN", "PASS")}


def index_html(rows: Sequence[Row], reports: dict[str, str]) -> str:
    """The page to begin with: every result, worst first, to be sorted and filtered."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(TEMPLATE.read_text("utf-8"))
    return template.render(rows=rows, reports=reports, counts=counts(rows), um=_um, seconds=_seconds, trend=_trend)


def _um(mm: float | None) -> str:
    return "" if mm is None else f"{mm * 1e3:.2f}"


def _seconds(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.2f}"


def _trend(row: Row) -> str:
    """Against the result before, when the part or the machine file was another: verdict, deviation, time."""
    if row["before_verdict"] is None:
        return ""
    words = [] if row["before_verdict"] == row["verdict"] else [f"was {row['before_verdict']}"]
    if row["before_deviation_mm"] is not None and row["deviation_max_mm"] is not None:
        words.append(f"{(row['deviation_max_mm'] - row['before_deviation_mm']) * 1e3:+.2f} um")
    if row["before_time_s"] and row["machine_time_s"] is not None:
        words.append(f"{(row['machine_time_s'] / row['before_time_s'] - 1) * 100:+.1f} % time")
    return ", ".join(words)


def junit_xml(rows: Sequence[Row]) -> str:
    """JUnit: a suite a machine, a case a part."""
    root = ElementTree.Element("testsuites", name="cnc-front batch", tests=str(len(rows)))
    for machine in dict.fromkeys(row["machine"] for row in rows):
        cases = [row for row in rows if row["machine"] == machine]
        failed = sum(row["verdict"] == "FAIL" for row in cases)
        suite = ElementTree.SubElement(
            root, "testsuite", name=cases[0]["machine_name"], tests=str(len(cases)), failures=str(failed)
        )
        for row in cases:
            time = f"{row['wall_s']:.3f}"
            case = ElementTree.SubElement(suite, "testcase", classname=row["machine_name"], name=row["part"], time=time)
            if row["verdict"] == "FAIL":
                failure = ElementTree.SubElement(case, "failure", message=_plain(row["reason"]))
                failure.text = _plain(row["stderr"])
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _plain(text: str) -> str:
    """Without what XML cannot hold."""
    return "".join(c if c in "\t\n" or " " <= c <= "\ud7ff" or "\ue000" <= c <= "\ufffd" else "?" for c in text)


def summary_md(rows: Sequence[Row]) -> str:
    """A summary as GitHub shows it beside a run."""
    found = counts(rows)
    lines = ["# Dry-runs", "", ", ".join(f"{count} {word}" for word, count in found.items()), ""]
    worst = [row for row in rows if row["verdict"] != "PASS"][:MOST]
    if worst:
        lines += ["| part | machine | verdict | deviation um | reason |", "|---|---|---|---|---|"]
        lines += [
            "| {part} | {machine_name} | {verdict} | {um} | {reason} |".format(
                **{name: _cell(row[name]) for name in ("part", "machine_name", "verdict", "reason")},
                um=_um(row["deviation_max_mm"]),
            )
            for row in worst
        ]
    return "\n".join(lines) + "\n"


def _cell(value: Any) -> str:
    return str(value).replace("|", "\\|").replace("\n", " ")
