"""`run --scan`: resources that a recording holds for every sample (docs/resources.md)."""

from __future__ import annotations

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.errors import UsageError
from motion_kernel import scanner
from motion_kernel.devices import ResourceError


def begin_scan(mcu: native_kernel.Mcu, names: tuple[str, ...], axes: list[str]) -> None:
    """Scans these resources from the next sample on. UsageError for what is none, or none that this board has."""
    try:
        scanner.start(mcu, names, axes)
    except (ValueError, ResourceError) as error:
        raise UsageError(f"--scan: {error}") from None


def parse_scan(text: str | None, machine: native_kernel.Machine, *, recorded: bool) -> tuple[str, ...]:
    """Names of a list with commas, tried on a controller of this machine. UsageError says what is wrong."""
    if text is None:
        return ()
    names = tuple(name.strip() for name in text.split(","))
    if not recorded:
        raise UsageError("--scan needs --record: the values go into the recording")
    begin_scan(native_kernel.Mcu(machine), names, list(machine.axis_names))
    return names
