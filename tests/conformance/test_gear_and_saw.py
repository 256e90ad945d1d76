"""Electronic gear and flying saw (resource interface, chapters 3 and 5) against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from motion_kernel import CommandRefused, Machine, Mcu
from motion_kernel.resources import Code, DataType, ObjectDescriptor, ResourceError
from tests.conformance.conftest import TA

AXIS = '[[axis]]\nname = "{}"\ndrive = "{}"\ncounts_per_unit = 1000\nrapid = 400\nacceleration = 4000\n'
COUNT = 1e-3
ENCODER = "encoder = { counts_per_unit = 500, feedback = true }\n"


def machine(drive: str = "stepper", more: str = "") -> Mcu:
    """Axes X, Y, Z, in closed loop."""
    mcu = Mcu(Machine.parse("".join(AXIS.format(name, drive) + more for name in "XYZ")))
    mcu.cl(["X", "Y", "Z"])
    return mcu


def travel(mcu: Mcu, axis: str, target: float, v: float = 50.0) -> None:
    mcu.smla({axis: target}, ac=1000.0, vl=v)
    mcu.ssms([axis])


# ---- gear


@pytest.mark.shows(
    "res.gear.factor-location", "res.gear.several-masters", "res.gear.activate-on-master", "res.gear.gcr-1",
    "res.gear.follows", "res.gear.gcr-0", "res.gear.dp-rp-difference", "res.gear.slave-loop-closed",
)  # fmt: skip
def test_a_slave_follows_the_sum_of_its_masters() -> None:
    mcu = machine()
    mcu.resources.cp["Z", 0, 0], mcu.resources.cp["Z", 1, 0] = 0.5, -2.0
    travel(mcu, "X", 1.0)
    mcu.advance(500)
    assert mcu.rdrp("Z") == 0.0, "no gcr, no following"
    mcu.wrgcr("X", 1)
    mcu.wrgcr("Y", 1)
    travel(mcu, "X", 21.0)
    travel(mcu, "Y", -5.0, v=20.0)
    mcu.advance(1500)
    dp, rp = mcu.trace.dp, mcu.trace.rp
    wanted = 0.5 * (dp[:, 0] - 1.0) - 2.0 * dp[:, 1]
    assert np.abs(rp[1:, 2] - wanted[:-1]).max() <= COUNT, "within one sample and one count"
    assert wanted[-1] == 20.0 == mcu.rdrp("Z") and mcu.rddp("Z") == 0.0
    mcu.wrgcr("X", 0)
    travel(mcu, "X", 0.0)
    mcu.advance(1500)
    assert mcu.rdrp("Z") == 20.0 and mcu.rddp("X") == 0.0
    mcu.ja({"Z": 3.0})
    mcu.advance(1500)
    assert (mcu.rddp("Z"), mcu.rdrp("Z")) == (3.0, 23.0), "profiles of the slave come on top"


@pytest.mark.shows("res.gear.gcr-2")
@pytest.mark.parametrize(("gcr", "way"), [(1, 20.0), (2, 0.0)])
def test_a_blocked_master(gcr: int, way: float) -> None:
    mcu = machine(more=ENCODER)
    mcu.wrgfaux("X", 2.0)
    mcu.wrgfaux("Z", 2.0)
    mcu.resources.cp["Z", 0, 0] = 1.0
    mcu.wrgcr("X", gcr)
    mcu.add_stimulus("when X > -1: X blocked\n")
    mcu.advance(2)
    travel(mcu, "X", 20.0)
    mcu.advance(1500)
    assert mcu.rdrp("Z") == way and mcu.rdrp("X") == 0.0


@pytest.mark.shows("res.gear.gcr-2")
def test_actual_positions_are_followed_within_a_sample() -> None:
    mcu = machine("servo", "pidf = { kp = 12.0 }\n")
    mcu.resources.cp["Z", 0, 0] = 1.0
    mcu.wrgcr("X", 2)
    travel(mcu, "X", 20.0)
    mcu.advance(1500)
    lag = mcu.trace.dp[:, 0] - mcu.trace.rp[:, 0]
    assert mcu.rdrp("Z") == pytest.approx(mcu.rdrp("X"), abs=3 * COUNT) and lag.max() > 10 * COUNT


@pytest.mark.shows("res.gear.poserr-excludes-offset")
def test_following_is_no_following_error() -> None:
    mcu = machine("servo", "mpe = 1.0\npidf = { kp = 12.0, kfcv = 0.003 }\n")
    mcu.resources.cp["Z", 0, 0] = 1.0
    mcu.wrgcr("X", 1)
    travel(mcu, "X", 50.0)
    mcu.advance(1500)
    assert mcu.rdrp("Z") == pytest.approx(50.0, abs=0.01) and abs(mcu.rdposerr("Z")) < 0.01
    assert not mcu.rdaxst("Z").mpe


@pytest.mark.shows("res.gear.gcr-minus-1", "res.gear.gcr-minus-1.closed-loop")
def test_clearing() -> None:
    mcu = machine()
    mcu.resources.cp["Z", 0, 0] = 1.0
    mcu.wrgcr("X", 1)
    travel(mcu, "X", 5.0)
    mcu.advance(1000)
    with pytest.raises(CommandRefused, match="gcr 0"):
        mcu.wrgcr("X", -1)
    mcu.wrgcr("X", 0)
    mcu.ol(["Z"])
    mcu.wrgcr("X", -1)
    assert mcu.rdgcr("X") == 0
    mcu.cl(["Z"])
    mcu.advance(10)
    assert (mcu.rddp("Z"), mcu.rdrp("Z")) == (5.0, 5.0)
    mcu.wrgcr("X", 1)
    travel(mcu, "X", 7.0)
    mcu.advance(1000)
    assert mcu.rdrp("Z") == 7.0
    mcu.wrgcr("X", 0)
    mcu.wrgcr("X", -1)
    mcu.advance(1000)
    assert mcu.rdrp("Z") == 5.0, "in closed loop the slave jumps"


@pytest.mark.shows("res.gear.open-loop-clears-gcr", "res.gear.master-loop-closed")
def test_loops_of_masters() -> None:
    mcu = machine()
    mcu.wrgcr("X", 1)
    mcu.wrgcr("Y", 2)
    mcu.ol(["X", "Y"])
    assert (mcu.rdgcr("X"), mcu.rdgcr("Y")) == (0, 2)
    with pytest.raises(CommandRefused, match="closed loop"):
        mcu.wrgcr("X", 1)
    assert mcu.rdgcr("X") == 0


@pytest.mark.shows("res.gear.option")
def test_without_the_option_nothing_follows() -> None:
    mcu = machine()
    mcu.resources.fit("RESOURCE")
    mcu.resources.cp["Z", 0, 0] = 1.0
    mcu.wrgcr("X", 1)
    travel(mcu, "X", 5.0)
    mcu.advance(1000)
    assert mcu.rdrp("Z") == 0.0 and mcu.rdgcr("X") == 1


def test_other_coordinates_and_offsets_move_no_slave() -> None:
    mcu = machine()
    mcu.resources.cp["Z", 0, 0] = 1.0
    mcu.wrgcr("X", 1)
    mcu.advance(5)
    mcu.shp("X", 100.0)
    mcu.szpa("X", 30.0)
    mcu.advance(5)
    assert mcu.rdrp("Z") == 0.0
    travel(mcu, "X", mcu.rddp("X") + 4.0)
    mcu.wrdpoffset("Z", 1.0)
    mcu.advance(1000)
    assert mcu.rdrp("Z") == 5.0
    mcu.wrdpoffset("Z", 0.0)
    mcu.advance(10)
    assert mcu.rdrp("Z") == 4.0
    mcu.wrgf("Z", 2 * mcu.rdgf("Z"))
    assert mcu.rdposerr("Z") == pytest.approx(0.0, abs=COUNT)


# ---- flying saw


def saw(mcu: Mcu, velocity: float, start: float, offset: float = 0.0, source: int = 0) -> None:
    r = mcu.resources
    r.MASTERAXIS["Z"], r.SYNCSOURCE["Z"] = 0, source
    r.STARTPOSITION["Z"], r.POSITIONOFFSET["Z"], r.MASTERVELOCITY["Z"] = start, offset, velocity
    r.SYNCMODE["Z"] = 1


@pytest.mark.shows(
    "res.dev-7000.SyncMode", "res.sync.descriptor", "res.sync.parameters-on-slave", "res.sync.index-1.syncmode",
    "res.sync.index-2.master-axis", "res.sync.index-3.sync-source", "res.sync.index-4.start-position",
    "res.sync.index-5.position-offset", "res.sync.index-6.master-velocity", "res.sync.index-7.gear-factor",
    "res.sync.index-8.aux-factor", "res.sync.option",
)  # fmt: skip
def test_sync_registers() -> None:
    mcu = machine()
    names = ["MASTERAXIS", "STARTPOSITION", "POSITIONOFFSET", "MASTERVELOCITY", "GEARFACTOR", "AUXFACTOR"]
    for value, (index, name) in enumerate(zip((2, 4, 5, 6, 7, 8), names, strict=True)):
        resource = getattr(mcu.resources, name)
        assert resource["Z"] == (1.0 if name in {"GEARFACTOR", "AUXFACTOR"} else 0.0)
        written = value % 2 if index == 2 else value + 0.5
        resource["Z"] = written
        kind = DataType.INTEGER if index == 2 else DataType.DOUBLE
        d = ObjectDescriptor(7000, index, 2, kind)
        read = mcu.resources.rdoptionint if index == 2 else mcu.resources.rdoptiondbl
        assert read(d) == (Code.OK, written)
        assert index == 2 or resource["Y"] != written
    for function in (0, 9):
        assert mcu.resources.rdoptionint(ObjectDescriptor(7000, function, 2))[0] == Code.UNKNOWN
    assert mcu.resources.rdoptionint(ObjectDescriptor(7000, 3, 2))[0] == Code.UNKNOWN, "SYNC SOURCE is write-only"
    assert mcu.resources.rdoptionint(ObjectDescriptor(7000, 1, 3))[0] == Code.STATE_ERR
    assert mcu.resources.SYNCMODE["Z"] == 0
    mcu.resources.fit("PCI")
    assert mcu.resources.rdoptionint(ObjectDescriptor(7000, 1, 2))[0] == Code.UNKNOWN


@pytest.mark.shows("res.sync.loop-closed-first", "res.sync.arm", "res.sync.abort-by-0")
def test_arming_and_early_end() -> None:
    mcu = machine()
    mcu.ol(["Z"])
    with pytest.raises(ResourceError, match="80 hex"):
        saw(mcu, 50.0, 10.0)
    mcu.cl(["Z"])
    saw(mcu, 50.0, 10.0)
    assert mcu.resources.SYNCMODE["Z"] == 1
    mcu.ja({"Z": 5.0})
    mcu.advance(500)
    assert mcu.rddp("Z") == pytest.approx(0.0, abs=1e-9), "armed: waits for the master"
    mcu.resources.SYNCMODE["Z"] = 0
    mcu.advance(1000)
    assert mcu.resources.SYNCMODE["Z"] == 0 and mcu.rddp("Z") == 5.0


@pytest.mark.shows(
    "res.sync.starts-at-trigger", "res.sync.follows-master-progress", "res.sync.nominal-speed", "res.sync.equal-speed",
    "res.sync.lead-distance", "res.sync.negative-direction", "res.sync.jog-or-spooled", "res.sync.ends-automatically",
    "res.sync.master-index-lower", "res.sync.more-commands",
)  # fmt: skip
@pytest.mark.parametrize("speed", [60.0, 30.0, 7.0, 101.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_saw_meets_the_workpiece(speed: float, sign: float) -> None:
    """Slave: 60 mm/s with 600 mm/s², so 0.1 s and 3 mm to full speed; the master's lead at 60 mm/s is 6 mm."""
    mcu = machine()
    nominal, ac, start = 60.0, 600.0, 20.0
    saw(mcu, sign * nominal, sign * start, -sign * nominal * nominal / ac)
    mcu.smla({"Z": sign * 40.0}, ac=ac, vl=nominal)
    mcu.smla({"Z": sign * 50.0}, ac=ac, vl=nominal)
    mcu.ssms(["Z"])
    travel(mcu, "X", sign * 120.0, v=speed)
    mcu.advance(round(45.0 / speed / TA))
    more = mcu.resources.SYNCMODE["Z"] == 1 and mcu.smla({"Z": sign * 55.0}, ac=ac, vl=nominal)
    assert more
    first = mcu.trace.dp.copy()
    mcu.advance(round(85.0 / speed / TA) + 500)
    dp = sign * np.vstack([first, mcu.trace.dp])
    master, slave = dp[:, 0], dp[:, 2]
    clock = np.maximum(master - (start - 6.0), 0.0) / nominal  # closed form: the profile at way / nominal velocity
    ramp = clock < 0.1
    cruise = (clock >= 0.1) & (slave < 36.9)
    assert np.abs(slave - 0.5 * ac * clock**2)[ramp].max() < 1e-6
    assert np.abs(slave - (master - (start - 3.0)))[cruise].max() < 1e-6, "synchronous from the start position on"
    assert cruise.sum() > 100 and slave[-1] == pytest.approx(55.0)
    assert mcu.resources.SYNCMODE["Z"] == 0
    mcu.ja({"Z": 0.0})
    mcu.advance(3000)
    assert mcu.rddp("Z") == 0.0, "moves as any axis again"


@pytest.mark.shows("res.sync.stops-with-master")
@pytest.mark.parametrize(("source", "goes_on"), [(0, True), (1, False), (2, False)])
def test_a_blocked_master_stops_the_saw(source: int, goes_on: bool) -> None:
    mcu = machine(more=ENCODER)
    for axis in ("X", "Z"):
        mcu.wrgfaux(axis, 2.0)
    mcu.add_stimulus("when X > 15: X blocked\n")
    mcu.resources.GEARFACTOR["Z"], mcu.resources.AUXFACTOR["Z"] = 1000.0, 2.0
    saw(mcu, 50.0, 10.0, source=source)
    mcu.wrjvl("Z", 50.0)
    mcu.ja({"Z": 90.0})
    travel(mcu, "X", 100.0, v=50.0)
    mcu.advance(400)
    stopped = mcu.rddp("Z")
    assert mcu.rdrp("X") == pytest.approx(15.0, abs=0.1) and 1.0 < stopped < 20.0, "it has started"
    mcu.advance(300)
    assert (mcu.rddp("Z") > stopped + 5.0) is goes_on
    assert goes_on or mcu.rddp("Z") == pytest.approx(stopped, abs=1e-9)
