"""The result of `batch` on stdout: a row a part, worst first, then counts and where the pages are."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from cnc_front.batch.store import Row
from cnc_front.errors import Exit
from cnc_front.messages import text

#: Widest column of names and of reasons; what is longer is cut in front or behind.
NAME, REASON = 40, 72


def table(rows: Sequence[Row], page: Path, language: str) -> str:
    """All of it as text. Deviations in um, times as h:mm:ss."""
    machines = len({row["machine_name"] for row in rows}) > 1
    names = [f"{row['part']} ({row['machine_name']})" if machines else str(row["part"]) for row in rows]
    head, *cells = text("batch_head", language).split("|"), *map(_cells, rows)
    width = min(NAME, max(map(len, [head[0], *names])))
    lines = [_line(head, width)]
    for name, row, cell in zip(names, rows, cells, strict=True):
        cut = name if len(name) <= width else "~" + name[1 - width :]
        lines.append(_line([cut, *cell], width))
        if row["code"] in (Exit.BAD_INPUT, Exit.STOPPED):
            lines.append(f"  {row['reason'][:REASON]}")
    found = Counter(_word(row) for row in rows)
    count = ", ".join(f"{found[word]} {word}" for word in ("ERROR", "FAIL", "WARN", "PASS") if found[word])
    lines.append(text("batch_foot", language, parts=len(rows), counts=count or "-", page=page))
    return "\n".join(lines)


def _word(row: Row) -> str:
    return "ERROR" if row["code"] == Exit.BAD_INPUT else row["verdict"]


def _cells(row: Row) -> list[str]:
    """What stands behind the name of a part."""
    run = json.loads(row["run"]) if row["run"] else {}
    actual = (run.get("deviation") or {}).get("actual") or {}
    um = [f"{actual[name] * 1e3:.1f}" if name in actual else "-" for name in ("max_mm", "p99_mm", "rms_mm")]
    seconds, alarms = row["machine_time_s"], row["alarms"]
    line = f"L{row['worst_line']}" if row["worst_line"] else "-"
    time = "-" if seconds is None else f"{int(seconds) // 3600}:{int(seconds) // 60 % 60:02d}:{int(seconds) % 60:02d}"
    return [_word(row), um[0], line, um[1], um[2], time, "-" if alarms is None else str(alarms)]


def _line(cells: Sequence[str], width: int) -> str:
    name, verdict, most, line, p99, rms, time, alarms = cells
    return f"{name:<{width}}  {verdict:<7} {most:>9}  {line:<8} {p99:>7} {rms:>7} {time:>9} {alarms:>7}"
