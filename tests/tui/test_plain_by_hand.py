"""Line mode: what Run, Manual, MDI, Jobs and Service can do beside the job that runs; fake and real engine."""

from __future__ import annotations

import io
from typing import Any

import pytest

from cnc_front.engine import State
from tests.tui.fake import FakeEngine
from tests.tui.test_by_hand import equipped
from tests.tui.test_plain import FAULTS, session, talk


def said(*lines: str, engine: FakeEngine | None = None, language: str = "en", **values: Any) -> tuple[str, list[str]]:
    """What is said to these lines, and what the engine is asked for."""
    acting = engine or equipped()
    acting.show(**values)
    text = session(acting, [f"{line}\n" for line in (*lines, "quit yes")], io.StringIO(), language)
    return text, acting.calls


def loaded() -> FakeEngine:
    """A machine at rest with the tests' job."""
    engine = equipped()
    engine.show(state=State.READY, revision=1)
    return engine


@pytest.mark.parametrize(
    ("lines", "calls", "part"),
    [
        (("search N620",), ["search N620"], "Type: yes"),
        (("search n620", "yes"), ["search N620", "start at N620"], "Starts at N620"),
        (("search 7", "yes"), ["search 7", "start at 7"], "Starts at N600"),
        (("search 7", "status", "yes"), ["search 7"], "Nothing was asked."),
        (("search 7", "yes", "yes"), ["search 7", "start at 7"], "Nothing was asked."),
        (("search 1", "yes"), ["search 1"], "GC617: line 1 is not executed"),
        (("search N7",), [], "N7: no such block."),
        (("search 0",), ["start at "], "Starts at the top"),
        (("search",), [], "Type: search: search N120"),
        (("serch 7",), [], "serch 7: no such command; nearest: search: "),
        (("blocks N560",), [], "N570: N570 G1 X+50.0000 Y+4.0000"),
        (("xyzzyx",), [], "xyzzyx: no such command; help lists them."),
    ],
)
def test_block_search(lines: tuple[str, ...], calls: list[str], part: str) -> None:
    text, asked = said(*lines, engine=loaded())
    assert part in text and asked == calls, text


def test_the_state_before_a_block_is_read_out_and_nothing_starts_under_way() -> None:
    text, _ = said("suche N620", engine=loaded(), language="de")
    assert "G1 G17 G90 G21 G94 G40 G49 G64 G54" in text and "S12000" in text and "Eingeben: ja" in text
    text, calls = said("search 7", "yes", engine=loaded(), state=State.RUNNING)
    assert "A job is under way" in text and "search 7" not in calls
    assert "No program to search." in said("search 7")[0]


def test_a_real_program_starts_at_a_block() -> None:
    text = "\n".join(talk("blocks 12\nsearch 11\nyes\nstart\nwait\nposition\nquit\n", FAULTS / "contour.nc"))
    assert "L13: G0 Z5" in text and "start at line 11" in text and "Starts at L11" in text
    assert "REPORT contour.nc: PASS" in text and "L5: max" not in text, "the blocks before are not run"
