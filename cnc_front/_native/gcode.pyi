from collections.abc import Sequence
from typing import Any, final

from numpy.typing import NDArray

from cnc_front._native.motion_kernel import Machine

__all__ = ["Program", "compile"]

@final
class Program:
    def counts(self) -> list[tuple[str, int]]: ...
    def events(self) -> list[tuple[int, str, str]]: ...
    def listing(self, json: bool) -> list[str]: ...
    def sequence(self) -> dict[str, NDArray[Any]]: ...

def compile(
    source: bytes,
    filename: str,
    machine: Machine,
    *,
    profile: str | None = None,
    optional_stop: bool = False,
    block_delete: Sequence[int] = ...,
    check_only: bool = False,
    library: str | None = None,
) -> tuple[Program | None, list[tuple[str, int, int, int, str, str, str]], dict[str, Any]]: ...
