"""Whatever comes in: exit 2, a diagnostic with place, id and remedy, nothing written over, no traceback, no hang."""

from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.app.conftest import ROOT, Cli

MACHINE = ROOT / "examples" / "machines" / "mill3.toml"

#: name: (bytes of the job, id expected)
JOBS: dict[str, tuple[bytes, str]] = {
    "binary": (bytes(range(256)) * 40, "GC1"),
    "zeros": (bytes(5000), "GC1"),
    "utf-16": ("G90 G21\nG1 X10 F500\nM30\n".encode("utf-16"), "GC1"),
    "line of 1 MB": (b"G1 X1 F100 " + b"Y1 " * 350_000 + b"\nM30\n", "GC1"),
    "unterminated comment": (b"G90 G21\nG1 X10 F500 (never closed\nM30\n", "GC1"),
    "arc whose radii differ": (b"G90 G21 G17\nG1 X0 Y0 F500\nG2 X10 Y0 I3 J0\nM30\n", "GC401"),
    "missing feed": (b"G90 G21\nG1 X10\nM30\n", "GC501"),
    "axis the machine lacks": (b"G90 G21\nG1 A10 F500\nM30\n", "GC801"),
    "target outside the limits": (b"G90 G21\nG1 X9999 F500\nM30\n", "GC413"),
    "arc outside the limits": (b"G90 G21 G17\nG0 X590\nG3 X590 Y40 I0 J20 F500\nM30\n", "GC413"),
    "number too large": (b"G90 G21\nG1 X1e400 F500\nM30\n", "GC"),
    "two motions": (b"G90 G21\nG0 G1 X1 F500\nM30\n", "GC302"),
    "prose": (b"Dear machine, please mill a bracket.\n", "GC"),
}

PLACE = re.compile(r"^(?P<file>.+):(?P<line>\d+):(?P<column>\d+): (?P<id>[A-Z]{2}\d{3}): \S", re.M)


def assert_diagnosed(err: str, path: Path, id: str) -> None:
    found = [m for m in PLACE.finditer(err) if m["file"] == str(path)]
    assert found, err[:2000]
    assert all(int(m["line"]) >= 1 and int(m["column"]) >= 1 for m in found)
    assert any(m["id"].startswith(id) for m in found), err[:2000]
    assert "hint:" in err


def test_a_line_of_1_mb_costs_nothing(cli: Cli, job: Callable[..., Path]) -> None:
    path = job(JOBS["line of 1 MB"][0])
    begun = time.monotonic()
    cli("check", path)
    assert time.monotonic() - begun < 5.0


@pytest.mark.parametrize("name", JOBS)
@pytest.mark.parametrize("command", ["run", "check", "translate"])
def test_bad_jobs(cli: Cli, job: Callable[..., Path], name: str, command: str) -> None:
    data, id = JOBS[name]
    path = job(data)
    ran = cli(command, path)
    assert ran.code == 2
    assert_diagnosed(ran.err, path, id)
    assert path.read_bytes() == data
    if command != "check":
        assert ran.out == "", "no result without a program"
    assert len(ran.err) < 200_000


def test_every_error_of_a_file_is_reported(cli: Cli, job: Callable[..., Path]) -> None:
    ran = cli("check", job("G90 G21 F500\nG1 A5\nG1 X9999\nG1 G2 X1\nG1 X1 !\nM30\n"))
    lines = {int(m["line"]) for m in PLACE.finditer(ran.err)}
    assert lines >= {2, 3, 4, 5}


@pytest.mark.parametrize("empty", [b"", b"\n\n  \n", b"%\n%\n", b"(nothing)\n"])
def test_empty_files_do_not_run(cli: Cli, job: Callable[..., Path], empty: bytes) -> None:
    path = job(empty)
    ran = cli("run", path)
    assert ran.code == 2
    assert_diagnosed(ran.err, path, "GC")


def test_an_error_leaves_no_output_files(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    record, report = tmp_path / "r.mcap", tmp_path / "report"
    ran = cli("run", job("G90\nG1 X10 F100\nG1 A1\n"), "--record", record, "--report", report)
    assert ran.code == 2
    assert not record.exists()
    assert not report.exists()


@pytest.mark.parametrize("command", ["run", "check", "translate", "report", "machine"])
def test_what_is_no_regular_file(cli: Cli, tmp_path: Path, command: str) -> None:
    fifo, folder, gone = tmp_path / "fifo", tmp_path / "folder.nc", tmp_path / "gone.nc"
    os.mkfifo(fifo)
    folder.mkdir()
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "s"))
        for path in (fifo, folder, gone, Path("/dev/zero"), Path("/dev/null"), tmp_path / "s"):
            before = [command, "check", path] if command == "machine" else [command, path]
            ran = cli(*before, *([tmp_path / "out"] if command == "report" else []), timeout=20)
            assert ran.code == 2, (path, ran)
            assert str(path) in ran.err


def test_names_that_are_no_utf8(tmp_path: Path) -> None:
    folder = os.fsencode(tmp_path) + b"/\xff"
    Path(os.fsdecode(folder)).mkdir()
    machine = folder + b"/m\xfe.toml"
    Path(os.fsdecode(machine)).write_bytes(MACHINE.read_bytes())
    for text, code in ((b"G90 G21\nG1 X5 F1000\nM30\n", 0), (b"G1 X5\n", 2)):
        Path(os.fsdecode(folder + b"/a\xff.nc")).write_bytes(text)
        outputs = [b"--record", folder + b"/r\xff.mcap", b"--report", folder + b"/out\xff"]
        for json_too in ([b"--json"], []):
            command = [sys.executable, "-m", "cnc_front", "run", folder + b"/a\xff.nc", b"--machine", machine]
            done = subprocess.run([*command, *outputs, *json_too], capture_output=True, cwd=ROOT, check=False)
            assert done.returncode == code, done.stderr
            if json_too:
                assert json.loads(done.stdout)["job"]["path"].endswith("/a\ufffd.nc")


def test_output_that_cannot_be_written(job: Callable[..., Path]) -> None:
    command = [sys.executable, "-m", "cnc_front", "run", str(job("G90 G21\nG1 X5 F1000\nM30\n")), "-q"]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, cwd=ROOT, check=False)
    assert done.returncode == 3
    assert done.stderr.count("\n") == 1
    closed = subprocess.run(
        ["sh", "-c", 'exec "$@" >&-', "sh", *command], stderr=subprocess.PIPE, text=True, cwd=ROOT, check=False
    )
    assert (closed.returncode, closed.stderr) == (0, "")


DAMAGED: dict[str, bytes] = {
    "empty": b"",
    "no toml": b"this is { not toml",
    "binary": bytes(range(256)),
    "unknown key": MACHINE.read_bytes().replace(b"maxacc", b"maxac", 1),
    "wrong type": re.sub(rb"(?m)^rapid *= *[0-9.]+", b'rapid = "fast"', MACHINE.read_bytes(), count=1),
    "negative": re.sub(rb"(?m)^rapid *= *[0-9.]+", b"rapid = -1.0", MACHINE.read_bytes(), count=1),
    "cut off": MACHINE.read_bytes()[: len(MACHINE.read_bytes()) // 2] + b"\n[axis",
}


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_machine_files(cli: Cli, job: Callable[..., Path], tmp_path: Path, name: str) -> None:
    assert DAMAGED[name] != MACHINE.read_bytes()
    path = tmp_path / "machine.toml"
    path.write_bytes(DAMAGED[name])
    checked = cli("machine", "check", path)
    assert checked.code == 2
    assert_diagnosed(checked.err, path, "M")
    ran = cli("run", job("G90\nM30\n"), "--json")
    assert ran.code == 2
    assert ran.object["diagnostics"][0]["file"] == str(path)
    assert path.read_bytes() == DAMAGED[name]


@pytest.mark.parametrize(
    "arguments",
    [
        ["--override", "0"],
        ["--override", "-1"],
        ["--override", "nan"],
        ["--override", "1e99"],
        ["--override", "fast"],
        ["--override", ""],
        ["--override", "0:1,1"],
        ["--override", "0:1,2:0.5,1:1"],
        ["--override", "0:1,0:0.5"],
        ["--override", "-1:1"],
        ["--tolerance", "0"],
        ["--tolerance", "nan"],
        ["--max-time", "0"],
        ["--max-time", "inf"],
        ["--skip", "0"],
        ["--skip", "x"],
        ["--machine", "/nowhere.toml"],
        ["--lang", "fr"],
        ["--record", "/nowhere/r.mcap"],
        ["--report", "/dev/null"],
        ["--report", "/dev/null/below"],
        ["--no-such-option"],
    ],
    ids=" ".join,
)
def test_bad_arguments(cli: Cli, arguments: list[str]) -> None:
    ran = cli("run", ROOT / "examples" / "jobs" / "cam.nc", *arguments)
    assert ran.code == 2
    assert ran.out == ""
    assert ran.err.strip()


def test_outputs_never_overwrite_inputs_or_strange_files(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    path = job("G90 G21\nG1 X5 F1000\nM30\n")
    machine = tmp_path / "own.toml"
    machine.write_bytes(MACHINE.read_bytes())
    strange, folder = tmp_path / "letter.mcap", tmp_path / "photos"
    strange.write_text("Dear Sir")
    folder.mkdir()
    (folder / "holiday.png").write_bytes(b"png")
    link = tmp_path / "link.mcap"
    link.symlink_to(path)
    before = {file: file.read_bytes() for file in (path, machine, strange, folder / "holiday.png")}
    for option, target in [
        ("--record", path),
        ("--record", link),
        ("--record", machine),
        ("--record", strange),
        ("--record", folder),
        ("--record", "/dev/null"),
        ("--report", path),
        ("--report", folder),
    ]:
        ran = cli("run", path, "--machine", machine, option, target)
        assert ran.code == 2, (option, target)
        assert option in ran.err
        if target in (path, link, machine):
            assert "is an input of this run" in ran.err or option == "--report"
    assert {file: file.read_bytes() for file in before} == before
    assert [p.name for p in folder.iterdir()] == ["holiday.png"]
