"""Alarms: cause and remedy, acknowledged only when the cause is gone, and kept on disk."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from cnc_front.engine import Alarm, State, Stop
from cnc_front.history import Filter, History
from tests.tui.fake import AXES, FakeEngine
from tests.tui.stage import NARROW, Stage, play
from tui.archive import Archive

MPE = Alarm(48.2, "E107", "Y", 9, "following error 0.52 mm > 0.5 mm (mpe); check drive and gains", True, "mpe")
REGISTER = Alarm(48.3, "E203", "", 0, "blocks shorter than a sample (ProfileToSmall)", False, "ProfileToSmall")
FAULTY = (AXES[0], replace(AXES[1], bits=(*AXES[1].bits, "mpe")), AXES[2])


def test_acknowledged_only_when_the_cause_is_gone(tmp_path: Path) -> None:
    archive = Archive(tmp_path / "h", "en")

    async def script(stage: Stage) -> None:
        engine = stage.engine
        await stage.load()
        engine.run_half()
        engine.show(state=State.ALARM, why="mpe", alarms=(MPE,), axes=FAULTY)
        await stage.press("6")
        text = await stage.frame()
        assert "E107 Y  N620" in text and "ACTIVE" in text and "-> check drive and gains" in text
        await stage.press("delete")
        assert "cause is still there" in stage.message and len(stage.app.keeper.book.open) == 1
        engine.show(axes=AXES)
        assert "gone" in await stage.frame()
        archive.wait()
        await stage.press("delete")
        assert stage.app.keeper.book.open == [] and "acknowledged" in await stage.frame()
        await stage.press("delete")
        assert "No alarm to acknowledge" in stage.message
        # the same fault after a reset is another alarm
        engine.show(state=State.READY, alarms=())
        await stage.frame()
        engine.show(state=State.ALARM, alarms=(MPE,), axes=FAULTY)
        await stage.frame()
        assert len(stage.app.keeper.book.open) == 1

    play(script, archive=archive)
    archive.close()
    rows = History(tmp_path / "h").alarms(Filter())
    assert [(row["code"], row["block"], row["acknowledged"] is not None) for row in rows] == [
        ("E107", "N620", False),
        ("E107", "N620", True),
    ]


def test_the_error_register_is_cleared_by_reset_only() -> None:
    async def script(stage: Stage) -> None:
        stage.engine.run_half()
        stage.engine.show(alarms=(MPE, REGISTER))
        await stage.press("6", "n")
        book = stage.app.keeper.book
        assert [entry.alarm.code for entry in book.open] == ["E203", "E107"]
        assert [entry.active for entry in book.open] == [True, False], "the bit of the axis is not set"
        assert book.chosen is book.open[1]
        await stage.press("delete", "up", "delete")
        assert [entry.alarm.code for entry in book.open] == ["E203"]
        stage.engine.show(alarms=())
        await stage.frame()
        await stage.press("delete")
        assert book.open == []

    play(script)


def test_an_alarm_that_is_wider_than_the_line_is_shown_in_parts() -> None:
    long = replace(MPE, text=f"{MPE.text}, or lower the feed or the acceleration of the axis")

    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.run_half()
        stage.engine.show(state=State.ALARM, stop=Stop.FAST_STOP, alarms=(REGISTER, long), axes=FAULTY)
        await stage.frame()
        first = stage.message
        assert first.startswith(" E107 Y N620 following error 0.52 mm > 0.5 mm (mpe)") and "... " in first
        await stage.press("n")
        assert "acceleration of the axis" in stage.message
        await stage.press("n")
        assert "E203 blocks shorter" in stage.message, "what did not stop the job comes later"
        await stage.press("n")
        assert "FAST STOP" in stage.message
        await stage.press("6")
        assert "acceleration of the axis" in stage.text.split("LOG")[1], "the log loses nothing either"

    play(script, size=NARROW)


def test_alarms_of_before_are_listed(tmp_path: Path) -> None:
    alarm = {"t_s": 1.0, "axis": "X", "bit": 4, "name": "lsrh", "line": 3, "block": "N30"}
    number = History(tmp_path / "h").add_alarm(alarm, "/parts/old.nc", "run")
    archive = Archive(tmp_path / "h", "de")

    async def script(stage: Stage) -> None:
        archive.wait()
        await stage.press("6")
        text = await stage.frame()
        assert "VOR dieser Sitzung" in text and "old.nc" in text and "rechter Hardware-Endschalter" in text

    play(script, FakeEngine(), archive=archive, language="de")
    archive.close()
    assert number == 1
