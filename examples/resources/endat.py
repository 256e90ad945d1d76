"""Commissioning an ENDAT encoder: who is there, its own memory, a disturbed line, an alarm (chapter 6)."""

from __future__ import annotations

from pathlib import Path

from motion_kernel import Machine, Mcu
from motion_kernel.resources import WRITE, Code, ObjectDescriptor

TPV, SMA, TP, RP, RESET, ALARM, CRC_ERRORS, BUS_ERROR = 3000, 3001, 3002, 3003, 3004, 3010, 3011, 3013
OEM = 0xA9  # a memory area that is free for the machine's builder


class Failed(Exception):
    """A transfer failed; the argument is its return code."""


def transfer(mcu: Mcu, device: int, value: int | None = None, address: int = 0) -> int:
    """Reads, or writes a value: repeated while BUSY, as 6.4 wants it."""
    d = ObjectDescriptor(device, mcu.axis_number("X"), address, access=1 if value is None else WRITE)
    while True:
        if value is None:
            code, answer = mcu.resources.rdoptionint(d)
        else:
            code, answer = mcu.resources.wroptionint(d, value), value
        if code == Code.OK:
            return answer
        if code != Code.BUSY:
            raise Failed(code)
        mcu.advance(1)


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    mcu.resources.fit("RESOURCE", "ENDAT")
    mcu.resources.fit_endat("X", bits=24, steps=1 << 13)
    print("without MT0 the axis has", mcu.resources.endat_setup("X"))
    mcu.environment["MT0"] = "16"
    mcu.rs()
    print(mcu.resources.endat_setup("X"))
    mcu.cl(["X"])
    mcu.ja({"X": 12.5})
    mcu.advance(2000)
    print("position word", transfer(mcu, TPV))
    transfer(mcu, SMA, OEM)
    transfer(mcu, RP, 4711, address=3)
    print("serial number", transfer(mcu, TP, address=3))
    mcu.resources.disturb_endat("X", alarm=True, crc_errors=1)
    try:
        transfer(mcu, TPV)
    except Failed as failed:
        crc, bus = transfer(mcu, CRC_ERRORS), transfer(mcu, BUS_ERROR)
        print(f"return code {failed.args[0]:#x}, {crc} CRC error, bus error {bus}")
    transfer(mcu, TPV)
    print("alarm", transfer(mcu, ALARM))
    try:
        transfer(mcu, RESET, 0)
    except Failed:
        print("no reset in closed loop")
    mcu.ol(["X"])
    transfer(mcu, RESET, 0)
    transfer(mcu, BUS_ERROR, 0)
    transfer(mcu, TPV)
    print("after the reset: alarm", transfer(mcu, ALARM), "bus error", transfer(mcu, BUS_ERROR))


if __name__ == "__main__":
    main()
