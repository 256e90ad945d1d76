"""The results of batches: one SQLite file, one row per task. Other tools read it with any SQLite client.

A row is written in one transaction: it is there whole or not at all. Several batches may write to one file.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cnc_front.batch.pool import HANGS, KILLED, Outcome

#: Columns beside the key: name, SQL type. Figures come from `run --json`; null where a run has none.
COLUMNS: dict[str, str] = {
    "part": "TEXT NOT NULL",
    "machine": "TEXT NOT NULL",
    "machine_name": "TEXT NOT NULL",
    "part_sha256": "TEXT NOT NULL",
    "verdict": "TEXT NOT NULL",
    "code": "INTEGER NOT NULL",
    "reason": "TEXT NOT NULL",
    "machine_time_s": "REAL",
    "path_length_mm": "REAL",
    "deviation_max_mm": "REAL",
    "deviation_p99_mm": "REAL",
    "worst_line": "INTEGER",
    "following_error_max": "REAL",
    "feed_reached_pct": "REAL",
    "commands": "INTEGER",
    "alarms": "INTEGER",
    "warnings": "INTEGER",
    "before_verdict": "TEXT",
    "before_deviation_mm": "REAL",
    "before_time_s": "REAL",
    "run": "TEXT",
    "stderr": "TEXT NOT NULL",
    "wall_s": "REAL NOT NULL",
}
#: Columns that differ between two runs of the same: times on the wall.
TIMES = frozenset({"wall_s"})
#: Rows that say nothing of their part (its worker was killed, or too slow): the next batch tries again.
UNSETTLED = f"reason IN ('{KILLED}', '{HANGS}')"
NAME = "results.sqlite"

Row = dict[str, Any]


class Store:
    """The table `results` of a folder."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._base = sqlite3.connect(folder / NAME, timeout=60.0, isolation_level=None)
        self._base.row_factory = sqlite3.Row
        self._base.execute("PRAGMA journal_mode=WAL")
        self._base.execute("PRAGMA synchronous=NORMAL")
        columns = ", ".join(f"{name} {kind}" for name, kind in COLUMNS.items())
        self._base.execute(f"CREATE TABLE IF NOT EXISTS results (key TEXT PRIMARY KEY, {columns}) WITHOUT ROWID")

    def close(self) -> None:
        """Writes what is pending and closes the file."""
        self._base.close()

    def known(self) -> set[str]:
        """Keys of the results that are there, without those that the next batch tries again."""
        return {row["key"] for row in self._base.execute(f"SELECT key FROM results WHERE NOT {UNSETTLED}")}

    def put(self, outcome: Outcome) -> Row:
        """Keeps a result; one that another batch has just written stays."""
        row = row_of(outcome)
        with self._transaction():
            # a changed part or machine file makes the result before it obsolete; its figures stay for the trend
            same = "SELECT * FROM results WHERE part = ? AND machine = ? AND key <> ?"
            before = self._base.execute(same, (row["part"], row["machine"], row["key"])).fetchone()
            if before is not None:
                row["before_verdict"] = before["verdict"]
                row["before_deviation_mm"] = before["deviation_max_mm"]
                row["before_time_s"] = before["machine_time_s"]
            self._base.execute(
                f"DELETE FROM results WHERE part = ? AND machine = ? AND (key <> ? OR {UNSETTLED})",
                (row["part"], row["machine"], row["key"]),
            )
            names = ", ".join(row)
            marks = ", ".join(f":{name}" for name in row)
            self._base.execute(f"INSERT OR IGNORE INTO results ({names}) VALUES ({marks})", row)
        return row

    def rows(self) -> list[Row]:
        """All results, worst first; equal ones by part and machine."""
        rows = [dict(row) for row in self._base.execute("SELECT * FROM results")]
        return sorted(rows, key=badness)

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._base.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            self._base.execute("ROLLBACK")
            raise
        self._base.execute("COMMIT")


def badness(row: Mapping[str, Any]) -> tuple[Any, ...]:
    """Worst first: failed by exit code, then by deviation."""
    order = {"FAIL": 0, "WARN": 1, "PASS": 2}
    return (order[row["verdict"]], -row["code"], -(row["deviation_max_mm"] or 0.0), row["part"], row["machine"])


def row_of(outcome: Outcome) -> Row:
    """The row of a task; without a result the reason says what happened."""
    task, run = outcome.task, outcome.run or {}
    actual = (run.get("deviation") or {}).get("actual") or {}
    verdict = run.get("verdict") or {}
    errors = [e["max"] for e in (run.get("following_error") or {}).values()]
    return {
        "key": task.key,
        "part": task.part.name,
        "machine": task.machine,
        "machine_name": task.machine_name,
        "part_sha256": task.part.sha256,
        "verdict": verdict.get("word", "FAIL"),
        "code": outcome.code,
        "reason": outcome.lost or _reason(run, outcome.stderr),
        "machine_time_s": run.get("machine_time_s"),
        "path_length_mm": run.get("path_length_mm"),
        "deviation_max_mm": actual.get("max_mm"),
        "deviation_p99_mm": actual.get("p99_mm"),
        "worst_line": (actual.get("worst") or {}).get("line"),
        "following_error_max": max(errors, default=None),
        "feed_reached_pct": (run.get("feed") or {}).get("programmed_reached_pct"),
        "commands": sum((run.get("commands") or {}).values()) if run.get("commands") is not None else None,
        "alarms": len(run["alarms"]) if run.get("alarms") is not None else None,
        "warnings": len(run.get("diagnostics") or ()),
        "before_verdict": None,
        "before_deviation_mm": None,
        "before_time_s": None,
        "run": json.dumps(_without_times(run), sort_keys=True) if run else None,
        "stderr": outcome.stderr,
        "wall_s": outcome.wall_s,
    }


def _without_times(run: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in run.items() if name != "wall_time_s"}


def _reason(run: dict[str, Any], stderr: str) -> str:
    error = run.get("error")
    if error:
        line = f" (line {error['line']})" if error.get("line") else ""
        return f"{error['id']}: {error['message']}{line}"
    reasons = (run.get("verdict") or {}).get("reasons") or []
    if reasons:
        return ", ".join(dict.fromkeys(str(reason["id"]) for reason in reasons))
    return "" if run else stderr.strip().splitlines()[-1][:200] if stderr.strip() else "no result"
