"""Gear change at run time: the motor stays, positions and what is derived from gf get other numbers (4.4.145)."""

from __future__ import annotations

from pathlib import Path

from motion_kernel import Machine, Mcu


def jog_by(mcu: Mcu, distance: float) -> int:
    """Jogs X; returns the encoder counts of the way."""
    before = mcu.rdrp("X") * mcu.rdslsp("X") / mcu.rdgf("X")
    mcu.jr({"X": distance})
    while not mcu.rdaxst("X").pe:
        mcu.advance(10)
    mcu.advance(100)
    return round(mcu.rdrp("X") * mcu.rdslsp("X") / mcu.rdgf("X") - before)


def change_gear(mcu: Mcu, factor: float) -> None:
    """Another gear, the same motor: velocities and accelerations of the axis go with it, which the card does not do."""
    mcu.wrgf("X", mcu.rdgf("X") * factor)
    for read, write in [
        (mcu.rdjvl, mcu.wrjvl),
        (mcu.rdjac, mcu.wrjac),
        (mcu.rdsdec, mcu.wrsdec),
        (mcu.rdmpe, mcu.wrmpe),
    ]:
        write("X", read("X") * factor)


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    mcu.cl("X")
    print(f"first gear: {mcu.rdgf('X'):g} mm a revolution, 10 mm are {jog_by(mcu, 10.0)} counts")
    change_gear(mcu, 4.0)
    print(f"the axis has not moved, its position is {mcu.rdrp('X'):.2f} now")
    print(f"second gear: {mcu.rdgf('X'):g} mm a revolution, 10 mm are {jog_by(mcu, 10.0)} counts")
    print(f"jog velocity {mcu.rdjvl('X'):g} mm/s, the motor as fast as before")


if __name__ == "__main__":
    main()
