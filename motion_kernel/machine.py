"""Machine files (design 3.5): what stands for system.dat of the manual."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import NamedTuple

from cnc_front._native import motion_kernel as native


class Diagnostic(NamedTuple):
    """One finding in a machine file or a part program. Lines and columns count from 1; GW ids are warnings."""

    file: str
    line: int
    column: int
    end_column: int
    id: str
    message: str
    hint: str
    #: The source line with a caret below; empty where the compiler gives none.
    excerpt: str = ""

    @property
    def is_warning(self) -> bool:
        """Warnings do not keep a program from being compiled."""
        return self.id.startswith(("GW", "SW"))

    def __str__(self) -> str:
        hint = f"\n  hint: {self.hint}" if self.hint else ""
        excerpt = f"\n{self.excerpt}" if self.excerpt else ""
        return f"{self.file}:{self.line}:{self.column}: {self.id}: {self.message}{excerpt}{hint}"


class MachineError(ValueError):
    """A machine file that is not valid; `diagnostics` names every finding."""

    def __init__(self, diagnostics: tuple[Diagnostic, ...]) -> None:
        super().__init__("\n".join(map(str, diagnostics)))
        self.diagnostics = diagnostics


class Machine:
    """A validated machine: axes, units, dynamics, limits, controller and G-code defaults."""

    def __init__(self, native_machine: native.Machine) -> None:
        self.native = native_machine

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Machine:
        """Reads a machine file. Raises OSError, or MachineError with every finding."""
        return cls.parse(Path(path).read_bytes(), str(path))

    @classmethod
    def parse(cls, text: str | bytes, filename: str = "<text>") -> Machine:
        """From TOML text. Raises MachineError."""
        data = text.encode() if isinstance(text, str) else text
        try:
            return cls(native.Machine.parse(data, filename))
        except native.MachineError as error:
            raise MachineError(tuple(Diagnostic(*row) for row in error.args[0])) from None

    @classmethod
    def builtin(cls) -> Machine:
        """The built-in 3-axis mill (mill3)."""
        return cls(native.Machine.builtin())

    @property
    def name(self) -> str:
        """Name of the machine."""
        return self.native.name

    @property
    def axis_names(self) -> list[str]:
        """Axes in their order; index n is axis n of every command."""
        return self.native.axis_names

    @property
    def units(self) -> list[str]:
        """ "mm" or "deg" per axis."""
        return self.native.units

    @property
    def sample_time_s(self) -> float:
        """TA: one sample interval, s."""
        return self.native.sample_time_us * 1e-6

    def show(self) -> str:
        """The machine file as TOML with all defaults filled in."""
        return self.native.show()

    def __repr__(self) -> str:
        return f"<Machine {self.name}: {' '.join(self.axis_names)}>"
