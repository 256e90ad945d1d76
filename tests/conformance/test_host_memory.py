"""Memory of the host through the resource interface (chapter 4)."""

from __future__ import annotations

import array
import ctypes
import gc
import struct
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motion_kernel import Mcu
from motion_kernel.resources import ResourceError

BUFFERS: list[Callable[[], Any]] = [
    lambda: np.zeros((4, 4)),
    lambda: bytearray(128),
    lambda: (ctypes.c_int * 32)(),
    lambda: array.array("d", [0.0] * 16),
]


@pytest.mark.shows(
    "res.dev-0310.IsisAxisPhysAdr", "res.dev-0311.IsisHostMemByte", "res.dev-0312.IsisHostMemWord",
    "res.dev-0314.IsisHostMemInt", "res.dev-0315.IsisHostMemFloat", "res.dev-0318.IsisHostMemDouble",
    "res.dev-0300.HostMemPhysAdr", "res.dev-0300.sets", "res.dev-0301.HostMemByte", "res.dev-0302.HostMemWord",
    "res.dev-0304.HostMemInt", "res.dev-0305.HostMemFloat", "res.dev-0308.HostMemDouble", "res.hostmem.base-first",
    "res.hostmem.shared-bytes", "res.hostmem.alloc", "res.hostmem.free",
)  # fmt: skip
@pytest.mark.parametrize("prefix", ["HostMem", "IsisHost"])
def test_host_memory(mcu: Mcu, prefix: str) -> None:
    r = mcu.resources
    r.fit("RESOURCE", "PCI", "ISIS")
    isis = "Mem" if prefix == "IsisHost" else ""
    base = r.IsisAxisPhysAdr if isis else r.HostMemPhysAdr
    byte, word, int_, float_, double = (
        getattr(r, f"{prefix}{isis}{width}") for width in ("Byte", "Word", "Int", "Float", "Double")
    )
    with pytest.raises(ResourceError, match="80 hex"):
        byte[0, 1]
    one, two = r.allocphysmem(64), r.allocphysmem(64)
    base[0, 1], base[0, 2] = one.phys_adr, two.phys_adr
    assert base[0, 1] == one.phys_adr != base[0, 2]
    int_[4, 1] = -2
    word[4, 1] = 0x1234
    assert (byte[4, 1], byte[5, 1], int_[4, 1]) == (0x34, 0x12, 0xFFFF1234 - 2**32)
    assert one[4:8] == b"\x34\x12\xff\xff" and two[:] == bytes(64)
    float_[8, 2], double[16, 2], byte[63, 2] = 0.5, -0.1, 200
    assert two[8:12] == struct.pack("<f", 0.5) and two[16:24] == struct.pack("<d", -0.1) and two[63:] == b"\xc8"
    two.write(32, struct.pack("<d", 6.25))
    assert (float_[8, 2], double[16, 2], double[32, 2], byte[63, 2]) == (0.5, -0.1, 6.25, 200)
    for index in (-1, 61, 64, 2**31 - 1):
        with pytest.raises(ResourceError, match="80 hex"):
            int_[index, 1]
    assert one.free() and not one.free()
    with pytest.raises(ResourceError, match="80 hex"):
        byte[0, 1]
    with pytest.raises(MemoryError):
        r.allocphysmem(2**31)


@pytest.mark.parametrize("make", BUFFERS)
def test_host_memory_of_the_caller(mcu: Mcu, make: Callable[[], Any]) -> None:
    """Both sides see the same bytes, and the buffer lives as long as the controller may reach it."""
    r, buffer = mcu.resources, make()
    memory = r.lendphysmem(buffer)
    assert memory.size == 128 and memory.phys_adr % 4096 == 0
    r.HostMemPhysAdr[0, 3] = memory.phys_adr
    r.HostMemDouble[8, 3] = 6.5
    assert bytes(memoryview(buffer).cast("B"))[8:16] == struct.pack("<d", 6.5) == memory[8:16]
    view = np.frombuffer(buffer, np.uint8)
    view[17] = 200
    assert r.HostMemByte[17, 3] == 200
    for offset in (-1, 121, 2**31 - 1):
        with pytest.raises(ResourceError, match="80 hex"):
            r.HostMemDouble[offset, 3] = 1.0
    assert view.sum() == 200 + sum(struct.pack("<d", 6.5))
    if isinstance(buffer, bytearray):
        del view
        with pytest.raises(BufferError):
            buffer.extend(b"more")
    del buffer
    gc.collect()
    assert r.HostMemByte[17, 3] == 200, "kept alive"
    assert memory.free()
    with pytest.raises(ResourceError, match="80 hex"):
        r.HostMemByte[17, 3]


def test_lent_memory_is_released(mcu: Mcu) -> None:
    buffer = bytearray(8)
    memory = mcu.resources.lendphysmem(buffer)
    gone = weakref.ref(memory)
    memory.free()
    del memory
    gc.collect()
    buffer.extend(b"resized")
    assert gone() is None and len(buffer) == 15


@pytest.mark.parametrize("buffer", [b"read-only", np.zeros(16)[::2], bytearray(), "text", np.broadcast_to(0.0, 4)])
def test_buffers_that_are_refused(mcu: Mcu, buffer: Any) -> None:
    with pytest.raises((ValueError, TypeError)):
        mcu.resources.lendphysmem(buffer)
