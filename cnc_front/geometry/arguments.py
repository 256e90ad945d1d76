"""Options of `run` and `report` for drawings and setups. Nothing heavy is imported here."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from typing import Any, TypeVar

#: Words of --reference-offset, each followed by :RADIUS but for `none`.
OFFSETS = ("none", "left", "right", "ball")
CAPTURE_MM = 0.5
P = TypeVar("P", bound=argparse.ArgumentParser)


@dataclass(frozen=True, slots=True)
class ReferenceOptions:
    """How a drawing is read and placed; mm. Plain values, so that a recording can carry them."""

    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    offset: str = "none"
    radius: float = 0.0
    unit: str | None = None
    layer: str | None = None
    section_z: float | None = None
    capture_mm: float = CAPTURE_MM


def parent(parser: P) -> P:
    """Adds the options to an empty parser, as a group of their own, for the commands that take them."""
    group = parser.add_argument_group("drawing and setup (docs/material.md)")
    group.add_argument("--setup", metavar="FILE", help="blank, fixtures, tools (default: .setup.toml beside the job)")
    group.add_argument("--reference", metavar="FILE", help="compare with a drawing: DXF, SVG, STL, PLY or 3MF")
    group.add_argument("--reference-at", metavar="X,Y,Z", type=_place, help="where the drawing's zero stands, mm")
    group.add_argument(
        "--reference-offset",
        metavar="SIDE:R",
        type=_offset,
        help="tool centre beside it: none, left:3, right:3, ball:3",
    )
    group.add_argument("--reference-unit", choices=("mm", "inch"), help="unit of the drawing, whatever it says")
    group.add_argument("--reference-layer", metavar="NAME", help="one layer of a DXF file only")
    group.add_argument("--reference-z", metavar="Z", type=_number, help="the section of a mesh at this height")
    group.add_argument(
        "--reference-capture", metavar="MM", type=_capture, help=f"farther off is extra (default {CAPTURE_MM:g})"
    )
    return parser


#: Options that mean nothing without --reference.
ABOUT_REFERENCE = ("at", "offset", "unit", "layer", "z", "capture")


def reference_options(options: argparse.Namespace) -> ReferenceOptions:
    """The values asked for; raises UsageError for those without --reference."""
    from cnc_front.errors import UsageError

    given: dict[str, Any] = {name: getattr(options, f"reference_{name}") for name in ABOUT_REFERENCE}
    if options.reference is None:
        for name, value in given.items():
            if value is not None:
                raise UsageError(f"--reference-{name} needs --reference")
    kind, radius = given["offset"] or ("none", 0.0)
    return ReferenceOptions(
        at=given["at"] or (0.0, 0.0, 0.0),
        offset=kind,
        radius=radius,
        unit=given["unit"],
        layer=given["layer"],
        section_z=given["z"],
        capture_mm=given["capture"] or CAPTURE_MM,
    )


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not abs(value) <= 1e5:
        raise argparse.ArgumentTypeError(f"'{text}' is no length in mm up to 1e5")
    return value


def _capture(text: str) -> float:
    value = _number(text)
    if not 0 < value <= 100:
        raise argparse.ArgumentTypeError(f"'{text}' is outside 0 .. 100 mm")
    return value


def _place(text: str) -> tuple[float, float, float]:
    parts = [_number(part) for part in text.split(",")]
    if len(parts) not in (2, 3):
        raise argparse.ArgumentTypeError(f"'{text}' is no X,Y or X,Y,Z")
    return parts[0], parts[1], parts[2] if len(parts) == 3 else 0.0


def _offset(text: str) -> tuple[str, float]:
    kind, _, radius = text.partition(":")
    if kind not in OFFSETS or (kind == "none") != (radius == ""):
        raise argparse.ArgumentTypeError(f"'{text}' is none of none, left:R, right:R, ball:R")
    value = _number(radius) if radius else 0.0
    if kind != "none" and not 0 < value <= 1000:
        raise argparse.ArgumentTypeError(f"the radius in '{text}' is outside 0 .. 1000 mm")
    return kind, value
