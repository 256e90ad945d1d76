"""Homing of two axes: reference switch, then the next index pulse, home position there (4.4.20 to 4.4.22)."""

from __future__ import annotations

from pathlib import Path

from motion_kernel import Machine, Mcu

AXES = ["X", "Y"]


def wait_for_profile_end(mcu: Mcu, axes: list[str]) -> None:
    while not all(mcu.rdaxst(axis).pe for axis in axes):
        mcu.advance(10)


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    mcu.cl(AXES)
    mcu.jhl(AXES)  # to the left until the switch of each axis closes, whatever it bounces
    wait_for_profile_end(mcu, AXES)
    for axis in AXES:
        print(f"{axis}: switch found at {mcu.rdrp(axis):.1f}")
        mcu.rdigi(axis)  # forget index pulses that were passed
    mcu.jhi(dict.fromkeys(AXES, 6.0))  # to the right, less than two index periods
    wait_for_profile_end(mcu, AXES)
    for axis in AXES:
        beyond = mcu.rdrp(axis) - mcu.rdlpndx(axis)  # it braked behind the pulse
        mcu.shp(axis, beyond)  # so 0 is exactly at the pulse
        print(f"{axis}: index latched, referenced {mcu.rdaxst(axis).referenced}, now at {mcu.rdrp(axis):.3f}")
    mcu.ja({"X": 0.0, "Y": 0.0})
    wait_for_profile_end(mcu, AXES)
    mcu.advance(100)
    print(f"at home: {mcu.rdrp('X'):.3f} {mcu.rdrp('Y'):.3f}")


if __name__ == "__main__":
    main()
