"""Recordings: the stock MCAP reader opens them, a cut one yields its first part, the same run gives the same bytes."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader

from cnc_front._native import recording as native
from cnc_front.deliver import report_from_recording
from cnc_front.errors import CompileError
from cnc_front.execution import Execution
from cnc_front.jobs import CompileOptions, compile_job, load_machine, read_job
from cnc_front.recording import open_recording
from tests.app.conftest import ROOT, Cli

CAM = ROOT / "examples/jobs/cam.nc"


@pytest.fixture(scope="module")
def recorded(cli: Cli, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    """A recording of the cam with an override schedule, and the object of its run."""
    path = tmp_path_factory.mktemp("recording") / "cam.mcap"
    ran = cli("run", CAM, "--record", path, "--override", "0:1,5:0.5,9:1.2", "--json")
    assert ran.code == 0
    return path, ran.object


def test_the_stock_reader_reads_it(recorded: tuple[Path, dict]) -> None:
    path, run = recorded
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        topics = {channel.topic: channel for channel in summary.channels.values()}
        assert set(topics) == {"/columns", "/state", "/events"}
        assert summary.schemas[topics["/state"].schema_id].encoding == "jsonschema"
        attached = ["job", "machine.toml", "sequence.npz", "modal.npz", "result.json"]
        assert [a.name for a in reader.iter_attachments()] == attached
        times, worst = [], 0.0
        for _, _, message in reader.iter_messages(topics=["/state"]):
            state = json.loads(message.data)
            times.append(message.log_time)
            worst = max(worst, state["deviation_um"])
            assert set(state["axes"]) == {"X", "Y", "Z"}
    assert times == sorted(times)
    assert times[-1] == pytest.approx(run["machine_time_s"] * 1e9, rel=1e-3)
    assert worst == pytest.approx(run["deviation"]["actual"]["max_mm"] * 1e3, abs=1e-3)


def test_its_columns_are_the_samples_of_the_run(recorded: tuple[Path, dict]) -> None:
    path, run = recorded
    job = compile_job(read_job(str(CAM)), load_machine(None), CompileOptions())
    execution = Execution(job, ((0.0, 1.0), (5.0, 0.5), (9.0, 1.2)))
    chunks = []
    while (chunk := execution.advance(50_000)) is not None:
        chunks.append(chunk)
    for name in ("dp", "load", "rp", "factor", "line", "entry"):
        wanted = np.concatenate([getattr(chunk, name) for chunk in chunks])
        found = np.concatenate([columns[name] for columns in open_recording(str(path)).columns()])
        assert np.array_equal(wanted, found), name
    assert len(wanted) == run["samples"]


def test_a_cut_recording_yields_its_first_part(recorded: tuple[Path, dict], tmp_path: Path) -> None:
    path, run = recorded
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    ours = open_recording(str(cut))
    samples = sum(len(columns["flags"]) for columns in ours.columns())
    assert 0.3 * run["samples"] < samples < run["samples"]
    assert ours.damage and ours.job == CAM.read_bytes() and ours.result is None
    messages = 0
    with cut.open("rb") as file, pytest.raises(McapError):
        for _ in NonSeekingReader(file).iter_messages(log_time_order=False):
            messages += 1
    assert messages > 100


def test_the_same_run_gives_the_same_bytes(cli: Cli, tmp_path: Path, job: Callable[..., Path]) -> None:
    part = job("G1 X10 F600\nG3 X10 I-3 J0\nM30\n")
    for name in ("a", "b"):
        assert cli("run", part, "--record", tmp_path / f"{name}.mcap").code == 0
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_a_full_disk_is_an_answer_not_a_traceback(tmp_path: Path) -> None:
    """The file may grow to 300 kB: the error arises in the thread that writes, and comes with a later call."""
    limited = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000));"
    run = "from cnc_front.cli import run_command_line; sys.exit(run_command_line(sys.argv[1:]))"
    path = tmp_path / "cam.mcap"
    command = [sys.executable, "-c", limited + run, "run", CAM, "--record", path]
    ran = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=120)
    assert ran.returncode == 3 and "Traceback" not in ran.stderr
    assert f"cnc-front: {path}: File too large" in ran.stderr
    assert path.stat().st_size == 300_000


def test_after_an_error_a_recording_stays_closed(tmp_path: Path) -> None:
    write = """
import resource, sys
from cnc_front._native import recording
from cnc_front.execution import Execution
from cnc_front.jobs import CompileOptions, compile_job, load_machine, read_job
import numpy as np
execution = Execution(compile_job(read_job(sys.argv[1]), load_machine(None), CompileOptions()))
chunk = max(iter(lambda: execution.advance(50_000), None), key=len)
writer = recording.Writer(sys.argv[2], ["X", "Y", "Z"], 1.28e-3, [], {})
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
errors = []
for _ in range(20):
    try:
        writer.write(chunk, np.zeros(len(chunk), np.float32))
    except (OSError, ValueError) as error:
        errors.append(type(error).__name__)
try:
    writer.finish("{}")
except ValueError as error:
    errors.append(str(error))
print(errors)
"""
    command = [sys.executable, "-c", write, CAM, tmp_path / "r.mcap"]
    ran = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=120)
    errors = ast.literal_eval(ran.stdout)
    assert errors[0] == "OSError" and set(errors[1:-1]) == {"ValueError"}
    assert errors[-1] == "the recording has ended after an error"


def test_damage_anywhere_is_an_answer_not_a_traceback(cli: Cli, tmp_path: Path, job: Callable[..., Path]) -> None:
    assert cli("run", job("G1 X10 F600\nG3 X10 I-3 J0\nM30\n"), "--record", tmp_path / "r.mcap").code == 0
    whole = (tmp_path / "r.mcap").read_bytes()
    bad = tmp_path / "bad.mcap"
    refused = answered = 0
    for at in [*range(0, len(whole), len(whole) // 60), *range(len(whole) - 2000, len(whole), 150)]:
        for damaged in (whole[:at], whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :]):
            bad.write_bytes(damaged)
            try:
                report_from_recording(str(bad), tmp_path / "report", "en")
                answered += 1
            except CompileError as error:
                refused += 1
                assert error.diagnostics[0].id == "CF401"
    assert refused > 5 and answered > 5


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("machine.toml", b"[machine"),
        ("machine.toml", b"\xff\x00"),
        ("sequence.npz", b"PK\x03\x04 no such thing"),
        ("sequence.npz", b""),
        ("result.json", b"[]"),
        ("result.json", b'{"schema": "cnc-front/run/1"}'),
        ("result.json", b"{"),
        ("tolerance_mm", b"?"),
        ("schedule", b"[[1]]"),
    ],
)
def test_a_sound_file_with_senseless_content_is_refused(
    recorded: tuple[Path, dict], tmp_path: Path, name: str, content: bytes
) -> None:
    """Checksums cannot find that."""
    with recorded[0].open("rb") as file:
        reader = make_reader(file)
        attached = {a.name: a.data for a in reader.iter_attachments()}
        metadata = next(m.metadata for m in reader.iter_metadata() if m.name == "run")
    for have in (attached, metadata):
        if name in have:
            have[name] = content if have is attached else content.decode()  # type: ignore[assignment]
    result = attached.pop("result.json").decode()
    files = [(n, "", data) for n, data in attached.items()]
    native.Writer(tmp_path / "f.mcap", ["X", "Y", "Z"], 1.28e-3, files, metadata).finish(result)
    with pytest.raises(CompileError, match="CF401"):
        report_from_recording(str(tmp_path / "f.mcap"), tmp_path / "report", "en")
    assert not (tmp_path / "report").exists()


@pytest.mark.parametrize("content", [b"", b"G0 X1\n", b"\x89MCAP0\r\n", bytes(range(256)) * 40])
def test_what_is_no_recording_is_refused(cli: Cli, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "no.mcap"
    path.write_bytes(content)
    ran = cli("report", path, tmp_path / "report")
    assert ran.code == 2
    assert f"{path}:1:1: CF401:" in ran.err and "hint:" in ran.err
    assert not (tmp_path / "report").exists()


def test_events_tell_what_the_program_announced(recorded: tuple[Path, dict]) -> None:
    recording = open_recording(str(recorded[0]))
    for _ in recording.columns():
        pass
    kinds = [event["name"] for event in recording.events if event["kind"] == "host"]
    assert kinds.count("M06") == 3 and kinds[-1] == "M30"
