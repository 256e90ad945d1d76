"""Devices of the resource interface: object descriptors, return codes, and the table by name."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from enum import IntEnum

from cnc_front._native import motion_kernel as native

AxisId = str | int

AXIS = "axis"  # what Index or SubIndex is

BUS = 1000
READ, WRITE = 1, 2  # access types; 3 (both) is wrong for resources
CP = 200  # first of the 15 columns of controller parameters


class Code(IntEnum):
    """Return codes of the object interface: BUSY is to be repeated, anything but BUSY and OK is an error."""

    UNKNOWN = 1
    BUSY = 2
    OK = 4
    HARDWARE = 8
    STATE_ERR = 0x80


class DataType(IntEnum):
    """Data types of descriptors. Only the number of DATA_BLOCK is in the manual, the others are ours."""

    BYTE = 1
    WORD = 2
    INTEGER = 3
    FLOAT = 4
    DOUBLE = 5
    DATA_BLOCK = 6
    SHORT = 7


class ResourceError(Exception):
    """Access by name failed: `code` says why."""

    def __init__(self, name: str, code: int, more: str = "") -> None:
        reason = REASONS.get(code, f"return code {code:#x}")
        super().__init__(f"{name}: {reason}{f' ({more})' if more else ''}")
        self.code = code


REASONS: dict[int, str] = {
    Code.UNKNOWN: "return code 1: the board has no such resource (see options), or not in this direction",
    Code.BUSY: "return code 2: not ready, repeat the access",
    Code.HARDWARE: "return code 8: the hardware cannot do it",
    Code.STATE_ERR: "return code 80 hex: not in this state, or an index or value out of range; nothing was changed",
}


@dataclass(slots=True)
class ObjectDescriptor:
    """A resource and a direction (2.1). `handle` is 0 before the first access and must be set to 0 after a boot and
    after clear; the accesses keep it."""

    device: int
    index: int = 0
    sub_index: int = 0
    type: DataType = DataType.INTEGER
    access: int = READ
    bus: int = BUS
    handle: int = 0

    def row(self) -> tuple[int, int, int, int, int, int, int]:
        return (self.handle, self.bus, self.device, self.index, self.sub_index, int(self.type), self.access)


@dataclass(frozen=True, slots=True)
class Device:
    """A row of the table: device numbers, name, type, directions, and what Index and SubIndex are: "axis", "0 to 5",
    "3" or "-" (no meaning, or one that the device judges itself). `needs`: options of the board without which it is
    unknown."""

    first: int
    last: int
    name: str
    type: DataType
    readable: bool
    writable: bool
    index: str
    sub_index: str
    function: int | None  # Index of one of several functions of the same number
    needs: tuple[str, ...]

    def descriptor(
        self, key: Sequence[AxisId], number_of: Callable[[AxisId], int], access: int = READ
    ) -> ObjectDescriptor:
        """A new descriptor of it; `number_of` tells the index of an axis. IndexError if it has no such parts."""
        parts = list(key)
        if self.function is not None:
            parts.insert(0, self.function)
        number = self.first + (whole(parts.pop()) if self.first == CP and len(parts) == 3 else 0)
        if len(parts) > 2 or not self.first <= number <= self.last:
            raise IndexError(f"{self.name}{list(key)}: {self.name} has no such index")
        # the line of a gear factor is that of its master
        axes = (self.index == AXIS, self.sub_index == AXIS or self.first == CP)
        numbers = [
            number_of(part) if axis and isinstance(part, str) else whole(part)
            for part, axis in zip(parts, axes, strict=False)
        ]
        if not numbers and self.index == AXIS:
            raise IndexError(f"{self.name} needs an axis")
        index, sub_index = [*numbers, 0, 0][:2]
        return ObjectDescriptor(number, index, sub_index, self.type, access)


def _devices() -> dict[str, Device]:
    devices = {}
    for first, last, manual, kind, readable, writable, index, sub_index, function, needs in native.resource_devices():
        name, data = re.sub(r"\W", "", manual), DataType(kind)
        devices[name] = Device(first, last, name, data, readable, writable, index, sub_index, function, tuple(needs))
    return devices


DEVICES = _devices()
"""All devices by name: the manual's, without blanks and brackets (DTV0, PositionFactor, MCPOFFSET)."""


def refusal(device: Device, code: int, options: Collection[str], access: int = READ) -> ResourceError:
    """The error of an access that a return code refuses, with what is known of the reason."""
    missing = [option for option in device.needs if option not in options]
    more = ""
    if code == Code.UNKNOWN and missing:
        more = f"the board has no option {', '.join(missing)}; mcu.resources.fit changes that"
    elif code == Code.UNKNOWN and not (device.readable if access == READ else device.writable):
        more = "it can only be written" if access == READ else "it can only be read"
    elif code == Code.STATE_ERR:
        more = f"Index: {device.index}, SubIndex: {device.sub_index}"
    return ResourceError(device.name, code, more)


def device_named(name: str) -> Device:
    """The device of that name. ValueError with the nearest name."""
    if name not in DEVICES:
        near = difflib.get_close_matches(name, DEVICES, 1, 0.5)
        raise ValueError(f"there is no resource {name}{f'; did you mean {near[0]}?' if near else ''}")
    return DEVICES[name]


def whole(value: float | str) -> int:
    """The number, if it is whole; else ValueError."""
    if isinstance(value, str) or value != int(value):
        raise ValueError(f"{value!r}: must be a whole number")
    return int(value)
