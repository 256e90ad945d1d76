"""The scanner of the resource interface: chosen resources, read at the end of every sample.

>>> mcu.resources.scan(["dp.X", "cp.X.3.0", "scntr"])
>>> mcu.advance(1000)
>>> mcu.resources.scanned["dp.X"]
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native
from motion_kernel.devices import DEVICES, AxisId, DataType, ObjectDescriptor, ResourceError, device_named, refusal

Scannable = str | ObjectDescriptor
RTS_DATABLOCK, RTS_DATAANALOGBLOCK = 8013, 8014
ANALOG_CHANNELS = 8


def named(name: str, axes: Sequence[str]) -> ObjectDescriptor:
    """The descriptor of `dp.X`, `cp.X.3.0` (axis, line, column), `CI.12`, `SYNCMODE.Z`, `scntr`: name of the device,
    then what stands in brackets of `mcu.resources`. ValueError for anything else."""
    first, *rest = name.split(".")
    device = device_named(first)
    keys: list[AxisId] = [int(part) if part.isascii() and part.isdigit() else part for part in rest]
    try:
        return device.descriptor(keys, lambda axis: _axis(axis, axes))
    except IndexError as error:
        raise ValueError(f"{name}: {error}") from None


def _axis(axis: AxisId, axes: Sequence[str]) -> int:
    if isinstance(axis, int):
        return axis
    if axis not in axes:
        raise ValueError(f"the machine has no axis {axis}; it has {', '.join(axes)}")
    return list(axes).index(axis)


def start(emulator: native.Mcu, resources: Iterable[Scannable], axes: Sequence[str]) -> None:
    """Scans these resources from the next sample on, and no others. Names are read once, as the manual wants it;
    descriptors must have been. ValueError for what is no resource, ResourceError for what cannot be scanned."""
    chosen = [_ready(emulator, resource, axes) for resource in resources]
    names = [name for name, _ in chosen]
    if twice := {name for name in names if names.count(name) > 1}:
        raise ValueError(f"{', '.join(sorted(twice))}: scanned twice")
    failed = emulator.scan([(name, descriptor.row()) for name, descriptor in chosen])
    if failed is not None:
        position, code = failed
        raise ResourceError(
            names[position], code, "scanned are at most 64 resources that were read before, no host memory"
        )


def _ready(emulator: native.Mcu, resource: Scannable, axes: Sequence[str]) -> tuple[str, ObjectDescriptor]:
    if isinstance(resource, ObjectDescriptor):
        device = next((d for d in DEVICES.values() if d.first <= resource.device <= d.last), None)
        name = device.name if device else str(resource.device)
        return (
            name if resource.type is DataType.DATA_BLOCK else f"{name}.{resource.index}.{resource.sub_index}"
        ), resource
    descriptor = named(resource, axes)
    read = emulator.rd_option_dbl if descriptor.type is DataType.DOUBLE else emulator.rd_option_int
    code, descriptor.handle, _ = read(descriptor.row())
    if descriptor.handle == 0:
        raise refusal(device_named(resource.split(".")[0]), code, emulator.resource_options())
    return resource, descriptor


def scanned(trace: native.Chunk) -> dict[str, NDArray[Any]]:
    """What was scanned with a trace, by name: a value for each sample, NaN where a resource was BUSY. Of a data block
    a structured array: count, status, reserved, positions (rows, columns) and, with analog inputs, analog (rows, 8);
    only the first `count` rows are valid, status 4 tells that rows were lost."""
    columns: dict[str, NDArray[Any]] = {name: trace.scan[:, n] for n, name in enumerate(trace.scan_names)}
    at = 0
    for name, width, rows, analog in trace.scan_layout:
        fields: list[Any] = [("count", "<i4"), ("status", "<i4"), ("reserved", "<i4", (2,))]
        fields.append(("positions", "<f8", (rows, width)))
        if analog:
            fields.append(("analog", "<i2", (rows, ANALOG_CHANNELS)))
        block = np.dtype(fields)
        own = np.ascontiguousarray(trace.scan_blocks[:, at : at + block.itemsize])
        columns[name] = own.view(block)[:, 0]
        at += block.itemsize
    return columns


def data_block(axes: Sequence[int], rows: int, analog: bool) -> ObjectDescriptor:
    """The descriptor of a data block with a column for each axis, in ascending order, and so many rows."""
    index = len(axes) | sum(1 << axis for axis in set(axes)) << 16
    number = RTS_DATAANALOGBLOCK if analog else RTS_DATABLOCK
    return ObjectDescriptor(number, index - (1 << 32) if index >= 1 << 31 else index, rows, DataType.DATA_BLOCK)
