"""The report screen: verdict, worst blocks, plots, export, comparison with earlier runs; and what is kept of a run."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cnc_front.deliver import Plotting
from cnc_front.engine import State
from cnc_front.evidence import finding_text, remedy_text
from cnc_front.history import Filter, History
from cnc_front.jobs import CompileOptions, JobSource, compile_job, load_machine
from cnc_front.messages import TEXTS
from cnc_front.outcome import Outcome, outcome_of
from cnc_front.run import RunOptions, dry_run
from tests.app.conftest import ROOT
from tests.tui.ended import PROGRAM, ended
from tests.tui.fake import FakeEngine
from tests.tui.stage import NARROW, WIDE, Stage, play, same_frame
from tui.archive import Archive
from tui.charts import columns, histogram, pointer, reduced
from tui.findings import place_of
from tui.look import make_look

OPTIONS = CompileOptions()
SIZES = {"wide": WIDE, "narrow": NARROW}


def done() -> FakeEngine:
    engine = FakeEngine()
    engine.run_half()
    engine.show(state=State.DONE)
    engine.ended = ended()
    return engine


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("theme", ["dark", "mono"])
def test_frames(size: str, language: str, theme: str) -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.show(state=State.DONE)
        await stage.press("7")
        same_frame(f"report-{size}-{language}", await stage.frame())

    play(script, done(), size=SIZES[size], language=language, theme=theme)


def test_before_the_first_run_it_says_so() -> None:
    async def script(stage: Stage) -> None:
        await stage.press("7")
        assert "No run has ended yet" in await stage.frame()
        await stage.press("e")
        assert "No run has ended yet" in stage.message

    play(script)


def test_a_chosen_block_is_shown_on_the_run_page() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        await stage.press("7", "down", "enter")
        assert stage.app.page.name == "run"
        assert stage.app.program.chosen == stage.engine.ended.worst[1].line  # type: ignore[union-attr]

    play(script, done())


#: An arc that gets smaller without feed-forward.
LAGGING = (ROOT / "examples/machines/mill3.toml").read_text().replace("kfcv = 0.0131068", "kfcv = 0.0")


@cache
def lagging() -> Outcome:
    """A run with named findings."""
    from cnc_front._native import motion_kernel

    machine = load_machine(None)
    parsed = motion_kernel.Machine.parse(LAGGING.encode(), "lagging.toml")
    job = compile_job(JobSource("parts/contour.nc", PROGRAM, "din66025"), replace(machine, machine=parsed), OPTIONS)
    plotting = Plotting(0.05)
    return outcome_of(dry_run(job, RunOptions(), None, plotting), plotting, 1)


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("size", SIZES)
def test_findings_with_cause_and_remedy_and_a_mark_in_the_plot(size: str, language: str) -> None:
    outcome = lagging()
    findings = outcome.run["findings"]
    assert findings
    engine = done()
    engine.ended = outcome

    async def script(stage: Stage) -> None:
        await stage.load()
        stage.engine.show(state=State.DONE)
        await stage.press("7")
        text = await stage.frame()
        same_frame(f"report-findings-{size}-{language}", text)
        flat = " ".join(text.split())
        assert finding_text(findings[0], language)[:40] in flat
        assert remedy_text(findings[0], language)[:40] in flat
        await stage.press("enter")
        assert stage.app.page.name == "run" and stage.app.program.chosen == findings[0]["line"]
        await stage.press("7", *["down"] * len(findings), "enter")
        assert stage.app.program.chosen == outcome.worst[0].line

    play(script, engine, size=SIZES[size], language=language)


def test_every_kind_of_finding_has_a_remedy_in_both_languages() -> None:
    kinds = [id.removeprefix("finding_") for id in TEXTS if id.startswith("finding_")]
    assert len(kinds) >= 10
    for kind in kinds:
        english, german = (remedy_text({"kind": kind, "axes": ["X"], "line": 3}, lang) for lang in ("en", "de"))
        assert english and german and english != german


def test_the_pointer_stands_at_the_middle_of_the_block() -> None:
    outcome = ended()
    share = place_of(outcome, 4)  # the arc: behind 11.2 mm of rapid and 30.4 mm of line, of 156.6 mm
    assert share == pytest.approx((11.18 + 30.41 + 15.71 / 2) / outcome.run["path_length_mm"], abs=0.01)
    assert place_of(outcome, 1) is None
    row = pointer(make_look("mono", "ascii"), 30, (0.5, "N40")).strip(30).text
    assert row.index("^") == 20 and row.rstrip().endswith("^ N40")
    assert pointer(make_look("mono", "ascii"), 30, (1.0, "N70")).strip(30).text.rstrip().endswith("N70 ^")


async def compared(stage: Stage, archive: Archive) -> str:
    """The report screen beside the run that the archive holds."""
    await stage.until(lambda: archive.wait() or len(archive.jobs) == 1)
    await stage.press("7")
    archive.wait()
    await stage.press("c")
    return await stage.frame()


def test_compared_with_a_run_that_had_findings(tmp_path: Path) -> None:
    file = tmp_path / "history.sqlite"
    before = lagging()
    History(file).add_run(before.kept(), before.path, "run", 0)
    archive = Archive(file, "en")

    async def script(stage: Stage) -> None:
        text = " ".join((await compared(stage, archive)).split())
        assert f"cured: {finding_text(before.run['findings'][0], 'en')[:30]}" in text
        assert "NEW finding" not in text

    play(script, done(), archive=archive)
    archive.close()


def test_the_last_recording_is_opened_by_a_key(tmp_path: Path) -> None:
    file, recording = tmp_path / "history.sqlite", tmp_path / "f.mcap"
    before = ended()
    run = before.kept() | {"files": {"recording": str(recording), "report": None}}
    History(file).add_run(run, before.path, "run", 0)
    archive = Archive(file, "en")

    async def script(stage: Stage) -> None:
        await stage.press("7", "P")
        archive.wait()
        await stage.until(lambda: "No recording" in stage.message)  # it is not there any more
        recording.write_bytes(b"")
        await stage.press("P")
        await stage.until(lambda: f"load {recording}" in stage.engine.calls)

    play(script, done(), archive=archive)
    archive.close()


def test_export_writes_the_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SSH_CONNECTION", raising=False)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("mine")

    async def script(stage: Stage) -> None:
        await stage.press("7", "e", "enter")
        await stage.until(lambda: "contour-report/report.html" in stage.message, 60)
        text = " ".join((await stage.frame()).split())
        assert f"EXPORTED to {tmp_path}/contour-report/report.html; see it with: xdg-open" in text
        await stage.press("e", *"mine", "enter")
        await stage.until(lambda: "W301" in stage.message)

    play(script, done())
    figures = json.loads((tmp_path / "contour-report" / "report.json").read_text())
    assert figures["findings"][0]["line"] == ended().worst[0].line
    assert [f.name for f in (tmp_path / "mine").iterdir()] == ["letter.txt"]


def test_the_run_is_kept_and_compared_with_the_one_before(tmp_path: Path) -> None:
    file = tmp_path / "history.sqlite"
    before = ended(override=0.3)
    number = History(file).add_run(before.kept(), before.path, "run", 0)
    archive = Archive(file, "en")

    async def script(stage: Stage) -> None:
        text = await compared(stage, archive)
        assert f"COMPARED with run {number}" in text and "new among the worst" in text
        await stage.press("c")
        assert "COMPARED" not in await stage.frame()

    play(script, done(), archive=archive)
    archive.close()
    rows = History(file).runs(Filter())
    assert [row["source"] for row in rows] == ["tui", "run"]
    assert rows[0]["deviation_max_mm"] == ended().run["deviation"]["actual"]["max_mm"]


def test_a_run_is_kept_once(tmp_path: Path) -> None:
    archive = Archive(tmp_path / "h", "en")

    async def script(stage: Stage) -> None:
        for _ in range(5):
            await stage.frame()

    play(script, done(), archive=archive)
    archive.close()
    assert len(History(tmp_path / "h").runs(Filter())) == 1


def test_a_damaged_history_is_told_once(tmp_path: Path) -> None:
    (tmp_path / "h").write_bytes(b"no data base at all" * 200)
    archive = Archive(tmp_path / "h", "de")

    async def script(stage: Stage) -> None:
        archive.wait()
        await stage.frame()
        assert "CF502" in stage.message and "beschädigt" in stage.message
        assert sum("CF502" in entry.text for entry in stage.app.messages.log) == 1

    play(script, done(), archive=archive, language="de")
    archive.close()


def test_no_peak_is_lost() -> None:
    values = np.ones(100_000)
    values[77_777] = 50.0
    assert reduced(values, 60).max() == 50.0
    assert reduced(np.array([1.0, 2.0]), 6).tolist() == [1, 1, 1, 2, 2, 2]
    assert np.isnan(reduced(np.zeros(0), 3)).all() and np.isnan(reduced(np.full(9, np.nan), 3)).all()


def test_a_chart_in_characters() -> None:
    look = make_look("mono", "ascii")
    rows = [row.strip(16).text for row in columns(look, np.array([1.0, 4.0, 2.0]), 16, 4, limit=3.0, ends=("0", "9"))]
    assert rows == [
        "       4 |  ##  ",
        "       3 |--##--",
        "         |  ####",
        "         |######",
        "          0    9",
    ]
    bars = [row.strip(40).text.rstrip() for row in histogram(look, ["<= 1", "<= 2", "> 2"], [3, 0, 1], 40, 2)]
    assert bars == ["        <= 1  75.00 % #############", "        <= 2   0.00 %", "         > 2  25.00 % ####"]
