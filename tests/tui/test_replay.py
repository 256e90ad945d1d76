"""A recording on the Run screen: what it shows, what it refuses, and damaged files."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cnc_front.engine import State
from cnc_front.errors import CompileError, UsageError
from cnc_front.recording import open_recording
from cnc_front.replay import ReplayEngine
from tests.app.conftest import ROOT
from tests.tui.stage import NARROW, Stage, play, same_frame

ONLY = {"en": "a recording is only shown", "de": "eine Aufzeichnung wird nur gezeigt"}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("replay") / "cam.mcap"
    job = str(ROOT / "examples/jobs/cam.nc")
    subprocess.run([sys.executable, "-m", "cnc_front", "run", job, "--record", str(path)], cwd=ROOT, check=True)
    return path


def ended(path: Path, language: str = "en") -> ReplayEngine:
    engine = ReplayEngine(str(path), language=language, speed=0.0)
    engine.start()
    assert engine.wait(60.0, lambda s: s.state in (State.DONE, State.ABORTED))
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

    play(script, engine, NARROW, language=language)  # type: ignore[arg-type]
    engine.close()


@pytest.mark.parametrize("language", ["en", "de"])
def test_the_end_as_it_looks(recording: Path, language: str) -> None:
    engine = ended(recording, language)

    async def script(stage: Stage) -> None:
        stage.app.tick()
        same_frame(f"replay-done-narrow-{language}", await stage.frame())

    play(script, engine, NARROW, language=language)  # type: ignore[arg-type]
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
    path = tmp_path / "short.mcap"
    job = str(ROOT / "examples/jobs/cam.nc")
    limit = ["--record", str(path), "--max-time", "3"]
    subprocess.run([sys.executable, "-m", "cnc_front", "run", job, *limit], cwd=ROOT, check=False)
    engine = ended(path)
    assert engine.snapshot().state is State.ABORTED and "ends early" in engine.snapshot().message
    engine.close()
