"""Homing X with a reference switch that bounces, then its encoder index: the same place every time.

Run it from anywhere: python examples/faults/homing.py
"""

from __future__ import annotations

from pathlib import Path

from motion_kernel import Machine, Mcu

HERE = Path(__file__).parent
SWITCH_MM = -50.0


def home(bounce_ms: float, start_mm: float) -> tuple[float, float]:
    """Homes X from `start_mm`; returns where it first stopped and where its zero is, on the scale of the machine."""
    mcu = Mcu(Machine.load(HERE / "machine.toml"))
    mcu.add_stimulus(f"while X < {SWITCH_MM}: input 5 on bouncing {bounce_ms} ms")
    mcu.cl(["X"])
    mcu.wrhvl("X", 20.0)
    mcu.ja({"X": start_mm})
    mcu.advance(2000)

    mcu.jhl(["X"])  # fast onto the switch
    while not mcu.rdaxst("X").pe:
        mcu.advance(10)
    stopped_mm = mcu.rdrp("X")
    mcu.jr({"X": 10.0})  # off it again
    mcu.advance(1500)
    mcu.wrhvl("X", 1.0)  # and slowly onto it: less way between two samples
    mcu.jhl(["X"])
    while not mcu.rdaxst("X").pe:
        mcu.advance(10)
    zero_mm = mcu.rdrp("X")
    mcu.shp("X", SWITCH_MM)
    assert mcu.rdaxst("X").referenced
    return stopped_mm, zero_mm


if __name__ == "__main__":
    for bounce_ms in (0.0, 4.0, 20.0):
        stopped_mm, zero_mm = home(bounce_ms, 5.0)
        print(f"bouncing {bounce_ms:4.1f} ms: first stop at {stopped_mm:9.4f} mm, zero at {zero_mm:9.4f} mm")
