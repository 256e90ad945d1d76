"""Two cards in a PC: boot and initialisation with their return codes, the choice of a card (4.4.5, 4.4.6, 4.4.18)."""

from __future__ import annotations

from pathlib import Path

from motion_kernel import Machine, Mcu, PcapError

CELL = Path(__file__).with_name("cell.toml")


def main() -> None:
    mcu = Mcu(Machine.load(CELL), Machine.builtin())
    error = mcu.bootfile("rwmos.elf")  # not on this disk: the card is reset and stays without operating system
    print(mcu.booterrorreport("rwmos.elf", error))
    print(mcu.initmcuerrorreport(mcu.initmcusystem3(CELL).status))
    try:
        mcu.cl("X")
    except PcapError as failure:
        print(f"return code {failure.status}: {failure}")
    print(f"card {mcu.cardselect(1)}: {mcu.machine.name}, {mcu.mcuinit().number_axis} axes")
    mcu.cl("X")
    mcu.ja({"X": 25.0})
    mcu.advance(2000)
    print(f"it is at {mcu.rdrp('X'):.2f}")
    print(mcu.txbferrorreport("cell.toml", mcu.txbf2(CELL)))
    print(f"card 1 is a {mcu.machine.name} now, its X at {mcu.rdrp('X'):.2f}")
    print(f"there is no card 2: {mcu.cardselect(2)}")


if __name__ == "__main__":
    main()
