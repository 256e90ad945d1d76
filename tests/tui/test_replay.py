"""A recording on the Run screen: what it shows, what it refuses, and damaged files."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cnc_front.console import Console
from cnc_front.engine import Snapshot, State
from cnc_front.errors import CompileError, UsageError
from cnc_front.history import Filter, History
from cnc_front.recording import open_recording
from cnc_front.reel import Film
from cnc_front.replay import ReplayEngine
from cnc_front.sim import SimEngine
from tests.app.conftest import ROOT
from tests.tui.stage import NARROW, Stage, play, same_frame
from tui.archive import Archive

ONLY = {"en": "a recording is only shown", "de": "eine Aufzeichnung wird nur gezeigt"}
FAULTS = ROOT / "examples/faults"


def recorded(target: Path, job: Path, *options: str) -> Path:
    """Runs a job and records it."""
    command = [sys.executable, "-m", "cnc_front", "run", "-q", "--history", "off", "--record", str(target), *options]
    subprocess.run([*command, str(job)], cwd=ROOT, check=False, capture_output=True)
    assert target.is_file()
    return target


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("replay") / "cam.mcap", ROOT / "examples/jobs/cam.nc")


def ended(path: Path, language: str = "en") -> ReplayEngine:
    engine = ReplayEngine(str(path), language=language, speed=0.0)
    engine.start()
    assert engine.wait(60.0, lambda s: s.state in (State.DONE, State.ABORTED, State.ALARM))
    return engine


def test_its_values_are_the_recorded_ones(recording: Path) -> None:
    engine = ended(recording)
    s = engine.snapshot()
    chunks = list(open_recording(str(recording)).columns())
    assert s.state is State.DONE
    assert [axis.actual for axis in s.axes] == list(chunks[-1]["rp"][-1])
    assert s.deviation_max_mm == max(float(np.max(c["deviation_mm"])) for c in chunks if len(c["flags"]))
    assert s.machine_time_s == pytest.approx(s.time_total_s)
    assert engine.new_deviation(0)[0] > 0.9 * len(engine.current_job().plot.points)  # type: ignore[union-attr]
    engine.close()


@pytest.mark.parametrize("language", ["en", "de"])
def test_the_run_screen_replays_and_refuses(recording: Path, language: str) -> None:
    engine = ReplayEngine(str(recording), language=language)

    async def script(stage: Stage) -> None:
        same_frame(f"replay-ready-narrow-{language}", await stage.frame())
        await stage.press("r")
        await stage.until(lambda: engine.snapshot().machine_time_s > 0.2)
        await stage.press("space")
        assert engine.snapshot().state is State.HOLD
        stood = engine.snapshot().machine_time_s
        await stage.press("plus")
        assert ONLY[language] in stage.message and engine.snapshot().override_set == 1.0
        await stage.press("full_stop")
        assert "[REPLAY x2]" in stage.text and engine.snapshot().machine_time_s == stood

    play(script, engine, NARROW, language=language)
    engine.close()


@pytest.mark.parametrize("language", ["en", "de"])
def test_the_end_as_it_looks(recording: Path, language: str) -> None:
    engine = ended(recording, language)

    async def script(stage: Stage) -> None:
        stage.app.tick()
        same_frame(f"replay-done-narrow-{language}", await stage.frame())

    play(script, engine, NARROW, language=language)
    engine.close()


@pytest.mark.parametrize("seed", range(8))
def test_damage_ends_the_replay_and_nothing_else(recording: Path, tmp_path: Path, seed: int) -> None:
    data = bytearray(recording.read_bytes())
    for place in np.random.default_rng(seed).integers(0, len(data), 5):
        data[place] ^= 0x55
    (tmp_path / "bent.mcap").write_bytes(data)
    try:
        engine = ended(tmp_path / "bent.mcap")
    except CompileError:
        return
    assert engine.snapshot().state in (State.DONE, State.ABORTED)
    assert "internal" not in engine.snapshot().message
    engine.close()


def test_a_cut_recording_says_so(recording: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.read_bytes()[: recording.stat().st_size * 2 // 3])
    engine = ended(cut)
    assert engine.snapshot().state is State.ABORTED and "ends early" in engine.snapshot().message
    engine.close()


def test_a_file_that_is_gone_is_said_and_nothing_breaks(recording: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy.mcap"
    copy.write_bytes(recording.read_bytes())
    engine = ended(copy)
    copy.unlink()
    engine.start()
    assert engine.snapshot().state is State.ABORTED and "file not found" in engine.snapshot().message
    engine.close()


def test_motion_is_refused(recording: Path) -> None:
    engine = ReplayEngine(str(recording), language="de")
    engine.jog("X", 1.0)
    assert ONLY["de"] in engine.snapshot().message and engine.snapshot().axes[0].actual == 0.0
    with pytest.raises(UsageError, match=ONLY["de"]):
        engine.check_mdi("G0 X1")
    with pytest.raises(UsageError, match=ONLY["de"]):
        engine.load("other.nc")
    engine.close()


def test_no_recording_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "bad.mcap").write_bytes(b"nothing")
    with pytest.raises(CompileError, match="CF401"):
        ReplayEngine(str(tmp_path / "bad.mcap"))


def test_a_run_that_was_stopped_is_not_done(tmp_path: Path) -> None:
    path = recorded(tmp_path / "short.mcap", ROOT / "examples/jobs/cam.nc", "--max-time", "3")
    engine = ended(path, "de")
    s = engine.snapshot()
    assert s.state is State.ABORTED and "endet vorzeitig: Zeitgrenze von 3 s" in s.message
    engine.close()


# ---- what it shows beside positions


def at(engine: ReplayEngine, place: str) -> Snapshot:
    """Winds there."""
    engine.seek(place)
    assert engine.wait(30.0, lambda s: engine._wanted is None)
    return engine.snapshot()


def test_modes_tool_spindle_coolant_and_spooler_are_those_of_the_run(recording: Path) -> None:
    engine = ReplayEngine(str(recording))
    s = at(engine, "1:00")
    assert s.machine_time_s == pytest.approx(60.0, abs=1e-3) and s.state is State.HOLD
    assert s.modal.startswith("G2 G17 G90 G21") and s.tool == 1
    assert (s.spindle, s.coolant) == ("M3 S3200", "M8")
    assert all(axis.referenced and 0.01 < axis.spool_fill < 0.2 for axis in s.axes) and 10 < s.spool_empty_s < 120
    assert s.axes[0].limits == (-600.0, 600.0)
    first = at(engine, "0:30")  # back
    assert (first.tool, first.spindle) == (2, "M3 S4500")
    engine.close()


def test_an_older_recording_says_that_it_does_not_know(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    engine = ReplayEngine(str(recording))
    engine._reel.modal.clear()
    monkeypatch.setattr(Film, "_next", forgetful(Film._next))

    async def script(stage: Stage) -> None:
        at(engine, "1:00")
        text = await stage.frame()
        assert "SPOOL - %  - s" in text

    play(script, engine, NARROW)
    engine.close()


def forgetful(read: Callable[[Film], bool]) -> Callable[[Film], bool]:
    def without(film: Film) -> bool:
        more = read(film)
        film.standing = []
        return more

    return without


@pytest.mark.parametrize(("language", "words"), [("en", "stopped by fault mpe X"), ("de", "Störung mpe X")])
def test_a_fault_comes_at_its_time_and_ends_it(tmp_path: Path, language: str, words: str) -> None:
    options = ("--machine", str(FAULTS / "machine.toml"), "--stimulus", str(FAULTS / "blocked_axis.stim"))
    engine = ReplayEngine(str(recorded(tmp_path / "f.mcap", FAULTS / "contour.nc", *options)), language=language)
    assert not at(engine, "0.4").alarms
    s = at(engine, "0.6")
    assert [(a.code, a.axis, a.line, a.stopped) for a in s.alarms] == [("E107", "X", 5, True)]
    assert (
        "mpe" in s.axes[0].bits
        and "1.0" in s.alarms[0].text
        and "> 1 mm" in s.alarms[0].text
        and s.alarms[0].t_s == pytest.approx(0.506, abs=2e-3)
    )
    assert not at(engine, "0.4").alarms  # wound back, it has not happened yet

    async def script(stage: Stage) -> None:
        await stage.press("r")
        await stage.until(lambda: engine.snapshot().state is State.ALARM)
        assert words in stage.message
        await stage.press("6")
        text = await stage.frame()
        assert "E107 X  L5" in text and "0.506 s" in text

    play(script, engine, NARROW, language=language)
    engine.close()


def test_winding_to_times_and_blocks(recording: Path) -> None:
    engine = ReplayEngine(str(recording))
    s = at(engine, "N390")
    lines = engine.job.lines
    assert lines[s.line - 1].startswith("N390 ")
    began = s.machine_time_s
    assert at(engine, f"L{s.line}").line == s.line
    assert at(engine, f"L{s.line}").machine_time_s == pytest.approx(began)  # it runs once: from behind it the same
    assert at(engine, "+5").machine_time_s == pytest.approx(began + 5, abs=2e-3)
    assert at(engine, "-7.5").machine_time_s == pytest.approx(began - 2.5, abs=3e-3)
    assert at(engine, "-999").machine_time_s == 0.0
    end = at(engine, "99:00")
    assert end.machine_time_s == pytest.approx(end.time_total_s)
    for wrong in ("", "N", "N4711", "x", "1:x", "1e400", "nan"):
        with pytest.raises(UsageError):
            engine.seek(wrong)
    engine.close()


def test_what_stands_is_not_stale(recording: Path) -> None:
    engine = ReplayEngine(str(recording))
    first = at(engine, "0:30")
    assert engine.wait(3.0, lambda s: s is not first) and engine.snapshot().axes == first.axes
    engine.close()


def test_the_deviation_of_the_path_is_that_of_a_run_to_there(recording: Path) -> None:
    straight, wound = ReplayEngine(str(recording)), ReplayEngine(str(recording))
    at(wound, "2:00")
    at(wound, "0:10")
    a, b = at(straight, "0:50"), at(wound, "0:50")
    assert (a.deviation_max_mm, a.line, a.axes) == (b.deviation_max_mm, b.line, b.axes)
    assert np.array_equal(straight.new_deviation(0)[1], wound.new_deviation(0)[1], equal_nan=True)
    straight.close(), wound.close()


def test_keys_wind_step_and_ask_for_a_place(recording: Path) -> None:
    engine = ReplayEngine(str(recording), speed=0.0)

    async def script(stage: Stage) -> None:
        await stage.press("m", "m")
        await stage.until(lambda: abs(engine.snapshot().machine_time_s - 10) < 0.01)
        await stage.press("u")
        await stage.until(lambda: abs(engine.snapshot().machine_time_s - 5) < 0.01)
        await stage.press("G", *"N390", "enter")
        await stage.until(lambda: engine.snapshot().machine_time_s > 60)
        line = engine.snapshot().line
        await stage.press("t")
        await stage.until(lambda: engine.snapshot().state is State.STEP)
        assert engine.snapshot().line == line  # at its end
        await stage.press("t")
        await stage.until(lambda: engine.snapshot().line == line + 1 and engine.snapshot().state is State.STEP)
        await stage.press("G", *"gibberish", "enter")
        assert "is no time" in stage.message

    play(script, engine, NARROW)
    engine.close()


# ---- rw_SymPas


@pytest.mark.parametrize("job", ["contour", "talk"])
def test_a_sympas_job_with_its_source_line(tmp_path: Path, job: str) -> None:
    cell = ROOT / "examples/cell"
    options = ("--machine", str(cell / "machine.toml"), "--max-time", "6")
    engine = ReplayEngine(str(recorded(tmp_path / "s.mcap", cell / f"{job}.src", *options)))
    s = at(engine, "3")
    text = engine.job.lines[s.line - 1]
    assert ("repeat wt(100)" if job == "contour" else "CI2") in text or "wrcbd" in text or "wt(" in text
    assert not any(axis.referenced for axis in s.axes)
    assert len(engine.job.plot.points) == 0 or engine.new_deviation(0)[0] > 0
    engine.close()


def test_a_runtime_error_names_task_and_include(tmp_path: Path) -> None:
    (tmp_path / "half.inc").write_text("procedure Half;\nbegin\n  CI0 := 1 / CI1;\nend;\n")
    (tmp_path / "fails.src").write_text("{$I half.inc}\nbegin\n  wt(1000);\n  Half;\nend.\n")
    (tmp_path / "job.src").write_text("begin\n  cl(X);\n  jaw(X := 5.0);\nend.\n")
    target = recorded(tmp_path / "s.mcap", tmp_path / "job.src", "--task", f"2={tmp_path / 'fails.src'}")
    engine = ReplayEngine(str(target))
    message = at(engine, "0.2").message
    assert "task 2" in message and f"line 3 ({tmp_path / 'half.inc'})" in message
    engine.close()


# ---- how it is opened


def test_a_recording_is_opened_from_jobs_and_put_away_again(recording: Path) -> None:
    console = Console(SimEngine(speed=0.0))

    async def script(stage: Stage) -> None:
        await stage.press("2", *str(recording), "ctrl+n")
        assert "not run" in stage.message and not stage.app.jobs.queue.entries
        await stage.press("enter")
        await stage.until(lambda: console.snapshot().replay)
        await stage.until(lambda: stage.app.page.name == "run" and stage.app.job is not None)
        assert "[REPLAY max]" in await stage.frame()
        await stage.press("ctrl+x", "enter")
        await stage.until(lambda: not console.snapshot().replay)
        text = await stage.frame()
        assert "[SIM max]" in text and "No job" in text
        await stage.press("2")
        stage.app.load(str(ROOT / "examples/jobs/bracket.nc"))
        await stage.until(lambda: stage.app.job is not None and stage.app.job.name == "bracket.nc")
        stage.app.load(str(recording))
        await stage.until(lambda: console.snapshot().replay)
        stage.app.load(str(ROOT / "examples/jobs/bracket.nc"))  # also while it plays
        await stage.press("r")
        await stage.until(lambda: not console.snapshot().replay and console.snapshot().state is not State.NO_JOB)

    play(script, console)
    console.close()


def test_what_is_no_recording_leaves_what_was_shown(recording: Path, tmp_path: Path) -> None:
    console = Console(SimEngine())
    console.load(str(recording))
    bad = tmp_path / "bad.mcap"
    bad.write_bytes(b"nothing")
    with pytest.raises(CompileError, match="CF401"):
        console.load(str(bad))
    assert console.snapshot().replay
    console.close()


def test_alarms_of_a_recording_are_not_kept_twice(tmp_path: Path) -> None:
    options = ("--machine", str(FAULTS / "machine.toml"), "--stimulus", str(FAULTS / "blocked_axis.stim"))
    engine = ended(recorded(tmp_path / "f.mcap", FAULTS / "contour.nc", *options))
    archive = Archive(tmp_path / "h.sqlite", "en")

    async def script(stage: Stage) -> None:
        await stage.until(lambda: stage.app.keeper.book.entries)

    play(script, engine, archive=archive)
    archive.close()
    engine.close()
    assert History(tmp_path / "h.sqlite").alarms(Filter()) == []


# ---- runs of the terminal, with what the operator did


def test_a_run_of_the_terminal_is_recorded_with_what_the_operator_did(tmp_path: Path) -> None:
    engine = SimEngine(speed=0.0, recordings=tmp_path)
    engine.load(str(FAULTS / "contour.nc"))
    engine.set_speed(20.0)
    assert engine.wait(10, lambda s: s.state is State.READY)
    engine.start()
    assert engine.wait(10, lambda s: s.machine_time_s > 0.5)
    engine.set_override(0.5)
    engine.hold()
    assert engine.wait(10, lambda s: s.state is State.HOLD)
    engine.resume()
    engine.set_speed(0.0)
    assert engine.wait(30, lambda s: s.state is State.DONE) and engine.wait(5, lambda _: engine.outcome() is not None)
    outcome = engine.outcome()
    assert outcome is not None and outcome.run["files"]["recording"] == str(tmp_path / "contour-1.mcap")
    final = engine.snapshot()
    engine.close()

    replay = ReplayEngine(str(tmp_path / "contour-1.mcap"))
    did = {e["name"]: e for e in replay._reel.index.events if e["kind"] == "operator"}
    assert list(did) == ["start", "override", "hold", "resume"] and did["override"]["value"] == 50
    assert "feed hold" in at(replay, str(did["hold"]["t_s"] + 0.01)).message
    assert at(replay, str(did["start"]["t_s"])).override_set == 1.0
    assert at(replay, str(did["override"]["t_s"] + 0.5)).override_set == 0.5
    end = at(replay, "9:00")
    assert end.deviation_max_mm == final.deviation_max_mm and end.machine_time_s == final.machine_time_s
    replay.start()
    assert replay.wait(10, lambda s: s.state is State.DONE)
    replay.close()


def test_slices_of_any_length_make_the_same_samples(tmp_path: Path) -> None:
    path = recorded(tmp_path / "run.mcap", FAULTS / "contour.nc")
    (tmp_path / "t").mkdir()
    engine = SimEngine(speed=0.0, recordings=tmp_path / "t")
    engine.load(str(FAULTS / "contour.nc"))
    engine.start()
    assert engine.wait(30, lambda s: s.state is State.DONE) and engine.wait(5, lambda _: engine.outcome() is not None)
    engine.close()
    whole, sliced = ([*open_recording(str(p)).columns()] for p in (path, tmp_path / "t" / "contour-1.mcap"))
    for name in ("dp", "load", "rp", "line", "flags", "deviation_mm"):
        a, b = (np.concatenate([columns[name] for columns in chunks]) for chunks in (whole, sliced))
        assert np.array_equal(a, b), name


def test_a_full_disk_ends_the_recording_not_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("cnc_front.recording.RecordingSink.tell", full)
    engine = SimEngine(speed=0.0, recordings=tmp_path)
    engine.load(str(FAULTS / "contour.nc"))
    engine.start()
    assert engine.wait(30, lambda s: s.state is State.DONE)
    assert "W302" in engine.snapshot().message and "No space left" in engine.snapshot().message
    assert engine.wait(5, lambda _: engine.outcome() is not None)
    engine.close()
