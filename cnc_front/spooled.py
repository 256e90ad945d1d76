"""What the tasks of a rw_SymPas job spool: the listing of its run, and the programmed paths that follow from it.

A listing is known only when the job has run. A *lane* is one path: motion commands that never run at the same time.
Groups of axes that run side by side have a lane each. Direct moves (ja, jr, mla ...) are in none: they have no
programmed contour.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front.sap_places import Places

BEGUN, DONE, CUT = range(3)
COLUMNS = ("number", "task", "line", "kind", "axes", "rounding", "phi", "vl", "ac", "tvl")
MATRICES = ("start", "target", "radius", "center", "normal", "circle")
Part = dict[str, Any]


@dataclass(slots=True)
class Passage:
    """When a command was executed: first and last sample (None: still at it), and whether it was cut short."""

    begin: int
    end: int | None = None
    cut: bool = False


@dataclass(slots=True)
class Listing:
    """Collects what the controller lists (Mcu.take_listing)."""

    parts: list[Part] = field(default_factory=list)
    passages: dict[int, Passage] = field(default_factory=dict)
    counts: Counter[str] = field(default_factory=Counter)

    def take(self, part: Part) -> None:
        """Adds what was listed since the last call."""
        if part["lost"]:
            raise RuntimeError(f"{part['lost']} spooled commands were not listed")
        self.counts.update(part["name"])
        if part["functions"]:
            self.counts["ssf"] += part["functions"]
        if part["name"]:
            self.parts.append(part)
        for number, sample, came in part["passed"]:
            if came == BEGUN:
                self.passages.setdefault(number, Passage(sample))
            elif (passage := self.passages.get(number)) is not None and passage.end is None:
                passage.end, passage.cut = sample, came == CUT

    def columns(self) -> dict[str, NDArray[Any]]:
        """All rows in the order in which they were spooled."""
        return {name: np.concatenate([part[name] for part in self.parts]) for name in (*COLUMNS, *MATRICES)}

    def names(self) -> list[str]:
        """Name of the command of each row."""
        return [name for part in self.parts for name in part["name"]]


@dataclass(slots=True)
class Lane:
    """A path: rows of the listing in the order in which they ran, and the stretches of time that are on it."""

    rows: list[int] = field(default_factory=list)
    #: first and last sample, first command, whether it was driven to its end; as Tracker.set_stretches wants them
    stretches: list[tuple[int, int, int, bool]] = field(default_factory=list)
    #: sequence columns of toolpaths.Path
    sequence: dict[str, NDArray[Any]] = field(default_factory=dict)
    #: set of all its axes
    axes: int = 0
    last_axes: int = 0
    last_begin: int = -1
    last_end: int = -1


@dataclass(frozen=True, slots=True)
class Paths:
    """All paths of a run, the longest first. `cut` and `apart` are lines (of all texts): broken off, or beside other
    commands of their axes."""

    lanes: list[Lane]
    cut: list[int]
    apart: list[int]
    #: how far stops may be off because targets are rounded to counts, mm
    rounding_mm: float


def paths_of(listing: Listing, samples: int, axes: int) -> Paths:
    """The paths of what ran in `samples` samples on so many axes; an empty one where nothing was spooled."""
    if not listing.parts:
        return Paths([Lane(sequence=_sequence(_nothing(axes), []))], [], [], 0.0)
    columns = listing.columns()
    order = [(p.begin, n, p) for n, number in enumerate(columns["number"]) if (p := listing.passages.get(int(number)))]
    lanes: list[Lane] = []
    cut, apart = [], []
    for begin, row, passage in sorted(order, key=lambda item: item[:2]):
        axes, place = int(columns["axes"][row]), int(columns["line"][row])
        end = passage.end if passage.end is not None else samples
        if passage.cut:
            cut.append(place)
        lane = _lane_for(lanes, begin, axes)
        if lane is None:
            apart.append(place)
        elif end >= begin:
            _append(lane, row, axes, begin, end, settles=not passage.cut and passage.end is not None)
    driven = sorted((lane for lane in lanes if lane.rows), key=lambda lane: -len(lane.rows)) or [Lane()]
    for lane in driven:
        lane.sequence = _sequence(columns, lane.rows)
    rounding = float(columns["rounding"].max(initial=0.0))
    return Paths(driven, cut, apart, rounding)


def _nothing(axes: int) -> dict[str, NDArray[Any]]:
    """Columns of a listing without rows but the first, which says where the axes are at boot."""
    matrices = {name: np.zeros((1, 3 if name in ("center", "normal", "circle") else axes)) for name in MATRICES}
    return {name: np.zeros(1) for name in COLUMNS} | matrices


def _lane_for(lanes: list[Lane], begin: int, axes: int) -> Lane | None:
    """A lane that is free from a sample on, rather that of the same axes; None where some of the axes are still
    executing another command, so that they have left what they have in common."""
    if any(lane.last_end > begin and lane.last_axes & axes for lane in lanes):
        return None
    free = [lane for lane in lanes if lane.last_end <= begin and (lane.last_axes == axes or lane.last_begin < begin)]
    same = [lane for lane in free if lane.last_axes == axes]
    if not free:
        lanes.append(Lane())
        free = lanes[-1:]
    return (same or free)[0]


def _append(lane: Lane, row: int, axes: int, begin: int, end: int, *, settles: bool) -> None:
    if lane.stretches and lane.last_axes == axes and lane.last_end == begin:
        first, _, command, _ = lane.stretches[-1]
        lane.stretches[-1] = (first, end, command, settles)
    else:
        lane.stretches.append((begin, end, len(lane.rows), settles))
    lane.rows.append(row)
    lane.axes, lane.last_axes = lane.axes | axes, axes
    lane.last_begin, lane.last_end = lane.stretches[-1][0], end


def _sequence(columns: dict[str, NDArray[Any]], rows: Sequence[int]) -> dict[str, NDArray[Any]]:
    """Columns of toolpaths.Path."""
    pick = np.asarray(rows, dtype=np.intp)
    of = {name: columns[name][pick] for name in (*COLUMNS, *MATRICES)}
    n = len(pick)
    # rows of radii that are told apart by their bits: NaN is a value here
    bits = np.ascontiguousarray(of["radius"]).view(np.uint64)
    radii, which = np.unique(bits, axis=0, return_inverse=True)
    circle = of["circle"].astype(np.uint8)
    none, zeros = np.empty(0, np.uint32), np.zeros(n, np.uint32)
    return {
        "start": columns["start"][pick[0] if n else 0].copy(),
        "kind": of["kind"].astype(np.uint8),
        "line": of["line"].astype(np.uint32),
        "rapid": np.zeros(n, np.bool_),
        "target": of["target"].ravel(),
        "c1": np.ascontiguousarray(circle[:, 0]),
        "c2": np.ascontiguousarray(circle[:, 1]),
        "c3": np.ascontiguousarray(circle[:, 2]),
        "center": np.ascontiguousarray(of["center"][:, :2]).ravel(),
        "center3": of["center"].ravel(),
        "normal": of["normal"].ravel(),
        "begin": of["start"].ravel(),
        "phi": of["phi"],
        "vl": of["vl"],
        "ac": of["ac"],
        "tvl": of["tvl"],
        "via_first": zeros,
        "via_count": zeros,
        "via_line": none,
        "via_target": np.empty(0, np.float64),
        "effradius": radii.view(np.float64).ravel(),
        "effradius_of": which.astype(np.uint16).ravel(),
    }


def rows_as_json(listing: Listing, names: Sequence[str], places: Places) -> list[dict[str, Any]]:
    """The listing as objects of design 3.3, with the task that gave each command and the include that it stands in."""
    if not listing.parts:
        return []
    columns = listing.columns()
    found = []
    for i, command in enumerate(listing.names()):
        axes = [a for a in range(len(names)) if int(columns["axes"][i]) >> a & 1]
        entry: dict[str, Any] = {"cmd": command} | places.at(int(columns["line"][i]))
        kind = int(columns["kind"][i])
        if kind:
            plane = [int(a) for a in columns["circle"][i][: 2 if kind == 1 else 3]]
            entry["plane"] = [names[a] for a in plane]
            entry["center"] = {names[a]: float(c) for a, c in zip(plane, columns["center"][i], strict=False)}
            entry |= {"normal": [float(x) for x in columns["normal"][i]]} if kind == 2 else {}
            entry["phi"] = float(columns["phi"][i])
        entry["target"] = {names[a]: float(columns["target"][i][a]) for a in axes}
        entry |= {name: float(columns[name][i]) for name in ("vl", "ac", "tvl")}
        radii = {names[a]: float(r) for a in axes if not np.isnan(r := columns["radius"][i][a])}
        found.append(entry | ({"effradius": radii} if radii else {}))
    return found
