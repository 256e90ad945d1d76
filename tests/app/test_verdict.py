"""The rules of design 3.1 one by one, on results made up for them."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import pytest

from cnc_front import run as run_module
from cnc_front.errors import Exit
from cnc_front.execution import AlarmEvent, End, Fault
from cnc_front.jobs import CompileOptions, JobSource, compile_job, load_machine
from cnc_front.run import RunOptions, dry_run
from cnc_front.verdict import judge

ALARM = AlarmEvent(1.5, "X", 7, "mpe", 12)


FAULT = Fault(ALARM, {"X": 1.0})


def result(
    actual: float = 0.01,
    setpoint: float = 0.0,
    merged: float = 0.0,
    end: End = End.FINISHED,
    alarms: tuple[AlarmEvent, ...] = (),
    completed: bool = True,
    warnings: int = 0,
    dry_feed: float | None = None,
) -> Any:
    worst = {"line": 3}
    return SimpleNamespace(
        job=SimpleNamespace(
            machine=SimpleNamespace(machine=SimpleNamespace(tolerance_mm=0.05)),
            warnings=[None] * warnings,
            dry_feed=dry_feed,
        ),
        options=SimpleNamespace(max_time_s=9.0),
        execution=SimpleNamespace(end=end, alarms=list(alarms), task_error=(8, 4), fault=FAULT),
        summary={
            "actual": {"max_mm": actual, "worst": worst},
            "setpoint": {"max_mm": setpoint, "worst": worst},
            "merged": (0, merged),
            "completed": completed,
            "missing_mm": 0.0 if completed else 1.0,
            "reached_line": 3,
        },
    )


@pytest.mark.parametrize(
    ("given", "word", "code", "reasons"),
    [
        ({}, "PASS", Exit.DONE, []),
        ({"warnings": 2}, "WARN", Exit.DONE, ["warnings"]),
        ({"dry_feed": 50.0}, "WARN", Exit.DONE, ["dry_feed_run"]),
        ({"actual": 0.05}, "PASS", Exit.DONE, []),
        ({"actual": 0.0501}, "FAIL", Exit.CHECK_FAILED, ["tolerance"]),
        ({"setpoint": 1.1e-6}, "FAIL", Exit.CHECK_FAILED, ["setpoint"]),
        ({"setpoint": 0.9e-6}, "PASS", Exit.DONE, []),
        ({"setpoint": 0.0011, "merged": 0.0011}, "PASS", Exit.DONE, []),
        ({"setpoint": 0.0012, "merged": 0.0011}, "FAIL", Exit.CHECK_FAILED, ["setpoint"]),
        ({"completed": False}, "FAIL", Exit.CHECK_FAILED, ["incomplete"]),
        ({"alarms": (ALARM,)}, "FAIL", Exit.CHECK_FAILED, ["alarm"]),
        ({"alarms": (ALARM,), "end": End.FAULT}, "FAIL", Exit.STOPPED, ["fault", "alarm"]),
        ({"end": End.TASK_ERROR}, "FAIL", Exit.STOPPED, ["task_error"]),
        ({"end": End.TIME_LIMIT, "completed": False}, "FAIL", Exit.STOPPED, ["time_limit"]),
        ({"end": End.INTERRUPTED}, "FAIL", Exit.INTERRUPTED, ["interrupted"]),
    ],
)
def test_rules(given: dict[str, Any], word: str, code: Exit, reasons: list[str]) -> None:
    verdict = judge(result(**given), None)
    assert (verdict.word, verdict.exit, [r.id for r in verdict.reasons]) == (word, code, reasons)


def test_a_given_tolerance_beats_the_machine_file() -> None:
    assert judge(result(actual=0.02), 0.01).exit is Exit.CHECK_FAILED
    assert judge(result(actual=0.2), 0.3).exit is Exit.DONE


def test_max_time_bounds_wall_time_too(monkeypatch: pytest.MonkeyPatch) -> None:
    source = JobSource("part.nc", b"G90 G21\nG1 X500 F600\nX-500\nX500\nM30\n", "din66025")
    job = compile_job(source, load_machine(None), CompileOptions())
    clock = itertools.count(0.0, 400.0)
    monkeypatch.setattr(run_module, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    done = dry_run(job, RunOptions(max_time_s=500.0))
    assert done.execution.end is End.TIME_LIMIT
    assert done.execution.machine_time_s < 250.0, "the job takes 250 s"
