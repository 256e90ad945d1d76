"""PCAP commands that set the controller up: boot, initialisation, files, cards, environment.

Each returns the code of its table in the manual; `booterrorreport` and its kin say it in words."""

from __future__ import annotations

import os
import struct
from pathlib import Path

from cnc_front._native import motion_kernel as native
from motion_kernel.axis_values import Loops
from motion_kernel.commands import command
from motion_kernel.driver import FAILED, TIMEOUT
from motion_kernel.machine import Machine, MachineError
from motion_kernel.structures import ROSI, Initialised

REVISION = "V2.5.3.126"  # OSVERSION 253126 (design D12)
APCI_8008 = 32
PLATFORM = 8  # ELF machine of rwmos.elf: MIPS (chapter 3)
SYSTEM_FILES = (".toml", ".dat")
AUTOCODE = ".cnc"

BOOT_ERRORS = {
    0: "the system is booted",
    10: "the file name is invalid",
    11: "the file cannot be opened",
    12: "unknown file format: only ELF files are allowed",
    13: "invalid ELF file",
    14: "invalid start address in the operating system file",
    15: "the operating system file is not meant for this hardware platform",
}
TXBF_ERRORS = {
    0: "the file was transferred",
    20: "the file cannot be opened: check name, path and drive",
    21: "the file is too large for the memory of a CNC task",
    22: "the file is neither a compiled program nor a system file",
    24: "invalid task number, or a system file that is invalid or damaged",
}
INIT_ERRORS = {
    **TXBF_ERRORS,
    0: "the system is initialised",
    32: "the operating system is not loaded or was stopped: load it with bootfile",
}


class System(Loops):
    """Boot and initialisation. An `Mcu` begins as if both had been done with its machine."""

    @command("4.4.5", manual="BootFile")
    def bootfile(self, filename: str | os.PathLike[str], tpubaseaddress: int = 0) -> int:
        """Resets the card and loads its operating system, an ELF file for MIPS; then initmcusystem2 or 3 is needed.
        0 = done; 10 to 15: see `booterrorreport`, and no operating system runs. `tpubaseaddress` has no meaning."""
        card = self._card
        card.booted = card.initialised = False
        card.trace = None
        status = _check_elf(os.fspath(filename))
        if status == 0:
            card.read_environment()
            card.emulator.reboot()
            card.booted = True
        return status

    @command("4.4.4", manual="BootErrorReport")
    def booterrorreport(self, filename: str | os.PathLike[str], error: int) -> str:
        """What a return code of bootfile means. A message box there, a string here (and in `messages`)."""
        return self._report(BOOT_ERRORS, error, os.fspath(filename))

    @command("4.4.32")
    def mcuinit(self) -> ROSI:
        """Asks the card for its system information, without a reset; all 0 if it does not answer."""
        if not self._card.booted:
            return ROSI("", 0, 0)
        return ROSI(REVISION, len(self.machine.axis_names), int(self._card.initialised))

    @command("4.4.16", manual="InitMcuSystem")
    def initmcusystem(self) -> Initialised:
        """Initialises the system; sends the machine of this `Mcu` as system data if the card has none yet. Status 0,
        32 (no operating system) or that of txbf2."""
        return self._initialise(None)

    @command("4.4.17", manual="InitMcuSystem2")
    def initmcusystem2(self, systemfilename: str | os.PathLike[str], tpubaseaddress: int = 0) -> Initialised:
        """As initmcusystem, with a machine file as system file."""
        return self._initialise(systemfilename)

    @command("4.4.18", manual="InitMcuSystem3")
    def initmcusystem3(self, systemfilename: str | os.PathLike[str], tpubaseaddress: int = 0) -> Initialised:
        """As initmcusystem2. The result holds the system information and the board type 32, APCI-8008."""
        return self._initialise(systemfilename)

    @command("4.4.15", manual="InitMcuErrorReport")
    def initmcuerrorreport(self, error: int) -> str:
        """What a status of the initialisation commands means."""
        return self._report(INIT_ERRORS, error, "")

    @command("4.4.129")
    def txbf2(self, filename: str | os.PathLike[str]) -> int:
        """Sends a machine file (.toml, .dat): all axes begin anew with its values, what was written before is lost
        (common variables stay). Or an autocode file (.cnc): its program replaces that of the task that it names, which
        stops; startcnct starts it. The name may have a path; it is looked for in the working folder, then along PATH.
        0, or 20 to 24: see `txbferrorreport`."""
        if not self._card.booted:
            return TIMEOUT
        path = _find(os.fspath(filename))
        if path is None:
            return 20
        kind = path.suffix.lower()
        if kind not in (*SYSTEM_FILES, AUTOCODE):
            return 22
        try:
            if path.stat().st_size > native.MOST_AUTOCODE_BYTES:
                return 21
            data = path.read_bytes()
        except OSError:
            return 20
        return self._send_program(data) if kind == AUTOCODE else self._send_system(data)

    def _send_program(self, data: bytes) -> int:
        return self._mcu.load_autocode(data) if self._card.initialised else FAILED

    def _send_system(self, data: bytes) -> int:
        try:
            self._card.take(Machine.parse(data))
        except MachineError:
            return 24
        return 0

    @command("4.4.129")
    def txbf(self, filename: str) -> int:
        """As txbf2, for a name without path or drive."""
        return self.txbf2(filename) if Path(filename).name == filename else 20

    @command("4.4.130", manual="txbfErrorReport")
    def txbferrorreport(self, filename: str | os.PathLike[str], error: int) -> str:
        """What a return code of txbf2 means."""
        return self._report(TXBF_ERRORS, error, os.fspath(filename))

    @command("4.4.40", manual="MsgToScreen")
    def msgtoscreen(self, enable: int) -> None:
        """Lets reports appear in `messages` (at first they do), or keeps them out (0)."""
        self._screen = bool(enable)

    @command("4.4.6", manual="CardSelect")
    def cardselect(self, cardnumber: int) -> int:
        """Chooses the card that all further commands refer to; returns its index. -1 if there is none: then card 0."""
        known = 0 <= cardnumber < len(self._cards)
        self._card = self._cards[cardnumber if known else 0]
        return cardnumber if known else -1

    @command("4.4.12", manual="getEnvStr")
    def getenvstr(self, name: str) -> str:
        """An environment string of the card (`environment`), "" if it has none. PcapError if it does not answer."""
        _ = self._mcu
        return self.environment.get(name, "")

    def _initialise(self, filename: str | os.PathLike[str] | None) -> Initialised:
        card = self._card
        if not card.booted:
            return Initialised(32, [], self.mcuinit(), 0)
        if not card.initialised:
            if filename is None:
                card.take(card.machine)
            elif status := self.txbf2(filename):
                return Initialised(status, [], self.mcuinit(), APCI_8008)
        return Initialised(0, [self.rdap(a) for a in range(len(card.names))], self.mcuinit(), APCI_8008)

    def _report(self, table: dict[int, str], error: int, filename: str) -> str:
        text = table.get(error, f"unknown error {error}")
        text = f"{filename}: {text}" if filename else text
        if self._screen:
            self.messages.append(text)
        return text


def _find(filename: str) -> Path | None:
    """The file in the working folder, else in a folder of PATH."""
    if not filename or "\0" in filename:
        return None
    name = Path(filename)
    folders = [Path(), *map(Path, os.get_exec_path())] if not name.is_absolute() else [Path()]
    return next((folder / name for folder in folders if (folder / name).is_file()), None)


def _check_elf(filename: str) -> int:
    """0 for an operating system file that this card can load, else the code of 4.4.5."""
    if not filename or "\0" in filename:
        return 10
    try:
        data = Path(filename).read_bytes()
    except OSError:
        return 11
    if data[:4] != b"\x7fELF":
        return 12
    if len(data) < 52 or data[4] != 1 or data[5] not in (1, 2):  # 32 bits, either byte order
        return 13
    order = "<" if data[5] == 1 else ">"
    kind, platform, _, entry, headers = struct.unpack_from(f"{order}HHIII", data, 16)
    size, count = struct.unpack_from(f"{order}HH", data, 42)
    if kind != 2 or size < 32 or headers + size * count > len(data):
        return 13
    if platform != PLATFORM:
        return 15
    segments = [struct.unpack_from(f"{order}8I", data, headers + size * n) for n in range(count)]
    loaded = [s for s in segments if s[0] == 1]
    if any(offset + length > len(data) for _, offset, _, _, length, *_ in loaded):
        return 13
    return 0 if any(start <= entry < start + memory for _, _, start, _, _, memory, *_ in loaded) else 14
