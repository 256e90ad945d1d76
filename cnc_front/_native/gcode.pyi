from collections.abc import Sequence
from typing import Any, final

from numpy.typing import NDArray

from cnc_front._native.motion_kernel import Machine

__all__ = ["MOST_BYTES", "Listing", "Program", "Stream", "StreamListing", "catalogue", "check_once", "compile"]

MOST_BYTES: int

_Found = tuple[list[tuple[str, int, int, int, str, str, str]], dict[str, Any]] | None

@final
class Listing:
    def __iter__(self) -> Listing: ...
    def __next__(self) -> str: ...

@final
class Program:
    def counts(self) -> list[tuple[str, int]]: ...
    def event(self, number: int) -> tuple[int, str, str] | None: ...
    def events(self) -> list[tuple[int, str, str]]: ...
    def listing(self, source: bytes, json: bool) -> Listing: ...
    def sequence(self) -> dict[str, NDArray[Any]]: ...

@final
class Stream:
    def __new__(
        cls,
        path: str,
        filename: str,
        machine: Machine,
        *,
        users: int = 2,
        profile: str | None = None,
        optional_stop: bool = False,
        block_delete: Sequence[int] = ...,
    ) -> Stream: ...
    def __iter__(self) -> Stream: ...
    def __next__(self) -> Program: ...
    def counts(self) -> list[tuple[str, int]]: ...
    def event(self, number: int) -> tuple[int, str, str] | None: ...
    def finish(self) -> _Found: ...
    def listing(self, path: str, json: bool) -> StreamListing: ...
    def send_away(self, user: int) -> None: ...

@final
class StreamListing:
    def __iter__(self) -> StreamListing: ...
    def __next__(self) -> str: ...

def check_once(
    path: str,
    filename: str,
    machine: Machine,
    *,
    profile: str | None = None,
    optional_stop: bool = False,
    block_delete: Sequence[int] = ...,
) -> _Found: ...
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
