"""A driven path against a drawing: distances to a contour or surface that stands where it stands, never best fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native.toolpaths import Chords, Nearest
from toolpaths.drawing import SEGMENT, Drawing
from toolpaths.meshes import GeometryError

Points = NDArray[np.float64]

#: Classes of the histogram that percentiles come from: 1,024 to each power of two, from a picometre on.
PICO_MM = 1e-9
LEAST_MM, CLASS_BITS, CLASSES = 1e-9, 42, 48 << 10
#: Coverage: chords of the driven path stay this near to it, and a drawing is asked about every so many mm, mm.
DRIVEN_CHORD_MM, COVER_STEP_MM, COVER_POINTS = 0.01, 0.02, 400_000
#: Samples of one point of the picture at first, and most of its points: beyond that pairs are merged.
PLOT_SAMPLES, PLOT_POINTS = 8, 300_000
#: Missing stretches and lines of extra blocks that are listed.
MISSING_LISTED = EXTRA_LISTED = 50


@dataclass(frozen=True, slots=True)
class Offset:
    """Where the tool's centre runs beside the drawing: `none`, `left`, `right` (of a contour, seen along the motion)
    or `ball` (outside of a surface; the path is that of the tip, the centre lies `radius` above). Radius in mm."""

    kind: str = "none"
    radius: float = 0.0


def _classes(size: Points) -> NDArray[np.int64]:
    """Class of each deviation: the leading bits of the number."""
    bits = np.maximum(size, LEAST_MM).view(np.int64) >> CLASS_BITS
    first = int(np.float64(LEAST_MM).view(np.int64)) >> CLASS_BITS
    classes: NDArray[np.int64] = np.minimum(bits - first, CLASSES - 1)
    return classes


def _whole(lengths: Points) -> NDArray[np.int64]:
    """In whole PICO_MM."""
    return np.round(lengths / PICO_MM).astype(np.int64)


def _squares(size: Points) -> int:
    """Exact sum of the squares in PICO_MM squared; in two halves, since the squares exceed 64 bits."""
    whole = _whole(size)
    high, low = whole >> 20, whole & 0xFFFFF
    return (int(high @ high) << 40) + (int(high @ low) << 21) + int(low @ low)


def _middle(number: int) -> float:
    """The deviation in the middle of a class."""
    first = int(np.float64(LEAST_MM).view(np.int64)) >> CLASS_BITS
    edges = np.array([first + number, first + number + 1], dtype=np.int64) << CLASS_BITS
    return float(edges.view(np.float64).mean())


class _Stats:
    """Deviations of some samples: a histogram, extremes and lengths."""

    def __init__(self) -> None:
        self.counts = np.zeros(CLASSES, dtype=np.int64)
        #: sums in whole PICO_MM (and their squares): exact, so that they do not depend on chunks
        self.squares, self.samples = 0, 0
        self.plus, self.minus = 0.0, 0.0
        self.worst: dict[str, Any] = {"mm": -1.0}
        self.length, self.wrong_side = 0, 0
        self.rows: list[Points] = []

    def add(self, m: _Measured) -> None:
        """Samples as they were measured."""
        signed = m.signed
        size = np.abs(signed)
        self.counts += np.bincount(_classes(size), minlength=CLASSES)
        self.squares += _squares(size)
        self.samples += len(size)
        sided = np.where(m.sided, signed, 0.0)
        self.plus, self.minus = max(self.plus, float(sided.max())), max(self.minus, float(-sided.min()))
        self.length += int(m.length.sum())
        self.wrong_side += int(m.wrong_side.sum())
        self.rows.append(_worst_of(np.column_stack([m.sample, m.at, m.foot, m.signed]), PLOT_SAMPLES))
        k = int(size.argmax())
        if abs(m.signed[k]) > self.worst["mm"]:
            place = {"position": m.point[k].tolist(), "nearest": m.foot[k].tolist()}
            self.worst = {"mm": float(abs(m.signed[k])), "line": int(m.line[k]), "sample": int(m.sample[k])} | place

    def merge(self, other: _Stats) -> None:
        """Adds what another one has collected."""
        self.counts += other.counts
        self.squares, self.samples = self.squares + other.squares, self.samples + other.samples
        self.plus, self.minus = max(self.plus, other.plus), max(self.minus, other.minus)
        self.length, self.wrong_side = self.length + other.length, self.wrong_side + other.wrong_side
        self.worst = other.worst if other.worst["mm"] > self.worst["mm"] else self.worst

    def percentile(self, share: float) -> float:
        """To half a class."""
        reached = np.cumsum(self.counts) >= share * self.samples
        return min(_middle(int(np.argmax(reached))), float(self.worst["mm"]))


@dataclass(slots=True)
class _Measured:
    """Samples of cutting moves: where they are and what was measured there."""

    sample: NDArray[Any]
    line: NDArray[Any]
    entry: NDArray[Any]
    point: Points
    at: Points
    foot: Points
    signed: Points
    #: the sign is one: nothing is left of a point that stands
    sided: NDArray[np.bool_]
    length: NDArray[np.int64]
    wrong_side: NDArray[np.int64]

    def part(self, chosen: slice | NDArray[Any]) -> _Measured:
        """Some of the samples."""
        return _Measured(*(getattr(self, name)[chosen] for name in self.__slots__))


class ReferenceMeter:
    """Measures samples in cutting moves against a drawing, chunk by chunk, in bounded memory.

    A deviation is the distance to the nearest place of the drawing, less the radius of the offset; + is material that
    was left (offset), left of the motion (no offset) or outside of the surface. A motion command that anywhere is
    farther than `capture_mm` from where the drawing wants it is none of the drawing (lead-in, link, other contour): it
    counts as extra length, not as deviation.
    """

    def __init__(self, drawing: Drawing, offset: Offset, capture_mm: float, *, covers: bool = True) -> None:
        """`covers` also finds what was not driven. Raises GeometryError where offset and drawing do not go together."""
        if (offset.kind == "ball") != drawing.is_surface and offset.kind != "none":
            wanted = "none or ball:R" if drawing.is_surface else "none, left:R or right:R"
            raise GeometryError(f"is a {'surface' if drawing.is_surface else 'contour'}; its offset is {wanted}")
        self._drawing, self._offset, self._capture = drawing, offset, capture_mm
        self._nearest = Nearest(drawing.kinds, drawing.data)
        self._chords = Chords(DRIVEN_CHORD_MM) if covers and not drawing.is_surface else None
        self._driven: list[Points] = []
        self._last: Points | None = None
        self._total, self._open = _Stats(), _Stats()
        #: the motion command that is not over yet: its number, line, and whether it was too far away
        self._entry, self._line, self._far = 0, 0, False
        self._extra: dict[int, int] = {}
        self._plot = _Plot()

    def feed(
        self,
        points: Points,
        cutting: NDArray[np.bool_],
        lines: NDArray[Any],
        entries: NDArray[Any],
        first_sample: int,
    ) -> None:
        """Samples (n, 3) in mm in the coordinates of the drawing, which of them lie in a cutting move, their lines and
        motion commands."""
        if len(points) == 0:
            return
        before = np.vstack([points[:1] if self._last is None else self._last, points[:-1]])
        self._last = points[-1:].copy()
        if self._chords is not None:
            self._cover(*self._chords.feed(points, cutting.astype(np.uint64), first_sample)[:2])
        chosen = np.flatnonzero(cutting)
        if len(chosen):
            step = points[chosen] - before[chosen]
            self._add(self._measured(points[chosen], step, lines[chosen], entries[chosen], chosen + first_sample))

    def _measured(
        self, points: Points, step: Points, lines: NDArray[Any], entries: NDArray[Any], samples: NDArray[Any]
    ) -> _Measured:
        at, radius = points, self._offset.radius
        if not self._drawing.is_surface:
            at, step = at * (1.0, 1.0, 0.0), step * (1.0, 1.0, 0.0)
        elif self._offset.kind == "ball":
            at = at + np.array([0.0, 0.0, radius])
        distance, foot, _, beyond, side = self._nearest.find(np.ascontiguousarray(at))
        length = _whole(np.sqrt(np.einsum("ij,ij->i", step, step)))
        wrong = np.zeros(len(at), dtype=np.int64)
        left = _cross(step, at - foot)  # above 0: the tool runs left of the contour
        sided = np.ones(len(at), dtype=np.bool_)
        if self._drawing.is_surface:
            signed = side * distance - radius
        elif self._offset.kind == "none":
            signed, sided = np.where(left < 0, -distance, distance), left != 0
        else:
            signed = distance - radius
            # round a corner the tool may run wider: the corner itself stays where it is
            signed[beyond & (signed > 0) & (signed <= self._capture)] = 0.0
            other = (left < 0) if self._offset.kind == "left" else (left > 0)
            wrong = np.where(other & ~beyond, length, 0)
        return _Measured(samples, lines, entries, points, at, foot, signed, sided, length, wrong)

    def _add(self, m: _Measured) -> None:
        """Closes the motion commands that are over, leaves the last one open."""
        starts = np.flatnonzero(np.concatenate([[True], np.diff(m.entry.astype(np.int64)) != 0]))
        far = np.maximum.reduceat(np.abs(m.signed), starts) > self._capture
        lengths = np.add.reduceat(m.length, starts)
        counts = np.diff(np.concatenate([starts, [len(m.entry)]]))
        inner = far.copy()
        inner[[0, -1]] = True  # they may go on in other chunks
        near = np.repeat(~inner, counts)
        between = slice(int(counts[0]), int(starts[-1]))
        for k in sorted({0, len(starts) - 1}):
            self._open_entry(int(m.entry[starts[k]]), int(m.line[starts[k]]))
            self._far |= bool(far[k])
            self._open.add(m.part(slice(int(starts[k]), int(starts[k] + counts[k]))))
            if k == 0 and near.any():
                self._close()
                self._total.add(m.part(between if near[between].all() else near))
                self._plot.add(self._total.rows)
        for k in np.flatnonzero(far[1:-1]).tolist():
            line = int(m.line[starts[k + 1]])
            self._extra[line] = self._extra.get(line, 0) + int(lengths[k + 1])

    def _open_entry(self, entry: int, line: int) -> None:
        if entry != self._entry:
            self._close()
            self._entry, self._line = entry, line

    def _close(self) -> None:
        """The open motion command is over: a part of the drawing, or extra."""
        if self._far:
            self._extra[self._line] = self._extra.get(self._line, 0) + self._open.length
        elif self._open.samples:
            self._total.merge(self._open)
            self._plot.add(self._open.rows)
        self._open, self._far = _Stats(), False

    def _cover(self, moves: Points, tags: NDArray[np.uint64]) -> None:
        self._driven.append(moves[tags == 1])

    def finish(self) -> dict[str, Any]:
        """The figures (docs/material.md); `worst.sample` counts from 0. What is unknown is None."""
        self._close()
        total, found = self._total, self._total.samples > 0
        figures: dict[str, Any] = {
            "max_mm": total.worst["mm"] if found else None,
            "rms_mm": float(np.sqrt(total.squares / total.samples)) * PICO_MM if found else None,
            "p99_mm": total.percentile(0.99) if found else None,
            "plus_mm": total.plus if found else None,
            "minus_mm": total.minus if found else None,
            "worst": {key: total.worst[key] for key in ("line", "sample", "position", "nearest")} if found else None,
            "driven_mm": total.length * PICO_MM,
            "wrong_side_mm": total.wrong_side * PICO_MM,
            "extra_mm": sum(self._extra.values()) * PICO_MM,
            "extra": [
                {"line": line, "length_mm": length * PICO_MM}
                for line, length in sorted(self._extra.items(), key=lambda item: (-item[1], item[0]))[:EXTRA_LISTED]
            ],
        }
        return figures | (self._coverage() if self._chords is not None else {})

    def _coverage(self) -> dict[str, Any]:
        """Which part of the drawing no cutting move came near to (capture, beside the offset)."""
        assert self._chords is not None
        self._cover(*self._chords.finish()[:2])
        lengths = self._drawing.lengths()
        total = float(lengths.sum())
        step = max(COVER_STEP_MM, total / COVER_POINTS)
        counts = np.maximum(1, np.ceil(lengths / step)).astype(np.int64)
        piece = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(piece)) - np.repeat(np.cumsum(counts) - counts, counts)
        places = self._drawing.points(piece, (number + 0.5) / counts[piece])
        weights = lengths[piece] / counts[piece]
        driven = np.vstack(self._driven) if self._driven else np.zeros((0, 6))
        missing = np.ones(len(places), dtype=np.bool_)
        if len(driven):
            data = np.zeros((len(driven), 9))
            data[:, 0:2], data[:, 3:5] = driven[:, 0:2], driven[:, 3:5]
            distance = Nearest(np.full(len(driven), SEGMENT, np.uint8), data).find(np.ascontiguousarray(places))[0]
            missing = distance > self._offset.radius + self._capture
        length = float(weights[missing].sum())
        return {
            "length_mm": total,
            "missing_mm": length,
            "missing_pct": 100 * length / total if total else 0.0,
            "missing": _stretches(missing, piece, places, weights),
        }

    def plot(self) -> dict[str, Points]:
        """For a picture: `at`, `foot` (n, 3), `signed` (n) in mm, `sample` (n): of some samples each the worst."""
        return self._plot.columns()


def _cross(a: Points, b: Points) -> Points:
    product: Points = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product


def _stretches(
    missing: NDArray[np.bool_], piece: NDArray[Any], places: Points, weights: Points
) -> list[dict[str, Any]]:
    """Runs of missing places on one piece, longest first."""
    marked = np.concatenate([[False], missing, [False]])
    starts = np.flatnonzero(~marked[:-1] & marked[1:])
    ends = np.flatnonzero(marked[:-1] & ~marked[1:])
    rows = [
        {
            "from": places[a, :2].round(4).tolist(),
            "to": places[b - 1, :2].round(4).tolist(),
            "length_mm": float(weights[a:b].sum()),
        }
        for a, b in zip(starts, ends, strict=True)
    ]
    return sorted(rows, key=lambda row: -row["length_mm"])[:MISSING_LISTED]


class _Plot:
    """Of every few samples the one with the largest deviation; the number of samples grows with the run."""

    def __init__(self) -> None:
        self._every = PLOT_SAMPLES
        self._rows: list[Points] = []
        self._count = 0

    def add(self, rows: list[Points]) -> None:
        """Takes rows (sample, at, foot, signed) away from a list."""
        self._rows += rows
        self._count += sum(map(len, rows))
        rows.clear()
        if self._count > PLOT_POINTS:
            self._every *= 4
            self._rows = [_worst_of(np.vstack(self._rows), self._every)]
            self._count = len(self._rows[0])

    def columns(self) -> dict[str, Points]:
        rows = _worst_of(np.vstack(self._rows), self._every) if self._rows else np.zeros((0, 8))
        return {"sample": rows[:, 0], "at": rows[:, 1:4], "foot": rows[:, 4:7], "signed": rows[:, 7]}


def _worst_of(rows: Points, every: int) -> Points:
    """Per `every` samples the row with the largest deviation; of equal ones the first."""
    bucket = (rows[:, 0] // every).astype(np.int64)
    starts = np.flatnonzero(np.diff(bucket, prepend=-1))
    size = np.abs(rows[:, 7])
    worst = size == np.repeat(np.maximum.reduceat(size, starts), np.diff(starts, append=len(rows)))
    number = np.flatnonzero(worst)
    chosen: Points = rows[number[np.diff(bucket[number], prepend=-1) != 0]]
    return chosen
