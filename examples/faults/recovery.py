"""A blocked axis and its recovery by RPtoDP: the following error is gone before the axis comes free.

Run it from anywhere: python examples/faults/recovery.py
"""

from __future__ import annotations

from pathlib import Path

from motion_kernel import Machine, Mcu

HERE = Path(__file__).parent


def main() -> tuple[float, float, float]:
    """Following error when blocked, jump as it comes free, and where the axis ends."""
    mcu = Mcu(Machine.load(HERE / "machine.toml"))
    mcu.add_stimulus("when X > 20: X blocked\nwhen input 16 on: X free")
    mcu.cl(["X"])
    mcu.smla({"X": 50.0}, ac=500.0, vl=40.0)
    mcu.ssms(["X"])
    while not mcu.rdaxst("X").mpe:
        mcu.advance(10)
    mcu.js(["X"])
    mcu.advance(500)
    error_mm, place_mm = mcu.rdposerr("X"), mcu.rdrp("X")

    mcu.rptodp(["X"])  # the actual position becomes the desired one
    mcu.set_inputs(mcu.rddigi("X") & 0xFFFF | 1 << 15)  # somebody frees the axis
    mcu.advance(500)
    jump_mm = mcu.rdrp("X") - place_mm

    mcu.cl(["X"])  # clears mpe
    mcu.ja({"X": 50.0})
    mcu.advance(4000)
    return error_mm, jump_mm, mcu.rdrp("X")


if __name__ == "__main__":
    error_mm, jump_mm, end_mm = main()
    print(
        f"blocked with {error_mm:.3f} mm of following error, free with a jump of {jump_mm:.4f} mm, ends at {end_mm:.4f}"
    )
