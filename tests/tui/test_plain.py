"""Line mode: the real program on a real engine, fed with lines; and that a hold is never queued."""

from __future__ import annotations

import io
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

import pytest

from cnc_front.engine import Alarm, State
from cnc_front.history import Filter, History
from tests.tui.ended import ended
from tests.tui.fake import FakeEngine
from tests.tui.test_terminal import ROOT
from tui.archive import Archive
from tui.plain import Plain
from tui.plain_words import VERBS, verb_of
from tui.words import Words

FAULTS = ROOT / "examples/faults"
PLAIN = [sys.executable, "-m", "cnc_front", "tui", "--plain", "--speed", "max", "--lang"]


def talk(lines: str, *arguments: object, language: str = "en", history: Path | None = None) -> list[str]:
    """What the program says to these lines."""
    command = [*PLAIN, language, *map(str, arguments)]
    env = os.environ | {"CNC_FRONT_HISTORY": str(history or "off")}
    ran = subprocess.run(command, cwd=ROOT, env=env, input=lines, capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0 and not ran.stderr, ran.stderr
    assert not re.search(r"[\x00-\x09\x0b-\x1f│─█┌]", ran.stdout), "no control characters, no box drawing"
    return ran.stdout.splitlines()


def test_a_job_from_load_to_report(tmp_path: Path) -> None:
    said = talk(
        "status\nstart\nwait\nreport\nposition\nblock 5\nexport " + str(tmp_path / "out") + "\nquit\n",
        FAULTS / "contour.nc",
        history=tmp_path / "h",
    )
    text = "\n".join(said)
    for part in ("contour.nc: 14 lines", "READY", "DONE", "REPORT contour.nc: PASS", "L5: G1 X50 F3000", "X: actual"):
        assert part in text, text
    assert (tmp_path / "out" / "report.html").is_file()
    assert [row["verdict"] for row in History(tmp_path / "h").runs(Filter())] == ["PASS"]


def test_german_words_and_a_fault(tmp_path: Path) -> None:
    for name in ("contour.nc", "machine.toml"):
        (tmp_path / name).write_bytes((FAULTS / name).read_bytes())
    (tmp_path / "contour.stim").write_bytes((FAULTS / "limit_sma.stim").read_bytes())
    lines = "los\nwarte\nstörungen\nquittieren\nabbruch\nabbruch ja\nwarte\nquittieren\nende\n"
    said = talk(lines, tmp_path / "contour.nc", language="de")
    text = "\n".join(said)
    assert "STÖRUNG" in text and "E104 Y" in text and "Reset, dann freifahren" in text and "bei 25.0" in text
    assert "die Ursache besteht noch" in text and "Eingeben: abbruch ja" in text
    assert "E104 Y quittiert" in text.split("Eingeben: abbruch ja")[1]


def test_what_is_wrong_is_said(tmp_path: Path) -> None:
    (tmp_path / "bad.nc").write_text("N10 G1 X5\nN20 M30\n")
    said = "\n".join(talk("dance\noverride much\nspeed 0.001\nload none.nc\nstart\nquit\n", tmp_path / "bad.nc"))
    assert "bad.nc:1:" in said and "dance: no such command" in said and "much: not a number" in said
    assert "No such file" in said and "No job" in said


class Slow(io.StringIO):
    """An output that takes its time, like a speech synthesiser."""

    def write(self, text: str) -> int:
        time.sleep(0.3)
        return super().write(text)


def session(engine: FakeEngine, lines: Iterator[str] | list[str], out: io.StringIO, language: str = "en") -> str:
    """Runs a session on the tests' own engine."""
    archive = Archive(None, language)
    Plain(engine, Words(language), out, archive, lambda: datetime(2026, 3, 4, 12, 31, 7)).run(lines)
    return out.getvalue()


def test_a_hold_does_not_wait_for_what_is_being_said() -> None:
    engine, when = FakeEngine(), []

    def lines() -> Iterator[str]:
        engine.run_half()
        yield "help\n"  # a score of lines, 0.3 s each
        when.append(time.monotonic())
        yield "\n"
        while "hold" not in engine.calls:
            time.sleep(0.001)
        when.append(time.monotonic())
        yield "quit yes\n"

    out = Slow()
    session(engine, lines(), out)
    assert when[1] - when[0] < 0.1, "an empty line holds at once"
    assert out.getvalue().index("Hold asked for") > out.getvalue().index("help")


def test_the_end_of_input_holds() -> None:
    engine = FakeEngine()
    engine.run_half()
    assert "Terminal closed: HOLD" in session(engine, [], io.StringIO())
    assert engine.calls == ["hold"]


def test_alarms_and_results_are_told() -> None:
    engine = FakeEngine()

    def lines() -> Iterator[str]:
        engine.run_half()
        engine.ended = ended()
        engine.show(state=State.ALARM, alarms=(Alarm(1.0, "E107", "Y", 9, "cause; remedy", True, "mpe"),))
        yield "alarms\n"
        yield "quit\n"

    text = session(engine, lines(), io.StringIO())
    assert "E107 Y" in text and "cause; remedy" in text and "REPORT contour.nc: PASS" in text


def test_quit_asks_while_a_job_runs() -> None:
    engine = FakeEngine()
    engine.run_half()
    assert "Type: quit yes" in session(engine, ["quit\n", "quit yes\n"], io.StringIO())
    assert engine.calls == ["hold"]


@pytest.mark.parametrize("language", ["en", "de"])
def test_every_command_is_listed_and_understood(language: str) -> None:
    text = session(FakeEngine(), ["help\n", "quit\n"], io.StringIO(), language)
    for verb in VERBS:
        names = verb.german if language == "de" else verb.english
        assert f"{', '.join(names)}: " in text
        assert all(verb_of(name.upper()) == verb.id for name in names)
    plain = Plain(FakeEngine(), Words(language), io.StringIO(), Archive(None, language))
    assert plain.deeds.keys() == {verb.id for verb in VERBS}


def test_an_interrupt_holds_and_a_second_one_at_rest_ends(tmp_path: Path) -> None:
    job = tmp_path / "long.nc"
    job.write_text("G90 G21 G17\nG1 X100 F100\nM30\n")
    command = [*PLAIN[:-3], "--lang", "en", str(job)]
    env = os.environ | {"PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(command, cwd=ROOT, env=env, stdin=-1, stdout=-1, stderr=-1, text=True) as run:
        assert run.stdin and run.stdout
        run.stdin.write("start\n")
        run.stdin.flush()
        seen = ""
        while "RUNNING" not in seen:
            seen = run.stdout.readline()
        run.send_signal(signal.SIGINT)
        while "HOLD" not in seen:
            seen = run.stdout.readline()
        run.stdin.write("quit yes\n")
        run.stdin.flush()
        assert run.wait(20) == 0


def test_a_hold_right_behind_a_start_holds() -> None:
    said = talk("speed 1\nstart\nhold\nwait\nstatus\nreset yes\nwait\nquit\n", FAULTS / "contour.nc")
    assert any("HOLD" in line for line in said) and not any("DONE" in line for line in said), said
