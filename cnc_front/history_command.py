"""`cnc-front history`: what ran here before, and the alarms of it."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from cnc_front.alarms import alarm_text
from cnc_front.errors import Exit, UsageError
from cnc_front.history import Filter, History, HistoryError, Row, place
from cnc_front.messages import language_from, text


def keep_run(run: Row, options: argparse.Namespace, code: int) -> None:
    """Puts the result of `cnc-front run` into the history; one that cannot be written is told and changes nothing."""
    path = place(options.history)
    if path is None:
        return
    try:
        History(path).add_run(run, options.job, "run", code)
    except HistoryError as error:
        print(f"cnc-front: {error.in_language(language_from(options.lang))}", file=sys.stderr)


def history(options: argparse.Namespace) -> int:
    """Lists, or shows one. A history that cannot be read is exit code 3, an unknown number 2."""
    language = language_from(options.lang)
    path = place(options.history)
    if path is None:
        raise UsageError("there is no history: it is switched off (--history, CNC_FRONT_HISTORY)")
    if options.alarms and options.verdict:
        raise UsageError("--verdict is for runs, not for --alarms")
    store, wanted = History(path), Filter(options.job, options.verdict, options.since, options.limit)
    try:
        if options.number is not None:
            return _show(store, options.number, options.json, language)
        rows = store.alarms(wanted) if options.alarms else store.runs(wanted)
    except HistoryError as error:
        print(f"cnc-front: {error.in_language(language)}", file=sys.stderr)
        return Exit.STOPPED
    if options.json:
        print("\n".join(json.dumps(row) for row in rows), end="\n" if rows else "")
    elif not rows:
        print(text("history_no_alarms" if options.alarms else "history_none", language, path=path))
    else:
        print("\n".join(alarm_lines(rows, language) if options.alarms else run_lines(rows, language)))
    return Exit.DONE


def _show(store: History, number: int, as_json: bool, language: str) -> int:
    row = store.run(number)
    if row is None:
        raise UsageError(f"there is no run {number} in {store.path}")
    print(json.dumps(row) if as_json else "\n".join(one_run(row, language)))
    return Exit.DONE


def local(stored: str) -> str:
    """Local time for people."""
    return datetime.fromisoformat(stored).astimezone().strftime("%Y-%m-%d %H:%M")


def micrometres(mm: float | None) -> str:
    """One decimal, `-` where there is none."""
    return "-" if mm is None else f"{mm * 1e3:.1f}"


def run_lines(rows: Sequence[Row], language: str) -> list[str]:
    """A table, newest first."""
    width = min(34, max([len(row["name"]) for row in rows] + [4]))
    lines = [text("history_head", language, job=text("history_job", language).ljust(width))]
    for row in rows:
        at = f"{text('history_line', language)} {row['worst_line']}" if row["worst_line"] else "-"
        seconds = "-" if row["machine_time_s"] is None else f"{row['machine_time_s']:.1f} s"
        lines.append(
            f"{row['id']:>6}  {local(row['at'])}  {row['name'][:width]:<{width}}  {row['verdict']:<7}"
            f" {micrometres(row['deviation_max_mm']):>8}  {at:<12} {seconds:>10}  {row['alarms']:>7}  {row['source']}"
        )
    return lines


def alarm_lines(rows: Sequence[Row], language: str) -> list[str]:
    """A table, newest first."""
    lines = [text("history_alarm_head", language)]
    for row in rows:
        _, what = alarm_text(row["name"], row["bit"], row["axis"], language)
        block = row["block"] or (f"L{row['line']}" if row["line"] else "")
        seen = text("history_seen", language) if row["acknowledged"] else ""
        job = Path(row["job"]).name
        lines.append(
            f"{local(row['at'])}  {row['t_s']:10.3f} s  {row['code']:<5} {row['axis']:<4} {block:<8} {job:<20} "
            f"{what}  {seen}".rstrip()
        )
    return lines


def one_run(row: Row, language: str) -> list[str]:
    """All that is known of a run."""
    verdict = row["run"].get("verdict") or {}
    lines = [f"{row['id']}  {local(row['at'])}  {row['job']}: {row['verdict']}"]
    error = row["run"].get("error")
    reasons = verdict.get("reasons") or []
    lines += [f"  {text(r['id'], language, **{k: v for k, v in r.items() if k != 'id'})}" for r in reasons]
    if error and not reasons:
        lines.append(
            f"  {error['id']}: {error['message']}" + (f" ({row['job']}:{error['line']})" if error["line"] else "")
        )
    facts = [
        ("machine", row["machine"]),
        ("time", row["machine_time_s"] is not None and f"{row['machine_time_s']:.3f} s"),
        ("deviation", row["deviation_max_mm"] is not None and f"{micrometres(row['deviation_max_mm'])} um "
         + text("at_line", language, line=row["worst_line"])),
        ("limit", row["tolerance_mm"] is not None and f"{row['tolerance_mm'] * 1e3:g} um"),
        ("report", row["report"]),
        ("recording", row["recording"]),
        ("history_hash", row["sha256"]),
    ]  # fmt: skip
    lines += [f"  {text(label, language):<22} {value}" for label, value in facts if value]
    for alarm in row["run"].get("alarms") or ():
        code, what = alarm_text(alarm["name"], alarm["bit"], alarm["axis"], language)
        lines.append(
            f"  {code} {alarm['axis']} {alarm['t_s']:.3f} s {text('at_line', language, line=alarm['line'])} {what}"
        )
    return lines
