"""Ways to look at a path: the planes of two axes, and an isometric view of three."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cnc_front.engine import PathPlot

Floats = NDArray[np.float64]

#: An axis that goes over less than this share of the longest way counts as standing.
STILL = 0.01
_RIGHT, _UP = 1 / sqrt(2), 1 / sqrt(6)

_UNITS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class Plane:
    """`right` and `up`: what a millimetre of each of the three axes of a plot adds on screen, mm."""

    name: str
    right: tuple[float, float, float]
    up: tuple[float, float, float]

    def project(self, points: Floats) -> Floats:
        """Places on screen, mm (n, 2), of points (n, 3)."""
        places = np.zeros((len(points), 2))
        for column, share in enumerate((self.right, self.up)):
            for axis, part in enumerate(share):
                if part:  # no matrix product: BLAS would wake threads for it
                    places[:, column] += part * points[:, axis]
        return places


#: From the right, in front and above: X goes right and down, Y right and up, Z up.
ISOMETRIC = Plane("ISO", (_RIGHT, _RIGHT, 0.0), (-_UP, _UP, 2 * _UP))


def planes_of(plot: PathPlot, drawn: Floats) -> tuple[Plane, ...]:
    """The planes in which a path can be seen, the best one first; `drawn`: the points (n, 3) that count for that.

    Where nothing moves along Y but along X and Z, that is their plane; Z to the right and X up, as lathes are drawn,
    if the program works in G18 or the machine has no Y.
    """
    names = [name for name in plot.axes if name]
    if len(names) < 2:
        return (_plane(names or ["X"], 0, 1),)
    z = names.index("Z") if "Z" in names else None
    lies = z is not None and names[0] == "X" and ("Y" not in names or plot.plane == "G18")
    if len(names) == 2:
        return (_plane(names, 1, 0) if lies else _plane(names, 0, 1),)
    # column by column: along the first axis of so narrow an array NumPy is ten times slower
    ways = np.array([np.ptp(column) for column in drawn.T]) if len(drawn) else np.ones(3)
    moves = ways > STILL * ways.max()
    first, last = _plane(names, 0, 1), _plane(names, 1, 2)
    middle = _plane(names, 2, 0) if lies and not moves[1] else _plane(names, 0, 2)
    pairs = [(first, (0, 1)), (middle, (0, 2)), (last, (1, 2))]
    best = next((plane for plane, pair in pairs if moves[list(pair)].all()), first)
    return (best, *(plane for plane, _ in pairs if plane is not best), ISOMETRIC)


def _plane(names: list[str], right: int, up: int) -> Plane:
    """The plane of two axes by number."""
    name = "".join(names[n] for n in (right, up) if n < len(names))
    return Plane(name, _UNITS[right], _UNITS[up])
