"""`run --scan`: resources in the recording, a topic of their own for plots."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from cnc_front.errors import Exit
from cnc_front.recording import open_recording
from tests.app.conftest import Cli

PART = "G21 G90 G94\nG1 X20 Y5 F3000\nG1 X0\nM30\n"


@pytest.fixture
def part(tmp_path: Path) -> Path:
    path = tmp_path / "part.nc"
    path.write_text(PART)
    return path


def messages(path: Path, topic: str) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Messages of a topic, as the stock reader gives them, and their schema."""
    with path.open("rb") as file:
        found = list(make_reader(file).iter_messages(topics=[topic]))
    schema = json.loads(found[0][0].data) if found and found[0][0] else {}
    return [json.loads(message.data) for _, _, message in found], schema


def test_a_message_a_sample(cli: Cli, part: Path) -> None:
    recording = part.with_suffix(".mcap")
    scan = "dp.X,rp.Y,scntr, cp.X.3.0"
    done = cli("run", part, "--record", recording, "--scan", scan)
    assert done.code == Exit.DONE, done.err
    rows, schema = messages(recording, "/scan")
    assert set(schema["properties"]) == set(rows[0]) == {"t_s", "dp_X", "rp_Y", "scntr", "cp_X_3_0"}
    columns = list(open_recording(str(recording)).columns())
    dp, rp = (np.vstack([c[name] for c in columns]) for name in ("dp", "rp"))
    assert len(rows) == len(dp) > 500
    assert np.array_equal([r["dp_X"] for r in rows], dp[:, 0]) and np.array_equal([r["rp_Y"] for r in rows], rp[:, 1])
    assert [r["scntr"] for r in rows] == list(range(1, len(dp) + 1))
    assert np.allclose([r["t_s"] for r in rows], (np.arange(len(dp)) + 1) * 1.28e-3, atol=1e-9)


def test_what_is_busy_is_null(cli: Cli, part: Path) -> None:
    recording = part.with_suffix(".mcap")
    part.with_suffix(".stim").write_text("at 0.1 s: input 14 pulsing 100 Hz\n")
    assert cli("run", part, "--record", recording, "--scan", "WTLSTRB.0,dp.X").code == Exit.DONE
    rows, _ = messages(recording, "/scan")
    busy = [row["dp_X"] is None for row in rows]
    assert all(busy[:78]) and 0.8 < np.mean(busy) < 0.95


def test_without_scan_there_is_no_topic_and_the_same_bytes(cli: Cli, part: Path) -> None:
    first, second = part.with_suffix(".a.mcap"), part.with_suffix(".b.mcap")
    for recording in (first, second):
        assert cli("run", part, "--record", recording).code == Exit.DONE
    assert messages(first, "/scan")[0] == []
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize(
    ("names", "words"),
    [("dp.Q", "no axis Q; it has X, Y, Z"), ("dq.X", "did you mean"), ("AOUT.0", "code 1"), ("", "no resource")],
)
def test_what_cannot_be_scanned_is_a_usage_error(cli: Cli, part: Path, names: str, words: str) -> None:
    recording = part.with_suffix(".mcap")
    done = cli("run", part, "--record", recording, "--scan", names)
    assert done.code == Exit.BAD_INPUT and words in done.err and "--scan" in done.err
    assert not recording.exists()
    done = cli("run", part, "--scan", "dp.X")
    assert done.code == Exit.BAD_INPUT and "--record" in done.err
