"""PCAP commands that read and write the values of one axis, in its own units: mm or degrees, s.

Writers raise ValueError for a value that is not allowed; the one before it stays."""

from __future__ import annotations

from dataclasses import fields

from motion_kernel.commands import command
from motion_kernel.driver import Axes, AxisId, Driver
from motion_kernel.structures import TSRP, Filter

POSITION = "axis position unit"
VELOCITY = "axis velocity unit"
ACCELERATION = "axis acceleration unit"
DISPLAY = "display unit of the axis"


class Positions(Driver):
    """Set point, encoder, target; virtual zero points."""

    @command("4.4.95", POSITION)
    def rdrp(self, axis: AxisId) -> float:
        """Real position: whole encoder counts, a new value each sample."""
        return self._read(axis, "rp")

    @command("4.4.96", DISPLAY)
    def rdrpd(self, axis: AxisId) -> float:
        """Real position in the display unit of the machine file."""
        return self._read(axis, "rpd")

    @command("4.4.167", POSITION)
    def wrrp(self, axis: AxisId, rp: float) -> None:
        """Another coordinate for the present position: the machine zero moves, the axis is no longer referenced.
        CommandRefused in closed loop."""
        self._write_in_state(axis, "rp", rp, "in open loop")

    @command("4.4.56", POSITION)
    def rddp(self, axis: AxisId) -> float:
        """Desired position, as the position loop sees it."""
        return self._read(axis, "dp")

    @command("4.4.58", DISPLAY)
    def rddpd(self, axis: AxisId) -> float:
        """Desired position in the display unit of the machine file."""
        return self._read(axis, "dpd")

    @command("4.4.140", POSITION)
    def wrdp(self, axis: AxisId, dp: float) -> None:
        """Desired position without a profile: the drive follows as fast as it can. CommandRefused in open loop."""
        self._write_in_state(axis, "dp", dp, "in closed loop")

    @command("4.4.103", POSITION)
    def rdtp(self, axis: AxisId) -> float:
        """Target position of the last travel command, always absolute."""
        return self._read(axis, "tp")

    @command("4.4.104", DISPLAY)
    def rdtpd(self, axis: AxisId) -> float:
        """Target position in the display unit of the machine file, always absolute."""
        return self._read(axis, "tpd")

    @command("4.4.172", POSITION)
    def wrtp(self, axis: AxisId, tp: float) -> None:
        """Writes the target position. CommandRefused while the axis travels."""
        self._write_in_state(axis, "tp", tp, "while it does not travel")

    @command("4.4.93", POSITION, manual="rdPosErr")
    def rdposerr(self, axis: AxisId) -> float:
        """Following error: desired minus real position. Only read."""
        return self._read(axis, "poserr")

    @command("4.4.59", VELOCITY)
    def rddv(self, axis: AxisId) -> float:
        """Desired velocity of the profile generator. Only travel commands change it."""
        return self._read(axis, "dv")

    @command("4.4.97", VELOCITY)
    def rdrv(self, axis: AxisId) -> float:
        """Actual velocity, what the encoder counted in the last sample; also in open loop. Only read."""
        return self._read(axis, "rv")

    @command("4.4.112", manual="RPtoDP")
    def rptodp(self, axes: Axes) -> None:
        """The actual positions become the desired ones, at once; a running profile replaces them again."""
        self._mcu.rptodp(self._indices(axes))

    @command("4.4.57", POSITION)
    def rddpoffset(self, axis: AxisId) -> float:
        """Offset of the set point of the position loop, as last written. PcapError without a system on the card."""
        return self._read(axis, "dpoffset")

    @command("4.4.141", POSITION, returns_status=True)
    def wrdpoffset(self, axis: AxisId, dpoffset: float) -> int:
        """Offset of the set point of the position loop: a step, or with dvoffset a ramp. Returns 0, or 1."""
        return self._set_axis(axis, "dpoffset", dpoffset)

    @command("4.4.60", VELOCITY)
    def rddvoffset(self, axis: AxisId) -> float:
        """Rate at which dpoffset takes effect; 0 = at once. PcapError without a system on the card."""
        return self._read(axis, "dvoffset")

    @command("4.4.142", VELOCITY, returns_status=True)
    def wrdvoffset(self, axis: AxisId, dvoffset: float) -> int:
        """Rate at which dpoffset takes effect; 0 = at once. Returns 0, or 1 if the value is not allowed."""
        return self._set_axis(axis, "dvoffset", dvoffset)

    @command("4.4.3")
    def azo(self, number: int) -> None:
        """Activates one of five sets of zero offsets (machine file, `zero_offsets`) for all axes; above 4: none."""
        self._mcu.azo(number)

    @command("4.4.127", POSITION)
    def szpa(self, axis: AxisId, position: float) -> None:
        """Virtual zero point at a position of the machine; 0 takes it back. Nothing moves. Not while commands are
        being spooled."""
        self._zero(axis, position, relative=False)

    @command("4.4.128", POSITION)
    def szpr(self, axis: AxisId, distance: float) -> None:
        """Shifts the virtual zero point."""
        self._zero(axis, distance, relative=True)

    @command("4.4.110", POSITION, manual="rdZeroOffset")
    def rdzerooffset(self, axis: AxisId) -> float:
        """The zero offset in force, a signed total. PcapError without a system on the card."""
        return self._read(axis, "zerooffset")

    def _zero(self, axis: AxisId, position: float, *, relative: bool) -> None:
        if not self._mcu.set_zero(self._index(axis), position, relative):
            raise ValueError(f"zero point {position}: must be a finite number")


class Parameters(Driver):
    """Parameters of jogs, look-ahead and monitoring. Defaults come from the machine file."""

    @command("4.4.75", ACCELERATION)
    def rdjac(self, axis: AxisId) -> float:
        """Jog acceleration, as last written."""
        return self._read(axis, "jac")

    @command("4.4.150", ACCELERATION)
    def wrjac(self, axis: AxisId, jac: float) -> None:
        """Jog acceleration: positive for both ramps, then negative for the braking ramp alone; not 0."""
        self._write(axis, "jac", jac, "other than 0")

    @command("4.4.78", VELOCITY)
    def rdjvl(self, axis: AxisId) -> float:
        """Jog velocity."""
        return self._read(axis, "jvl")

    @command("4.4.154", VELOCITY)
    def wrjvl(self, axis: AxisId, jvl: float) -> None:
        """Jog velocity; negative: an endless profile away from the target (2.2.4)."""
        self._write(axis, "jvl", jvl)

    @command("4.4.77", VELOCITY)
    def rdjtvl(self, axis: AxisId) -> float:
        """Jog target velocity."""
        return self._read(axis, "jtvl")

    @command("4.4.153", VELOCITY)
    def wrjtvl(self, axis: AxisId, jtvl: float) -> None:
        """Jog target velocity, of either sign."""
        self._write(axis, "jtvl", jtvl)

    @command("4.4.152", "factor")
    def rdjovr(self, axis: AxisId) -> float:
        """Jog override. Without OvrMode it follows the trajectory override, also while that ramps."""
        return self._read(axis, "jovr")

    @command("4.4.152", "factor")
    def wrjovr(self, axis: AxisId, jovr: float) -> None:
        """Jog override, at once; during an interpolation it breaks the path. Above 0."""
        self._write(axis, "jovr", jovr, "above 0")

    @command("4.4.99", ACCELERATION)
    def rdsdec(self, axis: AxisId) -> float:
        """Stop deceleration of js and of software limits with SMD."""
        return self._read(axis, "sdec")

    @command("4.4.168", ACCELERATION)
    def wrsdec(self, axis: AxisId, sdec: float) -> None:
        """Stop deceleration; 0 stops at once."""
        self._write(axis, "sdec", sdec, "of 0 or more")

    @command("4.4.76", "share 0..1", manual="rdJerkRel")
    def rdjerkrel(self, axis: AxisId) -> float:
        """Rounding of S ramps."""
        return self._read(axis, "jerkrel")

    @command("4.4.151", "share 0..1", manual="wrJerkRel")
    def wrjerkrel(self, axis: AxisId, jerkrel: float) -> None:
        """Rounding of S ramps; values outside 0..1 become 0 or 1."""
        self._write(axis, "jerkrel", jerkrel)

    @command("4.4.89", "PU/TU", manual="rdMDVel")
    def rdmdvel(self, axis: AxisId) -> float:
        """Largest velocity step at a corner, for the look-ahead; 0 = not watched."""
        return self._read(axis, "mdvel")

    @command("4.4.163", "PU/TU", manual="wrMDVel")
    def wrmdvel(self, axis: AxisId, mdvel: float) -> None:
        """Largest velocity step at a corner; 0 = not watched."""
        self._write(axis, "mdvel", mdvel, "of 0 or more")

    @command("4.4.86", "PU/TU", manual="rdMaxVel")
    def rdmaxvel(self, axis: AxisId) -> float:
        """Velocity limit of ChkMaxVel; 0 = not watched."""
        return self._read(axis, "maxvel")

    @command("4.4.161", "PU/TU", manual="wrMaxVel")
    def wrmaxvel(self, axis: AxisId, maxvel: float) -> None:
        """Velocity limit of ChkMaxVel; 0 = not watched."""
        self._write(axis, "maxvel", maxvel, "of 0 or more")

    @command("4.4.85", "PU/TU²", manual="rdMaxAcc")
    def rdmaxacc(self, axis: AxisId) -> float:
        """Acceleration limit of ChkMaxVel and of arcs; 0 = not watched."""
        return self._read(axis, "maxacc")

    @command("4.4.160", "PU/TU²", manual="wrMaxAcc")
    def wrmaxacc(self, axis: AxisId, maxacc: float) -> None:
        """Acceleration limit of ChkMaxVel and of arcs; 0 = not watched."""
        self._write(axis, "maxacc", maxacc, "of 0 or more")

    @command("4.4.61", "PU", manual="rdEffRadius")
    def rdeffradius(self, axis: AxisId) -> float:
        """Effective radius of a rotary axis; 0 for a linear one. mm where PU is no length."""
        return self._read(axis, "effradius")

    @command("4.4.143", "PU", manual="wrEffRadius")
    def wreffradius(self, axis: AxisId, radius: float) -> None:
        """Effective radius of a rotary axis, above 0. What is spooled already keeps its own."""
        self._write(axis, "effradius", radius, "above 0, of a rotary axis")

    @command("4.4.100", POSITION)
    def rdsll(self, axis: AxisId) -> float:
        """Left software limit, a position of the machine; -1e300 where there is none."""
        return self._read(axis, "sll")

    @command("4.4.169", POSITION)
    def wrsll(self, axis: AxisId, sll: float) -> None:
        """Left software limit; it counts once the axis is referenced."""
        self._write(axis, "sll", sll)

    @command("4.4.101", POSITION)
    def rdslr(self, axis: AxisId) -> float:
        """Right software limit, a position of the machine; 1e300 where there is none."""
        return self._read(axis, "slr")

    @command("4.4.170", POSITION)
    def wrslr(self, axis: AxisId, slr: float) -> None:
        """Right software limit; it counts once the axis is referenced."""
        self._write(axis, "slr", slr)

    @command("4.4.73", POSITION)
    def rdipw(self, axis: AxisId) -> float:
        """In-position window; 0 = not watched."""
        return self._read(axis, "ipw")

    @command("4.4.149", POSITION)
    def wripw(self, axis: AxisId, ipw: float) -> None:
        """In-position window; 0 = not watched."""
        self._write(axis, "ipw", ipw, "of 0 or more")

    @command("4.4.91", POSITION)
    def rdmpe(self, axis: AxisId) -> float:
        """Following error limit; 0 = not watched."""
        return self._read(axis, "mpe")

    @command("4.4.165", POSITION)
    def wrmpe(self, axis: AxisId, mpe: float) -> None:
        """Following error limit; 0 = not watched."""
        self._write(axis, "mpe", mpe, "of 0 or more")

    @command("4.4.102", "counts per revolution")
    def rdslsp(self, axis: AxisId) -> float:
        """Encoder counts or stepper pulses per motor revolution. PcapError without a system on the card."""
        return self._mcu.rdslsp(self._index(axis))

    @command("4.4.171", "counts per revolution")
    def wrslsp(self, axis: AxisId, slsp: float) -> None:
        """Encoder counts or stepper pulses per motor revolution, above 0. The motor stays, positions
        get other numbers."""
        self._write(axis, "slsp", slsp, "above 0")

    @command("4.4.66", "axis units per revolution")
    def rdgf(self, axis: AxisId) -> float:
        """Gear factor: what the axis travels in a motor revolution."""
        return self._read(axis, "gf")

    @command("4.4.145", "axis units per revolution")
    def wrgf(self, axis: AxisId, gf: float) -> None:
        """Gear factor, above 0. The motor stays; positions get other numbers, velocities and accelerations must be
        adapted by the application."""
        self._write(axis, "gf", gf, "above 0")

    @command("4.4.67", "steps per count", manual="rdgfaux")
    def rdgfaux(self, axis: AxisId) -> float:
        """Steps per encoder count of a stepper axis with encoder verification. PcapError without a system."""
        return self._read(axis, "gfaux")

    @command("4.4.146", "steps per count", returns_status=True)
    def wrgfaux(self, axis: AxisId, gfaux: float) -> int:
        """Steps per encoder count, not 0. Returns 0, or 1 if the value is not allowed."""
        return self._set_axis(axis, "gfaux", gfaux)

    @command("4.4.68", ACCELERATION)
    def rdhac(self, axis: AxisId) -> float:
        """Home acceleration."""
        return self._read(axis, "hac")

    @command("4.4.147", ACCELERATION)
    def wrhac(self, axis: AxisId, hac: float) -> None:
        """Home acceleration of all home commands, above 0."""
        self._write(axis, "hac", hac, "above 0")

    @command("4.4.69", VELOCITY)
    def rdhvl(self, axis: AxisId) -> float:
        """Home velocity."""
        return self._read(axis, "hvl")

    @command("4.4.148", VELOCITY)
    def wrhvl(self, axis: AxisId, hvl: float) -> None:
        """Home velocity of all home commands, above 0."""
        self._write(axis, "hvl", hvl, "above 0")

    @command("4.4.44", "stepper with encoder: counts")
    def rdaux(self, axis: AxisId) -> float:
        """Auxiliary register: counts of the encoder of a stepper axis that has one, else what was written last."""
        return self._read(axis, "aux")

    @command("4.4.133")
    def wraux(self, axis: AxisId, aux: float) -> None:
        """Auxiliary register."""
        self._write(axis, "aux", aux)


class Loops(Driver):
    """Position loops and motor commands; all values of an axis at once."""

    @command("4.4.8")
    def cl(self, axes: Axes) -> None:
        """Closes the loops; the actual positions become the set points, spoolers are emptied."""
        self._mcu.cl(self._indices(axes))

    @command("4.4.9")
    def clv(self, axes: Axes) -> None:
        """Closes the loops of axes that may be moving: actual positions and velocities become the desired ones."""
        self._mcu.clv(self._indices(axes))

    @command("4.4.41")
    def ol(self, axes: Axes) -> None:
        """Opens the loops: 0 on the motor command ports."""
        self._mcu.ol(self._indices(axes))

    @command("4.4.42")
    def ra(self, axes: Axes) -> None:
        """Resets axes: profiles and spoolers discarded, loops open, positions 0, effective overrides 1.0."""
        self._mcu.ra(self._indices(axes))

    @command("4.4.113")
    def rs(self) -> None:
        """Resets the system: loops open, spoolers emptied, tasks stopped, overrides 1.0. Common variables, system
        data, MODEREG, ErrorReg and ifs stay."""
        emulator = self._mcu
        self._card.read_environment()
        emulator.rs()

    @command("4.4.64", "digits, counts, s")
    def rdf(self, axis: AxisId) -> Filter:
        """Coefficients of the PIDF filter."""
        kp, ki, kd, kpl, kfcv, kfca = self._mcu.rdf(self._index(axis))
        return Filter(kp=kp, ki=ki, kd=kd, kpl=kpl, kfca=kfca, kfcv=kfcv)

    @command("4.4.131", "digits, counts, s")
    def uf(
        self, axis: AxisId, *, kp: float, ki: float, kd: float, kpl: float = 0.0, kfca: float = 0.0, kfcv: float = 0.0
    ) -> None:
        """Sets all coefficients of the PIDF filter together, at any time. ValueError unless finite, kpl in 0..1."""
        if not self._mcu.uf(self._index(axis), (kp, ki, kd, kpl, kfcv, kfca)):
            raise ValueError("uf: coefficients must be finite numbers, kpl from 0 to 1")

    @command("4.4.88", "digits, stepper: delay")
    def rdmcp(self, axis: AxisId) -> int:
        """Motor command port: digits of a servo axis (32767 = 10 V), delay of the pulses of a stepper."""
        return int(self._read(axis, "mcp"))

    @command("4.4.162", "digits, stepper: delay")
    def wrmcp(self, axis: AxisId, mcp: int) -> None:
        """Writes the motor command port, clamped to its range: moves the axis in open loop."""
        self._mcu.wrmcp(self._index(axis), max(-(2**31), min(mcp, 2**31 - 1)))

    @command("4.4.43", "axis units")
    def rdap(self, axis: AxisId) -> TSRP:
        """All values of an axis at once."""
        index = self._index(axis)
        tsrp = TSRP(an=index, **self.rdf(axis)._asdict())
        tsrp.axst, tsrp.lsm, tsrp.mcp = self._mcu.rdaxst(index), self._axis(axis)["lsm"], self.rdmcp(axis)
        tsrp.digi, tsrp.digo, tsrp.ifs = self._mcu.rddigi(index), self._mcu.rddigo(), self._mcu.rdifs()
        tsrp.epc = self._mcu.epc()
        for value in fields(TSRP):
            if value.type == "float" and value.name not in Filter._fields:
                setattr(tsrp, value.name, self._read(axis, value.name))
        return tsrp

    @command("4.4.62", "cycles")
    def rdepc(self, axis: AxisId) -> int:
        """Times that the EEPROM of the card was programmed: each time that mcfg saves (`program_eeprom`)."""
        self._index(axis)
        return self._mcu.epc()
