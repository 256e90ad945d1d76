"""The resource interface (manual "Ressourcen-Interface"): internal quantities by device number, or by name.

>>> mcu.resources.dp["X"]
0.0
>>> mcu.resources.cp["X", 3, 0] = 0.5  # controller parameter of line 3, column 0
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from cnc_front._native import motion_kernel as native
from motion_kernel.driver import AxisId, Driver

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

    def __init__(self, name: str, code: int) -> None:
        super().__init__(f"{name}: {REASONS.get(code, f'return code {code:#x}')}")
        self.code = code


REASONS: dict[int, str] = {
    Code.UNKNOWN: "return code 1: the board has no such resource, or not in this direction",
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


class HostMemory:
    """Memory of the PC that the controller reaches as bus master; `phys_adr` is its physical address."""

    def __init__(self, emulator: native.Mcu, size: int) -> None:
        self._emulator, self.size = emulator, size
        self.phys_adr: int = emulator.alloc_phys_mem(size)

    def __getitem__(self, key: slice) -> bytes:
        start, stop, _ = key.indices(self.size)
        return self._emulator.read_host(self.phys_adr + start, max(0, stop - start))

    def write(self, offset: int, data: bytes) -> None:
        """Writes from `offset` on; IndexError where it does not fit."""
        self._emulator.write_host(self.phys_adr + offset, data)

    def free(self) -> bool:
        """freePhysMem; False if it was released before."""
        return self._emulator.free_phys_mem(self.phys_adr)


@dataclass(frozen=True, slots=True)
class _Device:
    first: int
    last: int
    name: str
    type: DataType
    readable: bool
    writable: bool
    index_is_axis: bool
    sub_is_axis: bool
    function: int | None  # Index of one of several functions of the same number


def _devices() -> dict[str, _Device]:
    devices = {}
    for first, last, manual, kind, *flags, function in native.resource_devices():
        name = re.sub(r"\W", "", manual)
        readable, writable, index_is_axis, sub_is_axis = map(bool, flags)
        devices[name] = _Device(
            first, last, name, DataType(kind), readable, writable, index_is_axis, sub_is_axis, function
        )
    return devices


DEVICES = _devices()
"""All devices by name: the manual's, without blanks and brackets (DTV0, PositionFactor, MCPOFFSET)."""


class Resource:
    """A device of the table: `[index]` or `[index, sub-index]`, `cp` with `[axis, line, column]`,
    functions of SyncMode with `[slave]`. Axes by name or
    index. ResourceError unless the return code is OK."""

    def __init__(self, resources: Resources, device: _Device) -> None:
        self._resources, self._device = resources, device

    def descriptor(self, key: AxisId | Sequence[AxisId], access: int = READ) -> ObjectDescriptor:
        """A new descriptor of it."""
        parts = [key] if isinstance(key, str | int) else list(key)
        device = self._device
        if device.function is not None:
            parts.insert(0, device.function)
        number = device.first + (_whole(parts.pop()) if device.first == CP and len(parts) == 3 else 0)
        if len(parts) > 2 or not device.first <= number <= device.last:
            raise IndexError(f"{device.name}{list(parts)}: {device.name} has no such index")
        axes = (device.index_is_axis, device.sub_is_axis)
        numbers = [self._resources.number(part, axis) for part, axis in zip(parts, axes, strict=False)]
        index, sub_index = [*numbers, 0, 0][:2]
        return ObjectDescriptor(number, index, sub_index, device.type, access)

    def __getitem__(self, key: AxisId | tuple[AxisId, ...]) -> float:
        descriptor = self.descriptor(key)
        code: int
        value: float
        if descriptor.type is DataType.DOUBLE:
            code, value = self._resources.rdoptiondbl(descriptor)
        else:
            code, bits = self._resources.rdoptionint(descriptor)
            value = struct.unpack("<f", struct.pack("<i", bits))[0] if descriptor.type is DataType.FLOAT else bits
        self._check(code)
        return value

    def __setitem__(self, key: AxisId | tuple[AxisId, ...], value: float) -> None:
        descriptor = self.descriptor(key, WRITE)
        if descriptor.type is DataType.DOUBLE:
            return self._check(self._resources.wroptiondbl(descriptor, value))
        single = descriptor.type is DataType.FLOAT
        bits = struct.unpack("<i", struct.pack("<f", value))[0] if single else _whole(value)
        self._check(self._resources.wroptionint(descriptor, bits))

    def _check(self, code: int) -> None:
        if code != Code.OK:
            raise ResourceError(self._device.name, code)


class Resources:
    """The resources of the selected card."""

    def __init__(self, driver: ResourceAccess) -> None:
        self._driver = driver

    def __getattr__(self, name: str) -> Resource:
        if name not in DEVICES:
            raise AttributeError(f"there is no resource {name}")
        return Resource(self, DEVICES[name])

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *DEVICES]

    # ---- the universal object interface

    def rdoptionint(self, descriptor: ObjectDescriptor) -> tuple[int, int]:
        """rdOptionInt: return code and value; of a float its 32 bits."""
        code, descriptor.handle, value = self._emulator.rd_option_int(descriptor.row())
        return code, value

    def rdoptiondbl(self, descriptor: ObjectDescriptor) -> tuple[int, float]:
        """rdOptionDbl: return code and value."""
        code, descriptor.handle, value = self._emulator.rd_option_dbl(descriptor.row())
        return code, value

    def wroptionint(self, descriptor: ObjectDescriptor, value: int) -> int:
        """wrOptionInt: return code; a float is written as its 32 bits."""
        code, descriptor.handle = self._emulator.wr_option_int(descriptor.row(), value)
        return code

    def wroptiondbl(self, descriptor: ObjectDescriptor, value: float) -> int:
        """wrOptionDbl: return code."""
        code, descriptor.handle = self._emulator.wr_option_dbl(descriptor.row(), value)
        return code

    def clear(self) -> None:
        """Deletes all defined resources (device 0); handles of descriptors must be set to 0 then."""
        Resource(self, DEVICES["clear"])[1] = 1

    # ---- the board and the world outside

    @property
    def options(self) -> list[str]:
        """Options of the operating system and the board, as fwsetup lists them after a boot."""
        return self._emulator.resource_options()

    def fit(self, *options: str) -> None:
        """The board gets exactly these options; ValueError for an unknown one."""
        self._emulator.set_resource_options(list(options))

    def allocphysmem(self, size: int) -> HostMemory:
        """allocPhysMem: memory of the PC. MemoryError where there is none."""
        return HostMemory(self._emulator, size)

    def fit_endat(self, axis: AxisId, mt: int, bits: int = 25) -> None:
        """The axis gets an ENDAT encoder with that many position bits (1 to 32), if its environment variable MT is 11
        (version 2.1) or 16 (2.2); with any other none. Option ENDAT is needed besides."""
        self._emulator.fit_endat(self._driver.axis_number(axis), mt, bits)

    def disturb_endat(self, axis: AxisId, *, alarm: bool = False, crc_errors: int = 0, timeouts: int = 0) -> None:
        """The encoder signals an alarm or not; so many of its next transfers fail. ValueError without an encoder."""
        self._emulator.disturb_endat(self._driver.axis_number(axis), alarm, crc_errors, timeouts)

    def endat_resets(self, axis: AxisId) -> int:
        """Resets that the encoder has received."""
        return self._emulator.endat_resets(self._driver.axis_number(axis))

    def set_analog_input(self, channel: int, digits: int) -> None:
        """Level of an analog input (0 to 7), 32767 = 10 V."""
        self._emulator.set_analog_input(channel, digits)

    @property
    def analog_outputs(self) -> list[int]:
        """What AOUT and AOUT03 wrote, digits."""
        return self._emulator.analog_outputs()

    @property
    def fast_outputs(self) -> int:
        """What FASTPULSEOUT wrote, a bit for each axis."""
        return self._emulator.fast_outputs()

    def number(self, part: AxisId, is_axis: bool) -> int:
        """Index of an axis, or the number itself."""
        if isinstance(part, str) and is_axis:
            return self._driver.axis_number(part)
        return _whole(part)

    @property
    def _emulator(self) -> native.Mcu:
        return self._driver.emulator


def _whole(value: float | str) -> int:
    if isinstance(value, str) or value != int(value):
        raise ValueError(f"{value!r}: must be a whole number")
    return int(value)


class ResourceAccess(Driver):
    """`mcu.resources`."""

    @property
    def resources(self) -> Resources:
        """The resource interface of the selected card."""
        return Resources(self)

    @property
    def emulator(self) -> native.Mcu:
        """The emulator of the selected card."""
        return self._mcu

    def axis_number(self, axis: AxisId) -> int:
        """Index of an axis."""
        return self._index(axis)
