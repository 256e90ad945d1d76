"""The emulated controller of the APCI-8001/8008 with the PCAP command set (chapter 4.4 of the manual).

>>> from motion_kernel import Machine, Mcu
>>> mcu = Mcu(Machine.builtin())
>>> mcu.cl(["X", "Y"])
>>> mcu.smla({"X": 10.0, "Y": 5.0}, ac=500.0, vl=20.0)
True
>>> mcu.ssms(["X", "Y"])
>>> mcu.advance(samples=2000)
>>> mcu.rdaxst("X").pe, round(mcu.rddp("X"), 4)
(True, 10.0)
"""

from __future__ import annotations

from motion_kernel.commands import CommandRefused, PcapError
from motion_kernel.machine import Diagnostic, Machine, MachineError
from motion_kernel.mcu import Mcu
from motion_kernel.registers import Axst, ControllerFlags, Digi, ErrorReg, Ifs, ModeReg, Register
from motion_kernel.structures import MAXAXIS, ROSI, TSRP, Filter, Initialised, TaskStatus

__all__ = [
    "MAXAXIS",
    "ROSI",
    "TSRP",
    "Axst",
    "CommandRefused",
    "ControllerFlags",
    "Diagnostic",
    "Digi",
    "ErrorReg",
    "Filter",
    "Ifs",
    "Initialised",
    "Machine",
    "MachineError",
    "Mcu",
    "ModeReg",
    "PcapError",
    "Register",
    "TaskStatus",
]
