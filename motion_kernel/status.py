"""PCAP commands for status words, inputs, outputs, LEDs and the interrupt of the PC."""

from __future__ import annotations

from collections.abc import Sequence

from cnc_front._native import motion_kernel as native
from motion_kernel.commands import CommandRefused, command
from motion_kernel.driver import AxisId, Driver, InterruptRoutine
from motion_kernel.machine import Diagnostic, MachineError
from motion_kernel.registers import Axst, ControllerFlags, Digi, ErrorReg, Ifs, ModeReg

AXIS_FAULTS = ("cut_encoder", "drop_drive", "block")
CARD_FAULTS = ("undervoltage", "bus_error")
FIELD = 15  # controller parameters of an axis: 15 x 15


class Status(Driver):
    """Status words of axes and controller. Single bits are numbered from 1, those of the words from 0."""

    @command("4.4.45")
    def rdaxst(self, axis: AxisId) -> Axst:
        """Axis status."""
        return Axst(self._mcu.rdaxst(self._index(axis)))

    @command("4.4.46")
    def rdaxstb(self, axis: AxisId, bitnr: int) -> int:
        """One bit of the axis status; `bitnr` counts from 1: pe is 13."""
        return bit(self._mcu.rdaxst(self._index(axis)), bitnr)

    @command("4.4.63", manual="rdErrorReg")
    def rderrorreg(self) -> ErrorReg:
        """System errors, sticky."""
        return ErrorReg(self._mcu.rderrorreg())

    def wrerrorreg(self) -> None:
        """Clears the error register: 0 is the only value that may be written (6.3.1.3)."""
        self._mcu.clear_errorreg()

    @command("4.4.90", manual="rdModeReg")
    def rdmodereg(self) -> ModeReg:
        """MODEREG."""
        return ModeReg(self._mcu.rdmodereg())

    @command("4.4.164", manual="wrModeReg")
    def wrmodereg(self, value: int) -> None:
        """MODEREG, e.g. ModeReg.of("LookAhead", "ChkMaxVel")."""
        self._mcu.wrmodereg(value)

    @command("4.4.51", manual="rdControllerFlags")
    def rdcontrollerflags(self, axis: AxisId) -> ControllerFlags:
        """Options of the position loop."""
        return ControllerFlags(self._mcu.rdcontrollerflags(self._index(axis)))

    @command("4.4.137", manual="wrControllerFlags")
    def wrcontrollerflags(self, axis: AxisId, flags: int) -> None:
        """Options of the position loop, e.g. ControllerFlags.of("MoveControl", "MoveFix")."""
        self._mcu.wrcontrollerflags(self._index(axis), flags)

    @command("4.4.52")
    def rddigi(self, axis: AxisId = 0) -> Digi:
        """Digital inputs after inversion, bit n-1 = input n of the board, whatever the axis; bits 16 to 23 are signals
        of the axis (index, strobe, encoder alarms)."""
        return Digi(self._mcu.rddigi(self._index(axis)))

    @command("4.4.72")
    def rdigi(self, axis: AxisId) -> None:
        """Clears the stored bits 17 to 19 of the digi word of an axis."""
        self._mcu.rdigi(self._index(axis))

    @command("4.4.53")
    def rddigib(self, axis: AxisId, bitnr: int) -> int:
        """One bit of rddigi; `bitnr` counts from 1."""
        return bit(self.rddigi(axis), bitnr)

    @command("4.4.54")
    def rddigo(self, axis: AxisId = 0) -> int:
        """Digital outputs, bit n-1 = output n; the same for all axes."""
        self._index(axis)
        return self._mcu.rddigo()

    @command("4.4.138")
    def wrdigo(self, axis: AxisId, digo: int) -> None:
        """Sets all digital outputs, bit n-1 = output n of 8; the same for all axes."""
        self._mcu.wrdigo(self._index(axis), digo & 0xFFFFFFFF)

    @command("4.4.55")
    def rddigob(self, axis: AxisId, bitnr: int) -> int:
        """One digital output; `bitnr` counts from 1."""
        return bit(self.rddigo(axis), bitnr)

    @command("4.4.139")
    def wrdigob(self, axis: AxisId, bitnr: int, value: int) -> None:
        """Sets (1) or resets (0) one digital output; `bitnr` counts from 1, above 8 it does nothing."""
        if 1 <= bitnr <= 32:
            self._mcu.wrdigob(self._index(axis), bitnr, bool(value))

    @command("4.4.70")
    def rdifs(self, axis: AxisId = 0) -> Ifs:
        """Interface status of the card. PcapError without a system on it."""
        self._index(axis)
        return Ifs(self._mcu.rdifs())

    @command("4.4.71")
    def rdifsb(self, axis: AxisId, bitnr: int) -> int:
        """One bit of the interface status; `bitnr` counts from 1: edv is 1."""
        return bit(self.rdifs(axis), bitnr)

    @command("4.4.111")
    def rifs(self, axis: AxisId = 0) -> None:
        """Clears the error flags 16 to 20 of the interface status."""
        self._index(axis)
        self._mcu.rifs()

    def set_inputs(self, digi: int) -> None:
        """The world outside: levels of the digital inputs, bit n-1 = input n."""
        self._mcu.set_inputs(digi)

    def play(self, fault: str, axis: AxisId | None = None, *, on: bool = True, deep: bool = False) -> None:
        """The world outside: a fault. Of an axis, until it is played with `on` False: cut_encoder, drop_drive (its
        power and ready signal), block (its mechanics jam). Of the card: undervoltage (below 4.75 V, `deep`: below
        2.85 V), bus_error. ValueError for others."""
        if fault not in AXIS_FAULTS + CARD_FAULTS:
            raise ValueError(f"no fault {fault}; there are {', '.join(AXIS_FAULTS + CARD_FAULTS)}")
        if axis is None and fault in AXIS_FAULTS:
            raise ValueError(f"{fault}: name the axis")
        self._mcu.play(fault, 0 if axis is None else self._index(axis), deep if fault in CARD_FAULTS else on)

    def add_stimulus(self, text: str) -> None:
        """The world outside: rules that switch inputs and play faults from now on, e.g. `when X > 100: X blocked`
        (docs/stimulus.md). MachineError with every finding of the text."""
        machine = self.machine.native
        try:
            stimulus = native.Stimulus.parse(text.encode(), "<stimulus>", machine)
        except native.MachineError as error:
            raise MachineError(tuple(Diagnostic(*row) for row in error.args[0])) from None
        self._mcu.add_stimulus(stimulus)


class CardRegisters(Driver):
    """LEDs, interrupt, and registers whose meaning belongs to applications."""

    @command("4.4.79")
    def rdledgn(self) -> int:
        """1 while the green LED is on, else 0."""
        return int(self._mcu.led("green"))

    @command("4.4.155")
    def wrledgn(self, value: int) -> None:
        """Switches the green LED on (1) or off (0)."""
        self._mcu.set_led("green", bool(value))

    @command("4.4.80")
    def rdledrd(self) -> int:
        """1 while the red LED is on, else 0."""
        return int(self._mcu.led("red"))

    @command("4.4.156")
    def wrledrd(self, value: int) -> None:
        """Switches the red LED on (1) or off (0)."""
        self._mcu.set_led("red", bool(value))

    @command("4.4.81")
    def rdledyl(self) -> int:
        """1 while the yellow LED is on, else 0."""
        return int(self._mcu.led("yellow"))

    @command("4.4.157")
    def wrledyl(self, value: int) -> None:
        """Switches the yellow LED on (1) or off (0)."""
        self._mcu.set_led("yellow", bool(value))

    @command("4.4.74")
    def rdirqpc(self) -> int:
        """1 while the interrupt of the PC is active (ssf 1101, system variable IRQPC), else 0."""
        return int(self._mcu.irqpc())

    def wrirqpc(self, value: int) -> None:
        """System variable IRQPC (6.3.1.1): 1 raises the interrupt of the PC, 0 ends it. rw_SymPas programs write it."""
        raised = self._mcu.interrupts()
        self._mcu.set_irqpc(bool(value))
        if self._card.routine is not None and self._mcu.interrupts() != raised:
            self._card.routine(1)

    @command("4.4.33", manual="MCUG3_SetBoardIntRoutine")
    def mcug3_setboardintroutine(self, routine: InterruptRoutine) -> int:
        """Calls `routine` with the interrupt lines (1) behind each sample in which the card raises its interrupt. The
        routine may use all commands and cannot let time pass."""
        self._card.routine = routine
        return 0

    @command("4.4.34", manual="MCUG3_ResetBoardIntRoutine")
    def mcug3_resetboardintroutine(self) -> int:
        """The interrupt routine is called no more."""
        self._card.routine = None
        return 0

    def program_eeprom(self) -> None:
        """What mcfg does when it saves system data: one more programming cycle of the EEPROM (`rdepc`)."""
        self._mcu.program_eeprom()

    @command("4.4.65", manual="rdGCR")
    def rdgcr(self, axis: AxisId) -> int:
        """Gear configuration register (resource interface)."""
        return self._mcu.gcr(self._index(axis))

    @command("4.4.144", manual="wrGCR")
    def wrgcr(self, axis: AxisId, value: int) -> None:
        """Gear configuration register, 32 bits: slaves follow set points (1), actual positions (2), or nothing (0); -1
        clears what they have followed. CommandRefused: 1 in open loop, -1 while an axis has a gcr other than 0."""
        if not self._mcu.set_gcr(self._index(axis), value):
            raise CommandRefused(f"gcr {value} of axis {axis}: 1 needs a closed loop, -1 needs gcr 0 at all axes")

    @command("4.4.114")
    def scp(self, axis: AxisId, parameters: Sequence[Sequence[float]]) -> None:
        """Sends 15 x 15 controller parameters of customer extensions; the base system stores them. ValueError for
        another shape."""
        values = [float(x) for row in parameters for x in row]
        if len(parameters) != FIELD or any(len(row) != FIELD for row in parameters):
            raise ValueError(f"scp: {FIELD} rows of {FIELD} numbers")
        self._mcu.set_controller_parameters(self._index(axis), values)

    def controller_parameters(self, axis: AxisId) -> list[list[float]]:
        """What `scp` sent last."""
        values = self._mcu.controller_parameters(self._index(axis))
        return [values[n : n + FIELD] for n in range(0, FIELD * FIELD, FIELD)]

    @command("2.5.1", manual="rdSysVarInt", row="appvar.sys.pcap-int")
    def rdsysvarint(self, index: int) -> int:
        """Integer application variable of the system, 0 to 99. IndexError outside."""
        return self._mcu.variable_int(None, index)

    @command("2.5.1", manual="wrSysVarInt", row="appvar.sys.pcap-int")
    def wrsysvarint(self, index: int, value: int) -> None:
        """Integer application variable of the system, 32 bits."""
        self._mcu.set_variable_int(None, index, value)

    @command("2.5.1", manual="rdSysVarDbl", row="appvar.sys.pcap-dbl")
    def rdsysvardbl(self, index: int) -> float:
        """Floating-point application variable of the system, 0 to 99."""
        return self._mcu.variable_dbl(None, index)

    @command("2.5.1", manual="wrSysVarDbl", row="appvar.sys.pcap-dbl")
    def wrsysvardbl(self, index: int, value: float) -> None:
        """Floating-point application variable of the system."""
        self._mcu.set_variable_dbl(None, index, value)

    @command("2.5.2", manual="rdAxVarInt", row="appvar.axis.pcap-int")
    def rdaxvarint(self, axis: AxisId, index: int) -> int:
        """Integer application variable of an axis, 0 to 99."""
        return self._mcu.variable_int(self._index(axis), index)

    @command("2.5.2", manual="wrAxVarInt", row="appvar.axis.pcap-int")
    def wraxvarint(self, axis: AxisId, index: int, value: int) -> None:
        """Integer application variable of an axis, 32 bits."""
        self._mcu.set_variable_int(self._index(axis), index, value)

    @command("2.5.2", manual="rdAxVarDbl", row="appvar.axis.pcap-dbl")
    def rdaxvardbl(self, axis: AxisId, index: int) -> float:
        """Floating-point application variable of an axis, 0 to 99."""
        return self._mcu.variable_dbl(self._index(axis), index)

    @command("2.5.2", manual="wrAxVarDbl", row="appvar.axis.pcap-dbl")
    def wraxvardbl(self, axis: AxisId, index: int, value: float) -> None:
        """Floating-point application variable of an axis."""
        self._mcu.set_variable_dbl(self._index(axis), index, value)


def bit(word: int, bitnr: int) -> int:
    """A bit of a word; `bitnr` counts from 1, outside 1..32 it is 0."""
    return word >> (bitnr - 1) & 1 if 1 <= bitnr <= 32 else 0
