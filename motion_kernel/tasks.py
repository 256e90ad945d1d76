"""PCAP commands for CNC tasks, common variables and common buffers."""

from __future__ import annotations

from typing import Any, Literal, Protocol, overload

from motion_kernel.commands import PcapError, command
from motion_kernel.driver import Driver
from motion_kernel.structures import TaskStatus

MOST_BYTES = 512  # of a task string (4.4.14)
BUFFER = 1000  # bytes of a common buffer
BLOCKS = (100, 1000)  # indices that read variables 0..99 and 0..999 together


class Program(Protocol):
    """A compiled program (gcode.Program, sympas.Program)."""

    @property
    def native(self) -> Any:
        """The compiled program of cnc_front._native."""


class Tasks(Driver):
    """CNC tasks 0 to 3 (IndexError for others) and what they share with the PC."""

    def load(self, task: int, program: Program) -> None:
        """Loads a compiled program into a CNC task."""
        self._mcu.load(task, program.native)

    @command("4.4.124")
    def startcnct(self, task: int) -> None:
        """Starts a CNC task from its beginning."""
        self._mcu.startcnct(task)

    @command("4.4.126")
    def stopcnct(self, task: int) -> None:
        """Stops a CNC task where it is."""
        self._mcu.stopcnct(task)

    @command("4.4.10")
    def contcnct(self, task: int) -> None:
        """Continues a stopped or stepped CNC task."""
        self._mcu.contcnct(task)

    @command("4.4.125")
    def stepcnct(self, task: int) -> None:
        """Executes one source line of a CNC task."""
        self._mcu.stepcnct(task)

    @command("4.4.50")
    def rdcncts(self, task: int) -> TaskStatus:
        """Status of a CNC task."""
        return TaskStatus(*self._mcu.rdcncts(task))

    @command("4.4.13")
    def gettskinfo(self, task: int) -> int:
        """Whether the task wrote a string that was not read yet: bit 0 an open one (write), bit 1 a closed one
        (writeln). PcapError without a system on the card."""
        return self._mcu.gettskinfo(task)

    @command("4.4.14", "bytes")
    def gettskstr(self, task: int, szbuffer: int = MOST_BYTES) -> str:
        """The output string of a task, at most `szbuffer` and at most 512 bytes; reading it clears gettskinfo."""
        text = self._mcu.gettskstr(task)
        return text.encode()[: max(0, szbuffer)].decode(errors="ignore")

    @overload
    def rdci(self, number: Literal[100, 1000]) -> list[int]: ...  # type: ignore[overload-overlap]
    @overload
    def rdci(self, number: int) -> int: ...
    @command("4.4.49")
    def rdci(self, number: int) -> int | list[int]:
        """Common integer 0..999; IndexError outside. 100 reads 0..99 together and 1000 all of them, so that number
        100 cannot be read by itself."""
        return [self._mcu.rdci(n) for n in range(number)] if number in BLOCKS else self._mcu.rdci(number)

    @command("4.4.136")
    def wrci(self, number: int, value: int) -> None:
        """Common integer 0..999, 32 bits; 1000 does nothing. It survives rs."""
        if number != BLOCKS[-1]:
            self._mcu.wrci(number, value)

    @overload
    def rdcd(self, number: Literal[100, 1000]) -> list[float]: ...  # type: ignore[overload-overlap]
    @overload
    def rdcd(self, number: int) -> float: ...
    @command("4.4.48")
    def rdcd(self, number: int) -> float | list[float]:
        """Common double 0..999; IndexError outside. 100 reads 0..99 together and 1000 all of them."""
        return [self._mcu.rdcd(n) for n in range(number)] if number in BLOCKS else self._mcu.rdcd(number)

    @command("4.4.135")
    def wrcd(self, number: int, value: float) -> None:
        """Common double 0..999; 1000 does nothing. It survives rs."""
        if number != BLOCKS[-1]:
            self._mcu.wrcd(number, value)

    @command("4.4.47", "bytes")
    def rdcbcnct(self, task: int, size: int = BUFFER) -> bytes:
        """The first `size` bytes of the common buffer of a task. PcapError: status bit 0 task number, bit 1 size."""
        status, data = self._mcu.common_buffer(max(task, -1) & 0xFF, max(size, 0))
        if status:
            raise PcapError(status, f"rdcbcnct: tasks are 0 to 3, buffers have {BUFFER} bytes")
        return data

    @command("4.4.134", "bytes", returns_status=True)
    def wrcbcnct(self, task: int, data: bytes) -> int:
        """Writes the beginning of the common buffer of a task. Returns 0, or bit 0 task number, bit 1 size."""
        return self._mcu.set_common_buffer(max(task, -1) & 0xFF, data)
