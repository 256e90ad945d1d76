from collections.abc import Sequence
from typing import Any, final

from numpy.typing import NDArray

from cnc_front._native.motion_kernel import Machine

__all__ = ["Listing", "Program", "catalogue", "compile"]

@final
class Listing:
    def __iter__(self) -> Listing: ...
    def __next__(self) -> str: ...

@final
class Program:
    def counts(self) -> list[tuple[str, int]]: ...
    def events(self) -> list[tuple[int, str, str]]: ...
    def listing(self, source: bytes, json: bool) -> Listing: ...
    def sequence(self) -> dict[str, NDArray[Any]]: ...

def catalogue() -> list[tuple[str, str, str]]: ...
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
    start: str | None = None,
    stop: str | None = None,
    strict: bool = False,
    dry_feed: float | None = None,
    mdi: bool = False,
) -> tuple[Program | None, list[tuple[str, int, int, int, str, str, str]], dict[str, Any]]: ...
