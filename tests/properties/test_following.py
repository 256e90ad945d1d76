"""Gear and flying saw against closed forms, at any speeds of the master (resource interface, chapters 3 and 5)."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motion_kernel import Machine, Mcu

AXIS = '[[axis]]\nname = "{}"\ndrive = "{}"\ncounts_per_unit = 1000\nrapid = 400\nacceleration = 4000\n'
SERVO = "pidf = { kp = 6.0, kfcv = 0.08 }\n"
COUNT = 1e-3
TA = 1.28e-3

speeds = st.lists(st.floats(2.0, 250.0), min_size=1, max_size=4)


def machine(drives: str) -> Mcu:
    """Axes X, Y, Z of these drives, in closed loop."""
    axes = (AXIS.format(n, d) + (SERVO if d == "servo" else "") for n, d in zip("XYZ", drives.split(), strict=True))
    mcu = Mcu(Machine.parse("".join(axes)))
    mcu.cl(["X", "Y", "Z"])
    return mcu


def drive(mcu: Mcu, axis: str, way: float, chain: list[float]) -> int:
    """Spools parts of a way at speeds of their own, and stops between them; samples that they take."""
    samples = 100
    for n, speed in enumerate(chain, 1):
        mcu.smla({axis: way * n / len(chain)}, ac=2000.0, vl=speed)
        samples += math.ceil((abs(way) / len(chain) / speed + speed / 2000.0) / TA)
    mcu.ssms([axis])
    return samples


@settings(max_examples=40, deadline=None)
@given(chain=speeds, sign=st.sampled_from([1.0, -1.0]), source=st.sampled_from([0, 1]), start=st.floats(8.0, 40.0),
       nominal=st.floats(10.0, 120.0), ac=st.floats(400.0, 3000.0))  # fmt: skip
def test_the_saw_meets_the_workpiece_at_any_speed(
    chain: list[float], sign: float, source: int, start: float, nominal: float, ac: float
) -> None:
    """Slower, faster, in between at rest: from the start position on the saw is beside its mark within a count."""
    mcu = machine("servo stepper stepper" if source else "stepper stepper stepper")
    r = mcu.resources
    lead = nominal * nominal / ac / 2
    start += 2 * lead
    r.MASTERAXIS["Z"], r.SYNCSOURCE["Z"], r.MASTERVELOCITY["Z"] = 0, source, sign * nominal
    r.STARTPOSITION["Z"], r.POSITIONOFFSET["Z"] = sign * start, -sign * 2 * lead
    r.SYNCMODE["Z"] = 1
    end = 60.0 + 2 * lead
    mcu.smla({"Z": sign * end}, ac=ac, vl=nominal)
    mcu.ssms(["Z"])
    mcu.advance(drive(mcu, "X", sign * (start + end + 20.0), chain))
    guiding = sign * (mcu.trace.rp if source else mcu.trace.dp)[:, 0]
    guiding = np.maximum.accumulate(guiding)  # an encoder that swings back does not turn the saw back
    slave = sign * mcu.trace.dp[:, 2]
    beside = (guiding >= start) & (slave < end - lead)
    assert beside.sum() > 20 and slave[guiding < start - 2 * lead].max() < 1e-6
    assert np.abs(slave - (guiding - start) - lead)[beside].max() < 1e-6
    steps = sign * mcu.trace.rp[1:, 2]
    assert np.abs(steps - (guiding[:-1] - start) - lead)[beside[:-1]].max() <= COUNT
    assert r.SYNCMODE["Z"] == 0 and abs(slave[-1] - end) <= COUNT / 2, "a stop is at a whole count"


@settings(max_examples=40, deadline=None)
@given(
    chains=st.tuples(speeds, speeds),
    ways=st.tuples(st.floats(-60, 60), st.floats(-60, 60)),
    gcr=st.sampled_from([1, 2]),
    factors=st.tuples(st.floats(-3, 3), st.floats(-3, 3)),
)
def test_a_geared_slave_follows_within_a_sample_and_a_count(
    chains: tuple[list[float], list[float]], ways: tuple[float, float], gcr: int, factors: tuple[float, float]
) -> None:
    mcu = machine("servo servo stepper" if gcr == 2 else "stepper stepper stepper")
    for axis, factor in enumerate(factors):
        mcu.resources.cp["Z", axis, 0] = factor
        mcu.wrgcr(axis, gcr)
    mcu.advance(max(drive(mcu, axis, way, chain) for axis, way, chain in zip("XY", ways, chains, strict=True)))
    masters = (mcu.trace.rp if gcr == 2 else mcu.trace.dp)[:, :2]
    wanted = masters @ np.array(factors)
    assert np.abs(mcu.trace.rp[1:, 2] - wanted[:-1]).max() <= COUNT / 2 + 1e-9 * (1 + np.abs(wanted).max())
    assert not mcu.trace.dp[:, 2].any()
