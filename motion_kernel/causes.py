"""What limits the path velocity. The one table of causes is motion_kernel/src/cause.rs; `Mcu.trace.flags` names one for
every sample from bit 8 on.

>>> limit_of(0x0205)
Limit(cause=<Cause.MDVEL: 'mdvel'>, axis=1)
>>> english(Cause.MDVEL)
'mdvel at a junction'
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from cnc_front._native import motion_kernel as native

_ROWS = native.causes()
#: By the names that JSON has for them.
Cause = StrEnum("Cause", [("UNKNOWN", "unknown"), *((name.upper(), name) for _, name, _, _ in _ROWS)])  # type: ignore[misc]

_BY_NUMBER = {number: Cause(name) for number, name, _, _ in _ROWS}
_ENGLISH = {name: text for _, name, text, _ in _ROWS}
_GERMAN = {name: text for _, name, _, text in _ROWS}


class Limit(NamedTuple):
    """A cause and, where it is that of one axis, the index of the axis."""

    cause: str
    axis: int | None


def limit_of(code: int) -> Limit:
    """The 16 bits that trace and tracker have for it: the cause, and the axis + 1 in the high byte."""
    axis = code >> 8
    return Limit(_BY_NUMBER.get(code & 0xFF, Cause("unknown")), axis - 1 if axis else None)


def english(cause: str) -> str:
    """What a cause is, in words."""
    return _ENGLISH.get(cause, cause)


def german(cause: str) -> str:
    """As `english`, in German."""
    return _GERMAN.get(cause, cause)
