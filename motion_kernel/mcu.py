"""The PCAP commands (chapter 4.4) on the emulated controller.

Positions in mm or degrees (PU), velocities in PU/s, accelerations in PU/s², times in s unless said otherwise.
Axes are given by name or index. Emulated time moves only in `advance`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Protocol

from cnc_front._native import motion_kernel as native
from motion_kernel.machine import Machine
from motion_kernel.registers import Axst, ErrorReg, ModeReg

AxisId = str | int
Axes = AxisId | Iterable[AxisId]


class CommandRefused(Exception):
    """A motion or spool command for an axis in open loop: no motion, axst dhef, ErrorReg bit 9 (design D11)."""


class TaskStatus(NamedTuple):
    """CNCTS (4.3.2.10): error number and its line, state bits, source line being executed."""

    errnum: int
    errline: int
    running: int
    csrcline: int


class Program(Protocol):
    """A compiled program with its autocode (gcode.Program)."""

    @property
    def native(self) -> Any:
        """The compiled program of cnc_front._native."""


class Mcu:
    """A controller after boot: loops open, MODEREG and TROVRST 0. Not safe across threads."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self._mcu = native.Mcu(machine.native)
        self._names = {name: index for index, name in enumerate(machine.axis_names)}
        self._trace: native.Chunk | None = None

    # ---- time and what it recorded

    def advance(self, samples: int) -> None:
        """Lets that many sample intervals pass, whatever happens in them, and records them in `trace`."""
        self._trace = self._mcu.pass_time(samples)

    @property
    def trace(self) -> native.Chunk:
        """Columns of the last `advance` as NumPy arrays without a copy: dp, load, rp (samples, axes), line, entry,
        v_plan, factor, flags (samples). Row k is the state at the end of sample first_sample + k."""
        if self._trace is None:
            raise RuntimeError("nothing is recorded before the first advance")
        return self._trace

    @property
    def samples(self) -> int:
        """Sample intervals since boot."""
        return self._mcu.samples()

    def events(self) -> list[tuple[int, str, int, str, bool, int, int]]:
        """What happened since the last call: (sample, kind, axis or task, name, on, line, value)."""
        return self._mcu.events()

    # ---- spooled motion (4.4.35 to 4.4.38 with the spooler, chapter 6.6)

    def smla(self, targets: Mapping[AxisId, float], *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """Spools a straight line to absolute targets. `ac` path acceleration, `vl` path velocity, `tvl` velocity
        at its end. False if it was discarded or the spooler is full: the reason stands in ErrorReg."""
        return self._line("smla", targets, ac, vl, tvl)

    def smlr(self, distances: Mapping[AxisId, float], *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """As smla, by distances from the end of what is spooled."""
        return self._line("smlr", distances, ac, vl, tvl)

    def smca(self, center: Mapping[AxisId, float], phi: float, *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """Spools a circle with the two axes of `center` (absolute); `phi` in degrees, counter-clockwise positive."""
        return self._arc("smca", center, {}, phi, ac, vl, tvl)

    def smcr(self, center: Mapping[AxisId, float], phi: float, *, ac: float, vl: float, tvl: float = 0.0) -> bool:
        """As smca, the centre relative to the start of the circle."""
        return self._arc("smcr", center, {}, phi, ac, vl, tvl)

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
        return self._arc("smha", center, targets, phi, ac, vl, tvl)

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
        return self._arc("smhr", center, distances, phi, ac, vl, tvl)

    def ssf(self, axis: AxisId, command: int, value: float) -> bool:
        """Spools a special function of chapter 4.4.123 for one axis. False if it was discarded (ErrorReg).
        Times of waits in units of 64 us."""
        return self._entered(self._mcu.ssf(self._index(axis), command, value), f"ssf {command}")

    def ssms(self, axes: Axes) -> None:
        """Starts the spoolers of these axes at once (4.4.120)."""
        self._mcu.ssms(self._indices(axes))

    def sstps(self, axes: Axes) -> None:
        """Stops the spoolers after the command being executed; entries stay (4.4.121)."""
        self._mcu.sstps(self._indices(axes))

    def sdels(self, axes: Axes) -> None:
        """Deletes the entries of the spoolers (4.4.115)."""
        self._mcu.sdels(self._indices(axes))

    def rdlsm(self, axis: AxisId) -> int:
        """Free spool memory, bytes (4.4.84)."""
        return int(self._axis(axis)["lsm"])

    def rdmcis(self, axis: AxisId) -> int:
        """Motion commands waiting in the spooler (4.4.87)."""
        return int(self._axis(axis)["mcis"])

    # ---- stopping, loops

    def ms(self, axes: Axes) -> None:
        """Motion stop: brakes along the contour, the rest is discarded (4.4.39)."""
        self._mcu.ms(self._indices(axes))

    def js(self, axes: Axes) -> None:
        """Jog stop: each axis brakes on its own with sdec (4.4.24)."""
        self._mcu.js(self._indices(axes))

    def cl(self, axes: Axes) -> None:
        """Closes the loops; the actual position becomes the set point (4.4.8)."""
        self._mcu.cl(self._indices(axes))

    def ol(self, axes: Axes) -> None:
        """Opens the loops (4.4.41)."""
        self._mcu.ol(self._indices(axes))

    def rs(self) -> None:
        """Resets the system: loops open, spoolers and tasks stopped; MODEREG and ErrorReg stay (4.4.113)."""
        self._mcu.rs()

    # ---- override

    def wrtrovr(self, factor: float) -> None:
        """Buffers the trajectory override, above 0 (4.4.174); `utrovr` takes it over. ValueError otherwise."""
        if not self._mcu.wrtrovr(factor):
            raise ValueError(f"override {factor}: must be above 0")

    def rdtrovr(self) -> float:
        """The buffered trajectory override (4.4.106)."""
        return self._mcu.read_registers()[0]

    def utrovr(self, axes: Axes) -> None:
        """Takes the override over for these axes, ramped with TROVRST (4.4.132)."""
        self._mcu.utrovr(self._indices(axes))

    def wrtrovrst(self, seconds: float) -> None:
        """Time for an override change of 1.0 (4.4.175)."""
        self._mcu.wrtrovrst(seconds)

    def rdtrovrst(self) -> float:
        """Time for an override change of 1.0 (4.4.107)."""
        return self._mcu.read_registers()[1]

    def wrjovr(self, axis: AxisId, factor: float) -> None:
        """The jog override of an axis, at once; during an interpolation it breaks the path (4.4.152)."""
        if not self._mcu.wrjovr(self._index(axis), factor):
            raise ValueError(f"override {factor}: must be above 0")

    def rdjovr(self, axis: AxisId) -> float:
        """The jog override of an axis."""
        return float(self._axis(axis)["jovr"])

    # ---- positions and status

    def rdrp(self, axis: AxisId) -> float:
        """Real position: whole encoder counts (4.4.95)."""
        return float(self._axis(axis)["rp"])

    def rddp(self, axis: AxisId) -> float:
        """Desired position (4.4.56)."""
        return float(self._axis(axis)["dp"])

    def rddv(self, axis: AxisId) -> float:
        """Desired velocity (4.4.59)."""
        return float(self._axis(axis)["dv"])

    def rdtp(self, axis: AxisId) -> float:
        """Target position of the command being executed (4.4.103)."""
        return float(self._axis(axis)["target"])

    def rdPosErr(self, axis: AxisId) -> float:
        """Position error: desired minus real position (4.4.93)."""
        values = self._axis(axis)
        return float(values["dp"] - values["rp"])

    def rddigo(self, axis: AxisId) -> int:
        """Digital outputs of an axis, bit 0 = output 1 (4.4.54)."""
        return int(self._axis(axis)["digo"])

    def set_inputs(self, digi: int) -> None:
        """The world outside: digital inputs, bit 0 = input 1."""
        self._mcu.set_inputs(digi)

    def rdaxst(self, axis: AxisId) -> Axst:
        """Axis status (4.4.45)."""
        return Axst(self._mcu.rdaxst(self._index(axis)))

    def rderrorreg(self) -> ErrorReg:
        """System errors, sticky (4.4.63)."""
        return ErrorReg(self._mcu.rderrorreg())

    def wrerrorreg(self) -> None:
        """Clears the error register: 0 is the only value that may be written (6.3.1.3)."""
        self._mcu.clear_errorreg()

    def rdmodereg(self) -> ModeReg:
        """MODEREG (4.4.90)."""
        return ModeReg(self._mcu.rdmodereg())

    def wrmodereg(self, value: int) -> None:
        """MODEREG (4.4.164), e.g. ModeReg.of("LookAhead", "ChkMaxVel")."""
        self._mcu.wrmodereg(value)

    def rdqualifier(self, axis: AxisId, name: str) -> float:
        """An axis qualifier by its name: mdvel, maxvel, maxacc, jerkrel, sdec, mpe, ipw (0 = not watched)."""
        return self._mcu.read_qualifier(self._index(axis), name)

    def wrqualifier(self, axis: AxisId, name: str, value: float) -> None:
        """Writes an axis qualifier (4.4.160 to 4.4.165). ValueError below 0 or for an unknown name."""
        self._mcu.write_qualifier(self._index(axis), name, value)

    def rdtrac(self) -> float:
        """Trajectory acceleration TRAC, for `ms` with MS_DECEL (4.4.105)."""
        return self._mcu.read_registers()[2]

    def wrtrac(self, value: float) -> None:
        """Trajectory acceleration TRAC (4.4.173). ValueError below 0."""
        self._mcu.write_trac(value)

    def rdnfrax(self) -> list[str]:
        """Axes that do not count for the path velocity (4.4.92)."""
        return [self.machine.axis_names[a] for a in self._mcu.read_registers()[3]]

    def wrnfrax(self, axes: Axes) -> None:
        """Axes that do not count for the path velocity (4.4.166)."""
        self._mcu.write_nfrax(self._indices(axes))

    # ---- common variables and CNC tasks

    def rdci(self, number: int) -> int:
        """Common integer 0..999 (4.4.49). IndexError outside."""
        return self._mcu.rdci(number)

    def wrci(self, number: int, value: int) -> None:
        """Common integer 0..999 (4.4.136)."""
        self._mcu.wrci(number, value)

    def rdcd(self, number: int) -> float:
        """Common double 0..999 (4.4.48)."""
        return self._mcu.rdcd(number)

    def wrcd(self, number: int, value: float) -> None:
        """Common double 0..999 (4.4.135)."""
        self._mcu.wrcd(number, value)

    def ClearCI99(self) -> None:
        """CI99 := 0 in step with the system: axes that wait for it go on together (4.4.7)."""
        self._mcu.clearci99()

    def load(self, task: int, program: Program) -> None:
        """Loads a compiled program into a CNC task 0..3 (txbf2, 4.4.129)."""
        self._mcu.load(task, program.native)

    def startcnct(self, task: int) -> None:
        """Starts a CNC task from its beginning (4.4.124)."""
        self._mcu.startcnct(task)

    def stopcnct(self, task: int) -> None:
        """Stops a CNC task where it is (4.4.126)."""
        self._mcu.stopcnct(task)

    def contcnct(self, task: int) -> None:
        """Continues a stopped or stepped CNC task (4.4.10)."""
        self._mcu.contcnct(task)

    def stepcnct(self, task: int) -> None:
        """Executes one source line of a CNC task (4.4.125)."""
        self._mcu.stepcnct(task)

    def rdcncts(self, task: int) -> TaskStatus:
        """Status of a CNC task (4.4.50)."""
        return TaskStatus(*self._mcu.rdcncts(task))

    # ---- the application's side of a G-code run

    def prepare_gcode(self) -> None:
        """MODEREG, TROVRST, closed loops and references as at the start of a part program (design D19)."""
        self._mcu.prepare_gcode()

    def hold(self) -> None:
        """Operator's feed hold along the path (design D5)."""
        self._mcu.hold()

    def resume(self) -> None:
        """Goes on after a hold."""
        self._mcu.resume()

    # ---- inside

    def _index(self, axis: AxisId) -> int:
        if isinstance(axis, str):
            if axis not in self._names:
                raise KeyError(f"the machine has no axis {axis}; it has {', '.join(self._names)}")
            return self._names[axis]
        if not 0 <= axis < len(self._names):
            raise IndexError(f"the machine has no axis {axis}; it has 0 to {len(self._names) - 1}")
        return axis

    def _indices(self, axes: Axes) -> list[int]:
        return [self._index(axes)] if isinstance(axes, str | int) else [self._index(axis) for axis in axes]

    def _axis(self, axis: AxisId) -> dict[str, Any]:
        return self._mcu.read_axis(self._index(axis))

    def _line(self, kind: str, targets: Mapping[AxisId, float], ac: float, vl: float, tvl: float) -> bool:
        axes = [self._index(axis) for axis in targets]
        outcome = self._mcu.spool(kind, axes, [float(x) for x in targets.values()], vl, ac, tvl, 0.0, (0.0, 0.0))
        return self._entered(outcome, kind)

    def _arc(
        self,
        kind: str,
        center: Mapping[AxisId, float],
        targets: Mapping[AxisId, float],
        phi: float,
        ac: float,
        vl: float,
        tvl: float,
    ) -> bool:
        if len(center) != 2:
            raise ValueError(f"{kind}: a circle has a centre in two axes, {len(center)} given")
        plane = [self._index(axis) for axis in center]
        ends = {self._index(axis): float(x) for axis, x in targets.items()}
        if ends.keys() & set(plane) != set(plane) and kind in ("smha", "smhr") and abs(phi) <= 1e-100:
            raise ValueError(f"{kind}: without an angle the targets of both circle axes are needed")
        axes = plane + [axis for axis in ends if axis not in plane]
        first, second = (float(x) for x in center.values())
        goals = [ends.get(axis, 0.0) for axis in axes]
        return self._entered(self._mcu.spool(kind, axes, goals, vl, ac, tvl, phi, (first, second)), kind)

    def _entered(self, outcome: str, command: str) -> bool:
        if outcome == "refused":
            raise CommandRefused(f"{command}: an axis is in open loop; close it with cl")
        return outcome == "entered"
