"""The command line of `history`; what it does stands in cnc_front.history_command, which is loaded later."""

from __future__ import annotations

import argparse
import re
from datetime import UTC, datetime, timedelta
from typing import Any

VERDICTS = ("PASS", "WARN", "FAIL", "ERROR")
_AGO = re.compile(r"(\d{1,5})([mhdw])")
_UNITS = {"m": "minutes", "h": "hours", "d": "days", "w": "weeks"}


def _count(value: str) -> int:
    if not (value.isascii() and value.isdigit() and 0 < int(value) < 1_000_000):
        raise argparse.ArgumentTypeError(f"'{value}' is no number from 1 to 999999")
    return int(value)


def since(value: str) -> str:
    """A time as it stands in the file: `2026-03-04`, `2026-03-04T12:30` (local), or so long ago: `30m 5h 7d 2w`."""
    if found := _AGO.fullmatch(value):
        ago: dict[str, Any] = {_UNITS[found[2]]: int(found[1])}
        return _stored(datetime.now(UTC) - timedelta(**ago))
    try:
        return _stored(datetime.fromisoformat(value).astimezone(UTC))
    except (ValueError, OverflowError):
        raise argparse.ArgumentTypeError(f"'{value}' is neither a date (2026-03-04) nor a time ago (7d, 5h)") from None


def _stored(when: datetime) -> str:
    return when.strftime("%Y-%m-%dT%H:%M:%SZ")


def add(commands: Any, common: Any, keeping: Any) -> None:
    """Adds the command to the parser of cnc_front.cli. `keeping`: the option that names the file."""
    parser = commands.add_parser("history", parents=[common, keeping], help="runs and alarms of before")
    parser.add_argument("number", metavar="NUMBER", type=_count, nargs="?", help="show this run, whole")
    parser.add_argument("--job", metavar="TEXT", help="only where the path of the job contains this")
    parser.add_argument("--verdict", choices=VERDICTS, help="only runs with this verdict")
    parser.add_argument("--since", metavar="TIME", type=since, help="2026-03-04, 2026-03-04T12:30, or 7d, 5h, 30m ago")
    parser.add_argument("--limit", metavar="N", type=_count, default=20, help="the newest N (default 20)")
    parser.add_argument("--alarms", action="store_true", help="alarms instead of runs")
    parser.add_argument("--json", action="store_true", help="a line of JSON for each")
