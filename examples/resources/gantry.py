"""A gantry by electronic gear: W follows the set points of Z; a fault of either side stops both (chapter 5)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motion_kernel import Machine, Mcu


def gantry() -> Mcu:
    """Both loops closed, then the factor at the slave, then the gear at the master: in this order nothing jumps."""
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    mcu.cl(["Z", "W"])
    mcu.resources.cp["W", "Z", 0] = 1.0  # line = master, column 0
    mcu.wrgcr("Z", 1)
    mcu.resources.scan(["poserr.Z", "poserr.W", "rp.Z", "rp.W"])
    return mcu


def watch(mcu: Mcu, samples: int) -> bool:
    """Lets time pass in steps of ten samples; stops both sides where one is off by more than its limit."""
    for _ in range(0, samples, 10):
        mcu.advance(10)
        if mcu.rdaxst("Z").mpe or mcu.rdaxst("W").mpe:
            mcu.js(["Z"])
            return False
    return True


def main() -> None:
    mcu = gantry()
    mcu.smla({"Z": 100.0}, ac=1000.0, vl=150.0)
    mcu.ssms(["Z"])
    mcu.advance(2000)
    skew = mcu.resources.scanned["rp.Z"] - mcu.resources.scanned["rp.W"]
    print(f"at {mcu.rdrp('Z'):.2f} and {mcu.rdrp('W'):.2f}, askew by {1000 * np.abs(skew).max():.0f} um at most")
    mcu.add_stimulus("when W > 130: W blocked\n")
    mcu.ja({"Z": 200.0})
    if not watch(mcu, 3000):
        mcu.advance(200)
        print(f"W is stuck: both stopped at {mcu.rdrp('Z'):.1f} and {mcu.rdrp('W'):.1f}")


if __name__ == "__main__":
    main()
