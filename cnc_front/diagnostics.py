"""What a compiler or a machine file reader has to say, as values. Only the outermost layer prints them."""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding: where, which rule, what is wrong, what to do. Lines and columns count from 1."""

    file: str
    line: int
    column: int
    end_column: int
    id: str
    message: str
    hint: str = ""

    @property
    def is_warning(self) -> bool:
        """Warnings never stop a run (GWnnn of the dialect page)."""
        return self.id.startswith(("GW", "MW"))

    def __str__(self) -> str:
        hint = f"\n  hint: {self.hint}" if self.hint else ""
        return f"{self.file}:{self.line}:{self.column}: {self.id}: {self.message}{hint}"

    def as_json(self) -> dict[str, object]:
        """The object of `diagnostics` in `run --json` (design 3.2)."""
        return asdict(self)
