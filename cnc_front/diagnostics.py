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
    #: The source line with a caret below; empty where the compiler gives none.
    excerpt: str = ""

    @property
    def is_warning(self) -> bool:
        """Warnings never stop a run (GWnnn of the dialect page, SWnnn of rw_SymPas)."""
        return self.id.startswith(("GW", "MW", "SW"))

    def __str__(self) -> str:
        hint = f"\n  hint: {self.hint}" if self.hint else ""
        excerpt = f"\n{self.excerpt}" if self.excerpt else ""
        return f"{self.file}:{self.line}:{self.column}: {self.id}: {self.message}{excerpt}{hint}"

    def as_json(self) -> dict[str, object]:
        """The object of `diagnostics` in `run --json` (design 3.2)."""
        return {key: value for key, value in asdict(self).items() if key != "excerpt"}
