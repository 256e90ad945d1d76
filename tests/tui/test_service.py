"""The service screen: every register, task and variable, plain text per bit, and what changed is marked for 2 s."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.engine import State
from cnc_front.service import GERMAN, Bit, Service, ServiceTask
from cnc_front.sim import SimEngine
from tests.tui.ended import registers
from tests.tui.fake import FakeEngine
from tests.tui.stage import Stage, play
from tui.look import make_look
from tui.pages.service import MARK_S, Changes, service_rows
from tui.values import Shown
from tui.words import Words


def text(service: Service, changes: Changes, now: float, language: str = "en") -> list[str]:
    shown = Shown(FakeEngine().snapshot(), None, make_look("mono", "ascii"), Words(language))
    return [strip.text.rstrip() for strip in service_rows(shown, service, changes, now, 80)]


def test_every_bit_has_a_german_text() -> None:
    for register in ("axst", "errorreg"):
        assert {name for _, name, _ in native_kernel.register_bits(register)} <= GERMAN.keys()


def test_bits_in_words_and_changes_marked_for_two_seconds() -> None:
    service, changes = registers("en"), Changes()
    first = text(service, changes, 100.0)
    assert "   1  17 referenced         home position set" in first and not any("*" in row for row in first)
    wrong = Bit(7, "mpe", "following error above mpe", True)
    axis = service.axes[0]
    broken = replace(axis, axst=tuple(wrong if bit.name == "mpe" else bit for bit in axis.axst), entries=3)
    task = ServiceTask(0, 0, 40, 9, 40)
    later = replace(service, axes=(broken, *service.axes[1:]), tasks=(task, *service.tasks[1:]), integers=((7, -5),))
    rows = text(later, changes, 101.0)
    assert "  *1   7 mpe                following error above mpe" in rows
    assert any("*3 entries" in row for row in rows) and any("*0: RUNTIME ERROR line 40" in row for row in rows)
    assert any("CI7=-5" in row for row in rows)
    assert "  *1   7 mpe                following error above mpe" in text(later, changes, 101.0 + MARK_S - 0.1)
    assert "   1   7 mpe                following error above mpe" in text(later, changes, 101.0 + MARK_S + 0.1)
    # a bit that goes is shown as gone, then no more
    assert "  *0   7 mpe                following error above mpe" in text(service, changes, 110.0)
    assert not any(" mpe " in row for row in text(service, changes, 113.0))


@pytest.mark.parametrize("language", ["en", "de"])
def test_of_the_real_engine(language: str, tmp_path: Path) -> None:
    engine = SimEngine(speed=0, language=language)
    job = tmp_path / "part.nc"
    job.write_text("N10 G90 G21 G17\nN20 G1 X10 F3000 M08\nN30 M30\n")
    try:
        engine.service()
        assert engine.wait(5, lambda _: engine.service() is not None), "also without a job"
        engine.load(str(job))
        engine.start()
        assert engine.wait(10, lambda s: s.state is State.DONE)
        before = engine.service()
        assert engine.wait(5, lambda _: engine.service() is not before)
        service = engine.service()
        assert service is not None and service.axes[0].is_on("referenced") and service.axes[0].actual > 9.9
        assert service.axes[0].free == service.axes[0].memory and dict(service.axes[0].gains)["kp"] > 0
        assert len(service.tasks) == 4 and service.samples > 100
    finally:
        engine.close()


def test_the_page_asks_only_while_it_is_shown() -> None:
    class Counted(FakeEngine):
        asked = 0

        def service(self) -> Service | None:
            self.asked += 1
            return registers("en")

    engine = Counted()

    async def script(stage: Stage) -> None:
        await stage.frame()
        assert engine.asked == 0
        await stage.press("8")
        assert engine.asked > 0 and "home position set" in await stage.frame()

    play(script, engine)
