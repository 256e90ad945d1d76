"""The table of PCAP commands: each method of `Mcu` that is one says so itself, with its chapter and units.

`docs/pcap.md` is printed from it (`python -m motion_kernel.reference`).
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])


class PcapError(Exception):
    """A command that failed. `status` is the return code of the manual: -1 not available, -4 no communication with
    the card, for tables of their own the code of the table."""

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status = status


class CommandRefused(Exception):
    """A command that the state of an axis does not allow. For motion in open loop (design D11): nothing moves, axst
    dhef, ErrorReg bit 9."""


@dataclass(frozen=True, slots=True)
class Command:
    """A PCAP command: name of its method, name in the manual, chapter, units of what it takes and returns, and its row
    in the conformance catalogue."""

    name: str
    manual: str
    chapter: str
    unit: str
    row: str


COMMANDS: dict[str, Command] = {}


def command(
    chapter: str, unit: str = "", *, manual: str = "", row: str = "", returns_status: bool = False
) -> Callable[[F], F]:
    """Marks a method as the PCAP command of that chapter; `help` shows both. `manual` is its spelling there,
    if not lower case. With `returns_status` a failure is the return code, not an exception."""

    def mark(function: F) -> F:
        method = _as_status(function) if returns_status else function
        name = function.__name__
        where = f"{f'Unit: {unit}. ' if unit else ''}Manual: {manual or name}, chapter {chapter}."
        method.__doc__ = f"{inspect.cleandoc(function.__doc__ or '')}\n\n{where}"
        if name in COMMANDS:
            raise TypeError(f"the command {name} stands twice")
        COMMANDS[name] = Command(name, manual or name, chapter, unit, row or f"pcap.{name.removeprefix('mcug3_')}")
        return method

    return mark


def _as_status(function: F) -> F:
    @functools.wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        try:
            return function(*arguments, **named)
        except PcapError as error:
            return error.status

    return cast("F", call)
