"""The resource interface: descriptors, handles, return codes, and every device against the command it mirrors."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable

import pytest

import gcode
import sympas
from motion_kernel import Machine, Mcu, ModeReg
from motion_kernel.resources import DEVICES, READ, WRITE, Code, DataType, ObjectDescriptor, ResourceError
from tests.conformance.conftest import ROTARY

D = DataType.DOUBLE
DP, CI, CD = 1, 12, 13


@pytest.fixture
def moving(lathe: Mcu) -> Mcu:
    """X on its way to 50 at 20 mm/s, C to 90 degrees."""
    lathe.smla({"X": 50.0}, ac=500.0, vl=20.0)
    lathe.ssms(["X"])
    lathe.ja({"C": 90.0})
    lathe.advance(300)
    return lathe


def dbl(mcu: Mcu, device: int, index: int = 0, sub: int = 0) -> tuple[int, float]:
    return mcu.resources.rdoptiondbl(ObjectDescriptor(device, index, sub, D))


def int_(mcu: Mcu, device: int, index: int = 0, sub: int = 0) -> tuple[int, int]:
    return mcu.resources.rdoptionint(ObjectDescriptor(device, index, sub))


# ---- access, handles, return codes


@pytest.mark.shows("res.option.resource", "res.option.visible", "res.option.pci", "res.hostmem.requirements")
def test_options(mcu: Mcu) -> None:
    assert {"RESOURCE", "PCI"} <= set(mcu.resources.options)
    base = ObjectDescriptor(300, access=WRITE)
    assert mcu.resources.wroptionint(base, 4096) == Code.OK
    mcu.resources.fit("RESOURCE")
    assert mcu.resources.options == ["RESOURCE"]
    assert mcu.resources.wroptionint(base, 4096) == Code.UNKNOWN and dbl(mcu, DP)[0] == Code.OK
    mcu.resources.fit("PCI")
    assert dbl(mcu, DP)[0] == Code.UNKNOWN and mcu.resources.wroptionint(base, 4096) == Code.UNKNOWN
    with pytest.raises(ValueError, match="TEA"):
        mcu.resources.fit("TEA")


@pytest.mark.shows(
    "res.access.methods", "res.return.ok-4", "res.return.must-be-checked", "res.descriptor.handle",
    "res.descriptor.devicenumber", "res.descriptor.index", "res.handle.assigned-on-first-access",
)  # fmt: skip
def test_first_access_gives_the_handle(mcu: Mcu) -> None:
    mcu.wrcd(5, 2.5)
    reading = ObjectDescriptor(CD, 5, type=D)
    assert mcu.resources.rdoptiondbl(reading) == (Code.OK, 2.5)
    handle = reading.handle
    assert handle != 0
    assert mcu.resources.rdoptiondbl(reading) == (Code.OK, 2.5) and reading.handle == handle
    writing = ObjectDescriptor(CD, 5, type=D, access=WRITE)
    assert mcu.resources.wroptiondbl(writing, -1.0) == Code.OK and mcu.rdcd(5) == -1.0
    assert writing.handle not in (0, handle)
    other = ObjectDescriptor(CI, 6)
    mcu.wrci(6, 77)
    assert mcu.resources.rdoptionint(other) == (Code.OK, 77)
    assert mcu.resources.wroptionint(ObjectDescriptor(CI, 6, access=WRITE), -3) == Code.OK and mcu.rdci(6) == -3


@pytest.mark.shows("res.descriptor.busnumber", "res.return.unknown-1", "res.return.undefined-device")
def test_what_is_no_resource(mcu: Mcu) -> None:
    for bus in (0, 999, 1001, -1):
        descriptor = ObjectDescriptor(DP, type=D, bus=bus)
        assert mcu.resources.rdoptiondbl(descriptor) == (Code.UNKNOWN, 0.0) and descriptor.handle == 0
    known = set(itertools.chain(*(range(d.first, d.last + 1) for d in DEVICES.values())))
    for number in [*range(-5, 450), 2999, 9999, 2**31 - 1, -(2**31)]:
        if number not in known:
            codes = {int_(mcu, number)[0], dbl(mcu, number)[0]}
            assert codes == {Code.UNKNOWN}, number
    assert known.isdisjoint({25, 34, 35, 43})


@pytest.mark.shows(
    "res.handle.one-per-direction", "res.handle.inputoutput-wrong", "res.access.read-only", "res.access.write-only",
    "res.access.integer-by-int", "res.access.double-by-dbl", "res.return.other-is-error",
)  # fmt: skip
def test_directions_and_data_types(mcu: Mcu) -> None:
    r = mcu.resources
    assert r.rdoptiondbl(ObjectDescriptor(CD, type=D, access=3))[0] == Code.UNKNOWN
    assert r.wroptiondbl(ObjectDescriptor(CD, type=D, access=3), 1.0) == Code.UNKNOWN
    assert r.rdoptiondbl(ObjectDescriptor(CD, type=D, access=WRITE))[0] == Code.UNKNOWN
    assert r.wroptiondbl(ObjectDescriptor(CD, type=D, access=READ), 1.0) == Code.UNKNOWN
    assert mcu.rdcd(0) == 0.0
    assert r.wroptiondbl(ObjectDescriptor(DP, type=D, access=WRITE), 5.0) == Code.UNKNOWN and mcu.rddp(0) == 0.0
    assert r.rdoptionint(ObjectDescriptor(87))[0] == Code.UNKNOWN
    assert r.rdoptiondbl(ObjectDescriptor(CI))[0] == Code.UNKNOWN
    assert r.rdoptiondbl(ObjectDescriptor(CI, type=D))[0] == Code.UNKNOWN
    assert r.wroptiondbl(ObjectDescriptor(CI, access=WRITE), 1.0) == Code.UNKNOWN
    assert r.rdoptionint(ObjectDescriptor(DP, type=D))[0] == Code.UNKNOWN
    assert r.wroptionint(ObjectDescriptor(CD, type=D, access=WRITE), 1) == Code.UNKNOWN
    with pytest.raises(ResourceError, match="code 1"):
        r.AOUT[0]


def test_errors_by_name_say_what_to_do(mcu: Mcu) -> None:
    r = mcu.resources
    with pytest.raises(ResourceError, match="the board has no option ENDAT"):
        r.ENDAT_TPV["X"]
    with pytest.raises(ResourceError, match="only be written"):
        r.AOUT[0]
    with pytest.raises(ResourceError, match="only be read"):
        r.dp["X"] = 1.0
    with pytest.raises(ResourceError, match="Index: axis, SubIndex: 0 to 5"):
        r.RefOffset["X", 6]
    with pytest.raises(AttributeError, match="did you mean poserr"):
        r.poserror["X"]
    with pytest.raises(IndexError, match="no such index"):
        r.dp["X", 1, 2]
    with pytest.raises(KeyError, match="no axis Q; it has X, Y, Z"):
        r.dp["Q"]


@pytest.mark.shows("res.return.index-range", "res.descriptor.subindex")
def test_out_of_range_changes_nothing(mcu: Mcu) -> None:
    mcu.resources.fit("RESOURCE", "ENDAT")
    for device in DEVICES.values():
        if device.index == "axis" and device.readable:
            for index in (-1, 3, 2**31 - 1):
                d = ObjectDescriptor(device.first, index, type=device.type)
                read = mcu.resources.rdoptiondbl if device.type is D else mcu.resources.rdoptionint
                assert read(d)[0] == Code.STATE_ERR and d.handle == 0, device.name
    assert int_(mcu, 24, 4)[0] == int_(mcu, 70, -1)[0] == int_(mcu, 100, 8)[0] == int_(mcu, 101, 8)[0] == 0x80
    assert int_(mcu, CI, 1000)[0] == dbl(mcu, CD, 1000)[0] == dbl(mcu, 16, 0, 6)[0] == dbl(mcu, 200, 0, 15)[0] == 0x80
    assert dbl(mcu, DP, 0, 1)[0] == 0x80
    assert mcu.resources.wroptionint(ObjectDescriptor(CI, 1000, access=WRITE), 5) == 0x80
    assert mcu.resources.wroptionint(ObjectDescriptor(87, 4, access=WRITE), 5) == 0x80
    assert mcu.rdci(1000) == [0] * 1000 and mcu.resources.analog_outputs == [0] * 4


@pytest.mark.shows("res.dev-0000.clear", "res.dev-0000.clear.before-group", "res.handle.zero-after-clear")
def test_clear(mcu: Mcu) -> None:
    r = mcu.resources
    first = [ObjectDescriptor(CI, n) for n in range(3)]
    for n, descriptor in enumerate(first):
        mcu.wrci(n, 10 + n)
        assert r.rdoptionint(descriptor) == (Code.OK, 10 + n)
    assert len({d.handle for d in first}) == 3
    assert r.wroptionint(ObjectDescriptor(0, 1, access=WRITE), 0) == Code.STATE_ERR
    assert r.rdoptionint(first[2])[0] == Code.OK
    assert r.wroptionint(ObjectDescriptor(0, 1, access=WRITE), 1) == Code.OK
    assert r.rdoptionint(first[0]) == (Code.UNKNOWN, 0), "a stale handle"
    other = ObjectDescriptor(CI, 7)
    assert r.rdoptionint(other) == (Code.OK, 0) and other.handle == first[0].handle, "issued from the start"
    assert r.rdoptionint(first[0]) == (Code.UNKNOWN, 0), "not the value of CI7"
    first[0].handle = 0
    assert r.rdoptionint(first[0]) == (Code.OK, 10)
    forged = ObjectDescriptor(CI, 1, handle=2**31 - 1)
    assert r.rdoptionint(forged)[0] == Code.UNKNOWN
    mcu._card.emulator.reboot()
    assert r.rdoptionint(first[0])[0] == Code.UNKNOWN


@pytest.mark.shows("res.return.busy-2", "res.dev-0101.WTLSTRB", "res.dev-0101.WTLSTRB.resets")
def test_latch_strobe(mcu: Mcu) -> None:
    strobe = ObjectDescriptor(101, 0)
    assert mcu.resources.rdoptionint(strobe) == (Code.BUSY, 0) and strobe.handle != 0
    mcu.set_inputs(1 << 13)
    assert mcu.rddigi("X").strobe
    assert mcu.resources.rdoptionint(strobe) == (Code.OK, 1)
    assert not mcu.rddigi("X").strobe
    assert mcu.resources.rdoptionint(strobe) == (Code.BUSY, 0)


# ---- devices

MIRRORS: list[tuple[str, Callable[[Mcu, str], float]]] = [
    ("dp", lambda m, a: m.rddp(a)),
    ("rp", lambda m, a: m.rdrp(a)),
    ("axst", lambda m, a: int(m.rdaxst(a))),
    ("digi", lambda m, a: int(m.rddigi(a))),
    ("digo", lambda m, a: m.rddigo(a)),
    ("poserr", lambda m, a: m.rdposerr(a)),
    ("dv", lambda m, a: m.rddv(a)),
    ("rv", lambda m, a: m.rdrv(a)),
    ("aux", lambda m, a: m.rdaux(a)),
    ("PTP", lambda m, a: m.rdtp(a)),
    ("mcp", lambda m, a: m.rdmcp(a)),
    ("PcapIndex", lambda m, a: m.rdpcapindex(a)),
    ("ZPOffset", lambda m, a: m.rdzerooffset(a)),
    ("DpOffset", lambda m, a: m.rddpoffset(a)),
]


@pytest.mark.shows(
    "res.dev-0001.dp", "res.dev-0002.rp", "res.dev-0003.axst", "res.dev-0004.digi", "res.dev-0006.digo",
    "res.dev-0007.poserr", "res.dev-0009.dv", "res.dev-0010.rv", "res.dev-0011.aux", "res.dev-0023.PTP",
    "res.dev-0026.mcp", "res.dev-0032.PcapIndex", "res.dev-0036.ZPOffset", "res.dev-0037.DpOffset",
)  # fmt: skip
@pytest.mark.parametrize(("name", "command"), MIRRORS, ids=lambda x: x if isinstance(x, str) else "")
def test_device_equals_its_command(name: str, command: Callable[[Mcu, str], float]) -> None:
    mcu = Mcu(Machine.parse(ROTARY))
    mcu.cl(["X", "C"])
    mcu.set_inputs(5)
    mcu.wrdigo("X", 3)
    mcu.wraux("X", 7.0)
    mcu.szpa("C", 30.0)
    mcu.wrdpoffset("X", 0.5)
    mcu.smlai({"X": 50.0, "C": 90.0}, ac=500.0, vl=20.0, pcapindex=9)
    mcu.ssms(["X", "C"])
    seen = set()
    for _ in range(4):
        mcu.advance(97)
        values = [command(mcu, axis) for axis in ("X", "C")]
        resource = getattr(mcu.resources, name)
        assert [resource[axis] for axis in ("X", "C")] == values == [resource[0], resource[1]]
        seen.update(values)
    assert seen != {0.0}


@pytest.mark.shows("res.dev-0005.scntr")
def test_sample_counter(mcu: Mcu) -> None:
    before = mcu.resources.scntr[0]
    mcu.advance(17)
    assert mcu.resources.scntr[0] == before + 17


@pytest.mark.shows("res.dev-0008.trvl", "res.dev-0020.DTV0", "res.dev-0021.DTV1")
def test_trajectory_velocities(lathe: Mcu) -> None:
    lathe.ctru("mm", "min")
    lathe.wrmaxvel("X", 600.0)
    lathe.wrmodereg(ModeReg.of("ChkMaxVel"))
    assert lathe.resources.trvl["X"] == lathe.resources.DTV0[0] == lathe.resources.DTV1[0] == 0.0
    lathe.smla({"X": 50.0}, ac=500.0 * 3600, vl=1200.0)
    lathe.ssms(["X"])
    lathe.advance(500)
    dv = lathe.rddv("X") * 60
    assert dv == pytest.approx(600.0) == lathe.resources.trvl["X"] == lathe.resources.DTV1[0]
    assert lathe.resources.DTV0[0] == pytest.approx(1200.0)
    lathe.wrtrovr(0.5)
    lathe.utrovr(["X"])
    lathe.advance(500)
    assert lathe.resources.trvl["X"] == pytest.approx(lathe.rddv("X") * 60) == 300.0


@pytest.mark.shows(
    "res.dev-0012.CI", "res.dev-0013.CD", "res.dev-0019.LookAheadDepth", "res.dev-0019.LookAheadDepth.zero",
    "res.dev-0027.Backlash", "res.dev-0040.backlash-hysteresis", "res.dev-0018.PositionFactor",
    "res.dev-0018.PositionFactor.default", "res.dev-0018.PositionFactor.zero", "res.dev-0017.Mirror",
)  # fmt: skip
def test_what_is_written_is_read(mcu: Mcu) -> None:
    r = mcu.resources
    for n in (0, 99, 999):
        r.CI[n], r.CD[n] = n - 500, n / 7
        assert (r.CI[n], r.CD[n]) == (n - 500, n / 7) == (mcu.rdci(n) if n else r.CI[0], mcu.rdcd(n))
    assert r.LookAheadDepth[0] == 0
    r.LookAheadDepth[0] = 12
    assert r.LookAheadDepth[0] == 12
    for name in ("Backlash", "backlash"):
        resource = getattr(r, name)
        assert resource["Y"] == 0.0
        resource["Y"] = 0.25
        assert (resource["Y"], resource["X"]) == (0.25, 0.0)
    assert r.PositionFactor["X"] == -1.0
    r.PositionFactor["X"] = -2.0
    with pytest.raises(ResourceError, match="80 hex"):
        r.PositionFactor["X"] = 0.0
    assert r.PositionFactor["X"] == -2.0
    r.Mirror["X"] = 1
    assert (r.Mirror["X"], r.Mirror["Y"]) == (1, 0)
    r.Mirror["X"] = 0
    assert r.Mirror["X"] == 0


@pytest.mark.shows("res.dev-0016.RefOffset")
def test_zero_offsets(lathe: Mcu) -> None:
    r = lathe.resources
    assert [r.RefOffset["X", n] for n in range(6)] == [10.0, 0.0, 0.0, 0.0, -2.5, 0.0]
    r.RefOffset["X", 1] = 4.0
    r.RefOffset["X", 5] = 8.0
    lathe.azo(1)
    assert lathe.rdzerooffset("X") == 4.0 and r.RefOffset["X", 5] == 8.0
    lathe.azo(5)
    assert lathe.rdzerooffset("X") == 0.0


@pytest.mark.shows("res.dev-0030.ActualBacklash")
def test_backlash_in_effect(lathe: Mcu) -> None:
    r = lathe.resources
    r.Backlash["X"] = 0.5
    lathe.ja({"X": 5.0})
    lathe.advance(500)
    assert r.ActualBacklashValue["X"] == 0.0
    lathe.ja({"X": 3.0})
    lathe.advance(500)
    assert r.ActualBacklashValue["X"] == -0.5


@pytest.mark.shows(
    "res.dev-0028.MCP_MAX", "res.dev-0029.MCP_MIN", "res.dev-0038.mcpmax", "res.dev-0039.mcpmin",
    "res.access.float-by-int",
)  # fmt: skip
def test_motor_command_in_digits_and_volts(mcu: Mcu) -> None:
    r = mcu.resources
    bits = struct.unpack("<i", struct.pack("<f", 32768.0))[0]
    assert r.rdoptionint(ObjectDescriptor(28, 0, type=DataType.FLOAT)) == (Code.OK, bits)
    assert r.rdoptiondbl(ObjectDescriptor(28, 0, type=DataType.FLOAT))[0] == Code.UNKNOWN
    assert (r.mcpmax["X"], r.mcpmin["X"], r.MCP_MIN["X"]) == (10.0, -10.0, -32768.0)
    r.MCP_MAX["X"] = 1638.4
    assert r.mcpmax["X"] == pytest.approx(0.5)
    r.mcpmin["X"] = -0.25
    assert r.MCP_MIN["X"] == pytest.approx(-819.2)
    for volts in (10.1, -5.0, float("nan")):
        with pytest.raises(ResourceError):
            r.mcpmax["X"] = volts
    assert r.mcpmax["X"] == pytest.approx(0.5)
    mcu.ja({"X": 50.0})
    mcu.advance(100)
    assert mcu.rdmcp("X") == 1638


@pytest.mark.shows("res.dev-0041.mcpcp", "res.dev-0042.mcpcn")
@pytest.mark.parametrize(("name", "target", "digits"), [("mcpcp", 50.0, 3276.8), ("mcpcn", -50.0, -6553.6)])
def test_zero_compensation(name: str, target: float, digits: float) -> None:
    plain, compensated = (Mcu(Machine.parse(ROTARY)) for _ in range(2))
    register = getattr(compensated.resources, name)
    assert register["X"] == 0.0
    for mcu in (plain, compensated):
        mcu.cl(["X"])
        mcu.ja({"X": target})
        mcu.advance(100)
    register["X"] = abs(digits) / 3276.8
    assert register["X"] == pytest.approx(abs(digits) / 3276.8)
    for mcu in (plain, compensated):
        mcu.advance(1)
    assert compensated.rdmcp("X") - plain.rdmcp("X") == pytest.approx(digits, abs=1.0)
    with pytest.raises(ResourceError, match="80 hex"):
        register["X"] = -1.0


@pytest.mark.shows("res.dev-0406.MCP_OFFSET")
def test_motor_command_offset(mcu: Mcu) -> None:
    mcu.advance(10)
    before = mcu.rdmcp("X")
    mcu.resources.MCPOFFSET["X"] = 300.0
    mcu.advance(1)
    assert mcu.rdmcp("X") == before + 300 and mcu.rdmcp("Y") == before
    assert mcu.resources.MCPOFFSET["X"] == 300.0


@pytest.mark.shows("res.dev-0014.lp", "res.dev-0015.lpndx")
def test_latched_positions(moving: Mcu) -> None:
    moving.wrlpndx("X", 3.25)
    assert moving.resources.lpndx["X"] == 3.25
    moving.lps("X", 10)
    moving.advance(10)
    assert moving.resources.lp["X"] == moving.rdrp("X") != 0.0


@pytest.mark.shows("res.dev-0033.PosKorrRotAxis")
def test_revolutions(lathe: Mcu) -> None:
    lathe.ol(["X", "C"])
    for position, revolutions in ((0.0, 0), (359.0, 0), (360.0, 1), (1000.0, 2), (-10.0, -1)):
        lathe.wrrp("C", position)
        lathe.wrrp("X", position)
        assert (lathe.resources.PosKorrRotAxis["C"], lathe.resources.PosKorrRotAxis["X"]) == (revolutions, 0)


@pytest.mark.shows("res.dev-0031.PosErrAux")
def test_following_error_of_the_second_encoder() -> None:
    text = ROTARY.replace("[[axis]]", '[[axis]]\ndrive = "stepper"').replace(
        'display_unit = "inch"', 'display_unit = "inch"\nencoder = { counts_per_unit = 500 }'
    )
    mcu = Mcu(Machine.parse(text))
    mcu.cl(["X", "C"])
    mcu.wrgfaux("X", 2.0)
    mcu.ja({"X": 20.0, "C": 20.0})
    mcu.advance(100)
    expected = mcu.rddp("X") - mcu.rdaux("X") * 2.0 / 1000
    assert mcu.resources.PosErrAux["X"] == pytest.approx(expected, abs=1e-9) != 0.0
    assert mcu.resources.PosErrAux["C"] == 0.0


@pytest.mark.shows("res.dev-0062.EpmRevSdiCh0", "res.dev-0063.EpmRevSdiCh1", "res.dev-0079.INV_DIGI")
def test_board(mcu: Mcu) -> None:
    r = mcu.resources
    assert (r.EpmRevSdiCh0[0], r.EpmRevSdiCh1[0], r.INV_DIGI["X"]) == (1, 0, 0)
    inverted = Mcu(Machine.parse(ROTARY + "[[input]]\nnumber = 3\ninverted = true\n"))
    assert inverted.resources.INV_DIGI["X"] == inverted.resources.INV_DIGI["C"] == 4


@pytest.mark.shows("res.dev-0064.FastPulseOut")
def test_fast_pulse_outputs(mcu: Mcu) -> None:
    with pytest.raises(ResourceError, match="code 1"):
        mcu.resources.FASTPULSEOUT[0] = 4
    mcu.resources.fit("RESOURCE", "FAST_PULSE")
    for mask in (7, 4, 0):
        mcu.resources.FASTPULSEOUT[0] = mask
        assert mcu.resources.fast_outputs == mcu.resources.FASTPULSEOUT[0] == mask


@pytest.mark.shows("res.dev-0083.AOUT03", "res.dev-0087.AOUT", "res.dev-0100.ain_CH")
def test_analog_channels(mcu: Mcu) -> None:
    r = mcu.resources
    r.AOUT[1], r.AOUT[2], r.AOUT03[0] = 100, -32768, 32767
    assert r.analog_outputs == [0, 100, -32768, 32767]
    with pytest.raises(ResourceError, match="80 hex"):
        r.AOUT[0] = 40000
    r.AOUT[3] = 5
    assert r.analog_outputs == [0, 100, -32768, 5]
    r.set_analog_input(7, -123)
    assert [r.ain_CH[n] for n in range(8)] == [0] * 7 + [-123]


@pytest.mark.shows("res.dev-0105.EVLSS")
def test_software_limits_without_shp(mcu: Mcu) -> None:
    mcu.wrslr("X", -1.0)
    limits = mcu.resources.EVLSS
    mcu.advance(2)
    assert limits["X"] == 0 and not mcu.rdaxst("X").lsrs
    limits["X"] = 1
    mcu.advance(2)
    assert limits["X"] == 1 and limits["Y"] == 0 and mcu.rdaxst("X").lsrs and not mcu.rdaxst("X").referenced
    limits["X"] = 0
    mcu.advance(2)
    assert limits["X"] == 0 and not mcu.rdaxst("X").lsrs
    mcu.shp("X", 0.0)
    assert limits["X"] == 1
    with pytest.raises(ResourceError, match="80 hex"):
        limits["X"] = 2


@pytest.mark.shows(
    "res.dev-0200-0214.cp", "res.dev-0200.cp-column-0", "res.dev-0201-0213.cp-columns", "res.dev-0214.cp-column-14"
)
def test_controller_parameters(mcu: Mcu) -> None:
    field = [[15.0 * line + column for column in range(15)] for line in range(15)]
    mcu.scp("Y", field)
    assert [[mcu.resources.cp["Y", line, column] for column in range(15)] for line in range(15)] == field
    for column, line in ((0, 2), (7, 3), (14, 14)):
        d = ObjectDescriptor(200 + column, 1, line, D, WRITE)
        assert mcu.resources.wroptiondbl(d, -1.0) == Code.OK
        assert mcu.controller_parameters("Y")[line][column] == -1.0 == mcu.resources.cp["Y", line, column]
    assert mcu.resources.cp["X", 3, 0] == 0.0


@pytest.mark.shows("res.dev-0320.IsisSensorFrequencyFactor", "res.dev-0321.IsisPosNormFactor")
def test_isis_factors(lathe: Mcu) -> None:
    r = lathe.resources
    with pytest.raises(ResourceError, match="code 1"):
        r.IsisPosNormFactor[0, "X"]
    r.fit("RESOURCE", "ISIS")
    assert [r.IsisPosNormFactor[0, axis] for axis in ("X", "C")] == [20000.0, 4000.0]
    r.IsisPosNormFactor[0, "C"], r.IsisSensorFrequencyFactor[0, "X"] = 5.0, 8
    assert (r.IsisPosNormFactor[0, "C"], r.IsisSensorFrequencyFactor[0, "X"]) == (5.0, 8)
    assert (r.IsisPosNormFactor[0, "X"], r.IsisSensorFrequencyFactor[0, "C"]) == (20000.0, 1)


@pytest.mark.shows("res.dev-0024.TaskLineNr", "res.dev-0070.TaskStatus")
def test_tasks(mcu: Mcu) -> None:
    mcu.prepare_gcode()
    mcu.load(2, gcode.compile("G90 G21\n\nG4 F1\nM30\n", mcu.machine))
    mcu.load(1, sympas.compile("begin write('a'); writeln('b'); end.\n", mcu.machine))
    mcu.startcnct(2)
    mcu.startcnct(1)
    mcu.advance(20)
    lines = [mcu.resources.TaskLineNr[n] for n in range(4)]
    assert lines == [mcu.rdcncts(n).csrcline for n in range(4)] and lines[2] > 0 == lines[3]
    assert [mcu.resources.TASKSTATUS[n] for n in range(4)] == [mcu.gettskinfo(n) for n in range(4)] == [0, 2, 0, 0]
