"""PCAP commands for registers of the controller as a whole: units, override, path values of rw_SymPas."""

from __future__ import annotations

from cnc_front._native import motion_kernel as native
from motion_kernel.commands import command
from motion_kernel.driver import FAILED, Axes, Driver


class SystemValues(Driver):
    """Registers of the controller as a whole. Writers return 0, or 1 for a value that is not allowed."""

    @command("4.4.11")
    def ctru(self, pu: int | str, tu: int | str) -> bool:
        """Units of all interpolation commands and of rw_SymPas, by number or name: pu mm, inch, m, rev, deg, rad,
        counts, steps (0..7); tu sec, min, tsample (0..2). False, and ErrorReg errUnit, for an unknown one."""
        positions, times = native.trajectory_units()
        return self._mcu.ctru(_number(pu, positions), _number(tu, times))

    @command("4.4.98", "us", manual="rdSampleTime")
    def rdsampletime(self) -> int:
        """Sample time. PcapError without a system on the card."""
        return self._mcu.rdsampletime()

    @command("4.4.106", "factor")
    def rdtrovr(self) -> float:
        """The buffered trajectory override, as last written."""
        return self._mcu.read_register("trovr")

    @command("4.4.174", "factor")
    def wrtrovr(self, factor: float) -> None:
        """Buffers the trajectory override, above 0; `utrovr` takes it over. ValueError otherwise."""
        if not self._mcu.write_register("trovr", factor):
            raise ValueError(f"override {factor}: must be above 0")

    @command("4.4.132")
    def utrovr(self, axes: Axes) -> None:
        """Takes the trajectory override over for these axes, ramped with TROVRST."""
        self._mcu.utrovr(self._indices(axes))

    @command("4.4.107", "s")
    def rdtrovrst(self) -> float:
        """Time for an override change of 1.0."""
        return self._mcu.read_register("trovrst")

    @command("4.4.175", "s", returns_status=True)
    def wrtrovrst(self, seconds: float) -> int:
        """Time for an override change of 1.0; 0 = at once."""
        return self._set("trovrst", seconds)

    @command("4.4.105", "PU/TU²")
    def rdtrac(self) -> float:
        """TRAC: path acceleration of rw_SymPas programs, and of `ms` with MS_DECEL."""
        return self._mcu.read_register("trac")

    @command("4.4.173", "PU/TU²", returns_status=True)
    def wrtrac(self, trac: float) -> int:
        """TRAC, 0 or more. PCAP commands take their own `ac`."""
        return self._set("trac", trac)

    @command("4.4.108", "PU/TU")
    def rdtrvl(self) -> float:
        """TRVL: path velocity of rw_SymPas programs."""
        return self._mcu.read_register("trvl")

    @command("4.4.176", "PU/TU", returns_status=True)
    def wrtrvl(self, trvl: float) -> int:
        """TRVL, 0 or more. PCAP commands take their own `vl`."""
        return self._set("trvl", trvl)

    @command("4.4.109", "PU/TU")
    def rdtrtvl(self) -> float:
        """TRTVL: path target velocity of rw_SymPas programs."""
        return self._mcu.read_register("trtvl")

    @command("4.4.177", "PU/TU", returns_status=True)
    def wrtrtvl(self, trtvl: float) -> int:
        """TRTVL. PCAP commands take their own `tvl`."""
        return self._set("trtvl", trtvl)

    @command("4.4.92")
    def rdnfrax(self) -> list[str]:
        """NFRAX: names of the axes that do not count for the path velocity."""
        return [self.machine.axis_names[a] for a in self._mcu.read_registers()[0]]

    @command("4.4.166")
    def wrnfrax(self, axes: Axes) -> None:
        """NFRAX: the axes that do not count for the path velocity."""
        self._mcu.write_nfrax(self._indices(axes))

    def _set(self, register: str, value: float) -> int:
        return 0 if self._mcu.write_register(register, value) else FAILED


def _number(unit: int | str, names: list[str]) -> int:
    if isinstance(unit, str):
        return names.index(unit) if unit in names else -1
    return unit
