"""Measuring with latches: a probe at a strobe input in real time, a light barrier at an LP input (4.4.82)."""

from __future__ import annotations

from pathlib import Path

from motion_kernel import Machine, Mcu


def drive_until(mcu: Mcu, target: float, flag: str) -> float:
    """Drives X to a target until a latch of that kind has happened; returns the latched position."""
    mcu.rdigi("X")
    mcu.rdlp("X")  # arms it again
    mcu.mla({"X": target}, ac=500.0, vl=25.0)
    while not (mcu.rddigi("X").strobe if flag == "strobe" else mcu.rdaxst("X").lpsf):
        mcu.advance(1)
        if mcu.rdaxst("X").pe:
            raise SystemExit(f"nothing there up to {target}")
    mcu.ms("X")
    mcu.advance(200)
    return mcu.rdlp("X")


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    mcu.cl("X")
    near = drive_until(mcu, 50.0, "strobe")
    mcu.mla({"X": 50.0}, ac=500.0, vl=50.0)
    mcu.advance(2000)
    far = drive_until(mcu, 20.0, "strobe")
    print(f"the part reaches from {near:.3f} to {far:.3f}: {far - near:.3f} mm")
    barrier = drive_until(mcu, 90.0, "lpsf")
    print(f"light barrier at {barrier:.2f}, to a sample")
    try:
        drive_until(mcu, 95.0, "strobe")
    except SystemExit as nothing:
        print(nothing)


if __name__ == "__main__":
    main()
