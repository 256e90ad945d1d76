"""What only the application can find about a part program: whether the controller is ready for it, and what it said.

Ids and texts are those of the dialect page (docs/dialect.md, section 19): GC803, GC805, GC806 and GC809 before the
first entry is spooled, GC810 behind the run.
"""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

from cnc_front._native import gcode as native_gcode
from cnc_front._native import motion_kernel as native_kernel
from cnc_front.diagnostics import Diagnostic

#: Spool memory that one circle takes in the spooler of an axis, bytes (docs/machine-file.md, 2.2.8).
CIRCLE_BYTES = 128


@cache
def _texts() -> dict[str, tuple[str, str]]:
    return {id: (message, hint) for id, message, hint in native_gcode.catalogue()}


@cache
def _bits(register: str) -> dict[str, int]:
    return {name: 1 << number for number, name, _ in native_kernel.register_bits(register)}


def finding(file: str, id: str, *values: object) -> Diagnostic:
    """A diagnostic of the catalogue with its placeholders filled in order, at the start of the file."""
    message, hint = _texts()[id]
    left = iter(values)
    return Diagnostic(file, 1, 1, 1, id, re.sub(r"\{[^}]*\}", lambda _: str(next(left)), message), hint)


def not_ready(mcu: native_kernel.Mcu, machine: native_kernel.Machine, file: str) -> tuple[Diagnostic, ...]:
    """Why a part program must not start: every axis with a letter is referenced, in closed loop and at rest, has no
    zero offset of its own, and room in its spooler."""
    bits = _bits("axst")
    found: list[Diagnostic] = []
    for axis, (name, letter) in enumerate(zip(machine.axis_names, machine.letters, strict=True)):
        if not letter:
            continue
        status, zero = mcu.rdaxst(axis), mcu.read_axis_register(axis, "zerooffset")
        if zero != 0.0:
            found.append(finding(file, "GC805", name, f"{zero:g}"))
        if not status & bits["referenced"]:
            found.append(finding(file, "GC803", name))
        if status & (ready := bits["cl"] | bits["pe"]) != ready:
            found.append(finding(file, "GC806", name))
        if mcu.read_axis(axis)["lsm"] < CIRCLE_BYTES:
            found.append(finding(file, "GC809", name, CIRCLE_BYTES))
    return tuple(found)


def reported(mcu: native_kernel.Mcu, file: str, line: int = 0) -> tuple[Diagnostic, ...]:
    """GC810 if the controller's error register is not 0, at the block in which it came up (0: behind or before all)."""
    register = mcu.rderrorreg()
    if register == 0:
        return ()
    names = [name for name, bit in _bits("errorreg").items() if register & bit]
    found = finding(file, "GC810", f"{register:08X}h", ", ".join(names))
    return (replace(found, line=max(line, 1)),)
