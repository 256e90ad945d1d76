"""PCAP commands that move axes: jogs, direct and spooled interpolation, the spooler, stops, loops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motion_kernel.commands import command
from motion_kernel.driver import Axes, AxisId, Driver

INTERPOLATION = "PU, PU/TU, PU/TU²; phi in degrees"


class DirectMotion(Driver):
    """Jogs and direct moves: each replaces at once what its axes do, and takes effect 2 samples later (design D2)."""

    @command("4.4.19", "axis units")
    def ja(self, targets: Mapping[AxisId, float]) -> bool:
        """Jogs each axis, on its own, to an absolute target with its jvl, jac and jtvl. CommandRefused in open loop;
        False if a target is no number."""
        return self._jog(targets, relative=False)

    @command("4.4.23", "axis units")
    def jr(self, distances: Mapping[AxisId, float]) -> bool:
        """As ja, by distances from the desired positions when the profiles start."""
        return self._jog(distances, relative=True)

    @command("4.4.24")
    def js(self, axes: Axes) -> None:
        """Jog stop: each axis brakes on its own with sdec; its spooler is emptied."""
        self._mcu.js(self._indices(axes))

    @command("4.4.37", INTERPOLATION)
    def mla(self, targets: Mapping[AxisId, float], *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """A straight line to absolute targets at once: path acceleration `ac`, path velocity `vl`, velocity at its end
        `tvl`. False if it was discarded: the reason stands in ErrorReg. CommandRefused in open loop."""
        return self._line("smla", targets, ac, vl, tvl, direct=True)

    @command("4.4.38", INTERPOLATION)
    def mlr(self, distances: Mapping[AxisId, float], *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """As mla, by distances from the desired positions when the profile starts."""
        return self._line("smlr", distances, ac, vl, tvl, direct=True)

    @command("4.4.28", INTERPOLATION)
    def mca(self, center: Mapping[AxisId, float], phi: float, *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """A circle of the two axes of `center` (absolute) at once, counter-clockwise for positive `phi`."""
        return self._arc("smca", center, {}, phi, ac, vl, tvl, direct=True)

    @command("4.4.29", INTERPOLATION)
    def mcr(self, center: Mapping[AxisId, float], phi: float, *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """As mca, the centre relative to the desired positions when the profile starts."""
        return self._arc("smcr", center, {}, phi, ac, vl, tvl, direct=True)

    @command("4.4.35", INTERPOLATION)
    def mha(
        self,
        center: Mapping[AxisId, float],
        phi: float,
        targets: Mapping[AxisId, float],
        *,
        ac: float,
        vl: float,
        tvl: float = 0.0,
    ) -> bool:
        """A helix at once: a circle of the two axes of `center`, straight lines to `targets` with the others. With
        |phi| <= 1e-100 the circle ends at the targets of its two axes, which must then be given."""
        return self._arc("smha", center, targets, phi, ac, vl, tvl, direct=True)

    @command("4.4.36", INTERPOLATION)
    def mhr(
        self,
        center: Mapping[AxisId, float],
        phi: float,
        distances: Mapping[AxisId, float],
        *,
        ac: float,
        vl: float,
        tvl: float = 0.0,
    ) -> bool:
        """As mha, centre and distances relative to the desired positions when the profile starts."""
        return self._arc("smhr", center, distances, phi, ac, vl, tvl, direct=True)

    @command("4.4.30", INTERPOLATION)
    def mca3d(
        self,
        center: Mapping[AxisId, float],
        normal: Sequence[float],
        phi: float,
        *,
        ac: float,
        vl: float,
        tvl: float = 0.0,
    ) -> bool:
        """A circle of three axes in space at once: around `center` (absolute), in the plane through the start with
        that `normal`, `phi` degrees of any size, counter-clockwise seen from the tip of the normal."""
        return self._arc_3d("mca3d", center, normal, phi, ac, vl, tvl)

    @command("4.4.31", INTERPOLATION)
    def mcr3d(
        self,
        center: Mapping[AxisId, float],
        normal: Sequence[float],
        phi: float,
        *,
        ac: float,
        vl: float,
        tvl: float = 0.0,
    ) -> bool:
        """As mca3d, the centre relative to the desired positions when the profile starts."""
        return self._arc_3d("mcr3d", center, normal, phi, ac, vl, tvl)

    @command("4.4.39")
    def ms(self, axes: Axes) -> None:
        """Motion stop: brakes along the contour with the acceleration of the current command (MS_DECEL: TRAC); the
        rest is discarded."""
        self._mcu.ms(self._indices(axes))

    # ---- inside

    def _jog(self, ways: Mapping[AxisId, float], *, relative: bool) -> bool:
        axes = [self._index(axis) for axis in ways]
        outcome = self._mcu.jog(axes, [float(x) for x in ways.values()], relative)
        return self._entered(outcome, "jr" if relative else "ja")

    def _line(
        self,
        kind: str,
        targets: Mapping[AxisId, float],
        ac: float,
        vl: float,
        tvl: float,
        *,
        direct: bool,
        index: int | None = None,
    ) -> bool:
        axes = [self._index(axis) for axis in targets]
        goals = [float(x) for x in targets.values()]
        outcome = self._mcu.motion(kind, direct, axes, goals, vl, ac, tvl, 0.0, (0.0, 0.0), index)
        return self._entered(outcome, kind[direct:])

    def _arc(
        self,
        kind: str,
        center: Mapping[AxisId, float],
        targets: Mapping[AxisId, float],
        phi: float,
        ac: float,
        vl: float,
        tvl: float,
        *,
        direct: bool,
    ) -> bool:
        name = kind[direct:]
        if len(center) != 2:
            raise ValueError(f"{name}: a circle has a centre in two axes, {len(center)} given")
        plane = [self._index(axis) for axis in center]
        ends = {self._index(axis): float(x) for axis, x in targets.items()}
        if ends.keys() & set(plane) != set(plane) and kind in ("smha", "smhr") and abs(phi) <= 1e-100:
            raise ValueError(f"{name}: without an angle the targets of both circle axes are needed")
        axes = plane + [axis for axis in ends if axis not in plane]
        first, second = (float(x) for x in center.values())
        goals = [ends.get(axis, 0.0) for axis in axes]
        outcome = self._mcu.motion(kind, direct, axes, goals, vl, ac, tvl, phi, (first, second))
        return self._entered(outcome, name)

    def _arc_3d(
        self,
        kind: str,
        center: Mapping[AxisId, float],
        normal: Sequence[float],
        phi: float,
        ac: float,
        vl: float,
        tvl: float,
    ) -> bool:
        if len(center) != 3 or len(normal) != 3:
            raise ValueError(f"{kind}: a centre in three axes and a normal of three numbers")
        axes = [self._index(axis) for axis in center]
        middle = [float(x) for x in center.values()]
        outcome = self._mcu.circle_3d(kind, axes, middle, [float(x) for x in normal], phi, vl, ac, tvl)
        return self._entered(outcome, kind)


class SpooledMotion(DirectMotion):
    """The spooler of each axis: entered at once, executed after `ssms`."""

    @command("4.4.37", INTERPOLATION)
    def smla(self, targets: Mapping[AxisId, float], *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """Spools a straight line to absolute targets. `ac` path acceleration, `vl` path velocity, `tvl` velocity
        at its end. False if it was discarded or the spooler is full: the reason stands in ErrorReg. CommandRefused in
        open loop."""
        return self._line("smla", targets, ac, vl, tvl, direct=False)

    @command("4.4.38", INTERPOLATION)
    def smlr(self, distances: Mapping[AxisId, float], *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """As smla, by distances from the end of what is spooled."""
        return self._line("smlr", distances, ac, vl, tvl, direct=False)

    @command("4.4.28", INTERPOLATION)
    def smca(self, center: Mapping[AxisId, float], phi: float, *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """Spools a circle with the two axes of `center` (absolute), counter-clockwise for positive `phi`."""
        return self._arc("smca", center, {}, phi, ac, vl, tvl, direct=False)

    @command("4.4.29", INTERPOLATION)
    def smcr(self, center: Mapping[AxisId, float], phi: float, *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """As smca, the centre relative to the start of the circle."""
        return self._arc("smcr", center, {}, phi, ac, vl, tvl, direct=False)

    @command("4.4.35", INTERPOLATION)
    def smha(
        self,
        center: Mapping[AxisId, float],
        phi: float,
        targets: Mapping[AxisId, float],
        *,
        ac: float,
        vl: float,
        tvl: float = 0.0,
    ) -> bool:
        """Spools a helix: a circle with the two axes of `center`, straight lines to `targets` with the others.
        With |phi| <= 1e-100 the circle ends at the targets of its two axes, which must then be given."""
        return self._arc("smha", center, targets, phi, ac, vl, tvl, direct=False)

    @command("4.4.36", INTERPOLATION)
    def smhr(
        self,
        center: Mapping[AxisId, float],
        phi: float,
        distances: Mapping[AxisId, float],
        *,
        ac: float,
        vl: float,
        tvl: float = 0.0,
    ) -> bool:
        """As smha, centre and distances relative to the start."""
        return self._arc("smhr", center, distances, phi, ac, vl, tvl, direct=False)

    @command("4.4.123", "as the function; times in 64 us")
    def ssf(self, axis: AxisId, function: int, value: float) -> bool:
        """Spools a special function for one axis. False if it was discarded (ErrorReg)."""
        return self._entered(self._mcu.ssf(self._index(axis), function, value), f"ssf {function}")

    @command("4.4.94", INTERPOLATION)
    def smlai(self, targets: Mapping[AxisId, float], pcapindex: int, *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """As smla; `rdpcapindex` of its axes gives `pcapindex` while it is executed."""
        return self._line("smla", targets, ac, vl, tvl, direct=False, index=pcapindex)

    @command("4.4.94", INTERPOLATION)
    def smlri(
        self, distances: Mapping[AxisId, float], pcapindex: int, *, ac: float, vl: float, tvl: float = 0.0
    ) -> bool:
        """As smlr, with a PcapIndex."""
        return self._line("smlr", distances, ac, vl, tvl, direct=False, index=pcapindex)

    @command("4.4.94", "as the function; times in 64 us")
    def ssfi(self, axis: AxisId, function: int, value: float, pcapindex: int) -> bool:
        """As ssf, with a PcapIndex."""
        return self._entered(self._mcu.ssf(self._index(axis), function, value, pcapindex), f"ssfi {function}")

    @command("4.4.94", "as the function; times in 64 us")
    def ssfni(self, axis: AxisId, function: int, value: float, pcapindex: int) -> bool:
        """As ssfi (the manual names it without a description)."""
        return self.ssfi(axis, function, value, pcapindex)

    @command("4.4.94", manual="rdPcapIndex")
    def rdpcapindex(self, axis: AxisId) -> int:
        """PcapIndex of the command that the axis executes, or executed last, of those that had one. PcapError without
        a system on the card."""
        return int(self._read(axis, "pcapindex"))

    @command("4.4.117", "axis position unit")
    def spd(self, axis: AxisId, positions: Sequence[float]) -> bool:
        """Spools 1 to 1000 set points of an axis, one for each sample."""
        return self._points("spd", axis, positions, 0)

    @command("4.4.118", "axis position unit")
    def spda(self, axis: AxisId, positions: Sequence[float], pcapindex: int) -> bool:
        """As spd; the PcapIndex counts on with each point."""
        return self._points("spda", axis, positions, pcapindex)

    @command("4.4.119", "axis position unit")
    def spdr(self, axis: AxisId, distances: Sequence[float], pcapindex: int) -> bool:
        """As spda, by distances from where the axis stands as the block begins."""
        return self._points("spdr", axis, distances, pcapindex)

    @command("4.4.122", "PU/TU")
    def sstvl(self, axes: Axes, tvl: float) -> None:
        """Target velocity of the last trajectory in the spoolers of these axes, as far as it can be reached."""
        self._mcu.sstvl(self._indices(axes), tvl)

    @command("4.4.30", INTERPOLATION)
    def smca3d(
        self,
        center: Mapping[AxisId, float],
        normal: Sequence[float],
        phi: float,
        *,
        ac: float,
        vl: float,
        tvl: float = 0.0,
    ) -> bool:
        """As mca3d, into the spooler."""
        return self._arc_3d("smca3d", center, normal, phi, ac, vl, tvl)

    @command("4.4.31", INTERPOLATION)
    def smcr3d(
        self,
        center: Mapping[AxisId, float],
        normal: Sequence[float],
        phi: float,
        *,
        ac: float,
        vl: float,
        tvl: float = 0.0,
    ) -> bool:
        """As smca3d, the centre relative to the end of what is spooled."""
        return self._arc_3d("smcr3d", center, normal, phi, ac, vl, tvl)

    def _points(self, kind: str, axis: AxisId, points: Sequence[float], index: int) -> bool:
        return self._entered(self._mcu.points(kind, self._index(axis), [float(x) for x in points], index), kind)

    @command("4.4.120")
    def ssms(self, axes: Axes) -> None:
        """Starts the spoolers of these axes at once. Waits 1003 and 1004 end early, a halt 1000 goes on."""
        self._mcu.ssms(self._indices(axes))

    @command("4.4.121")
    def sstps(self, axes: Axes) -> None:
        """Stops the spoolers after the command being executed; entries stay."""
        self._mcu.sstps(self._indices(axes))

    @command("4.4.115")
    def sdels(self, axes: Axes) -> None:
        """Deletes the entries of the spoolers; the command being executed is completed."""
        self._mcu.sdels(self._indices(axes))

    @command("4.4.84", "bytes")
    def rdlsm(self, axis: AxisId) -> int:
        """Free spool memory."""
        return int(self._axis(axis)["lsm"])

    @command("4.4.87", manual="rdMCiS")
    def rdmcis(self, axis: AxisId) -> int:
        """Motion commands waiting in the spooler."""
        return int(self._axis(axis)["mcis"])

    @command("4.4.7", manual="ClearCI99")
    def clearci99(self) -> None:
        """CI99 := 0 in step with the system: axes that wait for it (ssf 1005, 1015) go on together."""
        self._mcu.clearci99()
