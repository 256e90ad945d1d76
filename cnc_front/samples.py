"""samples.parquet of a report: every sample of a run as columns, for pandas, polars, DuckDB and the like.

Written as the run goes on, a row group a chunk, so memory is bounded. Needs the extra `samples` (pyarrow).
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.errors import UsageError
from cnc_front.execution import Happened
from cnc_front.outputs import REPORT_FILE, REPORT_MARK
from cnc_front.recording import content_of, open_recording
from cnc_front.verdict import limit_name

SAMPLES_FILE = "samples.parquet"
#: Columns of a chunk that have a value a sample, beside those with a value an axis.
PLAIN = ("factor", "v_plan", "line", "entry", "flags")
PER_AXIS = ("dp", "load", "rp")


def check_available() -> None:
    """Raises UsageError where pyarrow is not installed."""
    if find_spec("pyarrow") is None:
        raise UsageError("--samples needs pyarrow: pip install 'cnc-front[samples]'")


class SamplesFile:
    """Takes the samples of a run (a Sink), or the columns of a recording."""

    def __init__(self, folder: Path, axes: Sequence[str], sample_time_s: float) -> None:
        """Creates folder and file; raises OSError."""
        folder.mkdir(parents=True, exist_ok=True)
        page = folder / REPORT_FILE
        if not page.exists():
            # marks the folder as ours, so that a later run may replace what an interrupted one left
            page.write_text(REPORT_MARK, encoding="utf-8")
        self.path = folder / SAMPLES_FILE
        self._axes, self._sample_time_s = list(axes), sample_time_s
        self._writer: Any = None

    def write(self, chunk: native_kernel.Chunk, deviation_mm: NDArray[np.float32], happened: Happened) -> None:
        """One chunk and the deviation of its load side; what happened stands in the table of events."""
        names = (*PLAIN, *PER_AXIS)
        self.add(chunk.first_sample, {name: getattr(chunk, name) for name in names}, deviation_mm)

    def add(self, first_sample: int, columns: dict[str, Any], deviation_mm: NDArray[np.float32]) -> None:
        """The next samples. Times are those of the end of the interval, as everywhere."""
        import pyarrow
        import pyarrow.parquet

        count = len(deviation_mm)
        if count == 0 and self._writer is not None:
            return
        data: dict[str, Any] = {"t_s": (first_sample + 1 + np.arange(count)) * self._sample_time_s}
        for name in PER_AXIS:
            values = np.asarray(columns[name])
            data |= {f"{name}_{axis}": np.ascontiguousarray(values[:, a]) for a, axis in enumerate(self._axes)}
        data |= {name: columns[name] for name in PLAIN}
        data["deviation_mm"] = deviation_mm
        codes, which = np.unique(np.asarray(columns["flags"]) >> 8, return_inverse=True)
        names = pyarrow.array([limit_name(int(code), self._axes) for code in codes], pyarrow.string())
        limit = pyarrow.DictionaryArray.from_arrays(pyarrow.array(which.astype(np.int32)), names)
        table = pyarrow.table(data | {"limit": limit.dictionary_decode()})
        if self._writer is None:
            # positions hardly differ from sample to sample: bytes of one significance side by side pack best
            floats = [name for name in data if data[name].dtype.kind == "f"]
            self._writer = pyarrow.parquet.ParquetWriter(
                self.path,
                table.schema,
                compression="zstd",
                use_dictionary=[name for name in table.column_names if name not in floats],
                use_byte_stream_split=floats,
            )
        self._writer.write_table(table)

    def close(self) -> None:
        """Ends the file; without this it cannot be read."""
        if self._writer is not None:
            self._writer.close()


def samples_of_recording(recording: str, folder: Path) -> None:
    """The same file from the columns of a recording; raises CompileError for what is no recording of ours."""
    with content_of(recording):
        recorded = open_recording(recording)
        machine = native_kernel.Machine.parse(recorded.machine_text.encode(), recorded.metadata["machine_path"])
        file = SamplesFile(folder, machine.axis_names, machine.sample_time_us * 1e-6)
        for columns in recorded.columns():
            file.add(columns["first_sample"], columns, columns["deviation_mm"])
        file.close()
