from collections.abc import Sequence
from os import PathLike
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from cnc_front._native.motion_kernel import Chunk

__all__ = ["Reader", "Writer"]

@final
class Writer:
    def __new__(
        cls,
        path: str | PathLike[str],
        axes: Sequence[str],
        sample_time_s: float,
        attachments: Sequence[tuple[str, str, bytes | str]],
        metadata: dict[str, str],
        resolution: Sequence[float] = ...,
        scan: Sequence[str] = ...,
    ) -> Writer: ...
    def attach(self, file: tuple[str, str, bytes | str]) -> None: ...
    def write(self, chunk: Chunk, deviation_mm: NDArray[np.float32]) -> None: ...
    def write_columns(
        self,
        place: tuple[int, Sequence[int]],
        matrices: Sequence[NDArray[np.float64]],
        numbers: Sequence[NDArray[np.float64]],
        words: Sequence[NDArray[np.uint32]],
        deviation_mm: NDArray[np.float32],
    ) -> None: ...
    def write_event(self, t_s: float, json: str) -> None: ...
    def finish(self, result_json: str) -> None: ...

@final
class Reader:
    def __new__(cls, path: str | PathLike[str], only: str | None = None) -> Reader: ...
    @property
    def damage(self) -> str | None: ...
    def next_item(self) -> tuple[str, str, Any] | None: ...
