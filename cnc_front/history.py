"""What ran here before: one SQLite file with runs and alarms, for `cnc-front history` and the terminal.

Every call opens the file, does one transaction and closes it, so any number of processes share it. Whatever is wrong
with the file is a HistoryError (CF501 to CF503): a run goes on without its history.
"""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from cnc_front.alarms import alarm_text
from cnc_front.messages import text

#: Version of the schema, in `user_version` of the file.
VERSION = 1
#: Runs kept; the oldest go first. Alarms are small: ten times as many.
MOST_RUNS = 10_000
MOST_ALARMS = 100_000
#: How long a process waits for another one that writes, s.
WAIT_S = 5.0
#: Lines of program output and diagnostics kept with a run.
MOST_LINES = 20
#: A name of no file: no history.
OFF = "off"

SCHEMA = """
CREATE TABLE runs (
  id INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL, source TEXT NOT NULL, job TEXT NOT NULL, name TEXT NOT NULL,
  language TEXT, sha256 TEXT, machine TEXT, verdict TEXT NOT NULL, code INTEGER NOT NULL, status TEXT,
  machine_time_s REAL, deviation_max_mm REAL, deviation_rms_mm REAL, tolerance_mm REAL, worst_line INTEGER,
  alarms INTEGER NOT NULL, warnings INTEGER NOT NULL, reason TEXT NOT NULL, report TEXT, recording TEXT,
  run TEXT NOT NULL);
CREATE INDEX runs_job ON runs (job);
CREATE TABLE alarms (
  id INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL, source TEXT NOT NULL, job TEXT NOT NULL, t_s REAL NOT NULL,
  code TEXT NOT NULL, axis TEXT NOT NULL, bit INTEGER NOT NULL, name TEXT NOT NULL, line INTEGER NOT NULL,
  block TEXT NOT NULL, acknowledged TEXT);
"""

Row = dict[str, Any]


class HistoryError(Exception):
    """The file cannot be used. `id` and `values` are those of cnc_front.messages."""

    def __init__(self, id: str, path: Path, **values: object) -> None:
        self.id, self.values = id, {"path": str(path), **values}
        super().__init__(text(id, "en", **self.values))

    def in_language(self, language: str) -> str:
        """One line for people."""
        return text(self.id, language, **self.values)


@dataclass(frozen=True, slots=True)
class Filter:
    """Which rows are wanted. `job`: part of its path; `since`: UTC, ISO 8601."""

    job: str | None = None
    verdict: str | None = None
    since: str | None = None
    limit: int = 20


def place(asked: str | None, environment: Mapping[str, str] | None = None) -> Path | None:
    """The file: as asked, else CNC_FRONT_HISTORY, else in the state directory of the user (XDG). None: no history."""
    env = os.environ if environment is None else environment
    name = asked if asked is not None else env.get("CNC_FRONT_HISTORY")
    if name is not None:
        return None if name in ("", OFF) else Path(name).expanduser()
    state = env.get("XDG_STATE_HOME", "")
    # the standard: a path that is not absolute is to be ignored
    folder = Path(state) if state.startswith("/") else Path(env.get("HOME", "~")).expanduser() / ".local" / "state"
    return folder / "cnc-front" / "history.sqlite"


class History:
    """The file at a path; it is made when something is first written."""

    def __init__(self, path: Path) -> None:
        self.path = path

    # ---- writing

    def add_run(self, run: Row, job: str, source: str, code: int, *, alarms: bool = True) -> int:
        """Keeps a run object of `run --json`; its alarms too, unless they were written as they came. Its number."""
        row = run_row(run, job, source, code)
        with self._opened(write=True) as base:
            number = _insert(base, "runs", row)
            for alarm in (run.get("alarms") or ()) if alarms else ():
                _insert(base, "alarms", alarm_row(alarm, job, source))
            base.execute("DELETE FROM runs WHERE id <= ?", (number - MOST_RUNS,))
        return number

    def add_alarm(self, alarm: Row, job: str, source: str) -> int:
        """Keeps one alarm (`t_s`, `axis`, `bit`, `name`, `line` and perhaps `block`). Its number."""
        with self._opened(write=True) as base:
            number = _insert(base, "alarms", alarm_row(alarm, job, source))
            base.execute("DELETE FROM alarms WHERE id <= ?", (number - MOST_ALARMS,))
        return number

    def acknowledge(self, number: int) -> None:
        """The operator has seen an alarm whose cause is gone."""
        with self._opened(write=True) as base:
            base.execute("UPDATE alarms SET acknowledged = ? WHERE id = ?", (_now(), number))

    # ---- reading

    def runs(self, wanted: Filter) -> list[Row]:
        """Runs, newest first, without their run objects."""
        return self._select("runs", wanted, "verdict = ?", wanted.verdict)

    def alarms(self, wanted: Filter) -> list[Row]:
        """Alarms, newest first."""
        return self._select("alarms", wanted, "", None)

    def run(self, number: int) -> Row | None:
        """One run; `run` is the run object."""
        with self._opened(write=False) as base:
            found = base.execute("SELECT * FROM runs WHERE id = ?", (number,)).fetchone() if base else None
            return None if found is None else dict(found) | {"run": json.loads(found["run"])}

    def recent_jobs(self, limit: int) -> list[Row]:
        """The newest run of each job, newest first."""
        with self._opened(write=False) as base:
            newest = "SELECT * FROM runs WHERE id IN (SELECT max(id) FROM runs GROUP BY job) ORDER BY id DESC LIMIT ?"
            return [_without_run(row) for row in base.execute(newest, (limit,))] if base else []

    def _select(self, table: str, wanted: Filter, more: str, value: str | None) -> list[Row]:
        tests = [("instr(job, ?) > 0", wanted.job), ("at >= ?", wanted.since), (more, value)]
        used = [(test, value) for test, value in tests if value is not None]
        where = f"WHERE {' AND '.join(test for test, _ in used)}" if used else ""
        with self._opened(write=False) as base:
            if base is None:
                return []
            rows = base.execute(
                f"SELECT * FROM {table} {where} ORDER BY id DESC LIMIT ?", (*(v for _, v in used), wanted.limit)
            )
            return [_without_run(row) for row in rows]

    @contextmanager
    def _opened(self, *, write: bool) -> Iterator[Any]:
        """A connection within one transaction; None where nothing was ever written and nothing is to be."""
        try:
            if not write and not self.path.exists():
                yield None
                return
            self.path.parent.mkdir(parents=True, exist_ok=True)
            base = sqlite3.connect(self.path, timeout=WAIT_S, isolation_level=None)
            try:
                base.row_factory = sqlite3.Row
                base.execute("BEGIN IMMEDIATE" if write else "BEGIN")
                _prepare(base, self.path, write=write)
                yield base
                base.execute("COMMIT")
            finally:
                base.close()  # what is not committed is rolled back
        except sqlite3.OperationalError as error:
            raise HistoryError("history_unusable", self.path, reason=error) from None
        except (sqlite3.DatabaseError, json.JSONDecodeError) as error:
            raise HistoryError("history_damaged", self.path, reason=error) from None
        except OSError as error:
            raise HistoryError("history_unusable", self.path, reason=error.strerror or error) from None


def _prepare(base: sqlite3.Connection, path: Path, *, write: bool) -> None:
    """Makes the tables in a new file. A file of another program or of a later version is left alone."""
    version: int = base.execute("PRAGMA user_version").fetchone()[0]
    if version > VERSION:
        raise HistoryError("history_newer", path, version=version, known=VERSION)
    if version == VERSION:
        return
    if base.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] or not write:
        raise HistoryError("history_damaged", path, reason="not a history of cnc-front")
    for statement in SCHEMA.split(";"):
        base.execute(statement)
    base.execute(f"PRAGMA user_version = {VERSION}")


def _insert(base: sqlite3.Connection, table: str, row: Row) -> int:
    names = ", ".join(row)
    marks = ", ".join(f":{name}" for name in row)
    number = base.execute(f"INSERT INTO {table} ({names}) VALUES ({marks})", row).lastrowid
    return number or 0


def _without_run(row: sqlite3.Row) -> Row:
    return {name: row[name] for name in row.keys() if name != "run"}  # noqa: SIM118  a Row iterates its values


def _now() -> str:
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def run_row(run: Row, job: str, source: str, code: int) -> Row:
    """The columns of a run object. A long list of findings is cut, so that the file stays small."""
    actual = (run.get("deviation") or {}).get("actual") or {}
    verdict = run.get("verdict") or {}
    findings, output = run.get("diagnostics") or [], run.get("output") or []
    kept = run | {"diagnostics": findings[:MOST_LINES], "output": output[-MOST_LINES:]}
    if "tasks" in run:
        kept["tasks"] = [task | {"output": task["output"][-MOST_LINES:]} for task in run["tasks"]]
    files = run.get("files") or {}
    error = run.get("error") or {}
    return {
        "at": _now(),
        "source": source,
        "job": str(Path(job).absolute()),
        "name": Path(job).name,
        "language": (run.get("job") or {}).get("language"),
        "sha256": (run.get("job") or {}).get("sha256"),
        "machine": (run.get("machine") or {}).get("name"),
        "verdict": verdict.get("word") or ("PASS" if code == 0 else "ERROR"),
        "code": code,
        "status": run.get("status"),
        "machine_time_s": run.get("machine_time_s"),
        "deviation_max_mm": actual.get("max_mm"),
        "deviation_rms_mm": actual.get("rms_mm"),
        "tolerance_mm": verdict.get("tolerance_mm"),
        "worst_line": (actual.get("worst") or {}).get("line"),
        "alarms": len(run.get("alarms") or ()),
        "warnings": sum(_is_warning(finding) for finding in findings),
        "reason": error.get("message") or ", ".join(dict.fromkeys(r["id"] for r in verdict.get("reasons") or ())),
        "report": _absolute(files.get("report")),
        "recording": _absolute(files.get("recording")),
        "run": json.dumps(kept, allow_nan=False),
    }


def _is_warning(finding: Row) -> bool:
    return str(finding.get("id", "")).startswith(("GW", "MW", "SW"))


def _absolute(path: str | None) -> str | None:
    return str(Path(path).absolute()) if path else None


def alarm_row(alarm: Row, job: str, source: str) -> Row:
    """The columns of an alarm; texts are made when it is shown, in the language of the reader."""
    code, _ = alarm_text(alarm["name"], alarm["bit"], alarm["axis"], "en")
    facts = {name: alarm[name] for name in ("t_s", "axis", "bit", "name", "line")}
    where = {"at": _now(), "source": source, "job": str(Path(job).absolute()) if job else ""}
    return where | facts | {"code": code, "block": alarm.get("block", ""), "acknowledged": None}
