"""PCAP commands that find and set positions: home searches, reference, latches."""

from __future__ import annotations

from collections.abc import Mapping

from motion_kernel.axis_values import POSITION
from motion_kernel.commands import command
from motion_kernel.driver import Axes, AxisId, Driver


class Homing(Driver):
    """Home searches run with hvl and hac, as direct commands; pe stays 0 until they end."""

    @command("4.4.20", POSITION)
    def jhi(self, distances: Mapping[AxisId, float]) -> bool:
        """Searches the encoder index of each axis over at most its distance, whose sign is the direction.
        CommandRefused in open loop."""
        axes = [self._index(axis) for axis in distances]
        return self._entered(self._mcu.search("index", axes, [float(x) for x in distances.values()]), "jhi")

    @command("4.4.21")
    def jhl(self, axes: Axes) -> bool:
        """Searches the reference switch (input with function REF) to the left, endlessly."""
        indices = self._indices(axes)
        return self._entered(self._mcu.search("left", indices, [0.0] * len(indices)), "jhl")

    @command("4.4.22")
    def jhr(self, axes: Axes) -> bool:
        """Searches the reference switch to the right, endlessly."""
        indices = self._indices(axes)
        return self._entered(self._mcu.search("right", indices, [0.0] * len(indices)), "jhr")

    @command("4.4.116", POSITION)
    def shp(self, axis: AxisId, position: float = 0.0) -> None:
        """The actual position gets this coordinate and the axis is referenced: its software limits count. Nothing
        moves."""
        if not self._mcu.shp(self._index(axis), position):
            raise ValueError(f"shp {position}: must be a finite number")

    @command("4.4.27", "sample intervals")
    def lps(self, axis: AxisId, mst: int) -> None:
        """Latches the actual position every `mst` samples (axst lpsf); 0 ends it. ValueError below 0."""
        if not 0 <= mst < 2**31:
            raise ValueError(f"lps: mst {mst} must be 0 or more")
        self._mcu.lps(self._index(axis), mst)

    @command("4.4.82", POSITION)
    def rdlp(self, axis: AxisId) -> float:
        """The latched position: by lps, an input with function LP or a strobe input. Reading it clears lpsf."""
        return self._mcu.rdlp(self._index(axis))

    @command("4.4.158", POSITION)
    def wrlp(self, axis: AxisId, lp: float) -> None:
        """Sets the latched position."""
        self._write(axis, "lp", lp)

    @command("4.4.83", POSITION)
    def rdlpndx(self, axis: AxisId) -> float:
        """The position latched by the encoder index."""
        return self._read(axis, "lpndx")

    @command("4.4.159", POSITION)
    def wrlpndx(self, axis: AxisId, lp: float) -> None:
        """Sets the position latched by the index."""
        self._write(axis, "lpndx", lp)

    @command("4.4.25", "s")
    def lpr(self, san: AxisId, let: float, lst: float = 0.0) -> None:
        """Records one axis for the graphic system analysis: for `let` s, beginning `lst` s from now. ValueError for
        times that are none."""
        self.lprs([san], let, lst)

    @command("4.4.26", "s")
    def lprs(self, axes: Axes, let: float, lst: float = 0.0) -> None:
        """As lpr for several axes in step: 1000 values each, `analysis` has them."""
        if not self._mcu.lprs(self._indices(axes), lst, let):
            raise ValueError(f"lprs: duration {let} and delay {lst} must be times, and an axis is needed")

    def analysis(self, axis: AxisId) -> dict[str, list[float]]:
        """What lpr or lprs recorded of an axis so far: times in s since boot, dp, rp, dv, rv and mcp; empty lists for
        an axis that was not recorded."""
        first, every, columns = self._mcu.analysis(self._index(axis))
        sample_time_s = self.machine.sample_time_s
        times = [(first + n * every + 1) * sample_time_s for n in range(len(columns["dp"]))]
        return {"t_s": times, **columns}
