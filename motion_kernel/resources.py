"""The resource interface (manual "Ressourcen-Interface"): internal quantities by device number, or by name.

>>> mcu.resources.dp["X"]
0.0
>>> mcu.resources.cp["X", 3, 0] = 0.5  # controller parameter of line 3, column 0
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native
from motion_kernel import scanner
from motion_kernel.devices import (
    BUS,
    DEVICES,
    READ,
    WRITE,
    Code,
    DataType,
    Device,
    ObjectDescriptor,
    ResourceError,
    device_named,
    refusal,
    whole,
)
from motion_kernel.driver import AxisId, Driver
from motion_kernel.machine import Machine
from motion_kernel.scanner import Scannable

if TYPE_CHECKING:
    from typing_extensions import Buffer

__all__ = [
    "BUS",
    "DEVICES",
    "READ",
    "WRITE",
    "Code",
    "DataType",
    "EndatSetup",
    "HostMemory",
    "ObjectDescriptor",
    "Resource",
    "ResourceAccess",
    "ResourceError",
    "Resources",
]


class EndatSetup(NamedTuple):
    """What the controller has read of an ENDAT encoder: version 21 or 22, bits of the position word, rotary or linear,
    steps per revolution or measuring step, nm."""

    version: int
    bits: int
    rotary: bool
    steps: int


class HostMemory:
    """Memory of the PC that the controller reaches as bus master; `phys_adr` is its physical address, `size` bytes."""

    def __init__(self, emulator: native.Mcu, phys_adr: int, size: int) -> None:
        self._emulator, self.phys_adr, self.size = emulator, phys_adr, size

    def __getitem__(self, key: slice) -> bytes:
        start, stop, _ = key.indices(self.size)
        return self._emulator.read_host(self.phys_adr + start, max(0, stop - start))

    def write(self, offset: int, data: bytes) -> None:
        """Writes from `offset` on; IndexError where it does not fit."""
        self._emulator.write_host(self.phys_adr + offset, data)

    def free(self) -> bool:
        """freePhysMem; False if it was released before."""
        return self._emulator.free_phys_mem(self.phys_adr)


class Resource:
    """A device of the table: `[index]` or `[index, sub-index]`, `cp` with `[axis, line, column]` (a line by
    its number or as that of an axis), functions of SyncMode with `[slave]`. Axes by name or index. ResourceError unless
    the return code is OK."""

    def __init__(self, resources: Resources, device: Device) -> None:
        self._resources, self._device = resources, device

    def descriptor(self, key: AxisId | Sequence[AxisId], access: int = READ) -> ObjectDescriptor:
        """A new descriptor of it."""
        parts = [key] if isinstance(key, str | int) else list(key)
        return self._device.descriptor(parts, self._resources.axis_number, access)

    def __getitem__(self, key: AxisId | tuple[AxisId, ...]) -> float:
        descriptor = self.descriptor(key)
        code: int
        value: float
        if descriptor.type is DataType.DOUBLE:
            code, value = self._resources.rdoptiondbl(descriptor)
        else:
            code, bits = self._resources.rdoptionint(descriptor)
            value = struct.unpack("<f", struct.pack("<i", bits))[0] if descriptor.type is DataType.FLOAT else bits
        self._check(code, READ)
        return value

    def __setitem__(self, key: AxisId | tuple[AxisId, ...], value: float) -> None:
        descriptor = self.descriptor(key, WRITE)
        if descriptor.type is DataType.DOUBLE:
            return self._check(self._resources.wroptiondbl(descriptor, value), WRITE)
        single = descriptor.type is DataType.FLOAT
        bits = struct.unpack("<i", struct.pack("<f", value))[0] if single else whole(value)
        self._check(self._resources.wroptionint(descriptor, bits), WRITE)

    def _check(self, code: int, access: int) -> None:
        if code != Code.OK:
            raise refusal(self._device, code, self._resources.options, access)


class Resources:
    """The resources of the selected card."""

    def __init__(self, driver: ResourceAccess) -> None:
        self._driver = driver

    def __getattr__(self, name: str) -> Resource:
        try:
            return Resource(self, device_named(name))
        except ValueError as error:
            raise AttributeError(str(error)) from None

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
        return HostMemory(self._emulator, self._emulator.alloc_phys_mem(size), size)

    def lendphysmem(self, buffer: Buffer) -> HostMemory:
        """The same with memory of the caller, used as it is without a copy: a NumPy array, bytearray, ctypes array or
        any other writable, contiguous buffer. It is kept alive until `free`. ValueError for other buffers."""
        try:
            view = np.frombuffer(memoryview(buffer), np.uint8)
        except (ValueError, BufferError) as error:
            raise ValueError(f"host memory must be a contiguous buffer that is not empty: {error}") from None
        if view.size == 0:
            raise ValueError("host memory must be a contiguous buffer that is not empty")
        return HostMemory(self._emulator, self._emulator.lend_phys_mem(view), view.size)

    # ---- the scanner

    def scan(self, resources: Iterable[Scannable]) -> None:
        """Records these resources from the next sample on, at the end of every sample: names as `dp.X`, `cp.X.3.0`,
        `CI.12`, `scntr`, or descriptors that were read before. An empty list ends it. Columns: `scanned`. ValueError
        for what is no resource, ResourceError for what cannot be scanned; then nothing changes."""
        scanner.start(self._emulator, resources, self._driver.machine.axis_names)

    @property
    def scanned(self) -> dict[str, NDArray[Any]]:
        """Columns of the last `advance` by name: a value a sample, NaN where a resource was BUSY. A data block is a
        structured array with count, status, positions (rows, columns) and, with analog inputs, analog (rows, 8)."""
        return scanner.scanned(self._driver.trace)

    def datablock(self, axes: Sequence[AxisId], rows: int, *, analog: bool = False) -> ObjectDescriptor:
        """Descriptor of RTS_DATABLOCK (7.4), or of RTS_DATAANALOGBLOCK, with a column for each axis and at most so many
        rows a sample. To be read once before it is scanned."""
        return scanner.data_block([self.axis_number(axis) for axis in axes], rows, analog)

    # ---- ENDAT encoders

    def fit_endat(self, axis: AxisId, bits: int = 25, *, rotary: bool = True, steps: int | None = None) -> None:
        """The axis gets an ENDAT encoder with that many position bits (1 to 32; 0 takes it away), and steps per
        revolution (2**bits), or a measuring step in nm if it is linear. The controller knows it after `rs` or a
        boot, if the environment variable of the axis (MT0, MT1 ...) is 11 (version 2.1) or 16 (2.2), and with
        option ENDAT."""
        self._emulator.fit_endat(
            self.axis_number(axis), bits, rotary, steps if steps is not None else (1 << bits) % (1 << 32)
        )

    def endat_setup(self, axis: AxisId) -> EndatSetup | None:
        """How boot or `rs` set the axis up from the data of its encoder (6.2); None: no encoder that answers."""
        setup = self._emulator.endat_setup(self.axis_number(axis))
        return EndatSetup(*setup) if setup else None

    def disturb_endat(self, axis: AxisId, *, alarm: bool = False, crc_errors: int = 0, timeouts: int = 0) -> None:
        """The encoder signals an alarm or not; so many of its next transfers fail. ValueError without an encoder."""
        self._emulator.disturb_endat(self.axis_number(axis), alarm, crc_errors, timeouts)

    def endat_resets(self, axis: AxisId) -> int:
        """Resets that the encoder has received."""
        return self._emulator.endat_resets(self.axis_number(axis))

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

    def axis_number(self, axis: AxisId) -> int:
        """Index of an axis."""
        return self._driver.axis_number(axis)

    @property
    def _emulator(self) -> native.Mcu:
        return self._driver.emulator


class ResourceAccess(Driver):
    """`mcu.resources`."""

    @property
    def resources(self) -> Resources:
        """The resource interface of the selected card."""
        return Resources(self)

    @property
    def gcode_machine(self) -> Machine:
        """The machine as part programs find it now: G54 to G59 are RefOffset 0 to 5, axes with Mirror go by
        PositionFactor (resources 16 to 18). For `gcode.compile`, whose programs run on this controller."""
        return Machine(self._mcu.gcode_machine())

    @property
    def emulator(self) -> native.Mcu:
        """The emulator of the selected card."""
        return self._mcu

    def axis_number(self, axis: AxisId) -> int:
        """Index of an axis."""
        return self._index(axis)
