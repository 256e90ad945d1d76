"""Digital inputs and outputs, interface status, configuration check (4.4.45, 4.4.52 to 4.4.55, 4.4.70, 4.4.138)."""

from __future__ import annotations

from pathlib import Path

import pytest

from motion_kernel import Machine, Mcu
from tests.conformance.conftest import MILL, stop

AXIS = '[[axis]]\nname = "{}"\ndrive = "{}"\ncounts_per_unit = 1000\nrapid = 100\nacceleration = 1000\n'
PAE = """
[[output]]
number = 1
function = "PAE"
axis = "X"
[[output]]
number = 2
function = "PAE"
axis = "Y"
[[output]]
number = 3
on = true
"""


@pytest.fixture
def cell() -> Mcu:
    """Axes X and Y whose amplifiers are enabled by outputs 1 and 2; output 3 is on by default."""
    return Mcu(Machine.parse(AXIS.format("X", "servo") + AXIS.format("Y", "servo") + PAE))


@pytest.mark.shows(
    "digi.bit0", "digi.bit1", "digi.bit2", "digi.bit3", "digi.bit4", "digi.bit5", "digi.bit6", "digi.bit7",
    "digi.bit8", "digi.bit9", "digi.bit10", "digi.bit11", "digi.bit12", "digi.bit13", "digi.bit14", "digi.bit15",
    "pcap.rddigi", "pcap.rddigib", "pcap.rddigib.inputs", "pcap.rddigi.no-axis-mapping",
)  # fmt: skip
@pytest.mark.parametrize("number", range(1, 17))
def test_each_input_has_its_bit(mcu: Mcu, number: int) -> None:
    rest = mcu.rddigi("X")
    mcu.set_inputs(rest ^ 1 << (number - 1))
    assert {(mcu.rddigi(axis) ^ rest) & 0xFFFF for axis in ("X", "Y", "Z")} == {1 << (number - 1)}
    assert [mcu.rddigib("X", n) for n in range(1, 17)] == [
        (int(rest) >> (n - 1) & 1) ^ int(n == number) for n in range(1, 17)
    ]


@pytest.mark.shows("digi.bits24-31", "pcap.rddigib.undefined")
def test_other_bits_of_digi_read_0(mcu: Mcu) -> None:
    mcu.set_inputs(0xFFFFFFFF)
    assert mcu.rddigi("X") >> 24 == 0
    assert [mcu.rddigib("X", n) for n in (*range(25, 34), 0, -1)] == [0] * 11


@pytest.mark.shows(
    "digo.bit0", "digo.bit1", "digo.bit2", "digo.bit3", "digo.bit4", "digo.bit5", "digo.bit6", "digo.bit7",
    "pcap.wrdigo", "pcap.wrdigob", "pcap.wrdigob.reset", "pcap.wrdigob.bitnr", "pcap.rddigob",
    "pcap.wrdigo.not-axis-specific",
)  # fmt: skip
@pytest.mark.parametrize("number", range(1, 9))
def test_each_output_has_its_bit(mcu: Mcu, number: int) -> None:
    mcu.wrdigo("X", 0)
    mcu.wrdigob("Y", number, 1)
    assert [mcu.rddigo(axis) for axis in ("X", "Y", "Z")] == [1 << (number - 1)] * 3
    assert [mcu.rddigob("Z", n) for n in range(1, 9)] == [int(n == number) for n in range(1, 9)]
    mcu.wrdigo("Z", 0xFF)
    mcu.wrdigob("X", number, 0)
    assert mcu.rddigo("Y") == 0xFF ^ 1 << (number - 1)


@pytest.mark.shows("digo.bits8-31", "pcap.wrdigob.unassigned")
def test_there_are_8_outputs(mcu: Mcu) -> None:
    mcu.wrdigo("X", 0xFFFFFF0F)
    assert mcu.rddigo("X") == 0x0F
    for bitnr in (*range(9, 33), 0, -1, 99):
        mcu.wrdigob("X", bitnr, 1)
    assert mcu.rddigo("X") == 0x0F


@pytest.mark.shows("ssf.example-set", "ssf.example-reset", "struct.tsrp.digo")
def test_outputs_from_the_spooler(mcu: Mcu) -> None:
    mcu.wrdigo("X", 0b110)
    mcu.cl("X")
    mcu.ssf("X", 1001, 1)
    mcu.ssf("X", 1002, 4)
    assert mcu.rddigo("X") == 0b110
    mcu.ssms("X")
    mcu.advance(3)
    assert mcu.rddigo("X") == mcu.rdap("X").digo == 0b011


@pytest.mark.shows("pcap.cl.pae", "pcap.ol.pae", "pcap.clv.pae")
@pytest.mark.parametrize("close", ["cl", "clv"])
def test_loops_and_amplifiers(cell: Mcu, close: str) -> None:
    cell.wrdigo("X", 0)
    getattr(cell, close)(["X"])
    assert cell.rddigo("X") == 0b011, "all outputs with PAE"
    cell.ol("X")
    assert cell.rddigo("X") == 0b010, "those of the axis"


@pytest.mark.shows("pcap.ra.outputs", "pcap.ra.pae-group", "pcap.rs", "pcap.rs.outputs")
def test_resets_and_outputs(cell: Mcu) -> None:
    cell.cl(["X", "Y"])
    cell.wrdigo("X", 0b11001011)
    cell.ra("X")
    assert cell.rddigo("X") == 0b100, "as configured, also the amplifier of Y is off"
    cell.cl("X")
    cell.wrdigo("X", 0xFF)
    cell.rs()
    assert cell.rddigo("X") == 0b100


@pytest.mark.shows("ssf.1004.group")
@pytest.mark.parametrize("number", [1, 16])
def test_any_input_can_be_waited_for_by_any_axis(mcu: Mcu, number: int) -> None:
    mcu.set_inputs(0)
    mcu.cl("Z")
    mcu.ssf("Z", 1004, 1 << (number - 1))
    mcu.ssf("Z", 5, 1)
    mcu.ssms("Z")
    mcu.advance(50)
    assert mcu.rdci(5) == 0
    mcu.set_inputs(1 << (number - 1))
    mcu.advance(5)
    assert mcu.rdci(5) == 1


@pytest.mark.shows(
    "pcap.rdifs", "pcap.rdifs.ret-0", "ifs.edv", "ifs.cncrdy", "ifs.bits2-15", "pcap.rdifsb", "pcap.rdifsb.one-based",
    "struct.tsrp.ifs", "pcap.rs.keeps-ifs",
)  # fmt: skip
def test_interface_status(mcu: Mcu) -> None:
    ifs = mcu.rdifs("X")
    assert ifs.edv and ifs.cncrdy
    assert ifs >> 2 & 0x3FFF == 0
    assert ifs == mcu.rdap("Y").ifs
    assert [mcu.rdifsb("X", n) for n in range(1, 33)] == [int(ifs) >> (n - 1) & 1 for n in range(1, 33)]
    assert mcu.rdifsb("Z", 1) == 1, "edv"
    mcu.rs()
    assert mcu.rdifs("X") == ifs
    with pytest.raises(stop(mcu)) as error:
        mcu.rdifs("X")
    assert error.value.status != 0


@pytest.mark.shows("ifs.pfe", "ifs.scpfe", "ifs.boot-copy", "ifs.rifs-clears", "pcap.rifs", "ifs.bus-error")
def test_errors_of_the_interface(mcu: Mcu, tmp_path: Path) -> None:
    from tests.conformance.test_system import elf

    rwmos = tmp_path / "rwmos.elf"
    rwmos.write_bytes(elf())

    def boot() -> None:
        assert mcu.bootfile(rwmos) == 0
        assert mcu.initmcusystem().status == 0

    assert {"pfe", "scpfe"} <= set(mcu.rdifs().names), "after power-up"
    boot()
    assert not {"pfe", "scpfe"} & set(mcu.rdifs().names), "a second boot has nothing to copy"
    mcu.play("undervoltage", deep=False)
    assert mcu.rdifs().scpfe and not mcu.rdifs().pfe, "below 4.75 V"
    mcu.play("undervoltage", deep=True)
    assert mcu.rdifs().scpfe and mcu.rdifs().pfe, "below 2.85 V"
    mcu.play("bus_error")
    mcu.rifs("X")
    assert mcu.rdifs().names == ("edv", "cncrdy", "bus_error"), "bits 21 to 23 need a boot"
    boot()
    assert {"pfe", "scpfe"} <= set(mcu.rdifs().names), "copied from the logic"
    assert not mcu.rdifs().bus_error
    boot()
    assert mcu.rdifs().names == ("edv", "cncrdy")


@pytest.mark.shows(
    "digi.bit17", "digi.bit20", "digi.bit21", "digi.bit22", "digi.bit23", "pcap.rddigib.18", "pcap.rddigib.21",
    "pcap.rddigib.22", "pcap.rddigib.23", "pcap.rddigib.24", "pcap.rdigi", "pcap.rddigi.rdigi", "struct.tsrp.digi",
)  # fmt: skip
def test_the_alarms_of_an_encoder(mcu: Mcu) -> None:
    alarms = ("AEA", "AEB", "AEN", "AES")
    assert not mcu.rddigi("X").names
    mcu.play("cut_encoder", "X", on=True)
    mcu.advance(1)
    assert mcu.rddigi("X").names == ("error", *alarms)
    assert mcu.rdap("X").digi == mcu.rddigi("X")
    assert [mcu.rddigib("X", n) for n in (18, 21, 22, 23, 24)] == [1] * 5
    assert not mcu.rddigi("Y").names
    mcu.play("cut_encoder", "X", on=False)
    mcu.advance(1)
    assert mcu.rddigi("X").names == ("error",), "the error is stored"
    mcu.rdigi("Y")
    assert mcu.rddigi("X").error
    mcu.rdigi("X")
    assert not mcu.rddigi("X").names


@pytest.mark.shows("axst.cef", "axst.cef.after-txbf2")
def test_the_configuration_is_checked(tmp_path: Path) -> None:
    mcu = Mcu(Machine.parse(AXIS.format("X", "servo")))
    assert not mcu.rdaxst("X").cef
    for drive in ("stepper", "servo"):
        (tmp_path / f"{drive}.toml").write_text(AXIS.format("X", drive))
    assert mcu.txbf2(tmp_path / "stepper.toml") == 0
    assert mcu.rdaxst("X").cef and mcu.rdaxst("X") & 0x200, "the drive that is there is a servo"
    mcu.rs()
    assert mcu.rdaxst("X").cef
    assert mcu.txbf2(tmp_path / "servo.toml") == 0
    assert not mcu.rdaxst("X").cef


@pytest.mark.shows("pcap.wripw.monitor", "pcap.wrmpe.monitor", "errorreg.bit20")
def test_windows_of_0_are_not_watched(mcu: Mcu) -> None:
    def blocked(mpe: float, ipw: float, *, closed: bool = True) -> tuple[bool, bool]:
        """(mpe, ip) while X cannot follow, then where it stands."""
        mcu.rs()
        mcu.wrmpe("X", mpe)
        mcu.wripw("X", ipw)
        if closed:
            mcu.cl("X")
            mcu.advance(20)
        ip = mcu.rdaxst("X").ip
        mcu.play("block", "X", on=True)
        if closed:
            mcu.wrdpoffset("X", 3.0)
        mcu.advance(20)
        mcu.play("block", "X", on=False)
        mpe_bit = mcu.rdaxst("X").mpe
        mcu.wrdpoffset("X", 0.0)
        return mpe_bit, ip

    assert blocked(1.0, 0.05) == (True, True)
    assert blocked(0.0, 0.0) == (False, False)
    assert blocked(1.0, 0.05, closed=False)[0] is False
    assert mcu.rderrorreg() & 1 << 20 == 0, "reserved for an option"


def test_faults_that_do_not_exist(mcu: Mcu) -> None:
    with pytest.raises(ValueError, match="cut_encoder"):
        mcu.play("earthquake")
    with pytest.raises(ValueError, match="axis"):
        mcu.play("cut_encoder")
    assert Mcu(Machine.load(MILL)).rdifs().edv
