"""Teach-in: an axis is led by hand in open loop, lps latches its way, spd drives it again (4.4.27, 4.4.117)."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from motion_kernel import Machine, Mcu

EVERY = 10  # sample intervals between two latched positions


def teach(mcu: Mcu) -> list[float]:
    """Positions of X while someone leads it, every EVERY samples."""
    mcu.ol("X")
    mcu.wrdigo("X", 0b11)  # the amplifiers stay enabled
    mcu.lps("X", EVERY)
    taught = []
    for push in [800, 2000, 3200, 2000, -1000, -2500, -800, 0]:  # motor commands stand for the hand
        mcu.wrmcp("X", push)
        for _ in range(200):
            mcu.advance(1)
            if mcu.rdaxst("X").lpsf:
                taught.append(mcu.rdlp("X"))
    mcu.lps("X", 0)
    return taught


def replay(mcu: Mcu, taught: list[float]) -> list[float]:
    """Drives along the taught positions at the same pace; returns where the axis was at each of them."""
    mcu.cl("X")
    mcu.mla({"X": taught[0]}, ac=200.0, vl=50.0)
    mcu.advance(2000)
    ways = pairwise(taught)
    points = [start + (end - start) * n / EVERY for start, end in ways for n in range(1, EVERY + 1)]
    for first in range(0, len(points), 1000):
        mcu.spd("X", points[first : first + 1000])
    mcu.ssms("X")
    mcu.advance(len(points))
    return [float(x) for x in mcu.trace.rp[EVERY - 1 :: EVERY, 0]]


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    taught = teach(mcu)
    driven = replay(mcu, taught)
    error = max(abs(a - b) for a, b in zip(taught[1:], driven, strict=True))
    print(f"taught {len(taught)} positions, from {taught[0]:.2f} to {max(taught):.2f} and back to {taught[-1]:.2f}")
    print(f"driven again within {1000 * error:.0f} um")


if __name__ == "__main__":
    main()
