"""The PCAP face of the controller (design 3.4) and the compilers' Python face."""

from __future__ import annotations

import doctest
import re

import numpy as np
import pytest

import gcode
import motion_kernel
import toolpaths
from motion_kernel import CommandRefused, Machine, MachineError, Mcu, ModeReg
from tests.app.conftest import ROOT

MILL = ROOT / "examples" / "machines" / "mill3.toml"


@pytest.fixture
def mcu() -> Mcu:
    mcu = Mcu(Machine.load(MILL))
    mcu.cl(mcu.machine.axis_names)
    return mcu


def test_the_example_of_the_module() -> None:
    assert doctest.testmod(motion_kernel).failed == 0


def test_line_in_spooler_then_moved(mcu: Mcu) -> None:
    free = mcu.rdlsm("X")
    assert mcu.smla({"X": 10.0, "Y": 5.0}, ac=500.0, vl=20.0)
    assert (mcu.rdmcis("X"), mcu.rdmcis(1), mcu.rdmcis("Z")) == (1, 1, 0)
    assert mcu.rdlsm("X") < free
    mcu.advance(100)
    assert mcu.rddp("X") == 0.0, "nothing moves before ssms"
    mcu.ssms(["X", "Y"])
    mcu.advance(samples=2000)
    assert (mcu.rddp("X"), mcu.rddp("Y")) == (10.0, 5.0)
    assert mcu.rdrp("X") == pytest.approx(10.0, abs=2e-3)
    assert mcu.rdaxst("X").pe
    assert "cl" in mcu.rdaxst("X").names
    assert mcu.rderrorreg() == 0
    # trapezoid: length / v + v / a
    length = np.hypot(10, 5)
    moving = int(np.count_nonzero(mcu.trace.flags & 1))
    assert moving * 1.28e-3 == pytest.approx(length / 20 + 20 / 500, abs=2 * 1.28e-3)


def test_trace_columns_are_views(mcu: Mcu) -> None:
    with pytest.raises(RuntimeError):
        _ = Mcu(mcu.machine).trace
    mcu.advance(50)
    assert mcu.trace.dp.shape == (50, 3)
    assert mcu.trace.dp is mcu.trace.dp, "the same array each time, not a copy"
    assert mcu.trace.first_sample == 0


def test_open_loop_is_refused() -> None:
    mcu = Mcu(Machine.builtin())
    with pytest.raises(CommandRefused):
        mcu.smla({"X": 1.0}, ac=500.0, vl=20.0)
    assert mcu.rdaxst("X").dhef
    assert "CheckMonitorScreen" in mcu.rderrorreg().names
    mcu.wrerrorreg()
    assert mcu.rderrorreg() == 0


def test_circle_and_helix(mcu: Mcu) -> None:
    assert mcu.smha({"X": 10.0, "Y": 0.0}, 360.0, {"Z": 2.0}, ac=500.0, vl=20.0)
    assert mcu.smcr({"X": 5.0, "Y": 0.0}, -180.0, ac=500.0, vl=20.0)
    mcu.ssms(["X", "Y", "Z"])
    mcu.advance(6000)
    radius = np.hypot(mcu.trace.dp[:, 0] - 10.0, mcu.trace.dp[:, 1])
    on_helix = mcu.trace.entry == mcu.trace.entry[mcu.trace.entry > 0][0]
    assert np.abs(radius[on_helix] - 10.0).max() < 1e-9
    assert mcu.rddp("X") == pytest.approx(10.0)
    assert mcu.rddp("Z") == 2.0
    with pytest.raises(ValueError, match="centre in two axes"):
        mcu.smca({"X": 1.0}, 90.0, ac=1.0, vl=1.0)


def test_override(mcu: Mcu) -> None:
    mcu.smla({"X": 100.0}, ac=500.0, vl=20.0)
    mcu.ssms("X")
    mcu.wrtrovr(0.5)
    mcu.utrovr("X")
    mcu.advance(500)
    assert mcu.rddv("X") == pytest.approx(10.0)
    with pytest.raises(ValueError, match="above 0"):
        mcu.wrtrovr(0.0)
    assert mcu.rdtrovr() == 0.5


def test_functions_of_the_spooler(mcu: Mcu) -> None:
    assert mcu.ssf("X", 7, 42.9)
    assert mcu.ssf("X", 1001, 5)
    mcu.ssms("X")
    mcu.advance(3)
    assert mcu.rdci(7) == 42
    assert mcu.rddigo("X") == 5


def test_registers_by_name(mcu: Mcu) -> None:
    mcu.wrmodereg(ModeReg.of("LookAhead", "ChkMaxVel"))
    assert mcu.rdmodereg().names == ("LookAhead", "ChkMaxVel")
    assert mcu.rdmodereg() == 0x81
    with pytest.raises(AttributeError, match="has no bit nonsense"):
        _ = mcu.rdmodereg().nonsense


def test_values_of_an_axis(mcu: Mcu) -> None:
    mcu.wrmpe("X", 0.25)
    assert mcu.rdmpe("X") == 0.25
    for bad in (-1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="finite"):
            mcu.wrmpe("X", bad)
    assert mcu.rdmpe("X") == 0.25


@pytest.mark.parametrize(("axis", "error"), [("Q", KeyError), (9, IndexError), (-1, IndexError)])
def test_unknown_axes(mcu: Mcu, axis: str | int, error: type[Exception]) -> None:
    with pytest.raises(error):
        mcu.rdaxst(axis)
    with pytest.raises(error):
        mcu.smla({axis: 1.0}, ac=1.0, vl=1.0)


def test_a_compiled_program_in_a_task(mcu: Mcu) -> None:
    program = gcode.compile("G90 G21\nG1 X5 F3000\nM30\n", mcu.machine)
    assert [c["cmd"] for c in program.listing() if c["cmd"] != "ssf"] == ["smla"]
    assert program.counts()["smla"] == 1
    mcu.prepare_gcode()
    mcu.load(0, program)
    mcu.startcnct(0)
    mcu.advance(1000)
    assert mcu.rddp("X") == 5.0
    assert mcu.rdcncts(0).running == 0
    assert toolpaths.Path(program.sequence()).length_mm == pytest.approx(5.0)


def test_errors_are_values() -> None:
    machine = Machine.builtin()
    with pytest.raises(gcode.CompileError) as caught:
        gcode.compile("G1 X1\nG1 A1 F5\n", machine, filename="p.nc")
    assert [(d.line, d.id) for d in caught.value.diagnostics if not d.is_warning] == [(1, "GC501"), (2, "GC801")]
    assert str(caught.value).startswith("p.nc:1:")
    with pytest.raises(MachineError) as broken:
        Machine.parse("nonsense")
    assert broken.value.diagnostics
    assert str(broken.value.diagnostics[0]).startswith("<text>:1:")


@pytest.mark.shows("ssf.1001", "ssf.1002", "pcap.rddigo")
def test_outputs_by_spool_functions(mcu: Mcu) -> None:
    mcu.ssf("X", 1001, 0b0111)
    mcu.ssf("X", 1003, 2000)  # 0.128 s
    mcu.ssf("X", 1002, 0b0010)
    mcu.ssms("X")
    mcu.advance(10)
    assert mcu.rddigo("X") == 0b0111
    mcu.advance(200)
    assert mcu.rddigo("X") == 0b0101


@pytest.mark.shows("pcap.rs.spooler", "pcap.rs.tasks", "pcap.rs.keeps-common", "pcap.rdcd.persist")
def test_rs_stops_everything_but_keeps_common_variables(mcu: Mcu) -> None:
    mcu.wrci(7, 42)
    mcu.wrcd(999, 2.5)
    program = gcode.compile("G90 G21\nG1 X500 F600\nX-500\nM30\n", mcu.machine)
    mcu.prepare_gcode()
    mcu.load(0, program)
    mcu.startcnct(0)
    mcu.advance(100)
    assert mcu.rdcncts(0).running & 1
    assert mcu.rdmcis("X") == 1, "the second line waits"
    mcu.rs()
    stands = mcu.rddp("X")
    mcu.advance(1000)
    assert mcu.rdcncts(0).running & 1 == 0
    assert mcu.rdmcis("X") == 0
    assert mcu.rdlsm("X") == Mcu(mcu.machine).rdlsm("X"), "all of its memory is free"
    assert mcu.rddp("X") == pytest.approx(stands, abs=0.1)
    assert (mcu.rdci(7), mcu.rdcd(999)) == (42, 2.5)


@pytest.mark.shows("axst.referenced.reset-boot", "axst.dhef.reset")
def test_rs_clears_referenced_and_dhef(mcu: Mcu) -> None:
    assert not mcu.rdaxst("X").referenced, "after boot"
    mcu.prepare_gcode()
    assert mcu.rdaxst("X").referenced
    mcu.ol("X")
    with pytest.raises(CommandRefused):
        mcu.smla({"X": 1.0}, ac=500.0, vl=20.0)
    mcu.cl("X")
    mcu.advance(10)
    assert mcu.rdaxst("X").dhef, "neither time nor cl clears it"
    mcu.rs()
    assert not mcu.rdaxst("X").dhef
    assert not mcu.rdaxst("X").referenced


@pytest.mark.shows("pcap.rdtp.absolute")
def test_target_position_is_absolute_after_a_relative_command(mcu: Mcu) -> None:
    mcu.smla({"X": 10.0}, ac=500.0, vl=20.0)
    mcu.smlr({"X": -4.0}, ac=500.0, vl=1.0)
    mcu.ssms("X")
    mcu.advance(700)  # inside the second line
    assert 6.0 < mcu.rddp("X") < 10.0
    assert mcu.rdtp("X") == 6.0


@pytest.mark.shows("pcap.rdtrovrst", "pcap.rdmodereg", "pcap.rderrorreg", "pcap.js.sdec-default")
def test_registers_are_read_as_they_were_written(mcu: Mcu) -> None:
    mcu.wrtrovrst(0.75)
    assert mcu.rdtrovrst() == 0.75
    mcu.wrmodereg(0x181)
    assert mcu.rdmodereg() == 0x181
    assert mcu.rderrorreg() == 0
    mcu.smla({"X": 1.0}, ac=500.0, vl=0.0)
    assert mcu.rderrorreg().VelocityZero
    assert mcu.rderrorreg() & 1 << 12
    shown = mcu.machine.show()
    assert mcu.rdsdec("X") == float(re.findall(r"(?m)^stop_deceleration = (.+)$", shown)[0])
    mcu.smla({"X": 1.0}, ac=500.0, vl=5.0)
    mcu.ssms("X")
    mcu.advance(5)
    mcu.wrsdec("X", 123.0)
    assert mcu.rdsdec("X") == 123.0


@pytest.mark.shows("pcap.rdcncts", "pcap.stepcnct", "pcap.contcnct")
def test_status_of_a_task(mcu: Mcu) -> None:
    program = gcode.compile("G90 G21\nG1 X5 F3000\n\nX10\nM30\n", mcu.machine)
    mcu.prepare_gcode()
    mcu.load(2, program)
    assert mcu.rdcncts(2).running == 0
    mcu.stepcnct(2)
    mcu.advance(1000)
    status = mcu.rdcncts(2)
    assert (status.errnum, status.running & 2) == (0, 2), "waits for the next step"
    mcu.contcnct(2)
    mcu.advance(2000)
    assert mcu.rdcncts(2).running == 0
    assert mcu.rddp("X") == 10.0
    assert mcu.rdcncts(0).running == 0, "another task is not concerned"
