"""The result of a run as text for people: verdict first, then figures."""

from __future__ import annotations

from typing import Any

from cnc_front.evidence import finding_text
from cnc_front.geometry.judging import geometry_rows
from cnc_front.messages import limit_text, text
from cnc_front.run import RunResult
from cnc_front.sweep import sweep_text
from cnc_front.verdict import Verdict

#: SGR colours of ui-guide section 5: good, warn, bad.
COLORS = {"PASS": "38;2;86;180;233", "WARN": "38;2;240;228;66", "FAIL": "38;2;255;106;19"}


def result_text(
    result: RunResult, verdict: Verdict, run: dict[str, Any], language: str, *, colors: bool = False
) -> str:
    """A dozen lines; numbers always with a decimal point, units always printed."""

    def say(id: str, **values: Any) -> str:
        return text(id, language, **values)

    word = f"\x1b[1;{COLORS[verdict.word]}m{verdict.word}\x1b[0m" if colors else verdict.word
    rows = [f"{run['job']['path']}: {word}"]
    rows += [f"  {say(reason.id, **reason.values)}" for reason in verdict.reasons[:10]]
    actual, setpoint, feed = run["deviation"]["actual"], run["deviation"]["setpoint"], run["feed"]
    line = say("at_line", line=actual["worst"]["line"])
    machine = run["machine"]
    rows += [
        _row(say("machine"), f"{machine['name']} ({machine['path'] or say('builtin')})"),
        *([_row(say("stimulus"), run["stimulus"]["path"])] if run["stimulus"] else []),
        _row(say("time"), f"{run['machine_time_s']:.3f} s ({run['wall_time_s']:.2f} s)"),
        _row(say("path"), f"{run['path_length_mm']:.3f} mm"),
        _row(say("deviation"), f"{_um(actual['max_mm'])} {line}, {say('limit')} {verdict.tolerance_mm * 1e3:g} um"),
        _row(say("setpoint_deviation"), _um(setpoint["max_mm"], 4)),
    ]
    if run["merged"]["blocks"]:
        rows.append(_row(say("merged"), f"{run['merged']['blocks']} ({_um(run['merged']['max_mm'])})"))
    errors = zip(run["following_error"].items(), result.job.machine.machine.units, strict=True)
    rows.append(_row(say("following"), "  ".join(f"{name} {e['max']:.4f} {unit}" for (name, e), unit in errors)))
    if feed["programmed_reached_pct"] is not None:
        rows.append(_row(say("feed"), f"{feed['programmed_reached_pct']:.1f} % {say('of_time')}"))
    if run["time_optimal_s"] is not None:
        share = 100 * (1 - run["time_optimal_s"] / run["machine_time_s"])
        rows.append(_row(say("possible"), f"{run['time_optimal_s']:.3f} s ({share:.1f} % {say('less')})"))
    rows.append(_row(say("limited"), ", ".join(_limits(feed["limits"], run["machine_time_s"], language))))
    rows += [_row(say(label), value) for label, value in geometry_rows(run, language)]
    rows += [_row(say("findings"), finding_text(found, language)) for found in (run["findings"] or [])[:5]]
    for key, label in (("recording", "recording"), ("report", "report")):
        if run["files"][key]:
            rows.append(_row(say(label), run["files"][key]))
    if run["override_sweep"]:
        rows += ["", *sweep_text(run["override_sweep"], language)]
    if run["output"]:
        rows += ["", *run["output"]]
    return "\n".join(rows)


def _limits(limits: dict[str, float], total_s: float, language: str) -> list[str]:
    """The three causes that limited the path velocity longest, with their shares of the machine time."""
    longest = sorted(limits.items(), key=lambda item: -item[1])[:3]
    return [f"{limit_text(name, language)} {100 * seconds / total_s:.1f} %" for name, seconds in longest]


def _row(label: str, value: str) -> str:
    return f"  {label:<22} {value}"


def _um(mm: float | None, digits: int = 1) -> str:
    return "-" if mm is None else f"{mm * 1e3:.{digits}f} um"
