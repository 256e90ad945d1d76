"""The jobs screen: lists, load check, and a queue that runs one job after the other."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from cnc_front.engine import Job, State
from cnc_front.errors import UsageError
from cnc_front.history import Filter, History
from cnc_front.sim import SimEngine
from tests.tui.ended import ended
from tests.tui.fake import FakeEngine
from tests.tui.stage import NARROW, WIDE, Stage, play, same_frame
from tui.archive import Archive
from tui.job_queue import JobQueue
from tui.words import Words

GOOD = "N10 G90 G21 G17\nN20 G1 X10 F3000\nN30 G1 X0\nN40 M30\n"
BAD = "N10 G1 X5\nN20 M30\n"


def parts(folder: Path) -> dict[str, Path]:
    """Three good jobs, one that does not compile, one that fails its tolerance."""
    files = {}
    for name, text in (("a.nc", GOOD), ("bad.nc", BAD), ("b.nc", GOOD)):
        files[name] = folder / name
        files[name].write_text(text)
    tight = folder / "tight"
    tight.mkdir()
    machine = SimEngine()._machine.bench.file.text
    (tight / "machine.toml").write_text(machine.replace("tolerance_mm = 0.05", "tolerance_mm = 1e-6"))
    files["tight.nc"] = tight / "tight.nc"
    files["tight.nc"].write_text(GOOD)
    return files


def run(queue: JobQueue, engine: SimEngine, seconds: float = 60.0) -> None:
    """Looks at the engine as the terminal does, until the queue is through."""
    deadline = time.monotonic() + seconds
    queue.start()
    while queue.is_active or queue._current is not None:
        assert time.monotonic() < deadline, [(entry.name, entry.state) for entry in queue.entries]
        queue.watch(engine.snapshot(), engine.outcome())
        time.sleep(0.005)


def test_one_that_fails_does_not_stop_the_rest_unless_asked(tmp_path: Path) -> None:
    files = parts(tmp_path)
    engine, said = SimEngine(speed=0), list[str]()
    queue = JobQueue(engine, Words("en"), said.append)
    for name in ("a.nc", "bad.nc", "tight.nc", "b.nc"):
        queue.add(str(files[name]))
    run(queue, engine)
    assert [entry.verdict for entry in queue.entries] == ["PASS", "ERROR", "FAIL", "PASS"]
    assert queue.entries[1].detail.startswith("1:") and "um" in queue.entries[0].detail
    assert said == ["Queue done: 2 of 4 good."]
    queue.stops_at_failure = True
    run(queue, engine)
    assert [entry.verdict for entry in queue.entries] == ["PASS", "ERROR", "", ""]
    assert "The queue stands: bad.nc: ERROR. ^R goes on" in said[-1] and queue.why == "bad.nc: ERROR"
    run(queue, engine)
    assert [entry.verdict for entry in queue.entries] == ["PASS", "ERROR", "FAIL", ""], "goes on behind it"
    run(queue, engine)
    assert [entry.verdict for entry in queue.entries] == ["PASS", "ERROR", "FAIL", "PASS"] and not queue.why
    engine.close()


def test_a_reset_ends_the_queue(tmp_path: Path) -> None:
    slow = tmp_path / "slow.nc"
    slow.write_text(GOOD.replace("F3000", "F60"))
    engine = SimEngine(speed=1)
    queue = JobQueue(engine, Words("en"), lambda _: None)
    queue.add(str(slow))
    queue.add(str(slow))
    queue.start()
    deadline = time.monotonic() + 20
    while engine.snapshot().path_done_mm < 0.1:
        assert time.monotonic() < deadline
        queue.watch(engine.snapshot(), engine.outcome())
        time.sleep(0.01)
    engine.reset()
    while queue.is_active or queue._current is not None:
        assert time.monotonic() < deadline
        queue.watch(engine.snapshot(), engine.outcome())
        time.sleep(0.01)
    assert [(entry.verdict, entry.state) for entry in queue.entries] == [("ABORT", "done"), ("", "waiting")]
    assert engine.snapshot().state is State.ABORTED and queue.why == "slow.nc: ABORT"
    slow.write_text(GOOD)
    engine.set_speed(0)
    run(queue, engine)
    assert [entry.verdict for entry in queue.entries] == ["ABORT", "PASS"], "what was reset is not run again by itself"
    engine.close()


@pytest.mark.parametrize(
    ("language", "says"),
    [("en", "cnc-front run FILE gives its verdict"), ("de", "cnc-front run DATEI gibt sein Urteil")],
)
def test_a_sympas_job_is_refused_with_what_to_do(language: str, says: str, tmp_path: Path) -> None:
    files, job = parts(tmp_path), tmp_path / "job.src"
    job.write_text("begin\n  CI5 := 1;\nend.\n")
    engine = SimEngine(speed=0, language=language)
    queue = JobQueue(engine, Words(language), lambda _: None)
    queue.add(str(job))
    queue.add(str(files["a.nc"]))
    run(queue, engine)
    assert [entry.verdict for entry in queue.entries] == ["ERROR", "PASS"]
    assert says in queue.entries[0].detail
    engine.close()


def test_a_job_without_motion_has_its_verdict(tmp_path: Path) -> None:
    (tmp_path / "still.nc").write_text("N10 M30\n")
    engine = SimEngine(speed=0)
    queue = JobQueue(engine, Words("en"), lambda _: None)
    queue.add(str(tmp_path / "still.nc"))
    run(queue, engine)
    assert queue.entries[0].verdict and queue.entries[0].state == "done"
    engine.close()


def test_an_alarm_makes_the_queue_stand(tmp_path: Path) -> None:
    """Whatever ^T says; while the alarm stands nothing starts."""
    engine, said = FakeEngine(), list[str]()
    queue = JobQueue(engine, Words("en"), said.append)
    queue.add("a.nc")
    queue.add("b.nc")
    queue.start()
    deadline = time.monotonic() + 10
    while queue.is_active:
        assert time.monotonic() < deadline
        if engine.calls[-1:] == ["start"]:
            engine.ended = ended()
            engine.show(state=State.ALARM)
        queue.watch(engine.snapshot(), engine.outcome())
        time.sleep(0.001)
    assert "alarm: cure" in queue.why and queue.entries[1].state == "waiting"
    queue.start()
    assert not queue.is_active and "cannot start in an alarm" in said[-1]
    engine.show(state=State.ABORTED)
    queue.start()
    assert queue.is_active and not queue.why


def test_what_never_gets_ready_does_not_block_the_queue(monkeypatch: pytest.MonkeyPatch) -> None:
    class Deaf(FakeEngine):
        def load(self, path: str, wanted: Callable[[], bool] = lambda: True) -> Job:
            job = super().load(path)
            self.show(state=State.ABORTED)
            return job

    monkeypatch.setattr("tui.job_queue.READY_S", 0.05)
    engine = Deaf()
    queue = JobQueue(engine, Words("en"), lambda _: None)
    queue.add("a.nc")
    run(queue, engine, 10)
    assert "a.nc is not ready" in queue.why and queue.entries[0].state == "waiting" and "start" not in engine.calls


@pytest.mark.parametrize("keys", [["space"], ["escape"], ["ctrl+x", "enter"]])
def test_hold_and_reset_between_two_jobs_start_nothing(keys: list[str]) -> None:
    go = threading.Event()

    class Slow(FakeEngine):
        def load(self, path: str, wanted: Callable[[], bool] = lambda: True) -> Job:
            assert path != "a.nc" or go.wait(10)
            return super().load(path)

    async def script(stage: Stage) -> None:
        await stage.load()
        queue = stage.app.jobs.queue
        queue.add("a.nc")
        await stage.press("f2", "ctrl+r", "f3")
        await stage.press(*keys)
        go.set()
        await stage.until(lambda: queue._current is None)
        assert queue.entries[0].state == "waiting" and "start" not in stage.engine.calls
        await stage.press("f2", "ctrl+l", "ctrl+l")
        text = await stage.frame()
        assert "STANDS: hold or reset before the next job" in text
        await stage.press("ctrl+r")
        await stage.until(lambda: "start" in stage.engine.calls)
        assert "STANDS" not in await stage.frame()

    play(script, Slow())


def test_the_chosen_entry_says_whole_why_it_was_refused() -> None:
    async def script(stage: Stage) -> None:
        stage.app.jobs.queue.add("bad.nc")
        await stage.press("f2", "ctrl+l", "ctrl+l", "ctrl+r")
        await stage.until(lambda: not stage.app.jobs.queue.is_active)
        text = " ".join((await stage.frame()).split())
        assert "bad.nc:4:11: GC801: axis W is not configured" in text and "choose a machine" in text

    play(script, size=NARROW)


@pytest.mark.parametrize("size", [WIDE, NARROW])
@pytest.mark.parametrize("language", ["en", "de"])
def test_entries_move_and_are_dropped(size: tuple[int, int], language: str) -> None:
    async def script(stage: Stage) -> None:
        queue = stage.app.jobs.queue

        def names() -> str:
            return "".join(entry.path for entry in queue.entries)

        for name in "abc":
            queue.add(name)
        await stage.press("f2", "ctrl+p")
        assert "^L" in stage.message and names() == "abc", "it says where entries move"
        await stage.press("ctrl+l", "ctrl+l", "ctrl+p")
        assert names() == "abc", "the first stays the first"
        await stage.press("ctrl+d", "shift+down", "ctrl+d")
        assert names() == "bca", "the cursor goes with the entry, to the end"
        await stage.press("shift+up")
        assert names() == "bac"
        await stage.press("ctrl+n")
        assert names() == "bc"
        failed = queue.entries[0]
        failed.state, failed.verdict, failed.detail = "done", "FAIL", "max 61.2 um @L9, 3.1 s"
        queue.why = "b: FAIL"
        same_frame(f"queue-{'wide' if size is WIDE else 'narrow'}-{language}", await stage.frame())

    play(script, size=size, language=language)


def test_keys_of_the_queue(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.nc").write_text(GOOD)

    async def script(stage: Stage) -> None:
        await stage.press("f2", "ctrl+n", "ctrl+n", "ctrl+l", "ctrl+l")
        assert [entry.path for entry in stage.app.jobs.queue.entries] == ["a.nc", "a.nc"]
        text = await stage.frame()
        assert "[queue 2]" in text and text.count("a.nc") == 3  # with the message
        await stage.press("ctrl+n", "ctrl+t")
        assert len(stage.app.jobs.queue.entries) == 1 and "stops at failure" in await stage.frame()
        await stage.press("ctrl+r")
        await stage.until(lambda: "start" in stage.engine.calls)
        stage.engine.ended = ended()
        await stage.until(lambda: not stage.app.jobs.queue.is_active)
        assert stage.engine.calls == ["load a.nc", "start"]
        assert "PASS" in await stage.frame() and "Queue done: 1 of 1 good" in stage.message

    play(script)


def test_no_queue_while_a_job_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.nc").write_text(GOOD)

    async def script(stage: Stage) -> None:
        stage.engine.run_half()
        await stage.press("f2", "ctrl+r")
        assert "The queue is empty" in stage.message
        await stage.press("ctrl+n", "ctrl+r")
        assert "A job is under way" in stage.message and not stage.engine.calls

    play(script)


def test_recent_jobs_and_their_verdicts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "contour.nc").write_text(GOOD)
    history = History(tmp_path / "h")
    history.add_run(ended().run, "contour.nc", "run", 0)
    history.add_run(ended().run | {"verdict": {"word": "FAIL"}}, "/parts/other.nc", "run", 1)
    archive = Archive(tmp_path / "h", "en")

    async def script(stage: Stage) -> None:
        archive.wait()
        await stage.press("f2")
        row = next(row for row in (await stage.frame()).splitlines() if "contour.nc" in row)
        assert "DIN 66025" in row and row.endswith("PASS") and " 51 B" in row
        await stage.press("ctrl+l")
        text = await stage.frame()
        assert "[recent]" in text and text.index("/parts/other.nc") < text.index("contour.nc")
        await stage.press(*"contour", "enter")
        assert "/parts/other.nc" not in await stage.frame()
        await stage.until(lambda: stage.engine.calls == [f"load {tmp_path / 'contour.nc'}"])

    play(script, archive=archive)
    archive.close()
    assert len(history.runs(Filter())) == 2


@pytest.mark.parametrize("size", [WIDE, NARROW])
@pytest.mark.parametrize("language", ["en", "de"])
def test_the_load_check(size: tuple[int, int], language: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the real compiler: extents against limits, tools, feeds, modes; findings with block, column and caret."""
    monkeypatch.chdir(tmp_path)
    text = "N10 G90 G21 G17\nN15 T2 M06\nN20 G0 X10 Y5\nN30 G1 X40 F3000\nN30 G1 Z-5 F200\nN40 M30\n"
    (tmp_path / "check.nc").write_text(text)
    engine = SimEngine(speed=0)
    try:
        job = engine.load("check.nc")
        assert engine.wait(20, lambda s: s.time_total_s is not None)
        fake = FakeEngine()
        fake.job = job
        reported = engine.snapshot()
    finally:
        engine.close()

    async def script(stage: Stage) -> None:
        await stage.load("check.nc")
        fake.show(time_total_s=reported.time_total_s, path_total_mm=reported.path_total_mm)
        await stage.press("f2")
        shown = await stage.frame()
        assert "X mm" in shown and "-600.000 .. +600.000" in shown and "T2" in shown and "F 200 .. 3000" in shown
        same_frame(f"check-{'wide' if size is WIDE else 'narrow'}-{language}", shown)

    play(script, fake, size=size, language=language)


def test_a_long_load_says_so_and_can_be_let_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is let go, or overtaken by a newer load, never replaces the job later."""
    go, wants = threading.Event(), []
    path = tmp_path / "big.nc"
    path.write_bytes(b"x" * 1_500_000)

    class Slow(FakeEngine):
        def load(self, path: str, wanted: Callable[[], bool] = lambda: True) -> Job:
            if "big" in path:
                wants.append(wanted)
                assert go.wait(30)
                if not wanted():
                    raise UsageError("not wanted any more")
            return super().load(path)

    async def script(stage: Stage) -> None:
        app, engine = stage.app, stage.engine
        app.load(str(path))
        await stage.until(lambda: wants)
        assert "loading" in stage.message and "Esc" not in stage.message
        monkeypatch.setattr("tui.loading.SHORT_S", 0.0)
        assert "big.nc: 1.5 MB, 0 s so far   Esc lets it go" in stage.message
        await stage.press("escape")
        assert not wants[0]() and "hold" in engine.calls, "Esc holds, whatever else it does"
        assert "big.nc: not loaded" in stage.message
        await stage.load()
        app.load(str(path))
        await stage.until(lambda: len(wants) == 2)
        app.load("bracket_07.nc")
        go.set()
        await stage.until(lambda: not app.loading.is_active)
        assert not wants[1]()
        await stage.until(lambda: not any(worker.is_running for worker in app.workers))
        assert "not wanted" not in stage.message and "1940.8 mm" in stage.message

    play(script, Slow(), size=NARROW)
