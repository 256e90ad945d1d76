"""rw_SymPas jobs on the command line and in Python: check, translate, autocode files."""

from __future__ import annotations

from pathlib import Path

import pytest

import sympas
from cnc_front.cli import run_command_line
from motion_kernel import Machine

GOOD = "program Job;\n{$TASK 2}\nvar i : integer;\nbegin\n  i := 15;\n  writeln(i);\nend.\n"
BAD = "program Job;\nvar speed : integer;\nbegin\n  speed := 1.5;\n  writeln(sped);\nend.\n"


@pytest.fixture
def job(tmp_path: Path) -> Path:
    path = tmp_path / "job.src"
    path.write_text(GOOD)
    return path


def test_check_names_every_error_with_a_caret(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bad.SRC"
    path.write_text(BAD)
    assert run_command_line(["check", str(path), "--lang", "en"]) == 2
    out, err = capsys.readouterr()
    assert out == f"{path}: 2 errors, 0 warnings\n"
    assert err.splitlines() == [
        f"{path}:4:12: SP401: Double cannot be assigned to Integer",
        "    speed := 1.5;",
        "             ^^^",
        "  hint: convert it, as in INTEGER(x)",
        f"{path}:5:11: 3: undeclared identifier 'sped'",
        "    writeln(sped);",
        "            ^^^^",
        "  hint: did you mean 'speed'?",
    ]


def test_diagnostics_in_german(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bad.src"
    path.write_text(BAD)
    assert run_command_line(["check", str(path), "--lang", "de"]) == 2
    assert "3: nicht deklarierter Bezeichner 'sped'" in capsys.readouterr().err


@pytest.mark.shows("sympas.lex.source-file")
def test_a_source_becomes_one_autocode_file(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (job.parent / "part.inc").write_text("CI0 := 7;")
    job.write_text(GOOD.replace("  writeln", "  {$I PART.INC}\n  writeln"))
    target = job.with_suffix(".cnc")
    assert run_command_line(["translate", str(job), "--output", str(target)]) == 0
    assert run_command_line(["translate", str(job), "--autocode"]) == 0
    listing = capsys.readouterr().out
    assert listing.startswith("program Job: task 2, 3 axes") and "WriteCi" in listing
    assert run_command_line(["translate", str(target)]) == 0
    assert capsys.readouterr().out == listing
    assert sympas.load(target).task == 2


def test_a_damaged_autocode_file_is_refused(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = job.with_suffix(".cnc")
    assert run_command_line(["translate", str(job), "--output", str(target)]) == 0
    data = bytearray(target.read_bytes())
    data[40] ^= 1
    target.write_bytes(data)
    assert run_command_line(["check", str(target)]) == 2
    assert "CF202: the autocode file is damaged" in capsys.readouterr().err
    with pytest.raises(ValueError, match="damaged"):
        sympas.load(target)


def test_nothing_is_written_over_other_files(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = job.with_name("other.txt")
    other.write_text("mine")
    for target in (job, other, job.parent, job.parent / "none" / "x.cnc"):
        assert run_command_line(["translate", str(job), "--output", str(target)]) == 2
    assert (job.read_text(), other.read_text()) == (GOOD, "mine")
    part = job.with_name("part.nc")
    part.write_text("G0 X1\nM30\n")
    assert run_command_line(["translate", str(part), "--autocode"]) == 2
    assert "rw_SymPas jobs" in capsys.readouterr().err


def test_python_compiles_text_and_files(job: Path) -> None:
    machine = Machine.builtin()
    assert sympas.compile(job, machine).listing() == sympas.compile(GOOD, machine).listing()
    with pytest.raises(sympas.CompileError) as caught:
        sympas.compile(BAD, machine, filename="bad.src")
    assert [(d.line, d.id) for d in caught.value.diagnostics] == [(4, "SP401"), (5, "3")]
    with pytest.raises(sympas.CompileError, match="no folder"):
        sympas.compile("{$I x} begin end.", machine)
