"""Controllers that the tests of PCAP commands begin with."""

from __future__ import annotations

import tomllib

import pytest

from motion_kernel import Machine, Mcu, PcapError
from tests.app.conftest import ROOT

MILL = ROOT / "examples" / "machines" / "mill3.toml"
TA = 1.28e-3
ROTARY = """
[[axis]]
name = "X"
counts_per_unit = 1000
rapid = 100
acceleration = 1000
display_unit = "inch"
zero_offsets = { set0 = 10.0, set4 = -2.5 }
limits = { left = -200, right = 200, function = "SMA" }
pidf = { kp = 12.0 }
[[axis]]
name = "C"
kind = "rotary"
counts_per_unit = 1000
rapid = 360
acceleration = 3600
display_unit = "rev"
zero_offsets = { set0 = 90.0 }
pidf = { kp = 12.0 }
"""


@pytest.fixture
def mcu() -> Mcu:
    """mill3 in closed loop."""
    mcu = Mcu(Machine.load(MILL))
    mcu.cl(mcu.machine.axis_names)
    return mcu


@pytest.fixture
def lathe() -> Mcu:
    """A linear and a rotary axis in closed loop, following exactly (steppers)."""
    mcu = Mcu(Machine.parse(ROTARY.replace("[[axis]]", '[[axis]]\ndrive = "stepper"')))
    mcu.cl(["X", "C"])
    return mcu


def stop(mcu: Mcu) -> type[PcapError]:
    """Stops the operating system of the card; returns what commands raise from then on."""
    assert mcu.bootfile("no such file") == 11
    return PcapError


def axis_of_machine(key: str) -> float:
    """A value of axis X of mill3, from the resolved machine file."""
    return float(tomllib.loads(Machine.load(MILL).show())["axis"][0][key])
