"""PC and CNC task together: common variables, a wait for CI99, an interrupt of the PC (4.4.7, 4.4.33)."""

from __future__ import annotations

from pathlib import Path

import gcode
from motion_kernel import Machine, Mcu

PROGRAM = """
G90 G21 G17
G1 X20 F3000
CI1 = 1
M06 T1
G1 Y20
CI1 = 2
M30
"""


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    heard: list[float] = []

    def routine(lines: int) -> None:
        heard.append(mcu.rddp("Z"))
        mcu.wrirqpc(0)

    mcu.mcug3_setboardintroutine(routine)
    mcu.prepare_gcode()
    mcu.load(0, gcode.compile(PROGRAM, mcu.machine))
    mcu.startcnct(0)
    while mcu.rdci(1) != 1:
        mcu.advance(10)
    mcu.advance(50)
    print(f"the task waits for a tool at X {mcu.rddp('X'):.1f}, CI99 is {mcu.rdci(99)}")
    mcu.wrcbcnct(0, b"tool 1: 6 mm end mill")  # what the task may read of the tool
    mcu.clearci99()
    while mcu.rdci(1) != 2:
        mcu.advance(10)
    mcu.advance(500)
    print(f"it went on to Y {mcu.rddp('Y'):.1f}; its buffer holds {mcu.rdcbcnct(0, 21).decode()!r}")
    mcu.smlr({"Z": -5.0}, ac=500.0, vl=20.0)
    mcu.ssf("Z", 1101, 1)
    mcu.smlr({"Z": 5.0}, ac=500.0, vl=20.0)
    mcu.ssms("Z")
    mcu.advance(1000)
    print(f"interrupt at Z {heard[0]:.2f}, then back to {mcu.rddp('Z'):.2f}")


if __name__ == "__main__":
    main()
