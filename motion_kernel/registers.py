"""Bit-coded registers as values. Names and texts come from the one table in motion_kernel/src/registers.rs."""

from __future__ import annotations

from typing import ClassVar

from cnc_front._native import motion_kernel as native


class Register(int):
    """An integer whose bits can be asked for by the manual's names: `mcu.rdaxst("X").pe`."""

    table: ClassVar[str] = ""
    bits: ClassVar[dict[str, int]] = {}
    texts: ClassVar[dict[str, str]] = {}

    def __init_subclass__(cls) -> None:
        rows = native.register_bits(cls.table)
        cls.bits = {name: number for number, name, _ in rows}
        cls.texts = {name: text for _, name, text in rows}

    def __getattr__(self, name: str) -> bool:
        number = type(self).bits.get(name)
        if number is None:
            raise AttributeError(f"{type(self).__name__} has no bit {name}; it has {', '.join(type(self).bits)}")
        return bool(self >> number & 1)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the bits that are set, in ascending order."""
        return tuple(name for name, number in type(self).bits.items() if self >> number & 1)

    @classmethod
    def of(cls, *names: str) -> int:
        """The value with these bits set, e.g. ModeReg.of("LookAhead", "ChkMaxVel")."""
        return sum(1 << cls.bits[name] for name in set(names))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {' '.join(self.names) or '0'}>"


class Axst(Register):
    """Axis status (4.4.45, table 12)."""

    table = "axst"


class ErrorReg(Register):
    """System errors (4.4.63.1, table 15). Sticky until 0 is written."""

    table = "errorreg"


class ControllerFlags(Register):
    """Options of the position loop of a servo axis (6.3.1.4, table 35)."""

    table = "controllerflags"


class Digi(Register):
    """Digi word of an axis (4.4.52.1): bits 0 to 15 the digital inputs, above them signals of the axis, by name."""

    table = "digi"


class Ifs(Register):
    """Interface status (4.4.70.1)."""

    table = "ifs"


class ModeReg(Register):
    """MODEREG (6.3.1.5, table 36)."""

    table = "modereg"
