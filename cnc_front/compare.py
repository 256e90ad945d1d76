"""`cnc-front compare RUN1 RUN2`: two runs of a job side by side, from their reports or recordings."""

from __future__ import annotations

import argparse
import base64
import csv
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from cnc_front import outputs
from cnc_front.errors import Exit, UsageError
from cnc_front.evidence import finding_text
from cnc_front.messages import language_from, text

SCHEMA = "cnc-front/compare/1"
REPORT_SCHEMA = "cnc-front/report/1"
#: Changes of a deviation (mm) and of a time (share) that are none; those of `compare` for batches.
DEVIATION_MM = 1e-4
TIME_SHARE = 1e-3
RANK = {"FAIL": 0, "WARN": 1, "PASS": 2}
#: Blocks that changed most.
BLOCKS = 20
LARGEST_BYTES = 256 << 20

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Side:
    """One run: the object of `run --json`, the rows of its blocks, a picture of its path (PNG)."""

    name: str
    result: dict[str, Any]
    blocks: list[Row]
    picture: bytes | None


def is_run(name: str) -> bool:
    """A recording, report.json or a folder of a report; else it is for the comparison of batches."""
    path = Path(name)
    return path.is_file() or (path / "report.json").is_file()


def compare_runs(options: argparse.Namespace) -> int:
    """Prints the changes; exit code 1 where the verdict or the deviation got worse or a finding is new."""
    named = (options.before, options.after)
    folder = outputs.check_report(options.out, named, "--out") if options.out else None
    before, after = (side(name) for name in named)
    language = language_from(options.lang)
    changes = compared(before, after, language)
    if folder is not None:
        _write(changes, before, after, folder, language)
    print(json.dumps(changes, allow_nan=False) if options.json else "\n".join(_lines(changes, language)))
    return Exit.CHECK_FAILED if changes["worse"] else Exit.DONE


def side(name: str) -> Side:
    """Reads one run; raises CompileError for what is no recording of ours, UsageError for what is no report."""
    path = Path(name)
    if path.is_file() and outputs.is_recording(path):
        return _recorded(name)
    file = path / "report.json" if path.is_dir() else path
    try:
        if file.stat().st_size > LARGEST_BYTES:
            raise ValueError("too large")
        figures = json.loads(file.read_text(encoding="utf-8"))
        if figures["schema"] != REPORT_SCHEMA:
            raise ValueError(f"schema {figures['schema']}")
        made = Side(name, figures["result"], _blocks(file.with_name("blocks.csv")), _picture(file.parent / "png"))
        compared(made, made, "en")  # what this needs is there
        return made
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        reason = f"there is no {error}" if isinstance(error, KeyError) else str(error)
        raise UsageError(f"{name} is neither a recording nor a report of cnc-front: {reason}") from None


def _blocks(path: Path) -> list[Row]:
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        try:
            return [
                {
                    "line": int(row["line"]),
                    "text": row["text"],
                    "max_um": float(row["max_um"]) if row["max_um"] else None,
                }
                for row in csv.DictReader(file)
            ]
        except (KeyError, ValueError, csv.Error):
            raise UsageError(f"{path} is not the table of blocks that a report of cnc-front has") from None


def _picture(folder: Path) -> bytes | None:
    found = sorted(folder.glob("path-??.png")) if folder.is_dir() else []
    return found[0].read_bytes() if found else None


def _recorded(name: str) -> Side:
    from cnc_front.deliver import measured_report
    from cnc_front.report.build import path_png
    from cnc_front.report.data import block_table

    report = measured_report(name)
    blocks = [{key: row[key] for key in ("line", "text", "max_um")} for row in block_table(report)]
    return Side(name, report.run, blocks, path_png(report))


#: Figures by name: where they are, scale and unit they are shown in, and whether less is better (0: neither).
FIGURES: tuple[tuple[str, tuple[str, ...], float, str, int], ...] = (
    ("deviation_max", ("deviation", "actual", "max_mm"), 1e3, "um", 1),
    ("deviation_rms", ("deviation", "actual", "rms_mm"), 1e3, "um", 1),
    ("deviation_p99", ("deviation", "actual", "p99_mm"), 1e3, "um", 1),
    ("setpoint_max", ("deviation", "setpoint", "max_mm"), 1e3, "um", 1),
    ("machine_time", ("machine_time_s",), 1.0, "s", 1),
    ("path_length", ("path_length_mm",), 1.0, "mm", 0),
    ("feed_reached", ("feed", "programmed_reached_pct"), 1.0, "%", -1),
    ("path_change", ("override", "path_change_mm"), 1e3, "um", 1),
    ("ratio_error", ("override", "velocity_ratio_error_pct"), 1.0, "%", 1),
)


def _at(value: Any, keys: Iterable[str]) -> Any:
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    return value


def compared(before: Side, after: Side, language: str) -> dict[str, Any]:
    """The object of `compare --json` for two runs."""
    figures = [
        _figure(name, _at(before.result, keys), _at(after.result, keys), scale, unit, better)
        for name, keys, scale, unit, better in FIGURES
    ]
    figures += _per_axis(before, after)
    words = [side.result["verdict"]["word"] for side in (before, after)]
    new, cured = changed_findings(before.result, after.result, language)
    deviation = [side.result["deviation"]["actual"]["max_mm"] for side in (before, after)]
    return {
        "schema": SCHEMA,
        "before": before.name,
        "after": after.name,
        "differs": _differs(before.result, after.result),
        "verdict": words,
        "figures": figures,
        "new": new,
        "cured": cured,
        "blocks": _changed_blocks(before.blocks, after.blocks),
        "worse": RANK[words[1]] < RANK[words[0]] or deviation[1] > deviation[0] + DEVIATION_MM or bool(new),
    }


def _figure(name: str, old: float | None, new: float | None, scale: float, unit: str, better: int) -> Row:
    before, after = (None if value is None else value * scale for value in (old, new))
    change = None if before is None or after is None else after - before
    small = change is None or abs(change) <= TIME_SHARE * abs(before or 0.0) + 1e-9
    trend = "same" if small or not better or change is None else "worse" if change * better > 0 else "better"
    return {"name": name, "unit": unit, "before": before, "after": after, "change": change, "trend": trend}


def _per_axis(before: Side, after: Side) -> list[Row]:
    sides = [side.result.get("following_error") or {} for side in (before, after)]
    return [
        _figure(f"following {axis}", _at(sides[0], (axis, "max")), _at(sides[1], (axis, "max")), 1.0, "", 1)
        for axis in dict.fromkeys([*sides[0], *sides[1]])
    ]


def _differs(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    """What was not the same for both runs."""
    places = {
        "job": ("job", "sha256"),
        "machine": ("machine", "sha256"),
        "schedule": ("override", "schedule"),
        "limit": ("verdict", "tolerance_mm"),
    }
    return [name for name, keys in places.items() if _at(old, keys) != _at(new, keys)]


def changed_findings(before: Row, after: Row, language: str) -> tuple[list[str], list[str]]:
    """Named findings, alarms and reasons of the verdict that only the second run has, and only the first."""
    old, new = (_told(result, language) for result in (before, after))
    return [new[key] for key in new if key not in old], [old[key] for key in old if key not in new]


def _told(result: dict[str, Any], language: str) -> dict[tuple[Any, ...], str]:
    told: dict[tuple[Any, ...], str] = {}
    for found in result.get("findings") or []:
        # a cause of an axis is the same wherever it is worst
        where = None if found["axes"] else found["line"]
        told[("finding", found["kind"], *found["axes"], where)] = finding_text(found, language)
    for reason in result["verdict"]["reasons"]:
        if reason["id"] not in ("named_findings", "warnings"):
            values = {key: value for key, value in reason.items() if key != "id"}
            told[("reason", reason["id"], reason.get("axis"), reason.get("name"))] = text(
                reason["id"], language, **values
            )
    return told


def _changed_blocks(old: Sequence[Row], new: Sequence[Row]) -> list[Row]:
    """The blocks whose largest deviation changed most; blocks are told apart by line and round."""
    known = _by_round(old)
    rows = [
        {"line": row["line"], "text": row["text"], "before_um": known[key]["max_um"], "after_um": row["max_um"]}
        for key, row in _by_round(new).items()
        if key in known and known[key]["max_um"] is not None and row["max_um"] is not None
    ]
    changed = [row | {"change_um": row["after_um"] - row["before_um"]} for row in rows]
    moved = [row for row in changed if abs(row["change_um"]) > DEVIATION_MM * 1e3]
    return sorted(moved, key=lambda row: -abs(row["change_um"]))[:BLOCKS]


def _by_round(rows: Sequence[Row]) -> dict[tuple[int, int], Row]:
    rounds: dict[int, int] = {}
    keyed = {}
    for row in rows:
        rounds[row["line"]] = rounds.get(row["line"], 0) + 1
        keyed[(row["line"], rounds[row["line"]])] = row
    return keyed


def _lines(changes: dict[str, Any], language: str) -> list[str]:
    from cnc_front.report.words_tune import WORDS

    words = WORDS[language]
    differs = ", ".join(words[name] for name in changes["differs"]) or words["none"]
    lines = [f"{changes['before']} -> {changes['after']}: {' -> '.join(changes['verdict'])}"]
    lines.append(f"  {words['differs']}: {differs}")
    for figure in changes["figures"]:
        if figure["before"] is None and figure["after"] is None:
            continue
        values = [_shown(figure[key]) for key in ("before", "after", "change")]
        trend = "" if figure["trend"] == "same" else words[figure["trend"]]
        name = figure_name(figure["name"], words)
        lines.append(
            f"  {name:<32} {values[0]:>12} {values[1]:>12} {values[2]:>12} {figure['unit']:<3} {trend}".rstrip()
        )
    for kind in ("new", "cured"):
        lines += [f"  {words[kind]}: {told}" for told in changes[kind]]
    if changes["blocks"]:
        lines.append(f"  {words['blocks']}:")
    for row in changes["blocks"][:5]:
        lines.append(f"    {row['line']:6}  {row['before_um']:8.2f} -> {row['after_um']:8.2f} um  {row['text']}")
    return lines


def figure_name(name: str, words: dict[str, str]) -> str:
    """Name of a figure in words; those of an axis end with it."""
    word, _, axis = name.partition(" ")
    return f"{words[word]} {axis}".strip()


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.4f}"


def _write(changes: dict[str, Any], before: Side, after: Side, folder: Path, language: str) -> None:
    from jinja2 import Environment, StrictUndefined

    from cnc_front.report.words_tune import WORDS

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    room = files("cnc_front.report")
    words = WORDS[language]
    pictures = [base64.b64encode(side.picture).decode() if side.picture else "" for side in (before, after)]
    html = environment.from_string((room / "compare.html.j2").read_text(encoding="utf-8")).render(
        mark=outputs.REPORT_MARK,
        css=(room / "report.css").read_text(encoding="utf-8"),
        words=words,
        language=language,
        changes=changes,
        sides=(before, after),
        pictures=pictures,
        names={figure["name"]: figure_name(figure["name"], words) for figure in changes["figures"]},
    )
    folder.mkdir(parents=True, exist_ok=True)
    (folder / outputs.REPORT_FILE).write_text(html, encoding="utf-8")
    (folder / "compare.json").write_text(json.dumps(changes, indent=1, allow_nan=False), encoding="utf-8")
