"""Spooling by hand: a contour through a small window, refilled while it runs, outputs in step (4.4.84, 4.4.123)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from motion_kernel import Machine, Mcu, ModeReg

PLANE = ["X", "Y"]
ROUNDS = 3
WINDOW = 20  # commands that wait at most


def flower() -> Iterator[tuple[float, float]]:
    """Corners of a flower of five leaves around (0, 0)."""
    for n in range(ROUNDS * 200 + 1):
        angle = math.tau * n / 200
        radius = 30.0 + 10.0 * math.cos(5 * angle)
        yield radius * math.cos(angle), radius * math.sin(angle)


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    mcu.wrmodereg(ModeReg.of("LookAhead", "ExactTargetPos"))
    for axis in PLANE:
        mcu.wrmdvel(axis, 5.0)
    mcu.cl(PLANE)
    memory = mcu.rdlsm("X")
    corners = list(flower())
    mcu.smla(dict(zip(PLANE, corners[0], strict=True)), ac=800.0, vl=60.0)
    mcu.ssf("X", 1001, 0b100)  # output 3 on: the tool
    least = memory
    for left, corner in zip(reversed(range(len(corners) - 1)), corners[1:], strict=True):
        mcu.smla(dict(zip(PLANE, corner, strict=True)), ac=800.0, vl=60.0, tvl=60.0 if left else 0.0)
        least = min(least, mcu.rdlsm("X"))
        if mcu.rdmcis("X") >= WINDOW:
            mcu.ssms(PLANE)
            while mcu.rdmcis("X") >= WINDOW:
                mcu.advance(1)
    mcu.ssf("X", 1002, 0b100)
    while mcu.rddigo("X") & 0b100:
        mcu.advance(10)
    print(f"{len(corners)} commands with {memory - least} of {memory} bytes, {mcu.samples * 1.28e-3:.1f} s")
    print(f"end at {mcu.rddp('X'):.3f} {abs(mcu.rddp('Y')):.3f}, ErrorReg {mcu.rderrorreg().names}")


if __name__ == "__main__":
    main()
