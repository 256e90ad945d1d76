"""Ids of the dialect's catalogue that the application finds, each with a scene; with those of gcode/tests/catalogue.rs
no id is unreachable."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.execution import Execution
from cnc_front.jobs import CompiledJob, CompileOptions, compile_job, load_machine, read_job
from cnc_front.readiness import not_ready, reported
from tests.app.conftest import ROOT, Cli

Scene = Callable[[Path, pytest.MonkeyPatch], Sequence[Diagnostic]]

MACHINE = native_kernel.Machine.builtin()


def prepared() -> native_kernel.Mcu:
    """A controller as `run` leaves it to the program."""
    mcu = native_kernel.Mcu(MACHINE)
    mcu.prepare_gcode()
    return mcu


def missing_file(folder: Path, patch: pytest.MonkeyPatch) -> Sequence[Diagnostic]:
    with pytest.raises(CompileError) as caught:
        read_job(str(folder / "no.nc"))
    return caught.value.diagnostics


def file_that_grows(folder: Path, patch: pytest.MonkeyPatch) -> Sequence[Diagnostic]:
    job = folder / "grows.nc"
    job.write_text("G0 X1\nM30\n")
    real, calls = os.fstat, iter(range(9))

    def fstat(handle: int) -> os.stat_result:
        status = real(handle)
        if next(calls) == 1:  # behind the look at its size, before it is read
            job.write_text("G0 X1\nG0 X2\nM30\n")
        return status

    patch.setattr("cnc_front.jobs.os.fstat", fstat)
    with pytest.raises(CompileError) as caught:
        read_job(str(job))
    return caught.value.diagnostics


def after_boot(folder: Path, patch: pytest.MonkeyPatch) -> Sequence[Diagnostic]:
    return not_ready(native_kernel.Mcu(MACHINE), MACHINE, "a.nc")


def zero_offset(folder: Path, patch: pytest.MonkeyPatch) -> Sequence[Diagnostic]:
    mcu = prepared()
    mcu.set_zero(1, 2.5, False)
    return not_ready(mcu, MACHINE, "a.nc")


def open_loop(folder: Path, patch: pytest.MonkeyPatch) -> Sequence[Diagnostic]:
    mcu = prepared()
    mcu.ol([1])
    return not_ready(mcu, MACHINE, "a.nc")


def full_spooler(folder: Path, patch: pytest.MonkeyPatch) -> Sequence[Diagnostic]:
    mcu = prepared()
    while mcu.ssf(0, 5, 1.0) == "entered":
        pass
    mcu.clear_errorreg()
    return not_ready(mcu, MACHINE, "a.nc")


def error_register(folder: Path, patch: pytest.MonkeyPatch) -> Sequence[Diagnostic]:
    mcu = prepared()
    mcu.motion("smla", False, [0, 0], [1.0, 1.0], 1.0, 1.0, 0.0, 0.0, (0.0, 0.0))
    return reported(mcu, "a.nc")


SCENES: dict[str, tuple[Scene, str]] = {
    "GC112": (missing_file, "cannot be read"),
    "GC114": (file_that_grows, "changed"),
    "GC803": (after_boot, "axis X is not referenced"),
    "GC805": (zero_offset, "axis Y: 2.5"),
    "GC806": (open_loop, "axis Y not in closed loop"),
    "GC809": (full_spooler, "axis X exhausted, 128 bytes needed"),
    "GC810": (error_register, "00000001h (errAxDef)"),
}


def test_each_id_of_the_application_has_a_scene() -> None:
    text = (ROOT / "gcode" / "tests" / "catalogue.rs").read_text("utf-8")
    listed = re.search(r"const APPLICATION: &\[&str\] =\s*&\[(.*?)\];", text, re.DOTALL)
    assert listed is not None
    assert set(re.findall(r'"(G[CW]\d{3})"', listed.group(1))) == SCENES.keys()


@pytest.mark.parametrize("id", SCENES)
def test_the_scene_is_found(id: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, text = SCENES[id]
    found = [d for d in scene(tmp_path, monkeypatch) if d.id == id]
    assert [(d.line, d.column) for d in found[:1]] == [(1, 1)]
    assert any(text in d.message for d in found), found
    assert all(d.hint for d in found)


def test_a_prepared_controller_is_ready() -> None:
    assert not_ready(prepared(), MACHINE, "a.nc") == ()
    assert reported(prepared(), "a.nc") == ()


def compiled(folder: Path, text: str) -> CompiledJob:
    job = folder / "job.nc"
    job.write_text(text)
    return compile_job(read_job(str(job)), load_machine(None), CompileOptions())


def test_a_program_does_not_start_on_a_controller_that_is_not_ready(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = compiled(tmp_path, "G0 X1\nM30\n")
    monkeypatch.setattr("cnc_front.execution.not_ready", lambda *_: after_boot(tmp_path, monkeypatch))
    with pytest.raises(CompileError) as caught:
        Execution(job)
    assert "GC803" in {d.id for d in caught.value.diagnostics}


def test_run_names_the_error_register(tmp_path: Path, cli: Cli) -> None:
    # two blocks in a row that take less than a sample at twice the speed
    job = tmp_path / "short.nc"
    blocks = "".join(f"X{i * 0.05:.2f} Y{i % 2 * 2e-5:.5f}\n" for i in range(1, 200))
    job.write_text(f"G64 P0\nG1 F6000\n{blocks}M30\n")
    ran = cli("run", job, "--override", "2", "--json").object
    assert "ProfileToSmall" in ran["error_register"]
    found = [d for d in ran["diagnostics"] if d["id"] == "GC810"]
    assert len(found) == 1 and "ProfileToSmall" in found[0]["message"]
    alarm = next(alarm for alarm in ran["alarms"] if alarm["name"] == "ProfileToSmall")
    assert found[0]["line"] == alarm["line"] > 2
