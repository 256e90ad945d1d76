"""Coordinates of an axis: zero points, offsets of the set point, gear factor (4.4.3, 4.4.57, 4.4.66, 4.4.127)."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from motion_kernel import Machine, Mcu, ModeReg
from tests.conformance.conftest import MILL, TA, axis_of_machine, stop


@pytest.mark.shows(
    "pcap.szpa", "pcap.szpa.open-and-closed", "pcap.szpa.clear", "pcap.szpa.readback", "pcap.szpr",
    "pcap.szpr.open-and-closed", "pcap.szpr.clear", "pcap.szpr.readback", "pcap.rdzerooffset",
    "pcap.rdzerooffset.after-szp",
)  # fmt: skip
@pytest.mark.parametrize("closed", [True, False])
def test_a_virtual_zero_point_moves_coordinates_and_no_axis(mcu: Mcu, closed: bool) -> None:
    mcu.ja({"X": 20.0})
    mcu.advance(4000)
    if not closed:
        mcu.ol("X")
    load = mcu.trace.load[-1, 0]
    for call, offset in [
        (lambda: mcu.szpa("X", 5.0), 5.0),
        (lambda: mcu.szpr("X", -7.5), -2.5),
        (lambda: mcu.szpr("X", 0.00003), -2.49997),
        (lambda: mcu.szpa("X", 0.0), 0.0),
    ]:
        before = mcu.rdrp("X") + mcu.rdzerooffset("X")
        call()
        assert mcu.rdzerooffset("X") == pytest.approx(offset, abs=1e-12)
        assert mcu.rdrp("X") + offset == pytest.approx(before, abs=2e-4), "to a count"
        mcu.advance(200)
        assert np.ptp(mcu.trace.load[:, 0]) < 1e-3, "no axis moves"
        if closed:
            assert abs(mcu.rdposerr("X")) < 1e-3
    assert mcu.trace.load[-1, 0] == pytest.approx(load, abs=1e-3)
    assert mcu.rdzerooffset("Y") == 0.0


def test_targets_are_in_the_coordinates_of_the_zero_point(mcu: Mcu) -> None:
    mcu.szpa("X", 5.0)
    mcu.smla({"X": 10.0}, ac=500.0, vl=50.0)
    mcu.smla({"X": 20.0}, ac=500.0, vl=50.0)
    mcu.szpr("X", 1.0)  # what is spooled stays where it is in the machine
    mcu.ssms("X")
    mcu.advance(2000)
    assert mcu.rddp("X") == pytest.approx(19.0)
    assert mcu.rdtp("X") == pytest.approx(19.0)
    mcu.szpa("X", 0.0)
    assert mcu.rddp("X") == pytest.approx(25.0)


@pytest.mark.shows("pcap.rdsll", "pcap.rdslr", "pcap.wrsll", "pcap.wrslr")
def test_software_limits_stay_at_the_machine(lathe: Mcu) -> None:
    lathe.prepare_gcode()
    lathe.szpa("X", 150.0)
    assert (lathe.rdsll("X"), lathe.rdslr("X")) == (-200.0, 200.0)
    lathe.ja({"X": 100.0})
    lathe.advance(8000)
    assert lathe.rdaxst("X").lsrs
    assert lathe.rddp("X") == pytest.approx(50.0, abs=1e-2)
    lathe.wrsll("X", -190.0)
    lathe.wrslr("X", 210.0)
    assert (lathe.rdsll("X"), lathe.rdslr("X")) == (-190.0, 210.0)


@pytest.mark.shows(
    "pcap.azo", "pcap.azo.five-sets", "pcap.azo.off", "pcap.azo.machine-zero-kept", "pcap.azo.readback",
)  # fmt: skip
def test_sets_of_zero_offsets(lathe: Mcu) -> None:
    lathe.ja({"X": 50.0, "C": 45.0})
    lathe.advance(4000)
    for number, offsets in enumerate([(10.0, 90.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (-2.5, 0.0)]):
        lathe.azo(number)
        assert (lathe.rdzerooffset("X"), lathe.rdzerooffset("C")) == offsets
        assert (lathe.rdrp("X"), lathe.rdrp("C")) == pytest.approx((50.0 - offsets[0], 45.0 - offsets[1]))
    lathe.azo(5)
    assert (lathe.rdzerooffset("X"), lathe.rdrp("X"), lathe.rdrp("C")) == pytest.approx((0.0, 50.0, 45.0))


@pytest.mark.shows("pcap.szpa.clearzeroposition")
def test_clearzeroposition_makes_the_virtual_zero_that_of_the_machine(mcu: Mcu) -> None:
    mcu.ja({"X": 20.0})
    mcu.advance(4000)
    mcu.szpa("X", 5.0)
    mcu.wrmodereg(ModeReg.of("ClearZeroPosition"))
    assert (mcu.rdzerooffset("X"), mcu.rddp("X")) == (0.0, 15.0)
    mcu.szpr("X", 1.0)
    assert (mcu.rdzerooffset("X"), mcu.rddp("X")) == (0.0, 14.0)


@pytest.mark.shows("pcap.rdzerooffset.ret-0")
def test_the_zero_offset_cannot_be_read_without_a_system(mcu: Mcu) -> None:
    assert mcu.rdzerooffset("X") == 0.0
    with pytest.raises(stop(mcu)) as error:
        mcu.rdzerooffset("X")
    assert error.value.status != 0


@pytest.mark.shows(
    "pcap.rddpoffset", "pcap.rddpoffset.ret-0", "pcap.rddvoffset", "pcap.rddvoffset.ret-0", "pcap.wrdpoffset",
    "pcap.wrdpoffset.ret-0", "pcap.wrdvoffset", "pcap.wrdvoffset.ret-0", "pcap.wrdvoffset.default",
)  # fmt: skip
def test_offsets_are_read_as_written(mcu: Mcu) -> None:
    assert (mcu.rddpoffset("X"), mcu.rddvoffset("X")) == (0.0, 0.0)
    assert mcu.wrdvoffset("X", 2.5) == mcu.wrdpoffset("X", 0.5) == 0
    assert (mcu.rddpoffset("X"), mcu.rddvoffset("X"), mcu.rddpoffset("Y")) == (0.5, 2.5, 0.0)
    assert mcu.wrdpoffset("X", float("nan")) != 0 != mcu.wrdvoffset("X", -1.0)
    assert (mcu.rddpoffset("X"), mcu.rddvoffset("X")) == (0.5, 2.5)
    error = stop(mcu)
    for read in (mcu.rddpoffset, mcu.rddvoffset):
        with pytest.raises(error):
            read("X")
    assert mcu.wrdpoffset("X", 0.0) != 0 != mcu.wrdvoffset("X", 0.0)


@pytest.mark.shows("pcap.wrdpoffset.step", "pcap.wrdpoffset.rate", "pcap.wrdvoffset.zero")
def test_an_offset_steps_or_ramps(lathe: Mcu) -> None:
    lathe.wrdpoffset("X", 0.5)
    lathe.advance(3)
    assert lathe.rdrp("X") == 0.5, "a step"
    assert lathe.rddp("X") == 0.0, "beside the profile generator"
    lathe.wrdvoffset("X", 2.0)
    lathe.wrdpoffset("X", -0.5)
    lathe.advance(1000)
    way = lathe.trace.rp[:, 0]
    assert np.abs(np.diff(way)).max() == pytest.approx(2.0 * TA, abs=1.1e-3), "with that rate, to a count"
    assert int((np.diff(way) != 0).sum()) == pytest.approx(1.0 / (2.0 * TA), abs=2)
    assert way[-1] == -0.5


@pytest.mark.shows(
    "pcap.rdgf", "pcap.rdgf.default", "pcap.wrgf", "pcap.wrgf.readback", "pcap.wrgf.params-not-adapted",
    "struct.tsrp.gf", "pcap.wrslsp", "pcap.wrslsp.positive",
)  # fmt: skip
def test_gear_factor_and_resolution(lathe: Mcu) -> None:
    gf, slsp = lathe.rdgf("X"), lathe.rdslsp("X")
    assert gf == lathe.rdap("X").gf == pytest.approx(slsp / 1000), "counts_per_unit of the machine file is 1000"
    lathe.ja({"X": 10.0})
    lathe.advance(2000)
    parameters = [lathe.rdjvl("X"), lathe.rdjac("X"), lathe.rdsdec("X"), lathe.rdmpe("X")]
    load = lathe.trace.load[-1, 0]
    lathe.wrgf("X", 2 * gf)
    assert lathe.rdgf("X") == lathe.rdap("X").gf == pytest.approx(2 * gf)
    assert (lathe.rdrp("X"), lathe.rdslsp("X")) == (20.0, slsp), "the motor has not moved, its way has another number"
    assert [lathe.rdjvl("X"), lathe.rdjac("X"), lathe.rdsdec("X"), lathe.rdmpe("X")] == parameters
    lathe.advance(10)
    assert np.ptp(lathe.trace.rp[:, 0]) == 0.0 and load == 10.0
    lathe.wrslsp("X", slsp / 4)
    assert (lathe.rdslsp("X"), lathe.rdgf("X")) == (slsp / 4, pytest.approx(2 * gf))
    assert lathe.rdrp("X") == pytest.approx(80.0)
    for bad in (0.0, -1.0, float("inf")):
        with pytest.raises(ValueError, match="above 0"):
            lathe.wrgf("X", bad)
        with pytest.raises(ValueError, match="above 0"):
            lathe.wrslsp("X", bad)


@pytest.mark.shows(
    "pcap.rdgfaux", "pcap.rdgfaux.default", "pcap.rdgfaux.ret-0", "pcap.wrgfaux", "pcap.wrgfaux.default",
    "pcap.wrgfaux.ret-0",
)  # fmt: skip
def test_gfaux_and_the_encoder_of_a_stepper_axis() -> None:
    text = '[[axis]]\nname = "X"\ndrive = "stepper"\ncounts_per_unit = 1000\nrapid = 100\nacceleration = 1000\n'
    mcu = Mcu(Machine.parse(f"{text}encoder = {{ counts_per_unit = 500, feedback = true }}\n"))
    assert mcu.rdgfaux("X") == 1.0
    assert mcu.wrgfaux("X", 2.0) == 0
    assert mcu.wrgfaux("X", 0.0) != 0
    assert mcu.rdgfaux("X") == 2.0
    mcu.cl("X")
    mcu.ja({"X": 10.0})
    mcu.advance(3000)
    assert mcu.rdaux("X") == 5000.0, "counts of the encoder"
    assert mcu.rdrp("X") == pytest.approx(10.0, abs=2e-3), "the position from them, times gfaux"
    error = stop(mcu)
    assert mcu.wrgfaux("X", 1.0) != 0
    with pytest.raises(error):
        mcu.rdgfaux("X")


@pytest.mark.shows("pcap.rdcontrollerflags", "pcap.rdcontrollerflags.roundtrip", "pcap.wrcontrollerflags")
def test_controller_flags(mcu: Mcu) -> None:
    assert mcu.rdcontrollerflags("X") == 0
    mcu.wrcontrollerflags("X", 0x0901)
    assert mcu.rdcontrollerflags("X") == 0x0901
    assert mcu.rdcontrollerflags("X").names == ("MoveControl", "StopControl", "StopFix")
    assert mcu.rdcontrollerflags("Y") == 0


@pytest.mark.shows("pcap.wrcontrollerflags.effect")
def test_a_flag_holds_the_integral_part() -> None:
    def command_of_a_blocked_axis(flags: int) -> float:
        mcu = Mcu(Machine.load(MILL))
        mcu.uf("X", kp=1.0, ki=2.0, kd=0.0)
        mcu.wrcontrollerflags("X", flags)
        mcu.cl("X")
        mcu.play("block", "X")
        mcu.wrdpoffset("X", 0.05)
        mcu.advance(500)
        return mcu.rdmcp("X") / (0.05 * axis_of_machine("counts_per_unit"))

    assert command_of_a_blocked_axis(0) == pytest.approx(1.0 + 2.0 * 500 * TA, rel=0.01), "the integral part grows"
    assert command_of_a_blocked_axis(1 << 8 | 1 << 9) == pytest.approx(1.0, abs=0.01), "StopControl, StopZero: empty"


@pytest.mark.shows(
    "pcap.rdpcapindex", "pcap.rdpcapindex.ret-0", "pcap.smlai", "pcap.smlri", "pcap.ssfi", "pcap.ssfni",
    "pcap.spda.index-resource",
)  # fmt: skip
def test_pcap_index(mcu: Mcu) -> None:
    mcu.smlai({"X": 5.0}, 41, ac=500.0, vl=20.0)
    mcu.smlri({"X": 5.0}, 42, ac=500.0, vl=20.0)
    mcu.ssfi("X", 7, 1.0, 43)
    mcu.ssfni("X", 8, 1.0, 44)
    mcu.spda("X", [10.0, 10.0, 10.0], 50)
    mcu.ssms("X")
    seen = [mcu.rdpcapindex("X")]
    for _ in range(600):
        mcu.advance(1)
        seen.append(mcu.rdpcapindex("X"))
        assert mcu.resources.PcapIndex["X"] == seen[-1]
    order = [now for before, now in itertools.pairwise(seen) if now != before]
    assert order[:2] == [41, 42] and order[-1] == 52
    assert (mcu.rddp("X"), mcu.rdci(7), mcu.rdci(8)) == (10.0, 1, 1)
    with pytest.raises(stop(mcu)) as error:
        mcu.rdpcapindex("X")
    assert error.value.status != 0


@pytest.mark.shows("pcap.lpr", "pcap.lprs", "pcap.lprs.san-ignored")
def test_recordings_of_the_system_analysis(mcu: Mcu) -> None:
    mcu.lprs(["X", "Z"], let=1000 * TA, lst=0.1)
    mcu.ja({"X": 30.0})
    mcu.advance(1200)
    x, z = mcu.analysis("X"), mcu.analysis("Z")
    assert mcu.analysis("Y")["dp"] == []
    first, last = x["t_s"][0], x["t_s"][-1]
    assert (first, last) == (pytest.approx(0.1, abs=2 * TA), pytest.approx(0.1 + 1000 * TA, abs=2 * TA))
    assert len(x["t_s"]) == 1000
    samples = np.rint(np.array(x["t_s"]) / TA).astype(int) - 1
    assert x["dp"] == mcu.trace.dp[samples, 0].tolist() and x["rp"] == mcu.trace.rp[samples, 0].tolist()
    assert max(x["dv"]) == mcu.rdjvl("X") and max(x["mcp"]) > 0.0
    assert x["t_s"] == z["t_s"] and set(z["dp"]) == {0.0}
    mcu.lpr("Y", let=2000 * TA)
    mcu.advance(2000)
    y = mcu.analysis("Y")["t_s"]
    assert (len(y), y[-1] - y[0]) == (1000, pytest.approx(2000 * TA, abs=3 * TA)), "every second sample"
    for lst, let in [(-1.0, 1.0), (0.0, -1.0), (0.0, float("nan"))]:
        with pytest.raises(ValueError, match="must be times"):
            mcu.lpr("X", let, lst)
