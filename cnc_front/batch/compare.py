"""`cnc-front compare OUT1 OUT2`: what changed from one batch to the next, and why."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cnc_front.batch.store import NAME, Row, Store
from cnc_front.errors import Exit, UsageError

#: Changes smaller than these are none.
DEVIATION_MM = 1e-4
TIME_SHARE = 1e-3
ORDER = ("new", "gone", "broken", "cured", "worse", "better", "slower", "faster", "same")
RANK = {"FAIL": 0, "WARN": 1, "PASS": 2}


def compare(options: argparse.Namespace) -> int:
    """Prints the changes; exit code 1 where something broke or got worse."""
    before, after = (_rows(folder) for folder in (options.before, options.after))
    changes = changed(before, after)
    if options.json:
        print(json.dumps(changes))
    else:
        print("\n".join(_lines(changes)))
    return Exit.CHECK_FAILED if any(c["change"] in ("broken", "worse") for c in changes) else Exit.DONE


def _rows(folder: str) -> list[Row]:
    if not (Path(folder) / NAME).is_file():
        raise UsageError(f"{folder} is no folder of a batch: there is no {NAME}")
    store = Store(Path(folder))
    try:
        return store.rows()
    finally:
        store.close()


def changed(before: Sequence[Row], after: Sequence[Row]) -> list[dict[str, Any]]:
    """One entry a part and machine of either batch: change, figures before and after, reason; the gravest first."""
    old = {(row["part"], row["machine"]): row for row in before}
    new = {(row["part"], row["machine"]): row for row in after}
    entries = [_entry(old.get(key), new.get(key)) for key in sorted(old.keys() | new.keys())]
    return sorted(entries, key=lambda e: (ORDER.index(e["change"]), e["part"], e["machine"]))


def _entry(old: Row | None, new: Row | None) -> dict[str, Any]:
    row = new or old
    assert row is not None
    entry: dict[str, Any] = {"part": row["part"], "machine": row["machine"], "change": _change(old, new)}
    for name in ("verdict", "deviation_max_mm", "machine_time_s", "reason"):
        entry[name] = [old[name] if old else None, new[name] if new else None]
    entry["why"] = _why(old, new)
    return entry


def _change(old: Row | None, new: Row | None) -> str:
    if old is None or new is None:
        return "new" if old is None else "gone"
    if RANK[old["verdict"]] != RANK[new["verdict"]]:
        return "broken" if RANK[new["verdict"]] < RANK[old["verdict"]] else "cured"
    deviations = [row["deviation_max_mm"] for row in (old, new)]
    if None not in deviations and abs(deviations[1] - deviations[0]) > DEVIATION_MM:
        return "worse" if deviations[1] > deviations[0] else "better"
    times = [row["machine_time_s"] for row in (old, new)]
    if None not in times and abs(times[1] - times[0]) > TIME_SHARE * times[0]:
        return "slower" if times[1] > times[0] else "faster"
    return "same"


def _why(old: Row | None, new: Row | None) -> str:
    """What differs between the two runs: text of the part, or else machine file, options or version."""
    if old is None or new is None or old["key"] == new["key"]:
        return ""
    if old["part_sha256"] != new["part_sha256"]:
        return "the part changed"
    return "machine file, options or version changed"


def _lines(changes: Sequence[dict[str, Any]]) -> list[str]:
    lines = []
    for change in changes:
        if change["change"] == "same":
            continue
        (old_um, new_um), (old_s, new_s) = (
            [_figure(v, scale) for v in change[name]]
            for name, scale in (("deviation_max_mm", 1e3), ("machine_time_s", 1.0))
        )
        reason = f" {change['reason'][1]}" if change["reason"][1] else ""
        why = f" ({change['why']})" if change["why"] else ""
        lines.append(
            f"{change['change']:<7} {change['part']} on {change['machine'] or 'mill3'}: {old_um} -> {new_um} um, "
            f"{old_s} -> {new_s} s{reason}{why}"
        )
    same = sum(change["change"] == "same" for change in changes)
    return [*lines, f"{same} of {len(changes)} are the same"]


def _figure(value: float | None, scale: float) -> str:
    return "-" if value is None else f"{value * scale:.2f}"
