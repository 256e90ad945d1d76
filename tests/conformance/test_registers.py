"""Plain registers of PCAP (chapter 4.4): what is written is read, defaults come from the machine file, units hold."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields

import numpy as np
import pytest

from motion_kernel import TSRP, CommandRefused, Machine, Mcu, ModeReg
from tests.conformance.conftest import MILL, TA, axis_of_machine, stop

DEFAULTS: list[tuple[str, str]] = [
    ("jac", "jog_acceleration"),
    ("jvl", "jog_velocity"),
    ("jtvl", "jog_target_velocity"),
    ("sdec", "stop_deceleration"),
    ("hac", "jog_acceleration"),
    ("jerkrel", "jerkrel"),
    ("mdvel", "mdvel"),
    ("maxvel", "maxvel"),
    ("maxacc", "maxacc"),
    ("ipw", "ipw"),
    ("mpe", "mpe"),
]


@pytest.mark.shows(
    "pcap.rdjac", "pcap.rdjac.default", "pcap.rdjvl", "pcap.rdjvl.default", "pcap.rdjtvl",
    "pcap.rdsdec", "pcap.rdsdec.default", "pcap.rdjerkrel", "pcap.rdmdvel", "pcap.rdmaxvel", "pcap.rdmaxacc",
    "pcap.wrjac", "pcap.wrjtvl", "pcap.rdipw", "pcap.wripw", "pcap.rdmpe", "pcap.wrmpe", "pcap.rdhac", "pcap.wrhac",
    "pcap.wrjvl", "pcap.wrsdec", "pcap.wrjerkrel", "pcap.wrmdvel", "pcap.wrmaxvel", "pcap.wrmaxacc",
    "struct.tsrp.jac", "struct.tsrp.jvl", "struct.tsrp.jtvl", "struct.tsrp.hac",
    "struct.tsrp.ipw", "struct.tsrp.mpe",
)  # fmt: skip
@pytest.mark.parametrize(("name", "key"), DEFAULTS)
def test_default_then_what_was_written(name: str, key: str) -> None:
    mcu = Mcu(Machine.load(MILL))
    read: Callable[[str], float] = getattr(mcu, f"rd{name}")
    write: Callable[[str, float], None] = getattr(mcu, f"wr{name}")
    assert read("X") == axis_of_machine(key)
    write("X", 0.375)
    assert read("X") == 0.375
    assert read("Y") == axis_of_machine(key), "another axis is not concerned"
    tsrp = mcu.rdap("X")
    if hasattr(tsrp, name):
        assert getattr(tsrp, name) == 0.375


@pytest.mark.shows("struct.tsrp.hvl", "pcap.rdhvl", "pcap.wrhvl")
def test_home_velocity(mcu: Mcu) -> None:
    assert mcu.rdhvl("X") == axis_of_machine("jog_velocity") / 4
    mcu.wrhvl("X", 3.0)
    assert mcu.rdhvl("X") == mcu.rdap("X").hvl == 3.0
    for write in (mcu.wrhvl, mcu.wrhac):
        with pytest.raises(ValueError, match="above 0"):
            write("X", 0.0)


@pytest.mark.shows("jerkrel.default", "jerkrel.clamp", "pcap.wrjerkrel.clamp")
def test_jerkrel_is_limited(mcu: Mcu) -> None:
    machine = Machine.parse('[[axis]]\nname = "X"\ncounts_per_unit = 1000\nrapid = 100\nacceleration = 1000\n')
    assert Mcu(machine).rdjerkrel(0) == 1.0
    for written, read in [(-0.5, 0.0), (1.5, 1.0), (0.25, 0.25), (math.inf, 1.0)]:
        mcu.wrjerkrel("X", written)
        assert mcu.rdjerkrel("X") == read
    with pytest.raises(ValueError, match="finite"):
        mcu.wrjerkrel("X", math.nan)


@pytest.mark.shows("pcap.wrjac.default", "pcap.wrjvl.default", "pcap.ja.params-not-transferred")
def test_a_jog_takes_what_was_written_and_not_a_tsrp(mcu: Mcu) -> None:
    tsrp = mcu.rdap("X")
    tsrp.jvl, tsrp.jac, tsrp.jtvl = 1.0, 10.0, 1.0
    mcu.ja({"X": 100.0})
    mcu.advance(1500)
    v = np.diff(mcu.trace.dp[:, 0]) / TA
    assert v.max() == pytest.approx(axis_of_machine("jog_velocity"), rel=1e-9)
    assert np.diff(v).max() / TA == pytest.approx(axis_of_machine("jog_acceleration"), rel=1e-6)
    mcu.wrjvl("X", 5.0)
    mcu.jr({"X": -20.0})
    mcu.advance(1500)
    assert np.diff(mcu.trace.dp[:, 0]).min() / TA == pytest.approx(-5.0, rel=1e-9)


@pytest.mark.shows("pcap.rdjtvl.default", "pcap.wrjtvl.default")
def test_jogs_end_with_the_target_velocity_of_the_machine() -> None:
    text = '[[axis]]\nname = "X"\ndrive = "stepper"\ncounts_per_unit = 1000\nrapid = 100\nacceleration = 1000\n'
    mcu = Mcu(Machine.parse(f"{text}jog_target_velocity = 2.5\n"))
    assert mcu.rdjtvl("X") == 2.5
    mcu.cl("X")
    mcu.ja({"X": 20.0})
    mcu.advance(1500)
    assert mcu.rddp("X") > 20.0 and mcu.trace.dp[-1, 0] - mcu.trace.dp[-2, 0] == pytest.approx(2.5 * TA)
    mcu.wrjtvl("X", 0.0)
    mcu.jr({"X": 5.0})
    mcu.advance(1500)
    assert np.ptp(mcu.trace.dp[-100:, 0]) == 0.0


@pytest.mark.shows("pcap.wrsdec.default")
def test_js_brakes_with_the_sdec_of_the_machine_until_another_is_written(mcu: Mcu) -> None:
    def braking() -> float:
        mcu.wrjvl("X", 20.0)
        mcu.jr({"X": 200.0})
        mcu.advance(200)
        mcu.js("X")
        mcu.advance(300)
        v = np.diff(mcu.trace.dp[:, 0]) / TA
        return float(-np.median(np.diff(v)[np.diff(v) < -1e-6]) / TA)

    assert braking() == pytest.approx(axis_of_machine("stop_deceleration"), rel=1e-6)
    mcu.wrsdec("X", 250.0)
    assert braking() == pytest.approx(250.0, rel=1e-6)


@pytest.mark.shows(
    "pcap.rdtrac", "pcap.rdtrac.ret-0", "pcap.rdtrvl", "pcap.rdtrvl.ret-0", "pcap.rdtrtvl", "pcap.rdtrtvl.ret-0",
    "pcap.wrtrac", "pcap.wrtrac.ret-0", "pcap.wrtrvl", "pcap.wrtrvl.ret-0", "pcap.wrtrtvl", "pcap.wrtrtvl.ret-0",
    "pcap.rdtrovrst.ret-0", "pcap.wrtrovrst.ret-0", "pcap.wrtrovrst",
)  # fmt: skip
@pytest.mark.parametrize("name", ["trac", "trvl", "trtvl", "trovrst"])
def test_path_values_return_0_or_an_error(mcu: Mcu, name: str) -> None:
    read, write = getattr(mcu, f"rd{name}"), getattr(mcu, f"wr{name}")
    assert write(1.5) == 0
    assert read() == 1.5
    for bad in (math.nan, math.inf):
        assert write(bad) != 0
        assert read() == 1.5
    stopped = stop(mcu)
    assert write(2.0) == -4
    with pytest.raises(stopped) as error:
        read()
    assert error.value.status == -4


@pytest.mark.shows("pcap.wrtrac.not-pcap", "pcap.wrtrvl.not-pcap", "pcap.wrtrtvl.not-pcap")
def test_pcap_moves_take_their_own_path_values(mcu: Mcu) -> None:
    mcu.wrtrac(1.0)
    mcu.wrtrvl(1.0)
    mcu.wrtrtvl(1.0)
    mcu.mla({"X": 20.0}, ac=500.0, vl=25.0)
    mcu.advance(1200)
    v = np.diff(mcu.trace.dp[:, 0]) / TA
    assert v.max() == pytest.approx(25.0, rel=1e-9)
    assert np.diff(v).max() / TA == pytest.approx(500.0, rel=1e-6)
    assert mcu.rddp("X") == 20.0 and v[-1] == 0.0, "it stops: no target velocity"


@pytest.mark.shows("pcap.rdnfrax", "pcap.wrnfrax")
def test_nfrax_takes_axes_out_of_the_path_velocity(mcu: Mcu) -> None:
    assert mcu.rdnfrax() == []
    mcu.wrnfrax(["Z"])
    assert mcu.rdnfrax() == ["Z"]
    mcu.mla({"X": 30.0, "Z": 40.0}, ac=5000.0, vl=30.0)
    mcu.advance(1000)
    speed = np.diff(mcu.trace.dp, axis=0).max(axis=0) / TA
    assert speed[0] == pytest.approx(30.0, rel=1e-9), "X alone has the path velocity"
    assert speed[2] == pytest.approx(40.0, rel=1e-9)
    mcu.wrnfrax([])
    assert mcu.rdnfrax() == []


@pytest.mark.shows("pcap.rdjovr", "pcap.wrjovr", "struct.tsrp.jovr", "pcap.wrjovr.reset")
def test_jog_override(mcu: Mcu) -> None:
    assert mcu.rdjovr("X") == 1.0
    for reset in (lambda: mcu.ra("X"), mcu.rs):
        mcu.wrjovr("X", 0.5)
        assert (mcu.rdjovr("X"), mcu.rdap("X").jovr, mcu.rdjovr("Y")) == (0.5, 0.5, 1.0)
        reset()
        assert mcu.rdjovr("X") == 1.0
    for bad in (0.0, -1.0, math.nan):
        with pytest.raises(ValueError, match="above 0"):
            mcu.wrjovr("X", bad)


@pytest.mark.shows("pcap.ra.override", "pcap.ra")
def test_ra_resets_the_effective_override_and_not_the_buffered_one(mcu: Mcu) -> None:
    mcu.wrtrovr(0.5)
    mcu.utrovr(["X", "Y"])
    mcu.advance(2)
    mcu.ra("X")
    assert mcu.rdtrovr() == 0.5
    mcu.cl(["X", "Y"])
    mcu.mla({"X": 50.0}, ac=5000.0, vl=20.0)
    mcu.mla({"Y": 50.0}, ac=5000.0, vl=20.0)
    mcu.advance(300)
    speed = np.diff(mcu.trace.dp, axis=0).max(axis=0) / TA
    assert speed[:2] == pytest.approx([20.0, 10.0], rel=1e-9)


@pytest.mark.shows(
    "pcap.wrtrovrst.trovr-read",
    "pcap.wrtrovrst.actual-by-jovr",
    "pcap.wrtrovrst.bit25",
    "pcap.rdtrovr",
    "pcap.wrtrovr",
    "pcap.utrovr",
)
@pytest.mark.parametrize("ovrmode", [False, True])
def test_the_override_in_its_ramp(mcu: Mcu, ovrmode: bool) -> None:
    mcu.wrmodereg(ModeReg.of("OvrMode") if ovrmode else 0)
    mcu.wrtrovrst(1.0)
    mcu.wrtrovr(0.5)
    mcu.utrovr("X")
    mcu.advance(200)
    assert mcu.rdtrovr() == 0.5
    effective = 1.0 - 200 * TA
    assert mcu.trace.factor[-1] == pytest.approx(effective)
    assert mcu.rdjovr("X") == (1.0 if ovrmode else pytest.approx(effective))
    mcu.advance(1000)
    assert mcu.rdjovr("X") == (1.0 if ovrmode else 0.5)


@pytest.mark.shows(
    "pcap.rdtp", "pcap.wrtp", "pcap.rdrp", "pcap.rddp", "pcap.rddv", "pcap.rdposerr",
    "struct.tsrp.tp", "struct.tsrp.rp", "struct.tsrp.dp", "pcap.rddv.read-only",
    "pcap.rdrv.read-only", "pcap.rdposerr.read-only",
)  # fmt: skip
def test_positions_and_targets(mcu: Mcu) -> None:
    mcu.ja({"X": 30.0})
    mcu.advance(60)
    tsrp = mcu.rdap("X")
    assert (mcu.rdtp("X"), tsrp.tp) == (30.0, 30.0)
    assert (tsrp.rp, tsrp.dp, tsrp.dv) == (mcu.rdrp("X"), mcu.rddp("X"), mcu.rddv("X"))
    assert 0.0 < tsrp.rp < 30.0 and tsrp.dv == axis_of_machine("jog_velocity")
    assert mcu.rdposerr("X") == tsrp.dp - tsrp.rp
    with pytest.raises(CommandRefused):
        mcu.wrtp("X", 5.0)
    mcu.advance(4000)
    assert mcu.rdtp("X") == 30.0
    mcu.wrtp("X", 5.0)
    assert (mcu.rdtp("X"), mcu.rddp("X")) == (5.0, 30.0), "nothing moves"
    for name in ("wrdv", "wrrv", "wrposerr"):
        assert not hasattr(mcu, name)


@pytest.mark.shows(
    "pcap.rdap", "pcap.rdf", "pcap.uf", "pcap.rdap.same-as-single",
    "struct.tsrp.per-axis", "struct.tsrp.an", "struct.tsrp.not-auto",
    "struct.tsrp.extra-fields", "struct.tsrp.kp", "struct.tsrp.ki", "struct.tsrp.kd", "struct.tsrp.kpl",
    "struct.tsrp.kfca", "struct.tsrp.kfcv", "struct.tsrp.mcp", "struct.tsrp.lsm", "struct.tsrp.axst",
    "struct.tsrp.digi", "struct.tsrp.digo", "struct.tsrp.sll", "struct.tsrp.slr",
)  # fmt: skip
def test_all_values_of_an_axis_at_once(mcu: Mcu) -> None:
    mcu.uf("Y", kp=2.0, ki=0.5, kd=0.01, kpl=0.3, kfca=0.004, kfcv=0.02)
    mcu.wraux("Y", 7.5)
    mcu.ssf("X", 1001, 3)
    mcu.ssms("X")
    mcu.set_inputs(0b101)
    mcu.smla({"X": 5.0, "Y": 2.0}, ac=500.0, vl=20.0)
    mcu.advance(20)
    mcu.ssms(["X", "Y"])
    mcu.advance(25)
    for n, name in enumerate(mcu.machine.axis_names):
        tsrp = mcu.rdap(name)
        assert tsrp.an == n
        assert (tsrp.kp, tsrp.ki, tsrp.kd, tsrp.kpl, tsrp.kfcv, tsrp.kfca) == (
            mcu.rdf(n).kp, mcu.rdf(n).ki, mcu.rdf(n).kd, mcu.rdf(n).kpl, mcu.rdf(n).kfcv, mcu.rdf(n).kfca,
        )  # fmt: skip
        for value in fields(TSRP):
            if value.name != "an" and value.name not in mcu.rdf(n)._fields:
                assert getattr(tsrp, value.name) == getattr(mcu, f"rd{value.name}")(name), value.name
    before = mcu.rdap("Y")
    assert (before.kp, before.kpl, before.kfca, before.aux) == (2.0, 0.3, 0.004, 7.5)
    assert before.dp > 0.0 and before.mcp != 0 and before.digi & 0b101 == 0b101
    dp = before.dp
    mcu.advance(10)
    assert before.dp == dp != mcu.rddp("Y"), "a field changes only by reading"


@pytest.mark.shows("pcap.rdepc", "struct.tsrp.epc")
def test_eeprom_cycles_are_counted(mcu: Mcu) -> None:
    before = mcu.rdepc("X")
    for _ in range(3):
        mcu.program_eeprom()
    mcu.rs()
    assert mcu.rdepc("X") == mcu.rdepc("Z") == mcu.rdap("Y").epc == before + 3


@pytest.mark.shows("pcap.rdaux", "pcap.wraux")
def test_the_auxiliary_register(mcu: Mcu) -> None:
    mcu.wraux("X", -1.25)
    mcu.rs()
    assert (mcu.rdaux("X"), mcu.rdaux("Y")) == (-1.25, 0.0)


@pytest.mark.shows("pcap.wrmodereg")
def test_modereg_controls_options(mcu: Mcu) -> None:
    def end_of_a_fraction_of_a_count() -> float:
        mcu.mla({"X": 1.00003}, ac=500.0, vl=20.0)
        mcu.advance(400)
        return mcu.rddp("X")

    mcu.wrmodereg(ModeReg.of("ExactTargetPos"))
    assert mcu.rdmodereg().names == ("ExactTargetPos",)
    assert end_of_a_fraction_of_a_count() == 1.00003
    mcu.wrmodereg(0)
    mcu.mla({"X": 0.0}, ac=500.0, vl=20.0)
    mcu.advance(400)
    assert end_of_a_fraction_of_a_count() != 1.00003


@pytest.mark.shows(
    "pcap.ctru", "pcap.rdmdvel", "pcap.wrmdvel", "pcap.rdmaxvel", "pcap.wrmaxvel", "pcap.rdmaxacc", "pcap.wrmaxacc"
)
def test_look_ahead_limits_are_in_interpolation_units(mcu: Mcu) -> None:
    mcu.wrmdvel("X", 25.4)
    mcu.wrmaxvel("X", 254.0)
    mcu.wrmaxacc("X", 25.4)
    assert mcu.ctru("inch", "min")
    assert mcu.rdmdvel("X") == pytest.approx(60.0)
    assert mcu.rdmaxvel("X") == pytest.approx(600.0)
    assert mcu.rdmaxacc("X") == pytest.approx(3600.0)
    mcu.wrmaxvel("X", 60.0)
    mcu.wrmdvel("X", 30.0)
    mcu.wrmaxacc("X", 7200.0)
    assert mcu.ctru(0, 0)
    assert mcu.rdmaxvel("X") == pytest.approx(25.4)
    assert mcu.rdmdvel("X") == pytest.approx(12.7)
    assert mcu.rdmaxacc("X") == pytest.approx(50.8)
    mcu.wrmodereg(ModeReg.of("ChkMaxVel"))
    mcu.wrmaxacc("X", 0.0)
    mcu.smla({"X": 50.0}, ac=1e4, vl=100.0)
    mcu.ssms("X")
    mcu.advance(600)
    assert np.diff(mcu.trace.dp[:, 0]).max() / TA == pytest.approx(25.4, rel=1e-9)


@pytest.mark.shows("pcap.rddpd", "pcap.rdrpd", "pcap.rdrpd.any-time", "pcap.rdtpd", "pcap.rdtpd.absolute")
def test_display_units(lathe: Mcu) -> None:
    lathe.ja({"X": 50.8, "C": 720.0})
    values = []
    for _ in range(5):
        lathe.advance(1)
        values.append(lathe.rdrpd("X"))
        assert lathe.rdrpd("X") == pytest.approx(lathe.rdrp("X") / 25.4, rel=1e-12)
    assert values[-1] > values[-2] > 0.0, "also while it moves, a new value each sample"
    assert (lathe.rdtpd("X"), lathe.rdtpd("C")) == pytest.approx((2.0, 2.0))
    lathe.advance(8000)
    assert (lathe.rddpd("X"), lathe.rdrpd("X")) == pytest.approx((2.0, 2.0))
    assert (lathe.rddpd("C"), lathe.rdrpd("C")) == pytest.approx((2.0, 2.0))
    lathe.jr({"X": -25.4})
    lathe.advance(10)
    assert lathe.rdtpd("X") == pytest.approx(1.0)


@pytest.mark.shows("pcap.rdeffradius", "pcap.wreffradius")
def test_the_effective_radius_is_in_pu(lathe: Mcu) -> None:
    lathe.wreffradius("C", 25.4)
    assert lathe.rdeffradius("C") == pytest.approx(25.4)
    lathe.mla({"C": 25.4}, ac=1e4, vl=25.4)  # a circumference of one radius in a second
    lathe.advance(2000)
    assert lathe.rddp("C") == pytest.approx(math.degrees(1.0), abs=1e-3)
    assert np.diff(lathe.trace.dp[:, 1]).max() / TA == pytest.approx(math.degrees(1.0), rel=1e-9)
    lathe.ctru("inch", "sec")
    assert lathe.rdeffradius("C") == pytest.approx(1.0)
    lathe.wreffradius("C", 2.0)
    lathe.ctru("mm", "sec")
    assert lathe.rdeffradius("C") == pytest.approx(50.8)
    for axis, bad in [("C", 0.0), ("C", -1.0), ("X", 1.0)]:
        with pytest.raises(ValueError, match="effradius"):
            lathe.wreffradius(axis, bad)


@pytest.mark.shows("pcap.rdslsp", "pcap.rdslsp.ret-0")
def test_slsp_cannot_be_read_without_a_system(mcu: Mcu) -> None:
    assert mcu.rdslsp("X") == axis_of_machine("slsp")
    with pytest.raises(stop(mcu)):
        mcu.rdslsp("X")


@pytest.mark.shows(
    "appvar.sys", "appvar.sys.pcap-int", "appvar.sys.pcap-dbl", "appvar.axis", "appvar.axis.pcap-int",
    "appvar.axis.pcap-dbl",
)  # fmt: skip
def test_application_variables(mcu: Mcu) -> None:
    mcu.wrsysvarint(1, -7)
    mcu.wrsysvardbl(1, 2.5)
    mcu.wraxvarint("Y", 99, 2**31 - 1)
    mcu.wraxvardbl("Y", 99, -0.125)
    mcu.rs()
    assert (mcu.rdsysvarint(1), mcu.rdsysvardbl(1), mcu.rdsysvarint(2)) == (-7, 2.5, 0)
    assert (mcu.rdaxvarint("Y", 99), mcu.rdaxvardbl("Y", 99)) == (2**31 - 1, -0.125)
    assert (mcu.rdaxvarint("X", 99), mcu.rdaxvardbl("X", 99)) == (0, 0.0)
    for read in (mcu.rdsysvarint, mcu.rdsysvardbl, lambda n: mcu.rdaxvarint("X", n)):
        with pytest.raises(IndexError):
            read(100)


@pytest.mark.shows("pcap.rdgcr", "pcap.wrgcr")
def test_the_gear_configuration_register(mcu: Mcu) -> None:
    mcu.wrgcr("Z", 0x41)
    assert (mcu.rdgcr("Z"), mcu.rdgcr("X")) == (0x41, 0)


@pytest.mark.shows("pcap.scp", "pcap.scp.application-specific")
def test_controller_parameters_are_stored(mcu: Mcu) -> None:
    field = [[row + column / 100 for column in range(15)] for row in range(15)]
    mcu.scp("X", field)
    assert mcu.controller_parameters("X") == field
    assert mcu.controller_parameters("Y") == [[0.0] * 15] * 15
    for wrong in (field[1:], [*field[1:], [0.0] * 14]):
        with pytest.raises(ValueError, match="15"):
            mcu.scp("X", wrong)


@pytest.mark.shows("pcap.rdledgn", "pcap.rdledrd", "pcap.rdledyl", "pcap.wrledgn", "pcap.wrledrd", "pcap.wrledyl")
@pytest.mark.parametrize("colour", ["gn", "rd", "yl"])
def test_leds(mcu: Mcu, colour: str) -> None:
    state = {c: getattr(mcu, f"rdled{c}") for c in ("gn", "rd", "yl")}
    assert [read() for read in state.values()] == [0, 0, 0]
    getattr(mcu, f"wrled{colour}")(1)
    assert {c: read() for c, read in state.items()} == {c: int(c == colour) for c in state}
    getattr(mcu, f"wrled{colour}")(0)
    assert state[colour]() == 0
