"""Writes engraving.nc, a guilloche for a watch dial: dense closed curves in short lines, as a CAM post writes them.

usage: python examples/jobs/make_engraving.py > examples/jobs/engraving.nc
"""

import math
from collections.abc import Iterator

# radius of the band, its amplitude, waves a turn, turns until the curve closes, length of a line; lengths in mm.
# The lines of the inner band are shorter than two samples of the controller at F1500: they will be merged.
BANDS = [(16.0, 1.6, 12.2, 5, 0.2), (11.0, 2.0, 8.25, 4, 0.2), (6.0, 1.4, 6.5, 2, 0.05)]


def curve(radius: float, amplitude: float, waves: float, angle: float) -> tuple[float, float, float]:
    """A rosette whose groove is deepest, 0.15 mm, on its outer waves."""
    wave = math.sin(waves * angle)
    r = radius + amplitude * wave
    return r * math.cos(angle), r * math.sin(angle), -0.1 - 0.05 * wave


def points(
    radius: float, amplitude: float, waves: float, turns: int, step: float
) -> Iterator[tuple[float, float, float]]:
    """The closed curve in steps of nearly `step`."""
    end = 2 * math.pi * turns
    angle, advance = 0.0, 0.0
    while angle + 2 * advance < end:  # no short rest at the end: the last line is two to three steps long
        yield curve(radius, amplitude, waves, angle)
        slope = amplitude * waves * math.cos(waves * angle)
        advance = step / math.hypot(math.hypot(*curve(radius, amplitude, waves, angle)[:2]), slope)
        angle += advance
    yield curve(radius, amplitude, waves, end)


def program() -> Iterator[str]:
    """The lines of the part program."""
    yield from ("%", "(GUILLOCHE FOR A DIAL D36, brass; written by make_engraving.py)", "(zero: dial centre, top face)")
    yield from ("(T4 engraving cutter 60 degrees)", "G17 G21 G40 G49 G80 G90 G94", "G54", "G64 P0.004")
    yield from ("T4 M6", "G43 H4", "S18000 M3", "G0 Z5 M8")
    for band in BANDS:
        dots = list(points(*band))
        yield f"(band R{band[0]:g})"
        yield f"G0 X{dots[0][0]:.3f} Y{dots[0][1]:.3f}"
        yield "Z0.5"
        yield f"G1 Z{dots[0][2]:.3f} F200"
        yield "F1500"
        yield from (f"X{x:.3f}Y{y:.3f}Z{z:.3f}" for x, y, z in dots[1:])
        yield "G0 Z5"
    yield from ("G49 M5 M9", "G0 X0 Y0", "M30", "%")


if __name__ == "__main__":
    print(*program(), sep="\n")
