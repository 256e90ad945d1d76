"""Help, languages, streams, signals, start-up."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from cnc_front.cli import build_parser
from cnc_front.examples import EXAMPLES
from tests.app.conftest import ROOT, Cli

HEAVY = {"textual", "cv2", "numpy", "jinja2", "mcap", "scipy", "rich"}
#: X back and forth for hours
LONG = "G90 G21 F60\n" + "G1 X300\nX-300\n" * 400 + "M30\n"


def test_help_loads_nothing_heavy_and_is_quick() -> None:
    probe = (
        "import sys, time; t = time.process_time()\n"
        "from cnc_front.cli import run_command_line\n"
        "try: run_command_line(['--help'])\n"
        "except SystemExit: pass\n"
        "print(time.process_time() - t, file=sys.stderr)\n"
        "print(*sorted({m.split('.')[0] for m in sys.modules}), file=sys.stderr)\n"
    )
    took = []
    for _ in range(3):
        done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, cwd=ROOT, check=True)
        seconds, modules = done.stderr.strip().split("\n")
        assert not HEAVY & set(modules.split()), "heavy modules at start-up"
        took.append(float(seconds))
    assert min(took) < 0.3, "seconds of processor time: a busy machine is no failure"
    assert done.stdout.startswith("examples:\n")


@pytest.mark.parametrize("command", EXAMPLES)
def test_help_begins_with_examples_that_are_right(cli: Cli, command: str) -> None:
    ran = cli(*command.split(), "-h")
    assert ran.code == 0 and ran.out.startswith("examples:\n  cnc-front ")
    for line, _ in EXAMPLES[command]:
        assert line in ran.out
        words = shlex.split(line.partition(" > ")[0])[1:]
        assert build_parser().parse_args(words).command == (command or words[0])


def test_every_command_has_examples(cli: Cli) -> None:
    commands = re.findall(r"^    (\w+)", cli("-h").out.partition("COMMAND\n")[2].partition("options:")[0], re.M)
    assert len(commands) > 8 and set(EXAMPLES) == {"", *commands}


def test_verbose_quiet_and_no_input(cli: Cli, job: Callable[..., Path]) -> None:
    path = job("G90 G21 F1000\n" + "".join(f"N{n // 2} G1 X{n}\n" for n in range(20)) + "M30\n")
    usual, verbose, quiet = (cli("run", path, *more) for more in ((), ("-v",), ("-q",)))
    assert (usual.err.count("GW908"), verbose.err.count("GW908"), quiet.err) == (6, 10, "")
    assert "5 more GW908" in usual.err and "sha256" in verbose.err and "samples" not in usual.err
    result = [re.sub(r"\(\d+\.\d+ s\)", "", ran.out) for ran in (usual, verbose, quiet)]
    assert result[0] == result[1] == result[2], "the result is the same, but for the time on the wall"
    ran = cli("tui", "--no-input", "--plain", path)
    assert ran.code == 2 and "cnc-front run needs none" in ran.err
    assert cli("run", "--no-input", path).code == 0


def test_version(cli: Cli) -> None:
    ran = cli("--version")
    assert (ran.code, ran.out.split()[0]) == (0, "cnc-front")


@pytest.mark.parametrize("arguments", [[], ["nonsense"], ["run"], ["check"], ["report", "x"], ["machine"]])
def test_wrong_usage_is_one_line_and_exit_2(cli: Cli, arguments: list[str]) -> None:
    ran = cli(*arguments)
    assert (ran.code, ran.out) == (2, "")
    assert len(ran.err.strip().splitlines()) == 1


def test_check_judges_every_file(cli: Cli, job: Callable[..., Path]) -> None:
    good, bad = job("G90 G21\nG1 X5 F1000\nM30\n", "good.nc"), job("G1 X5\nM30\n", "bad.nc")
    assert cli("check", good).code == 0
    ran = cli("check", bad, good)
    assert ran.code == 2
    assert [line.split(":")[0] for line in ran.out.splitlines()] == [str(bad), str(good)]


def test_translate_lists_commands_in_order(cli: Cli, job: Callable[..., Path]) -> None:
    path = job("G90 G21 G17\nG0 X0 Y0 Z0\nG1 X40 F3000\nG3 X50 Y10 I0 J10\nM30\n")
    listing = [json.loads(line) for line in cli("translate", path, "--json").out.splitlines()]
    motion = [c for c in listing if c["cmd"] != "ssf"]
    assert [(c["cmd"], c["line"]) for c in motion] == [("smla", 3), ("smha", 4)]
    assert motion[0]["target"] == {"X": 40.0, "Y": 0.0, "Z": 0.0}
    assert motion[0]["vl"] == pytest.approx(50.0)
    assert motion[1]["phi"] == pytest.approx(90.0)
    assert motion[1]["center"] == {"X": pytest.approx(40.0), "Y": pytest.approx(10.0)}
    text = cli("translate", path)
    assert text.code == 0
    assert "smha" in text.out


def test_machine_show_is_the_commented_example_resolved(cli: Cli, tmp_path: Path) -> None:
    shown = cli("machine", "show")
    assert shown.code == 0
    copy = tmp_path / "copy.toml"
    copy.write_text(shown.out)
    assert cli("machine", "check", copy).code == 0
    assert cli("machine", "show", copy).out == shown.out
    assert cli("machine", "show", ROOT / "examples" / "machines" / "mill3.toml").out == shown.out


@pytest.mark.parametrize("name", ["mill3", "mill3s", "mill4a", "mill4c", "xy-stepper"])
def test_example_machines_are_valid(cli: Cli, name: str) -> None:
    assert cli("machine", "check", ROOT / "examples" / "machines" / f"{name}.toml").code == 0


def _start(*arguments: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "cnc_front", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupt_closes_the_recording_and_prints_the_object(job: Callable[..., Path], number: signal.Signals) -> None:
    mcap_reader = pytest.importorskip("mcap.reader")
    record = job(LONG).with_suffix(".mcap")
    process = _start("run", job(LONG), "--record", record, "--json", "-q")
    deadline = time.monotonic() + 30
    while not (record.exists() and record.stat().st_size > 100_000) and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(number)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 130, err
    run = json.loads(out)
    assert (run["status"], run["error"]["id"]) == ("stopped", "CF304")
    assert run["samples"] > 0
    assert run["deviation"]["setpoint"]["max_mm"] <= 1e-6
    with record.open("rb") as file:
        summary = mcap_reader.make_reader(file).get_summary()
    assert summary is not None, "the index is written"


def test_a_reader_that_goes_away_is_no_error(job: Callable[..., Path]) -> None:
    path = job("G90 G21 F1000\n" + "".join(f"G1 X{n % 50}.5\n" for n in range(20_000)) + "M30\n")
    process = _start("translate", path, "--json")
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.readline()
    process.stdout.close()
    assert process.wait(timeout=30) in (0, -signal.SIGPIPE)
    assert process.stderr.read() == ""


def test_internal_errors_are_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    from cnc_front import cli as command_line

    def broken(name: str) -> None:
        raise RuntimeError("wheel fell off")

    monkeypatch.setattr(command_line, "_command", broken)
    monkeypatch.delenv("CNC_FRONT_DEBUG", raising=False)
    before = signal.getsignal(signal.SIGPIPE)
    try:
        assert command_line.run_command_line(["machine", "show"]) == 3
        assert capsys.readouterr().err.count("\n") == 1
        monkeypatch.setenv("CNC_FRONT_DEBUG", "1")
        assert command_line.run_command_line(["machine", "show"]) == 3
        assert "Traceback" in capsys.readouterr().err
    finally:
        signal.signal(signal.SIGPIPE, before)


def test_a_panic_of_the_compiled_module_is_one_line_too() -> None:
    code = (
        "from cnc_front import cli\n"
        "class PanicException(BaseException): pass\n"
        "def broken(name): raise PanicException('index out of bounds')\n"
        "cli._command = broken\n"
        "raise SystemExit(cli.run_command_line(['machine', 'show']))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 3
    assert done.stderr.count("\n") == 1


def test_options_are_written_out(cli: Cli) -> None:
    assert cli("run", "x.nc", "--toler", "1").code == 2


def test_colours_only_on_a_terminal(cli: Cli, job: Callable[..., Path]) -> None:
    import pty

    path = job("G90 G21\nG1 X5 F1000\nM30\n")
    assert "\x1b" not in cli("run", path).out

    def shown(*more: str) -> str:
        master, slave = pty.openpty()
        command = [sys.executable, "-m", "cnc_front", "run", str(path), "-q", *more]
        subprocess.run(command, stdout=slave, stderr=subprocess.DEVNULL, cwd=ROOT, check=True)
        os.close(slave)
        text = os.read(master, 100_000).decode()
        os.close(master)
        return text

    assert "\x1b[1;" in shown()
    assert "\x1b" not in shown("--no-color")


def test_module_and_script_are_the_same(cli: Cli) -> None:
    script = Path(sys.executable).with_name("cnc-front")
    if not script.exists():
        pytest.skip("cnc-front is not installed beside this interpreter")
    done = subprocess.run([script, "--version"], capture_output=True, text=True, cwd=os.sep, check=True)
    assert done.stdout == cli("--version").out


def test_a_flood_of_warnings_is_counted(cli: Cli, job: Callable[..., Path]) -> None:
    part = job("G1 X1 F600\n" + "G90 G90 X2\n" * 20 + "M30\n")
    ran = cli("run", part)
    assert ran.code == 0
    assert ran.err.count("GW913:") == 5 and "15 more GW913" in ran.err
    assert cli("check", part).err.count("GW913:") == 20, "check names every one"
    assert "GW913" not in cli("run", part, "-q").err
