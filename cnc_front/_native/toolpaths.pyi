from collections.abc import Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from cnc_front._native.motion_kernel import Chunk

__all__ = ["Path", "Tracker"]

@final
class Path:
    def __new__(cls, sequence: dict[str, NDArray[Any]]) -> Path: ...
    @property
    def length_mm(self) -> float: ...
    @property
    def merged(self) -> tuple[int, float]: ...
    @property
    def extents(self) -> list[tuple[float, float]]: ...
    def polyline(self, chord_mm: float, max_points: int) -> dict[str, NDArray[Any]]: ...
    def blocks(self) -> dict[str, NDArray[Any]]: ...

@final
class Tracker:
    def __new__(
        cls,
        path: Path,
        *,
        sample_time_s: float,
        schedule: Sequence[tuple[float, float]] = ...,
        trovrst_s: float = 0.0,
        buckets: int = 4096,
    ) -> Tracker: ...
    def watch(self, s_mm: NDArray[np.float64]) -> None: ...
    def watched(self) -> tuple[NDArray[np.float32], int]: ...
    def feed(self, chunk: Chunk) -> NDArray[np.float32]: ...
    def feed_columns(
        self,
        first_sample: int,
        dp: NDArray[np.float64],
        load: NDArray[np.float64],
        rp: NDArray[np.float64],
        factor: NDArray[np.float64],
        v_plan: NDArray[np.float64],
    ) -> NDArray[np.float32]: ...
    def finish(self) -> dict[str, Any]: ...
    def blocks(self) -> dict[str, NDArray[Any]]: ...
    def series(self) -> dict[str, Any]: ...
