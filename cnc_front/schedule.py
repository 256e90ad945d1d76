"""Override schedules of the command line: `0.5`, or `0:1.0,2.5:0.5,4:1.2` (machine seconds : factor)."""

from __future__ import annotations

import math
from itertools import pairwise

from cnc_front.errors import UsageError

#: Highest factor that is accepted; the controller itself refuses 0 and below.
HIGHEST = 10.0

Schedule = tuple[tuple[float, float], ...]


def parse_schedule(text: str) -> Schedule:
    """Points in time order, the first at 0 s. Raises UsageError with what is wrong."""
    points = [_point(part, index) for index, part in enumerate(text.split(","))]
    if points[0][0] > 0:
        points.insert(0, (0.0, 1.0))
    for (before, _), (after, _) in pairwise(points):
        if after <= before:
            raise UsageError(f"--override: times must rise, {after:g} s follows {before:g} s")
    return tuple(points)


def _point(part: str, index: int) -> tuple[float, float]:
    head, colon, tail = part.partition(":")
    time_text, factor_text = (head, tail) if colon else ("0", head)
    if not colon and index > 0:
        raise UsageError(f"--override: '{part}' is no TIME:FACTOR")
    time, factor = _number(time_text, part), _number(factor_text, part)
    if time < 0:
        raise UsageError(f"--override: time {time:g} s is before the start")
    if not 0 < factor <= HIGHEST:
        raise UsageError(f"--override: factor {factor:g} is outside 0 .. {HIGHEST:g} (0 itself is refused; use hold)")
    return time, factor


def _number(text: str, part: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"--override: '{part}' is no factor and no TIME:FACTOR")
    return value
