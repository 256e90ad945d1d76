"""Large programs are translated while they are read and run: the same result in memory that does not grow with them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import toolpaths
from cnc_front import jobs, recording, streaming
from cnc_front.cli import run_command_line
from cnc_front.jobs import CompileOptions, JobSource, compile_job, load_machine, read_job
from cnc_front.recording import open_recording
from cnc_front.streaming import FileSource, _hash_and_lines, streams

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples" / "jobs").glob("*.nc"))
VARIANTS = sorted(p for p in (ROOT / "tests" / "app" / "variants").iterdir() if p.suffix in (".nc", ".ngc", ".tap"))
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """Runs a command with a program streamed, or compiled whole."""

    def call(*arguments: object, whole: bool = False) -> tuple[int, str, str]:
        monkeypatch.setattr(streaming, "streams", (lambda *_: False) if whole else streams)
        capsys.readouterr()
        code = run_command_line([str(a) for a in arguments])
        out, err = capsys.readouterr()
        return code, out, err

    return call


def result(text: str) -> dict[str, Any]:
    return json.loads(text) | {"wall_time_s": None}


def zigzag(lines: int, middle: str = "", end: str = "M30\n") -> str:
    """Some cuts, a text in the middle, as many again."""
    rows = "".join(f"G1 X{n % 50}.5 Y{n % 7}.25\n" for n in range(lines // 2))
    return f"G21 G90 G17 F6000\n{rows}{middle}{rows}{end}"


@pytest.mark.parametrize("job", EXAMPLES + VARIANTS, ids=lambda path: path.name)
def test_the_result_of_a_streamed_run_is_that_of_a_whole_one(job: Path, run: Run) -> None:
    streamed, whole = run("run", "--json", job), run("run", "--json", job, whole=True)
    assert streamed[0] == whole[0]
    assert result(streamed[1]) == result(whole[1])
    assert sorted(streamed[2].splitlines()) == sorted(whole[2].splitlines())


@pytest.mark.parametrize("job", EXAMPLES + VARIANTS, ids=lambda path: path.name)
@pytest.mark.parametrize("command", [["check"], ["translate"], ["translate", "--json"]], ids=" ".join)
def test_check_and_translate_say_the_same(command: list[str], job: Path, run: Run) -> None:
    assert run(*command, job) == run(*command, job, whole=True)


@pytest.mark.parametrize(
    ("middle", "arguments"),
    [
        ('(MSG, half)\nM0\nT1 M6\nwrite "so far"\nwriteln\n', ["--override", "0:1,1:0.5,2:1.2"]),
        ("G2 X10 Y10 I5 J5\nG3 X0 Y0 I-5 J-5\nG2 X0 Y0 I20 J0\n", ["--tolerance", "0.0001"]),
        ("G4 P5000\n", ["--max-time", "4"]),
        ("G41 D1 X60 Y20\nX70\nM8\nY30\nX60\nG40 X60 Y60\n", []),
        ("G20\nG1 X1 F50\nG21\n", ["--skip", "1", "--optional-stop"]),
    ],
)
def test_stops_overrides_messages_and_limits_come_the_same(
    tmp_path: Path, run: Run, middle: str, arguments: list[str]
) -> None:
    (tmp_path / "part.nc").write_text(zigzag(800, middle))
    streamed = run("run", "--json", tmp_path / "part.nc", *arguments)
    whole = run("run", "--json", tmp_path / "part.nc", *arguments, whole=True)
    assert (streamed[0], result(streamed[1])) == (whole[0], result(whole[1]))


def test_a_fault_of_the_machine_comes_the_same(tmp_path: Path, run: Run) -> None:
    (tmp_path / "part.nc").write_text(zigzag(2000))
    cell = (ROOT / "examples" / "faults" / "machine.toml").read_text()
    (tmp_path / "machine.toml").write_text(cell)
    (tmp_path / "part.stim").write_text("at 1.5 s: input 8 on\n")
    streamed, whole = run("run", "--json", tmp_path / "part.nc"), run("run", "--json", tmp_path / "part.nc", whole=True)
    assert (streamed[0], result(streamed[1])) == (3, result(whole[1]))


@pytest.mark.parametrize("middle", ["M98 P5\n", "#1=3\nWHILE [#1 GT 0] DO1\n#1=#1-1\nEND1\n", "GOTO 5\nN5 X1\n"])
def test_a_program_that_looks_back_is_compiled_whole(tmp_path: Path, run: Run, middle: str) -> None:
    (tmp_path / "part.nc").write_text(zigzag(600, middle, "M30\nO5\nG91 G1 X1\nG90\nM99\n"))
    for command in (["run", "--json"], ["check"], ["translate"]):
        streamed, whole = run(*command, tmp_path / "part.nc"), run(*command, tmp_path / "part.nc", whole=True)
        assert streamed[0] == whole[0] == 0
        if command[0] == "run":
            assert result(streamed[1]) == result(whole[1])
        else:
            assert streamed == whole


def test_an_error_at_the_end_undoes_the_run(tmp_path: Path, run: Run) -> None:
    (tmp_path / "part.nc").write_text(zigzag(30_000, "G1 Q5\n", "G1 X1 $\nM30\n"))
    streamed, whole = run("run", "--json", tmp_path / "part.nc"), run("run", "--json", tmp_path / "part.nc", whole=True)
    assert (streamed[0], json.loads(streamed[1])) == (2, json.loads(whole[1]))
    assert streamed[2] == whole[2] and "GC326" in streamed[2] and "GC107" in streamed[2]
    assert run("translate", tmp_path / "part.nc") == run("translate", tmp_path / "part.nc", whole=True)
    assert run("translate", tmp_path / "part.nc")[1] == ""


def test_a_machine_that_is_not_ready_comes_behind_errors_of_the_text(tmp_path: Path, run: Run) -> None:
    machine = (
        (ROOT / "examples" / "machines" / "mill3.toml").read_text().replace("referenced = true", "referenced = false")
    )
    (tmp_path / "machine.toml").write_text(machine)
    for text in (zigzag(3000), zigzag(3000, "G1 Q5\n")):
        (tmp_path / "part.nc").write_text(text)
        streamed, whole = run("run", tmp_path / "part.nc"), run("run", tmp_path / "part.nc", whole=True)
        assert (streamed[0], streamed[2]) == (whole[0], whole[2])


@pytest.mark.parametrize("text", [b"", b"a", b"a\n", b"a\r\nb\r\n", b"a\rb\n\rc", b"\r\n" * 9, b"\r" * 7 + b"\n\n"])
def test_lines_and_hash_are_those_of_the_whole_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: bytes
) -> None:
    (tmp_path / "p.nc").write_bytes(text)
    source = JobSource("p.nc", text, "din66025")
    for block in (1, 2, 3, 1000):
        monkeypatch.setattr(streaming, "BLOCK", block)
        assert _hash_and_lines(str(tmp_path / "p.nc")) == (source.sha256, source.lines)


def test_a_file_that_changes_while_it_is_read_is_refused(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = tmp_path / "part.nc"
    part.write_text(zigzag(200_000))
    count = FileSource.count

    def shrink(self: FileSource) -> None:
        os.truncate(part, 1_000_000)
        count(self)

    monkeypatch.setattr(FileSource, "count", shrink)
    code, _, err = run("run", part)
    assert code == 2 and "GC114" in err and "Traceback" not in err


def child(part: Path, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "cnc_front", *arguments, str(part)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_ctrl_c_ends_a_streamed_run_with_its_result(tmp_path: Path) -> None:
    part = tmp_path / "part.nc"
    part.write_text(zigzag(600_000))
    with child(part, "run", "--json") as process:
        time.sleep(2.5)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert json.loads(out)["error"]["id"] == "CF304"


def test_the_time_limit_ends_a_streamed_run(tmp_path: Path, run: Run) -> None:
    part = tmp_path / "part.nc"
    part.write_text(zigzag(100_000))
    code, out, _ = run("run", "--json", "--max-time", "1", part)
    assert code == 3 and json.loads(out)["error"]["id"] == "CF303"


PEAK = """
import resource, sys
from cnc_front.cli import run_command_line
code = run_command_line(sys.argv[1:])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr)
sys.exit(code)
"""


def peak_mib(*arguments: str) -> float:
    """Most memory of a command."""
    done = subprocess.run(
        [sys.executable, "-c", PEAK, *arguments], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    assert done.returncode in (0, 1), done.stderr
    return int(done.stderr.split()[-1]) / 1024


@pytest.mark.parametrize("command", [["run", "-q"], ["check", "-q"], ["translate", "-q", "--json"]], ids=" ".join)
def test_memory_does_not_grow_with_the_program(tmp_path: Path, command: list[str]) -> None:
    """Five times the lines in nearly the same memory. Compiled whole, 300,000 lines take 100 MiB more."""
    rows = "".join(f"X{n % 50}.5 Y{n % 7}.25 F{5000 + n % 1000}\n" for n in range(1000))
    peaks = []
    for thousands in (60, 300):
        part = tmp_path / f"{thousands}.nc"
        part.write_text(f"G21 G90 G1 F6000\n{rows * thousands}M30\n")
        peaks.append(peak_mib(*command, str(part)))
    assert peaks[1] < peaks[0] + 25, peaks


@pytest.mark.parametrize("part", [["--from", "N20"], ["--to", "300"], ["--from", "150", "--to", "N700"]], ids=" ".join)
def test_parts_are_the_same(tmp_path: Path, run: Run, part: list[str]) -> None:
    head = "T2 M6\nM3 S900\nG0 X3\nN20 G1 X5 F5000\n"
    (tmp_path / "part.nc").write_text(head + zigzag(600, "M8\nN700 X1\n"))
    for command in (["run", "--json"], ["check"], ["translate"], ["translate", "--json"]):
        streamed, whole = (run(*command, *part, tmp_path / "part.nc", whole=whole) for whole in (False, True))
        if command[0] == "run":
            assert result(streamed[1]) == result(whole[1])
            streamed, whole = (streamed[0], "", streamed[2]), (whole[0], "", whole[2])
        assert streamed == whole and streamed[0] == 0, command


def test_the_linter_finds_the_same(tmp_path: Path, run: Run) -> None:
    smells = "X1 F60\nX2 F6000\nG0 Z50\nZ1\nX0\nG1 X0 Y0\nG2 X0.01 Y0 R50\nG1 X1\n"
    (tmp_path / "part.nc").write_text(zigzag(400, smells, "M98 P7\nM30\nO5\nM99\nO6\nM99\nO7\nM99\n"))
    (tmp_path / "line.nc").write_text(zigzag(400, smells, "M30\nO5\nM99\nO6\nM99\n"))
    for name in ("part.nc", "line.nc"):
        streamed, whole = (run("check", "--strict", tmp_path / name, whole=whole) for whole in (False, True))
        assert streamed == whole
        assert all(smell in streamed[2] for smell in ("GW941", "GW942", "GW943", "GW944")), streamed[2]


@pytest.mark.parametrize("rows", [1 << 16, 100, 7])
def test_a_recording_is_the_same_to_the_last_byte(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch, rows: int
) -> None:
    monkeypatch.setattr(recording, "PIECE", rows)
    text = zigzag(500, "M98 P7 L3\n(MSG, half)\nG1 X3 F60000\nX3.001\nX3.002\nX9\n", "M30\nO7\nG91 X1 Y1\nG90\nM99\n")
    (tmp_path / "part.nc").write_text(text)
    for arguments in ([], ["--max-time", "3"], ["--from", "20", "--to", "400"]):
        files = [tmp_path / f"{name}.mcap" for name in ("streamed", "whole")]
        for path, whole in zip(files, (False, True), strict=True):
            run("run", "--record", path, *arguments, tmp_path / "part.nc", whole=whole)
        assert files[0].read_bytes() == files[1].read_bytes()
    job = compile_job(read_job(str(tmp_path / "part.nc")), load_machine(None), CompileOptions(start="20", stop="400"))
    whole_path, recorded = toolpaths.Path(job.program.sequence()), open_recording(str(files[0]))
    path = toolpaths.Path(recorded.sequence)
    assert path.length_mm == whole_path.length_mm and path.merged == whole_path.merged
    blocks = whole_path.blocks()
    assert all(np.array_equal(column, blocks[name]) for name, column in path.blocks().items())
    assert run("report", files[0], tmp_path / f"r{rows}")[0] == 0


def test_radii_in_pieces(tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "PIECE", 5)
    machine = (ROOT / "examples" / "machines" / "mill4c.toml").read_text()
    (tmp_path / "machine.toml").write_text(machine)
    turns = "".join(f"G7.1 C{radius}\nG1 C{radius + 40}\nG7.1 C0\nG1 C0\n" for radius in (20, 25, 20, 30))
    (tmp_path / "part.nc").write_text(zigzag(30, turns))
    assert run("run", "--record", tmp_path / "a.mcap", tmp_path / "part.nc")[0] == 0
    job = compile_job(
        read_job(str(tmp_path / "part.nc")), load_machine(str(tmp_path / "machine.toml")), CompileOptions()
    )
    blocks = toolpaths.Path(job.program.sequence()).blocks()
    found = toolpaths.Path(open_recording(str(tmp_path / "a.mcap")).sequence).blocks()
    assert all(np.array_equal(column, blocks[name]) for name, column in found.items())


def test_a_path_that_is_too_long_to_be_held_is_told(tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    part = tmp_path / "part.nc"
    part.write_text(zigzag(600))
    monkeypatch.setattr(recording, "PIECE", 100)
    assert run("run", part, "--record", tmp_path / "r.mcap")[0] == 0
    monkeypatch.setattr(jobs, "MOST_BLOCKS", 500)
    for arguments in (["--report", tmp_path / "r"], ["--time-optimal"], ["--override-sweep", "0.5:1:0.5"]):
        code, _, err = run("run", part, *arguments)
        assert code == 2 and "CF203" in err and "--from" in err and not (tmp_path / "r").exists()
    assert run("report", tmp_path / "r.mcap", tmp_path / "r")[0] == 2
    assert run("run", part, "--record", tmp_path / "r.mcap")[0] == 0


def test_a_run_that_is_killed_leaves_a_recording_that_says_so(tmp_path: Path, run: Run) -> None:
    part, path = tmp_path / "part.nc", tmp_path / "r.mcap"
    part.write_text(zigzag(400_000))
    with child(part, "run", "--record", str(path)) as process:
        begun = time.monotonic()
        while not (path.exists() and path.stat().st_size > 20_000_000) and time.monotonic() - begun < 60:
            time.sleep(0.05)
        process.kill()
    recorded = open_recording(str(path))
    samples = sum(len(columns["flags"]) for columns in recorded.columns())
    assert samples > 0 and recorded.result is None and recorded.damage
    assert run("report", path, tmp_path / "report")[0] == 0
    assert recorded.damage in (tmp_path / "report" / "report.html").read_text()


def test_a_file_that_changes_while_it_is_recorded(tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    part = tmp_path / "part.nc"
    part.write_text(zigzag(200_000))
    begin = streaming.begin

    def changed(*arguments: Any, **options: Any) -> Any:
        job = begin(*arguments, **options)
        part.write_text("G1 X1 Q1\n")
        return job

    monkeypatch.setattr(streaming, "begin", changed)
    code, out, err = run("run", part, "--json", "--record", tmp_path / "r.mcap")
    assert code == 2 and "GC114" in err and json.loads(out)["diagnostics"][0]["id"] == "GC114"
    assert open_recording(str(tmp_path / "r.mcap")).result is None


def test_a_program_that_never_ends_is_told(tmp_path: Path, run: Run) -> None:
    (tmp_path / "part.nc").write_text("F6000\nWHILE [1 EQ 1] DO1\nEND1\nM30\n")
    streamed, whole = (run("run", "--max-time", "2", tmp_path / "part.nc", whole=whole) for whole in (False, True))
    assert streamed == whole and streamed[0] == 2 and "GC602" in streamed[2]


def test_errors_are_not_hidden_behind_warnings(tmp_path: Path, run: Run) -> None:
    (tmp_path / "part.nc").write_text(zigzag(40, "N5 X1\nN5 X2\n" * 40 + "G1 Q5\n"))
    err = run("run", tmp_path / "part.nc")[2]
    assert "GW908" in err and "GC326" in err and len(err.splitlines()) < 15, err
