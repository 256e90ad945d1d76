from typing import final

from cnc_front._native.motion_kernel import Machine

__all__ = ["MAGIC", "Program", "compile", "decode"]

MAGIC: bytes

@final
class Program:
    @property
    def name(self) -> str: ...
    @property
    def task(self) -> int | None: ...
    @property
    def full_system(self) -> bool: ...
    @property
    def files(self) -> list[tuple[str, int]]: ...
    @property
    def places(self) -> int: ...
    def listing(self) -> list[str]: ...
    def encode(self) -> bytes: ...

def decode(data: bytes) -> Program: ...
def compile(
    source: bytes,
    filename: str,
    machine: Machine,
    *,
    path: str | None = None,
    language: str = "en",
) -> tuple[Program | None, list[tuple[str, int, int, int, str, str, str, str]]]: ...
